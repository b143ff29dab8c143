"""Gaussian processes: fit to a record, crossings of levels, impacts, probability to stay in limits.

A record is m + s z(t), clipped at its smallest value if it often stays there.

m and s maximise the likelihood of the values; clipped values count with the probability of being
below (Tobin 1958, Econometrica 26). Without clipping they are mean and standard deviation. The
value that is exceeded once on average is m + s u. The level u comes from the largest values of many
windows (`crossings`).

Scores are derivatives of the log likelihood by m, s and the third and fourth Hermite moments. A
value contributes He_k(z), a clipped value -phi(z0) He_(k-1)(z0) / Phi(z0). The errors of the
parameters are the inverse information times the mean scores. The error of u follows from the
windows' mean of exp(-z^2 / 2), z being the largest value of each window. All errors are drawn
together, because both are high where waves are high. They give the uncertainty of the fit. They
also show whether third and fourth moments, zero for a Gaussian process, would move the extremes.

Upcrossings of a level by a sampled Gaussian process, and the number of their groups.

Values have unit variance. The probability that a value is above u and its predecessor below is

    p(u) = 2 T(u, a),     a = sqrt((1 - r) / (1 + r)),     r the correlation of neighbours

T is Owen's function (1956, Annals of Mathematical Statistics 27). For short steps this is Rice's
rate, a / pi exp(-u^2 / 2). Values above u come in groups. The narrower the band and the lower the
level, the fewer the groups. Groups come at random, and their number is a fraction

    g(u) = 1 - exp(-k u)     (Vanmarcke 1975, Journal of Applied Mechanics 42)

of the upcrossings. The largest of n values is below u with probability exp(-n p g). For short times
this is multiplied by 1 - exp(-u^2 / 2), the probability that the envelope begins below u. The
factor k follows from this law and the largest values of many windows.

Impacts on a Gaussian motion, and the law of their largest values.

An impact is a rise that the earlier motion does not predict. A linear prediction of a Gaussian
motion has normal errors (`prediction_errors`). Errors of `MIN_IMPACT_PREDICTION_ERROR` times their
scatter do not happen. The largest values after impacts come at random. Above some level they are
exponential (Davison and Smith 1990, Journal of the Royal Statistical Society B 52):

    times above v: n exp(-(v - level) / mean)

n has the error of a Poisson count, and the mean has the error of a mean of n exponential sizes.

Probability that a Gaussian motion of known spectrum stays within limits.

A motion has the spectral moments m0, m1, m2. In a time T it rises n = T / (2 pi) sqrt(m2 / m0)
times above its mean, and n exp(-u^2 / 2) times above a level of u standard deviations. These
upcrossings come in groups while the envelope is above the level. The envelope rises above it sqrt(2
pi) q u times as often, with q^2 = 1 - m1^2 / (m0 m2) (Cramer and Leadbetter 1967, Stationary and
Related Stochastic Processes). With Vanmarcke's groups (1975, Journal of Applied Mechanics 42) the
motion stays within its limits with the probability

    p = b exp(-g / b),     g = c (1 - exp(-e / c)),     b = 1 - exp(-u^2 / 2),

c is the mean number of crossings of any limit. e is the mean number of upcrossings of the nearest
limit u by the envelope. Statistics of runs count groups in the same way (`crossings`), from the
record instead of the spectrum. Levels are at most 0.5 % low, and 3.5 % high for a narrow band such
as a roll of 1 % damping.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, expm1, log, pi, sqrt
from typing import NamedTuple

import numpy as np
import scipy
from numpy.polynomial.hermite_e import hermevander
from scipy.special import log_ndtr, ndtr, ndtri, owens_t, stdtrit

from hydrosim.statistics.gumbel import DRAWS, INTERVAL_ENDS, sliding_maxima
from hydrosim.statistics.series import (
    exponential_misfit,
    peaks,
    prediction_errors,
    scatter,
    slow_parts,
    upcrossings,
)

MIN_LEVEL = 0.5  # lower bound of levels
GROUP_FRACTION_RANGE = (0.01, 0.99)  # bounds of the fraction of groups
MAX_STEEPNESS = 1e3  # of a: neighbours are uncorrelated
MAX_LEVEL_ITERATIONS, LEVEL_TOLERANCE = 50, 1e-12  # of a fixed-point iteration on logarithms


class Crossings(NamedTuple):
    """A process of so many ``values``, with a as ``steepness`` and k as ``grouping``. ``beyond`` is
    the logarithm of the ratio of the groups found to the groups that are possible; zero within
    bounds."""

    values: float
    steepness: float
    grouping: float
    beyond: float

    def groups(self, u: float) -> float:
        """Mean number of groups above u."""
        u = max(u, MIN_LEVEL)
        share = -np.expm1(-self.grouping * u)
        return float(self.values * 2.0 * owens_t(u, self.steepness) * share)

    def level(self, exceeded: float) -> float:
        """Level u that so many groups exceed on average; at least zero."""
        u, before = MIN_LEVEL, 0.0
        for _ in range(MAX_LEVEL_ITERATIONS):
            if abs(u - before) < LEVEL_TOLERANCE:
                break
            rate = self.groups(u) * np.exp(0.5 * max(u, MIN_LEVEL) ** 2)
            u, before = float(np.sqrt(2.0 * max(np.log(rate / exceeded), 0.0))), u
        return u


def crossings(rate: float, at: float, peaks: np.ndarray, windows: int, values: int) -> Crossings:
    """How a process crosses levels. It rises above the level ``at`` >= 0 at the ``rate`` per
    sample, counted over so many samples, ``values``. Of the ``windows`` of time, n had a peak above
    it: ``peaks`` (n,)."""
    steepness = _steepness_at(rate, at)
    u = np.sqrt(max(-2.0 * np.log(np.exp(-0.5 * peaks**2).mean()), MIN_LEVEL**2))
    begins = -np.log(-np.expm1(-0.5 * u**2))
    share = (1.0 - begins) * windows / (values * 2.0 * owens_t(u, steepness))
    possible = np.clip(share, *GROUP_FRACTION_RANGE)
    beyond = np.log(max(share, GROUP_FRACTION_RANGE[0]) / possible)
    return Crossings(float(values), steepness, float(-np.log1p(-possible) / u), float(beyond))


def _steepness_at(rate: float, at: float) -> float:
    """The a for which a process rises above a level at this rate."""
    if not 2.0 * owens_t(at, MAX_STEEPNESS) > rate:
        return MAX_STEEPNESS
    return float(
        scipy.optimize.brentq(lambda a: 2.0 * owens_t(at, a) - rate, 0.0, MAX_STEEPNESS, rtol=1e-12)
    )


HERMITE_ORDER = 4
MAX_FIT_ITERATIONS, FIT_TOLERANCE = 50, 1e-10  # of the search for m and s
INTEGRAL_LIMIT, INTEGRAL_NODES = 8.0, 801  # of integrals over z
# probability that the largest value of a Gaussian record is rejected, on each side
MAXIMUM_REJECTION = 1e-3
MOMENT_REJECTION = 0.01  # probability that a Gaussian record is rejected, for each moment


class GaussianFit(NamedTuple):
    """A fit to a record: ``mean`` and ``std``; the mean ``scores`` (4,) and draws (4, k) of their
    ``scatter``; the ``information`` (4, 4). ``crossings`` are the upcrossings of levels, and
    ``moved`` (2,) is their change with mean and std. ``counted`` (k,) are draws of the scatter of
    the group count."""

    mean: float
    std: float
    scores: np.ndarray
    scatter: np.ndarray
    information: np.ndarray
    crossings: Crossings
    moved: np.ndarray
    counted: np.ndarray

    def expected_maximum(self, ratio: float) -> float:
        """Value that is exceeded once on average in ``ratio`` times the length."""
        return self.mean + self.std * self._level(ratio, np.exp(-1.0))

    def confidence_interval(self, ratio: float) -> np.ndarray:
        """Confidence interval (2,) of the `expected_maximum` value. If more groups were found than
        are possible, the interval is centred on the groups found, as far as possible."""
        u = self._level(ratio, np.exp(-1.0))
        bounds = self.mean + self.std * u
        whole = self._error(u)
        if not self.crossings.beyond > 0.0:
            return bounds + whole * np.array([-1.0, 1.0])
        size, beyond = self._error(u, counted=False), self.std * self.crossings.beyond / u
        return bounds + np.array([min(beyond - whole, -size), min(beyond + whole, size)])

    def prediction_interval(
        self, ratio: float, ends: tuple[float, float] = INTERVAL_ENDS
    ) -> np.ndarray:
        """Prediction interval (2,) of the largest value in ``ratio`` times the length; ``ends`` are
        the probabilities of its ends. The scatter of the largest value and the error of the fit are
        added in squares."""
        middle = self._level(ratio, 0.5)
        levels = [self._level(ratio, p) for p in ends]
        apart = [np.hypot(self.std * (u - middle), self._error(u, odds=ends[1])) for u in levels]
        return self.mean + self.std * middle + np.array([-apart[0], apart[1]])

    def is_doubtful(self) -> bool:
        """Whether the third or fourth moment is not that of a Gaussian record, and would change the
        largest value."""
        u = self._level(1.0, np.exp(-1.0))
        usual = self._weights(u, 2)
        odds = stdtrit(self.scatter.shape[1], 1.0 - 0.5 * MOMENT_REJECTION)
        for order in range(3, HERMITE_ORDER + 1):
            moved = self._weights(u, order) - usual
            if abs(moved @ self.scores) > odds * _root_mean_square(moved @ self.scatter):
                return True
        return False

    def is_unlikely(self, largest: float) -> bool:
        """Whether the largest value is so far from its expectation that a Gaussian record is
        rejected."""
        u = (largest - self.mean) / self.std
        exceeded = self.crossings.groups(u)
        return bool(exceeded < MAXIMUM_REJECTION or exceeded > -np.log(MAXIMUM_REJECTION))

    def _level(self, ratio: float, probability: float) -> float:
        """Level u below which the largest value is with a probability."""
        return self.crossings.level(-np.log(probability) / ratio)

    def _error(self, u: float, counted: bool = True, odds: float = INTERVAL_ENDS[1]) -> float:
        """Distance of m + s u from the end of its interval that has the probability ``odds``.
        Without ``counted``, from the errors of m and s alone."""
        shape = np.array([1.0, u])
        off = np.zeros(self.counted.size)
        if counted and u > 0.0:
            shape, off = shape - self.moved / u, self.counted / u
        weights = np.linalg.solve(self.information[:2, :2], shape)
        draws = weights @ self.scatter[:2, : off.size] - off
        return float(stdtrit(draws.size, odds)) * self.std * _root_mean_square(draws)

    def _weights(self, u: float, order: int) -> np.ndarray:
        """Derivative of the value at u with respect to the mean scores (4,), if so many parameters
        are free."""
        shape = hermevander(u, HERMITE_ORDER - 1)[0, :order]
        weights = np.zeros(HERMITE_ORDER)
        weights[:order] = np.linalg.solve(self.information[:order, :order], shape)
        return weights


def fit_gaussian(x: np.ndarray, independent: float, windows: int) -> GaussianFit | None:
    """Fit to a record x (nt,) that is so many times as long as its memory; None if there is none.
    Values at the smallest value are clipped if there are several."""
    floor = x.min()
    clipped = x == floor
    if clipped.sum() == 1:
        floor, clipped = -np.inf, np.zeros(x.size, dtype=bool)
    mean, std = _initial_moments(x, clipped)
    for _ in range(MAX_FIT_ITERATIONS):
        edge = (floor - mean) / std
        scores, information = (
            _score_functions((x - mean) / std, clipped, edge),
            _fisher_information(edge),
        )
        step = np.linalg.solve(information[:2, :2], scores[:2].mean(axis=1))
        if np.abs(step).max() < FIT_TOLERANCE:
            draws = scatter(scores, independent)
            about = scores.mean(axis=1), draws, information
            return GaussianFit(
                mean, std, *about, *_group_statistics(x, mean, std, windows, draws.shape[1])
            )
        mean, std = mean + std * float(step[0]), std * (1.0 + float(np.clip(step[1], -0.5, 1.0)))
    return None


def _group_statistics(
    x: np.ndarray, mean: float, std: float, windows: int, count: int
) -> tuple[Crossings, np.ndarray, np.ndarray]:
    """Crossings of a record from the largest values of its windows, their derivatives, and draws of
    their scatter."""
    at = max(float(x.min()), mean)  # level above which upcrossings are visible
    rate = np.count_nonzero((x[:-1] <= at) & (x[1:] > at)) / x.size
    z = (sliding_maxima(x, windows) - mean) / std
    weight = np.exp(-0.5 * z**2)
    weight /= weight.mean()
    moved = np.array([(weight * z).mean(), (weight * z**2).mean()])
    group_crossings = crossings(rate, (at - mean) / std, z, windows, x.size)
    slow = slow_parts(weight - 1.0, count)
    # a mean over sliding windows has less of the fast variation
    return group_crossings, moved, slow / np.sinc(0.5 * np.arange(1, slow.size + 1) / windows)


def _initial_moments(x: np.ndarray, clipped: np.ndarray) -> tuple[float, float]:
    """Estimate of mean and standard deviation from two quantiles of the values that are not
    clipped."""
    if not clipped.any():
        return float(x.mean()), float(x.std())
    probability = np.array([clipped.mean(), 0.5 * (1.0 + clipped.mean())])
    values, z = np.quantile(x, probability), ndtri(probability)
    std = float(np.ptp(values) / np.ptp(z))
    return float(values[0] - std * z[0]), std


def _score_functions(z: np.ndarray, clipped: np.ndarray, edge: float) -> np.ndarray:
    """Scores (4, nt) of values z (nt,), some of which are ``clipped`` at the edge."""
    scores = np.ascontiguousarray(hermevander(z, HERMITE_ORDER)[:, 1:].T)
    scores[:, clipped] = _clipped_scores(edge)[:, None]
    return scores


def _clipped_scores(edge: float) -> np.ndarray:
    """Scores (4,) of a value that is clipped at the edge."""
    if np.isinf(edge):
        return np.zeros(HERMITE_ORDER)
    hazard = np.exp(-0.5 * edge**2 - log_ndtr(edge)) / np.sqrt(2.0 * np.pi)
    return np.asarray(-hazard * hermevander(edge, HERMITE_ORDER - 1)[0])


def _fisher_information(edge: float) -> np.ndarray:
    """Mean products (4, 4) of the scores."""
    z = np.linspace(max(edge, -INTEGRAL_LIMIT), INTEGRAL_LIMIT, INTEGRAL_NODES)
    weight = np.exp(-0.5 * z**2) / np.sqrt(2.0 * np.pi) * (z[1] - z[0])
    weight[[0, -1]] *= 0.5
    scores, below = hermevander(z, HERMITE_ORDER)[:, 1:], _clipped_scores(edge)
    return np.asarray((scores.T * weight) @ scores + ndtr(edge) * np.outer(below, below))


def _root_mean_square(draws: np.ndarray) -> float:
    return float(np.sqrt(np.mean(draws**2)))


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

    def confidence_interval(self, ratio: float) -> np.ndarray:
        """Confidence interval (2,) of the `expected_maximum` value."""
        means, counts, _ = self._draws()
        return np.asarray(np.quantile(self.level + means * np.log(counts * ratio), INTERVAL_ENDS))

    def prediction_interval(
        self, ratio: float, ends: tuple[float, float] = INTERVAL_ENDS
    ) -> np.ndarray:
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
    few exceed it, or if the record has fewer waves than the lowest level needs."""
    if hits.waves < WAVES_ABOVE[0]:
        return None
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
    impacts = np.flatnonzero(np.abs(errors) > MIN_IMPACT_PREDICTION_ERROR * usual)
    if impacts.size == 0:
        return []
    apart = np.flatnonzero(np.diff(impacts) > 0.5 * period / stride) + 1
    groups = np.split(impacts, apart)
    upwards = [group for group in groups if errors[group[0]] > 0.0]
    return [(stride * int(group[0]), stride * int(group[-1])) for group in upwards]


LEVEL_RANGE = (1e-2, 1e2)  # standard deviations between which a level is searched


class Excursions(NamedTuple):
    """A Gaussian motion of unit variance: mean number of ``waves`` in the time, and the
    ``broadness`` q of its band, 0 for a regular motion."""

    waves: float
    broadness: float

    def log_inside(self, levels: Sequence[float]) -> float:
        """Logarithm of the probability that the motion stays within its ``levels``: at most one
        above its mean and one below."""
        nearest = min(levels)
        crossings = sum(exp(0.5 * (nearest**2 - level**2)) for level in levels)
        envelope = sqrt(2.0 * pi) * self.broadness * nearest
        groups = -crossings * expm1(-envelope / crossings)
        begins_inside = -expm1(-0.5 * nearest**2)
        left = self.waves * exp(-0.5 * nearest**2) * groups
        return log(begins_inside) - left / begins_inside

    def level(self, probability: float) -> float:
        """Level that the motion stays below with a ``probability``."""

        def excess(level: float) -> float:
            return self.log_inside([level]) - log(probability)

        return float(scipy.optimize.brentq(excess, *LEVEL_RANGE, xtol=1e-12))


def find_excursions(m0: float, m1: float, m2: float, duration: float) -> Excursions:
    """Excursions of a motion with these spectral moments (m0 and m2 above zero), in a ``duration``
    [s]."""
    waves = duration * sqrt(m2 / m0) / (2.0 * pi)
    broadness = sqrt(max(1.0 - m1**2 / (m0 * m2), 0.0))
    return Excursions(max(waves, 1.0), broadness)
