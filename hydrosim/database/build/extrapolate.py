"""Added mass and damping extrapolated to infinitely small panels, from two sets of panels.

At the right angles of a barge's bilge, the velocity of the water grows without bound, as the power
-1/3 of the distance. Panels shrink towards the edge as the square of their number. Then the error
of added mass and damping decreases as the power -4/3 of that number. On the barge of H-851, roll
damping at 0.7 rad/s is 3.875, 3.976 and 4.013e9 N m s with 0.6, 1 and 1.4 times the panels. Any two
of these values extrapolate to 4.079e9.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hydrosim.database import HydroDatabase
from hydrosim.database.build.barge import Resolution
from hydrosim.database.build.drift import Real
from hydrosim.waves.dispersion import wavenumber

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
