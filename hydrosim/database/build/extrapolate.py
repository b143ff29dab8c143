"""Added mass and damping of ever smaller panels, from two sets of them.

The water turns round the right angles of a barge's bilge, and its velocity grows without bound
there, as the power -1/3 of the distance. With panels that shrink towards the edge as the square of
their number, what they miss of added mass and damping falls as the power -4/3 of that number: on
the barge of H-851, roll damping at 0.7 rad/s is 3.875, 3.976 and 4.013e9 N m s with 0.6, 1 and 1.4
times the panels, and any two of these tell of 4.079e9 without any.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hydrosim.database import HydroDatabase
from hydrosim.database.build.barge import Resolution
from hydrosim.database.build.drift import Real

ORDER = 4 / 3
ROUGH = 1e-3  # of the largest: eigenvalues below are noise of the panels


class Radiation(NamedTuple):
    """Added mass and damping (frequencies, n, n), and added mass (n, n) at infinite and, if known,
    at zero frequency."""

    added_mass: Real
    damping: Real
    infinite: Real
    zero: Real | None


def coarser(counts: Resolution, share: float) -> Resolution:
    """The panels with a ``share`` of their number round every section, on both rakes and end walls.
    Along the hull and on the lid, where they are as small as waves are short, they stay."""

    def fewer(count: int) -> int:
        return max(1, round(share * count))

    first, *middle, last = counts.along
    return replace(
        counts,
        along=(fewer(first), *middle, fewer(last)),
        across=fewer(counts.across),
        down=fewer(counts.down),
        wall_across=fewer(counts.wall_across),
        wall_down=fewer(counts.wall_down),
    )


def extrapolated(db: HydroDatabase, coarse: Radiation, share: float) -> HydroDatabase:
    """``db`` with added mass and damping as of no panels' size, from its own and from those of a
    ``share`` of the panels (Richardson 1911)."""
    factor = 1 / (share**-ORDER - 1)

    def beyond(fine: Real, other: Real) -> Real:
        return fine + factor * (fine - other)

    fine, zero = db.radiation_damping, db.added_mass_zero
    if zero is not None and coarse.zero is not None:
        zero = beyond(zero, coarse.zero)
    return replace(
        db,
        added_mass=beyond(db.added_mass, coarse.added_mass),
        radiation_damping=fine + _kept_positive(fine, beyond(fine, coarse.damping) - fine),
        added_mass_infinite=beyond(np.asarray(db.added_mass_infinite), coarse.infinite),
        added_mass_zero=zero,
    )


def _kept_positive(fine: Real, change: Real) -> Real:
    """As much of the ``change`` of damping (frequencies, n, n) as leaves half of the smallest
    eigenvalue, which falls at most evenly along it; where that is not all, panels are too large for
    the waves to tell of smaller ones."""
    scale = np.sqrt(np.abs(np.diagonal(fine, axis1=1, axis2=2)))
    scale = np.where(scale > 0.0, scale, 1.0)
    unit = 1 / (scale[:, :, None] * scale[:, None, :])
    before, after = (np.linalg.eigvalsh(each * unit)[:, 0] for each in (fine, fine + change))
    fall = np.maximum(before - after, np.finfo(float).tiny)
    return change * np.clip((before / 2 + ROUGH) / fall, 0.0, 1.0)[:, None, None]
