"""Figures of the error of a run in its dataset.

    position_error         largest error of each motion over the run (body, dof) [m, rad]
    error_relative         the largest of them, relative to the range of that motion
    error_contact_force    error of the largest normal force of a contact, relative to it
    error_parted           time [s] at which the run and its companion part for good
    error_companion        what the run was compared with
    error_evaluations      evaluations of the equation of motion that this took

The first is a variable, the others are attributes. All are absent where motion is propagated
exactly, and where a run did not measure its error. See `hydrosim.studies.run.error_estimate`.
"""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, NamedTuple

from hydrosim.results.ledger import append_warnings
from hydrosim.results.variables import describe

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

REPORTED = 5e-4
"""Error relative to the range of a motion above which a run gets a warning: half of the error that
matters, because it is an estimate. With a chosen accuracy, errors above that are reported."""
ACCURACY = "solver_accuracy"
"""Attribute: error of motions for which the method was chosen."""
RELATIVE = "error_relative"
CONTACT_FORCE = "error_contact_force"
PARTED = "error_parted"
COMPANION = "error_companion"
EVALUATIONS = "error_evaluations"


class ErrorEstimate(NamedTuple):
    """Largest errors of a run: ``motion`` (nb, 6) [m, rad]; ``relative`` to the range of a motion;
    ``contact_force`` relative to the largest normal force, NaN without contact. ``parted`` is the
    time [s] at which run and companion part for good, NaN if they do not. ``companion`` says what
    the run was compared with, and ``evaluations`` what that took."""

    motion: np.ndarray
    relative: float
    contact_force: float
    parted: float
    companion: str
    evaluations: int
    warnings: tuple[str, ...]


def reported_beyond(run: xr.Dataset) -> float:
    """Error of motions, relative to their range, above which a run or a set of runs has a
    warning."""
    return float(run.attrs.get(ACCURACY, REPORTED))


def add_error_estimate(run: xr.Dataset, estimate: ErrorEstimate) -> None:
    """Add the figures and warnings of an ``estimate`` to the dataset of its run."""
    run["position_error"] = (("body", "dof"), estimate.motion)
    describe(run[["position_error"]])
    figures = {
        RELATIVE: estimate.relative,
        CONTACT_FORCE: estimate.contact_force,
        PARTED: estimate.parted,
    }
    run.attrs.update({name: float(x) for name, x in figures.items() if isfinite(x)})
    run.attrs[COMPANION] = estimate.companion
    run.attrs[EVALUATIONS] = estimate.evaluations
    append_warnings(run, estimate.warnings)
