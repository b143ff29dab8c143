"""What a body's database means for the body: about its own centre of gravity, in time."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from hydrosim import database, radiation
from hydrosim.database import HydroDatabase
from hydrosim.errors import InputError
from hydrosim.radiation import Retardation, StateSpace
from hydrosim.scene import DOFS, Body, Environment, RadiationModel

MEMORY_LENGTH = 80.0  # s: of the retardation functions
MEMORY_STEP = 0.1  # s: of their tables


@dataclass(frozen=True)
class WetBody:
    """A body's database about its own centre of gravity, for all headings, with the ``checksum``
    of the one that was read; and its radiation in the time domain: retardation functions and, for
    a state-space model, their fits."""

    database: HydroDatabase
    checksum: str
    memory: Retardation
    fits: tuple[StateSpace, ...] = ()

    def provenance(self) -> dict[str, str]:
        """What the run's record says of it."""
        report, db = self.memory.report, self.database
        fits = [
            f"{group.B.shape[0]} states for {', '.join(DOFS[i] for i in group.dofs)},"
            f" error {group.report.frequency_error:.1e} in frequency,"
            f" {group.report.time_error:.1e} in time, passivity {group.report.passivity_margin:.1e}"
            for group in self.fits
        ]
        return {
            "database": db.source,
            "database_checksum": self.checksum,
            "radiation": "; ".join(fits) or "no state space",
            "retardation": f"|K(T)|/max|K| {report.end_ratio:.1e}, B(w_max)/max B"
            f" {report.band_ratio:.1e}, Ogilvie residual {report.ogilvie_residual:.1e}, smallest"
            f" eigenvalue of B {report.smallest_eigenvalue:.1e}",
        }


def wet_body(body: Body, water: Environment) -> WetBody | None:
    """The body's hydrodynamics about its centre of gravity; None for a dry body."""
    if body.hydrodynamics is None:
        return None
    db = body.hydrodynamics
    db = db if isinstance(db, HydroDatabase) else database.load(db)
    if db.bodies != 1:
        raise InputError(
            f"{db.source}: has {db.bodies} bodies, but bodies.{body.name} needs a database of one."
        )
    _check_environment(db, body, water)
    checksum = db.checksum
    db = database.all_headings(database.move_reference(db, body.centre_of_gravity))
    memory = radiation.retardation(
        *(db.frequency, db.added_mass, db.radiation_damping), length=MEMORY_LENGTH, step=MEMORY_STEP
    )
    if body.radiation != RadiationModel.STATE_SPACE:
        return WetBody(db, checksum, memory)
    return WetBody(db, checksum, memory, radiation.fit(db.checksum, memory, db.frequency))


def _check_environment(db: HydroDatabase, body: Body, water: Environment) -> None:
    for name in ("water_density", "gravity", "water_depth"):
        here, there = getattr(water, name), getattr(db, name)
        if here != there and not (here < inf and abs(here - there) <= 1e-3 * here):
            raise InputError(
                f"environment.{name}: found {here:g}, but {db.source} of bodies.{body.name} was"
                f" made for {there:g}. Use a database made for this water, or change the case."
            )


def critical_damping(body: Body, stiffness: np.ndarray, wet: WetBody | None) -> np.ndarray:
    """2 sqrt(k (m + a(w_n))) per DOF (6,), w_n the natural frequency with hydrostatics."""
    mass = np.array([body.mass] * 3 + list(np.diag(body.inertia)))
    if wet is None:
        return 2.0 * np.sqrt(np.maximum(stiffness, 0.0) * mass)
    db = wet.database
    total = np.maximum(stiffness + np.diag(database.needed(db, "hydrostatic_stiffness")), 0.0)
    heavy = mass + [
        _added_mass_in_resonance(db, i, m, k) for i, m, k in zip(range(6), mass, total, strict=True)
    ]
    return 2.0 * np.sqrt(np.maximum(stiffness, 0.0) * heavy)


def _added_mass_in_resonance(db: HydroDatabase, dof: int, mass: float, stiffness: float) -> float:
    """a(w_n) with w_n^2 = k / (m + a(w_n)), by fixed-point iteration."""
    added = db.added_mass[:, dof, dof]
    a = added[0]
    for _ in range(50):
        a = np.interp(np.sqrt(stiffness / (mass + a)), db.frequency, added)
    return float(a)
