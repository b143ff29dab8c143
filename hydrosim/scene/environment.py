"""Waves, current, wind and water."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from hydrosim.scene.spectra import Spectrum


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
    """Steady and uniform current or wind: ``speed`` [m/s] and ``heading`` [rad], the direction of
    flow, counter-clockwise from +x."""

    speed: float = 0.0
    heading: float = 0.0


@dataclass(frozen=True)
class Environment:
    """Water [m, kg/m^3, m/s^2] and the waves on it; an infinite depth is ``math.inf``. ``current``
    and ``wind`` act through force elements alone and do not change the waves."""

    water_depth: float = np.inf
    water_density: float = 1025.0
    gravity: float = 9.81
    waves: tuple[WaveTrain, ...] = ()
    current: Stream = field(default_factory=Stream)
    wind: Stream = field(default_factory=Stream)
