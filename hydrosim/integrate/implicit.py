"""Implicit stages: Newton's method with a Jacobian that is kept over many steps.

A stage of a diagonally implicit method is k = f(t + c h, Y + g k) with g = h a_ii. From a guess,

    (I - g J) d = f(t + c h, Y + g k) - k,   k += d

is repeated until the change g d is small in units of the tolerances. J is the Jacobian of f over
the ``states`` that f depends on; all other states follow from them without a solution. J is renewed
only if Newton's method has become slow or f itself has changed. The factors of I - g J are valid
for one g. (Hairer & Wanner 1996, IV.8.)

Filters, of which there may be hundreds, are solved one by one,

    x' = a x + b z + ...,   z' = a z - b x + ...

Their effect on the other states follows by iteration. Its rate of convergence is g^2 times the
force per mass that a filter feeds back of a velocity. It is small if the step is short compared
with the periods of the motion.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import assign, kernel

STAGE_TOLERANCE = 1e-4  # fraction of the tolerances of a step to which stages are solved
MAX_ITERATIONS, SLOW_ITERATIONS = 12, 5
STALE, READY = range(2)


class Filters(NamedTuple):
    """Pairs of states x and z of y that decay and rotate by themselves: entries ``one`` and
    ``other`` (p,) with ``decay`` a and ``rotation`` b (p,). ``other`` equals ``one`` if there is no
    z."""

    one: np.ndarray
    other: np.ndarray
    decay: np.ndarray
    rotation: np.ndarray


NO_FILTERS = Filters(*(np.zeros(0, dtype=np.int64),) * 2, *(np.zeros(0),) * 2)


class Newton(NamedTuple):
    """Scratch for Newton's method.

    ``states`` (m,) of y are solved together, ``filters`` one by one. ``J`` and the ``factors`` of I
    - g J are (m, m), the latter with their ``order`` of rows (m,). ``change`` is (m,). ``status``
    (1,) is `STALE` or `READY`, ``weight`` g (1,) is that of the factors, and ``shifted`` (3, ny) is
    work space.
    """

    states: np.ndarray
    filters: Filters
    J: np.ndarray
    factors: np.ndarray
    order: np.ndarray
    change: np.ndarray
    status: np.ndarray
    weight: np.ndarray
    shifted: np.ndarray


def new_newton(states: np.ndarray, size: int, filters: Filters = NO_FILTERS) -> Newton:
    """Scratch for ``states`` (m,) out of ``size`` states; m is 0 for explicit methods."""
    m = states.size
    flags, order = np.zeros(1, dtype=np.int64), np.zeros(m, dtype=np.int64)
    J, factors = np.zeros((m, m)), np.zeros((m, m))
    room = np.zeros((3, size))
    return Newton(states, filters, J, factors, order, np.zeros(m), flags, np.zeros(1), room)


@kernel
def newton_iteration(k, f, y, weight, newton, control):
    """One iteration: update ``k`` (ny,) from ``f`` evaluated at it. Returns the change of the stage
    in units of `STAGE_TOLERANCE` times the tolerances. ``y`` sets the scale of relative
    tolerances."""
    d, states, total = newton.change, newton.states, 0.0
    for i in range(states.size):
        d[i] = f[states[i]] - k[states[i]]
    solve(newton.factors, newton.order, d)
    for i in range(states.size):
        m = states[i]
        scale = STAGE_TOLERANCE * (control.absolute[m] + control.relative * abs(y[m]))
        total += (weight * d[i] / scale) ** 2
        d[i] += k[m]
    total += _improve_filters(k, f, y, weight, newton.filters, control)
    assign(k, f)
    for i in range(states.size):
        k[states[i]] = d[i]
    return sqrt(total / max(states.size + 2 * newton.filters.one.size, 1))


@kernel
def _improve_filters(k, f, y, weight, p, control):
    """Write the updated derivatives of filters into ``f``; returns the sum of squares of the
    changes."""
    total = 0.0
    for i in range(p.one.size):
        m, n = p.one[i], p.other[i]
        a, b = 1.0 - weight * p.decay[i], weight * p.rotation[i]
        r, s = f[m] - k[m], f[n] - k[n]
        det = a * a + b * b
        for j, d in ((m, (a * r + b * s) / det), (n, (a * s - b * r) / det)):
            scale = STAGE_TOLERANCE * (control.absolute[j] + control.relative * abs(y[j]))
            total += (weight * d / scale) ** 2
            f[j] = k[j] + d
    return total


@kernel
def factorise_iteration_matrix(weight, newton):
    """Factorise I - g J for this ``weight`` g."""
    m = newton.states.size
    for i in range(m):
        for j in range(m):
            newton.factors[i, j] = -weight * newton.J[i, j]
        newton.factors[i, i] += 1.0
    factorise(newton.factors, newton.order)
    newton.weight[0] = weight


@kernel
def factorise(A, order):
    """Factors L U of ``A`` in place, with the ``order`` of its rows after partial pivoting."""
    n = A.shape[0]
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(A[i, k]) > abs(A[best, k]):
                best = i
        order[k] = best
        if best != k:
            for j in range(n):
                A[k, j], A[best, j] = A[best, j], A[k, j]
        for i in range(k + 1, n):
            factor = A[i, k] / A[k, k]
            A[i, k] = factor
            if factor != 0.0:
                for j in range(k + 1, n):
                    A[i, j] -= factor * A[k, j]


@kernel
def solve(factors, order, x):
    """Solve A x = x in place by the factors of A."""
    n = x.size
    for k in range(n):
        x[k], x[order[k]] = x[order[k]], x[k]
    for i in range(n):
        for j in range(i):
            x[i] -= factors[i, j] * x[j]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            x[i] -= factors[i, j] * x[j]
        x[i] /= factors[i, i]
