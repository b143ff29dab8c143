"""When a contact point changes its mode, and into which.

A mode holds while its margins are positive:

    contact   min(k delta, N), its opposite when open      k: the curve's steepest slope; if N is
                                                           prescribed, N less 1e-12 of its largest,
                                                           or less 1e-9 of that when open, so that
                                                           an N which touches zero lets go once
    friction  of the friction law                          in contact
    segment   distance to the nearer corner of the curve   in contact
    rising    N_e', its opposite where the load falls      in contact, if K2 goes with the load

What follows a mode that has ended is the friction law's own affair (`laws`).
"""

from __future__ import annotations

from hydrosim.forces import curve
from hydrosim.forces.contact import geometry, laws
from hydrosim.forces.contact.fender import (
    DISSIPATED,
    SETTLED,
    SLIP_DISTANCE,
    STATES,
    left_behind,
    pressed,
    pressure,
    stored_along_normal,
)
from hydrosim.forces.contact.law import AT_REST
from hydrosim.forces.contact.laws import COULOMB
from hydrosim.forces.modes import (
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

REGAINED = 1e3  # of the least prescribed N at which contact ends: then it begins again
LULL = 1e-9  # 1/s, of the reference load: it rises or falls faster than that
FAST, RELAXATIONS = 10, 3  # steps that a fast node relaxes in; how often until it is settled


@kernel
def margins(t, y, modes, motion, bodies, p, headings, reactions, watched, out):
    """Margins ``out`` (4 to a row of modes) of all points, negative where a mode has ended: of
    those whose row is ``watched``, not zero."""
    for i in range(p.points.size):
        point, row = p.points[i], p.mode + i
        m = MARGINS * row
        if watched[row] == 0:
            continue
        c, k, mode = geometry.touch(point, bodies, motion), p.state + STATES * i, modes[row]
        out[m + FRICTION_MARGIN] = out[m + SEGMENT_MARGIN] = out[m + RISING_MARGIN] = 1.0
        if mode[MODE] == OPEN:
            segment = _find_segment(point, c, p)
            out[m + CONTACT_MARGIN] = -_contact_margin(t, OPEN, point, segment, c, p)
            continue
        load, s, v = pressure(i, t, modes, c, p), (y[k], y[k + 1]), c.velocity
        heading, reaction = (headings[i, 0], headings[i, 1]), (reactions[i, 0], reactions[i, 1])
        grip = laws.margin(mode[MODE], load, v, s, heading, reaction, point)
        out[m + CONTACT_MARGIN] = _contact_margin(t, mode[MODE], point, mode[SEGMENT], c, p)
        out[m + FRICTION_MARGIN] = grip
        out[m + SEGMENT_MARGIN] = curve.inside_segment(p.segments[mode[SEGMENT]], c.compression)
        if point.reference > 0.0:
            lull = LULL * point.reference
            out[m + RISING_MARGIN] = (load.rate if load.rising else -load.rate) + lull


@kernel
def _contact_margin(t, mode, point, segment, contact, p):
    """min(k delta, N), or what N is above the least, if it is prescribed: positive in contact."""
    N = pressed(t, point, p.segments[segment], 0, contact, p).N
    if point.prescribed:  # not N: a force that ends at exactly zero and stays there ends
        return N - (REGAINED * point.least if mode == OPEN else point.least)
    return min(point.steepest * contact.compression, N)


@kernel
def _find_segment(point, contact, p):
    """Index of the segment of its curve that a point is on."""
    return curve.find_segment(point.first, point.last, p.segments, contact.compression)


@kernel
def find_headings(t, y, modes, motion, bodies, p, out):
    """Unit vectors ``out`` (n, 2) along the traction, or the velocity, of all points that slip;
    laws without a node keep theirs in y."""
    for i in range(p.points.size):
        point, k = p.points[i], p.state + STATES * i
        x = y[k : k + STATES]
        if modes[p.mode + i, MODE] != SLIP or not (point.node or laws.keeps_heading(point)):
            continue
        c = geometry.touch(point, bodies, motion)
        a = laws.heading(pressure(i, t, modes, c, p), c.velocity, (x[0], x[1]), point)
        size, kept, known = length(a), laws.keeps_heading(point), x[0] != 0.0 or x[1] != 0.0
        if kept and known and size <= AT_REST:
            out[i, 0], out[i, 1] = x[0], x[1]
        elif size > 0.0:
            out[i, 0], out[i, 1] = a[0] / size, a[1] / size
            turned = out[i, 0] * x[0] + out[i, 1] * x[1] <= 0.0
            if kept and not (known and turned):
                x[0], x[1] = out[i, 0], out[i, 1]


@root
def switch(i, which, size, step, t, y, modes, motion, bodies, reactions, p):
    """Put point ``i`` into the mode that follows when margin ``which``, which was of this ``size``
    before or after, has reached zero. A node that relaxes in few steps of length ``step`` is
    settled only a while later."""
    c, mode, point = geometry.touch(p.points[i], bodies, motion), modes[p.mode + i], p.points[i]
    if which == SEGMENT_MARGIN:
        k = mode[SEGMENT]
        mode[SEGMENT] = curve.next_segment(k, p.segments[k], c.compression)
    elif which == RISING_MARGIN:
        _turn_over(i, t, y, modes, c, p)
    elif which == FRICTION_MARGIN and mode[MODE] == STICK:
        _break_away(i, t, y, modes, c, reactions, p)
    elif which == FRICTION_MARGIN:
        _grip(i, size, t, y, modes, c, p)
    elif mode[MODE] == OPEN:
        _close(i, t, y, modes, c, p)
    else:
        _open(i, t, y, modes, c, p)
    if mode[MODE] != STICK and point.relaxation < FAST * step:
        y[p.state + STATES * i + SETTLED] = t + RELAXATIONS * point.relaxation


@kernel
def _turn_over(i, t, y, modes, contact, p):
    """The load begins to fall, or to rise again: the traction stays."""
    k, mode = p.state + STATES * i, modes[p.mode + i]
    load, x = pressure(i, t, modes, contact, p), y[k : k + STATES]
    x[0], x[1] = laws.turn_over(load, (x[0], x[1]), p.points[i])
    mode[RISING] = 1 - mode[RISING]


@kernel
def _break_away(i, t, y, modes, contact, reactions, p):
    """Slip begins."""
    k, reaction = p.state + STATES * i, (reactions[i, 0], reactions[i, 1])
    x = y[k : k + STATES]
    load, v = pressure(i, t, modes, contact, p), contact.velocity
    (x[0], x[1]), jump, lost = laws.break_away(load, v, (x[0], x[1]), reaction, p.points[i])
    x[SLIP_DISTANCE] += jump
    x[DISSIPATED] += lost
    modes[p.mode + i, MODE] = SLIP


@kernel
def _grip(i, size, t, y, modes, contact, p):
    """Slip ends."""
    k = p.state + STATES * i
    load, x = pressure(i, t, modes, contact, p), y[k : k + STATES]
    mode, (x[0], x[1]) = laws.grip(size, load, contact.velocity, (x[0], x[1]), p.points[i])
    modes[p.mode + i, MODE] = mode


@kernel
def _close(i, t, y, modes, contact, p):
    """Contact begins."""
    k, mode, point = p.state + STATES * i, modes[p.mode + i], p.points[i]
    segment, x = _find_segment(point, contact, p), y[k : k + STATES]
    load = pressed(t, point, p.segments[segment], 0, contact, p)
    mode[SEGMENT], mode[RISING] = segment, 1 if load.rate > 0.0 else 0
    mode[MODE], (x[0], x[1]) = laws.close(load, contact.velocity, (x[0], x[1]), point)
    x[DISSIPATED] -= stored_along_normal(i, modes, contact, p)


@kernel
def _open(i, t, y, modes, contact, p):
    """Contact ends: what the normal curve still holds, because its damper pulled, is lost."""
    k, mode, point = p.state + STATES * i, modes[p.mode + i], p.points[i]
    x = y[k : k + STATES]
    x[DISSIPATED] += stored_along_normal(i, modes, contact, p)
    load = pressure(i, t, modes, contact, p)
    (x[0], x[1]), lost = laws.release(mode[MODE], load, contact.velocity, (x[0], x[1]), point)
    x[DISSIPATED] += lost
    mode[MODE], mode[SEGMENT], mode[RISING] = OPEN, point.first, 0


@kernel
def break_loose(t, y, modes, motion, bodies, p, reactions):
    """Let the first point slip whose reaction is more than rigid friction can hold, if any."""
    for i in range(p.points.size):
        point = p.points[i]
        if point.law == COULOMB and modes[p.mode + i, MODE] == STICK:
            c = geometry.touch(point, bodies, motion)
            held = point.static * pressure(i, t, modes, c, p).N
            if length((reactions[i, 0], reactions[i, 1])) > held:
                _break_away(i, t, y, modes, c, reactions, p)
                return True
    return False


@kernel
def settling(t, y, p):
    """Whether any node still relaxes fast after an event."""
    for i in range(p.points.size):
        if t < y[p.state + STATES * i + SETTLED]:
            return True
    return False


@root
def settle(t, y, modes, motion, bodies, p):
    """Modes of all points for a start from ``y``: open, or stick or slip by the margins."""
    for i in range(p.points.size):
        point, mode = p.points[i], modes[p.mode + i]
        mode[MODE], mode[SEGMENT], mode[RISING] = OPEN, point.first, 0
        c = geometry.touch(point, bodies, motion)
        if _contact_margin(t, OPEN, point, _find_segment(point, c, p), c, p) > 0.0:
            _close(i, t, y, modes, c, p)
            y[p.state + STATES * i + DISSIPATED] = 0.0  # what is stored at the start was there
        else:
            y[p.state + STATES * i + DISSIPATED] = left_behind(i, c, p)  # and is lost bit by bit
