"""`Plane`: the surface that contact points are pressed against."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hydrosim.forces.mirroring import foot_of_perpendicular, mirrored_vector


@dataclass(frozen=True)
class Plane:
    """``point`` and ``normal`` (towards the free side), in the earth frame or that of ``body``. The
    plane may end at the convex polygon of its ``corners`` (n, 3), or at an ``extent`` [m] from its
    point."""

    point: tuple[float, ...]
    normal: tuple[float, ...]
    body: str | None = None
    corners: tuple[tuple[float, ...], ...] = ()
    extent: float | None = None

    def by_its_foot(self, y: float) -> Plane:
        """The same plane given by the foot of the perpendicular from the origin, relative to the
        plane at ``y`` [m]; its corners are in a canonical order."""
        y = 0.0 if self.body else y
        corners = np.subtract(self.corners, (0.0, y, 0.0)) if self.corners else np.zeros((0, 3))
        return replace(
            self,
            point=foot_of_perpendicular(self.point, self.normal, y),
            corners=_sorted_corners(corners),
        )

    def mirror_image(self) -> Plane:
        """The mirror image in the plane y = 0."""
        corners = _sorted_corners(
            np.array([mirrored_vector(corner) for corner in self.corners]).reshape(-1, 3)
        )
        point = mirrored_vector(self.point)
        normal = mirrored_vector(self.normal)
        return replace(self, point=point, normal=normal, corners=corners)


def _sorted_corners(corners: np.ndarray) -> tuple[tuple[float, ...], ...]:
    """Corners of a convex polygon in an order that does not depend on the first corner."""
    fine = np.round(corners / max(np.abs(corners).max(initial=0.0), 1.0), 6)
    return tuple(map(tuple, corners[np.lexsort(fine.T)].tolist()))
