"""Intervals for one more run from the values of n runs, without a distribution.

Each of n + 1 equally distributed values is equally likely to be the smallest. So one more value
lies between the smallest and the largest of n with probability (n - 1) / (n + 1). A quantile lies
between two of the n ordered values with a binomial probability (David and Nagaraja 2003, Order
Statistics, sections 7.1, 7.2).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from hydrosim.statistics.gumbel import INTERVAL_PROBABILITY

# values whose smallest and largest contain another one with `INTERVAL_PROBABILITY`
VALUES_FOR_INTERVAL = 19
COUNT_ROUNDING = 1e-9


class PredictionInterval(NamedTuple):
    """An interval from ``low`` to ``high`` that contains another value with a ``probability``."""

    low: float
    high: float
    probability: float


def find_prediction(values: np.ndarray) -> PredictionInterval:
    """Prediction interval for one more value, from n >= 2 values. Its probability is at least
    `INTERVAL_PROBABILITY`; for fewer than `VALUES_FOR_INTERVAL` values, that of their smallest to
    largest."""
    ordered = np.sort(values)
    count = ordered.size
    outside = int(0.5 * (1.0 - INTERVAL_PROBABILITY) * (count + 1) + COUNT_ROUNDING)
    left_out = max(outside, 1)
    probability = 1.0 - 2.0 * left_out / (count + 1)
    return PredictionInterval(float(ordered[left_out - 1]), float(ordered[-left_out]), probability)


def find_confidence(values: np.ndarray, probability: float) -> tuple[float, float]:
    """Confidence interval of a quantile: the value below which another one is with a
    ``probability``. An end is infinite if there are too few values for it."""
    found = scipy.stats.quantile_test(values, p=probability).confidence_interval(
        INTERVAL_PROBABILITY
    )
    low = -np.inf if np.isnan(found.low) else float(found.low)
    high = np.inf if np.isnan(found.high) else float(found.high)
    return low, high
