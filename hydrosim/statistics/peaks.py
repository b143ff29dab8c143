"""Peaks of a record (the largest value of each wave above the mean), and their Weibull law.

    P(peak <= x) = 1 - exp(-(x / scale)^shape)

The shape is 2 if peaks follow Rayleigh's law, as in a narrow-banded Gaussian record
(Longuet-Higgins 1952). It is smaller if large peaks are more frequent.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.statistics.series import upcrossings

MIN_PEAKS = 3  # peaks
LEVEL_COUNT, MIN_CROSSINGS = 40, 20  # number of levels above the mean; crossings of a used level
MIN_LOG_FALL = 0.3  # of the logarithm of a rate: lower levels are among small waves
# over the root of crossings: shapes of lower and upper levels scatter by less
SHAPE_DIFFERENCE = 4.0
NEWTON_ITERATIONS, NEWTON_TOLERANCE = 50, 1e-12  # of Newton's method
MIN_PROBABILITY = 1e-12  # least probability that is told from zero and one


class Weibull(NamedTuple):
    """Weibull law of peaks; NaN if there are too few, or all are equal."""

    shape: float
    scale: float


class Tail(NamedTuple):
    """A record rises above a level ``waves`` exp(-((level - origin) / scale)^shape) times. The
    shape is 2 for a Gaussian process about its mean, for any bandwidth. ``crossings`` is the number
    of upcrossings behind the shape."""

    origin: float
    shape: float
    scale: float
    waves: int
    crossings: int

    def exceedances(self, level: float) -> float:
        """Expected number of upcrossings of a level."""
        return float(self.waves * np.exp(-(((level - self.origin) / self.scale) ** self.shape)))


def peaks(x: np.ndarray) -> np.ndarray:
    """Largest values (n,) above the mean between successive upcrossings of it."""
    z = x - x.mean()
    first = np.ceil(upcrossings(z)).astype(int)
    return np.maximum.reduceat(z, first)[:-1] if first.size > 1 else np.zeros(0)


class _UpcrossingDecrease(NamedTuple):
    """Decrease of the logarithm of upcrossings, ``fallen``, at some levels, and the number of
    crossings of each."""

    levels: np.ndarray
    fallen: np.ndarray
    counts: np.ndarray

    def halves(self) -> tuple[_UpcrossingDecrease, _UpcrossingDecrease]:
        """The lower and the upper levels."""
        parts = [np.array_split(each, 2) for each in self]
        lower, upper = zip(*parts, strict=True)
        return _UpcrossingDecrease(*lower), _UpcrossingDecrease(*upper)

    def fits(self) -> bool:
        """Whether there are enough levels for a shape."""
        return self.levels.size >= MIN_PEAKS and float(np.ptp(self.fallen)) > 0.0

    def fit(self) -> tuple[float, float]:
        """Shape and scale of the tail."""
        weight = self.fallen * np.sqrt(self.counts)
        shape, offset = np.polyfit(np.log(self.levels), np.log(self.fallen), 1, w=weight)
        return float(shape), float(np.exp(-offset / shape))

    def tail(self, origin: float, waves: int) -> Tail:
        """Tail by all of these levels; NaN if they are too few."""
        shape, scale = self.fit() if self.fits() else (np.nan, np.nan)
        return Tail(origin, shape, scale, waves, waves)


def fit_tail(x: np.ndarray, origin: float) -> Tail:
    """Tail of a record x (nt,) above an origin, from its upcrossings of often crossed levels; NaN
    if these are too few."""
    falls, waves = _falls(x, origin)
    return falls.tail(origin, waves)


def fit_upper_tail(x: np.ndarray, origin: float) -> Tail:
    """`fit_tail`, but by the upper half of the levels if the shape is larger there than at the
    lower ones, repeatedly."""
    falls, waves = _falls(x, origin)
    tail = falls.tail(origin, waves)
    while True:
        lower, falls = falls.halves()
        if not (lower.fits() and falls.fits()):
            return tail
        shape, scale = falls.fit()
        crossings = int(falls.counts[0])
        if shape - lower.fit()[0] < SHAPE_DIFFERENCE * shape / np.sqrt(crossings):
            return tail
        tail = Tail(origin, shape, scale, waves, crossings)


def _falls(x: np.ndarray, origin: float) -> tuple[_UpcrossingDecrease, int]:
    """Often crossed levels above an origin, and the number of crossings of the origin."""
    z = x - origin
    levels = z.max() * np.arange(1, LEVEL_COUNT) / LEVEL_COUNT
    counts = np.array([np.count_nonzero((z[:-1] < u) & (z[1:] >= u)) for u in (0.0, *levels)])
    fallen = np.log(counts[0] / np.maximum(counts[1:], 1))
    used = (counts[1:] >= MIN_CROSSINGS) & (fallen > MIN_LOG_FALL)
    return _UpcrossingDecrease(levels[used], fallen[used], counts[1:][used]), int(counts[0])


def exponential_misfit(excesses: np.ndarray) -> float:
    """Anderson's and Darling's statistic of ``excesses`` (n,) over an exponential distribution of
    their mean (Stephens 1974, Journal of the American Statistical Association 69)."""
    count = excesses.size
    below = -np.expm1(-np.sort(excesses) / excesses.mean())
    statistic = anderson_darling(np.clip(below, MIN_PROBABILITY, 1.0 - MIN_PROBABILITY))
    return statistic * (1.0 + 0.6 / count)


def anderson_darling(below: np.ndarray) -> float:
    """Anderson's and Darling's statistic of values whose rising probabilities ``below`` (n,) by a
    law are above 0 and below 1."""
    count = below.size
    weight = 2.0 * np.arange(1, count + 1) - 1.0
    return float(-count - np.mean(weight * (np.log(below) + np.log1p(-below[::-1]))))


def fit_weibull(heights: np.ndarray) -> Weibull:
    """Maximum likelihood law of ``heights`` (n,) above zero. The shape k is the zero of sum(x^k log
    x) / sum(x^k) - 1 / k - mean(log x)."""
    if heights.size < MIN_PEAKS or not np.ptp(heights) > NEWTON_TOLERANCE * heights.max():
        return Weibull(np.nan, np.nan)
    top = float(heights.max())
    log = np.log(heights / top)
    k = float(np.pi / (np.sqrt(6.0) * log.std()))
    for _ in range(NEWTON_ITERATIONS):
        weight = np.exp(k * log)
        first, second = (np.average(log**n, weights=weight) for n in (1, 2))
        step = (first - 1.0 / k - log.mean()) / (second - first**2 + 1.0 / k**2)
        k = max(k - step, 0.2 * k)
        if abs(step) < NEWTON_TOLERANCE * k:
            break
    return Weibull(k, float(top * np.exp(k * log).mean() ** (1.0 / k)))
