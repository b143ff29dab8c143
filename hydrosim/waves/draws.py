"""Random draws for a wave train or for gusts: phases, amplitudes and directions. Each has a stream
of its own, so that none changes another."""

from __future__ import annotations

import numpy as np

from hydrosim.scene import DirectionalTable, Gusts, WaveTrain

GUSTS = 2**31
"""Stream of gusts: no wave train has this number."""
_PHASES, _AMPLITUDES, _DIRECTIONS = (), (1,), (2,)  # numpy's keys of streams within a train's


def phases(train: WaveTrain | Gusts, stream: int, count: int) -> np.ndarray:
    """Phases (count,) [rad], uniform in a turn."""
    return 2.0 * np.pi * _generator(train, stream, _PHASES).random(count)


def rayleigh_factors(train: WaveTrain | Gusts, stream: int, count: int) -> np.ndarray:
    """Factors (count,) with a Rayleigh distribution and mean square 1.

    With a uniform phase the real and imaginary parts of the complex amplitude are then independent
    and Gaussian, and so is the sea.
    """
    return np.sqrt(_generator(train, stream, _AMPLITUDES).standard_exponential(count))


def directions(train: WaveTrain, stream: int, omega: np.ndarray) -> np.ndarray:
    """Headings (n,) [rad] of the components at ``omega`` (n,) [rad/s], one draw for each."""
    if isinstance(train.spectrum, DirectionalTable):
        uniform = _generator(train, stream, _DIRECTIONS).random(omega.size)
        return _from_table(train.spectrum, omega, uniform)
    if train.spreading is None:
        return np.full(omega.size, train.heading)
    uniform = _generator(train, stream, _DIRECTIONS).random(omega.size)
    return train.heading + spreading_angles(uniform, train.spreading)


def spreading_angles(uniform: np.ndarray, exponent: float) -> np.ndarray:
    """Angles [rad] to the mean heading, from numbers ``uniform`` in 0 to 1. Their density is D ~
    cos^2s(angle / 2) over the whole turn (Longuet-Higgins, Cartwright and Smith 1963).

    The square of sin(angle / 2) has a beta distribution; the mean of cos(angle) is s / (s + 1).
    """
    from scipy.special import betaincinv  # slow to load, and few seas have spreading

    side = 2.0 * uniform - 1.0
    return 2.0 * np.sign(side) * np.arcsin(np.sqrt(betaincinv(0.5, exponent + 0.5, np.abs(side))))


def _from_table(table: DirectionalTable, omega: np.ndarray, uniform: np.ndarray) -> np.ndarray:
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


def _generator(train: WaveTrain | Gusts, stream: int, use: tuple[int, ...]) -> np.random.Generator:
    sequence = np.random.SeedSequence(train.seed, spawn_key=(stream, *use))
    return np.random.Generator(np.random.PCG64(sequence))
