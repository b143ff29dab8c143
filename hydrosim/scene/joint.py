"""Joints between bodies, or of a body to the earth: `joints` of a case file.

A joint leaves some relative motions free. Each type is one class with its own keys and its free
``motions``. What acts in these (springs, damping, stops, friction) stands beside them if there is
one motion, else below the name of the motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field, replace
from enum import StrEnum
from math import inf, pi
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple, Self

import numpy as np
from pydantic import StrictStr, model_validator

from hydrosim.files import quantities as of
from hydrosim.files.key_rules import at_least_one, exactly_one
from hydrosim.files.schema_class import ByKind, SchemaClass, schema_class
from hydrosim.files.units import problem
from hydrosim.scene.force import Active

MIN_AXIS_LENGTH = 1e-100  # length of an axis: below it has no direction
PARALLEL = 1e-6  # of two axes that must be at right angles: cosine that is rounding


class MotionKind(StrEnum):
    """A slide along an axis, a turn about an axis, or one of the three turns of a ball."""

    SLIDE = "slide"
    TURN = "turn"
    SWIVEL = "swivel"


class JointMotion(NamedTuple):
    """A free motion of a joint: its ``name``, its ``kind``, and the number of its axis among
    `Joint.axes`."""

    name: str
    kind: MotionKind
    axis: int


TURN = JointMotion("angle", MotionKind.TURN, 0)
SLIDE = JointMotion("offset", MotionKind.SLIDE, 0)
SWIVELS = tuple(JointMotion(f"rotation_{x}", MotionKind.SWIVEL, k) for k, x in enumerate("xyz"))


def require_direction(axis: Sequence[float]) -> None:
    """Raises a problem if an ``axis`` has no length."""
    if not np.linalg.norm(axis) > MIN_AXIS_LENGTH:
        raise problem("an axis of no length", "a direction, such as [0, 1, 0]")


# What acts in a free motion.


@schema_class
class JointStops(SchemaClass):
    """End stops of a motion."""

    if TYPE_CHECKING:
        range: tuple[float, float]
        stiffness: float
        damping: float

    @model_validator(mode="after")
    def _check_order(self) -> Self:
        lowest, highest = self.range
        if lowest >= highest:
            expected = "the lower end first, then the higher"
            raise problem(f"range [{lowest:g}, {highest:g}]", expected)
        return self


@schema_class
class TurnStops(JointStops):
    """End stops of a turn."""

    range: tuple[of.Angle, of.Angle]
    """Lowest and highest angle without contact. Example: [-60 deg, 60 deg]."""
    stiffness: of.TurnStiffness
    """Moment per angle beyond a stop."""
    damping: of.TurnDamping = 0.0
    """Damping while a stop is pressed. A stop never pulls."""


@schema_class
class SlideStops(JointStops):
    """End stops of a slide."""

    range: tuple[of.Length, of.Length]
    """Lowest and highest offset without contact. Example: [-3 m, 3 m]."""
    stiffness: of.Stiffness
    """Force per offset beyond a stop."""
    damping: of.Damping = 0.0
    """Damping while a stop is pressed. A stop never pulls."""


@schema_class
class JointDryFriction(SchemaClass):
    """Dry friction of a motion: given, or growing with the load of the joint's bearings, or the sum
    of both."""

    law: Literal["coulomb"] = field(default="coulomb", kw_only=True)
    """Law of the friction."""
    static_coefficient: of.Factor | None = None
    """Largest friction while the joint rests, over the load of its bearings. Example: 0.2."""
    kinetic_coefficient: of.Factor | None = None
    """Friction while it moves, over the load. Without it, the same as static_coefficient."""

    given_friction: ClassVar[str]
    """The word of keys of a given friction: force or moment."""
    bearing_keys: ClassVar[tuple[str, ...]]
    """Keys that say how bearings are loaded; the first ones are needed."""

    @model_validator(mode="after")
    def _check_friction(self) -> Self:
        static = f"static_{self.given_friction}"
        if not self.keys_with_value(static, "static_coefficient"):
            raise problem("no friction", f"{static}, static_coefficient, or both")
        for key in (self.given_friction, "coefficient"):
            static_value = getattr(self, f"static_{key}") or 0.0
            kinetic = getattr(self, f"kinetic_{key}")
            if kinetic is not None and kinetic > static_value:
                found_text = f"kinetic_{key} {kinetic:g} above static_{key} {static_value:g}"
                raise problem(found_text, "no more than static")
        bearings = self.keys_with_value(*self.bearing_keys)
        if self.static_coefficient is None and bearings:
            raise problem(f"{bearings[0]} without static_coefficient", "both, or neither")
        if self.static_coefficient is not None and not self.coefficients[1] > 0.0:
            raise problem("a coefficient of 0", "coefficients above 0, or none")
        return self

    def _pair(self, key: str) -> tuple[float, float]:
        """Static and kinetic friction of a key: the latter is the same if not given."""
        static = getattr(self, f"static_{key}") or 0.0
        kinetic = getattr(self, f"kinetic_{key}")
        return static, static if kinetic is None else kinetic

    @property
    def constant_friction(self) -> tuple[float, float]:
        """Static and kinetic friction [N or N m] that do not depend on the load."""
        return self._pair(self.given_friction)

    @property
    def coefficients(self) -> tuple[float, float]:
        """Static and kinetic friction over the load; 0 if it does not depend on it."""
        return self._pair("coefficient")

    @property
    def levers(self) -> tuple[float, float, float]:
        """Radius of the pin [m], 1 for a slide; that of its collar; the distance of the two
        bearings, infinite if they carry no moment."""
        raise NotImplementedError


@schema_class
class TurnFriction(JointDryFriction):
    """Dry friction of a turn."""

    given_friction = "moment"
    bearing_keys = ("radius", "collar_radius", "bearing_distance")

    static_moment: of.FrictionMoment | None = None
    """Largest moment while the joint rests that does not depend on its load."""
    kinetic_moment: of.FrictionMoment | None = None
    """Moment while it turns. Without it, the same as static_moment."""
    radius: of.LineLength | None = None
    """Radius of the pin: the lever of the friction by the force across the axis. Example: 0.1 m."""
    collar_radius: of.LineLength | None = None
    """Mean radius of the collar: the lever of the friction by the force along the axis."""
    bearing_distance: of.LineLength | None = None
    """Distance of the two bearings of the pin, with the joint in their middle. They also carry the
    moment across the axis. Without it, that moment makes no friction."""

    @model_validator(mode="after")
    def _check_levers(self) -> Self:
        if self.static_coefficient is not None and self.radius is None and not self.collar_radius:
            raise problem("static_coefficient without a lever", "radius, collar_radius, or both")
        return self

    @property
    def levers(self) -> tuple[float, float, float]:
        return self.radius or 0.0, self.collar_radius or 0.0, self.bearing_distance or inf


@schema_class
class SlideFriction(JointDryFriction):
    """Dry friction of a slide."""

    given_friction = "force"
    bearing_keys = ("guide_length",)

    static_force: of.FrictionForce | None = None
    """Largest force while the joint rests that does not depend on its load."""
    kinetic_force: of.FrictionForce | None = None
    """Force while it slides. Without it, the same as static_force."""
    guide_length: of.LineLength | None = None
    """Distance of the two shoes along the axis, with the joint in their middle: they also carry the
    moment across the axis, and jam if it is large. Without it, that moment makes no friction."""

    @property
    def levers(self) -> tuple[float, float, float]:
        return 1.0, 0.0, self.guide_length or inf


@schema_class
class TurnInitial(SchemaClass):
    """Start of a turn."""

    has_valid_defaults = True
    angle: of.Angle = 0.0
    """Angle at the start. At rest it is zero."""
    rate: of.TurnRate = 0.0
    """Its rate at the start."""


@schema_class
class SlideInitial(SchemaClass):
    """Start of a slide."""

    has_valid_defaults = True
    offset: of.Length = 0.0
    """Offset at the start. At rest it is zero."""
    speed: of.Speed = 0.0
    """Its rate at the start."""


@schema_class
class JointResistance(SchemaClass):
    """What acts in a free motion of a joint."""

    if TYPE_CHECKING:
        stiffness: float
        neutral: float
        damping: float
        stops: JointStops | None
        friction: JointDryFriction | None

    @property
    def position(self) -> float:
        """Place at the start [m or rad]."""
        raise NotImplementedError

    @property
    def velocity(self) -> float:
        """Its rate at the start."""
        raise NotImplementedError

    @property
    def acts(self) -> bool:
        """True if it makes any force."""
        linear = self.stiffness != 0.0 or self.damping != 0.0
        return linear or self.stops is not None or self.friction is not None


@schema_class
class Turn(JointResistance):
    """What acts about an axis of a joint."""

    has_valid_defaults = True
    stiffness: of.EitherTurnStiffness = field(default=0.0, kw_only=True)
    """Moment per angle of a spring, of either sign."""
    neutral: of.Angle = field(default=0.0, kw_only=True)
    """Angle at which the spring has no moment."""
    damping: of.TurnDamping = field(default=0.0, kw_only=True)
    """Linear damping."""
    stops: TurnStops | None = field(default=None, kw_only=True)
    """End stops."""
    friction: TurnFriction | None = field(default=None, kw_only=True)
    """Dry friction."""
    initial: TurnInitial = field(default=TurnInitial(), kw_only=True)
    """Angle and rate at the start."""

    @property
    def position(self) -> float:
        return self.initial.angle

    @property
    def velocity(self) -> float:
        return self.initial.rate


@schema_class
class Slide(JointResistance):
    """What acts along an axis of a joint."""

    has_valid_defaults = True
    stiffness: of.EitherStiffness = field(default=0.0, kw_only=True)
    """Force per offset of a spring, of either sign."""
    neutral: of.Length = field(default=0.0, kw_only=True)
    """Offset at which the spring has no force."""
    damping: of.Damping = field(default=0.0, kw_only=True)
    """Linear damping."""
    stops: SlideStops | None = field(default=None, kw_only=True)
    """End stops."""
    friction: SlideFriction | None = field(default=None, kw_only=True)
    """Dry friction."""
    initial: SlideInitial = field(default=SlideInitial(), kw_only=True)
    """Offset and speed at the start."""

    @property
    def position(self) -> float:
        return self.initial.offset

    @property
    def velocity(self) -> float:
        return self.initial.speed


# Joints.


@schema_class
class JointWindow(SchemaClass):
    """Window in which a joint closes."""

    key_rules = (at_least_one("gap", "speed", nothing="an empty mapping"),)
    gap: of.Length | None = None
    """The joint closes when its point on both bodies is nearer than this. A slide that it leaves
    free does not count. Example: 0.05 m."""
    speed: of.Speed | None = None
    """The joint closes when the relative speed of the bodies at its point is below this. A slide
    that it leaves free does not count. Example: 0.1 m/s."""

    @model_validator(mode="after")
    def _check_values(self) -> Self:
        for key in self.keys_with_value("gap", "speed"):
            if not getattr(self, key) > 0.0:
                raise problem(f"{key} {getattr(self, key):g}", "a value above 0")
        return self

    @property
    def limits(self) -> tuple[float, float]:
        """Gap [m] and speed [m/s], infinite if not given."""
        return inf if self.gap is None else self.gap, inf if self.speed is None else self.speed


@schema_class
class Joint(SchemaClass):
    """A joint of a ``body`` to another body or to the earth; in examples there are a "barge" and a
    "topside".

    Point and axes are in the frame of ``body``, with both bodies at their places at rest, where all
    motions of the joint are zero. A joint that lasts for the whole run and closes no loop has its
    motions as coordinates. Any other one locks what it does not leave free while it is active, at
    the relative place of the bodies when it closes.
    """

    motions: ClassVar[tuple[JointMotion, ...]] = ()
    """Its free motions, applied one after the other from ``to`` outwards to ``body``. A ratchet and
    a rod are never branches of a tree: they leave all motions free but one."""
    example: ClassVar[dict[str, Any]] = {}

    type: str = field(default="", kw_only=True)
    """Type of the joint."""
    body: StrictStr
    """Body of the joint. Point and axes are in its frame. Example: barge."""
    to: StrictStr | None = None
    """Other body of the joint. Without it the joint is to the earth. Example: topside."""
    point: of.Point = (0.0, 0.0, 0.0)
    """Place of the joint, with both bodies at their places at rest."""
    active: Active | None = field(default=None, kw_only=True)
    """Time in which the joint holds: from, until, or both. It holds the bodies in the relative
    place that they have when it closes."""
    window: JointWindow | None = field(default=None, kw_only=True)
    """Gap and speed at the joint's point below which the joint closes, while it is active. Without
    it, it closes as soon as it is active."""
    breaks_at: of.Force | None = field(default=None, kw_only=True)
    """Force at which the joint opens for good. Without it, it never breaks."""

    @model_validator(mode="after")
    def _check_active(self) -> Self:
        limited = self.keys_with_value("active", "window", "breaks_at")
        if self.breaks_at is not None and not self.breaks_at > 0.0:
            raise problem(f"breaks_at {self.breaks_at:g} N", "a force above 0")
        if limited and any(resistance.acts for resistance in self.resistances):
            raise problem(
                f"{limited[0]}, and a spring, damping, stops or friction in the joint",
                "one of them",
                "a joint that comes and goes leaves its free motions without forces",
            )
        if limited and any(r.position or r.velocity for r in self.resistances):
            raise problem(
                f"{limited[0]}, and initial of the joint",
                "one of them",
                "a joint that comes and goes holds its bodies where they are: give them an initial",
            )
        return self

    @property
    def resistances(self) -> Sequence[JointResistance]:
        """What acts in its free motions, one after the other."""
        return ()

    @property
    def pawl(self) -> SlidingPawl | TurningPawl | None:
        """What holds if it is a ratchet."""
        return None

    @property
    def moves(self) -> bool:
        """Whether it has a rate or speed at the start."""
        return any(resistance.velocity for resistance in self.resistances)

    @property
    def lasts(self) -> bool:
        """True if it holds for the whole run."""
        limits = (self.active, self.window, self.pawl, self.breaks_at)
        return all(limit is None for limit in limits)

    def build_active(self) -> Self:
        """The same with conditions for both ends of its action."""
        if self.active is None or self.active.is_built:
            return self
        return replace(self, active=self.active.build())

    def given_axes(self) -> tuple[tuple[float, ...], tuple[float, ...] | None]:
        """Its axis and its second axis, if it has one."""
        return (0.0, 0.0, 1.0), None

    def axes(self) -> np.ndarray:
        """Three unit vectors by rows (3, 3), at right angles, right-handed, in the frame of
        ``body`` at rest. Without a second axis, the second is any right angle to the first."""
        axis, given = self.given_axes()
        first = np.array(axis) / np.linalg.norm(axis)
        if given is None:  # the x axis, unless that is nearly the first
            given = (1.0, 0.0, 0.0) if abs(first[0]) < 0.9 else (0.0, 1.0, 0.0)
        second = np.array(given) - first * (first @ np.array(given))
        second /= np.linalg.norm(second)
        return np.array([first, second, np.cross(first, second)])


@schema_class
class OnAxis(Joint):
    """A joint with an axis."""

    axis: of.Direction = field(kw_only=True)
    """Direction of the axis. Example: [0, 1, 0]."""

    @model_validator(mode="after")
    def _check_axis(self) -> Self:
        require_direction(self.axis)
        return self

    def given_axes(self) -> tuple[tuple[float, ...], tuple[float, ...] | None]:
        return self.axis, None


@schema_class
class Hinge(OnAxis, Turn):
    """A joint that turns about an axis."""

    motions = (TURN,)
    example: ClassVar[dict[str, Any]] = {
        "type": "hinge",
        "body": "barge",
        "to": "topside",
        "point": ["-1 m", "0 m", "0.5 m"],
        "axis": [0, 1, 0],
        "damping": "1e6 N*m*s/rad",
        "stops": {"range": ["-60 deg", "60 deg"], "stiffness": "1e9 N*m/rad"},
        "initial": {"angle": "10 deg"},
    }

    type: Literal["hinge"] = field(default="hinge", kw_only=True)
    """A turn about an axis."""

    @property
    def resistances(self) -> Sequence[JointResistance]:
        return (self,)


@schema_class
class Slider(OnAxis, Slide):
    """A joint that slides along an axis."""

    motions = (SLIDE,)
    example: ClassVar[dict[str, Any]] = {
        "type": "slider",
        "body": "barge",
        "to": "topside",
        "axis": [0, 0, 1],
        "damping": "100 kN*s/m",
    }

    type: Literal["slider"] = field(default="slider", kw_only=True)
    """A slide along an axis."""

    @property
    def resistances(self) -> Sequence[JointResistance]:
        return (self,)


@schema_class
class Cylindrical(OnAxis):
    """A joint that slides along an axis and turns about it."""

    motions = (SLIDE, TURN)
    example: ClassVar[dict[str, Any]] = {
        "type": "cylindrical",
        "body": "barge",
        "axis": [0, 0, 1],
        "slide": {"damping": "100 kN*s/m"},
    }

    type: Literal["cylindrical"] = field(default="cylindrical", kw_only=True)
    """A slide along an axis and a turn about it."""
    slide: Slide = field(default=Slide(), kw_only=True)
    """What acts along the axis."""
    turn: Turn = field(default=Turn(), kw_only=True)
    """What acts about the axis."""

    @property
    def resistances(self) -> Sequence[JointResistance]:
        return self.slide, self.turn


@schema_class
class Universal(OnAxis):
    """A joint that turns about two axes at right angles."""

    motions = (
        JointMotion("first_angle", MotionKind.TURN, 0),
        JointMotion("second_angle", MotionKind.TURN, 1),
    )
    example: ClassVar[dict[str, Any]] = {
        "type": "universal",
        "body": "barge",
        "axis": [1, 0, 0],
        "second_axis": [0, 1, 0],
        "first": {"damping": "1e6 N*m*s/rad"},
    }

    type: Literal["universal"] = field(default="universal", kw_only=True)
    """Turns about an axis of the other body, then about one of this body."""
    second_axis: of.Direction = field(kw_only=True)
    """Axis that moves with the body, at right angles to axis. Example: [0, 1, 0]."""
    first: Turn = field(default=Turn(), kw_only=True)
    """What acts about axis, which moves with the other body."""
    second: Turn = field(default=Turn(), kw_only=True)
    """What acts about second_axis."""

    @model_validator(mode="after")
    def _check_angle(self) -> Self:
        _require_right_angles(self.axis, self.second_axis)
        return self

    def given_axes(self) -> tuple[tuple[float, ...], tuple[float, ...] | None]:
        return self.axis, self.second_axis

    @property
    def resistances(self) -> Sequence[JointResistance]:
        return self.first, self.second


@schema_class
class Planar(OnAxis):
    """A joint that slides in a plane and turns about its normal."""

    motions = (
        JointMotion("first_offset", MotionKind.SLIDE, 1),
        JointMotion("second_offset", MotionKind.SLIDE, 2),
        TURN,
    )
    example: ClassVar[dict[str, Any]] = {"type": "planar", "body": "barge", "axis": [0, 1, 0]}

    type: Literal["planar"] = field(default="planar", kw_only=True)
    """Slides in a plane with the normal axis, and a turn about it."""
    second_axis: of.Direction | None = field(default=None, kw_only=True)
    """First direction in the plane. Without it, x, or y if the normal is along x. Example: [1, 0,
    0]."""
    first: Slide = field(default=Slide(), kw_only=True)
    """What acts along the first direction."""
    second: Slide = field(default=Slide(), kw_only=True)
    """What acts along the second direction, axis x second_axis."""
    turn: Turn = field(default=Turn(), kw_only=True)
    """What acts about the normal."""

    @model_validator(mode="after")
    def _check_angle(self) -> Self:
        if self.second_axis is not None:
            _require_right_angles(self.axis, self.second_axis)
        return self

    def given_axes(self) -> tuple[tuple[float, ...], tuple[float, ...] | None]:
        return self.axis, self.second_axis

    @property
    def resistances(self) -> Sequence[JointResistance]:
        return self.first, self.second, self.turn


@schema_class
class BallInitial(SchemaClass):
    """Start of a ball joint."""

    has_valid_defaults = True
    rotation: tuple[of.Angle, of.Angle, of.Angle] = (0.0, 0.0, 0.0)
    """Rotation vector at the start: its direction is the axis, its length the angle."""
    rate: tuple[of.TurnRate, of.TurnRate, of.TurnRate] = (0.0, 0.0, 0.0)
    """Angular velocity relative to the other body at the start."""


@schema_class
class Ball(Joint):
    """A joint that turns about a point."""

    motions = SWIVELS
    example: ClassVar[dict[str, Any]] = {
        "type": "ball",
        "body": "barge",
        "point": ["0 m", "0 m", "2 m"],
        "damping": "1e6 N*m*s/rad",
    }

    type: Literal["ball"] = field(default="ball", kw_only=True)
    """All turns about a point."""
    damping: of.TurnDamping = field(default=0.0, kw_only=True)
    """Linear damping of the relative angular velocity."""
    initial: BallInitial = field(default=BallInitial(), kw_only=True)
    """Rotation and angular velocity at the start."""

    @property
    def resistances(self) -> Sequence[JointResistance]:
        start = zip(self.initial.rotation, self.initial.rate, strict=True)
        return [Turn(damping=self.damping, initial=TurnInitial(*at)) for at in start]

    def axes(self) -> np.ndarray:
        """Those of the frame of its body."""
        return np.eye(3)


@schema_class
class Guide(OnAxis, Slide):
    """A joint that slides along an axis and turns all ways: a guide pin in a sleeve."""

    motions = (SLIDE, *SWIVELS)
    example: ClassVar[dict[str, Any]] = {
        "type": "guide",
        "body": "barge",
        "axis": [0, 0, 1],
        "active": {"from": "100 s"},
    }

    type: Literal["guide"] = field(default="guide", kw_only=True)
    """A point of the body stays on an axis of the other body; all turns are free."""

    @property
    def resistances(self) -> Sequence[JointResistance]:
        return (self, Turn(), Turn(), Turn())


@schema_class
class Fixed(Joint):
    """A joint that leaves no motion free."""

    example: ClassVar[dict[str, Any]] = {
        "type": "fixed",
        "body": "barge",
        "to": "topside",
        "active": {"from": "100 s"},
    }

    type: Literal["fixed"] = field(default="fixed", kw_only=True)
    """No motion."""


@schema_class
class SlidingPawl(SchemaClass):
    """A ratchet along its axis."""

    turns: ClassVar[bool] = False
    has_valid_defaults = True
    pitch: of.Length = 0.0
    """Distance of its teeth. Without it, it holds wherever it would go back."""


@schema_class
class TurningPawl(SchemaClass):
    """A ratchet about its axis."""

    turns: ClassVar[bool] = True
    has_valid_defaults = True
    pitch: of.Angle = 0.0
    """Angle between its teeth, below 180 deg. Without it, it holds wherever it would turn back."""


@schema_class
class Ratchet(OnAxis):
    """A joint that lets one motion go one way only, and leaves all others free."""

    key_rules = (
        exactly_one("slide", "turn", nothing="no motion", expected="either slide: {} or turn: {}"),
    )
    example: ClassVar[dict[str, Any]] = {
        "type": "ratchet",
        "body": "barge",
        "axis": [-1, 0, 0],
        "slide": {"pitch": "0.1 m"},
        "active": {"from": "100 s"},
    }

    type: Literal["ratchet"] = field(default="ratchet", kw_only=True)
    """A motion of the body along an axis of the other body, or about it, that never goes back."""
    slide: SlidingPawl | None = field(default=None, kw_only=True)
    """The body only goes along the axis, not back."""
    turn: TurningPawl | None = field(default=None, kw_only=True)
    """The body only turns about the axis, not back."""

    @model_validator(mode="after")
    def _check_motion(self) -> Self:
        if self.window is not None or self.breaks_at is not None:
            expected = "neither; a ratchet holds when it goes back, and lets go when it would pull"
            raise problem("a ratchet with a window or breaks_at", expected)
        assert self.pawl is not None
        pitch = self.pawl.pitch
        if not pitch >= 0.0 or (self.turn is not None and not pitch < pi):
            raise problem(f"pitch {pitch:g}", "0 or more, and below 180 deg for a turn")
        return self

    @property
    def pawl(self) -> SlidingPawl | TurningPawl | None:
        return self.slide or self.turn


@schema_class
class Rod(Joint):
    """A joint that keeps the distance of two points, and leaves all else free."""

    example: ClassVar[dict[str, Any]] = {
        "type": "rod",
        "body": "barge",
        "to": "topside",
        "point": ["0 m", "0 m", "2 m"],
        "to_point": ["0 m", "0 m", "-3 m"],
    }

    type: Literal["rod"] = field(default="rod", kw_only=True)
    """A constant distance of two points."""
    point: of.Point = field(kw_only=True)
    """End of the rod on its body, in the body frame."""
    to_point: of.Point = field(kw_only=True)
    """Other end of the rod, in the frame of the other body or, without to, of the earth."""
    length: of.LineLength | None = field(default=None, kw_only=True)
    """Distance of both ends. Without it, that with both bodies at their places at rest."""

    @model_validator(mode="after")
    def _check_window(self) -> Self:
        if self.window is not None:
            raise problem("a rod with a window", "none; a rod has no gap to close")
        return self


def _require_right_angles(first: tuple[float, ...], second: tuple[float, ...]) -> None:
    a, b = np.array(first), np.array(second)
    cosine = float(a @ b) / float(np.linalg.norm(a) * np.linalg.norm(b) or 1.0)
    if not np.linalg.norm(b) > MIN_AXIS_LENGTH or abs(cosine) > PARALLEL:
        found_text = (
            f"axis [{a[0]:g}, {a[1]:g}, {a[2]:g}] and second_axis [{b[0]:g}, {b[1]:g}, {b[2]:g}]"
        )
        raise problem(found_text, "two axes at right angles")


AnyJoint = Annotated[
    Hinge | Ball | Universal | Slider | Cylindrical | Planar | Guide | Fixed | Ratchet | Rod,
    ByKind("type"),
]
