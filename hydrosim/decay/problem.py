"""Least squares of recorded decays about the equation of a decay, in scaled numbers.

Roll is scaled by the largest roll A of all records, time by the first guess W of the frequency:
p1 / W, p2 A, p3 A^2 W, w / W and c A^2 are of order one or less. The mean of each record is a
polynomial over its time, so that it may drift.

The estimate is plain least squares. A filter that whitens residuals would take out the roll as well
where they are large at its frequency. So noise counts in the covariance alone,

    R^-1 (Q^T S Q) R^-T

with the derivatives J = Q R of the residuals, Q orthonormal, and the covariance S of the noise
(White 1980). In the cosine transform S is diagonal for any noise that is stationary. Its density
is the mean of squared residuals of `BAND_FREQUENCIES` neighbouring frequencies. The fit takes from
each of them the squares of its row of Q, so the mean is over the rest.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.fft import dct
from scipy.ndimage import uniform_filter1d
from scipy.optimize import least_squares
from scipy.stats import t as student

from hydrosim.decay.equation import LAW, OMEGA, P1, solve
from hydrosim.decay.record import DecayRecord

TERMS = 3  # p1, p2 and p3 are the first parameters
FIRST_P1 = 0.08  # a damping ratio of 4 %
MIN_DEGREE, MAX_DEGREE = 2, 6  # of the polynomial that is the mean of a record
# frequencies of the cosine transform, which are half a wave of a record apart
BAND_FREQUENCIES = 11
MAX_EVALUATIONS = 200
COVERED = 0.90
MIN_REST = 0.05  # of the noise in a band, that the fit leaves
NEIGHBOURS = np.array([0.5, 1.0, 2.0])  # of the frequency of roll
WILD = 1e3  # scaled residual of a trial that is no decay


class DecaySolution(NamedTuple):
    """Minimum of the squares: ``parameters`` (5 + own,), scaled; their ``covariance``; the
    ``weights`` of records; the ``degrees`` of freedom to which the noise is known; the ``peaks`` of
    each record: the density of its residuals at the frequency of roll over that around it; whether
    the search ``converged``."""

    parameters: np.ndarray
    covariance: np.ndarray
    weights: np.ndarray
    degrees: float
    peaks: list[float]
    converged: bool

    @property
    def quantile(self) -> float:
        """Half a 90 % interval, in standard deviations."""
        return float(student.ppf(0.5 + 0.5 * COVERED, self.degrees))


class DecayProblem:
    """The scaled problem of some decays. ``scales`` (5,) turn p1, p2, p3, w, c into scaled ones."""

    def __init__(self, decays: Sequence[DecayRecord]) -> None:
        self.decays = decays
        self.size = max(decay.size for decay in decays)
        self.omega = float(np.mean([decay.frequency for decay in decays]))
        A, W = self.size, self.omega
        self.scales = np.array([1.0 / W, A, A * A * W, 1.0 / W, A * A])
        self.times = [W * (decay.time - decay.time[0]) for decay in decays]
        self.angles = [decay.angle / A for decay in decays]
        self.means = [_drifts(t) for t in self.times]
        ends = LAW + np.cumsum([0, *(2 + mean.shape[1] for mean in self.means)])
        self.own = [slice(*pair) for pair in pairwise(ends.tolist())]

    def solve(self) -> DecaySolution:
        """The smallest squares with all parameters free. Several records are weighted by their
        residuals."""
        weights = np.ones(len(self.decays))
        parameters, converged = self.minimise(self._guess(), weights)
        if len(self.decays) > 1:
            squares = [float(r @ r) / r.size for r, _ in self._misfits(parameters)]
            weights = 1.0 / np.sqrt(np.maximum(squares, 1e-30))
            parameters, converged = self.minimise(parameters, weights)
        covariance, degrees, peaks = self._covariance(parameters, weights)
        return DecaySolution(parameters, covariance, weights, degrees, peaks, converged)

    def _covariance(
        self, parameters: np.ndarray, weights: np.ndarray
    ) -> tuple[np.ndarray, float, list[float]]:
        """Covariance of all parameters, degrees of freedom, and peaks, see `DecaySolution`."""
        misfits = self._weighted_misfits(parameters, weights)
        inverse = np.linalg.pinv(np.linalg.qr(np.concatenate([J for _, J in misfits]), "r"))
        middle = np.zeros_like(inverse)
        degrees = 0.0
        peaks = []
        for t, (r, J) in zip(self.times, misfits, strict=True):
            Q = dct(J @ inverse, norm="ortho", axis=0)
            rest = np.maximum(_average(1.0 - np.sum(Q**2, axis=1)), MIN_REST)
            density = _average(dct(r, norm="ortho") ** 2) / rest
            middle += (Q.T * density) @ Q
            roll = np.rint(NEIGHBOURS * parameters[OMEGA] * t[-1] / np.pi).astype(int)
            below, here, above = np.maximum(np.take(density, roll, mode="clip"), 1e-300)
            degrees += BAND_FREQUENCIES * float(np.take(rest, roll[1], mode="clip"))
            peaks.append(float(here / np.sqrt(below * above)))
        return inverse @ middle @ inverse.T, degrees, peaks

    def minimise(
        self, start: np.ndarray, weights: np.ndarray, least: float = -np.inf
    ) -> tuple[np.ndarray, bool]:
        """Parameters of the smallest squares near ``start``, with no damping term below ``least``,
        and whether the search converged."""
        latest: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}

        def weighted_misfits(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            key = values.tobytes()
            if key not in latest:
                latest.clear()
                residuals, slopes = zip(*self._weighted_misfits(values, weights), strict=True)
                latest[key] = np.concatenate(residuals), np.concatenate(slopes)
            return latest[key]

        bounds = np.where(np.arange(start.size) < TERMS, least, -np.inf)
        done = least_squares(
            lambda values: weighted_misfits(values)[0],
            np.maximum(start, bounds),
            lambda values: weighted_misfits(values)[1],
            bounds=(bounds, np.inf),
            xtol=1e-9,
            ftol=1e-11,
            gtol=1e-11,
            max_nfev=MAX_EVALUATIONS,
        )
        return done.x, bool(done.success)

    def smallest_amplitude(self, parameters: np.ndarray) -> float:
        """The smallest amplitude [rad] of the last period of any record."""
        ends = []
        for k, t in enumerate(self.times):
            x = solve(t, parameters[:LAW], parameters[self.own[k]][:2])[0]
            ends.append(0.5 * float(np.ptp(x[t > t[-1] - 2.0 * np.pi])))
        return self.size * min(ends)

    def residuals(self, parameters: np.ndarray) -> list[np.ndarray]:
        """Modelled less recorded roll (n,) [rad] of each record."""
        return [self.size * r for r, _ in self._misfits(parameters)]

    def _guess(self) -> np.ndarray:
        """First parameters (5 + own,): linear damping, and for each record the harmonic motion next
        to it."""
        parameters = np.zeros(self.own[-1].stop)
        parameters[P1] = FIRST_P1
        parameters[OMEGA] = 1.0
        for t, x, mean, own in zip(self.times, self.angles, self.means, self.own, strict=True):
            wave = np.exp((1j - 0.5 * FIRST_P1) * t)
            columns = np.column_stack([wave.real, wave.imag, mean])
            a, b, *rest = np.linalg.lstsq(columns, x, rcond=None)[0]
            parameters[own] = a, b - 0.5 * FIRST_P1 * a, *rest
        return parameters

    def _weighted_misfits(
        self, parameters: np.ndarray, weights: np.ndarray
    ) -> list[tuple[np.ndarray, np.ndarray]]:
        """Misfits and derivatives times the weight of their record."""
        pairs = zip(weights, self._misfits(parameters), strict=True)
        return [(w * r, w * J) for w, (r, J) in pairs]

    def _misfits(self, parameters: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Modelled less recorded roll (n,) of each record, and its derivatives by all
        parameters."""
        for k, (t, angle) in enumerate(zip(self.times, self.angles, strict=True)):
            own = parameters[self.own[k]]
            x, slopes = solve(t, parameters[:LAW], own[:2])
            J = np.zeros((t.size, parameters.size))
            J[:, :LAW] = slopes[:, :LAW]
            J[:, self.own[k]] = np.hstack([slopes[:, LAW:], self.means[k]])
            residual = x + self.means[k] @ own[2:] - angle
            yield np.clip(np.nan_to_num(residual, nan=WILD), -WILD, WILD), np.nan_to_num(J)


def _drifts(t: np.ndarray) -> np.ndarray:
    """Legendre polynomials (n, m) of a record at scaled times (n,), with half as many waves as the
    roll has at most."""
    degree = int(np.clip(t[-1] / (2.0 * np.pi), MIN_DEGREE, MAX_DEGREE))
    return np.polynomial.legendre.legvander(2.0 * t / t[-1] - 1.0, degree)


def _average(values: np.ndarray) -> np.ndarray:
    """Means of `BAND_FREQUENCIES` neighbours of ``values`` (n,)."""
    return np.asarray(uniform_filter1d(values, BAND_FREQUENCIES, mode="mirror"))
