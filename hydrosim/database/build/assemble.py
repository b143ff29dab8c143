"""From a solver's results to a `HydroDatabase`: exact symmetries, mean drift of the floating
body."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hydrosim.database import HydroDatabase
from hydrosim.database.build.bem import Solution
from hydrosim.database.build.drift import Complex, Drifting, MeanDrift, Real, mean_drift
from hydrosim.database.build.water import Water

LATERAL = np.array([False, True, False, True, False, True])


@dataclass(frozen=True)
class Floating:
    """Floating bodies in the database's frame: ``centre_of_gravity`` and ``centre_of_buoyancy``
    (bodies, 3) [m], ``volume`` (bodies,) [m^3], ``inertia`` and ``stiffness`` (n, n) about the
    centres of gravity, n = 6 x number of bodies."""

    centre_of_gravity: Real
    centre_of_buoyancy: Real
    volume: Real
    inertia: Real
    stiffness: Real


def assemble(
    body: Floating,
    water: Water,
    headings: Real,
    solutions: Sequence[Solution],
    limits: tuple[Real | None, Real],
    attributes: Mapping[str, str],
    *,
    symmetric: bool = True,
    drift: Collection[Drifting] = tuple(Drifting),
) -> HydroDatabase:
    """Database of one or several bodies from their ``solutions``.

    ``limits`` are the added masses at zero frequency, if known, and at infinite frequency. Added
    mass and damping are made symmetric. For a ``symmetric`` hull, all entries that port-starboard
    symmetry forbids are set to zero. The solver satisfies both except for its error. The mean drift
    is that of the free body, without viscous damping, and of the held body, with its yaw moment
    about the centre of gravity. If requested, its energy imbalance is that of the free body.
    """
    rules = Rules(symmetric, headings)
    added_mass = rules.matrices(np.array([s.added_mass for s in solutions]))
    damping = rules.matrices(np.array([s.damping for s in solutions]))
    excitation = rules.loads([s.excitation for s in solutions])
    moved = zip(solutions, added_mass, damping, excitation, strict=True)
    waves = {
        Drifting.FREE: [floating_waves(body, s, A, B, X) for s, A, B, X in moved],
        Drifting.HELD: [s.kochin_diffraction for s in solutions],
    }
    x, y, _ = body.centre_of_gravity[0].tolist()
    drifts = {kind: _drifts(waves[kind], solutions, headings, water, (x, y)) for kind in drift}
    force = {kind: rules.loads([d.force for d in found]) for kind, found in drifts.items()}
    imbalance = [[d.imbalance for d in found] for _, found in sorted(drifts.items())]
    zero, infinite = limits
    return HydroDatabase(
        source="computed",
        frequency=np.array([s.frequency for s in solutions]),
        heading=headings,
        added_mass=added_mass,
        radiation_damping=damping,
        added_mass_zero=None if zero is None else rules.matrices(zero),
        added_mass_infinite=rules.matrices(infinite),
        excitation=excitation,
        froude_krylov=rules.loads([s.froude_krylov for s in solutions]),
        mean_drift=force.get(Drifting.FREE),
        mean_drift_held=force.get(Drifting.HELD),
        drift_imbalance=np.array(imbalance[0]) if imbalance else None,
        hydrostatic_stiffness=body.stiffness,
        inertia_matrix=body.inertia,
        volume=body.volume,
        centre_of_buoyancy=body.centre_of_buoyancy,
        centre_of_gravity=body.centre_of_gravity,
        reference_point=body.centre_of_gravity,
        water_depth=water.depth,
        water_density=water.density,
        gravity=water.gravity,
        port_starboard_symmetric=symmetric,
        attributes=attributes,
    )


def asymmetry(matrices: Real) -> Real:
    """Matrix (n, n): largest |M_ij - M_ji| over the frequencies, relative to the largest M_ii and
    M_jj."""
    skew = np.abs(matrices - np.swapaxes(matrices, -1, -2)).max(axis=0)
    scale = np.sqrt(np.abs(np.diagonal(matrices, axis1=-2, axis2=-1)).max(axis=0))
    return skew / np.outer(scale, scale)


def _drifts(
    waves: Sequence[Complex],
    solutions: Sequence[Solution],
    headings: Real,
    water: Water,
    about: tuple[float, float],
) -> list[MeanDrift]:
    pairs = zip(waves, solutions, strict=True)
    return [mean_drift(kochin, s.frequency, headings, water, about) for kochin, s in pairs]


def floating_waves(body: Floating, s: Solution, A: Real, B: Real, X: Complex) -> Complex:
    """Kochin functions (headings, directions) of the free body in waves."""
    w = s.frequency
    impedance = body.stiffness - w**2 * (body.inertia + A) + 1j * w * B
    motion = np.linalg.solve(impedance, X.T).T
    # The Kochin functions have Capytaine's time factor, so they need the conjugate motion.
    return s.kochin_diffraction + np.conj(motion) @ s.kochin_radiation


@dataclass(frozen=True)
class Rules:
    """Largest errors of reciprocity and of port-starboard symmetry."""

    symmetric: bool
    headings: Real

    def matrices(self, matrices: Real) -> Real:
        """Symmetric part (..., n, n), without coupling across the plane of symmetry."""
        lateral = np.resize(LATERAL, matrices.shape[-1])
        coupled = (lateral[:, None] == lateral) | (not self.symmetric)
        return np.where(coupled, (matrices + np.swapaxes(matrices, -1, -2)) / 2, 0.0)

    def loads(self, loads: Sequence[np.ndarray]) -> np.ndarray:
        """Loads (frequencies, headings, n) without sway, roll and yaw in waves along the hull."""
        found = np.array(loads)
        along = np.isclose(np.sin(self.headings), 0.0, atol=1e-9) & self.symmetric
        return np.where(along[:, None] & np.resize(LATERAL, found.shape[-1]), 0.0, found)
