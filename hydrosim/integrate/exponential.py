"""Linear systems z' = J z + G f(t), propagated exactly over intervals.

    z(t + h) = exp(J h) z(t) + int_0^h exp(J (h - s)) G f(t + s) ds

f is known at nodes h apart. Between two nodes it is replaced by the polynomial through the 8 nodes
around them. Its error for a component of frequency w is at most 1.1e-3 (w h)^8 of the amplitude.

The integral of this polynomial is exact: the integral and exp(J h) are blocks of one matrix
exponential (Van Loan 1978). It exists for any J, also with zero eigenvalues or too few
eigenvectors.
"""

from __future__ import annotations

from math import factorial
from typing import NamedTuple

import numpy as np
from scipy import linalg

from hydrosim.jit.kernels import kernel

POLYNOMIAL_NODES = 8  # of the polynomial between two nodes
NODES_BESIDE = POLYNOMIAL_NODES // 2 - 1  # nodes needed on either side of an interval
AREA_NODES = 6  # of the polynomials integrated for a quadrature


class PropagationInterval(NamedTuple):
    """Matrices of an interval in p parts. z after i parts is ``states[i] @ z + loads[i] @ f``, with
    z at the start and f at p + 1 + 2 `NODES_BESIDE` nodes, the first `NODES_BESIDE` parts before
    the start. ``states`` (p + 1, m, m), ``loads`` (p + 1, m, nodes * n)."""

    states: np.ndarray
    loads: np.ndarray


def propagation_interval(
    J: np.ndarray, G: np.ndarray, length: float, parts: int
) -> PropagationInterval:
    """The interval of this ``length`` [s] for J (m, m) and G (m, n)."""
    m, n = G.shape
    E, W = _part_matrices(J, G, length / parts)
    states = np.empty((parts + 1, m, m))
    loads = np.zeros((parts + 1, m, parts + POLYNOMIAL_NODES - 1, n))
    states[0] = np.eye(m)
    for i in range(parts):
        states[i + 1] = E @ states[i]
        loads[i + 1] = np.tensordot(E, loads[i], 1)
        loads[i + 1, :, i : i + POLYNOMIAL_NODES] += W
    return PropagationInterval(states, loads.reshape(parts + 1, m, -1))


def _part_matrices(J: np.ndarray, G: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    """exp(J h), and the weights (m, `POLYNOMIAL_NODES`, n) of f at the nodes from `NODES_BESIDE`
    parts before.

    The matrix exponential covers z and the derivatives of the polynomial over the time h. J is
    balanced first, because the units of the states set the sizes of its entries.
    """
    m, n = G.shape
    balanced, (scale, _) = linalg.matrix_balance(J, permute=False, separate=True)
    whole = np.zeros((m + POLYNOMIAL_NODES * n,) * 2)
    whole[:m, :m] = h * balanced
    whole[:m, m : m + n] = h * G / scale[:, None]
    whole[m:-n, m + n :] = np.eye((POLYNOMIAL_NODES - 1) * n)
    top = scale[:, None] * linalg.expm(whole)[:m]
    W = np.einsum(
        "mdn,dj->mjn", top[:, m:].reshape(m, POLYNOMIAL_NODES, n), _polynomial_derivatives()
    )
    return top[:, :m] / scale, W


def _polynomial_derivatives() -> np.ndarray:
    """Derivatives at 0 (`POLYNOMIAL_NODES`, `POLYNOMIAL_NODES`), one a row, of the polynomials, one
    a column, that are 1 at one of the nodes -`NODES_BESIDE`, ... and 0 at the others."""
    nodes = np.arange(POLYNOMIAL_NODES) - NODES_BESIDE
    factorials = np.array([factorial(d) for d in range(POLYNOMIAL_NODES)])
    return np.array([_lagrange_basis(nodes, j) * factorials for j in range(POLYNOMIAL_NODES)]).T


def _lagrange_basis(nodes: np.ndarray, j: int) -> np.ndarray:
    """Coefficients, constant first, of the polynomial that is 1 at node j and 0 at the others."""
    others = np.delete(nodes, j)
    return np.poly(others)[::-1] / np.prod(nodes[j] - others)


def extend_nodes(f: np.ndarray) -> np.ndarray:
    """f (nodes, n) with `NODES_BESIDE` more nodes at both ends, on the polynomials through the
    first and last `POLYNOMIAL_NODES`. So the first and last parts also use these polynomials."""
    before = WEIGHTS_BESIDE.T @ f[:POLYNOMIAL_NODES]
    after = WEIGHTS_BESIDE.T[::-1] @ f[: -POLYNOMIAL_NODES - 1 : -1]
    return np.concatenate([before, f, after])


def _weights_beside() -> np.ndarray:
    beyond = np.arange(-NODES_BESIDE, 0)
    basis = np.array(
        [_lagrange_basis(np.arange(POLYNOMIAL_NODES), j) for j in range(POLYNOMIAL_NODES)]
    )
    return np.asarray(basis @ np.power.outer(beyond, np.arange(POLYNOMIAL_NODES)).T.astype(float))


WEIGHTS_BESIDE = _weights_beside()
"""Weights (`POLYNOMIAL_NODES`, `NODES_BESIDE`) of the first nodes for the nodes before them."""


def area_weights(parts: int) -> np.ndarray:
    """Weights (parts + 1,) of values at the nodes of an interval for its integral, per length of a
    part. They integrate polynomials through 6 nodes and are exact to the fifth degree."""
    weights = np.zeros(parts + 1)
    for i in range(parts):
        first = min(max(i - AREA_NODES // 2 + 1, 0), parts + 1 - AREA_NODES)
        nodes = np.arange(first, first + AREA_NODES) - i
        for j in range(AREA_NODES):
            weights[first + j] += np.sum(_lagrange_basis(nodes, j) / np.arange(1, AREA_NODES + 1))
    return weights


@kernel
def fill_recursion(transposed, z):
    """Turn the rows of ``z`` (nk + 1, m), which hold a state and then drives, into the states z_k+1
    = E z_k + drive_k+1; ``transposed`` is E^T (m, m)."""
    for k in range(z.shape[0] - 1):
        for j in range(z.shape[1]):
            x = z[k, j]
            column = transposed[j]
            row = z[k + 1]
            for i in range(row.size):
                row[i] += x * column[i]
