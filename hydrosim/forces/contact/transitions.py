"""When a contact point changes its mode, and into which.

A mode holds while its margins are positive:

    contact   min(k delta, N), its opposite when open      k: the curve's steepest slope; if N is
                                                           prescribed, N less 1e-12 of its largest
    friction  of the friction law                          in contact
    segment   distance to the nearer corner of the curve   in contact
    rising    N_e', its opposite where the load falls      in contact, if K2 goes with the load
"""

from __future__ import annotations

from hydrosim.forces.contact import (
    coulomb,
    friction_slope,
    frictionless,
    geometry,
    normal,
    stick_slip,
)
from hydrosim.forces.contact.fender import (
    COULOMB,
    DISSIPATED,
    FRICTION_SLOPE,
    FRICTIONLESS,
    SLIP_DISTANCE,
    STATES,
    STICK_SLIP,
    pressed,
    pressure,
    stored_along_normal,
)
from hydrosim.forces.contact.modes import (
    CONTACT_MARGIN,
    FRICTION_MARGIN,
    MARGINS,
    MODE,
    OPEN,
    RISING,
    RISING_MARGIN,
    SEGMENT,
    SEGMENT_MARGIN,
    SLIP,
    STICK,
)
from hydrosim.jit.kernels import kernel, root
from hydrosim.rigid.vectors import length

AT_REST = 1e-6  # of the speed that the end of slip was located by: slip has come to rest
LULL = 1e-9  # 1/s, of the reference load: it rises or falls faster than that


@kernel
def margins(t, y, modes, motion, bodies, p, headings, reactions, watched, out):
    """Margins ``out`` (4 n,) of the modes of points, negative where a mode has ended: of those that
    are ``watched`` (n,), not zero."""
    for i in range(p.points.size):
        point, k, m = p.points[i], p.state + STATES * i, MARGINS * i
        if watched[i] == 0:
            continue
        c = geometry.touch(point, bodies, motion)
        out[m + FRICTION_MARGIN] = out[m + SEGMENT_MARGIN] = out[m + RISING_MARGIN] = 1.0
        if modes[i, MODE] == OPEN:
            out[m + CONTACT_MARGIN] = -_contact_margin(t, point, _find_segment(point, c, p), c, p)
            continue
        load, s = pressure(i, t, modes, c, p), (y[k], y[k + 1])
        heading, reaction = (headings[i, 0], headings[i, 1]), (reactions[i, 0], reactions[i, 1])
        grip = _friction_margin(modes[i, MODE], load, c.velocity, s, heading, reaction, point)
        out[m + CONTACT_MARGIN] = _contact_margin(t, point, modes[i, SEGMENT], c, p)
        out[m + FRICTION_MARGIN] = grip
        out[m + SEGMENT_MARGIN] = normal.inside_segment(
            p.segments[modes[i, SEGMENT]], c.compression
        )
        if point.reference > 0.0:
            lull = LULL * point.reference
            out[m + RISING_MARGIN] = (load.rate if load.rising else -load.rate) + lull


@kernel
def _friction_margin(mode, load, v1, s, heading, reaction, point):
    """How far a point is from leaving stick or slip."""
    if point.law == STICK_SLIP:
        return stick_slip.margin(mode, load, v1, s, heading, point)
    if point.law == FRICTION_SLOPE:
        return friction_slope.margin(mode, load, v1, heading, point)
    if point.law == COULOMB:
        return coulomb.margin(mode, load, v1, s, reaction, point)
    return frictionless.margin(mode)


@kernel
def _contact_margin(t, point, segment, contact, p):
    """min(k delta, N), or what N is above the least, if it is prescribed: positive in contact."""
    N = pressed(t, point, p.segments[segment], 0, contact, p).N
    if point.prescribed:
        return N - point.least  # not N: a force that ends at exactly zero and stays there ends
    return min(point.steepest * contact.compression, N)


@kernel
def _find_segment(point, contact, p):
    """Index of the segment of its curve that a point is on."""
    return normal.find_segment(point.first, point.last, p.segments, contact.compression)


@kernel
def find_headings(t, y, modes, motion, bodies, p, out):
    """Unit vectors ``out`` (n, 2) along the traction, or the velocity, of all points that slip;
    laws without a node keep theirs in y."""
    for i in range(p.points.size):
        point, k = p.points[i], p.state + STATES * i
        if modes[i, MODE] != SLIP or point.law == FRICTIONLESS:
            continue
        c = geometry.touch(point, bodies, motion)
        a = c.velocity
        if point.law == STICK_SLIP:
            a = stick_slip.traction(pressure(i, t, modes, c, p), a, (y[k], y[k + 1]), point)
        size = length(a)
        if size > 0.0:
            out[i, 0], out[i, 1] = a[0] / size, a[1] / size
            turned = out[i, 0] * y[k] + out[i, 1] * y[k + 1] <= 0.0
            unknown = y[k] == 0.0 and y[k + 1] == 0.0
            if point.law != STICK_SLIP and (unknown or not turned):
                y[k], y[k + 1] = out[i, 0], out[i, 1]


@root
def switch(i, which, size, t, y, modes, motion, bodies, reactions, p):
    """Put point ``i`` into the mode that follows when margin ``which``, which was of this ``size``
    before or after, has reached zero."""
    c = geometry.touch(p.points[i], bodies, motion)
    if which == SEGMENT_MARGIN:
        k = modes[i, SEGMENT]
        modes[i, SEGMENT] = normal.next_segment(k, p.segments[k], c.compression)
    elif which == RISING_MARGIN:
        _turn_over(i, t, y, modes, c, p)
    elif which == FRICTION_MARGIN and modes[i, MODE] == STICK:
        _break_away(i, t, y, modes, c, reactions, p)
    elif which == FRICTION_MARGIN:
        _grip(i, size, y, modes, c, p)
    elif modes[i, MODE] == OPEN:
        _close(i, t, y, modes, c, p)
    else:
        _open(i, t, y, modes, c, p)


@kernel
def _turn_over(i, t, y, modes, contact, p):
    """The load begins to fall, or to rise again: the traction stays."""
    k, load = p.state + STATES * i, pressure(i, t, modes, contact, p)
    y[k], y[k + 1] = stick_slip.turn_over(load, (y[k], y[k + 1]), p.points[i])
    modes[i, RISING] = 1 - modes[i, RISING]


@kernel
def _break_away(i, t, y, modes, contact, reactions, p):
    """Slip begins; in the rate-free limit the node jumps."""
    k, point = p.state + STATES * i, p.points[i]
    if point.law == COULOMB:
        size = length((reactions[i, 0], reactions[i, 1]))
        y[k], y[k + 1] = -reactions[i, 0] / size, -reactions[i, 1] / size
    if point.law == FRICTION_SLOPE:
        y[k], y[k + 1] = coulomb.direction(contact.velocity, (0.0, 0.0))
    if point.law == STICK_SLIP:
        load, before = pressure(i, t, modes, contact, p), length((y[k], y[k + 1]))
        (y[k], y[k + 1]), lost = stick_slip.break_away(load, (y[k], y[k + 1]), point)
        y[k + SLIP_DISTANCE] += before - length((y[k], y[k + 1]))
        y[k + DISSIPATED] += lost
    modes[i, MODE] = SLIP


@kernel
def _grip(i, size, y, modes, contact, p):
    """Slip ends, unless a rigid point has only turned out of the half plane of its heading."""
    k, v = p.state + STATES * i, contact.velocity
    speed = length(v)
    if p.points[i].law != COULOMB or speed <= AT_REST * size:
        modes[i, MODE] = STICK
    else:
        y[k], y[k + 1] = v[0] / speed, v[1] / speed


@kernel
def _close(i, t, y, modes, contact, p):
    """Contact begins: the mode is the one whose margin is positive."""
    k, point, v = p.state + STATES * i, p.points[i], contact.velocity
    segment = _find_segment(point, contact, p)
    load = pressed(t, point, p.segments[segment], 0, contact, p)
    modes[i, SEGMENT], modes[i, RISING] = segment, 1 if load.rate > 0.0 else 0
    if point.law == COULOMB:
        held = v[0] == 0.0 and v[1] == 0.0
        y[k], y[k + 1] = coulomb.direction(v, (0.0, 0.0))
    else:
        zero, s = (0.0, 0.0), (y[k], y[k + 1])
        held = _friction_margin(STICK, load, v, s, zero, zero, point) >= 0.0
    if point.law == FRICTION_SLOPE:
        y[k], y[k + 1] = coulomb.direction(v, (0.0, 0.0))
    modes[i, MODE] = STICK if held else SLIP
    y[k + DISSIPATED] -= stored_along_normal(i, modes, contact, p)


@kernel
def _open(i, t, y, modes, contact, p):
    """Contact ends: what the normal curve still holds, because its damper pulled, is lost, and so
    is the stretch of a node that springs back at once, without a damper or a stiffness."""
    k, point = p.state + STATES * i, p.points[i]
    y[k + DISSIPATED] += stored_along_normal(i, modes, contact, p)
    if point.law == STICK_SLIP and (point.damping == 0.0 or point.reference > 0.0):
        load, s = pressure(i, t, modes, contact, p), (y[k], y[k + 1])
        stored, lent = stick_slip.stored_energy(load, s, point), stick_slip.lent(load, s, point)
        y[k + DISSIPATED] += stored - lent
        y[k], y[k + 1] = 0.0, 0.0
    modes[i, MODE], modes[i, SEGMENT], modes[i, RISING] = OPEN, point.first, 0


@kernel
def break_loose(t, y, modes, motion, bodies, p, reactions):
    """Let the first point slip whose reaction is more than rigid friction can hold, if any."""
    for i in range(p.points.size):
        point = p.points[i]
        if point.law == COULOMB and modes[i, MODE] == STICK:
            c = geometry.touch(point, bodies, motion)
            held = point.static * pressure(i, t, modes, c, p).N
            if length((reactions[i, 0], reactions[i, 1])) > held:
                _break_away(i, t, y, modes, c, reactions, p)
                return True
    return False


@root
def settle(t, y, modes, motion, bodies, p):
    """Modes of all points for a start from ``y``: open, or stick or slip by the margins."""
    for i in range(p.points.size):
        point = p.points[i]
        modes[i, MODE], modes[i, SEGMENT], modes[i, RISING] = OPEN, point.first, 0
        c = geometry.touch(point, bodies, motion)
        if _contact_margin(t, point, _find_segment(point, c, p), c, p) > 0.0:
            _close(i, t, y, modes, c, p)
            y[p.state + STATES * i + DISSIPATED] = 0.0  # what is stored at the start was there
