"""Gumbel's law of the largest value, fitted to maxima by maximum likelihood, with intervals.

    P(largest <= x) = exp(-exp(-(x - a) / b))

For maxima that follow the law, the distributions of (a - a_fit) / b_fit and b / b_fit depend only
on the number of maxima. They are drawn once, and every interval follows from them, exact for any
number of maxima (Lawless 2003, Statistical Models and Methods for Lifetime Data, section 5.2).
Windows that slide by an eighth of their length contain more information than adjacent windows
(Buecher and Segers 2018, Extremes 21); the draws slide in the same way. Windows of a record are
correlated, the more so the fewer memories they last. Their model is the energy of an oscillator in
noise, |Z|^2 of a complex process with the autocorrelation exp(-t / 2) over t memories. Draws of
this energy are mapped to Gumbel's law by rank.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from hydrosim.statistics.peaks import anderson_darling

SLIDE = 8  # parts of a window that it slides by
DRAWS = 4000
ROUNDS = 8  # of Newton's method, which has converged by then
INTERVAL = 0.9  # probability of all intervals
ENDS = (0.05, 0.95)
DOUBTED = 0.637  # statistic of Anderson's and Darling's test of Gumbel's law that 10 % exceed
CERTAIN = 1e-15
LONGEST = 16  # memories: longer windows count as independent


class Gumbel(NamedTuple):
    """A fit to ``windows`` maxima. If they slide, each is ``memories`` long; lengths above
    `LONGEST` are equivalent."""

    location: float
    scale: float
    windows: int
    memories: int | None

    def expected(self, ratio: float) -> float:
        """Value that is exceeded once on average in so many windows."""
        return float(self.location + self.scale * np.log(ratio))

    def exceedances(self, value: float, ratio: float) -> float:
        """Mean number of exceedances of a value in so many windows."""
        return float(ratio * np.exp((self.location - value) / self.scale))

    def confidence(self, ratio: float) -> np.ndarray:
        """Confidence interval (2,) of the `expected` value."""
        moved, wider = _pivots(self.windows, self.memories)[:2]
        return self._ends(moved + np.log(ratio) * wider)

    def prediction(self, ratio: float, ends: tuple[float, float] = ENDS) -> np.ndarray:
        """Prediction interval (2,) of the largest value in so many windows; ``ends`` are the
        probabilities of its ends."""
        moved, wider, largest = _pivots(self.windows, self.memories)
        return self._ends(moved + (np.log(ratio) + largest) * wider, ends)

    def _ends(self, draws: np.ndarray, ends: tuple[float, float] = ENDS) -> np.ndarray:
        return np.asarray(self.location + self.scale * np.quantile(draws, ends))


def exceeding(probability: float) -> float:
    """Multiple of the record's length for which `expected` is a quantile. The largest value of one
    record is below that quantile with this ``probability``."""
    return float(-1.0 / np.log(probability))


def fit_maxima(maxima: np.ndarray) -> Gumbel:
    """Law of independent maxima (n,), not all equal."""
    location, scale = _fit(maxima)
    return Gumbel(float(location), float(scale), maxima.size, None)


def follows_gumbel(maxima: np.ndarray, law: Gumbel) -> bool:
    """Whether independent maxima (n,) are compatible with the ``law`` fitted to them, by the test
    of Anderson and Darling at 10 % (Stephens 1977, Biometrika 64)."""
    count = maxima.size
    below = np.exp(-np.exp((law.location - np.sort(maxima)) / law.scale))
    statistic = anderson_darling(np.clip(below, CERTAIN, 1.0 - CERTAIN))
    return bool(statistic * (1.0 + 0.2 / np.sqrt(count)) < DOUBTED)


def fit_record(x: np.ndarray, windows: int, memories: float) -> Gumbel:
    """Law of the largest value in a window of a record x (nt,), from so many windows; the record is
    so many times as long as its memory."""
    location, scale = _fit(sliding(x, windows))
    each = min(max(round(memories / windows), 1), LONGEST + 1)
    return Gumbel(float(location), float(scale), windows, each)


def sliding(x: np.ndarray, windows: int) -> np.ndarray:
    """Maxima over windows that slide by an eighth of their length. A rest shorter than one part of
    a window is left out."""
    size = x.size // (SLIDE * windows)
    return _slid(x[: size * SLIDE * windows].reshape(-1, size).max(axis=1))


def _slid(parts: np.ndarray) -> np.ndarray:
    windows = np.lib.stride_tricks.sliding_window_view(parts, SLIDE, axis=-1)
    return np.asarray(windows.max(axis=-1))


def _fit(maxima: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Location and scale by maximum likelihood, over the last axis. The scale is the zero of b -
    mean(x) + sum(x e) / sum(e), e = exp(-x / b)."""
    least = maxima.min(axis=-1, keepdims=True)
    x = maxima - least
    mean, b = x.mean(axis=-1, keepdims=True), x.std(axis=-1, keepdims=True) * np.sqrt(6.0) / np.pi
    for _ in range(ROUNDS):
        e = np.exp(-x / b)
        weighted, total = x * e, e.sum(axis=-1, keepdims=True)
        first = weighted.sum(axis=-1, keepdims=True) / total
        second = (x * weighted).sum(axis=-1, keepdims=True) / total
        slope = 1.0 + (second - first**2) / b**2
        b = np.maximum(b - (b - mean + first) / slope, 0.2 * b)
    a = least - b * np.log(np.exp(-x / b).mean(axis=-1, keepdims=True))
    return a[..., 0], b[..., 0]


@lru_cache
def _pivots(windows: int, memories: int | None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Draws (`DRAWS`,) of (a - a_fit) / b_fit, of b / b_fit and of a largest value, for a = 0, b =
    1."""
    random = np.random.default_rng(windows)
    if memories is None:
        drawn = _reduced(random.random((DRAWS, windows)))
    elif memories > LONGEST:
        # the largest of n such values has their law, moved by log n
        drawn = _slid(_reduced(random.random((DRAWS, windows * SLIDE))) - np.log(SLIDE))
    else:
        drawn = _by_rank(_slid(_energies(random, windows, memories)))
    location, scale = _fit(drawn)
    return -location / scale, 1.0 / scale, _reduced(random.random(DRAWS))


def _energies(random: np.random.Generator, windows: int, memories: int) -> np.ndarray:
    """Largest energies (`DRAWS`, windows x `SLIDE`) in parts of windows. Samples are at most one
    memory apart, about one cycle of an oscillator with that memory."""
    steps = -(-memories // SLIDE)  # of a part
    kept = np.exp(-0.5 * memories / (steps * SLIDE))
    z, found = random.normal(size=(2, DRAWS)), np.zeros((windows * SLIDE, DRAWS))
    for energy in found:
        for _ in range(steps):
            z = kept * z + np.sqrt(1.0 - kept**2) * random.normal(size=z.shape)
            np.maximum(energy, (z**2).sum(axis=0), out=energy)
    return found.T


def _by_rank(values: np.ndarray) -> np.ndarray:
    """Values of Gumbel's law in the same order."""
    known = np.sort(values[:, :: SLIDE // 2].ravel())
    return _reduced((np.searchsorted(known, values) + 0.5) / (known.size + 1.0))


def _reduced(probability: np.ndarray) -> np.ndarray:
    return np.asarray(-np.log(-np.log(probability)))
