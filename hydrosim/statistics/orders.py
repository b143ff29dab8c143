"""What the largest values of runs say of another run where they follow no law.

Of n + 1 values that are drawn alike each is as likely the smallest: one more lies between the
smallest and the largest of n with the probability (n - 1) / (n + 1). A quantile lies between two of
the n in order as the binomial distribution says (David and Nagaraja 2003, Order Statistics,
sections 7.1, 7.2).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.stats import quantile_test

from hydrosim.statistics.gumbel import INTERVAL

ENOUGH = 19  # values whose smallest and largest hold another one with `INTERVAL`
ROUNDING = 1e-9


class Held(NamedTuple):
    """An interval from ``low`` to ``high`` that holds another value with a ``probability``."""

    low: float
    high: float
    probability: float


def find_prediction(values: np.ndarray) -> Held:
    """The interval of another value, given n of them, two or more: with `INTERVAL` at least, or, of
    fewer than `ENOUGH`, as often as the smallest and the largest hold it."""
    ordered = np.sort(values)
    count = ordered.size
    outside = int(0.5 * (1.0 - INTERVAL) * (count + 1) + ROUNDING)
    left_out = max(outside, 1)
    probability = 1.0 - 2.0 * left_out / (count + 1)
    return Held(float(ordered[left_out - 1]), float(ordered[-left_out]), probability)


def find_confidence(values: np.ndarray, probability: float) -> tuple[float, float]:
    """The interval that holds the value below which another one is with a ``probability``. An end
    that so few values do not know is infinite."""
    found = quantile_test(values, p=probability).confidence_interval(INTERVAL)
    low = -np.inf if np.isnan(found.low) else float(found.low)
    high = np.inf if np.isnan(found.high) else float(found.high)
    return low, high
