"""From a solver's results to a `HydroDatabase`: symmetries, drift, far field, extrapolation.

Loads and damping from the waves that motions radiate into the far field.

By Haskind's relation the wave loads X follow from the Kochin functions H of the motions, and the
damping B from the loads (Newman 1977, Marine Hydrodynamics, 6.18). In deep water

    X_i(b) = -4 pi i rho g / w H_i(b + pi),   B_ij = w^3 / (4 pi rho g^3) Re int X_i X_j* db.

These loads differ from loads by pressures on the hull by the error of the panels. In resonances of
the water between bodies, pressures can make the damping negative. There, the mean of both is closer
to the result of finer panels than either. In long waves, H of surge, sway and roll is a small
difference of large numbers.

Added mass and damping extrapolated to infinitely small panels, from two sets of panels.

At the right angles of a barge's bilge, the velocity of the water grows without bound, as the power
-1/3 of the distance. Panels shrink towards the edge as the square of their number. Then the error
of added mass and damping decreases as the power -4/3 of that number. On the barge of H-851, roll
damping at 0.7 rad/s is 3.875, 3.976 and 4.013e9 N m s with 0.6, 1 and 1.4 times the panels. Any two
of these values extrapolate to 4.079e9.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from hydrosim.database import HydroDatabase
from hydrosim.database.build.barge import Resolution
from hydrosim.database.build.bem import Solution
from hydrosim.database.build.drift import (
    DIRECTION_STEP,
    DIRECTIONS,
    Complex,
    Drifting,
    MeanDrift,
    Real,
    Water,
    mean_drift,
)
from hydrosim.database.build.recipe import FarField
from hydrosim.water.spectra import wavenumber

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
    force = {
        kind: rules.loads([d.force for d in kind_drifts]) for kind, kind_drifts in drifts.items()
    }
    imbalance = [[d.imbalance for d in kind_drifts] for _, kind_drifts in sorted(drifts.items())]
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
        array = np.array(loads)
        along = np.isclose(np.sin(self.headings), 0.0, atol=1e-9) & self.symmetric
        return np.where(along[:, None] & np.resize(LATERAL, array.shape[-1]), 0.0, array)


def by_far_field(
    solutions: Sequence[Solution], headings: Real, wanted: FarField, water: Water
) -> list[Solution]:
    """``solutions`` with loads that come partly from Haskind's relation, and with the damping of
    these loads. The damping is symmetric and has no negative eigenvalues, as energy conservation
    requires. The ``headings`` are evenly spaced around the circle; the water is deep."""
    return [_blend_far_field(solution, headings, wanted, water) for solution in solutions]


def _blend_far_field(
    solution: Solution, headings: Real, wanted: FarField, water: Water
) -> Solution:
    w = solution.frequency
    share = np.interp(w, wanted.rising, [0.0, wanted.share])
    far = haskind(solution.kochin_radiation, w, headings, water)
    loads = (1 - share) * solution.excitation + share * far
    flux = np.real(loads.T @ loads.conj()) * (2 * np.pi / headings.size)
    factor = w**3 / (4 * np.pi * water.density * water.gravity**3)
    return solution._replace(excitation=loads, damping=factor * flux)


def haskind(kochin: Complex, frequency: float, headings: Real, water: Water) -> Complex:
    """Loads (headings, n) for exp(+i w t) from Kochin functions (n, directions) in Capytaine's
    normalisation and time factor. Headings are multiples of half a degree."""
    behind = np.rint((headings + np.pi) / DIRECTION_STEP).astype(int) % DIRECTIONS.size
    factor = -4j * np.pi * water.density * water.gravity / frequency
    return np.conj(factor * kochin[:, behind].T)


CONVERGENCE_ORDER = 4 / 3


class CoarseRadiation(NamedTuple):
    """Added mass and damping (frequencies, n, n), and, if known, added mass (n, n) at zero
    frequency."""

    added_mass: Real
    damping: Real
    zero: Real | None


def coarsen(counts: Resolution, share: float) -> Resolution:
    """Panels with a ``share`` of their number around every section, on both rakes and on end walls.
    Along the hull and on the lid their number is unchanged, because short waves determine their
    size there."""

    def reduce_count(count: int) -> int:
        return max(1, round(share * count))

    first, *middle, last = counts.along
    return replace(
        counts,
        along=(reduce_count(first), *middle, reduce_count(last)),
        across=reduce_count(counts.across),
        down=reduce_count(counts.down),
        wall_across=reduce_count(counts.wall_across),
        wall_down=reduce_count(counts.wall_down),
    )


def extrapolate_radiation(
    db: HydroDatabase, coarse: CoarseRadiation, share: float, draught: float
) -> HydroDatabase:
    """``db`` with added mass and damping extrapolated to zero panel size, from its own and from
    those of a ``share`` of the panels (Richardson 1911).

    Waves shorter than the ``draught`` [m] do not reach the bilge, and the error of panels has
    another cause there. So the change decays as exp(-(k T / 4)^2), and small damping stays
    positive.
    """
    factor = 1 / (share**-CONVERGENCE_ORDER - 1)
    k = wavenumber(db.frequency, db.water_depth, db.gravity)
    reached = np.exp(-((k * draught / 4) ** 2))[:, None, None]

    def to_zero_panel_size(fine: Real, other: Real) -> Real:
        return fine + factor * (fine - other)

    def to_zero_below_bilge(fine: Real, other: Real) -> Real:
        return fine + factor * reached * (fine - other)

    zero = db.added_mass_zero
    if zero is not None and coarse.zero is not None:
        zero = to_zero_panel_size(zero, coarse.zero)
    return replace(
        db,
        added_mass=to_zero_below_bilge(db.added_mass, coarse.added_mass),
        radiation_damping=to_zero_below_bilge(db.radiation_damping, coarse.damping),
        added_mass_zero=zero,
    )
