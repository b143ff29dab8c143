"""State-space models of a database, kept on disk so that each is fitted once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, fields

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.radiation.kept import Arrays, kept
from hydrosim.radiation.passivity import ROUNDING
from hydrosim.radiation.retardation import Retardation
from hydrosim.radiation.state_space import (
    TOLERANCE,
    FitReport,
    StateSpace,
    coupled_groups,
    fit_group,
)

ARRAYS = tuple(field.name for field in fields(StateSpace) if field.name != "report")


REFUSED = 10.0  # times the tolerance: a larger error of a passive fit is refused


def fit(
    checksum: str,
    source: str,
    memory: Retardation,
    frequency: np.ndarray,
    tolerance: float = TOLERANCE,
    free: np.ndarray | None = None,
) -> tuple[StateSpace, ...]:
    """State-space models of all coupled groups of DOFs of a database, see `fit_group`; only of
    those with some of the ``free`` DOFs (m,), if they are given.

    Raises InputError, which names the database's ``source`` and all groups, where no passive fit
    has an error below ten times the tolerance.

    They are kept in the cache folder by the database's ``checksum``, the table of K, the band of
    ``frequency`` [rad/s], the tolerance and the groups, see `kept`.
    """
    band = float(frequency[-1])
    groups = [
        dofs
        for dofs in coupled_groups(memory.kernel, tolerance)
        if free is None or np.isin(dofs, free).any()
    ]

    def made() -> tuple[StateSpace, ...]:
        return tuple(fit_group(memory, dofs, band, tolerance) for dofs in groups)

    which = ";".join(",".join(map(str, dofs)) for dofs in groups)
    settings = (checksum, memory.time.size, float(memory.time[-1]), band, tolerance, which)
    models = kept("fits", settings, made, _to_arrays, _of_arrays)
    _check(models, source)
    return models


def _check(models: Sequence[StateSpace], source: str) -> None:
    """Raises InputError where a model is not passive, or too far off."""
    refused = [
        model
        for model in models
        if not model.report.passivity_margin >= -ROUNDING
        or model.report.frequency_error > REFUSED * model.report.tolerance
    ]
    if refused:
        worst = max(model.report.frequency_error for model in refused)
        raise InputError(
            f"{source}: found no state-space model of the radiation {_listed(refused)} that is"
            f" passive within {REFUSED:g} times the tolerance {refused[0].report.tolerance:g};"
            " expected damping that is nowhere negative and smooth. Run `hydrosim db check`; set"
            f" radiation: {{model: state_space, tolerance: {_rounded_up(worst):g}}} or radiation:"
            " convolution."
        )


def _listed(models: Sequence[StateSpace]) -> str:
    """The groups, and how far off the nearest passive fits are."""
    return "; ".join(
        "in "
        + ", ".join(
            DOFS[dof % 6] + (f" of body {dof // 6 + 1}" if dof > 5 else "") for dof in model.dofs
        )
        + f" (the nearest, of {model.order} states, is {model.report.frequency_error:.1e} off;"
        f" passivity {model.report.passivity_margin:.1e}, {model.report.passivity_before:.1e}"
        " before)"
        for model in models
    )


def _rounded_up(error: float) -> float:
    """A tolerance of one digit that this error is within."""
    size = 10.0 ** np.floor(np.log10(error))
    return float(np.ceil(error / size) * size)


def _of_arrays(arrays: Arrays) -> tuple[StateSpace, ...]:
    return tuple(
        StateSpace(
            **{name: arrays[f"{name}_{k}"] for name in ARRAYS},
            report=FitReport(*map(float, arrays[f"report_{k}"])),
        )
        for k in range(int(arrays["groups"]))
    )


def _to_arrays(models: Sequence[StateSpace]) -> Arrays:
    arrays = {"groups": np.array(len(models))}
    for k, model in enumerate(models):
        arrays |= {f"{name}_{k}": getattr(model, name) for name in ARRAYS}
        arrays[f"report_{k}"] = np.array(astuple(model.report))
    return arrays
