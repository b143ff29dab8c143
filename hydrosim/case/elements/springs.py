"""Springs of a case file: `spring`, `bushing`, `strut` and `torsion_spring`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import StrictStr, model_validator

from hydrosim.case.elements.element import (
    Breaking,
    BuildContext,
    Element,
    LengthOverTime,
    length_signal,
)
from hydrosim.files import quantities as of
from hydrosim.files.messages import Keys
from hydrosim.files.quantities import SchemaModel, as_matrix
from hydrosim.files.units import problem
from hydrosim.scene.links import Spring, Strut, TorsionSpring
from hydrosim.scene.signal import RecordedColumns

if TYPE_CHECKING:
    from hydrosim.elements.bushing import Bushing as BuiltBushing


class Curve(SchemaModel):
    """Tension of a spring over its extension."""

    extension: of.Extensions
    """Extensions that rise."""
    tension: of.NormalForces
    """Tension at each extension."""

    @model_validator(mode="after")
    def _check_curve(self) -> Self:
        if len(self.extension) != len(self.tension):
            found_text = (
                f"{len(self.extension)} values in extension and {len(self.tension)} in tension"
            )
            raise problem(found_text, "a tension for each extension")
        if not self.tension[-1]:
            raise problem("no tension at any extension", "one that rises")
        return self


class SpringEntry(Breaking):
    """A line from a point of a body to an anchor, on the earth or on another body."""

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

    type: Literal["spring"]
    """A line between a point of a body and an anchor. It carries no push."""
    point: of.Point
    """End of the line on the body, in the body frame."""
    anchor: of.Point
    """Other end of the line, in the earth frame or the frame of anchor_body."""
    anchor_body: StrictStr | None = None
    """Body that the anchor is fixed to. Without it the anchor is fixed to the earth. Example:
    barge."""
    length: LengthOverTime
    """Length of the line without tension, or a table, recorded series or sine of it over time."""
    stiffness: of.Stiffness | None = None
    """Tension per extension."""
    curve: Curve | None = None
    """Tension over extension, in place of stiffness."""
    damping: of.Damping = 0.0
    """Damping along the line."""
    capacity: of.ReferenceForce | None = None
    """Allowable tension, which statistics compare with."""

    @model_validator(mode="after")
    def _check_curve(self) -> Self:
        given = self.keys_with_value("stiffness", "curve")
        if len(given) != 1:
            raise problem(" and ".join(given) or "no curve", "either stiffness or curve")
        first = self.curve.extension[0] if self.curve else 0.0
        if isinstance(self.length, float) and self.length + first <= 0.0:
            found_text = f"length {self.length:g} m and a first extension of {first:g} m"
            expected = "a line that is slack where its ends meet"
            raise problem(found_text, expected, "begin the curve above -length")
        return self

    def body_references(self) -> Iterator[tuple[Keys, str | None, str]]:
        remedy = "an anchor without anchor_body is fixed to the earth"
        yield ("anchor_body",), self.anchor_body, remedy

    def recorded_series(self) -> Iterator[tuple[Keys, RecordedColumns]]:
        if isinstance(self.length, RecordedColumns):
            yield ("length",), self.length

    def build(self, where: BuildContext) -> Spring:
        extension, tension = np.array([0.0, 1.0]), np.array([0.0, self.stiffness or 0.0])
        if self.curve is not None:
            extension, tension = np.array(self.curve.extension), np.array(self.curve.tension)
        length: Any = self.length
        if not isinstance(length, float):
            length, _ = length_signal(length, f"{where.key}.length", where.path)
        return Spring(
            self.body,
            point=self.point,
            anchor=self.anchor,
            length=length,
            extension=extension,
            tension=tension,
            damping=self.damping,
            anchor_body=self.anchor_body,
            capacity=self.capacity,
        )


# `bushing` in a case file.


class Bushing(Element):
    """A spring and damper in all six directions, between a body and another one or the earth."""

    example: ClassVar[dict[str, Any]] = {
        "type": "bushing",
        "body": "barge",
        "to": "topside",
        "point": ["0.4 m", "-0.3 m", "0.8 m"],
        "stiffness": {"surge": "40 kN/m", "heave": "60 kN/m", "pitch": "20 kN*m/rad"},
        "damping": {"surge": "2 kN*s/m", "yaw": "1 kN*m*s/rad"},
    }

    type: Literal["bushing"]
    """A spring and damper in six directions."""
    to: StrictStr | None = None
    """Other body. Without it the other side is the earth. Example: topside."""
    point: of.Point = (0.0, 0.0, 0.0)
    """Place of the bushing in the body frame, with both bodies at their places at rest."""
    stiffness: of.StiffnessMatrix | None = None
    """Stiffness: per direction, or a 6 x 6 matrix, along the axes of the body at rest, which move
    with the other side."""
    damping: of.DampingMatrix | None = None
    """Damping: per direction, or a 6 x 6 matrix, along the same axes."""

    @model_validator(mode="after")
    def _check_law(self) -> Self:
        if not self.keys_with_value("stiffness", "damping"):
            raise problem("nothing that acts", "stiffness, damping, or both")
        return self

    def body_references(self) -> Iterator[tuple[Keys, str | None, str]]:
        yield ("to",), self.to, "without to the other side is the earth"

    def build(self, where: BuildContext) -> BuiltBushing:
        from hydrosim.elements.bushing import Bushing as BuiltBushing  # loads numba

        stiffness, damping = (
            np.zeros((6, 6)) if given is None else as_matrix(given)
            for given in (self.stiffness, self.damping)
        )
        return BuiltBushing(self.body, self.point, stiffness, damping, self.to)


# `strut` and `power_take_off` in a case file.


class StrutCurve(SchemaModel):
    """Force of a strut over its extension; straight lines, the outer ones continued."""

    extension: of.Extensions
    """Extensions that rise, beyond the length."""
    force: tuple[of.Force, ...]
    """Force at each extension: tension above 0, compression below."""

    @model_validator(mode="after")
    def _check_curve(self) -> Self:
        check_points("extension", self.extension, "force", self.force)
        return self


class StrutEntry(Element):
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

    type: Literal["strut", "power_take_off"]
    """A spring and damper along a line, which pushes and pulls. A power_take_off is the same with
    its absorbed power recorded."""
    point: of.Point
    """End on the body, in the body frame."""
    anchor: of.Point
    """Other end, in the earth frame or the frame of anchor_body."""
    anchor_body: StrictStr | None = None
    """Body that the anchor is fixed to. Without it the anchor is fixed to the earth. Example:
    topside."""
    length: of.LineLength | None = None
    """Length at which the spring has no force. Without it, the length at rest."""
    stiffness: of.EitherStiffness | None = None
    """Force per extension, in tension and in compression. It may be 0 or negative."""
    curve: StrutCurve | None = None
    """Force over extension, in place of stiffness."""
    damping: of.Damping = 0.0
    """Linear damping along the line."""
    quadratic_damping: of.Drag = 0.0
    """Damping along the line by the square of the speed."""
    capacity: of.ReferenceForce | None = None
    """Allowable force of both signs, which statistics compare with."""

    @model_validator(mode="after")
    def _check_law(self) -> Self:
        check_law(self)
        return self

    def body_references(self) -> Iterator[tuple[Keys, str | None, str]]:
        remedy = "an anchor without anchor_body is fixed to the earth"
        yield ("anchor_body",), self.anchor_body, remedy

    def build(self, where: BuildContext) -> Strut:
        points = None if self.curve is None else (self.curve.extension, self.curve.force)
        return Strut(
            self.body,
            *points_of(self.stiffness, points),
            self.damping,
            self.quadratic_damping,
            self.type == "power_take_off",
            point=self.point,
            anchor=self.anchor,
            length=self.length,
            anchor_body=self.anchor_body,
            capacity=self.capacity,
        )


def check_points(x: str, at: Sequence[float], y: str, values: Sequence[float]) -> None:
    """Raises a problem if ``at`` and ``values`` of the keys ``x`` and ``y`` are no curve."""
    if len(at) != len(values):
        found_text = f"{len(at)} values in {x} and {len(values)} in {y}"
        raise problem(found_text, f"a {y} for each {x}")
    if len(at) < 2:
        raise problem(f"{len(at)} points", "two or more")


def check_law(element: Any) -> None:
    """Raises a problem if an element has two springs, or nothing that acts."""
    given = element.keys_with_value("stiffness", "curve")
    if len(given) == 2:
        raise problem("stiffness and curve", "one of them", "remove one")
    damped = element.damping or element.quadratic_damping
    if not (damped or element.stiffness or element.curve):
        expected = "stiffness, curve, damping or quadratic_damping above 0"
        raise problem("nothing that acts", expected)


def points_of(
    stiffness: float | None, points: tuple[Sequence[float], Sequence[float]] | None
) -> tuple[np.ndarray, np.ndarray]:
    """The points of a curve, or of a straight line; none if there is no spring."""
    if points is not None:
        return np.array(points[0]), np.array(points[1])
    if not stiffness:
        return np.zeros(0), np.zeros(0)
    return np.array([0.0, 1.0]), np.array([0.0, stiffness])


# `torsion_spring` and `rotary_power_take_off` in a case file.


class TorsionCurve(SchemaModel):
    """Moment of a torsion spring over its angle; straight lines, the outer ones continued."""

    angle: of.Angles
    """Angles that rise, beyond the neutral one."""
    moment: tuple[of.Moment, ...]
    """Moment against the twist at each angle."""

    @model_validator(mode="after")
    def _check_curve(self) -> Self:
        check_points("angle", self.angle, "moment", self.moment)
        return self


class TorsionSpringEntry(Element):
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

    type: Literal["torsion_spring", "rotary_power_take_off"]
    """A spring and damper about an axis. A rotary_power_take_off is the same with its absorbed
    power recorded."""
    to: StrictStr | None = None
    """Other body. Without it the other side is the earth. Example: topside."""
    axis: of.Direction
    """Direction of the axis, in the body frame. Example: [0, 1, 0]."""
    neutral: of.Angle = 0.0
    """Angle at which the spring has no moment. The angle is 0 at rest."""
    stiffness: of.EitherTurnStiffness | None = None
    """Moment per angle. It may be 0 or negative."""
    curve: TorsionCurve | None = None
    """Moment over angle, in place of stiffness."""
    damping: of.TurnDamping = 0.0
    """Linear damping about the axis."""
    quadratic_damping: of.TurnDrag = 0.0
    """Damping about the axis by the square of the rate."""

    @model_validator(mode="after")
    def _check_law(self) -> Self:
        if not any(self.axis):
            raise problem("an axis of no length", "a direction, such as [0, 1, 0]")
        check_law(self)
        return self

    def body_references(self) -> Iterator[tuple[Keys, str | None, str]]:
        yield ("to",), self.to, "without to the other side is the earth"

    def build(self, where: BuildContext) -> TorsionSpring:
        points = None if self.curve is None else (self.curve.angle, self.curve.moment)
        return TorsionSpring(
            self.body,
            *points_of(self.stiffness, points),
            self.damping,
            self.quadratic_damping,
            self.type == "rotary_power_take_off",
            axis=self.axis,
            neutral=self.neutral,
            to=self.to,
        )
