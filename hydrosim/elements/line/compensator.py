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

from hydrosim.elements.contact.geometry import EARTH
from hydrosim.elements.kind import (
    LINEARISATION_DEPTH,
    Columns,
    KindWithModeSets,
    Layout,
    ModeRows,
    ModeSet,
    UnitRecord,
    Variable,
    capacity_of,
    elements_of,
    rest_at_first,
    with_mode_of_unit,
)
from hydrosim.elements.pair import TwoPointElement, apply_tension, line_between
from hydrosim.jit.kernels import kernel, root
from hydrosim.modes import CONTACT_MARGIN, MARGINS, MODE, SEGMENT, SEGMENT_MARGIN
from hydrosim.multibody.vectors import vector
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
def kinematics(cylinder, bodies, motion):
    """State of a compensator, as a `CylinderKinematics`."""
    point = vector(cylinder.point, 0)
    anchor = vector(cylinder.anchor, 0)
    s = line_between(cylinder.body, point, cylinder.anchor_body, anchor, bodies, motion)
    return CylinderKinematics(s.arm, s.other_arm, s.direction, s.length - cylinder.length, s.rate)


@kernel
def static_tension(cylinder, segment, x):
    """f(x) on a segment."""
    if segment == GAS:
        return cylinder.tension * (cylinder.gas / (cylinder.gas - x)) ** cylinder.exponent
    if segment == UPPER:
        return cylinder.high + cylinder.stiffness * (x - cylinder.half)
    if segment == LOWER:
        return cylinder.low + cylinder.stiffness * (x + cylinder.half)
    return 0.0


@kernel
def stored_energy(cylinder, segment, x):
    """Integral of f from the middle of the stroke to x."""
    if segment == GAS:
        return _gas_energy(cylinder, x)
    if segment == UPPER:
        d = x - cylinder.half
        return (
            _gas_energy(cylinder, cylinder.half)
            + (cylinder.high + 0.5 * cylinder.stiffness * d) * d
        )
    d = -cylinder.low / cylinder.stiffness  # where it becomes slack
    if segment == LOWER:
        d = x + cylinder.half
    return _gas_energy(cylinder, -cylinder.half) + (cylinder.low + 0.5 * cylinder.stiffness * d) * d


@kernel
def _gas_energy(cylinder, x):
    h = cylinder.gas
    n = cylinder.exponent
    if n == 1.0:
        return cylinder.tension * h * log(h / (h - x))
    return cylinder.tension * h / (n - 1.0) * ((h / (h - x)) ** (n - 1.0) - 1.0)


@kernel
def cylinder_tension(cylinder, mode, r):
    """T and f of a compensator."""
    f = static_tension(cylinder, mode[SEGMENT], r.x)
    if mode[MODE] != PULLING or mode[SEGMENT] == SLACK_PIECE:
        return 0.0, f
    return f + cylinder.damping * r.rate, f


@root
def add_force(t, y, modes, motion, bodies, p, loads):
    """Add the force [N, N m] of every compensator to its row of ``wrench``, and the power [W] that
    it dissipates to ``rate``, in place."""
    for i in range(p.each.size):
        cylinder = p.each[i]
        mode = modes[p.mode + i]
        if mode[MODE] == CYLINDER_INACTIVE:
            continue
        r = kinematics(cylinder, bodies, motion)
        T, f = cylinder_tension(cylinder, mode, r)
        loads.rate[cylinder.row] += (T - f) * r.rate
        apply_tension(cylinder, r, T, loads.wrench[cylinder.row])


@root
def add_energy(t, y, modes, motion, bodies, p, stored):
    """Add the energy stored in every compensator to its row of ``stored``."""
    for i in range(p.each.size):
        cylinder = p.each[i]
        mode = modes[p.mode + i]
        if mode[MODE] != CYLINDER_INACTIVE:
            x = kinematics(cylinder, bodies, motion).x
            stored[cylinder.row] += stored_energy(cylinder, mode[SEGMENT], x)


@root
def write_outputs(modes, motion, bodies, p, out):
    """Write rows of `COMPENSATOR_OUTPUTS` of all compensators to ``out``: T and x."""
    for i in range(p.each.size):
        r = kinematics(p.each[i], bodies, motion)
        row = out[COMPENSATOR_OUTPUTS * i : COMPENSATOR_OUTPUTS * (i + 1)]
        row[CYLINDER_TENSION], _ = cylinder_tension(p.each[i], modes[p.mode + i], r)
        row[STROKE] = r.x


@kernel
def _lower_end(cylinder, segment):
    """x where a segment begins."""
    if segment == UPPER:
        return cylinder.half
    return -cylinder.half if segment == GAS else -cylinder.half - cylinder.low / cylinder.stiffness


@kernel
def _upper_end(cylinder, segment):
    """x where a segment ends."""
    if segment == GAS:
        return cylinder.half
    return (
        -cylinder.half if segment == LOWER else -cylinder.half - cylinder.low / cylinder.stiffness
    )


@root
def find_margins(modes, motion, bodies, p, out):
    """Margins of all compensators into ``out`` (4 to a row of modes): T, or its opposite where it
    is cut; the way to the nearer end of the segment."""
    for i in range(p.each.size):
        cylinder = p.each[i]
        mode = modes[p.mode + i]
        m = MARGINS * (p.mode + i)
        for k in range(MARGINS):
            out[m + k] = 1.0
        if mode[MODE] == CYLINDER_INACTIVE:
            continue
        r = kinematics(cylinder, bodies, motion)
        segment = mode[SEGMENT]
        if segment == SLACK_PIECE:
            out[m + SEGMENT_MARGIN] = _upper_end(cylinder, segment) - r.x
        elif segment == UPPER:
            out[m + SEGMENT_MARGIN] = r.x - cylinder.half
        else:
            room = min(r.x - _lower_end(cylinder, segment), _upper_end(cylinder, segment) - r.x)
            out[m + SEGMENT_MARGIN] = room
        if cylinder.damping > 0.0 and segment != SLACK_PIECE:
            T = static_tension(cylinder, segment, r.x) + cylinder.damping * r.rate
            out[m + CONTACT_MARGIN] = T if mode[MODE] == PULLING else -T


@root
def transition(i, which, modes, motion, bodies, p):
    """Switch compensator ``i`` to its next mode, after margin ``which`` has reached zero."""
    cylinder = p.each[i]
    mode = modes[p.mode + i]
    if which == CONTACT_MARGIN:
        mode[MODE] = TENSION_CUT if mode[MODE] == PULLING else PULLING
        return
    segment = mode[SEGMENT]
    r = kinematics(cylinder, bodies, motion)
    if segment == SLACK_PIECE:
        mode[SEGMENT] = LOWER
        mode[MODE] = PULLING
    elif segment == UPPER:
        mode[SEGMENT] = GAS
    else:
        up = _upper_end(cylinder, segment) - r.x < r.x - _lower_end(cylinder, segment)
        mode[SEGMENT] = segment + 1 if up else segment - 1


@root
def set_initial_modes(modes, motion, bodies, p):
    """Modes of all compensators for a start."""
    for i in range(p.each.size):
        activate(i, modes, motion, bodies, p)


@kernel
def activate(i, modes, motion, bodies, p):
    """Mode of compensator ``i`` when it becomes active."""
    cylinder = p.each[i]
    mode = modes[p.mode + i]
    r = kinematics(cylinder, bodies, motion)
    segment = SLACK_PIECE
    while segment < UPPER and r.x >= _upper_end(cylinder, segment):
        segment += 1
    mode[SEGMENT] = segment
    mode[MODE] = PULLING
    if static_tension(cylinder, segment, r.x) + cylinder.damping * r.rate < 0.0:
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
            cylinder = with_mode_of_unit(_modes_on_segment(p, GAS), _modes_on_segment(p, UPPER), i)
            yield ModeSet(f"{names[i]} alone on its stop", cylinder)

    def equivalence_keys(self, p: CompensatorConstants) -> Sequence[Hashable]:
        """No two compensators are alike: each pulls in a direction of its own."""
        return range(p.each.size)

    def rates(self, p: CompensatorConstants, bodies: Any, motion: Any) -> np.ndarray:
        """Along the lines."""
        return np.reshape(
            [kinematics(cylinder, bodies, motion).rate for cylinder in p.each], (-1, 1)
        )

    def moved_onto_segment(
        self, p: CompensatorConstants, modes: np.ndarray, bodies: Any, motion: Any
    ) -> CompensatorConstants:
        """Constants in which each is at the end of its stroke, where the gas is stiffest, or on its
        stop."""
        constants = p.each.copy()
        for cylinder, (_, segment, _) in zip(constants, modes, strict=True):
            x = cylinder["half"] + (LINEARISATION_DEPTH if segment == UPPER else 0.0)
            cylinder["length"] += kinematics(cylinder, bodies, motion).x - x
        return p._replace(each=constants)

    def coordinates(self, scene: Scene) -> dict[str, object]:
        compensators = elements_of(scene, Compensator)
        return super().coordinates(scene) | capacity_of(self.unit, compensators)

    def record(self, p: CompensatorConstants, bodies: Any, unit_record: UnitRecord) -> Columns:
        dims = ("time", self.unit)
        return {
            "compensator_tension": (dims, unit_record.observed[:, :, CYLINDER_TENSION]),
            "compensator_stroke": (dims, unit_record.observed[:, :, STROKE]),
            "compensator_mode": (dims, unit_record.modes[:, :, MODE].astype(np.int8)),
        }


def _modes_on_segment(p: CompensatorConstants, segment: int) -> np.ndarray:
    """Modes with all compensators on one segment."""
    return rest_at_first(np.full(p.each.size, segment), PULLING)


COMPENSATOR_KIND = CompensatorKind("compensators", (Compensator,), compile_elements)
