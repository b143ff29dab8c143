"""Impacts on a Gaussian motion, and the law of their largest values.

An impact is a rise that the motion before it does not foretell. A Gaussian motion is foretold by a
linear prediction, and what that is off scatters normally (`prediction_errors`): `BEYOND` times its
scatter does not happen. The largest values that impacts lead to come at random, and are exponential
above some level, as sizes are that go on with one mean (Davison and Smith 1990, Journal of the
Royal Statistical Society B 52):

    times above v: n exp(-(v - level) / mean)

n has the error of a Poisson count, the mean that of n exponential sizes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.special import ndtri

from hydrosim.statistics.gumbel import DRAWS, ENDS
from hydrosim.statistics.peaks import peaks
from hydrosim.statistics.series import prediction_errors, upcrossings

BEYOND = 6.0  # times the usual error of a prediction
QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
ABNORMAL = 0.15  # standard deviations that a quantile of a normal distribution is not off
WAVES_ABOVE = (100.0, 30.0, 10.0, 3.0, 1.0)  # of the motion, above levels that are tried
HIGHEST, LEADING = 7, 3  # crests of a motion
FEWEST, MOST = 6, 20  # impacts of a law
EXPONENTIAL = 1.062  # of Anderson's and Darling's test: 10 % are beyond (Stephens 1974)
CERTAIN = 1e-12
ONE_STD = 0.6827  # of a normal distribution is within one standard deviation of its mean


class Hits(NamedTuple):
    """The largest values (n,) that impacts of a motion lead to, falling; the ``middle`` and ``std``
    of the motion without them, its ``waves``, and how many of its ``highest`` crests are theirs."""

    values: np.ndarray
    middle: float
    std: float
    waves: int
    highest: int

    def lead(self) -> bool:
        """Whether the highest crests are of impacts, and not by chance."""
        return self.highest >= LEADING

    def level(self, above: float) -> float:
        """The level that so many waves of the motion alone are above."""
        return float(self.middle + self.std * np.sqrt(2.0 * np.log(self.waves / above)))


class Impacts(NamedTuple):
    """A ``number`` of impacts of a record lead above a ``level``, by this ``mean``."""

    number: int
    level: float
    mean: float

    def expected(self, ratio: float) -> float:
        """The value that is exceeded once on average in ``ratio`` times the length."""
        return float(self.level + self.mean * np.log(self.number * ratio))

    def confidence(self, ratio: float) -> np.ndarray:
        """Interval (2,) that holds the true `expected` value."""
        means, counts, _ = self._draws()
        return np.asarray(np.quantile(self.level + means * np.log(counts * ratio), ENDS))

    def prediction(self, ratio: float, ends: tuple[float, float] = ENDS) -> np.ndarray:
        """Interval (2,) whose ``ends`` have these probabilities to be above the largest value in
        ``ratio`` times the length."""
        means, counts, largest = self._draws()
        values = self.level + means * (np.log(counts * ratio) + largest)
        return np.asarray(np.quantile(values, ends))

    def _draws(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """What mean and count (`DRAWS`,) may be, and largest values of Gumbel's law."""
        random = np.random.default_rng(self.number)
        means = self.mean * self.number / random.gamma(self.number, size=DRAWS)
        counts = random.gamma(self.number + 0.5, size=DRAWS)
        return means, counts, random.gumbel(size=DRAWS)


def find_impacts(x: np.ndarray) -> Hits | None:
    """The impacts upwards in a record (nt,); None if there are none, or if what else there is is no
    Gaussian motion."""
    middle = float(np.median(x))
    if not _is_nearly_normal(x):
        return None
    waves = upcrossings(x - middle).size
    period = x.size / waves
    events = _find_events(x - middle, period)
    if not events:
        return None
    after = int(0.5 * period)
    values = [x[max(first - 1, 0) : last + after].max() for first, last in events]
    std = float(np.quantile(np.abs(x - middle), ONE_STD))
    lowest = np.sort(peaks(x))[-HIGHEST]
    highest = np.count_nonzero(values >= lowest)
    return Hits(np.sort(values)[::-1], middle, std, waves, int(highest))


def fit_impacts(hits: Hits) -> Impacts | None:
    """The law of the largest impacts, from the lowest level on from which it is exponential; None
    where too few are above it."""
    for above in WAVES_ABOVE:
        level = hits.level(above)
        values = hits.values[hits.values > level]
        if values.size > MOST:
            level = float(values[MOST])
            values = values[:MOST]
        if values.size < FEWEST:
            return None
        if _are_exponential(values - level):
            return Impacts(values.size, level, float(np.mean(values) - level))
    return None


def _is_nearly_normal(x: np.ndarray) -> bool:
    """Whether quantiles of a record are those of a normal distribution, its tails left out."""
    quantiles = np.quantile(x, QUANTILES)
    normal = ndtri(QUANTILES)
    spread = (quantiles[3] - quantiles[1]) / (normal[3] - normal[1])
    off = np.abs(quantiles - quantiles[2] - spread * normal).max()
    return bool(off < ABNORMAL * spread)


def _find_events(z: np.ndarray, period: float) -> list[tuple[int, int]]:
    """First and last index of each rise of z (nt,) that is not foretold; a ``period`` is a number
    of steps. What follows within half of it is of the same impact, also its end."""
    errors, stride = prediction_errors(z)
    usual = np.median(np.abs(errors)) / ndtri(0.75)
    found = np.flatnonzero(np.abs(errors) > BEYOND * usual)
    if found.size == 0:
        return []
    apart = np.flatnonzero(np.diff(found) > 0.5 * period / stride) + 1
    groups = np.split(found, apart)
    upwards = [group for group in groups if errors[group[0]] > 0.0]
    return [(stride * int(group[0]), stride * int(group[-1])) for group in upwards]


def _are_exponential(excesses: np.ndarray) -> bool:
    """Whether ``excesses`` (n,) may be of an exponential distribution, by the test of Anderson and
    Darling (Stephens 1974, Journal of the American Statistical Association 69)."""
    count = excesses.size
    below = -np.expm1(-np.sort(excesses) / excesses.mean())
    below = np.clip(below, CERTAIN, 1.0 - CERTAIN)
    weight = 2.0 * np.arange(1, count + 1) - 1.0
    statistic = -count - np.mean(weight * (np.log(below) + np.log1p(-below[::-1])))
    return bool(statistic * (1.0 + 0.6 / count) < EXPONENTIAL)
