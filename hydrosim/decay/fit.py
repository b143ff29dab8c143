"""Damping of a decaying roll, fitted to whole records, with 90 % intervals.

Least squares of the recorded roll about the solution of `equation`, all records together: p1, p2,
p3, the natural frequency and a cubic restoring are common; each record has its own start, mean and
noise (`problem`). Intervals have quantiles of Student's t.

A record may not tell p1, p2 and p3 apart: an interval holds zero, or a value is negative. Terms for
use are those of the smallest squares with none below zero.

A fit is refused where the damping in the middle of the recorded amplitudes is not known well
enough, and doubted where its residuals oscillate as the roll does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hydrosim.decay.equation import CUBIC, LAW, OMEGA
from hydrosim.decay.problem import TERMS, DecayProblem, DecaySolution
from hydrosim.decay.record import DecayRecord, read_decay
from hydrosim.errors import InputError

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
    def holds_zero(self) -> bool:
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
        doubts=tuple(_doubts(problem, full)),
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


def _doubts(problem: DecayProblem, full: DecaySolution) -> list[str]:
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
