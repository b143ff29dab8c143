"""Rational approximation of a matrix of transfer functions, with shared stable poles.

Vector fitting finds poles and residues (Gustavsen and Semlyen 1999, relaxed as in Gustavsen 2006):
linear least squares only, without a starting guess of any quality. Balanced truncation then drops
the states that matter least (Moore 1981), which keeps the rest stable.

Poles are given as (np,) complex: real ones first, then of each pair the one with positive
imaginary part. ``s`` (ns,) are points i w.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.linalg

ITERATIONS = 8  # relocations of the poles; they settle in 4 to 6
NEGLIGIBLE = 1e-10  # Hankel singular values below this part of the largest are rounding


class Modes(NamedTuple):
    """A linear system in modal form, every pole of a pair written out: K^(s) = c (s - p)^-1 b."""

    poles: np.ndarray  # (k,)
    c: np.ndarray  # (m, k)
    b: np.ndarray  # (k, m)

    def transfer_function(self, s: np.ndarray) -> np.ndarray:
        """K^ at the points s (ns,): (ns, m, m)."""
        return np.einsum("ik,sk,kj->sij", self.c, 1.0 / (s[:, None] - self.poles), self.b)

    def impulse_response(self, time: np.ndarray) -> np.ndarray:
        """K(t) = c exp(p t) b at the times (nt,): (nt, m, m)."""
        wave = np.exp(np.multiply.outer(time, self.poles))
        return np.einsum("ik,tk,kj->tij", self.c, wave, self.b).real


def vector_fit(s: np.ndarray, values: np.ndarray, order: int) -> tuple[np.ndarray, np.ndarray]:
    """Poles, ``order`` of them counting pairs twice (even), and residues of ``values`` (ns, ne).

    The residues (order, ne) belong to the functions of `partial_fractions`.
    """
    top = np.abs(s).max()
    poles = np.arange(1, order // 2 + 1) * top / (order // 2) * (-0.1 + 1j)
    for _ in range(ITERATIONS):
        poles = _relocated(s, values, poles)
    fractions = _stacked(partial_fractions(s, poles))
    return poles, np.linalg.lstsq(fractions, _stacked(values), rcond=None)[0]


def partial_fractions(s: np.ndarray, poles: np.ndarray) -> np.ndarray:
    """Functions with real coefficients that span the poles, (ns, order).

    1/(s - p) for a real pole; 1/(s - p) + 1/(s - p*) and i/(s - p) - i/(s - p*) for a pair.
    """
    columns = []
    for p in poles:
        upper = 1.0 / (s - p)
        if p.imag == 0.0:
            columns.append(upper)
        else:
            lower = 1.0 / (s - np.conj(p))
            columns += [upper + lower, 1j * (upper - lower)]
    return np.array(columns).T


def _relocated(s: np.ndarray, values: np.ndarray, poles: np.ndarray) -> np.ndarray:
    """Zeros of the weight sigma(s) with which sigma * values has the given poles: better poles.

    sigma = d + sum c_k phi_k; the mean of its real part over s is held at 1 (the relaxation).
    """
    fractions = partial_fractions(s, poles)
    sigma = np.column_stack([fractions, np.ones_like(s)])
    own = np.linalg.qr(_stacked(fractions))[0]
    # what no residues can take up, for all entries: (2 ns, ne, order + 1)
    rest = _stacked(values[:, :, None] * sigma[:, None, :])
    rest -= np.tensordot(own, np.tensordot(own, rest, (0, 0)), 1)
    size = np.linalg.norm(values)
    system = np.vstack([rest.reshape(-1, sigma.shape[1]), size * sigma.real.mean(axis=0)])
    right = np.append(np.zeros(len(system) - 1), size)
    c = np.linalg.lstsq(system, right, rcond=None)[0]
    A, b = pole_blocks(poles)
    return _stable_upper(np.linalg.eigvals(A - np.outer(b, c[:-1]) / c[-1]))


def _stable_upper(eigenvalues: np.ndarray) -> np.ndarray:
    """Eigenvalues of a real matrix, mirrored to the stable side, in this module's order."""
    poles: np.ndarray = -np.abs(eigenvalues.real) + 1j * eigenvalues.imag
    return np.concatenate([poles[poles.imag == 0.0], poles[poles.imag > 0.0]])


def _stacked(values: np.ndarray) -> np.ndarray:
    return np.concatenate([values.real, values.imag])


def pole_blocks(poles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A (order, order) and b (order,), real, with (s - A)^-1 b the `partial_fractions`."""
    blocks, b = [], []
    for p in poles:
        if p.imag == 0.0:
            blocks.append(np.array([[p.real]]))
            b.append(1.0)
        else:
            blocks.append(np.array([[p.real, p.imag], [-p.imag, p.real]]))
            b += [2.0, 0.0]
    return scipy.linalg.block_diag(*blocks), np.array(b)


def realisation(
    poles: np.ndarray, residues: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A, B, C of the fit of an (m, m) matrix from its residues (order, m, m): m states per pole."""
    m = residues.shape[1]
    A, b = pole_blocks(poles)
    return np.kron(A, np.eye(m)), np.kron(b[:, None], np.eye(m)), np.hstack(list(residues))


def balanced(
    A: np.ndarray, B: np.ndarray, C: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The system in coordinates in which its states are equally controllable and observable,
    most important first: the first k states are the balanced truncation to order k."""
    controllable = _factor(scipy.linalg.solve_continuous_lyapunov(A, -B @ B.T))
    observable = _factor(scipy.linalg.solve_continuous_lyapunov(A.T, -C.T @ C))
    U, hankel, Vt = np.linalg.svd(observable.T @ controllable)
    k = int(np.sum(hankel > NEGLIGIBLE * hankel[0]))
    root = np.sqrt(hankel[:k])
    T, inverse = controllable @ Vt[:k].T / root, (U[:, :k] / root).T @ observable.T
    return inverse @ A @ T, inverse @ B, C @ T


def modes(A: np.ndarray, B: np.ndarray, C: np.ndarray) -> Modes:
    """Modal form of a system, rows of b and columns of c scaled to the same norm."""
    poles, vectors = np.linalg.eig(A)
    b, c = np.linalg.solve(vectors, B), C @ vectors
    ratio = np.sqrt(np.linalg.norm(c, axis=0) / np.linalg.norm(b, axis=1))
    return Modes(poles.astype(complex), c / ratio, b * ratio[:, None])


def _factor(gramian: np.ndarray) -> np.ndarray:
    """L with L L^T the symmetric positive semi-definite matrix, up to rounding."""
    eigenvalues, vectors = np.linalg.eigh(0.5 * (gramian + gramian.T))
    return vectors * np.sqrt(np.maximum(eigenvalues, 0.0))
