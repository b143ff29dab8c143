"""A pure delay of a signal, as states of the motion.

    exp(-s tau) = product of (s^2 - a s + b) / (s^2 + a s + b), three of them

The factors are those of Pade's approximant of degree 6 (Baker & Graves-Morris 1996, chapter 1). It
changes no amplitude. Its phase is behind by w tau + 1.7e-13 (w tau)^13 for small w tau: an error of
1.7e-13 rad at w tau = 1, 1.4e-9 at 2, 4.2e-7 at pi. So its equations are ordinary ones. A method of
any order keeps that order, and a restart continues to the bit.

Each factor has two states: x1' = x2, x2' = u - b x1 - a x2, and passes u - 2 a x2 on. They are
fast, with rates of about 8.5 / tau, which limits the step of an explicit method to about 0.3 tau.
"""

from __future__ import annotations

from math import factorial

import numpy as np

from hydrosim.jit.kernels import kernel

FACTORS = 3
DELAY_STATES = 2 * FACTORS


def delay_factors(tau: float) -> np.ndarray:
    """a [1/s] and b [1/s^2] (3, 2) of a delay ``tau`` [s]; zeros if it is 0."""
    if tau == 0.0:
        return np.zeros((FACTORS, 2))
    m = DELAY_STATES
    terms = [factorial(2 * m - j) / (factorial(j) * factorial(m - j)) for j in range(m + 1)]
    poles = np.roots(terms[::-1])
    upper = poles[poles.imag > 0.0]
    upper = upper[np.argsort(upper.imag)]
    return np.stack([-2.0 * upper.real / tau, np.abs(upper) ** 2 / tau**2], axis=1)


@kernel
def start_delay(u, each, y, k):
    """Fill the states from ``k`` on in ``y`` as if ``u`` had never changed."""
    for i in range(FACTORS):
        y[k + 2 * i] = u / each[i, 1]
        y[k + 2 * i + 1] = 0.0


@kernel
def delayed_signal(u, rate, each, y, k):
    """The delayed value of ``u`` and its rate, from the states from ``k`` on in ``y``."""
    for i in range(FACTORS):
        a = each[i, 0]
        x2 = y[k + 2 * i + 1]
        change = u - each[i, 1] * y[k + 2 * i] - a * x2
        u -= 2.0 * a * x2
        rate -= 2.0 * a * change
    return u, rate


@kernel
def add_rates(u, each, y, k, dy):
    """Rates of the states from ``k`` on into ``dy``."""
    for i in range(FACTORS):
        a = each[i, 0]
        x2 = y[k + 2 * i + 1]
        dy[k + 2 * i] = x2
        dy[k + 2 * i + 1] = u - each[i, 1] * y[k + 2 * i] - a * x2
        u -= 2.0 * a * x2
