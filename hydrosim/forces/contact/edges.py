"""Edges of a plane: of a convex polygon in it, or of the circle of a seat.

An edge is a row (a, b, c). (u1, u2) is the foot of a point in the plane, along its tangents. Its
distance from the edge is a u1 + b u2 + c, positive inside. A point beyond the edge is open. A point
that has passed behind the plane there, or left over the edge while pressed, touches again only
after it has returned to the free side.
"""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.errors import InputError
from hydrosim.forces.contact.geometry import tangents
from hydrosim.jit.kernels import kernel
from hydrosim.rigid.vectors import length

if TYPE_CHECKING:
    from hydrosim.forces.contact.plane import Plane

PLANE_RTOL = 1e-6  # of the polygon's size: tolerance of its corners from the plane
CONVEX_RTOL = 1e-9  # of the polygon's size: a corner this far inside is on the edge


def plane_edges(plane: Plane) -> np.ndarray:
    """The edges (n, 3) of a plane; empty if it has none.

    Raises InputError if its corners do not form a convex polygon in the plane.
    """
    if not plane.corners:
        return np.zeros((0, 3))
    normal = np.array(plane.normal, float) / np.linalg.norm(plane.normal)
    apart = np.subtract(plane.corners, plane.point)
    size, u = np.ptp(apart, axis=0).max(), apart @ np.array(tangents(normal)).T
    if np.abs(apart @ normal).max() > PLANE_RTOL * size:
        off = np.abs(apart @ normal).max()
        text = f"found a corner {off:.3g} m off the plane; expected all corners in it"
        raise InputError(f"plane.corners: {text}.")
    about = u - u.mean(axis=0)
    u = u[np.argsort(np.arctan2(about[:, 1], about[:, 0]))]
    along = np.roll(u, -1, axis=0) - u
    inward = np.stack([-along[:, 1], along[:, 0]], 1) / np.linalg.norm(along, axis=1)[:, None]
    sides = np.column_stack([inward, -np.sum(inward * u, axis=1)])
    inside = u @ inward.T + sides[:, 2]
    corner = np.eye(len(u), dtype=bool) | np.roll(np.eye(len(u), dtype=bool), 1, axis=0)
    if len(u) < 3 or not np.all(inside[~corner] > CONVEX_RTOL * size):
        raise InputError(
            "plane.corners: found no convex polygon; expected three corners or more that turn"
            " one way. Use several fenders for any other shape."
        )
    return sides


@kernel
def ends_somewhere(point):
    """True if a point's plane has edges."""
    return point.edges > 0 or point.extent < inf


@kernel
def distance_inside(point, contact, ends):
    """Distance of a point's foot from the nearest edge of its plane, negative beyond."""
    nearest = point.extent - length(contact.offset)
    for k in range(point.edge, point.edge + point.edges):
        u = contact.offset
        nearest = min(nearest, ends[k, 0] * u[0] + ends[k, 1] * u[1] + ends[k, 2])
    return nearest
