"""A wave train as a sum of Airy waves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrosim.errors import InputError
from hydrosim.scene import Environment, Jonswap, WaveTrain
from hydrosim.waves.dispersion import wavenumber
from hydrosim.waves.loads import rise
from hydrosim.waves.spectra import cut_off, density

_PEAK_PERIODS = 20.0  # in a repeat period at least: the energy is then right to 0.1 %


@dataclass(frozen=True, eq=False)
class Components:
    """Airy waves that grow together: eta = ramp(t) sum a cos(w t - k (x cos b + y sin b) + e).

    ``omega`` [rad/s], ``amplitude`` [m], ``phase`` [rad], ``wavenumber`` [1/m] and ``heading``
    b [rad] are (n,), in any order; ``ramp`` [s]. On a grid all frequencies are multiples of the
    ``spacing`` [rad/s], each any number of times; off the grid the spacing is 0.
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
        """The multiples of the spacing that the frequencies are, (n,)."""
        return np.rint(self.omega / self.spacing).astype(np.int64)

    def at(self, x: float, y: float) -> np.ndarray:
        """Complex amplitudes (n,) [m] at a point: the elevation there is Re sum at e^(i w t)."""
        along = x * np.cos(self.heading) + y * np.sin(self.heading)
        return self.amplitude * np.exp(1j * (self.phase - self.wavenumber * along))


def sea(environment: Environment) -> tuple[Components, ...]:
    """The components of all wave trains of the environment, with independent phases.

    Trains of the same ramp and the same spacing are one set; only the waves of one set load a body
    together, at their difference and sum frequencies.
    """
    together: dict[tuple[float, float], list[Components]] = {}
    for stream, train in enumerate(environment.waves):
        waves = components(train, environment, stream)
        together.setdefault((waves.ramp, waves.spacing), []).append(waves)
    return tuple(_joined(sets) for sets in together.values())


def _joined(sets: list[Components]) -> Components:
    def every(name: str) -> np.ndarray:
        return np.concatenate([getattr(waves, name) for waves in sets])

    arrays = (every("omega"), every("amplitude"), every("phase"), every("wavenumber"))
    return Components(*arrays, every("heading"), sets[0].ramp, sets[0].spacing)


def components(train: WaveTrain, environment: Environment, stream: int = 0) -> Components:
    """The components of one wave train; ``stream`` tells trains of the same seed apart.

    An irregular sea has deterministic amplitudes sqrt(2 S dw) at multiples of dw = 2 pi /
    repeat_period up to `spectra.cut_off`, and random phases. The phases are drawn in the order of
    the multiples, so that the sea depends on seed, stream, spectrum and repeat_period alone.
    Raises InputError if the repeat period is too short for the spectrum.
    """
    spectrum = train.spectrum
    if isinstance(spectrum, Jonswap):
        spacing = _spacing(spectrum, train.repeat_period)
        omega = spacing * np.arange(1, int(cut_off(spectrum) / spacing) + 1)
        amplitude = np.sqrt(2.0 * density(spectrum, omega) * spacing)
        phase = _random_phases(train.seed, stream, omega.size)
    else:
        spacing, omega = 0.0, np.array([2.0 * np.pi / spectrum.period])
        amplitude, phase = np.array([spectrum.amplitude]), np.array([spectrum.phase])
    k = wavenumber(omega, environment.water_depth, environment.gravity)
    heading = np.full(omega.size, train.heading)
    return Components(omega, amplitude, phase, k, heading, train.ramp, spacing)


def elevation_at(waves: Components, x: float, y: float, time: np.ndarray) -> np.ndarray:
    """Elevation (nt,) [m] at a point, at ``time`` (nt,) [s], by direct summation."""
    amplitude = waves.at(x, y)
    total = [np.sum(amplitude * np.exp(1j * waves.omega * t)).real for t in time]
    return np.array([rise(t, waves.ramp) for t in time]) * total


def energy_outside(waves: Components, frequency: np.ndarray) -> tuple[float, float]:
    """Fractions of the components' energy below and above a database's frequencies [rad/s]."""
    energy = waves.amplitude**2
    below = energy[waves.omega < frequency.min()].sum() / energy.sum()
    above = energy[waves.omega > frequency.max()].sum() / energy.sum()
    return float(below), float(above)


def _spacing(spectrum: Jonswap, repeat_period: float) -> float:
    shortest = _PEAK_PERIODS * spectrum.peak_period
    if repeat_period < shortest:
        raise InputError(
            f"environment.waves.repeat_period: {repeat_period:g} s gives too few components for a"
            f" peak period of {spectrum.peak_period:g} s; raise it to {shortest:g} s or more"
        )
    return 2.0 * np.pi / repeat_period


def _random_phases(seed: int, stream: int, count: int) -> np.ndarray:
    sequence = np.random.SeedSequence(seed, spawn_key=(stream,))
    return 2.0 * np.pi * np.random.Generator(np.random.PCG64(sequence)).random(count)
