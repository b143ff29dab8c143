"""Start of a run from the state of another run: `Scene.initial`.

The dataset of a run holds its whole state under names (`hydrosim.results.output`); this module
reads it. Bodies, degrees of freedom and radiation must be the same, all else may differ. New
elements begin unstretched, without slip or loss. A contact mode that has become impossible is
determined anew. Time continues, with the waves and all tables.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.dofs import LATERAL
from hydrosim.elements import ELEMENT_KINDS, events, kinds_of, modes_of_kind, new_modes
from hydrosim.elements.events import set_initial_modes
from hydrosim.elements.kind import ModeRows, ResetsOnRestart, UnitKind
from hydrosim.errors import InputError
from hydrosim.integrate.dynamics import Model, motion_at
from hydrosim.integrate.names import MOVING, Coordinate, StateKind, StateLayout, memory_names
from hydrosim.integrate.state import State
from hydrosim.modes import CONTACT_MARGIN, MARGINS, MODE, RISING, SEGMENT, SEGMENT_MARGIN
from hydrosim.multibody.kinematics import Motion
from hydrosim.results.dataset import read_run
from hydrosim.results.ledger import ACCURACY
from hydrosim.results.memory import push_again, take_over
from hydrosim.scene import Body, Place, Scene, Start, WaveForces
from hydrosim.water import radiation
from hydrosim.water.displaced_loads import slow_bodies
from hydrosim.water.radiation import VelocityHistory

if TYPE_CHECKING:
    import xarray as xr


MODE_OVERRUN_ATOL = (
    1e-6  # m or s: a stored mode may exceed its end by this; it then ends as the run begins
)
SAME_FIT = 1e-6  # of the largest entry: fits of one database agree to this rounding
HEADINGS = "initial_heading"  # variable: heading of each body at the start of the first run [rad]
MET = "waves_meet"  # variable, with a body's name: position and headings of its wave forces
MAX_NAMES_SHOWN = 5  # names in a message


def open_start(scene: Scene) -> Scene:
    """Scene with the run that it starts from in memory, and the time of the stored state.

    Raises InputError if there is no such run, or if it has no state at that time.
    """
    if scene.initial is None:
        return scene
    start = opened_start(scene.initial)
    bodies = tuple(_met_as_before(body, start) for body in scene.bodies)
    return replace(scene, initial=start, bodies=bodies)


def _met_as_before(body: Body, start: Start) -> Body:
    """The body; waves act on it where they did in the earlier run if the scene leaves that to the
    program."""
    assert not isinstance(start.run, Path | str)
    stored = str(start.run.attrs.get(f"{MET}_{body.name}", "")).split()
    asked = body.wave_forces
    if len(stored) != 2:
        return body
    position, headings = (
        Place(before) if here == Place.AUTOMATIC else here
        for here, before in zip((asked.position, asked.headings), stored, strict=True)
    )
    return replace(body, wave_forces=replace(asked, position=position, headings=headings))


def opened_start(start: Start) -> Start:
    """Start with its run in memory and the time of the stored state. Raises as `open_start`
    does."""
    run = _read_run(start.run) if isinstance(start.run, Path | str) else start.run.load()
    if "state_value" not in run or "state_kind" not in run:
        found_text = "has no states" if "state_value" not in run else "does not name its states"
        raise InputError(
            f"initial.run: {_source_text(run)} {found_text}, so no run can start from it; expected"
            " the result of `hydrosim run` or simulate of this version. Run that case again, or"
            " read its file with hs.open_run."
        )
    return Start(run, _stored_time(run, start.time))


def start_time(scene: Scene) -> float:
    """Time at which a run of an `open_start` scene begins [s]: 0, or the time of the stored
    state."""
    start = scene.initial
    return 0.0 if start is None or start.time is None else start.time


def method_before(scene: Scene, accuracy: float) -> str | None:
    """Method of the run that an `opened_start` scene starts from, if it was chosen for the same
    ``accuracy``; else None."""
    if scene.initial is None:
        return None
    attributes = _open_run(scene).attrs
    same = float(attributes.get(ACCURACY, 0.0)) == accuracy
    return str(attributes["solver_method"]) if same else None


def has_slow_places(scene: Scene, met: Mapping[str, WaveForces]) -> bool:
    """Whether an `open_start` scene starts from a run that stored all its slow positions in waves.
    ``met`` has the positions where waves act, by body."""
    if scene.initial is None:
        return False
    run = _open_run(scene)
    there = {*run.state_owner.values[run.state_kind.values == StateKind.SLOW_PLACE]}
    return {*slow_bodies(scene, met)} <= there


def initial_headings(scene: Scene) -> list[float]:
    """Heading of every body of an `open_start` scene at the start of the first run [rad]."""
    here = [body.heading + body.position[5] for body in scene.bodies]
    if scene.initial is None:
        return here
    stored = np.atleast_1d(_open_run(scene).attrs.get(HEADINGS, here))
    return [float(x) for x in stored] if len(stored) == len(here) else here


class MemoryBefore(NamedTuple):
    """Coordinates ("surge of barge") whose memory a run computes by convolution, and by states."""

    convolved: frozenset[str] = frozenset()
    states: frozenset[str] = frozenset()


def memory_before(scene: Scene) -> MemoryBefore:
    """Coordinates with memory of the run that an `opened_start` scene starts from; empty at a start
    from rest."""
    start = scene.initial
    if start is None or isinstance(start.run, Path | str):
        return MemoryBefore()
    names = ("memory_dof", "radiation_dof")
    convolved, states = (start.run[x].values if x in start.run else () for x in names)
    return MemoryBefore(frozenset(map(str, convolved)), frozenset(map(str, states)))


def resumed_state(scene: Scene, model: Model, layout: StateLayout, fresh: State) -> State:
    """State that an `opened_start` scene starts from; ``fresh`` is the state of a start from rest.

    Raises InputError if the stored state is not finite, or if its memory is too short.
    """
    run = _open_run(scene)
    time = start_time(scene)
    values = run.state_value.sel(state_time=time).values
    if not np.isfinite(values).all():
        text = f"its state at {time:g} s is not finite; start from an earlier time"
        raise InputError(f"initial.run: {_source_text(run)}: {text}.")
    there = dict(zip(run.state.values, values, strict=True))
    names = layout.names()
    is_known = np.array([name in there for name in names])
    y = np.array([there.get(name, 0.0) for name in names])
    contents = slice(model.tanks.state, model.tanks.state + model.tanks.each.size)
    y[contents] = np.where(is_known, y, fresh.y)[contents]  # as at a start from rest
    for i, entry in enumerate(layout.entries_of(StateKind.SLOW_DRAUGHT), model.draught):
        if not is_known[i]:  # at the draught of the body
            y[i] = there.get(Coordinate("heave", entry.owner).name, 0.0)
    modes = _stored_modes(scene, model, run, y, is_known)
    return State(y, modes, _restore_history(scene, model, run, fresh.history))


def _open_run(scene: Scene) -> xr.Dataset:
    assert scene.initial is not None
    assert not isinstance(scene.initial.run, Path | str)
    return scene.initial.run


def _read_run(path: Path | str) -> xr.Dataset:
    try:
        return read_run(Path(path))
    except InputError as error:
        raise InputError(f"initial.run: {error}") from None


def _source_text(run: xr.Dataset) -> str:
    return str(run.encoding.get("source", "the dataset"))


def _stored_time(run: xr.Dataset, time: float | None) -> float:
    """Index of the state stored at ``time``, or of the last state."""
    times = run.state_time.values
    if time is None:
        return float(times[-1])
    nearest = float(times[np.abs(times - time).argmin()])
    if np.isclose(nearest, time, rtol=1e-9, atol=1e-9):
        return nearest
    text = f"initial.time: found {time:g} s; {_source_text(run)} has"
    if times.size < run.sizes["time"]:
        raise InputError(
            f"{text} only its last whole state, at {nearest:g} s. Start there, or run that case"
            " with output: {states: true}, which stores the state at every output time."
        )
    raise InputError(f"{text} no state at that time; the nearest is at {nearest:g} s.")


def check_fit(scene: Scene, model: Model, layout: StateLayout) -> None:
    """Raises InputError if bodies, degrees of freedom or radiation of an `open_start` scene differ
    from those of the run that it starts from."""
    run = _open_run(scene)
    moving = layout.moving()
    names = {entry.name: [q.name for q in entry.coordinates] for entry in moving}
    names |= {f"memory of {name}": [name] for name in memory_names(scene, model)}
    kinds = zip(run.state.values, run.state_kind.values, strict=True)
    stored = [str(name) for name, kind in kinds if kind in MOVING]
    if "memory_past" in run:
        stored += [f"memory of {name}" for name in run.memory_dof.values]
    zero = {*str(run.attrs.get("zero_by_symmetry", "")).splitlines()}
    if zero:  # also of bodies whose coordinates are those of a joint
        zero |= {Coordinate(dof, body.name).name for body in scene.bodies for dof in LATERAL}
    problems = {
        "that run lacks": [
            name for name, of in names.items() if name not in stored and {*of} - zero
        ],
        "this scene lacks": [name for name in stored if name not in names],
    }
    problem_text = "; ".join(
        f"{what} {_name_list(names)}" for what, names in problems.items() if names
    )
    if not problem_text and not _has_same_fit(model, layout, run):
        problem_text = (
            "its radiation states belong to another fit (another database, other masses, or"
            " another program version)"
        )
    if problem_text:
        raise InputError(
            f"initial.run: {_source_text(run)}: {problem_text}; expected the same"
            " bodies, degrees of"
            " freedom and radiation in that run and in this scene. Change this case, or run the"
            " earlier case again."
        )


def _name_list(names: Sequence[str]) -> str:
    more = f" and {len(names) - MAX_NAMES_SHOWN} more" if len(names) > MAX_NAMES_SHOWN else ""
    return ", ".join(names[:MAX_NAMES_SHOWN]) + more


def _has_same_fit(model: Model, layout: StateLayout, run: xr.Dataset) -> bool:
    """Whether the radiation states that both have belong to one fit."""
    names = layout.names()[model.radiation :]
    here = radiation.input_rates(model.states)
    there = dict(zip(run.state.values, run.state_input.values, strict=True))
    missed = [there.get(name, x) - x for name, x in zip(names, here, strict=False)]
    return np.abs(missed).max(initial=0.0) <= SAME_FIT * np.abs(here).max(initial=0.0)


def _stored_modes(
    scene: Scene, model: Model, run: xr.Dataset, y: np.ndarray, is_known: np.ndarray
) -> np.ndarray:
    """Modes (rows, 3) of all units: the stored mode if it is possible, else that of a start from
    ``y``. ``is_known`` (ny,) marks the states of ``y`` that the run had."""
    time = start_time(scene)
    renewing = [kind for kind in ELEMENT_KINDS if isinstance(kind, ResetsOnRestart)]
    for resetting in renewing:
        resetting.clear_unused_states(resetting.constants_in(model), y)
    motion = motion_at(model, y)
    settled = new_modes(model)
    anew = y.copy()
    set_initial_modes(time, anew, settled, motion, model.bodies, model.elements, model.tanks)
    stored = settled.copy()
    at = run.sel(time=time, state_time=time)
    for kind, p in kinds_of(model):
        _restore_modes(
            kind, kind.modes(p), kind.unit_names(scene), at, modes_of_kind(kind, p, stored)
        )
    possible = _possible_modes(time, y, stored, motion, model)
    for resetting in renewing:
        p = resetting.constants_in(model)
        resetting.renew(p, y, anew, modes_of_kind(resetting, p, possible[:, None])[:, 0], is_known)
    return np.where(possible[:, None], stored, settled)


def _restore_modes(
    kind: UnitKind, rows: ModeRows, names: Sequence[str], at: xr.Dataset, modes: np.ndarray
) -> None:
    """Stored modes of the units that the run has by name, ``at`` the time of the start."""
    there = [*at[kind.unit].values] if kind.unit in at.dims else []
    for i, name in enumerate(names):
        if name not in there:
            continue
        stored = at.isel({kind.unit: there.index(name)})
        modes[i, MODE] = int(stored[f"{kind.unit}_{rows.mode}"])
        if rows.first is not None and rows.last is not None:
            segment = rows.first[i] + int(stored[f"{kind.unit}_segment"])
            modes[i, SEGMENT] = min(segment, rows.last[i])
        if rows.rising:
            modes[i, RISING] = int(stored[f"{kind.unit}_{rows.rising}"])


def _possible_modes(
    time: float, y: np.ndarray, modes: np.ndarray, motion: Motion, model: Model
) -> np.ndarray:
    """Whether each unit (rows,) is in contact, or on its curve, as its mode says."""
    count = len(modes)
    out = np.zeros((count, MARGINS))
    unused = np.zeros((count, 2))  # headings and reactions do not matter here
    every = np.ones(count, dtype=np.int64)
    elements = model.elements
    tanks = model.tanks
    bodies = model.bodies
    events.find_margins(
        time, y, modes, motion, bodies, elements, tanks, unused, unused, every, out.reshape(-1)
    )
    possible = np.ones(count, dtype=bool)
    for kind, p in kinds_of(model):
        steepest = kind.modes(p).steepest
        if steepest is not None:
            margins = modes_of_kind(kind, p, out)
            touching = margins[:, CONTACT_MARGIN] >= -MODE_OVERRUN_ATOL * steepest
            kind_modes = modes_of_kind(kind, p, possible[:, None])
            kind_modes[:, 0] = touching & (margins[:, SEGMENT_MARGIN] >= -MODE_OVERRUN_ATOL)
    return possible


def _restore_history(
    scene: Scene, model: Model, run: xr.Dataset, fresh: VelocityHistory
) -> VelocityHistory:
    """Memory of a convolution before the start: ``fresh``, filled with the memory of the run."""
    kernel = model.convolution
    time = start_time(scene)
    if kernel.row.size == 0:
        return fresh
    t = run.memory_time.values
    length = (len(kernel.K) - 1) * kernel.step
    if t[0] > max(0.0, time - length):
        raise InputError(
            f"initial.time: found {time:g} s; {_source_text(run)} stores velocities from {t[0]:g} s"
            f" on, and a convolution needs {length:g} s of them. Start at {t[0] + length:g} s or"
            " later."
        )
    column = dict(zip(memory_names(scene, model), np.unique(kernel.column), strict=True))
    dofs = np.array([column[name] for name in run.memory_dof.values])
    at_end = time == run.state_time.values[-1]
    if not (at_end and take_over(run, dofs, fresh)):
        push_again(run, time, dofs, fresh)
    return fresh


def started_from(scene: Scene) -> dict[str, object]:
    """Record entries of an `open_start` scene about the run that it started from."""
    start = scene.initial
    if start is None or isinstance(start.run, Path | str):
        return {}
    return {"initial_run": _source_text(start.run), "initial_time": start.time}
