"""Wave spectra: one-sided densities of the elevation over angular frequency, one file per
family."""

from __future__ import annotations

from functools import lru_cache
from typing import Protocol, assert_never

import numpy as np
from numpy.typing import ArrayLike

from hydrosim import scene
from hydrosim.waves.spectra.peaks import Peak, Peaks
from hydrosim.waves.spectra.table import TabulatedSpectrum
from hydrosim.waves.spectra.tma import TmaShape
from hydrosim.waves.spectra.torsethaugen import wind_sea_and_swell

TAIL_ENERGY = 1e-3
"""Fraction of the energy above the highest component of an irregular sea."""


class _Curve(Protocol):
    """A spectrum over angular frequency."""

    def density(self, omega: np.ndarray) -> np.ndarray:
        """Density [m^2 s/rad] at ``omega`` [rad/s]; zero at omega <= 0."""

    def energy_above(self, omega: float) -> float:
        """Energy [m^2] above ``omega``: the integral of the density from there on."""

    @property
    def width(self) -> float:
        """Frequency [rad/s]; the spacing of components must be a small fraction of it."""


def density(spectrum: scene.Density, omega: ArrayLike) -> np.ndarray:
    """Density [m^2 s/rad] at ``omega`` [rad/s], of any shape; zero at omega <= 0.

    If a significant height is given, the integral over the whole axis is Hs^2 / 16 to rounding: no
    fit is used to scale a shape.
    """
    return _curve(spectrum).density(np.asarray(omega, dtype=float))


def energy(spectrum: scene.Density) -> float:
    """Variance of the elevation [m^2]: the integral of the density."""
    return energy_above(spectrum, 0.0)


def energy_above(spectrum: scene.Density, omega: float) -> float:
    """Variance of the elevation [m^2] by waves above ``omega`` [rad/s]."""
    return _curve(spectrum).energy_above(omega)


def width(spectrum: scene.Density) -> float:
    """Frequency [rad/s] of the lowest peak, or width of a band. The spacing of components must be a
    small fraction of it."""
    return _curve(spectrum).width


@lru_cache
def cut_off(spectrum: scene.Density) -> float:
    """Frequency [rad/s] with the fraction `TAIL_ENERGY` of the energy above it."""
    wanted = TAIL_ENERGY * energy(spectrum)
    high = 1.0
    if wanted == 0.0:
        return 0.0
    above = _curve(spectrum).energy_above
    while above(high) > wanted:
        high *= 2.0
    while above(0.5 * high) < wanted:
        high *= 0.5
    low = 0.5 * high
    while high - low > 1e-14 * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if above(middle) > wanted else (low, middle)
    return high


@lru_cache
def _curve(spectrum: scene.Density) -> _Curve:
    match spectrum:
        case scene.Jonswap(height, period, enhancement):
            return Peaks((Peak(height, period, enhancement=enhancement),))
        case scene.Tma():
            return TmaShape(spectrum).with_scale()
        case scene.OchiHubble(peaks):
            return Peaks(
                tuple(Peak(p.significant_height, p.peak_period, 4 * p.shape + 1) for p in peaks)
            )
        case scene.Torsethaugen():
            return Peaks(wind_sea_and_swell(spectrum))
        case scene.WhiteNoise(height, low, high):
            level = height**2 / (16.0 * (high - low))
            return TabulatedSpectrum(np.array([low, high]), np.array([level, level]))
        case scene.SpectrumTable(frequency, values):
            return TabulatedSpectrum(frequency, values)
        case scene.DirectionalTable(frequency, heading, values):
            return TabulatedSpectrum(frequency, values.sum(axis=1) * (heading[1] - heading[0]))
    assert_never(spectrum)
