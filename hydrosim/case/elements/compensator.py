"""`compensator` in a case file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

from pydantic import StrictStr, model_validator

from hydrosim.case.elements.element import BuildContext, Element
from hydrosim.documents import quantities as of
from hydrosim.documents.messages import Keys
from hydrosim.documents.units import problem

if TYPE_CHECKING:
    from hydrosim.forces.line.compensator import Compensator as Built


class Compensator(Element):
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

    type: Literal["compensator"]
    """A gas spring in a line, with end stops. It carries no push."""
    point: of.Point
    """End on the body, in the body frame."""
    anchor: of.Point
    """Other end, in the earth frame or the frame of anchor_body."""
    anchor_body: StrictStr | None = None
    """Body that the anchor is fixed to. Without it the anchor is fixed to the earth. Example:
    topside."""
    length: of.LineLength
    """Length of the whole line in the middle of the stroke."""
    tension: of.ReferenceForce
    """Tension in the middle of the stroke."""
    stroke: of.LineLength
    """Stroke, half of it to each side."""
    gas_length: of.LineLength
    """Volume of the gas over the area of the piston, in the middle of the stroke."""
    exponent: of.GasExponent = 1.0
    """Exponent n of p V^n = const: 1 for slow motion, about 1.4 for fast motion."""
    stiffness: of.Stiffness
    """Stiffness of line and stop beyond the stroke."""
    damping: of.Damping = 0.0
    """Damping along the line."""
    capacity: of.ReferenceForce | None = None
    """Allowable tension, which statistics compare with."""

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

    def body_references(self) -> Iterator[tuple[Keys, str | None, str]]:
        remedy = "an anchor without anchor_body is fixed to the earth"
        yield ("anchor_body",), self.anchor_body, remedy

    def build(self, where: BuildContext) -> Built:
        from hydrosim.forces.line.compensator import Compensator as Built  # loads numba

        return Built(
            self.body,
            point=self.point,
            anchor=self.anchor,
            length=self.length,
            tension=self.tension,
            stroke=self.stroke,
            gas_length=self.gas_length,
            exponent=self.exponent,
            stiffness=self.stiffness,
            damping=self.damping,
            anchor_body=self.anchor_body,
            capacity=self.capacity,
        )
