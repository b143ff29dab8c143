"""Checks of stiffness, volume and mass against each other."""

from __future__ import annotations

import numpy as np

from hydrosim.database.checks.finding import (
    Check,
    CheckSubject,
    RelativeErrors,
    diagonal,
    displaced_mass,
)
from hydrosim.database.database import HydroDatabase, Real, require_array


def _of_dofs(db: HydroDatabase, values: Real, *dofs: int) -> RelativeErrors:
    """``values`` (nb, len(dofs)) or (nb, 1) for those degrees of freedom of each body."""
    relative = np.full((db.bodies, 6), np.nan)
    relative[:, list(dofs)] = values
    return RelativeErrors(relative.ravel(), ("dof",))


def _heave(db: HydroDatabase) -> RelativeErrors:
    heave_stiffness = diagonal(require_array(db, "hydrostatic_stiffness"))[2::6]
    return _of_dofs(db, ((1 - np.sign(heave_stiffness)) / 2)[:, None], 2)


def _asymmetry(db: HydroDatabase) -> RelativeErrors:
    stiffness = require_array(db, "hydrostatic_stiffness")
    scale = np.sqrt(np.maximum(np.abs(np.diag(stiffness)), 1e-300))
    dofs = np.arange(len(stiffness))
    stiff = (dofs % 6 > 1) & (dofs % 6 < 5)
    judged = np.outer(stiff, stiff) & (dofs[:, None] // 6 == dofs // 6)
    gap = np.where(judged, stiffness - stiffness.T, np.nan)
    return RelativeErrors(np.abs(gap) / np.outer(scale, scale), ("dof", "motion"), gap, ("N", "/m"))


def _metacentre(db: HydroDatabase) -> RelativeErrors:
    """1 for each negative metacentric height."""
    stiffness = diagonal(require_array(db, "hydrostatic_stiffness")).reshape(-1, 6)
    return _of_dofs(db, np.where(stiffness[:, 3:5] < 0, 1.0, 0.0), 3, 4)


def _waterplane(db: HydroDatabase) -> RelativeErrors:
    """Heave, roll and pitch stiffness minus the levers of buoyancy and weight are rho g times the
    integrals of (1, x, y)(1, x, y) over the waterplane. The error is their distance from positive
    semi-definite, and below the polar moment A^2/2pi of a disc, the smallest possible."""
    rho_g = db.water_density * db.gravity
    lever = (require_array(db, "centre_of_buoyancy") - require_array(db, "centre_of_gravity"))[:, 2]
    stiffness = _blocks(require_array(db, "hydrostatic_stiffness"))[:, 2:5, 2:5].copy()
    for block, less in zip(stiffness, rho_g * require_array(db, "volume") * lever, strict=True):
        block[[1, 2], [1, 2]] -= less
    impossible = [[_impossible_moments(block / rho_g)] for block in stiffness]
    return _of_dofs(db, np.array(impossible), 3, 4)


def _impossible_moments(moments: Real) -> float:
    """Errors of the moments (3, 3) of a plane area."""
    area = moments[0, 0]
    if area <= 0.0:
        return 0.0
    least = area**2 / (2 * np.pi)
    polar = moments[1, 1] + moments[2, 2] - (moments[0, 1] ** 2 + moments[0, 2] ** 2) / area
    size = np.sqrt(np.maximum(np.abs(np.diag(moments)), 1e-9 * least))
    scaled = moments / np.outer(size, size)
    return max(0.0, 1 - polar / least, -np.linalg.eigvalsh((scaled + scaled.T) / 2)[0])


def _weight(db: HydroDatabase) -> RelativeErrors:
    mass = diagonal(require_array(db, "inertia_matrix"))[0::6]
    return RelativeErrors(np.abs(mass / displaced_mass(db) - 1), ("body",))


def _blocks(matrix: Real) -> Real:
    """Blocks (nb, 6, 6): each body's own part of (n, n)."""
    bodies = len(matrix) // 6
    return np.array([matrix[6 * b :, 6 * b :][:6, :6] for b in range(bodies)])


HYDROSTATICS = (
    Check(
        "heave stiffness",
        _heave,
        0.0,
        "1 if a body has a negative heave stiffness, 1/2 if it has none; acceptable for a"
        " submerged body, else the stiffness is missing or its sign is wrong",
        refusal=0.5,
        needs=("hydrostatic_stiffness",),
        of=frozenset({CheckSubject.STIFFNESS}),
    ),
    Check(
        "symmetry of the stiffness",
        _asymmetry,
        0.02,
        "largest |C_ij - C_ji| / sqrt(C_ii C_jj) in heave, roll and pitch, zero in theory; look"
        " for a wrong sign or an exchanged entry",
        needs=("hydrostatic_stiffness",),
        of=frozenset({CheckSubject.STIFFNESS}),
    ),
    Check(
        "metacentric heights",
        _metacentre,
        0.0,
        "1 if a roll or pitch stiffness is negative; the body capsizes, or its centre of gravity"
        " or the sign is wrong",
        needs=("hydrostatic_stiffness",),
        of=frozenset({CheckSubject.STIFFNESS}),
    ),
    Check(
        "moments of the waterplane",
        _waterplane,
        0.05,
        "distance of stiffness, volume and centres from those of any possible waterplane; look"
        " for wrong units, a stiffness without gravity, or centres in another frame",
        refusal=0.5,
        needs=("hydrostatic_stiffness", "volume", "centre_of_buoyancy", "centre_of_gravity"),
        of=frozenset({CheckSubject.STIFFNESS}),
    ),
    Check(
        "weight",
        _weight,
        0.01,
        "relative difference of mass and displaced mass; acceptable if moorings carry the"
        " difference, else volume, density or mass is wrong",
        refusal=0.9,
        needs=("inertia_matrix", "volume"),
        of=frozenset({CheckSubject.SPARE}),
    ),
)
