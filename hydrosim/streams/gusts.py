"""Gusts along the mean wind, as sums of components.

    u(z, t) = ramp(t) sum_k sqrt(2 S_k(z)) cos(2 pi k t / T + e_k)

T: repeat period; S_k: variance of the spectrum between (k - 1/2) / T and (k + 1/2) / T, within the
band; e_k: random phases, which all heights share. So the components do not depend on the duration,
and their phases do not depend on those of waves with the same seed. A seed gives one series for
each spectrum, band and repeat period.

The series is a table on the solver's stage grid, as wave loads are (`hydrosim.waves.loads`): exact
at its nodes, and with 6 points between them. There its error is below 1.2e-6 of the amplitude at
the highest frequency, and falls with the sixth power of the frequency.

Limits: the gusts have the direction of the mean wind. They are coherent: one body, and all bodies,
feel them at the same instant.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hydrosim.errors import InputError
from hydrosim.jit.kernels import kernel
from hydrosim.scene import Amplitudes, Environment, Gusts
from hydrosim.streams.spectra import density
from hydrosim.streams.wind import REFERENCE_HEIGHT, MeanWind, mean_wind
from hydrosim.waves import draws
from hydrosim.waves.loads import lagrange, rise, rows_at
from hydrosim.waves.synthesis import SpectralLines, add_sum, time_grid

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
    gusts: Gusts, wind: MeanWind, heights: Sequence[float] = (REFERENCE_HEIGHT,)
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
    power = np.array([_power(gusts, number, spacing, z, wind) for z in heights]).T
    amplitude = np.sqrt(2.0 * power)
    if gusts.amplitudes == Amplitudes.RAYLEIGH:
        amplitude *= draws.rayleigh_factors(gusts, draws.GUSTS, number.size)[:, None]
    phase = draws.phases(gusts, draws.GUSTS, number.size)
    turn = 2.0 * np.pi * spacing
    return GustComponents(turn, turn * number, amplitude, phase)


def gust_band(gusts: Gusts) -> tuple[float, float]:
    """Lowest and highest frequency [Hz]."""
    return gusts.lowest / (2.0 * np.pi), gusts.highest / (2.0 * np.pi)


def _power(
    gusts: Gusts, number: np.ndarray, spacing: float, height: float, wind: MeanWind
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
    environment: Environment, heights: Sequence[float], dt: float, end: float
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


def check_span(gusts: Gusts, end: float) -> None:
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
