"""Cutting a step where the mode of a contact or a spring ends inside it, and switching the mode.

A mode holds while its margins (`elements.events`) are positive. A step
is cut at the first zero of any margin. A margin that becomes negative and positive again within the
step counts too. The right hand side is smooth on every piece, so a method keeps its order through
stick, slip and contact.
"""

from __future__ import annotations

from math import isfinite

from hydrosim.elements import add_element_energies, events
from hydrosim.elements.contact.law import SLIP
from hydrosim.integrate.constraint_projection import apply_impacts
from hydrosim.integrate.dynamics import apply_impulse, project_velocities
from hydrosim.integrate.methods import STALE, guard_defect, hermite, linear_value, next_trial
from hydrosim.integrate.state import (
    AFTER_STEP,
    AT_END,
    AT_PLACE,
    AT_START,
    AT_THIRD,
    AT_TWO_THIRDS,
    BEFORE_STEP,
    END,
    END_SLOPE,
    EVALUATED,
    FULL,
    GUARD_EVALUATIONS,
    IN_PROGRESS,
    INSIDE_STEP,
    MAY_END,
    NEAR_END,
    NEAR_START,
    SLOPE,
    SPARE,
    STAGE,
    STALE_SLIP_ONLY,
    START_MARGINS,
    STATUS,
    TRIAL,
    VALID,
)
from hydrosim.integrate.step import find_slope, is_held, keep_reactions, knows_end_slope, take_step
from hydrosim.jit.kernels import any_negative, assign, clear, kernel, root, root_giving
from hydrosim.modes import MARGINS, MODE
from hydrosim.multibody.kinematics import place_bodies
from hydrosim.tanks.flows import add_momentum

GUARD_RTOL = 1e-10  # of a margin's range over the step: tolerance of the location of an event
JOINT_GUARD_RTOL = 1e-8  # margins this close to zero switch together
MAX_CHORDS = 1000  # attempts to land by chords; afterwards by bisection
MAX_CUTS = 10  # times that a step is shortened in search of a mode that ends inside it
SLOPE_OFFSET = 1e-4  # of a step: distance from its ends at which slopes of margins are taken


@root_giving(float, bool)
def truncate_at_event(t, stop, located, run):
    """Cut the step from ``t`` to ``stop`` at its first event, if it has one and events are
    ``located``. Returns the time at its end, and true if a mode has ended there."""
    scratch = run.scratch
    after = scratch.margins[AFTER_STEP]
    if after.size == 0:
        return stop, False
    _evaluate_end_guards(stop, run, after)
    left = any_negative(after)
    if not located:
        return stop, left
    for _ in range(MAX_CUTS):  # negative on the cubic need not be negative in the method's step
        if left:
            stop = t + _locate_event(t, stop - t, run)
        else:
            assign(scratch.margins[AT_PLACE], after)
        _find_end_reactions(stop, run)
        part = _find_grazing_event(t, stop - t, run) if stop > t else 1.0
        if part == 1.0:
            if left:
                _check_midway(t, stop - t, run)
            return stop, left
        stop = t + part * (stop - t)
        take_step(t, stop - t, run)
        _evaluate_end_guards(stop, run, after)
        left = any_negative(after)
    if left:
        stop = t + _locate_event(t, stop - t, run)
        _find_end_reactions(stop, run)
        assign(scratch.margins[NEAR_END], scratch.margins[BEFORE_STEP])
    return stop, left


@root
def _evaluate_end_guards(t, run, out):
    """Margins at the end of the step. Reactions are margins of held points: the right hand side
    gives them, and its slope is kept."""
    scratch = run.scratch
    end = scratch.states[END]
    every = scratch.watched[MAY_END]
    _find_end_reactions(t, run)
    _evaluate_guards(t, end, run, AT_END, every, out)
    elements = run.model.elements
    if events.has_lines(elements):
        motion = run.work.motion
        events.update_lines_at_step_end(
            t, end, run.state.modes, motion, run.model.bodies, elements, every, out
        )


@root
def _evaluate_trial_guards(t, run, out):
    """Margins at the end of a tried step; the values of the uncut step are kept."""
    scratch = run.scratch
    end = scratch.states[END]
    if is_held(run):
        find_slope(t, end, run, scratch.states[SPARE])
    keep_reactions(INSIDE_STEP, run)
    _evaluate_guards(t, end, run, INSIDE_STEP, scratch.watched[MAY_END], out)


@root
def _find_end_slope(t, run):
    """The slope at the end of the step into ``states[SLOPE]``, with the reactions there, unless
    they are known."""
    scratch = run.scratch
    if scratch.step_cache[END_SLOPE] == 0:
        if knows_end_slope(run):
            assign(scratch.states[SLOPE], scratch.k[-1])
        else:
            find_slope(t, scratch.states[END], run, scratch.states[SLOPE])
        scratch.step_cache[END_SLOPE] = 1
        keep_reactions(AT_END, run)


@kernel
def _find_end_reactions(t, run):
    """Reactions at the end of the step; nothing is evaluated if they are zero."""
    if is_held(run):
        _find_end_slope(t, run)
    else:
        keep_reactions(AT_END, run)


@root
def _evaluate_guards(t, y, run, which, watched, out):
    """Margins at t, y with ``which`` of the reactions; for contacts, only the ``watched`` rows."""
    model = run.model
    modes = run.state.modes
    motion = run.work.motion
    _place_bodies_at(y, run)
    run.counters[GUARD_EVALUATIONS] += 1
    bodies = model.bodies
    elements = model.elements
    headings = run.scratch.headings
    reactions = run.scratch.reactions[which]
    events.find_margins(
        t, y, modes, motion, bodies, elements, model.tanks, headings, reactions, watched, out
    )


@kernel
def _place_bodies_at(y, run):
    """Fill the motion of the bodies from ``y``."""
    n = run.model.bodies.active.size
    place_bodies(y[:n], y[n : 2 * n], run.model.bodies, run.work.motion)


@root
def _find_before(t, run):
    """Margins at the start of the step, unless the step before has left them there."""
    scratch = run.scratch
    state = run.state
    cache = scratch.step_cache
    watched = scratch.watched[MAY_END]
    slipping = scratch.watched[EVALUATED]
    if cache[START_MARGINS] == VALID:
        return
    if cache[START_MARGINS] == STALE_SLIP_ONLY:
        watched = slipping
        for i in range(slipping.size):
            slipping[i] = 1 if state.modes[i, MODE] == SLIP else 0
    _evaluate_guards(t, state.y, run, AT_START, watched, scratch.margins[BEFORE_STEP])
    cache[START_MARGINS] = VALID


@root
def _scan_guards(t, h, run):
    """Store the step as the uncut one, with the cubic through both its ends, and compute the
    margins at its start."""
    scratch = run.scratch
    _find_end_slope(t + h, run)
    assign(scratch.states[FULL], scratch.states[END])
    if is_held(run):
        _find_reactions_on_cubic(AT_THIRD, t, h, run)
        _find_reactions_on_cubic(AT_TWO_THIRDS, t, h, run)
    else:
        keep_reactions(AT_THIRD, run)
        keep_reactions(AT_TWO_THIRDS, run)
    _find_before(t, run)


@root
def _find_reactions_on_cubic(which, t, h, run):
    """Reactions at one third, or two thirds, of the cubic."""
    x = (which - AT_START) / 3.0
    stage = run.scratch.states[STAGE]
    _interpolate(x, h, 0, stage.size, run)
    find_slope(t + x * h, stage, run, run.scratch.states[SPARE])
    keep_reactions(which, run)


@root_giving(float)
def _locate_event(t, h, run):
    """Cut the step of length ``h`` at its first event: the state there is in ``states[END]``.

    The zero is sought on the cubic through both ends. The difference between the method's own step
    and the cubic at that point is then subtracted (a contraction of order h^3), within a bracket
    that always shrinks. Returns the length of the cut step.
    """
    scratch = run.scratch
    before = scratch.margins[BEFORE_STEP]
    after = scratch.margins[AFTER_STEP]
    now = scratch.margins[AT_PLACE]
    ended = scratch.watched[EVALUATED]
    _scan_guards(t, h, run)
    for i in range(ended.size):
        ended[i] = 1 if any_negative(after[MARGINS * i : MARGINS * (i + 1)]) else 0
    if events.has_lines(run.model.elements):  # not all of them had margins at the start
        _evaluate_guards(t, run.state.y, run, AT_START, ended, before)
    lo = 0.0
    f_lo = guard_defect(before, before, after)
    hi = 1.0
    f_hi = guard_defect(after, before, after)
    x, on_cubic = _zero_on_cubic(0.0, t, h, run)
    tries = 0
    while True:  # bisects the bracket in the end, so that the search terminates
        tries += 1
        take_step(t, x * h, run)
        if run.counters[STATUS] != IN_PROGRESS:
            return x * h
        _evaluate_trial_guards(t + x * h, run, now)
        value = guard_defect(now, before, after)
        if x == 0.0 or abs(value) <= GUARD_RTOL or hi - lo < 1e-13:
            return x * h
        if value >= 0.0:
            lo = x
            f_lo = value
        else:  # or a step that is no longer finite
            hi = x
            f_hi = value
        x, on_cubic = _zero_on_cubic(value - on_cubic, t, h, run)
        if tries > MAX_CHORDS or not (isfinite(f_lo) and isfinite(f_hi)):
            x = 0.5 * (lo + hi)
            on_cubic = _phi_on_cubic(x, t, h, run)
        elif not lo < x < hi:
            x = next_trial(lo, max(f_lo, 0.0), hi, f_hi)
            on_cubic = _phi_on_cubic(x, t, h, run)


@root_giving(float, float)
def _zero_on_cubic(defect, t, h, run):
    """First x in [0, 1] where phi on the cubic, plus ``defect``, becomes negative, and phi there.
    Zero if phi is never positive (a mode that ends as soon as it begins)."""
    before = run.scratch.margins[BEFORE_STEP]
    after = run.scratch.margins[AFTER_STEP]
    lo = 0.0
    f_lo = guard_defect(before, before, after) + defect
    hi = 0.0
    f_hi = -1.0
    for j in range(1, 9):
        hi = (j / 8) ** 2  # closer together where a mode has just begun
        f_hi = _phi_on_cubic(hi, t, h, run) + defect
        if f_hi < 0.0 <= f_lo:
            break
        lo = hi
        f_lo = f_hi
    if not f_hi < 0.0 <= f_lo:
        return 0.0, f_lo - defect
    x = hi
    f = f_hi
    for _ in range(60):
        if hi - lo < 1e-14 or abs(f) < 1e-13:
            break
        x = next_trial(lo, f_lo, hi, f_hi)
        f = _phi_on_cubic(x, t, h, run) + defect
        if f >= 0.0:
            lo = x
            f_lo = f
        else:
            hi = x
            f_hi = f
    return x, f - defect


@kernel
def _phi_on_cubic(x, t, h, run):
    scratch = run.scratch
    now = scratch.margins[AT_PLACE]
    before = scratch.margins[BEFORE_STEP]
    after = scratch.margins[AFTER_STEP]
    _evaluate_guards_on_cubic(x, t, h, run, scratch.watched[EVALUATED], now)
    smallest = 1.0
    for i in range(run.state.modes.shape[0]):
        if scratch.watched[EVALUATED, i] != 0:
            a = MARGINS * i
            b = MARGINS * (i + 1)
            smallest = min(smallest, guard_defect(now[a:b], before[a:b], after[a:b]))
    return smallest


@root
def _evaluate_guards_on_cubic(x, t, h, run, watched, out):
    """`_evaluate_guards` on the cubic through both ends of the uncut step, for coordinates, rates
    and other entries that margins depend on. Reactions lie on the cubic through the known ones."""
    model = run.model
    stage = run.scratch.states[STAGE]
    _interpolate(x, h, 0, 2 * model.bodies.active.size, run)
    for i in range(watched.size):
        if watched[i] != 0:
            for part in range(events.MAX_DEPENDENCIES):
                first, last = events.guard_dependencies(i, part, model.elements, model.tanks)
                if last > first:
                    _interpolate(x, h, first, last, run)
    _interpolate_reactions(x, run.scratch.reactions)
    _evaluate_guards(t + x * h, stage, run, INSIDE_STEP, watched, out)


@kernel
def _interpolate_reactions(x, reactions):
    """Reactions ``reactions[BETWEEN]`` at ``x`` on the cubic through the four others."""
    start = -4.5 * (x - 1.0 / 3.0) * (x - 2.0 / 3.0) * (x - 1.0)
    third = 13.5 * x * (x - 2.0 / 3.0) * (x - 1.0)
    two_thirds = -13.5 * x * (x - 1.0 / 3.0) * (x - 1.0)
    end = 4.5 * x * (x - 1.0 / 3.0) * (x - 2.0 / 3.0)
    for i in range(reactions.shape[1]):
        for a in range(2):
            reaction = start * reactions[AT_START, i, a]
            reaction += third * reactions[AT_THIRD, i, a]
            reaction += two_thirds * reactions[AT_TWO_THIRDS, i, a]
            reaction += end * reactions[AT_END, i, a]
            reactions[INSIDE_STEP, i, a] = reaction


@kernel
def _interpolate(x, h, i, j, run):
    """States i to j on the cubic through both ends of the uncut step, into ``states[STAGE]``."""
    states = run.scratch.states
    y = run.state.y
    k = run.scratch.k[0]
    full = states[FULL]
    end = states[SLOPE]
    out = states[STAGE]
    hermite(x, h, y[i:j], k[i:j], full[i:j], end[i:j], out[i:j])


@root_giving(float)
def _find_grazing_event(t, h, run):
    """Fraction of the step at which a margin that falls at first and rises at last is negative on
    the cubic through both ends; 1 if there is none.

    A margin is examined if its tangents meet below zero. So a mode that ends and begins again
    within a step, or before another event, is not missed. The margins of the end are in NOW.
    """
    scratch = run.scratch
    margin = scratch.margins
    every = scratch.watched[MAY_END]
    _scan_guards(t, h, run)
    _evaluate_guards_on_cubic(SLOPE_OFFSET, t, h, run, every, margin[NEAR_START])
    if not _may_dip(margin):
        return 1.0
    _evaluate_guards_on_cubic(1.0 - SLOPE_OFFSET, t, h, run, every, margin[NEAR_END])
    for i in range(margin.shape[1]):
        first = margin[BEFORE_STEP, i]
        last = margin[AT_PLACE, i]
        falling = (margin[NEAR_START, i] - first) / SLOPE_OFFSET
        rising = (last - margin[NEAR_END, i]) / SLOPE_OFFSET
        if falling < 0.0 < rising:
            meet = (last - rising - first) / (falling - rising)
            floor = -GUARD_RTOL * max(abs(first), abs(last))
            if first + falling * meet < floor:
                x = _minimise_guard(i, floor, t, h, run)
                if x < 1.0:
                    return x
    return 1.0


@kernel
def _may_dip(margin):
    """True if the tangent of any margin at the start of the step is below zero at its end."""
    for i in range(margin.shape[1]):
        first = margin[BEFORE_STEP, i]
        if first + (margin[NEAR_START, i] - first) / SLOPE_OFFSET < 0.0:
            return True
    return False


@root_giving(float)
def _minimise_guard(i, floor, t, h, run):
    """Place of a value below ``floor`` near the minimum of margin ``i`` on the cubic, by golden
    section; 1 if there is none."""
    golden = 0.6180339887498949
    lo = 0.0
    hi = 1.0
    a = 1.0 - golden
    b = golden
    f_a = _margin_on_cubic(i, a, t, h, run)
    f_b = _margin_on_cubic(i, b, t, h, run)
    for _ in range(20):  # to 1e-4 of the step, and so to 1e-8 of the depth
        if min(f_a, f_b) < floor:
            return a if f_a < f_b else b
        if f_a < f_b:
            hi = b
            b = a
            f_b = f_a
            a = hi - golden * (hi - lo)
            f_a = _margin_on_cubic(i, a, t, h, run)
        else:
            lo = a
            a = b
            f_a = f_b
            b = lo + golden * (hi - lo)
            f_b = _margin_on_cubic(i, b, t, h, run)
    return 1.0


@root_giving(float)
def _margin_on_cubic(i, x, t, h, run):
    watched_row = run.scratch.watched[EVALUATED]
    out = run.scratch.margins[TRIAL]
    for j in range(watched_row.size):
        watched_row[j] = 1 if j == i // MARGINS else 0
    _evaluate_guards_on_cubic(x, t, h, run, watched_row, out)
    return out[i]


@root
def store_slip_directions(t, run):
    """Store the headings of all slipping points at the start of a step."""
    headings = run.scratch.headings
    state = run.state
    model = run.model
    _place_bodies_at(state.y, run)
    motion = run.work.motion
    bodies = model.bodies
    events.find_slip_directions(t, state.y, state.modes, motion, bodies, model.elements, headings)


@root
def switch_modes(t, run):
    """Switch the modes that have ended at ``state.y``: all with a zero margin, or without location
    all with a negative margin. Each row of modes switches once."""
    state = run.state
    scratch = run.scratch
    before = scratch.margins[BEFORE_STEP]
    after = scratch.margins[AFTER_STEP]
    first = guard_defect(scratch.margins[AT_PLACE], before, after)
    _place_bodies_at(state.y, run)
    _add_momentum(-1.0, run)
    for i in range(state.modes.shape[0]):
        for which in range(MARGINS):
            m = MARGINS * i + which
            if _has_ended(m, first, run):
                _switch_mode(i, which, max(abs(before[m]), abs(after[m])), t, run)
                break
    _add_momentum(1.0, run)
    scratch.newton.status[0] = STALE
    make_consistent(t, run)


@kernel
def _has_ended(m, first, run):
    """True if the mode of margin ``m`` ends here, at the event ``first``.

    A margin that was zero at the start of the step too, and has not fallen since, belongs to a mode
    that has just begun. It does not end together with another mode. Otherwise the modes of two rows
    that have begun in turn would end each other endlessly. If it does end here, it is the first
    event of the next step.
    """
    margins = run.scratch.margins
    if not _is_near(m, first, run):
        return False
    if not run.clock.events or not _was_zero(m, run):
        return True
    if linear_value(m, margins[AT_PLACE], margins[BEFORE_STEP], margins[AFTER_STEP]) <= first:
        return True
    return margins[AT_PLACE, m] < max(margins[BEFORE_STEP, m], margins[NEAR_END, m])


@kernel
def _is_near(m, first, run):
    """True if margin ``m`` is negative at the end of the uncut step, and zero now; without location
    the first condition suffices."""
    margins = run.scratch.margins
    if margins[AFTER_STEP, m] >= 0.0:
        return False
    if not run.clock.events:
        return True
    near = max(first, 0.0) + JOINT_GUARD_RTOL
    return linear_value(m, margins[AT_PLACE], margins[BEFORE_STEP], margins[AFTER_STEP]) <= near


@kernel
def _was_zero(m, run):
    """True if margin ``m`` was zero at the start of the step."""
    margins = run.scratch.margins
    return (
        abs(linear_value(m, margins[BEFORE_STEP], margins[BEFORE_STEP], margins[AFTER_STEP]))
        <= JOINT_GUARD_RTOL
    )


@kernel
def _check_midway(t, h, run):
    """Margins in the middle of the cut step of length ``h`` into LATE, for `_has_ended`. They are
    computed on its cubic if needed, and otherwise copied from its start."""
    scratch = run.scratch
    margins = scratch.margins
    assign(margins[NEAR_END], margins[BEFORE_STEP])
    first = guard_defect(margins[AT_PLACE], margins[BEFORE_STEP], margins[AFTER_STEP])
    count = 0
    begun = False
    for m in range(margins.shape[1]):
        if _is_near(m, first, run):
            count += 1
            begun = begun or _was_zero(m, run)
    if begun and count > 1 and h > 0.0:
        _evaluate_guards_on_cubic(0.5, t, h, run, scratch.watched[MAY_END], margins[NEAR_END])


@kernel
def _add_momentum(sign, run):
    """Impulse of flows between tanks that begin or end.

    With ``sign`` -1, before modes switch, their momentum is stored. With 1, after the switch, the
    difference is applied to the bodies. So the momentum of bodies and fluid together is conserved.
    """
    p = run.model.tanks
    model = run.model
    state = run.state
    push = run.work.push
    if p.flows.size == 0:
        return
    if sign < 0.0:
        clear(push)
    add_momentum(-sign, state.y, state.modes, run.work.motion, model.bodies, p, push)
    if sign > 0.0:
        apply_impulse(state.y, state.modes, model, run.work)


@kernel
def _switch_mode(i, which, size, t, run):
    """Switch row ``i`` of the modes, whose margin ``which`` had this ``size``."""
    state = run.state
    model = run.model
    step = run.clock.step if run.clock.events else 0.0
    triggered = events.is_trigger(i, model.elements)
    if triggered:
        _book_stored(i, 1.0, t, run)
    y = state.y
    modes = state.modes
    motion = run.work.motion
    bodies = model.bodies
    elements = model.elements
    tanks = model.tanks
    reactions = run.scratch.reactions[AT_END]
    events.transition(i, which, size, step, t, y, modes, motion, bodies, elements, tanks, reactions)
    run.scratch.switches[i] += 1
    if triggered:
        _book_stored(i, -1.0, t, run)


@root
def _book_stored(i, sign, t, run):
    """Book stored energy before and after a trigger: energy stored in its element is lost, or comes
    from outside."""
    state = run.state
    model = run.model
    stored = run.work.rate
    clear(stored)
    motion = run.work.motion
    elements = model.elements
    add_element_energies(t, state.y, state.modes, motion, model.bodies, elements, stored)
    events.book_stored(i, sign, state.y, stored, elements)


@kernel
def make_consistent(t, run):
    """Bring driven coordinates to their signals and held points to rest, and release points that
    cannot be held."""
    events.follow_drives(t, run.state.y, run.model.bodies, run.model.elements, run.work.holds)
    if events.any_joints(run.model.elements):
        apply_impacts(t, run)
    if run.work.constraints.force.size > events.joint_rows(run.model.elements):
        _make_velocities_consistent(t, run)


@root
def _make_velocities_consistent(t, run):
    state = run.state
    model = run.model
    work = run.work
    project_velocities(state.y, state.modes, model, work)
    for _ in range(work.constraints.force.size):
        find_slope(t, state.y, run, run.scratch.states[SPARE])
        loose = events.break_loose(
            t,
            state.y,
            state.modes,
            work.motion,
            model.bodies,
            model.elements,
            work.holds.reaction,
        )
        if not loose:
            return
