"""Contacts of a scene, which are their keys in a case file: `fender`, `landing`, friction laws.

`hydrosim.elements.contact` has their physics.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

import numpy as np
import pydantic

from hydrosim.dofs import MIRROR_SIGN, mirrored_vector
from hydrosim.files import quantities as of
from hydrosim.files.key_rules import exactly_one, same_length
from hydrosim.files.messages import Keys
from hydrosim.files.quantities import SchemaModel
from hydrosim.files.schema_class import ArrayOf, EqualByValue, ReadAs, SchemaClass, schema_class
from hydrosim.files.units import problem
from hydrosim.scene.force import BuildContext, ForceElement
from hydrosim.scene.plane import Plane
from hydrosim.scene.signal import NormalOverTime, RecordedColumns, Signal, scale_signal, signal_of

SEAT = 2.0  # m: default radius of a seat, or its width beside the mouth of its wall
ENDLESS = 1e6  # m: a wall without a mouth

# Friction laws.


def _check_coefficients(static: float, kinetic: float) -> None:
    if static < kinetic:
        raise problem(f"static {static:g}, kinetic {kinetic:g}", "static >= kinetic")


@schema_class
class LoadPowers(SchemaClass):
    """Powers of the elastic normal force over a ``reference`` that the coefficients go with; a
    ``total`` reference is shared by the points, as the coefficients are."""

    reference: of.ReferenceForce
    """Normal force at which the coefficients are as given."""
    stiffness: of.Power
    """Power of the normal force that the stiffness goes with."""
    damping: of.Power = 0.0
    """Power of the normal force that the damping goes with."""
    slip_damping: of.Power = 0.0
    """Power of the normal force that the slip damping goes with."""

    @pydantic.model_validator(mode="after")
    def _check_powers(self) -> Self:
        if max(self.damping, self.slip_damping) > self.stiffness:
            found_text = f"damping {self.damping:g}, slip_damping {self.slip_damping:g}"
            expected = f"no more than that of the stiffness, {self.stiffness:g}"
            raise problem(
                found_text, expected, "else the node stiffens without bound as the load goes"
            )
        return self


@schema_class
class FrictionLaw(SchemaClass):
    """Base of the friction laws. Coefficients are of each point, or of all together if ``total``;
    a scene that is built from a file has those of each."""

    law: str = field(default="", kw_only=True)
    """Friction law."""

    def build_for(self, contact: Contact, where: BuildContext) -> FrictionLaw:
        """The law of each point of ``contact``."""
        return self


@schema_class
class StickSlip(FrictionLaw):
    """The thesis' new friction model; ``total`` values are shared by the points."""

    example: ClassVar[dict[str, Any]] = {
        "law": "stick_slip",
        "static": 0.4,
        "kinetic": 0.3,
        "stiffness": "200 kN/m",
        "damping": "10 kN*s/m",
    }

    law: Literal["stick_slip"] = field(default="stick_slip", kw_only=True)
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
    total: pydantic.StrictBool = False
    """Whether values are of all points together and are shared equally."""

    @pydantic.model_validator(mode="after")
    def _check_law(self) -> Self:
        _check_coefficients(self.static, self.kinetic)
        if self.load and not self.damping + self.slip_damping:
            found_text = "load without damping and slip_damping"
            raise problem(found_text, "one of the latter above 0, or no load")
        return self

    def build_for(self, contact: Contact, where: BuildContext) -> StickSlip:
        """The law of each point of ``contact``."""
        if not self.total:
            return self
        share = 1.0 / len(contact.points)
        load = self.load and replace(self.load, reference=share * self.load.reference)
        parts = {
            key: share * getattr(self, key) for key in ("stiffness", "damping", "slip_damping")
        }
        return replace(self, load=load, total=False, **parts)


@schema_class
class Coulomb(FrictionLaw):
    """Rigid friction: what sticks does not move."""

    example: ClassVar[dict[str, Any]] = {"law": "coulomb", "static": 0.4, "kinetic": 0.3}

    law: Literal["coulomb"] = field(default="coulomb", kw_only=True)
    """Rigid friction: a contact that sticks does not move."""
    static: of.Factor
    """Friction coefficient at which sticking ends."""
    kinetic: of.Factor
    """Friction coefficient while slipping."""

    @pydantic.model_validator(mode="after")
    def _check_law(self) -> Self:
        _check_coefficients(self.static, self.kinetic)
        return self


@schema_class
class FrictionSlope(FrictionLaw):
    """aNySIM's friction model; a ``total`` slope is shared by the points."""

    example: ClassVar[dict[str, Any]] = {
        "law": "friction_slope",
        "coefficient": 0.3,
        "slope": "40 kN*s/m",
    }

    law: Literal["friction_slope"] = field(default="friction_slope", kw_only=True)
    """Friction that rises with velocity up to the full value, as in aNySIM."""
    coefficient: of.Factor
    """Friction coefficient."""
    slope: of.Slope
    """Friction force per velocity while below the full value."""
    total: pydantic.StrictBool = False
    """Whether the slope is of all points together and is shared equally."""

    def build_for(self, contact: Contact, where: BuildContext) -> FrictionSlope:
        """The law of each point of ``contact``."""
        share = 1.0 / len(contact.points) if self.total else 1.0
        return replace(self, slope=share * self.slope, total=False)


@schema_class
class Frictionless(FrictionLaw):
    """No friction; the other keys may stay, so that one word turns the friction of a case off."""

    has_valid_defaults: ClassVar[bool] = True

    __pydantic_config__: ClassVar = pydantic.ConfigDict(extra="ignore")
    example: ClassVar[dict[str, Any]] = {"law": "none"}
    law: Literal["none"] = field(default="none", kw_only=True)
    """No friction."""


Friction = Annotated[
    StickSlip | Coulomb | FrictionSlope | Frictionless, pydantic.Discriminator("law")
]
Law = StickSlip | FrictionSlope | Coulomb | Frictionless


# Normal forces.


@dataclass(frozen=True)
class PrescribedNormal:
    """Normal force of each contact point: ``force`` [N] over time. Contact lasts while it is
    positive, at any position of the point."""

    force: Signal


@dataclass(frozen=True, eq=False)
class NormalCurve(EqualByValue):
    """Normal curve of each contact point: ``compression`` (n,) [m], rising from 0, ``force`` (n,)
    [N], not falling from 0, and ``damping`` [N s/m]."""

    compression: np.ndarray
    force: np.ndarray
    damping: float = 0.0


@dataclass(frozen=True, eq=False)
class NormalLoop(EqualByValue):
    """Normal curve with a loop, for each contact point: ``force`` (n,) [N] over ``compression``
    (n,) [m] in loading, and a smaller force over ``unloading_compression`` (m,) in unloading. All
    start at 0 and do not fall. ``stiffness`` [N/m] between the two is above all slopes of both, see
    `hydrosim.elements.contact.curves`."""

    compression: np.ndarray
    force: np.ndarray
    unloading_compression: np.ndarray
    unloading_force: np.ndarray
    stiffness: float


class Unloading(SchemaModel):
    """The way back along a normal curve, and the stiff line between."""

    key_rules = (same_length("compression", "force"),)

    compression: of.Compressions
    """Compressions from 0 that rise, on the way back."""
    force: of.NormalForces
    """Force at each compression on the way back."""
    stiffness: of.Stiffness
    """Stiffness of the line between the way there and the way back."""


class Normal(SchemaModel):
    """Normal force of a contact; ``total`` values are shared by the points."""

    key_rules = (
        exactly_one("stiffness", ("compression", "force"), "prescribed", nothing="no curve"),
        same_length("compression", "force"),
    )

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
    total: pydantic.StrictBool = False
    """Whether values are of all points together and are shared equally."""

    @pydantic.model_validator(mode="after")
    def _check_curve(self) -> Self:
        if self.prescribed and self.damping:
            raise problem("prescribed and damping", "one of them")
        if self.unloading and (self.prescribed or self.damping):
            found_text = f"unloading and {'prescribed' if self.prescribed else 'damping'}"
            raise problem(found_text, "one of them", "the loop takes energy, and needs a curve")
        if self.force and not self.force[-1]:
            raise problem("no force at any compression", "one that rises")
        return self

    def build_for(self, contact: Contact, where: BuildContext) -> NormalForce:
        """The normal force of each point of ``contact``."""
        share = 1.0 / len(contact.points) if self.total else 1.0
        if self.prescribed is not None:
            key = f"{where.key}.normal.prescribed"
            return PrescribedNormal(
                scale_signal(signal_of(self.prescribed, key, where.path, "N"), share)
            )
        compression, force = contact_curve(self)
        if self.unloading is not None:
            back = np.array(self.unloading.compression), share * np.array(self.unloading.force)
            return NormalLoop(compression, share * force, *back, share * self.unloading.stiffness)
        return NormalCurve(compression, share * force, share * self.damping)


def contact_curve(keys: Normal | Wall) -> tuple[np.ndarray, np.ndarray]:
    """Compressions (n,) [m] and forces (n,) [N] of a contact that has a stiffness or a table."""
    if keys.stiffness is not None:
        return np.array([0.0, 1.0]), np.array([0.0, keys.stiffness])
    return np.array(keys.compression), np.array(keys.force)


NormalForce = NormalCurve | NormalLoop | PrescribedNormal


# Contacts.

ContactNormal = Annotated[NormalForce, ReadAs(Normal, NormalForce)]
Points = Annotated[
    np.ndarray,
    ArrayOf(Annotated[tuple[of.Point, ...], pydantic.AfterValidator(of.require_entries)]),
]


class Contact(ForceElement):
    """``points`` (n, 3) in the body frame against planes; ``normal`` and ``friction`` apply to each
    point. Contacts of one ``group`` are analysed together; None stands for the element's name.

    If it ``remembers``, its points count closings and store their largest force (`loop`). A seat
    carries up to its ``reach`` [m] from its centre; a plane has none.
    """

    remembers: ClassVar[bool] = False
    if TYPE_CHECKING:
        points: np.ndarray
        normal: NormalForce
        friction: Law
        group: str | None
        capacity: float | None

    @abstractmethod
    def planes(self) -> Sequence[Plane]:
        """The plane of each point."""

    def reach(self) -> float:
        """Largest distance of a point from that of its plane at which there is contact [m]."""
        return np.inf

    def can_add_energy(self) -> bool:
        """A prescribed normal force may push a moving body."""
        return isinstance(self.normal, PrescribedNormal)

    def signals(self) -> Iterator[tuple[str, Signal]]:
        if isinstance(self.normal, PrescribedNormal):
            yield "normal.prescribed", self.normal.force

    def unit_names(self, name: str) -> Sequence[str]:
        return [f"{name} {i}" for i in range(1, len(self.points) + 1)]

    def asymmetry(self) -> str | None:
        """Rigid friction beside the plane: the shares of the points in a load are then undefined
        without sideways motions."""
        rigid = isinstance(self.friction, Coulomb) and np.any(self.points[:, 1])
        return "has rigid friction beside the plane" if rigid else None


@schema_class
class Fender(Contact):
    """Points of a body against a plane."""

    example: ClassVar[dict[str, Any]] = {
        "type": "fender",
        "body": "barge",
        "points": [["1 m", "0.5 m", "-1 m"], ["-0.8 m", "-0.6 m", "-1.1 m"]],
        "plane": {"body": "topside", "point": [0, 0, "0.9 m"], "normal": [0, 0, 1]},
        "normal": {"stiffness": "100 kN/m", "damping": "3 kN*s/m"},
        "friction": StickSlip.example,
    }

    type: Literal["fender"] = field(default="fender", kw_only=True)
    """Points of a body against a plane."""
    points: Points
    """Points in the body frame that touch the plane."""
    plane: Plane
    """The other side of the contact."""
    normal: ContactNormal
    """Normal force of the contact."""
    friction: Friction
    """Friction law of the contact."""
    group: of.Name | None = field(default=None, kw_only=True)
    """Name of a group of contacts. Statistics of contacts are made for each group. Example:
    legs."""
    capacity: of.ReferenceForce | None = field(default=None, kw_only=True)
    """Allowable force, which statistics compare with."""

    @pydantic.model_validator(mode="after")
    def _check_corners(self) -> Self:
        if self.plane.corners and getattr(self.normal, "prescribed", None):
            raise problem("plane.corners and normal.prescribed", "one of them")
        return self

    @pydantic.model_validator(mode="after")
    def _check_rate_free(self) -> Self:
        law = self.friction
        rate_free = isinstance(law, StickSlip) and not law.damping + law.slip_damping
        if rate_free and getattr(self.normal, "damping", False):
            found_text = "normal.damping and friction without damping and slip_damping"
            raise problem(found_text, "one of the latter above 0, or no normal.damping")
        return self

    def planes(self) -> Sequence[Plane]:
        return [self.plane] * len(self.points)

    def connected_bodies(self) -> Iterator[tuple[str, str | None]]:
        yield "plane.body", self.plane.body

    def body_references(self) -> Iterator[tuple[Keys, str | None, str]]:
        yield ("plane", "body"), self.plane.body, "a plane without body is fixed to the earth"

    def recorded_series(self) -> Iterator[tuple[Keys, RecordedColumns]]:
        prescribed = getattr(self.normal, "prescribed", None)
        if isinstance(prescribed, RecordedColumns):
            yield ("normal", "prescribed"), prescribed

    def mirrored_parts(self, y: float) -> Sequence[ForceElement]:
        """A fender for each point; each plane is given by the foot of the perpendicular from the
        origin."""
        plane = self.plane.canonical_form(y)
        return [replace(self, points=point[None], plane=plane) for point in self.points]

    def mirror_image(self) -> ForceElement:
        return replace(self, points=self.points * MIRROR_SIGN[:3], plane=self.plane.mirror_image())


@schema_class
class Seats(SchemaClass):
    """Where points come down, in the earth frame or that of a body; they carry along ``axis``, as
    far as ``extent`` from their middle."""

    points: Points
    """Seats, one for each point, in the earth frame or the frame of their body."""
    axis: of.Direction = (0.0, 0.0, 1.0)
    """Direction in which seats carry, from seat to point. Example: [0, 0, 1]."""
    body: pydantic.StrictStr | None = None
    """Body that the seats are fixed to. Without it they are fixed to the earth. Example:
    barge."""
    extent: of.LineLength | None = None
    """Distance from the middle of a seat beyond which it does not carry."""

    @pydantic.model_validator(mode="after")
    def _check_axis(self) -> Self:
        if not any(self.axis):
            raise problem("the axis [0, 0, 0]", "a direction", "point it from seat to point")
        return self


@schema_class
class Wall(SchemaClass):
    """The wall around each seat: a cylinder, or a cone of an ``angle`` to its axis."""

    key_rules = (
        exactly_one("stiffness", ("compression", "force"), nothing="no curve"),
        same_length("compression", "force"),
    )

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

    @pydantic.model_validator(mode="after")
    def _check_wall(self) -> Self:
        if not 0.0 <= self.angle < 0.5 * np.pi:
            found_text = f"an angle of {np.degrees(self.angle):g} deg"
            raise problem(found_text, "0 (a cylinder) to less than 90 deg")
        return self

    @property
    def slope(self) -> float:
        """Tangent of the angle between wall and axis."""
        return float(np.tan(self.angle))

    @property
    def mouth(self) -> float:
        """Height of the mouth above the seat [m]."""
        return ENDLESS if self.depth is None else self.depth


@schema_class
class Landing(Contact):
    """Points of a body, each on a seat of its own. A seat without extent carries up to 2 m from its
    centre, or 2 m beside the mouth of its wall."""

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
    remembers: ClassVar[bool] = True

    type: Literal["landing"] = field(default="landing", kw_only=True)
    """Points of a body, each on a seat of its own."""
    points: Points
    """Points in the body frame."""
    on: Seats
    """Seats that the points come down on."""
    normal: ContactNormal
    """Normal force of the contact."""
    friction: Friction = Frictionless()
    """Friction law of the contact."""
    wall: Wall | None = None
    """Wall around each seat, which guides the point."""
    group: of.Name | None = field(default=None, kw_only=True)
    """Name of a group of contacts. Statistics of contacts are made for each group. Example:
    legs."""
    capacity: of.ReferenceForce | None = field(default=None, kw_only=True)
    """Allowable force, which statistics compare with."""

    @pydantic.model_validator(mode="after")
    def _check_seats(self) -> Self:
        if len(self.points) != len(self.on.points):
            found_text = f"{len(self.points)} points and {len(self.on.points)} seats in on.points"
            raise problem(found_text, "a seat for each point")
        prescribed = getattr(self.normal, "prescribed", None)
        if prescribed or getattr(self.normal, "damping", False):
            found_text = "normal.prescribed" if prescribed else "normal.damping"
            expected = "stiffness, or compression and force, with unloading where energy is lost"
            remedy = "only the normal of a fender may have prescribed or damping"
            raise problem(found_text, expected, remedy)
        return self

    def planes(self) -> Sequence[Plane]:
        seats = self.on
        return [Plane(tuple(seat), seats.axis, seats.body) for seat in seats.points.tolist()]

    def reach(self) -> float:
        if self.on.extent is not None:
            return self.on.extent
        return SEAT + (self.wall.gap + self.wall.slope * self.wall.mouth if self.wall else 0.0)

    def connected_bodies(self) -> Iterator[tuple[str, str | None]]:
        yield "on.body", self.on.body

    def body_references(self) -> Iterator[tuple[Keys, str | None, str]]:
        yield ("on", "body"), self.on.body, "seats without body are fixed to the earth"

    def mirrored_parts(self, y: float) -> Sequence[ForceElement]:
        """A landing for each point."""
        seats = self.on.points - np.array([0.0, 0.0 if self.on.body else y, 0.0])
        return [
            self._move_points(p[None], q[None]) for p, q in zip(self.points, seats, strict=True)
        ]

    def mirror_image(self) -> ForceElement:
        sign = MIRROR_SIGN[:3]
        axis = mirrored_vector(self.on.axis)
        return self._move_points(self.points * sign, self.on.points * sign, axis=axis)

    def _move_points(self, points: np.ndarray, seats: np.ndarray, **changes: Any) -> Landing:
        return replace(self, points=points, on=replace(self.on, points=seats, **changes))
