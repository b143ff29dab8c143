"""The water that a hull is computed in."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hydrosim.waves.dispersion import wavenumber

MIN_TESTED_KH = 0.01  # kh down to which `green` is tested


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

    @property
    def lowest_frequency(self) -> float:
        """Lowest frequency [rad/s] that can be computed; 0 in deep water."""
        if self.is_deep:
            return 0.0
        return math.sqrt(self.gravity * MIN_TESTED_KH / self.depth * math.tanh(MIN_TESTED_KH))

    def wavenumber(self, frequency: float) -> float:
        """Wavenumber [1/m] of waves of ``frequency`` [rad/s]."""
        return float(wavenumber(frequency, self.depth, self.gravity))
