"""Tests whether mean and variance of a record change over its time.

The lowest cosine coefficients of a stationary series are independent and have equal variance, for
any memory, if the record is many memories long (Mueller 2007, Journal of Econometrics 141). A
steady trend appears in the first coefficient, other trends in the first few. Without a trend, their
mean square over that of the rest has Fisher's distribution. For the variance, the series is the
logarithm of the variance of short intervals, which is nearly normal.
"""

from __future__ import annotations

import numpy as np
import scipy

from hydrosim.statistics.series import binned, prediction_errors, slow_parts

TRENDS = (1, 3)  # coefficients
GUSTS = 12  # coefficients of the variance: groups of waves that vary slowly
BEGINNINGS = (8, 16, 32, 64)  # parts of the record, the first of which may be a transient
FEWEST = 10  # intervals of a beginning
ALIKE = 1e-9  # logarithms of variances: smaller differences are rounding
LARGER = 1e-5  # probability of a false alarm, for independent intervals
ALARM = 0.001  # probability of a false alarm, for each trend of mean and of variance
PARTS = 6  # of a memory: coefficients that are slow against it
STRETCH = 2  # memories
LITTLE = 0.05  # of the variance: less in an interval does not matter


def changes(x: np.ndarray, independent: float) -> tuple[bool, bool]:
    """Whether mean and variance of a record x (nt,) change; the record is so many times as long as
    its memory."""
    z = (x - x.mean()) / x.std()
    variance = _log_variances(z, independent)
    count = int(independent / PARTS)
    return _has_trend(z, count), _has_trend(variance, count) or _has_gusts(z, independent)


def begins_larger(x: np.ndarray, independent: float) -> bool:
    """Whether the variance of a record x (nt,) is larger at its beginning than later, as in a
    transient. The test is Student's, on logarithms of the variance of short intervals."""
    variance = _log_variances((x - x.mean()) / x.std(), independent)
    for part in BEGINNINGS:
        first = variance[: variance.size // part]
        if first.size < FEWEST or not np.ptp(first) > ALIKE:
            continue
        found = scipy.stats.ttest_ind(
            first, variance[first.size :], equal_var=False, alternative="greater"
        )
        if found.pvalue < LARGER:
            return True
    return False


def _log_variances(z: np.ndarray, independent: float) -> np.ndarray:
    """Logarithms of the variance of z (nt,) in short intervals."""
    stretches = max(int(independent / STRETCH), 1)
    variance = binned(z**2, stretches) / binned(np.ones(z.size), stretches)
    return np.asarray(np.log(variance + LITTLE))


def _has_trend(series: np.ndarray, count: int) -> bool:
    """Whether the first of the lowest coefficients of a series are larger than the rest."""
    squares = slow_parts(series - series.mean(), count) ** 2
    return any(_is_larger(squares[:first], squares[max(TRENDS) :]) for first in TRENDS)


def _has_gusts(z: np.ndarray, independent: float) -> bool:
    """Whether the size of waves varies slowly. The test compares more of the lowest coefficients
    with an equal number of others, for the variance of prediction errors, which scatters least."""
    errors, _ = prediction_errors(z)
    variance = _log_variances(errors / errors.std(), independent)
    squares = slow_parts(variance - variance.mean(), int(independent / PARTS)) ** 2
    return squares.size >= 2 * GUSTS and _is_larger(squares[:GUSTS], squares[GUSTS:])


def _is_larger(first: np.ndarray, rest: np.ndarray) -> bool:
    """Whether the mean of the first squares is larger than that of the rest, by Fisher's test."""
    if rest.size == 0:
        return False
    return bool(first.mean() > scipy.stats.f.isf(ALARM, first.size, rest.size) * rest.mean())
