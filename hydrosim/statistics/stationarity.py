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

from hydrosim.statistics.series import bin_sums, prediction_errors, slow_parts

TREND_COEFFICIENTS = (1, 3)  # coefficients
GUST_COEFFICIENTS = 12  # coefficients of the variance: groups of waves that vary slowly
BEGINNING_PARTS = (8, 16, 32, 64)  # parts of the record, the first of which may be a transient
MIN_INTERVALS = 10  # intervals of a beginning
LOG_VARIANCE_ROUNDING = 1e-9  # logarithms of variances: smaller differences are rounding
TRANSIENT_ALARM = 1e-5  # probability of a false alarm, for independent intervals
TREND_ALARM = 0.001  # probability of a false alarm, for each trend of mean and of variance
COEFFICIENT_MEMORIES = 6  # of a memory: coefficients that are slow against it
INTERVAL_MEMORIES = 2  # memories
VARIANCE_FLOOR = 0.05  # of the variance: less in an interval does not matter


def changes_of_moments(x: np.ndarray, independent: float) -> tuple[bool, bool]:
    """Whether mean and variance of a record x (nt,) change; the record is so many times as long as
    its memory."""
    z = (x - x.mean()) / x.std()
    variance = _log_variances(z, independent)
    count = int(independent / COEFFICIENT_MEMORIES)
    return _has_trend(z, count), _has_trend(variance, count) or _has_gusts(z, independent)


def has_initial_transient(x: np.ndarray, independent: float) -> bool:
    """Whether the variance of a record x (nt,) is larger at its beginning than later, as in a
    transient. The test is Student's, on logarithms of the variance of short intervals."""
    variance = _log_variances((x - x.mean()) / x.std(), independent)
    for part in BEGINNING_PARTS:
        first = variance[: variance.size // part]
        if first.size < MIN_INTERVALS or not np.ptp(first) > LOG_VARIANCE_ROUNDING:
            continue
        found = scipy.stats.ttest_ind(
            first, variance[first.size :], equal_var=False, alternative="greater"
        )
        if found.pvalue < TRANSIENT_ALARM:
            return True
    return False


def _log_variances(z: np.ndarray, independent: float) -> np.ndarray:
    """Logarithms of the variance of z (nt,) in short intervals."""
    stretches = max(int(independent / INTERVAL_MEMORIES), 1)
    variance = bin_sums(z**2, stretches) / bin_sums(np.ones(z.size), stretches)
    return np.asarray(np.log(variance + VARIANCE_FLOOR))


def _has_trend(series: np.ndarray, count: int) -> bool:
    """Whether the first of the lowest coefficients of a series are larger than the rest."""
    squares = slow_parts(series - series.mean(), count) ** 2
    return any(
        _is_larger(squares[:first], squares[max(TREND_COEFFICIENTS) :])
        for first in TREND_COEFFICIENTS
    )


def _has_gusts(z: np.ndarray, independent: float) -> bool:
    """Whether the size of waves varies slowly. The test compares more of the lowest coefficients
    with an equal number of others, for the variance of prediction errors, which scatters least."""
    errors, _ = prediction_errors(z)
    variance = _log_variances(errors / errors.std(), independent)
    squares = slow_parts(variance - variance.mean(), int(independent / COEFFICIENT_MEMORIES)) ** 2
    return squares.size >= 2 * GUST_COEFFICIENTS and _is_larger(
        squares[:GUST_COEFFICIENTS], squares[GUST_COEFFICIENTS:]
    )


def _is_larger(first: np.ndarray, rest: np.ndarray) -> bool:
    """Whether the mean of the first squares is larger than that of the rest, by Fisher's test."""
    if rest.size == 0:
        return False
    return bool(first.mean() > scipy.stats.f.isf(TREND_ALARM, first.size, rest.size) * rest.mean())
