"""Fender: points of a body against a plane, with a normal curve and a friction law each.

    F = N n + f,   on the plane's body the opposite at the same place

N: normal force along the plane's normal n (`normal`); f: friction in the plane (`stick_slip`,
`friction_slope` or none); both from compression, velocity and stretch (`geometry`). Every point has
a mode (open, stick, slip) and a segment of its curve. They change only at events: a mode holds
while its three margins are positive,

    contact   min(k delta, N), its opposite when open      k: the curve's steepest slope; N alone
                                                           if it is prescribed
    friction  of the friction law                          in contact
    segment   distance to the nearer corner of the curve   in contact

State per point: stretch s (2,), slip distance, energy lost in friction and where contact ends with
something still stored, and of that energy the parts lost in C2 and in C3 of a contact node. A point
without stretch (other laws) keeps s = 0. Stored energy: normal curve and stretch; dissipation:
normal damping, friction; a prescribed normal force stores nothing and what it takes from the body
counts as dissipation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import hypot
from typing import Any, NamedTuple

import numpy as np

from hydrosim.forces.contact import friction_slope, geometry, normal, stick_slip
from hydrosim.forces.contact.friction_slope import FrictionSlope
from hydrosim.forces.contact.modes import OPEN, SLIP, STICK
from hydrosim.forces.contact.normal import NormalCurve, PrescribedNormal
from hydrosim.forces.contact.stick_slip import Friction, StickSlip
from hydrosim.forces.layout import Layout
from hydrosim.kernels import clear, kernel
from hydrosim.scene import ForceElement

FRICTIONLESS, STICK_SLIP, FRICTION_SLOPE = range(3)
STATE_NAMES = (  # of each point
    *("stretch 1", "stretch 2", "slip distance"),
    *("friction loss", "damping loss", "slip damping loss"),
)
STATES = len(STATE_NAMES)
SLIP_DISTANCE, DISSIPATED, DAMPED, SLIP_DAMPED = range(2, STATES)
CONTACT_MARGIN, FRICTION_MARGIN, SEGMENT_MARGIN = range(3)
MARGINS = 3


@dataclass(frozen=True)
class Plane:
    """``point`` and ``normal`` (towards the free side), in the earth frame or that of ``body``."""

    point: tuple[float, ...]
    normal: tuple[float, ...]
    body: str | None = None


@dataclass(frozen=True)
class Frictionless:
    """No friction."""


@dataclass(frozen=True)
class Fender(ForceElement):
    """``points`` (n, 3) in the body frame; ``normal`` and ``friction`` hold for each of them."""

    points: np.ndarray
    plane: Plane
    normal: NormalCurve | PrescribedNormal
    friction: StickSlip | FrictionSlope | Frictionless


POINT = np.dtype(
    [
        *(("body", int), ("row", int), ("place", float, 3)),
        *geometry.PLANE,
        *(("first", int), ("last", int), ("steepest", float)),
        *(("prescribed", bool), ("normal_damping", float)),
        *(("law", int), ("static", float), ("kinetic", float)),
        *(("stiffness", float), ("damping", float), ("slip_damping", float)),
    ]
)
"""Constants of a contact point: its place on its body, its plane, the pieces ``first`` to ``last``
of its normal curve, its friction law."""


class Params(NamedTuple):
    """``points`` (n,) of `POINT`, the ``segments`` of their curves, and the first entry of their
    states in y."""

    points: np.ndarray
    segments: np.ndarray
    state: int


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> Params:
    """Constants of all contact points of the fenders among ``elements``, in their order."""
    rows, pieces, last = [], [np.zeros(0, dtype=normal.SEGMENT)], -1
    for name, e in elements.items():
        if isinstance(e, Fender):
            curve = normal.segments(e.normal)
            first, last = last + 1, last + curve.size
            pieces.append(curve)
            prescribed = isinstance(e.normal, PrescribedNormal)
            damping = 0.0 if isinstance(e.normal, PrescribedNormal) else e.normal.damping
            steepest = curve["slope"].max()
            shared = (first, last, steepest, prescribed, damping, *_law(e.friction))
            plane = _plane(e.plane, layout)
            rows += [(layout.body[e.body], layout.row[name], p, *plane, *shared) for p in e.points]
    return Params(np.array(rows, dtype=POINT), np.concatenate(pieces), layout.state)


def _plane(plane: Plane, layout: Layout) -> tuple[Any, ...]:
    n = np.array(plane.normal, dtype=float)
    n /= np.linalg.norm(n)
    body = layout.body[plane.body] if plane.body else geometry.EARTH
    return (body, plane.point, n, *geometry.tangents(n))


def _law(law: StickSlip | FrictionSlope | Frictionless) -> tuple[float, ...]:
    """Kind, mu_s, mu_k, K2, C2 (or the slope b), C3."""
    if isinstance(law, StickSlip):
        constants = (law.stiffness, law.damping, law.slip_damping)
        return (STICK_SLIP, law.static, law.kinetic, *constants)
    if isinstance(law, FrictionSlope):
        return (FRICTION_SLOPE, law.coefficient, law.coefficient, 0.0, law.slope, 0.0)
    return (FRICTIONLESS, 0.0, 0.0, 0.0, 0.0, 0.0)


@kernel
def add_force(t, y, modes, motion, bodies, p, wrench, rate, dy):
    """Force of every point into its row of ``wrench``, dissipation along the normal into ``rate``,
    the rates of stretch, slip distance and energy lost in friction into ``dy``."""
    for i in range(p.points.size):
        point, mode, k = p.points[i], modes[i, 0], p.state + STATES * i
        if mode == OPEN and point.law != STICK_SLIP:
            clear(dy[k : k + STATES])
            continue
        c = geometry.touch(point, bodies, motion)
        N, dN = pressure(t, point, mode, p.segments[modes[i, 1]], c)
        f = friction(mode, N, dN, c.velocity, (y[k], y[k + 1]), point)
        dy[k], dy[k + 1] = f.stretch_rate
        dy[k + SLIP_DISTANCE], dy[k + DISSIPATED] = f.slip_speed, f.dissipation
        stretching = f.stretch_rate[0] ** 2 + f.stretch_rate[1] ** 2
        dy[k + DAMPED] = point.damping * stretching
        dy[k + SLIP_DAMPED] = point.slip_damping * f.slip_speed**2
        if mode != OPEN:
            lost = N if point.prescribed else point.normal_damping * c.rate
            rate[point.row] += lost * c.rate
            geometry.press(point, c, N, f.force, wrench[point.row])


@kernel
def on_curve(t, point, contact):
    """Where a point is on its normal curve, x, and x': compression, or time if prescribed."""
    return (t, 1.0) if point.prescribed else (contact.compression, contact.rate)


@kernel
def pressure(t, point, mode, piece, contact):
    """Normal force N of a point on a piece of its curve and N', zero when open; not cut at zero, so
    that it is smooth across the event that ends the contact. N' leaves out normal damping."""
    if mode == OPEN:
        return 0.0, 0.0
    x, dx = on_curve(t, point, contact)
    damping = point.normal_damping * contact.rate
    return normal.curve_force(piece, x) + damping, piece.slope * dx


@kernel
def friction(mode, N, dN, v1, s, point):
    """Friction of a point by its law."""
    if point.law == STICK_SLIP:
        return stick_slip.friction(mode, N, dN, v1, s, point)
    if point.law == FRICTION_SLOPE:
        return friction_slope.friction(mode, N, dN, v1, s, point)
    return Friction((0.0, 0.0), (0.0, 0.0), hypot(v1[0], v1[1]) if mode == SLIP else 0.0, 0.0)


@kernel
def friction_margin(mode, N, dN, v1, s, heading, point):
    """How far a point is from leaving stick or slip; frictionless points always slip."""
    if point.law == STICK_SLIP:
        return stick_slip.margin(mode, N, dN, v1, s, heading, point)
    if point.law == FRICTION_SLOPE:
        return friction_slope.margin(mode, N, dN, v1, s, heading, point)
    return 1.0 if mode == SLIP else -1.0


@kernel
def contact_margin(t, point, piece, contact):
    """min(k delta, N), or N if it is prescribed: positive in contact."""
    N, _ = pressure(t, point, STICK, piece, contact)
    return N if point.prescribed else min(point.steepest * contact.compression, N)


@kernel
def find_piece(t, point, pieces, contact):
    """Index of the piece of its curve that a point is on."""
    x, _ = on_curve(t, point, contact)
    return normal.find_segment(point.first, point.last, pieces, x)


@kernel
def margins(t, y, modes, motion, bodies, p, headings, out):
    """Margins ``out`` (3 n,) of the modes of all points, negative where a mode has ended."""
    for i in range(p.points.size):
        point, mode, k, m = p.points[i], modes[i, 0], p.state + STATES * i, MARGINS * i
        c = geometry.touch(point, bodies, motion)
        if mode == OPEN:
            piece = p.segments[find_piece(t, point, p.segments, c)]
            out[m + CONTACT_MARGIN] = -contact_margin(t, point, piece, c)
            out[m + FRICTION_MARGIN] = out[m + SEGMENT_MARGIN] = 1.0
            continue
        piece, s = p.segments[modes[i, 1]], (y[k], y[k + 1])
        N, dN = pressure(t, point, mode, piece, c)
        out[m + CONTACT_MARGIN] = contact_margin(t, point, piece, c)
        heading = (headings[i, 0], headings[i, 1])
        out[m + FRICTION_MARGIN] = friction_margin(mode, N, dN, c.velocity, s, heading, point)
        out[m + SEGMENT_MARGIN] = normal.inside_segment(piece, on_curve(t, point, c)[0])


@kernel
def find_headings(y, modes, motion, bodies, p, out):
    """Unit vectors ``out`` (n, 2) along the traction, or the velocity, of all points that slip."""
    for i in range(p.points.size):
        point, k = p.points[i], p.state + STATES * i
        if modes[i, 0] != SLIP or point.law == FRICTIONLESS:
            continue
        a = geometry.touch(point, bodies, motion).velocity
        if point.law == STICK_SLIP:
            a = stick_slip.traction(a, (y[k], y[k + 1]), point)
        size = hypot(a[0], a[1])
        if size > 0.0:
            out[i, 0], out[i, 1] = a[0] / size, a[1] / size


@kernel
def switch(i, which, t, y, modes, motion, bodies, p):
    """Put point ``i`` into the mode that follows when margin ``which`` has reached zero."""
    point, c = p.points[i], geometry.touch(p.points[i], bodies, motion)
    if which == SEGMENT_MARGIN:
        piece, x = p.segments[modes[i, 1]], on_curve(t, point, c)[0]
        modes[i, 1] += 1 if piece.upper - x < x - piece.lower else -1
    elif which == FRICTION_MARGIN and modes[i, 0] == STICK:
        _break_away(i, t, y, modes, c, p)
    elif which == FRICTION_MARGIN:
        modes[i, 0] = STICK
    elif modes[i, 0] == OPEN:
        _close(i, t, y, modes, c, p)
    else:
        _open(i, y, modes, c, p)


@kernel
def _break_away(i, t, y, modes, contact, p):
    """Slip begins; in the rate-free limit the node jumps."""
    k, point = p.state + STATES * i, p.points[i]
    if point.law == STICK_SLIP:
        N, _ = pressure(t, point, STICK, p.segments[modes[i, 1]], contact)
        before = hypot(y[k], y[k + 1])
        (y[k], y[k + 1]), lost = stick_slip.break_away(N, (y[k], y[k + 1]), point)
        y[k + SLIP_DISTANCE] += before - hypot(y[k], y[k + 1])
        y[k + DISSIPATED] += lost
    modes[i, 0] = SLIP


@kernel
def _close(i, t, y, modes, contact, p):
    """Contact begins: the mode is the one whose margin is positive."""
    k, point = p.state + STATES * i, p.points[i]
    modes[i, 1] = find_piece(t, point, p.segments, contact)
    piece = p.segments[modes[i, 1]]
    N, dN = pressure(t, point, STICK, piece, contact)
    v, s = contact.velocity, (y[k], y[k + 1])
    held = friction_margin(STICK, N, dN, v, s, (0.0, 0.0), point) >= 0.0
    modes[i, 0] = STICK if held else SLIP
    y[k + DISSIPATED] -= _stored_along_normal(point, piece, contact)


@kernel
def _open(i, y, modes, contact, p):
    """Contact ends: what the normal curve still holds, because its damper pulled, is lost, and so
    is the stretch of a node without a damper, which springs back at once."""
    k, point = p.state + STATES * i, p.points[i]
    y[k + DISSIPATED] += _stored_along_normal(point, p.segments[modes[i, 1]], contact)
    modes[i, 0], modes[i, 1] = OPEN, point.first
    if point.law == STICK_SLIP and point.damping == 0.0:
        y[k + DISSIPATED] += stick_slip.stored_energy((y[k], y[k + 1]), point)
        y[k], y[k + 1] = 0.0, 0.0


@kernel
def _stored_along_normal(point, piece, contact):
    return 0.0 if point.prescribed else normal.stored_energy(piece, contact.compression)


@kernel
def settle(t, y, modes, motion, bodies, p):
    """Modes of all points for a start from ``y``: open, or stick or slip by the margins."""
    for i in range(p.points.size):
        modes[i, 0], modes[i, 1] = OPEN, p.points[i].first
        c = geometry.touch(p.points[i], bodies, motion)
        piece = p.segments[find_piece(t, p.points[i], p.segments, c)]
        if contact_margin(t, p.points[i], piece, c) > 0.0:
            _close(i, t, y, modes, c, p)
            y[p.state + STATES * i + DISSIPATED] = 0.0  # what is stored at the start was there


@kernel
def add_energy(t, y, modes, motion, bodies, p, stored):
    """Energy in normal curves and stretched nodes, into each fender's row of ``stored``."""
    for i in range(p.points.size):
        point, k = p.points[i], p.state + STATES * i
        if point.law == STICK_SLIP:
            stored[point.row] += stick_slip.stored_energy((y[k], y[k + 1]), point)
        if modes[i, 0] != OPEN:
            contact = geometry.touch(point, bodies, motion)
            stored[point.row] += _stored_along_normal(point, p.segments[modes[i, 1]], contact)


@kernel
def observe(t, y, modes, motion, bodies, p, out):
    """Rows ``out`` (n, 8): compression, N, friction (3) in the earth frame, node (3)."""
    for i in range(p.points.size):
        point, mode, k = p.points[i], modes[i, 0], p.state + STATES * i
        c, s = geometry.touch(point, bodies, motion), (y[k], y[k + 1])
        N, dN = pressure(t, point, mode, p.segments[modes[i, 1]], c)
        f = friction(mode, N, dN, c.velocity, s, point).force
        out[i, 0], out[i, 1] = c.compression, N
        for j in range(3):
            t1, t2, n = c.tangent1[j], c.tangent2[j], c.normal[j]
            out[i, 2 + j] = f[0] * t1 + f[1] * t2
            out[i, 5 + j] = c.place[j] + c.compression * n - s[0] * t1 - s[1] * t2
