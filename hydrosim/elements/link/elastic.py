"""Struts, torsion springs, springs of any coordinate, power take-offs: curves of both signs.

    T = f(x) + c x' + d |x'| x'

f: straight lines through the points of a curve, with the first and last slopes continued. Corners
are events. Stored energy is the integral of f. c, d: linear and quadratic damping. c x'^2 + d
|x'|^3 is the dissipated power; it is the absorbed power of a power take-off.

Limits: the slope of |x'| x' has a corner at x' = 0, so methods have order 3 with d.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hydrosim.elements.contact import curves
from hydrosim.elements.kind import ChartHint, Topic, Variable, range_columns
from hydrosim.elements.link import law
from hydrosim.jit.kernels import kernel
from hydrosim.modes import SEGMENT, SEGMENT_MARGIN
from hydrosim.scene.links import SpringDamper, Strut, TorsionSpring

Elastic = Strut | TorsionSpring | SpringDamper


def curve(link: Elastic) -> np.ndarray:
    """The pieces of the curve, with no energy stored at offset 0."""
    if not len(link.offset):
        return curves.segments(np.array([0.0, 1.0]), np.zeros(2))
    pieces = curves.segments(link.offset, link.force)
    middle = pieces[curves.piece_at(pieces, 0.0)]
    d = -middle["start"]
    pieces["energy"] -= middle["energy"] + (middle["force"] + 0.5 * middle["slope"] * d) * d
    return pieces


def law_fields(link: Elastic, pieces: np.ndarray) -> dict[str, Any]:
    """Fields of `LINK` of a link."""
    idle = curves.piece_at(pieces, 0.0)
    fields = law.curve_fields(pieces, idle, (pieces["lower"][idle], pieces["upper"][idle]))
    stiff = fields["stiff"]
    return {
        **fields,
        "stiff_range": (pieces["lower"][stiff], pieces["upper"][stiff]),
        "damping": link.damping,
        "drag": link.quadratic_damping,
        "absorbs": link.absorbs,
    }


STRUT_COLUMNS = {
    "strut_force": law.Column(
        law.LOAD_OUTPUT,
        Variable(
            "force, tension positive",
            "N",
            "from the point to the anchor",
            chart=ChartHint("Force of struts", "strut force", Topic.LINKS),
            summary=range_columns("force"),
            is_load=True,
        ),
    ),
    "strut_length": law.Column(
        law.PLACE_OUTPUT,
        Variable(
            "distance from the point to the anchor",
            "m",
            chart=ChartHint("Length of struts", "strut length", Topic.DETAILS + 6),
        ),
    ),
}
TORSION_COLUMNS = {
    "torsion_moment": law.Column(
        law.LOAD_OUTPUT,
        Variable(
            "moment against the twist",
            "N m",
            "about the axis",
            chart=ChartHint("Moment of torsion springs", "torsion moment", Topic.LINKS + 3),
            summary=range_columns("moment"),
        ),
    ),
    "torsion_angle": law.Column(
        law.PLACE_OUTPUT,
        Variable(
            "twist about the axis from rest",
            "rad",
            chart=ChartHint("Twist of torsion springs", "twist", Topic.DETAILS + 6),
        ),
    ),
}
STRUT = law.LinkClass(Strut, "strut", STRUT_COLUMNS, law_fields, curve)
TORSION_SPRING = law.LinkClass(TorsionSpring, "torsion_spring", TORSION_COLUMNS, law_fields, curve)
SPRING_DAMPER = law.LinkClass(
    SpringDamper, "spring_damper", law.load_and_place("spring_damper"), law_fields, curve
)


@kernel
def resistance(link, rate):
    """c x' + d |x'| x'."""
    return (link.damping + link.drag * abs(rate)) * rate


@kernel
def find_loads(link, mode, s, p):
    """T, and the power that it dissipates."""
    lost = resistance(link, s.rate)
    return curves.curve_force(p.segments[mode[SEGMENT]], s.x) + lost, lost * s.rate


@kernel
def find_margins(link, mode, s, p, out):
    """Margins (4,): the distance to the nearer corner of the curve."""
    if link.last > link.first:
        out[SEGMENT_MARGIN] = curves.segment_margin(p.segments[mode[SEGMENT]], s.x)


@kernel
def transition(mode, s, p):
    """The next piece of the curve."""
    mode[SEGMENT] = curves.next_segment(mode[SEGMENT], p.segments[mode[SEGMENT]], s.x)


@kernel
def set_initial_mode(link, mode, s, p):
    """The piece of a link that becomes active."""
    mode[SEGMENT] = curves.find_segment(link.first, link.last, p.segments, s.x)
