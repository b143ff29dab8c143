"""Decay tests of roll: the equation of a decay, and its damping fitted to recordings.

Damping of a decaying roll, fitted to whole records, with 90 % intervals.

Least squares of the recorded roll about the solution of `solve`, all records together: p1, p2, p3,
the natural frequency and a cubic restoring are common; each record has its own start, mean and
noise (`DecayProblem`). Intervals have quantiles of Student's t.

A record may not tell p1, p2 and p3 apart: an interval holds zero, or a value is negative. Terms for
use are those of the smallest squares with none below zero.

A fit is refused where the damping in the middle of the recorded amplitudes is not known well
enough, and doubted where its residuals oscillate as the roll does.

The equation of a decaying roll, with the derivatives of its solution by its parameters.

    x'' + p1 x' + p2 |x'| x' + p3 x'^3 + w^2 (x + c x^3) = 0

x: roll about its mean; w: natural frequency; c: cubic part of the restoring (zero if the restoring
is linear). The sensitivities s = dx/dq obey the derivative of the equation by each parameter q,

    s'' = -(p1 + 2 p2 |x'| + 3 p3 x'^2) s' - w^2 (1 + 3 c x^2) s - df/dq.

All numbers are scaled by the size of the motion and by its frequency, so they are of order one.
Steps are of the classical Runge-Kutta method of order 4, at most `STEP` long: its error is below
1e-7 in twenty periods.

Least squares of recorded decays about the equation of a decay, in scaled numbers.

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
from dataclasses import dataclass
from itertools import pairwise
from math import ceil
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.fft import dct
from scipy.ndimage import uniform_filter1d
from scipy.optimize import least_squares
from scipy.stats import t as student

from hydrosim.elements.decay_records import DecayRecord, read_decay
from hydrosim.errors import InputError
from hydrosim.jit.kernels import kernel, root

P1, P2, P3, OMEGA, CUBIC = range(5)
LAW = 5  # parameters of the equation; place and rate at the start follow them
SIZE = LAW + 2
STATES = 2 + 2 * SIZE
STEP = 0.03  # of scaled time, in which a period is 2 pi
FASTEST = 20.0  # rate beyond which a trial is no decay any more


def solve(time: np.ndarray, law: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Roll (n,) at equal steps of ``time`` (n,) for the ``law`` (p1, p2, p3, w, c) from place and
    rate at the ``start`` (2,), and its derivatives (n, 7) by the law and the start."""
    y = np.zeros(STATES)
    y[:2] = start
    y[2 + LAW] = 1.0
    y[2 + SIZE + LAW + 1] = 1.0
    rolls = np.empty((time.size, 1 + SIZE))
    step = (time[-1] - time[0]) / (time.size - 1)
    parts = ceil(step / STEP)
    fill_decay(law, step / parts, parts, y, np.empty((3, STATES)), rolls)
    return rolls[:, 0], rolls[:, 1:]


@root
def fill_decay(law, h, parts, y, scratch, rolls):
    """Fill ``rolls`` (n, 8) with roll and sensitivities at every ``parts`` steps ``h`` from ``y``
    (16,), which is changed."""
    for k in range(len(rolls)):
        if k > 0:
            for _ in range(parts):
                _take_step(law, h, y, scratch)
        rolls[k, 0] = y[0]
        for i in range(SIZE):
            rolls[k, 1 + i] = y[2 + i]


@kernel
def _take_step(law, h, y, scratch):
    """Move ``y`` on by a step ``h``."""
    total, slope, at = scratch[0], scratch[1], scratch[2]
    for i in range(STATES):
        total[i] = 0.0
        at[i] = y[i]
    for stage in range(4):
        _fill_slope(law, at, slope)
        weight = h / 6.0 if stage == 0 or stage == 3 else h / 3.0
        reach = h if stage == 2 else 0.5 * h
        for i in range(STATES):
            total[i] += weight * slope[i]
            at[i] = y[i] + reach * slope[i]
    for i in range(STATES):
        y[i] += total[i]


@kernel
def _fill_slope(law, y, slope):
    """Fill ``slope`` (16,) = y' of roll, rate, and the sensitivities of both."""
    p1, p2, p3, w, c = law[P1], law[P2], law[P3], law[OMEGA], law[CUBIC]
    x = y[0]
    v = min(max(y[1], -FASTEST), FASTEST)
    lift = x + c * x * x * x
    slope[0] = y[1]
    slope[1] = -(p1 + p2 * abs(v) + p3 * v * v) * v - w * w * lift
    damping = p1 + 2.0 * p2 * abs(v) + 3.0 * p3 * v * v
    stiffness = w * w * (1.0 + 3.0 * c * x * x)
    s, r = 2, 2 + SIZE
    for i in range(SIZE):
        slope[s + i] = y[r + i]
        slope[r + i] = -damping * y[r + i] - stiffness * y[s + i]
    slope[r + P1] -= v
    slope[r + P2] -= abs(v) * v
    slope[r + P3] -= v * v * v
    slope[r + OMEGA] -= 2.0 * w * lift
    slope[r + CUBIC] -= w * w * x * x * x


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
        self.means = [_trend_polynomials(t) for t in self.times]
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
            rest = np.maximum(_average_neighbours(1.0 - np.sum(Q**2, axis=1)), MIN_REST)
            density = _average_neighbours(dct(r, norm="ortho") ** 2) / rest
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
        for t, x, mean, state_indices in zip(
            self.times, self.angles, self.means, self.own, strict=True
        ):
            wave = np.exp((1j - 0.5 * FIRST_P1) * t)
            columns = np.column_stack([wave.real, wave.imag, mean])
            a, b, *rest = np.linalg.lstsq(columns, x, rcond=None)[0]
            parameters[state_indices] = a, b - 0.5 * FIRST_P1 * a, *rest
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
            record_parameters = parameters[self.own[k]]
            x, slopes = solve(t, parameters[:LAW], record_parameters[:2])
            J = np.zeros((t.size, parameters.size))
            J[:, :LAW] = slopes[:, :LAW]
            J[:, self.own[k]] = np.hstack([slopes[:, LAW:], self.means[k]])
            residual = x + self.means[k] @ record_parameters[2:] - angle
            yield np.clip(np.nan_to_num(residual, nan=WILD), -WILD, WILD), np.nan_to_num(J)


def _trend_polynomials(t: np.ndarray) -> np.ndarray:
    """Legendre polynomials (n, m) of a record at scaled times (n,), with half as many waves as the
    roll has at most."""
    degree = int(np.clip(t[-1] / (2.0 * np.pi), MIN_DEGREE, MAX_DEGREE))
    return np.polynomial.legendre.legvander(2.0 * t / t[-1] - 1.0, degree)


def _average_neighbours(values: np.ndarray) -> np.ndarray:
    """Means of `BAND_FREQUENCIES` neighbours of ``values`` (n,)."""
    return np.asarray(uniform_filter1d(values, BAND_FREQUENCIES, mode="mirror"))


DAMPING_TERMS = slice(TERMS)
EDDIES, CUBES = 8.0 / (3.0 * np.pi), 0.75  # of |p| p and p^3 in equivalent linear damping
MAX_HALF_WIDTH = 0.12  # of the damping ratio in the middle of the recorded amplitudes
MAX_PEAK = 10.0  # ratio of densities of residuals at the frequency of roll and around it
ROUNDING_FRACTION = 1e-5  # of the largest roll


class Interval(NamedTuple):
    """An estimate with the ends of its 90 % interval."""

    value: float
    low: float
    high: float

    @property
    def includes_zero(self) -> bool:
        """True if the record does not tell it from zero."""
        return self.low <= 0.0 <= self.high


@dataclass(frozen=True, eq=False)
class Terms:
    """p1 [1/s], p2 [1/rad] and p3 [s/rad^2]: ``values`` (3,) and their ``covariance`` (3, 3).
    ``quantile`` is half an interval in standard deviations; the natural ``frequency`` is in
    rad/s."""

    values: np.ndarray
    covariance: np.ndarray
    quantile: float
    frequency: float

    def interval(self, term: int) -> Interval:
        """p1, p2 or p3 with its interval."""
        return self._interval_around(np.eye(TERMS)[term])

    def damping_ratio(self, amplitude: float) -> Interval:
        """Equivalent damping, of critical, of a roll of this amplitude [rad]: the linear damping
        that takes the same energy in a cycle (Himeno 1981, section 2.4)."""
        return self._interval_around(self._ratio_weights(amplitude))

    def ratio_of(self, damping: Sequence[float], amplitude: float) -> float:
        """The same ratio for other values of p1, p2 and p3."""
        return float(self._ratio_weights(amplitude) @ damping)

    def _ratio_weights(self, amplitude: float) -> np.ndarray:
        rate = self.frequency * amplitude
        return np.array([1.0, EDDIES * rate, CUBES * rate**2]) / (2.0 * self.frequency)

    def _interval_around(self, weights: np.ndarray) -> Interval:
        value = float(weights @ self.values)
        half = self.quantile * float(np.sqrt(weights @ self.covariance @ weights))
        return Interval(value, value - half, value + half)


@dataclass(frozen=True, eq=False)
class DecayFit:
    """Fit of ``decays``: all ``terms`` with their intervals, and the ``damping`` for use, p1 [1/s],
    p2 [1/rad], p3 [s/rad^2], of which none is negative. ``period`` is the natural period [s] of
    small roll, ``restoring`` the cubic part c of the restoring [1/rad^2]; ``amplitudes`` the
    smallest and the largest roll [rad]. Of each record: ``modelled`` roll (n,) [rad] with that
    damping, and ``deviations``, the standard deviation of the residuals [rad]. ``doubts`` say where
    the equation may not fit."""

    decays: Sequence[DecayRecord]
    terms: Terms
    damping: tuple[float, ...]
    period: Interval
    restoring: Interval
    amplitudes: tuple[float, float]
    modelled: Sequence[np.ndarray]
    deviations: Sequence[float]
    doubts: Sequence[str]

    @property
    def size(self) -> float:
        """Largest roll from the mean [rad]."""
        return self.amplitudes[1]

    def used_ratio(self, amplitude: float) -> float:
        """Equivalent damping, of critical, of the damping for use, see `Terms.damping_ratio`."""
        return self.terms.ratio_of(self.damping, amplitude)


def fit_files(
    paths: Sequence[Path],
    column: str = "roll",
    unit: str | None = None,
    start: float | None = None,
    end: float | None = None,
    wanted: str = "",
) -> DecayFit:
    """Fit of the decays in files, see `read_decay` and `fit_decays`."""
    decays = [read_decay(path, column, unit, start, end, wanted) for path in paths]
    try:
        return fit_decays(decays)
    except InputError as error:
        files = ", ".join(map(str, paths))
        raise InputError(": ".join(part for part in (wanted, files, str(error)) if part)) from None


def fit_decays(decays: Sequence[DecayRecord]) -> DecayFit:
    """Fit p1, p2, p3, the natural period and a cubic restoring to all ``decays`` together. Raises
    InputError if they do not decay, or do not tell their damping."""
    problem = DecayProblem(decays)
    full = problem.solve()
    scales = problem.scales
    values = full.parameters[:LAW] / scales
    covariance = full.covariance[:LAW, :LAW] / np.outer(scales, scales)
    terms = Terms(
        values[DAMPING_TERMS],
        covariance[DAMPING_TERMS, DAMPING_TERMS],
        full.quantile,
        float(values[OMEGA]),
    )
    size, smallest = problem.size, problem.smallest_amplitude(full.parameters)
    _require_decay(full, terms, (smallest, size))
    parameters = full.parameters
    if parameters[DAMPING_TERMS].min() < 0.0:
        parameters = problem.minimise(parameters, full.weights, 0.0)[0]
    half = full.quantile * np.sqrt(np.diag(covariance))
    frequency, restoring = (
        Interval(*(float(values[k] + sign * half[k]) for sign in (0, -1, 1)))
        for k in (OMEGA, CUBIC)
    )
    residuals = problem.residuals(parameters)
    return DecayFit(
        decays=decays,
        terms=terms,
        damping=tuple((parameters[DAMPING_TERMS] / scales[DAMPING_TERMS]).tolist()),
        period=Interval(
            *(2.0 * np.pi / x for x in (frequency.value, frequency.high, frequency.low))
        ),
        restoring=restoring,
        amplitudes=(smallest, size),
        modelled=[decay.angle + r for decay, r in zip(decays, residuals, strict=True)],
        deviations=[float(np.std(r)) for r in residuals],
        doubts=tuple(_doubts_about_fit(problem, full)),
    )


def _require_decay(solution: DecaySolution, terms: Terms, amplitudes: tuple[float, float]) -> None:
    """Raises InputError for a fit that is no decay, or that does not tell its damping."""
    advice = "Give the part of the record that is a free decay, by its start and end."
    if not solution.converged or not np.isfinite(solution.covariance).all():
        raise InputError(
            "found a record that no decay follows: the fit does not converge; expected the free"
            f" roll after a release. {advice}"
        )
    middle = 0.5 * sum(amplitudes)
    ratio = terms.damping_ratio(middle)
    if ratio.low <= 0.0:
        raise InputError(
            f"found {_ratio_text(ratio, middle)}; expected a roll that decays, above 0. {advice}"
        )
    if ratio.high - ratio.value > MAX_HALF_WIDTH * ratio.value:
        raise InputError(
            f"found {_ratio_text(ratio, middle)}; expected it to be known within"
            f" {100.0 * MAX_HALF_WIDTH:g} %. Give a longer part of the record, or several records"
            " of the same condition together."
        )


def _ratio_text(ratio: Interval, amplitude: float) -> str:
    value, low, high = (100.0 * x for x in ratio)
    return (
        f"a damping of {value:.2g} % of critical (90 % interval {low:.2g} to {high:.2g}) at"
        f" {np.degrees(amplitude):.2g} deg"
    )


def _doubts_about_fit(problem: DecayProblem, full: DecaySolution) -> list[str]:
    """In words, which residuals are no noise. Residuals of rounding are not asked."""
    texts = []
    residuals = problem.residuals(full.parameters)
    for decay, residual, peak in zip(problem.decays, residuals, full.peaks, strict=True):
        if peak > MAX_PEAK and np.std(residual) > ROUNDING_FRACTION * problem.size:
            name = f"{decay.called}: " if decay.called else ""
            texts.append(
                f"{name}the equation may not fit: residuals oscillate at the period of roll, with"
                f" {peak:.2g} times the density of those around. The intervals are widened for"
                " that. Look for waves in the basin, or for another motion."
            )
    return texts
