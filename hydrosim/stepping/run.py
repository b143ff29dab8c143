"""A run: steps on a fixed grid, cut at breakpoints and events, recorded at output times.

A step from t to t + h is one step of the method unless a contact mode ends inside it or a table
has a corner there. Then the step is cut: the end of the mode is located, the state is taken there
by the method itself, the mode switches, and the rest of the step follows (see `crossing`).
"""

from __future__ import annotations

from math import prod
from typing import NamedTuple

import numpy as np

from hydrosim.forces import FENDER, SPRING, new_modes, spring
from hydrosim.forces.contact.fender import OBSERVED, SETTLED, STATES, observe
from hydrosim.integrate import Control, error_norm, step_factor
from hydrosim.jit.kernels import assign, kernel, root, summing
from hydrosim.jit.refs import ref
from hydrosim.radiation.history import push
from hydrosim.rigid import accelerations
from hydrosim.stepping.crossing import cut, make_consistent, note_headings, switch_modes
from hydrosim.stepping.dynamics import Model, rhs, still, stored_energies
from hydrosim.stepping.stepper import (
    AFTER,
    BEFORE,
    BUT_FOR_SLIP,
    CAPSIZED,
    CHATTERING,
    END,
    EVALUATIONS,
    EVENTS,
    NO_SOLUTION,
    NOT_FINITE,
    RECORDS,
    REJECTED,
    RUNNING,
    SLOPE,
    STATUS,
    STEP_TOO_SMALL,
    STEPS,
    UNKNOWN,
    step,
)
from hydrosim.waves.loads import wave_loads

PITCH = 4  # among a body's six coordinates
STEEPEST = 1.48  # rad (85 deg): beyond it the angles' rates lose their meaning
PARTS = 3  # of a step, while a contact node relaxes fast after an event
SHORTEST = 1e-3  # part of a step that is tried where an implicit method finds no solution
PIECES = 200  # events in one step, per contact point or spring, after which it is called chattering


class Clock(NamedTuple):
    """Grid of ``points`` steps up to ``end`` [s]; every ``every``-th and the last are recorded. It
    begins ``first`` steps after ``start``: so a restart is on the grid of the run before it.
    ``breakpoints`` are times that no step may cross; ``events`` false lets steps run past them.

    With adaptive ``control`` the grid is that of the records, and steps are shorter: they begin
    with ``pace``.
    """

    start: float
    first: int
    step: float
    end: float
    points: int
    every: int
    breakpoints: np.ndarray
    events: bool
    control: Control
    pace: float


class Record(NamedTuple):
    """What is kept at every output time: ``channels`` (nt, nc), see `channels`, and the ``modes``
    (nt, nf + ns, 3) of contacts and springs."""

    channels: np.ndarray
    modes: np.ndarray


def channels(model: Model) -> dict[str, tuple[int, ...]]:
    """Names and shapes of the channels of a record, in their order."""
    m = 6 * model.bodies.each.size
    return {
        "time": (),
        "elevation": (),
        "kinetic": (),
        "y": (model.size,),
        "coordinates": (m,),
        "velocity": (m,),
        "stored": (model.rows,),
        "wrench": (model.rows, m),
        "contact": (model.elements[FENDER].points.size, OBSERVED),
        "springs": (model.elements[SPRING].lines.size, spring.OBSERVED),
    }


def new_record(model: Model, clock: Clock) -> Record:
    """Room for all output times, the first included."""
    nt = -(-clock.points // clock.every) + 1  # the end is recorded, on an output time or not
    width = sum(prod(shape) for shape in channels(model).values())
    modes = new_modes(model.elements)
    return Record(np.zeros((nt, width)), np.zeros((nt, *modes.shape), modes.dtype))


@root
def advance(first, count, clock, model, method, state, work, scratch, record, counters):
    """Go from grid point ``first`` over up to ``count`` more; stops early where
    ``counters[STATUS]`` says why.

    ``state`` is left where the last accepted piece ended. Returns the time that was reached.
    """
    return _advance(
        first,
        count,
        ref(clock),
        ref(model),
        ref(method),
        ref(state),
        ref(work),
        ref(scratch),
        ref(record),
        counters,
    )


@kernel
def _advance(first, count, clock, model, method, state, work, scratch, record, counters):
    """The loop of `advance`, with references."""
    t = grid_time(first, clock)
    if counters[RECORDS] == 0:
        make_consistent(t, model, state, work, scratch)
        remember(t, model, state, work, scratch, counters)
        keep(t, model, state, work, scratch, record, counters)
    for n in range(first + 1, min(first + count, clock.points) + 1):
        t = _cross(t, grid_time(n, clock), clock, model, method, state, work, scratch, counters)
        if counters[STATUS] != RUNNING:
            return t
        if n % clock.every == 0 or n == clock.points:
            keep(t, model, state, work, scratch, record, counters)
    return t


@kernel
def grid_time(n, clock):
    """Time of grid point ``n``; the last one is the end of the run."""
    return min(clock.start + (clock.first + n) * clock.step, clock.end)


@kernel
def _cross(t, goal, clock, model, method, state, work, scratch, counters):
    """Go to the time ``goal``, piece by piece; returns the time reached."""
    limit = PIECES * (1 + state.modes.shape[0])
    events, part = 0, 1.0  # of a step, where the stages of the whole have no solution
    while t < goal and events <= limit and counters[STATUS] == RUNNING:
        stop = _breakpoint_after(t, goal, clock)
        stop = min(stop, t + _pace(t, stop - t, clock, model, state, scratch))
        stop = stop if part == 1.0 else t + part * (stop - t)
        accepted, reached, left = _try(
            t, stop, clock, model, method, state, work, scratch, counters
        )
        if counters[STATUS] == NO_SOLUTION and part > SHORTEST:
            counters[STATUS], part = RUNNING, 0.5 * part
        if not accepted:
            counters[REJECTED] += 1
            continue
        t, part = reached, min(2.0 * part, 1.0)
        counters[STEPS] += 1
        assign(state.y, scratch.states[END])
        _renew(left, work, scratch)
        if left:
            events += 1
            remember(t, model, state, work, scratch, counters)  # as it was before the event
            switch_modes(clock.events, clock.step, t, model, state, work, scratch)
        elif work.holds.point.size > 0:
            still(state.y, state.modes, model, work)
        check(state.y, model.bodies, counters)
        remember(t, model, state, work, scratch, counters)
    if events > limit:
        counters[STATUS] = CHATTERING
    counters[EVENTS] += events
    return t


@kernel
def _try(t, stop, clock, model, method, state, work, scratch, counters):
    """Take a step from ``t`` to ``stop``: whether it counts, its end at its first event, if it has
    one, and whether a mode has ended there."""
    note_headings(t, model, state, work, scratch.headings)
    step(t, stop - t, model, method, state, work, scratch, counters)
    h = stop - t
    if clock.control.adaptive and not _accepted(t, h, clock, method, state, scratch, counters):
        return False, t, False
    left = False
    if counters[STATUS] == RUNNING:
        stop, left = cut(t, stop, clock.events, model, method, state, work, scratch, counters)
    return counters[STATUS] == RUNNING, stop, left


@kernel
def _pace(t, h, clock, model, state, scratch):
    """How long the next step shall be, if not the whole ``h``: as the control of an adaptive method
    has it, or a part of a step while a contact node settles after an event."""
    if clock.control.adaptive:
        return scratch.pace[0]
    part = clock.step / PARTS
    if h > 1.1 * part:  # not cut for a sliver
        fenders = model.elements[FENDER]
        for i in range(fenders.points.size):
            if t < state.y[fenders.state + STATES * i + SETTLED]:
                return part
    return h


@kernel
def _accepted(t, h, clock, method, state, scratch, counters):
    """Judge a step by its error and set the pace of the next; a run whose steps shrink to nothing
    is stopped."""
    pace = scratch.pace
    error = error_norm(h, method, scratch.k, state.y, scratch.states[END], clock.control)
    factor = step_factor(error, pace[1], method.order)
    if error <= 1.0:
        short = h < 0.999 * pace[0]  # by the grid or a breakpoint: no reason for a slower pace
        pace[0], pace[1] = max(factor * h, pace[0] if short else 0.0), error
        return True
    pace[0] = factor * h
    if pace[0] < 1e-12 * max(abs(t), 1.0):
        counters[STATUS] = STEP_TOO_SMALL
    return False


@kernel
def remember(t, model, state, work, scratch, counters):
    """Add velocities and accelerations at ``t`` to the history, if a convolution needs them; the
    slope found for that begins the next step."""
    if state.history.time.size == 0:
        return
    bodies, slope = model.bodies, scratch.k[0]
    n = bodies.active.size
    rhs(t, state.y, state.modes, state.history, model, work, slope)
    counters[EVALUATIONS] += 1
    scratch.fresh[0] = 1
    accelerations(slope[n : 2 * n], bodies, work.motion, work.total)
    push(state.history, t, work.motion.velocity, work.total)


@kernel
def _breakpoint_after(t, goal, clock):
    k = np.searchsorted(clock.breakpoints, t, side="right")
    if k < clock.breakpoints.size and clock.breakpoints[k] < goal:
        return clock.breakpoints[k]
    return goal


@kernel
def _renew(left, work, scratch):
    """After a step: the slope at its end, where it is known, and the margins there begin the next,
    if the modes stay and rigid friction does not change the state."""
    fresh, margins = scratch.fresh, scratch.margins
    known = fresh[1] != 0
    fresh[0], fresh[1], fresh[2] = 0, 0, UNKNOWN
    if left or work.holds.point.size > 0:
        return
    assign(margins[BEFORE], margins[AFTER])
    fresh[2] = BUT_FOR_SLIP  # whose headings are new at each step
    if known:
        assign(scratch.k[0], scratch.states[SLOPE])
        fresh[0] = 1


@kernel
def check(y, bodies, counters):
    """Set the status where a number is not finite or a pitch angle is too steep."""
    for j in range(bodies.active.size if bodies.exact else 0):
        if bodies.active[j] % 6 == PITCH and abs(y[j]) > STEEPEST:
            counters[STATUS] = CAPSIZED
    if nothing(y) != 0.0:
        counters[STATUS] = NOT_FINITE


@summing
def nothing(y):
    """Zero times the sum of ``y``: zero if all of it is finite, else not a number."""
    total = 0.0
    for j in range(y.size):
        total += 0.0 * y[j]
    return total


@root
def keep(t, model, state, work, scratch, record, counters):
    """Record the state and everything that follows from it, in the order of `channels`; the slope
    that is found for that begins the next step."""
    y, modes, motion = state.y, state.modes, work.motion
    row, kept = record.channels[counters[RECORDS]], record.modes[counters[RECORDS]]
    m, points = 6 * model.bodies.each.size, model.elements[FENDER].points.size
    at = 3 + y.size
    stored = row[at + 2 * m :]
    wrench = stored[model.rows :]
    row[2] = stored_energies(t, y, modes, model, work, stored[: model.rows])
    rhs(t, y, modes, state.history, model, work, scratch.k[0])
    scratch.fresh[0] = 1
    row[0] = t
    assign(row[3:], y)
    assign(row[at:], motion.coordinates)
    assign(row[at + m :], motion.velocity)
    for r in range(model.rows):
        assign(wrench[m * r :], work.wrench[r])
    observed = wrench[m * model.rows :]
    contact = observed[: points * OBSERVED].reshape((points, OBSERVED))
    pulls = observed[points * OBSERVED :].reshape((modes.shape[0] - points, spring.OBSERVED))
    fenders, reactions = model.elements[FENDER], work.holds.reaction
    observe(t, y, modes, motion, model.bodies, fenders, reactions, contact)
    spring.observe(modes, motion, model.bodies, model.elements[SPRING], pulls)
    for i in range(modes.shape[0]):
        assign(kept[i], modes[i])
    row[1] = wave_loads(t, model.waves, work.total, work.total)
    counters[RECORDS] += 1
