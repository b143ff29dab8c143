"""Recipes of databases: YAML files with units that say which hull to compute, where and how."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Generic, Literal, Self, TypeVar

import numpy as np
from pydantic import AfterValidator, Discriminator, Field, StrictStr, Tag, model_validator

from hydrosim.database.build import barge
from hydrosim.database.build.drift import STEP, Drifting, Real
from hydrosim.documents import quantities as of
from hydrosim.documents.layers import read_case
from hydrosim.documents.quantities import Strict
from hydrosim.documents.units import Quantity, problem
from hydrosim.documents.validate import validated

MOST = 1000  # frequencies or headings

Size = Annotated[float, Quantity("length", "m", "12.4 m", above=0)]
Scale = Annotated[float, Quantity("scale", "", "0.001", above=0)]
Frequency = Annotated[float, Quantity("wave frequency", "rad/s", "0.1 rad/s", above=0)]
Stiffness = Annotated[float, Quantity("stiffness", "N/m", "132105 kN/m", above=0)]
Count = Annotated[int, Field(strict=True, ge=1, le=1000)]
T = TypeVar("T")


class Lid(StrEnum):
    """Panels on the waterplane inside the hull, against irregular frequencies."""

    AUTO = "auto"
    NONE = "none"


class Symmetry(StrEnum):
    """Whether half of the hull is computed, where it is its own mirror image in y = 0."""

    AUTO = "auto"
    NONE = "none"


class Method(StrEnum):
    """The integral equation that pressures are from: for sources on the panels (indirect), or for
    the potential (direct), which needs fewer panels where the hull is smooth."""

    INDIRECT = "indirect"
    DIRECT = "direct"


class Steps(Strict, Generic[T]):
    """Values from start to stop."""

    start: T
    stop: T
    step: T

    def values(self) -> tuple[float, ...]:
        """All values; rounded, so that 0.06 is 0.06."""
        start, stop, step = (float(x) for x in (self.start, self.stop, self.step))  # type: ignore[arg-type]
        steps = (stop - start) / step if step else -1.0
        if not -1e-9 <= steps < MOST or abs(steps - round(steps)) > 1e-6:
            found = f"start {start:g}, stop {stop:g}, step {step:g}"
            expected = f"0 to {MOST - 1} whole steps from start to stop"
            raise problem(found, expected)
        return tuple(np.linspace(start, stop, round(steps) + 1).round(15).tolist())


def _listed(value: Any) -> Any:
    return value.values() if isinstance(value, Steps) else value


def _form(value: object) -> str:
    return "steps" if isinstance(value, dict) else "list"


def _on_grid(headings: tuple[float, ...]) -> tuple[float, ...]:
    for heading in headings:
        off = heading / STEP - round(heading / STEP)
        if abs(off) > 1e-6 or abs(heading) > 2 * math.pi + 1e-9:
            found = f"a heading of {math.degrees(heading):g} deg"
            raise problem(found, "multiples of half a degree, at most one turn")
    return headings


Frequencies = Annotated[
    Annotated[Steps[Frequency], Tag("steps")] | Annotated[tuple[Frequency, ...], Tag("list")],
    Discriminator(_form),
    AfterValidator(_listed),
    AfterValidator(of.some),
    of.RISING,
]
Headings = Annotated[
    Annotated[Steps[of.Angle], Tag("steps")] | Annotated[tuple[of.Angle, ...], Tag("list")],
    Discriminator(_form),
    AfterValidator(_listed),
    AfterValidator(of.some),
    of.RISING,
    AfterValidator(_on_grid),
]


class Counts(Strict):
    """Numbers of panels, see `barge.Resolution`."""

    along: tuple[Count, Count, Count, Count, Count]
    across: Count
    down: Count
    wall_across: Count
    wall_down: Count
    lid_along: tuple[Count, Count, Count]
    lid_across: Count

    def resolution(self) -> barge.Resolution:
        """As the barge's panels need them."""
        return barge.Resolution(**dict(self))


PanelsOf = Annotated[
    Annotated[Counts, Tag("counts")] | Annotated[Size, Tag("size")],
    Discriminator(lambda value: "counts" if isinstance(value, dict) else "size"),
]


class BargeHull(Strict):
    """A launch barge; its full beam is as long as ``stern_length`` or the heave stiffness says."""

    type: Literal["barge"]
    length: Size
    beam: Size
    draught: Size
    bow_beam: Size
    bow_length: Size
    stern_length: Size | None = None
    heave_stiffness: Stiffness | None = None
    wall_depth: Size
    rake_length: Size
    panels: PanelsOf

    @model_validator(mode="after")
    def _check_stern(self) -> Self:
        given = self.given("stern_length", "heave_stiffness")
        if len(given) != 1:
            raise problem(" and ".join(given) or "none", "stern_length or heave_stiffness")
        if self.wall_depth > self.draught:
            raise problem(f"a wall_depth of {self.wall_depth:g} m", "the draught at most")
        return self

    def shape(self, water: Water) -> barge.Barge:
        """The barge afloat in ``water``."""
        taper = (self.beam + self.bow_beam) / 2
        stern = self.stern_length
        if stern is None:
            area = float(self.heave_stiffness or 0.0) / (water.density * water.gravity)
            rest = area - self.bow_beam * self.bow_length - taper * (self.length - self.bow_length)
            stern = rest / (self.beam - taper) if self.beam > taper else -1.0
        names = ("length", "beam", "draught", "bow_beam", "bow_length", "wall_depth", "rake_length")
        return barge.Barge(stern_length=stern, **{name: getattr(self, name) for name in names})


class BoxHull(Strict):
    """A rectangular box."""

    type: Literal["box"]
    length: Size
    beam: Size
    draught: Size
    panels: PanelsOf

    def shape(self, _: Water) -> barge.Barge:
        """The box as a barge."""
        return barge.box(self.length, self.beam, self.draught)


class SphereHull(Strict):
    """A sphere with its centre on the waterline."""

    type: Literal["sphere"]
    radius: Size
    panels: Size


class MeshHull(Strict):
    """A hull from a file beside the recipe, at ``waterline`` above the file's z = 0 (scaled)."""

    type: Literal["mesh"]
    file: StrictStr
    scale: Scale = 1.0
    waterline: of.Length = 0.0


class Water(Strict):
    """Density, gravity and depth."""

    density: of.Density = 1025.0
    gravity: of.Gravity = 9.81
    depth: of.Depth = math.inf


class DifferenceQtf(Strict):
    """Difference-frequency QTFs of waves to the same heading, for the body floating free."""

    frequencies: Frequencies
    headings: Headings


class RecipeFile(Strict):
    """All of a recipe, in SI and radians."""

    title: StrictStr
    hull: Annotated[BargeHull | BoxHull | SphereHull | MeshHull, Discriminator("type")]
    water: Water = Water()
    centre_of_gravity: of.Point
    radii_of_gyration: of.Vector[of.Radius] | None = None
    inertia: of.InertiaMatrix | None = None
    frequencies: Frequencies
    headings: Headings
    lid: Lid = Lid.AUTO
    symmetry: Symmetry = Symmetry.AUTO
    method: Method = Method.INDIRECT
    drift: tuple[Drifting, ...] = tuple(Drifting)
    qtf: DifferenceQtf | None = None
    attributes: dict[str, StrictStr] = {}  # noqa: RUF012  pydantic copies it

    @model_validator(mode="after")
    def _check(self) -> Self:
        given = self.given("radii_of_gyration", "inertia")
        if len(given) != 1:
            raise problem(" and ".join(given) or "none", "radii_of_gyration or inertia")
        if isinstance(self.hull, BargeHull | BoxHull):
            _check_corners(self.hull.shape(self.water))
        if self.qtf is not None:
            self._check_qtf(self.qtf)
        return self

    def _check_qtf(self, qtf: DifferenceQtf) -> None:
        """It holds in deep water, and its diagonal is the drift of the body floating free."""
        if math.isfinite(self.water.depth):
            raise problem(f"qtf in {self.water.depth:g} m of water", "deep water", "remove qtf")
        if Drifting.FREE not in self.drift:
            raise problem("qtf without the drift of the body floating free", "drift: [free]")
        if self.method is Method.DIRECT:
            raise problem("qtf with method: direct", "method: indirect", "its flow is of sources")
        for heading in np.array(qtf.headings):
            if np.abs(np.array(self.headings) - heading).min() > 1e-9:
                raise problem(f"qtf for {math.degrees(heading):g} deg", "one of `headings`")
        (lowest, highest), (first, last) = _ends(self.frequencies), _ends(qtf.frequencies)
        if first < lowest or last > highest:
            found = f"qtf from {first:g} to {last:g} rad/s"
            raise problem(found, f"`frequencies` around them, not {lowest:g} to {highest:g} rad/s")


def _ends(values: Frequencies) -> tuple[float, float]:
    first, last = np.array(values)[[0, -1]]
    return float(first), float(last)


def _check_corners(shape: barge.Barge) -> None:
    corners = shape.corners()
    ends = [0.0, shape.stern_length, shape.length - shape.bow_length, shape.length]
    spans = [b - a for a, b in [*pairwise(corners), *pairwise(ends)]]
    if len(corners) != 6 or corners[0] != 0.0 or min(spans) <= 1e-6 * shape.length:
        found = ", ".join(f"{x:g}" for x in corners)
        raise problem(
            f"corners of the hull at {found} m from the stern",
            "six in different places: both ends, both rakes, both ends of the taper",
            "mend stern_length (or heave_stiffness), bow_length or rake_length",
        )


@dataclass(frozen=True)
class Recipe:
    """A validated recipe: the file's ``path``, its whole ``text`` and its ``data``."""

    path: Path
    text: str
    data: RecipeFile

    @property
    def frequencies(self) -> Real:
        """All frequencies [rad/s]."""
        return np.array(self.data.frequencies)

    @property
    def headings(self) -> Real:
        """All headings [rad]."""
        return np.array(self.data.headings)

    @property
    def steps(self) -> int:
        """How many frequencies are solved, those of the QTF once more."""
        qtf = self.data.qtf
        return len(self.frequencies) + (0 if qtf is None else np.array(qtf.frequencies).size)


def load_recipe(path: Path | str) -> Recipe:
    """The recipe in the YAML file ``path``; raises `InputError` with a line for each problem.

    The key `extends` lays it over another recipe, as in case files.
    """
    path = Path(path)
    text, document = read_case(path)
    return Recipe(path, text, validated(document, RecipeFile))
