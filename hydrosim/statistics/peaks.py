"""Peaks of a record, the largest value of each wave above the mean, and Weibull's law of them.

    P(peak <= x) = 1 - exp(-(x / scale)^shape)

The shape is 2 where peaks have Rayleigh's law, as those of a narrow-banded Gaussian record have
(Longuet-Higgins 1952), and less where large ones are more frequent.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.statistics.series import upcrossings

FEWEST = 3  # peaks
LEVELS, MANY = 40, 20  # above the mean; crossings
NEAR = 0.3  # of the logarithm of a rate: lower levels are in the midst of small waves
ROUNDS, CLOSE = 50, 1e-12  # of Newton's method


class Weibull(NamedTuple):
    """A law of peaks; NaN where there are too few, or all are alike."""

    shape: float
    scale: float


class Tail(NamedTuple):
    """A record rises above a level ``waves`` exp(-((level - origin) / scale)^shape) times. The
    shape is 2 of a Gaussian process about its mean, however broad its band."""

    origin: float
    shape: float
    scale: float
    waves: int

    def exceedances(self, level: float) -> float:
        """How often the record is expected to rise above a level."""
        return float(self.waves * np.exp(-(((level - self.origin) / self.scale) ** self.shape)))


def peaks(x: np.ndarray) -> np.ndarray:
    """The largest value (n,) above the mean between each two upcrossings of it."""
    z = x - x.mean()
    first = np.ceil(upcrossings(z)).astype(int)
    return np.maximum.reduceat(z, first)[:-1] if first.size > 1 else np.zeros(0)


def fit_tail(x: np.ndarray, origin: float) -> Tail:
    """The tail of a record x (nt,) above an origin, by its upcrossings of those levels that it
    crosses often; of not a number where these are too few."""
    z = x - origin
    levels = z.max() * np.arange(1, LEVELS) / LEVELS
    counts = np.array([np.count_nonzero((z[:-1] < u) & (z[1:] >= u)) for u in (0.0, *levels)])
    fall = np.log(counts[0] / np.maximum(counts[1:], 1))
    used = (counts[1:] >= MANY) & (fall > NEAR)
    if np.count_nonzero(used) < FEWEST:
        return Tail(origin, np.nan, np.nan, int(counts[0]))
    weight = (fall * np.sqrt(counts[1:]))[used]
    shape, offset = np.polyfit(np.log(levels[used]), np.log(fall[used]), 1, w=weight)
    return Tail(origin, float(shape), float(np.exp(-offset / shape)), int(counts[0]))


def fit_weibull(heights: np.ndarray) -> Weibull:
    """The law of greatest likelihood of ``heights`` (n,) above zero: the shape k is the zero of
    sum(x^k log x) / sum(x^k) - 1 / k - mean(log x)."""
    if heights.size < FEWEST or not np.ptp(heights) > CLOSE * heights.max():
        return Weibull(np.nan, np.nan)
    top = float(heights.max())
    log = np.log(heights / top)
    k = float(np.pi / (np.sqrt(6.0) * log.std()))
    for _ in range(ROUNDS):
        weight = np.exp(k * log)
        first, second = (np.average(log**n, weights=weight) for n in (1, 2))
        step = (first - 1.0 / k - log.mean()) / (second - first**2 + 1.0 / k**2)
        k = max(k - step, 0.2 * k)
        if abs(step) < CLOSE * k:
            break
    return Weibull(k, float(top * np.exp(k * log).mean() ** (1.0 / k)))
