"""Upcrossings of a level by a sampled Gaussian process, and the number of their groups.

Values have unit variance. The probability that a value is above u and its predecessor below is

    p(u) = 2 T(u, a),     a = sqrt((1 - r) / (1 + r)),     r the correlation of neighbours

T is Owen's function (1956, Annals of Mathematical Statistics 27). For short steps this is Rice's
rate, a / pi exp(-u^2 / 2). Values above u come in groups. The narrower the band and the lower the
level, the fewer the groups. Groups come at random, and their number is a fraction

    g(u) = 1 - exp(-k u)     (Vanmarcke 1975, Journal of Applied Mechanics 42)

of the upcrossings. The largest of n values is below u with probability exp(-n p g). For short times
this is multiplied by 1 - exp(-u^2 / 2), the probability that the envelope begins below u. The
factor k follows from this law and the largest values of many windows.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy
from scipy.special import owens_t

MIN_LEVEL = 0.5  # lower bound of levels
GROUP_FRACTION_RANGE = (0.01, 0.99)  # bounds of the fraction of groups
MAX_STEEPNESS = 1e3  # of a: neighbours are uncorrelated
MAX_LEVEL_ITERATIONS, LEVEL_TOLERANCE = 50, 1e-12  # of a fixed-point iteration on logarithms


class Crossings(NamedTuple):
    """A process of so many ``values``, with a as ``steepness`` and k as ``grouping``. ``beyond`` is
    the logarithm of the ratio of the groups found to the groups that are possible; zero within
    bounds."""

    values: float
    steepness: float
    grouping: float
    beyond: float

    def groups(self, u: float) -> float:
        """Mean number of groups above u."""
        u = max(u, MIN_LEVEL)
        share = -np.expm1(-self.grouping * u)
        return float(self.values * 2.0 * owens_t(u, self.steepness) * share)

    def level(self, exceeded: float) -> float:
        """Level u that so many groups exceed on average; at least zero."""
        u, before = MIN_LEVEL, 0.0
        for _ in range(MAX_LEVEL_ITERATIONS):
            if abs(u - before) < LEVEL_TOLERANCE:
                break
            rate = self.groups(u) * np.exp(0.5 * max(u, MIN_LEVEL) ** 2)
            u, before = float(np.sqrt(2.0 * max(np.log(rate / exceeded), 0.0))), u
        return u


def crossings(rate: float, at: float, peaks: np.ndarray, windows: int, values: int) -> Crossings:
    """How a process crosses levels. It rises above the level ``at`` >= 0 at the ``rate`` per
    sample, counted over so many samples, ``values``. Of the ``windows`` of time, n had a peak above
    it: ``peaks`` (n,)."""
    steepness = _steepness(rate, at)
    u = np.sqrt(max(-2.0 * np.log(np.exp(-0.5 * peaks**2).mean()), MIN_LEVEL**2))
    begins = -np.log(-np.expm1(-0.5 * u**2))
    share = (1.0 - begins) * windows / (values * 2.0 * owens_t(u, steepness))
    possible = np.clip(share, *GROUP_FRACTION_RANGE)
    beyond = np.log(max(share, GROUP_FRACTION_RANGE[0]) / possible)
    return Crossings(float(values), steepness, float(-np.log1p(-possible) / u), float(beyond))


def _steepness(rate: float, at: float) -> float:
    """The a for which a process rises above a level at this rate."""
    if not 2.0 * owens_t(at, MAX_STEEPNESS) > rate:
        return MAX_STEEPNESS
    return float(
        scipy.optimize.brentq(lambda a: 2.0 * owens_t(at, a) - rate, 0.0, MAX_STEEPNESS, rtol=1e-12)
    )
