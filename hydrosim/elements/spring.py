"""Spring between two points, with a table: a mooring line, a tug line, a connection. It pulls only.

    x = |a - p| - L0,   e = (a - p) / |a - p|,   T = max(0, f(x) + c x'),   F = T e

p: point on the body, which receives F there; a: its anchor on the earth or on another body, which
receives -F there; L0: length without load, constant or a signal over time; f(x): straight lines
through the points of the table, with the last slope continued; c: damping. Before the first point
of the table the line is slack: T = 0.

Slack is the first segment of the curve. Its corners are events. Events also mark where damping
alone would push (T is cut), and where it ceases to: in between, T is smooth. Stored energy is the
integral of f. Dissipation is (T - f) x': c x'^2 while taut, and the energy that the spring releases
while T is cut. Where L0 changes, T L0' is booked with it: the energy that goes into the drum, below
zero if it heaves in.

Limits: no mass, no sag, no drag of the line; with damping, T jumps to c x' where a line snaps taut,
and by c times the change of L0' at the corners of a table of L0. With small angles lever arms stay
as at rest while e follows the points. Power is then exact, and moments of the two ends are opposite
to the first order of the displacement.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from hydrosim.elements import signal
from hydrosim.elements.contact import curves
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
    steepest_segment,
    with_mode_of_unit,
)
from hydrosim.elements.pair import TwoPointElement, apply_tension, line_between
from hydrosim.elements.signal import rate as rate_of
from hydrosim.jit.kernels import kernel, root
from hydrosim.modes import (
    CONTACT_MARGIN,
    FRICTION_MARGIN,
    MARGINS,
    MODE,
    RISING_MARGIN,
    SEGMENT,
    SEGMENT_MARGIN,
)
from hydrosim.multibody.vectors import vector
from hydrosim.scene import ForceElement, Scene

SLACK, TAUT, SPRING_INACTIVE = range(3)
SPRING_TENSION, SPRING_LENGTH, SPRING_OUTPUTS = range(3)  # see `write_outputs`


@dataclass(frozen=True)
class Spring(TwoPointElement):
    """From ``point`` of the body to ``anchor`` on the earth or in the frame of ``anchor_body``: the
    ``tension`` (n,) [N], not falling from 0, over the ``extension`` (n,) [m], rising, of a
    ``length`` [m] without load, which may be a signal over time; ``damping`` [N s/m]."""

    point: tuple[float, ...]
    anchor: tuple[float, ...]
    length: signal.Signal | float
    extension: np.ndarray
    tension: np.ndarray
    damping: float = 0.0
    anchor_body: str | None = None

    def can_add_energy(self) -> bool:
        """A line that is heaved in gives energy."""
        return isinstance(self.length, signal.Signal)

    def signals(self) -> Iterator[tuple[str, Any]]:
        if isinstance(self.length, signal.Signal):
            yield "length", self.length

    def jumps(self) -> Iterator[tuple[str, float]]:
        if isinstance(self.length, signal.Table):
            yield "length", self.damping * signal.largest_corner(self.length)


SPRING = np.dtype(
    [
        *(("body", int), ("row", int), ("point", float, 3)),
        *(("anchor_body", int), ("anchor", float, 3)),
        *(("length", float), ("varies", bool), ("signal", signal.SIGNAL), ("damping", float)),
        *(("first", int), ("last", int), ("steepest", float)),
    ]
)
"""Constants of a spring: its ends, its length, or the signal of it if that ``varies``; the pieces
``first`` (slack) to ``last`` of its curve."""


class SpringConstants(NamedTuple):
    """``lines`` (n,) of `SPRING`, the ``segments`` of their curves, the ``pieces`` of the signals
    of their lengths, and the first of their rows of modes: slack (tension cut) or taut, and the
    segment."""

    lines: np.ndarray
    segments: np.ndarray
    pieces: np.ndarray
    mode: int


class SpringKinematics(NamedTuple):
    """State of one spring; vectors are tuples in the earth frame, lever arms those of its ends;
    ``extension`` x, its ``rate``, and the ``speed`` L0' at which it is paid out."""

    arm: tuple[float, float, float]
    anchor_arm: tuple[float, float, float]
    direction: tuple[float, float, float]
    length: float
    extension: float
    rate: float
    speed: float


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> SpringConstants:
    """Constants of the springs among ``elements``, in their order."""
    springs = {name: e for name, e in elements.items() if isinstance(e, Spring)}
    signals, moves = signal.compile_signals([s for e in springs.values() for _, s in e.signals()])
    compiled = iter(signals)
    rows = []
    segments = [np.zeros(0, dtype=curves.SEGMENT)]
    first = 0
    for name, e in springs.items():
        pieces = _tension_segments(e)
        last = first + pieces.size - 1
        anchor = layout.body[e.anchor_body] if e.anchor_body else EARTH
        ends = (layout.body[e.body], layout.row[name], e.point, anchor, e.anchor)
        length = (e.length, False, signal.NOTHING)
        if isinstance(e.length, signal.Signal):
            length = (signal.first_value(e.length), True, next(compiled))
        rows.append((*ends, *length, e.damping, first, last, pieces["slope"].max()))
        segments.append(pieces)
        first = last + 1
    return SpringConstants(np.array(rows, dtype=SPRING), np.concatenate(segments), moves, 0)


def _tension_segments(spring: Spring) -> np.ndarray:
    """The pieces of the curve, the slack one before the table's."""
    x = np.asarray(spring.extension, float)
    f = np.asarray(spring.tension, float)
    return curves.segments(np.array([x[0] - 1.0, *x]), np.array([0.0, *f]))


@kernel
def kinematics(line, t, bodies, motion, p):
    """Positions and velocities of the ends of a spring, as a `SpringKinematics`."""
    point = vector(line.point, 0)
    anchor = vector(line.anchor, 0)
    s = line_between(line.body, point, line.anchor_body, anchor, bodies, motion)
    L0 = line.length
    speed = 0.0
    if line.varies:
        L0 = signal.value(t, line.signal, p.pieces)
        speed = rate_of(t, line.signal, p.pieces)
    return SpringKinematics(
        s.arm, s.other_arm, s.direction, s.length, s.length - L0, s.rate - speed, speed
    )


@kernel
def tension(line, mode, s, p):
    """T and f of a spring. T is not cut in the taut mode, so that it is smooth across the event
    that ends the mode."""
    f = curves.curve_force(p.segments[mode[SEGMENT]], s.extension)
    return (f + line.damping * s.rate if mode[MODE] == TAUT else 0.0), f


@root
def add_force(t, y, modes, motion, bodies, p, loads):
    """Add the force [N, N m] of every spring to its row of ``wrench``, and the power [W] that it
    dissipates to ``rate``, in place."""
    for i in range(p.lines.size):
        line = p.lines[i]
        mode = modes[p.mode + i]
        if mode[SEGMENT] == line.first:
            continue
        s = kinematics(line, t, bodies, motion, p)
        T, f = tension(line, mode, s, p)
        loads.rate[line.row] += (T - f) * s.rate + T * s.speed
        apply_tension(line, s, T, loads.wrench[line.row])


@root
def add_energy(t, y, modes, motion, bodies, p, stored):
    """Add the energy stored in every spring to its row of ``stored``."""
    for i in range(p.lines.size):
        line = p.lines[i]
        mode = modes[p.mode + i]
        s = kinematics(line, t, bodies, motion, p)
        stored[line.row] += curves.stored_energy(p.segments[mode[SEGMENT]], s.extension)


@root
def write_outputs(t, modes, motion, bodies, p, out):
    """Write rows of `SPRING_OUTPUTS` of all lines to ``out``: tension and length."""
    for i in range(p.lines.size):
        s = kinematics(p.lines[i], t, bodies, motion, p)
        row = out[SPRING_OUTPUTS * i : SPRING_OUTPUTS * (i + 1)]
        row[SPRING_TENSION], _ = tension(p.lines[i], modes[p.mode + i], s, p)
        row[SPRING_LENGTH] = s.length


@root
def find_margins(t, modes, motion, bodies, p, out):
    """Margins of all springs into ``out`` (4 to a row of modes): for contact T, or its opposite
    where it is cut; for the segment the distance to its nearer corner."""
    for i in range(p.lines.size):
        line = p.lines[i]
        mode = modes[p.mode + i]
        m = MARGINS * (p.mode + i)
        s = kinematics(line, t, bodies, motion, p)
        out[m + CONTACT_MARGIN] = out[m + FRICTION_MARGIN] = out[m + RISING_MARGIN] = 1.0
        if mode[MODE] == SPRING_INACTIVE:
            out[m + SEGMENT_MARGIN] = 1.0
            continue
        out[m + SEGMENT_MARGIN] = curves.segment_margin(p.segments[mode[SEGMENT]], s.extension)
        if line.damping > 0.0 and mode[SEGMENT] != line.first:
            T = curves.curve_force(p.segments[mode[SEGMENT]], s.extension) + line.damping * s.rate
            out[m + CONTACT_MARGIN] = T if mode[MODE] == TAUT else -T


@root
def transition(i, which, t, modes, motion, bodies, p):
    """Switch spring ``i`` to its next mode, after margin ``which`` has reached zero."""
    line = p.lines[i]
    mode = modes[p.mode + i]
    if which == CONTACT_MARGIN:
        mode[MODE] = SLACK if mode[MODE] == TAUT else TAUT
        return
    before = mode[SEGMENT]
    x = kinematics(line, t, bodies, motion, p).extension
    mode[SEGMENT] = curves.next_segment(before, p.segments[before], x)
    if mode[SEGMENT] == line.first:
        mode[MODE] = SLACK
    elif before == line.first:
        mode[MODE] = TAUT


@root
def set_initial_modes(t, modes, motion, bodies, p):
    """Modes of all springs for a start."""
    for i in range(p.lines.size):
        set_initial_mode(i, t, modes, motion, bodies, p)


@kernel
def set_initial_mode(i, t, modes, motion, bodies, p):
    """Mode of spring ``i`` when it becomes active."""
    line = p.lines[i]
    mode = modes[p.mode + i]
    s = kinematics(line, t, bodies, motion, p)
    mode[SEGMENT] = curves.find_segment(line.first, line.last, p.segments, s.extension)
    mode[MODE] = TAUT
    T, _ = tension(line, mode, s, p)
    if mode[SEGMENT] == line.first or T < 0.0:
        mode[MODE] = SLACK


@kernel
def deactivate(i, modes, p):
    """Deactivate spring ``i``."""
    modes[p.mode + i, MODE] = SPRING_INACTIVE
    modes[p.mode + i, SEGMENT] = p.lines[i].first


def _taut_modes(p: SpringConstants) -> np.ndarray:
    """Modes with all lines taut on their steepest pieces."""
    modes = rest_at_first(p.lines["first"], TAUT)
    pieces = [steepest_segment(p.segments, line["first"], line["last"]) for line in p.lines]
    modes[:, SEGMENT] = pieces
    return modes


class SpringKind(KindWithModeSets):
    unit = "spring"
    variables: ClassVar = {
        "spring_tension": Variable("tension", "N", "from the point to the anchor"),
        "spring_length": Variable("distance from the point to the anchor", "m"),
        "spring_mode": Variable("slack (no tension) or taut", "1", flags="slack taut absent"),
        "spring_segment": Variable("piece of the curve, 0 if slack", "1"),
    }

    def modes(self, p: SpringConstants) -> ModeRows:
        lines = p.lines
        return ModeRows(
            lines.size, first=lines["first"], last=lines["last"], steepest=lines["steepest"]
        )

    def mode_sets(self, p: SpringConstants) -> Sequence[ModeSet]:
        if not p.lines.size:
            return []
        slack = rest_at_first(p.lines["first"], SLACK)
        return [ModeSet("springs slack", slack), ModeSet("springs taut", _taut_modes(p))]

    def one_unit_active(
        self, p: SpringConstants, names: Sequence[str], which: Sequence[int]
    ) -> Iterator[ModeSet]:
        slack = rest_at_first(p.lines["first"], SLACK)
        for i in which if p.lines.size > 1 else ():
            yield ModeSet(f"{names[i]} alone taut", with_mode_of_unit(slack, _taut_modes(p), i))

    def equivalence_keys(self, p: SpringConstants) -> Sequence[Hashable]:
        """No two springs are alike: each pulls in a direction of its own."""
        return range(p.lines.size)

    def rates(self, p: SpringConstants, bodies: Any, motion: Any) -> np.ndarray:
        """Along the lines."""
        speeds = [kinematics(line, 0.0, bodies, motion, p).rate for line in p.lines]
        return np.reshape(speeds, (-1, 1))

    def moved_onto_segment(
        self, p: SpringConstants, modes: np.ndarray, bodies: Any, motion: Any
    ) -> SpringConstants:
        """Constants in which each line has the length of its piece."""
        lines = p.lines.copy()
        for line, (mode, segment, _) in zip(lines, modes, strict=True):
            if mode == TAUT:
                extension = p.segments[segment]["start"] + LINEARISATION_DEPTH
                line["length"] = kinematics(line, 0.0, bodies, motion, p).length - extension
                line["varies"] = False
        return p._replace(lines=lines)

    def coordinates(self, scene: Scene) -> dict[str, object]:
        return super().coordinates(scene) | capacity_of(self.unit, elements_of(scene, Spring))

    def record(self, p: SpringConstants, bodies: Any, unit_record: UnitRecord) -> Columns:
        dims = ("time", "spring")
        return {
            "spring_tension": (dims, unit_record.observed[:, :, SPRING_TENSION]),
            "spring_length": (dims, unit_record.observed[:, :, SPRING_LENGTH]),
            "spring_mode": (dims, unit_record.modes[:, :, MODE].astype(np.int8)),
        }


SPRING_KIND = SpringKind("springs", (Spring,), compile_elements)
