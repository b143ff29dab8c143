"""How often a sampled Gaussian process rises above a level, and in how many groups.

Of values of unit variance, one in so many is the first above u after one below it:

    p(u) = 2 T(u, a),     a = sqrt((1 - r) / (1 + r)),     r the correlation of neighbours

T being Owen's function (1956, Annals of Mathematical Statistics 27); where steps are short this is
Rice's rate, a / pi exp(-u^2 / 2). Values above u come in groups, fewer than they are, the more so
the narrower the band and the lower the level; groups come at random, and are a share

    g(u) = 1 - exp(-k u)     (Vanmarcke 1975, Journal of Applied Mechanics 42)

of them. The largest of n values is below u with the probability exp(-n p g); that of a short time
times 1 - exp(-u^2 / 2), with which the envelope is below u when it begins. From that, and from the
largest values of many windows, follows k.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq
from scipy.special import owens_t

LOWEST = 0.5  # level, below which the largest of a record is not
SHARES = (0.01, 0.99)  # between which a share of groups is
STEEP = 1e3  # of a: neighbours have nothing in common
ROUNDS, CLOSE = 50, 1e-12  # of a fixed point that moves by logarithms


class Crossings(NamedTuple):
    """Of a process of so many ``values``: a as ``steepness``, k as ``grouping``; the logarithm of
    by what factor more or fewer groups were found than there can be is ``beyond``."""

    values: float
    steepness: float
    grouping: float
    beyond: float

    def groups(self, u: float) -> float:
        """How often the process exceeds u on average, in groups."""
        u = max(u, LOWEST)
        share = -np.expm1(-self.grouping * u)
        return float(self.values * 2.0 * owens_t(u, self.steepness) * share)

    def level(self, exceeded: float) -> float:
        """The level u that is exceeded so often on average; zero at least."""
        u, before = LOWEST, 0.0
        for _ in range(ROUNDS):
            if abs(u - before) < CLOSE:
                break
            rate = self.groups(u) * np.exp(0.5 * max(u, LOWEST) ** 2)
            u, before = float(np.sqrt(2.0 * max(np.log(rate / exceeded), 0.0))), u
        return u


def crossings(rate: float, at: float, peaks: np.ndarray, windows: int, values: int) -> Crossings:
    """Of a process that rises above the level ``at``, zero or more, once in 1 / ``rate`` of its
    ``values``, and whose largest values are ``peaks`` (n,) in so many ``windows``."""
    steepness = _steepness(rate, at)
    u = np.sqrt(max(-2.0 * np.log(np.exp(-0.5 * peaks**2).mean()), LOWEST**2))
    begins = -np.log(-np.expm1(-0.5 * u**2))
    share = (1.0 - begins) * windows / (values * 2.0 * owens_t(u, steepness))
    possible = np.clip(share, *SHARES)
    beyond = np.log(max(share, SHARES[0]) / possible)
    return Crossings(float(values), steepness, float(-np.log1p(-possible) / u), float(beyond))


def _steepness(rate: float, at: float) -> float:
    """The a of which a process rises above a level so often."""
    if not 2.0 * owens_t(at, STEEP) > rate:
        return STEEP
    return float(brentq(lambda a: 2.0 * owens_t(at, a) - rate, 0.0, STEEP, rtol=1e-12))
