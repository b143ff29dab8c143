"""Noise of a recording: its correlation as an autoregressive process, and signs of another model.

    e_k = a_1 e_(k-1) + ... + a_m e_(k-m) + white noise

A filter with these coefficients makes residuals white. Least squares of filtered residuals then
have the usual covariance (Cochrane and Orcutt 1949, for m = 1). The order m is the one of smallest
BIC (Schwarz 1978).
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

MOST = 12  # order
CYCLES = 64  # frequencies of a spectrum


def find_noise(residual: np.ndarray, fitted: int = 0) -> np.ndarray:
    """Coefficients a (m,) of the noise in a ``residual`` (n,) of a fit with that many parameters;
    empty for white noise."""
    n = residual.size
    gamma = np.array([residual[: n - k] @ residual[k:] for k in range(MOST + 1)]) / n
    best = np.zeros(0)
    least = np.inf
    for m in range(min(MOST, n // 20) + 1):
        a = solve_toeplitz(gamma[:m], gamma[1 : m + 1]) if m else np.zeros(0)
        power = gamma[0] - a @ gamma[1 : m + 1]
        score = n * np.log(max(power, 1e-300)) + (m + fitted) * np.log(n)
        if score < least - 1e-9:
            best = a
            least = score
    return best


def whiten(values: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """``values`` (n, ...) filtered along their first axis, without the first m, where the filter
    begins."""
    if not noise.size:
        return values
    return np.asarray(lfilter([1.0, *-noise], [1.0], values, axis=0)[noise.size :])


def density(noise: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Spectral density of the noise, relative to white noise of the same drive, at frequencies
    ``angle`` [rad per step]."""
    powers = np.exp(-1j * np.multiply.outer(angle, np.arange(1, noise.size + 1)))
    return np.asarray(1.0 / np.abs(1.0 - powers @ noise) ** 2)
