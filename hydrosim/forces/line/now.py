"""Lines at one state of a scene, for messages and pictures: ends, pulls, strains, points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from hydrosim.forces.kind import KindConstants
from hydrosim.forces.line.catenary import (
    CATENARY_STATES,
    EndKinematics,
    end_kinematics,
    pull_entries,
)
from hydrosim.forces.line.kind import CATENARY_KIND
from hydrosim.forces.line.points import line_points
from hydrosim.forces.line.shape import LinePull
from hydrosim.forces.signal import value
from hydrosim.modes import INACTIVE, MODE, NO_INDEX
from hydrosim.scene import Scene

LINE_POINTS = 41  # of a line in pictures


@dataclass(frozen=True, eq=False)
class LineShape:
    """A line ``name`` with its ``constants``, its ``pieces``, its ``ends`` and its ``pull``."""

    name: str
    constants: Any
    pieces: np.ndarray
    ends: EndKinematics
    pull: LinePull

    @property
    def length(self) -> float:
        """Unstretched length [m]."""
        return float(self.line_pieces["length"].sum())

    @property
    def distance(self) -> float:
        """Distance of its ends [m]."""
        return float(np.hypot(self.ends.x, self.ends.z))

    @property
    def strain(self) -> float:
        """Largest tension over the smallest EA."""
        ends = (self.pull.H, self.pull.V), (self.pull.anchor_H, self.pull.anchor_V)
        return float(max(np.hypot(*each) for each in ends) / self.line_pieces["stiffness"].min())

    def places(self, count: int = LINE_POINTS) -> tuple[np.ndarray, np.ndarray]:
        """Places (count, 3) [m] from the fairlead to the anchor in the earth frame, relative to a
        point straight below or above the fairlead at the still water; tensions (count,) [N]."""
        line = self.constants
        e = self.ends
        ends = (e.x, e.z, e.bed, float(line["friction"]))
        found, tension = line_points(
            self.pieces, int(line["first"]), int(line["last"]), *ends, self.pull, count
        )
        across, height = found.T
        return np.stack([across * e.e[0], across * e.e[1], height + e.anchor], axis=1), tension

    @property
    def line_pieces(self) -> np.ndarray:
        """Its pieces alone."""
        return self.pieces[self.constants["first"] : self.constants["last"]]


def line_shapes(
    parts: KindConstants,
    scene: Scene,
    t: float,
    y: np.ndarray,
    modes: np.ndarray,
    bodies: Any,
    motion: Any,
) -> Iterator[LineShape]:
    """The lines that act at a state ``y`` with its ``modes``; ``motion`` must be filled."""
    p = CATENARY_KIND.constants_in(parts)
    for i, name in enumerate(CATENARY_KIND.unit_names(scene)):
        if modes[p.mode + i, MODE] != INACTIVE:
            line = p.lines[i]
            ends = end_kinematics(line, bodies, motion)
            pieces = p.pieces.copy()
            if line["paying"] != NO_INDEX:
                paid = value(t, line["paid"], p.signals)
                pieces["length"][line["first"] + line["paying"]] = paid
            guess = y[p.state + CATENARY_STATES * i :][:2]
            own = (int(line["first"]), int(line["last"]), ends.x, ends.z, ends.bed)
            pull = LinePull(*pull_entries(*own, float(line["friction"]), *guess, pieces))
            yield LineShape(name, line, pieces, ends, pull)
