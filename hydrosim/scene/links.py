"""Links of a scene: what acts along one coordinate, a distance, a twist or a motion of a joint.

`hydrosim.elements.link` has their physics.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import field, fields, replace
from math import inf
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import AfterValidator, StrictBool, StrictStr, model_validator

from hydrosim.dofs import mirrored_vector
from hydrosim.errors import InputError
from hydrosim.files import quantities as of
from hydrosim.files.key_rules import Rule, at_least_one, at_most_one, exactly_one, same_length
from hydrosim.files.messages import Keys
from hydrosim.files.schema_class import ReadAs, SchemaClass, schema_class
from hydrosim.files.units import CoordinateQuantity, CoordinateValue, problem
from hydrosim.scene import signal
from hydrosim.scene.force import BreakingElement, BuildContext, ForceElement, Turns
from hydrosim.scene.joint import Joint, MotionKind, require_direction


@schema_class
class TwoPointElement(ForceElement):
    """Base of elements from a point of their body to an anchor."""

    point: of.Point
    """End on the body, in the body frame."""
    anchor: of.Point
    """Other end, in the earth frame or the frame of anchor_body."""
    anchor_body: StrictStr | None = field(default=None, kw_only=True)
    """Body that the anchor is fixed to. Without it the anchor is fixed to the earth. Example:
    topside."""
    capacity: of.ReferenceForce | None = field(default=None, kw_only=True)
    """Allowable tension, which statistics compare with."""

    def restored_dofs(self) -> Collection[str]:
        return ("surge", "sway", "yaw") if self.anchor_body is None else ()

    def connected_bodies(self) -> Iterator[tuple[str, str | None]]:
        yield "anchor_body", self.anchor_body

    def body_references(self) -> Iterator[tuple[Keys, str | None, str]]:
        remedy = "an anchor without anchor_body is fixed to the earth"
        yield ("anchor_body",), self.anchor_body, remedy

    def unit_names(self, name: str) -> Sequence[str]:
        return [name]

    def mirrored_parts(self, y: float) -> Sequence[ForceElement]:
        """The element itself; an anchor on the earth is given relative to the plane."""
        if self.anchor_body is not None:
            return [self]
        return [self._with_ends(anchor=tuple(np.subtract(self.anchor, (0.0, y, 0.0))))]

    def mirror_image(self) -> ForceElement | None:
        return self._with_ends(
            point=mirrored_vector(self.point), anchor=mirrored_vector(self.anchor)
        )

    def _with_ends(self, **changes: Any) -> ForceElement:
        return replace(self, **changes)


class Link(ForceElement):
    """Base of elements with one load along one coordinate."""

    def unit_names(self, name: str) -> Sequence[str]:
        return [name]


# Lines that pull only.


@schema_class
class TensionCurve(SchemaClass):
    """Tension of a spring over its extension."""

    key_rules = (same_length("extension", "tension"),)
    extension: of.Extensions
    """Extensions that rise."""
    tension: of.NormalForces
    """Tension at each extension."""

    @model_validator(mode="after")
    def _check_curve(self) -> Self:
        if not self.tension[-1]:
            raise problem("no tension at any extension", "one that rises")
        return self


@schema_class
class Spring(TwoPointElement, BreakingElement, Link):
    """A line from a point of a body to an anchor, on the earth or on another body."""

    key_rules = (exactly_one("stiffness", "curve", nothing="no curve"),)
    tension_channel: ClassVar[str] = "spring_tension"
    example: ClassVar[dict[str, Any]] = {
        "type": "spring",
        "body": "barge",
        "point": ["0.4 m", "-0.3 m", "0.8 m"],
        "anchor": ["0.5 m", "0.2 m", "5 m"],
        "anchor_body": "topside",
        "length": "2.7 m",
        "stiffness": "100 kN/m",
        "damping": "2 kN*s/m",
    }

    type: Literal["spring"] = field(default="spring", kw_only=True)
    """A line between a point of a body and an anchor. It carries no push."""
    length: Annotated[signal.Signal | float, ReadAs(signal.LengthOverTime, signal.Signal)]
    """Length of the line without tension, or a table, recorded series or sine of it over time."""
    stiffness: of.Stiffness | None = None
    """Tension per extension."""
    curve: TensionCurve | None = None
    """Tension over extension, in place of stiffness."""
    damping: of.Damping = 0.0
    """Damping along the line."""

    @model_validator(mode="after")
    def _check_curve(self) -> Self:
        signal.require_length(self.length)
        first = self.extension[0]
        if isinstance(self.length, float) and self.length + first <= 0.0:
            found_text = f"length {self.length:g} m and a first extension of {first:g} m"
            expected = "a line that is slack where its ends meet"
            raise problem(found_text, expected, "begin the curve above -length")
        return self

    @property
    def extension(self) -> np.ndarray:
        """The extensions (n,) [m] of its curve."""
        return np.array((0.0, 1.0) if self.curve is None else self.curve.extension)

    @property
    def tension(self) -> np.ndarray:
        """The tensions (n,) [N] of its curve, not falling from 0."""
        straight = (0.0, self.stiffness or 0.0)
        return np.array(straight if self.curve is None else self.curve.tension)

    def recorded_series(self) -> Iterator[tuple[Keys, signal.RecordedColumns]]:
        if isinstance(self.length, signal.RecordedColumns):
            yield ("length",), self.length

    def with_built_parts(self, where: BuildContext) -> Self:
        """The same with its length as a signal, if that is given over time."""
        if isinstance(self.length, float | signal.Signal):
            return self
        length = signal.length_signal(self.length, f"{where.key}.length", where.path)
        return replace(self, length=length)

    def can_add_energy(self) -> bool:
        """A line that is heaved in gives energy."""
        return isinstance(self.length, signal.Signal)

    def signals(self) -> Iterator[tuple[str, Any]]:
        if isinstance(self.length, signal.Signal):
            yield "length", self.length

    def jumps(self) -> Iterator[tuple[str, float]]:
        if isinstance(self.length, signal.Table):
            yield "length", self.damping * signal.largest_corner(self.length)


@schema_class
class Compensator(TwoPointElement, Link):
    """A passive compensator: a gas spring in a line between a point of a body and an anchor, with
    end stops."""

    example: ClassVar[dict[str, Any]] = {
        "type": "compensator",
        "body": "barge",
        "point": ["0.4 m", "-0.3 m", "0.8 m"],
        "anchor": ["0.5 m", "0.2 m", "5 m"],
        "anchor_body": "topside",
        "length": "4.6 m",
        "tension": "10 kN",
        "stroke": "3 m",
        "gas_length": "4 m",
        "exponent": 1.3,
        "stiffness": "100 kN/m",
        "damping": "2 kN*s/m",
    }

    type: Literal["compensator"] = field(default="compensator", kw_only=True)
    """A gas spring in a line, with end stops. It carries no push."""
    length: of.LineLength
    """Length of the whole line in the middle of the stroke."""
    tension: of.ReferenceForce
    """Tension in the middle of the stroke."""
    stroke: of.LineLength
    """Stroke, half of it to each side."""
    gas_length: of.LineLength
    """Volume of the gas over the area of the piston, in the middle of the stroke."""
    exponent: of.GasExponent = field(default=1.0, kw_only=True)
    """Exponent n of p V^n = const: 1 for slow motion, about 1.4 for fast motion."""
    stiffness: of.Stiffness
    """Stiffness of line and stop beyond the stroke."""
    damping: of.Damping = field(default=0.0, kw_only=True)
    """Damping along the line."""

    @model_validator(mode="after")
    def _check_stroke(self) -> Self:
        half = 0.5 * self.stroke
        if self.gas_length <= half:
            found_text = f"gas_length {self.gas_length:g} m and a stroke of {self.stroke:g} m"
            raise problem(found_text, "gas that is left at the end: a gas_length above stroke / 2")
        low = self.tension * (self.gas_length / (self.gas_length + half)) ** self.exponent
        if self.length <= half + low / self.stiffness:
            found_text = f"length {self.length:g} m and a stroke of {self.stroke:g} m"
            raise problem(found_text, "a line that is slack where its ends meet: a longer length")
        return self


# Springs and dampers of both signs.

Points = tuple[Sequence[float], Sequence[float]]
"""Offsets and loads of a curve."""


@schema_class
class ElasticLink(Link):
    """Base of springs and dampers of both signs. Their load is that of a ``stiffness`` or a
    ``curve``, with linear and quadratic damping. The power that one with ``absorbs`` dissipates is
    recorded."""

    key_rules = (at_most_one("stiffness", "curve", expected="one of them", remedy="remove one"),)

    if TYPE_CHECKING:
        stiffness: Any
        curve: Any
        damping: Any
        quadratic_damping: Any

    def check_law(self) -> None:
        """Raises a problem if nothing acts."""
        if not (self.damping or self.quadratic_damping or self.stiffness or self.curve):
            expected = "stiffness, curve, damping or quadratic_damping above 0"
            raise problem("nothing that acts", expected)

    @property
    def offset(self) -> np.ndarray:
        """Offsets (n,) [m or rad] of its curve from where it is neutral; none without a spring."""
        return np.array(self._points()[0])

    @property
    def force(self) -> np.ndarray:
        """The loads (n,) [N or N m] of its curve."""
        return np.array(self._points()[1])

    def _points(self) -> Points:
        """Offsets and loads of its curve, or of the straight line that its stiffness is."""
        if self.curve is not None:
            points: Points = self.curve.points()
            return points
        return ((0.0, 1.0), (0.0, self.stiffness)) if self.stiffness else ((), ())

    def can_carry_weight(self) -> bool:
        return bool(np.any(self.force))


def two_or_more_points(key: str) -> Rule:
    """A rule of keys: the list of a key has two values or more."""

    def check(curve: Any) -> None:
        if len(points := getattr(curve, key)) < 2:
            raise problem(f"{len(points)} points", "two or more")

    return check


@schema_class
class StrutCurve(SchemaClass):
    """Force of a strut over its extension; straight lines, the outer ones continued."""

    key_rules = (same_length("extension", "force"), two_or_more_points("extension"))
    extension: of.Extensions
    """Extensions that rise, beyond the length."""
    force: tuple[of.Force, ...]
    """Force at each extension: tension above 0, compression below."""

    def points(self) -> Points:
        """Its extensions and forces."""
        return self.extension, self.force


@schema_class
class Strut(TwoPointElement, ElasticLink):
    """A spring and damper that pushes and pulls between a point of a body and an anchor, on the
    earth or on another body. The power that a power take-off absorbs is recorded."""

    example: ClassVar[dict[str, Any]] = {
        "type": "strut",
        "body": "barge",
        "point": ["0.4 m", "-0.3 m", "0.8 m"],
        "anchor": ["0.5 m", "0.2 m", "5 m"],
        "anchor_body": "topside",
        "curve": {"extension": ["-0.3 m", "0 m", "0.3 m"], "force": ["-9 kN", "0 kN", "6 kN"]},
        "damping": "2 kN*s/m",
        "quadratic_damping": "1 kN*s^2/m^2",
    }

    type: Literal["strut", "power_take_off"] = field(default="strut", kw_only=True)
    """A spring and damper along a line, which pushes and pulls. A power_take_off is the same with
    its absorbed power recorded."""
    length: of.LineLength | None = None
    """Length at which the spring has no force. Without it, the length at rest."""
    stiffness: of.EitherStiffness | None = field(default=None, kw_only=True)
    """Force per extension, in tension and in compression. It may be 0 or negative."""
    curve: StrutCurve | None = field(default=None, kw_only=True)
    """Force over extension, in place of stiffness."""
    damping: of.Damping = field(default=0.0, kw_only=True)
    """Linear damping along the line."""
    quadratic_damping: of.Drag = field(default=0.0, kw_only=True)
    """Damping along the line by the square of the speed."""
    capacity: of.ReferenceForce | None = field(default=None, kw_only=True)
    """Allowable force of both signs, which statistics compare with."""

    @model_validator(mode="after")
    def _check_law(self) -> Self:
        self.check_law()
        return self

    @property
    def absorbs(self) -> bool:
        """True if its power is recorded."""
        return self.type == "power_take_off"

    def restored_dofs(self) -> Collection[str]:
        return super().restored_dofs() if self.can_carry_weight() else ()


@schema_class
class TorsionCurve(SchemaClass):
    """Moment of a torsion spring over its angle; straight lines, the outer ones continued."""

    key_rules = (same_length("angle", "moment"), two_or_more_points("angle"))
    angle: of.Angles
    """Angles that rise, beyond the neutral one."""
    moment: tuple[of.Moment, ...]
    """Moment against the twist at each angle."""

    def points(self) -> Points:
        """Its angles and moments."""
        return self.angle, self.moment


@schema_class
class TorsionSpring(ElasticLink):
    """A spring and damper about an axis, between a body and another one or the earth. The power
    that a rotary power take-off absorbs is recorded."""

    example: ClassVar[dict[str, Any]] = {
        "type": "torsion_spring",
        "body": "barge",
        "to": "topside",
        "axis": [0.3, 1, 0.2],
        "stiffness": "2 MN*m/rad",
        "damping": "50 kN*m*s/rad",
    }

    type: Literal["torsion_spring", "rotary_power_take_off"] = field(
        default="torsion_spring", kw_only=True
    )
    """A spring and damper about an axis. A rotary_power_take_off is the same with its absorbed
    power recorded."""
    to: StrictStr | None = field(default=None, kw_only=True)
    """Other body. Without it the other side is the earth. Example: topside."""
    axis: of.Direction
    """Direction of the axis, in the body frame. Example: [0, 1, 0]."""
    neutral: of.Angle = field(default=0.0, kw_only=True)
    """Angle at which the spring has no moment. The angle is 0 at rest."""
    stiffness: of.EitherTurnStiffness | None = field(default=None, kw_only=True)
    """Moment per angle. It may be 0 or negative."""
    curve: TorsionCurve | None = field(default=None, kw_only=True)
    """Moment over angle, in place of stiffness."""
    damping: of.TurnDamping = field(default=0.0, kw_only=True)
    """Linear damping about the axis."""
    quadratic_damping: of.TurnDrag = field(default=0.0, kw_only=True)
    """Damping about the axis by the square of the rate."""

    @model_validator(mode="after")
    def _check_law(self) -> Self:
        require_direction(self.axis)
        self.check_law()
        return self

    @property
    def absorbs(self) -> bool:
        """True if its power is recorded."""
        return self.type == "rotary_power_take_off"

    def body_references(self) -> Iterator[tuple[Keys, str | None, str]]:
        yield ("to",), self.to, "without to the other side is the earth"

    def connected_bodies(self) -> Iterator[tuple[str, str | None]]:
        yield "to", self.to

    def restored_dofs(self) -> Collection[str]:
        held = self.to is None and np.any(self.force) and self.axis[2] != 0.0
        return ("yaw",) if held else ()

    def can_carry_weight(self) -> bool:
        return False

    def nonlinearity(self, name: str, turns: Turns) -> str | None:
        """Linear with small angles, if its curve and its damping are."""
        straight = len(self.offset) <= 2 and self.quadratic_damping == 0.0
        return None if straight and not turns.exact else name

    def mirrored_parts(self, y: float) -> Sequence[ForceElement]:
        return [self._in_order()]

    def mirror_image(self) -> ForceElement:
        """A rotation about (x, y, z) has the image of one about (-x, y, -z)."""
        x, y, z = self.axis
        return replace(self, axis=(-x, y, -z))._in_order()

    def _in_order(self) -> TorsionSpring:
        """The same spring with the axis of unit length and, if its curve is odd, towards positive
        coordinates."""
        axis = np.array(self.axis) / np.linalg.norm(self.axis)
        straight = len(self.offset) <= 2 and not (np.any(self.offset[:1]) or np.any(self.force[:1]))
        first = axis[np.flatnonzero(np.abs(axis) > 1e-12)[0]]
        if straight and self.neutral == 0.0 and first < 0.0:
            axis = -axis
        return replace(self, axis=tuple(axis))


# Laws along any coordinate.

Place = Annotated[float, CoordinateQuantity("place", "m", "2 m", turn_unit="rad")]
Stroke = Annotated[float, CoordinateQuantity("stroke", "m", "2 m", above=0, turn_unit="rad")]
Load = Annotated[float, CoordinateQuantity("load", "N", "100 kN", turn_unit="N*m")]
Push = Annotated[float, CoordinateQuantity("load", "N", "100 kN", above=0, turn_unit="N*m")]
Friction = Annotated[float, CoordinateQuantity("load", "N", "100 kN", at_least=0, turn_unit="N*m")]
LinkStiffness = Annotated[
    float, CoordinateQuantity("stiffness", "N/m", "100 kN/m", above=0, turn_unit="N*m/rad")
]
AnyLinkStiffness = Annotated[
    float, CoordinateQuantity("stiffness", "N/m", "100 kN/m", turn_unit="N*m/rad")
]
LinkDamping = Annotated[
    float,
    CoordinateQuantity("damping", "N*s/m", "10 kN*s/m", at_least=0, turn_unit="N*m*s/rad"),
]
LinkDrag = Annotated[
    float,
    CoordinateQuantity(
        "quadratic damping", "N*s^2/m^2", "1 kN*s^2/m^2", at_least=0, turn_unit="N*m*s^2/rad^2"
    ),
]


@schema_class
class CoordinateElement(Link):
    """Base of elements along any coordinate. Values are in metres and newtons along a line, in
    radians and newton metres about an axis."""

    key_rules = (
        exactly_one(
            *("point", "axis", "joint"),
            nothing="no coordinate",
            expected="one: point and anchor, axis, or joint",
        ),
    )
    body: StrictStr | None = None  # type: ignore[assignment]
    """Body that it acts on; of a joint this is left out. Example: barge."""
    point: of.Point | None = field(default=None, kw_only=True)
    """End on the body of a distance, in the body frame."""
    anchor: of.Point | None = field(default=None, kw_only=True)
    """Other end of a distance, in the earth frame or the frame of anchor_body."""
    anchor_body: StrictStr | None = field(default=None, kw_only=True)
    """Body that the anchor is fixed to. Without it the anchor is fixed to the earth. Example:
    topside."""
    axis: of.Direction | None = field(default=None, kw_only=True)
    """Direction of the axis of a twist, in the body frame. The twist is 0 at rest. Example:
    [0, 1, 0]."""
    to: StrictStr | None = field(default=None, kw_only=True)
    """Other body of a twist. Without it the other side is the earth. Example: topside."""
    joint: StrictStr | None = field(default=None, kw_only=True)
    """Joint in whose motion it acts. Example: hinge."""
    motion: StrictStr | None = field(default=None, kw_only=True)
    """Motion of the joint. Without it, the only one. Example: angle."""

    @model_validator(mode="after")
    def _check_coordinate(self) -> Self:
        wanted = "point and anchor, axis, or joint"
        (given,) = self.keys_with_value("point", "axis", "joint")
        belong = {"point": ("anchor", "anchor_body"), "axis": ("to",), "joint": ("motion",)}
        for form, keys in belong.items():
            for key in self.keys_with_value(*keys) if form != given else ():
                raise problem(f"{key} without {form}", wanted)
        if self.point is not None and self.anchor is None:
            raise problem("point without anchor", wanted)
        if self.joint is None and self.body is None:
            raise problem("no body", "the name of a body", "only a joint goes without it")
        if self.axis is not None:
            require_direction(self.axis)
        return self

    def build_active(self, where: BuildContext) -> ForceElement:
        """The element, which acts on the body of its joint."""
        joint = where.joints.get(self.joint) if self.joint and self.body is None else None
        placed = self if joint is None else replace(self, body=joint.body)
        return super(CoordinateElement, placed).build_active(where)

    def turns(self, joints: Mapping[str, Joint]) -> bool:
        """True if it acts about an axis, or in a turn of one of the ``joints``."""
        if self.joint is None:
            return self.axis is not None
        motions = [m for m in joints[self.joint].motions if self.motion in (None, m.name)]
        return motions[0].kind == MotionKind.TURN

    def check_units(self, turns: bool) -> None:
        """Raises InputError for a value that was given in units of the other kind of coordinate."""
        for key, value in self._coordinate_values():
            if isinstance(value, CoordinateValue) and value.turns != turns:
                unit = value.turn_unit if turns else value.unit
                reason = "about an axis" if turns else "along a line"
                raise InputError(
                    f'{key}: found "{value.text}"; expected a value in {unit}, as it acts {reason}.'
                )

    def _coordinate_values(self) -> Iterator[tuple[str, Any]]:
        """Keys and values that may be along a coordinate."""
        for field_ in fields(self):
            yield field_.name, getattr(self, field_.name)

    def can_carry_weight(self) -> bool:
        return self.point is not None  # what a joint carries is known of the joint

    def restored_dofs(self) -> Collection[str]:
        if self.point is not None:
            return ("surge", "sway", "yaw") if self.anchor_body is None else ()
        return ("yaw",) if self.axis is not None and self.to is None and self.axis[2] else ()

    def connected_bodies(self) -> Iterator[tuple[str, str | None]]:
        if self.axis is not None:
            yield "to", self.to
        elif self.joint is None:
            yield "anchor_body", self.anchor_body

    def body_references(self) -> Iterator[tuple[Keys, str | None, str]]:
        yield ("anchor_body",), self.anchor_body, "an anchor without it is fixed to the earth"
        yield ("to",), self.to, "without to the other side is the earth"


@schema_class
class Stop(CoordinateElement):
    """End stops of a distance, a twist or a motion of a joint. They never pull."""

    key_rules = (at_least_one("lowest", "highest", nothing="no stop"),)
    example: ClassVar[dict[str, Any]] = {
        "type": "stop",
        "body": "barge",
        "point": ["0.4 m", "-0.3 m", "0.8 m"],
        "anchor": ["0.5 m", "0.2 m", "5 m"],
        "anchor_body": "topside",
        "lowest": "4.3 m",
        "stiffness": "100 kN/m",
        "damping": "2 kN*s/m",
    }

    type: Literal["stop"] = field(default="stop", kw_only=True)
    """End stops of a coordinate."""
    lowest: Place | None = field(default=None, kw_only=True)
    """Shortest distance, or lowest place of a twist or a motion, that is free."""
    highest: Place | None = field(default=None, kw_only=True)
    """Longest distance, or highest place of a twist or a motion, that is free."""
    stiffness: LinkStiffness = field(kw_only=True)
    """Stiffness beyond the stop."""
    damping: LinkDamping = field(default=0.0, kw_only=True)
    """Damping beyond the stop."""

    @model_validator(mode="after")
    def _check_ends(self) -> Self:
        for key in self.keys_with_value("lowest", "highest") if self.point is not None else ():
            if getattr(self, key) <= 0.0:
                found_text = f"{key} {getattr(self, key):g}"
                expected = "a distance above 0: that of the ends, which is not 0 at rest"
                raise problem(found_text, expected)
        if not self.low < self.high:
            found_text = f"lowest {self.low:g} and highest {self.high:g}"
            raise problem(found_text, "a lowest place below the highest")
        return self

    @property
    def low(self) -> float:
        """The lowest place [m or rad] that is free."""
        return -inf if self.lowest is None else self.lowest

    @property
    def high(self) -> float:
        """The highest place [m or rad] that is free."""
        return inf if self.highest is None else self.highest


@schema_class
class GasSpring(CoordinateElement):
    """A gas spring that pushes, with end stops."""

    example: ClassVar[dict[str, Any]] = {
        "type": "gas_spring",
        "body": "barge",
        "point": ["0.4 m", "-0.3 m", "0.8 m"],
        "anchor": ["0.5 m", "0.2 m", "5 m"],
        "anchor_body": "topside",
        "neutral": "4.3 m",
        "push": "10 kN",
        "stroke": "3 m",
        "gas_length": "4 m",
        "exponent": 1.3,
        "stiffness": "100 kN/m",
        "damping": "2 kN*s/m",
    }

    type: Literal["gas_spring"] = field(default="gas_spring", kw_only=True)
    """A gas spring that pushes along a coordinate."""
    neutral: Place | None = field(default=None, kw_only=True)
    """Place in the middle of the stroke. Without it, the place at rest."""
    push: Push = field(kw_only=True)
    """Load in the middle of the stroke, which drives the coordinate up."""
    stroke: Stroke = field(kw_only=True)
    """Stroke, half of it to each side."""
    gas_length: Stroke = field(kw_only=True)
    """Volume of the gas over the area of the piston, in the middle of the stroke."""
    exponent: of.GasExponent = field(default=1.0, kw_only=True)
    """Exponent n of p V^n = const: 1 for slow motion, about 1.4 for fast motion."""
    stiffness: LinkStiffness = field(kw_only=True)
    """Stiffness of the stops at both ends of the stroke."""
    damping: LinkDamping = field(default=0.0, kw_only=True)
    """Damping along the coordinate."""

    @model_validator(mode="after")
    def _check_stroke(self) -> Self:
        if self.gas_length <= 0.5 * self.stroke:
            found_text = f"gas_length {self.gas_length:g} and a stroke of {self.stroke:g}"
            raise problem(found_text, "gas that is left at the end: a gas_length above stroke / 2")
        if self.point is not None and self.neutral is not None and self.neutral <= self.stroke / 2:
            found_text = f"neutral {self.neutral:g} and a stroke of {self.stroke:g}"
            raise problem(found_text, "ends that never meet: a neutral distance above stroke / 2")
        return self


@schema_class
class DryFriction(CoordinateElement):
    """Dry friction along a distance, a twist or a motion of a joint, by stick-slip."""

    example: ClassVar[dict[str, Any]] = {
        "type": "dry_friction",
        "body": "barge",
        "point": ["0.4 m", "-0.3 m", "0.8 m"],
        "anchor": ["0.5 m", "0.2 m", "5 m"],
        "anchor_body": "topside",
        "static": "6 kN",
        "kinetic": "4 kN",
        "stiffness": "100 kN/m",
        "damping": "2 kN*s/m",
    }

    type: Literal["dry_friction"] = field(default="dry_friction", kw_only=True)
    """Dry friction along a coordinate."""
    static: Friction = field(kw_only=True)
    """Load at which sticking ends."""
    kinetic: Friction = field(kw_only=True)
    """Load while it slips."""
    stiffness: LinkStiffness = field(kw_only=True)
    """Stiffness while it sticks."""
    damping: LinkDamping = field(default=0.0, kw_only=True)
    """Damping while it sticks."""

    @model_validator(mode="after")
    def _check_loads(self) -> Self:
        if self.static < self.kinetic or not self.static:
            found_text = f"static {self.static:g}, kinetic {self.kinetic:g}"
            raise problem(found_text, "static >= kinetic, and static above 0")
        return self


@schema_class
class LoadCurve(SchemaClass):
    """Load of a spring over the place from where it is neutral; the outer lines are continued."""

    key_rules = (same_length("place", "load"),)
    place: Annotated[tuple[Place, ...], of.RISING, AfterValidator(of.require_two_entries)]
    """Places that rise."""
    load: tuple[Load, ...]
    """Load against the motion at each place."""

    def points(self) -> Points:
        """Its places and loads."""
        return self.place, self.load


@schema_class
class SpringDamper(CoordinateElement, ElasticLink):
    """A spring and damper along a distance, a twist or a motion of a joint."""

    example: ClassVar[dict[str, Any]] = {
        "type": "spring_damper",
        "body": "barge",
        "axis": [0, 1, 0],
        "stiffness": "2 MN*m/rad",
        "damping": "50 kN*m*s/rad",
    }

    type: Literal["spring_damper"] = field(default="spring_damper", kw_only=True)
    """A spring and damper along a coordinate, such as a motion of a joint."""
    neutral: Place | None = field(default=None, kw_only=True)
    """Place at which the spring has no load. Without it, the place at rest."""
    stiffness: AnyLinkStiffness | None = field(default=None, kw_only=True)
    """Load per way. It may be 0 or negative."""
    curve: LoadCurve | None = field(default=None, kw_only=True)
    """Load over the way from neutral, in place of stiffness."""
    damping: LinkDamping = field(default=0.0, kw_only=True)
    """Linear damping."""
    quadratic_damping: LinkDrag = field(default=0.0, kw_only=True)
    """Damping by the square of the rate."""
    absorbs: StrictBool = field(default=False, kw_only=True)
    """Whether it is a power take-off, whose absorbed power is recorded."""

    @model_validator(mode="after")
    def _check_law(self) -> Self:
        self.check_law()
        if self.point is not None and self.neutral is not None and self.neutral < 0.0:
            raise problem(f"neutral {self.neutral:g}", "a distance of 0 or more")
        return self

    def can_carry_weight(self) -> bool:
        return super().can_carry_weight() and bool(np.any(self.force))

    def restored_dofs(self) -> Collection[str]:
        return super().restored_dofs() if np.any(self.force) else ()

    def _coordinate_values(self) -> Iterator[tuple[str, Any]]:
        yield from super()._coordinate_values()
        if self.curve is not None:
            yield from (("curve.place", place) for place in self.curve.place)
            yield from (("curve.load", load) for load in self.curve.load)


AnyCoordinateElement = SpringDamper | GasSpring | Stop | DryFriction
"""The elements along any coordinate, of which case files have one each."""
