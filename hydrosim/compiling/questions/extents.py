"""Size of a hull, from its water plane and its volume.

The water plane has the area A and the second moments S_xx and S_yy. The rectangle of length L and
breadth B with the same values has L^2 = 12 S_xx / A and B^2 = 12 S_yy / A. This is exact for a box.
The rectangle is 13 % shorter than an ellipse, and some 10 % narrower than a ship. Hulls that float
on columns fill only a small part of their rectangle.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from hydrosim.database.database import HydroDatabase
    from hydrosim.scene import Body


ELLIPSE_OVER_RECTANGLE = 2.0 / np.sqrt(
    3.0
)  # axis of an ellipse over the side of the rectangle of its water plane
COMPACT = 0.8  # filled fraction of the rectangle, above which a hull counts as one closed body


class Extents(NamedTuple):
    """Rectangle of a hull's water plane in the body frame: its ``centre`` (3,), its ``half`` length
    and breadth (2,), and the fraction of it that is ``filled``. ``draught`` is the draught of
    upright sides below the water plane. All lengths in m."""

    centre: np.ndarray
    half: np.ndarray
    filled: float
    draught: float


def extents(body: Body, db: HydroDatabase) -> Extents | None:
    """Extents of a hull; None if its database does not have the data."""
    if db.hydrostatic_stiffness is None or db.volume is None or db.centre_of_buoyancy is None:
        return None
    C = db.hydrostatic_stiffness / (db.water_density * db.gravity)
    area, volume = float(C[2, 2]), float(db.volume[0])
    if area <= 0.0 or volume <= 0.0:
        return None
    height = body.centre_of_gravity[2]
    lever = volume * (db.centre_of_buoyancy[0, 2] - height)
    middle = np.array([-C[2, 4], C[2, 3]]) / area
    second = np.array([C[4, 4], C[3, 3]]) - lever - area * middle**2
    if np.any(second <= 0.0):
        return None
    half = np.sqrt(3.0 * second / area)
    centre = np.array([*middle, -height])
    return Extents(centre, half, float(area / (4.0 * np.prod(half))), volume / area)
