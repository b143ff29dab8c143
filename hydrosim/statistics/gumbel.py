"""Laws of largest values: Gumbel's, fitted with intervals, and order statistics without a law.

Gumbel's law is fitted to maxima by maximum likelihood:

    P(largest <= x) = exp(-exp(-(x - a) / b))

For maxima that follow the law, the distributions of (a - a_fit) / b_fit and b / b_fit depend only
on the number of maxima. They are drawn once, and every interval follows from them, exact for any
number of maxima (Lawless 2003, Statistical Models and Methods for Lifetime Data, section 5.2).
Windows that slide by an eighth of their length contain more information than adjacent windows
(Buecher and Segers 2018, Extremes 21); the draws slide in the same way. Windows of a record are
correlated, the more so the fewer memories they last. Their model is the energy of an oscillator in
noise, |Z|^2 of a complex process with the autocorrelation exp(-t / 2) over t memories. Draws of
this energy are mapped to Gumbel's law by rank.

Intervals for one more run from the values of n runs, without a distribution.

Each of n + 1 equally distributed values is equally likely to be the smallest. So one more value
lies between the smallest and the largest of n with probability (n - 1) / (n + 1). A quantile lies
between two of the n ordered values with a binomial probability (David and Nagaraja 2003, Order
Statistics, sections 7.1, 7.2).
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy

from hydrosim.statistics.series import anderson_darling

PARTS_PER_WINDOW = 8  # parts of a window that it slides by
DRAWS = 4000
NEWTON_ITERATIONS = 8  # of Newton's method, which has converged by then
INTERVAL_PROBABILITY = 0.9  # probability of all intervals
INTERVAL_ENDS = (0.05, 0.95)
MAX_MISFIT = 0.637  # statistic of Anderson's and Darling's test of Gumbel's law that 10 % exceed
MIN_PROBABILITY = 1e-15
MAX_WINDOW_MEMORIES = 16  # memories: longer windows count as independent


class Gumbel(NamedTuple):
    """A fit to ``windows`` maxima. If they slide, each is ``memories`` long; lengths above
    `MAX_WINDOW_MEMORIES` are equivalent."""

    location: float
    scale: float
    windows: int
    memories: int | None

    def expected_maximum(self, ratio: float) -> float:
        """Value that is exceeded once on average in so many windows."""
        return float(self.location + self.scale * np.log(ratio))

    def exceedances(self, value: float, ratio: float) -> float:
        """Mean number of exceedances of a value in so many windows."""
        return float(ratio * np.exp((self.location - value) / self.scale))

    def confidence_interval(self, ratio: float) -> np.ndarray:
        """Confidence interval (2,) of the `expected_maximum` value."""
        moved, wider = _draw_pivots(self.windows, self.memories)[:2]
        return self._ends(moved + np.log(ratio) * wider)

    def prediction_interval(
        self, ratio: float, ends: tuple[float, float] = INTERVAL_ENDS
    ) -> np.ndarray:
        """Prediction interval (2,) of the largest value in so many windows; ``ends`` are the
        probabilities of its ends."""
        moved, wider, largest = _draw_pivots(self.windows, self.memories)
        return self._ends(moved + (np.log(ratio) + largest) * wider, ends)

    def _ends(self, draws: np.ndarray, ends: tuple[float, float] = INTERVAL_ENDS) -> np.ndarray:
        return np.asarray(self.location + self.scale * np.quantile(draws, ends))


def length_ratio(probability: float) -> float:
    """Multiple of the record's length for which `expected_maximum` is a quantile. The largest value
    of one record is below that quantile with this ``probability``."""
    return float(-1.0 / np.log(probability))


def fit_maxima(maxima: np.ndarray) -> Gumbel:
    """Law of independent maxima (n,), not all equal."""
    location, scale = _fit_gumbel(maxima)
    return Gumbel(float(location), float(scale), maxima.size, None)


def fits_gumbel(maxima: np.ndarray, law: Gumbel) -> bool:
    """Whether independent maxima (n,) are compatible with the ``law`` fitted to them, by the test
    of Anderson and Darling at 10 % (Stephens 1977, Biometrika 64)."""
    count = maxima.size
    below = np.exp(-np.exp((law.location - np.sort(maxima)) / law.scale))
    statistic = anderson_darling(np.clip(below, MIN_PROBABILITY, 1.0 - MIN_PROBABILITY))
    return bool(statistic * (1.0 + 0.2 / np.sqrt(count)) < MAX_MISFIT)


def fit_record(x: np.ndarray, windows: int, memories: float) -> Gumbel:
    """Law of the largest value in a window of a record x (nt,), from so many windows; the record is
    so many times as long as its memory."""
    location, scale = _fit_gumbel(sliding_maxima(x, windows))
    memories_per_window = min(max(round(memories / windows), 1), MAX_WINDOW_MEMORIES + 1)
    return Gumbel(float(location), float(scale), windows, memories_per_window)


def sliding_maxima(x: np.ndarray, windows: int) -> np.ndarray:
    """Maxima over windows that slide by an eighth of their length. A rest shorter than one part of
    a window is left out."""
    size = x.size // (PARTS_PER_WINDOW * windows)
    return _window_maxima(x[: size * PARTS_PER_WINDOW * windows].reshape(-1, size).max(axis=1))


def _window_maxima(parts: np.ndarray) -> np.ndarray:
    windows = np.lib.stride_tricks.sliding_window_view(parts, PARTS_PER_WINDOW, axis=-1)
    return np.asarray(windows.max(axis=-1))


def _fit_gumbel(maxima: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Location and scale by maximum likelihood, over the last axis. The scale is the zero of b -
    mean(x) + sum(x e) / sum(e), e = exp(-x / b)."""
    least = maxima.min(axis=-1, keepdims=True)
    x = maxima - least
    mean, b = x.mean(axis=-1, keepdims=True), x.std(axis=-1, keepdims=True) * np.sqrt(6.0) / np.pi
    for _ in range(NEWTON_ITERATIONS):
        e = np.exp(-x / b)
        weighted, total = x * e, e.sum(axis=-1, keepdims=True)
        first = weighted.sum(axis=-1, keepdims=True) / total
        second = (x * weighted).sum(axis=-1, keepdims=True) / total
        slope = 1.0 + (second - first**2) / b**2
        b = np.maximum(b - (b - mean + first) / slope, 0.2 * b)
    a = least - b * np.log(np.exp(-x / b).mean(axis=-1, keepdims=True))
    return a[..., 0], b[..., 0]


@lru_cache
def _draw_pivots(windows: int, memories: int | None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Draws (`DRAWS`,) of (a - a_fit) / b_fit, of b / b_fit and of a largest value, for a = 0, b =
    1."""
    random = np.random.default_rng(windows)
    if memories is None:
        drawn = _reduced_variate(random.random((DRAWS, windows)))
    elif memories > MAX_WINDOW_MEMORIES:
        # the largest of n such values has their law, moved by log n
        drawn = _window_maxima(
            _reduced_variate(random.random((DRAWS, windows * PARTS_PER_WINDOW)))
            - np.log(PARTS_PER_WINDOW)
        )
    else:
        drawn = _gumbel_of_ranks(_window_maxima(_draw_energies(random, windows, memories)))
    location, scale = _fit_gumbel(drawn)
    return -location / scale, 1.0 / scale, _reduced_variate(random.random(DRAWS))


def _draw_energies(random: np.random.Generator, windows: int, memories: int) -> np.ndarray:
    """Largest energies (`DRAWS`, windows x `PARTS_PER_WINDOW`) in parts of windows. Samples are at
    most one memory apart, about one cycle of an oscillator with that memory."""
    steps = -(-memories // PARTS_PER_WINDOW)  # of a part
    memory_fraction = np.exp(-0.5 * memories / (steps * PARTS_PER_WINDOW))
    z, energies = random.normal(size=(2, DRAWS)), np.zeros((windows * PARTS_PER_WINDOW, DRAWS))
    for energy in energies:
        for _ in range(steps):
            z = memory_fraction * z + np.sqrt(1.0 - memory_fraction**2) * random.normal(
                size=z.shape
            )
            np.maximum(energy, (z**2).sum(axis=0), out=energy)
    return energies.T


def _gumbel_of_ranks(values: np.ndarray) -> np.ndarray:
    """Values of Gumbel's law in the same order."""
    maxima = np.sort(values[:, :: PARTS_PER_WINDOW // 2].ravel())
    return _reduced_variate((np.searchsorted(maxima, values) + 0.5) / (maxima.size + 1.0))


def _reduced_variate(probability: np.ndarray) -> np.ndarray:
    return np.asarray(-np.log(-np.log(probability)))


# Count of values whose smallest and largest contain another one with `INTERVAL_PROBABILITY`.
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
    interval = scipy.stats.quantile_test(values, p=probability).confidence_interval(
        INTERVAL_PROBABILITY
    )
    low = -np.inf if np.isnan(interval.low) else float(interval.low)
    high = np.inf if np.isnan(interval.high) else float(interval.high)
    return low, high
