"""Wind: its mean over height and averaging times, spectra of gusts, and gusts over time.

Mean wind.

NPD (NORSOK N-003; the same in ISO 19901-1:2005, A.7.3, and API RP 2A-WSD 21st edition, 2.3.2), with
the mean U0 of one hour at 10 m:

    U(z) = U0 (1 + C ln(z / 10)),   C = 0.0573 sqrt(1 + 0.15 U0)
    U(z, T) = U(z) (1 - 0.41 I(z) ln(T / T0)),   T0 = 1 h, T <= T0
    I(z) = 0.06 (1 + 0.043 U0) (z / 10)^-0.22

z: height above the still water [m]; U(z, T): largest mean over T within the hour; I: intensity of
turbulence. The power law is U(z) = U0 (z / 10)^a.

Without a profile the wind is that of 10 m at all heights. Limits: neutral air over the sea; heights
above 1 m.

Spectra of gusts along the wind, one-sided, over the frequency f [Hz]: S in (m/s)^2/Hz.

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

Gusts along the mean wind, as sums of components.

    u(z, t) = ramp(t) sum_k sqrt(2 S_k(z)) cos(2 pi k t / T + e_k)

T: repeat period; S_k: variance of the spectrum between (k - 1/2) / T and (k + 1/2) / T, within the
band; e_k: random phases, which all heights share. So the components do not depend on the duration,
and their phases do not depend on those of waves with the same seed. A seed gives one series for
each spectrum, band and repeat period.

The series is a table on the solver's stage grid, as wave loads are (`hydrosim.water.loads`): exact
at its nodes, and with 6 points between them. There its error is below 1.2e-6 of the amplitude at
the highest frequency, and falls with the sixth power of the frequency.

Limits: the gusts have the direction of the mean wind. They are coherent: one body, and all bodies,
feel them at the same instant.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import cos, log, sin, sqrt
from typing import NamedTuple

import numpy as np

from hydrosim import scene
from hydrosim.errors import InputError
from hydrosim.jit.kernels import kernel
from hydrosim.water.components import GUSTS, phases, rayleigh_factors
from hydrosim.water.current import velocity_along
from hydrosim.water.loads import SpectralLines, add_sum, lagrange, rise, rows_at, time_grid

REFERENCE_HEIGHT = 10.0
"""Height [m] of the wind that spectra and results are about."""
HOUR_S = 3600.0
MIN_HEIGHT = 1.0
"""Height [m] below which the laws are not used."""


@dataclass(frozen=True)
class MeanWind:
    """Mean wind: ``hour_mean`` [m/s] is that of one hour at 10 m, or the steady wind there."""

    stream: scene.Wind
    hour_mean: float

    def height_felt(self, height: float) -> float:
        """Height [m] whose wind acts at a ``height``: 10 m if there is no profile."""
        return height if self.has_profile else REFERENCE_HEIGHT

    def speed_at(self, height: float) -> float:
        """Mean speed [m/s] at a ``height`` [m] above the still water."""
        return self.hour_mean * _profile_factor(self.stream, self.hour_mean, height)

    def velocity_at(self, height: float) -> tuple[float, float]:
        """Mean velocity [m/s] at a ``height`` [m], in the earth's x and y."""
        return velocity_along(self.speed_at(height), self.stream.heading)

    @property
    def has_profile(self) -> bool:
        """True if it changes over the height."""
        return self.stream.profile != "none"

    @property
    def direction(self) -> tuple[float, float]:
        """Unit vector along the wind."""
        return cos(self.stream.heading), sin(self.stream.heading)


def mean_wind(environment: scene.Environment) -> MeanWind:
    """Mean wind of an environment. The mean of one hour at 10 m is the one with the given mean at
    the given height. Raises InputError if there is no such mean."""
    wind = environment.wind
    averaging = HOUR_S if wind.gusts is None else wind.gusts.averaging
    height = wind.height
    if wind.speed == 0.0 or (height == REFERENCE_HEIGHT and averaging == HOUR_S):
        return MeanWind(wind, wind.speed)

    def speed(hour_mean: float) -> float:
        return (
            hour_mean
            * _profile_factor(wind, hour_mean, height)
            * gust_factor(hour_mean, height, averaging)
        )

    return MeanWind(wind, _solve_hour_mean(speed, wind.speed))


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


def _profile_factor(wind: scene.Wind, hour_mean: float, height: float) -> float:
    """U(z) / U0."""
    if wind.profile == "none":
        return 1.0
    if isinstance(wind.profile, scene.WindPower):
        return float((height / REFERENCE_HEIGHT) ** wind.profile.exponent)
    C = 0.0573 * sqrt(1.0 + 0.15 * hour_mean)
    return 1.0 + C * log(height / REFERENCE_HEIGHT)


def turbulence_intensity(hour_mean: float, height: float) -> float:
    """I(z) of the NPD wind."""
    return float(0.06 * (1.0 + 0.043 * hour_mean) * (height / REFERENCE_HEIGHT) ** -0.22)


def gust_factor(hour_mean: float, height: float, averaging: float) -> float:
    """Largest mean over ``averaging`` [s] within an hour, over the mean of the hour (NPD)."""
    intensity = turbulence_intensity(hour_mean, height)
    return 1.0 - 0.41 * intensity * log(averaging / HOUR_S)


NPD_EXPONENT = 0.468
_OUTSIDE = np.geomspace(1e-9, 1e6, 60001)  # Hz, for the energy of a whole spectrum


def density(
    spectrum: scene.GustSpectrum, f: np.ndarray, height: float, wind: MeanWind
) -> np.ndarray:
    """Density S (n,) [(m/s)^2/Hz] at the frequencies ``f`` (n,) [Hz] and a ``height`` [m]."""
    return DENSITIES[spectrum](np.asarray(f, dtype=float), height, wind)


def _npd_density(f: np.ndarray, z: float, wind: MeanWind) -> np.ndarray:
    U0 = wind.hour_mean
    n = NPD_EXPONENT
    x = 172.0 * f * (z / 10.0) ** (2.0 / 3.0) * (U0 / 10.0) ** -0.75
    return 320.0 * (U0 / 10.0) ** 2 * (z / 10.0) ** 0.45 / (1.0 + x**n) ** (5.0 / (3.0 * n))


def _api_density(f: np.ndarray, z: float, wind: MeanWind) -> np.ndarray:
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


DENSITIES: dict[scene.GustSpectrum, Callable[[np.ndarray, float, MeanWind], np.ndarray]] = {
    scene.GustSpectrum.NPD: _npd_density,
    scene.GustSpectrum.API: _api_density,
    scene.GustSpectrum.OCHI_SHIN: _ochi_shin,
}


def variance(
    spectrum: scene.GustSpectrum, height: float, wind: MeanWind, lowest: float, highest: float
) -> tuple[float, float, float]:
    """Variance [(m/s)^2] of a spectrum below, within and above a band of frequencies [Hz]."""
    edges = [_OUTSIDE[0], lowest, highest, _OUTSIDE[-1]]
    parts = []
    for first, last in pairwise(edges):
        f = np.unique([first, *_OUTSIDE[(first < _OUTSIDE) & (last > _OUTSIDE)], last])
        S = density(spectrum, f, height, wind)
        parts.append(float(np.trapezoid(S * f, np.log(f))))
    return parts[0], parts[1], parts[2]


MIN_COMPONENTS = 20
"""Fewest components: the variance of a record is then near that of the spectrum."""
NODES_PER_CELL = 6  # in the cell of a component
_LATE = 1e-6  # s: the end of a run may be this much later than the repeat period


class GustTable(NamedTuple):
    """Speeds of gusts: the rows of ``values`` (nt, nh) [m/s] are at the times start, start + step,
    ... [s], its columns are heights. The first is 10 m, where the mean wind has the speed ``mean``
    [m/s]. All grow from zero over ``ramp`` [s]. Without gusts there are no rows."""

    start: float
    step: float
    ramp: float
    mean: float
    values: np.ndarray


NO_GUSTS = GustTable(0.0, 1.0, 0.0, 0.0, np.zeros((0, 1)))


class GustComponents(NamedTuple):
    """Components of gusts: ``omega`` (n,) [rad/s], multiples of ``spacing``; ``amplitude`` (n, nh)
    [m/s] at each height, and ``phase`` (n,) [rad]."""

    spacing: float
    omega: np.ndarray
    amplitude: np.ndarray
    phase: np.ndarray


def gust_components(
    gusts: scene.Gusts, wind: MeanWind, heights: Sequence[float] = (REFERENCE_HEIGHT,)
) -> GustComponents:
    """Components of ``gusts`` about a mean ``wind`` at the ``heights`` [m]. Raises InputError if
    the repeat period is too short for the band."""
    spacing = 1.0 / gusts.repeat_period
    lowest, highest = gust_band(gusts)
    first = max(int(np.ceil(lowest / spacing - 0.5)), 1)
    last = int(np.floor(highest / spacing + 0.5))
    number = np.arange(first, last + 1)
    if number.size < MIN_COMPONENTS:
        raise InputError(
            f"environment.wind.gusts.repeat_period: {gusts.repeat_period:g} s gives"
            f" {number.size} components between {lowest:.3g} and {highest:.3g} Hz; expected"
            f" {MIN_COMPONENTS} or more. Raise it, or widen the band."
        )
    power = np.array([_gust_power(gusts, number, spacing, z, wind) for z in heights]).T
    amplitude = np.sqrt(2.0 * power)
    if gusts.amplitudes == scene.Amplitudes.RAYLEIGH:
        amplitude *= rayleigh_factors(gusts, GUSTS, number.size)[:, None]
    phase = phases(gusts, GUSTS, number.size)
    turn = 2.0 * np.pi * spacing
    return GustComponents(turn, turn * number, amplitude, phase)


def gust_band(gusts: scene.Gusts) -> tuple[float, float]:
    """Lowest and highest frequency [Hz]."""
    return gusts.lowest_frequency / (2.0 * np.pi), gusts.highest_frequency / (2.0 * np.pi)


def _gust_power(
    gusts: scene.Gusts, number: np.ndarray, spacing: float, height: float, wind: MeanWind
) -> np.ndarray:
    """Variance (n,) of the spectrum in the cell of each component, by Gauss' rule. Cells at the
    ends of the band are cut."""
    lowest, highest = gust_band(gusts)
    left = np.clip((number - 0.5) * spacing, lowest, highest)
    right = np.clip((number + 0.5) * spacing, lowest, highest)
    place, weight = np.polynomial.legendre.leggauss(NODES_PER_CELL)
    f = left + np.multiply.outer(0.5 + 0.5 * place, right - left)
    return np.asarray(0.5 * (right - left) * (weight @ density(gusts.spectrum, f, height, wind)))


def gust_table(
    environment: scene.Environment, heights: Sequence[float], dt: float, end: float
) -> GustTable:
    """Gusts from 0 to the ``end`` [s] of a run whose stages are ``dt`` [s] apart, at the
    ``heights`` [m], of which the first is 10 m. Raises InputError if they would repeat."""
    gusts = environment.gusts
    wind = mean_wind(environment)
    if gusts is None or wind.hour_mean == 0.0:
        return NO_GUSTS
    check_span(gusts, end)
    waves = gust_components(gusts, wind, heights)
    lines = SpectralLines(waves.omega, waves.amplitude * np.exp(1j * waves.phase)[:, None])
    grid = time_grid(waves.spacing, lines.highest, 0.0, dt, end)
    values = np.zeros((grid.rows, len(heights)))
    add_sum(grid, lines, values)
    return GustTable(grid.start, grid.step, gusts.ramp, wind.speed_at(REFERENCE_HEIGHT), values)


def check_span(gusts: scene.Gusts, end: float) -> None:
    """Raises InputError if gusts repeat before the ``end`` [s] of a run."""
    if end > gusts.repeat_period + _LATE:
        raise InputError(
            f"environment.wind.gusts.repeat_period: {gusts.repeat_period:g} s is shorter than the"
            f" run, so that the gusts would repeat. Raise it to {end:g} s, the end of the run, or"
            " more."
        )


@kernel
def has_gusts(p):
    """True if there are gusts."""
    return p.values.shape[0] > 0


@kernel
def gust_at(t, column, p):
    """Speed [m/s] of the gusts of a ``column`` of the table at time t."""
    x = (t - p.start) / p.step
    row, points = rows_at(x, p.values.shape[0])
    speed = 0.0
    for m in range(points):
        speed += lagrange(x - row, m, points) * p.values[row + m, column]
    return rise(t, p.ramp) * speed
