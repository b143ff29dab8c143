"""Seas: spectra, regular waves, components and recorded elevations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Jonswap:
    """JONSWAP spectrum (Hasselmann et al. 1973) of a significant height [m] and peak period [s]."""

    significant_height: float
    peak_period: float
    peak_enhancement: float = 3.3


@dataclass(frozen=True)
class Tma:
    """JONSWAP spectrum limited by a ``water_depth`` [m] (Bouws et al. 1985), scaled to the
    significant height; ``gravity`` [m/s^2]."""

    significant_height: float
    peak_period: float
    water_depth: float
    peak_enhancement: float = 3.3
    gravity: float = 9.81


@dataclass(frozen=True)
class OchiHubblePeak:
    """One of the peaks of `OchiHubble`: significant height [m], peak period [s], and ``shape``
    lambda, the sharpness of the peak."""

    significant_height: float
    peak_period: float
    shape: float = 1.0


@dataclass(frozen=True)
class OchiHubble:
    """Sum of peaks of chosen sharpness (Ochi and Hubble 1976, with two peaks: swell and wind
    sea)."""

    peaks: tuple[OchiHubblePeak, ...]


@dataclass(frozen=True)
class Torsethaugen:
    """Wind sea and swell of a significant height [m] and peak period [s] (Torsethaugen and Haver
    2004, the simplified form), for the North Sea; ``gravity`` [m/s^2]."""

    significant_height: float
    peak_period: float
    gravity: float = 9.81


@dataclass(frozen=True)
class WhiteNoise:
    """Constant density between two frequencies [rad/s], of a significant height [m]."""

    significant_height: float
    lowest_frequency: float
    highest_frequency: float


@dataclass(frozen=True, eq=False)
class SpectrumTable:
    """``density`` (nf,) [m^2 s/rad] at rising ``frequency`` (nf,) [rad/s], linear between them and
    zero outside."""

    frequency: np.ndarray
    density: np.ndarray


@dataclass(frozen=True, eq=False)
class DirectionalTable:
    """``density`` (nf, nh) [m^2 s/rad^2] at rising ``frequency`` (nf,) [rad/s] and rising, equally
    spaced ``heading`` (nh,) [rad], the direction of propagation. It is linear between frequencies,
    and constant over the sector around each heading."""

    frequency: np.ndarray
    heading: np.ndarray
    density: np.ndarray


@dataclass(frozen=True)
class RegularWave:
    """One Airy wave: amplitude * cos(2 pi t / period + phase) at the earth's origin."""

    amplitude: float
    period: float
    phase: float = 0.0


@dataclass(frozen=True, eq=False)
class GivenComponents:
    """Airy waves amplitude * cos(omega t + phase) at the earth's origin: ``omega`` [rad/s],
    ``amplitude`` [m], ``phase`` [rad] and ``heading`` [rad] are (n,) each."""

    omega: np.ndarray
    amplitude: np.ndarray
    phase: np.ndarray
    heading: np.ndarray


@dataclass(frozen=True, eq=False)
class RecordedElevation:
    """``elevation`` (n,) [m] at equally spaced ``time`` (n,) [s] of the run, measured at
    ``position`` x, y [m]. Its mean and its content above ``highest_frequency`` [rad/s] are
    removed."""

    time: np.ndarray
    elevation: np.ndarray
    position: tuple[float, float] = (0.0, 0.0)
    highest_frequency: float = np.inf


Density = Jonswap | Tma | OchiHubble | Torsethaugen | WhiteNoise | SpectrumTable | DirectionalTable
"""Spectra from which a random sea is drawn."""


Spectrum = Density | RegularWave | GivenComponents | RecordedElevation
