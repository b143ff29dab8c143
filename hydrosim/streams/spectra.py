"""Spectra of gusts along the wind, one-sided, over the frequency f [Hz]: S in (m/s)^2/Hz.

NPD (NORSOK N-003; ISO 19901-1:2005, A.7.4), 1/600 Hz < f < 0.5 Hz:

    S = 320 (U0 / 10)^2 (z / 10)^0.45 / (1 + x^n)^(5 / (3 n)),   n = 0.468
    x = 172 f (z / 10)^(2/3) (U0 / 10)^-0.75

API (RP 2A-WSD 20th edition, 2.3.2), with fp z / U(z) = 0.025:

    f S = s^2 (f / fp) / (1 + 1.5 f / fp)^(5/3)
    s = 0.15 U(z) (z / 20)^-a,   a = 0.125 up to 20 m, 0.275 above

Ochi and Shin (1988, OTC 5736), with F = 10 f / U0 and the drag of Wu (1982):

    f S = c U0^2 G,   c = (0.8 + 0.065 U0) / 1000
    G = 583 F                                     F <= 0.003
    G = 420 F^0.7 / (1 + F^0.35)^11.5     0.003 < F <= 0.1
    G = 838 F / (1 + F^0.35)^11.5           0.1 < F

U0: mean of one hour at 10 m; U(z): that at the height z. The last spectrum is that of 10 m at all
heights.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from hydrosim.scene import GustSpectrum
from hydrosim.streams.wind import REFERENCE_HEIGHT, MeanWind

NPD_EXPONENT = 0.468
_OUTSIDE = np.geomspace(1e-9, 1e6, 60001)  # Hz, for the energy of a whole spectrum


def density(spectrum: GustSpectrum, f: np.ndarray, height: float, wind: MeanWind) -> np.ndarray:
    """Density S (n,) [(m/s)^2/Hz] at the frequencies ``f`` (n,) [Hz] and a ``height`` [m]."""
    return DENSITIES[spectrum](np.asarray(f, dtype=float), height, wind)


def _npd(f: np.ndarray, z: float, wind: MeanWind) -> np.ndarray:
    U0 = wind.hour_mean
    n = NPD_EXPONENT
    x = 172.0 * f * (z / 10.0) ** (2.0 / 3.0) * (U0 / 10.0) ** -0.75
    return 320.0 * (U0 / 10.0) ** 2 * (z / 10.0) ** 0.45 / (1.0 + x**n) ** (5.0 / (3.0 * n))


def _api(f: np.ndarray, z: float, wind: MeanWind) -> np.ndarray:
    U = wind.speed_at(z)
    fp = 0.025 * U / z
    s = 0.15 * U * (z / 20.0) ** (-0.125 if z <= 20.0 else -0.275)
    return s**2 / fp / (1.0 + 1.5 * f / fp) ** (5.0 / 3.0)


def _ochi_shin(f: np.ndarray, z: float, wind: MeanWind) -> np.ndarray:
    U0 = wind.hour_mean
    F = REFERENCE_HEIGHT * f / U0
    c = (0.8 + 0.065 * U0) / 1000.0
    fall = (1.0 + F**0.35) ** -11.5
    slope = np.where(F <= 0.003, 583.0, np.where(F <= 0.1, 420.0 * F**-0.3 * fall, 838.0 * fall))
    return c * U0 * REFERENCE_HEIGHT * slope


DENSITIES: dict[GustSpectrum, Callable[[np.ndarray, float, MeanWind], np.ndarray]] = {
    GustSpectrum.NPD: _npd,
    GustSpectrum.API: _api,
    GustSpectrum.OCHI_SHIN: _ochi_shin,
}


def variance(
    spectrum: GustSpectrum, height: float, wind: MeanWind, lowest: float, highest: float
) -> tuple[float, float, float]:
    """Variance [(m/s)^2] of a spectrum below, within and above a band of frequencies [Hz]."""
    edges = [_OUTSIDE[0], lowest, highest, _OUTSIDE[-1]]
    parts = []
    for first, last in pairwise(edges):
        f = np.unique([first, *_OUTSIDE[(first < _OUTSIDE) & (last > _OUTSIDE)], last])
        S = density(spectrum, f, height, wind)
        parts.append(float(np.trapezoid(S * f, np.log(f))))
    return parts[0], parts[1], parts[2]
