"""Catenaries as a kind: states, modes, postures and records; and their drag, linearised.

Drag of a line, linearised along it and gathered at its fairlead.

    c = int 1/2 rho C D phi^2 E|w|(w g') / E(g' g') ds,   m = int 1/2 rho C D phi E|w| w_u / u ds

g: velocity of the fairlead across the line, a Gaussian in two directions; g' = phi g: that of the
line; u: current across the line; w = u + g'. phi is the share of the fairlead's motion: linear in
the length, 1 at the fairlead, 0 where the line touches down or at its anchor. c takes as much power
from g as the quadratic drag of all places (Borgman 1967; Krolikowski and Gay 1980 with a current).
In a Gaussian motion along one direction without a current

    c = sqrt(8/pi) sigma 1/2 rho int C D phi^3 ds.

In regular waves of an amplitude a of the velocity, 8/(3 pi) a replaces sqrt(8/pi) sigma.

Limits: the motion of the anchor, drag along the line, and inertia of the line are neglected.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from math import pi, sqrt
from typing import Any, ClassVar, NamedTuple

import numpy as np

from hydrosim.elements.kind import (
    LARGEST,
    ChartHint,
    Columns,
    KindWithModeSets,
    ModeRows,
    ModeSet,
    StateBlocks,
    SummaryColumn,
    Topic,
    UnitRecord,
    Variable,
    capacity_of,
    elements_of,
    rest_at_first,
    tension_variable,
)
from hydrosim.elements.line import catenary, shape
from hydrosim.modes import ACTING, MODE, RISING, UNDEFINED
from hydrosim.scene import Scene

PHASES = 4096  # of a regular motion with a current
QUADRATURE_NODES = 40  # of Gauss and Hermite, in each direction, with a current
NODES_PER_SEGMENT = 4  # of Gauss and Legendre, on each segment


class LinearisedDrag(NamedTuple):
    """``damping`` c and ``drift`` m [N s/m] of a line."""

    damping: float
    drift: float


class DragPoints(NamedTuple):
    """Places (k,) along what hangs of a line: ``phi``, and the length [m] that each stands for."""

    phi: np.ndarray
    length: np.ndarray
    segment: np.ndarray


def drag_points(length: np.ndarray, touch: float) -> DragPoints:
    """`DragPoints` of Gauss's quadrature on segments of ``length`` (n,) [m], of which ``touch`` [m]
    from the fairlead hangs; each with the number of its ``segment``."""
    ends = np.minimum(np.concatenate([[0.0], np.cumsum(length)]), touch)
    nodes, weights = np.polynomial.legendre.leggauss(NODES_PER_SEGMENT)
    half = 0.5 * np.diff(ends)
    middle = 0.5 * (ends[1:] + ends[:-1])
    arc = middle[:, None] + np.multiply.outer(half, nodes)
    point_weights = np.multiply.outer(half, weights)
    segment = np.repeat(np.arange(half.size), NODES_PER_SEGMENT)
    return DragPoints(1.0 - arc.ravel() / touch, point_weights.ravel(), segment)


def linearise_random(covariance: np.ndarray, current: np.ndarray) -> LinearisedDrag:
    """E|w|(w g)/E(g g) and E|w| w_u/u [m/s] for a Gaussian velocity g of a ``covariance`` (3, 3)
    and a ``current`` (3,) across the line."""
    values, axes = np.linalg.eigh(covariance)
    sigma = np.sqrt(np.maximum(values[1:], 0.0))
    u = axes[:, 1:].T @ current
    speed = float(np.linalg.norm(current))
    if not sigma.any():
        return LinearisedDrag(2.0 * speed, speed)
    if speed == 0.0:
        square = 0.5 * float((sigma**2).sum())
        return LinearisedDrag(1.5 * sqrt(pi / 2.0) * _mean_cube(sigma) / square, 0.0)
    nodes, weights = np.polynomial.hermite_e.hermegauss(QUADRATURE_NODES)
    weights = weights / weights.sum()
    g = np.stack(np.meshgrid(*(s * nodes for s in sigma), indexing="ij"))
    share = np.multiply.outer(weights, weights)
    w = g + u[:, None, None]
    size = np.sqrt((w**2).sum(axis=0))
    c = float((share * size * (w * g).sum(axis=0)).sum() / (sigma**2).sum())
    along = np.tensordot(u, w, axes=1) / float(u @ u)
    return LinearisedDrag(c, float((share * size * along).sum()))


def _mean_cube(sigma: np.ndarray) -> float:
    """Mean over all directions of (s1^2 cos^2 + s2^2 sin^2)^(3/2), by elliptic integrals."""
    from scipy.special import ellipe, ellipkm1

    low, high = sorted(float(s) for s in sigma)
    p = (low / high) ** 2
    rest = p * ellipkm1(p) if p > 0.0 else 0.0
    return float(high**3 * (2.0 * (1.0 + p) * ellipe(1.0 - p) - rest) / 3.0 * 2.0 / pi)


def linearise_regular(amplitude: float, current: np.ndarray) -> LinearisedDrag:
    """The same for a harmonic velocity of an ``amplitude`` [m/s]; with a current, as if both were
    in one direction."""
    speed = float(np.linalg.norm(current))
    angle = 2.0 * pi * (np.arange(PHASES) + 0.5) / PHASES
    g = amplitude * np.sin(angle)
    w = speed + g
    if amplitude == 0.0:
        return LinearisedDrag(2.0 * speed, speed)
    if speed == 0.0:
        return LinearisedDrag(8.0 / (3.0 * pi) * amplitude, 0.0)
    c = float(np.mean(np.abs(w) * w * g) / np.mean(g * g))
    return LinearisedDrag(c, float(np.mean(np.abs(w) * w)) / speed)


def with_drag_of(
    p: catenary.CatenaryConstants, other: catenary.CatenaryConstants
) -> catenary.CatenaryConstants:
    """Constants of the lines ``p`` with the linearised drag of the same lines in ``other``."""
    lines = p.lines.copy()
    for name in ("damping", "drift"):
        lines[name] = other.lines[name]
    return p._replace(lines=lines)


PROFILES = 1 << 40
"""More than any line has."""
TAUT_LENGTH_RATIO = 0.999
"""Unstretched length over the distance of the ends, at which a taut line is linearised."""


class CatenaryKind(KindWithModeSets):
    unit = "line"
    variables: ClassVar = {
        "line_tension": tension_variable(
            "tension at the fairlead",
            "along the line",
            "Tension of catenaries at the fairlead",
            1,
            [LARGEST],
            "catenary",
        ),
        "line_anchor_tension": Variable(
            "tension at the anchor",
            "N",
            "along the line",
            chart=ChartHint(
                "Tension of catenaries at the anchor", "anchor tension", Topic.DETAILS + 4
            ),
            lowest=0.0,
        ),
        "line_horizontal": Variable("horizontal pull at the fairlead", "N", "to the anchor"),
        "line_grounded": Variable(
            "unstretched length on the seabed",
            "m",
            chart=ChartHint(
                "Length of catenaries on the seabed", "grounded length", Topic.DETAILS + 4
            ),
            summary=[SummaryColumn("smallest on the seabed", "smallest")],
            lowest=0.0,
        ),
        "line_mode": Variable("whether a line acts", "1", flags="acting absent lost"),
        "line_damping": Variable("linearised drag over velocity across the line", "N s/m"),
        "line_drift": Variable("mean drag over the current across the line", "N s/m"),
        "line_segment": Variable("profile: where it touches down, slips and hangs", "1"),
    }

    def modes(self, p: catenary.CatenaryConstants) -> ModeRows:
        size = p.lines.size
        return ModeRows(size, first=np.zeros(size, int), last=np.full(size, PROFILES))

    def states(self, p: catenary.CatenaryConstants, scene: Scene) -> Iterator[StateBlocks]:
        yield StateBlocks("line", self.unit_names(scene), catenary.GUESS)

    def mode_sets(self, p: catenary.CatenaryConstants) -> Sequence[ModeSet]:
        """All as they hang, and all taut."""
        if not p.lines.size:
            return []
        first = np.zeros(p.lines.size)
        return [
            ModeSet("", rest_at_first(first, ACTING)),
            ModeSet("lines taut", rest_at_first(first, catenary.TAUT_LINE)),
        ]

    def equivalence_keys(self, p: catenary.CatenaryConstants) -> Sequence[Hashable]:
        """No two lines are alike: each pulls in a direction of its own."""
        return range(p.lines.size)

    def rates(self, p: catenary.CatenaryConstants, bodies: Any, motion: Any) -> np.ndarray:
        """Along the chords."""
        speeds = [_distance_rate(catenary.end_kinematics(line, bodies, motion)) for line in p.lines]
        return np.reshape(speeds, (-1, 1))

    def moved_onto_segment(
        self,
        p: catenary.CatenaryConstants,
        modes: np.ndarray,
        bodies: Any,
        motion: Any,
        y: np.ndarray,
    ) -> catenary.CatenaryConstants:
        """Constants in which lines that are taut are a little shorter than the way between their
        ends, and as stiff as the steepest branch of a curve."""
        pieces = p.pieces.copy()
        for line, mode in zip(p.lines, modes[:, MODE], strict=True):
            if mode == catenary.TAUT_LINE:
                s = catenary.end_kinematics(line, bodies, motion)
                line_pieces = pieces[line["first"] : line["last"]]
                line_pieces["length"] *= (
                    TAUT_LENGTH_RATIO * np.hypot(s.x, s.z) / line_pieces["length"].sum()
                )
                steepest = np.maximum(line_pieces["stiffness"], line_pieces["tangent"].max(axis=1))
                line_pieces["stiffness"], line_pieces["corners"] = steepest, 0
        return p._replace(pieces=pieces)

    def undefined_units(
        self, p: catenary.CatenaryConstants, modes: np.ndarray
    ) -> Iterator[tuple[int, str]]:
        for i in np.flatnonzero(modes[:, MODE] == UNDEFINED).tolist():
            yield i, shape.REASONS[int(modes[i, RISING])]

    def clear_unused_states(self, p: catenary.CatenaryConstants, y: np.ndarray) -> None:
        """Guesses of an earlier run are valid."""

    def renew(
        self,
        p: catenary.CatenaryConstants,
        y: np.ndarray,
        anew: np.ndarray,
        possible: np.ndarray,
        known_states: np.ndarray,
    ) -> None:
        """Guesses of lines that the earlier run did not have."""
        guesses = slice(p.state, p.state + catenary.CATENARY_STATES * p.lines.size)
        y[guesses] = np.where(known_states[guesses], y[guesses], anew[guesses])

    def coordinates(self, scene: Scene) -> dict[str, object]:
        return super().coordinates(scene) | capacity_of(
            self.unit, elements_of(scene, catenary.Catenary)
        )

    def record(
        self, p: catenary.CatenaryConstants, bodies: Any, unit_record: UnitRecord
    ) -> Columns:
        dims = ("time", "line")
        variables: Columns = {"line_mode": (dims, unit_record.modes[:, :, MODE].astype(np.int8))}
        columns = {
            "line_tension": catenary.FAIRLEAD_TENSION,
            "line_anchor_tension": catenary.ANCHOR_TENSION,
            "line_horizontal": catenary.HORIZONTAL,
            "line_grounded": catenary.GROUNDED,
        }
        for name, column in columns.items():
            variables[name] = (dims, unit_record.observed[:, :, column])
        if p.widths.any():
            variables["line_damping"] = (("line",), p.lines["damping"])
            variables["line_drift"] = (("line",), p.lines["drift"])
        return variables


def _distance_rate(s: Any) -> float:
    """Rate of the distance between the ends of a line."""
    apart = np.subtract(s.w, s.v)
    chord = np.array([s.x * s.e[0], s.x * s.e[1], -s.z])
    return float(chord @ apart / max(np.linalg.norm(chord), 1e-9))


CATENARY_KIND = CatenaryKind("catenaries", (catenary.Catenary,), catenary.compile_elements)
