"""Planes that contacts and clearances refer to: unbounded, or polygons."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Self

import numpy as np
import pydantic

from hydrosim.dofs import foot_of_perpendicular, mirrored_vector
from hydrosim.files import quantities as of
from hydrosim.files.schema_class import SchemaClass, schema_class
from hydrosim.files.units import problem


@schema_class
class Plane(SchemaClass):
    """The other side of a contact, in the earth frame or in that of a body."""

    point: of.Point
    """A point of the plane, in the earth frame or the frame of its body."""
    normal: of.Direction
    """Direction away from the plane, to the free side. Example: [0, -1, 0]."""
    body: pydantic.StrictStr | None = None
    """Body that the plane is fixed to. Without it the plane is fixed to the earth. Example:
    topside."""
    corners: tuple[of.Point, ...] = ()
    """Corners of a polygon in the plane, outside of which there is no contact."""

    @pydantic.model_validator(mode="after")
    def _check_normal(self) -> Self:
        if not any(self.normal):
            raise problem("the normal [0, 0, 0]", "a direction", "point it to the free side")
        return self

    @pydantic.model_validator(mode="after")
    def _check_corners(self) -> Self:
        if len({*self.corners}) < len(self.corners):
            raise problem("a corner twice", "each once", "a polygon is closed by itself")
        if len(self.corners) > 2 and not _goes_round_once(np.array(self.corners), self.normal):
            expected = "each beside the one before it, once round the polygon"
            raise problem("corners whose sides cross each other", expected, "put them in order")
        return self

    def canonical_form(self, y: float) -> Plane:
        """The same plane given by the foot of the perpendicular from the origin, relative to the
        plane at ``y`` [m]; its corners are in a canonical order."""
        y = 0.0 if self.body else y
        corners = np.subtract(self.corners, (0.0, y, 0.0)) if self.corners else np.zeros((0, 3))
        point = foot_of_perpendicular(self.point, self.normal, y)
        return replace(self, point=point, corners=_sorted_corners(corners, self.normal))

    def mirror_image(self) -> Plane:
        """The mirror image in the plane y = 0."""
        normal = mirrored_vector(self.normal)
        corners = np.array([mirrored_vector(corner) for corner in self.corners]).reshape(-1, 3)
        return replace(
            self,
            point=mirrored_vector(self.point),
            normal=normal,
            corners=_sorted_corners(corners, normal),
        )


def _goes_round_once(corners: np.ndarray, normal: Sequence[float]) -> bool:
    """Whether corners (n, 3) are in the order of their angles about their middle, either way."""
    across = np.delete(corners - corners.mean(axis=0), np.argmax(np.abs(normal)), axis=1)
    angle = np.arctan2(across[:, 1], across[:, 0])
    turns = np.mod(np.diff(angle, append=angle[:1]), 2.0 * np.pi).sum() / (2.0 * np.pi)
    return round(turns) in (1, len(corners) - 1)


def _sorted_corners(corners: np.ndarray, normal: Sequence[float]) -> tuple[of.Point, ...]:
    """Corners of a convex polygon, once round it, in an order that does not depend on the first
    corner nor on the sense."""
    if not len(corners):
        return ()
    across = np.delete(corners - corners.mean(axis=0), np.argmax(np.abs(normal)), axis=1)
    corners = corners[np.argsort(np.arctan2(across[:, 1], across[:, 0]))]
    fine = np.round(corners / max(np.abs(corners).max(), 1.0), 6)
    rank = np.argsort(np.lexsort(fine.T))
    first = int(rank.argmin())
    step = 1 if rank[(first + 1) % len(rank)] < rank[first - 1] else -1
    order = [(first + step * k) % len(rank) for k in range(len(rank))]
    return tuple((x, y, z) for x, y, z in corners[order].tolist())
