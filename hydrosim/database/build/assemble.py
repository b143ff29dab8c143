"""From a solver's results to a `HydroDatabase`: exact symmetries, drift of the floating body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hydrosim.database import HydroDatabase
from hydrosim.database.build.bem import Solution, Water
from hydrosim.database.build.drift import Complex, Drift, Real, mean_drift

LATERAL = np.array([False, True, False, True, False, True])


@dataclass(frozen=True)
class Floating:
    """A floating body in the database's frame: ``centre_of_gravity`` and ``centre_of_buoyancy``
    (3,) [m], ``volume`` [m^3], ``inertia`` and ``stiffness`` (6, 6) about the centre of gravity."""

    centre_of_gravity: Real
    centre_of_buoyancy: Real
    volume: float
    inertia: Real
    stiffness: Real


def assemble(
    body: Floating,
    water: Water,
    headings: Real,
    solutions: Sequence[Solution],
    limits: tuple[Real, Real],
    attributes: Mapping[str, str],
) -> HydroDatabase:
    """Database of one body with port-starboard symmetry in deep water.

    ``limits`` are the added masses at zero and infinite frequency. Added mass and damping are made
    symmetric and everything that port-starboard symmetry forbids is set to zero; the solver gives
    both but for its error. The drift is that of the body floating free, without viscous damping.
    """
    added_mass = _symmetric(np.array([s.added_mass for s in solutions]))
    damping = _symmetric(np.array([s.damping for s in solutions]))
    allowed = _allowed(headings)
    excitation = np.where(allowed, [s.excitation for s in solutions], 0.0)
    drift = [
        _free_drift(body, water, headings, s, A, B, X)
        for s, A, B, X in zip(solutions, added_mass, damping, excitation, strict=True)
    ]
    zero, infinite = (_symmetric(limit) for limit in limits)
    return HydroDatabase(
        source="computed",
        frequency=np.array([s.frequency for s in solutions]),
        heading=headings,
        added_mass=added_mass,
        radiation_damping=damping,
        added_mass_zero=zero,
        added_mass_infinite=infinite,
        excitation=excitation,
        froude_krylov=np.where(allowed, [s.froude_krylov for s in solutions], 0.0),
        mean_drift=np.where(allowed, [d.force for d in drift], 0.0),
        drift_imbalance=np.array([d.imbalance for d in drift]),
        hydrostatic_stiffness=body.stiffness,
        inertia_matrix=body.inertia,
        volume=np.array([body.volume]),
        centre_of_buoyancy=body.centre_of_buoyancy[None],
        centre_of_gravity=body.centre_of_gravity[None],
        reference_point=body.centre_of_gravity[None],
        water_depth=np.inf,
        water_density=water.density,
        gravity=water.gravity,
        port_starboard_symmetric=True,
        attributes=attributes,
    )


def asymmetry(matrices: Real) -> Real:
    """(6, 6): largest |M_ij - M_ji| over the frequencies, relative to the largest M_ii and M_jj."""
    skew = np.abs(matrices - np.swapaxes(matrices, -1, -2)).max(axis=0)
    scale = np.sqrt(np.abs(np.diagonal(matrices, axis1=-2, axis2=-1)).max(axis=0))
    return skew / np.outer(scale, scale)


def _free_drift(
    body: Floating, water: Water, headings: Real, s: Solution, A: Real, B: Real, X: Complex
) -> Drift:
    w = s.frequency
    impedance = body.stiffness - w**2 * (body.inertia + A) + 1j * w * B
    motion = np.linalg.solve(impedance, X.T).T
    # The Kochin functions have Capytaine's time factor, so they need the conjugate motion.
    kochin = s.kochin_diffraction + np.conj(motion) @ s.kochin_radiation
    return mean_drift(kochin, w, headings, water.density, water.gravity)


def _symmetric(matrices: Real) -> Real:
    coupled = LATERAL[:, None] == LATERAL
    return np.where(coupled, (matrices + np.swapaxes(matrices, -1, -2)) / 2, 0.0)


def _allowed(headings: Real) -> np.ndarray:
    """(headings, 6): false for sway, roll and yaw in waves along the hull."""
    along = np.isclose(np.sin(headings), 0.0, atol=1e-9)
    return ~(along[:, None] & LATERAL)
