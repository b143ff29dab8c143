"""Impacts on a Gaussian motion, and the law of their largest values.

An impact is a rise that the earlier motion does not predict. A linear prediction of a Gaussian
motion has normal errors (`prediction_errors`). Errors of `MIN_IMPACT_PREDICTION_ERROR` times their
scatter do not happen. The largest values after impacts come at random. Above some level they are
exponential (Davison and Smith 1990, Journal of the Royal Statistical Society B 52):

    times above v: n exp(-(v - level) / mean)

n has the error of a Poisson count, and the mean has the error of a mean of n exponential sizes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.special import ndtri

from hydrosim.statistics.gumbel import DRAWS, INTERVAL_ENDS
from hydrosim.statistics.peaks import exponential_misfit, peaks
from hydrosim.statistics.series import prediction_errors, upcrossings

MIN_IMPACT_PREDICTION_ERROR = 6.0  # times the usual error of a prediction
QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
# standard deviations: largest error of a quantile of a normal distribution
MAX_QUANTILE_ERROR = 0.15
WAVES_ABOVE = (100.0, 30.0, 10.0, 3.0, 1.0)  # of the motion: waves above the levels that are tried
COMPARED_CRESTS, MIN_IMPACT_CRESTS = 7, 3  # crests of a motion
MIN_IMPACTS, MAX_IMPACTS = 6, 20  # impacts of a law
MAX_IMPACT_MISFIT = 1.062
"""Largest `exponential_misfit` of a law: 10 % of exponential excesses exceed it."""
ONE_STD_PROBABILITY = 0.6827  # fraction of a normal distribution within one standard deviation


class ImpactPeaks(NamedTuple):
    """Largest values (n,) after the impacts on a motion, descending; the ``middle`` and ``std`` of
    the motion without them; its ``waves``; the number of its ``highest`` crests that are due to
    impacts."""

    values: np.ndarray
    middle: float
    std: float
    waves: int
    highest: int

    def has_highest_crests(self) -> bool:
        """Whether impacts cause the highest crests, more than by chance."""
        return self.highest >= MIN_IMPACT_CRESTS

    def level(self, above: float) -> float:
        """Level that so many waves of the motion alone exceed."""
        return float(self.middle + self.std * np.sqrt(2.0 * np.log(self.waves / above)))


class Impacts(NamedTuple):
    """Law of impacts: a ``number`` of values in the record exceed a ``level``, on average by
    ``mean``."""

    number: int
    level: float
    mean: float

    def expected_maximum(self, ratio: float) -> float:
        """Value that is exceeded once on average in ``ratio`` times the length."""
        return float(self.level + self.mean * np.log(self.number * ratio))

    def confidence(self, ratio: float) -> np.ndarray:
        """Confidence interval (2,) of the `expected_maximum` value."""
        means, counts, _ = self._draws()
        return np.asarray(np.quantile(self.level + means * np.log(counts * ratio), INTERVAL_ENDS))

    def prediction(self, ratio: float, ends: tuple[float, float] = INTERVAL_ENDS) -> np.ndarray:
        """Prediction interval (2,) of the largest value in ``ratio`` times the length; ``ends`` are
        the probabilities of its ends."""
        means, counts, largest = self._draws()
        values = self.level + means * (np.log(counts * ratio) + largest)
        return np.asarray(np.quantile(values, ends))

    def _draws(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Draws (`DRAWS`,) of mean and count, and of a largest value by Gumbel's law."""
        random = np.random.default_rng(self.number)
        means = self.mean * self.number / random.gamma(self.number, size=DRAWS)
        counts = random.gamma(self.number + 0.5, size=DRAWS)
        return means, counts, random.gumbel(size=DRAWS)


def find_impacts(x: np.ndarray) -> ImpactPeaks | None:
    """Upward impacts in a record (nt,); None if there are none, or if the rest is no Gaussian
    motion."""
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
    std = float(np.quantile(np.abs(x - middle), ONE_STD_PROBABILITY))
    lowest = np.sort(peaks(x))[-COMPARED_CRESTS]
    highest = np.count_nonzero(values >= lowest)
    return ImpactPeaks(np.sort(values)[::-1], middle, std, waves, int(highest))


def fit_impacts(hits: ImpactPeaks) -> Impacts | None:
    """Law of the largest impacts, above the lowest level from which it is exponential; None if too
    few exceed it."""
    for above in WAVES_ABOVE:
        level = hits.level(above)
        values = hits.values[hits.values > level]
        if values.size > MAX_IMPACTS:
            level = float(values[MAX_IMPACTS])
            values = values[:MAX_IMPACTS]
        if values.size < MIN_IMPACTS:
            return None
        if exponential_misfit(values - level) < MAX_IMPACT_MISFIT:
            return Impacts(values.size, level, float(np.mean(values) - level))
    return None


def _is_nearly_normal(x: np.ndarray) -> bool:
    """Whether the inner quantiles of a record are those of a normal distribution."""
    quantiles = np.quantile(x, QUANTILES)
    normal = ndtri(QUANTILES)
    spread = (quantiles[3] - quantiles[1]) / (normal[3] - normal[1])
    off = np.abs(quantiles - quantiles[2] - spread * normal).max()
    return bool(off < MAX_QUANTILE_ERROR * spread)


def _find_events(z: np.ndarray, period: float) -> list[tuple[int, int]]:
    """First and last index of each unpredicted rise of z (nt,). A ``period`` is a number of steps.
    Rises within half a period belong to the same impact, also at its end."""
    errors, stride = prediction_errors(z)
    usual = np.median(np.abs(errors)) / ndtri(0.75)
    found = np.flatnonzero(np.abs(errors) > MIN_IMPACT_PREDICTION_ERROR * usual)
    if found.size == 0:
        return []
    apart = np.flatnonzero(np.diff(found) > 0.5 * period / stride) + 1
    groups = np.split(found, apart)
    upwards = [group for group in groups if errors[group[0]] > 0.0]
    return [(stride * int(group[0]), stride * int(group[-1])) for group in upwards]
