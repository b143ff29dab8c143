"""A run: steps on a fixed grid, cut at breakpoints and events, recorded at output times.

A step from t to t + h is one step of the method unless a contact mode ends inside it or a table
has a corner there. Then the step is cut: the end of the mode is located, the state is taken there
by the method itself, the mode switches, and the rest of the step follows. On every piece the right
hand side is smooth, so a method keeps its order through stick, slip and contact.

The loop calls `hydrosim.dynamics.rhs` by name: kernels that take functions as arguments would be
compiled anew in every process.
"""

from __future__ import annotations

from math import isfinite
from typing import NamedTuple

import numpy as np

from hydrosim.dynamics import Model, Work, rhs, stored_energies
from hydrosim.forces import FENDER
from hydrosim.forces.contact.fender import MARGINS, margins, observe, switch
from hydrosim.integrate import (
    Tableau,
    advance_state,
    between,
    hermite,
    left_behind,
    phi,
    scaled,
    stage_state,
)
from hydrosim.kernels import assign, kernel
from hydrosim.radiation.memory import VelocityHistory, push
from hydrosim.rigid import place_bodies
from hydrosim.waves.loads import wave_loads

RUNNING, NOT_FINITE, CAPSIZED, CHATTERING = range(4)
STEPS, RECORDS, EVENTS, EVALUATIONS, STATUS = range(5)
STEEPEST = 1.48  # rad (85 deg): beyond it the angles' rates lose their meaning
PIECES = 200  # events in one step, per contact point, after which it is called chattering
LANDED = 1e-10  # of a margin's range over the step: an event is located to this
SWITCHED = 1e-8  # margins this near to zero switch together


class State(NamedTuple):
    """All that a run remembers: ``y``, contact ``modes`` (nf, 2), the velocity ``history``."""

    y: np.ndarray
    modes: np.ndarray
    history: VelocityHistory


class Clock(NamedTuple):
    """Grid of ``steps`` steps from ``start`` to ``end`` [s]; every ``every``-th is recorded;
    ``breakpoints`` are times that no step may cross; ``events`` false lets steps run past them."""

    start: float
    step: float
    end: float
    steps: int
    every: int
    breakpoints: np.ndarray
    events: bool


class Scratch(NamedTuple):
    """Scratch of a step: stage derivatives ``k`` (s, ny), states, slope, margins."""

    k: np.ndarray
    stage: np.ndarray
    end: np.ndarray
    full: np.ndarray
    slope: np.ndarray
    before: np.ndarray
    after: np.ndarray
    now: np.ndarray


class Record(NamedTuple):
    """What is kept at every output time; see the names in `hydrosim.output`."""

    time: np.ndarray
    y: np.ndarray
    modes: np.ndarray
    coordinates: np.ndarray
    velocity: np.ndarray
    wrench: np.ndarray
    stored: np.ndarray
    kinetic: np.ndarray
    elevation: np.ndarray
    contact: np.ndarray


def new_scratch(model: Model, method: Tableau) -> Scratch:
    """Scratch for this model and method."""
    states = [np.zeros(model.size) for _ in range(4)]
    nm = MARGINS * model.elements[FENDER].body.size
    return Scratch(np.zeros((method.b.size, model.size)), *states, *(np.zeros((3, nm))))


def new_record(model: Model, clock: Clock) -> Record:
    """Room for all output times, the first included."""
    nt = clock.steps // clock.every + 1
    m, nf = 6 * model.bodies.mass.size, model.elements[FENDER].body.size
    return Record(
        np.zeros(nt),
        np.zeros((nt, model.size)),
        np.zeros((nt, nf, 2), dtype=np.int64),
        np.zeros((nt, m)),
        np.zeros((nt, m)),
        np.zeros((nt, model.rows, m)),
        np.zeros((nt, model.rows)),
        np.zeros(nt),
        np.zeros(nt),
        np.zeros((nt, nf, 8)),
    )


@kernel
def advance(count, clock, model, method, state, work, scratch, record, counters):
    """Take up to ``count`` steps of the grid; stops early where ``counters[STATUS]`` says why.

    ``state`` is where the last accepted piece ended; ``scratch.now[...]`` is of no meaning after.
    Returns the time that was reached.
    """
    t = grid_time(counters[STEPS], clock)
    if counters[RECORDS] == 0:
        remember(t, model, state, work)
        keep(t, model, state, work, scratch, record, counters)
    for _ in range(min(count, clock.steps - counters[STEPS])):
        t = _cross(t, clock, model, method, state, work, scratch, counters)
        if counters[STATUS] != RUNNING:
            return t
        counters[STEPS] += 1
        if counters[STEPS] % clock.every == 0:
            keep(t, model, state, work, scratch, record, counters)
    return t


@kernel
def grid_time(n, clock):
    """Time of grid point ``n``; the last one is the end of the run."""
    return min(clock.start + n * clock.step, clock.end)


@kernel
def _cross(t, clock, model, method, state, work, scratch, counters):
    """Go to the next point of the grid, piece by piece; returns the time reached."""
    goal = grid_time(counters[STEPS] + 1, clock)
    limit = PIECES * (1 + state.modes.shape[0])
    events = 0
    while t < goal:
        stop = _breakpoint_after(t, goal, clock)
        h = stop - t
        step(t, h, model, method, state, work, scratch, counters)
        left = _margins(scratch.end, scratch.after, model, state, work)
        if left and clock.events:
            h = _land(t, h, model, method, state, work, scratch, counters)
            stop = t + h
        t = stop
        assign(state.y, scratch.end)
        _check(state.y, model, counters)
        if left:
            events += 1
            _switch(clock.events, model, state, work, scratch)
        if events > limit:
            counters[STATUS] = CHATTERING
        if counters[STATUS] != RUNNING:
            break
        remember(t, model, state, work)
    counters[EVENTS] += events
    return t


@kernel
def remember(t, model, state, work):
    """Add the velocities at ``t`` to the history, if a convolution needs one."""
    if state.history.time.size > 0:
        _place(state.y, model, work)
        push(state.history, t, work.motion.velocity)


@kernel
def _breakpoint_after(t, goal, clock):
    k = np.searchsorted(clock.breakpoints, t, side="right")
    if k < clock.breakpoints.size and clock.breakpoints[k] < goal:
        return clock.breakpoints[k]
    return goal


@kernel
def step(t, h, model, method, state, work, scratch, counters):
    """One step of the method from ``state`` into ``scratch.end``."""
    y, k = state.y, scratch.k
    rhs(t, y, state.modes, state.history, model, work, k[0])
    for i in range(1, method.c.size):
        stage_state(i, method, h, y, k, scratch.stage)
        rhs(t + method.c[i] * h, scratch.stage, state.modes, state.history, model, work, k[i])
    advance_state(method, h, y, k, scratch.end)
    counters[EVALUATIONS] += method.c.size


@kernel
def _margins(y, out, model, state, work):
    """Margins of all contact modes at ``y``; True if any mode has ended."""
    if out.size == 0:
        return False
    _place(y, model, work)
    margins(y, state.modes, work.motion, model.bodies, model.elements[FENDER], out)
    return left_behind(out)


@kernel
def _place(y, model, work):
    n = model.bodies.active.size
    place_bodies(y[:n], y[n : 2 * n], model.bodies, work.motion)


@kernel
def _land(t, h, model, method, state, work, scratch, counters):
    """Cut the step of length ``h`` at its first event: the state there in ``scratch.end``.

    The zero is sought on the cubic through both ends, and the difference between the method's own
    step and the cubic at that place is then taken off (a contraction of order h^3). Returns the
    length of the cut step.
    """
    rhs(t + h, scratch.end, state.modes, state.history, model, work, scratch.slope)
    counters[EVALUATIONS] += 1
    assign(scratch.full, scratch.end)
    _margins(state.y, scratch.before, model, state, work)
    defect, x = 0.0, 0.0
    for _ in range(5):
        x, on_cubic = _zero_on_cubic(defect, h, model, state, work, scratch)
        step(t, x * h, model, method, state, work, scratch, counters)
        _margins(scratch.end, scratch.now, model, state, work)
        value = phi(scratch.now, scratch.before, scratch.after)
        if x == 0.0 or abs(value) <= LANDED:
            break
        defect = value - on_cubic
    return x * h


@kernel
def _zero_on_cubic(defect, h, model, state, work, scratch):
    """First x in [0, 1] where phi on the cubic, plus ``defect``, turns negative, and phi there;
    zero if phi is never positive (a mode that ends as soon as it begins)."""
    lo, f_lo = 0.0, phi(scratch.before, scratch.before, scratch.after) + defect
    hi, f_hi = 0.0, -1.0
    for j in range(1, 9):
        hi = j / 8
        f_hi = _phi_on_cubic(hi, h, model, state, work, scratch) + defect
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
        f = _phi_on_cubic(x, h, model, state, work, scratch) + defect
        if f >= 0.0:
            lo, f_lo = x, f
        else:
            hi, f_hi = x, f
    return x, f - defect


@kernel
def _phi_on_cubic(x, h, model, state, work, scratch):
    hermite(x, h, state.y, scratch.k[0], scratch.full, scratch.slope, scratch.stage)
    _margins(scratch.stage, scratch.now, model, state, work)
    return phi(scratch.now, scratch.before, scratch.after)


@kernel
def _switch(located, model, state, work, scratch):
    """Switch the modes that have ended at ``state.y``: all whose margin is zero there, or without
    location all whose margin is negative. One switch per point."""
    p = model.elements[FENDER]
    _place(state.y, model, work)
    smallest = phi(scratch.now, scratch.before, scratch.after) if located else 0.0
    for i in range(p.body.size):
        for which in range(MARGINS):
            m = MARGINS * i + which
            if scratch.after[m] >= 0.0:
                continue
            near = max(smallest, 0.0) + SWITCHED
            if located and scaled(m, scratch.now, scratch.before, scratch.after) > near:
                continue
            switch(i, which, state.y, state.modes, work.motion, model.bodies, p)
            break


@kernel
def _check(y, model, counters):
    """Set the status where a number is not finite or a pitch angle is too steep."""
    n = model.bodies.active.size
    for j in range(2 * n):
        if not isfinite(y[j]):
            counters[STATUS] = NOT_FINITE
            return
        if j < n and model.bodies.active[j] % 6 == 4 and abs(y[j]) > STEEPEST:
            if model.bodies.exact:
                counters[STATUS] = CAPSIZED


@kernel
def keep(t, model, state, work, scratch, record, counters):
    """Record the state and everything that follows from it."""
    r, y, modes = counters[RECORDS], state.y, state.modes
    record.time[r] = t
    assign(record.y[r], y)
    for i in range(modes.shape[0]):
        record.modes[r, i, 0], record.modes[r, i, 1] = modes[i, 0], modes[i, 1]
    record.kinetic[r] = stored_energies(t, y, modes, model, work, record.stored[r])
    rhs(t, y, modes, state.history, model, work, scratch.stage)
    assign(record.coordinates[r], work.motion.coordinates)
    assign(record.velocity[r], work.motion.velocity)
    for row in range(model.rows):
        assign(record.wrench[r, row], work.wrench[row])
    bodies, elements = model.bodies, model.elements
    observe(y, modes, work.motion, bodies, elements[FENDER], record.contact[r])
    record.elevation[r] = wave_loads(t, model.waves, work.total, work.total)
    counters[RECORDS] += 1
