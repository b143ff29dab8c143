"""A run that starts from the state of another: `Scene.initial`.

What a run keeps of its whole state is in its dataset under names (`hydrosim.results.output`); here
it is read again. Bodies, degrees of freedom and radiation must be the same; all else may differ:
what is new begins with nothing stretched, slipped or lost, and a contact mode that cannot be any
more is found anew. Time goes on, with the waves and all tables.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr

from hydrosim import radiation
from hydrosim.errors import InputError
from hydrosim.forces import events, new_modes, own_modes, spring, trigger
from hydrosim.forces.ballast import tanks
from hydrosim.forces.ballast.tanks import flow_names
from hydrosim.forces.contact import fender, group, guide, loop
from hydrosim.forces.events import settle
from hydrosim.forces.modes import CONTACT_MARGIN, MARGINS, MODE, RISING, SEGMENT, SEGMENT_MARGIN
from hydrosim.radiation import VelocityHistory
from hydrosim.results.memory import push_again, take_over
from hydrosim.results.netcdf import read
from hydrosim.rigid import Motion, place_bodies
from hydrosim.scene import Body, Place, Scene, Start
from hydrosim.stepping.dynamics import Model, new_work
from hydrosim.stepping.names import (
    Coordinate,
    fender_names,
    group_names,
    guide_names,
    memory_names,
    spring_names,
    trigger_names,
)
from hydrosim.stepping.state import State
from hydrosim.stepping.state_layout import MOVING, Kind, state_layout
from hydrosim.waves import slow_bodies

NEAR = 1e-6  # m or s: a stored mode may be so far past its end, and ends then as the run begins
SAME_FIT = 1e-6  # of the largest entry: two fits of one database are the same to rounding
HEADINGS = "initial_heading"  # of a dataset: of each body where its first run began [rad]
MET = "waves_meet"  # of a dataset, with a body's name: position and headings of its wave forces
SHOWN = 5  # names in a message


def opened(scene: Scene) -> Scene:
    """The scene with the run that it starts from in memory and the time as it is recorded there.

    Raises InputError if there is no such run, or nothing kept of its state at that time.
    """
    if scene.initial is None:
        return scene
    start = opened_start(scene.initial)
    bodies = tuple(_met_as_before(body, start) for body in scene.bodies)
    return replace(scene, initial=start, bodies=bodies)


def _met_as_before(body: Body, start: Start) -> Body:
    """The body, which waves meet as in the run before where that is left to the program."""
    assert isinstance(start.run, xr.Dataset)
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
    """The start with its run in memory and its time as recorded; raises as `opened` does."""
    run = _read(start.run) if isinstance(start.run, Path | str) else start.run.load()
    if "state_value" not in run or "state_kind" not in run:
        found = "has no states" if "state_value" not in run else "does not say what its states are"
        raise InputError(
            f"initial.run: {_source(run)} {found} to start from; expected the result of"
            " `hydrosim run` or simulate of this version; run that case again."
        )
    return Start(run, _recorded(run, start.time))


def begin(scene: Scene) -> float:
    """Time at which a run of an `opened` scene begins [s]: 0, or that of what it starts from."""
    start = scene.initial
    return 0.0 if start is None or start.time is None else start.time


def knows_slow_places(scene: Scene) -> bool:
    """Whether an `opened` scene starts from a run that knows all its slow places in waves."""
    if scene.initial is None:
        return False
    run = _run(scene)
    there = {*run.state_owner.values[run.state_kind.values == Kind.SLOW_PLACE]}
    return {body.name for body in slow_bodies(scene)} <= there


def initial_headings(scene: Scene) -> list[float]:
    """Heading of every body of an `opened` scene at the start of the first run [rad]."""
    here = [body.heading + body.position[5] for body in scene.bodies]
    if scene.initial is None:
        return here
    stored = np.atleast_1d(_run(scene).attrs.get(HEADINGS, here))
    return [float(x) for x in stored] if len(stored) == len(here) else here


class MemoryBefore(NamedTuple):
    """The coordinates, "surge of barge", whose memory a run has by convolution, and by states."""

    convolved: frozenset[str] = frozenset()
    states: frozenset[str] = frozenset()


def before(scene: Scene) -> MemoryBefore:
    """That of the run that an `opened` scene starts from; none if it starts from rest."""
    start = scene.initial
    if start is None or not isinstance(start.run, xr.Dataset):
        return MemoryBefore()
    names = ("memory_dof", "radiation_dof")
    convolved, states = (start.run[x].values if x in start.run else () for x in names)
    return MemoryBefore(frozenset(map(str, convolved)), frozenset(map(str, states)))


def resume(scene: Scene, model: Model, fresh: State) -> State:
    """The state that an `opened` scene starts from; ``fresh`` is that of a start from rest.

    Raises InputError if the stored state is not finite, or its memory too short.
    """
    run, time = _run(scene), begin(scene)
    values = run.state_value.sel(state_time=time).values
    if not np.isfinite(values).all():
        text = f"its state at {time:g} s is not finite; start from an earlier time"
        raise InputError(f"initial.run: {_source(run)}: {text}.")
    there = dict(zip(run.state.values, values, strict=True))
    layout = state_layout(scene, model)
    y = np.array([there.get(name, 0.0) for name in layout.names()])
    for block in layout.blocks:
        for i, entry in enumerate(block.entries, start=block.offset):
            if entry.name in there:
                continue
            if block.kind == Kind.TANK:  # as at a start from rest
                y[i] = fresh.y[i]
            if block.kind == Kind.SLOW_DRAUGHT:  # as deep as the body is
                y[i] = there.get(Coordinate("heave", entry.owner).name, 0.0)
    return State(y, _modes(scene, model, run, y), _history(scene, model, run, fresh.history))


def _run(scene: Scene) -> xr.Dataset:
    assert scene.initial is not None
    assert isinstance(scene.initial.run, xr.Dataset)
    return scene.initial.run


def _read(path: Path | str) -> xr.Dataset:
    try:
        return read(Path(path))
    except InputError as error:
        raise InputError(f"initial.run: {error}") from None


def _source(run: xr.Dataset) -> str:
    return str(run.encoding.get("source", "the dataset"))


def _recorded(run: xr.Dataset, time: float | None) -> float:
    """The time of the kept state at ``time``, or of the last one."""
    kept = run.state_time.values
    if time is None:
        return float(kept[-1])
    nearest = float(kept[np.abs(kept - time).argmin()])
    if np.isclose(nearest, time, rtol=1e-9, atol=1e-9):
        return nearest
    text = f"initial.time: found {time:g} s; {_source(run)} has"
    if kept.size < run.sizes["time"]:
        raise InputError(
            f"{text} the state at its end alone, {nearest:g} s; start there, or run that case with"
            " output: {states: true}, which keeps the state at every output time."
        )
    raise InputError(f"{text} no state then; the nearest is at {nearest:g} s.")


def check_fit(scene: Scene, model: Model) -> None:
    """Raises InputError where the bodies, degrees of freedom or radiation of an `opened` scene are
    not those of the run that it starts from."""
    run = _run(scene)
    moving = state_layout(scene, model).moving()
    names = {entry.name: [q.name for q in entry.coordinates] for entry in moving}
    names |= {f"memory of {name}": [name] for name in memory_names(scene, model)}
    kinds = zip(run.state.values, run.state_kind.values, strict=True)
    stored = [str(name) for name, kind in kinds if kind in MOVING]
    if "memory_past" in run:
        stored += [f"memory of {name}" for name in run.memory_dof.values]
    zero = {*str(run.attrs.get("zero_by_symmetry", "")).splitlines()}
    problems = {
        "it lacks": [name for name, of in names.items() if name not in stored and {*of} - zero],
        "it has, and this scene has not,": [name for name in stored if name not in names],
    }
    found = "; ".join(f"{what} {_listed(names)}" for what, names in problems.items() if names)
    if not found and not _same_fit(scene, model, run):
        found = "its radiation states are of another fit (another database, or program version)"
    if found:
        raise InputError(
            f"initial.run: {_source(run)}: {found}; expected the bodies, degrees of freedom and"
            " radiation of this scene; change them here, or run that case again with these."
        )


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return ", ".join(names[:SHOWN]) + more


def _same_fit(scene: Scene, model: Model, run: xr.Dataset) -> bool:
    """Whether the radiation states that both have are of one fit."""
    names = state_layout(scene, model).names()[model.radiation :]
    here = radiation.input_rates(model.states)
    there = dict(zip(run.state.values, run.state_input.values, strict=True))
    missed = [there.get(name, x) - x for name, x in zip(names, here, strict=False)]
    return np.abs(missed).max(initial=0.0) <= SAME_FIT * np.abs(here).max(initial=0.0)


def _modes(scene: Scene, model: Model, run: xr.Dataset, y: np.ndarray) -> np.ndarray:
    """Modes (nf + ns, 3) of contacts and springs: those stored where they can be, else those of a
    start from ``y``."""
    elements, motion, time = model.elements, new_work(model).motion, begin(scene)
    points, lines = elements.fenders.points, elements.springs.lines
    fender.forget(elements.fenders, y)
    n = model.bodies.active.size
    place_bodies(y[:n], y[n : 2 * n], model.bodies, motion)
    settled, anew = new_modes(elements), y.copy()
    settle(time, anew, settled, motion, model.bodies, elements)
    stored = settled.copy()
    _restore(
        "fender",
        fender_names(scene),
        points,
        time,
        run,
        own_modes(fender, elements.fenders, stored),
    )
    _restore(
        "spring", spring_names(scene), lines, time, run, own_modes(spring, elements.springs, stored)
    )
    p = elements.tanks
    _restore("pump", flow_names(scene), p.flows, time, run, own_modes(tanks, p, stored))
    pins, of_pins = elements.guides.pins, own_modes(guide, elements.guides, stored)
    _restore("guide", guide_names(scene), pins, time, run, of_pins)
    _restore_triggers(scene, model, run, stored)
    possible = _possible(time, y, stored, motion, model)
    _set_anew(model.elements.fenders, y, anew, [*map(bool, possible)], run, fender_names(scene))
    _begin_groups(scene, model, y, anew, run)
    return np.where(possible[:, None], stored, settled)


def _set_anew(
    fenders: fender.Params,
    y: np.ndarray,
    anew: np.ndarray,
    possible: Sequence[bool],
    run: xr.Dataset,
    names: Sequence[str],
) -> None:
    """Stiff lines in y of points that were not in the run, or cannot be pressed as they were."""
    there = {*map(str, run.fender.values)} if "fender" in run.dims else set()
    for k, i in enumerate(fender.which_remember(fenders)):
        if not possible[fenders.mode + i] or names[i] not in there:
            found = fender.memories(fenders, anew)[k, loop.SET]
            fender.memories(fenders, y)[k, loop.SET] = found


def _begin_groups(
    scene: Scene, model: Model, y: np.ndarray, anew: np.ndarray, run: xr.Dataset
) -> None:
    """Groups of contacts that did not remember their stages in the run begin to."""
    fenders, there = model.elements.fenders, {*map(str, run.state.values)}
    for name, first in zip(group_names(scene, model), fenders.groups["first"], strict=True):
        if f"{group.STATE_NAMES[0]} of group {name}" not in there:
            own = slice(fenders.state + first, fenders.state + first + group.STATES)
            y[own] = anew[own]


def _restore_triggers(scene: Scene, model: Model, run: xr.Dataset, modes: np.ndarray) -> None:
    """The stored stages of those triggers that are in ``run`` by name."""
    if "trigger" not in run.dims:
        return
    own = own_modes(trigger, model.elements.triggers, modes)
    at, there = run.sel(time=begin(scene), state_time=begin(scene)), list(run.trigger.values)
    for i, name in enumerate(trigger_names(scene)):
        if name in there:
            own[i, MODE] = int(at.trigger_stage[there.index(name)])
            own[i, RISING] = int(at.trigger_waits[there.index(name)])


def _restore(
    kind: str, names: list[str], each: np.ndarray, time: float, run: xr.Dataset, modes: np.ndarray
) -> None:
    """The stored modes of those of ``each`` fender or spring that are in ``run`` by name."""
    if kind not in run.dims:
        return
    at, there = run.sel(time=time, state_time=time), list(run[kind].values)
    last = np.maximum(each["last"], each["line"]) if kind == "fender" else each["last"]
    for i, name in enumerate(names):
        if name in there:
            k = there.index(name)
            segment = each["first"][i] + int(at[f"{kind}_segment"][k])
            modes[i, MODE] = int(at[f"{kind}_mode"][k])
            modes[i, SEGMENT] = min(segment, last[i])
            if kind == "fender":
                modes[i, RISING] = int(at.fender_rising[k])


def _possible(
    time: float, y: np.ndarray, modes: np.ndarray, motion: Motion, model: Model
) -> np.ndarray:
    """Which points and springs (nf + ns,) are in contact or not, and on their curve, as their mode
    says."""
    fenders, springs = model.elements.fenders, model.elements.springs
    guides, triggers = model.elements.guides, model.elements.triggers
    out = np.zeros((len(modes), MARGINS))
    nothing = np.zeros((len(modes), 2))  # headings and reactions do not matter to them
    flat, bodies, every = out.reshape(-1), model.bodies, np.ones(len(modes), dtype=np.int64)
    each = model.elements
    events.find_margins(time, y, modes, motion, bodies, each, nothing, nothing, every, flat)
    steepest = np.zeros(len(modes))
    steepest[fenders.mode :][: fenders.points.size] = fenders.points["steepest"]
    steepest[springs.mode :][: springs.lines.size] = springs.lines["steepest"]
    flowing = np.zeros(len(modes), dtype=bool)
    own_modes(tanks, each.tanks, flowing[:, None, None])[:] = True
    touching = out[:, CONTACT_MARGIN] >= -NEAR * steepest
    possible = touching & (out[:, SEGMENT_MARGIN] >= -NEAR)
    for kind, each in ((guides, guides.pins), (triggers, triggers.each)):
        possible[kind.mode :][: len(each)] = True
    return flowing | possible


def _history(
    scene: Scene, model: Model, run: xr.Dataset, fresh: VelocityHistory
) -> VelocityHistory:
    """What a convolution remembers before the start: ``fresh``, filled with that of the run."""
    kernel, time = model.convolution, begin(scene)
    if kernel.row.size == 0:
        return fresh
    t, length = run.memory_time.values, (len(kernel.K) - 1) * kernel.step
    if t[0] > max(0.0, time - length):
        raise InputError(
            f"initial.time: found {time:g} s; {_source(run)} remembers velocities from {t[0]:g} s"
            f" on, and a convolution needs {length:g} s of them; start at {t[0] + length:g} s or"
            " later."
        )
    column = dict(zip(memory_names(scene, model), np.unique(kernel.column), strict=True))
    dofs = np.array([column[name] for name in run.memory_dof.values])
    at_end = time == run.state_time.values[-1]
    if not (at_end and take_over(run, dofs, fresh)):
        push_again(run, time, dofs, fresh)
    return fresh


def started_from(scene: Scene) -> dict[str, object]:
    """What the record of an `opened` scene says of the run it started from."""
    start = scene.initial
    if start is None or not isinstance(start.run, xr.Dataset):
        return {}
    return {"initial_run": _source(start.run), "initial_time": start.time}
