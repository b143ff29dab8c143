"""Sizes of a body, by which figures are scaled; from the added mass if there is no volume."""

from __future__ import annotations

import numpy as np

from hydrosim.database.database import HydroDatabase, Real
from hydrosim.waves.dispersion import wavenumber

# a DOF with less than this fraction of its body's scale counts as having no added mass or damping
MASS_NOISE_FRACTION = 1e-4
LONG_WAVE = 0.3  # k V^(1/3) below which the limits of long waves must hold
GYRATION = 2.5  # half a length over its radius of gyration: 1.7 for a box, 2.2 for an ellipsoid
LENGTH_POWERS = np.array([0, 0, 0, 1, 1, 1])  # power of a length in the loads of the six DOFs


def displaced_mass(db: HydroDatabase) -> Real:
    """Displaced mass (nb,); without volumes, the largest added mass of a translation, which has the
    same order."""
    if db.volume is not None:
        return db.water_density * db.volume
    added = np.abs(diagonal(db.added_mass)).reshape(-1, db.bodies, 6)
    return np.maximum(added[..., :3].max(axis=(0, 2)), np.finfo(float).tiny)


def length(db: HydroDatabase) -> Real:
    """(nb,): V^(1/3)."""
    return np.cbrt(displaced_mass(db) / db.water_density)


def radius(db: HydroDatabase) -> Real:
    """Estimate (nb,) of half the longest side or more, from the distribution of added mass over the
    body and from its waterplane. Shallow water adds more mass in heave than in pitch."""
    added = np.abs(diagonal(db.added_mass)[0]).reshape(db.bodies, 6)
    heave = np.maximum(added[:, 2], MASS_NOISE_FRACTION * displaced_mass(db))
    of_mass = GYRATION * np.sqrt(added[:, 3:].max(axis=1) / heave)
    return np.maximum.reduce([of_mass, length(db), _waterplane_radius(db)])


def _waterplane_radius(db: HydroDatabase) -> Real:
    """Half the diagonal (nb,) of a rectangle with the moments of the waterplane; zero without."""
    if db.hydrostatic_stiffness is None:
        return np.zeros(db.bodies)
    stiffness = np.diag(db.hydrostatic_stiffness).reshape(db.bodies, 6)
    moments = np.maximum(stiffness[:, 3:5], 0.0).sum(axis=1)
    heave = stiffness[:, 2]
    return np.sqrt(3.0 * np.divide(moments, heave, out=np.zeros(db.bodies), where=heave > 0.0))


def first_wavenumber(db: HydroDatabase) -> float:
    """Wavenumber at the lowest frequency."""
    return float(wavenumber(db.frequency[0], db.water_depth, db.gravity))


def is_compact(db: HydroDatabase) -> bool:
    """Whether the longest wave is long compared with every body."""
    return bool(first_wavenumber(db) * length(db).max() < LONG_WAVE)


def added_mass_scale(db: HydroDatabase) -> Real:
    """Square root of the largest diagonal (n,), or of the noise if that is larger."""
    largest = np.abs(diagonal(db.added_mass)).max(axis=0)
    return np.sqrt(np.maximum(largest, MASS_NOISE_FRACTION * _inertia(db)))


def damping_scale(db: HydroDatabase) -> Real:
    """The same as `added_mass_scale`, for the radiation damping."""
    largest = np.abs(diagonal(db.radiation_damping)).max(axis=0)
    return np.sqrt(np.maximum(largest, damping_floor(db)))


def damping_floor(db: HydroDatabase) -> Real:
    """Noise (n,) on the diagonal of the damping."""
    rate = np.sqrt(db.gravity / np.repeat(length(db), 6))
    return MASS_NOISE_FRACTION * _inertia(db) * rate


def load_floor(db: HydroDatabase) -> Real:
    """Noise (n,) in the loads per wave amplitude."""
    side = length(db)[:, None]
    return (
        MASS_NOISE_FRACTION * db.water_density * db.gravity * side ** (2 + LENGTH_POWERS)
    ).ravel()


def diagonal(matrices: Real) -> Real:
    """Diagonals (..., n) of (..., n, n)."""
    return np.diagonal(matrices, axis1=-2, axis2=-1)


def _inertia(db: HydroDatabase) -> Real:
    """Displaced mass (n,), times V^(2/3) for rotations."""
    return (displaced_mass(db)[:, None] * length(db)[:, None] ** (2 * LENGTH_POWERS)).ravel()
