"""Step size control for embedded pairs: error norm and PI controller.

The error of a step is the largest, over the states with a finite tolerance, of

    e_m = |sum_i (b_i - b^_i) k_i| / (absolute_m + relative max(|y_m|, |y_new_m|))

A step is accepted if this is at most 1. A mean would hide one fast state among many. The error is
per unit of time: the total error of a run grows with its duration, not with its number of steps. A
fast vibration with many short steps is as accurate as a slow one (error per unit step; Hairer,
Norsett & Wanner 1993, II.4; Shampine 2005).

Steps shorter than `SHORT_STEP_S` may have the error of a step of that length. Otherwise the
rounding of k_i would shorten them without end.

The next step is h times 0.9 e^-0.7/q e_last^0.4/q, q the lower order, at least a fifth and at most
five times the last (Gustafsson 1991; Hairer & Wanner 1996, IV.2).

Location of the end of a mode inside a step, by margins that are positive while the mode holds.

The owner of a margin knows its physics; here margins are numbers. All margins that are negative at
the end of a step are watched, each in units of the larger of its values at the two ends. The
smallest of them is phi: its first zero is the first event.
"""

from __future__ import annotations

from math import isfinite, isnan
from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import kernel

SAFETY, MIN_STEP_FACTOR, MAX_STEP_FACTOR = 0.9, 0.2, 5.0
SHORT_STEP_S = 1e-3  # s


class Control(NamedTuple):
    """Tolerances: ``relative`` [1/s] and ``absolute`` (ny,), the latter in the units of the states
    per second and infinite for states that do not count. If ``adaptive`` is false every step is
    accepted."""

    adaptive: bool
    relative: float
    absolute: np.ndarray


@kernel
def error_norm(h, method, k, y, end, control):
    """Error of a step of length ``h`` with stage derivatives ``k`` from ``y`` to ``end``."""
    largest, part = 0.0, h / max(h, SHORT_STEP_S)
    for m in range(y.size):
        if isfinite(control.absolute[m]):
            error = 0.0
            for i in range(method.error.size):
                error += method.error[i] * k[i, m]
            scale = control.absolute[m] + control.relative * max(abs(y[m]), abs(end[m]))
            error = abs(part * error / scale)
            largest = error if error > largest or isnan(error) else largest
    return largest


@kernel
def step_factor(error, last, order):
    """Factor on the step after an ``error``, with the error of the ``last`` accepted step;
    ``order`` is the higher order of the method."""
    if not isfinite(error):
        return MIN_STEP_FACTOR
    error, last, q = max(error, 1e-10), max(last, 1e-4), order - 1
    factor = SAFETY * error ** (-0.7 / q)
    if error <= 1.0:
        factor *= last ** (0.4 / q)
    return min(max(factor, MIN_STEP_FACTOR), MAX_STEP_FACTOR if error <= 1.0 else SAFETY)


@kernel
def guard_defect(now, before, after):
    """Smallest watched margin of ``now`` in units of its own range over the step."""
    smallest = 1.0
    for i in range(now.size):
        if after[i] < 0.0:
            smallest = min(smallest, linear_value(i, now, before, after))
    return smallest


@kernel
def linear_value(i, now, before, after):
    """Margin ``i`` in units of the larger of its values at the ends of the step."""
    return now[i] / max(abs(before[i]), abs(after[i]))


@kernel
def next_trial(lo, f_lo, hi, f_hi):
    """Next guess for a zero of a function f in [lo, hi], where f(lo) = f_lo >= 0 > f_hi = f(hi).
    It is the zero of the chord, kept 1 % of the bracket away from its ends, so that the bracket
    always shrinks."""
    x = lo + (hi - lo) * f_lo / (f_lo - f_hi)
    guard = 0.01 * (hi - lo)
    return min(max(x, lo + guard), hi - guard)
