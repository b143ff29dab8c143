"""Wave spectra: one-sided densities of the elevation over angular frequency."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import quad

from hydrosim.scene import Jonswap

TAIL_ENERGY = 1e-3
"""Fraction of the energy above the highest component of an irregular sea."""

_PEAK_END = 2.0  # in peak frequencies: above it the enhancement is below 1e-26


def density(spectrum: Jonswap, omega: ArrayLike) -> np.ndarray:
    """Density [m^2 s/rad] at ``omega`` [rad/s], of any shape; zero at omega <= 0.

    JONSWAP (Hasselmann et al. 1973) with peak widths 0.07 and 0.09; a peak enhancement of 1 is
    Pierson-Moskowitz. Scaled so that the integral over the whole axis is Hs^2 / 16; the integral
    of the shape is computed by quadrature, so that this holds to rounding for any enhancement.
    """
    peak = 2.0 * np.pi / spectrum.peak_period
    u = np.asarray(omega, dtype=float) / peak
    wet = u > 0.0
    shape = np.where(wet, _shape(np.where(wet, u, 1.0), spectrum.peak_enhancement), 0.0)
    scale = spectrum.significant_height**2 / (16.0 * peak * _shape_energy(spectrum))
    return scale * shape


def cut_off(spectrum: Jonswap) -> float:
    """Frequency [rad/s] above which the fraction `TAIL_ENERGY` of the energy is.

    So far above the peak the enhancement is one, and the integral of the tail is exact:
    int_u^inf v^-5 exp(-5/4 v^-4) dv = (1 - exp(-5/4 u^-4)) / 5.
    """
    tail = 5.0 * TAIL_ENERGY * _shape_energy(spectrum)
    return 2.0 * np.pi / spectrum.peak_period * (-0.8 * np.log1p(-tail)) ** -0.25


def _shape(u: np.ndarray, enhancement: float) -> np.ndarray:
    """JONSWAP over u = omega / peak, without its scale."""
    return _pierson_moskowitz(u) * enhancement ** _peakedness(u)


def _pierson_moskowitz(u: np.ndarray) -> np.ndarray:
    with np.errstate(over="ignore", under="ignore"):  # far below the peak: exp(-inf) = 0
        return np.exp(-1.25 * u**-4.0 - 5.0 * np.log(u))


def _peakedness(u: np.ndarray) -> np.ndarray:
    width = np.where(u <= 1.0, 0.07, 0.09)
    return np.exp(-0.5 * ((u - 1.0) / width) ** 2)


def _shape_energy(spectrum: Jonswap) -> float:
    return _energy_of_enhancement(spectrum.peak_enhancement)


@lru_cache
def _energy_of_enhancement(enhancement: float) -> float:
    """Integral of the shape: 1/5 for Pierson-Moskowitz, and what the peak adds."""

    def added(u: float) -> float:
        v = np.asarray(u)
        return float(_shape(v, enhancement) - _pierson_moskowitz(v))

    below = quad(added, 0.3, 1.0, epsabs=1e-14, epsrel=1e-13)[0]
    above = quad(added, 1.0, _PEAK_END, epsabs=1e-14, epsrel=1e-13)[0]
    return 0.2 + below + above
