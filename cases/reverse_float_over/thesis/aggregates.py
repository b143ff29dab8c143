"""Means over seeds and shares of seeds, with 90 % intervals."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from scipy.stats import binomtest, t

LEVEL = 0.9


class Mean(NamedTuple):
    """Mean of ``n`` values with its interval ``lower`` to ``upper``; the values' standard deviation
    and extremes."""

    n: int
    mean: float
    lower: float
    upper: float
    deviation: float
    least: float
    most: float


class Share(NamedTuple):
    """``agree`` of ``n`` seeds as a share, with its interval ``lower`` to ``upper``."""

    agree: int
    n: int
    share: float
    lower: float
    upper: float


def mean_of(values: Iterable[float]) -> Mean:
    """Mean with Student's interval. Values that are not numbers do not count; ``n`` says how many
    do. The interval of a single value is not a number."""
    known = np.array([value for value in values if np.isfinite(value)])
    n = known.size
    if n == 0:
        return Mean(0, *6 * (np.nan,))
    mean = float(known.mean())
    deviation = float(known.std(ddof=1)) if n > 1 else float("nan")
    half = float(t.ppf(0.5 + LEVEL / 2, n - 1)) * deviation / n**0.5
    extremes = float(known.min()), float(known.max())
    return Mean(n, mean, mean - half, mean + half, deviation, *extremes)


def share_of(outcomes: Iterable[bool]) -> Share:
    """Share of true ``outcomes`` with Wilson's interval."""
    known = list(outcomes)
    if not known:
        return Share(0, 0, *3 * (np.nan,))
    test = binomtest(sum(known), len(known))
    interval = test.proportion_ci(LEVEL, method="wilson")
    return Share(
        sum(known), len(known), float(test.statistic), float(interval.low), float(interval.high)
    )
