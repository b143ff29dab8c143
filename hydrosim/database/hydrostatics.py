"""`Hydrostatics`: integrals over the submerged hull, and its stiffness."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Hydrostatics:
    """Integrals over the hull [m]: waterplane area, its first and second moments about the axes of
    the frame, the volume, and the centre of buoyancy (3,)."""

    area: float
    moment_x: float
    second_xx: float
    second_yy: float
    volume: float
    centre_of_buoyancy: np.ndarray
    moment_y: float = 0.0
    second_xy: float = 0.0

    def stiffness(self, height: float, density: float, gravity: float) -> np.ndarray:
        """Stiffness (6, 6) about a centre of gravity at ``height`` [m] above the centre of
        buoyancy, for weight equal to buoyancy (Newman 1977, Marine Hydrodynamics, chapter 6)."""
        x, y, z = self.centre_of_buoyancy
        lever = self.volume * (z - height)
        C = np.zeros((6, 6))
        C[2, 2] = self.area
        C[2, 3] = C[3, 2] = self.moment_y - self.area * y
        C[2, 4] = C[4, 2] = self.area * x - self.moment_x
        C[3, 3] = self.second_yy - 2 * y * self.moment_y + y**2 * self.area + lever
        C[3, 4] = C[4, 3] = (
            x * self.moment_y + y * self.moment_x - self.second_xy - x * y * self.area
        )
        C[4, 4] = self.second_xx - 2 * x * self.moment_x + x**2 * self.area + lever
        return density * gravity * C
