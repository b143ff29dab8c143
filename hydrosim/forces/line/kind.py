"""Catenaries as a kind: their states, modes, postures and records."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from typing import Any, ClassVar

import numpy as np

from hydrosim.forces.kind import (
    Columns,
    ModeRows,
    StateBlocks,
    UnitRecord,
    Variable,
    capacity_of,
    elements_of,
)
from hydrosim.forces.line import shape
from hydrosim.forces.line.catenary import (
    ANCHOR_TENSION,
    CATENARY_STATES,
    FAIRLEAD_TENSION,
    GROUNDED,
    GUESS,
    HORIZONTAL,
    TAUT_LINE,
    Catenary,
    CatenaryConstants,
    compile_elements,
    end_kinematics,
)
from hydrosim.forces.postures import KindWithModeSets, ModeSet, rest_at_first
from hydrosim.modes import ACTING, MODE, RISING, UNDEFINED
from hydrosim.scene import Scene

PROFILES = 1 << 30
"""More than any line has."""
TAUT_LENGTH_RATIO = 0.999
"""Unstretched length over the distance of the ends, at which a taut line is linearised."""


class CatenaryKind(KindWithModeSets):
    unit = "line"
    variables: ClassVar = {
        "line_tension": Variable("tension at the fairlead", "N", "along the line"),
        "line_anchor_tension": Variable("tension at the anchor", "N", "along the line"),
        "line_horizontal": Variable("horizontal pull at the fairlead", "N", "to the anchor"),
        "line_grounded": Variable("unstretched length on the seabed", "m"),
        "line_mode": Variable("whether a line acts", "1", flags="acting absent lost"),
        "line_damping": Variable("linearised drag over velocity across the line", "N s/m"),
        "line_drift": Variable("mean drag over the current across the line", "N s/m"),
        "line_segment": Variable("profile: where it touches down, slips and hangs", "1"),
    }

    def modes(self, p: CatenaryConstants) -> ModeRows:
        size = p.lines.size
        return ModeRows(size, first=np.zeros(size, int), last=np.full(size, PROFILES))

    def states(self, p: CatenaryConstants, scene: Scene) -> Iterator[StateBlocks]:
        yield StateBlocks("line", self.unit_names(scene), GUESS)

    def mode_sets(self, p: CatenaryConstants) -> Sequence[ModeSet]:
        """All as they hang, and all taut."""
        if not p.lines.size:
            return []
        first = np.zeros(p.lines.size)
        return [
            ModeSet("", rest_at_first(first, ACTING)),
            ModeSet("lines taut", rest_at_first(first, TAUT_LINE)),
        ]

    def equivalence_keys(self, p: CatenaryConstants) -> Sequence[Hashable]:
        """No two lines are alike: each pulls in a direction of its own."""
        return range(p.lines.size)

    def rates(self, p: CatenaryConstants, bodies: Any, motion: Any) -> np.ndarray:
        """Along the chords."""
        found = [_distance_rate(end_kinematics(line, bodies, motion)) for line in p.lines]
        return np.reshape(found, (-1, 1))

    def moved_onto_segment(
        self, p: CatenaryConstants, modes: np.ndarray, bodies: Any, motion: Any
    ) -> CatenaryConstants:
        """Constants in which lines that are taut are a little shorter than the way between their
        ends."""
        pieces = p.pieces.copy()
        for line, mode in zip(p.lines, modes[:, MODE], strict=True):
            if mode == TAUT_LINE:
                s = end_kinematics(line, bodies, motion)
                own = pieces[line["first"] : line["last"]]
                own["length"] *= TAUT_LENGTH_RATIO * np.hypot(s.x, s.z) / own["length"].sum()
        return p._replace(pieces=pieces)

    def undefined_units(self, p: CatenaryConstants, modes: np.ndarray) -> Iterator[tuple[int, str]]:
        for i in np.flatnonzero(modes[:, MODE] == UNDEFINED).tolist():
            yield i, shape.REASONS[int(modes[i, RISING])]

    def clear_unused_states(self, p: CatenaryConstants, y: np.ndarray) -> None:
        """Guesses of an earlier run are valid."""

    def renew(
        self,
        p: CatenaryConstants,
        y: np.ndarray,
        anew: np.ndarray,
        possible: np.ndarray,
        known: np.ndarray,
    ) -> None:
        """Guesses of lines that the earlier run did not have."""
        own = slice(p.state, p.state + CATENARY_STATES * p.lines.size)
        y[own] = np.where(known[own], y[own], anew[own])

    def coordinates(self, scene: Scene) -> dict[str, object]:
        return super().coordinates(scene) | capacity_of(self.unit, elements_of(scene, Catenary))

    def record(self, p: CatenaryConstants, bodies: Any, kept: UnitRecord) -> Columns:
        each = ("time", "line")
        found: Columns = {"line_mode": (each, kept.modes[:, :, MODE].astype(np.int8))}
        columns = {
            "line_tension": FAIRLEAD_TENSION,
            "line_anchor_tension": ANCHOR_TENSION,
            "line_horizontal": HORIZONTAL,
            "line_grounded": GROUNDED,
        }
        for name, column in columns.items():
            found[name] = (each, kept.observed[:, :, column])
        if p.widths.any():
            found["line_damping"] = (("line",), p.lines["damping"])
            found["line_drift"] = (("line",), p.lines["drift"])
        return found


def _distance_rate(s: Any) -> float:
    """Rate of the distance between the ends of a line."""
    apart = np.subtract(s.w, s.v)
    chord = np.array([s.x * s.e[0], s.x * s.e[1], -s.z])
    return float(chord @ apart / max(np.linalg.norm(chord), 1e-9))


CATENARY_KIND = CatenaryKind("catenaries", (Catenary,), compile_elements)
