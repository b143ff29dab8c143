"""Retardation functions as the impulse response of a linear system: K(t) = C exp(Lambda t) B.

The fit is made in the frequency domain, on K^(i w) = B(w) + i w (A(w) - A_inf), by `rational`. It
is stable and reciprocal by construction, and then made passive, see `passivity`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from hydrosim.radiation.passivity import ROUNDING, Reciprocal, passive
from hydrosim.radiation.rational import (
    Modes,
    balanced,
    modes,
    partial_fractions,
    realisation,
    vector_fit,
)
from hydrosim.radiation.retardation import (
    Retardation,
    diagonal_scale,
    radiating,
    relative_size,
    transfer_function,
)
from hydrosim.radiation.threads import one_thread

TOLERANCE = 1e-3
MAX_ORDER = 60  # poles in vector fitting
BEYOND = 3.0  # the fit is made up to this multiple of the band
TRIES, FEW = 12, 3  # truncations that are made passive; of data that are too far from it


@dataclass(frozen=True)
class FitReport:
    """How far a state-space model is from its retardation functions.

    Errors are the largest over the entries ij, each divided by the geometric mean of the largest
    |.| of the diagonal entries ii and jj.
    """

    tolerance: float  # asked of `frequency_error`
    frequency_error: float  # of K^(i w) over the database's band
    time_error: float  # of K(t) over its table
    passivity_before: float  # see `passivity.passive`: negative for a fit that had to be changed
    passivity_margin: float  # the same of the model

    def __str__(self) -> str:
        return (
            f"error {self.frequency_error:.1e} in frequency, {self.time_error:.1e} in time,"
            f" passivity {self.passivity_margin:.1e} ({self.passivity_before:.1e} as fitted)"
        )


@dataclass(frozen=True, eq=False)
class StateSpace:
    """x' = Lambda x + B v, F = -C x for one group of coupled DOFs, in real modal form.

    The states are: one per real pole, then the first states of all pairs of complex poles, then
    their second states. Real pole: x' = a x + B v. Pair a +- i w: x1' = a x1 + w x2 + B1 v and
    x2' = a x2 - w x1 + B2 v. Rows of B and columns of C of one pole have the same norm.
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
        """The same model acting on other DOFs (m,), as on those of a body in a scene."""
        return replace(self, dofs=np.asarray(dofs, dtype=np.int64))

    @property
    def modes(self) -> Modes:
        """The system with each pole of a pair written out; has the transfer function."""
        n, half = self.real, self.decay.size
        upper = self.decay[n:] + 1j * self.frequency[n:]
        c = (self.C[:, n:half] + 1j * self.C[:, half:]) / np.sqrt(2.0)
        b = (self.B[n:half] - 1j * self.B[half:]) / np.sqrt(2.0)
        return Modes(
            np.concatenate([self.decay[:n], upper, upper.conj()]),
            np.hstack([self.C[:, :n], c, c.conj()]),
            np.vstack([self.B[:n], b, b.conj()]),
        )


def coupled_groups(kernel: np.ndarray, tolerance: float = TOLERANCE) -> list[np.ndarray]:
    """Groups of DOFs that drive each other, from K (nt, n, n) or B (nw, n, n), n = 6 per body.

    i and j are coupled where max |K_ij| or max |K_ji| exceeds ``tolerance`` times the geometric
    mean of max |K_ii| and max |K_jj|; smaller couplings are taken for rounding. DOFs that do not
    radiate are in no group, see `radiating`.
    """
    active = radiating(kernel)
    block = kernel[:, active[:, None], active]
    scale = diagonal_scale(block)
    coupled = np.abs(block).max(axis=0) > tolerance * scale[:, None] * scale
    together = coupled | coupled.T | np.eye(active.size, dtype=bool)
    for _ in range(active.size):
        together = together @ together  # and those that are coupled to these
    first = together.argmax(axis=1) if active.size else active
    return [active[first == i] for i in np.unique(first)]


@one_thread
def fit_group(
    memory: Retardation, dofs: np.ndarray, band: float, tolerance: float = TOLERANCE
) -> StateSpace:
    """State-space model of K between the ``dofs`` (m,), with few states.

    Poles are added until vector fitting is within half the tolerance; then the smallest balanced
    truncation is taken that can be made passive and whose `FitReport.frequency_error` is then
    within ``tolerance``. ``band`` [rad/s] is the database's highest frequency. All poles are stable
    by construction. Where the tolerance cannot be reached, the model nearest to it is returned:
    compare the report's error with its tolerance, and its passivity margin with zero.
    """
    kernel = memory.kernel[:, dofs[:, None], dofs]
    w, inside = frequencies(memory.time[-1], band)
    target = transfer_function(memory.time, kernel, w)
    scale = diagonal_scale(target[:inside])
    target = target / (scale[:, None] * scale)
    system = balanced(*_vector_fit(1j * w, target, inside, 0.5 * tolerance))
    found = _smallest(system, band, w[:inside], target[:inside], tolerance)
    model = replace(found.model, B=found.model.B * scale)
    result = StateSpace(
        dofs=np.asarray(dofs, dtype=np.int64),
        decay=model.decay[: model.decay.size - model.rotation.size],
        frequency=np.append(np.zeros(model.decay.size - 2 * model.rotation.size), model.rotation),
        B=model.B,
        C=model.B.T * model.sign,
        report=FitReport(tolerance, found.error, 0.0, found.before, found.after),
    )
    late = relative_size(result.modes.impulse_response(memory.time) - kernel, kernel)
    return replace(result, report=replace(result.report, time_error=late))


def frequencies(length: float, band: float) -> tuple[np.ndarray, int]:
    """Where a fit is made [rad/s], and how many of these are in the band: twice as dense as a
    memory of this length needs (pi / T), coarse above it."""
    inside = int(np.ceil(2.0 * band * length / np.pi)) + 1
    above = np.geomspace(band, BEYOND * band, inside // 3 + 2)[1:]
    return np.append(np.linspace(0.0, band, inside), above), inside


def _vector_fit(
    s: np.ndarray, target: np.ndarray, inside: int, tolerance: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    m = target.shape[1]
    values = target.reshape(s.size, m * m)
    for order in range(4, MAX_ORDER + 1, 4):
        poles, residues = vector_fit(s, values, order)
        error = partial_fractions(s, poles) @ residues - values
        if np.abs(error[:inside]).max() <= tolerance:
            break
    return realisation(poles, residues.reshape(-1, m, m))


class _Found(NamedTuple):
    """A passive model, its largest error, and the passivity before and after the change."""

    model: Reciprocal
    error: float
    before: float
    after: float


def _smallest(
    system: tuple[np.ndarray, np.ndarray, np.ndarray],
    band: float,
    w: np.ndarray,
    target: np.ndarray,
    tolerance: float,
) -> _Found:
    """The first balanced truncation that is within the tolerance once it is passive; else the best
    of the first few that were within it before, or of all if there are none."""
    models = list(truncations(*system))
    errors = [np.abs(model.transfer_function(1j * w) - target).max() for model in models]
    good = [model for model, error in zip(models, errors, strict=True) if error <= tolerance]
    found: list[_Found] = []
    tries = TRIES if np.linalg.eigvalsh(target.real).min() >= -tolerance else FEW
    for model in good[:tries] or [models[int(np.argmin(errors))]]:
        changed, before, after = passive(model, band)
        error = np.abs(changed.transfer_function(1j * w) - target).max()
        found.append(_Found(changed, float(error), before, after))
        if error <= tolerance and after >= -ROUNDING:
            break
    return min(found, key=lambda one: (one.after < -ROUNDING, one.error))


def truncations(A: np.ndarray, B: np.ndarray, C: np.ndarray) -> Iterator[Reciprocal]:
    """The stable balanced truncations, the smallest first, in reciprocal form."""
    for k in range(1, len(A) + 1):
        candidate = modes(A[:k, :k], B[:k], C[:, :k])
        if np.all(candidate.poles.real < 0.0):
            yield reciprocal(candidate)


def reciprocal(modes: Modes) -> Reciprocal:
    """The modes with every residue c b as +-b^T b: b and c of a reciprocal system are parallel, so
    that only their lengths and phases are free. A part that is not reciprocal is left out."""
    real, upper = modes.poles.imag == 0.0, modes.poles.imag > 0.0
    size = np.einsum("km,km->k", modes.b.conj(), modes.b).real
    ratio = np.einsum("km,mk->k", modes.b.conj(), modes.c) / size
    b = np.sqrt(np.where(real, np.abs(ratio), ratio))[:, None] * modes.b
    first, pairs = np.sqrt(2.0) * b[upper], int(np.count_nonzero(upper))
    poles = modes.poles[upper]
    return Reciprocal(
        decay=np.concatenate([modes.poles[real].real, poles.real, poles.real]),
        rotation=poles.imag,
        sign=np.concatenate([np.sign(ratio[real].real), np.ones(pairs), -np.ones(pairs)]),
        B=np.vstack([b[real].real, first.real, -first.imag]),
    )
