"""Wave spectra: one-sided densities of the elevation over angular frequency; dispersion of waves.

Spectra that are sums of peaks, each u^-n exp(-n/4 u^-4) gamma^p(u) over u = omega / peak.

JONSWAP (Hasselmann et al. 1973) has n = 5; without enhancement (gamma = 1) it is the spectrum of
Pierson and Moskowitz (1964). A peak of Ochi and Hubble (1976, eq. 8) has n = 4 lambda + 1 without
enhancement. The peaks of Torsethaugen and Haver (2004) have n = 4. Near its peak the spectrum is
enhanced by p(u) = exp(-(u - 1)^2 / (2 s^2)), s = 0.07 below and 0.09 above the peak.

TMA spectrum: JONSWAP in water of limited depth.

Bouws, Gunther, Rosenthal and Vincent (1985, J. Geophys. Res. 90(C1)) multiply the JONSWAP spectrum
by the factor of Kitaigorodskii et al. (1975). The tail then falls as k^-3 in any depth:

    phi = tanh^2(k h) / (1 + 2 k h / sinh(2 k h)),

which is w^2 h / 2g in shallow water and 1 in deep water.

Torsethaugen's spectrum: division of a sea of given height and peak period into wind sea and
swell.

Torsethaugen and Haver (2004), "Simplified double peak spectral model for ocean waves", ISOPE; also
in DNV-RP-C205, 3.5.6. A fully developed wind sea has the peak period T_f = 6.6 Hs^(1/3) (a fetch of
370 km). Up to T_f the main peak is wind sea and the secondary one is swell. Above T_f the main peak
is swell. The squares of the two heights add up to Hs^2.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Protocol, assert_never

import numpy as np
from numpy.typing import ArrayLike

from hydrosim import scene

if TYPE_CHECKING:
    from hydrosim.scene import Tma, Torsethaugen

TAIL_ENERGY = 1e-3
"""Fraction of the energy above the highest component of an irregular sea."""


class _Curve(Protocol):
    """A spectrum over angular frequency."""

    def density(self, omega: np.ndarray) -> np.ndarray:
        """Density [m^2 s/rad] at ``omega`` [rad/s]; zero at omega <= 0."""

    def energy_above(self, omega: float) -> float:
        """Energy [m^2] above ``omega``: the integral of the density from there on."""

    @property
    def resolution_frequency(self) -> float:
        """Frequency [rad/s]; the spacing of components must be a small fraction of it."""


def density(spectrum: scene.Density, omega: ArrayLike) -> np.ndarray:
    """Density [m^2 s/rad] at ``omega`` [rad/s], of any shape; zero at omega <= 0.

    If a significant height is given, the integral over the whole axis is Hs^2 / 16 to rounding: no
    fit is used to scale a shape.
    """
    return _curve_of_spectrum(spectrum).density(np.asarray(omega, dtype=float))


def energy(spectrum: scene.Density) -> float:
    """Variance of the elevation [m^2]: the integral of the density."""
    return energy_above(spectrum, 0.0)


def energy_above(spectrum: scene.Density, omega: float) -> float:
    """Variance of the elevation [m^2] by waves above ``omega`` [rad/s]."""
    return _curve_of_spectrum(spectrum).energy_above(omega)


def resolution_frequency(spectrum: scene.Density) -> float:
    """Frequency [rad/s] of the lowest peak, or width of a band. The spacing of components must be a
    small fraction of it."""
    return _curve_of_spectrum(spectrum).resolution_frequency


@lru_cache
def cut_off(spectrum: scene.Density) -> float:
    """Frequency [rad/s] with the fraction `TAIL_ENERGY` of the energy above it."""
    wanted = TAIL_ENERGY * energy(spectrum)
    high = 1.0
    if wanted == 0.0:
        return 0.0
    above = _curve_of_spectrum(spectrum).energy_above
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
def _curve_of_spectrum(spectrum: scene.Density) -> _Curve:
    match spectrum:
        case scene.Jonswap(height, period, enhancement):
            return PeakSum((Peak(height, period, enhancement=enhancement),))
        case scene.Tma():
            return TmaShape(spectrum).with_scale()
        case scene.OchiHubble(peaks):
            return PeakSum(
                tuple(Peak(p.significant_height, p.peak_period, 4 * p.shape + 1) for p in peaks)
            )
        case scene.Torsethaugen():
            return PeakSum(wind_sea_and_swell(spectrum))
        case scene.WhiteNoise(height, low, high):
            level = height**2 / (16.0 * (high - low))
            return TabulatedSpectrum(np.array([low, high]), np.array([level, level]))
        case scene.SpectrumTable(frequency, values):
            return TabulatedSpectrum(frequency, values)
        case scene.DirectionalTable(frequency, heading, values):
            return TabulatedSpectrum(frequency, values.sum(axis=1) * (heading[1] - heading[0]))
    assert_never(spectrum)


_ENHANCED = (0.3, 2.0)  # in peak frequencies: outside, the enhancement is below 1e-22

# Gauss and Legendre's rule: exact to rounding for both sides of the enhancement.
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
class PeakSum:
    """A sum of peaks."""

    peaks: tuple[Peak, ...]

    def density(self, omega: np.ndarray) -> np.ndarray:
        """Density [m^2 s/rad] at ``omega`` [rad/s]."""
        return np.sum([peak.density(omega) for peak in self.peaks], axis=0)

    def energy_above(self, omega: float) -> float:
        """Energy [m^2] above ``omega`` [rad/s]."""
        return sum(peak.energy_above(omega) for peak in self.peaks)

    @property
    def resolution_frequency(self) -> float:
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


# Piecewise linear spectra: tables and white noise.


@dataclass(frozen=True, eq=False)
class TabulatedSpectrum:
    """``values`` (n,) [m^2 s/rad] at rising ``frequency`` (n,) [rad/s], zero outside."""

    frequency: np.ndarray
    values: np.ndarray

    def density(self, omega: np.ndarray) -> np.ndarray:
        """Density [m^2 s/rad] at ``omega`` [rad/s]; zero at omega <= 0."""
        density_there = np.interp(omega, self.frequency, self.values, left=0.0, right=0.0)
        return np.where(np.asarray(omega) > 0.0, density_there, 0.0)

    def energy_above(self, omega: float) -> float:
        """Energy [m^2] above ``omega`` [rad/s]."""
        low = min(max(omega, self.frequency[0]), self.frequency[-1])
        nodes = np.append(low, self.frequency[self.frequency > low])
        values = np.interp(nodes, self.frequency, self.values)
        return float(0.5 * np.diff(nodes) @ (values[1:] + values[:-1]))

    @property
    def resolution_frequency(self) -> float:
        """Width of the band of equal energy and equal mean density (energy^2 over the integral
        of the squared density) [rad/s]."""
        a, b, step = self.values[:-1], self.values[1:], np.diff(self.frequency)
        square = float(np.sum((a * a + a * b + b * b) / 3.0 * step))
        return self.energy_above(0.0) ** 2 / square if square else np.inf


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
    def resolution_frequency(self) -> float:
        """Peak frequency of the JONSWAP spectrum [rad/s]."""
        return 2.0 * np.pi / self.spectrum.peak_period

    def density(self, omega: np.ndarray) -> np.ndarray:
        """Density [m^2 s/rad] at ``omega`` [rad/s]; zero at omega <= 0."""
        wet = np.asarray(omega) > 0.0
        u = np.where(wet, omega, self.resolution_frequency) / self.resolution_frequency
        return np.where(wet, self.scale / self.resolution_frequency * self._shape(u), 0.0)

    def energy_above(self, omega: float) -> float:
        """Energy [m^2] above ``omega`` [rad/s]."""
        return self.scale * self._energy(omega / self.resolution_frequency)

    def with_scale(self) -> TmaShape:
        """The spectrum with its scale, by quadrature."""
        height = self.spectrum.significant_height
        return replace(self, scale=height**2 / (16.0 * self._energy(0.0)))

    def _shape(self, u: np.ndarray) -> np.ndarray:
        s = self.spectrum
        limited = kitaigorodskii(u * self.resolution_frequency, s.water_depth, s.gravity)
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


_EXPONENT = 4.0


def wind_sea_and_swell(sea: Torsethaugen) -> tuple[Peak, Peak]:
    """The main peak, which is enhanced, and the secondary one.

    Heights are in m and periods in s: the coefficients depend on these units.
    """
    height, period = sea.significant_height, sea.peak_period
    developed = 6.6 * height ** (1.0 / 3.0)
    if period <= developed:
        lowest = 2.0 * np.sqrt(height)
        young = min((developed - period) / (developed - lowest), 1.0)
        main = (0.7 + 0.3 * np.exp(-((2.0 * young) ** 2))) * height
        other = np.sqrt(height**2 - main**2)
        enhancement = _peak_enhancement(main, period, sea.gravity)
        second_period = developed + 2.0
    else:
        old = min((period - developed) / (25.0 - developed), 1.0)
        main = (0.6 + 0.4 * np.exp(-((old / 0.3) ** 2))) * height
        other = np.sqrt(height**2 - main**2)
        enhancement = _peak_enhancement(height, developed, sea.gravity) * (1.0 + 6.0 * old)
        second_period = 6.6 * other ** (1.0 / 3.0)
    return (
        Peak(float(main), period, _EXPONENT, max(float(enhancement), 1.0)),
        Peak(float(other), float(second_period) or period, _EXPONENT),
    )


def _peak_enhancement(height: float, period: float, gravity: float) -> float:
    """Peak enhancement from the steepness of a sea."""
    return 35.0 * (2.0 * np.pi * height / (gravity * period**2)) ** 0.857 if period else 1.0


# Dispersion of linear gravity waves.

_GUO = 2.4908  # exponent of Guo's closed form
_NEWTON_STEPS = 3  # Guo's form is within 0.75 %, and each step squares the error


def wavenumber(omega: ArrayLike, depth: float, gravity: float) -> np.ndarray:
    """Wavenumber k [1/m] with omega^2 = g k tanh(k depth), for ``omega`` [rad/s] of any shape.

    ``depth`` [m] may be infinite. Newton's method on k h tanh(k h) = omega^2 h / g starts from the
    closed form of Guo (2002, Coastal Engineering 45, eq. 21). The result is accurate to rounding.
    """
    deep = np.asarray(omega, dtype=float) ** 2 / gravity
    if np.isinf(depth):
        return deep
    target = deep * depth
    wet = target > 0.0
    y = np.where(wet, target, 1.0)
    kh = y * (-np.expm1(-(y ** (_GUO / 2.0)))) ** (-1.0 / _GUO)
    for _ in range(_NEWTON_STEPS):
        tanh = np.tanh(kh)
        kh -= (kh * tanh - y) / (tanh + kh * (1.0 - tanh * tanh))
    return np.where(wet, kh / depth, 0.0)
