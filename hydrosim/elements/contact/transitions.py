"""Transitions of contact points from one mode to another.

A mode holds while its margins are positive:

    contact   min(k delta, N), its opposite when open      k: the curve's steepest slope; if N is
                                                           prescribed, N less 1e-12 of its largest,
                                                           or less 1e-9 of that when open, so that
                                                           an N which touches zero lets go once
    friction  of the friction law                          in contact
    segment   distance to the nearer corner of the curve   in contact
    rising    N_e', its opposite where the load falls      in contact, if K2 goes with the load,
              or delta' where the curve has a loop         and on the branches of a loop

Where a plane ends, the distance inside its nearest edge belongs to the margin of contact. The curve
(`curves`) and the friction law (`laws`) determine the mode that follows.
"""

from __future__ import annotations

from hydrosim.elements.contact import curves, fender, geometry, group, laws
from hydrosim.elements.contact.law import ABSENT, AT_REST, OPEN, PASSED, SLIP, STICK
from hydrosim.elements.contact.laws import COULOMB, FRICTION_SLOPE
from hydrosim.jit.kernels import kernel, root
from hydrosim.modes import (
    CONTACT_MARGIN,
    FRICTION_MARGIN,
    MARGINS,
    MODE,
    NO_INDEX,
    RISING,
    RISING_MARGIN,
    SEGMENT,
    SEGMENT_MARGIN,
)
from hydrosim.multibody.vectors import length

REGAINED = 1e3  # of the least prescribed N at which contact ends: above it contact begins again
LULL = 1e-9  # 1/s, of the reference load: slower changes of the load do not count
# steps in which a fast node relaxes; number of times before it is settled
FAST, RELAXATIONS = 10, 3


@kernel
def find_margins(t, y, modes, motion, bodies, p, headings, reactions, watched, out):
    """Margins ``out`` (4 to a row of modes) of all points, negative where a mode has ended. Only
    rows with non-zero ``watched`` are computed."""
    for i in range(p.points.size):
        point, row = p.points[i], p.mode + i
        m = MARGINS * row
        if watched[row] == 0:
            continue
        c, k, mode = (
            geometry.contact_kinematics(point, bodies, motion),
            p.state + fender.CONTACT_STATES * i,
            modes[row],
        )
        out[m + FRICTION_MARGIN] = out[m + SEGMENT_MARGIN] = out[m + RISING_MARGIN] = 1.0
        if mode[MODE] == OPEN:
            out[m + CONTACT_MARGIN] = _open_margin(t, mode, point, c, p)
            continue
        load, s, v = fender.normal_load_of(i, t, y, modes, c, p), (y[k], y[k + 1]), c.velocity
        heading, reaction = (headings[i, 0], headings[i, 1]), (reactions[i, 0], reactions[i, 1])
        grip = laws.margin(mode[MODE], load, v, s, heading, reaction, point)
        out[m + CONTACT_MARGIN] = _contact_margin(t, mode[MODE], point, mode[SEGMENT], c, p)
        out[m + FRICTION_MARGIN] = grip
        if mode[SEGMENT] == point.line:
            start = y[fender.memory_start(point, p) + curves.BRANCH_START]
            out[m + SEGMENT_MARGIN] = curves.inside_reload_branch(
                start, c.compression, point, p.segments
            )
        else:
            piece = p.segments[mode[SEGMENT]]
            out[m + SEGMENT_MARGIN] = curves.segment_margin(piece, c.compression)
        if point.line != NO_INDEX and mode[SEGMENT] != point.line:
            onward = c.rate if mode[SEGMENT] <= point.last else -c.rate
            out[m + RISING_MARGIN] = onward + point.leeway
        elif point.reference > 0.0:
            lull = LULL * point.reference
            out[m + RISING_MARGIN] = (load.rate if load.rising else -load.rate) + lull


@kernel
def _contact_margin(t, mode, point, segment, contact, p):
    """min(k delta, N), or N minus its least value if it is prescribed: positive in contact. For a
    closed point also k times its distance from the edge."""
    held = _pressed_margin(t, mode, point, segment, contact, p)
    if mode != OPEN and not point.prescribed and geometry.ends_somewhere(point):
        held = min(held, point.steepest * geometry.distance_inside(point, contact, p.edges))
    return held


@kernel
def _pressed_margin(t, mode, point, segment, contact, p):
    """The margin of contact without the edge."""
    held = point.steepest * contact.compression
    if point.line == NO_INDEX:  # on a loop N is not negative
        N = fender.normal_load(t, point, p.segments[segment], 0.0, 0, contact, p).N
        # not N: a force that reaches exactly zero and stays there also ends contact
        if point.prescribed:
            return N - (REGAINED * point.least if mode == OPEN else point.least)
        held = min(held, N)
    return held


@kernel
def _open_margin(t, mode, point, contact, p):
    """Positive while an open point stays open, or stays behind its plane after passing the edge."""
    if mode[RISING] == ABSENT:
        return 1.0
    if mode[RISING] == PASSED:
        return point.steepest * contact.compression
    return -_contact_margin(t, OPEN, point, _find_segment(point, contact, p), contact, p)


@kernel
def _find_segment(point, contact, p):
    """Index of the segment of its curve that holds a point."""
    return curves.find_segment(point.first, point.last, p.segments, contact.compression)


@kernel
def find_slip_directions(t, y, modes, motion, bodies, p, out):
    """Unit vectors ``out`` (n, 2) along the traction, or the velocity, of all slipping points; laws
    without a node keep theirs in y."""
    for i in range(p.points.size):
        point, k = p.points[i], p.state + fender.CONTACT_STATES * i
        x = y[k : k + fender.CONTACT_STATES]
        if modes[p.mode + i, MODE] != SLIP or not (point.node or laws.keeps_slip_direction(point)):
            continue
        c = geometry.contact_kinematics(point, bodies, motion)
        a = laws.slip_direction(
            fender.normal_load_of(i, t, y, modes, c, p), c.velocity, (x[0], x[1]), point
        )
        size, keeps_direction, has_direction = (
            length(a),
            laws.keeps_slip_direction(point),
            x[0] != 0.0 or x[1] != 0.0,
        )
        if keeps_direction and has_direction and size <= AT_REST:
            out[i, 0], out[i, 1] = x[0], x[1]
        elif size > 0.0:
            out[i, 0], out[i, 1] = a[0] / size, a[1] / size
            turned = out[i, 0] * x[0] + out[i, 1] * x[1] <= 0.0
            if keeps_direction and not (has_direction and turned):
                x[0], x[1] = out[i, 0], out[i, 1]


@root
def transition(i, which, size, step, t, y, modes, motion, bodies, reactions, p):
    """Switch point ``i`` to its next mode, after margin ``which``, which had this ``size`` before
    or after, has reached zero. A node that relaxes in few steps of length ``step`` is settled a
    while later."""
    c, mode, point = (
        geometry.contact_kinematics(p.points[i], bodies, motion),
        modes[p.mode + i],
        p.points[i],
    )
    if which == SEGMENT_MARGIN and mode[SEGMENT] == point.line:
        _end_reload_branch(i, y, modes, c, p)
    elif which == SEGMENT_MARGIN:
        k = mode[SEGMENT]
        mode[SEGMENT] = curves.next_segment(k, p.segments[k], c.compression)
    elif which == RISING_MARGIN:
        if point.line != NO_INDEX and mode[SEGMENT] != point.line:
            _start_reload_branch(i, t, y, modes, c, p)
        if point.reference > 0.0:
            _reverse_load(i, t, y, modes, c, p)
    elif which == FRICTION_MARGIN and mode[MODE] == STICK:
        _break_away(i, t, y, modes, c, reactions, p)
    elif which == FRICTION_MARGIN:
        _stick_point(i, size, t, y, modes, c, p)
    elif mode[MODE] == OPEN and mode[RISING] == PASSED:
        mode[RISING] = 0
    elif mode[MODE] == OPEN and geometry.distance_inside(point, c, p.edges) <= 0.0:
        mode[RISING] = PASSED
    elif mode[MODE] == OPEN:
        _close_point(i, t, y, modes, c, p)
    else:
        _open_point(i, t, y, modes, c, p)
    if mode[MODE] != STICK and point.relaxation < FAST * step:
        y[p.state + fender.CONTACT_STATES * i + fender.SETTLED] = t + RELAXATIONS * point.relaxation


@root
def _start_reload_branch(i, t, y, modes, contact, p):
    """The motion reverses on a branch of a loop: the stiff line begins here."""
    point, mode = p.points[i], modes[p.mode + i]
    k, N = fender.memory_start(point, p), fender.normal_load_of(i, t, y, modes, contact, p).elastic
    y[k + curves.LOOP_LOSS] += curves.branch_loss(
        mode[SEGMENT], contact.compression, point, p.segments
    )
    y[k + curves.BRANCH_START] = curves.reload_start(N, contact.compression, point, p.segments)
    y[k + curves.LARGEST_NORMAL] = max(y[k + curves.LARGEST_NORMAL], N)
    mode[SEGMENT] = point.line


@root
def _end_reload_branch(i, y, modes, contact, p):
    """A branch of a loop begins; its losses are counted from here."""
    point, mode = p.points[i], modes[p.mode + i]
    k, x = fender.memory_start(point, p), contact.compression
    mode[SEGMENT] = curves.segment_after_reload(y[k + curves.BRANCH_START], x, point, p.segments)
    y[k + curves.LOOP_LOSS] -= curves.branch_loss(mode[SEGMENT], x, point, p.segments)


@root
def _reverse_load(i, t, y, modes, contact, p):
    """The load begins to fall, or to rise again: the traction is kept."""
    k, mode = p.state + fender.CONTACT_STATES * i, modes[p.mode + i]
    load, x = fender.normal_load_of(i, t, y, modes, contact, p), y[k : k + fender.CONTACT_STATES]
    x[0], x[1] = laws.reverse_load(load, (x[0], x[1]), p.points[i])
    mode[RISING] = 1 - mode[RISING]


@kernel
def _break_away(i, t, y, modes, contact, reactions, p):
    """Slip begins."""
    k, reaction = p.state + fender.CONTACT_STATES * i, (reactions[i, 0], reactions[i, 1])
    x = y[k : k + fender.CONTACT_STATES]
    load, v = fender.normal_load_of(i, t, y, modes, contact, p), contact.velocity
    (x[0], x[1]), jump, lost = laws.break_away(load, v, (x[0], x[1]), reaction, p.points[i])
    x[fender.SLIP_DISTANCE] += jump
    x[fender.DISSIPATED] += lost
    modes[p.mode + i, MODE] = SLIP


@kernel
def _stick_point(i, size, t, y, modes, contact, p):
    """Slip ends."""
    k = p.state + fender.CONTACT_STATES * i
    load, x = fender.normal_load_of(i, t, y, modes, contact, p), y[k : k + fender.CONTACT_STATES]
    mode, (x[0], x[1]) = laws.end_slip(size, load, contact.velocity, (x[0], x[1]), p.points[i])
    modes[p.mode + i, MODE] = mode


@root
def _close_point(i, t, y, modes, contact, p):
    """Contact begins."""
    k, mode, point = p.state + fender.CONTACT_STATES * i, modes[p.mode + i], p.points[i]
    segment, x = _find_segment(point, contact, p), y[k : k + fender.CONTACT_STATES]
    load = fender.normal_load(t, point, p.segments[segment], 0.0, 0, contact, p)
    mode[SEGMENT], mode[RISING] = segment, 1 if load.rate > 0.0 else 0
    mode[MODE], (x[0], x[1]) = laws.begin_contact(load, contact.velocity, (x[0], x[1]), point)
    x[fender.DISSIPATED] -= fender.stored_along_normal(i, t, y, modes, contact, p)
    if point.memory != NO_INDEX:
        first = fender.memory_start(point, p)
        y[first + curves.LOOP_LOSS] -= curves.branch_loss(
            segment, contact.compression, point, p.segments
        )
        y[first + curves.CLOSINGS] += 1.0
        y[first + curves.CLOSING_SPEED], y[first + curves.LARGEST_NORMAL] = contact.rate, load.N
    group.record_closing(t, contact.rate, y, point, p)


@kernel
def _open_point(i, t, y, modes, contact, p):
    """Contact ends. Energy still in the normal curve, because its damper pulled or the plane has
    ended, is lost."""
    k, mode, point = p.state + fender.CONTACT_STATES * i, modes[p.mode + i], p.points[i]
    x = y[k : k + fender.CONTACT_STATES]
    x[fender.DISSIPATED] += fender.stored_along_normal(i, t, y, modes, contact, p)
    load = fender.normal_load_of(i, t, y, modes, contact, p)
    (x[0], x[1]), lost = laws.end_contact(mode[MODE], load, contact.velocity, (x[0], x[1]), point)
    x[fender.DISSIPATED] += lost
    if point.memory != NO_INDEX:
        y[fender.memory_start(point, p) + curves.LOOP_LOSS] += curves.branch_loss(
            mode[SEGMENT], contact.compression, point, p.segments
        )
    passed = _goes_over_edge(t, mode, point, contact, p)
    mode[MODE], mode[SEGMENT] = OPEN, point.first
    mode[RISING] = PASSED if passed else 0
    group.record_opening(t, y, modes, point, p)


@kernel
def _goes_over_edge(t, mode, point, contact, p):
    """True if contact ends because the plane ends. The end is located to a tolerance, so the point
    may still be inside by that; it is pressed then, and would close again at once."""
    inside = geometry.distance_inside(point, contact, p.edges)
    if inside <= 0.0:
        return True
    if point.prescribed or not geometry.ends_somewhere(point):
        return False
    pressed_by = _pressed_margin(t, mode[MODE], point, mode[SEGMENT], contact, p)
    return point.steepest * inside < pressed_by


@kernel
def break_loose(t, y, modes, motion, bodies, p, reactions):
    """Let the first point slip whose reaction exceeds the limit of rigid friction, if any."""
    for i in range(p.points.size):
        point = p.points[i]
        if point.law == COULOMB and modes[p.mode + i, MODE] == STICK:
            c = geometry.contact_kinematics(point, bodies, motion)
            held = point.static * fender.normal_load_of(i, t, y, modes, c, p).N
            if length((reactions[i, 0], reactions[i, 1])) > held:
                _break_away(i, t, y, modes, c, reactions, p)
                return True
    return False


@root
def recheck_after_impact(t, y, modes, motion, bodies, headings, reactions, p):
    """Test all points in contact again, after velocities have jumped: stick that cannot hold breaks
    away, slip that has reversed against its ``headings`` (n, 2) ends. Points of rigid friction
    bear no impulse, because their normal force is finite: they slide if they move."""
    for i in range(p.points.size):
        mode = modes[p.mode + i]
        if mode[MODE] == OPEN:
            continue
        point = p.points[i]
        c = geometry.contact_kinematics(point, bodies, motion)
        load = fender.normal_load_of(i, t, y, modes, c, p)
        x = y[p.state + fender.CONTACT_STATES * i : p.state + fender.CONTACT_STATES * (i + 1)]
        if point.law == COULOMB:
            mode[MODE], (x[0], x[1]) = laws.begin_contact(load, c.velocity, (x[0], x[1]), point)
            continue
        heading = (headings[i, 0], headings[i, 1])
        if laws.margin(mode[MODE], load, c.velocity, (x[0], x[1]), heading, (0.0, 0.0), point) < 0:
            if mode[MODE] == STICK:
                _break_away(i, t, y, modes, c, reactions, p)
            else:
                _stick_point(i, 0.0, t, y, modes, c, p)


@kernel
def has_load_limit(modes, p):
    """True if any point sticks so firmly that its motion does not show its load."""
    for i in range(p.points.size):
        firm = p.points[i].law in (COULOMB, FRICTION_SLOPE)
        if firm and modes[p.mode + i, MODE] == STICK:
            return True
    return False


@kernel
def has_fast_transient(t, y, p):
    """True if any node still relaxes fast after an event."""
    for i in range(p.points.size):
        if t < y[p.state + fender.CONTACT_STATES * i + fender.SETTLED]:
            return True
    return False


@root
def set_initial_modes(t, y, modes, motion, bodies, p):
    """Modes of all points for a start from ``y``: open, or stick or slip by the margins."""
    for i in range(p.points.size):
        activate(i, t, y, modes, motion, bodies, p)
        reset_losses(i, y, p)
        c = geometry.contact_kinematics(p.points[i], bodies, motion)
        if modes[p.mode + i, MODE] == OPEN:  # energy left by a damper is lost gradually
            y[p.state + fender.CONTACT_STATES * i + fender.DISSIPATED] = fender.residual_energy(
                i, modes, c, p
            )


@kernel
def activate(i, t, y, modes, motion, bodies, p):
    """Activate point ``i`` at its present position; on a loop it starts at rest."""
    point, mode = p.points[i], modes[p.mode + i]
    mode[MODE], mode[SEGMENT], mode[RISING] = OPEN, point.first, 0
    c = geometry.contact_kinematics(point, bodies, motion)
    if _contact_margin(t, OPEN, point, _find_segment(point, c, p), c, p) <= 0.0:
        return
    if geometry.distance_inside(point, c, p.edges) <= 0.0:
        mode[RISING] = PASSED
        return
    _close_point(i, t, y, modes, c, p)
    if point.line != NO_INDEX:
        _start_reload_branch(i, t, y, modes, c, p)


@kernel
def reset_losses(i, y, p):
    """Reset the losses of point ``i`` so far, and its memory of closing."""
    point = p.points[i]
    y[p.state + fender.CONTACT_STATES * i + fender.DISSIPATED] = 0.0
    if point.memory != NO_INDEX:
        k = fender.memory_start(point, p)
        y[k + curves.LOOP_LOSS] = y[k + curves.CLOSINGS] = y[k + curves.CLOSING_SPEED] = 0.0


@kernel
def deactivate(i, t, y, modes, motion, bodies, p):
    """Deactivate point ``i``."""
    if modes[p.mode + i, MODE] != OPEN:
        _open_point(i, t, y, modes, geometry.contact_kinematics(p.points[i], bodies, motion), p)
    modes[p.mode + i, RISING] = ABSENT


@root
def record_largest(t, y, modes, motion, bodies, p):
    """Keep the largest normal force of every point in contact with memory, and for every group the
    largest force of a point and of all points together."""
    group.clear_loads(y, p)
    for i in range(p.points.size):
        point = p.points[i]
        if modes[p.mode + i, MODE] == OPEN or point.memory == point.group == NO_INDEX:
            continue
        N = fender.normal_load_of(
            i, t, y, modes, geometry.contact_kinematics(point, bodies, motion), p
        ).N
        if point.memory != NO_INDEX:
            k = fender.memory_start(point, p) + curves.LARGEST_NORMAL
            y[k] = max(y[k], N)
        if point.group != NO_INDEX:
            group.add_to_load(N, y, point, p)
