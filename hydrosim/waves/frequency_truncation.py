"""Estimate of the loads by waves outside the frequencies of a database; a run has no such loads.

The walls of a hull reflect short waves, which reach as deep as they are long. So loads fall as
w^-2, or faster if the hull has no walls: the pressure 2 rho g a e^(k z) adds up to 2 rho g a / k.

If the mean square over all headings falls like that at the end of the band, the mean square of the
waves above is known well enough for an estimate. The load of one wave of one heading is not: loads
of the ends and corners of a hull alternately add up and cancel.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple, Protocol

import numpy as np

from hydrosim.waves.components import WaveComponents, energy_outside

BAND = 0.3  # part of the band, at its end, in which the decay of the loads is checked
MIN_FREQUENCIES = 4  # fewest frequencies there
FALL = -2.0  # power of the frequency with which loads fall
RISEN = 4.0  # largest growth of the mean square times w^4 from the first to the second half


class Loads(Protocol):
    """Data that this module reads of a database, see `transfer.TransferFunctions`."""

    def __hash__(self) -> int: ...
    @property
    def frequency(self) -> np.ndarray: ...
    @property
    def excitation(self) -> np.ndarray: ...


class Outside(NamedTuple):
    """Shares of the energy of a sea's ``waves`` below and above a database's frequencies, and share
    of the first-order ``loads`` above them. The latter is the larger of forces and moments, and
    None if loads do not decay as expected."""

    below: float
    above: float
    loads: float | None

    @property
    def share(self) -> float:
        """Share that is left out: loads above plus waves below, or else all waves."""
        return self.below + (self.above if self.loads is None else self.loads)


def shares_outside(database: Loads, seas: Sequence[WaveComponents]) -> Outside:
    """Shares of the ``seas`` outside the frequencies of the database; the last result is kept."""
    return _compute_shares(database, tuple(seas))


@lru_cache(maxsize=2)
def _compute_shares(database: Loads, seas: tuple[WaveComponents, ...]) -> Outside:
    energy = [float(np.sum(waves.amplitude**2)) for waves in seas]
    shares = [energy_outside(waves, database.frequency) for waves in seas]
    below, above = np.average(shares, axis=0, weights=energy)
    return Outside(float(below), float(above), _loads_above(database, seas))


def _loads_above(database: Loads, seas: Sequence[WaveComponents]) -> float | None:
    w, last = database.frequency, database.frequency[-1]
    size = _mean_squares(database)
    levelled = size * (w[:, None] / last) ** (-2.0 * FALL)
    first = (w > (1.0 - BAND) * last) & (w <= (1.0 - BAND / 2) * last)
    second = w > (1.0 - BAND / 2) * last
    if min(first.sum(), second.sum()) < MIN_FREQUENCIES // 2:
        return None
    level = levelled[second].mean(axis=0)
    if np.any(level > RISEN * levelled[first].mean(axis=0)):
        return None
    inside, beyond = np.zeros(2), np.zeros(2)
    for waves in seas:
        energy, above = waves.amplitude**2, waves.omega > last
        at = [np.interp(waves.omega[~above], w, column) for column in size.T]
        inside += np.array(at) @ energy[~above]
        beyond += level * np.sum(energy[above] * (waves.omega[above] / last) ** (2.0 * FALL))
    whole = inside + beyond
    return float(np.divide(beyond, whole, out=np.zeros(2), where=whole > 0.0).max())


def _mean_squares(database: Loads) -> np.ndarray:
    """Mean squares of forces and of moments (nw, 2), over all headings."""
    squares = np.mean(np.abs(database.excitation) ** 2, axis=1)
    return squares.reshape(len(squares), -1, 2, 3).sum(axis=(1, 3))
