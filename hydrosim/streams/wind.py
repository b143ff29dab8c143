"""Mean wind over the height and over averaging times.

NPD (NORSOK N-003; the same in ISO 19901-1:2005, A.7.3, and API RP 2A-WSD 21st edition, 2.3.2), with
the mean U0 of one hour at 10 m:

    U(z) = U0 (1 + C ln(z / 10)),   C = 0.0573 sqrt(1 + 0.15 U0)
    U(z, T) = U(z) (1 - 0.41 I(z) ln(T / T0)),   T0 = 1 h, T <= T0
    I(z) = 0.06 (1 + 0.043 U0) (z / 10)^-0.22

z: height above the still water [m]; U(z, T): largest mean over T within the hour; I: intensity of
turbulence. The power law is U(z) = U0 (z / 10)^a.

Without a profile the wind is that of 10 m at all heights. Limits: neutral air over the sea; heights
above 1 m.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, log, sin, sqrt

from hydrosim.errors import InputError
from hydrosim.scene import Environment, Stream, WindLaw, WindProfile
from hydrosim.streams.current import velocity_of

REFERENCE_HEIGHT = 10.0
"""Height [m] of the wind that spectra and results are about."""
HOUR_S = 3600.0
MIN_HEIGHT = 1.0
"""Height [m] below which the laws are not used."""


@dataclass(frozen=True)
class MeanWind:
    """Mean wind: ``hour_mean`` [m/s] is that of one hour at 10 m, or the steady wind there."""

    stream: Stream
    profile: WindProfile | None
    hour_mean: float

    def height_felt(self, height: float) -> float:
        """Height [m] whose wind acts at a ``height``: 10 m if there is no profile."""
        return REFERENCE_HEIGHT if self.profile is None else height

    def speed_at(self, height: float) -> float:
        """Mean speed [m/s] at a ``height`` [m] above the still water."""
        if self.profile is None:
            return self.hour_mean
        return self.hour_mean * _profile_factor(self.profile, self.hour_mean, height)

    def velocity_at(self, height: float) -> tuple[float, float]:
        """Mean velocity [m/s] at a ``height`` [m], in the earth's x and y."""
        return velocity_of(Stream(self.speed_at(height), self.stream.heading))

    @property
    def direction(self) -> tuple[float, float]:
        """Unit vector along the wind."""
        return cos(self.stream.heading), sin(self.stream.heading)


def mean_wind(environment: Environment) -> MeanWind:
    """Mean wind of an environment. The mean of one hour at 10 m is the one with the given mean at
    the given height. Raises InputError if there is no such mean."""
    stream, profile, gusts = environment.wind, environment.wind_profile, environment.gusts
    averaging = HOUR_S if gusts is None else gusts.averaging
    height = REFERENCE_HEIGHT if profile is None else profile.height
    if stream.speed == 0.0 or (height == REFERENCE_HEIGHT and averaging == HOUR_S):
        return MeanWind(stream, profile, stream.speed)

    def speed(hour_mean: float) -> float:
        return (
            hour_mean
            * (1.0 if profile is None else _profile_factor(profile, hour_mean, height))
            * gust_factor(hour_mean, height, averaging)
        )

    return MeanWind(stream, profile, _solve_hour_mean(speed, stream.speed))


def _solve_hour_mean(speed: Callable[[float], float], wanted: float) -> float:
    """The mean of one hour at 10 m that gives the ``wanted`` speed."""
    from scipy.optimize import brentq  # slow to load, and few scenes need it

    highest = 10.0 * wanted
    if speed(highest) < wanted:
        raise InputError(
            f"environment.wind.height: found a height at which {wanted:g} m/s belongs to more than"
            f" {highest:g} m/s at 10 m; expected a height nearer to 10 m"
        )
    return float(brentq(lambda U0: speed(U0) - wanted, 0.0, highest, xtol=1e-13, rtol=1e-14))


def _profile_factor(profile: WindProfile, hour_mean: float, height: float) -> float:
    """U(z) / U0."""
    if profile.law == WindLaw.POWER:
        return float((height / REFERENCE_HEIGHT) ** profile.exponent)
    C = 0.0573 * sqrt(1.0 + 0.15 * hour_mean)
    return 1.0 + C * log(height / REFERENCE_HEIGHT)


def turbulence_intensity(hour_mean: float, height: float) -> float:
    """I(z) of the NPD wind."""
    return float(0.06 * (1.0 + 0.043 * hour_mean) * (height / REFERENCE_HEIGHT) ** -0.22)


def gust_factor(hour_mean: float, height: float, averaging: float) -> float:
    """Largest mean over ``averaging`` [s] within an hour, over the mean of the hour (NPD)."""
    intensity = turbulence_intensity(hour_mean, height)
    return 1.0 - 0.41 * intensity * log(averaging / HOUR_S)
