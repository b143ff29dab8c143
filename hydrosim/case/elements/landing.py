"""`landing` in a case file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import AfterValidator, StrictStr, model_validator

from hydrosim.case.elements.element import BuildContext, Element
from hydrosim.case.elements.fender import Normal, check_lengths
from hydrosim.case.elements.friction import Friction, Frictionless
from hydrosim.documents import quantities as of
from hydrosim.documents.messages import Keys
from hydrosim.documents.quantities import SchemaModel
from hydrosim.documents.units import problem

if TYPE_CHECKING:
    from hydrosim import forces


class Seats(SchemaModel):
    """Where points come down, in the earth frame or that of a body; they carry along ``axis``, as
    far as ``extent`` from their middle."""

    points: Annotated[tuple[of.Point, ...], AfterValidator(of.require_entries)]
    """Seats, one for each point, in the earth frame or the frame of their body."""
    axis: of.Direction = (0.0, 0.0, 1.0)
    """Direction in which seats carry, from seat to point. Example: [0, 0, 1]."""
    body: StrictStr | None = None
    """Body that the seats are fixed to. Without it they are fixed to the earth. Example:
    barge."""
    extent: of.LineLength | None = None
    """Distance from the middle of a seat beyond which it does not carry."""

    @model_validator(mode="after")
    def _check_axis(self) -> Self:
        if not any(self.axis):
            raise problem("the axis [0, 0, 0]", "a direction", "point it from seat to point")
        return self


class Wall(SchemaModel):
    """The wall around each seat: a cylinder, or a cone of an ``angle`` to its axis."""

    gap: of.LineLength
    """Play between point and wall."""
    stiffness: of.Stiffness | None = None
    """Force per compression of the wall."""
    compression: of.Compressions | None = None
    """Compressions from 0 that rise, for a curve."""
    force: of.NormalForces | None = None
    """Force at each compression."""
    angle: of.Angle = 0.0
    """Angle of a conical wall to the axis. Zero is a cylinder."""
    depth: of.LineLength | None = None
    """Height of the wall above the seat."""

    @model_validator(mode="after")
    def _check_wall(self) -> Self:
        given = self.keys_with_value("stiffness", "compression", "force")
        if given not in (["stiffness"], ["compression", "force"]):
            raise problem(" and ".join(given) or "no curve", "stiffness, or compression and force")
        if not 0.0 <= self.angle < 0.5 * np.pi:
            found_text = f"an angle of {np.degrees(self.angle):g} deg"
            raise problem(found_text, "0 (a cylinder) to less than 90 deg")
        check_lengths(self.compression, self.force)
        return self

    def build(self) -> forces.Wall:
        """The same of the scene."""
        from hydrosim.forces.contact.guide import Wall as Built  # loads numba

        compression = np.array([0.0, 1.0])
        force = np.array([0.0, self.stiffness or 0.0])
        if self.compression is not None and self.force is not None:
            compression = np.array(self.compression)
            force = np.array(self.force)
        wall = Built(self.gap, compression, force, float(np.tan(self.angle)))
        return wall if self.depth is None else replace(wall, depth=self.depth)


class Landing(Element):
    """Points of a body, each on a seat of its own."""

    example: ClassVar[dict[str, Any]] = {
        "type": "landing",
        "body": "barge",
        "points": [["1 m", "0.5 m", "-1 m"], ["-0.8 m", "-0.6 m", "-1.1 m"]],
        "on": {"body": "topside", "points": [["1 m", "0.5 m", "0.9 m"], ["-0.8 m", "-0.6 m", 1]]},
        "normal": {
            "compression": [0, "10 cm", "20 cm"],
            "force": [0, "20 kN", "60 kN"],
            "unloading": {
                "compression": [0, "10 cm", "20 cm"],
                "force": [0, "5 kN", "60 kN"],
                "stiffness": "2000 kN/m",
            },
        },
        "wall": {"gap": "5 cm", "stiffness": "50 kN/m", "angle": "20 deg", "depth": "15 cm"},
        "group": "legs",
    }

    type: Literal["landing"]
    """Points of a body, each on a seat of its own."""
    points: Annotated[tuple[of.Point, ...], AfterValidator(of.require_entries)]
    """Points in the body frame."""
    on: Seats
    """Seats that the points come down on."""
    normal: Normal
    """Normal force of the contact."""
    friction: Friction = Frictionless(law="none")
    """Friction law of the contact."""
    wall: Wall | None = None
    """Wall around each seat, which guides the point."""
    group: of.Name | None = None
    """Name of a group of contacts. Statistics of contacts are made for each group. Example:
    legs."""
    capacity: of.ReferenceForce | None = None
    """Allowable force, which statistics compare with."""

    @model_validator(mode="after")
    def _check_seats(self) -> Self:
        if len(self.points) != len(self.on.points):
            found_text = f"{len(self.points)} points and {len(self.on.points)} seats in on.points"
            raise problem(found_text, "a seat for each point")
        if self.normal.prescribed or self.normal.damping:
            found_text = "normal.prescribed" if self.normal.prescribed else "normal.damping"
            expected = "stiffness, or compression and force, with unloading where energy is lost"
            remedy = "only the normal of a fender may have prescribed or damping"
            raise problem(found_text, expected, remedy)
        return self

    def body_references(self) -> Iterator[tuple[Keys, str | None, str]]:
        yield ("on", "body"), self.on.body, "seats without body are fixed to the earth"

    def build(self, where: BuildContext) -> forces.Landing:
        from hydrosim.forces.contact.landing import Landing as Built  # loads numba

        count = len(self.points)
        return Built(
            self.body,
            points=np.array(self.points),
            seats=np.array(self.on.points),
            normal=self.normal.build(count, where),
            friction=self.friction.build(count),
            axis=self.on.axis,
            on=self.on.body,
            wall=self.wall.build() if self.wall else None,
            extent=self.on.extent,
            group=self.group,
            capacity=self.capacity,
        )
