"""Second-order loads: double sums over the waves of a sea, as lines of other frequencies.

Two waves of complex elevations a_i, a_j load a body at the difference of their frequencies, and at
the sum:

    F-(t) = Re sum_ij a_i conj(a_j) T-_ij exp(i (w_i - w_j) t),   T-_ji = conj T-_ij
    F+(t) = Re sum_ij a_i a_j T+_ij exp(i (w_i + w_j) t),         T+_ji = T+_ij

Every transfer function here has few factors, T_ij = sum_rs C_rs W_ri W_sj. So sums over pairs of
waves become sums over pairs of filtered elevations. Fourier transforms give these for all waves of
a grid:

    F-(t) = Re sum_rs C_rs z_r conj(z_s),   F+(t) = Re sum_rs C_rs z_r z_s,
    z_r(t) = sum_i W_ri a_i exp(i w_i t)

The factors of Newman's approximation are drift coefficients. The factors of a quadratic transfer
function are the splines that interpolate it (`quadratic`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy

from hydrosim.errors import InputError
from hydrosim.waves.synthesis import SpectralLines

if TYPE_CHECKING:
    from hydrosim.waves.components import WaveComponents

MOST_WAVES = 60  # waves off a grid: their pairs are summed one by one, at every stage of every step


@dataclass(frozen=True, eq=False)
class Factors:
    """T_ij of n loads for nw waves: ``weights`` W (r, nw) and ``core`` C (n, r, r)."""

    weights: np.ndarray
    core: np.ndarray

    def pairs(self) -> np.ndarray:
        """T as a full matrix, (n, nw, nw)."""
        return np.asarray(self.weights.T @ self.core @ self.weights)


def newman(drift: np.ndarray) -> Factors:
    """T-_ij = (D_i + D_j) / 2 from mean drift D (nw, n) [N/m^2, N m/m^2] (Newman 1974)."""
    waves, loads = drift.shape
    core = np.zeros((loads, 1 + loads, 1 + loads))
    each = np.arange(loads)
    core[each, 0, 1 + each] = core[each, 1 + each, 0] = 0.5
    return Factors(np.vstack([np.ones((1, waves)), drift.T]), core)


def newman_square_root(drift: np.ndarray) -> Factors:
    """T-_ij = sign(D_i) sqrt(D_i D_j) from mean drift D (nw, n), zero where the signs differ
    (Newman's approximation with a geometric mean, as in Standing, Brendling and Wilson 1987)."""
    loads = drift.shape[1]
    parts = np.hstack([np.maximum(drift, 0.0), np.maximum(-drift, 0.0)])
    core = np.zeros((loads, 2 * loads, 2 * loads))
    each = np.arange(loads)
    core[each, each, each] = 1.0
    core[each, loads + each, loads + each] = -1.0
    return Factors(np.sqrt(parts).T, core)


def add_factors(one: Factors, other: Factors) -> Factors:
    """The sum of two transfer functions."""
    n, r, s = len(one.core), len(one.weights), len(other.weights)
    core = np.zeros((n, r + s, r + s), dtype=np.result_type(one.core, other.core))
    core[:, :r, :r], core[:, r:, r:] = one.core, other.core
    return Factors(np.vstack([one.weights, other.weights]), core)


def mean_load(elevation: np.ndarray, drift: np.ndarray) -> SpectralLines:
    """The mean load sum_i D_i |a_i|^2 alone, as a line at zero frequency; ``elevation`` (nw,) [m],
    ``drift`` (nw, n)."""
    return SpectralLines(np.zeros(1), (np.abs(elevation) ** 2 @ drift + 0j)[None])


def difference_loads(
    waves: WaveComponents, elevation: np.ndarray, factors: Factors
) -> SpectralLines:
    """Lines of F- for waves of complex ``elevation`` (nw,) [m] at the body.

    Raises InputError if there are more than `MOST_WAVES` and they are not on a grid.
    """
    if waves.spacing == 0.0:
        pairs = factors.pairs() * np.outer(elevation, elevation.conj())
        i, j = _each_pair(waves)
        return SpectralLines(np.abs(waves.omega[i] - waves.omega[j]), _falling(waves, pairs, i, j))
    z = _filter_elevation(waves, elevation, factors)
    record = [np.sum((z @ core) * z.conj(), axis=1).real for core in factors.core]
    lines = scipy.fft.rfft(np.array(record).T, axis=0) / len(z)
    lines[1:] *= 2.0
    lines = lines[: int(waves.index.max())]
    return SpectralLines(waves.spacing * np.arange(len(lines)), lines)


def sum_loads(waves: WaveComponents, elevation: np.ndarray, factors: Factors) -> SpectralLines:
    """Lines of F+ for waves of complex ``elevation`` (nw,) [m] at the body, see
    `difference_loads`."""
    if waves.spacing == 0.0:
        pairs = factors.pairs() * np.outer(elevation, elevation)
        i, j = _each_pair(waves)
        twice = np.where(i == j, 1.0, 2.0)[:, None]
        return SpectralLines(waves.omega[i] + waves.omega[j], twice * pairs[:, i, j].T)
    z = _filter_elevation(waves, elevation, factors)
    record = [np.sum((z @ core) * z, axis=1) for core in factors.core]
    lines = scipy.fft.fft(np.array(record).T, axis=0) / len(z)
    lines = lines[: 2 * int(waves.index.max()) + 1]
    return SpectralLines(waves.spacing * np.arange(len(lines)), lines)


def _filter_elevation(waves: WaveComponents, elevation: np.ndarray, factors: Factors) -> np.ndarray:
    """z (N, r) at N times of the repeat period; N is large enough that no product of two is
    aliased."""
    count = scipy.fft.next_fast_len(2 * int(waves.index.max()) + 1)
    lines = np.zeros((count, len(factors.weights)), dtype=complex)
    np.add.at(lines, waves.index, (factors.weights * elevation).T)
    return np.asarray(scipy.fft.ifft(lines, axis=0)) * count


def _each_pair(waves: WaveComponents) -> tuple[np.ndarray, np.ndarray]:
    """Indices (i, j) of every pair of waves off the grid, once, and of each wave with itself."""
    if waves.omega.size > MOST_WAVES:
        raise InputError(
            f"environment.waves: found {waves.omega.size} given waves whose frequencies are not on"
            f" a grid; expected at most {MOST_WAVES}, because their second-order loads are summed"
            " pair by pair. Give fewer waves, or set wave_forces.second_order: mean_drift."
        )
    return np.tril_indices(waves.omega.size)


def _falling(waves: WaveComponents, pairs: np.ndarray, i: np.ndarray, j: np.ndarray) -> np.ndarray:
    """Amplitudes (m, n) of the lines of the pairs (i, j), each with (j, i), at |w_i - w_j|."""
    values = pairs[:, i, j].T
    turned = np.where((waves.omega[i] >= waves.omega[j])[:, None], values, values.conj())
    return np.where((i == j)[:, None], turned, 2.0 * turned)
