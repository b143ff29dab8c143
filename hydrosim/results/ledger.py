"""Errors of a run in its dataset: the residual of its energy balance, and its measured error.

    residual(t) = kinetic + stored - work + dissipated,   since the start

The residual is zero except for the error of the time integration. In each interval of time, it is
compared with the energy that was exchanged there, which is kinetic energy gained or lost, and
dissipated energy:

    exchanged = largest kinetic + sum over output times of |change of kinetic| + |change of lost|

Energy that a slow load lifts or a spring holds does not count, because it is large without motion.
A run is cut into overlapping intervals. The relative residual is that of the worst interval, or of
the whole run, so a great impact hides no error before or after it. In quiet intervals, the scale is
the geometric mean of the exchange there and in a median interval, because errors of motion grow
with the root of their energy. Rounding of large energies is left out, and so is very small motion.

Figures of the error of a run in its dataset.

    position_error         largest error of each motion over the run (body, dof) [m, rad]
    error_relative         the largest of them, relative to the range of that motion
    error_contact_force    error of the largest normal force of a contact, relative to it
    error_parted           time [s] at which the run and its companion part for good
    error_companion        what the run was compared with
    error_evaluations      evaluations of the equation of motion that this took

The first is a variable, the others are attributes. All are absent where motion is propagated
exactly, and where a run did not measure its error. See `hydrosim.run.error_estimate`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import isfinite
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.results.variables import describe
from hydrosim.scene import Method

if TYPE_CHECKING:
    import xarray as xr

MAX_RESIDUAL_FRACTION = 1e-4  # of the exchanged energy: larger residuals cause a warning
DELAYED = 1e-2  # of the exchanged energy: delays of external forces that give more cause a warning
STRETCHES = 16  # of a run; intervals overlap by half
MIN_INTERVAL_TIMES = 8  # output times in an interval
MIN_SPECIFIC_ENERGY = (
    1e-6  # J/kg of all bodies that can move, as at 1.4 mm/s: less counts as no motion
)
ENERGY_RTOL = 1e-11  # of the largest energy, by integrals of many steps
ADAPTIVE_REMEDY = "Try a smaller solver.tolerance"
SMALLER_STEP_HINT = "Try a smaller solver.step"


class EnergyGap(NamedTuple):
    """The interval [s] with the largest relative residual: ``energy`` [J] is missing or in excess,
    ``relative`` is its ratio to the exchanged energy."""

    begin: float
    end: float
    energy: float
    relative: float


def worst_energy_gap(run: xr.Dataset, least: float = 0.0) -> EnergyGap:
    """Worst gap in the energy balance of a run; ``least`` [J] is the smallest exchange of an
    interval."""
    time, residual, kinetic = (
        run.variables[name].values for name in ("time", "energy_residual", "energy_kinetic")
    )
    if time.size < 2:
        return EnergyGap(0.0, 0.0, 0.0, 0.0)
    exchanged = _exchanged_energy(run)
    rounding = ENERGY_RTOL * max(float(np.abs(e).max()) for e in _balance_energies(run).values())
    parts = list(_stretch_ranges(time.size))
    exchanges = [exchanged[j] - exchanged[i] + kinetic[i : j + 1].max() for i, j in parts]
    usual = float(np.median(exchanges))
    gaps = []
    for (i, j), exchange in zip(parts, exchanges, strict=True):
        missing = max(float(np.ptp(residual[i : j + 1])) - rounding, 0.0)
        scale = max(np.sqrt(exchange * max(exchange, usual)), least)
        gaps.append(
            EnergyGap(time[i], time[j], missing, float(missing / scale) if missing else 0.0)
        )
    return max(gaps, key=lambda gap: gap.relative)


def check_balance(run: xr.Dataset, mass: float = 0.0) -> None:
    """Store the relative residual of a run of bodies of this ``mass`` [kg] in its attributes. Add
    warnings if the energy balance is open, if friction adds energy, or if the delay of an external
    force gives or takes much."""
    with np.errstate(over="ignore", invalid="ignore"):  # of a failed run
        worst = worst_energy_gap(run, MIN_SPECIFIC_ENERGY * mass)
    run.attrs["energy_residual_relative"] = worst.relative
    append_warnings(
        run, [*_gap_warning(run, worst), *_energy_adding_points(run), *_delay_warnings(run)]
    )


def append_warnings(run: xr.Dataset, more: Iterable[str]) -> None:
    """Append ``more`` warnings to those of the run."""
    warnings = [*str(run.attrs.get("warnings", "")).splitlines(), *more]
    if warnings:
        run.attrs["warnings"] = "\n".join(warnings)


def _gap_warning(run: xr.Dataset, worst: EnergyGap) -> Iterator[str]:
    """Warning about a gap that is too large."""
    if worst.relative > MAX_RESIDUAL_FRACTION:
        yield (
            f"the energy balance is open: from {worst.begin:g} to {worst.end:g} s"
            f" {worst.energy:.2g} J are not accounted for, {worst.relative:.1e} of the energy"
            f" exchanged; expected at most {MAX_RESIDUAL_FRACTION:g}. Motions may be wrong by more"
            f" than this fraction. {_remedy_text(run)}."
        )


def _energy_adding_points(run: xr.Dataset) -> Iterator[str]:
    """Warnings about points whose friction adds energy: their loss falls by more than the tolerance
    of the balance."""
    if "fender" not in run.dims or run.time.size < 2:
        return
    exchanged = _exchanged_energy(run)[-1]
    for name in run.fender.values:
        lost = run.fender_dissipated.sel(fender=name).values
        fall = np.maximum.accumulate(lost) - lost
        if fall.max() > MAX_RESIDUAL_FRACTION * exchanged / STRETCHES:
            at = float(run.time[int(fall.argmax())])
            yield (
                f"friction of {name} adds energy, {fall.max():.2g} J until {at:g} s; expected"
                f" only losses. {_remedy_text(run)}."
            )


def _delay_warnings(run: xr.Dataset) -> Iterator[str]:
    """Warnings about external forces whose delay gives or takes a part of the energy exchanged."""
    if "external" not in run.dims or run.time.size < 2:
        return
    exchanged = _exchanged_energy(run)[-1]
    for name in map(str, run.external.values):
        energy = run.external_delay_energy.sel(external=name).values
        most = float(energy[np.abs(energy).argmax()])
        if abs(most) > DELAYED * exchanged:
            coupling = ", coupling extrapolated instead of held" if _is_held(run, name) else ""
            verb = "gives" if most > 0.0 else "takes"
            yield (
                f"the delay of {name} {verb} {abs(most):.2g} J, {abs(most) / exchanged:.1g} of the"
                f" energy exchanged; expected at most {DELAYED:g}. {_remedy_text(run)}{coupling},"
                " or coupling stage if the function does not remember."
            )


def _is_held(run: xr.Dataset, name: str) -> bool:
    """Whether an external force is kept over each step."""
    lines = str(run.attrs.get("external_forces", "")).splitlines()
    return any(line.startswith(f"{name}: ") and ", held (" in line for line in lines)


def _remedy_text(run: xr.Dataset) -> str:
    name = str(run.attrs.get("solver_method"))
    adapts = name in [*Method] and Method(name).adapts
    return ADAPTIVE_REMEDY if adapts else SMALLER_STEP_HINT


def _balance_energies(run: xr.Dataset) -> dict[str, np.ndarray]:
    """All energies (nt,) of the balance except its residual."""
    left_out = ("energy_residual", "energy_wave_absolute")
    return {
        str(name): run.variables[name].values
        for name in run.data_vars
        if str(name).startswith("energy_") and name not in left_out
    }


def _exchanged_energy(run: xr.Dataset) -> np.ndarray:
    """Energy exchanged (nt,) since the start."""
    energies = _balance_energies(run)
    lost = [e for name, e in energies.items() if name.startswith("energy_dissipated_")]
    changes = sum(np.abs(np.diff(e)) for e in (energies["energy_kinetic"], *lost))
    return np.concatenate([[0.0], np.cumsum(changes)])


def _stretch_ranges(count: int) -> Iterator[tuple[int, int]]:
    """Indices of the first and last output time of all intervals; the whole run is the first
    interval."""
    yield 0, count - 1
    length = max((count - 1) // STRETCHES, MIN_INTERVAL_TIMES)
    for first in range(0, count - 1 - length, max(length // 2, 1)):
        yield first, first + length


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
