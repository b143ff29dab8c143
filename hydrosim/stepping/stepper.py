"""One step of a method from a state; what a run remembers, and the scratch of its steps.

The stages call `dynamics.rhs` by name: kernels that take functions as arguments would be compiled
anew in every process.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.forces import FENDER, new_modes
from hydrosim.forces.contact.modes import MARGINS
from hydrosim.integrate import (
    Control,
    Newton,
    Tableau,
    advance_state,
    improve,
    new_newton,
    prepare,
    stage_state,
)
from hydrosim.integrate.implicit import ITERATIONS, READY, SLOW, STALE
from hydrosim.jit.kernels import assign, kernel, root
from hydrosim.radiation.history import VelocityHistory
from hydrosim.stepping.dynamics import Model, dynamic_states, jacobian, rhs

RUNNING, NOT_FINITE, CAPSIZED, CHATTERING, STEP_TOO_SMALL, NO_SOLUTION = range(6)
STEPS, REJECTED, RECORDS, EVENTS, EVALUATIONS, STATUS, COUNTERS = range(7)
END, FULL, SLOPE, STAGE, SPARE = range(5)
UNKNOWN, BUT_FOR_SLIP, KNOWN = range(3)
BEFORE, AFTER, NOW, EARLY, LATE, TRIAL = range(6)
EVERY, SOME = range(2)
INSIDE = 1e-15  # of the time: what a corner is seen from inside by
SMALL = 1e-7  # of differences of states for the Jacobian: m, rad and their rates


class State(NamedTuple):
    """All that a run remembers: ``y``, the ``modes`` (nf + ns, 3) of contacts and springs, the
    velocity ``history``."""

    y: np.ndarray
    modes: np.ndarray
    history: VelocityHistory


class Scratch(NamedTuple):
    """Scratch of a step: stage derivatives ``k`` (s, ny), ``states`` (5, ny), ``margins`` (6, nm),
    ``pace`` (2,), the next adaptive step and the error of the last, and ``fresh`` (3,), not zero
    while k[0] is the slope at the current state, and the slope in ``states`` that at the end; then
    whether the margins before the step are known.

    The states are the end of the step, the end of the uncut step and the slope there, a stage, and
    one to spare; the margins are those before and after the uncut step, at the place in question,
    near both ends and on trial; ``watched`` (2, rows of modes) is not zero where these are wanted,
    of every row and of some; ``headings`` (nf, 2) are those of slip at the start of the step.
    """

    k: np.ndarray
    states: np.ndarray
    margins: np.ndarray
    watched: np.ndarray
    pace: np.ndarray
    fresh: np.ndarray
    headings: np.ndarray
    newton: Newton
    control: Control


def new_scratch(model: Model, method: Tableau, control: Control, pace: float) -> Scratch:
    """Scratch for this model and method; adaptive steps begin with ``pace`` [s]."""
    nf, ny = model.elements[FENDER].points.size, model.size
    implicit = bool(np.diag(method.a).any())
    unknown = dynamic_states(model) if implicit else np.zeros(0, dtype=np.int64)
    rows = len(new_modes(model.elements))
    watched = np.zeros((2, rows), dtype=np.int64)
    watched[EVERY] = 1
    return Scratch(
        np.zeros((method.b.size, ny)),
        np.zeros((5, ny)),
        np.zeros((6, MARGINS * rows)),
        watched,
        np.array([pace, 1.0]),
        np.zeros(3, dtype=np.int64),
        np.zeros((nf, 2)),
        new_newton(unknown, ny),
        control,
    )


@root
def step(t, h, model, method, state, work, scratch, counters):
    """One step of the method from ``state`` into ``scratch.states[END]``.

    Its end is seen from inside, a few roundings early: a rate may jump there.
    """
    y, k, stage, last = state.y, scratch.k, scratch.states[STAGE], (t + h) * (1.0 - INSIDE)
    if scratch.fresh[0] == 0:
        rhs(t, y, state.modes, state.history, model, work, k[0])
        scratch.fresh[0] = 1
        counters[EVALUATIONS] += 1
    for i in range(1, method.c.size):
        stage_state(i, method, h, y, k, stage)
        at, weight = min(t + method.c[i] * h, last), h * method.a[i, i]
        if weight == 0.0:
            rhs(at, stage, state.modes, state.history, model, work, k[i])
            counters[EVALUATIONS] += 1
        else:
            _solve_stage(i, at, weight, model, state, work, scratch, counters)
    advance_state(method, h, y, k, scratch.states[END])


@kernel
def _solve_stage(i, t, weight, model, state, work, scratch, counters):
    """Find k[i] = f(t, stage + weight k[i]); a second time with a new Jacobian if it must be."""
    newton = scratch.newton
    for _ in range(2):
        if newton.status[0] == STALE:
            y, modes, history = state.y, state.modes, state.history
            states, room, J = newton.states, newton.shifted, newton.J
            jacobian(t, y, modes, history, model, work, states, SMALL, room, J)
            counters[EVALUATIONS] += 2 * states.size
            newton.weight[0] = 0.0
            newton.status[0] = READY
        if newton.weight[0] != weight:
            prepare(weight, newton)
        if _iterate(i, t, weight, model, state, work, scratch, counters):
            return
        newton.status[0] = STALE
    counters[STATUS] = NO_SOLUTION


@kernel
def _iterate(i, t, weight, model, state, work, scratch, counters):
    """Newton's iterations for k[i] from k[i - 1]; True if they converge."""
    k, stage = scratch.k, scratch.states[STAGE]
    guess, f = scratch.states[END], scratch.states[SPARE]
    assign(k[i], k[i - 1])
    for n in range(ITERATIONS):
        for m in range(guess.size):
            guess[m] = stage[m] + weight * k[i, m]
        rhs(t, guess, state.modes, state.history, model, work, f)
        counters[EVALUATIONS] += 1
        if improve(k[i], f, state.y, weight, scratch.newton, scratch.control) <= 1.0:
            if n >= SLOW:
                scratch.newton.status[0] = STALE
            return True
    return False
