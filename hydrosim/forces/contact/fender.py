"""Fender: points of a body against a plane, with a normal curve and a friction law each.

    F = N n + f,   on the plane's body the opposite at the same place

N: normal force along the plane's normal n (`normal`); f: friction in the plane (`laws`); both from
compression, velocity and stretch (`geometry`). Every point has a mode (open, stick, slip), a
segment of its curve, and stick-slip that goes with the load knows whether that rises. They change
only at events (`transitions`).

State per point: stretch s (2,), or of slip without a node its heading; slip distance; energy lost
in friction and where contact ends with something still stored, and of that energy the parts lost
in C2 and in C3 of a contact node. Stored energy: normal curve and stretch; dissipation: normal
damping, friction; a prescribed normal force stores nothing and what it takes from the body counts
as dissipation.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from hydrosim.dofs import MIRROR_SIGN
from hydrosim.errors import InputError
from hydrosim.forces import curve
from hydrosim.forces.contact import coulomb, geometry, laws
from hydrosim.forces.contact.frictionless import Frictionless
from hydrosim.forces.contact.law import Pressed
from hydrosim.forces.contact.laws import COULOMB, FORGETFUL, LAW, Law
from hydrosim.forces.contact.normal import FLAT, NormalCurve, PrescribedNormal
from hydrosim.forces.contact.stick_slip import StickSlip
from hydrosim.forces.curve import SEGMENT as PIECE
from hydrosim.forces.layout import Layout
from hydrosim.forces.mirroring import SMALL, foot, turned
from hydrosim.forces.modes import MODE, OPEN, RISING, SEGMENT, STICK
from hydrosim.forces.signal import (
    NOTHING,
    SIGNAL,
    Signal,
    compile_signals,
    crest,
    rate,
    value,
)
from hydrosim.jit.kernels import clear, kernel
from hydrosim.scene import ForceElement

STATE_NAMES = (  # of each point
    *("stretch 1", "stretch 2", "slip distance"),
    *("friction loss", "damping loss", "slip damping loss", "settled"),
)
STATES = len(STATE_NAMES)
SLIP_DISTANCE, DISSIPATED, DAMPED, SLIP_DAMPED, SETTLED = range(2, STATES)
FELT = 2  # first states of a point, which others feel: its stretch
COMPRESSION, NORMAL_FORCE, FRICTION, NODE, LOST, OBSERVED = 0, 1, 2, 5, 8, 9  # see `observe`
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
    friction: Law

    def may_give(self) -> bool:
        """A prescribed normal force pushes whatever moves."""
        return isinstance(self.normal, PrescribedNormal)

    def others(self) -> Iterator[tuple[str, str | None]]:
        yield "plane.body", self.plane.body

    def signals(self) -> Iterator[tuple[str, Signal]]:
        if isinstance(self.normal, PrescribedNormal):
            yield "normal.prescribed", self.normal.force

    def unit_names(self, name: str) -> Sequence[str]:
        return [f"{name} {i}" for i in range(1, len(self.points) + 1)]

    def parts(self, y: float) -> Sequence[ForceElement]:
        """A fender for each point; planes by the foot of the perpendicular from the origin."""
        point = foot(self.plane.point, self.plane.normal, 0.0 if self.plane.body else y)
        level = replace(self.plane, point=point)
        return [replace(self, points=point[None], plane=level) for point in self.points]

    def image(self) -> ForceElement:
        point, normal = turned(self.plane.point), turned(self.plane.normal)
        plane = replace(self.plane, point=point, normal=normal)
        return replace(self, points=self.points * MIRROR_SIGN[:3], plane=plane)

    def asymmetry(self) -> str | None:
        """Rigid friction beside the plane: how points share a load is then not defined without
        motions that lead aside."""
        rigid = isinstance(self.friction, coulomb.Coulomb) and np.any(self.points[:, 1])
        return "has rigid friction beside the plane" if rigid else None

    def check(self, name: str) -> None:
        """Slip without damping needs N' and constant coefficients."""
        law, normal = self.friction, self.normal
        if not isinstance(law, StickSlip) or law.damping + law.slip_damping > 0.0:
            return
        damped = isinstance(normal, NormalCurve) and normal.damping > 0.0
        if law.load or damped:
            found = "a load" if law.load else "normal damping"
            raise InputError(
                f"forces.{name}.friction: found {found} and friction without damping and"
                " slip_damping; expected one of the latter above 0, or no"
                f" {found.split()[-1]}."
            )


POINT = np.dtype(
    [
        *(("body", int), ("row", int), ("place", float, 3)),
        *geometry.PLANE,
        *(("first", int), ("last", int), ("steepest", float)),
        *(("normal_damping", float), ("prescribed", bool), ("least", float), ("signal", SIGNAL)),
        *LAW,
        *(("reach", float), ("lag", float)),
    ]
)
"""Constants of a contact point: its place on its body, its plane, the pieces ``first`` to ``last``
of its normal curve or the signal that prescribes its normal force, its friction law, the ``reach``
[m] of its node under a usual load, and the ``lag`` [s] of explicit methods."""


class Params(NamedTuple):
    """``points`` (n,) of `POINT`, the ``segments`` of their curves, the ``pieces`` of their
    signals; the first of their states in y, and of their rows of modes."""

    points: np.ndarray
    segments: np.ndarray
    pieces: np.ndarray
    state: int
    mode: int


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> Params:
    """Constants of all contact points of the fenders among ``elements``, in their order."""
    fenders = {name: e for name, e in elements.items() if isinstance(e, Fender)}
    normals = [e.normal for e in fenders.values()]
    signals, pieces = compile_signals([n.force for n in normals if isinstance(n, PrescribedNormal)])
    rows, segments, first, following = [], [np.zeros(0, dtype=PIECE)], 0, iter(signals)
    for name, e in fenders.items():
        table = e.normal if isinstance(e.normal, NormalCurve) else FLAT
        signal = (False, 0.0, NOTHING)
        if isinstance(e.normal, PrescribedNormal):
            signal = _prescribed(next(following), pieces)
        segments.append(curve.segments(table.compression, table.force))
        last, steepest = first + segments[-1].size - 1, segments[-1]["slope"].max()
        law = laws.constants(e.friction)
        usual = laws.reach(e.friction, _usual_load(e, signal, pieces, layout)), layout.step
        shared = (first, last, steepest, table.damping, *signal, *law, *usual)
        place = (layout.body[e.body], layout.row[name])
        rows += [(*place, p, *_plane(e.plane, layout), *shared) for p in e.points]
        first = last + 1
    return Params(np.array(rows, dtype=POINT), np.concatenate(segments), pieces, 0, 0)


def _prescribed(signal: np.void, pieces: np.ndarray) -> tuple[bool, float, np.void]:
    """That the normal force is prescribed, the least that counts as contact, and its signal."""
    return True, LEAST_NORMAL * abs(value(crest(signal, pieces), signal, pieces)), signal


def _usual_load(
    fender: Fender, signal: tuple[bool, float, np.void], pieces: np.ndarray, layout: Layout
) -> float:
    """Normal force [N] on a point, the size of it: the largest that is prescribed, else the weight
    of a body or, if that is less, the end of the curve."""
    _, least, _ = signal
    if not isinstance(fender.normal, NormalCurve):
        return least / LEAST_NORMAL
    between = [fender.body, *([fender.plane.body] if fender.plane.body else [])]
    weights = [layout.weight[layout.body[name]] for name in between]
    return min(*weights, float(fender.normal.force[-1]))


def _plane(plane: Plane, layout: Layout) -> tuple[Any, ...]:
    n = np.array(plane.normal, dtype=float)
    n /= np.linalg.norm(n)
    body = layout.body[plane.body] if plane.body else geometry.EARTH
    return (body, plane.point, n, *geometry.tangents(n))


def units(p: Params) -> np.ndarray:
    """The contact points: each has states and a row of modes."""
    return p.points


def without_friction(p: Params) -> Params:
    """The same contact points without friction."""
    points, none = p.points.copy(), laws.constants(Frictionless())
    for (name, _), constant in zip(LAW, none, strict=True):
        points[name] = constant
    return p._replace(points=points)


def dynamic_states(p: Params) -> np.ndarray:
    """Entries (m,) of y that others feel: the stretches of nodes."""
    first = p.state + STATES * np.flatnonzero(p.points["node"])
    return np.sort(np.concatenate([first, first + 1]))


def forget(p: Params, y: np.ndarray) -> None:
    """Clear the states in y that mean nothing to their points' law."""
    for i in np.flatnonzero(np.isin(p.points["law"], FORGETFUL)):
        y[p.state + STATES * i :][:2] = 0.0


def is_mirrored(p: Params, y: np.ndarray, modes: np.ndarray) -> bool:
    """Whether each contact point's image is stretched as it is, and in the same mode."""
    points, n = p.points, p.points.size
    s = y[p.state :][: STATES * n].reshape(-1, STATES)[:, :2, None]
    stretch = s[:, 0] * points["tangent1"] + s[:, 1] * points["tangent2"]
    here = np.stack([points["place"], points["plane_normal"], stretch], axis=1)
    mode = modes[p.mode :][:n, MODE]
    whose = np.stack([points["body"], points["plane_body"], mode], 1)
    apart = np.abs((here * MIRROR_SIGN[:3])[:, None] - here).max(axis=3)
    close = apart <= SMALL * np.abs(here).max(axis=(0, 2), initial=0.0)
    images = close.all(axis=2) & np.all(whose[:, None] == whose, axis=2)
    return bool(np.all(images.any(axis=1)))


@kernel
def add_force(t, y, modes, motion, bodies, p, wrench, rate, dy):
    """Force of every point into its row of ``wrench``, dissipation along the normal into ``rate``,
    the rates of stretch, slip distance and energy lost in friction into ``dy``. The reactions of
    rigid friction are not among them: see `add_reactions`."""
    for i in range(p.points.size):
        point, mode, k = p.points[i], modes[p.mode + i, MODE], p.state + STATES * i
        x, dx = y[k : k + STATES], dy[k : k + STATES]
        if mode == OPEN and (not point.node or x[0] == x[1] == 0.0):
            clear(dx)
            continue
        if mode == OPEN:
            _relax((x[0], x[1]), point, dx)
            continue
        c = geometry.touch(point, bodies, motion)
        load = pressure(i, t, modes, c, p)
        f = laws.friction(mode, load, c.velocity, (x[0], x[1]), point)
        dx[0], dx[1] = f.stretch_rate
        dx[SLIP_DISTANCE], dx[DISSIPATED] = f.slip_speed, f.dissipation
        dx[DAMPED], dx[SLIP_DAMPED], dx[SETTLED] = f.damped, f.slip_damped, 0.0
        lost = load.N if point.prescribed else point.normal_damping * c.rate
        rate[point.row] += lost * c.rate
        geometry.press(point, c, load.N, f.force, wrench[point.row])


@kernel
def _relax(s, point, dx):
    """Rates of an open point with the stretch ``s``, wherever it is."""
    f = laws.relax(Pressed(0.0, 0.0, 0.0, False), s, point)
    clear(dx)
    dx[0], dx[1] = f.stretch_rate
    dx[DISSIPATED], dx[DAMPED] = f.dissipation, f.damped


@kernel
def pressure(i, t, modes, contact, p):
    """Normal force of point ``i``, zero when open; not cut at zero, so that it is smooth across the
    event that ends the contact."""
    mode = modes[p.mode + i]
    if mode[MODE] == OPEN:
        return Pressed(0.0, 0.0, 0.0, False)
    return pressed(t, p.points[i], p.segments[mode[SEGMENT]], mode[RISING], contact, p)


@kernel
def pressed(t, point, piece, rising, contact, p):
    """Normal force of a point in contact, on a piece of its curve or prescribed."""
    if point.prescribed:
        N = value(t, point.signal, p.pieces)
        return Pressed(N, N, rate(t, point.signal, p.pieces), rising != 0)
    elastic, damping = curve.curve_force(piece, contact.compression), point.normal_damping
    return Pressed(
        elastic + damping * contact.rate, elastic, piece.slope * contact.rate, rising != 0
    )


@kernel
def hold_points(modes, motion, bodies, p, wrench, constraints, holds):
    """Add constraints of all points that rigid friction holds; ``wrench`` (6 nb,) is scratch."""
    for i in range(p.points.size):
        point = p.points[i]
        if point.law == COULOMB and modes[p.mode + i, MODE] == STICK:
            contact = geometry.touch(point, bodies, motion)
            coulomb.hold(i, point, contact, bodies, motion, wrench, constraints, holds)


@kernel
def add_reactions(modes, motion, bodies, p, constraints, holds, wrench):
    """Reactions of the held points into their rows of ``wrench``."""
    coulomb.collect_reactions(constraints, holds)
    for i in range(p.points.size if constraints.number[0] > 0 else 0):
        point, f = p.points[i], (holds.reaction[i, 0], holds.reaction[i, 1])
        if point.law == COULOMB and modes[p.mode + i, MODE] == STICK:
            geometry.press(point, geometry.touch(point, bodies, motion), 0.0, f, wrench[point.row])


@kernel
def stored_along_normal(i, modes, contact, p):
    """Energy in the normal curve of point ``i``, in contact."""
    return curve.stored_energy(p.segments[modes[p.mode + i, SEGMENT]], contact.compression)


@kernel
def left_behind(i, contact, p):
    """Energy in the normal curve of point ``i``, open, whose damper pulled it off the plane before
    the curve was free: what is not lost yet of what is booked as lost."""
    point = p.points[i]
    if point.prescribed or contact.compression <= 0.0:
        return 0.0
    segment = curve.find_segment(point.first, point.last, p.segments, contact.compression)
    return curve.stored_energy(p.segments[segment], contact.compression)


@kernel
def stored_in_plane(i, t, y, modes, contact, p):
    """Energy in the stretched node of point ``i``."""
    k, point = p.state + STATES * i, p.points[i]
    if not point.node:
        return 0.0
    load, s = pressure(i, t, modes, contact, p), (y[k], y[k + 1])
    return laws.stored_energy(modes[p.mode + i, MODE], load, contact.velocity, s, point)


@kernel
def add_energy(t, y, modes, motion, bodies, p, stored):
    """Energy in normal curves and stretched nodes, into each fender's row of ``stored``."""
    for i in range(p.points.size):
        contact, row = geometry.touch(p.points[i], bodies, motion), p.points[i].row
        stored[row] += stored_in_plane(i, t, y, modes, contact, p)
        if modes[p.mode + i, MODE] != OPEN:
            stored[row] += stored_along_normal(i, modes, contact, p)
        else:
            stored[row] += left_behind(i, contact, p)


@kernel
def observe(t, y, modes, motion, bodies, p, reactions, out):
    """Rows of `OBSERVED` of all points one after the other in ``out``: compression, N, friction (3)
    in the earth frame, node (3), energy lost in friction."""
    for i in range(p.points.size):
        point, mode, k = p.points[i], modes[p.mode + i, MODE], p.state + STATES * i
        x, row = y[k : k + STATES], out[OBSERVED * i : OBSERVED * (i + 1)]
        c, s = geometry.touch(point, bodies, motion), (x[0], x[1])
        load = pressure(i, t, modes, c, p)
        f = laws.friction(mode, load, c.velocity, s, point).force
        if point.law == COULOMB and mode == STICK:
            f = (reactions[i, 0], reactions[i, 1])
        row[LOST] = x[DISSIPATED] - laws.lent(mode, load, c.velocity, s, point)
        if mode == OPEN:
            row[LOST] -= left_behind(i, c, p)
        s = laws.stretch(mode, load, c.velocity, s, point)
        row[COMPRESSION], row[NORMAL_FORCE] = c.compression, load.N
        for j in range(3):
            t1, t2, n = c.tangent1[j], c.tangent2[j], c.normal[j]
            row[FRICTION + j] = f[0] * t1 + f[1] * t2
            row[NODE + j] = c.place[j] + c.compression * n - s[0] * t1 - s[1] * t2
