"""Wave trains in four figures: height, peak period, mean direction and spreading.

The figures are those of the spectrum, not of one draw from it. Directions have the mean r exp(i b)
over the energy, of the heading b and the spreading sqrt(2 (1 - r)) [rad] (Kuik, van Vledder and
Holthuijsen 1988, J. Phys. Oceanogr. 18, eq. 29).
"""

from __future__ import annotations

from math import nan, pi, sqrt
from typing import NamedTuple, get_args

import numpy as np

from hydrosim.scene import (
    Density,
    DirectionalTable,
    Environment,
    WaveTrain,
    WhiteNoise,
)
from hydrosim.waves.components import WaveComponents, components, energy_outside
from hydrosim.waves.spectra import cut_off, density, energy, energy_above

PEAK_POINTS = 20_001
PEAK_WINDOW = 0.05
"""Part of a frequency on both sides of it, over which the energy of lines is averaged."""
MIN_RESULTANT = 0.05
"""Length of the mean of unit vectors along directions, below which they have no mean direction."""


class SeaState(NamedTuple):
    """Significant height [m], peak period [s], mean heading [rad] in 0 to 2 pi and spreading [rad].
    The period is NaN for a flat spectrum, the heading for waves from all around."""

    significant_height: float
    peak_period: float
    heading: float
    spreading: float


def sea_state(train: WaveTrain, environment: Environment) -> SeaState:
    """The figures of one wave train; `components` names the errors."""
    spectrum = train.spectrum
    if isinstance(spectrum, get_args(Density)):
        return _of_density(spectrum, train)
    waves = components(train, environment)
    squares = waves.amplitude**2 / 2.0
    resultant = np.sum(squares * np.exp(1j * waves.heading)) / (squares.sum() or 1.0)
    return _from_moments(float(squares.sum()), _peak_of_lines(waves), complex(resultant))


def energy_outside_band(
    train: WaveTrain, environment: Environment, low: float, high: float
) -> float:
    """Fraction of a train's energy below ``low`` and above ``high`` [rad/s]. Energy above the
    highest component of a random sea is not counted."""
    spectrum = train.spectrum
    if not isinstance(spectrum, get_args(Density)):
        return sum(energy_outside(components(train, environment), np.array([low, high])))
    total = energy(spectrum)
    end = cut_off(spectrum)
    if total == 0.0:
        return 0.0
    below = total - energy_above(spectrum, min(low, end))
    above = energy_above(spectrum, min(high, end)) - energy_above(spectrum, end)
    return (below + above) / total


def _of_density(spectrum: Density, train: WaveTrain) -> SeaState:
    omega = np.linspace(0.0, cut_off(spectrum), PEAK_POINTS)[1:]
    peak = omega[np.argmax(density(spectrum, omega))] if omega[-1] > 0.0 else 0.0
    period = nan if isinstance(spectrum, WhiteNoise) or peak == 0.0 else 2.0 * pi / float(peak)
    if isinstance(spectrum, DirectionalTable):
        return _from_moments(energy(spectrum), period, _resultant_of_table(spectrum))
    # the mean of cos(angle) over cos^2s(angle / 2) is s / (s + 1)
    length = 1.0 if train.spreading is None else train.spreading / (train.spreading + 1.0)
    return _from_moments(energy(spectrum), period, length * np.exp(1j * train.heading))


def _resultant_of_table(table: DirectionalTable) -> complex:
    """Mean of exp(i heading) over the energy, which is constant over the sector of a heading."""
    half_sector = (table.heading[1] - table.heading[0]) / 2.0
    weight = np.trapezoid(table.density, table.frequency, axis=0)
    total = np.sum(weight * np.exp(1j * table.heading)) * np.sin(half_sector) / half_sector
    return complex(total / (weight.sum() or 1.0))


def _from_moments(variance: float, period: float, resultant: complex) -> SeaState:
    length = min(abs(resultant), 1.0)
    heading = float(np.mod(np.angle(resultant), 2.0 * pi)) if length > MIN_RESULTANT else nan
    return SeaState(4.0 * sqrt(variance), period, heading, sqrt(2.0 * (1.0 - length)))


def _peak_of_lines(waves: WaveComponents) -> float:
    """Period [s] of the largest density of lines: their energy near a frequency over it, and the
    mean frequency of the lines there."""
    order = np.argsort(waves.omega)
    omega = waves.omega[order]
    power = waves.amplitude[order] ** 2
    if not power.any():
        return nan
    first = np.searchsorted(omega, omega * (1.0 - PEAK_WINDOW) * (1.0 - 1e-12))
    after = np.searchsorted(omega, omega * (1.0 + PEAK_WINDOW) * (1.0 + 1e-12), side="right")
    total = np.concatenate([[0.0], np.cumsum(power)])
    moment = np.concatenate([[0.0], np.cumsum(power * omega)])
    near = total[after] - total[first]
    best = int(np.argmax(near / omega))
    return float(2.0 * pi * near[best] / (moment[after] - moment[first])[best])
