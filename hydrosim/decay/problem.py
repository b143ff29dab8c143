"""Least squares of recorded decays about the equation of a decay, in scaled numbers.

Roll is scaled by the largest roll A of all records, time by the first guess W of the frequency:
p1 / W, p2 A, p3 A^2 W, w / W and c A^2 are of order one or less. The mean of each record is a
parabola over its time, so that it may drift.

The estimate is plain least squares. The noise is no part of it: a filter that whitens residuals
takes out the roll as well where they are large at its frequency. Noise counts in the covariance,

    (J^T J)^-1 J^T S J (J^T J)^-1,

with derivatives J and the covariance S of the noise (`noise`). Noise is fitted to means of
neighbouring values, `NOISE_VALUES` in a period, which is enough for what acts at the frequency of
roll.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from hydrosim.decay.equation import LAW, OMEGA, P1, solve
from hydrosim.decay.noise import Noise, fit_noise
from hydrosim.decay.record import Decay, block_means

TERMS = 3  # p1, p2 and p3 are the first parameters
MIN_DEGREE, MAX_DEGREE = 2, 6  # of the polynomial that is the mean of a record
NOISE_VALUES = 24.0
MAX_EVALUATIONS = 200
COVERED = 0.90
WILD = 1e3  # scaled residual of a trial that is no decay


class Solution(NamedTuple):
    """Minimum of the squares: all ``parameters`` (5 + 5 nd,), scaled; the ``free`` ones (k,) and
    their ``covariance`` (k, k); ``residuals`` of each record (n,) [rad], and its ``noise``, with
    ``whitened`` residuals; ``degrees`` of freedom; whether the search ``converged``."""

    parameters: np.ndarray
    free: np.ndarray
    covariance: np.ndarray
    residuals: list[np.ndarray]
    noise: list[Noise]
    whitened: list[np.ndarray]
    degrees: float
    converged: bool

    @property
    def quantile(self) -> float:
        """Half a 90 % interval, in standard deviations."""
        return float(student.ppf(0.5 + 0.5 * COVERED, self.degrees))

    def deviations_from_zero(self, parameter: int) -> float:
        """How many of its standard deviations a free parameter is away from zero."""
        at = self.free.tolist().index(parameter)
        deviation = max(float(np.sqrt(self.covariance[at, at])), 1e-300)
        return float(abs(self.parameters[parameter])) / deviation


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
        self.steps = [float(t[-1]) / (t.size - 1) for t in self.times]
        self.blocks = [max(int(2.0 * np.pi / NOISE_VALUES / step), 1) for step in self.steps]
        self.means = [_drifts(t) for t in self.times]
        widths = [2 + mean.shape[1] for mean in self.means]
        ends = LAW + np.cumsum([0, *widths])
        self.own = [slice(*pair) for pair in pairwise(ends.tolist())]

    def guess(self) -> np.ndarray:
        """First parameters (5 + 5 nd,): linear damping from how the motion shrinks, and for each
        record the harmonic motion next to it."""
        parameters = np.zeros(self.own[-1].stop)
        parameters[OMEGA] = 1.0
        pairs = list(zip(self.times, self.angles, strict=True))
        p1 = float(np.mean([_shrinking(t, x) for t, x in pairs]))
        parameters[P1] = p1
        for k, (t, x) in enumerate(pairs):
            envelope = np.exp(-0.5 * p1 * t)
            harmonics = np.stack([envelope * np.cos(t), envelope * np.sin(t)], 1)
            columns = np.hstack([harmonics, self.means[k]])
            a, b, *mean = np.linalg.lstsq(columns, x, rcond=None)[0]
            parameters[self.own[k]] = a, b - 0.5 * p1 * a, *mean
        return parameters

    def solve(self, start: np.ndarray, law: Sequence[int]) -> Solution:
        """The minimum of the squares near ``start`` (5 + 5 nd,) with the parameters ``law`` of the
        equation free."""
        free = np.array([*law, *range(LAW, start.size)])
        parameters, weights, converged = self.minimise(start, law)
        misfits = list(self._misfits(parameters))
        normal = np.zeros((free.size, free.size))
        spread = np.zeros((free.size, free.size))
        noises = []
        whitened = []
        degrees = 0.0
        for k, (r, J) in enumerate(misfits):
            count = self.blocks[k]
            residual = block_means(r, count)
            slopes = block_means(J[:, free], count)
            here = np.flatnonzero(np.any(J[:, free] != 0.0, axis=0))
            noise = fit_noise(residual, slopes[:, here])
            normal += weights[k] ** 2 * J[:, free].T @ J[:, free]
            spread += weights[k] ** 4 * count**2 * noise.covariance_of(slopes)
            told = residual.size - free.size / len(self.decays)
            degrees += noise.freedom(told, count * self.steps[k] * parameters[OMEGA])
            noises.append(noise)
            whitened.append(noise.whiten(residual))
        inverse = np.linalg.pinv(normal)
        covariance = inverse @ spread @ inverse
        residuals = [self.size * r for r, _ in misfits]
        return Solution(
            parameters, free, covariance, residuals, noises, whitened, degrees, converged
        )

    def minimise(
        self, start: np.ndarray, law: Sequence[int], least: float = -np.inf
    ) -> tuple[np.ndarray, np.ndarray, bool]:
        """Parameters of the smallest squares near ``start``, the weight of each record, by its
        residuals, and whether the search converged. No damping term is below ``least``."""
        free = np.array([*law, *range(LAW, start.size)])
        weights = np.ones(len(self.decays))
        for _ in range(min(len(self.decays), 2)):
            start, converged = self._search(start, free, weights, least)
            squares = [float(r @ r) / r.size for r, _ in self._misfits(start)]
            weights = 1.0 / np.sqrt(np.maximum(squares, 1e-30))
        return start, weights, converged

    def _search(
        self, start: np.ndarray, free: np.ndarray, weights: np.ndarray, least: float
    ) -> tuple[np.ndarray, bool]:
        parameters = start.copy()
        latest: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}

        def weighted(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            key = values.tobytes()
            if key not in latest:
                latest.clear()
                parameters[free] = values
                rows = zip(weights, self._misfits(parameters), strict=True)
                residuals, slopes = zip(*((w * r, w * J[:, free]) for w, (r, J) in rows), strict=True)
                latest[key] = np.concatenate(residuals), np.concatenate(slopes)
            return latest[key]

        bounds = np.where(free < TERMS, least, -np.inf)
        done = least_squares(
            lambda values: weighted(values)[0],
            np.maximum(start[free], bounds),
            lambda values: weighted(values)[1],
            bounds=(bounds, np.inf),
            method="dogbox" if least > -np.inf else "lm",
            xtol=1e-9,
            ftol=1e-11,
            gtol=1e-11,
            max_nfev=MAX_EVALUATIONS,
        )
        parameters[free] = done.x
        return parameters, bool(done.success)

    def amplitudes(self, parameters: np.ndarray) -> tuple[float, float]:
        """The smallest amplitude [rad] of the last period of any record, and the largest roll."""
        ends = []
        for (r, _), angle, step in zip(
            self._misfits(parameters), self.angles, self.steps, strict=True
        ):
            last = (angle + r)[-round(2.0 * np.pi / step) :]
            ends.append(0.5 * float(np.ptp(last)))
        return self.size * min(ends), self.size

    def modelled(self, parameters: np.ndarray) -> list[np.ndarray]:
        """Roll (n,) [rad] of each record with these parameters, about its recorded mean."""
        misfits = self._misfits(parameters)
        pairs = zip(self.decays, misfits, strict=True)
        return [decay.angle + self.size * r for decay, (r, _) in pairs]

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
            yield np.nan_to_num(residual, nan=WILD, posinf=WILD, neginf=-WILD), np.nan_to_num(J)


def _drifts(t: np.ndarray) -> np.ndarray:
    """Legendre polynomials (n, m) of a record at scaled times (n,), with half as many waves as the
    roll has at most."""
    degree = int(np.clip(t[-1] / (2.0 * np.pi), MIN_DEGREE, MAX_DEGREE))
    return np.polynomial.legendre.legvander(2.0 * t / t[-1] - 1.0, degree)


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
