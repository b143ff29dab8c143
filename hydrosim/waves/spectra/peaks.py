"""Spectra that are sums of peaks, each u^-n exp(-n/4 u^-4) gamma^p(u) over u = omega / peak.

JONSWAP (Hasselmann et al. 1973) has n = 5; without enhancement (gamma = 1) it is the spectrum of
Pierson and Moskowitz (1964). A peak of Ochi and Hubble (1976, eq. 8) has n = 4 lambda + 1 without
enhancement. The peaks of Torsethaugen and Haver (2004) have n = 4. Near its peak the spectrum is
enhanced by p(u) = exp(-(u - 1)^2 / (2 s^2)), s = 0.07 below and 0.09 above the peak.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

_ENHANCED = (0.3, 2.0)  # in peak frequencies: outside, the enhancement is below 1e-22

# Gauss and Legendre's rule: exact to rounding for both sides of the enhancement
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(100)


@dataclass(frozen=True)
class Peak:
    """One peak: significant height [m], peak period [s], exponent n of the tail, enhancement."""

    significant_height: float
    peak_period: float
    exponent: float = 5.0
    enhancement: float = 1.0

    @property
    def frequency(self) -> float:
        """Peak frequency [rad/s]."""
        return 2.0 * np.pi / self.peak_period

    def density(self, omega: np.ndarray) -> np.ndarray:
        """Density [m^2 s/rad] at ``omega`` [rad/s]; zero at omega <= 0."""
        u = np.asarray(omega) / self.frequency
        wet = u > 0.0
        v = np.where(wet, u, 1.0)
        values = shape(v, self.exponent) * self.enhancement ** peakedness(v)
        total = _shape_energy(self.exponent, self.enhancement, 0.0)
        scale = self.significant_height**2 / (16.0 * self.frequency * total)
        return np.where(wet, scale * values, 0.0)

    def energy_above(self, omega: float) -> float:
        """Energy [m^2] above ``omega`` [rad/s]."""
        parts = [
            _shape_energy(self.exponent, self.enhancement, u) for u in (omega / self.frequency, 0.0)
        ]
        return self.significant_height**2 / 16.0 * parts[0] / parts[1]


@dataclass(frozen=True)
class Peaks:
    """A sum of peaks."""

    peaks: tuple[Peak, ...]

    def density(self, omega: np.ndarray) -> np.ndarray:
        """Density [m^2 s/rad] at ``omega`` [rad/s]."""
        return np.sum([peak.density(omega) for peak in self.peaks], axis=0)

    def energy_above(self, omega: float) -> float:
        """Energy [m^2] above ``omega`` [rad/s]."""
        return sum(peak.energy_above(omega) for peak in self.peaks)

    @property
    def width(self) -> float:
        """The lowest peak's frequency [rad/s]."""
        return min(peak.frequency for peak in self.peaks)


def shape(u: np.ndarray, exponent: float) -> np.ndarray:
    """A peak without its scale and enhancement, at u > 0."""
    with np.errstate(over="ignore", under="ignore"):  # far below the peak: exp(-inf) = 0
        return np.exp(-0.25 * exponent * u**-4.0 - exponent * np.log(u))


def peakedness(u: np.ndarray) -> np.ndarray:
    """Power of the peak enhancement at u."""
    side = np.where(u <= 1.0, 0.07, 0.09)
    return np.exp(-0.5 * ((u - 1.0) / side) ** 2)


def _shape_energy(exponent: float, enhancement: float, low: float) -> float:
    """Integral of the enhanced shape from ``low`` on: an incomplete gamma function plus the
    enhancement's share, by quadrature."""
    from scipy.special import gamma, gammainc  # slow to load, and few scenes have such a sea

    a = 0.25 * (exponent - 1.0)
    b = 0.25 * exponent
    part = gammainc(a, b * low**-4.0) if low > 0.0 else 1.0
    return float(0.25 * b**-a * gamma(a) * part + _added_energy(exponent, enhancement, low))


def _added_energy(exponent: float, enhancement: float, low: float) -> float:
    if enhancement == 1.0:
        return 0.0
    begin = max(low, _ENHANCED[0])
    end = _ENHANCED[1]
    limits = [begin, *([1.0] if begin < 1.0 else []), max(begin, end)]
    total = 0.0
    for low, high in pairwise(limits):
        half = 0.5 * (high - low)
        middle = 0.5 * (high + low)
        u = middle + half * _NODES
        total += half * float(
            _WEIGHTS @ (shape(u, exponent) * (enhancement ** peakedness(u) - 1.0))
        )
    return total
