"""Contacts of a case file: `fender` with its friction laws, and `landing`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import (
    AfterValidator,
    ConfigDict,
    Discriminator,
    StrictBool,
    StrictStr,
    model_validator,
)

from hydrosim.case.elements.element import BuildContext, Element, Exemplary
from hydrosim.case.signals import NormalOverTime, Recorded, signal_of
from hydrosim.files import quantities as of
from hydrosim.files.messages import Keys
from hydrosim.files.quantities import SchemaModel
from hydrosim.files.units import problem

if TYPE_CHECKING:
    from hydrosim import elements


def _check_coefficients(static: float, kinetic: float) -> None:
    if static < kinetic:
        raise problem(f"static {static:g}, kinetic {kinetic:g}", "static >= kinetic")


class LoadPowers(SchemaModel):
    """Powers of the normal force over a ``reference`` that the coefficients go with; a ``total``
    reference is shared by the points, as the coefficients are."""

    reference: of.ReferenceForce
    """Normal force at which the coefficients are as given."""
    stiffness: of.Power
    """Power of the normal force that the stiffness goes with."""
    damping: of.Power = 0.0
    """Power of the normal force that the damping goes with."""
    slip_damping: of.Power = 0.0
    """Power of the normal force that the slip damping goes with."""

    @model_validator(mode="after")
    def _check_powers(self) -> Self:
        if max(self.damping, self.slip_damping) > self.stiffness:
            found_text = f"damping {self.damping:g}, slip_damping {self.slip_damping:g}"
            expected = f"no more than that of the stiffness, {self.stiffness:g}"
            raise problem(
                found_text, expected, "else the node stiffens without bound as the load goes"
            )
        return self


class StickSlip(Exemplary):
    """The thesis' new friction model; ``total`` values are shared by the points."""

    example: ClassVar[dict[str, Any]] = {
        "law": "stick_slip",
        "static": 0.4,
        "kinetic": 0.3,
        "stiffness": "200 kN/m",
        "damping": "10 kN*s/m",
    }

    law: Literal["stick_slip"]
    """Stick-slip friction with an elastic contact node."""
    static: of.Factor
    """Friction coefficient at which sticking ends."""
    kinetic: of.Factor
    """Friction coefficient while slipping."""
    stiffness: of.Stiffness
    """Tangential stiffness K2 of the contact."""
    damping: of.Damping = 0.0
    """Tangential damping C2 of the contact."""
    slip_damping: of.Damping = 0.0
    """Damping C3 of the slip velocity."""
    load: LoadPowers | None = None
    """Powers of the normal force that stiffness and damping go with."""
    total: StrictBool = False
    """Whether values are of all points together and are shared equally."""

    @model_validator(mode="after")
    def _check_law(self) -> Self:
        _check_coefficients(self.static, self.kinetic)
        if self.load and not self.damping + self.slip_damping:
            found_text = "load without damping and slip_damping"
            raise problem(found_text, "one of the latter above 0, or no load")
        return self

    def build(self, count: int) -> elements.StickSlip:
        """The law of each of ``count`` points."""
        from hydrosim.elements.contact.stick_slip import LoadPowers as Powers
        from hydrosim.elements.contact.stick_slip import StickSlip as Built

        share, load = 1.0 / count if self.total else 1.0, None
        if self.load is not None:
            powers = (self.load.stiffness, self.load.damping, self.load.slip_damping)
            load = Powers(share * self.load.reference, *powers)
        stiffness, damping = share * self.stiffness, share * self.damping
        slip_damping = share * self.slip_damping
        return Built(self.static, self.kinetic, stiffness, damping, slip_damping, load)


class Coulomb(Exemplary):
    """Rigid friction: what sticks does not move."""

    example: ClassVar[dict[str, Any]] = {"law": "coulomb", "static": 0.4, "kinetic": 0.3}

    law: Literal["coulomb"]
    """Rigid friction: a contact that sticks does not move."""
    static: of.Factor
    """Friction coefficient at which sticking ends."""
    kinetic: of.Factor
    """Friction coefficient while slipping."""

    @model_validator(mode="after")
    def _check_law(self) -> Self:
        _check_coefficients(self.static, self.kinetic)
        return self

    def build(self, count: int) -> elements.Coulomb:
        """The law of each of ``count`` points."""
        from hydrosim.elements.contact.coulomb import Coulomb as Built

        return Built(self.static, self.kinetic)


class FrictionSlope(Exemplary):
    """aNySIM's friction model; a ``total`` slope is shared by the points."""

    example: ClassVar[dict[str, Any]] = {
        "law": "friction_slope",
        "coefficient": 0.3,
        "slope": "40 kN*s/m",
    }

    law: Literal["friction_slope"]
    """Friction that rises with velocity up to the full value, as in aNySIM."""
    coefficient: of.Factor
    """Friction coefficient."""
    slope: of.Slope
    """Friction force per velocity while below the full value."""
    total: StrictBool = False
    """Whether the slope is of all points together and is shared equally."""

    def build(self, count: int) -> elements.FrictionSlope:
        """The law of each of ``count`` points."""
        from hydrosim.elements.contact.friction_slope import FrictionSlope as Built

        return Built(self.coefficient, (1.0 / count if self.total else 1.0) * self.slope)


class Frictionless(Exemplary):
    """No friction; the other keys may stay, so that one word turns the friction of a case off."""

    model_config = ConfigDict(extra="ignore")
    example: ClassVar[dict[str, Any]] = {"law": "none"}
    law: Literal["none"]
    """No friction."""

    def build(self, count: int) -> elements.Frictionless:
        """The law of each of ``count`` points."""
        from hydrosim.elements.contact.frictionless import Frictionless as Built

        return Built()


Friction = Annotated[StickSlip | Coulomb | FrictionSlope | Frictionless, Discriminator("law")]


# `fender` in a case file.


class Plane(SchemaModel):
    """The other side of a contact, in the earth frame or in that of a body."""

    point: of.Point
    """A point of the plane, in the earth frame or the frame of its body."""
    normal: of.Direction
    """Direction away from the plane, to the free side. Example: [0, -1, 0]."""
    body: StrictStr | None = None
    """Body that the plane is fixed to. Without it the plane is fixed to the earth. Example:
    topside."""
    corners: tuple[of.Point, ...] = ()
    """Corners of a polygon in the plane, outside of which there is no contact."""

    @model_validator(mode="after")
    def _check_normal(self) -> Self:
        if not any(self.normal):
            raise problem("the normal [0, 0, 0]", "a direction", "point it to the free side")
        return self

    @model_validator(mode="after")
    def _check_corners(self) -> Self:
        if len({*self.corners}) < len(self.corners):
            raise problem("a corner twice", "each once", "a polygon is closed by itself")
        if len(self.corners) > 2 and not _goes_round_once(np.array(self.corners), self.normal):
            expected = "each beside the one before it, once round the polygon"
            raise problem("corners whose sides cross each other", expected, "put them in order")
        return self


def _goes_round_once(corners: np.ndarray, normal: Sequence[float]) -> bool:
    """Whether corners (n, 3) are in the order of their angles about their middle, either way."""
    across = np.delete(corners - corners.mean(axis=0), np.argmax(np.abs(normal)), axis=1)
    angle = np.arctan2(across[:, 1], across[:, 0])
    turns = np.mod(np.diff(angle, append=angle[:1]), 2.0 * np.pi).sum() / (2.0 * np.pi)
    return round(turns) in (1, len(corners) - 1)


def check_lengths(compression: Sequence[float] | None, force: Sequence[float] | None) -> None:
    """Refuses a table that has not a force for each compression."""
    if compression and force and len(compression) != len(force):
        found_text = f"{len(compression)} values in compression and {len(force)} in force"
        raise problem(found_text, "a force for each compression")


class Unloading(SchemaModel):
    """The way back along a normal curve, and the stiff line between."""

    compression: of.Compressions
    """Compressions from 0 that rise, on the way back."""
    force: of.NormalForces
    """Force at each compression on the way back."""
    stiffness: of.Stiffness
    """Stiffness of the line between the way there and the way back."""

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        check_lengths(self.compression, self.force)
        return self


class Normal(SchemaModel):
    """Normal force of a contact; ``total`` values are shared by the points."""

    stiffness: of.Stiffness | None = None
    """Force per compression of a linear contact."""
    compression: of.Compressions | None = None
    """Compressions from 0 that rise, for a curve."""
    force: of.NormalForces | None = None
    """Force at each compression."""
    unloading: Unloading | None = None
    """Curve of the way back, of a contact that loses energy."""
    prescribed: NormalOverTime | None = None
    """Normal force over time, whatever the compression."""
    damping: of.Damping = 0.0
    """Damping of compression."""
    total: StrictBool = False
    """Whether values are of all points together and are shared equally."""

    @model_validator(mode="after")
    def _check_curve(self) -> Self:
        given = self.keys_with_value("stiffness", "compression", "force", "prescribed")
        if given not in (["stiffness"], ["compression", "force"], ["prescribed"]):
            expected = "stiffness, or compression and force, or prescribed"
            raise problem(" and ".join(given) or "no curve", expected)
        if self.prescribed and self.damping:
            raise problem("prescribed and damping", "one of them")
        if self.unloading and (self.prescribed or self.damping):
            found_text = f"unloading and {'prescribed' if self.prescribed else 'damping'}"
            raise problem(found_text, "one of them", "the loop takes energy, and needs a curve")
        if self.force and not self.force[-1]:
            raise problem("no force at any compression", "one that rises")
        check_lengths(self.compression, self.force)
        return self

    def build(self, count: int, where: BuildContext) -> elements.Normal:
        """The normal force of each of ``count`` points."""
        from hydrosim.elements.contact.curves import NormalCurve, NormalLoop, PrescribedNormal
        from hydrosim.elements.signal import scale_signal

        share = 1.0 / count if self.total else 1.0
        if self.prescribed is not None:
            key = f"{where.key}.normal.prescribed"
            return PrescribedNormal(
                scale_signal(signal_of(self.prescribed, key, where.path, "N"), share)
            )
        if self.stiffness is not None:
            table = np.array([0.0, 1.0]), np.array([0.0, self.stiffness])
        else:
            table = np.array(self.compression), np.array(self.force)
        compression, force = table
        if self.unloading is not None:
            back = np.array(self.unloading.compression), share * np.array(self.unloading.force)
            return NormalLoop(compression, share * force, *back, share * self.unloading.stiffness)
        return NormalCurve(compression, share * force, share * self.damping)


class Fender(Element):
    """Points of a body against a plane."""

    example: ClassVar[dict[str, Any]] = {
        "type": "fender",
        "body": "barge",
        "points": [["1 m", "0.5 m", "-1 m"], ["-0.8 m", "-0.6 m", "-1.1 m"]],
        "plane": {"body": "topside", "point": [0, 0, "0.9 m"], "normal": [0, 0, 1]},
        "normal": {"stiffness": "100 kN/m", "damping": "3 kN*s/m"},
        "friction": StickSlip.example,
    }

    type: Literal["fender"]
    """Points of a body against a plane."""
    points: Annotated[tuple[of.Point, ...], AfterValidator(of.require_entries)]
    """Points in the body frame that touch the plane."""
    plane: Plane
    """The other side of the contact."""
    normal: Normal
    """Normal force of the contact."""
    friction: Friction
    """Friction law of the contact."""
    group: of.Name | None = None
    """Name of a group of contacts. Statistics of contacts are made for each group. Example:
    legs."""
    capacity: of.ReferenceForce | None = None
    """Allowable force, which statistics compare with."""

    @model_validator(mode="after")
    def _check_corners(self) -> Self:
        if self.plane.corners and self.normal.prescribed:
            raise problem("plane.corners and normal.prescribed", "one of them")
        return self

    @model_validator(mode="after")
    def _check_rate_free(self) -> Self:
        law = self.friction
        rate_free = isinstance(law, StickSlip) and not law.damping + law.slip_damping
        if rate_free and self.normal.damping:
            found_text = "normal.damping and friction without damping and slip_damping"
            raise problem(found_text, "one of the latter above 0, or no normal.damping")
        return self

    def body_references(self) -> Iterator[tuple[Keys, str | None, str]]:
        yield ("plane", "body"), self.plane.body, "a plane without body is fixed to the earth"

    def recorded_series(self) -> Iterator[tuple[Keys, Recorded]]:
        if isinstance(self.normal.prescribed, Recorded):
            yield ("normal", "prescribed"), self.normal.prescribed

    def build(self, where: BuildContext) -> elements.Fender:
        from hydrosim.elements.contact import fender, geometry  # loads numba

        count = len(self.points)
        return fender.Fender(
            self.body,
            points=np.array(self.points),
            plane=geometry.Plane(**dict(self.plane)),
            normal=self.normal.build(count, where),
            friction=self.friction.build(count),
            group=self.group,
            capacity=self.capacity,
        )


# `landing` in a case file.


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

    def build(self) -> elements.Wall:
        """The same of the scene."""
        from hydrosim.elements.contact.landing import Wall as Built  # loads numba

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

    def build(self, where: BuildContext) -> elements.Landing:
        from hydrosim.elements.contact.landing import Landing as Built  # loads numba

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
