"""Whether mean and variance of a record change over its time.

The lowest cosine coefficients of a stationary series are independent and equally large, however
long its memory, if the record is many memories long (Mueller 2007, Journal of Econometrics 141). A
steady trend is in the first of them, others are in the first few: their mean square over that of
the rest has Fisher's distribution if there is none. Of the variance it is the logarithm of short
stretches that is looked at, for it is nearly normal.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import f as fisher
from scipy.stats import ttest_ind

from hydrosim.statistics.series import binned, prediction_errors, slow_parts

TRENDS = (1, 3)  # coefficients
GUSTS = 12  # coefficients of the variance: waves that wax and wane
BEGINNINGS = (8, 16, 32, 64)  # parts of the record, the first of which may be a transient
FEWEST = 10  # stretches of a beginning
ALIKE = 1e-9  # logarithms of variances: all that is below is of rounding
LARGER = 1e-5  # probability of a false alarm, if stretches knew nothing of each other
ALARM = 0.001  # probability of a false one, for each trend of mean and of variance
PARTS = 6  # of a memory: coefficients that are slow against it
STRETCH = 2  # memories
LITTLE = 0.05  # of the variance: less in a stretch does not matter


def changes(x: np.ndarray, independent: float) -> tuple[bool, bool]:
    """Whether mean and variance of a record x (nt,) change, which is so many times as long as its
    memory."""
    z = (x - x.mean()) / x.std()
    variance = _log_variances(z, independent)
    count = int(independent / PARTS)
    return _has_trend(z, count), _has_trend(variance, count) or _has_gusts(z, independent)


def begins_larger(x: np.ndarray, independent: float) -> bool:
    """Whether the variance of a record x (nt,) is larger at its beginning than later, as while it
    forgets how it began: Student's test of the logarithms of the variance of short stretches."""
    variance = _log_variances((x - x.mean()) / x.std(), independent)
    for part in BEGINNINGS:
        first = variance[: variance.size // part]
        if first.size < FEWEST or not np.ptp(first) > ALIKE:
            continue
        found = ttest_ind(first, variance[first.size :], equal_var=False, alternative="greater")
        if found.pvalue < LARGER:
            return True
    return False


def _log_variances(z: np.ndarray, independent: float) -> np.ndarray:
    """Logarithms of the variance of z (nt,) in short stretches."""
    stretches = max(int(independent / STRETCH), 1)
    variance = binned(z**2, stretches) / binned(np.ones(z.size), stretches)
    return np.asarray(np.log(variance + LITTLE))


def _has_trend(series: np.ndarray, count: int) -> bool:
    """Whether the first of the lowest coefficients of a series are larger than the rest."""
    squares = slow_parts(series - series.mean(), count) ** 2
    return any(_is_larger(squares[:first], squares[max(TRENDS) :]) for first in TRENDS)


def _has_gusts(z: np.ndarray, independent: float) -> bool:
    """Whether waves wax and wane slowly: whether more of the lowest coefficients of the variance of
    what is not foretold, which scatters least, are larger than the rest, if these are as many."""
    errors, _ = prediction_errors(z)
    variance = _log_variances(errors / errors.std(), independent)
    squares = slow_parts(variance - variance.mean(), int(independent / PARTS)) ** 2
    return squares.size >= 2 * GUSTS and _is_larger(squares[:GUSTS], squares[GUSTS:])


def _is_larger(first: np.ndarray, rest: np.ndarray) -> bool:
    """Whether the mean of the first squares is larger than that of the rest, by Fisher's test."""
    if rest.size == 0:
        return False
    return bool(first.mean() > fisher.isf(ALARM, first.size, rest.size) * rest.mean())
