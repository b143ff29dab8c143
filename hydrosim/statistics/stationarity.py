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

from hydrosim.statistics.series import binned, slow_parts

TRENDS = (1, 3)  # coefficients
ALARM = 0.001  # probability of a false one, for each trend of mean and of variance
PARTS = 6  # of a memory: coefficients that are slow against it
STRETCH = 2  # memories
LITTLE = 0.05  # of the variance: less in a stretch does not matter


def changes(x: np.ndarray, independent: float) -> tuple[bool, bool]:
    """Whether mean and variance of a record x (nt,) change, which is so many times as long as its
    memory."""
    z = (x - x.mean()) / x.std()
    stretches = max(int(independent / STRETCH), 1)
    variance = binned(z**2, stretches) / binned(np.ones(z.size), stretches)
    count = int(independent / PARTS)
    return _has_trend(z, count), _has_trend(np.log(variance + LITTLE), count)


def _has_trend(series: np.ndarray, count: int) -> bool:
    """Whether the first of the lowest coefficients of a series are larger than the rest."""
    squares = slow_parts(series - series.mean(), count) ** 2
    rest = squares[max(TRENDS) :]
    if rest.size == 0:
        return False
    ratios = [squares[:first].mean() / rest.mean() for first in TRENDS]
    return bool(np.any(ratios > fisher.isf(ALARM, TRENDS, rest.size)))
