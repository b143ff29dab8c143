"""Passivity of a state-space model: no motion may gain energy from the waves that it radiates.

The condition is Re K^(i w) >= 0, as a matrix, at all frequencies. Radiation is reciprocal, K^ =
K^^T. So a model in modal form is K^(s) = B^T S (s - Lambda)^-1 B with S = diag(+-1), and a change
of B keeps it reciprocal and keeps its poles.

If an eigenvalue of Re K^ is negative, the smallest change of B is found that lifts it to first
order. All other small eigenvalues are held above zero. This is repeated until all are positive
(Gustavsen 2008, fast residue perturbation, in other variables).

Eigenvalues are multiplied by 1 + (w / w_0)^2, so that the limit w -> infinity, where Re K^ falls as
w^-2, counts like any other frequency.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import scipy.linalg

if TYPE_CHECKING:
    from hydrosim.water.radiation.rational import Weight

GRID = 400  # frequencies, in addition to those about each pole
# a minimum is sought between its neighbours: number of rounds, and of points in each
ZOOMS, FINER = 5, 9
# distances of frequencies from a pole, in units of its real part
ABOUT_POLES = np.linspace(-4.0, 4.0, 9)
ROUNDING = 1e-7  # of the largest eigenvalue: treated as zero, where motions do not make waves
AIM = 1e-6  # of the largest: negative eigenvalues are lifted to this
HELD = 0.05  # of the largest: eigenvalues below this are held above zero
PASSES = 15


@dataclass(frozen=True, eq=False)
class Reciprocal:
    """K^(s) = B^T S (s - Lambda)^-1 B, Lambda of blocks a, or [[a, w], [-w, a]] with S = 1, -1.

    States: real poles, then the first states of all pairs, then their second states.
    """

    decay: np.ndarray  # (states,), a of every state
    rotation: np.ndarray  # (pairs,), w
    sign: np.ndarray  # (states,), diagonal of S
    B: np.ndarray  # (states, m)

    def resolved(self, s: np.ndarray) -> np.ndarray:
        """(s - Lambda)^-1 B at the points s (ns,): (ns, states, m)."""
        real = self.decay.size - 2 * self.rotation.size
        first, second = np.split(np.arange(real, self.decay.size), 2)
        x = s[:, None] - self.decay
        result = np.empty((s.size, *self.B.shape), dtype=complex)
        result[:, :real] = self.B[:real] / x[:, :real, None]
        x, w = x[:, first, None], self.rotation[:, None]
        size = x * x + w * w
        result[:, first] = (x * self.B[first] + w * self.B[second]) / size
        result[:, second] = (x * self.B[second] - w * self.B[first]) / size
        return result

    def transfer_function(self, s: np.ndarray) -> np.ndarray:
        """K^ at the points s (ns,): (ns, m, m)."""
        return (self.B.T * self.sign) @ self.resolved(s)

    @property
    def matrix(self) -> np.ndarray:
        """Lambda, (states, states)."""
        result = np.diag(self.decay)
        pairs = self.rotation.size
        first = self.decay.size - 2 * pairs + np.arange(pairs)
        result[first, first + pairs] = self.rotation
        result[first + pairs, first] = -self.rotation
        return result


def make_passive(
    model: Reciprocal, band: float, emphasis: Weight
) -> tuple[Reciprocal, float, float]:
    """The passive model nearest to ``model``, with errors weighted by the ``emphasis``.

    Also returns the smallest over the largest eigenvalue of (1 + (w / band)^2) Re K^(i w) over all
    w, before and after. A value below -`ROUNDING` means that no passive model was found.
    """
    place, value = _find_smallest_damping(model, band)
    first = last = value.min()
    for _ in range(PASSES):
        if last >= -ROUNDING:
            break
        model = _lift_damping(model, band, emphasis, place, value)
        place, value = _find_smallest_damping(model, band)
        last = value.min()
    return model, float(first), float(last)


def _find_damping(model: Reciprocal, w: np.ndarray, band: float) -> tuple[np.ndarray, np.ndarray]:
    """Re (i w - Lambda)^-1 B times 1 + (w / band)^2 (nw, states, m), infinite w included; and the
    same of K^ (nw, m, m)."""
    finite = np.isfinite(w)
    at = np.where(finite, w, 0.0)
    resolved = (1.0 + (at / band) ** 2)[:, None, None] * model.resolved(1j * at).real
    resolved[~finite] = -(model.matrix @ model.B) / band**2
    whole = (model.B.T * model.sign) @ resolved
    return resolved, 0.5 * (whole + np.swapaxes(whole, 1, 2))


def _find_smallest_damping(model: Reciprocal, band: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies with small eigenvalues of the damping, including minima, as angles atan(w / band)
    (k,), and these eigenvalues relative to the largest (k, m), ascending."""

    def eigenvalues(angle: np.ndarray) -> np.ndarray:
        return np.linalg.eigvalsh(_find_damping(model, _angle_to_frequency(angle, band), band)[1])

    angles = _search_grid(model, band)
    value = eigenvalues(angles)
    weight = np.cos(angles) ** 2  # removes the factor 1 + (w / band)^2
    largest = max(np.abs(value * weight[:, None]).max(), np.finfo(float).tiny)
    inner = np.pad(value, ((1, 1), (0, 0)), mode="edge")
    small = value < HELD * largest
    i, j = np.nonzero(small & (value <= inner[:-2]) & (value <= inner[2:]))
    low, high = angles[np.maximum(i - 1, 0)], angles[np.minimum(i + 1, angles.size - 1)]
    rows = np.arange(i.size)
    for _ in range(ZOOMS):  # all minima at once
        x = np.linspace(low, high, FINER, axis=1)
        at = eigenvalues(x.ravel()).reshape(*x.shape, model.B.shape[1])
        least = at[rows, :, j].argmin(axis=1)
        low, high = x[rows, np.maximum(least - 1, 0)], x[rows, np.minimum(least + 1, FINER - 1)]
    ends = np.array([0.0, 0.5 * np.pi])
    place = np.unique(np.concatenate([angles[small.any(axis=1)], 0.5 * (low + high), ends]))
    return place, eigenvalues(place) / largest


def _angle_to_frequency(angle: np.ndarray, band: float) -> np.ndarray:
    return np.where(angle < 0.5 * np.pi, band * np.tan(angle), np.inf)


def _search_grid(model: Reciprocal, band: float) -> np.ndarray:
    """Angles atan(w / band) from 0 to pi / 2, denser about the poles."""
    pairs = model.rotation.size
    decay = -model.decay[model.decay.size - pairs :] if pairs else np.empty(0)
    about = model.rotation[:, None] + decay[:, None] * ABOUT_POLES
    angles = np.arctan(np.maximum(about.ravel(), 0.0) / band)
    return np.unique(np.append(np.linspace(0.0, 0.5 * np.pi, GRID), angles))


def _lift_damping(
    model: Reciprocal, band: float, emphasis: Weight, place: np.ndarray, value: np.ndarray
) -> Reciprocal:
    """The model with the smallest change of B, in the mean square of W K^ over frequencies. To
    first order it lifts negative eigenvalues to `AIM` and lowers no other below it."""
    resolved, damping = _find_damping(model, _angle_to_frequency(place, band), band)
    eigenvalues, vectors = np.linalg.eigh(damping)
    i = np.unravel_index(np.abs(value).argmax(), value.shape)
    largest = eigenvalues[i] / value[i]
    k, j = np.nonzero(value < HELD)
    u = vectors[k, :, j]
    gramian = emphasis.gramian(model.matrix, model.B) * np.outer(model.sign, model.sign)
    floor = 1e-9 * np.trace(gramian) * np.eye(len(gramian))
    root = np.linalg.cholesky(gramian + floor)
    # d(u Re K^ u) = 2 (dB u) S Re(s - Lambda)^-1 B u
    rows = 2.0 * model.sign * np.einsum("ksm,km->ks", resolved[k], u)
    rows = scipy.linalg.solve_triangular(root, rows.T, lower=True).T
    slopes = np.einsum("ks,km->ksm", rows, u).reshape(k.size, -1)
    now = value[k, j]
    aim = np.where(now < -ROUNDING, AIM, np.minimum(now, AIM))
    change = _find_least_change(slopes, (aim - now) * largest).reshape(model.B.shape)
    return replace(model, B=model.B + scipy.linalg.solve_triangular(root.T, change))


def _find_least_change(G: np.ndarray, h: np.ndarray) -> np.ndarray:
    """The shortest x with G x >= h, by non-negative least squares (Lawson & Hanson 1974, 23.4).
    Rows of zeros, which no x changes, do not count."""
    from scipy.optimize import nnls  # slow to load, and not needed where fits are in the cache

    size = np.linalg.norm(G, axis=1)
    if not np.any(size):
        return np.zeros(G.shape[1])
    G, h = G[size > 0.0] / size[size > 0.0, None], h[size > 0.0] / size[size > 0.0]
    scale = np.abs(h).max()
    dual = nnls(np.vstack([G.T, h / scale]), np.append(np.zeros(G.shape[1]), 1.0), maxiter=10000)[0]
    rest = np.append(G.T @ dual, h @ dual / scale - 1.0)
    return -scale * rest[:-1] / rest[-1]
