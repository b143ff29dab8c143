"""TMA spectrum: JONSWAP in water of limited depth.

Bouws, Gunther, Rosenthal and Vincent (1985, J. Geophys. Res. 90(C1)) multiply the JONSWAP spectrum
by the factor of Kitaigorodskii et al. (1975). The tail then falls as k^-3 in any depth:

    phi = tanh^2(k h) / (1 + 2 k h / sinh(2 k h)),

which is w^2 h / 2g in shallow water and 1 in deep water.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.waves.dispersion import wavenumber
from hydrosim.waves.spectra.peaks import peakedness, shape

if TYPE_CHECKING:
    from hydrosim.scene import Tma

_NOTHING_BELOW = 0.4  # in peak frequencies: exp(-5/4 u^-4) is 6e-22


def kitaigorodskii(omega: np.ndarray, depth: float, gravity: float) -> np.ndarray:
    """The factor phi at ``omega`` [rad/s]."""
    if np.isinf(depth):
        return np.ones_like(omega)
    kh = np.clip(wavenumber(omega, depth, gravity) * depth, 1e-12, 300.0)
    return np.tanh(kh) ** 2 / (1.0 + 2.0 * kh / np.sinh(2.0 * kh))


@dataclass(frozen=True)
class TmaShape:
    """The ``spectrum`` over frequency; ``scale`` [m^2] adjusts it to its significant height."""

    spectrum: Tma
    scale: float = 1.0

    @property
    def width(self) -> float:
        """Peak frequency of the JONSWAP spectrum [rad/s]."""
        return 2.0 * np.pi / self.spectrum.peak_period

    def density(self, omega: np.ndarray) -> np.ndarray:
        """Density [m^2 s/rad] at ``omega`` [rad/s]; zero at omega <= 0."""
        wet = np.asarray(omega) > 0.0
        u = np.where(wet, omega, self.width) / self.width
        return np.where(wet, self.scale / self.width * self._shape(u), 0.0)

    def energy_above(self, omega: float) -> float:
        """Energy [m^2] above ``omega`` [rad/s]."""
        return self.scale * self._energy(omega / self.width)

    def with_scale(self) -> TmaShape:
        """The spectrum with its scale, by quadrature."""
        height = self.spectrum.significant_height
        return replace(self, scale=height**2 / (16.0 * self._energy(0.0)))

    def _shape(self, u: np.ndarray) -> np.ndarray:
        s = self.spectrum
        limited = kitaigorodskii(u * self.width, s.water_depth, s.gravity)
        return shape(u, 5.0) * s.peak_enhancement ** peakedness(u) * limited

    def _energy(self, low: float) -> float:
        """Integral from ``low`` on, over x = u^-4, in which the tail is finite and smooth."""
        from scipy.integrate import quad  # slow to load, and few seas are of this kind

        def integrand(x: float) -> float:
            u = np.array([x**-0.25])
            return float(self._shape(u)[0] * 0.25 * x**-1.25)

        end = max(low, _NOTHING_BELOW) ** -4.0
        limits = [0.0, *(x for x in (0.2, 1.0, 3.0) if x < end), end]
        pieces = pairwise(limits)
        return sum(quad(integrand, *piece, epsabs=1e-14, epsrel=1e-12)[0] for piece in pieces)
