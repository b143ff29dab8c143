"""`Facts`: derived data of a compiled scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hydrosim.compiling.hydrodynamic_groups import each_alone
from hydrosim.compiling.restart import initial_headings
from hydrosim.linear.linearise import nonlinearities
from hydrosim.scene import LinearScenes
from hydrosim.stepping.names import force_names
from hydrosim.stepping.state_layout import state_layout
from hydrosim.waves.wave_reference import met_by_waves

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hydrosim.compiling.hydrodynamic_groups import HydrodynamicGroup
    from hydrosim.database.database import HydroDatabase
    from hydrosim.scene import Scene, WaveForces
    from hydrosim.stepping.dynamics import Model
    from hydrosim.stepping.state_layout import StateLayout


@dataclass(frozen=True, eq=False)
class Facts:
    """Data derived from a scene, its databases and its ``model``.

    ``rows`` are the names of the rows of forces, ``layout`` is the layout of y. ``databases`` has,
    by name of a wet body, its own part of its database. ``met`` has, by name of a body, the
    position where waves act. ``headings`` are the headings of all bodies at the start of the first
    run [rad]. ``nonlinear`` names the parts that are not linear. An ``exact`` run is propagated,
    not stepped.
    """

    model: Model
    rows: tuple[str, ...]
    layout: StateLayout
    databases: Mapping[str, HydroDatabase]
    met: Mapping[str, WaveForces]
    headings: tuple[float, ...]
    nonlinear: tuple[str, ...]
    exact: bool


def facts_of(scene: Scene, wet: Sequence[HydrodynamicGroup], model: Model) -> Facts:
    """Facts of a scene of `open_start`. Raises InputError if waves cannot act on a body as
    asked."""
    databases = each_alone(wet)
    nonlinear = tuple(nonlinearities(scene, model))
    met = met_by_waves(scene, databases)
    return Facts(
        model=model,
        rows=force_names(scene),
        layout=state_layout(scene, model, met),
        databases=databases,
        met=met,
        headings=tuple(initial_headings(scene)),
        nonlinear=nonlinear,
        exact=not nonlinear and scene.solver.linear == LinearScenes.EXACT,
    )


def solution(scene: Scene, facts: Facts) -> str:
    """Text on how the motions of a scene are computed."""
    if scene.solver.linear == LinearScenes.STEP:
        return "stepped, as solver.linear asks"
    reasons = "; ".join(facts.nonlinear)
    return f"stepped, not linear: {reasons}" if reasons else "propagated exactly: linear"
