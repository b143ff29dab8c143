"""How many states does the memory of the radiated waves need, by which fit?

Three ways from the field make linear systems of the same retardation functions:

* vector fitting of K^(i w) (Gustavsen and Semlyen 1999), hydrosim's own;
* AAA, greedy rational interpolation of all entries with one set of poles (Nakatsukasa, Sete and
  Trefethen 2018; Lietaert et al. 2022), unstable poles mirrored, residues by least squares;
* singular values of the Hankel matrix of K(t) at the steps of its table (Kung 1978; Kristiansen,
  Hjulstad and Egeland 2005).

Systems of the first two are reduced by balanced truncation, which the third has built in. Each is
the smallest within the tolerance; then it is made passive, in the same way for all.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

import numpy as np
import scipy.linalg

from benchmarks.report import ROOT, Answer, Row
from hydrosim.database.load import read
from hydrosim.radiation import retardation
from hydrosim.radiation.emphasis import Emphasis
from hydrosim.radiation.passivity import Reciprocal, passive
from hydrosim.radiation.rational import Modes, balanced, partial_fractions, vector_fit
from hydrosim.radiation.retardation import diagonal_scale, transfer_function
from hydrosim.radiation.state_space import coupled_groups, frequencies, reciprocal, truncation
from hydrosim.scene.given import Given
from tests.validation_data import unpacked

TOLERANCES = (1e-2, 1e-3, 1e-4)
LENGTH, STEP = 80.0, 0.1  # s
NO_EMPHASIS = Emphasis(1.0, 1.0)  # all frequencies count the same
MOST_POLES, MOST_STATES = 60, 150
FILES = {
    "H-851": ROOT / "hydro_db" / "h851.nc",
    "sphere": unpacked("sphere/sphere.h5"),
    "VolturnUS": unpacked("volturnus/volturnus.1"),
}


class Problem(NamedTuple):
    """K of a group of coupled DOFs, scaled: in time (nt, m, m), and at ``w``, ``inside`` of which
    are in the band up to ``band``."""

    kernel: np.ndarray
    w: np.ndarray
    inside: int
    band: float
    target: np.ndarray

    def error(self, model: Reciprocal) -> float:
        """Largest, over the band."""
        return self.distance(model.transfer_function(1j * self.w))

    def distance(self, found: np.ndarray) -> float:
        """Largest difference of K^ (nw, m, m), over the band."""
        return float(np.abs(found - self.target)[: self.inside].max())


class Fit(NamedTuple):
    """What one way makes of one group; no states where it does not reach the tolerance."""

    states: int
    before: float
    error: float
    seconds: float


class Figures(NamedTuple):
    """What one way makes of all groups of a database."""

    states: str | float
    passivity: str | float
    error: str | float
    seconds: str | float


TITLES = {
    "states": "States, all groups of coupled DOFs together (a dash: not within the tolerance with"
    f" {MOST_POLES} poles or {MOST_STATES} states)",
    "passivity": "Smallest over largest eigenvalue of Re K^, as fitted",
    "error": "Largest error in the band, once passive",
    "seconds": "Time for the fits [s]",
}
Models = Iterator[tuple[Reciprocal, float]]
Way = Callable[[Problem, float], Models]


def answer() -> Answer:
    """States, passivity, error once passive and time, of every database, tolerance and way."""
    tables: dict[str, list[Row]] = {title: [] for title in Figures._fields}
    for name, path in FILES.items():
        groups = list(_problems(path))
        for tolerance in TOLERANCES if groups else ():
            found = {way: _together(groups, tolerance, make) for way, make in WAYS.items()}
            for title, rows in tables.items():
                figures = {way: getattr(figures, title) for way, figures in found.items()}
                rows.append({"database": name, "tolerance": f"{tolerance:.0e}", **figures})
    return Answer({TITLES[title]: rows for title, rows in tables.items()})


def _problems(path: Path) -> Iterator[Problem]:
    db = read(path, Given(length=1.0, water_density=1025.0, gravity=9.81))
    coefficients = db.frequency, db.added_mass, db.radiation_damping
    memory, band = retardation(*coefficients, length=LENGTH, step=STEP), float(db.frequency[-1])
    w, inside = frequencies(LENGTH, band)
    for dofs in coupled_groups(memory.kernel):
        kernel = memory.kernel[:, dofs[:, None], dofs]
        target = transfer_function(memory.time, kernel, w)
        scale = diagonal_scale(target[:inside])
        scale = scale[:, None] * scale
        yield Problem(kernel / scale, w, inside, band, target / scale)


def _together(groups: list[Problem], tolerance: float, make: Way) -> Figures:
    """What one way makes of all groups; a dash where one of them is not within the tolerance."""
    fits = [_smallest(problem, tolerance, make) for problem in groups]
    if not all(fit.states for fit in fits):
        return Figures("-", "-", "-", sum(fit.seconds for fit in fits))
    return Figures(
        sum(fit.states for fit in fits),
        f"{min(fit.before for fit in fits):.0e}",
        f"{max(fit.error for fit in fits):.1e}",
        sum(fit.seconds for fit in fits),
    )


def _smallest(problem: Problem, tolerance: float, make: Way) -> Fit:
    begin = perf_counter()
    for model, error in make(problem, tolerance):
        if model.decay.size > MOST_STATES:
            break
        if error <= tolerance:
            seconds = perf_counter() - begin
            changed, before, _ = passive(model, problem.band, NO_EMPHASIS)
            return Fit(model.decay.size, before, problem.error(changed), seconds)
    return Fit(0, 0.0, 0.0, perf_counter() - begin)


def by_vector_fitting(problem: Problem, tolerance: float) -> Models:
    """Poles until the fit is within half the tolerance, then truncated."""
    return _by_poles(problem, tolerance, lambda s, values, n: vector_fit(s, values, n)[0])


def by_aaa(problem: Problem, tolerance: float) -> Models:
    """The same with the poles of AAA."""
    return _by_poles(problem, tolerance, aaa_poles)


def _by_poles(
    problem: Problem,
    tolerance: float,
    find: Callable[[np.ndarray, np.ndarray, int], np.ndarray],
) -> Models:
    s, m = 1j * problem.w, problem.target.shape[1]
    values = problem.target.reshape(s.size, m * m)
    for order in range(4, MOST_POLES + 1, 4):
        poles = find(s, values, order)
        fractions = partial_fractions(s, poles)
        left, right = (np.concatenate([x.real, x.imag]) for x in (fractions, values))
        residues = np.linalg.lstsq(left, right, rcond=None)[0]
        error = np.abs(fractions @ residues - values)[: problem.inside].max()
        if error <= 0.5 * tolerance:
            break
    residues = residues.reshape(-1, m, m)
    system = balanced(poles, 0.5 * (residues + residues.transpose(0, 2, 1)), NO_EMPHASIS)
    for states in range(1, len(system[0]) + 1):
        model = truncation(system, states)
        if model is not None:
            yield model, problem.error(model)


def aaa_poles(s: np.ndarray, values: np.ndarray, order: int) -> np.ndarray:
    """Poles of the AAA interpolant of ``values`` (ns, ne), about ``order`` of them: stable, real
    ones first, then one of each pair. Points are taken with their conjugates."""
    z, f = np.append(s, s[1:].conj()), np.vstack([values, values[1:].conj()])
    support: list[int] = []
    rest, fitted = np.arange(z.size), np.broadcast_to(f.mean(axis=0), f.shape)
    while len(support) < order + 1:
        worst = rest[np.abs(f - fitted).max(axis=1)[rest].argmax()]
        pair = np.flatnonzero(np.abs(z - z[worst].conj()) < 1e-12)
        support += sorted({int(worst), int(pair[0])})
        rest = np.setdiff1d(np.arange(z.size), support)
        cauchy = 1.0 / (z[rest, None] - z[support])
        loewner = (f[rest, None, :] - f[support]) * cauchy[:, :, None]
        columns = loewner.transpose(0, 2, 1).reshape(-1, len(support))
        weight = np.linalg.svd(np.linalg.qr(columns, mode="r"))[2][-1].conj()
        fitted = f.copy()
        fitted[rest] = (cauchy * weight) @ f[support] / (cauchy @ weight)[:, None]
    n = len(support)
    pencil = np.block([[np.zeros((1, 1)), weight[None]], [np.ones((n, 1)), np.diag(z[support])]])
    found = scipy.linalg.eigvals(pencil, np.diag(np.append(0.0, np.ones(n))))
    found = found[np.abs(found) < 1e3 * np.abs(s).max()]
    poles = -np.abs(found.real) + 1j * found.imag
    real = np.abs(poles.imag) < 1e-6 * np.abs(s).max()
    return np.concatenate([poles[real].real + 0j, poles[~real & (poles.imag > 0.0)]])


def by_hankel(problem: Problem, tolerance: float) -> Models:
    """Balanced realisations of the samples of K; those that are not stable are passed over. The
    error is that of the lines between the samples of the model, as K^ is of those of K."""
    m, blocks = problem.kernel.shape[1], len(problem.kernel) // 2
    lag, time = np.arange(blocks), STEP * np.arange(len(problem.kernel))
    hankel = problem.kernel[lag[:, None] + lag].transpose(0, 2, 1, 3).reshape(m * blocks, -1)
    U, size, Vt = np.linalg.svd(hankel)
    for k in range(1, MOST_STATES + 1):
        observed, reached = U[:, :k] * np.sqrt(size[:k]), np.sqrt(size[:k])[:, None] * Vt[:k]
        A = np.linalg.lstsq(observed[:-m], observed[m:], rcond=None)[0]
        factor, vectors = np.linalg.eig(A)
        if np.any(np.abs(factor) >= 1.0) or np.any((factor.imag == 0.0) & (factor.real <= 0.0)):
            continue
        poles, b = np.log(factor.astype(complex)) / STEP, np.linalg.solve(vectors, reached[:, :m])
        modes = Modes(poles, observed[:m] @ vectors, b)
        samples = modes.impulse_response(time)
        yield reciprocal(modes), problem.distance(transfer_function(time, samples, problem.w))


WAYS: dict[str, Way] = {
    "vector fitting": by_vector_fitting,
    "AAA": by_aaa,
    "Hankel": by_hankel,
}
