"""Environment of a scene: spectra and seas, current, wind, gusts and water."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import ClassVar

import numpy as np
from pydantic import SkipValidation

from hydrosim.files import quantities as of
from hydrosim.files.schema_class import SchemaClass, schema_class

# Seas: spectra, regular waves, components and recorded elevations.


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


@schema_class
class OchiHubblePeak(SchemaClass):
    """One peak; ``shape`` is lambda."""

    significant_height: of.Height
    """Significant height of this peak alone."""
    peak_period: of.Period
    """Period of this peak."""
    shape: of.Sharpness = 1.0
    """Sharpness lambda of this peak."""


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


class Amplitudes(StrEnum):
    """Amplitudes of the components of a random sea: sqrt(2 S dw), or Rayleigh distributed about
    that, which makes the sea Gaussian."""

    DETERMINISTIC = "deterministic"
    RAYLEIGH = "rayleigh"


@dataclass(frozen=True)
class WaveTrain:
    """Waves of one spectrum and one mean direction.

    ``heading`` [rad] is the direction of propagation, counter-clockwise from +x (`GivenComponents`
    and `DirectionalTable` have their own). ``ramp`` [s] is the time over which the elevation grows
    from zero. ``repeat_period`` [s] sets the spacing of the components of a random sea, 2 pi /
    repeat_period, so that the sea does not depend on the duration. ``spreading`` is the exponent s
    of the distribution cos^2s of half the angle to the heading; None gives long crests.
    """

    spectrum: Spectrum
    heading: float = 0.0
    seed: int = 1
    ramp: float = 0.0
    repeat_period: float = 10800.0
    amplitudes: Amplitudes = Amplitudes.DETERMINISTIC
    spreading: float | None = None


@dataclass(frozen=True)
class Stream:
    """Current or wind: ``speed`` [m/s] and ``heading`` [rad], the direction of flow,
    counter-clockwise from +x. It is steady and uniform without a profile or gusts."""

    speed: float = 0.0
    heading: float = 0.0


@dataclass(frozen=True)
class CurrentProfile:
    """Current over the ``depth`` (n,) [m] below the still water, which rises from 0: the speed is
    ``factor`` (n,) times that of the stream, the heading is turned by ``turn`` (n,) [rad]. The
    components of the velocity are linear between the depths, and constant below the last."""

    depth: tuple[float, ...]
    factor: tuple[float, ...]
    turn: tuple[float, ...]


class WindLaw(StrEnum):
    """Law of the mean wind over the height."""

    NPD = "npd"
    POWER = "power"


@dataclass(frozen=True)
class WindProfile:
    """Mean wind over the height by a ``law``. ``height`` [m] above the still water is where the
    stream has its speed. ``exponent`` is that of the power law."""

    law: WindLaw
    height: float = 10.0
    exponent: float = 0.11


class GustSpectrum(StrEnum):
    """Spectrum of gusts, see `hydrosim.water.wind`."""

    NPD = "npd"
    API = "api"
    OCHI_SHIN = "ochi_shin"


@dataclass(frozen=True)
class Gusts:
    """Gusts along the mean wind: their ``spectrum`` between the ``lowest`` and the ``highest``
    frequency [rad/s].

    ``averaging`` [s] is the time over which the speed of the wind is a mean. ``ramp`` [s],
    ``repeat_period`` [s], ``amplitudes`` and ``seed`` are as in a `WaveTrain`; the phases are
    independent of those of waves with the same seed.
    """

    spectrum: GustSpectrum = GustSpectrum.NPD
    seed: int = 1
    lowest: float = 2.0 * np.pi / 600.0
    highest: float = np.pi
    averaging: float = 3600.0
    ramp: float = 0.0
    repeat_period: float = 10800.0
    amplitudes: Amplitudes = Amplitudes.DETERMINISTIC


@schema_class
class WaterProperties(SchemaClass):
    """The water of a scene."""

    has_valid_defaults: ClassVar[bool] = True

    water_depth: of.Depth = np.inf
    """Depth of the water, or infinite."""
    water_density: of.Density = 1025.0
    """Density of the water."""
    gravity: of.Gravity = 9.81
    """Acceleration of gravity."""


@schema_class
class Environment(WaterProperties):
    """Water and the waves on it. ``current`` and ``wind`` act through force elements alone and do
    not change the waves. Each may have a profile, and the wind may have ``gusts``. In Python there
    may be no gravity."""

    water_depth: SkipValidation[float] = np.inf
    gravity: of.GravityOrNone = 9.81
    waves: SkipValidation[tuple[WaveTrain, ...]] = ()
    current: SkipValidation[Stream] = Stream()
    wind: SkipValidation[Stream] = Stream()
    current_profile: SkipValidation[CurrentProfile | None] = None
    wind_profile: SkipValidation[WindProfile | None] = None
    gusts: SkipValidation[Gusts | None] = None

    @property
    def seeds(self) -> list[int]:
        """The seeds of all wave trains, and of the gusts if there are any."""
        gust_seeds = [] if self.gusts is None else [self.gusts.seed]
        return [*(train.seed for train in self.waves), *gust_seeds]

    def with_seed(self, seed: int) -> Environment:
        """The same waves and gusts, drawn from another seed. They stay independent of each
        other."""
        waves = tuple(replace(train, seed=seed) for train in self.waves)
        gusts = None if self.gusts is None else replace(self.gusts, seed=seed)
        return replace(self, waves=waves, gusts=gusts)

    def without_waves(self) -> Environment:
        """The same in calm water; two environments that differ in waves and seeds alone are then
        equal."""
        return replace(self.with_seed(0), waves=())
