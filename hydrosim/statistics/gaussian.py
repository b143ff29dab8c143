"""A record as a Gaussian process m + s z(t), clipped at its smallest value if it often stays there.

m and s maximise the likelihood of the values; clipped values count with the probability of being
below (Tobin 1958, Econometrica 26). Without clipping they are mean and standard deviation. The
value that is exceeded once on average is m + s u. The level u comes from
`hydrosim.statistics.crossings`, which uses the largest values of many windows.

Scores are derivatives of the log likelihood by m, s and the third and fourth Hermite moments. A
value contributes He_k(z), a clipped value -phi(z0) He_(k-1)(z0) / Phi(z0). The errors of the
parameters are the inverse information times the mean scores. The error of u follows from the
windows' mean of exp(-z^2 / 2), z being the largest value of each window. All errors are drawn
together, because both are high where waves are high. They give the uncertainty of the fit. They
also show whether third and fourth moments, zero for a Gaussian process, would move the extremes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.polynomial.hermite_e import hermevander
from scipy.special import log_ndtr, ndtr, ndtri, stdtrit

from hydrosim.statistics.crossings import Crossings, crossings
from hydrosim.statistics.gumbel import INTERVAL_ENDS, sliding_maxima
from hydrosim.statistics.series import scatter, slow_parts

HERMITE_ORDER = 4
MAX_FIT_ITERATIONS, FIT_TOLERANCE = 50, 1e-10  # of the search for m and s
INTEGRAL_LIMIT, INTEGRAL_NODES = 8.0, 801  # of integrals over z
# probability that the largest value of a Gaussian record is rejected, on each side
MAXIMUM_REJECTION = 1e-3
MOMENT_REJECTION = 0.01  # probability that a Gaussian record is rejected, for each moment


class Gaussian(NamedTuple):
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

    def confidence(self, ratio: float) -> np.ndarray:
        """Confidence interval (2,) of the `expected_maximum` value. If more groups were found than
        are possible, the interval is centred on the groups found, as far as possible."""
        u = self._level(ratio, np.exp(-1.0))
        found = self.mean + self.std * u
        whole = self._error(u)
        if not self.crossings.beyond > 0.0:
            return found + whole * np.array([-1.0, 1.0])
        size, beyond = self._error(u, counted=False), self.std * self.crossings.beyond / u
        return found + np.array([min(beyond - whole, -size), min(beyond + whole, size)])

    def prediction(self, ratio: float, ends: tuple[float, float] = INTERVAL_ENDS) -> np.ndarray:
        """Prediction interval (2,) of the largest value in ``ratio`` times the length; ``ends`` are
        the probabilities of its ends. The scatter of the largest value and the error of the fit are
        added in squares."""
        middle = self._level(ratio, 0.5)
        levels = [self._level(ratio, p) for p in ends]
        apart = [np.hypot(self.std * (u - middle), self._error(u, odds=ends[1])) for u in levels]
        return self.mean + self.std * middle + np.array([-apart[0], apart[1]])

    def doubtful(self) -> bool:
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

    def unlikely(self, largest: float) -> bool:
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
        found = np.zeros(HERMITE_ORDER)
        found[:order] = np.linalg.solve(self.information[:order, :order], shape)
        return found


def fit_gaussian(x: np.ndarray, independent: float, windows: int) -> Gaussian | None:
    """Fit to a record x (nt,) that is so many times as long as its memory; None if there is none.
    Values at the smallest value are clipped if there are several."""
    floor = x.min()
    clipped = x == floor
    if clipped.sum() == 1:
        floor, clipped = -np.inf, np.zeros(x.size, dtype=bool)
    mean, std = _initial_moments(x, clipped)
    for _ in range(MAX_FIT_ITERATIONS):
        edge = (floor - mean) / std
        scores, information = _scores((x - mean) / std, clipped, edge), _information(edge)
        step = np.linalg.solve(information[:2, :2], scores[:2].mean(axis=1))
        if np.abs(step).max() < FIT_TOLERANCE:
            draws = scatter(scores, independent)
            about = scores.mean(axis=1), draws, information
            return Gaussian(
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
    found = crossings(rate, (at - mean) / std, z, windows, x.size)
    slow = slow_parts(weight - 1.0, count)
    # a mean over sliding windows has less of the fast variation
    return found, moved, slow / np.sinc(0.5 * np.arange(1, slow.size + 1) / windows)


def _initial_moments(x: np.ndarray, clipped: np.ndarray) -> tuple[float, float]:
    """Estimate of mean and standard deviation from two quantiles of the values that are not
    clipped."""
    if not clipped.any():
        return float(x.mean()), float(x.std())
    probability = np.array([clipped.mean(), 0.5 * (1.0 + clipped.mean())])
    values, z = np.quantile(x, probability), ndtri(probability)
    std = float(np.ptp(values) / np.ptp(z))
    return float(values[0] - std * z[0]), std


def _scores(z: np.ndarray, clipped: np.ndarray, edge: float) -> np.ndarray:
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


def _information(edge: float) -> np.ndarray:
    """Mean products (4, 4) of the scores."""
    z = np.linspace(max(edge, -INTEGRAL_LIMIT), INTEGRAL_LIMIT, INTEGRAL_NODES)
    weight = np.exp(-0.5 * z**2) / np.sqrt(2.0 * np.pi) * (z[1] - z[0])
    weight[[0, -1]] *= 0.5
    scores, below = hermevander(z, HERMITE_ORDER)[:, 1:], _clipped_scores(edge)
    return np.asarray((scores.T * weight) @ scores + ndtr(edge) * np.outer(below, below))


def _root_mean_square(draws: np.ndarray) -> float:
    return float(np.sqrt(np.mean(draws**2)))
