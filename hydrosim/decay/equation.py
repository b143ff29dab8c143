"""The equation of a decaying roll, with the derivatives of its solution by its parameters.

    x'' + p1 x' + p2 |x'| x' + p3 x'^3 + w^2 (x + c x^3) = 0

x: roll about its mean; w: natural frequency; c: cubic part of the restoring (zero if the restoring
is linear). The sensitivities S = dx/dq obey the equation's own derivative,

    S'' = -(p1 + 2 p2 |x'| + 3 p3 x'^2) S' - w^2 (1 + 3 c x^2) S - df/dq.

All numbers are scaled by the size of the motion and by its frequency, so they are of order one.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

P1, P2, P3, OMEGA, CUBIC = range(5)
LAW = 5  # parameters of the equation; place and rate at the start follow them
RTOL, ATOL = 1e-8, 1e-10
FASTEST = 20.0  # rate beyond which a trial is no decay any more


def solve(time: np.ndarray, law: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Roll (n,) at the ``time`` (n,) for the ``law`` (p1, p2, p3, w, c) from place and rate at the
    ``start`` (2,), and its derivatives (n, 7) by the law and the start."""
    size = LAW + 2
    y = np.zeros(2 + 2 * size)
    y[:2] = start
    y[2 + LAW] = 1.0
    y[2 + size + LAW + 1] = 1.0
    done = solve_ivp(
        _slope,
        (time[0], time[-1]),
        y,
        method="DOP853",
        t_eval=time,
        rtol=RTOL,
        atol=ATOL,
        args=(law, size),
    )
    return done.y[0], done.y[2 : 2 + size].T


def _slope(t: float, y: np.ndarray, law: np.ndarray, size: int) -> np.ndarray:
    """y' of roll, rate, and the sensitivities of both."""
    p1, p2, p3, w, c = law
    x = y[0]
    v = min(max(y[1], -FASTEST), FASTEST)
    s = y[2 : 2 + size]
    r = y[2 + size :]
    square = abs(v) * v
    cube = v * v * v
    lift = x + c * x**3
    slope = np.empty_like(y)
    slope[0] = y[1]
    slope[1] = -(p1 * v + p2 * square + p3 * cube + w * w * lift)
    slope[2 : 2 + size] = r
    rates = slope[2 + size :]
    rates[:] = -(p1 + 2.0 * p2 * abs(v) + 3.0 * p3 * v * v) * r
    rates -= w * w * (1.0 + 3.0 * c * x * x) * s
    rates[P1] -= v
    rates[P2] -= square
    rates[P3] -= cube
    rates[OMEGA] -= 2.0 * w * lift
    rates[CUBIC] -= w * w * x**3
    return slope
