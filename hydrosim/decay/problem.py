"""Least squares of recorded decays about the equation of a decay, in scaled numbers.

Roll is scaled by the largest roll A of all records, time by the first guess W of the frequency:
p1 / W, p2 A, p3 A^2 W, w / W and c A^2 are of order one or less.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from hydrosim.decay.equation import LAW, OMEGA, P1, solve
from hydrosim.decay.noise import find_noise, freedom, whiten
from hydrosim.decay.record import Decay

OWN = 3  # parameters of each record: place and rate at its start, and its mean
PASSES = 3  # fits: with white noise, then with the noise of the residuals before
EVALUATIONS = 200
COVERED = 0.90


class Solution(NamedTuple):
    """Minimum of the squares: all ``parameters`` (5 + 3 nd,), scaled; the ``free`` ones (k,) and
    their ``covariance`` (k, k); ``residuals`` and coefficients of the ``noise`` of each record;
    ``whitened`` residuals; ``degrees`` of freedom; whether the search ``converged``."""

    parameters: np.ndarray
    free: np.ndarray
    covariance: np.ndarray
    residuals: list[np.ndarray]
    noise: list[np.ndarray]
    whitened: list[np.ndarray]
    degrees: float
    converged: bool

    @property
    def quantile(self) -> float:
        """Half a 90 % interval, in standard deviations."""
        return float(student.ppf(0.5 + 0.5 * COVERED, self.degrees))


class Problem:
    """The scaled problem of some decays. ``scales`` (5,) turn p1, p2, p3, w, c into scaled ones."""

    def __init__(self, decays: Sequence[Decay]) -> None:
        self.decays = decays
        self.size = max(decay.size for decay in decays)
        self.omega = float(np.mean([decay.frequency for decay in decays]))
        A, W = self.size, self.omega
        self.scales = np.array([1.0 / W, A, A * A * W, 1.0 / W, A * A])
        self.times = [W * (decay.time - decay.time[0]) for decay in decays]
        self.angles = [decay.angle / A for decay in decays]
        self.count = sum(angle.size for angle in self.angles)

    def guess(self) -> np.ndarray:
        """First parameters (5 + 3 nd,): linear damping from how the motion shrinks, and for each
        record the harmonic motion next to it."""
        found = np.zeros(LAW + OWN * len(self.decays))
        found[OMEGA] = 1.0
        found[P1] = np.mean(
            [_shrinking(t, x) for t, x in zip(self.times, self.angles, strict=True)]
        )
        for k, (t, x) in enumerate(zip(self.times, self.angles, strict=True)):
            envelope = np.exp(-0.5 * found[P1] * t)
            columns = np.stack([envelope * np.cos(t), envelope * np.sin(t), np.ones(t.size)], 1)
            a, b, mean = np.linalg.lstsq(columns, x, rcond=None)[0]
            found[_own(k)] = a, b - 0.5 * found[P1] * a, mean
        return found

    def solve(
        self,
        start: np.ndarray,
        law: Sequence[int],
        noise: Sequence[np.ndarray] | None = None,
    ) -> Solution:
        """The minimum near ``start`` (5 + 3 nd,) with the parameters ``law`` of the equation free.
        The ``noise`` is that of the residuals, or the given one."""
        free = np.array([*law, *range(LAW, start.size)])
        known = noise is not None
        filters = list(noise or [np.zeros(0)] * len(self.decays))
        weights = [1.0] * len(self.decays)
        parameters = start
        for _ in range(1 if known and len(self.decays) == 1 else PASSES):
            parameters, converged = self._search(parameters, free, filters, weights)
            misfits = self._misfits(parameters)
            residuals = [r for r, _ in misfits]
            if not known:
                filters = [
                    find_noise(r, J[:, [*law, *range(*_own(k).indices(J.shape[1]))]])
                    for k, (r, J) in enumerate(misfits)
                ]
            white = [whiten(r, a) for r, a in zip(residuals, filters, strict=True)]
            weights = [1.0 / _deviation(w, free.size / len(white)) for w in white]
        jacobian = self._weighted(parameters, free, filters, weights)[1]
        covariance = np.linalg.pinv(jacobian.T @ jacobian)
        degrees = self._degrees(white, filters, free.size)
        sized = [self.size * r for r in residuals]
        return Solution(parameters, free, covariance, sized, filters, white, degrees, converged)

    def _degrees(
        self, white: Sequence[np.ndarray], filters: Sequence[np.ndarray], fitted: int
    ) -> float:
        """Degrees of freedom of the noise at the frequency of roll, of all records together."""
        total = 0.0
        for w, a, time in zip(white, filters, self.times, strict=True):
            total += freedom(a, w.size - fitted / len(white), time[1] - time[0])
        return total

    def score(self, found: Solution, term: int) -> float:
        """How many standard deviations a parameter of the equation that is zero would be away from
        it, by one step of Gauss and Newton."""
        free = np.append(found.free, term)
        weights = [
            1.0 / _deviation(w, found.free.size / len(found.whitened)) for w in found.whitened
        ]
        r, J = self._weighted(found.parameters, free, found.noise, weights)
        covariance = np.linalg.pinv(J.T @ J)
        step = -covariance @ (J.T @ r)
        return float(abs(step[-1]) / np.sqrt(covariance[-1, -1]))

    def _search(
        self,
        start: np.ndarray,
        free: np.ndarray,
        filters: Sequence[np.ndarray],
        weights: Sequence[float],
    ) -> tuple[np.ndarray, bool]:
        """Parameters of the smallest squares near ``start``, and whether the search converged."""
        parameters = start.copy()
        kept: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}

        def at(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            key = values.tobytes()
            if key not in kept:
                kept.clear()
                parameters[free] = values
                kept[key] = self._weighted(parameters, free, filters, weights)
            return kept[key]

        done = least_squares(
            lambda values: at(values)[0],
            start[free],
            lambda values: at(values)[1],
            method="lm",
            xtol=1e-9,
            ftol=1e-11,
            gtol=1e-11,
            max_nfev=EVALUATIONS,
        )
        parameters[free] = done.x
        return parameters, bool(done.success)

    def _weighted(
        self,
        parameters: np.ndarray,
        free: np.ndarray,
        filters: Sequence[np.ndarray],
        weights: Sequence[float],
    ) -> tuple[np.ndarray, np.ndarray]:
        """Filtered and weighted residuals of all records, and their derivatives by the free
        parameters."""
        rows = []
        slopes = []
        for (r, J), a, weight in zip(self._misfits(parameters), filters, weights, strict=True):
            rows.append(weight * whiten(r, a))
            slopes.append(weight * whiten(J[:, free], a))
        return np.concatenate(rows), np.concatenate(slopes)

    def _misfits(self, parameters: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """Modelled less recorded roll (n,) of each record, and its derivatives by all
        parameters."""
        found = []
        for k, (t, angle) in enumerate(zip(self.times, self.angles, strict=True)):
            own = parameters[_own(k)]
            x, slopes = solve(t, parameters[:LAW], own[:2])
            J = np.zeros((t.size, parameters.size))
            J[:, :LAW] = slopes[:, :LAW]
            J[:, _own(k)] = np.column_stack([slopes[:, LAW:], np.ones(t.size)])
            found.append((x + own[2] - angle, J))
        return found


def _own(k: int) -> slice:
    """Parameters of record ``k``."""
    return slice(LAW + OWN * k, LAW + OWN * (k + 1))


def _deviation(white: np.ndarray, fitted: float) -> float:
    """Standard deviation of white residuals of a fit with that many parameters."""
    return float(np.sqrt(max(white @ white, 1e-30) / max(white.size - fitted, 1.0)))


def _shrinking(t: np.ndarray, x: np.ndarray) -> float:
    """p1 of an exponential decay through the largest values of the half periods that are above the
    noise."""
    x = x - x[-x.size // 4 :].mean()
    halves = (t // np.pi).astype(int)
    peaks = np.array([np.abs(x[halves == k]).max() for k in np.unique(halves)])
    above = peaks > 0.1 * peaks.max()
    last = int(np.argmin(above)) if not above.all() else peaks.size
    if last < 2:
        return 0.5
    slope = np.polyfit(np.pi * np.arange(last), np.log(peaks[:last]), 1)[0]
    return float(np.clip(-2.0 * slope, 0.0, 1.0))
