"""`torsion_spring` and `rotary_power_take_off` in a case file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

from pydantic import StrictStr, model_validator

from hydrosim.case.elements.element import BuildContext, Element
from hydrosim.case.elements.strut import check_law, check_points, points_of
from hydrosim.documents import quantities as of
from hydrosim.documents.messages import Keys
from hydrosim.documents.quantities import SchemaModel
from hydrosim.documents.units import problem

if TYPE_CHECKING:
    from hydrosim.forces.link import TorsionSpring as Built


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


class TorsionSpring(Element):
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

    def build(self, where: BuildContext) -> Built:
        from hydrosim.forces.link import TorsionSpring as Built  # loads numba

        points = None if self.curve is None else (self.curve.angle, self.curve.moment)
        return Built(
            self.body,
            *points_of(self.stiffness, points),
            self.damping,
            self.quadratic_damping,
            self.type == "rotary_power_take_off",
            axis=self.axis,
            neutral=self.neutral,
            to=self.to,
        )
