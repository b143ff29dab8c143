"""Whether the runs of a set fit into one file, before any of them is made.

One file has the names of contacts, forces and points once, and what goes with them, such as the
kinetic friction beside impulses; and all runs have the same variables. Scenes that differ in these
are tried for a few steps: what is kept of a run says which of it matters.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from hydrosim.errors import HydrosimError, InputError
from hydrosim.results.assembled import differing
from hydrosim.results.output import fixed_coordinates
from hydrosim.stepping.names import force_names
from hydrosim.studies.many.alike import alike

if TYPE_CHECKING:
    from hydrosim.scene import Scene

STEPS = 8  # of output, for a trial
SHOWN = 3  # names of parameters in a message

Keep = Callable[[xr.Dataset], xr.Dataset]
"""What is kept of a run."""
Simulate = Callable[["Scene"], xr.Dataset]
"""Makes a run."""


def check_together(
    scenes: Sequence[Scene], labels: Mapping[str, xr.Variable], keep: Keep, simulate: Simulate
) -> None:
    """Raises InputError where what one run keeps has other coordinates or variables than what the
    first does; ``labels`` are what is known of the runs."""
    first = scenes[0]
    fitting = [_layout(first)]
    kept: xr.Dataset | None = None
    before = without_waves(first)
    for run, scene in enumerate(scenes):
        here = without_waves(scene)
        if alike(here, before):
            continue
        before = here
        layout = _layout(scene)
        if any(differing(layout, other) is None for other in fitting):
            continue
        fitting.append(layout)
        kept = kept or _tried(first, keep, simulate)
        try:
            found = _tried(scene, keep, simulate)
        except InputError as error:  # of what is kept
            raise InputError(f"simulate_many: run {run}{_because(run, labels)}: {error}") from None
        if kept is not None and found is not None and (name := differing(kept, found)):
            raise InputError(_refusal(name, kept, found, run, labels))


def _layout(scene: Scene) -> xr.Dataset:
    """What the runs of a scene have in their files, whatever happens: names, and what decides which
    variables there are."""
    forces = {
        "name_of_force": list(force_names(scene)),
        "accelerations": scene.output_accelerations,
    }
    return xr.Dataset(coords={**fixed_coordinates(scene), **forces})


def without_waves(scene: Scene) -> Scene:
    """The scene without what its coordinates do not depend on."""
    calm = replace(scene.environment, waves=())
    return replace(scene, title="", source={}, environment=calm)


def _tried(scene: Scene, keep: Keep, simulate: Simulate) -> xr.Dataset | None:
    """What is kept of a few steps; None where there is no such run, which its own will tell."""
    short = replace(scene, duration=min(scene.duration, STEPS * scene.output_step))
    try:
        run = simulate(short)
    except HydrosimError:
        return None
    return keep(run)


def _refusal(
    name: str, one: xr.Dataset, other: xr.Dataset, run: int, labels: Mapping[str, xr.Variable]
) -> str:
    here, there = (_values(name, each) for each in (one, other))
    remedy = "Make a study of its own for each value"
    if "force" in {*one.coords, *other.coords}:
        remedy += ", or leave out impulses"
    return (
        f"simulate_many: found {name} {here} in run 0 and {there} in run {run}"
        f"{_because(run, labels)}; expected the same in all runs of one file. {remedy}."
    )


def _because(run: int, labels: Mapping[str, xr.Variable]) -> str:
    """What a run has otherwise than the first."""
    varied = [key for key, of in labels.items() if not np.array_equal(of.values[run], of.values[0])]
    return f", as {', '.join(varied[:SHOWN])} differ" if varied else ""


def _values(name: str, kept: xr.Dataset) -> str:
    """The values of a coordinate, in few words."""
    if name not in kept.coords:
        return "missing"
    values = kept[name].values.ravel().tolist()
    unique = list(dict.fromkeys(values))
    if len(unique) == 1:
        return str(unique[0])
    return f"of {len(values)} values" if len(values) > SHOWN else ", ".join(map(str, values))
