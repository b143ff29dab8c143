"""How large a hull is, as its water plane and its volume tell.

A rectangle of length L and breadth B with the area A and the second moments of the water plane has
L^2 = 12 S_xx / A and B^2 = 12 S_yy / A. That is exact for a box. The rectangle of an ellipse is
13 % shorter, that of a ship some 10 % narrower than it is. Hulls that float on columns fill little
of their rectangle.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from hydrosim.database.database import HydroDatabase
    from hydrosim.scene import Body


class Extents(NamedTuple):
    """The rectangle of a hull's water plane in the body frame: its ``centre`` (3,), its ``half``
    length and breadth (2,), the part of it that is ``filled``; and the ``draught`` of upright sides
    below the water plane. All in m."""

    centre: np.ndarray
    half: np.ndarray
    filled: float
    draught: float


def extents(body: Body, db: HydroDatabase) -> Extents | None:
    """The extents of a hull; None where its database does not tell."""
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
