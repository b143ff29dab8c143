"""Hydrodynamics given as numbers: a database that is constant and has no wave loads."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.database.database import HydroDatabase
from hydrosim.errors import InputError
from hydrosim.radiation.retardation import KernelReport, Retardation

if TYPE_CHECKING:
    from hydrosim.scene import Body, Coefficients, Environment

SOURCE = "coefficients of the case"
CONSTANT = inf  # s: placeholder period, because coefficients are the same at all periods
_FREQUENCIES = np.array([1e-3, 1e3])  # rad/s, a range that holds all motions


def database_of(given: Coefficients, body: Body, water: Environment) -> HydroDatabase:
    """Database of a body about its centre of gravity. Raises InputError if a matrix is not that of
    a passive body."""
    for name in ("added_mass", "damping", "stiffness"):
        _check(f"bodies.{body.name}.hydrodynamics.{name}", np.asarray(getattr(given, name)))
    centre = np.array([body.centre_of_gravity])
    return HydroDatabase(
        source=SOURCE,
        frequency=_FREQUENCIES,
        heading=np.zeros(0),
        added_mass=np.array([given.added_mass] * 2),
        radiation_damping=np.array([given.damping] * 2),
        excitation=np.zeros((2, 0, 6), dtype=complex),
        reference_point=centre,
        centre_of_gravity=centre,
        volume=np.array([body.mass / water.water_density]),
        hydrostatic_stiffness=np.array(given.stiffness),
        water_depth=water.water_depth,
        water_density=water.water_density,
        gravity=water.gravity,
        port_starboard_symmetric=bool(_is_symmetric(given)),
    )


def no_memory(db: HydroDatabase) -> Retardation:
    """Retardation of constant coefficients: A_inf alone."""
    K = np.zeros((2, *db.added_mass.shape[1:]))
    report = KernelReport(0.0, 0.0, 0.0, 0.0, K[0])
    return Retardation(np.array([0.0, 1.0]), K, db.added_mass[0], report)


def _check(key: str, matrix: np.ndarray) -> None:
    """Check a matrix: a scene written in Python may have any."""
    if matrix.shape != (6, 6) or not np.isfinite(matrix).all():
        raise InputError(
            f"{key}: found an array of shape {matrix.shape}; expected numbers of shape (6, 6)."
        )
    size = np.sqrt(np.where(np.diag(matrix) > 0.0, np.diag(matrix), 1.0))
    scaled = matrix / np.outer(size, size)
    odd = np.abs(scaled - scaled.T)
    if odd.max() > 1e-6:
        i, j = np.unravel_index(int(odd.argmax()), odd.shape)
        raise InputError(
            f"{key}: found {matrix[i, j]:g} in row {i + 1}, column {j + 1} but {matrix[j, i]:g} in"
            f" row {j + 1}, column {i + 1}; expected a symmetric matrix."
        )
    if np.linalg.eigvalsh(scaled)[0] < -1e-9:
        raise InputError(
            f"{key}: found a matrix with a negative eigenvalue, which adds energy in some"
            " motion; expected eigenvalues of zero or more. Check signs and couplings."
        )


def _is_symmetric(given: Coefficients) -> bool:
    """Whether no entry couples surge, heave and pitch with sway, roll and yaw."""
    even = np.arange(6) % 2 == 0
    matrices = (given.added_mass, given.damping, given.stiffness)
    return not any(np.asarray(matrix)[np.ix_(even, ~even)].any() for matrix in matrices)
