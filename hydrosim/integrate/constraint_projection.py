"""Joints that are constraints hold to rounding, and stop at once what they stop.

After every accepted step, places and velocities are brought back onto the constraints with the
least kinetic energy,

    H dq = J^T mu,  J dq = -residual,      H du = J^T mu,  J (q' + du) = 0,      H = S^T (M + A) S,

which is of the order of the error of the step, so that a method keeps its order. Forces between
steps come from J q'' = c (index 1).

A joint that closes is a plastic impact through all closed joints, with the added mass:

    (J H^-1 J^T) p = -J q',   lost 1/2 (J q')^T (J H^-1 J^T)^-1 J q' = -1/2 p . J q'

The impulse p acts for no time. Contacts have finite forces, so that they bear none: also rigid
friction slides if an impact moves it. A ratchet only pushes: one that would pull lets go, one that
would go back joins in.

Rows that depend on earlier ones are dropped where joints close or open, and stay dropped: bodies
leave the constraints by the errors of stages, where repeated rows seem to differ. A constraint
whose row comes to depend on others later (a four-bar linkage in a straight line) ends the run. So
does a drive that moves what a dropped row holds: at once, or when it moves on from a rest.
"""

from __future__ import annotations

from hydrosim.elements import events
from hydrosim.elements.joint import locks
from hydrosim.elements.joint.locks import CLOSED, LOCK_IMPULSE, LOCK_LOSS, NO_RATCHET, RATCHETING
from hydrosim.integrate import state as states
from hydrosim.integrate.dynamics import add_constraints, find_inertia, solve_held
from hydrosim.jit.kernels import assign, clear, kernel, root, root_giving
from hydrosim.modes import MODE, NO_INDEX, SEGMENT
from hydrosim.multibody.constraints import DROPPED, find_rank
from hydrosim.multibody.kinematics import place_bodies
from hydrosim.multibody.mass import cholesky
from hydrosim.multibody.tree import fill_rates

PLACE_TOLERANCE = (
    1e-13  # m or 1: residual of a place, more by 1e-15 of the farthest place beyond 100 m
)
VELOCITY_ROUNDING = 1e-14  # of the sum of the terms of a velocity: rounding of J q'
OPPOSED_RATE = 1e-9  # m/s or rad/s, and 1e-9 of the lever: rounding of the rate of a dropped row
DRIVEN_TOLERANCE = 1e-6  # m, rad and per second, and of the size of a rate: errors of a dropped row
MAX_PROJECTIONS = 5  # Newton's iterations back to the constraints
MAX_IMPACT_ROUNDS = 20  # impacts through ratchets that join in or let go


@root
def project_state(t, run):
    """Bring the accepted state back onto the constraints of joints, and watch their rank."""
    model = run.model
    if locks.any_closed(run.state.modes, model.elements.locks):
        project_places_and_rates(run.state.y, run.state.modes, model, run.work)
        _check_rank(t, run)
        if run.work.holds.driven.shape[0] > 0 and _drives_part_joint(run.state, model, run.work):
            run.counters[states.STATUS] = states.DRIVEN_APART


@root
def apply_impacts(t, run):
    """After modes have switched: find the rows of joints that hold, and book the impact of those
    that have closed. A joint that closes against a drive ends the run."""
    state = run.state
    model = run.model
    p = model.elements.locks
    choose_rows(state.y, state.modes, model, run.work)
    if not locks.any_closed(state.modes, p) and not _any_ratcheting(state.modes, p):
        return
    project_places(state.y, state.modes, model, run.work)
    for _ in range(MAX_IMPACT_ROUNDS):
        struck = apply_impact(state.y, state.modes, model, run.work)
        joins = _ratchets_join(state.y, state.modes, model, run.work)
        if joins:
            choose_rows(state.y, state.modes, model, run.work)
        if struck:
            _test_contacts(t, run)
        if not joins:
            break
    run.scratch.pace[states.ROW_RANK_TIME] = t
    run.scratch.pace[states.ROW_RANK] = choose_rows(state.y, state.modes, model, run.work)
    if _opposes_drives(state.y, model, run.work):
        run.counters[states.STATUS] = states.DRIVEN_APART
    project_places_and_rates(state.y, state.modes, model, run.work)


@kernel
def _opposes_drives(y, model, work):
    """True if rows that depend on those of drives, and are dropped for that, would have to move."""
    n = model.bodies.active.size
    constraints = work.constraints
    if constraints.number[0] == 0 or work.holds.driven.shape[0] == 0:
        return False
    for r in range(constraints.number[0]):
        rate = 0.0
        size = 1.0
        for j in range(n):
            rate += constraints.J[r, j] * y[n + j]
            size = max(size, abs(constraints.J[r, j]))
        if constraints.pivot[r] == DROPPED and abs(rate) > OPPOSED_RATE * size:
            return True
    return False


@kernel
def _drives_part_joint(state, model, work):
    """True if drives have moved what a closed joint holds by rows that depend on those of drives.
    They are dropped, so that nothing else would show it: the joint closed while the drive stood
    still. ``work.motion`` is that of the state."""
    p = model.elements.locks
    constraints = work.constraints
    holds = work.holds
    parted = False
    for i in range(p.each.size):
        mode = state.modes[p.mode + i]
        kept_rows = mode[SEGMENT]
        if mode[MODE] != CLOSED or kept_rows == locks.every_row(i, p):
            continue
        mode[SEGMENT] = locks.every_row(i, p)
        constraints.number[0] = 0
        locks.add_constraints(
            state.y, state.modes, work.motion, model.bodies, p, work.total, constraints, holds
        )
        parted = parted or _is_parted(i, state.y, model.bodies.active.size, constraints, holds)
        mode[SEGMENT] = kept_rows
    return parted


@kernel
def _is_parted(i, y, n, constraints, holds):
    """True if a row of joint ``i`` has a residual, or a rate in the state ``y``."""
    for r in range(constraints.number[0]):
        rate = 0.0
        size = 1.0
        for j in range(n):
            term = constraints.J[r, j] * y[n + j]
            rate += term
            size += abs(term)
        moves = abs(rate) > DRIVEN_TOLERANCE * size or abs(holds.residual[r]) > DRIVEN_TOLERANCE
        if holds.lock[r] == i and moves:
            return True
    return False


@kernel
def _any_ratcheting(modes, p):
    running = 0
    for i in range(p.each.size):
        if modes[p.mode + i, MODE] == RATCHETING:
            running += 1
    return running > 0


@kernel
def _test_contacts(t, run):
    """Test all contacts again after an impact."""
    state = run.state
    model = run.model
    n = model.bodies.active.size
    motion = run.work.motion
    place_bodies(state.y[:n], state.y[n : 2 * n], model.bodies, motion)
    headings = run.scratch.headings
    reactions = run.work.holds.reaction
    events.recheck_after_impact(
        t, state.y, state.modes, motion, model.bodies, headings, reactions, model.elements
    )


@kernel
def _set_up(y, modes, model, work):
    """Inertia, and constraints of drives and closed joints, at the state ``y``."""
    find_inertia(y, model, work)
    work.constraints.number[0] = 0
    p = model.elements.locks
    holds = work.holds
    events.add_drive_constraints(model.elements, work.constraints, holds)
    locks.add_constraints(
        y, modes, work.motion, model.bodies, p, work.total, work.constraints, holds
    )


@root_giving(float)
def choose_rows(y, modes, model, work):
    """Keep of all closed joints, in their order, the rows that do not depend on earlier ones.
    Returns the smallest sine between a kept row and those before it."""
    p = model.elements.locks
    for i in range(p.each.size):
        if modes[p.mode + i, MODE] == CLOSED:
            modes[p.mode + i, SEGMENT] = locks.every_row(i, p)
    _set_up(y, modes, model, work)
    cholesky(work.inertia)
    least = find_rank(work.constraints, work.inertia, work.holds.size)
    for r in range(work.constraints.number[0]):
        if work.constraints.pivot[r] == DROPPED and work.holds.lock[r] != NO_INDEX:
            modes[p.mode + work.holds.lock[r], SEGMENT] -= 1 << work.holds.bit[r]
    return least


@root
def project_places(y, modes, model, work):
    """Bring the places in ``y`` back onto the constraints of closed joints."""
    n = model.bodies.active.size
    constraints = work.constraints
    change = work.jump[0]
    for _ in range(MAX_PROJECTIONS):
        _set_up(y, modes, model, work)
        if _places_met(model, work):
            return
        for r in range(constraints.number[0]):
            constraints.bound[r] = -work.holds.residual[r]
        clear(change)
        solve_held(work.inertia, constraints, change)
        move = work.jump[1]
        assign(move, change)
        if model.bodies.tree.branches.size > 0:
            fill_rates(y[:n], change, model.bodies, move)
        for i in range(n):
            y[i] += move[i]


@kernel
def _places_met(model, work):
    """True if all residuals of places are rounding."""
    farthest = 1.0
    for b in range(model.bodies.each.size):
        for i in range(3):
            place = model.bodies.each[b].origin[i] + work.motion.coordinates[6 * b + i]
            farthest = max(farthest, 0.01 * abs(place))
    for r in range(work.constraints.number[0]):
        if abs(work.holds.residual[r]) > PLACE_TOLERANCE * farthest:
            return False
    return True


@root
def project_places_and_rates(y, modes, model, work):
    """Bring places and rates in ``y`` back onto the constraints: places onto those of joints, rates
    onto all."""
    n = model.bodies.active.size
    project_places(y, modes, model, work)
    change = work.jump[0]
    for _ in range(MAX_PROJECTIONS):
        find_inertia(y, model, work)
        add_constraints(y, modes, model, work)
        if _find_stops(y[n : 2 * n], work.constraints, model.elements.drives.each.size):
            return
        clear(change)
        solve_held(work.inertia, work.constraints, change)
        for i in range(n):
            y[n + i] += change[i]


@kernel
def _find_stops(u, constraints, drives):
    """Set bounds that stop the rates ``u`` across constraints; true if they are rounding. The first
    rows, of ``drives``, keep their rates."""
    still = True
    for r in range(drives):
        constraints.bound[r] = 0.0
    for r in range(drives, constraints.number[0]):
        rate = 0.0
        size = 0.0
        for j in range(u.size):
            term = constraints.J[r, j] * u[j]
            rate += term
            size += abs(term)
        constraints.bound[r] = -rate
        if abs(rate) > VELOCITY_ROUNDING * size:
            still = False
    return still


@root_giving(bool)
def apply_impact(y, modes, model, work):
    """Stop the rates in ``y`` across closed joints by impulses, and book them. A ratchet that would
    pull lets go. Returns true if there was anything to stop."""
    n = model.bodies.active.size
    p = model.elements.locks
    constraints = work.constraints
    change = work.jump[0]
    for _ in range(MAX_IMPACT_ROUNDS):
        _set_up(y, modes, model, work)
        if _find_stops(y[n : 2 * n], constraints, model.elements.drives.each.size):
            return False
        for r in range(constraints.number[0]):
            work.jump[1, r] = constraints.bound[r]
        clear(change)
        solve_held(work.inertia, constraints, change)
        if not _lets_go(modes, constraints, work.holds, p):
            break
    _book_impact(y, change, modes, model, work)
    for i in range(n):
        y[n + i] += change[i]
    return True


@kernel
def _lets_go(modes, constraints, holds, p):
    """Release the ratchet with the largest pull, if any pulls; true if one does."""
    worst = -1
    pull = 0.0
    for r in range(constraints.number[0]):
        i = holds.lock[r]
        if i == NO_INDEX:
            continue
        if p.each[i].ratchet != NO_RATCHET and constraints.force[r] < pull:
            pull = constraints.force[r]
            worst = i
    if worst < 0:
        return False
    modes[p.mode + worst, MODE] = RATCHETING
    return True


@root_giving(bool)
def _ratchets_join(y, modes, model, work):
    """Close running ratchets without teeth that go back; true if there are any."""
    n = model.bodies.active.size
    p = model.elements.locks
    has_joined = False
    place_bodies(y[:n], y[n : 2 * n], model.bodies, work.motion)
    for i in range(p.each.size):
        if locks.goes_back(i, y, modes, model.bodies, work.motion, p):
            locks.close_lock(i, y, modes, work.motion, model.bodies, p)
            has_joined = True
    return has_joined


@kernel
def _book_impact(y, change, modes, model, work):
    """Book the impulses of all closed joints and the energy that they take, before the rates
    ``change`` (n,)."""
    p = model.elements.locks
    constraints = work.constraints
    holds = work.holds
    locks.collect_reactions(p, constraints, holds)
    for r in range(constraints.number[0]):
        i = holds.lock[r]
        if i == NO_INDEX:
            continue
        lost = 0.5 * constraints.force[r] * work.jump[1, r]
        y[p.state + locks.LOCK_STATES * i + LOCK_LOSS] += lost
        y[p.losses + p.each[i].row] += lost
    for i in range(p.each.size):
        for a in range(6):
            y[p.state + locks.LOCK_STATES * i + LOCK_IMPULSE + a] += holds.joint[i, a]
    events.book_drive_impulses(y, model.bodies, model.elements, constraints)
    if model.impulse < model.size:
        _book_impulses(y, modes, change, model, work)


@root
def _book_impulses(y, modes, change, model, work):
    """Add the impulses on bodies, and their works by coordinate, to the integrals of ``y``. The
    velocities of the works are the mean of those before and after the impact."""
    p = model.elements.locks
    push = work.push
    m = push.size
    row = p.each[0].row
    clear(push)
    for i in range(p.each.size):
        if locks.is_closed(i, modes, p):
            locks.add_joint_wrench(i, y, work.holds.joint[i], work.motion, model.bodies, p, push)
    n = model.bodies.active.size
    mean = work.jump[1]
    for i in range(n):
        mean[i] = y[n + i] + 0.5 * change[i]
    place_bodies(y[:n], mean[:n], model.bodies, work.motion)
    works = model.impulse + model.rows * m
    for i in range(m):
        y[model.impulse + row * m + i] += push[i]
        y[works + row * m + i] += push[i] * work.motion.velocity[i]
    events.add_drive_impulses(
        y,
        work.motion,
        model.bodies,
        model.elements,
        work.constraints,
        work.holds,
        push,
        model.impulse,
        works,
    )


@kernel
def _check_rank(t, run):
    """End the run if a row of constraints depends on others, or will by the end of the next step:
    the sine between them, continued in a straight line, reaches zero."""
    pace = run.scratch.pace
    now = _smallest_sine(run)
    before = pace[states.ROW_RANK]
    h = t - pace[states.ROW_RANK_TIME]
    ahead = pace[states.NEXT_STEP] if run.clock.control.adaptive else run.clock.step
    falls = h > 0.0 and now < before and now * h <= (before - now) * ahead
    if now == 0.0 or falls:
        run.counters[states.STATUS] = states.SINGULAR
    pace[states.ROW_RANK] = now
    pace[states.ROW_RANK_TIME] = t


@root_giving(float)
def _smallest_sine(run):
    """Smallest sine between a row of joints and those before it; 0 if a row depends on them."""
    work = run.work
    _set_up(run.state.y, run.state.modes, run.model, work)
    cholesky(work.inertia)
    least = find_rank(work.constraints, work.inertia, work.holds.size)
    for r in range(work.constraints.number[0]):
        if work.constraints.pivot[r] == DROPPED:
            least = 0.0
    return least
