"""Spring between two points, with a table: a mooring line, a tug line, a connection. It pulls only.

    T = max(0, f(x) + c x')

x: extension beyond the length L0 without load, which may change over time; f(x): straight lines
through the points of the table, with the last slope continued; c: damping. Before the first point
of the table the line is slack: T = 0.

Slack is the first segment of the curve. Its corners are events. Events also mark where damping
alone would push (T is cut), and where it ceases to: in between, T is smooth. Stored energy is the
integral of f. Dissipation is (T - f) x': c x'^2 while taut, and the energy that the spring releases
while T is cut. Where L0 changes, T L0' is booked with it: the energy that goes into the drum, below
zero if it heaves in.

Limits: no mass, no sag, no drag of the line; with damping, T jumps to c x' where a line snaps taut,
and by c times the change of L0' at the corners of a table of L0.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hydrosim.elements.contact import curves
from hydrosim.elements.kind import (
    LARGEST,
    LINEARISATION_DEPTH,
    SLACK_SHARE,
    Variable,
    tension_variable,
)
from hydrosim.elements.link import law
from hydrosim.jit.kernels import kernel
from hydrosim.modes import CONTACT_MARGIN, MODE, SEGMENT, SEGMENT_MARGIN
from hydrosim.scene.links import Spring

SLACK, TAUT, SPRING_INACTIVE = range(3)


def curve(spring: Spring) -> np.ndarray:
    """The pieces of the curve, the slack one before the table's."""
    x = np.asarray(spring.extension, float)
    f = np.asarray(spring.tension, float)
    return curves.segments(np.array([x[0] - 1.0, *x]), np.array([0.0, *f]))


def law_fields(spring: Spring, pieces: np.ndarray) -> dict[str, Any]:
    """Fields of `LINK` of a spring."""
    fields = law.curve_fields(pieces, 0, law.ANYWHERE)
    taut = float(pieces["start"][fields["stiff"]]) + LINEARISATION_DEPTH
    return {**fields, "stiff_range": (taut, taut), "damping": spring.damping}


COLUMNS = {
    "spring_tension": law.Column(
        law.LOAD_OUTPUT,
        tension_variable(
            "tension",
            "from the point to the anchor",
            "Tension of lines",
            0,
            (LARGEST, SLACK_SHARE),
            "line",
        ),
    ),
    "spring_length": law.Column(
        law.PLACE_OUTPUT, Variable("distance from the point to the anchor", "m")
    ),
}
SPRING = law.LinkClass(
    *(Spring, "spring", COLUMNS, law_fields, curve),
    inactive_mode=SPRING_INACTIVE,
    pulls_only=True,
)


@kernel
def find_loads(link, mode, s, p):
    """T, and the power that it dissipates. T is not cut in the taut mode, so that it is smooth
    across the event that ends the mode."""
    f = curves.curve_force(p.segments[mode[SEGMENT]], s.x)
    T = f + link.damping * s.rate if mode[MODE] == TAUT else 0.0
    return T, (T - f) * s.rate


@kernel
def stored_energy(mode, s, p):
    """Integral of f up to x."""
    return curves.stored_energy(p.segments[mode[SEGMENT]], s.x)


@kernel
def find_margins(link, mode, s, p, out):
    """Margins (4,): for contact T, or its opposite where it is cut; for the segment the distance to
    its nearer corner."""
    piece = p.segments[mode[SEGMENT]]
    out[SEGMENT_MARGIN] = curves.segment_margin(piece, s.x)
    if link.damping > 0.0 and mode[SEGMENT] != link.first:
        T = curves.curve_force(piece, s.x) + link.damping * s.rate
        out[CONTACT_MARGIN] = T if mode[MODE] == TAUT else -T


@kernel
def transition(link, which, mode, s, p):
    """The next mode, after margin ``which`` has reached zero."""
    if which == CONTACT_MARGIN:
        mode[MODE] = SLACK if mode[MODE] == TAUT else TAUT
        return
    before = mode[SEGMENT]
    mode[SEGMENT] = curves.next_segment(before, p.segments[before], s.x)
    if mode[SEGMENT] == link.first:
        mode[MODE] = SLACK
    elif before == link.first:
        mode[MODE] = TAUT


@kernel
def set_initial_mode(link, mode, s, p):
    """The mode of a line that becomes active."""
    mode[SEGMENT] = curves.find_segment(link.first, link.last, p.segments, s.x)
    mode[MODE] = TAUT
    T, _ = find_loads(link, mode, s, p)
    if mode[SEGMENT] == link.first or T < 0.0:
        mode[MODE] = SLACK
