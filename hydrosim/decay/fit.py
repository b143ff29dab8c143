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
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.stats import f as fisher

from hydrosim.decay.equation import CUBIC, OMEGA
from hydrosim.decay.noise import density
from hydrosim.decay.problem import Problem, Solution
from hydrosim.decay.record import Decay, read_decay
from hydrosim.errors import InputError

TERMS = (0, 1, 2)
EDDIES, CUBES = 8.0 / (3.0 * np.pi), 0.75  # of |p| p and p^3 in equivalent linear damping
DOUBTED = 1e-3  # probability of a doubt about a fit that is right
UNEVEN = 2.0  # ratio of squares of residuals of large and small roll
PEAKED = 5.0  # ratio of densities of the noise at the frequency of roll and around it
ROUNDING = 1e-6  # of the largest roll
SURE = 4.0  # standard deviations of a cubic restoring


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
        return self._around(np.eye(3)[term])

    def damping_ratio(self, amplitude: float) -> Interval:
        """Equivalent damping, of critical, of a roll of this amplitude [rad]: the linear damping
        that takes the same energy in a cycle (Himeno 1981, section 2.4)."""
        w = self.frequency
        rate = w * amplitude
        return self._around(np.array([1.0, EDDIES * rate, CUBES * rate**2]) / (2.0 * w))

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
    modelled: Sequence[np.ndarray]
    noise: Sequence[tuple[float, np.ndarray]]
    doubts: Sequence[str]

    @property
    def size(self) -> float:
        """Largest roll from the mean [rad]."""
        return max(decay.size for decay in self.decays)


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
    """Fit p1, p2, p3 and the natural period to all ``decays`` together, with ``cubic`` also a cubic
    restoring. Raises InputError if they do not decay."""
    problem = Problem(decays)
    others = [OMEGA, *([CUBIC] if cubic else [])]
    full = problem.solve(problem.guess(), [*TERMS, *others])
    terms = _terms(problem, full)
    _require_decay(full, terms, problem.size)
    used = _choose(terms)
    found = full
    if used != TERMS:
        start = full.parameters.copy()
        start[: len(TERMS)] = _without(terms, used) * problem.scales[: len(TERMS)]
        found = problem.solve(start, [*used, *others], full.noise)
    frequency = _interval(problem, full, OMEGA)
    period = Interval(*(2.0 * np.pi / x for x in (frequency.value, frequency.high, frequency.low)))
    pairs = list(zip(decays, found.residuals, strict=True))
    return DecayFit(
        decays=decays,
        terms=terms,
        damping=tuple(max(float(x), 0.0) for x in found.parameters[:3] / problem.scales[:3]),
        period=period,
        restoring=_interval(problem, full, CUBIC) if cubic else None,
        modelled=[decay.angle + r for decay, r in pairs],
        noise=[(float(np.std(r)), a) for (_, r), a in zip(pairs, full.noise, strict=True)],
        doubts=tuple(_doubts(problem, full, cubic)),
    )


def _terms(problem: Problem, found: Solution) -> Terms:
    """The damping of a solution with all terms, in its units."""
    scales = problem.scales[: len(TERMS)]
    own = found.covariance[: len(TERMS), : len(TERMS)]
    return Terms(
        found.parameters[: len(TERMS)] / scales,
        own / np.outer(scales, scales),
        found.quantile,
        float(found.parameters[OMEGA] / problem.scales[OMEGA]),
    )


def _interval(problem: Problem, found: Solution, parameter: int) -> Interval:
    at = found.free.tolist().index(parameter)
    value = found.parameters[parameter] / problem.scales[parameter]
    half = found.quantile * np.sqrt(found.covariance[at, at]) / problem.scales[parameter]
    return Interval(float(value), float(value - half), float(value + half))


def _require_decay(found: Solution, terms: Terms, size: float) -> None:
    if not found.converged or not np.isfinite(found.covariance).all():
        raise InputError(
            "found a record that no decay follows: the fit does not converge; expected the free"
            " roll after a release. Give the part of the record that is one, by its start and end."
        )
    ratio = terms.damping_ratio(0.5 * size)
    if ratio.low <= 0.0:
        raise InputError(
            f"found a damping ratio of {ratio.value:.2g} ({ratio.low:.2g} to {ratio.high:.2g}) at"
            f" half of the largest roll; expected a roll that decays, above 0. Give the part of the"
            " record that is a free decay, by its start and end."
        )


def _choose(terms: Terms) -> tuple[int, ...]:
    """Terms of the smallest squares with none below zero."""
    best: tuple[int, ...] = (0,)
    least = np.inf
    for number in (3, 2, 1):
        for used in combinations(TERMS, number):
            left = [term for term in TERMS if term not in used]
            q = terms.values[left]
            C = terms.covariance[np.ix_(left, left)]
            rise = float(q @ np.linalg.solve(C, q)) if left else 0.0
            if _without(terms, used).min() >= 0.0 and rise < least:
                best = used
                least = rise
    return best


def _without(terms: Terms, used: tuple[int, ...]) -> np.ndarray:
    """Values (3,) of the smallest squares with the ``used`` terms alone."""
    left = [term for term in TERMS if term not in used]
    found = terms.values.copy()
    if left:
        C = terms.covariance
        found -= C[:, left] @ np.linalg.solve(C[np.ix_(left, left)], terms.values[left])
        found[left] = 0.0
    return found


def _doubts(problem: Problem, full: Solution, cubic: bool) -> Iterator[str]:
    """In words, where residuals are no noise. Residuals of rounding are not asked."""
    if max(np.std(r) for r in full.residuals) < ROUNDING * problem.size:
        return
    for k, decay in enumerate(problem.decays):
        called = f"{decay.called}: " if decay.called else ""
        third = full.whitened[k].size // 3
        early, late = full.whitened[k][:third], full.whitened[k][-third:]
        ratio = float(early @ early) / max(float(late @ late), 1e-30)
        if ratio > max(UNEVEN, float(fisher.isf(DOUBTED, third, third))):
            yield (
                f"{called}the equation does not fit: residuals are {np.sqrt(ratio):.2g} times as"
                " large in the first third of the record, where the roll is large, as in the last."
                " The intervals are too narrow. Fit large and small roll apart (--from, --to)."
            )
        step = problem.times[k][1] * float(full.parameters[OMEGA])
        at, below, above = density(full.noise[k], step * np.array([1.0, 0.5, 2.0]))
        peak = float(at / np.sqrt(below * above))
        if peak > PEAKED:
            yield (
                f"{called}the equation may not fit: residuals oscillate at the period of roll,"
                f" with {peak:.2g} times the density of those around. The intervals are widened for"
                " that. Look for waves in the basin, or for another motion."
            )
    if not cubic and (away := problem.score(full, CUBIC)) > SURE:
        yield (
            f"the period changes with the amplitude, by {away:.2g} standard deviations: the"
            " restoring is not linear. Fit it as well (--cubic), or a part with smaller roll"
            " (--from)."
        )
