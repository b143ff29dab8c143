"""State-space models of a database, stored on disk so that each is fitted once.

Fits with fewer states, as exact as the motions of the free bodies require.

An additional force dK^ v changes harmonic motions v by -Y dK^ v. Y = (s (M + A_inf) + C / s +
K^)^-1 is the admittance of bodies that float freely. A large inertia makes motions insensitive to
errors of K^ that are large compared with K^ itself.

So a fit is repeated with errors weighted by |Y|. Its error is the largest spectral norm of Y dK^ in
the band, with coordinates scaled by the roots of their inertias. Y does not contain lines and
contacts. The effect of a fit on the whole scene is measured later (`compiling.memory_errors`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.water.radiation.kept import Arrays, read_or_make
from hydrosim.water.radiation.retardation import SLOWEST, Retardation
from hydrosim.water.radiation.state_space import (
    HELD_DOWN,
    TOLERANCE,
    FitReport,
    StateSpace,
    Target,
    coupled_groups,
    find_state_space,
    find_target,
    fit_group,
    fit_once,
)
from hydrosim.water.radiation.threads import one_thread

PART = 0.5  # of the tolerance: largest change of motions by a reduced model
BETWEEN = 8  # points of an integral for each frequency: poles are narrower than the spacing


class Floating(NamedTuple):
    """Bodies that float freely: their ``inertia`` (n, n), without added mass, and hydrostatic
    ``stiffness`` (n, n), both along the DOFs of their database; SI."""

    inertia: np.ndarray
    stiffness: np.ndarray

    def among(self, dofs: np.ndarray) -> Floating:
        """The bodies with all DOFs held except ``dofs`` (m,)."""
        block = dofs[:, None], dofs
        return Floating(self.inertia[block], self.stiffness[block])


class Felt(NamedTuple):
    """The weight |W| = ``size`` (nw,) at the frequencies ``w`` (nw,), zero beyond them."""

    w: np.ndarray
    size: np.ndarray

    def at(self, w: np.ndarray) -> np.ndarray:
        """|W| at the frequencies w [rad/s], linear between the known ones."""
        return np.interp(w, self.w, self.size)

    def gramian(self, A: np.ndarray, B: np.ndarray) -> np.ndarray:
        """1 / 2 pi int |W|^2 (i w - A)^-1 B B^T (i w - A)^-H dw, over the known frequencies."""
        places = np.arange(BETWEEN * (self.w.size - 1) + 1) / BETWEEN
        w = np.interp(places, np.arange(self.w.size), self.w)
        width = np.gradient(w)
        width[[0, -1]] *= 0.5  # the trapezoidal rule
        share = self.at(w) ** 2 * width / np.pi  # of w and -w together
        poles, vectors = np.linalg.eig(A)
        b = np.linalg.solve(vectors, B.astype(complex))
        resolved = 1.0 / (1j * w[:, None] - poles)
        modal = (share * resolved.T) @ resolved.conj() * (b @ b.conj().T)
        result = (vectors @ modal @ vectors.conj().T).real
        return np.asarray(0.5 * (result + result.T))


@dataclass(frozen=True, eq=False)
class FeltTarget(Target):
    """A target whose errors are changes of motion: ``admittance`` (nw, m, m) is Y, scaled."""

    admittance: np.ndarray

    def error(self, fitted: np.ndarray) -> float:
        """Largest change of motion in the band if K^ is replaced by ``found`` (nw, m, m)."""
        change = self.admittance @ (fitted - self.values)
        return float(np.linalg.norm(change, 2, axis=(1, 2))[: self.inside].max())


@one_thread
def reduce_stored(
    full: StateSpace, memory: Retardation, band: float, floating: Floating
) -> StateSpace:
    """A passive model with fewer states than the fit ``full``, which changes the motions of
    ``floating`` bodies by at most `PART` of its tolerance. Returns ``full`` itself if none was
    found.

    ``memory`` and ``band`` [rad/s] are those of the fit.
    """
    target = felt_target(memory, full.dofs, band, floating)
    tolerance = full.report.tolerance
    model, report = fit_once(target, PART * tolerance)
    good = report.passive and report.frequency_error <= PART * tolerance
    if not good or model.decay.size >= full.order:
        return full
    felt = replace(report, tolerance=tolerance, motion_error=report.frequency_error)
    result = find_state_space(model, felt, target, memory)
    plain = find_target(memory, full.dofs, band)
    K = result.modes.transfer_function(1j * plain.w) / np.outer(plain.scale, plain.scale)
    return replace(result, report=replace(result.report, frequency_error=plain.error(K)))


def felt_target(
    memory: Retardation, dofs: np.ndarray, band: float, floating: Floating
) -> FeltTarget:
    """K^ between the ``dofs`` (m,) as in `target_of`, with the admittance of the `floating`
    bodies."""
    plain = find_target(memory, dofs, band)
    inertia, stiffness = floating.among(dofs)
    inertia = inertia + memory.added_mass_infinite[dofs[:, None], dofs]
    scale = np.sqrt(np.diag(inertia))
    size = np.outer(scale, scale)
    values = plain.values * np.outer(plain.scale, plain.scale) / size
    s = (SLOWEST + 1j * plain.w)[:, None, None]
    admittance = np.linalg.inv(s * (inertia / size) + stiffness / size / s + values)
    felt = np.linalg.norm(admittance, 2, axis=(1, 2))
    held_down = np.where(np.arange(plain.w.size) >= plain.inside, HELD_DOWN, 1.0)
    return FeltTarget(
        dofs=dofs,
        w=plain.w,
        inside=plain.inside,
        band=band,
        values=values,
        scale=scale,
        emphasis=Felt(plain.w, felt),
        weight=held_down * felt,
        gain=0.0,  # one attempt is made, without regard to the limit of passive models
        admittance=admittance,
    )


ARRAYS = tuple(field.name for field in fields(StateSpace) if field.name != "report")


TOLERABLE = 10.0  # times the tolerance: largest error of an accepted passive fit


def fit_state_space(
    checksum: str,
    memory: Retardation,
    frequency: np.ndarray,
    free: np.ndarray,
    tolerance: float = TOLERANCE,
) -> tuple[StateSpace, ...]:
    """State-space models of all groups of coupled DOFs of a database, among its ``free`` DOFs (m,),
    see `fit_group`. Their reports say whether they are within the tolerance.

    Each is stored in the cache folder by the database's ``checksum``, the table of K, the band of
    ``frequency`` [rad/s], the tolerance and its DOFs, see `kept`.
    """
    band = float(frequency[-1])
    settings = (checksum, memory.time.size, float(memory.time[-1]), band, tolerance)
    return tuple(
        read_or_make(
            "fits",
            (*settings, *dofs.tolist()),
            partial(fit_group, memory, dofs, band, tolerance),
            _state_space_arrays,
            _read_state_space,
        )
        for dofs in groups_free_to_reduce(memory, free, tolerance)
    )


def reduce_states(
    models: Sequence[StateSpace],
    checksum: str,
    memory: Retardation,
    frequency: np.ndarray,
    floating: Floating,
) -> tuple[StateSpace, ...]:
    """The ``models`` of `fit`, with fewer states where a model is within its tolerance, see
    `reduced`; other models are unchanged.

    Each is stored like a model of `fit`; its key also contains the inertia and stiffness of the
    ``floating`` bodies.
    """
    band = float(frequency[-1])

    def smaller(model: StateSpace) -> StateSpace:
        felt = floating.among(model.dofs)
        settings = (
            checksum,
            memory.time.size,
            float(memory.time[-1]),
            band,
            model.report.tolerance,
            *model.dofs.tolist(),
            *np.ravel(felt).tolist(),
        )
        make = partial(reduce_stored, model, memory, band, floating)
        return read_or_make("reduced", settings, make, _state_space_arrays, _read_state_space)

    return tuple(smaller(model) if model.report.holds else model for model in models)


def groups_free_to_reduce(
    memory: Retardation, free: np.ndarray, tolerance: float = TOLERANCE
) -> list[np.ndarray]:
    """The groups of `coupled_groups`, restricted to the ``free`` DOFs (m,): the other DOFs do not
    move."""
    block = memory.kernel[:, free[:, None], free]
    return [free[group] for group in coupled_groups(block, tolerance)]


def check_fits(models: Sequence[StateSpace], source: str) -> None:
    """Raises InputError if a group has no passive fit with an error below ten times the tolerance,
    and convolution is not allowed. The message names the database's ``source`` and all groups that
    fail."""
    failed = [model for model in models if not is_tolerable(model)]
    if not failed:
        return
    tolerance = failed[0].report.tolerance
    reached = max(model.report.frequency_error for model in models)
    described = "; ".join(
        f"{_name_dofs(model.dofs)}: {_describe_nearest(model)}" for model in failed
    )
    raise InputError(
        f"{source}: fitted a state-space model to the radiation of {described}, and none that is"
        f" passive has an error below {TOLERABLE * tolerance:g}; expected damping that is smooth"
        " and positive, and a memory that has decayed at its end. Check the database with"
        " `hydrosim db check`. Then choose: one database for each body, with which `automatic` uses"
        " convolution; a longer memory, radiation: {length: ...}; or a larger error,"
        f" radiation: {{model: state_space, tolerance: {_round_up(reached):g}}}."
    )


def is_within_tolerance(model: StateSpace) -> bool:
    """True if a fit is passive and within its tolerance."""
    return model.report.holds


def is_tolerable(model: StateSpace) -> bool:
    """True if a fit is passive and within ten times its tolerance."""
    report = model.report
    return report.passive and report.error <= TOLERABLE * report.tolerance


def _name_dofs(dofs: np.ndarray) -> str:
    return ", ".join(
        DOFS[dof % 6] + (f" of body {dof // 6 + 1}" if dof > 5 else "") for dof in dofs
    )


def _describe_nearest(model: StateSpace) -> str:
    report = model.report
    return (
        f"the nearest, with {model.order} states, has an error of {report.frequency_error:.1e}"
        f" (passivity {report.passivity_margin:.1e}, {report.passivity_before:.1e} before)"
    )


def _round_up(error: float) -> float:
    """The smallest tolerance with one digit that is not below this error."""
    size = 10.0 ** np.floor(np.log10(error))
    return float(np.ceil(error / size) * size)


def _read_state_space(arrays: Arrays) -> StateSpace:
    report = FitReport(*map(float, arrays["report"]))
    return StateSpace(**{name: arrays[name] for name in ARRAYS}, report=report)


def _state_space_arrays(model: StateSpace) -> Arrays:
    arrays = {name: getattr(model, name) for name in ARRAYS}
    return {**arrays, "report": np.array(astuple(model.report))}
