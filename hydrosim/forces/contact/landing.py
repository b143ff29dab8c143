"""Landing: points of a body that come down on seats, on the earth or on another body.

A landing is a contact point whose plane passes through its seat, normal to the ``axis`` along which
the seat carries. It only pushes. It may carry along a loop (`loop`), be guided sideways (`guide`),
and has the friction of any contact. Legs of a topside on its substructure, leg mating units and
deck support units are landings.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from hydrosim.dofs import MIRROR_SIGN
from hydrosim.forces.contact.fender import Contact, Normal
from hydrosim.forces.contact.guide import Wall
from hydrosim.forces.contact.laws import Law
from hydrosim.forces.contact.plane import Plane
from hydrosim.forces.mirroring import mirrored_vector
from hydrosim.scene import ForceElement

SEAT = 2.0  # m: default radius of a seat, or its width beside the mouth of its wall


@dataclass(frozen=True)
class Landing(Contact):
    """``points`` (n, 3) in the body frame, each on its own of the ``seats`` (n, 3), which carry
    along ``axis`` (towards the point). Seats and axis are in the earth frame or in the frame of
    ``on``, a body. A ``wall`` around each seat holds its point sideways. A seat carries up to an
    ``extent`` [m] from its centre; None means 2 m, or 2 m beside the mouth of its wall."""

    remembers: ClassVar[bool] = True
    points: np.ndarray
    seats: np.ndarray
    normal: Normal
    friction: Law
    axis: tuple[float, ...] = (0.0, 0.0, 1.0)
    on: str | None = None
    wall: Wall | None = None
    extent: float | None = None
    group: str | None = field(default=None, kw_only=True)

    def planes(self) -> Sequence[Plane]:
        each = map(tuple, self.seats)
        return [Plane(seat, self.axis, self.on, extent=self.reach()) for seat in each]

    def reach(self) -> float:
        """Largest distance from its centre at which a seat carries [m]."""
        if self.extent is not None:
            return self.extent
        mouth = self.wall.gap + self.wall.slope * self.wall.depth if self.wall else 0.0
        return SEAT + mouth

    def connected_bodies(self) -> Iterator[tuple[str, str | None]]:
        yield "on.body", self.on

    def mirrored_parts(self, y: float) -> Sequence[ForceElement]:
        """A landing for each point."""
        seats = self.seats - np.array([0.0, 0.0 if self.on else y, 0.0])
        pairs = zip(self.points, seats, strict=True)
        return [replace(self, points=point[None], seats=seat[None]) for point, seat in pairs]

    def mirror_image(self) -> ForceElement:
        points = self.points * MIRROR_SIGN[:3]
        seats = self.seats * MIRROR_SIGN[:3]
        return replace(self, points=points, seats=seats, axis=mirrored_vector(self.axis))
