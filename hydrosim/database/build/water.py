"""The water that a hull is computed in."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hydrosim.waves.dispersion import wavenumber


@dataclass(frozen=True)
class Water:
    """Density [kg/m^3], gravity [m/s^2] and depth [m], ``math.inf`` for deep water."""

    density: float = 1025.0
    gravity: float = 9.81
    depth: float = math.inf

    @property
    def is_deep(self) -> bool:
        """True for infinite depth."""
        return math.isinf(self.depth)

    def wavenumber(self, frequency: float) -> float:
        """Wavenumber [1/m] of waves of ``frequency`` [rad/s]."""
        return float(wavenumber(frequency, self.depth, self.gravity))
