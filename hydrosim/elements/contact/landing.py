"""Landings, points of a body that come down on seats, and guides, the walls around seats.

A landing is a contact point whose plane passes through its seat, normal to the ``axis`` along which
the seat carries. It only pushes. It may carry along a loop (`NormalLoop`), be guided
sideways, and has the friction of any contact. Legs of a topside on its substructure, leg mating
units and deck support units are landings.

Guide: the wall around a seat, a cone or a cylinder, that holds a landing's pin sideways.

    e = r - gap + s delta,   F_across = -f(e) u1 / r,   F_along the axis = s f(e)   while e > 0

r = |u1|: distance of the pin from the axis; delta: its compression, negative above the seat; gap:
clearance around a seated pin. Further s: tangent of the angle between wall and axis, 0 for a
cylinder; f: straight lines through a table. The wall has no friction: its stored energy, the
integral of f over e, is a potential of position. It reaches up to the mouth at delta = -depth.

A pin that leaves while pressed loses the stored energy. A pin that comes down outside the mouth is
beside the wall until it has entered. A wall that becomes active (`elements.trigger`) catches a pin
that is inside it; any other pin is beside it. The energy stored in a wall when it ends is lost.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np

from hydrosim.elements import kind
from hydrosim.elements.contact import curves, geometry
from hydrosim.elements.kind import LINEARISATION_DEPTH as COMPRESSED
from hydrosim.jit.kernels import kernel, root
from hydrosim.modes import CONTACT_MARGIN, MARGINS, MODE, RISING_MARGIN, SEGMENT, SEGMENT_MARGIN
from hydrosim.multibody.vectors import length
from hydrosim.scene import ForceElement, Scene
from hydrosim.scene.contacts import Contact, contact_curve

AWAY, FREE, PIN_PRESSED, PIN_BESIDE, INACTIVE = range(5)
GUIDE_MODES = ("away", "free", "pressed", "beside", "inactive")
PIN_FORCE, PIN_CLEARANCE, GUIDE_OUTPUTS = range(3)  # see `write_outputs`
INSIDE = 1.0  # m: limit of the margin from the mouth


PIN = np.dtype(
    [
        *(("point", int), ("row", int), ("gap", float), ("slope", float), ("depth", float)),
        *(("first", int), ("last", int)),
    ]
)
"""A pin: the index of its contact point, the row of its element, its wall."""


class GuideConstants(NamedTuple):
    """``pins`` (n,) of `PIN`, the ``segments`` of their curves; the first of their rows of modes,
    and of the integrals of losses in y, row by row."""

    pins: np.ndarray
    segments: np.ndarray
    mode: int
    losses: int


def compile_elements(elements: Mapping[str, ForceElement], layout: kind.Layout) -> GuideConstants:
    """Constants of the guides of all landings among ``elements``, in their order."""
    rows = []
    segments = [np.zeros(0, dtype=curves.SEGMENT)]
    for name, (begin, end) in kind.unit_ranges(elements, Contact).items():
        wall = getattr(elements[name], "wall", None)
        if wall is None:
            continue
        first = sum(map(len, segments))
        segments.append(curves.segments(*contact_curve(wall)))
        wall_fields = (wall.gap, wall.slope, wall.mouth, first, first + len(segments[-1]) - 1)
        rows += [(i, layout.row[name], *wall_fields) for i in range(begin, end)]
    return GuideConstants(np.array(rows, dtype=PIN), np.concatenate(segments), 0, 0)


@kernel
def pin_compression(pin, contact):
    """Compression e of the wall by a pin, and the distance r of the pin from the axis."""
    r = length(contact.offset)
    return r - pin.gap + pin.slope * contact.compression, r


@kernel
def wall_force(i, e, modes, p):
    """f(e) of pin ``i`` while it is pressed, else zero."""
    mode = modes[p.mode + i]
    return curves.curve_force(p.segments[mode[SEGMENT]], e) if mode[MODE] == PIN_PRESSED else 0.0


@root
def add_force(t, y, modes, motion, bodies, elements, wrench):
    """Add the force of every wall to its row of ``wrench``; walls dissipate nothing."""
    p = elements.guides
    for i in range(p.pins.size):
        if modes[p.mode + i, MODE] == PIN_PRESSED:
            pin = p.pins[i]
            point = elements.fenders.points[pin.point]
            c = geometry.contact_kinematics(point, bodies, motion)
            e, r = pin_compression(pin, c)
            f = wall_force(i, e, modes, p)
            share = f / r if r > 0.0 else 0.0
            across = (-share * c.offset[0], -share * c.offset[1])
            geometry.add_contact_wrench(point, c, pin.slope * f, across, wrench[pin.row])


@root
def add_energy(modes, motion, bodies, elements, stored):
    """Add the energy stored in every wall to its row of ``stored``."""
    p = elements.guides
    for i in range(p.pins.size):
        stored[p.pins[i].row] += _stored_energy(i, modes, motion, bodies, elements)


@kernel
def _stored_energy(i, modes, motion, bodies, elements):
    p = elements.guides
    if modes[p.mode + i, MODE] != PIN_PRESSED:
        return 0.0
    c = geometry.contact_kinematics(elements.fenders.points[p.pins[i].point], bodies, motion)
    return curves.stored_energy(
        p.segments[modes[p.mode + i, SEGMENT]], pin_compression(p.pins[i], c)[0]
    )


@root
def write_outputs(modes, motion, bodies, elements, out):
    """Write rows of `GUIDE_OUTPUTS` of all pins to ``out``: f and -e."""
    p = elements.guides
    for i in range(p.pins.size):
        c = geometry.contact_kinematics(elements.fenders.points[p.pins[i].point], bodies, motion)
        e, _ = pin_compression(p.pins[i], c)
        out[GUIDE_OUTPUTS * i + PIN_FORCE] = wall_force(i, e, modes, p)
        out[GUIDE_OUTPUTS * i + PIN_CLEARANCE] = -e


@root
def find_margins(modes, motion, bodies, elements, out):
    """Margins of all pins into ``out``: for contact e or its opposite, for the mouth the depth
    below it or its opposite, for the segment the distance to its nearer corner."""
    p = elements.guides
    for i in range(p.pins.size):
        pin = p.pins[i]
        mode = modes[p.mode + i]
        m = MARGINS * (p.mode + i)
        c = geometry.contact_kinematics(elements.fenders.points[pin.point], bodies, motion)
        e, _ = pin_compression(pin, c)
        within = min(c.compression + pin.depth, INSIDE)
        for k in range(MARGINS):
            out[m + k] = 1.0
        if mode[MODE] == INACTIVE:
            continue
        out[m + RISING_MARGIN] = -within if mode[MODE] == AWAY else within
        if mode[MODE] != AWAY:
            out[m + CONTACT_MARGIN] = -e if mode[MODE] == FREE else e
        if mode[MODE] == PIN_PRESSED and mode[SEGMENT] < pin.last:
            out[m + SEGMENT_MARGIN] = p.segments[mode[SEGMENT]].upper - e
        if mode[MODE] == PIN_PRESSED and mode[SEGMENT] > pin.first:
            below = e - p.segments[mode[SEGMENT]].lower
            out[m + SEGMENT_MARGIN] = min(out[m + SEGMENT_MARGIN], below)


@root
def transition(i, which, y, modes, motion, bodies, elements):
    """Switch pin ``i`` to its next mode, after margin ``which`` has reached zero."""
    p = elements.guides
    pin = p.pins[i]
    mode = modes[p.mode + i]
    c = geometry.contact_kinematics(elements.fenders.points[pin.point], bodies, motion)
    e, _ = pin_compression(pin, c)
    if which == SEGMENT_MARGIN:
        mode[SEGMENT] = curves.next_segment(mode[SEGMENT], p.segments[mode[SEGMENT]], e)
    elif which == CONTACT_MARGIN:
        mode[MODE] = PIN_PRESSED if mode[MODE] == FREE else FREE
        mode[SEGMENT] = pin.first
    elif mode[MODE] == AWAY:
        mode[MODE] = PIN_BESIDE if e > 0.0 else FREE
    else:
        _leave_wall(i, AWAY, y, modes, motion, bodies, elements)


@kernel
def _leave_wall(i, mode, y, modes, motion, bodies, elements):
    """Set pin ``i`` to a ``mode`` without force; the energy stored in its wall is lost."""
    p = elements.guides
    pin = p.pins[i]
    y[p.losses + pin.row] += _stored_energy(i, modes, motion, bodies, elements)
    modes[p.mode + i, MODE] = mode
    modes[p.mode + i, SEGMENT] = pin.first


@kernel
def activate(i, modes, motion, bodies, elements):
    """Activate the wall of pin ``i``: it catches the pin within its clearance."""
    p = elements.guides
    pin = p.pins[i]
    c = geometry.contact_kinematics(elements.fenders.points[pin.point], bodies, motion)
    e, _ = pin_compression(pin, c)
    modes[p.mode + i, MODE] = (
        AWAY if c.compression <= -pin.depth else PIN_BESIDE if e > 0.0 else FREE
    )
    modes[p.mode + i, SEGMENT] = pin.first


@kernel
def deactivate(i, y, modes, motion, bodies, elements):
    """Deactivate the wall of pin ``i``."""
    _leave_wall(i, INACTIVE, y, modes, motion, bodies, elements)


@kernel
def start_inactive(i, modes, p):
    """Make the wall of pin ``i`` inactive before its time: it has stored nothing."""
    modes[p.mode + i, MODE] = INACTIVE
    modes[p.mode + i, SEGMENT] = p.pins[i].first


@root
def set_initial_modes(modes, motion, bodies, elements):
    """Modes of all pins for a start."""
    p = elements.guides
    for i in range(p.pins.size):
        pin = p.pins[i]
        mode = modes[p.mode + i]
        c = geometry.contact_kinematics(elements.fenders.points[pin.point], bodies, motion)
        e, _ = pin_compression(pin, c)
        mode[MODE] = AWAY if c.compression <= -pin.depth else PIN_PRESSED if e > 0.0 else FREE
        mode[SEGMENT] = curves.find_segment(pin.first, pin.last, p.segments, e)


class GuideKind(kind.KindWithModeSets):
    unit = "guide"
    variables: ClassVar = {
        "guide_force": kind.Variable(
            "force of the wall, across the axis of the seat",
            "N",
            chart=kind.ChartHint("Force of guides", "guide force", kind.Topic.DETAILS + 7),
            is_detail=True,
        ),
        "guide_clearance": kind.Variable(
            "clearance to the wall, negative if pressed", "m", is_detail=True
        ),
        "guide_mode": kind.Variable("mode of a pin in its guide", "1", flags=" ".join(GUIDE_MODES)),
        "guide_segment": kind.Variable("piece of the curve of the wall, counted from 0", "1"),
    }

    def unit_names(self, scene: Scene) -> list[str]:
        """Names of the contact points that a wall holds sideways."""
        walled = ((name, e) for name, e in scene.forces.items() if getattr(e, "wall", None))
        return [unit for name, e in walled for unit in e.unit_names(name)]

    def modes(self, p: GuideConstants) -> kind.ModeRows:
        return kind.ModeRows(p.pins.size, first=p.pins["first"], last=p.pins["last"])

    def mode_sets(self, p: GuideConstants) -> Sequence[kind.ModeSet]:
        if not p.pins.size:
            return []
        first = p.pins["first"]
        free = kind.ModeSet("pins free", kind.rest_at_first(first, FREE))
        return [free, kind.ModeSet("pins at their walls", kind.rest_at_first(first, PIN_PRESSED))]

    def moved_onto_segment(
        self, p: GuideConstants, modes: np.ndarray, bodies: Any, motion: Any, y: np.ndarray
    ) -> GuideConstants:
        """Constants in which pins are pressed by the steepest piece of their walls at any
        position."""
        pins = p.pins.copy()
        segments = p.segments.copy()
        for pin in pins:
            pin_segments = segments[pin["first"] : pin["last"] + 1]
            pin_segments["slope"][0] = pin_segments["slope"].max()
            pin["gap"] = pin["slope"] * COMPRESSED
        return p._replace(pins=pins, segments=segments)

    def record(self, p: GuideConstants, bodies: Any, unit_record: kind.UnitRecord) -> kind.Columns:
        dims = ("time", "guide")
        return {
            "guide_force": (dims, unit_record.observed[:, :, PIN_FORCE]),
            "guide_clearance": (dims, unit_record.observed[:, :, PIN_CLEARANCE]),
            "guide_mode": (dims, unit_record.modes[:, :, MODE].astype(np.int8)),
        }


GUIDE_KIND = GuideKind("guides", (), compile_elements)
