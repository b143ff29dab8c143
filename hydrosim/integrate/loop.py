"""A run: steps on a fixed grid, cut at breakpoints and events, recorded at output times.

A step from t to t + h is one step of the method unless a contact mode ends inside it or a table has
a corner there. Then the step is cut at the located end of the mode. The method itself computes the
state there, the mode switches, and the rest of the step follows (see `event_location`).
"""

from __future__ import annotations

import numpy as np

from hydrosim.elements import events
from hydrosim.integrate import event_location
from hydrosim.integrate import state as states
from hydrosim.integrate.constraint_projection import project_state
from hydrosim.integrate.dynamics import may_hold, project_velocities, update_contents
from hydrosim.integrate.methods import error_norm, step_factor
from hydrosim.integrate.record import write_record
from hydrosim.integrate.step import find_start_slope, knows_end_slope, take_step
from hydrosim.jit.kernels import assign, clear, kernel, root, root_giving, summing
from hydrosim.multibody.heading import accelerations_in_heading
from hydrosim.multibody.kinematics import LARGEST_TILT, accelerations, place_bodies
from hydrosim.multibody.tree import switch_rotation_chart
from hydrosim.tanks.pumping import share_of_step
from hydrosim.tanks.surface import find_clearances, first_passage
from hydrosim.water.radiation.history import append_node, recount_integrals, remove_newest_node
from hydrosim.water.slow_path_loads import BLOCK_BEGIN, begin_block

PITCH_DOF = 4  # among a body's six coordinates
MIN_PITCH_COSINE = 0.087  # cosine of that angle
RELAXATION_PARTS = 3  # of a step, while a contact node relaxes fast after an event
MIN_STEP = 1e-12  # s, or relative to the time: smallest step of an adaptive method
MAX_EVENTS_PER_INTERVAL = (
    200  # events in one step, per contact point or spring: more are chattering
)
MAX_STEPS_PER_INTERVAL = 200_000  # steps in the time of one: with more, no step is small enough


@root_giving(float)
def advance(evaluations, run):
    """Continue for this number of evaluations of the right hand side and margins, until the present
    step is complete. Ends early with the run, or if ``counters[STATUS]`` is set.

    ``run.state`` is left where the last accepted piece ended. Returns the time reached.
    """
    return advance_until(evaluations, np.inf, run)


@root_giving(float)
def advance_until(evaluations, until, run):
    """`advance`, but not beyond the time ``until``. A step is cut there if that is between two
    points of the grid; the rest of it follows at the next call."""
    clock = run.clock
    counters = run.counters
    pace = run.scratch.pace
    enough = count_evaluations(counters) + evaluations
    if counters[states.RECORDS] == 0:
        t = grid_time(0, clock)
        pace[states.REACHED_TIME] = pace[states.PROGRESS_TIME] = t
        if clock.block > 0:
            _begin_block(t, run)
        event_location.make_consistent(t, run)
        if events.has_sampled_functions(run.model.elements):
            take_samples(t, False, run)
        append_velocity_history(t, run)
        write_record(t, run)
    while counters[states.GRID_POINT] < clock.points and count_evaluations(counters) < enough:
        goal = grid_time(counters[states.GRID_POINT] + 1, clock)
        _advance_to_gridpoint(min(goal, until), enough, run)
        if counters[states.STATUS] != states.IN_PROGRESS or pace[states.REACHED_TIME] < goal:
            break
        counters[states.GRID_POINT] += 1
        n = counters[states.GRID_POINT]
        if clock.block > 0 and (clock.first + n) % clock.block == 0:
            _next_block(goal, run)
        if n % clock.every == 0 or n == clock.points:
            write_record(goal, run)
    return pace[states.REACHED_TIME]


@kernel
def count_evaluations(counters):
    """Cost of a run: evaluations of the right hand side plus evaluations of margins."""
    return counters[states.EVALUATIONS] + counters[states.GUARD_EVALUATIONS]


@root
def _next_block(t, run):
    """Renew the slow paths in waves at t. Loads jump here. Store the acceleration that a run
    starting at t would have."""
    model = run.model
    cache = run.scratch.step_cache
    begin_block(t, run.state.y[model.slow :], model.following)
    cache[states.START_SLOPE] = 0
    cache[states.START_MARGINS] = states.STALE
    if remove_newest_node(t, run.state.history):
        append_velocity_history(t, run)


@root
def _begin_block(t, run):
    """Keep the paths that a run starts with if the next ones are due before these end."""
    clock = run.clock
    p = run.model.following
    missing = clock.block - clock.first % clock.block
    begun = run.state.y[run.model.slow + BLOCK_BEGIN]
    if t + missing * clock.step > begun + p.block * (1.0 + 1e-9):
        _next_block(t, run)


@kernel
def grid_time(n, clock):
    """Time of grid point ``n``; the last one is the end of the run."""
    return min(clock.start + (clock.first + n) * clock.step, clock.end)


@root
def _advance_to_gridpoint(goal, enough, run):
    """Advance to the time ``goal``, piece by piece, but not beyond ``enough`` evaluations."""
    clock = run.clock
    state = run.state
    scratch = run.scratch
    counters = run.counters
    t = scratch.pace[states.REACHED_TIME]
    events.begin_drives(t, run.model.elements, run.work.holds)
    while (
        t < goal
        and count_evaluations(counters) < enough
        and counters[states.STATUS] == states.IN_PROGRESS
    ):
        stop = _breakpoint_after(t, goal, clock)
        paced = t + _adapt_step(t, stop - t, run)
        if stop - paced > rounding_of_step(t, stop):
            stop = paced
        recount_integrals(state.history)
        accepted, reached, left = _attempt_step(t, stop, run)
        if not accepted:
            counters[states.REJECTED] += 1
            continue
        t = _round_event(t, reached, stop) if left else reached
        counters[states.ACCEPTED] += 1
        assign(state.y, scratch.states[states.END])
        if events.stores_step_values(run.model.elements):
            _record_largest(t, run)
        _reuse_end_slope(t, left, run)
        events.follow_drives(t, state.y, run.model.bodies, run.model.elements, run.work.holds)
        if events.any_joints(run.model.elements):
            project_state(t, run)
        if left:
            counters[states.EVENTS] += 1
            append_velocity_history(t, run)  # as it was before the event
            event_location.switch_modes(t, run)
        elif run.work.constraints.force.size > events.joint_rows(run.model.elements):
            project_velocities(state.y, state.modes, run.model, run.work)
        check(state.y, run.model, counters)
        if run.model.bodies.tree.branches.size > 0:
            _check_joints(run)
        if (
            events.has_sampled_functions(run.model.elements)
            and counters[states.STATUS] == states.IN_PROGRESS
        ):
            take_samples(t, left, run)
        append_velocity_history(t, run)
        _check_progress(t, run)
    scratch.pace[states.REACHED_TIME] = t


@kernel
def rounding_of_step(t, stop):
    """Time [s] that is rounding beside a step from ``t`` to ``stop``: no step is that short."""
    return max(states.STEP_ROUNDING * (stop - t), states.TIME_ROUNDING * abs(stop))


@kernel
def _round_event(t, reached, stop):
    """The time ``reached`` by a step that an event has cut. Within rounding of its start or its
    ``stop`` it is that time."""
    near = rounding_of_step(t, stop)
    if stop - reached <= near:
        return stop
    return reached if reached - t > near else t


@root
def _record_largest(t, run):
    """Store values that a record would miss between output times."""
    y = run.state.y
    model = run.model
    motion = run.work.motion
    n = model.bodies.active.size
    place_bodies(y[:n], y[n : 2 * n], model.bodies, motion)
    watched = run.scratch.watched[states.MAY_END]
    events.record_largest(t, y, run.state.modes, motion, model.bodies, model.elements, watched)


@root
def take_samples(t, jumped, run):
    """Call the functions that are called once per step, at its end; motions may have ``jumped``
    there. Loads jump, so the known slope is of no use."""
    y = run.state.y
    model = run.model
    motion = run.work.motion
    n = model.bodies.active.size
    place_bodies(y[:n], y[n : 2 * n], model.bodies, motion)
    wrench = run.work.wrench
    ahead = min(_adapt_step(t, run.clock.step, run), run.clock.step)
    elements = model.elements
    if not events.sample_user_functions(
        t, jumped, ahead, y, motion, model.bodies, elements, wrench
    ):
        run.counters[states.STATUS] = states.NO_SAMPLE
    run.scratch.step_cache[states.START_SLOPE] = 0


@kernel
def _check_progress(t, run):
    """Stop a run that makes no progress: too many modes have ended, or too many steps were taken,
    in the time of one step of the solver."""
    counters = run.counters
    pace = run.scratch.pace
    if t - pace[states.PROGRESS_TIME] > run.clock.solver_step:
        pace[states.PROGRESS_TIME] = t
        clear(run.scratch.switches)
        counters[states.EARLIER_EVENTS] = counters[states.EVENTS]
        counters[states.EARLIER_STEPS] = counters[states.ACCEPTED] + counters[states.REJECTED]
    if counters[states.EVENTS] - counters[states.EARLIER_EVENTS] > MAX_EVENTS_PER_INTERVAL * (
        1 + run.state.modes.shape[0]
    ):
        counters[states.STATUS] = states.CHATTERING
    if (
        counters[states.ACCEPTED] + counters[states.REJECTED] - counters[states.EARLIER_STEPS]
        > MAX_STEPS_PER_INTERVAL
    ):
        counters[states.STATUS] = states.STEP_TOO_SMALL


@root_giving(bool, float, bool)
def _attempt_step(t, stop, run):
    """Try a step from ``t`` to ``stop``. Returns true if it is accepted, its end (at its first
    event, if any), and true if a mode has ended there."""
    clock = run.clock
    counters = run.counters
    if run.scratch.headings.size > 0:
        event_location.store_slip_directions(t, run)
    take_step(t, stop - t, run)
    located = clock.events and not clock.control.adaptive
    if (
        located
        and run.model.liquids.each.size > 0
        and counters[states.STATUS] == states.IN_PROGRESS
    ):
        stop = _cut_at_corner(t, stop, run)
    if clock.control.adaptive and not _is_accepted(t, stop - t, run):
        return False, t, False
    left = False
    if counters[states.STATUS] == states.IN_PROGRESS:
        stop, left = event_location.truncate_at_event(t, stop, clock.events, run)
    accepted = counters[states.STATUS] == states.IN_PROGRESS
    if not accepted:
        _shorten_step(t, 0.5 * (stop - t), run)
    return accepted, stop, left


@root_giving(float)
def _cut_at_corner(t, stop, run):
    """Cut the step where the surface in a tank passes a corner, because moments have few
    derivatives there. The position is interpolated linearly over the step: its error is of second
    order in the step, and its effect of fifth order."""
    clearances = run.work.clearances
    _find_clearances(run.state.y, run, clearances[0])
    _find_clearances(run.scratch.states[states.END], run, clearances[1])
    part = first_passage(clearances[0], clearances[1])
    if part < 1.0:
        stop = t + part * (stop - t)
        take_step(t, stop - t, run)
    return stop


@kernel
def _find_clearances(y, run, out):
    model = run.model
    work = run.work
    n = model.bodies.active.size
    place_bodies(y[:n], y[n : 2 * n], model.bodies, work.motion)
    update_contents(y, model, work)
    heights = work.contents.height
    find_clearances(y, work.motion, model.bodies, model.tanks, model.liquids, heights, out)


@kernel
def _adapt_step(t, whole, run):
    """Length of the next step; beyond the ``whole`` time to the next stop, the step ends there.
    Loads that no motion shows are followed by equal parts of that time."""
    clock = run.clock
    planned = _planned_step(t, whole, run)
    h = min(planned, whole)
    longest = clock.signal_step
    if h > clock.held_step and events.has_load_limit(run.state.modes, run.model.elements):
        longest = clock.held_step
    if h <= longest:
        return planned
    parts = np.ceil(whole / longest * (1.0 - states.STEP_ROUNDING))
    return whole / parts if parts > 1.0 else 2.0 * whole


@kernel
def _planned_step(t, h, run):
    """Length of the next step, if not the whole ``h``: from the control of an adaptive method, or a
    fraction of a step while a contact node settles after an event or a tank runs empty or full."""
    clock = run.clock
    tanks = run.model.tanks
    if clock.control.adaptive:
        h = run.scratch.pace[states.NEXT_STEP]
    if tanks.flows.size > 0:
        share = share_of_step(clock.step, run.state.y, run.state.modes, tanks)
        if share < 1.0:
            h = min(h, share * clock.step)
    if clock.control.adaptive:
        return h
    part = clock.step / RELAXATION_PARTS
    if h > 1.1 * part and events.has_fast_transient(t, run.state.y, run.model.elements):
        return part  # avoids a very short remaining step
    return h


@root_giving(bool)
def _is_accepted(t, h, run):
    """Accept or reject a step by its error and set the length of the next. A run whose steps shrink
    to zero is stopped. Stages without a solution count as an infinite error."""
    method = run.method
    scratch = run.scratch
    pace = run.scratch.pace
    counters = run.counters
    y = run.state.y
    end = scratch.states[states.END]
    error = np.inf
    if counters[states.STATUS] == states.IN_PROGRESS:
        error = error_norm(h, method, scratch.k, y, end, run.clock.control)
    factor = step_factor(error, pace[states.LAST_ERROR], method.order)
    planned = pace[states.NEXT_STEP]
    if error <= 1.0:
        pace[states.NEXT_STEP] = factor * h
        if h < 0.999 * planned:  # by the grid or a breakpoint: no reason for a shorter next step
            pace[states.NEXT_STEP] = max(factor * h, planned)
        pace[states.LAST_ERROR] = error
        pace[states.ERROR_INTEGRAL] += h * error
        return True
    _shorten_step(t, factor * h, run)
    return False


@kernel
def _shorten_step(t, h, run):
    """Continue with a step of ``h``, unless it is negligible compared with the time."""
    counters = run.counters
    run.scratch.pace[states.NEXT_STEP] = h
    if h > MIN_STEP * max(abs(t), 1.0):
        counters[states.STATUS] = states.IN_PROGRESS
    elif counters[states.STATUS] == states.IN_PROGRESS:
        counters[states.STATUS] = states.STEP_TOO_SMALL


@kernel
def append_velocity_history(t, run):
    """Add velocities and accelerations at ``t`` to the history, if a convolution needs them."""
    if run.state.history.grid.shape[1] > 0:
        _append_velocity(t, run)


@root
def _append_velocity(t, run):
    """`append_velocity_history` in heading axes; the slope found for it begins the next step."""
    history = run.state.history
    bodies = run.model.bodies
    work = run.work
    rates = run.scratch.k[0]
    n = bodies.active.size
    find_start_slope(t, run)
    accelerations(rates[n : 2 * n], bodies, work.motion, work.total)
    headings = run.model.headings
    hulls = work.hulls
    accelerations_in_heading(headings, work.motion, hulls.flow, work.total)
    u = hulls.velocity if headings.turned.size > 0 else work.motion.velocity
    append_node(history, t, u, work.total)


@kernel
def _breakpoint_after(t, goal, clock):
    """The first breakpoint after ``t`` and before the ``goal``, else the goal."""
    first = _count_breakpoints(t, clock)
    if first < clock.breakpoints.size and clock.breakpoints[first] < goal:
        return clock.breakpoints[first]
    return goal


@kernel
def _is_breakpoint(t, clock):
    before = _count_breakpoints(t, clock)
    return before > 0 and clock.breakpoints[before - 1] == t


@kernel
def _count_breakpoints(t, clock):
    """Number of breakpoints up to ``t``."""
    first = 0
    behind = clock.breakpoints.size
    while first < behind:
        middle = (first + behind) // 2
        if clock.breakpoints[middle] > t:
            behind = middle
        else:
            first = middle + 1
    return first


@root
def _reuse_end_slope(t, left, run):
    """Prepare the next step after a step to ``t``. If the modes stay and no constraint changes the
    state, the slope at its end, if known, and the margins there are reused. At a breakpoint that
    slope is the one from inside, and the next step may begin with another."""
    scratch = run.scratch
    cache = run.scratch.step_cache
    end_slope = cache[states.END_SLOPE] != 0
    cache[states.START_SLOPE] = 0
    cache[states.END_SLOPE] = 0
    cache[states.START_MARGINS] = states.STALE
    if left or may_hold(run.state.modes, run.model, run.work):
        return
    assign(scratch.margins[states.BEFORE_STEP], scratch.margins[states.AFTER_STEP])
    cache[states.START_MARGINS] = states.STALE_SLIP_ONLY  # their headings are new at each step
    if _is_breakpoint(t, run.clock):
        return
    if end_slope:
        assign(scratch.k[0], scratch.states[states.SLOPE])
        cache[states.START_SLOPE] = 1
    elif knows_end_slope(run):
        assign(scratch.k[0], scratch.k[-1])
        cache[states.START_SLOPE] = 1


@kernel
def check(y, model, counters):
    """Set the status if a number is not finite, or if a pitch or the heel of a hull or a tank is
    too large."""
    bodies = model.bodies
    for j in model.hulls.roll:
        if abs(y[j]) > LARGEST_TILT:
            counters[states.STATUS] = states.CAPSIZED
    for j in model.liquids.roll:
        if abs(y[j]) > LARGEST_TILT:
            counters[states.STATUS] = states.CAPSIZED
    own_dofs = bodies.active.size - bodies.tree.coordinates
    for j in range(own_dofs if bodies.exact else 0):
        if bodies.active[j] % 6 == PITCH_DOF and abs(y[j]) > LARGEST_TILT:
            counters[states.STATUS] = states.CAPSIZED
    if zero_if_finite(y) != 0.0:
        counters[states.STATUS] = states.NOT_FINITE


@root
def _check_joints(run):
    """Set the status if a hull or a tank that a joint carries heels too far. Rewrite the rotation
    of ball joints beyond 180 deg; margins and slopes of old coordinates are then unknown."""
    state = run.state
    model = run.model
    bodies = model.bodies
    motion = run.work.motion
    cache = run.scratch.step_cache
    n = bodies.active.size
    if switch_rotation_chart(state.y[:n], bodies):
        cache[states.START_SLOPE] = 0
        cache[states.START_MARGINS] = states.STALE
    if bodies.exact:
        place_bodies(state.y[:n], state.y[n : 2 * n], bodies, motion)
        for b in model.hulls.body:
            if motion.rotation[b, 2, 2] < MIN_PITCH_COSINE:
                run.counters[states.STATUS] = states.CAPSIZED
        for k in range(model.liquids.each.size):
            if motion.rotation[model.liquids.each[k].body, 2, 2] < MIN_PITCH_COSINE:
                run.counters[states.STATUS] = states.CAPSIZED


@summing
def zero_if_finite(y):
    """Zero times the sum of ``y``: zero if all entries are finite, else NaN."""
    total = 0.0
    for j in range(y.size):
        total += 0.0 * y[j]
    return total
