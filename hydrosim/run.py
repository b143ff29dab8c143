"""A run: steps on a fixed grid, cut at breakpoints and events, recorded at output times.

A step from t to t + h is one step of the method unless a contact mode ends inside it or a table
has a corner there. Then the step is cut: the end of the mode is located, the state is taken there
by the method itself, the mode switches, and the rest of the step follows. On every piece the right
hand side is smooth, so a method keeps its order through stick, slip and contact.

The loop calls `hydrosim.dynamics.rhs` by name: kernels that take functions as arguments would be
compiled anew in every process.
"""

from __future__ import annotations

from math import isfinite, prod
from typing import NamedTuple

import numpy as np

from hydrosim.dynamics import Model, rhs, stored_energies
from hydrosim.forces import FENDER
from hydrosim.forces.contact.fender import MARGINS, find_headings, margins, observe, switch
from hydrosim.integrate import (
    Control,
    Tableau,
    advance_state,
    between,
    error_norm,
    hermite,
    left_behind,
    phi,
    scaled,
    stage_state,
    step_factor,
)
from hydrosim.kernels import assign, kernel
from hydrosim.radiation.memory import VelocityHistory, push
from hydrosim.rigid import place_bodies
from hydrosim.waves.loads import wave_loads

PITCH = 4  # among a body's six coordinates
RUNNING, NOT_FINITE, CAPSIZED, CHATTERING, STEP_TOO_SMALL = range(5)
STEPS, REJECTED, RECORDS, EVENTS, EVALUATIONS, STATUS, COUNTERS = range(7)
END, FULL, SLOPE, STAGE = range(4)
BEFORE, AFTER, NOW, EARLY, LATE, TRIAL = range(6)
STEEPEST = 1.48  # rad (85 deg): beyond it the angles' rates lose their meaning
PIECES = 200  # events in one step, per contact point, after which it is called chattering
LANDED = 1e-10  # of a margin's range over the step: an event is located to this
SWITCHED = 1e-8  # margins this near to zero switch together
DIPS = 10  # times that a step is shortened in search of a mode that ends inside it
NEAR = 1e-4  # of a step: as far from its ends as slopes of margins are taken


class State(NamedTuple):
    """All that a run remembers: ``y``, contact ``modes`` (nf, 2), the velocity ``history``."""

    y: np.ndarray
    modes: np.ndarray
    history: VelocityHistory


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


class Scratch(NamedTuple):
    """Scratch of a step: stage derivatives ``k`` (s, ny), ``states`` (4, ny), ``margins`` (6, nm),
    ``pace`` (2,), the next adaptive step and the error of the last, and ``fresh`` (2,), not zero
    while k[0] is the slope at the current state, and the slope in ``states`` that at the end.

    The states are the end of the step, the end of the uncut step and the slope there, and a stage;
    the margins are those before and after the uncut step, at the place in question, near both ends
    and on trial.
    """

    k: np.ndarray
    states: np.ndarray
    margins: np.ndarray
    pace: np.ndarray
    fresh: np.ndarray
    headings: np.ndarray


class Record(NamedTuple):
    """What is kept at every output time: ``channels`` (nt, nc), see `channels`, and the contact
    ``modes`` (nt, nf, 2)."""

    channels: np.ndarray
    modes: np.ndarray


def new_scratch(model: Model, method: Tableau, clock: Clock) -> Scratch:
    """Scratch for this model and method."""
    nm, ny = MARGINS * model.elements[FENDER].points.size, model.size
    k, states, margins = np.zeros((method.b.size, ny)), np.zeros((4, ny)), np.zeros((6, nm))
    pace, headings = np.array([clock.pace, 1.0]), np.zeros((nm // MARGINS, 2))
    return Scratch(k, states, margins, pace, np.zeros(2, dtype=np.int64), headings)


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
        "contact": (model.elements[FENDER].points.size, 8),
    }


def new_record(model: Model, clock: Clock) -> Record:
    """Room for all output times, the first included."""
    nt = -(-clock.points // clock.every) + 1  # the end is recorded, on an output time or not
    width = sum(prod(shape) for shape in channels(model).values())
    nf = model.elements[FENDER].points.size
    return Record(np.zeros((nt, width)), np.zeros((nt, nf, 2), dtype=np.int64))


@kernel
def advance(first, count, clock, model, method, state, work, scratch, record, counters):
    """Go from grid point ``first`` over up to ``count`` more; stops early where
    ``counters[STATUS]`` says why.

    ``state`` is left where the last accepted piece ended. Returns the time that was reached.
    """
    t = grid_time(first, clock)
    if counters[RECORDS] == 0:
        remember(t, state, model.bodies, work.motion)
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
    fenders, bodies, motion = model.elements[FENDER], model.bodies, work.motion
    limit = PIECES * (1 + fenders.points.size)
    events = 0
    while t < goal and events <= limit and counters[STATUS] == RUNNING:
        stop = _breakpoint_after(t, goal, clock)
        if clock.control.adaptive:
            stop = min(stop, t + scratch.pace[0])
        _head(state, bodies, motion, fenders, scratch.headings)
        step(t, stop - t, model, method, state, work, scratch, counters)
        h = stop - t
        if clock.control.adaptive and not _accepted(t, h, clock, method, state, scratch, counters):
            continue
        reached, left = _cut(t, stop, clock, model, method, state, work, scratch, counters)
        t = reached
        counters[STEPS] += 1
        assign(state.y, scratch.states[END])
        _renew(left, scratch)
        if left:
            events += 1
            _switch(clock.events, t, state, bodies, motion, fenders, scratch.margins)
        _check(state.y, bodies, counters)
        remember(t, state, bodies, motion)
    if events > limit:
        counters[STATUS] = CHATTERING
    counters[EVENTS] += events
    return t


@kernel
def _cut(t, stop, clock, model, method, state, work, scratch, counters):
    """Cut the step from ``t`` to ``stop`` that was taken at its first event, if it has one. Returns
    the time at its end and whether a mode has ended there."""
    fenders, bodies, motion = model.elements[FENDER], model.bodies, work.motion
    end, after = scratch.states[END], scratch.margins[AFTER]
    left = _left(stop, end, state.modes, bodies, motion, fenders, scratch.headings, after)
    if after.size == 0 or not clock.events:
        return stop, left
    for _ in range(DIPS):  # what is below zero on the cubic need not be so in the method's step
        if left:
            stop = t + _land(t, stop - t, model, method, state, work, scratch, counters)
        part = _dip(t, stop - t, model, state, work, scratch, counters) if stop > t else 1.0
        if part == 1.0:
            return stop, left
        stop = t + part * (stop - t)
        step(t, stop - t, model, method, state, work, scratch, counters)
        left = _left(stop, end, state.modes, bodies, motion, fenders, scratch.headings, after)
    if left:
        stop = t + _land(t, stop - t, model, method, state, work, scratch, counters)
    scratch.fresh[1] = 0
    return stop, left


@kernel
def _accepted(t, h, clock, method, state, scratch, counters):
    """Judge a step by its error and set the pace of the next; a run whose steps shrink to nothing
    is stopped."""
    pace = scratch.pace
    error = error_norm(h, method, scratch.k, state.y, scratch.states[END], clock.control)
    factor = step_factor(error, pace[1], method.order)
    if error <= 1.0:
        cut = h < 0.999 * pace[0]  # by the grid or a breakpoint: no reason for a slower pace
        pace[0], pace[1] = max(factor * h, pace[0] if cut else 0.0), error
        return True
    pace[0] = factor * h
    counters[REJECTED] += 1
    if pace[0] < 1e-12 * max(abs(t), 1.0):
        counters[STATUS] = STEP_TOO_SMALL
    return False


@kernel
def remember(t, state, bodies, motion):
    """Add the velocities at ``t`` to the history, if a convolution needs one."""
    if state.history.time.size > 0:
        _place(state.y, bodies, motion)
        push(state.history, t, motion.velocity)


@kernel
def _breakpoint_after(t, goal, clock):
    k = np.searchsorted(clock.breakpoints, t, side="right")
    if k < clock.breakpoints.size and clock.breakpoints[k] < goal:
        return clock.breakpoints[k]
    return goal


@kernel
def step(t, h, model, method, state, work, scratch, counters):
    """One step of the method from ``state`` into ``scratch.states[END]``."""
    y, k, stage = state.y, scratch.k, scratch.states[STAGE]
    if scratch.fresh[0] == 0:
        rhs(t, y, state.modes, state.history, model, work, k[0])
        scratch.fresh[0] = 1
        counters[EVALUATIONS] += 1
    for i in range(1, method.c.size):
        stage_state(i, method, h, y, k, stage)
        rhs(t + method.c[i] * h, stage, state.modes, state.history, model, work, k[i])
    advance_state(method, h, y, k, scratch.states[END])
    counters[EVALUATIONS] += method.c.size - 1


@kernel
def _renew(left, scratch):
    """After a step: the slope at its end, where it is known and the modes stay, begins the next."""
    scratch.fresh[0] = 0
    if scratch.fresh[1] != 0 and not left:
        assign(scratch.k[0], scratch.states[SLOPE])
        scratch.fresh[0] = 1
    scratch.fresh[1] = 0


@kernel
def _dip(t, h, model, state, work, scratch, counters):
    """Where in a step, as a part of it, a margin that falls at first and rises at last is below
    zero on the cubic through both ends; 1 where none is.

    It is looked into if its tangents meet below zero: so a mode that ends and begins again within a
    step, or before another event, is not jumped over. Leaves the margins of the end in NOW.
    """
    fenders, bodies, motion = model.elements[FENDER], model.bodies, work.motion
    margin, end = scratch.margins, scratch.states[END]
    rhs(t + h, end, state.modes, state.history, model, work, scratch.states[SLOPE])
    counters[EVALUATIONS] += 1
    scratch.fresh[1] = 1
    assign(scratch.states[FULL], end)
    _left(t, state.y, state.modes, bodies, motion, fenders, scratch.headings, margin[BEFORE])
    _left(t + h, end, state.modes, bodies, motion, fenders, scratch.headings, margin[NOW])
    _on_cubic(NEAR, t, h, state, bodies, motion, fenders, scratch, margin[EARLY])
    _on_cubic(1.0 - NEAR, t, h, state, bodies, motion, fenders, scratch, margin[LATE])
    for i in range(margin.shape[1]):
        first, last = margin[BEFORE, i], margin[NOW, i]
        falling, rising = (margin[EARLY, i] - first) / NEAR, (last - margin[LATE, i]) / NEAR
        if falling < 0.0 < rising:
            meet = (last - rising - first) / (falling - rising)
            if first + falling * meet < 0.0:
                x = _deepest(i, t, h, state, bodies, motion, fenders, scratch)
                if x < 1.0:
                    return x
    return 1.0


@kernel
def _deepest(i, t, h, state, bodies, motion, fenders, scratch):
    """Place of a value below zero near the minimum of margin ``i`` on the cubic, by golden section;
    1 if there is none."""
    here, golden = scratch.margins[TRIAL], 0.6180339887498949
    lo, hi = 0.0, 1.0
    a, b = 1.0 - golden, golden
    _on_cubic(a, t, h, state, bodies, motion, fenders, scratch, here)
    f_a = here[i]
    _on_cubic(b, t, h, state, bodies, motion, fenders, scratch, here)
    f_b = here[i]
    for _ in range(40):
        if min(f_a, f_b) < 0.0:
            return a if f_a < f_b else b
        if f_a < f_b:
            hi, b, f_b = b, a, f_a
            a = hi - golden * (hi - lo)
            _on_cubic(a, t, h, state, bodies, motion, fenders, scratch, here)
            f_a = here[i]
        else:
            lo, a, f_a = a, b, f_b
            b = lo + golden * (hi - lo)
            _on_cubic(b, t, h, state, bodies, motion, fenders, scratch, here)
            f_b = here[i]
    return 1.0


@kernel
def _on_cubic(x, t, h, state, bodies, motion, fenders, scratch, out):
    """Margins on the cubic through both ends of the uncut step."""
    states, stage = scratch.states, scratch.states[STAGE]
    hermite(x, h, state.y, scratch.k[0], states[FULL], states[SLOPE], stage)
    _left(t + x * h, stage, state.modes, bodies, motion, fenders, scratch.headings, out)


@kernel
def _place(y, bodies, motion):
    n = bodies.active.size
    place_bodies(y[:n], y[n : 2 * n], bodies, motion)


@kernel
def _head(state, bodies, motion, fenders, headings):
    """Note where all points slip to at the start of a step."""
    if headings.size > 0:
        _place(state.y, bodies, motion)
        find_headings(state.y, state.modes, motion, bodies, fenders, headings)


@kernel
def _left(t, y, modes, bodies, motion, fenders, headings, out):
    """Margins of all contact modes at t, y; True if any mode has ended."""
    if out.size == 0:
        return False
    _place(y, bodies, motion)
    margins(t, y, modes, motion, bodies, fenders, headings, out)
    return left_behind(out)


@kernel
def _land(t, h, model, method, state, work, scratch, counters):
    """Cut the step of length ``h`` at its first event: the state there in ``states[END]``.

    The zero is sought on the cubic through both ends, and the difference between the method's own
    step and the cubic at that place is then taken off (a contraction of order h^3), within a
    bracket that always shrinks. Returns the length of the cut step.
    """
    fenders, bodies, motion = model.elements[FENDER], model.bodies, work.motion
    end = scratch.states[END]
    before, after, now = scratch.margins[BEFORE], scratch.margins[AFTER], scratch.margins[NOW]
    rhs(t + h, end, state.modes, state.history, model, work, scratch.states[SLOPE])
    counters[EVALUATIONS] += 1
    assign(scratch.states[FULL], end)
    _left(t, state.y, state.modes, bodies, motion, fenders, scratch.headings, before)
    lo, f_lo, hi, f_hi = 0.0, phi(before, before, after), 1.0, phi(after, before, after)
    x, on_cubic = _zero_on_cubic(0.0, t, h, state, bodies, motion, fenders, scratch)
    while True:
        step(t, x * h, model, method, state, work, scratch, counters)
        _left(t + x * h, end, state.modes, bodies, motion, fenders, scratch.headings, now)
        value = phi(now, before, after)
        if x == 0.0 or abs(value) <= LANDED or hi - lo < 1e-13:
            return x * h
        if value >= 0.0:
            lo, f_lo = x, value
        else:
            hi, f_hi = x, value
        defect = value - on_cubic
        x, on_cubic = _zero_on_cubic(defect, t, h, state, bodies, motion, fenders, scratch)
        if not lo < x < hi:
            x = between(lo, max(f_lo, 0.0), hi, f_hi)
            on_cubic = _phi_on_cubic(x, t, h, state, bodies, motion, fenders, scratch)


@kernel
def _zero_on_cubic(defect, t, h, state, bodies, motion, fenders, scratch):
    """First x in [0, 1] where phi on the cubic, plus ``defect``, turns negative, and phi there;
    zero if phi is never positive (a mode that ends as soon as it begins)."""
    before, after = scratch.margins[BEFORE], scratch.margins[AFTER]
    lo, f_lo = 0.0, phi(before, before, after) + defect
    hi, f_hi = 0.0, -1.0
    for j in range(1, 9):
        hi = (j / 8) ** 2  # closer together where a mode has just begun
        f_hi = _phi_on_cubic(hi, t, h, state, bodies, motion, fenders, scratch) + defect
        if f_hi < 0.0 <= f_lo:
            break
        lo, f_lo = hi, f_hi
    if not f_hi < 0.0 <= f_lo:
        return 0.0, f_lo - defect
    x, f = hi, f_hi
    for _ in range(60):
        if hi - lo < 1e-14 or abs(f) < 1e-13:
            break
        x = between(lo, f_lo, hi, f_hi)
        f = _phi_on_cubic(x, t, h, state, bodies, motion, fenders, scratch) + defect
        if f >= 0.0:
            lo, f_lo = x, f
        else:
            hi, f_hi = x, f
    return x, f - defect


@kernel
def _phi_on_cubic(x, t, h, state, bodies, motion, fenders, scratch):
    _on_cubic(x, t, h, state, bodies, motion, fenders, scratch, scratch.margins[NOW])
    return phi(scratch.margins[NOW], scratch.margins[BEFORE], scratch.margins[AFTER])


@kernel
def _switch(located, t, state, bodies, motion, fenders, margin):
    """Switch the modes that have ended at ``state.y``: all whose margin is zero there, or without
    location all whose margin is negative. One switch per point."""
    _place(state.y, bodies, motion)
    before, after, now = margin[BEFORE], margin[AFTER], margin[NOW]
    near = max(phi(now, before, after), 0.0) + SWITCHED
    for i in range(fenders.points.size):
        for which in range(MARGINS):
            m = MARGINS * i + which
            if after[m] >= 0.0 or (located and scaled(m, now, before, after) > near):
                continue
            switch(i, which, t, state.y, state.modes, motion, bodies, fenders)
            break


@kernel
def _check(y, bodies, counters):
    """Set the status where a number is not finite or a pitch angle is too steep."""
    n = bodies.active.size
    for j in range(y.size):
        if not isfinite(y[j]):
            counters[STATUS] = NOT_FINITE
        elif j < n and bodies.active[j] % 6 == PITCH and abs(y[j]) > STEEPEST and bodies.exact:
            counters[STATUS] = CAPSIZED


@kernel
def keep(t, model, state, work, scratch, record, counters):
    """Record the state and everything that follows from it, in the order of `channels`."""
    y, modes, motion = state.y, state.modes, work.motion
    row, kept = record.channels[counters[RECORDS]], record.modes[counters[RECORDS]]
    m, points = 6 * model.bodies.each.size, model.elements[FENDER].points.size
    at = 3 + y.size
    stored = row[at + 2 * m :]
    wrench = stored[model.rows :]
    row[2] = stored_energies(t, y, modes, model, work, stored[: model.rows])
    rhs(t, y, modes, state.history, model, work, scratch.states[STAGE])
    row[0] = t
    assign(row[3:], y)
    assign(row[at:], motion.coordinates)
    assign(row[at + m :], motion.velocity)
    for r in range(model.rows):
        assign(wrench[m * r :], work.wrench[r])
    contact = wrench[m * model.rows :].reshape((points, 8))
    observe(t, y, modes, motion, model.bodies, model.elements[FENDER], contact)
    for i in range(points):
        assign(kept[i], modes[i])
    row[1] = wave_loads(t, model.waves, work.total, work.total)
    counters[RECORDS] += 1
