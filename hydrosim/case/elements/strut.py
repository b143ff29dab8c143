"""`strut` and `power_take_off` in a case file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import StrictStr, model_validator

from hydrosim.case.elements.element import BuildContext, Element
from hydrosim.documents import quantities as of
from hydrosim.documents.messages import Keys
from hydrosim.documents.quantities import SchemaModel
from hydrosim.documents.units import problem

if TYPE_CHECKING:
    from hydrosim.forces.link import Strut as Built


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


class Strut(Element):
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

    def build(self, where: BuildContext) -> Built:
        from hydrosim.forces.link import Strut as Built  # loads numba

        points = None if self.curve is None else (self.curve.extension, self.curve.force)
        return Built(
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
