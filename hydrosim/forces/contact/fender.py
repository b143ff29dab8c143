"""Fender: points of a body against a plane, with a normal curve and a friction law each.

    F = N n + f,   on the plane's body the opposite at the same place

N: normal force along the plane's normal n (`normal`); f: friction in the plane (`stick_slip`,
`coulomb`, `friction_slope` or none); both from compression, velocity and stretch (`geometry`).
Every point has a mode (open, stick, slip), a segment of its curve, and stick-slip that goes with
the load knows whether that rises. They change only at events (`transitions`).

State per point: stretch s (2,), or of slip without a node its heading; slip distance; energy lost
in friction and where contact ends with something still stored, and of that energy the parts lost
in C2 and in C3 of a contact node. Stored energy: normal curve and stretch; dissipation: normal
damping, friction; a prescribed normal force stores nothing and what it takes from the body counts
as dissipation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from hydrosim.forces.contact import (
    coulomb,
    friction_slope,
    frictionless,
    geometry,
    normal,
    stick_slip,
)
from hydrosim.forces.contact.coulomb import Coulomb
from hydrosim.forces.contact.friction_slope import FrictionSlope
from hydrosim.forces.contact.frictionless import Frictionless
from hydrosim.forces.contact.modes import MODE, OPEN, RISING, SEGMENT, STICK
from hydrosim.forces.contact.normal import FLAT, NormalCurve, PrescribedNormal
from hydrosim.forces.contact.stick_slip import LoadPowers, Pressed, StickSlip
from hydrosim.forces.layout import Layout
from hydrosim.forces.signal import NOTHING, SIGNAL, compile_signals, crest, rate, value
from hydrosim.jit.kernels import clear, kernel
from hydrosim.scene import ForceElement

FRICTIONLESS, STICK_SLIP, FRICTION_SLOPE, COULOMB = range(4)
STATE_NAMES = (  # of each point
    *("stretch 1", "stretch 2", "slip distance"),
    *("friction loss", "damping loss", "slip damping loss", "settled"),
)
STATES = len(STATE_NAMES)
SLIP_DISTANCE, DISSIPATED, DAMPED, SLIP_DAMPED, SETTLED = range(2, STATES)
OBSERVED = 9  # see `observe`
LEAST_NORMAL = 1e-12  # of the largest prescribed normal force


@dataclass(frozen=True)
class Plane:
    """``point`` and ``normal`` (towards the free side), in the earth frame or that of ``body``."""

    point: tuple[float, ...]
    normal: tuple[float, ...]
    body: str | None = None


@dataclass(frozen=True)
class Fender(ForceElement):
    """``points`` (n, 3) in the body frame; ``normal`` and ``friction`` hold for each of them."""

    points: np.ndarray
    plane: Plane
    normal: NormalCurve | PrescribedNormal
    friction: StickSlip | FrictionSlope | Coulomb | Frictionless


LAW_FIELDS = (
    *("law", "static", "kinetic", "stiffness", "damping", "slip_damping", "relaxation"),
    *("reference", "stiffness_power", "damping_power", "slip_damping_power"),
)
POINT = np.dtype(
    [
        *(("body", int), ("row", int), ("place", float, 3)),
        *geometry.PLANE,
        *(("first", int), ("last", int), ("steepest", float)),
        *(("normal_damping", float), ("prescribed", bool), ("least", float), ("signal", SIGNAL)),
        *((name, int if name == "law" else float) for name in LAW_FIELDS),
    ]
)
"""Constants of a contact point: its place on its body, its plane, the pieces ``first`` to ``last``
of its normal curve or the signal that prescribes its normal force, its friction law."""


class Params(NamedTuple):
    """``points`` (n,) of `POINT`, the ``segments`` of their curves, the ``pieces`` of their
    signals, and the first entry of their states in y."""

    points: np.ndarray
    segments: np.ndarray
    pieces: np.ndarray
    state: int


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> Params:
    """Constants of all contact points of the fenders among ``elements``, in their order."""
    fenders = {name: e for name, e in elements.items() if isinstance(e, Fender)}
    normals = [e.normal for e in fenders.values()]
    signals, pieces = compile_signals([n.force for n in normals if isinstance(n, PrescribedNormal)])
    rows, segments, first, following = [], [np.zeros(0, dtype=normal.SEGMENT)], 0, iter(signals)
    for name, e in fenders.items():
        curve = e.normal if isinstance(e.normal, NormalCurve) else FLAT
        signal = (False, 0.0, NOTHING)
        if isinstance(e.normal, PrescribedNormal):
            signal = _prescribed(next(following), pieces)
        segments.append(normal.segments(curve))
        last, steepest = first + segments[-1].size - 1, segments[-1]["slope"].max()
        shared = (first, last, steepest, curve.damping, *signal, *_law(e.friction))
        place = (layout.body[e.body], layout.row[name])
        rows += [(*place, p, *_plane(e.plane, layout), *shared) for p in e.points]
        first = last + 1
    return Params(np.array(rows, dtype=POINT), np.concatenate(segments), pieces, layout.state)


def _prescribed(signal: np.void, pieces: np.ndarray) -> tuple[bool, float, np.void]:
    """That the normal force is prescribed, the least that counts as contact, and its signal."""
    return True, LEAST_NORMAL * abs(value(crest(signal, pieces), signal, pieces)), signal


def _plane(plane: Plane, layout: Layout) -> tuple[Any, ...]:
    n = np.array(plane.normal, dtype=float)
    n /= np.linalg.norm(n)
    body = layout.body[plane.body] if plane.body else geometry.EARTH
    return (body, plane.point, n, *geometry.tangents(n))


def _law(law: StickSlip | FrictionSlope | Coulomb | Frictionless) -> tuple[float, ...]:
    """Kind, mu_s, mu_k, K2, C2 (or the slope b), C3, the time (C2 + C3) / K2 in which a slipping
    node relaxes, and how these go with the load."""
    none = (0.0,) * 5
    if isinstance(law, StickSlip):
        load = law.load or LoadPowers(0.0, 0.0)
        constants = (law.stiffness, law.damping, law.slip_damping)
        relaxation = (law.damping + law.slip_damping) / law.stiffness
        powers = (load.reference, load.stiffness, load.damping, load.slip_damping)
        return (STICK_SLIP, law.static, law.kinetic, *constants, relaxation, *powers)
    if isinstance(law, FrictionSlope):
        return (FRICTION_SLOPE, law.coefficient, law.coefficient, 0.0, law.slope, 0.0, *none)
    if isinstance(law, Coulomb):
        return (COULOMB, law.static, law.kinetic, 0.0, 0.0, 0.0, *none)
    return (FRICTIONLESS, 0.0, 0.0, 0.0, 0.0, 0.0, *none)


def without_friction(p: Params) -> Params:
    """The same contact points without friction."""
    points = p.points.copy()
    for name, none in zip(LAW_FIELDS, _law(Frictionless()), strict=True):
        points[name] = none
    return p._replace(points=points)


@kernel
def add_force(t, y, modes, motion, bodies, p, wrench, rate, dy):
    """Force of every point into its row of ``wrench``, dissipation along the normal into ``rate``,
    the rates of stretch, slip distance and energy lost in friction into ``dy``. The reactions of
    rigid friction are not among them: see `add_reactions`."""
    for i in range(p.points.size):
        point, mode, k = p.points[i], modes[i, MODE], p.state + STATES * i
        if mode == OPEN and (point.law != STICK_SLIP or y[k] == y[k + 1] == 0.0):
            clear(dy[k : k + STATES])
            continue
        if mode == OPEN:
            _relax((y[k], y[k + 1]), point, dy[k : k + STATES])
            continue
        c = geometry.touch(point, bodies, motion)
        load = pressure(i, t, modes, c, p)
        f = friction(mode, load, c.velocity, (y[k], y[k + 1]), point)
        dy[k], dy[k + 1] = f.stretch_rate
        dy[k + SLIP_DISTANCE], dy[k + DISSIPATED] = f.slip_speed, f.dissipation
        dy[k + DAMPED], dy[k + SLIP_DAMPED], dy[k + SETTLED] = f.damped, f.slip_damped, 0.0
        lost = load.N if point.prescribed else point.normal_damping * c.rate
        rate[point.row] += lost * c.rate
        geometry.press(point, c, load.N, f.force, wrench[point.row])


@kernel
def _relax(s, point, rates):
    """Rates of an open point with the stretch ``s``, wherever it is."""
    f = stick_slip.friction(OPEN, Pressed(0.0, 0.0, 0.0, False), (0.0, 0.0), s, point)
    clear(rates)
    rates[0], rates[1] = f.stretch_rate
    rates[DISSIPATED], rates[DAMPED] = f.dissipation, f.damped


@kernel
def pressure(i, t, modes, contact, p):
    """Normal force of point ``i``, zero when open; not cut at zero, so that it is smooth across the
    event that ends the contact."""
    if modes[i, MODE] == OPEN:
        return Pressed(0.0, 0.0, 0.0, False)
    return pressed(t, p.points[i], p.segments[modes[i, SEGMENT]], modes[i, RISING], contact, p)


@kernel
def pressed(t, point, piece, rising, contact, p):
    """Normal force of a point in contact, on a piece of its curve or prescribed."""
    if point.prescribed:
        N = value(t, point.signal, p.pieces)
        return Pressed(N, N, rate(t, point.signal, p.pieces), rising != 0)
    elastic, damping = normal.curve_force(piece, contact.compression), point.normal_damping
    return Pressed(
        elastic + damping * contact.rate, elastic, piece.slope * contact.rate, rising != 0
    )


@kernel
def friction(mode, load, v1, s, point):
    """Friction of a point by its law."""
    if point.law == STICK_SLIP:
        return stick_slip.friction(mode, load, v1, s, point)
    if point.law == FRICTION_SLOPE:
        return friction_slope.friction(mode, load, v1, s, point)
    if point.law == COULOMB:
        return coulomb.friction(mode, load, v1, s, point)
    return frictionless.friction(mode, load, v1, s, point)


@kernel
def hold_points(modes, motion, bodies, p, wrench, holds):
    """Constraints of all points that rigid friction holds; ``wrench`` (6 nb,) is scratch."""
    holds.constraints.number[0] = 0
    for i in range(p.points.size):
        point = p.points[i]
        if point.law == COULOMB and modes[i, MODE] == STICK:
            contact = geometry.touch(point, bodies, motion)
            coulomb.hold(i, point, contact, bodies, motion, wrench, holds)


@kernel
def add_reactions(modes, motion, bodies, p, holds, wrench):
    """Reactions of the held points into their rows of ``wrench``."""
    coulomb.collect_reactions(holds)
    for i in range(p.points.size if holds.constraints.number[0] > 0 else 0):
        point, f = p.points[i], (holds.reaction[i, 0], holds.reaction[i, 1])
        if point.law == COULOMB and modes[i, MODE] == STICK:
            geometry.press(point, geometry.touch(point, bodies, motion), 0.0, f, wrench[point.row])


@kernel
def stored_along_normal(i, modes, contact, p):
    """Energy in the normal curve of point ``i``, in contact."""
    return normal.stored_energy(p.segments[modes[i, SEGMENT]], contact.compression)


@kernel
def stored_in_plane(i, t, y, modes, contact, p):
    """Energy in the stretched node of point ``i``."""
    k, point = p.state + STATES * i, p.points[i]
    if point.law != STICK_SLIP:
        return 0.0
    return stick_slip.stored_energy(pressure(i, t, modes, contact, p), (y[k], y[k + 1]), point)


@kernel
def add_energy(t, y, modes, motion, bodies, p, stored):
    """Energy in normal curves and stretched nodes, into each fender's row of ``stored``."""
    for i in range(p.points.size):
        contact, row = geometry.touch(p.points[i], bodies, motion), p.points[i].row
        stored[row] += stored_in_plane(i, t, y, modes, contact, p)
        if modes[i, MODE] != OPEN:
            stored[row] += stored_along_normal(i, modes, contact, p)


@kernel
def observe(t, y, modes, motion, bodies, p, reactions, out):
    """Rows ``out`` (n, 9): compression, N, friction (3) in the earth frame, node (3), energy lost
    in friction."""
    for i in range(p.points.size):
        point, mode, k = p.points[i], modes[i, MODE], p.state + STATES * i
        c, s = geometry.touch(point, bodies, motion), (y[k], y[k + 1])
        load = pressure(i, t, modes, c, p)
        f = friction(mode, load, c.velocity, s, point).force
        if point.law == COULOMB and mode == STICK:
            f = (reactions[i, 0], reactions[i, 1])
        out[i, 8] = y[k + DISSIPATED]
        if point.law == STICK_SLIP:
            out[i, 8] -= stick_slip.lent(load, s, point)
        s = stick_slip.stretch(load, s, point) if point.law == STICK_SLIP else (0.0, 0.0)
        out[i, 0], out[i, 1] = c.compression, load.N
        for j in range(3):
            t1, t2, n = c.tangent1[j], c.tangent2[j], c.normal[j]
            out[i, 2 + j] = f[0] * t1 + f[1] * t2
            out[i, 5 + j] = c.place[j] + c.compression * n - s[0] * t1 - s[1] * t2
