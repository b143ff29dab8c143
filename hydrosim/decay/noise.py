"""Noise of a recording, as an autoregressive process.

    e_k = a_1 e_(k-1) + ... + a_m e_(k-m) + white noise

A filter with these coefficients makes residuals white, and least squares of filtered residuals have
the usual covariance (Cochrane and Orcutt 1949, for m = 1). The order m is the one of smallest BIC
(Schwarz 1978), with coefficients after Yule and Walker. The fitted parameters have taken up some of
the noise, most of it at the frequency of roll. So the coefficients are those of the largest
restricted likelihood (Patterson and Thompson 1971), the smallest

    (n - k) ln |A (r - J q)|^2 + ln |(A J)^T A J|

with the filter A, residuals r, derivatives J by k parameters, and the q of the smallest squares.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.optimize import minimize
from scipy.signal import lfilter

MOST = 12  # order


def find_noise(residual: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Coefficients a (m,) of the noise in a ``residual`` (n,) of a fit, with its derivatives by k
    parameters ``slopes`` (n, k); empty for white noise."""
    n = residual.size
    gamma = np.array([residual[: n - k] @ residual[k:] for k in range(MOST + 1)]) / n
    best = np.zeros(0)
    least = np.inf
    for m in range(min(MOST, n // 20) + 1):
        a = solve_toeplitz(gamma[:m], gamma[1 : m + 1]) if m else np.zeros(0)
        power = gamma[0] - a @ gamma[1 : m + 1]
        score = n * np.log(max(power, 1e-300)) + m * np.log(n)
        if score < least - 1e-9:
            best = a
            least = score
    return _refine(best, residual, slopes) if best.size else best


def _refine(noise: np.ndarray, residual: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Coefficients (m,) of the largest restricted likelihood near ``noise``, in partial
    correlations, which keep the process stationary."""
    rest = residual.size - slopes.shape[1]

    def criterion(u: np.ndarray) -> float:
        a = _coefficients(np.tanh(u))
        J = whiten(slopes, a)
        r = whiten(residual, a)
        Q, R = np.linalg.qr(J)
        squares = r @ r - np.sum((Q.T @ r) ** 2)
        determinant = 2.0 * np.sum(np.log(np.abs(np.diag(R)) + 1e-300))
        return float(rest * np.log(max(squares, 1e-300)) + determinant)

    start = np.arctanh(np.clip(_partial(noise), -0.999999, 0.999999))
    found = minimize(criterion, start, method="BFGS", options={"gtol": 1e-3, "maxiter": 50})
    return _coefficients(np.tanh(found.x)) if found.fun < criterion(start) else noise


def _coefficients(partial: np.ndarray) -> np.ndarray:
    """Coefficients (m,) from partial correlations, by the recursion of Levinson and Durbin."""
    a = np.zeros(0)
    for r in partial:
        a = np.append(a - r * a[::-1], r)
    return a


def _partial(noise: np.ndarray) -> np.ndarray:
    """Partial correlations (m,) of coefficients, by the same recursion backwards."""
    found = []
    a = noise
    while a.size:
        r = a[-1]
        found.append(r)
        a = (a[:-1] + r * a[:-1][::-1]) / max(1.0 - r * r, 1e-12)
    return np.array(found[::-1])


def freedom(noise: np.ndarray, count: float, angle: float) -> float:
    """Degrees of freedom of the density of the noise at a frequency ``angle`` [rad per step] that
    ``count`` values tell: 2 / var(ln S), as of a chi-squared variable (Satterthwaite 1946), with
    the covariance of the coefficients of large samples (Box and Jenkins 1970)."""
    m = noise.size
    if not m:
        return count
    lags = np.arange(1, m + 1)
    wave = np.exp(-1j * angle * lags)
    slope = 2.0 * np.real(wave / (1.0 - wave @ noise))
    A = np.concatenate([[1.0], -noise])
    left, right = np.zeros((m, m)), np.zeros((m, m))
    for i in range(m):
        left[i, : i + 1] = A[: i + 1][::-1]
        right[i, : i + 1] = A[m - i :]
    inverse = (
        left @ left.T - right @ right.T
    )  # of the correlations, over the white power (Siddiqui)
    variance = 2.0 / count + slope @ inverse @ slope / count
    return float(2.0 / variance)


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
