"""Seas as sums of Airy waves."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hydrosim.errors import InputError
from hydrosim.scene import (
    Amplitudes,
    Density,
    Environment,
    GivenComponents,
    RecordedElevation,
    RegularWave,
    Tma,
    WaveTrain,
)
from hydrosim.waves import draws
from hydrosim.waves.dispersion import wavenumber
from hydrosim.waves.spectra import cut_off, density, width

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
            one = np.array([amplitude]), np.array([phase]), np.array([train.heading])
            return _airy(train, environment, 0.0, omega, *one)
        case GivenComponents() as given:
            spacing, omega = _on_grid(given.omega, 2.0 * np.pi / train.repeat_period)
            lines = given.amplitude, given.phase, given.heading
            return _airy(train, environment, spacing, omega, *lines)
        case RecordedElevation() as record:
            return _recorded_components(record, train, environment)
        case spectrum:
            return _random(spectrum, train, environment, stream)


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


def _airy(
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


def _random(
    spectrum: Density, train: WaveTrain, environment: Environment, stream: int
) -> WaveComponents:
    _check_depth(spectrum, environment)
    spacing = _spacing(spectrum, train.repeat_period)
    omega = spacing * np.arange(1, int(cut_off(spectrum) / spacing) + 1)
    amplitude = np.sqrt(2.0 * density(spectrum, omega) * spacing)
    if train.amplitudes == Amplitudes.RAYLEIGH:
        amplitude *= draws.rayleigh_factors(train, stream, omega.size)
    phase = draws.phases(train, stream, omega.size)
    heading = draws.directions(train, stream, omega)
    return _airy(train, environment, spacing, omega, amplitude, phase, heading)


def _check_depth(spectrum: Density, environment: Environment) -> None:
    if isinstance(spectrum, Tma) and spectrum.water_depth != environment.water_depth:
        raise InputError(
            f"environment.waves: found a TMA spectrum of {spectrum.water_depth:g} m of water;"
            f" expected that of the environment, {environment.water_depth:g} m"
        )


def _spacing(spectrum: Density, repeat_period: float) -> float:
    longest = 2.0 * np.pi / width(spectrum)
    shortest = _PEAK_PERIODS * longest
    if repeat_period < shortest * (1.0 - 1e-9):
        raise InputError(
            f"environment.waves.repeat_period: {repeat_period:g} s gives too few components for a"
            f" peak period, or a narrow band, of {longest:g} s. Raise it to {shortest:g} s or more."
        )
    return 2.0 * np.pi / repeat_period


def _on_grid(omega: np.ndarray, spacing: float) -> tuple[float, np.ndarray]:
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
    kept = omega <= record.highest_frequency
    omega = omega[kept]
    lines = lines[kept]
    heading = np.full(omega.size, train.heading)
    phase = np.angle(lines) - omega * record.time[0]
    there = _airy(train, environment, spacing, omega, np.abs(lines), phase, heading)
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
