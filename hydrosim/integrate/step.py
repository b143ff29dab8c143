"""One step of a method from a state.

The stages call `dynamics.rhs` by name: kernels that take functions as arguments would be compiled
again in every process.
"""

from __future__ import annotations

from hydrosim.elements.events import has_load_friction
from hydrosim.integrate import methods
from hydrosim.integrate.dynamics import fill_jacobian, may_hold, rhs
from hydrosim.integrate.state import (
    AT_START,
    END,
    END_SLOPE,
    EVALUATIONS,
    NO_SOLUTION,
    SPARE,
    STAGE,
    START_SLOPE,
    STATUS,
)
from hydrosim.jit.kernels import assign, kernel, root

CORNER_OFFSET = 1e-15  # of the time: distance from a corner at which it is evaluated from inside
JACOBIAN_OFFSET = 1e-7  # of differences of states for the Jacobian: m, rad and their rates


@root
def take_step(t, h, run):
    """One step of the method from ``run.state`` into ``scratch.states[END]``.

    Its end is evaluated from inside, a few roundings early: a rate may jump there.
    """
    y, k, method, scratch = run.state.y, run.scratch.k, run.method, run.scratch
    stage, last = scratch.states[STAGE], (t + h) * (1.0 - CORNER_OFFSET)
    if scratch.step_cache[START_SLOPE] == 0:
        find_start_slope(t, run)
    for i in range(1, method.c.size):
        methods.stage_state(i, method, h, y, k, stage)
        at, weight = min(t + method.c[i] * h, last), h * method.a[i, i]
        if weight == 0.0:
            find_slope(at, stage, run, k[i])
        else:
            _solve_stage(i, at, weight, run)
            if run.counters[STATUS] == NO_SOLUTION:
                return
    methods.advance_state(method, h, y, k, scratch.states[END])
    scratch.step_cache[END_SLOPE] = 0


@kernel
def knows_end_slope(run):
    """True if the last slope of a step is the slope at its end, and no reactions are needed there,
    as they are if points may be held."""
    return run.method.closes and not may_hold(run.state.modes, run.model, run.work)


@kernel
def find_start_slope(t, run):
    """The slope at the current state into k[0], with the reactions there."""
    find_slope(t, run.state.y, run, run.scratch.k[0])
    run.scratch.step_cache[START_SLOPE] = 1
    keep_reactions(AT_START, run)


@kernel
def keep_reactions(which, run):
    """Keep the reactions of the last evaluation."""
    reactions = run.scratch.reactions[which]
    solved_reactions = run.work.holds.reaction
    for i in range(solved_reactions.shape[0]):
        reactions[i, 0] = solved_reactions[i, 0]
        reactions[i, 1] = solved_reactions[i, 1]


@kernel
def is_held(run):
    """True if anything is held now, or friction grows with loads; otherwise all reactions are
    zero."""
    return run.work.constraints.number[0] > 0 or has_load_friction(run.model.elements)


@kernel
def find_slope(t, y, run, dy):
    """Fill ``dy`` = y'(t) with the modes and history of the run."""
    rhs(t, y, run.state.modes, run.state.history, run.model, run.work, dy)
    run.counters[EVALUATIONS] += 1


@root
def _solve_stage(i, t, weight, run):
    """Find k[i] = f(t, stage + weight k[i]); retried with a new Jacobian if necessary."""
    newton, state = run.scratch.newton, run.state
    for _ in range(2):
        if newton.status[0] == methods.STALE:
            y, modes, history = state.y, state.modes, state.history
            states, shifts, room, J = newton.states, newton.shifts, newton.shifted, newton.J
            model, work, offset = run.model, run.work, JACOBIAN_OFFSET
            fill_jacobian(t, y, modes, history, model, work, states, shifts, offset, room, J)
            run.counters[EVALUATIONS] += 2 * states.size
            newton.weight[0] = 0.0
            newton.status[0] = methods.READY
        if newton.weight[0] != weight:
            methods.factorise_iteration_matrix(weight, newton)
        if _iterate_stage(i, t, weight, run):
            return
        newton.status[0] = methods.STALE
    run.counters[STATUS] = NO_SOLUTION


@kernel
def _iterate_stage(i, t, weight, run):
    """Newton's iterations for k[i] from k[i - 1]; True if they converge."""
    scratch = run.scratch
    k, stage = scratch.k, scratch.states[STAGE]
    guess, f = scratch.states[END], scratch.states[SPARE]
    assign(k[i], k[i - 1])
    for n in range(methods.MAX_ITERATIONS):
        for m in range(guess.size):
            guess[m] = stage[m] + weight * k[i, m]
        find_slope(t, guess, run, f)
        if (
            methods.newton_iteration(
                k[i], f, run.state.y, weight, scratch.newton, run.clock.control
            )
            <= 1.0
        ):
            if n >= methods.SLOW_ITERATIONS:
                scratch.newton.status[0] = methods.STALE
            return True
    return False
