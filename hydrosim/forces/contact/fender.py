"""Fender: points of a body against a plane, with a normal curve and a friction law each.

    F = N n + f,   on the plane's body the opposite at the same place

N: normal force along the plane's normal n (`normal`); f: friction in the plane (`stick_slip`,
`friction_slope` or none); both from compression, velocity and stretch (`geometry`). Every point has
a mode (open, stick, slip) and a segment of its curve. They change only at events: a mode holds
while its three margins are positive,

    contact   min(k delta, N), its opposite when open      k: the curve's steepest slope
    friction  of the friction law                          in contact
    segment   distance to the nearer corner of the curve   in contact

State per point: stretch s (2,), slip distance, energy lost in friction. A point without stretch
(other laws) keeps s = 0. Stored energy: normal curve and stretch; dissipation: normal damping,
friction.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import hypot
from typing import NamedTuple

import numpy as np

from hydrosim.forces.contact import friction_slope, geometry, normal, stick_slip
from hydrosim.forces.contact.friction_slope import FrictionSlope
from hydrosim.forces.contact.modes import OPEN, SLIP, STICK
from hydrosim.forces.contact.normal import NormalCurve
from hydrosim.forces.contact.stick_slip import Friction, StickSlip
from hydrosim.forces.layout import Layout
from hydrosim.kernels import clear, kernel
from hydrosim.rigid.vectors import vector
from hydrosim.scene import ForceElement

FRICTIONLESS, STICK_SLIP, FRICTION_SLOPE = range(3)
STATES = 4  # per point: stretch (2), slip distance, dissipated energy
SLIP_DISTANCE, DISSIPATED = 2, 3
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
    normal: NormalCurve
    friction: StickSlip | FrictionSlope | Frictionless


class Params(NamedTuple):
    """Arrays over all contact points; ``state`` is their first entry in y."""

    state: int
    body: np.ndarray
    row: np.ndarray
    point: np.ndarray
    planes: geometry.Planes
    curves: normal.Curves
    steepest: np.ndarray
    law: np.ndarray
    static: np.ndarray
    kinetic: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    slip_damping: np.ndarray


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> Params:
    """Constants of all contact points of the fenders among ``elements``, in their order."""
    chosen = {name: e for name, e in elements.items() if isinstance(e, Fender)}
    each = [(name, e, point) for name, e in chosen.items() for point in e.points]
    curves = normal.compile_curves([e.normal for _, e, _ in each])
    steepest = [curves.slope[i : j + 1].max() for i, j in zip(curves.first, curves.last)]
    laws = np.array([_law(e.friction) for _, e, _ in each], dtype=float).reshape(-1, 6)
    law, static, kinetic, stiffness, damping, slip_damping = laws.T.copy()
    return Params(
        layout.state,
        np.array([layout.body[e.body] for _, e, _ in each], dtype=np.int64),
        np.array([layout.row[name] for name, _, _ in each], dtype=np.int64),
        np.array([point for _, _, point in each], dtype=float).reshape(-1, 3),
        _planes([e.plane for _, e, _ in each], layout),
        curves,
        np.array(steepest, dtype=float),
        law.astype(np.int64),
        *(static, kinetic, stiffness, damping, slip_damping),
    )


def _planes(planes: list[Plane], layout: Layout) -> geometry.Planes:
    normals = np.array([p.normal for p in planes], dtype=float).reshape(-1, 3)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    frames = np.array([geometry.tangents(n) for n in normals]).reshape(-1, 2, 3)
    return geometry.Planes(
        np.array([layout.body[p.body] if p.body else geometry.EARTH for p in planes], np.int64),
        np.array([p.point for p in planes], dtype=float).reshape(-1, 3),
        normals,
        np.ascontiguousarray(frames[:, 0]),
        np.ascontiguousarray(frames[:, 1]),
    )


def _law(law: StickSlip | FrictionSlope | Frictionless) -> tuple[float, ...]:
    """Kind, mu_s, mu_k, K2, C2 (or the slope b), C3."""
    if isinstance(law, StickSlip):
        return (
            *(STICK_SLIP, law.static, law.kinetic),
            *(law.stiffness, law.damping, law.slip_damping),
        )
    if isinstance(law, FrictionSlope):
        return (FRICTION_SLOPE, law.coefficient, law.coefficient, 0.0, law.slope, 0.0)
    return (FRICTIONLESS, 0.0, 0.0, 0.0, 0.0, 0.0)


@kernel
def add_force(t, y, modes, motion, bodies, p, wrench, rate, dy):
    """Force of every point into its row of ``wrench``, dissipation into ``rate``, the rates of
    stretch, slip distance and lost energy into ``dy``."""
    for i in range(p.body.size):
        k = p.state + STATES * i
        if modes[i, 0] == OPEN and p.law[i] != STICK_SLIP:
            clear(dy[k : k + STATES])
            continue
        c = touch(i, p, bodies, motion)
        N = pressure(i, modes, c, p)
        f = friction(modes[i, 0], N, c.velocity, (y[k], y[k + 1]), p, i)
        dy[k], dy[k + 1] = f.stretch_rate
        dy[k + SLIP_DISTANCE], dy[k + DISSIPATED] = f.slip_speed, f.dissipation
        rate[p.row[i]] += f.dissipation
        if modes[i, 0] != OPEN:
            rate[p.row[i]] += p.curves.damping[i] * c.rate * c.rate
            geometry.press(p.body[i], p.planes.body[i], c, N, f.force, wrench[p.row[i]])


@kernel
def touch(i, p, bodies, motion):
    """Geometry of point ``i``."""
    return geometry.touch(p.body[i], vector(p.point[i], 0), i, p.planes, bodies, motion)


@kernel
def pressure(i, modes, contact, p):
    """Normal force of point ``i``; zero when open."""
    if modes[i, 0] == OPEN:
        return 0.0
    return normal.normal_force(i, modes[i, 1], contact.compression, contact.rate, p.curves)


@kernel
def friction(mode, N, v1, s, p, i):
    """Friction of point ``i`` by its law."""
    if p.law[i] == STICK_SLIP:
        return stick_slip.friction(mode, N, v1, s, p, i)
    if p.law[i] == FRICTION_SLOPE:
        return friction_slope.friction(mode, N, v1, s, p, i)
    return Friction((0.0, 0.0), (0.0, 0.0), hypot(v1[0], v1[1]) if mode == SLIP else 0.0, 0.0)


@kernel
def friction_margin(mode, N, v1, s, p, i):
    """How far point ``i`` is from leaving stick or slip; frictionless points always slip."""
    if p.law[i] == STICK_SLIP:
        return stick_slip.margin(mode, N, v1, s, p, i)
    if p.law[i] == FRICTION_SLOPE:
        return friction_slope.margin(mode, N, v1, s, p, i)
    return 1.0 if mode == SLIP else -1.0


@kernel
def margins(y, modes, motion, bodies, p, out):
    """Margins ``out`` (3 n,) of the modes of all points, negative where a mode has ended."""
    for i in range(p.body.size):
        mode, k, m = modes[i, 0], p.state + STATES * i, MARGINS * i
        c = touch(i, p, bodies, motion)
        if mode == OPEN:
            segment = normal.segment(i, c.compression, p.curves)
            N = normal.normal_force(i, segment, c.compression, c.rate, p.curves)
            out[m + CONTACT_MARGIN] = -min(p.steepest[i] * c.compression, N)
            out[m + FRICTION_MARGIN] = out[m + SEGMENT_MARGIN] = 1.0
            continue
        N = pressure(i, modes, c, p)
        s = (y[k], y[k + 1])
        out[m + CONTACT_MARGIN] = min(p.steepest[i] * c.compression, N)
        out[m + FRICTION_MARGIN] = friction_margin(mode, N, c.velocity, s, p, i)
        out[m + SEGMENT_MARGIN] = normal.inside_segment(modes[i, 1], c.compression, p.curves)


@kernel
def switch(i, which, y, modes, motion, bodies, p):
    """Put point ``i`` into the mode that follows when margin ``which`` has reached zero."""
    c = touch(i, p, bodies, motion)
    if which == SEGMENT_MARGIN:
        low = c.compression - p.curves.lower[modes[i, 1]]
        high = p.curves.upper[modes[i, 1]] - c.compression
        modes[i, 1] += 1 if high < low else -1
    elif which == FRICTION_MARGIN:
        modes[i, 0] = SLIP if modes[i, 0] == STICK else STICK
    elif modes[i, 0] == OPEN:
        _close(i, c, y, modes, p)
    else:
        _open(i, y, modes, p)


@kernel
def _close(i, contact, y, modes, p):
    """Contact begins: the mode is the one whose margin is positive."""
    k = p.state + STATES * i
    modes[i, 0], modes[i, 1] = STICK, normal.segment(i, contact.compression, p.curves)
    N = pressure(i, modes, contact, p)
    if friction_margin(STICK, N, contact.velocity, (y[k], y[k + 1]), p, i) < 0.0:
        modes[i, 0] = SLIP


@kernel
def _open(i, y, modes, p):
    """Contact ends; a node without a damper springs back at once and its energy is lost."""
    k = p.state + STATES * i
    modes[i, 0] = OPEN
    if p.law[i] == STICK_SLIP and p.damping[i] == 0.0:
        y[k + DISSIPATED] += stick_slip.stored_energy((y[k], y[k + 1]), p, i)
        y[k], y[k + 1] = 0.0, 0.0


@kernel
def settle(y, modes, motion, bodies, p):
    """Modes of all points for a start from ``y``: open, or stick or slip by the margins."""
    for i in range(p.body.size):
        modes[i, 0], modes[i, 1] = OPEN, p.curves.first[i]
        c = touch(i, p, bodies, motion)
        segment = normal.segment(i, c.compression, p.curves)
        N = normal.normal_force(i, segment, c.compression, c.rate, p.curves)
        if c.compression > 0.0 and N > 0.0:
            _close(i, c, y, modes, p)


@kernel
def add_energy(t, y, modes, motion, bodies, p, stored):
    """Energy in normal curves and stretched nodes, into each fender's row of ``stored``."""
    for i in range(p.body.size):
        k = p.state + STATES * i
        if p.law[i] == STICK_SLIP:
            stored[p.row[i]] += stick_slip.stored_energy((y[k], y[k + 1]), p, i)
        if modes[i, 0] != OPEN:
            compression = touch(i, p, bodies, motion).compression
            stored[p.row[i]] += normal.stored_energy(modes[i, 1], compression, p.curves)


@kernel
def observe(y, modes, motion, bodies, p, out):
    """Rows ``out`` (n, 8): compression, N, friction (3) in the earth frame, node (3)."""
    for i in range(p.body.size):
        k = p.state + STATES * i
        c = touch(i, p, bodies, motion)
        N = pressure(i, modes, c, p)
        s = (y[k], y[k + 1])
        f = friction(modes[i, 0], N, c.velocity, s, p, i).force
        out[i, 0], out[i, 1] = c.compression, N
        for j in range(3):
            t1, t2, n = c.tangent1[j], c.tangent2[j], c.normal[j]
            out[i, 2 + j] = f[0] * t1 + f[1] * t2
            out[i, 5 + j] = c.place[j] + c.compression * n - s[0] * t1 - s[1] * t2
