"""What a body's database means for the body: about its own centre of gravity, in time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from hydrosim import database, radiation
from hydrosim.database import HydroDatabase
from hydrosim.errors import InputError
from hydrosim.radiation import Retardation, StateSpace
from hydrosim.scene import (
    BY_NAME,
    DOFS,
    Body,
    ConstantRadiation,
    ConvolutionRadiation,
    Environment,
    Radiation,
    RadiationModel,
    StateSpaceRadiation,
)

Memory = StateSpaceRadiation | ConvolutionRadiation


@dataclass(frozen=True)
class WetBody:
    """A body's database about its own centre of gravity, for all headings, with the ``checksum``
    of the one that was read; and its radiation in the time domain: the model, the retardation
    functions, their fits for a state-space model, and the constant part: ``added_mass`` and
    ``damping`` (6, 6), which are A_inf and zero but for constant radiation."""

    database: HydroDatabase
    checksum: str
    radiation: Radiation | None
    memory: Retardation
    added_mass: np.ndarray
    damping: np.ndarray
    fits: tuple[StateSpace, ...] = ()

    def provenance(self) -> dict[str, str]:
        """What the run's record says of it."""
        return {
            "database": self.database.source,
            "database_checksum": self.checksum,
            "radiation": self._described(),
            "retardation": str(self.memory.report),
        }

    def _described(self) -> str:
        match self.radiation:
            case ConvolutionRadiation(length, step):
                return f"convolution over {length:g} s, table every {step:g} s"
            case ConstantRadiation(period):
                return f"constant added mass and damping of {period:g} s"
            case StateSpaceRadiation():
                groups = ((", ".join(DOFS[i] for i in fit.dofs), fit) for fit in self.fits)
                texts = [f"{fit.order} states for {dofs}, {fit.report}" for dofs, fit in groups]
                return "state space: " + ("; ".join(texts) or "no radiation, no states")
        return "none"


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
    chosen = radiation_of(body)
    table = chosen if isinstance(chosen, Memory) else ConvolutionRadiation()
    memory = radiation.retardation(
        *(db.frequency, db.added_mass, db.radiation_damping), length=table.length, step=table.step
    )
    added_mass, damping = memory.added_mass_infinite, np.zeros((6, 6))
    if isinstance(chosen, ConstantRadiation):
        added_mass, damping = _at_period(db, body, chosen.period)
    wet = WetBody(db, checksum, chosen, memory, added_mass, damping)
    if not isinstance(chosen, StateSpaceRadiation):
        return wet
    fits = radiation.fit(db.checksum, db.source, memory, db.frequency, chosen.tolerance)
    return replace(wet, fits=fits)


def radiation_of(body: Body) -> Radiation | None:
    """The body's radiation model with its settings."""
    if isinstance(body.radiation, RadiationModel):
        return BY_NAME[body.radiation]
    return body.radiation


def _at_period(db: HydroDatabase, body: Body, period: float) -> tuple[np.ndarray, np.ndarray]:
    """A and B (6, 6), linear between the frequencies of the database, and reciprocal."""
    w, at = db.frequency, 2.0 * np.pi / period
    if not w[0] <= at <= w[-1]:
        raise InputError(
            f"bodies.{body.name}.radiation.period: found {period:g} s; expected one in the range of"
            f" {db.source}, {2.0 * np.pi / w[-1]:.3g} to {2.0 * np.pi / w[0]:.3g} s."
        )
    k = min(int(np.searchsorted(w, at, side="right")) - 1, w.size - 2)
    part = (at - w[k]) / (w[k + 1] - w[k])
    A, B = (
        (1.0 - part) * matrices[k] + part * matrices[k + 1]
        for matrices in (db.added_mass, db.radiation_damping)
    )
    return 0.5 * (A + A.T), 0.5 * (B + B.T)


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
