"""The equation of a decaying roll, with the derivatives of its solution by its parameters.

    x'' + p1 x' + p2 |x'| x' + p3 x'^3 + w^2 (x + c x^3) = 0

x: roll about its mean; w: natural frequency; c: cubic part of the restoring (zero if the restoring
is linear). The sensitivities s = dx/dq obey the derivative of the equation by each parameter q,

    s'' = -(p1 + 2 p2 |x'| + 3 p3 x'^2) s' - w^2 (1 + 3 c x^2) s - df/dq.

All numbers are scaled by the size of the motion and by its frequency, so they are of order one.
Steps are of the classical Runge-Kutta method of order 4, at most `STEP` long: its error is below
1e-7 in twenty periods.
"""

from __future__ import annotations

from math import ceil

import numpy as np

from hydrosim.jit.kernels import kernel, root

P1, P2, P3, OMEGA, CUBIC = range(5)
LAW = 5  # parameters of the equation; place and rate at the start follow them
SIZE = LAW + 2
STATES = 2 + 2 * SIZE
STEP = 0.03  # of scaled time, in which a period is 2 pi
FASTEST = 20.0  # rate beyond which a trial is no decay any more


def solve(time: np.ndarray, law: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Roll (n,) at equal steps of ``time`` (n,) for the ``law`` (p1, p2, p3, w, c) from place and
    rate at the ``start`` (2,), and its derivatives (n, 7) by the law and the start."""
    y = np.zeros(STATES)
    y[:2] = start
    y[2 + LAW] = 1.0
    y[2 + SIZE + LAW + 1] = 1.0
    found = np.empty((time.size, 1 + SIZE))
    step = (time[-1] - time[0]) / (time.size - 1)
    parts = ceil(step / STEP)
    fill_decay(law, step / parts, parts, y, np.empty((3, STATES)), found)
    return found[:, 0], found[:, 1:]


@root
def fill_decay(law, h, parts, y, scratch, found):
    """Fill ``found`` (n, 8) with roll and sensitivities at every ``parts`` steps ``h`` from ``y``
    (16,), which is changed."""
    for k in range(len(found)):
        if k > 0:
            for _ in range(parts):
                _step(law, h, y, scratch)
        found[k, 0] = y[0]
        for i in range(SIZE):
            found[k, 1 + i] = y[2 + i]


@kernel
def _step(law, h, y, scratch):
    """Move ``y`` on by a step ``h``."""
    total, slope, at = scratch[0], scratch[1], scratch[2]
    for i in range(STATES):
        total[i] = 0.0
        at[i] = y[i]
    for stage in range(4):
        _fill_slope(law, at, slope)
        weight = h / 6.0 if stage == 0 or stage == 3 else h / 3.0
        reach = h if stage == 2 else 0.5 * h
        for i in range(STATES):
            total[i] += weight * slope[i]
            at[i] = y[i] + reach * slope[i]
    for i in range(STATES):
        y[i] += total[i]


@kernel
def _fill_slope(law, y, slope):
    """Fill ``slope`` (16,) = y' of roll, rate, and the sensitivities of both."""
    p1, p2, p3, w, c = law[P1], law[P2], law[P3], law[OMEGA], law[CUBIC]
    x = y[0]
    v = min(max(y[1], -FASTEST), FASTEST)
    lift = x + c * x * x * x
    slope[0] = y[1]
    slope[1] = -(p1 + p2 * abs(v) + p3 * v * v) * v - w * w * lift
    damping = p1 + 2.0 * p2 * abs(v) + 3.0 * p3 * v * v
    stiffness = w * w * (1.0 + 3.0 * c * x * x)
    s, r = 2, 2 + SIZE
    for i in range(SIZE):
        slope[s + i] = y[r + i]
        slope[r + i] = -damping * y[r + i] - stiffness * y[s + i]
    slope[r + P1] -= v
    slope[r + P2] -= abs(v) * v
    slope[r + P3] -= v * v * v
    slope[r + OMEGA] -= 2.0 * w * lift
    slope[r + CUBIC] -= w * w * x * x * x
