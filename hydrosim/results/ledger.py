"""The energy ledger as a guard: how far a run does not add up, and whether that is too much.

    residual(t) = kinetic + stored - work + dissipated,   since the start

It is zero but for the error of the time integration. Over a stretch of time it is compared with the
energy that was exchanged there: what came into motion or went out of it, and what was lost,

    exchanged = largest kinetic + sum over output times of |change of kinetic| + |change of lost|

What a slow load lifts or a spring holds is large and says nothing; it does not count. A run is cut
into overlapping stretches, and the worst of them, or the run as a whole, is the relative residual:
one great impact hides nothing that comes before or after it. In a stretch quieter than usual the
scale is the geometric mean of its exchange and that of a usual one, because errors of motion go
with the root of their energy. Roundings of large energies are left out, as is what hardly moves.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.scene import Method

if TYPE_CHECKING:
    import xarray as xr

CLOSED = 1e-4  # of the exchanged energy: a residual beyond is warned of
STRETCHES = 16  # of a run, half overlapping
FEWEST = 8  # output times in a stretch
LEAST = 1e-6  # J/kg of all bodies that may move, as at 1.4 mm/s: less is hardly motion
ROUNDING = 1e-11  # of the largest energy: integrals of many steps
ADAPTIVE_REMEDY = "Try a smaller solver.tolerance"
REMEDY = "Try a smaller solver.step"


class Gap(NamedTuple):
    """The stretch of time [s] that adds up worst: ``energy`` [J] is missing or too much, a
    ``relative`` part of what was exchanged."""

    begin: float
    end: float
    energy: float
    relative: float


def gap(run: xr.Dataset, least: float = 0.0) -> Gap:
    """The worst gap in the ledger of a run; ``least`` [J] counts as exchanged in any stretch."""
    time, residual, kinetic = (
        run.variables[name].values for name in ("time", "energy_residual", "energy_kinetic")
    )
    if time.size < 2:
        return Gap(0.0, 0.0, 0.0, 0.0)
    exchanged = _exchanged(run)
    rounding = ROUNDING * max(float(np.abs(e).max()) for e in _energies(run).values())
    parts = list(_stretches(time.size))
    each = [exchanged[j] - exchanged[i] + kinetic[i : j + 1].max() for i, j in parts]
    usual = float(np.median(each))
    found = []
    for (i, j), own in zip(parts, each, strict=True):
        missing = max(float(np.ptp(residual[i : j + 1])) - rounding, 0.0)
        scale = max(np.sqrt(own * max(own, usual)), least)
        found.append(Gap(time[i], time[j], missing, float(missing / scale) if missing else 0.0))
    return max(found, key=lambda gap: gap.relative)


def guard(run: xr.Dataset, mass: float = 0.0) -> None:
    """Put the relative residual of a run of bodies of this ``mass`` [kg] among its attributes, and
    warnings if its ledger is open or its friction gives energy."""
    with np.errstate(over="ignore", invalid="ignore"):  # of a run that has failed
        worst = gap(run, LEAST * mass)
    run.attrs["energy_residual_relative"] = worst.relative
    warn(run, [*_open(run, worst), *_giving(run)])


def warn(run: xr.Dataset, more: Iterable[str]) -> None:
    """Put ``more`` warnings behind those that the run has."""
    said = [*str(run.attrs.get("warnings", "")).splitlines(), *more]
    if said:
        run.attrs["warnings"] = "\n".join(said)


def _open(run: xr.Dataset, worst: Gap) -> Iterator[str]:
    """A gap that is too wide, in words."""
    if worst.relative > CLOSED:
        yield (
            f"the energy ledger is open: from {worst.begin:g} to {worst.end:g} s {worst.energy:.2g}"
            f" J are not accounted for, {worst.relative:.1e} of the energy exchanged; expected at"
            f" most {CLOSED:g}. {_remedy(run)}: motions may be wrong by more than that part."
        )


def _giving(run: xr.Dataset) -> Iterator[str]:
    """Points whose friction has given energy: their loss falls by more than the ledger may be
    open."""
    if "fender" not in run.dims or run.time.size < 2:
        return
    exchanged = _exchanged(run)[-1]
    for name in run.fender.values:
        lost = run.fender_dissipated.sel(fender=name).values
        fall = np.maximum.accumulate(lost) - lost
        if fall.max() > CLOSED * exchanged / STRETCHES:
            at = float(run.time[int(fall.argmax())])
            yield (
                f"friction of {name} gives energy, {fall.max():.2g} J until {at:g} s, where it can"
                f" only take it. {_remedy(run)}."
            )


def _remedy(run: xr.Dataset) -> str:
    name = str(run.attrs.get("solver_method"))
    adapts = name in [*Method] and Method(name).adapts
    return ADAPTIVE_REMEDY if adapts else REMEDY


def _energies(run: xr.Dataset) -> dict[str, np.ndarray]:
    """All energies (nt,) of the ledger but its residual."""
    left_out = ("energy_residual", "energy_wave_absolute")
    return {
        str(name): run.variables[name].values
        for name in run.data_vars
        if str(name).startswith("energy_") and name not in left_out
    }


def _exchanged(run: xr.Dataset) -> np.ndarray:
    """Energy exchanged (nt,) since the start."""
    energies = _energies(run)
    lost = [e for name, e in energies.items() if name.startswith("energy_dissipated_")]
    changes = sum(np.abs(np.diff(e)) for e in (energies["energy_kinetic"], *lost))
    return np.concatenate([[0.0], np.cumsum(changes)])


def _stretches(count: int) -> Iterator[tuple[int, int]]:
    """First and last output time of all stretches, the whole run the first."""
    yield 0, count - 1
    length = max((count - 1) // STRETCHES, FEWEST)
    for first in range(0, count - 1 - length, max(length // 2, 1)):
        yield first, first + length
