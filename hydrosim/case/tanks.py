"""`tanks` and `pumps` of a body in a case file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import AfterValidator, Discriminator, StrictStr, Tag, model_validator

from hydrosim import scene
from hydrosim.case.hydrodynamics import Depth, MeshHull, RecipeHull
from hydrosim.errors import InputError
from hydrosim.files import quantities as of
from hydrosim.files.key_rules import exactly_one
from hydrosim.files.quantities import Axes, Scale, SchemaModel
from hydrosim.files.units import Quantity, problem
from hydrosim.scene import FreeSurface, LevelReached, Plan
from hydrosim.scene.force import AtTime, Event

SEA_NAME = "sea"
SHAPES = ("box", "table", "mesh", "recipe")
PLACING = ("scale", "axes", "offset", "waterline")  # keys of a mesh
Volume = Annotated[float, Quantity("volume", "m^3", "100 m^3", at_least=0)]
AreaMoment = Annotated[float, Quantity("second moment of area", "m^4", "1000 m^4", at_least=0)]
MixedMoment = Annotated[float, Quantity("second moment of area", "m^4", "-1000 m^4")]
Part = Annotated[float, Quantity("number", "", "98 %", above=0, at_most=1)]
Rate = Annotated[float, Quantity("mass per time", "kg/s", "5000 tonne/hour", above=0)]
Levels = Annotated[tuple[of.Level, ...], of.RISING, AfterValidator(of.require_start_at_zero)]
Volumes = Annotated[tuple[Volume, ...], of.RISING, AfterValidator(of.require_start_at_zero)]


class TankTableEntry(SchemaModel):
    """What a tank holds at each ``level`` above its bottom: ``volume`` of fluid, its ``centroid``
    in the database's frame, and second moments of its free surface about the surface's centroid."""

    level: Levels
    """Levels above the tank's bottom, rising from 0."""
    volume: Volumes
    """Volume of fluid at each level, rising from 0."""
    centroid: tuple[of.Point, ...]
    """Centroid of the fluid at each level, in the database's frame."""
    longitudinal: tuple[AreaMoment, ...]
    """Second moment of the free surface about its transverse axis, at each level."""
    transverse: tuple[AreaMoment, ...]
    """Second moment of the free surface about its longitudinal axis, at each level."""
    mixed: tuple[MixedMoment, ...] | None = None
    """Mixed second moment of the free surface at each level."""

    @model_validator(mode="after")
    def _check_rows(self) -> Self:
        names = ("level", "volume", "centroid", "longitudinal", "transverse", "mixed")
        sizes = {name: len(x) for name in names if (x := getattr(self, name)) is not None}
        if len({*sizes.values()}) > 1:
            sizes_text = ", ".join(f"{size} of {name}" for name, size in sizes.items())
            raise problem(sizes_text, "as many of each: one a row")
        return self

    def build(self) -> scene.TankTable:
        """As a scene has it."""
        mixed = np.zeros(len(self.level)) if self.mixed is None else np.array(self.mixed)
        surface = np.column_stack([self.longitudinal, mixed, self.transverse])
        level, volume = np.array(self.level), np.array(self.volume)
        return scene.TankTable(level, volume, np.array(self.centroid), surface)


class TankEntry(SchemaModel):
    """A tank: a ``box`` between two corners, a ``table``, a closed ``mesh`` in a file, or the hull
    of a ``recipe``, in the database's frame; the latter two with the keys that a hull has."""

    key_rules = (exactly_one(*SHAPES, nothing="none of them"),)

    box: tuple[of.Point, of.Point] | None = None
    """Two opposite corners of a tank that is a box, in the database's frame.
    Example: [[-20 m, 10 m, -12 m], [20 m, 30 m, 2 m]]."""
    table: TankTableEntry | None = None
    """Volumes and free surfaces at levels."""
    mesh: StrictStr | None = None
    """File with a closed mesh of the tank. Example: tank.stl."""
    scale: Scale | None = None
    """Factor that turns the coordinates of the mesh into metres."""
    axes: Axes | None = None
    """The axes of the mesh that point forward, to port and up. Example: [x, -y, -z]."""
    offset: of.Point | None = None
    """Vector that is added to the scaled and turned coordinates of the mesh."""
    waterline: of.Length | None = None
    """Height of the still water above z = 0 of the mesh."""
    recipe: StrictStr | None = None
    """Recipe file whose hull is the tank. Example: ../hydro_db/barge.yaml."""
    depth: Depth | None = None
    """Height from keel to deck of the recipe's hull."""
    permeability: Part = 1.0
    """Part of the volume that fluid can fill."""
    density: of.Density = 1025.0
    """Density of the fluid."""
    level: of.Level = 0.0
    """Level of the fluid above the tank's bottom when the run starts."""
    free_surface: FreeSurface = FreeSurface.QUASI_STATIC
    """Whether the fluid's surface stays level, or is frozen to the tank."""
    plan: Plan | None = None
    """Levels at times, filled from or emptied to the sea."""

    @model_validator(mode="after")
    def _check_shape(self) -> Self:
        (shape,) = self.keys_with_value(*SHAPES)
        for key, owner in (*((key, "mesh") for key in PLACING), ("depth", "recipe")):
            if self.keys_with_value(key) and shape != owner:
                raise problem(f"{key} of a {shape}", f"it of a {owner}")
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
            self.plan,
        )

    def _shape(self, folder: Path) -> scene.TankShape:
        if self.table is not None:
            return self.table.build()
        if self.mesh is not None:
            given = {key: getattr(self, key) for key in self.keys_with_value(*PLACING)}
            corners = MeshHull(mesh=self.mesh, **given).triangles(folder)
            return scene.TankMesh(corners, self.permeability, str(folder / self.mesh))
        if self.recipe is not None:
            corners = RecipeHull(recipe=self.recipe, depth=self.depth).triangles(folder)
            return scene.TankMesh(corners, self.permeability, str(folder / self.recipe))
        low, high = np.sort(np.array(self.box), axis=0)
        return scene.Box(tuple(low.tolist()), tuple(high.tolist()), self.permeability)


def _form_tag(value: object) -> str:
    if isinstance(value, Event) or (isinstance(value, dict) and "channel" in value):
        return "event"
    if isinstance(value, AtTime) or (isinstance(value, dict) and "time" in value):
        return "mapping"
    return "level" if isinstance(value, dict | LevelReached) else "time"


FlowEnd = Annotated[
    Annotated[of.Instant, Tag("time")]
    | Annotated[AtTime, Tag("mapping")]
    | Annotated[LevelReached, Tag("level")]
    | Annotated[Event, Tag("event")],
    Discriminator(_form_tag),
]


class PumpEntry(SchemaModel):
    """Moves fluid from its ``source`` to its ``target``: names of tanks of the body, or sea; from
    ``start`` to ``stop``, each a time, a level or an event."""

    source: StrictStr
    """Tank that fluid is taken from, or sea. Example: fore_sb."""
    target: StrictStr
    """Tank that fluid is pumped to, or sea. Example: sea."""
    rate: Rate
    """Mass of fluid per time."""
    start: FlowEnd = 0.0
    """Time, level or event at which the pump starts."""
    stop: FlowEnd | None = None
    """Time, level or event at which the pump stops. Without it the pump stops when a tank is empty
    or full."""

    def build(self, name: str) -> scene.Pump:
        """As a scene has it."""
        source, target = (None if end == SEA_NAME else end for end in (self.source, self.target))
        start, stop = (_flow_end(end) for end in (self.start, self.stop))
        return scene.Pump(name, self.rate, source, target, 0.0 if start is None else start, stop)


def _flow_end(end: Any) -> Any:
    """A start or a stop as a scene has it."""
    if isinstance(end, AtTime):
        return end.time
    return end.build() if isinstance(end, Event) else end
