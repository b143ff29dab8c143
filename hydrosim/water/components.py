"""Seas as sums of Airy waves: random draws, components, and figures of wave trains.

Wave trains in four figures: height, peak period, mean direction and spreading.

The figures are those of the spectrum, not of one draw from it. Directions have the mean r exp(i b)
over the energy, of the heading b and the spreading sqrt(2 (1 - r)) [rad] (Kuik, van Vledder and
Holthuijsen 1988, J. Phys. Oceanogr. 18, eq. 29).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import nan, pi, sqrt
from typing import NamedTuple, get_args

import numpy as np

from hydrosim.errors import InputError
from hydrosim.scene import (
    Amplitudes,
    Density,
    DirectionalTable,
    Environment,
    GivenComponents,
    Gusts,
    RecordedElevation,
    RegularWave,
    Tma,
    WaveTrain,
    WhiteNoise,
)
from hydrosim.water.spectra import (
    cut_off,
    density,
    energy,
    energy_above,
    resolution_frequency,
    wavenumber,
)

# Random draws for waves or gusts, each of a stream of its own, so that none changes another.

GUSTS = 2**31
"""Stream of gusts: no wave train has this number."""
_PHASES, _AMPLITUDES, _DIRECTIONS = (), (1,), (2,)  # numpy's keys of streams within a train's


def phases(train: WaveTrain | Gusts, stream: int, count: int) -> np.ndarray:
    """Phases (count,) [rad], uniform in a turn."""
    return 2.0 * np.pi * _random_generator(train, stream, _PHASES).random(count)


def rayleigh_factors(train: WaveTrain | Gusts, stream: int, count: int) -> np.ndarray:
    """Factors (count,) with a Rayleigh distribution and mean square 1.

    With a uniform phase the real and imaginary parts of the complex amplitude are then independent
    and Gaussian, and so is the sea.
    """
    return np.sqrt(_random_generator(train, stream, _AMPLITUDES).standard_exponential(count))


def directions(train: WaveTrain, stream: int, omega: np.ndarray) -> np.ndarray:
    """Headings (n,) [rad] of the components at ``omega`` (n,) [rad/s], one draw for each."""
    if isinstance(train.spectrum, DirectionalTable):
        uniform = _random_generator(train, stream, _DIRECTIONS).random(omega.size)
        return _headings_of_table(train.spectrum, omega, uniform)
    if train.spreading is None:
        return np.full(omega.size, train.heading)
    uniform = _random_generator(train, stream, _DIRECTIONS).random(omega.size)
    return train.heading + spreading_angles(uniform, train.spreading)


def spreading_angles(uniform: np.ndarray, exponent: float) -> np.ndarray:
    """Angles [rad] to the mean heading, from numbers ``uniform`` in 0 to 1. Their density is D ~
    cos^2s(angle / 2) over the whole turn (Longuet-Higgins, Cartwright and Smith 1963).

    The square of sin(angle / 2) has a beta distribution; the mean of cos(angle) is s / (s + 1).
    """
    from scipy.special import betaincinv  # slow to load, and few seas have spreading

    side = 2.0 * uniform - 1.0
    return 2.0 * np.sign(side) * np.arcsin(np.sqrt(betaincinv(0.5, exponent + 0.5, np.abs(side))))


def _headings_of_table(
    table: DirectionalTable, omega: np.ndarray, uniform: np.ndarray
) -> np.ndarray:
    """Headings with the density of a table, constant over the sector around each of its
    headings."""
    after = np.clip(np.searchsorted(table.frequency, omega), 1, table.frequency.size - 1)
    low, high = table.frequency[after - 1], table.frequency[after]
    part = np.clip((omega - low) / (high - low), 0.0, 1.0)[:, None]
    share = (1.0 - part) * table.density[after - 1] + part * table.density[after]
    until = np.cumsum(share, axis=1)
    wanted = uniform * until[:, -1]
    sector = np.minimum(np.sum(until <= wanted[:, None], axis=1), table.heading.size - 1)
    rows = np.arange(omega.size)
    size = np.where(share[rows, sector] > 0.0, share[rows, sector], 1.0)
    into = 0.5 - (until[rows, sector] - wanted) / size
    return table.heading[sector] + into * (table.heading[1] - table.heading[0])


def _random_generator(
    train: WaveTrain | Gusts, stream: int, use: tuple[int, ...]
) -> np.random.Generator:
    sequence = np.random.SeedSequence(train.seed, spawn_key=(stream, *use))
    return np.random.Generator(np.random.PCG64(sequence))


_PEAK_PERIODS = 20.0  # fewest components in a repeat period: the energy is then right to 0.1 %
_UNEVEN = 1e-3  # of a record's step: tolerance of equal spacing
_ROUNDED = 0.05  # of a time, if that is within the rounding of single precision
_LATE = 1e-6  # s: the end of a run may be this much later than the end of the waves
_MULTIPLE = 1e-9  # relative distance of a frequency from a multiple below which they are equal


@dataclass(frozen=True, eq=False)
class WaveComponents:
    """Airy waves that grow together: eta = ramp(t) sum a cos(w t - k (x cos b + y sin b) + e).

    ``omega`` [rad/s], ``amplitude`` [m], ``phase`` [rad], ``wavenumber`` [1/m] and ``heading`` b
    [rad] are (n,), in any order; ``ramp`` [s]. On a grid all frequencies are multiples of the
    ``spacing`` [rad/s] and may repeat; off the grid the spacing is 0.
    """

    omega: np.ndarray
    amplitude: np.ndarray
    phase: np.ndarray
    wavenumber: np.ndarray
    heading: np.ndarray
    ramp: float
    spacing: float

    @property
    def index(self) -> np.ndarray:
        """Frequencies as multiples of the spacing, (n,)."""
        return np.rint(self.omega / self.spacing).astype(np.int64)

    def amplitudes_at(self, x: float, y: float) -> np.ndarray:
        """Complex amplitudes (n,) [m] at a point: the elevation there is Re sum at e^(i w t)."""
        along = x * np.cos(self.heading) + y * np.sin(self.heading)
        return self.amplitude * np.exp(1j * (self.phase - self.wavenumber * along))


def sea(environment: Environment) -> tuple[WaveComponents, ...]:
    """The components of all wave trains of the environment with non-zero energy, with independent
    phases.

    Trains of the same ramp and the same spacing form one set. Only the waves of one set load a body
    together, at their difference and sum frequencies.
    """
    together: dict[tuple[float, float], list[WaveComponents]] = {}
    for stream, train in enumerate(environment.waves):
        waves = components(train, environment, stream)
        if np.any(waves.amplitude**2):  # squares of less than 1e-162 m are zero
            together.setdefault((waves.ramp, waves.spacing), []).append(waves)
    return tuple(_join_components(sets) for sets in together.values())


def _join_components(sets: list[WaveComponents]) -> WaveComponents:
    def concatenate_field(name: str) -> np.ndarray:
        return np.concatenate([getattr(waves, name) for waves in sets])

    arrays = (
        concatenate_field("omega"),
        concatenate_field("amplitude"),
        concatenate_field("phase"),
        concatenate_field("wavenumber"),
    )
    return WaveComponents(*arrays, concatenate_field("heading"), sets[0].ramp, sets[0].spacing)


def components(train: WaveTrain, environment: Environment, stream: int = 0) -> WaveComponents:
    """The components of one wave train; ``stream`` distinguishes trains of the same seed.

    The components of a random sea lie at multiples of dw = 2 pi / repeat_period up to
    `spectra.cut_off`. Amplitudes are sqrt(2 S dw), or Rayleigh distributed about that; phases and
    directions are random. They are drawn in the order of the multiples, each from its own stream.
    So the sea depends on seed, stream, spectrum and repeat_period alone.

    Given components lie on that grid if all are multiples. The components of a record lie at
    multiples of 2 pi / its length. Raises InputError if the repeat period is too short for the
    spectrum, or if a record is not equally spaced.
    """
    match train.spectrum:
        case RegularWave(amplitude, period, phase):
            omega = np.array([2.0 * np.pi / period])
            single = np.array([amplitude]), np.array([phase]), np.array([train.heading])
            return _airy_components(train, environment, 0.0, omega, *single)
        case GivenComponents() as given:
            spacing, omega = _multiples_of_spacing(given.omega, 2.0 * np.pi / train.repeat_period)
            lines = given.amplitude, given.phase, given.heading
            return _airy_components(train, environment, spacing, omega, *lines)
        case RecordedElevation() as record:
            return _recorded_components(record, train, environment)
        case spectrum:
            return _random_components(spectrum, train, environment, stream)


def check_span(environment: Environment, start: float, end: float) -> None:
    """Raises InputError if a random sea repeats in a run from ``start`` to ``end`` [s], or a record
    does not cover the run."""
    for train in environment.waves:
        match train.spectrum:
            case RegularWave() | GivenComponents():
                continue
            case RecordedElevation(time):
                if start < time[0] - _LATE or end > time[-1] + _LATE:
                    raise InputError(
                        "environment.waves: found an elevation file with times from"
                        f" {time[0]:g} to {time[-1]:g} s; expected times that cover the whole"
                        f" run, from {start:g} to {end:g} s. Shorten the run, or give a longer"
                        " file."
                    )
            case _ if end > train.repeat_period + _LATE:
                raise InputError(
                    f"environment.waves.repeat_period: {train.repeat_period:g} s is shorter than"
                    f" the run, so that the sea would repeat itself. Raise it to {end:g} s, the end"
                    " of the run, or more."
                )


def energy_outside(waves: WaveComponents, frequency: np.ndarray) -> tuple[float, float]:
    """Fractions of the components' energy below and above a database's frequencies [rad/s]."""
    energy = waves.amplitude**2
    total = energy.sum() or 1.0
    below = energy[waves.omega < frequency.min()].sum() / total
    above = energy[waves.omega > frequency.max()].sum() / total
    return float(below), float(above)


def _airy_components(
    train: WaveTrain,
    environment: Environment,
    spacing: float,
    omega: np.ndarray,
    amplitude: np.ndarray,
    phase: np.ndarray,
    heading: np.ndarray,
) -> WaveComponents:
    k = wavenumber(omega, environment.water_depth, environment.gravity)
    return WaveComponents(omega, amplitude, phase, k, heading, train.ramp, spacing)


def _random_components(
    spectrum: Density, train: WaveTrain, environment: Environment, stream: int
) -> WaveComponents:
    _check_depth(spectrum, environment)
    spacing = _frequency_spacing(spectrum, train.repeat_period)
    omega = spacing * np.arange(1, int(cut_off(spectrum) / spacing) + 1)
    amplitude = np.sqrt(2.0 * density(spectrum, omega) * spacing)
    if train.amplitudes == Amplitudes.RAYLEIGH:
        amplitude *= rayleigh_factors(train, stream, omega.size)
    phase = phases(train, stream, omega.size)
    heading = directions(train, stream, omega)
    return _airy_components(train, environment, spacing, omega, amplitude, phase, heading)


def _check_depth(spectrum: Density, environment: Environment) -> None:
    if isinstance(spectrum, Tma) and spectrum.water_depth != environment.water_depth:
        raise InputError(
            f"environment.waves: found a TMA spectrum of {spectrum.water_depth:g} m of water;"
            f" expected that of the environment, {environment.water_depth:g} m"
        )


def _frequency_spacing(spectrum: Density, repeat_period: float) -> float:
    longest = 2.0 * np.pi / resolution_frequency(spectrum)
    shortest = _PEAK_PERIODS * longest
    if repeat_period < shortest * (1.0 - 1e-9):
        raise InputError(
            f"environment.waves.repeat_period: {repeat_period:g} s gives too few components for a"
            f" peak period, or a narrow band, of {longest:g} s. Raise it to {shortest:g} s or more."
        )
    return 2.0 * np.pi / repeat_period


def _multiples_of_spacing(omega: np.ndarray, spacing: float) -> tuple[float, np.ndarray]:
    """Spacing and multiples of it, if all frequencies are multiples; else 0 and the frequencies."""
    index = np.rint(omega / spacing)
    if np.all(np.abs(omega - index * spacing) <= _MULTIPLE * omega):
        return spacing, index * spacing
    return 0.0, omega


def _recorded_components(
    record: RecordedElevation, train: WaveTrain, environment: Environment
) -> WaveComponents:
    """Fourier series of a record; it reproduces the record at its place and times."""
    count = record.time.size
    step = _even_step(record.time)
    spacing = 2.0 * np.pi / (count * step)
    lines = np.fft.rfft(record.elevation)[1:] / count
    lines[: (count - 1) // 2] *= 2.0  # all but that of two values a period
    omega = spacing * np.arange(1, lines.size + 1)
    is_below_limit = omega <= record.highest_frequency
    omega = omega[is_below_limit]
    lines = lines[is_below_limit]
    heading = np.full(omega.size, train.heading)
    phase = np.angle(lines) - omega * record.time[0]
    there = _airy_components(train, environment, spacing, omega, np.abs(lines), phase, heading)
    x, y = record.position
    along = x * np.cos(train.heading) + y * np.sin(train.heading)
    return replace(there, phase=phase + there.wavenumber * along)


def _even_step(time: np.ndarray) -> float:
    step = (time[-1] - time[0]) / (time.size - 1)
    late = np.abs(time - time[0] - step * np.arange(time.size)).max()
    rounding = np.finfo(np.float32).eps * np.abs(time).max()
    if not late <= max(_UNEVEN * step, min(rounding, _ROUNDED * step)):
        raise InputError(
            f"environment.waves: found times in the recorded elevation that are up to {late:.3g} s"
            f" off from steps of {step:.6g} s; expected equal steps; interpolate it first"
        )
    return float(step)


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
        return _sea_state_of_density(spectrum, train)
    waves = components(train, environment)
    squares = waves.amplitude**2 / 2.0
    resultant = np.sum(squares * np.exp(1j * waves.heading)) / (squares.sum() or 1.0)
    return _sea_state_of_moments(float(squares.sum()), _peak_of_lines(waves), complex(resultant))


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


def _sea_state_of_density(spectrum: Density, train: WaveTrain) -> SeaState:
    omega = np.linspace(0.0, cut_off(spectrum), PEAK_POINTS)[1:]
    peak = omega[np.argmax(density(spectrum, omega))] if omega[-1] > 0.0 else 0.0
    period = nan if isinstance(spectrum, WhiteNoise) or peak == 0.0 else 2.0 * pi / float(peak)
    if isinstance(spectrum, DirectionalTable):
        return _sea_state_of_moments(energy(spectrum), period, _resultant_of_table(spectrum))
    # the mean of cos(angle) over cos^2s(angle / 2) is s / (s + 1)
    length = 1.0 if train.spreading is None else train.spreading / (train.spreading + 1.0)
    return _sea_state_of_moments(energy(spectrum), period, length * np.exp(1j * train.heading))


def _resultant_of_table(table: DirectionalTable) -> complex:
    """Mean of exp(i heading) over the energy, which is constant over the sector of a heading."""
    half_sector = (table.heading[1] - table.heading[0]) / 2.0
    weight = np.trapezoid(table.density, table.frequency, axis=0)
    total = np.sum(weight * np.exp(1j * table.heading)) * np.sin(half_sector) / half_sector
    return complex(total / (weight.sum() or 1.0))


def _sea_state_of_moments(variance: float, period: float, resultant: complex) -> SeaState:
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
