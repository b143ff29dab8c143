"""Piecewise linear spectra: tables and white noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class TabulatedSpectrum:
    """``values`` (n,) [m^2 s/rad] at rising ``frequency`` (n,) [rad/s], zero outside."""

    frequency: np.ndarray
    values: np.ndarray

    def density(self, omega: np.ndarray) -> np.ndarray:
        """Density [m^2 s/rad] at ``omega`` [rad/s]; zero at omega <= 0."""
        found = np.interp(omega, self.frequency, self.values, left=0.0, right=0.0)
        return np.where(np.asarray(omega) > 0.0, found, 0.0)

    def energy_above(self, omega: float) -> float:
        """Energy [m^2] above ``omega`` [rad/s]."""
        low = min(max(omega, self.frequency[0]), self.frequency[-1])
        nodes = np.append(low, self.frequency[self.frequency > low])
        values = np.interp(nodes, self.frequency, self.values)
        return float(0.5 * np.diff(nodes) @ (values[1:] + values[:-1]))

    @property
    def width(self) -> float:
        """Width of the band of equal energy and equal mean density (energy^2 over the integral
        of the squared density) [rad/s]."""
        a, b, step = self.values[:-1], self.values[1:], np.diff(self.frequency)
        square = float(np.sum((a * a + a * b + b * b) / 3.0 * step))
        return self.energy_above(0.0) ** 2 / square if square else np.inf
