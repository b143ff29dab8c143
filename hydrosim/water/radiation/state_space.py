"""Retardation functions as the impulse response of a linear system: K(t) = C exp(Lambda t) B.

The fit is made in the frequency domain, on K^(i w) = B(w) + i w (A(w) - A_inf), by `rational`. It
is stable and reciprocal by construction, and is then made passive, see `passivity`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from hydrosim.water.radiation.passivity import ROUNDING, Reciprocal, make_passive
from hydrosim.water.radiation.rational import (
    Modes,
    Weight,
    balance,
    find_emphasis,
    find_modes,
    partial_fractions,
    vector_fit,
)
from hydrosim.water.radiation.retardation import (
    Retardation,
    diagonal_scale,
    find_radiating,
    relative_size,
    transfer_function,
)
from hydrosim.water.radiation.threads import one_thread

TOLERANCE = 3e-4
ORDERS = (4, 8, 12, 16, 20, 24, 28, 34, 40, 48, 58, 70, 84, 100)  # most poles in vector fitting
FEWEST = 160  # fewest intervals of the band: with fewer, fits of many poles have peaks in between
BEYOND = 3.0  # the fit covers this multiple of the band
HELD_DOWN = 10.0  # weight of errors beyond the band, so that damping is not negative there
# of the gain of a non-passive target: how close a fit to it is attempted, and is accepted
PART = 0.2
NEARLY = 1.5
ATTEMPTS = ((4.0, 1.0), (np.inf, 1.0), (4.0, 2.0), (4.0, 4.0))
"""Fastest poles, in bands, and target errors, in tolerances. Fast poles need small steps, so they
are limited first."""
MOST = 150  # most states of a group: an integral costs less than more states
# additional states that are tried if the smallest model is not passive
MORE = (0, 1, 2, 4, 7, 11, 16, 22, 30, 40, 52)


@dataclass(frozen=True)
class FitReport:
    """Deviation of a state-space model from its retardation functions.

    Errors are the largest over the entries ij, each divided by the geometric mean of the largest
    |.| of the diagonal entries ii and jj.
    """

    tolerance: float  # tolerance of `frequency_error`
    frequency_error: float  # of K^(i w) over the database's band, times W of `emphasis`
    time_error: float  # of K(t) over its table
    passivity_before: float  # see `passivity.passive`: negative for a fit that had to be changed
    passivity_margin: float  # the same of the final model
    motion_error: float = np.inf  # of the motions of free bodies, see `reduction`

    @property
    def passive(self) -> bool:
        """True if no motion gains energy from the model."""
        return self.passivity_margin >= -ROUNDING

    @property
    def error(self) -> float:
        """The error that the tolerance limits: the error in frequency or, if smaller, the error of
        motions."""
        return min(self.frequency_error, self.motion_error)

    @property
    def holds(self) -> bool:
        """True if the model is passive and within its tolerance."""
        return self.passive and self.error <= self.tolerance

    @property
    def refusal(self) -> str:
        """Reason why the model is refused where it must be within its tolerance."""
        return (
            f"no passive state-space model within {self.tolerance:g} was found; the nearest has an"
            f" error of {self.frequency_error:.1e}"
        )

    def __str__(self) -> str:
        felt = f"{self.motion_error:.1e} of motions, " if np.isfinite(self.motion_error) else ""
        return (
            f"error {felt}{self.frequency_error:.1e} in frequency, {self.time_error:.1e} in time,"
            f" passivity {self.passivity_margin:.1e} ({self.passivity_before:.1e} as fitted)"
        )


@dataclass(frozen=True, eq=False)
class StateSpace:
    """x' = Lambda x + B v, F = -C x for one group of coupled DOFs, in real modal form.

    The states are: one per real pole, then the first states of all pairs of complex poles, then
    their second states. Real pole: x' = a x + B v. Pair a +- i w: x1' = a x1 + w x2 + B1 v and x2'
    = a x2 - w x1 + B2 v. For each pole, rows of B and columns of C have the same norm.
    """

    dofs: np.ndarray  # (m,) int64, the group's DOFs
    decay: np.ndarray  # (poles,) real parts a [1/s], all negative; real poles first
    frequency: np.ndarray  # (poles,) imaginary parts w [rad/s], 0 for the real poles
    B: np.ndarray  # (states, m)
    C: np.ndarray  # (m, states)
    report: FitReport

    @property
    def order(self) -> int:
        """Number of states."""
        return self.B.shape[0]

    @property
    def real(self) -> int:
        """Number of real poles."""
        return int(np.count_nonzero(self.frequency == 0.0))

    @property
    def matrix(self) -> np.ndarray:
        """Lambda, (states, states)."""
        pairs = self.decay.size - self.real
        result = np.diag(np.concatenate([self.decay, self.decay[self.real :]]))
        first = self.real + np.arange(pairs)
        result[first, first + pairs] = self.frequency[self.real :]
        result[first + pairs, first] = -self.frequency[self.real :]
        return result

    def on_dofs(self, dofs: np.ndarray) -> StateSpace:
        """The model for other DOFs (m,), such as those of a body in a scene."""
        return replace(self, dofs=np.asarray(dofs, dtype=np.int64))

    @property
    def modes(self) -> Modes:
        """The system with both poles of each pair; it has the transfer function."""
        n = self.real
        half = self.decay.size
        upper = self.decay[n:] + 1j * self.frequency[n:]
        c = (self.C[:, n:half] + 1j * self.C[:, half:]) / np.sqrt(2.0)
        b = (self.B[n:half] - 1j * self.B[half:]) / np.sqrt(2.0)
        return Modes(
            np.concatenate([self.decay[:n], upper, upper.conj()]),
            np.hstack([self.C[:, :n], c, c.conj()]),
            np.vstack([self.B[:n], b, b.conj()]),
        )


def coupled_groups(kernel: np.ndarray, tolerance: float = TOLERANCE) -> list[np.ndarray]:
    """Groups of coupled DOFs, from K (nt, n, n) or B (nw, n, n), n = 6 per body.

    i and j are coupled if max |K_ij| or max |K_ji| exceeds ``tolerance`` times the geometric mean
    of max |K_ii| and max |K_jj|. Smaller couplings count as rounding. DOFs that do not radiate are
    in no group, see `radiating`.
    """
    active = find_radiating(kernel)
    block = kernel[:, active[:, None], active]
    scale = diagonal_scale(block)
    coupled = np.abs(block).max(axis=0) > tolerance * scale[:, None] * scale
    together = coupled | coupled.T | np.eye(active.size, dtype=bool)
    for _ in range(active.size):
        together = together @ together  # with all DOFs coupled to these
    first = together.argmax(axis=1) if active.size else active
    return [active[first == i] for i in np.unique(first)]


@dataclass(frozen=True, eq=False)
class Target:
    """Data of a fit: K^ (nw, m, m) at ``w`` (nw,), divided by ``scale`` (m,) of its rows and
    columns. The first ``inside`` frequencies are in the ``band``.

    ``emphasis`` is the weight of frequencies; ``weight`` (nw,) that of errors in vector fitting.
    ``gain`` is the largest energy gain of K^, weighted by the emphasis. The distance of any passive
    model from K^ is at least the gain divided by m, and hardly less than the gain.
    """

    dofs: np.ndarray
    w: np.ndarray
    inside: int
    band: float
    values: np.ndarray
    scale: np.ndarray
    emphasis: Weight
    weight: np.ndarray
    gain: float

    def error(self, fitted: np.ndarray) -> float:
        """Largest weighted error of ``found`` (nw, m, m) in the band."""
        off = np.abs(fitted - self.values).max(axis=(1, 2))
        return float((self.emphasis.at(self.w) * off)[: self.inside].max())


@one_thread
def find_target(memory: Retardation, dofs: np.ndarray, band: float) -> Target:
    """K^ between the ``dofs`` (m,); ``band`` [rad/s] is the database's highest frequency."""
    kernel = memory.kernel[:, dofs[:, None], dofs]
    w, inside = choose_frequencies(memory.time[-1], band)
    values = transfer_function(memory.time, kernel, w)
    scale = diagonal_scale(values[:inside])
    values = values / (scale[:, None] * scale)
    emphasis = find_emphasis(w[:inside], values[:inside])
    counted = emphasis.at(w)
    weight = np.where(np.arange(w.size) >= inside, HELD_DOWN, 1.0) * counted
    least = np.linalg.eigvalsh(values.real)[:, 0]
    gain = max(0.0, -float((counted * least)[:inside].min()))
    return Target(dofs, w, inside, band, values, scale, emphasis, weight, gain)


@one_thread
def fit_group(
    memory: Retardation, dofs: np.ndarray, band: float, tolerance: float = TOLERANCE
) -> StateSpace:
    """State-space model of K between the ``dofs`` (m,), with few states.

    Poles are added until vector fitting is within half the tolerance. Then the smallest balanced
    truncation is used that can be made passive with a `FitReport.frequency_error` within
    ``tolerance``. ``band`` [rad/s] is the database's highest frequency. All poles are stable by
    construction.

    If the tolerance cannot be reached, the nearest model with a reasonable number of states is
    returned. Compare the report's error with its tolerance, and its passivity margin with zero.
    """
    target = find_target(memory, dofs, band)
    return find_state_space(*_fit_within(target, tolerance), target, memory)


def find_state_space(
    model: Reciprocal, report: FitReport, target: Target, memory: Retardation
) -> StateSpace:
    """The ``model`` of a ``target`` in SI units, with its error in time in the report."""
    dofs = target.dofs
    result = StateSpace(
        dofs=np.asarray(dofs, dtype=np.int64),
        decay=model.decay[: model.decay.size - model.rotation.size],
        frequency=np.append(np.zeros(model.decay.size - 2 * model.rotation.size), model.rotation),
        B=model.B * target.scale,
        C=(model.B * target.scale).T * model.sign,
        report=report,
    )
    kernel = memory.kernel[:, dofs[:, None], dofs]
    late = relative_size(result.modes.impulse_response(memory.time) - kernel, kernel)
    return replace(result, report=replace(report, time_error=late))


def choose_frequencies(length: float, band: float) -> tuple[np.ndarray, int]:
    """Frequencies of a fit [rad/s], and the number of these in the band. They are twice as dense as
    a memory of this length needs (pi / T), and coarse above the band. Short memories have
    `FEWEST`."""
    inside = max(int(np.ceil(2.0 * band * length / np.pi)), FEWEST) + 1
    above = np.geomspace(band, BEYOND * band, inside // 3 + 2)[1:]
    return np.append(np.linspace(0.0, band, inside), above), inside


def _vector_fit(target: Target, tolerance: float, fastest: float) -> tuple[np.ndarray, np.ndarray]:
    """Poles, up to ``fastest`` [rad/s], and residues (order, m, m) of the first fit within the
    tolerance, or else of the best fit."""
    s = 1j * target.w
    m = target.scale.size
    upper = np.triu_indices(m)
    place = np.zeros((m, m), dtype=int)
    place[upper] = place.T[upper] = np.arange(upper[0].size)
    values = target.values[:, *upper]
    best = np.inf, np.empty(0), np.empty(0)
    for order in ORDERS:
        poles, residues = vector_fit(s, values, order, target.weight, fastest, target.band)
        error = target.error((partial_fractions(s, poles) @ residues)[:, place])
        if error < best[0]:
            best = error, poles, residues[:, place]
        if error <= tolerance:
            break
    return best[1], best[2]


System = tuple[np.ndarray, np.ndarray, np.ndarray]


def _fit_within(target: Target, tolerance: float) -> tuple[Reciprocal, FitReport]:
    """A passive model within the tolerance, with few states. If the tolerance cannot be reached, a
    model as close as passive models can be, or the best one for wider targets."""
    candidates: list[tuple[Reciprocal, FitReport]] = []
    least = max(tolerance, PART * target.gain)
    reached: dict[float, float] = {}
    for fastest, times in ATTEMPTS:
        aim = times * least
        if aim < reached.get(fastest, 0.0):
            continue  # it would be the same fit again
        good = max(aim, NEARLY * target.gain)
        system = _balanced_fit(target, aim, fastest * target.band)
        reached[fastest] = _find_untruncated_error(system, target)
        is_hopeless = reached[fastest] > aim
        candidates.append(_find_smallest_fit(system, target, tolerance, aim, good, is_hopeless))
        if _is_good(candidates[-1][1], good):
            break
    return min(candidates, key=_rank_fit)


def _balanced_fit(target: Target, aim: float, fastest: float) -> System:
    """The balanced states of a fit within half the ``aim``, most important first."""
    fit = _vector_fit(target, 0.5 * aim, fastest)
    A, B, C = balance(*fit, target.emphasis)
    return A[:MOST, :MOST], B[:MOST], C[:, :MOST]


def fit_once(target: Target, tolerance: float) -> tuple[Reciprocal, FitReport]:
    """A passive model within the tolerance, with few states, from one attempt; or else the best
    that was tried."""
    system = _balanced_fit(target, tolerance, ATTEMPTS[0][0] * target.band)
    is_hopeless = _find_untruncated_error(system, target) > tolerance
    return _find_smallest_fit(system, target, tolerance, tolerance, tolerance, is_hopeless)


def _is_good(report: FitReport, aim: float) -> bool:
    return report.passive and report.frequency_error <= aim


def _rank_fit(candidate: tuple[Reciprocal, FitReport]) -> tuple[bool, float]:
    return not candidate[1].passive, candidate[1].frequency_error


def _find_smallest_fit(
    system: System,
    target: Target,
    tolerance: float,
    aim: float,
    good: float,
    is_hopeless: bool,
) -> tuple[Reciprocal, FitReport]:
    """The first balanced truncation that is within the ``aim``, and within ``good`` after it is
    made passive; else the best of several. It ``is_hopeless`` if not even all states are within the
    ``aim``. Then it is the largest that can be made passive: to search on would take minutes and
    gain nothing."""
    candidates: list[tuple[Reciprocal, FitReport]] = []
    fewest = _find_fewest_states(system, target, aim)
    tried = [fewest + more for more in MORE]
    for model in filter(None, map(partial(truncate, system), [*tried, *range(fewest)[::-1]])):
        if len(candidates) == len(MORE):
            break
        changed, before, after = make_passive(model, target.band, target.emphasis)
        error = target.error(changed.transfer_function(1j * target.w))
        report = FitReport(tolerance, error, 0.0, before, after)
        candidates.append((changed, report))
        if _is_good(report, good) or (is_hopeless and report.passive):
            break
    return min(candidates, key=_rank_fit)


def _find_fewest_states(system: System, target: Target, aim: float) -> int:
    """Number of states of the smallest truncation within the ``aim``, by bisection; all of them if
    none is. Errors fall almost monotonically with the number."""
    low = 0
    high = len(system[0])
    while high - low > 1:
        middle = (low + high) // 2
        if _find_error(truncate(system, middle), target) > aim:
            low = middle
        else:
            high = middle
    return high


def _find_untruncated_error(system: System, target: Target) -> float:
    """The error of a system with all its states."""
    return _find_error(truncate(system, len(system[0])), target)


def _find_error(model: Reciprocal | None, target: Target) -> float:
    """The error of a model; infinite if there is none."""
    return np.inf if model is None else target.error(model.transfer_function(1j * target.w))


def truncate(system: System, states: int) -> Reciprocal | None:
    """A balanced truncation in reciprocal form; None if it has a different number of states or is
    unstable."""
    A, B, C = system
    if states > len(A):
        return None
    truncated = find_modes(A[:states, :states], B[:states], C[:, :states])
    return make_reciprocal(truncated) if np.all(truncated.poles.real < 0.0) else None


def make_reciprocal(modes: Modes) -> Reciprocal:
    """The modes with every residue c b replaced by +-b^T b. In a reciprocal system b and c are
    parallel, so that only their lengths and phases are free. A part that is not reciprocal is left
    out."""
    real = modes.poles.imag == 0.0
    upper = modes.poles.imag > 0.0
    size = np.einsum("km,km->k", modes.b.conj(), modes.b).real
    ratio = np.einsum("km,mk->k", modes.b.conj(), modes.c) / size
    b = np.sqrt(np.where(real, np.abs(ratio), ratio))[:, None] * modes.b
    first = np.sqrt(2.0) * b[upper]
    pairs = int(np.count_nonzero(upper))
    poles = modes.poles[upper]
    return Reciprocal(
        decay=np.concatenate([modes.poles[real].real, poles.real, poles.real]),
        rotation=poles.imag,
        sign=np.concatenate([np.sign(ratio[real].real), np.ones(pairs), -np.ones(pairs)]),
        B=np.vstack([b[real].real, first.real, -first.imag]),
    )
