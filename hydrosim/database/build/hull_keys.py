"""Keys of a recipe for its hulls and for the water."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Discriminator, Field, StrictStr, Tag, model_validator

from hydrosim.database.build import barge
from hydrosim.documents import quantities as of
from hydrosim.documents.mesh_keys import MeshKeys
from hydrosim.documents.quantities import SchemaModel
from hydrosim.documents.units import Quantity, problem

Size = Annotated[float, Quantity("length", "m", "12.4 m", above=0)]
Stiffness = Annotated[float, Quantity("stiffness", "N/m", "132105 kN/m", above=0)]
Count = Annotated[int, Field(strict=True, ge=1, le=1000)]
DEFAULT_PANELS = 1000  # number of panels of default size that would cover the wetted hull


class RecipeWater(SchemaModel):
    """Density, gravity and depth."""

    density: of.Density = 1025.0
    """Density of the water."""
    gravity: of.Gravity = 9.81
    """Acceleration of gravity."""
    depth: of.Depth = math.inf
    """Depth of the water, or infinite."""


class Counts(SchemaModel):
    """Numbers of panels."""

    along: tuple[Count, Count, Count, Count, Count]
    """Panels along each of the five parts of the hull's length. Example: [10, 10, 28, 20, 10]."""
    across: Count
    """Panels across half of the beam. Example: 8."""
    down: Count
    """Panels down the side. Example: 10."""
    wall_across: Count
    """Panels across half of the end walls. Example: 10."""
    wall_down: Count
    """Panels down the end walls. Example: 4."""
    lid_along: tuple[Count, Count, Count]
    """Panels of the lid along each of three parts of the length. Example: [13, 32, 28]."""
    lid_across: Count
    """Panels of the lid across half of the beam. Example: 9."""

    def resolution(self) -> barge.Resolution:
        """Resolution for the panels of a barge."""
        return barge.Resolution(**dict(self))


PanelsOf = Annotated[
    Annotated[Counts, Tag("counts")] | Annotated[Size, Tag("size")],
    Discriminator(lambda value: "counts" if isinstance(value, dict) else "size"),
]


class BargeHull(SchemaModel):
    """A launch barge; ``stern_length`` or the heave stiffness gives the length of full beam. Its
    frame has the origin at the stern, on the waterline."""

    type: Literal["barge"]
    """A launch barge."""
    length: Size
    """Length over all."""
    beam: Size
    """Beam at the stern part."""
    draught: Size
    """Draught from keel to waterline."""
    bow_beam: Size
    """Beam at the bow."""
    bow_length: Size
    """Length of the part with the bow's beam."""
    stern_length: Size | None = None
    """Length of the part with the full beam."""
    heave_stiffness: Stiffness | None = None
    """Heave stiffness; stern_length is computed from it."""
    wall_depth: Size
    """Depth of the vertical end walls below the waterline."""
    rake_length: Size
    """Length of the rakes below the end walls."""
    panels: PanelsOf | None = None
    """Largest size of panels, or their numbers."""

    @model_validator(mode="after")
    def _check_stern(self) -> Self:
        given = self.keys_with_value("stern_length", "heave_stiffness")
        if len(given) != 1:
            raise problem(" and ".join(given) or "none", "stern_length or heave_stiffness")
        if self.wall_depth > self.draught:
            raise problem(f"a wall_depth of {self.wall_depth:g} m", "the draught at most")
        return self

    def shape(self, water: RecipeWater) -> barge.Barge:
        """The barge afloat in ``water``."""
        taper = (self.beam + self.bow_beam) / 2
        stern = self.stern_length
        if stern is None:
            area = float(self.heave_stiffness or 0.0) / (water.density * water.gravity)
            rest = area - self.bow_beam * self.bow_length - taper * (self.length - self.bow_length)
            stern = rest / (self.beam - taper) if self.beam > taper else -1.0
        names = ("length", "beam", "draught", "bow_beam", "bow_length", "wall_depth", "rake_length")
        return barge.Barge(stern_length=stern, **{name: getattr(self, name) for name in names})


class BoxHull(SchemaModel):
    """A rectangular box."""

    type: Literal["box"]
    """A rectangular box."""
    length: Size
    """Length."""
    beam: Size
    """Beam."""
    draught: Size
    """Draught from keel to waterline."""
    panels: PanelsOf | None = None
    """Largest size of panels, or their numbers."""

    def shape(self, _: RecipeWater) -> barge.Barge:
        """The box as a barge."""
        return barge.box(self.length, self.beam, self.draught)


class SphereHull(SchemaModel):
    """A sphere with its centre on the waterline."""

    type: Literal["sphere"]
    """A sphere with its centre on the waterline."""
    radius: Size
    """Radius."""
    panels: Size | None = None
    """Largest size of panels."""

    def size(self) -> float:
        """Largest size of the panels [m]."""
        return self.panels or math.sqrt(2 * math.pi * self.radius**2 / DEFAULT_PANELS)


class MeshFileHull(MeshKeys):
    """A hull from a file beside the recipe."""

    type: Literal["mesh"]
    """A hull from a file."""
    file: StrictStr
    """Mesh file, relative to the recipe. Example: hull.stl."""


AnyHull = Annotated[BargeHull | BoxHull | SphereHull | MeshFileHull, Discriminator("type")]


def resolution(hull: BargeHull | BoxHull, shape: barge.Barge) -> barge.Resolution:
    """Panels of a barge or a box: the given numbers, the given size, or the default."""
    if isinstance(hull.panels, Counts):
        return hull.panels.resolution()
    around = 2 * (shape.length + shape.beam) * shape.draught
    usual = math.sqrt((shape.length * shape.beam + around) / DEFAULT_PANELS)
    return barge.resolution(shape, hull.panels or usual)


def check_hull(hull: AnyHull, water: RecipeWater) -> None:
    """Refuse a barge whose corners are in the wrong order."""
    if isinstance(hull, BargeHull | BoxHull):
        _check_corners(hull.shape(water))


def _check_corners(shape: barge.Barge) -> None:
    corners = shape.corners()
    ends = [0.0, shape.stern_length, shape.length - shape.bow_length, shape.length]
    spans = [b - a for a, b in [*pairwise(corners), *pairwise(ends)]]
    if len(corners) != 6 or corners[0] != 0.0 or min(spans) <= 1e-6 * shape.length:
        found = ", ".join(f"{x:g}" for x in corners)
        raise problem(
            f"corners of the hull at {found} m from the stern",
            "six different positions: both ends, both rakes, both ends of the taper",
            "correct stern_length (or heave_stiffness), bow_length or rake_length",
        )
