"""Recipes of databases: YAML files with units that give hulls, water and method; their hulls."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Generic, Literal, Self, TypeVar

import numpy as np
from pydantic import AfterValidator, Discriminator, Field, StrictStr, Tag, model_validator

from hydrosim.database.build import barge
from hydrosim.database.build.barge import Barge, hydrostatics, patch
from hydrosim.database.build.drift import DIRECTION_STEP, Drifting, Real
from hydrosim.database.hull import close_hull, read_closed, triangles_of
from hydrosim.dofs import about_z
from hydrosim.errors import InputError
from hydrosim.files import quantities as of
from hydrosim.files.key_rules import exactly_one
from hydrosim.files.layers import apply_setting, read_case, yaml_text
from hydrosim.files.messages import Problem, validate_document
from hydrosim.files.quantities import MeshKeys, SchemaModel
from hydrosim.files.units import Quantity, problem
from hydrosim.files.yaml_nodes import entry_nodes
from hydrosim.scene import Hull

# Keys of a recipe for its hulls and for the water.

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

    key_rules = (
        exactly_one("stern_length", "heave_stiffness", expected="stern_length or heave_stiffness"),
    )

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
        corners_text = ", ".join(f"{x:g}" for x in corners)
        raise problem(
            f"corners of the hull at {corners_text} m from the stern",
            "six different positions: both ends, both rakes, both ends of the taper",
            "correct stern_length (or heave_stiffness), bow_length or rake_length",
        )


MAX_STEPS = 1000  # frequencies or headings

Frequency = Annotated[float, Quantity("wave frequency", "rad/s", "0.1 rad/s", above=0)]
Share = Annotated[float, Quantity("share", "", "50 %", above=0, at_most=1)]
Coarser = Annotated[float, Quantity("part of the panels", "", "0.6", above=0, at_most=0.9)]
StepValue = TypeVar("StepValue")


class Lid(StrEnum):
    """Panels on the waterplane inside the hull, which remove irregular frequencies."""

    AUTO = "auto"
    NONE = "none"


class HullSymmetry(StrEnum):
    """Whether one half is computed if the hull is symmetric about y = 0."""

    AUTO = "auto"
    NONE = "none"


class IntegralEquation(StrEnum):
    """Integral equation for the pressures: for sources on the panels (indirect), or for the
    potential (direct), which needs fewer panels on smooth hulls."""

    INDIRECT = "indirect"
    DIRECT = "direct"


class Steps(SchemaModel, Generic[StepValue]):
    """Values from start to stop."""

    start: StepValue
    """First value."""
    stop: StepValue
    """Last value."""
    step: StepValue
    """Difference between values."""

    def values(self) -> tuple[float, ...]:
        """All values, rounded so that 0.06 is 0.06."""
        start, stop, step = (float(x) for x in (self.start, self.stop, self.step))  # type: ignore[arg-type]
        steps = (stop - start) / step if step else -1.0
        if not -1e-9 <= steps < MAX_STEPS or abs(steps - round(steps)) > 1e-6:
            range_text = f"start {start:g}, stop {stop:g}, step {step:g}"
            if steps > 0.0:
                range_text += f", which are {steps:.6g} steps"
            expected = f"a whole number of steps from start to stop, at most {MAX_STEPS - 1}"
            raise problem(range_text, expected)
        return tuple(np.linspace(start, stop, round(steps) + 1).round(15).tolist())


def _form_of_steps(value: object) -> str:
    return "steps" if isinstance(value, dict) else "list"


def _values(given: Any) -> tuple[float, ...]:
    """All values of steps, or of a list that may contain steps."""
    if isinstance(given, Steps):
        return given.values()
    parts = [entry.values() if isinstance(entry, Steps) else (entry,) for entry in given]
    return tuple(value for part in parts for value in part)


def _on_grid(headings: tuple[float, ...]) -> tuple[float, ...]:
    for heading in headings:
        off = heading / DIRECTION_STEP - round(heading / DIRECTION_STEP)
        if abs(off) > 1e-6 or abs(heading) > 2 * math.pi + 1e-9:
            heading_text = f"a heading of {math.degrees(heading):g} deg"
            raise problem(heading_text, "multiples of half a degree, at most one turn")
    return headings


_Entry = Annotated[
    Annotated[Steps[Frequency], Tag("steps")] | Annotated[Frequency, Tag("list")],
    Discriminator(_form_of_steps),
]
Frequencies = Annotated[
    Annotated[Steps[Frequency], Tag("steps")] | Annotated[tuple[_Entry, ...], Tag("list")],
    Discriminator(_form_of_steps),
    AfterValidator(_values),
    AfterValidator(of.require_entries),
    of.RISING,
]
Headings = Annotated[
    Annotated[Steps[of.Angle], Tag("steps")] | Annotated[tuple[of.Angle, ...], Tag("list")],
    Discriminator(_form_of_steps),
    AfterValidator(_values),
    AfterValidator(of.require_entries),
    of.RISING,
    AfterValidator(_on_grid),
]


class DifferenceQtf(SchemaModel):
    """Difference-frequency QTFs of waves with the same heading, for the free body."""

    frequencies: Frequencies
    """Frequencies of the pairs of waves."""
    headings: Headings
    """Headings of the waves, among those of the recipe."""


class FarField(SchemaModel):
    """How much of the loads is from the waves that motions make far away: none up to the first
    frequency of ``rising``, the ``share`` from the second on."""

    share: Share
    """Fraction of the loads that comes from the far field, above the second frequency of rising."""
    rising: tuple[Frequency, Frequency]
    """Frequencies between which the share rises from 0. Example: [1 rad/s, 1.5 rad/s]."""


class RecipeBody(SchemaModel):
    """A body: its hull, position and mass properties. The centre of gravity is in the hull's own
    frame. ``position`` and ``heading`` place this frame in the database's frame."""

    key_rules = (
        exactly_one("radii_of_gyration", "inertia", expected="radii_of_gyration or inertia"),
    )

    hull: AnyHull
    """Shape of the hull."""
    position: of.Position = (0.0, 0.0)
    """Position x, y of the hull's frame in the frame of the database. Example: [0 m, 0 m]."""
    heading: of.Angle = 0.0
    """Direction of the hull's x axis in the frame of the database."""
    centre_of_gravity: of.Point
    """Centre of gravity in the hull's frame."""
    radii_of_gyration: of.Radii | None = None
    """Radii of gyration about the centre of gravity for roll, pitch and yaw."""
    inertia: of.InertiaMatrix | None = None
    """Moments of inertia about the centre of gravity: three by name, or a 3 x 3 matrix."""


class CommonKeys(SchemaModel):
    """Keys common to recipes of one and of several bodies, in SI and radians."""

    title: StrictStr
    """Title of the database, for people. Example: Barge at a draught of 6 m."""
    water: RecipeWater = RecipeWater()
    """Water that the hull floats in."""
    frequencies: Frequencies
    """Wave frequencies: steps, or a list of values and steps."""
    headings: Headings
    """Directions that waves go to: steps, or a list. They are multiples of half a degree."""
    lid: Lid = Lid.AUTO
    """Whether panels on the inner waterplane remove irregular frequencies."""
    symmetry: HullSymmetry = HullSymmetry.AUTO
    """Whether half of a symmetric hull is computed."""
    method: IntegralEquation = IntegralEquation.INDIRECT
    """Integral equation that is solved."""
    far_field: FarField | None = None
    """Use of the far field for loads at high frequencies."""
    attributes: dict[str, StrictStr] = {}  # noqa: RUF012  pydantic copies it
    """Further texts by name, stored in the database. Example: {project: Crane barge}."""

    @model_validator(mode="before")
    @classmethod
    def _check_kind(cls, data: Any) -> Any:
        other = {"duration": "a case", "case": "a study"}
        key = next((key for key in other if isinstance(data, dict) and key in data), None)
        if key is not None:
            raise problem(f"{other[key]}, with the key {key}", "a recipe of a database")
        return data

    @model_validator(mode="after")
    def _check_far_field(self) -> Self:
        if self.far_field is not None:
            headings = np.array(self.headings)
            turn = np.diff(headings, append=headings[0] + 2 * math.pi)
            if np.ptp(turn) > 1e-6:
                raise problem("far_field", "headings all round the circle, evenly spaced")
            if math.isfinite(self.water.depth):
                raise problem(f"far_field in {self.water.depth:g} m of water", "deep water")
        return self


class SeveralBodies(CommonKeys):
    """Recipe of several bodies with hydrodynamic interaction: by name, in the order of the
    database."""

    bodies: Annotated[dict[str, RecipeBody], AfterValidator(of.require_entries)]
    """Bodies by name, in the order of the database."""
    drift: tuple[Drifting, ...] = ()
    """Mean drift loads to compute: of free bodies, held bodies, or both."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.drift and (
            math.isfinite(self.water.depth) or self.method is IntegralEquation.DIRECT
        ):
            choice_text = "drift of several bodies in shallow water, or with method: direct"
            raise problem(choice_text, "deep water and method: indirect", "remove drift")
        for part in self.bodies.values():
            check_hull(part.hull, self.water)
        return self

    @property
    def parts(self) -> tuple[RecipeBody, ...]:
        """The bodies."""
        return tuple(self.bodies.values())


class OneBody(RecipeBody, CommonKeys):
    """The recipe of one body."""

    drift: tuple[Drifting, ...] = tuple(Drifting)
    """Mean drift loads to compute: of the free body, the held body, or both."""
    qtf: DifferenceQtf | None = None
    """Difference-frequency QTFs to compute."""
    extrapolate: Coarser | None = None
    """Fraction of the number of panels for a second, coarser mesh. Results are extrapolated from
    both."""

    @property
    def parts(self) -> tuple[RecipeBody, ...]:
        """The body."""
        return (self,)

    @model_validator(mode="after")
    def _check(self) -> Self:
        check_hull(self.hull, self.water)
        if self.qtf is not None:
            self._check_qtf(self.qtf)
        if self.extrapolate is not None and isinstance(self.hull, MeshFileHull):
            raise problem("extrapolate with a mesh", "a barge, a box or a sphere")
        return self

    def _check_qtf(self, qtf: DifferenceQtf) -> None:
        """Check the QTF: it is valid in deep water, and its diagonal is the drift of the free
        body."""
        if math.isfinite(self.water.depth):
            raise problem(f"qtf in {self.water.depth:g} m of water", "deep water", "remove qtf")
        if Drifting.FREE not in self.drift:
            raise problem("qtf without the drift of the body floating free", "drift: [free]")
        if self.method is IntegralEquation.DIRECT:
            raise problem("qtf with method: direct", "method: indirect", "its flow is of sources")
        for heading in np.array(qtf.headings):
            if np.abs(np.array(self.headings) - heading).min() > 1e-9:
                raise problem(f"qtf for {math.degrees(heading):g} deg", "one of `headings`")
        (lowest, highest), (first, last) = _ends(self.frequencies), _ends(qtf.frequencies)
        if first < lowest or last > highest:
            range_text = f"qtf from {first:g} to {last:g} rad/s"
            raise problem(
                range_text, f"`frequencies` around them, not {lowest:g} to {highest:g} rad/s"
            )


def _ends(values: Frequencies) -> tuple[float, float]:
    first, last = np.array(values)[[0, -1]]
    return float(first), float(last)


@dataclass(frozen=True)
class Recipe:
    """A validated recipe: the file's ``path``, its ``text`` and its ``data``."""

    path: Path
    text: str
    data: OneBody | SeveralBodies

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
        """Number of frequencies to solve; those of QTFs, of fewer panels and of drifts count
        again."""
        count = self.frequencies.size
        if isinstance(self.data, SeveralBodies):
            return count * (1 + len(self.data.drift))
        qtf = self.data.qtf
        more = 0 if qtf is None else np.array(qtf.frequencies).size
        return more + count * (1 if self.data.extrapolate is None else 2)


def load_recipe(path: Path | str, settings: Sequence[str] = ()) -> Recipe:
    """Read the recipe in the YAML file ``path``; ``settings`` KEY=VALUE override it. Raises
    `InputError` with a line for each problem.

    The key `extends` names another recipe that this one overrides, as in case files.
    """
    path = Path(path)
    text, document = read_case(path)
    for setting in settings:
        document = apply_setting(document, setting)
    text = yaml_text(document) if settings else text
    further = partial(_without_file, path.parent)
    if "bodies" in entry_nodes(document):
        return Recipe(path, text, validate_document(document, SeveralBodies, further))
    return Recipe(path, text, validate_document(document, OneBody, further))


def _without_file(folder: Path, data: OneBody | SeveralBodies) -> Iterator[Problem]:
    """Refuse hulls whose mesh file does not exist."""
    for k, part in enumerate(data.parts):
        if isinstance(part.hull, MeshFileHull) and not (folder / part.hull.file).is_file():
            above = ("bodies", [*data.bodies][k]) if isinstance(data, SeveralBodies) else ()
            text = f"found no such file at {folder / part.hull.file}; expected a mesh of the hull"
            yield Problem((*above, "hull", "file"), text)


# Hulls of a recipe, closed by a deck.


def hull_of_recipe(path: Path, body: int = 1, depth: float | None = None) -> Hull:
    """Hull of a ``body`` of a recipe, in the database's frame. The sides of barges and boxes extend
    to a flat deck ``depth`` [m] above the keel. Raises `InputError` if that is not possible.
    """
    return close_hull(shape_of_recipe(path, body, depth), str(path))


def shape_of_recipe(path: Path, body: int = 1, depth: float | None = None) -> np.ndarray:
    """Triangles (nt, 3, 3) of the same hull, which may be submerged."""
    recipe = load_recipe(path)
    if body > len(recipe.data.parts):
        raise InputError(f"{path}: has {len(recipe.data.parts)} bodies; expected body {body}.")
    part = recipe.data.parts[body - 1]
    hull = part.hull
    if isinstance(hull, SphereHull) or isinstance(hull, MeshFileHull) == (depth is not None):
        raise InputError(
            f"{path}: its hull is a {hull.type}, and depth is {depth}; expected a barge or a box"
            " with a depth (keel to deck), or a mesh without one. Give a file as mesh instead."
        )
    if isinstance(hull, MeshFileHull):
        corners = read_closed(path.parent / hull.file, hull)
    else:
        corners = barge_with_deck(hull.shape(recipe.data.water), float(depth or 0.0))
    return np.asarray(corners @ about_z(part.heading).T + [*part.position, 0.0])


def barge_with_deck(hull: Barge, depth: float) -> np.ndarray:
    """Triangles (n, 3, 3) of a barge, with the origin above its centre of buoyancy as in its
    database."""
    x = np.array(hull.corners())
    side = hull.half_breadth(x)[:, None] * [-1.0, 1.0]
    low, high = hull.bottom(x)[:, None], np.full((x.size, 1), depth - hull.draught)
    starboard, port = side[:, :1], side[:, 1:]
    x = x[:, None] - hydrostatics(hull).centre_of_buoyancy[0]
    rising = np.hstack([low, high])
    faces = [
        patch(x, side, low)[:, ::-1],
        patch(x, side, high),
        patch(x, starboard, rising),
        patch(x, port, rising)[:, ::-1],
        patch(x[0], side[0][:, None], rising[0])[:, ::-1],
        patch(x[-1], side[-1][:, None], rising[-1]),
    ]
    return triangles_of(np.concatenate(faces))
