"""Passive compensator: a gas spring in a line, with end stops. It pulls only.

    x = |a - p| - L,   f(x) = T0 (h / (h - x))^n   for |x| <= S/2,   T = max(0, f(x) + c x')

p: point on the body, which receives T along the line; a: its anchor on the earth or on another
body, which receives the opposite; L: length in the middle of the stroke S, where the tension is T0;
h: volume of the gas over the area of its piston there; n: exponent of p V^n = const, 1 for slow and
about 1.4 for fast motion of nitrogen; c: damping. As the line gets longer the piston compresses
the gas.

Beyond the stroke the piston is on a stop, and the gas keeps its pressure:

    f(x) = f(S/2) + k (x - S/2)   or   f(-S/2) - k (-S/2 - x),   until it is slack

k: stiffness of line and stop. Stops and slack are events, and so are the moments where damping
alone would push. Stored energy is the integral of f from the middle of the stroke. Dissipation is
(T - f) x'.

Limits: no mass of the piston, no heat to or from the gas, no flow to a bottle but by c.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import log
from typing import Any, ClassVar, NamedTuple

import numpy as np

from hydrosim.forces.contact.geometry import EARTH
from hydrosim.forces.kind import Columns, ModeRows, UnitRecord, Variable, capacity_of, elements_of
from hydrosim.forces.layout import Layout
from hydrosim.forces.pair import TwoPointElement, apply_tension, line_between
from hydrosim.forces.postures import (
    LINEARISATION_DEPTH,
    KindWithModeSets,
    ModeSet,
    rest_at_first,
    with_mode_of_unit,
)
from hydrosim.jit.kernels import kernel, root
from hydrosim.modes import CONTACT_MARGIN, MARGINS, MODE, SEGMENT, SEGMENT_MARGIN
from hydrosim.rigid.vectors import vector
from hydrosim.scene import ForceElement, Scene

PULLING, TENSION_CUT, CYLINDER_INACTIVE = range(3)
SLACK_PIECE, LOWER, GAS, UPPER = range(4)
CYLINDER_TENSION, STROKE, COMPENSATOR_OUTPUTS = range(3)  # see `write_outputs`


@dataclass(frozen=True)
class Compensator(TwoPointElement):
    """From ``point`` of the body to ``anchor`` on the earth or in the frame of ``anchor_body``: the
    ``tension`` [N] at the ``length`` [m] in the middle of the ``stroke`` [m]; the ``gas_length``
    [m] there, the ``exponent``, the ``stiffness`` [N/m] on the stops, the ``damping`` [N s/m]."""

    point: tuple[float, ...]
    anchor: tuple[float, ...]
    length: float
    tension: float
    stroke: float
    gas_length: float
    exponent: float
    stiffness: float
    damping: float = 0.0
    anchor_body: str | None = None


CYLINDER = np.dtype(
    [
        *(("body", int), ("row", int), ("point", float, 3)),
        *(("anchor_body", int), ("anchor", float, 3), ("length", float)),
        *(("tension", float), ("gas", float), ("exponent", float)),
        *(("half", float), ("stiffness", float), ("damping", float)),
        *(("low", float), ("high", float)),
    ]
)
"""Constants of a compensator: its ends, L; T0, h, n; S/2, k, c; f at both ends of the stroke."""


class CompensatorConstants(NamedTuple):
    """The compensators ``each`` (n,) of `CYLINDER`, and the first of their rows of modes: pulling
    or cut, and the segment."""

    each: np.ndarray
    mode: int


class CylinderKinematics(NamedTuple):
    """State of one compensator: lever arms of both ends, the direction, x and its rate."""

    arm: tuple[float, float, float]
    anchor_arm: tuple[float, float, float]
    direction: tuple[float, float, float]
    x: float
    rate: float


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> CompensatorConstants:
    """Constants of the compensators among ``elements``, in their order."""
    rows = []
    for name, e in elements.items():
        if isinstance(e, Compensator):
            anchor = layout.body[e.anchor_body] if e.anchor_body else EARTH
            ends = (layout.body[e.body], layout.row[name], e.point, anchor, e.anchor, e.length)
            half = 0.5 * e.stroke
            low = e.tension * (e.gas_length / (e.gas_length + half)) ** e.exponent
            high = e.tension * (e.gas_length / (e.gas_length - half)) ** e.exponent
            gas = (e.tension, e.gas_length, e.exponent)
            rows.append((*ends, *gas, half, e.stiffness, e.damping, low, high))
    return CompensatorConstants(np.array(rows, dtype=CYLINDER), 0)


@kernel
def kinematics(one, bodies, motion):
    """State of a compensator, as a `CylinderKinematics`."""
    point = vector(one.point, 0)
    anchor = vector(one.anchor, 0)
    s = line_between(one.body, point, one.anchor_body, anchor, bodies, motion)
    return CylinderKinematics(s.arm, s.other_arm, s.direction, s.length - one.length, s.rate)


@kernel
def static_tension(one, segment, x):
    """f(x) on a segment."""
    if segment == GAS:
        return one.tension * (one.gas / (one.gas - x)) ** one.exponent
    if segment == UPPER:
        return one.high + one.stiffness * (x - one.half)
    if segment == LOWER:
        return one.low + one.stiffness * (x + one.half)
    return 0.0


@kernel
def stored_energy(one, segment, x):
    """Integral of f from the middle of the stroke to x."""
    if segment == GAS:
        return _gas_energy(one, x)
    if segment == UPPER:
        d = x - one.half
        return _gas_energy(one, one.half) + (one.high + 0.5 * one.stiffness * d) * d
    d = -one.low / one.stiffness  # where it becomes slack
    if segment == LOWER:
        d = x + one.half
    return _gas_energy(one, -one.half) + (one.low + 0.5 * one.stiffness * d) * d


@kernel
def _gas_energy(one, x):
    h = one.gas
    n = one.exponent
    if n == 1.0:
        return one.tension * h * log(h / (h - x))
    return one.tension * h / (n - 1.0) * ((h / (h - x)) ** (n - 1.0) - 1.0)


@kernel
def cylinder_tension(one, mode, r):
    """T and f of a compensator."""
    f = static_tension(one, mode[SEGMENT], r.x)
    if mode[MODE] != PULLING or mode[SEGMENT] == SLACK_PIECE:
        return 0.0, f
    return f + one.damping * r.rate, f


@root
def add_force(t, y, modes, motion, bodies, p, wrench, rate, dy):
    """Add the force [N, N m] of every compensator to its row of ``wrench``, and the power [W] that
    it dissipates to ``rate``, in place."""
    for i in range(p.each.size):
        one = p.each[i]
        mode = modes[p.mode + i]
        if mode[MODE] == CYLINDER_INACTIVE:
            continue
        r = kinematics(one, bodies, motion)
        T, f = cylinder_tension(one, mode, r)
        rate[one.row] += (T - f) * r.rate
        apply_tension(one, r, T, wrench[one.row])


@root
def add_energy(t, y, modes, motion, bodies, p, stored):
    """Add the energy stored in every compensator to its row of ``stored``."""
    for i in range(p.each.size):
        one = p.each[i]
        mode = modes[p.mode + i]
        if mode[MODE] != CYLINDER_INACTIVE:
            x = kinematics(one, bodies, motion).x
            stored[one.row] += stored_energy(one, mode[SEGMENT], x)


@root
def write_outputs(modes, motion, bodies, p, out):
    """Write rows of `COMPENSATOR_OUTPUTS` of all compensators to ``out``: T and x."""
    for i in range(p.each.size):
        r = kinematics(p.each[i], bodies, motion)
        row = out[COMPENSATOR_OUTPUTS * i : COMPENSATOR_OUTPUTS * (i + 1)]
        row[CYLINDER_TENSION], _ = cylinder_tension(p.each[i], modes[p.mode + i], r)
        row[STROKE] = r.x


@kernel
def _lower_end(one, segment):
    """x where a segment begins."""
    if segment == UPPER:
        return one.half
    return -one.half if segment == GAS else -one.half - one.low / one.stiffness


@kernel
def _upper_end(one, segment):
    """x where a segment ends."""
    if segment == GAS:
        return one.half
    return -one.half if segment == LOWER else -one.half - one.low / one.stiffness


@root
def find_margins(modes, motion, bodies, p, out):
    """Margins of all compensators into ``out`` (4 to a row of modes): T, or its opposite where it
    is cut; the way to the nearer end of the segment."""
    for i in range(p.each.size):
        one = p.each[i]
        mode = modes[p.mode + i]
        m = MARGINS * (p.mode + i)
        for k in range(MARGINS):
            out[m + k] = 1.0
        if mode[MODE] == CYLINDER_INACTIVE:
            continue
        r = kinematics(one, bodies, motion)
        segment = mode[SEGMENT]
        if segment == SLACK_PIECE:
            out[m + SEGMENT_MARGIN] = _upper_end(one, segment) - r.x
        elif segment == UPPER:
            out[m + SEGMENT_MARGIN] = r.x - one.half
        else:
            room = min(r.x - _lower_end(one, segment), _upper_end(one, segment) - r.x)
            out[m + SEGMENT_MARGIN] = room
        if one.damping > 0.0 and segment != SLACK_PIECE:
            T = static_tension(one, segment, r.x) + one.damping * r.rate
            out[m + CONTACT_MARGIN] = T if mode[MODE] == PULLING else -T


@root
def transition(i, which, modes, motion, bodies, p):
    """Switch compensator ``i`` to its next mode, after margin ``which`` has reached zero."""
    one = p.each[i]
    mode = modes[p.mode + i]
    if which == CONTACT_MARGIN:
        mode[MODE] = TENSION_CUT if mode[MODE] == PULLING else PULLING
        return
    segment = mode[SEGMENT]
    r = kinematics(one, bodies, motion)
    if segment == SLACK_PIECE:
        mode[SEGMENT] = LOWER
        mode[MODE] = PULLING
    elif segment == UPPER:
        mode[SEGMENT] = GAS
    else:
        up = _upper_end(one, segment) - r.x < r.x - _lower_end(one, segment)
        mode[SEGMENT] = segment + 1 if up else segment - 1


@root
def set_initial_modes(modes, motion, bodies, p):
    """Modes of all compensators for a start."""
    for i in range(p.each.size):
        activate(i, modes, motion, bodies, p)


@kernel
def activate(i, modes, motion, bodies, p):
    """Mode of compensator ``i`` when it becomes active."""
    one = p.each[i]
    mode = modes[p.mode + i]
    r = kinematics(one, bodies, motion)
    segment = SLACK_PIECE
    while segment < UPPER and r.x >= _upper_end(one, segment):
        segment += 1
    mode[SEGMENT] = segment
    mode[MODE] = PULLING
    if static_tension(one, segment, r.x) + one.damping * r.rate < 0.0:
        mode[MODE] = TENSION_CUT


@kernel
def deactivate(i, modes, p):
    """Deactivate compensator ``i``."""
    modes[p.mode + i, MODE] = CYLINDER_INACTIVE
    modes[p.mode + i, SEGMENT] = SLACK_PIECE


class CompensatorKind(KindWithModeSets):
    unit = "compensator"
    variables: ClassVar = {
        "compensator_tension": Variable("tension", "N", "from the point to the anchor"),
        "compensator_stroke": Variable("extension from the middle of the stroke", "m"),
        "compensator_mode": Variable(
            "pulling, or cut by its damping", "1", flags="pulling cut absent"
        ),
        "compensator_segment": Variable("slack, lower stop, gas, upper stop", "1"),
    }

    def modes(self, p: CompensatorConstants) -> ModeRows:
        count = p.each.size
        return ModeRows(
            count,
            first=np.zeros(count, dtype=int),
            last=np.full(count, UPPER),
            steepest=p.each["stiffness"],
        )

    def mode_sets(self, p: CompensatorConstants) -> Sequence[ModeSet]:
        if not p.each.size:
            return []
        return [
            ModeSet("compensators in their stroke", _modes_on_segment(p, GAS)),
            ModeSet("compensators on their stops", _modes_on_segment(p, UPPER)),
        ]

    def one_unit_active(
        self, p: CompensatorConstants, names: Sequence[str], which: Sequence[int]
    ) -> Iterator[ModeSet]:
        for i in which if p.each.size > 1 else ():
            one = with_mode_of_unit(_modes_on_segment(p, GAS), _modes_on_segment(p, UPPER), i)
            yield ModeSet(f"{names[i]} alone on its stop", one)

    def equivalence_keys(self, p: CompensatorConstants) -> Sequence[Hashable]:
        """No two compensators are alike: each pulls in a direction of its own."""
        return range(p.each.size)

    def rates(self, p: CompensatorConstants, bodies: Any, motion: Any) -> np.ndarray:
        """Along the lines."""
        return np.reshape([kinematics(one, bodies, motion).rate for one in p.each], (-1, 1))

    def moved_onto_segment(
        self, p: CompensatorConstants, modes: np.ndarray, bodies: Any, motion: Any
    ) -> CompensatorConstants:
        """Constants in which each is at the end of its stroke, where the gas is stiffest, or on its
        stop."""
        each = p.each.copy()
        for one, (_, segment, _) in zip(each, modes, strict=True):
            x = one["half"] + (LINEARISATION_DEPTH if segment == UPPER else 0.0)
            one["length"] += kinematics(one, bodies, motion).x - x
        return p._replace(each=each)

    def coordinates(self, scene: Scene) -> dict[str, object]:
        own = elements_of(scene, Compensator)
        return super().coordinates(scene) | capacity_of(self.unit, own)

    def record(self, p: CompensatorConstants, bodies: Any, kept: UnitRecord) -> Columns:
        each = ("time", self.unit)
        return {
            "compensator_tension": (each, kept.observed[:, :, CYLINDER_TENSION]),
            "compensator_stroke": (each, kept.observed[:, :, STROKE]),
            "compensator_mode": (each, kept.modes[:, :, MODE].astype(np.int8)),
        }


def _modes_on_segment(p: CompensatorConstants, segment: int) -> np.ndarray:
    """Modes with all compensators on one segment."""
    return rest_at_first(np.full(p.each.size, segment), PULLING)


COMPENSATOR_KIND = CompensatorKind("compensators", (Compensator,), compile_elements)
