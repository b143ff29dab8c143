"""Runs that cannot continue: message with reason and remedy, and a test for energy from nowhere.

Test whether the motions of a run hold more energy than any source can have given.

The kinetic and stored energy of bodies is at most their energy at the start plus the energy
supplied since. Supplies are the work of waves, applied forces and streams, and energy from a
prescribed normal force or a damper in a current. A solution far beyond this bound is a numerical
artefact. The test finds friction and dampers that add energy, and unstable steps, long before
numbers overflow.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.compile.closed_joints import driven_joints, singular_joints
from hydrosim.compile.drives import drives_of, is_turn
from hydrosim.dofs import DOFS
from hydrosim.elements import function_errors, losses, mode_row_names, undefined_units
from hydrosim.elements.kind import RADIATION
from hydrosim.integrate import state
from hydrosim.integrate.dynamics import Model, motion_at
from hydrosim.integrate.loop import PITCH_DOF
from hydrosim.integrate.names import StateKind, element_of, force_names, is_work_row
from hydrosim.integrate.record import unpack_channels
from hydrosim.integrate.state import (
    BLOWN_UP,
    CAPSIZED,
    CHATTERING,
    DRIVEN_APART,
    NO_SAMPLE,
    NO_SOLUTION,
    NOT_FINITE,
    RECORDS,
    SINGULAR,
    STATUS,
    STEP_TOO_SMALL,
    Record,
    Run,
    State,
)
from hydrosim.scene import Method, Scene
from hydrosim.scene.scene import joined_with

if TYPE_CHECKING:
    from hydrosim.compile.compiled import Compiled

MAX_ENERGY_RATIO = 10.0  # times the possible energy
MAX_WARNINGS = 4  # earlier warnings in a message
MIN_TESTED_ENERGY = 1e-3  # J/kg of all bodies, as at 0.04 m/s: less energy is not tested


def find_blow_up(scene: Scene, model: Model, record: Record, first: int, count: int) -> int | None:
    """First record, from ``first`` to ``count``, at which the energy is `MAX_ENERGY_RATIO`
    times its supply."""
    if count <= first:
        return None
    start = unpack_channels(model, record, 1)
    # only these records, because a run is tested many times
    values = unpack_channels(model, record, count, first)
    with np.errstate(over="ignore", invalid="ignore"):
        held = values["kinetic"] + values["stored"].sum(axis=1)
    works = slice(model.energy, model.energy + model.rows)
    since = values["y"][works] - start["y"][works]
    given = np.zeros(count - first)
    lost_before = losses(model, start)
    lost_besides = losses(model, values)
    for row in range(model.rows):
        if is_work_row(scene, row):
            given += np.maximum(since[:, row], 0.0)
        elif _can_add_energy(scene, row):
            lost = since[:, row]
            if row in lost_besides:
                lost = lost + lost_besides[row] - lost_before[row]
            given += np.maximum(-lost, 0.0)
    least = MIN_TESTED_ENERGY * sum(body.mass for body in scene.bodies)
    had = abs(start["kinetic"][0] + start["stored"][0].sum())
    beyond = np.flatnonzero(held > MAX_ENERGY_RATIO * (had + given) + least)
    return first + int(beyond[0]) if beyond.size else None


def largest_energy_holder(scene: Scene, model: Model, record: Record, count: int) -> str:
    """Name of the part with most energy at the last record: an element that stores it, or a degree
    of freedom of a single body, such as "heave of body barge"."""
    values = unpack_channels(model, record, count)
    stored = values["stored"][-1]
    if not stored.max() < values["kinetic"][-1]:
        return force_names(scene)[int(np.argmax(stored))]
    v = values["velocity"][-1].reshape(-1, 6)
    inertia = [[body.mass] * 3 + list(np.diag(body.inertia)) for body in scene.bodies]
    body, dof = divmod(int(np.argmax(np.sqrt(inertia) * np.abs(v))), 6)
    return f"{DOFS[dof]} of body {scene.bodies[body].name}"


def _can_add_energy(scene: Scene, row: int) -> bool:
    """Whether a row of dissipation may be negative; radiation memory returns energy that it had at
    the start."""
    element = element_of(scene, row)
    if element is None:
        return row == RADIATION and scene.initial is not None
    return (
        element.can_add_energy() or element.active is not None
    )  # energy that it holds at the start


MESSAGES = {
    NOT_FINITE: "{where} is no longer finite",
    CAPSIZED: "the pitch of body {where} is beyond 85 deg, or the heel of its hull or tanks,"
    " where angles are no longer defined",
    CHATTERING: "{where} changes its mode endlessly (more than 200 times in one step)",
    STEP_TOO_SMALL: "no step is small enough to continue (200,000 steps were taken within one"
    " solver.step, or the last was 1e-12 of the time)",
    NO_SOLUTION: "the implicit method finds no solution for a step",
    SINGULAR: "the joints {where} come to a place where they do not determine their forces, as a"
    " four-bar linkage in a straight line",
    DRIVEN_APART: "{where} would have to let go: the joint is closed, and a drive moves what it"
    " holds",
    NO_SAMPLE: "the function of an external force cannot be called: it belongs to another process,"
    " or the call was interrupted",
    BLOWN_UP: "the solution blows up: it holds more than ten times the energy that all sources"
    " can have given, most of it in {where}",
}
REMEDIES = {
    NO_SAMPLE: "Run it in the process in which the function was made.",
    SINGULAR: "End the run before, or keep the joints away from that place.",
    DRIVEN_APART: "Let the drive stand still while the joint is closed, or end the active time of"
    " the joint before the drive moves.",
    NO_SOLUTION: "Try solver.method: dopri5, or check the stiffness and damping of that element.",
}
"""Remedies for a status that do not depend on the method."""
MIN_SWITCH_SHARE = 0.5
"""Least switches of a unit that is named, as a share of those of the one that switches most."""
MAX_NAMED_UNITS = 4
"""Most units that a message names."""

STATE_DESCRIPTIONS = {
    StateKind.SLOW_PLACE: "the slow position in waves, {entry.name}",
    StateKind.SLOW_DRAUGHT: "the {entry.name}",
    StateKind.RADIATION: "a radiation state",
    StateKind.ENERGY: "an energy",
    StateKind.IMPULSE: "an impulse",
}
"""Description of a state that is not finite, other than coordinates and their rates."""


def failure(compiled: Compiled, run: Run, time: float) -> str:
    """Message of a run that cannot continue: time, reason, element, remedy, and earlier
    warnings."""
    scene = compiled.scene
    model = compiled.model
    counters = run.counters
    count = int(counters[RECORDS])
    status = int(counters[STATUS])
    if status == BLOWN_UP:
        where = largest_energy_holder(scene, model, run.record, count)
    elif status == SINGULAR:
        where = singular_joints(scene, model, run.state)
    elif status == DRIVEN_APART:
        where = driven_joints(scene, model, run.state)
    elif status == CHATTERING:
        where = _alternating_units(compiled, run)
    else:
        where = _failed_part(compiled, run.state)
    what = MESSAGES[status].format(where=where)
    if status == CAPSIZED:
        what += _driven_text(scene, where)
    remedy = REMEDIES.get(status) or choose_remedy(status, scene.solver.method)
    for name, reason in undefined_units(model, scene, run.state.modes):
        what = f"the force of {name} is lost: {reason}"
        remedy = (
            "No step helps there: change the arrangement of that element, or end the run before."
        )
    for name, error in function_errors(scene.forces):
        what = f"the function of {name} fails ({type(error).__name__}: {error})"
        remedy = "Correct the function: its traceback is the cause of this error."
    message = f"at t = {time:.6g} s {what}."
    if status != CHATTERING:  # which names the units that it is about
        name, size = _largest_force(scene, model, run.record, count)
        message += f" The largest force at the last record is that of {name}, {size:.3g} N."
    message += f" {remedy}"
    earlier = (*compiled.notes.warnings, *compiled.step_warnings)
    return "\n".join([message, *earlier_warnings(earlier)])


def earlier_warnings(warnings: Sequence[str]) -> Iterator[str]:
    """A line of each of the first warnings, and the number of the others."""
    yield from (f"Earlier warnings: {text}" for text in warnings[:MAX_WARNINGS])
    if (more := len(warnings) - MAX_WARNINGS) > 0:
        yield f"Earlier warnings: {more} more, which hydrosim check prints."


def _driven_text(scene: Scene, body: str) -> str:
    """Names of the drives that turn a ``body``, or the joints of its tree."""
    tree = joined_with(scene, body)
    names = [
        f"forces.{name}"
        for name, drive in drives_of(scene).items()
        if drive.body in tree and is_turn(scene, drive)
    ]
    return f" (moved by {' and '.join(names)})" if names else ""


def choose_remedy(status: int, method: Method) -> str:
    """Text on what to try against a ``status``, with another method than the one in use."""
    tries = ["a smaller solver.tolerance" if method.adapts else "a smaller solver.step"]
    if status == STEP_TOO_SMALL:
        tries = ["a larger solver.tolerance"]
    if status in (STEP_TOO_SMALL, CHATTERING) and method != Method.ESDIRK4:
        tries.append("solver.method: esdirk4, which is stable at any step")
    return f"Try {', or '.join(tries)}, or check the stiffness and damping of that element."


def _alternating_units(compiled: Compiled, run: Run) -> str:
    """Names of the units whose modes alternate in the present step."""
    switches = run.scratch.switches
    names = mode_row_names(compiled.model, compiled.scene)
    often = np.flatnonzero(switches > MIN_SWITCH_SHARE * switches.max(initial=0))
    more = f" and {often.size - MAX_NAMED_UNITS} more" if often.size > MAX_NAMED_UNITS else ""
    return ", with ".join(names[i] for i in often[:MAX_NAMED_UNITS]) + more or "a contact or spring"


def _failed_part(compiled: Compiled, state: State) -> str:
    """Name of the state that is not finite, or else of the body with the steepest angle."""
    scene = compiled.scene
    model = compiled.model
    y = state.y
    first = int(np.argmax(~np.isfinite(y)))
    if np.isfinite(y[first]):
        return scene.bodies[_steepest_body(model, y)].name
    kind, entry = compiled.derived.layout.entry_at(first)
    if kind in (StateKind.COORDINATE, StateKind.RATE):
        return f"{entry.component} of body {entry.owner}"
    if kind in STATE_DESCRIPTIONS:
        return STATE_DESCRIPTIONS[StateKind(kind)].format(entry=entry)
    return f"the {kind} of {entry.owner}"


def _steepest_body(model: Model, y: np.ndarray) -> int:
    """Index of the body with the largest tilt among those with a pitch, a hull or cut tanks."""
    bodies = model.bodies
    n = bodies.active.size
    free_dofs = bodies.active[: n - bodies.tree.coordinates]
    judged = [
        *free_dofs[free_dofs % 6 == PITCH_DOF] // 6,
        *model.hulls.body,
        *model.liquids.each["body"],
    ]
    motion = motion_at(model, y)
    return int(min(judged, key=lambda b: motion.rotation[b, 2, 2], default=0))


def _largest_force(
    scene: Scene, model: Model, record: state.Record, count: int
) -> tuple[str, float]:
    """Name and size of the largest force at the last record."""
    wrench = unpack_channels(model, record, count)["wrench"][-1].reshape(model.rows, -1, 6)
    size = np.abs(wrench[:, :, :3]).max(axis=(1, 2))
    return force_names(scene)[int(size.argmax())], float(size.max())
