"""Probability that a Gaussian motion of known spectrum stays within limits.

A motion has the spectral moments m0, m1, m2. In a time T it rises n = T / (2 pi) sqrt(m2 / m0)
times above its mean, and n exp(-u^2 / 2) times above a level of u standard deviations. These
upcrossings come in groups while the envelope is above the level. The envelope rises above it sqrt(2
pi) q u times as often, with q^2 = 1 - m1^2 / (m0 m2) (Cramer and Leadbetter 1967, Stationary and
Related Stochastic Processes). With Vanmarcke's groups (1975, Journal of Applied Mechanics 42) the
motion stays within its limits with the probability

    p = b exp(-g / b),     g = c (1 - exp(-e / c)),     b = 1 - exp(-u^2 / 2),

c is the mean number of crossings of any limit. e is the mean number of upcrossings of the nearest
limit u by the envelope. Statistics of runs count groups in the same way
(`hydrosim.statistics.crossings`), from the record instead of the spectrum. Levels are at most 0.5 %
low, and 3.5 % high for a narrow band such as a roll of 1 % damping.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, expm1, log, pi, sqrt
from typing import NamedTuple

import scipy

LEVEL_RANGE = (1e-2, 1e2)  # standard deviations between which a level is searched


class Excursions(NamedTuple):
    """A Gaussian motion of unit variance: mean number of ``waves`` in the time, and the
    ``broadness`` q of its band, 0 for a regular motion."""

    waves: float
    broadness: float

    def log_inside(self, levels: Sequence[float]) -> float:
        """Logarithm of the probability that the motion stays within its ``levels``: at most one
        above its mean and one below."""
        nearest = min(levels)
        crossings = sum(exp(0.5 * (nearest**2 - each**2)) for each in levels)
        envelope = sqrt(2.0 * pi) * self.broadness * nearest
        groups = -crossings * expm1(-envelope / crossings)
        begins_inside = -expm1(-0.5 * nearest**2)
        left = self.waves * exp(-0.5 * nearest**2) * groups
        return log(begins_inside) - left / begins_inside

    def level(self, probability: float) -> float:
        """Level that the motion stays below with a ``probability``."""

        def excess(level: float) -> float:
            return self.log_inside([level]) - log(probability)

        return float(scipy.optimize.brentq(excess, *LEVEL_RANGE, xtol=1e-12))


def find_excursions(m0: float, m1: float, m2: float, duration: float) -> Excursions:
    """Excursions of a motion with these spectral moments (m0 and m2 above zero), in a ``duration``
    [s]."""
    waves = duration * sqrt(m2 / m0) / (2.0 * pi)
    broadness = sqrt(max(1.0 - m1**2 / (m0 * m2), 0.0))
    return Excursions(max(waves, 1.0), broadness)
