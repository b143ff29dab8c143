"""Links between two points or axes: struts, torsion springs and power take-offs, of both signs.

    T = f(x) + c x' + d |x'| x'

A strut acts along the line between a point p of its body and an anchor a, on the earth or on
another body. x = |a - p| - L0 is its extension beyond the length L0. The body receives T e at p,
with e = (a - p) / |a - p|, and the other side -T e at a.

A torsion spring acts about an axis. x is the twist of the body relative to the other side, less the
neutral angle: the twist of the swing-twist decomposition of the relative rotation (swing after
twist; Dobrowolski 2015, arXiv:1506.05481). Let u, v, w be an orthonormal triad on the other side,
and U, V, W that of the body, equal at rest, with the axis u. Then

    tan x = (w V - v W) / (v V + w W),   x' = g (omega - omega_other),   g = (u + U) / (1 + u U)

The body receives the moment -T g, the other side T g. As g is the gradient of x at any rotation,
the spring has a potential: the integral of f. Its moment has components across the axis while the
body swings.

f: straight lines through the points of a curve, with the first and last slopes continued. Corners
are events. c, d: linear and quadratic damping. c x'^2 + d |x'|^3 is the dissipated power; it is the
absorbed power of a power take-off. The twist is counted beyond half a turn: its half turns are in
the modes.

Limits: no mass. A strut has no direction where its ends meet, and a twist none where the axes are
opposite (a swing of 180 deg): a run ends there. The slope of |x'| x' has a corner at x' = 0, so
methods have order 3 with d. With small angles lever arms stay as at rest while e follows the
points, as for a `spring`; a twist is the difference of the angles about the axis.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import atan2, nan, pi, sqrt
from typing import Any, ClassVar, NamedTuple

import numpy as np

from hydrosim.elements.contact import curves
from hydrosim.elements.contact.geometry import EARTH
from hydrosim.elements.kind import (
    Columns,
    KindWithModeSets,
    Layout,
    LinearResistance,
    ModeRows,
    ModeSet,
    UnitRecord,
    Variable,
    capacity_of,
    elements_of,
    rest_at_first,
    steepest_segment,
)
from hydrosim.elements.pair import (
    TwoPointElement,
    line_between,
    relative_small_turn,
    relative_turn_rate,
)
from hydrosim.jit.kernels import kernel, root
from hydrosim.modes import (
    ACTING,
    CONTACT_MARGIN,
    INACTIVE,
    MARGINS,
    MODE,
    RISING,
    RISING_MARGIN,
    SEGMENT,
    SEGMENT_MARGIN,
    UNDEFINED,
)
from hydrosim.multibody.kinematics import add_wrench
from hydrosim.multibody.vectors import add, cross, dot, matvec, scale, vector
from hydrosim.scene import ForceElement, Scene, Turns

LINE_LINK, AXIS_LINK = range(2)
LOAD_OUTPUT, PLACE_OUTPUT, POWER_OUTPUT, LINK_OUTPUTS = range(4)  # see `write_outputs`
HALF_TURNS = RISING  # column of modes
MIN_LENGTH_SHARE = 0.01  # of the length at rest: closer ends have no direction
MIN_SWING_COSINE = 1e-3  # least 1 + cosine of the swing of an axis: 177 deg
MAX_HALF_TURN = 0.75 * pi  # from the middle of its half turn: a twist then belongs to the next one


@dataclass(frozen=True)
class Link(ForceElement):
    """The load ``force`` (n,) [N or N m] over the offset ``offset`` (n,) [m or rad], rising, from
    where the link has its length or neutral angle. Both are empty if it has no spring. ``damping``
    [N s/m or N m s/rad], and ``drag`` [N s^2/m^2 or N m s^2/rad^2]. The power that a link with
    ``absorbs`` dissipates is recorded."""

    offset: np.ndarray
    force: np.ndarray
    damping: float = 0.0
    drag: float = 0.0
    absorbs: bool = False

    def can_carry_weight(self) -> bool:
        return bool(np.any(self.force))

    def unit_names(self, name: str) -> Sequence[str]:
        return [name]


@dataclass(frozen=True, kw_only=True)
class Strut(TwoPointElement, Link):
    """From ``point`` of the body to ``anchor`` on the earth or in the frame of ``anchor_body``.
    ``length`` [m] is the length without force of the spring; None: the length at rest."""

    point: tuple[float, ...]
    anchor: tuple[float, ...]
    length: float | None = None
    anchor_body: str | None = None

    def restored_dofs(self) -> Collection[str]:
        return super().restored_dofs() if self.can_carry_weight() else ()


@dataclass(frozen=True, kw_only=True)
class TorsionSpring(Link):
    """About ``axis`` in the frame of the body, between it and the body ``to`` or the earth.
    ``neutral`` [rad] is the twist without moment of the spring; the twist is 0 at rest."""

    axis: tuple[float, ...]
    neutral: float = 0.0
    to: str | None = None

    def restored_dofs(self) -> Collection[str]:
        held = self.to is None and np.any(self.force) and self.axis[2] != 0.0
        return ("yaw",) if held else ()

    def connected_bodies(self) -> Iterator[tuple[str, str | None]]:
        yield "to", self.to

    def can_carry_weight(self) -> bool:
        return False

    def nonlinearity(self, name: str, turns: Turns) -> str | None:
        """Linear with small angles, if its curve and its damping are."""
        straight = len(self.offset) <= 2 and self.drag == 0.0
        return None if straight and not turns.exact else name

    def mirrored_parts(self, y: float) -> Sequence[ForceElement]:
        return [self._in_order()]

    def mirror_image(self) -> ForceElement:
        """A rotation about (x, y, z) has the image of one about (-x, y, -z)."""
        x, y, z = self.axis
        return replace(self, axis=(-x, y, -z))._in_order()

    def _in_order(self) -> TorsionSpring:
        """The same spring with the axis of unit length and, if its curve is odd, towards positive
        coordinates."""
        axis = np.array(self.axis) / np.linalg.norm(self.axis)
        straight = len(self.offset) <= 2 and not (np.any(self.offset[:1]) or np.any(self.force[:1]))
        first = axis[np.flatnonzero(np.abs(axis) > 1e-12)[0]]
        if straight and self.neutral == 0.0 and first < 0.0:
            axis = -axis
        return replace(self, axis=tuple(axis))


LINK = np.dtype(
    [
        *(("kind", int), ("absorbs", bool), ("body", int), ("row", int), ("other", int)),
        *(("ends", float, 6), ("axes", float, 18), ("neutral", float), ("closest", float)),
        *(("damping", float), ("drag", float)),
        *(("first", int), ("last", int), ("steepest", float)),
    ]
)
"""Constants of a link: its ``kind``, `LINE_LINK` or `AXIS_LINK`; its own point and its anchor; the
triads of both sides, each in the frame of its side, the axis first; length or angle without load;
the closest that its ends may come; the pieces ``first`` to ``last`` of its curve."""


class LinkConstants(NamedTuple):
    """``links`` (n,) of `LINK`, the ``segments`` of their curves, and the first of their rows of
    modes: acting, the segment, and the half turns of the twist."""

    links: np.ndarray
    segments: np.ndarray
    mode: int


class LinkKinematics(NamedTuple):
    """State of one link: its offset ``x`` and the ``rate``. The load T = 1 is the ``force`` and
    the ``moment`` on the body, the opposite force and the moment ``counter`` on the other side.
    ``room`` is positive while it has a direction; ``turned`` is the twist from the middle of its
    half turn."""

    x: float
    rate: float
    force: tuple[float, float, float]
    moment: tuple[float, float, float]
    counter: tuple[float, float, float]
    room: float
    turned: float


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> LinkConstants:
    """Constants of the links among ``elements``, in their order."""
    rows = []
    segments = [np.zeros(0, dtype=curves.SEGMENT)]
    first = 0
    for name, e in elements.items():
        if isinstance(e, Strut | TorsionSpring):
            pieces = _load_segments(e)
            last = first + pieces.size - 1
            place = _strut_fields(e, layout) if isinstance(e, Strut) else _torsion_fields(e, layout)
            kind, other, ends, axes, neutral, closest = place
            which = (kind, e.absorbs, layout.body[e.body], layout.row[name], other)
            law = (e.damping, e.drag, first, last, np.abs(pieces["slope"]).max())
            rows.append((*which, ends, axes, neutral, closest, *law))
            segments.append(pieces)
            first = last + 1
    return LinkConstants(np.array(rows, dtype=LINK), np.concatenate(segments), 0)


def _load_segments(link: Link) -> np.ndarray:
    """The pieces of the curve, with no energy stored at offset 0."""
    if not len(link.offset):
        return curves.segments(np.array([0.0, 1.0]), np.zeros(2))
    pieces = curves.segments(link.offset, link.force)
    middle = pieces[curves.piece_at(pieces, 0.0)]
    d = -middle["start"]
    pieces["energy"] -= middle["energy"] + (middle["force"] + 0.5 * middle["slope"] * d) * d
    return pieces


Placed = tuple[int, int, np.ndarray, np.ndarray, float, float]


def _strut_fields(strut: Strut, layout: Layout) -> Placed:
    """Kind, other body, ends, triads, length and closest distance of a strut."""
    other = EARTH if strut.anchor_body is None else layout.body[strut.anchor_body]
    anchor = layout.place_at_rest(strut.anchor_body, strut.anchor)
    d = (anchor - layout.place_at_rest(strut.body, strut.point)).tolist()
    long = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])  # to the bit as in `kinematics`
    length = long if strut.length is None else strut.length
    ends = np.array([*strut.point, *strut.anchor])
    return LINE_LINK, other, ends, np.zeros(18), length, MIN_LENGTH_SHARE * max(long, length)


def _torsion_fields(spring: TorsionSpring, layout: Layout) -> Placed:
    """The same of a torsion spring."""
    other = EARTH if spring.to is None else layout.body[spring.to]
    first = np.array(spring.axis) / np.linalg.norm(spring.axis)
    second = np.cross(first, np.eye(3)[np.abs(first).argmin()])
    second /= np.linalg.norm(second)
    axes = np.array([first, second, np.cross(first, second)])
    there = axes @ layout.axes_from(spring.body, spring.to).T
    return AXIS_LINK, other, np.zeros(6), np.array([axes, there]).ravel(), spring.neutral, 0.0


@kernel
def kinematics(link, mode, bodies, motion):
    """State of a link, as a `LinkKinematics`."""
    if link.kind == LINE_LINK:
        return strut_kinematics(link, bodies, motion)
    if bodies.exact:
        return twist_kinematics(link, mode, motion)
    return small_twist(link, mode, motion)


@kernel
def strut_kinematics(link, bodies, motion):
    """State of a strut."""
    point = vector(link.ends, 0)
    place = vector(link.ends, 3)
    s = line_between(link.body, point, link.other, place, bodies, motion)
    moment = cross(s.arm, s.direction)
    counter = cross(s.direction, s.other_arm)
    stretched = s.length - link.neutral
    return LinkKinematics(
        stretched, s.rate, s.direction, moment, counter, s.length - link.closest, 0.0
    )


@kernel
def axis_vector(link, side, k, motion):
    """Vector ``k`` of the triad of the body (``side`` 0) or of the other side, in the earth
    frame."""
    axis = vector(link.axes, 9 * side + 3 * k)
    b = link.body if side == 0 else link.other
    return axis if b == EARTH else matvec(motion.rotation[b], axis)


@kernel
def twist_kinematics(link, mode, motion):
    """State of a torsion spring."""
    U = axis_vector(link, 0, 0, motion)
    V = axis_vector(link, 0, 1, motion)
    W = axis_vector(link, 0, 2, motion)
    u = axis_vector(link, 1, 0, motion)
    v = axis_vector(link, 1, 1, motion)
    w = axis_vector(link, 1, 2, motion)
    cosine = dot(u, U)
    half_turns = mode[HALF_TURNS]
    sign = 1.0 if half_turns % 2 == 0 else -1.0
    turned = atan2(sign * (dot(w, V) - dot(v, W)), sign * (dot(v, V) + dot(w, W)))
    swing = 1.0 + cosine
    g = scale(1.0 / swing if swing > 0.0 else 0.0, add(u, U))
    x = pi * half_turns + turned - link.neutral
    return _rotation_kinematics(
        x, g, relative_turn_rate(link.body, link.other, motion), swing - MIN_SWING_COSINE, turned
    )


@kernel
def small_twist(link, mode, motion):
    """State of a torsion spring with small angles."""
    axis = vector(link.axes, 0)
    angle = dot(axis, relative_small_turn(link.body, link.other, motion))
    turned = angle - pi * mode[HALF_TURNS]
    return _rotation_kinematics(
        angle - link.neutral, axis, relative_turn_rate(link.body, link.other, motion), 1.0, turned
    )


@kernel
def _rotation_kinematics(x, g, omega, room, turned):
    """The `LinkKinematics` of a twist x with the gradient ``g``."""
    return LinkKinematics(x, dot(g, omega), (0.0, 0.0, 0.0), scale(-1.0, g), g, room, turned)


@kernel
def resistance(link, rate):
    """c x' + d |x'| x' of a link."""
    return (link.damping + link.drag * abs(rate)) * rate


@kernel
def load_of(link, mode, r, p):
    """T of a link; not a number where it has no direction, so that the run ends."""
    if mode[MODE] == UNDEFINED:
        return nan
    return curves.curve_force(p.segments[mode[SEGMENT]], r.x) + resistance(link, r.rate)


@root
def add_force(t, y, modes, motion, bodies, p, loads):
    """Add the force [N, N m] of every link to its row of ``wrench``, and the power [W] that it
    dissipates to ``rate``, in place."""
    for i in range(p.links.size):
        link = p.links[i]
        mode = modes[p.mode + i]
        if mode[MODE] == INACTIVE:
            continue
        r = kinematics(link, mode, bodies, motion)
        T = load_of(link, mode, r, p)
        loads.rate[link.row] += resistance(link, r.rate) * r.rate
        add_wrench(link.body, scale(T, r.force), scale(T, r.moment), loads.wrench[link.row])
        if link.other != EARTH:
            add_wrench(link.other, scale(-T, r.force), scale(T, r.counter), loads.wrench[link.row])


@root
def add_energy(t, y, modes, motion, bodies, p, stored):
    """Add the energy stored in every link to its row of ``stored``."""
    for i in range(p.links.size):
        link = p.links[i]
        mode = modes[p.mode + i]
        if mode[MODE] == ACTING:
            r = kinematics(link, mode, bodies, motion)
            stored[link.row] += curves.stored_energy(p.segments[mode[SEGMENT]], r.x)


@root
def write_outputs(modes, motion, bodies, p, out):
    """Write rows of `LINK_OUTPUTS` of all links to ``out``: load, length or twist, dissipated
    power."""
    for i in range(p.links.size):
        row = out[LINK_OUTPUTS * i : LINK_OUTPUTS * (i + 1)]
        row[LOAD_OUTPUT], row[PLACE_OUTPUT], row[POWER_OUTPUT] = link_outputs(
            i, modes, motion, bodies, p
        )


@kernel
def link_outputs(i, modes, motion, bodies, p):
    """Load, length or twist, and dissipated power of link ``i``."""
    link = p.links[i]
    mode = modes[p.mode + i]
    r = kinematics(link, mode, bodies, motion)
    place = r.x + link.neutral
    if mode[MODE] == INACTIVE:
        return 0.0, place, 0.0
    return load_of(link, mode, r, p), place, resistance(link, r.rate) * r.rate


@root
def find_margins(modes, motion, bodies, p, out):
    """Margins of all links into ``out`` (4 to a row of modes): room before their direction is lost,
    distance to the nearer corner of the curve, room in the half turn."""
    for i in range(p.links.size):
        link = p.links[i]
        mode = modes[p.mode + i]
        m = MARGINS * (p.mode + i)
        for k in range(MARGINS):
            out[m + k] = 1.0
        if mode[MODE] != ACTING:
            continue
        r = kinematics(link, mode, bodies, motion)
        out[m + CONTACT_MARGIN] = r.room
        out[m + RISING_MARGIN] = MAX_HALF_TURN - abs(r.turned)
        if link.last > link.first:
            out[m + SEGMENT_MARGIN] = curves.segment_margin(p.segments[mode[SEGMENT]], r.x)


@root
def transition(i, which, modes, motion, bodies, p):
    """Switch link ``i`` to its next mode, after margin ``which`` has reached zero."""
    link = p.links[i]
    mode = modes[p.mode + i]
    r = kinematics(link, mode, bodies, motion)
    if which == CONTACT_MARGIN:
        mode[MODE] = UNDEFINED
    elif which == RISING_MARGIN:
        mode[HALF_TURNS] += 1 if r.turned > 0.0 else -1
    else:
        mode[SEGMENT] = curves.next_segment(mode[SEGMENT], p.segments[mode[SEGMENT]], r.x)


@root
def set_initial_modes(modes, motion, bodies, p):
    """Modes of all links for a start."""
    for i in range(p.links.size):
        activate(i, modes, motion, bodies, p)


@kernel
def activate(i, modes, motion, bodies, p):
    """Mode of link ``i`` when it becomes active. Its twist is then within half a turn."""
    link = p.links[i]
    mode = modes[p.mode + i]
    mode[HALF_TURNS] = 0
    r = kinematics(link, mode, bodies, motion)
    mode[SEGMENT] = curves.find_segment(link.first, link.last, p.segments, r.x)
    mode[MODE] = ACTING if r.room > 0.0 else UNDEFINED


@kernel
def deactivate(i, modes, p):
    """Deactivate link ``i``."""
    modes[p.mode + i, MODE] = INACTIVE


class LinkKind(KindWithModeSets):
    unit = "link"
    variables: ClassVar = {
        "strut_force": Variable("force, tension positive", "N", "from the point to the anchor"),
        "strut_length": Variable("distance from the point to the anchor", "m"),
        "torsion_moment": Variable("moment against the twist", "N m", "about the axis"),
        "torsion_angle": Variable("twist about the axis from rest", "rad"),
        "pto_power": Variable("power absorbed by a power take-off", "W"),
        "link_mode": Variable("whether a strut or torsion spring acts", "1", flags="acting absent"),
        "link_segment": Variable("piece of the curve", "1"),
        "link_half_turns": Variable("half turns of the twist", "1"),
    }

    def modes(self, p: LinkConstants) -> ModeRows:
        links = p.links
        first, last, slope = links["first"], links["last"], links["steepest"]
        return ModeRows(links.size, rising="half_turns", first=first, last=last, steepest=slope)

    def mode_sets(self, p: LinkConstants) -> Sequence[ModeSet]:
        """All on the piece of their curve without load, and on their steepest."""
        if not p.links.size:
            return []
        idle, stiff = [], []
        for link in p.links:
            pieces = p.segments[link["first"] : link["last"] + 1]
            idle.append(link["first"] + curves.piece_at(pieces, 0.0))
            stiff.append(steepest_segment(p.segments, link["first"], link["last"]))
        sets = [ModeSet("", rest_at_first(np.array(idle), ACTING))]
        if stiff != idle:
            text = "struts on their steepest pieces"
            sets.append(ModeSet(text, rest_at_first(np.array(stiff), ACTING)))
        return sets

    def moved_onto_segment(
        self, p: LinkConstants, modes: np.ndarray, bodies: Any, motion: Any
    ) -> LinkConstants:
        """Constants in which each link is on its piece, at the offset nearest to where it is."""
        links = p.links.copy()
        for link, mode in zip(links, modes, strict=True):
            x = kinematics(link, mode, bodies, motion).x
            piece = p.segments[mode[SEGMENT]]
            link["neutral"] += x - np.clip(x, piece["lower"], piece["upper"])
        return p._replace(links=links)

    def resistances(self, p: LinkConstants) -> Iterator[LinearResistance]:
        """Damping of each torsion spring with small angles; struts are never linear."""
        for link in p.links[p.links["kind"] == AXIS_LINK]:
            axis = link["axes"][:3]
            J = np.array([0.0, 0.0, 0.0, *axis])
            if link["other"] != EARTH:
                J = np.concatenate([J, -J])
            B = link["damping"] * np.outer(J, J)
            yield LinearResistance(
                link["row"], link["body"], B, np.zeros(len(B)), other=link["other"]
            )

    def undefined_units(self, p: LinkConstants, modes: np.ndarray) -> Iterator[tuple[int, str]]:
        reasons = {
            LINE_LINK: "its ends meet (closer than 1 % of its length), where it has no direction",
            AXIS_LINK: "its axis has swung to the opposite, where its twist is not defined",
        }
        for i in np.flatnonzero(modes[:, MODE] == UNDEFINED).tolist():
            yield i, reasons[int(p.links[i]["kind"])]

    def coordinates(self, scene: Scene) -> dict[str, object]:
        every = elements_of(scene, Link)
        struts = elements_of(scene, Strut)
        named = {
            "link": every,
            "strut": struts,
            "torsion_spring": elements_of(scene, TorsionSpring),
            "pto": [(n, e) for n, e in every if getattr(e, "absorbs", False)],
        }
        coordinates_by_dim: dict[str, object] = {
            d: (d, [n for n, _ in units]) for d, units in named.items() if units
        }
        return coordinates_by_dim | capacity_of("strut", struts)

    def record(self, p: LinkConstants, bodies: Any, unit_record: UnitRecord) -> Columns:
        kind = p.links["kind"]
        dims = {
            "strut": (
                kind == LINE_LINK,
                {"strut_force": LOAD_OUTPUT, "strut_length": PLACE_OUTPUT},
            ),
            "torsion_spring": (
                kind == AXIS_LINK,
                {"torsion_moment": LOAD_OUTPUT, "torsion_angle": PLACE_OUTPUT},
            ),
            "pto": (p.links["absorbs"], {"pto_power": POWER_OUTPUT}),
        }
        columns_by_name: Columns = {
            "link_mode": (("time", "link"), unit_record.modes[:, :, MODE].astype(np.int8))
        }
        for dim, (units, columns) in dims.items():
            if units.any():
                for name, column in columns.items():
                    columns_by_name[name] = (("time", dim), unit_record.observed[:, units, column])
        return columns_by_name


LINK_KIND = LinkKind("links", (Strut, TorsionSpring), compile_elements)
