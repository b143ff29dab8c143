"""State-space models of a database, stored on disk so that each is fitted once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, fields
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.water.radiation.kept import Arrays, kept
from hydrosim.water.radiation.reduction import Floating, reduced
from hydrosim.water.radiation.state_space import (
    TOLERANCE,
    FitReport,
    StateSpace,
    coupled_groups,
    fit_group,
)

if TYPE_CHECKING:
    from hydrosim.water.radiation.retardation import Retardation

ARRAYS = tuple(field.name for field in fields(StateSpace) if field.name != "report")


TOLERABLE = 10.0  # times the tolerance: largest error of an accepted passive fit


def fit(
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
        kept(
            "fits",
            (*settings, *dofs.tolist()),
            partial(fit_group, memory, dofs, band, tolerance),
            _to_arrays,
            _of_arrays,
        )
        for dofs in free_groups(memory, free, tolerance)
    )


def reduce(
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
        make = partial(reduced, model, memory, band, floating)
        return kept("reduced", settings, make, _to_arrays, _of_arrays)

    return tuple(smaller(model) if model.report.holds else model for model in models)


def free_groups(
    memory: Retardation, free: np.ndarray, tolerance: float = TOLERANCE
) -> list[np.ndarray]:
    """The groups of `coupled_groups`, restricted to the ``free`` DOFs (m,): the other DOFs do not
    move."""
    block = memory.kernel[:, free[:, None], free]
    return [free[group] for group in coupled_groups(block, tolerance)]


def check(models: Sequence[StateSpace], source: str) -> None:
    """Raises InputError if a group has no passive fit with an error below ten times the tolerance,
    and convolution is not allowed. The message names the database's ``source`` and all groups that
    fail."""
    failed = [model for model in models if not is_tolerable(model)]
    if not failed:
        return
    tolerance = failed[0].report.tolerance
    reached = max(model.report.frequency_error for model in models)
    found = "; ".join(f"{_names(model.dofs)}: {_nearest(model)}" for model in failed)
    raise InputError(
        f"{source}: fitted a state-space model to the radiation of {found}, and none that is"
        f" passive has an error below {TOLERABLE * tolerance:g}; expected damping that is smooth"
        " and positive, and a memory that has decayed at its end. Check the database with"
        " `hydrosim db check`. Then choose: one database for each body, with which `automatic` uses"
        " convolution; a longer memory, radiation: {length: ...}; or a larger error,"
        f" radiation: {{model: state_space, tolerance: {_rounded_up(reached):g}}}."
    )


def is_within_tolerance(model: StateSpace) -> bool:
    """True if a fit is passive and within its tolerance."""
    return model.report.holds


def is_tolerable(model: StateSpace) -> bool:
    """True if a fit is passive and within ten times its tolerance."""
    report = model.report
    return report.passive and report.error <= TOLERABLE * report.tolerance


def _names(dofs: np.ndarray) -> str:
    return ", ".join(
        DOFS[dof % 6] + (f" of body {dof // 6 + 1}" if dof > 5 else "") for dof in dofs
    )


def _nearest(model: StateSpace) -> str:
    report = model.report
    return (
        f"the nearest, with {model.order} states, has an error of {report.frequency_error:.1e}"
        f" (passivity {report.passivity_margin:.1e}, {report.passivity_before:.1e} before)"
    )


def _rounded_up(error: float) -> float:
    """The smallest tolerance with one digit that is not below this error."""
    size = 10.0 ** np.floor(np.log10(error))
    return float(np.ceil(error / size) * size)


def _of_arrays(arrays: Arrays) -> StateSpace:
    report = FitReport(*map(float, arrays["report"]))
    return StateSpace(**{name: arrays[name] for name in ARRAYS}, report=report)


def _to_arrays(model: StateSpace) -> Arrays:
    arrays = {name: getattr(model, name) for name in ARRAYS}
    return {**arrays, "report": np.array(astuple(model.report))}
