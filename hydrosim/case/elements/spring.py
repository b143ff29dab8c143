"""`spring` in a case file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import StrictStr, model_validator

from hydrosim.case.elements.breaking import Breaking
from hydrosim.case.elements.element import BuildContext
from hydrosim.case.elements.paid import LengthOverTime, length_signal
from hydrosim.case.signals import Recorded
from hydrosim.documents import quantities as of
from hydrosim.documents.messages import Keys
from hydrosim.documents.quantities import SchemaModel
from hydrosim.documents.units import problem

if TYPE_CHECKING:
    from hydrosim.forces.spring import Spring as Built


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


class Spring(Breaking):
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

    def recorded_series(self) -> Iterator[tuple[Keys, Recorded]]:
        if isinstance(self.length, Recorded):
            yield ("length",), self.length

    def build(self, where: BuildContext) -> Built:
        from hydrosim.forces.spring import Spring as Built  # loads numba

        extension, tension = np.array([0.0, 1.0]), np.array([0.0, self.stiffness or 0.0])
        if self.curve is not None:
            extension, tension = np.array(self.curve.extension), np.array(self.curve.tension)
        length: Any = self.length
        if not isinstance(length, float):
            length, _ = length_signal(length, f"{where.key}.length", where.path)
        return Built(
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
