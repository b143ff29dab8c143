"""One mooring line by itself: its pull, stiffness and shape over offsets of its fairlead.

An offset along the heading of the line leads away from its anchor; an offset upward lifts the
fairlead. The stiffness is that of the pull in the direction of the offset, from the equations, not
from differences.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, nan
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.case.lines.chains import mooring_lines, water_of_system
from hydrosim.compile.validate_scene import STRAINED
from hydrosim.elements.line import points
from hydrosim.elements.line.hang import SuspendedLine, find_touchdown, pieces_of_segments
from hydrosim.elements.line.search import stiffness
from hydrosim.elements.line.shape import REASONS, LinePull, solve
from hydrosim.files.text import Source
from hydrosim.integrate.dynamics import motion_at

if TYPE_CHECKING:
    from hydrosim.case.lines.system import System
    from hydrosim.compile.compiled import Compiled

OFFSET_COUNT = 21
"""Offsets in a table."""
OFFSET_SHARE = 0.1
"""Largest usual offset, of the height of the fairlead above the anchor."""
MIN_OFFSET_M = 1.0  # m: largest usual offset of lines between ends of the same height
PROFILE_POINTS = 161  # of a profile
DEFAULT_WATER = (1025.0, 9.81)  # of files that do not say


@dataclass(frozen=True, eq=False)
class StillLine:
    """A line at rest: ``pieces`` from the fairlead to the anchor, distance ``x`` and height ``z``
    of the fairlead from the anchor, height of the seabed ``bed`` above the anchor [m], ``friction``
    of it, ``heading`` [rad] from the fairlead to the anchor in the earth frame."""

    name: str
    pieces: np.ndarray
    x: float
    z: float
    bed: float
    friction: float
    heading: float

    @property
    def length(self) -> float:
        """Unstretched length [m]."""
        return float(self.pieces["length"].sum())

    def end_forces(self) -> LinePull:
        """Its forces."""
        return LinePull(*solve(self.suspended_line, nan, nan))

    @property
    def suspended_line(self) -> SuspendedLine:
        """The line for the functions of `hydrosim.elements.line.shape`."""
        ends = (self.x, self.z, self.bed, self.friction)
        return SuspendedLine(self.pieces, 0, self.pieces.size, *ends)

    def with_moved_fairlead(self, along: float, up: float) -> StillLine:
        """The line with its fairlead moved away from the anchor, and upward [m]."""
        return replace(self, x=abs(self.x + along), z=self.z + up)

    def profile(self) -> tuple[np.ndarray, np.ndarray]:
        """Places (n, 2) [m] from the fairlead to the anchor: the distance from the anchor, and the
        height above it; tensions (n,) [N]."""
        places, tension = points.line_points(self.suspended_line, self.end_forces(), PROFILE_POINTS)
        return np.stack([self.x - places[:, 0], places[:, 1]], axis=1), tension

    def grounded_length(self, pull: LinePull) -> float:
        """Length on the bed [m]."""
        if not pull.touch < self.length:
            return 0.0 if pull.converged else nan
        behind = 0.0
        if pull.anchor_V < 0.0:
            behind = find_touchdown(self.suspended_line, -1, -pull.anchor_V).arc
        return self.length - pull.touch - behind

    def usual_offset(self) -> float:
        """Largest offset [m] of tables and pictures that ask for none."""
        return max(OFFSET_SHARE * abs(self.z), MIN_OFFSET_M)


@dataclass(frozen=True, eq=False)
class LineResponse:
    """Over ``offsets`` (n,) [m] ``up`` or along the heading: ``tension``, ``horizontal`` and
    ``vertical`` pull at the fairlead, ``anchor`` tension [N], ``stiffness`` [N/m], ``grounded``
    length [m]. Where there is no line, all are nan, and ``reasons`` says why."""

    up: bool
    offsets: np.ndarray
    tension: np.ndarray
    horizontal: np.ndarray
    vertical: np.ndarray
    anchor: np.ndarray
    stiffness: np.ndarray
    grounded: np.ndarray
    reasons: Sequence[str] = ()


def response(line: StillLine, offsets: np.ndarray, up: bool) -> LineResponse:
    """Forces and stiffness of a line over offsets of its fairlead."""
    rows: list[list[float]] = []
    reasons: dict[str, None] = {}
    for offset in offsets:
        moved = (
            line.with_moved_fairlead(0.0, offset) if up else line.with_moved_fairlead(offset, 0.0)
        )
        pull = moved.end_forces()
        rows.append(_response_row(moved, pull, up))
        if not pull.converged:
            reasons[REASONS[pull.reason]] = None
    tension, horizontal, vertical, anchor, stiff, grounded = np.transpose(rows)
    forces = (tension, horizontal, vertical, anchor)
    return LineResponse(up, offsets, *forces, stiff, grounded, tuple(reasons))


def _response_row(line: StillLine, pull: LinePull, up: bool) -> list[float]:
    """The figures of one offset."""
    if not pull.converged:
        return [nan] * 6
    slopes = stiffness(line.suspended_line, pull)
    return [
        float(np.hypot(pull.H, pull.V)),
        pull.H,
        pull.V,
        float(np.hypot(pull.anchor_H, pull.anchor_V)),
        slopes[3] if up else slopes[0],
        line.grounded_length(pull),
    ]


def offsets_to(largest: float) -> np.ndarray:
    """Offsets of a table, both ways."""
    return np.linspace(-largest, largest, OFFSET_COUNT)


def lines_of_case(compiled: Compiled) -> list[StillLine]:
    """The catenaries of a compiled scene, as they are at its start."""
    model, state = compiled.model, compiled.state
    motion = motion_at(model, state.y)
    shapes = points.line_shapes(
        model, compiled.scene, 0.0, state.y, state.modes, model.bodies, motion
    )
    return [
        StillLine(
            line.name,
            line.line_pieces.copy(),
            line.ends.x,
            line.ends.z,
            line.ends.bed,
            float(line.constants["friction"]),
            float(np.arctan2(line.ends.e[1], line.ends.e[0])),
        )
        for line in shapes
    ]


def lines_of_system(system: System) -> list[StillLine]:
    """The lines of a mooring system, with the vessel where its file has it. Raises InputError."""
    source = Source(system.file)
    still_lines = []
    for name, line in mooring_lines(system, water_of_system(system, DEFAULT_WATER), source).items():
        across = np.subtract(line.anchor, line.fairlead)
        bed = -inf if system.depth is None else min(-system.depth - line.anchor[2], 0.0)
        still_lines.append(
            StillLine(
                name,
                pieces_of_segments(line.segments),
                float(np.hypot(across[0], across[1])),
                -float(across[2]),
                bed,
                system.friction,
                float(np.arctan2(across[1], across[0])),
            )
        )
        _check_strain(still_lines[-1], source)
    return still_lines


def _check_strain(line: StillLine, source: Source) -> None:
    """Refuse a line that no line is, because it would be stretched by a fifth and more."""
    pull = line.end_forces()
    strain = points.largest_strain(line.pieces, points.largest_tension(pull))
    if pull.converged and strain > STRAINED:
        source.wrong(
            f"found line {line.name} of {line.length:g} m, while its ends are"
            f" {float(np.hypot(line.x, line.z)):.5g} m apart, where it would have to stretch by"
            f" {strain:.0%}; expected less than {STRAINED:.0%}"
        )


def angle_at_fairlead(pull: LinePull) -> float:
    """Angle of the line at its fairlead below the horizontal [rad]."""
    return float(np.arctan2(pull.V, pull.H))
