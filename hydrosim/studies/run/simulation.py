"""`simulate`: runs a case or a scene, and returns its dataset."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from datetime import UTC, datetime
from math import isfinite
from pathlib import Path
from time import thread_time
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.case import load_case
from hydrosim.compiling.clock import compile_clock
from hydrosim.compiling.compile import compile_scene
from hydrosim.compiling.compiled import Compiled
from hydrosim.compiling.facts import solution
from hydrosim.compiling.joints.closed import singular_joints
from hydrosim.compiling.restart import ACCURACY, HEADINGS, MET, started_from
from hydrosim.documents.places import locating
from hydrosim.errors import SimulationError
from hydrosim.forces import lost_units
from hydrosim.jit.refs import Held, forget
from hydrosim.jit.waiting import Torn, running_time
from hydrosim.linear.propagate import propagate
from hydrosim.program import program_version, versions
from hydrosim.results.ledger import warn
from hydrosim.results.netcdf import FORMAT, LATEST
from hydrosim.results.output import to_dataset
from hydrosim.rigid.free import owners
from hydrosim.scene import Scene
from hydrosim.stepping.names import force_names
from hydrosim.stepping.record import SPACING, new_record, unpack
from hydrosim.stepping.run import PITCH, advance, count_evaluations
from hydrosim.stepping.state import (
    BLOWN_UP,
    CAPSIZED,
    CHATTERING,
    EVALUATIONS,
    EVENTS,
    NO_SOLUTION,
    NOT_FINITE,
    POINT,
    RECORDS,
    REJECTED,
    RUNNING,
    SINGULAR,
    STATUS,
    STEP_TOO_SMALL,
    STEPS,
    Record,
    Run,
    State,
    new_run,
)
from hydrosim.stepping.state_layout import StateKind
from hydrosim.studies.run.aftermath import noticed
from hydrosim.studies.run.asked import check_criteria
from hydrosim.studies.run.blow_up import blown_up, holder
from hydrosim.studies.run.checkpoint import Checkpoint, Keeper
from hydrosim.studies.run.resolution import (
    unresolved,
)
from hydrosim.studies.run.stages import complete
from hydrosim.studies.run.step_limits import warned_of_steps
from hydrosim.studies.run.twin import estimated

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.case import Case
    from hydrosim.stepping.dynamics import Model

CHUNK = 0.1  # s of processor time between reports of progress
MESSAGES = {
    NOT_FINITE: "{where} is no longer finite",
    CAPSIZED: "the pitch of body {where} is beyond 85 deg, or the heel of its hull or tanks,"
    " where angles are no longer defined",
    CHATTERING: "a contact or spring changes its mode endlessly (more than 200 times in one step)",
    STEP_TOO_SMALL: "no step is small enough to continue (200,000 steps were taken within one"
    " solver.step, or the last was 1e-12 of the time)",
    NO_SOLUTION: "the implicit method finds no solution for a step",
    SINGULAR: "the joints {where} come to a place where they do not determine their forces, as a"
    " four-bar linkage in a straight line",
    BLOWN_UP: "the solution blows up: it holds more than ten times the energy that all sources"
    " can have given, most of it in {where}",
}
REMEDY = "Try a smaller solver.step, or check the stiffness and damping of that element."
REMEDIES = {
    CHATTERING: "Try a smaller solver.step, solver.method: esdirk4, which is stable at any step, or"
    " check the stiffness and damping of that element.",
    STEP_TOO_SMALL: "Try solver.method: esdirk4, which is stable at any step, or a larger"
    " solver.tolerance, or check the stiffness and damping of that element.",
    SINGULAR: "End the run before, or keep the joints away from that place.",
    NO_SOLUTION: "Try solver.method: dopri5, or check the stiffness and damping of that element.",
}
"""Remedies for a status if another one is better than `REMEDY`."""

NAMED = {
    StateKind.SLOW_PLACE: "the slow position in waves, {entry.name}",
    StateKind.SLOW_DRAUGHT: "the {entry.name}",
    StateKind.RADIATION: "a radiation state",
    StateKind.ENERGY: "an energy",
    StateKind.IMPULSE: "an impulse",
}
"""Description of a state that is not finite, other than coordinates and their rates."""

Progress = Callable[[float, int], None]
"""Function that is called at times with the simulated time [s] and the number of steps."""


def simulate(
    case: Case | Scene | Compiled | str | Path,
    progress: Progress | None = None,
    kept: Checkpoint | None = None,
) -> xr.Dataset:
    """Run a case, the case in a file, a scene or a compiled scene. `hydrosim.results.output`
    describes the dataset.
    Runs that a case needs are made first, see `hydrosim.studies.run.stages`. Cases and scenes are
    compiled ``in_plane``, which leaves out motions that are zero by symmetry; a compiled scene is
    run as it is. With ``kept``, checkpoints are saved to disk; the caller removes them after
    writing the result.

    An interrupt from the keyboard ends the run early, with ``status`` "interrupted". Raises
    InputError if the scene cannot be compiled or has not the channels of its criteria, and
    SimulationError if the run cannot continue. That error carries the ``dataset`` until then, with
    ``status`` "failed".
    """
    if isinstance(case, Compiled):
        return run_compiled(_checked(case), progress, kept)
    if isinstance(case, Scene):
        with locating(case.places):
            # no name for the compiled scene: `run_compiled` lets go of its waves
            return run_compiled(_checked(compile_scene(case, in_plane=True)), progress, kept)
    return simulate(prepared(case, progress), progress, kept)


def _checked(compiled: Compiled) -> Compiled:
    """The scene with warnings of its step, once its run is known to have what its criteria ask."""
    check_criteria(compiled)
    return warned_of_steps(compiled)


def prepared(case: Case | Scene | str | Path, progress: Progress | None = None) -> Scene:
    """Scene of a case or of the case in a file, after the runs that it needs were made."""
    if isinstance(case, Scene):
        return case
    read = load_case(case) if isinstance(case, str | Path) else case
    complete(read, lambda stage, _: simulate(stage, progress))
    return read.scene()


def run_compiled(
    compiled: Compiled,
    progress: Progress | None = None,
    kept: Checkpoint | None = None,
    estimates: bool = True,
) -> xr.Dataset:
    """`simulate` for a compiled scene whose step limits are known. With ``estimates``, a twin run
    estimates its error."""
    scene = compiled.scene
    model = compiled.model
    clock = compile_clock(compiled)
    spacing = 1 if scene.output_states else SPACING
    record = new_record(model, clock, scene.output_accelerations, spacing)
    run = new_run(clock, model, compiled.method, compiled.first_state(), record)
    counters = run.counters
    exact = compiled.facts.exact  # computed at once: no checkpoint
    keeper = Keeper(kept, compiled, run) if kept and not exact else None
    if keeper:
        keeper.take_up()
    chunks = propagate(run) if exact else _chunks(run)
    time = next(chunks)  # the first chunk takes no step
    start = running_time()
    status = "complete"
    if keeper:
        keeper.begin()
    try:
        for time in _guarded(chunks, compiled, run):
            if progress is not None:
                progress(time, int(counters[STEPS]))
            if keeper:
                keeper.look()
    except KeyboardInterrupt as interrupt:
        status = "interrupted"
        if keeper and not isinstance(interrupt, Torn):
            keeper.save()
    failed = counters[STATUS] != RUNNING
    message = _failure(compiled, run, time) if failed else None
    attributes = {
        **_provenance(compiled),
        "solver_linear": solution(scene, compiled.facts),
        "solver_steps": int(counters[STEPS]),
        "solver_rejected": int(counters[REJECTED]),
        "solver_events": int(counters[EVENTS]),
        "solver_evaluations": int(counters[EVALUATIONS]),
        "wall_time": keeper.wall_time if keeper else running_time() - start,
        "status": "failed" if message else status,
        "status_message": message,
    }
    count = int(counters[RECORDS])
    history = run.state.history
    warnings = [*compiled.notes.warnings, *unresolved(compiled, record, count)]
    attributes["warnings"] = "\n".join(warnings) or None
    wanted = estimates and status == "complete" and not failed
    estimate = estimated(compiled, run) if wanted else None
    compiled = _without_table(compiled)
    del chunks, keeper, run, model  # with them the table of waves, if no caller holds it
    forget()
    layout = compiled.facts.layout
    dataset = to_dataset(
        scene, compiled.model, layout, compiled.sea, record, count, history, attributes
    )
    warn(dataset, noticed(compiled, dataset))
    if estimate:
        dataset.attrs["twin_evaluations"] = estimate.evaluations
        warn(dataset, estimate.warnings)
    if message:
        raise SimulationError(message, dataset)
    return dataset


def _without_table(compiled: Compiled) -> Compiled:
    """Compiled scene without its waves over time. Only steps need them, and of a long run they are
    a third of its record."""
    waves = compiled.model.waves
    model = compiled.model._replace(waves=waves._replace(values=waves.values[:0].copy()))
    return replace(compiled, facts=replace(compiled.facts, model=model))


def _chunks(run: Run) -> Iterator[float]:
    """Advance to the end in chunks of about 0.1 s of processor time, so that an interrupt is
    handled; yields the simulated time, first that of the start.

    The processor time of this thread counts. Otherwise, a chunk that waits for other processes
    would shorten the next ones, each of which is followed by a test of its records.
    """
    counters = run.counters
    held = Held(run)
    evaluations = 1
    yield advance(0, held)
    while counters[POINT] < run.clock.points and not counters[STATUS]:
        begin = thread_time()
        before = int(count_evaluations(counters))
        reached = advance(evaluations, held)
        pace = (count_evaluations(counters) - before) / max(thread_time() - begin, 1e-6)
        evaluations = int(min(max(CHUNK * pace, 1), 100 * evaluations))
        yield reached


def _guarded(chunks: Iterator[float], compiled: Compiled, run: Run) -> Iterator[float]:
    """Times of ``chunks``, up to the record at which the run blows up. Later records are
    discarded."""
    seen = 0
    counters = run.counters
    record = run.record
    for time in chunks:
        count = int(counters[RECORDS])
        found = blown_up(compiled.scene, run.model, record, seen, count)
        if found is not None:
            counters[RECORDS] = found + 1
            counters[STATUS] = BLOWN_UP
            yield float(unpack(run.model, record, found + 1, found)["time"][0])
            return
        seen = count
        yield time


def _failure(compiled: Compiled, run: Run, time: float) -> str:
    """Message of a run that cannot continue: time, reason, element, remedy, and earlier
    warnings."""
    scene = compiled.scene
    model = compiled.model
    counters = run.counters
    count = int(counters[RECORDS])
    if counters[STATUS] == BLOWN_UP:
        where = holder(scene, model, run.record, count)
    elif counters[STATUS] == SINGULAR:
        where = singular_joints(scene, model, run.state)
    else:
        where = _where(compiled, run.state)
    what = MESSAGES[int(counters[STATUS])].format(where=where)
    for name, reason in lost_units(model, scene, run.state.modes):
        what = f"the force of {name} is lost: {reason}"
    name, size = _largest_force(scene, model, run.record, count)
    message = (
        f"at t = {time:.6g} s {what}. The largest force at the last record is that of {name},"
        f" {size:.3g} N. {REMEDIES.get(int(counters[STATUS]), REMEDY)}"
    )
    return "\n".join([message, *(f"Earlier warnings: {text}" for text in compiled.notes.warnings)])


def _where(compiled: Compiled, state: State) -> str:
    """Name of the state that is not finite, or else of the body with the steepest angle."""
    scene = compiled.scene
    model = compiled.model
    n = model.bodies.active.size
    y = state.y
    first = int(np.argmax(~np.isfinite(y)))
    if np.isfinite(y[first]):
        judged = np.isin(model.bodies.active, 6 * np.arange(len(scene.bodies)) + PITCH)
        judged[model.hulls.roll] = True
        steepest = int(np.argmax(np.abs(y[:n]) * judged))
        return scene.bodies[owners(model.bodies)[steepest]].name
    kind, entry = compiled.facts.layout.at(first)
    if kind in (StateKind.COORDINATE, StateKind.RATE):
        return f"{entry.component} of body {entry.owner}"
    if kind in NAMED:
        return NAMED[StateKind(kind)].format(entry=entry)
    return f"the {kind} of {entry.owner}"


def _largest_force(scene: Scene, model: Model, record: Record, count: int) -> tuple[str, float]:
    """Name and size of the largest force at the last record."""
    wrench = unpack(model, record, count)["wrench"][-1].reshape(model.rows, -1, 6)
    size = np.abs(wrench[:, :, :3]).max(axis=(1, 2))
    return force_names(scene)[int(size.argmax())], float(size.max())


def _provenance(compiled: Compiled) -> dict[str, object]:
    """Attributes on the origin of the numbers: case, databases, seeds, radiation, solver."""
    scene = compiled.scene
    notes = compiled.notes
    return {
        "Conventions": "CF-1.11",
        "format": f"{FORMAT} {LATEST}",
        "date_created": datetime.now(UTC).isoformat(timespec="seconds"),
        "title": scene.title,
        **scene.source,
        "program": f"hydrosim {program_version()}",
        "versions": versions(),
        "seeds": [wave.seed for wave in scene.environment.waves] or None,
        "wave_ramp": max((wave.ramp for wave in scene.environment.waves), default=0.0) or None,
        "solver_method": str(scene.solver.method),
        "solver_step": scene.solver.step,
        ACCURACY: scene.solver.accuracy,
        "solver_chosen": notes.method or None,
        "skipped": "\n".join(notes.skipped) or None,
        "solver_symmetry": notes.symmetry or None,
        "zero_by_symmetry": "\n".join(notes.zero) or None,
        **started_from(scene),
        HEADINGS: compiled.facts.headings if np.any(compiled.model.headings.stream) else None,
        "records": "\n".join(notes.records) or None,
        "meetings": "\n".join(notes.meetings) or None,
        "line_drag": "\n".join(notes.drag) or None,
        "radiation_errors": "\n".join(notes.memory) or None,
        "radiation_error": notes.radiation_error if isfinite(notes.radiation_error) else None,
        **_met(compiled),
        **{
            f"{key}_{name}": value
            for wet in compiled.wet
            for name in wet.names
            for key, value in wet.provenance().items()
        },
    }


def _met(compiled: Compiled) -> dict[str, str]:
    """Positions where waves act on each wet body, for runs that continue this one."""
    met = compiled.facts.met
    wet = [name for name in met if name in compiled.facts.databases]
    return {f"{MET}_{name}": f"{met[name].position} {met[name].headings}" for name in wet}
