"""Runge-Kutta steps and the cubic interpolant of a step.

A method is a `Tableau`; a step of length h from (t, y) is

    Y_i = y + h sum_{j<i} a_ij k_j,   k_i = f(t + c_i h, Y_i + h a_ii k_i)
    y_new = y + h sum_i b_i k_i

where a_ii = 0 for explicit methods; otherwise `implicit` finds k_i.

The caller evaluates f, because kernels that take functions cannot be cached on disk. So the loop
over the stages stands beside the equation that it integrates (`hydrosim.stepping.stepper`, or a
test's own loop):

    for i in range(1, c.size):
        stage_state(i, tableau, h, y, k, Y)
        k[i] = f(t + c[i] * h, Y)
    advance_state(tableau, h, y, k, y_new)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import assign, kernel

EXPLICIT, IMPLICIT = range(2)
"""Values of `Tableau.code`: how the stages are found."""


class Tableau(NamedTuple):
    """Butcher tableau: ``a`` (s, s) lower triangular with a_11 = 0, ``b``, ``c`` (s,).

    ``error`` (s,) holds the differences of ``b`` and the embedded weights, or zeros without an
    embedded method. ``code`` tells `hydrosim.stepping.stepper` how to find the stages. ``closes``
    is true for an explicit method whose last stage is the end of the step: its derivative begins
    the next step (Dormand & Prince 1980).
    """

    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    error: np.ndarray
    order: int
    code: int
    closes: bool


def tableau(
    a: list[list[float]], b: list[float], order: int, embedded: list[float] | None = None
) -> Tableau:
    """Tableau from the rows of ``a`` below the first; ``c`` are the row sums."""
    matrix = np.zeros((len(b), len(b)))
    for i, row in enumerate(a, start=1):
        matrix[i, : len(row)] = row
    weights = np.array(b)
    error = weights - (weights if embedded is None else np.array(embedded))
    code = IMPLICIT if np.diag(matrix).any() else EXPLICIT
    closes = code == EXPLICIT and np.array_equal(matrix[-1], weights)
    return Tableau(matrix, weights, matrix.sum(axis=1), error, order, code, closes)


@kernel
def stage_state(i, method, h, y, k, out):
    """State of stage ``i`` from the derivatives ``k`` (s, ny) of the stages before it."""
    _combine(method.a[i, :i], h, y, k, out)


@kernel
def advance_state(method, h, y, k, out):
    """State at the end of the step from all stage derivatives ``k`` (s, ny)."""
    _combine(method.b, h, y, k, out)


@kernel
def _combine(weights, h, y, k, out):
    """``out`` = y + h sum of the first rows of k by their ``weights``, in one pass for each."""
    begun = False
    for j in range(weights.size):
        weight = h * weights[j]
        if weight != 0.0:
            base = out if begun else y
            for m in range(y.size):
                out[m] = base[m] + weight * k[j, m]
            begun = True
    if not begun:
        assign(out, y)


@kernel
def hermite(theta, h, y0, f0, y1, f1, out):
    """Cubic through both ends of a step with their derivatives, at ``theta`` in [0, 1]. Its error
    is h^4/384 max |y''''| (Hairer, Norsett & Wanner 1993, II.6). A constant state stays constant to
    the last bit: tables are kept while the states that they depend on do not change."""
    c = theta - 1.0
    a = theta * theta * (3.0 - 2.0 * theta)
    b0 = h * theta * c * c
    b1 = h * theta * theta * c
    for m in range(y0.size):
        out[m] = y0[m] + a * (y1[m] - y0[m]) + b0 * f0[m] + b1 * f1[m]
