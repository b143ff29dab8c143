"""Noise of a recording, as an autoregressive process.

    e_k = a_1 e_(k-1) + ... + a_m e_(k-m) + white noise

The order m is the one of smallest BIC (Schwarz 1978), with partial correlations after Burg (1975).
The fitted parameters have taken up some of the noise, most of it at the frequency of roll. So the
partial correlations are those of the largest restricted likelihood (Patterson and Thompson 1971),
the smallest

    (n - m - k) ln |A (r - J q)|^2 + ln |(A J)^T A J|

with the filter A that makes the noise white, residuals r, derivatives J by k parameters, and the q
of the smallest squares. Any partial correlations below 1 are those of a stationary process.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import matmul_toeplitz
from scipy.optimize import minimize
from scipy.signal import lfilter

MAX_ORDER = 12
MIN_VALUES_PER_ORDER = 20
PENALTY = lambda m, n: m * np.log(n)
MAX_CORRELATION = 0.9999


class Noise(NamedTuple):
    """Partial correlations ``partial`` (m,), coefficients a (m,), and the ``power`` of its white
    noise."""

    partial: np.ndarray
    coefficients: np.ndarray
    power: float

    @property
    def order(self) -> int:
        """Number of coefficients, 0 for white noise."""
        return int(self.partial.size)

    def whiten(self, values: np.ndarray) -> np.ndarray:
        """``values`` (n, ...) filtered along their first axis, without the first m, where the
        filter begins."""
        return _whiten(values, self.coefficients)

    def density(self, angle: np.ndarray) -> np.ndarray:
        """Spectral density relative to that of its white noise, at frequencies ``angle`` [rad per
        step]."""
        powers = np.exp(-1j * np.multiply.outer(angle, np.arange(1, self.order + 1)))
        return np.asarray(1.0 / np.abs(1.0 - powers @ self.coefficients) ** 2)

    def covariance_of(self, slopes: np.ndarray) -> np.ndarray:
        """Covariance (k, k) of J^T e for derivatives J (n, k), ``slopes``, and n values e of the
        noise."""
        return np.asarray(slopes.T @ matmul_toeplitz(self._autocovariance(len(slopes)), slopes))

    def _autocovariance(self, count: int) -> np.ndarray:
        """Covariances (n,) of values 0, 1, 2... steps apart, by the recursion of Levinson and
        Durbin."""
        variance = self.power / float(np.prod(1.0 - self.partial**2))
        gamma = np.zeros(max(count, self.order + 1))
        gamma[0] = variance
        a = np.zeros(0)
        for k in range(1, gamma.size):
            gamma[k] = a @ gamma[k - a.size : k][::-1]
            if k <= self.order:
                r = self.partial[k - 1]
                gamma[k] += r * variance
                variance *= 1.0 - r * r
                a = np.append(a - r * a[::-1], r)
        return gamma[:count]

    def freedom(self, count: float, angle: float) -> float:
        """Degrees of freedom of the density at a frequency ``angle`` [rad per step] that ``count``
        values tell: 2 / var(ln S), as of a chi-squared variable (Satterthwaite 1946), with the
        covariance of the coefficients of large samples (Box and Jenkins 1970)."""
        m = self.order
        lags = np.arange(1, m + 1)
        wave = np.exp(-1j * angle * lags)
        slope = 2.0 * np.real(wave / (1.0 - wave @ self.coefficients))
        A = np.concatenate([[1.0], -self.coefficients])
        left, right = np.zeros((m, m)), np.zeros((m, m))
        for i in range(m):
            left[i, : i + 1] = A[: i + 1][::-1]
            right[i, : i + 1] = A[m - i :]
        # of the correlations, over the white power (Siddiqui 1958)
        inverse = left @ left.T - right @ right.T
        variance = 2.0 / count + slope @ inverse @ slope / count
        return float(2.0 / variance)


def fit_noise(residual: np.ndarray, slopes: np.ndarray) -> Noise:
    """The noise in a ``residual`` (n,) of a fit, with its derivatives by k parameters ``slopes``
    (n, k)."""
    partial = _order_and_correlations(residual)
    if partial.size:
        start = np.arctanh(np.clip(partial, -MAX_CORRELATION, MAX_CORRELATION))
        found = minimize(
            lambda u: _likelihood(residual, slopes, np.tanh(u))[0],
            start,
            method="BFGS",
            options={"gtol": 1e-3, "maxiter": 50},
        )
        partial = np.clip(np.tanh(found.x), -MAX_CORRELATION, MAX_CORRELATION)
    power = _likelihood(residual, slopes, partial)[1]
    return Noise(partial, _coefficients(partial), power)


def _order_and_correlations(residual: np.ndarray) -> np.ndarray:
    """Partial correlations (m,) of the order with the smallest BIC."""
    n = residual.size
    forward, backward = residual, residual
    power = float(residual @ residual) / n
    partial = np.zeros(0)
    best, least = partial, n * np.log(max(power, 1e-300))
    for m in range(1, min(MAX_ORDER, n // MIN_VALUES_PER_ORDER) + 1):
        forward, backward = forward[1:], backward[:-1]
        squares = float(forward @ forward + backward @ backward)
        r = 2.0 * float(forward @ backward) / max(squares, 1e-300)
        forward, backward = forward - r * backward, backward - r * forward
        partial = np.append(partial, r)
        power *= 1.0 - r * r
        score = n * np.log(max(power, 1e-300)) + PENALTY(m, n)
        if score < least:
            best, least = partial, score
    return best


def _likelihood(
    residual: np.ndarray, slopes: np.ndarray, partial: np.ndarray
) -> tuple[float, float]:
    """The criterion of the restricted likelihood, and the power of the white noise."""
    a = _coefficients(partial)
    J = _whiten(slopes, a)
    r = _whiten(residual, a)
    Q, R = np.linalg.qr(J)
    squares = max(float(r @ r - np.sum((Q.T @ r) ** 2)), 1e-300)
    rest = max(r.size - J.shape[1], 1)
    determinant = 2.0 * np.sum(np.log(np.abs(np.diag(R)) + 1e-300))
    return float(rest * np.log(squares) + determinant), squares / rest


def _coefficients(partial: np.ndarray) -> np.ndarray:
    """Coefficients (m,) from partial correlations, by the recursion of Levinson and Durbin."""
    a = np.zeros(0)
    for r in partial:
        a = np.append(a - r * a[::-1], r)
    return a


def _whiten(values: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
    filtered = lfilter([1.0, *-coefficients], [1.0], values, axis=0)
    return np.asarray(filtered[coefficients.size :])
