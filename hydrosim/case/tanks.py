"""`lightship`, `tanks` and `pumps` of a body in a case file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Self

import numpy as np
from pydantic import AfterValidator, Discriminator, StrictStr, Tag, model_validator

from hydrosim import scene
from hydrosim.case.elements.active import Event
from hydrosim.case.hydrostatics import Depth, MeshHull, RecipeHull
from hydrosim.documents import quantities as of
from hydrosim.documents.mesh_keys import Axes, Scale
from hydrosim.documents.quantities import Strict
from hydrosim.documents.units import Quantity, problem
from hydrosim.errors import InputError
from hydrosim.scene import FreeSurface

SEA = "sea"
PLACING = ("scale", "axes", "offset", "waterline")  # keys of a mesh
Level = Annotated[float, Quantity("level", "m", "3 m", at_least=0)]
Volume = Annotated[float, Quantity("volume", "m^3", "100 m^3", at_least=0)]
AreaMoment = Annotated[float, Quantity("second moment of area", "m^4", "1000 m^4", at_least=0)]
MixedMoment = Annotated[float, Quantity("second moment of area", "m^4", "-1000 m^4")]
Part = Annotated[float, Quantity("number", "", "98 %", above=0, at_most=1)]
Rate = Annotated[float, Quantity("mass per time", "kg/s", "5000 tonne/hour", above=0)]
Levels = Annotated[tuple[Level, ...], of.RISING, AfterValidator(of.from_zero)]
Volumes = Annotated[tuple[Volume, ...], of.RISING, AfterValidator(of.from_zero)]


class Lightship(Strict):
    """The body without what is in its tanks; ``centre_of_gravity`` is in the database's frame."""

    mass: of.Mass
    centre_of_gravity: of.Point
    radii_of_gyration: of.Radii | None = None
    inertia: of.InertiaMatrix | None = None

    @model_validator(mode="after")
    def _check_inertia(self) -> Self:
        given = self.given("radii_of_gyration", "inertia")
        if len(given) != 1:
            found = " and ".join(given) or "neither radii_of_gyration nor inertia"
            raise problem(found, "one of radii_of_gyration, inertia")
        return self


class TankTable(Strict):
    """What a tank holds at each ``level`` above its bottom: ``volume`` of fluid, its ``centroid``
    in the database's frame, and second moments of its free surface about the surface's centroid."""

    level: Levels
    volume: Volumes
    centroid: tuple[of.Point, ...]
    longitudinal: tuple[AreaMoment, ...]
    transverse: tuple[AreaMoment, ...]
    mixed: tuple[MixedMoment, ...] | None = None

    @model_validator(mode="after")
    def _check_rows(self) -> Self:
        names = ("level", "volume", "centroid", "longitudinal", "transverse", "mixed")
        sizes = {name: len(x) for name in names if (x := getattr(self, name)) is not None}
        if len({*sizes.values()}) > 1:
            found = ", ".join(f"{size} of {name}" for name, size in sizes.items())
            raise problem(found, "as many of each: one a row")
        return self

    def build(self) -> scene.TankTable:
        """As a scene has it."""
        mixed = np.zeros(len(self.level)) if self.mixed is None else np.array(self.mixed)
        surface = np.column_stack([self.longitudinal, mixed, self.transverse])
        level, volume = np.array(self.level), np.array(self.volume)
        return scene.TankTable(level, volume, np.array(self.centroid), surface)


class Plan(Strict):
    """Levels at times; the flow between them is constant, from or to the sea."""

    time: of.Times
    level: tuple[Level, ...]

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        if len(self.time) != len(self.level) or len(self.time) < 2:
            found = f"{len(self.time)} times and {len(self.level)} levels"
            raise problem(found, "two times or more, and a level at each")
        return self


class Tank(Strict):
    """A tank: a ``box`` between two corners, a ``table``, a closed ``mesh`` in a file, or the hull
    of a ``recipe``, in the database's frame; the latter two with the keys that a hull has."""

    box: tuple[of.Point, of.Point] | None = None
    table: TankTable | None = None
    mesh: StrictStr | None = None
    scale: Scale | None = None
    axes: Axes | None = None
    offset: of.Point | None = None
    waterline: of.Length | None = None
    recipe: StrictStr | None = None
    depth: Depth | None = None
    permeability: Part = 1.0
    density: of.Density = 1025.0
    level: Level = 0.0
    free_surface: FreeSurface = FreeSurface.QUASI_STATIC
    plan: Plan | None = None

    @model_validator(mode="after")
    def _check_shape(self) -> Self:
        given = self.given("box", "table", "mesh", "recipe")
        if len(given) != 1:
            found = " and ".join(given) or "none of them"
            raise problem(found, "one of box, table, mesh, recipe")
        for key, owner in (*((key, "mesh") for key in PLACING), ("depth", "recipe")):
            if self.given(key) and given[0] != owner:
                raise problem(f"{key} of a {given[0]}", f"it of a {owner}")
        if self.table is not None and self.permeability != 1.0:
            raise problem("permeability of a table", "volumes of fluid in it, and no permeability")
        if self.box is not None and not np.all(np.subtract(*self.box)):
            raise problem(f"the corners {self.box[0]} and {self.box[1]}", "a box of three sizes")
        return self

    def build(self, name: str, key: str, folder: Path) -> scene.Tank:
        """As a scene has it; ``key`` is that of the tank in a case in ``folder``. Raises InputError
        for a mesh that cannot be read or is open."""
        try:
            shape = self._shape(folder)
        except InputError as error:
            raise InputError(f"{key}: {error}") from None
        return scene.Tank(
            name,
            shape,
            self.level,
            self.density,
            self.free_surface,
            scene.Plan(np.array(self.plan.time), np.array(self.plan.level)) if self.plan else None,
        )

    def _shape(self, folder: Path) -> scene.TankShape:
        if self.table is not None:
            return self.table.build()
        if self.mesh is not None:
            given = {key: getattr(self, key) for key in self.given(*PLACING)}
            corners = MeshHull(mesh=self.mesh, **given).triangles(folder)
            return scene.TankMesh(corners, self.permeability, str(folder / self.mesh))
        if self.recipe is not None:
            corners = RecipeHull(recipe=self.recipe, depth=self.depth).triangles(folder)
            return scene.TankMesh(corners, self.permeability, str(folder / self.recipe))
        low, high = np.sort(np.array(self.box), axis=0)
        return scene.Box(tuple(low.tolist()), tuple(high.tolist()), self.permeability)


class LevelReached(Strict):
    """When the level of a tank is above or below a height."""

    tank: StrictStr
    above: Level | None = None
    below: Level | None = None

    @model_validator(mode="after")
    def _check_side(self) -> Self:
        given = self.given("above", "below")
        if len(given) != 1:
            raise problem(" and ".join(given) or "neither", "one of above, below")
        return self

    def build(self) -> scene.LevelReached:
        """As a scene has it."""
        level = self.below if self.above is None else self.above
        return scene.LevelReached(self.tank, float(level or 0.0), self.above is not None)


def _form(value: object) -> str:
    if isinstance(value, Event) or (isinstance(value, dict) and "channel" in value):
        return "event"
    return "level" if isinstance(value, dict | LevelReached) else "time"


When = Annotated[
    Annotated[of.Instant, Tag("time")]
    | Annotated[LevelReached, Tag("level")]
    | Annotated[Event, Tag("event")],
    Discriminator(_form),
]


class Pump(Strict):
    """Moves fluid from its ``source`` to its ``target``: names of tanks of the body, or sea; from
    ``start`` to ``stop``, each a time, a level or an event."""

    source: StrictStr
    target: StrictStr
    rate: Rate
    start: When = 0.0
    stop: When | None = None

    def build(self, name: str) -> scene.Pump:
        """As a scene has it."""
        source, target = (None if end == SEA else end for end in (self.source, self.target))
        start = self.start if isinstance(self.start, float | int) else self.start.build()
        stop = self.stop.build() if isinstance(self.stop, LevelReached | Event) else self.stop
        return scene.Pump(name, self.rate, source, target, start, stop)
