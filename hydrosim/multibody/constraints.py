"""Rigid constraints J x = c on the solution of H x = Q + J^T lambda, by elimination.

Each row of J is solved for its pivot, the coordinate with its largest entry. The equations of the
other coordinates remain (Wehage & Haug 1982). So constraints hold exactly, not to a residual. A row
that depends on earlier rows is dropped: it has no force. `find_rank` finds such rows in a metric
where lengths and angles compare.

    fill J, c, number;  solve_for_pivots;  eliminate;  solve H x = Q;  find_forces;  restore
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import assign, clear, kernel, root_giving
from hydrosim.multibody.mass import cholesky_solve

DROPPED = -1  # pivot of a row that depends on earlier rows
ENTRY_ROUNDING = 1e-10  # of a row's largest entry: what elimination leaves of it is rounding
ROW_ROUNDING = 1e-20  # of the size of a row: what is left of it is rounding
MIN_SQUARED_SINE = 1e-10  # squared sine of the angle between a row and the span of earlier ones


class Constraints(NamedTuple):
    """Scratch for up to r constraints on n coordinates.

    Constraints: rows ``J`` (r, n) and ``bound`` c (r,), ``force`` lambda (r,), and their ``number``
    (1,). Elimination: the ``pivot`` (r,) of each row, the ``combination`` (r, r) of given rows that
    each row has become, and the equations of the pivots, ``inertia`` (r, n) and ``load`` (r,). The
    pivot of a dependent row is `DROPPED`.
    """

    J: np.ndarray
    bound: np.ndarray
    force: np.ndarray
    number: np.ndarray
    pivot: np.ndarray
    combination: np.ndarray
    inertia: np.ndarray
    load: np.ndarray


def new_constraints(most: int, n: int) -> Constraints:
    """Scratch for up to ``most`` constraints on ``n`` coordinates."""
    whole = np.zeros(1, dtype=np.int64), np.zeros(most, dtype=np.int64)
    square, wide = np.zeros((most, most)), np.zeros((most, n))
    flat = np.zeros(most)
    return Constraints(wide, flat, flat.copy(), *whole, square, wide.copy(), flat.copy())


@kernel
def solve_for_pivots(p):
    """Gauss-Jordan elimination: each row of J becomes 1 at its pivot and 0 at the pivots of the
    other rows."""
    for i in range(p.number[0]):
        clear(p.combination[i])
        p.combination[i, i] = 1.0
        p.load[i] = ENTRY_ROUNDING * abs(p.J[i, _largest_entry(p.J[i])])
    for i in range(p.number[0]):
        p.pivot[i] = _largest_entry(p.J[i])
        if abs(p.J[i, p.pivot[i]]) <= p.load[i]:
            p.pivot[i] = DROPPED
            continue
        _scale_row(i, 1.0 / p.J[i, p.pivot[i]], p)
        p.J[i, p.pivot[i]] = 1.0
        for k in range(p.number[0]):
            if k != i and (k > i or p.pivot[k] != DROPPED):
                _add_row(i, k, -p.J[k, p.pivot[i]], p)


@kernel
def _largest_entry(row):
    """Index of the entry with the largest absolute value."""
    best = 0
    for j in range(row.size):
        if abs(row[j]) > abs(row[best]):
            best = j
    return best


@kernel
def _scale_row(i, factor, p):
    p.bound[i] *= factor
    for j in range(p.J.shape[1]):
        p.J[i, j] *= factor
    for j in range(p.number[0]):
        p.combination[i, j] *= factor


@kernel
def _add_row(i, k, factor, p):
    """Add ``factor`` times row i to row k."""
    p.bound[k] += factor * p.bound[i]
    for j in range(p.J.shape[1]):
        p.J[k, j] += factor * p.J[i, j]
    for j in range(p.number[0]):
        p.combination[k, j] += factor * p.combination[i, j]


@kernel
def eliminate(p, H, Q):
    """Turn ``H`` (n, n) and ``Q`` (n,) into T^T H T and T^T (Q - H c), where x = T x + c. The
    pivots of this x are zero."""
    n = Q.size
    for k in range(p.number[0]):
        if p.pivot[k] == DROPPED:
            continue
        for i in range(n):
            held = H[i, p.pivot[k]]
            Q[i] -= held * p.bound[k]
            for j in range(n):
                H[i, j] -= held * p.J[k, j]
    reduce_load(p, Q)
    for k in range(p.number[0]):
        if p.pivot[k] == DROPPED:
            continue
        for j in range(n):
            p.inertia[k, j] = H[p.pivot[k], j]
        for i in range(n):
            for j in range(n):
                H[i, j] -= p.J[k, i] * p.inertia[k, j]
    for k in range(p.number[0]):
        if p.pivot[k] != DROPPED:
            H[p.pivot[k], p.pivot[k]] = 1.0


@kernel
def reduce_load(p, Q):
    """Turn ``Q`` (n,) into T^T Q, and keep what its pivots had."""
    for k in range(p.number[0]):
        if p.pivot[k] == DROPPED:
            continue
        p.load[k] = Q[p.pivot[k]]
        for i in range(Q.size):
            Q[i] -= p.J[k, i] * p.load[k]


@kernel
def find_forces(p, x):
    """Compute lambda of the given rows from the solution ``x``, whose pivots are still zero."""
    clear(p.force)
    for k in range(p.number[0]):
        if p.pivot[k] == DROPPED:
            continue
        missing = -p.load[k]
        for j in range(x.size):
            missing += p.inertia[k, j] * x[j]
        for i in range(p.number[0]):
            p.force[i] += p.combination[k, i] * missing


@kernel
def restore_pivots(p, x):
    """Set the pivots of ``x`` (n,) such that J x = c."""
    for k in range(p.number[0]):
        if p.pivot[k] == DROPPED:
            continue
        missing = p.bound[k]
        for j in range(x.size):
            missing -= p.J[k, j] * x[j]
        x[p.pivot[k]] += missing


@root_giving(float)
def find_rank(p, L, size):
    """Mark the rows of J that depend on earlier ones: their ``pivot`` becomes `DROPPED`. ``L`` is
    the factor of H (n, n), see `cholesky`. A row whose J H^-1 J^T is rounding of its ``size`` (r,)
    holds what cannot move.

    Rows are compared in J H^-1 J^T, so that metres and radians compare. Returns the smallest sine
    of the angle between a kept row and the span of the rows before it.
    """
    least = 1.0
    for i in range(p.number[0]):
        assign(p.inertia[i], p.J[i])
        cholesky_solve(L, p.inertia[i])
    for i in range(p.number[0]):
        clear(p.combination[i])
        for k in range(i):
            if p.pivot[k] != DROPPED:
                _projected_entry(i, k, p)
        row_inertia = _dot_product(p.J[i], p.inertia[i])
        left = row_inertia
        for k in range(i):
            left -= p.combination[i, k] * p.combination[i, k]
        if left <= MIN_SQUARED_SINE * row_inertia or row_inertia <= ROW_ROUNDING * size[i]:
            p.pivot[i] = DROPPED
            clear(p.combination[i])
            continue
        p.pivot[i] = 0
        p.combination[i, i] = sqrt(left)
        least = min(least, sqrt(left / row_inertia))
    return least


@kernel
def _projected_entry(i, k, p):
    """Entry (i, k) of the Cholesky factor of J H^-1 J^T."""
    entry = _dot_product(p.J[i], p.inertia[k])
    for s in range(k):
        entry -= p.combination[i, s] * p.combination[k, s]
    p.combination[i, k] = entry / p.combination[k, k]


@kernel
def _dot_product(a, b):
    total = 0.0
    for j in range(a.size):
        total += a[j] * b[j]
    return total
