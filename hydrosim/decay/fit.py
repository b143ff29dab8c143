"""Damping of a decaying roll, fitted to whole records, with 90 % intervals.

Least squares of the recorded roll about the solution of `equation`, all records together: p1, p2,
p3 and the natural frequency are common; each record has its own start, mean and noise. The noise is
white or autoregressive (`noise`). Residuals are filtered with it, and fitted again. Intervals are
those of Laplace: the covariance (J^T J)^-1 of the filtered problem, with quantiles of Student's t.

A record may not tell p1, p2 and p3 apart: an interval holds zero, or a value is negative. Terms for
use are those of the smallest squares with none below zero. Leaving out terms S raises the squares
by q_S^T C_SS^-1 q_S (Wald), with their values q_S and covariance C_SS. (In 300 made decays the
damping at once and twice the largest roll was nearer to the truth with them than with terms chosen
by AIC or BIC.)

A fit is doubted where its residuals are no noise: larger while the roll is large, or oscillating as
the roll does, or gone with a cubic restoring. Intervals are of noise alone, and do not hold then.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.stats import f as fisher

from hydrosim.decay.equation import CUBIC, OMEGA
from hydrosim.decay.noise import Noise
from hydrosim.decay.problem import TERMS, Problem, Solution
from hydrosim.decay.record import Decay, read_decay
from hydrosim.errors import InputError

DAMPING = range(TERMS)
EDDIES, CUBES = 8.0 / (3.0 * np.pi), 0.75  # of |p| p and p^3 in equivalent linear damping
MAX_HALF_WIDTH = 0.15  # of the damping ratio in the middle of the recorded amplitudes
AMPLITUDES = 20  # at which damping must not be negative
DOUBT_PROBABILITY = 1e-3  # of a doubt about a fit that is right
UNEVEN_RATIO = 2.0  # of squares of residuals of large and small roll
PEAK_RATIO = 5.0  # of densities of the noise at the frequency of roll and around it
ROUNDING = 1e-6  # of the largest roll
CUBIC_DEVIATIONS = 0.0
MIN_FREQUENCY_CHANGE = 0.0
MAX_SOFTENING = 0.9  # c A^2 beyond which the roll would not come back


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
        return self._around(np.eye(TERMS)[term])

    def damping_ratio(self, amplitude: float) -> Interval:
        """Equivalent damping, of critical, of a roll of this amplitude [rad]: the linear damping
        that takes the same energy in a cycle (Himeno 1981, section 2.4)."""
        return self._around(self._ratio_weights(amplitude))

    def ratio_of(self, damping: Sequence[float], amplitude: float) -> float:
        """The same ratio for other values of p1, p2 and p3."""
        return float(self._ratio_weights(amplitude) @ damping)

    def _ratio_weights(self, amplitude: float) -> np.ndarray:
        rate = self.frequency * amplitude
        return np.array([1.0, EDDIES * rate, CUBES * rate**2]) / (2.0 * self.frequency)

    def _around(self, weights: np.ndarray) -> Interval:
        value = float(weights @ self.values)
        half = self.quantile * float(np.sqrt(weights @ self.covariance @ weights))
        return Interval(value, value - half, value + half)


@dataclass(frozen=True, eq=False)
class DecayFit:
    """Fit of ``decays``: all ``terms`` with their intervals, and the ``damping`` for use, p1 [1/s],
    p2 [1/rad], p3 [s/rad^2], of which none is negative. ``period`` is the natural period [s],
    ``restoring`` the cubic part c of the restoring [1/rad^2], if it was fitted. Of each record:
    ``modelled`` roll (n,) [rad] with that damping, and ``noise``, the standard deviation of the
    residuals [rad] and their autoregressive coefficients. ``doubts`` say where the equation does
    not fit."""

    decays: Sequence[Decay]
    terms: Terms
    damping: tuple[float, ...]
    period: Interval
    restoring: Interval | None
    amplitudes: tuple[float, float]
    modelled: Sequence[np.ndarray]
    deviations: Sequence[float]
    noise: Sequence[Noise]
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
    cubic: bool = False,
) -> DecayFit:
    """Fit of the decays in files, see `read_decay` and `fit_decays`."""
    decays = [read_decay(path, column, unit, start, end, wanted) for path in paths]
    try:
        return fit_decays(decays, cubic)
    except InputError as error:
        files = ", ".join(map(str, paths))
        raise InputError(": ".join(part for part in (wanted, files, str(error)) if part)) from None


def fit_decays(decays: Sequence[Decay], cubic: bool = False) -> DecayFit:
    """Fit p1, p2, p3 and the natural period to all ``decays`` together. A cubic restoring is fitted
    where it is told from zero, and with ``cubic`` always. Raises InputError if they do not decay,
    or do not tell their damping."""
    problem = Problem(decays)
    law = [*DAMPING, OMEGA]
    full = problem.solve(problem.guess(), law)
    softened = problem.solve(full.parameters, [*law, CUBIC])
    if cubic or _is_better(softened, full):
        law.append(CUBIC)
        full = softened
    terms = _terms(problem, full)
    parameters = full.parameters
    amplitudes = problem.amplitudes(parameters)
    _require_decay(full, terms, amplitudes)
    if parameters[DAMPING].min() < 0.0:
        parameters = problem.minimise(parameters, law, 0.0)[0]
    frequency = _interval(problem, full, OMEGA)
    period = Interval(*(2.0 * np.pi / x for x in (frequency.value, frequency.high, frequency.low)))
    modelled = problem.modelled(parameters)
    residuals = [m - decay.angle for m, decay in zip(modelled, decays, strict=True)]
    return DecayFit(
        decays=decays,
        terms=terms,
        damping=tuple((parameters[DAMPING] / problem.scales[DAMPING]).tolist()),
        period=period,
        restoring=_interval(problem, full, CUBIC) if CUBIC in law else None,
        amplitudes=amplitudes,
        modelled=modelled,
        deviations=[float(np.std(r)) for r in residuals],
        noise=full.noise,
        doubts=tuple(_doubts(problem, full)),
    )


def _is_better(softened: Solution, full: Solution) -> bool:
    """True if the record tells a cubic restoring from zero, and the roll comes back with it."""
    c = softened.parameters[CUBIC]
    return bool(
        softened.converged
        and np.isfinite(softened.covariance).all()
        and c > -MAX_SOFTENING
        and abs(0.375 * c) > MIN_FREQUENCY_CHANGE
        and softened.deviations_from_zero(CUBIC) > CUBIC_DEVIATIONS
    )


def _terms(problem: Problem, solution: Solution) -> Terms:
    """The damping of a solution, in its units."""
    scales = problem.scales[DAMPING]
    covariance = solution.covariance[:TERMS, :TERMS]
    return Terms(
        solution.parameters[DAMPING] / scales,
        covariance / np.outer(scales, scales),
        solution.quantile,
        float(solution.parameters[OMEGA] / problem.scales[OMEGA]),
    )


def _interval(problem: Problem, solution: Solution, parameter: int) -> Interval:
    at = solution.free.tolist().index(parameter)
    value = solution.parameters[parameter] / problem.scales[parameter]
    half = solution.quantile * np.sqrt(solution.covariance[at, at]) / problem.scales[parameter]
    return Interval(float(value), float(value - half), float(value + half))


def _require_decay(solution: Solution, terms: Terms, amplitudes: tuple[float, float]) -> None:
    """Raises InputError for a fit that is no decay, or that does not tell its damping."""
    advice = "Give the part of the record that is a free decay, by its start and end."
    if not solution.converged or not np.isfinite(solution.covariance).all():
        raise InputError(
            "found a record that no decay follows: the fit does not converge; expected the free"
            f" roll after a release. {advice}"
        )
    for amplitude in np.linspace(*amplitudes, AMPLITUDES):
        if (ratio := terms.damping_ratio(amplitude)).high < 0.0:
            raise InputError(
                f"found {_ratio_text(ratio, amplitude)}; expected a roll that loses energy at all"
                f" recorded amplitudes. {advice}"
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


def _doubts(problem: Problem, full: Solution) -> Iterator[str]:
    """In words, where residuals are no noise. Residuals of rounding are not asked."""
    if max(np.std(r) for r in full.residuals) < ROUNDING * problem.size:
        return
    for k, decay in enumerate(problem.decays):
        name = f"{decay.called}: " if decay.called else ""
        third = full.whitened[k].size // 3
        early, late = full.whitened[k][:third], full.whitened[k][-third:]
        ratio = float(early @ early) / max(float(late @ late), 1e-30)
        if ratio > max(UNEVEN_RATIO, float(fisher.isf(DOUBT_PROBABILITY, third, third))):
            yield (
                f"{name}the equation does not fit: residuals are {np.sqrt(ratio):.2g} times as"
                " large in the first third of the record, where the roll is large, as in the last."
                " The intervals are too narrow. Fit large and small roll apart (--from, --to)."
            )
        step = problem.steps[k] * problem.blocks[k] * float(full.parameters[OMEGA])
        at, below, above = full.noise[k].density(step * np.array([1.0, 0.5, 2.0]))
        peak = float(at / np.sqrt(below * above))
        if peak > PEAK_RATIO:
            yield (
                f"{name}the equation may not fit: residuals oscillate at the period of roll,"
                f" with {peak:.2g} times the density of those around. The intervals are widened for"
                " that. Look for waves in the basin, or for another motion."
            )
