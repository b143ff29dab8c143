"""Properties of a body that wave loads depend on."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.dofs import about_z, loads_about_z

if TYPE_CHECKING:
    from hydrosim.scene import WaveForces
    from hydrosim.waves.components import WaveComponents
    from hydrosim.waves.quadratic import QuadraticFunctions


@dataclass(frozen=True, eq=False)
class WaveBody:
    """A body in waves.

    ``database``: transfer functions of n loads about the centre of gravity, for all headings, in
    the body's heading axes; None for a dry body. ``location`` (2,): origin of the database's frame
    at rest, in the earth's x, y [m]. ``centre`` (2,): centre of gravity in that frame. ``offset``:
    index of the body's first DOF among those of the scene. ``active`` (n,): true for DOFs that are
    not locked. ``heading``: heading of the database's frame at rest [rad]. ``owner``: index of the
    scene's body, if these loads are one share of several.
    """

    database: QuadraticFunctions | None
    location: tuple[float, ...]
    wave_forces: WaveForces
    offset: int
    active: np.ndarray
    centre: tuple[float, ...] = (0.0, 0.0)
    heading: float = 0.0
    owner: int | None = None

    @property
    def index(self) -> int:
        """Index of the body among those of the scene."""
        return self.offset // 6 if self.owner is None else self.owner

    def place(self) -> tuple[float, float]:
        """Centre of gravity at rest in the earth's x, y [m]."""
        x, y, _ = about_z(self.heading) @ (*self.centre[:2], 0.0)
        return self.location[0] + x, self.location[1] + y

    def moved_by(self, at: np.ndarray) -> WaveBody:
        """The body displaced by (6,): moved, and turned by its yaw about its centre of gravity."""
        heading = self.heading + at[5]
        frame = np.array(self.place()) + at[:2] - (about_z(heading) @ (*self.centre[:2], 0.0))[:2]
        return replace(self, heading=heading, location=tuple(frame))

    def relative_waves(self, waves: WaveComponents) -> WaveComponents:
        """The waves with their headings relative to the body at rest."""
        return (
            waves if self.heading == 0.0 else replace(waves, heading=waves.heading - self.heading)
        )

    def in_earth_axes(self, loads: np.ndarray) -> np.ndarray:
        """Loads (..., n) turned from heading axes to the earth's; forces and moments alternate in
        threes."""
        return loads if self.heading == 0.0 else loads_about_z(loads, self.heading)
