"""`current_load` and `wind_load` in a case file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from hydrosim.case.elements.element import BuildContext, Element
from hydrosim.documents import quantities as of
from hydrosim.documents.units import problem

if TYPE_CHECKING:
    from hydrosim import forces

TABLE: dict[str, Any] = {
    "headings": ["0 deg", "90 deg", "180 deg"],
    "surge": ["40 kN*s^2/m^2", 0, "-40 kN*s^2/m^2"],
    "sway": [0, "300 kN*s^2/m^2", 0],
    "yaw": [0, "2 MN*s^2/m", 0],
}


class StreamLoad(Element):
    """Load by coefficients over the heading of a stream: all round, or from 0 to 180 deg for a body
    that is its own mirror image."""

    point: of.Point = (0.0, 0.0, 0.0)
    """Point of attack in the body frame."""
    headings: of.Headings
    """Directions of the stream relative to the body, from 0 to 180 deg or all round."""
    surge: of.StreamForces | None = None
    """Surge force per squared speed at each heading."""
    sway: of.StreamForces | None = None
    """Sway force per squared speed at each heading."""
    yaw: of.StreamMoments | None = None
    """Yaw moment per squared speed at each heading."""

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        given = self.keys_with_value("surge", "sway", "yaw")
        if not given:
            raise problem("no coefficients", "those of one or more of surge, sway, yaw")
        for dof in given:
            if len(getattr(self, dof)) != len(self.headings):
                found_text = f"{len(getattr(self, dof))} values in {dof} and {len(self.headings)}"
                raise problem(f"{found_text} in headings", "a value for each heading")
        self._check_ends()
        return self

    def _check_ends(self) -> None:
        if not self.is_half:
            return
        for dof in self.keys_with_value("sway", "yaw"):
            first, *_, last = getattr(self, dof)
            if first or last:
                found_text = f"{first:g} at 0 and {last:g} at 180 deg in {dof}"
                expected = "0 at both, as for a body that is its own mirror image"
                raise problem(found_text, expected, "give the headings of the whole circle")

    @property
    def is_half(self) -> bool:
        """True if the headings are those of half a circle."""
        return self.headings[-1] <= np.pi * (1.0 + 1e-9)

    def all_round(self) -> tuple[np.ndarray, ...]:
        """Headings, and coefficients in surge, sway and yaw, of the whole circle."""
        headings = np.array(self.headings)
        zero = (0.0,) * headings.size
        values = [np.array(x or zero) for x in (self.surge, self.sway, self.yaw)]
        if not self.is_half:
            return headings, *values
        image = slice(-2, 0, -1)  # without 0 and 180 deg, which are their own
        mirrored = [sign * x[image] for sign, x in zip((1.0, -1.0, -1.0), values, strict=True)]
        both = [np.append(x, more) for x, more in zip(values, mirrored, strict=True)]
        return np.append(headings, 2.0 * np.pi - headings[image]), *both


class CurrentLoad(StreamLoad):
    """Load of the current."""

    example: ClassVar[dict[str, Any]] = {"type": "current_load", "body": "barge", **TABLE}
    stream: ClassVar[str | None] = "current"
    type: Literal["current_load"]
    """Load of the current by coefficients over its heading."""
    depth: tuple[of.Length, of.Length] | None = None
    """Depths, from top to bottom, between which the mean of a current with a profile acts. Without
    it, the draught of the body or the depth of the point. Example: [0 m, 8 m]."""

    @model_validator(mode="after")
    def _check_depth(self) -> Self:
        if self.depth is not None and not 0.0 <= self.depth[0] < self.depth[1]:
            top, bottom = self.depth
            raise problem(f"depths of {top:g} and {bottom:g} m", "0 or more, top above bottom")
        return self

    def build(self, where: BuildContext) -> forces.CurrentLoad:
        from hydrosim.forces.stream_load import CurrentLoad as Built  # loads numba

        return Built(self.body, self.point, *self.all_round(), depth=self.depth)


class WindLoad(StreamLoad):
    """Load of the wind."""

    example: ClassVar[dict[str, Any]] = {"type": "wind_load", "body": "barge", **TABLE}
    stream: ClassVar[str | None] = "wind"
    type: Literal["wind_load"]
    """Load of the wind by coefficients over its heading."""
    height: Annotated[float, of.Quantity("height", "m", "10 m", above=0)] | None = None
    """Height above the water of the wind that acts. Without it, that of the point at rest."""

    def build(self, where: BuildContext) -> forces.WindLoad:
        from hydrosim.forces.stream_load import WindLoad as Built  # loads numba

        return Built(self.body, self.point, *self.all_round(), height=self.height)
