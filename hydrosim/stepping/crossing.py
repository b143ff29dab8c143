"""Cutting a step where the mode of a contact or a spring ends inside it, and switching the mode.

A mode holds while its margins (`forces.contact.transitions`, `forces.spring`) are positive. A step
is cut at the first zero of any; one that dips below zero and comes back within the step counts too.
The right hand side is smooth on every piece, so a method keeps its order through stick, slip and
contact.
"""

from __future__ import annotations

from hydrosim.forces import FENDER, SPRING, spring
from hydrosim.forces.contact.fender import SETTLED, STATES
from hydrosim.forces.contact.modes import MARGINS, MODE, SLIP, STICK
from hydrosim.forces.contact.transitions import break_loose, find_headings, margins, switch
from hydrosim.integrate import between, hermite, phi, scaled
from hydrosim.integrate.implicit import STALE
from hydrosim.jit.kernels import any_negative, assign, kernel, root
from hydrosim.rigid import place_bodies
from hydrosim.stepping.dynamics import rhs, still
from hydrosim.stepping.stepper import (
    AFTER,
    BEFORE,
    BUT_FOR_SLIP,
    EARLY,
    END,
    EVALUATIONS,
    EVERY,
    FULL,
    KNOWN,
    LATE,
    NOW,
    SLOPE,
    SOME,
    SPARE,
    STAGE,
    TRIAL,
    step,
)

LANDED = 1e-10  # of a margin's range over the step: an event is located to this
SWITCHED = 1e-8  # margins this near to zero switch together
DIPS = 10  # times that a step is shortened in search of a mode that ends inside it
FAST, RELAXATIONS = 10, 3  # steps that a fast node relaxes in; how often until it is settled
NEAR = 1e-4  # of a step: as far from its ends as slopes of margins are taken


@kernel
def cut(t, stop, located, model, method, state, work, scratch, counters):
    """Cut the step from ``t`` to ``stop`` that was taken at its first event, if it has one and it
    is to be ``located``. Returns the time at its end and whether a mode has ended there."""
    end, after, every = scratch.states[END], scratch.margins[AFTER], scratch.watched[EVERY]
    _measure(stop, end, model, state, work, scratch, every, after)
    left = any_negative(after)
    if after.size == 0 or not located:
        return stop, left
    for _ in range(DIPS):  # what is below zero on the cubic need not be so in the method's step
        if left:
            stop = t + _land(t, stop - t, model, method, state, work, scratch, counters)
        else:
            assign(scratch.margins[NOW], after)
        part = _dip(t, stop - t, model, state, work, scratch, counters) if stop > t else 1.0
        if part == 1.0:
            return stop, left
        stop = t + part * (stop - t)
        step(t, stop - t, model, method, state, work, scratch, counters)
        _measure(stop, end, model, state, work, scratch, every, after)
        left = any_negative(after)
    if left:
        stop = t + _land(t, stop - t, model, method, state, work, scratch, counters)
    scratch.fresh[1] = 0
    return stop, left


@root
def _measure(t, y, model, state, work, scratch, watched, out):
    """Margins at t, y of springs, and of contact modes of ``watched`` rows."""
    if out.size == 0:
        return
    n, fenders, holds = model.bodies.active.size, model.elements[FENDER], work.holds
    if holds.point.size > 0:  # the reactions are margins of rigid friction
        rhs(t, y, state.modes, state.history, model, work, scratch.states[SPARE])
    else:
        place_bodies(y[:n], y[n : 2 * n], model.bodies, work.motion)
    headings, reactions = scratch.headings, holds.reaction
    motion, bodies = work.motion, model.bodies
    margins(t, y, state.modes, motion, bodies, fenders, headings, reactions, watched, out)
    if model.elements[SPRING].lines.size > 0:
        spring.margins(state.modes, motion, bodies, model.elements[SPRING], out)


@root
def _find_before(t, model, state, work, scratch):
    """Margins at the start of the step, as far as the step before has not left them there."""
    fresh, watched, slipping = scratch.fresh, scratch.watched[EVERY], scratch.watched[SOME]
    if fresh[2] == KNOWN:
        return
    if fresh[2] == BUT_FOR_SLIP:
        watched = slipping
        for i in range(slipping.size):
            slipping[i] = 1 if state.modes[i, MODE] == SLIP else 0
    _measure(t, state.y, model, state, work, scratch, watched, scratch.margins[BEFORE])
    fresh[2] = KNOWN


@root
def _land(t, h, model, method, state, work, scratch, counters):
    """Cut the step of length ``h`` at its first event: the state there in ``states[END]``.

    The zero is sought on the cubic through both ends, and the difference between the method's own
    step and the cubic at that place is then taken off (a contraction of order h^3), within a
    bracket that always shrinks. Returns the length of the cut step.
    """
    end = scratch.states[END]
    before, after, now = scratch.margins[BEFORE], scratch.margins[AFTER], scratch.margins[NOW]
    every, ended = scratch.watched[EVERY], scratch.watched[SOME]
    rhs(t + h, end, state.modes, state.history, model, work, scratch.states[SLOPE])
    counters[EVALUATIONS] += 1
    assign(scratch.states[FULL], end)
    _find_before(t, model, state, work, scratch)
    for i in range(ended.size):
        ended[i] = 1 if any_negative(after[MARGINS * i : MARGINS * (i + 1)]) else 0
    lo, f_lo, hi, f_hi = 0.0, phi(before, before, after), 1.0, phi(after, before, after)
    x, on_cubic = _zero_on_cubic(0.0, t, h, model, state, work, scratch)
    while True:
        step(t, x * h, model, method, state, work, scratch, counters)
        _measure(t + x * h, end, model, state, work, scratch, every, now)
        value = phi(now, before, after)
        if x == 0.0 or abs(value) <= LANDED or hi - lo < 1e-13:
            return x * h
        if value >= 0.0:
            lo, f_lo = x, value
        else:
            hi, f_hi = x, value
        x, on_cubic = _zero_on_cubic(value - on_cubic, t, h, model, state, work, scratch)
        if not lo < x < hi:
            x = between(lo, max(f_lo, 0.0), hi, f_hi)
            on_cubic = _phi_on_cubic(x, t, h, model, state, work, scratch)


@root
def _zero_on_cubic(defect, t, h, model, state, work, scratch):
    """First x in [0, 1] where phi on the cubic, plus ``defect``, turns negative, and phi there;
    zero if phi is never positive (a mode that ends as soon as it begins)."""
    before, after = scratch.margins[BEFORE], scratch.margins[AFTER]
    lo, f_lo = 0.0, phi(before, before, after) + defect
    hi, f_hi = 0.0, -1.0
    for j in range(1, 9):
        hi = (j / 8) ** 2  # closer together where a mode has just begun
        f_hi = _phi_on_cubic(hi, t, h, model, state, work, scratch) + defect
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
        f = _phi_on_cubic(x, t, h, model, state, work, scratch) + defect
        if f >= 0.0:
            lo, f_lo = x, f
        else:
            hi, f_hi = x, f
    return x, f - defect


@kernel
def _phi_on_cubic(x, t, h, model, state, work, scratch):
    now, before, after = scratch.margins[NOW], scratch.margins[BEFORE], scratch.margins[AFTER]
    _on_cubic(x, t, h, model, state, work, scratch, scratch.watched[SOME], now)
    smallest = 1.0
    for i in range(state.modes.shape[0]):
        if scratch.watched[SOME, i] != 0:
            a, b = MARGINS * i, MARGINS * (i + 1)
            smallest = min(smallest, phi(now[a:b], before[a:b], after[a:b]))
    return smallest


@root
def _on_cubic(x, t, h, model, state, work, scratch, watched, out):
    """`_measure` on the cubic through both ends of the uncut step: of coordinates, rates and nodes
    alone, but for the reactions of rigid friction."""
    fenders, stage = model.elements[FENDER], scratch.states[STAGE]
    if work.holds.point.size > 0:
        _interpolate(x, h, 0, stage.size, state, scratch, stage)
    else:
        _interpolate(x, h, 0, 2 * model.bodies.active.size, state, scratch, stage)
        for i in range(fenders.points.size):
            if watched[i] != 0:
                k = fenders.state + STATES * i
                _interpolate(x, h, k, k + 2, state, scratch, stage)  # its stretch
    _measure(t + x * h, stage, model, state, work, scratch, watched, out)


@kernel
def _interpolate(x, h, i, j, state, scratch, out):
    """States i to j on the cubic through both ends of the uncut step."""
    k, full, slope = scratch.k[0], scratch.states[FULL], scratch.states[SLOPE]
    hermite(x, h, state.y[i:j], k[i:j], full[i:j], slope[i:j], out[i:j])


@kernel
def _dip(t, h, model, state, work, scratch, counters):
    """Where in a step, as a part of it, a margin that falls at first and rises at last is below
    zero on the cubic through both ends; 1 where none is.

    It is looked into if its tangents meet below zero: so a mode that ends and begins again within a
    step, or before another event, is not jumped over. The margins of the end are in NOW.
    """
    margin, every, end = scratch.margins, scratch.watched[EVERY], scratch.states[END]
    rhs(t + h, end, state.modes, state.history, model, work, scratch.states[SLOPE])
    counters[EVALUATIONS] += 1
    scratch.fresh[1] = 1
    assign(scratch.states[FULL], end)
    _find_before(t, model, state, work, scratch)
    _on_cubic(NEAR, t, h, model, state, work, scratch, every, margin[EARLY])
    if not _may_dip(margin):
        return 1.0
    _on_cubic(1.0 - NEAR, t, h, model, state, work, scratch, every, margin[LATE])
    for i in range(margin.shape[1]):
        first, last = margin[BEFORE, i], margin[NOW, i]
        falling, rising = (margin[EARLY, i] - first) / NEAR, (last - margin[LATE, i]) / NEAR
        if falling < 0.0 < rising:
            meet = (last - rising - first) / (falling - rising)
            floor = -LANDED * max(abs(first), abs(last))
            if first + falling * meet < floor:
                x = _deepest(i, floor, t, h, model, state, work, scratch)
                if x < 1.0:
                    return x
    return 1.0


@kernel
def _may_dip(margin):
    """True if the tangent of any margin at the start of the step is below zero at its end."""
    for i in range(margin.shape[1]):
        first = margin[BEFORE, i]
        if first + (margin[EARLY, i] - first) / NEAR < 0.0:
            return True
    return False


@kernel
def _deepest(i, floor, t, h, model, state, work, scratch):
    """Place of a value below ``floor`` near the minimum of margin ``i`` on the cubic, by golden
    section; 1 if there is none."""
    golden = 0.6180339887498949
    lo, hi = 0.0, 1.0
    a, b = 1.0 - golden, golden
    f_a = _margin_on_cubic(i, a, t, h, model, state, work, scratch)
    f_b = _margin_on_cubic(i, b, t, h, model, state, work, scratch)
    for _ in range(20):  # to 1e-4 of the step, and so to 1e-8 of the depth
        if min(f_a, f_b) < floor:
            return a if f_a < f_b else b
        if f_a < f_b:
            hi, b, f_b = b, a, f_a
            a = hi - golden * (hi - lo)
            f_a = _margin_on_cubic(i, a, t, h, model, state, work, scratch)
        else:
            lo, a, f_a = a, b, f_b
            b = lo + golden * (hi - lo)
            f_b = _margin_on_cubic(i, b, t, h, model, state, work, scratch)
    return 1.0


@kernel
def _margin_on_cubic(i, x, t, h, model, state, work, scratch):
    one, out = scratch.watched[SOME], scratch.margins[TRIAL]
    for j in range(one.size):
        one[j] = 1 if j == i // MARGINS else 0
    _on_cubic(x, t, h, model, state, work, scratch, one, out)
    return out[i]


@kernel
def note_headings(t, model, state, work, headings):
    """Note where all points slip to at the start of a step."""
    if headings.size > 0:
        n = model.bodies.active.size
        place_bodies(state.y[:n], state.y[n : 2 * n], model.bodies, work.motion)
        fenders = model.elements[FENDER]
        find_headings(t, state.y, state.modes, work.motion, model.bodies, fenders, headings)


@kernel
def switch_modes(located, step, t, model, state, work, scratch):
    """Switch the modes that have ended at ``state.y``: all whose margin is zero there, or without
    location all whose margin is negative. One switch per row of modes."""
    y, n = state.y, model.bodies.active.size
    before, after, now = scratch.margins[BEFORE], scratch.margins[AFTER], scratch.margins[NOW]
    near = max(phi(now, before, after), 0.0) + SWITCHED
    place_bodies(y[:n], y[n : 2 * n], model.bodies, work.motion)
    for i in range(state.modes.shape[0]):
        for which in range(MARGINS):
            m = MARGINS * i + which
            if after[m] >= 0.0 or (located and scaled(m, now, before, after) > near):
                continue
            size = max(abs(before[m]), abs(after[m]))
            _switch(i, which, size, located, step, t, model, state, work)
            break
    scratch.newton.status[0] = STALE
    make_consistent(t, model, state, work, scratch)


@kernel
def _switch(i, which, size, located, step, t, model, state, work):
    """Switch row ``i`` of the modes; a node that relaxes in few steps of length ``step`` is settled
    only a while later."""
    y, modes, motion, fenders = state.y, state.modes, work.motion, model.elements[FENDER]
    if i >= fenders.points.size:
        lines = model.elements[SPRING]
        spring.switch(i - fenders.points.size, which, modes, motion, model.bodies, lines)
        return
    switch(i, which, size, t, y, modes, motion, model.bodies, work.holds.reaction, fenders)
    relaxation = fenders.points[i].relaxation
    if located and modes[i, MODE] != STICK and relaxation < FAST * step:
        y[fenders.state + STATES * i + SETTLED] = t + RELAXATIONS * relaxation


@kernel
def make_consistent(t, model, state, work, scratch):
    """Bring what rigid friction holds to rest, and let break loose what it cannot hold."""
    still(state.y, state.modes, model, work)
    for _ in range(work.holds.point.size):
        rhs(t, state.y, state.modes, state.history, model, work, scratch.states[SPARE])
        fenders, reactions = model.elements[FENDER], work.holds.reaction
        if not break_loose(t, state.y, state.modes, work.motion, model.bodies, fenders, reactions):
            return
