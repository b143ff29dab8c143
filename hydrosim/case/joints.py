"""`joints` of a case file: what connects bodies to each other or to the earth.

Each type is one class with its own keys. What acts in its free motions (springs, damping, stops,
friction) stands beside them if there is one motion, else below the name of the motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf, pi
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import StrictStr, model_validator

from hydrosim import scene
from hydrosim.case.elements.element import Exemplary
from hydrosim.files import quantities as of
from hydrosim.files.quantities import SchemaModel
from hydrosim.files.schema_class import ByKind
from hydrosim.files.units import problem
from hydrosim.scene.force import Active
from hydrosim.scene.joint import JointType

MIN_AXIS_LENGTH = 1e-100  # length of an axis: below it has no direction
PARALLEL = 1e-6  # of two axes that must be at right angles: cosine that is rounding


class TurnStops(SchemaModel):
    """End stops of a turn."""

    range: tuple[of.Angle, of.Angle]
    """Lowest and highest angle without contact. Example: [-60 deg, 60 deg]."""
    stiffness: of.TurnStiffness
    """Moment per angle beyond a stop."""
    damping: of.TurnDamping = 0.0
    """Damping while a stop is pressed. A stop never pulls."""

    _check_order = model_validator(mode="after")(lambda stops: check_stop_order(stops))


class SlideStops(SchemaModel):
    """End stops of a slide."""

    range: tuple[of.Length, of.Length]
    """Lowest and highest offset without contact. Example: [-3 m, 3 m]."""
    stiffness: of.Stiffness
    """Force per offset beyond a stop."""
    damping: of.Damping = 0.0
    """Damping while a stop is pressed. A stop never pulls."""

    _check_order = model_validator(mode="after")(lambda stops: check_stop_order(stops))


def check_stop_order(stops: Any) -> Any:
    lowest, highest = stops.range
    if lowest >= highest:
        raise problem(f"range [{lowest:g}, {highest:g}]", "the lower end first, then the higher")
    return stops


class JointDryFriction(SchemaModel):
    """Dry friction of a motion: given, or growing with the load of the joint's bearings, or the sum
    of both."""

    law: Literal["coulomb"]
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
            _require_not_more(getattr(self, f"static_{key}"), getattr(self, f"kinetic_{key}"), key)
        bearings = self.keys_with_value(*self.bearing_keys)
        if self.static_coefficient is None and bearings:
            raise problem(f"{bearings[0]} without static_coefficient", "both, or neither")
        if self.static_coefficient is not None and not self._coefficients()[1] > 0.0:
            raise problem("a coefficient of 0", "coefficients above 0, or none")
        return self

    def _coefficients(self) -> tuple[float, float]:
        return _both_of(self.static_coefficient, self.kinetic_coefficient)


def _both_of(static: float | None, kinetic: float | None) -> tuple[float, float]:
    """Static and kinetic friction: the latter is the same if not given."""
    static = static or 0.0
    return static, static if kinetic is None else kinetic


def _require_not_more(static: float | None, kinetic: float | None, what: str) -> None:
    if kinetic is not None and kinetic > (static or 0.0):
        raise problem(
            f"kinetic_{what} {kinetic:g} above static_{what} {static or 0.0:g}",
            "no more than static",
        )


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

    def build(self) -> scene.JointFriction:
        """The same of the scene."""
        return scene.JointFriction(
            *_both_of(self.static_moment, self.kinetic_moment),
            *self._coefficients(),
            self.radius or 0.0,
            self.collar_radius or 0.0,
            self.bearing_distance or inf,
        )


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

    def build(self) -> scene.JointFriction:
        """The same of the scene."""
        return scene.JointFriction(
            *_both_of(self.static_force, self.kinetic_force),
            *self._coefficients(),
            bearing_distance=self.guide_length or inf,
        )


class TurnInitial(SchemaModel):
    """Start of a turn."""

    angle: of.Angle = 0.0
    """Angle at the start. At rest it is zero."""
    rate: of.TurnRate = 0.0
    """Its rate at the start."""


class SlideInitial(SchemaModel):
    """Start of a slide."""

    offset: of.Length = 0.0
    """Offset at the start. At rest it is zero."""
    speed: of.Speed = 0.0
    """Its rate at the start."""


class Turn(SchemaModel):
    """What acts about an axis of a joint."""

    stiffness: of.EitherTurnStiffness = 0.0
    """Moment per angle of a spring, of either sign."""
    neutral: of.Angle = 0.0
    """Angle at which the spring has no moment."""
    damping: of.TurnDamping = 0.0
    """Linear damping."""
    stops: TurnStops | None = None
    """End stops."""
    friction: TurnFriction | None = None
    """Dry friction."""
    initial: TurnInitial = TurnInitial()
    """Angle and rate at the start."""

    def build_resistance(self) -> scene.JointResistance:
        """The same of the scene."""
        return _build_resistance(self, self.initial.angle, self.initial.rate)


class Slide(SchemaModel):
    """What acts along an axis of a joint."""

    stiffness: of.EitherStiffness = 0.0
    """Force per offset of a spring, of either sign."""
    neutral: of.Length = 0.0
    """Offset at which the spring has no force."""
    damping: of.Damping = 0.0
    """Linear damping."""
    stops: SlideStops | None = None
    """End stops."""
    friction: SlideFriction | None = None
    """Dry friction."""
    initial: SlideInitial = SlideInitial()
    """Offset and speed at the start."""

    def build_resistance(self) -> scene.JointResistance:
        """The same of the scene."""
        return _build_resistance(self, self.initial.offset, self.initial.speed)


def _build_resistance(
    form: Turn | Slide, position: float, velocity: float
) -> scene.JointResistance:
    return scene.JointResistance(
        form.stiffness,
        form.neutral,
        form.damping,
        _build_stops(form.stops),
        form.friction.build() if form.friction else None,
        position,
        velocity,
    )


def _build_stops(form: TurnStops | SlideStops | None) -> scene.Stops | None:
    return None if form is None else scene.Stops(*form.range, form.stiffness, form.damping)


class JointWindow(SchemaModel):
    """Window in which a joint closes."""

    gap: of.Length | None = None
    """The joint closes when its point on both bodies is nearer than this. A slide that it leaves
    free does not count. Example: 0.05 m."""
    speed: of.Speed | None = None
    """The joint closes when the relative speed of the bodies at its point is below this. A slide
    that it leaves free does not count. Example: 0.1 m/s."""

    @model_validator(mode="after")
    def _check_values(self) -> Self:
        given = self.keys_with_value("gap", "speed")
        if not given:
            raise problem("an empty mapping", "gap, speed, or both")
        for key in given:
            if not getattr(self, key) > 0.0:
                raise problem(f"{key} {getattr(self, key):g}", "a value above 0")
        return self

    def build(self) -> scene.Window:
        """The same of the scene."""
        return scene.Window(
            inf if self.gap is None else self.gap, inf if self.speed is None else self.speed
        )


class JointForm(Exemplary):
    """A joint of a ``body``; in examples there are a "barge" and a "topside"."""

    type: str
    """Type of the joint."""
    body: StrictStr
    """Body of the joint. Point and axes are in its frame. Example: barge."""
    to: StrictStr | None = None
    """Other body of the joint. Without it the joint is to the earth. Example: topside."""
    point: of.Point = (0.0, 0.0, 0.0)
    """Place of the joint, with both bodies at their places at rest."""
    active: Active | None = None
    """Time in which the joint holds: from, until, or both. It holds the bodies in the relative
    place that they have when it closes."""
    window: JointWindow | None = None
    """Gap and speed at the joint's point below which the joint closes, while it is active. Without
    it, it closes as soon as it is active."""

    breaks_at: of.Force | None = None
    """Force at which the joint opens for good. Without it, it never breaks."""

    @model_validator(mode="after")
    def _check_active(self) -> Self:
        limited = self.keys_with_value("active", "window", "breaks_at")
        if self.breaks_at is not None and not self.breaks_at > 0.0:
            raise problem(f"breaks_at {self.breaks_at:g} N", "a force above 0")
        if limited and any(resistance.acts for resistance in self.resistances()):
            raise problem(
                f"{limited[0]}, and a spring, damping, stops or friction in the joint",
                "one of them",
                "a joint that comes and goes leaves its free motions without forces",
            )
        return self

    def axes(self) -> tuple[tuple[float, ...], tuple[float, ...] | None]:
        """Its axis and its second axis."""
        return (0.0, 0.0, 1.0), None

    def resistances(self) -> Sequence[scene.JointResistance]:
        """What acts in its free motions, one after the other."""
        return ()

    @property
    def moves(self) -> bool:
        """Whether it has a rate or speed at the start."""
        return any(resistance.velocity for resistance in self.resistances())

    def build(self) -> scene.Joint:
        """The joint of the scene."""
        axis, second = self.axes()
        return scene.Joint(
            JointType(self.type),
            self.body,
            self.to,
            self.point,
            axis,
            second,
            tuple(self.resistances()),
            self.active.build() if self.active else None,
            self.window.build() if self.window else None,
            self.pawl(),
            self.breaks_at,
        )

    def pawl(self) -> scene.Ratchet | None:
        """The ratchet of the scene, if it is one."""
        return None


class OnAxis(JointForm):
    """A joint with an axis."""

    axis: of.Direction
    """Direction of the axis. Example: [0, 1, 0]."""

    @model_validator(mode="after")
    def _check_axis(self) -> Self:
        if not np.linalg.norm(self.axis) > MIN_AXIS_LENGTH:
            raise problem("an axis of no length", "a direction, such as [0, 1, 0]")
        return self

    def axes(self) -> tuple[tuple[float, ...], tuple[float, ...] | None]:
        return self.axis, None


class Hinge(OnAxis, Turn):
    """A joint that turns about an axis."""

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

    type: Literal["hinge"]
    """A turn about an axis."""

    def resistances(self) -> Sequence[scene.JointResistance]:
        return (self.build_resistance(),)


class Slider(OnAxis, Slide):
    """A joint that slides along an axis."""

    example: ClassVar[dict[str, Any]] = {
        "type": "slider",
        "body": "barge",
        "to": "topside",
        "axis": [0, 0, 1],
        "damping": "100 kN*s/m",
    }

    type: Literal["slider"]
    """A slide along an axis."""

    def resistances(self) -> Sequence[scene.JointResistance]:
        return (self.build_resistance(),)


class Cylindrical(OnAxis):
    """A joint that slides along an axis and turns about it."""

    example: ClassVar[dict[str, Any]] = {
        "type": "cylindrical",
        "body": "barge",
        "axis": [0, 0, 1],
        "slide": {"damping": "100 kN*s/m"},
    }

    type: Literal["cylindrical"]
    """A slide along an axis and a turn about it."""
    slide: Slide = Slide()
    """What acts along the axis."""
    turn: Turn = Turn()
    """What acts about the axis."""

    def resistances(self) -> Sequence[scene.JointResistance]:
        return self.slide.build_resistance(), self.turn.build_resistance()


class Universal(OnAxis):
    """A joint that turns about two axes at right angles."""

    example: ClassVar[dict[str, Any]] = {
        "type": "universal",
        "body": "barge",
        "axis": [1, 0, 0],
        "second_axis": [0, 1, 0],
        "first": {"damping": "1e6 N*m*s/rad"},
    }

    type: Literal["universal"]
    """Turns about an axis of the other body, then about one of this body."""
    second_axis: of.Direction
    """Axis that moves with the body, at right angles to axis. Example: [0, 1, 0]."""
    first: Turn = Turn()
    """What acts about axis, which moves with the other body."""
    second: Turn = Turn()
    """What acts about second_axis."""

    @model_validator(mode="after")
    def _check_angle(self) -> Self:
        _require_right_angles(self.axis, self.second_axis)
        return self

    def axes(self) -> tuple[tuple[float, ...], tuple[float, ...] | None]:
        return self.axis, self.second_axis

    def resistances(self) -> Sequence[scene.JointResistance]:
        return self.first.build_resistance(), self.second.build_resistance()


class Planar(OnAxis):
    """A joint that slides in a plane and turns about its normal."""

    example: ClassVar[dict[str, Any]] = {"type": "planar", "body": "barge", "axis": [0, 1, 0]}

    type: Literal["planar"]
    """Slides in a plane with the normal axis, and a turn about it."""
    second_axis: of.Direction | None = None
    """First direction in the plane. Without it, x, or y if the normal is along x. Example: [1, 0,
    0]."""
    first: Slide = Slide()
    """What acts along the first direction."""
    second: Slide = Slide()
    """What acts along the second direction, axis x second_axis."""
    turn: Turn = Turn()
    """What acts about the normal."""

    @model_validator(mode="after")
    def _check_angle(self) -> Self:
        if self.second_axis is not None:
            _require_right_angles(self.axis, self.second_axis)
        return self

    def axes(self) -> tuple[tuple[float, ...], tuple[float, ...] | None]:
        return self.axis, self.second_axis

    def resistances(self) -> Sequence[scene.JointResistance]:
        return (
            self.first.build_resistance(),
            self.second.build_resistance(),
            self.turn.build_resistance(),
        )


class BallInitial(SchemaModel):
    """Start of a ball joint."""

    rotation: tuple[of.Angle, of.Angle, of.Angle] = (0.0, 0.0, 0.0)
    """Rotation vector at the start: its direction is the axis, its length the angle."""
    rate: tuple[of.TurnRate, of.TurnRate, of.TurnRate] = (0.0, 0.0, 0.0)
    """Angular velocity relative to the other body at the start."""


class Ball(JointForm):
    """A joint that turns about a point."""

    example: ClassVar[dict[str, Any]] = {
        "type": "ball",
        "body": "barge",
        "point": ["0 m", "0 m", "2 m"],
        "damping": "1e6 N*m*s/rad",
    }

    type: Literal["ball"]
    """All turns about a point."""
    damping: of.TurnDamping = 0.0
    """Linear damping of the relative angular velocity."""
    initial: BallInitial = BallInitial()
    """Rotation and angular velocity at the start."""

    def resistances(self) -> Sequence[scene.JointResistance]:
        start = self.initial
        return [
            scene.JointResistance(damping=self.damping, position=angle, velocity=rate)
            for angle, rate in zip(start.rotation, start.rate, strict=True)
        ]


class Guide(OnAxis, Slide):
    """A joint that slides along an axis and turns all ways: a guide pin in a sleeve."""

    example: ClassVar[dict[str, Any]] = {
        "type": "guide",
        "body": "barge",
        "axis": [0, 0, 1],
        "active": {"from": "100 s"},
    }

    type: Literal["guide"]
    """A point of the body stays on an axis of the other body; all turns are free."""

    def resistances(self) -> Sequence[scene.JointResistance]:
        turns = (scene.JointResistance(),) * 3
        return (self.build_resistance(), *turns)


class Fixed(JointForm):
    """A joint that leaves no motion free."""

    example: ClassVar[dict[str, Any]] = {
        "type": "fixed",
        "body": "barge",
        "to": "topside",
        "active": {"from": "100 s"},
    }

    type: Literal["fixed"]
    """No motion."""


class SlidingPawl(SchemaModel):
    """A ratchet along its axis."""

    pitch: of.Length = 0.0
    """Distance of its teeth. Without it, it holds wherever it would go back."""


class TurningPawl(SchemaModel):
    """A ratchet about its axis."""

    pitch: of.Angle = 0.0
    """Angle between its teeth, below 180 deg. Without it, it holds wherever it would turn back."""


class RatchetEntry(OnAxis):
    """A joint that lets one motion go one way only, and leaves all others free."""

    example: ClassVar[dict[str, Any]] = {
        "type": "ratchet",
        "body": "barge",
        "axis": [-1, 0, 0],
        "slide": {"pitch": "0.1 m"},
        "active": {"from": "100 s"},
    }

    type: Literal["ratchet"]
    """A motion of the body along an axis of the other body, or about it, that never goes back."""
    slide: SlidingPawl | None = None
    """The body only goes along the axis, not back."""
    turn: TurningPawl | None = None
    """The body only turns about the axis, not back."""

    @model_validator(mode="after")
    def _check_motion(self) -> Self:
        given = self.keys_with_value("slide", "turn")
        if len(given) != 1:
            raise problem(" and ".join(given) or "no motion", "either slide: {} or turn: {}")
        if self.window is not None or self.breaks_at is not None:
            expected = "neither; a ratchet holds when it goes back, and lets go when it would pull"
            raise problem("a ratchet with a window or breaks_at", expected)
        pitch = getattr(self, given[0]).pitch
        if not pitch >= 0.0 or (given[0] == "turn" and not pitch < pi):
            raise problem(f"pitch {pitch:g}", "0 or more, and below 180 deg for a turn")
        return self

    def pawl(self) -> scene.Ratchet:
        form = self.slide or self.turn
        assert form is not None
        return scene.Ratchet(self.turn is not None, form.pitch)


class Rod(JointForm):
    """A joint that keeps the distance of two points, and leaves all else free."""

    example: ClassVar[dict[str, Any]] = {
        "type": "rod",
        "body": "barge",
        "to": "topside",
        "point": ["0 m", "0 m", "2 m"],
        "to_point": ["0 m", "0 m", "-3 m"],
    }

    type: Literal["rod"]
    """A constant distance of two points."""
    point: of.Point
    """End of the rod on its body, in the body frame."""
    to_point: of.Point
    """Other end of the rod, in the frame of the other body or, without to, of the earth."""
    length: of.LineLength | None = None
    """Distance of both ends. Without it, that with both bodies at their places at rest."""

    @model_validator(mode="after")
    def _check_window(self) -> Self:
        if self.window is not None:
            raise problem("a rod with a window", "none; a rod has no gap to close")
        return self

    def build(self) -> scene.Joint:
        return replace(super().build(), to_point=self.to_point, length=self.length)


def _require_right_angles(first: tuple[float, ...], second: tuple[float, ...]) -> None:
    a, b = np.array(first), np.array(second)
    cosine = float(a @ b) / float(np.linalg.norm(a) * np.linalg.norm(b) or 1.0)
    if not np.linalg.norm(b) > MIN_AXIS_LENGTH or abs(cosine) > PARALLEL:
        found_text = (
            f"axis [{a[0]:g}, {a[1]:g}, {a[2]:g}] and second_axis [{b[0]:g}, {b[1]:g}, {b[2]:g}]"
        )
        raise problem(found_text, "two axes at right angles")


AnyJoint = Annotated[
    Hinge | Ball | Universal | Slider | Cylindrical | Planar | Guide | Fixed | RatchetEntry | Rod,
    ByKind("type"),
]
