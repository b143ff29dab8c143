"""Estimates of loads that a database lacks: between its headings, and outside its frequencies.

Between headings.

N headings evenly round the circle resolve the harmonics of the heading up to N / 2. Higher
harmonics are lost, and appear as lower ones (aliasing). Their size is estimated from the decay of
the last resolved harmonics. Beyond their argument Bessel functions decay as J_(n+2) / J_n ~ x^2 /
(4 (n + 1) (n + 2)). (A hull of length L has harmonics up to about k L / 2; Abramowitz and Stegun
1964, 9.3.1.)

On the shipped hulls with every second heading left out, the estimate is 0.7 to 1.4 times the true
loss, as long as that is below a half.

Estimate of the loads by waves outside the frequencies of a database; a run has no such loads.

The walls of a hull reflect short waves, which reach as deep as they are long. So loads fall as
w^-2, or faster if the hull has no walls: the pressure 2 rho g a e^(k z) adds up to 2 rho g a / k.

If the mean square over all headings falls like that at the end of the band, the mean square of the
waves above is known well enough for an estimate. The load of one wave of one heading is not: loads
of the ends and corners of a hull alternately add up and cancel.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from hydrosim.water.components import WaveComponents, energy_outside

if TYPE_CHECKING:
    from hydrosim.water.transfer import TransferFunctions

MIN_HEADINGS = 8  # fewest headings for an estimate
EVEN = 1e-6  # rad: largest difference of the spacing of headings
UNRESOLVED = 0.95  # largest ratio of harmonics: above it they do not decay
ARM = 1e-3  # m: moments below the forces times this arm are noise


def lost_between_headings(
    database: TransferFunctions, seas: Sequence[WaveComponents]
) -> tuple[float, float] | None:
    """Loss by interpolation between the headings, for the first-order forces and for the moments in
    the ``seas``: root mean squares over all headings, relative to those of the loads.

    None if the headings are not evenly spaced round the circle, or fewer than `MIN_HEADINGS`.
    """
    order = np.argsort(np.mod(database.heading, 2.0 * np.pi))
    angle = np.mod(database.heading, 2.0 * np.pi)[order]
    count = angle.size
    if count < MIN_HEADINGS or np.abs(np.diff(angle) - 2.0 * np.pi / count).max() > EVEN:
        return None
    X = database.excitation[:, order, :6]
    size, missed = (np.abs(X) ** 2).mean(axis=1), _interpolation_loss(X) ** 2
    weight = _energies_of_seas(database.frequency, seas)
    total, error = (np.sqrt((weight @ x).reshape(2, 3).sum(axis=1)) for x in (size, missed))
    if total[1] < ARM * total[0]:
        error[1] = 0.0
    forces, moments = np.divide(error, total, out=np.zeros(2), where=total > 0.0)
    return float(forces), float(moments)


def _interpolation_loss(X: np.ndarray) -> np.ndarray:
    """Root mean square (nw, n) over the headings of the loss of X (nw, N, n) between them."""
    last, count = X.shape[1] // 2, X.shape[1]
    power = np.abs(np.fft.fft(X, axis=1) / count) ** 2
    power = power + np.roll(power[:, ::-1], 1, axis=1)  # of n and -n together
    before, end = (np.sqrt(power[:, last - k] + power[:, last - k + 1]) for k in (4, 2))
    n = last - 3.5  # of the first two; even and odd ones may differ, so two at a time
    falling = (n + 1.0) * (n + 2.0) / ((n + 3.0) * (n + 4.0))
    ratio = np.minimum(falling * end / np.maximum(before, np.finfo(float).tiny), 1.0)
    beyond = end * ratio / np.sqrt(1.0 - np.minimum(ratio, UNRESOLVED) ** 2)
    most = np.sqrt((np.abs(X) ** 2).mean(axis=1))
    return np.asarray(np.sqrt(2.0) * np.minimum(beyond, most))


def _energies_of_seas(frequency: np.ndarray, seas: Sequence[WaveComponents]) -> np.ndarray:
    """Energy of the seas near each of the frequencies (nw,)."""
    middle = 0.5 * (frequency[1:] + frequency[:-1])
    energies = np.zeros(frequency.size)
    for waves in seas:
        inside = waves.omega <= frequency[-1]
        near = np.searchsorted(middle, waves.omega[inside])
        np.add.at(energies, near, waves.amplitude[inside] ** 2)
    return energies


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
