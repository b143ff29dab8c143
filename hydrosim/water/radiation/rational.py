"""Rational approximation of a matrix of transfer functions, with shared stable poles.

Vector fitting finds poles and residues (Gustavsen and Semlyen 1999, relaxed as in Gustavsen 2006).
It needs only linear least squares and no good starting guess. Balanced truncation then drops the
states that matter least (Moore 1981; Enns 1984 with weights).

Poles are given as (np,) complex: real ones first, then of each pair the one with positive imaginary
part. ``s`` (ns,) are points i w.

Weight of each frequency in a fit: low frequencies count more, because small forces matter to
slow motions.

The relative change of a motion is the change of K^ over the impedance, which is about i w (M + A).
So the same error of K^ has the more effect, the slower the motion. Errors of K^ are therefore
multiplied by |W(i w)|, W(s) = (s + b) / (s + a), which is 1 above b and `RATIO` below a. Since W is
a filter, balanced truncation still needs only matrix equations: frequency-weighted Gramians (Enns
1984).
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
import scipy.linalg

RATIO = 10.0  # b / a


class Weight(Protocol):
    """Weight of errors of K^ at each frequency."""

    def at(self, w: np.ndarray) -> np.ndarray:
        """|W(i w)| at the frequencies w (nw,) [rad/s]."""
        ...

    def gramian(self, A: np.ndarray, B: np.ndarray) -> np.ndarray:
        """The Gramian of the states of A and inputs B, weighted by W over all frequencies w:
        (1 / (2 pi)) int |W|^2 (i w - A)^-1 B B^T (i w - A)^-H dw."""
        ...


class Emphasis(NamedTuple):
    """W(s) = (s + b) / (s + a); ``corner`` b [rad/s], ``ratio`` b / a."""

    corner: float
    ratio: float = RATIO

    @property
    def low(self) -> float:
        """a [rad/s]."""
        return self.corner / self.ratio

    def at(self, w: np.ndarray) -> np.ndarray:
        """|W(i w)|, at least 1."""
        return np.abs((1j * w + self.corner) / (1j * w + self.low))

    def gramian(self, A: np.ndarray, B: np.ndarray) -> np.ndarray:
        """P = 1 / 2 pi int |W|^2 (i w - A)^-1 B B^T (i w - A)^-H dw: the Gramian of the states of A
        in W (s - A)^-1 B, which has one more state for each column of B."""
        n, m = B.shape
        joined = np.block([[A, (self.corner - self.low) * B], [np.zeros((m, n)), np.zeros((m, m))]])
        joined[n:, n:] -= self.low * np.eye(m)
        driven = np.vstack([B, np.eye(m)])
        return scipy.linalg.solve_continuous_lyapunov(joined, -driven @ driven.T)[:n, :n]


def find_emphasis(w: np.ndarray, target: np.ndarray) -> Emphasis:
    """Emphasis whose corner is the frequency of the largest ``target`` (nw, m, m). ``w`` (nw,)
    rises from 0; w = 0 does not count, because nothing radiates there."""
    return Emphasis(float(w[1 + np.abs(target[1:]).max(axis=(1, 2)).argmax()]))


ITERATIONS = 8  # relocations of the poles; they converge in 4 to 6
DAMPED = 0.5  # smallest damping ratio of poles that are moved back to the fastest allowed
# smallest damping ratio of poles beyond the band, where a weakly damped one would ring between the
# points of a fit
RINGING = 0.03
NEGLIGIBLE = 1e-10  # Hankel singular values below this part of the largest are rounding


class Modes(NamedTuple):
    """A linear system in modal form, with both poles of every pair: K^(s) = c (s - p)^-1 b."""

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


def vector_fit(
    s: np.ndarray,
    values: np.ndarray,
    order: int,
    weight: np.ndarray | None = None,
    fastest: float = np.inf,
    band: float = np.inf,
) -> tuple[np.ndarray, np.ndarray]:
    """Poles, ``order`` of them counting pairs twice (even), and residues of ``values`` (ns, ne),
    whose errors are multiplied by ``weight`` (ns,). No pole is farther from zero than ``fastest``.
    No pole beyond the ``band`` is weakly damped.

    The residues (order, ne) belong to the functions of `partial_fractions`.
    """
    rows = np.ones((s.size, 1)) if weight is None else weight[:, None]
    top = np.abs(s).max()
    poles = np.arange(1, order // 2 + 1) * top / (order // 2) * (-0.1 + 1j)
    for _ in range(ITERATIONS):
        poles = _keep_within_band(
            fastest, min(band, fastest), _relocate_poles(s, values, poles, rows)
        )
    fractions = _stack_parts(rows * partial_fractions(s, poles))
    return poles, np.linalg.lstsq(fractions, _stack_parts(rows * values), rcond=None)[0]


def _keep_within_band(fastest: float, band: float, poles: np.ndarray) -> np.ndarray:
    """The poles within limits. Poles beyond ``fastest`` are moved to it, with a damping ratio of
    `DAMPED` at least; poles beyond the ``band`` get `RINGING` at least."""
    size = np.abs(poles)
    part = np.maximum(-poles.real / size, np.where(size > fastest, DAMPED, RINGING))
    damped = np.where(poles.imag == 0.0, -1.0, -part + 1j * np.sqrt(1.0 - part**2))
    return np.asarray(np.where(size > band, np.minimum(size, fastest) * damped, poles))


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


def _relocate_poles(
    s: np.ndarray, values: np.ndarray, poles: np.ndarray, rows: np.ndarray
) -> np.ndarray:
    """Better poles: the zeros of the factor sigma(s) for which sigma * values has the given poles.

    sigma = d + sum c_k phi_k; the mean of its real part over s is held at 1 (the relaxation).
    """
    fractions = partial_fractions(s, poles)
    sigma = np.column_stack([fractions, np.ones_like(s)])
    basis = np.linalg.qr(_stack_parts(rows * fractions))[0]
    # the part that no residues can fit, for all entries: (2 ns, ne, order + 1)
    rest = _stack_parts((rows * values)[:, :, None] * sigma[:, None, :])
    rest -= np.tensordot(basis, np.tensordot(basis, rest, (0, 0)), 1)
    size = np.linalg.norm(rows * values)
    # of each entry its triangle alone (Deschrijver et al. 2008)
    small = np.concatenate([np.linalg.qr(entry, mode="r") for entry in rest.transpose(1, 0, 2)])
    system = np.vstack([small, size * sigma.real.mean(axis=0)])
    right = np.append(np.zeros(len(system) - 1), size)
    c = np.linalg.lstsq(system, right, rcond=None)[0]
    A, b = pole_blocks(poles)
    return _keep_stable_upper(np.linalg.eigvals(A - np.outer(b, c[:-1]) / c[-1]))


def _keep_stable_upper(eigenvalues: np.ndarray) -> np.ndarray:
    """Eigenvalues of a real matrix, mirrored to the stable side, in this module's order."""
    poles: np.ndarray = -np.abs(eigenvalues.real) + 1j * eigenvalues.imag
    return np.concatenate([poles[poles.imag == 0.0], poles[poles.imag > 0.0]])


def _stack_parts(values: np.ndarray) -> np.ndarray:
    return np.concatenate([values.real, values.imag])


def pole_blocks(poles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A (order, order) and b (order,), real; (s - A)^-1 b are the `partial_fractions`."""
    blocks, b = [], []
    for p in poles:
        if p.imag == 0.0:
            blocks.append(np.array([[p.real]]))
            b.append(1.0)
        else:
            blocks.append(np.array([[p.real, p.imag], [-p.imag, p.real]]))
            b += [2.0, 0.0]
    return scipy.linalg.block_diag(*blocks), np.array(b)


def balance(
    poles: np.ndarray, residues: np.ndarray, emphasis: Weight
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A, B and C of the fit of a reciprocal (m, m) matrix from its symmetric residues (order, m,
    m), in balanced coordinates: states are equally controllable and observable, most important
    first. The first k states are the balanced truncation to order k.

    The m states per pole have C^T = T B and A^T T = T A with a symmetric T of the residues. So the
    observability Gramian is T P T, with P the controllability Gramian, which is that of the poles
    for each column. With L L^T = P, the eigenvalues of L^T T L have the Hankel singular values as
    magnitudes, and the signs of a model in reciprocal form.
    """
    m = residues.shape[1]
    A, b = pole_blocks(poles)
    eye = np.eye(m)
    T = _find_symmetriser(poles, residues)
    factor = np.kron(_factor(emphasis.gramian(A, b[:, None])), eye)
    hankel, V = np.linalg.eigh(factor.T @ T @ factor)
    size = np.abs(hankel)
    kept = np.argsort(-size)[: np.sum(size > NEGLIGIBLE * size.max())]
    root = np.sqrt(size[kept])
    to = factor @ V[:, kept] / root
    back = np.sign(hankel[kept])[:, None] * to.T @ T
    return back @ np.kron(A, eye) @ to, back @ np.kron(b[:, None], eye), np.hstack([*residues]) @ to


def _find_symmetriser(poles: np.ndarray, residues: np.ndarray) -> np.ndarray:
    """The symmetric T of `balanced`: R for a real pole; [[R1, R2], [R2, -R1]] / 2 for a pair."""
    blocks, k = [], 0
    for p in poles:
        if p.imag == 0.0:
            blocks.append(residues[k])
            k += 1
        else:
            one, two = residues[k : k + 2]
            blocks.append(0.5 * np.block([[one, two], [two, -one]]))
            k += 2
    return scipy.linalg.block_diag(*blocks)


def find_modes(A: np.ndarray, B: np.ndarray, C: np.ndarray) -> Modes:
    """Modal form of a system; rows of b and columns of c are scaled to the same norm."""
    poles, vectors = np.linalg.eig(A)
    b, c = np.linalg.solve(vectors, B), C @ vectors
    ratio = np.sqrt(np.linalg.norm(c, axis=0) / np.linalg.norm(b, axis=1))
    return Modes(poles.astype(complex), c / ratio, b * ratio[:, None])


def _factor(gramian: np.ndarray) -> np.ndarray:
    """L with L L^T equal to the symmetric positive semi-definite matrix, up to rounding."""
    eigenvalues, vectors = np.linalg.eigh(0.5 * (gramian + gramian.T))
    return vectors * np.sqrt(np.maximum(eigenvalues, 0.0))
