"""`tanks` and `pumps` of a body in a case file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, ClassVar, Self

import numpy as np
from pydantic import AfterValidator, StrictStr, model_validator

from hydrosim import scene
from hydrosim.case.hydrodynamics import Depth, MeshHull, RecipeHull
from hydrosim.errors import InputError
from hydrosim.files import quantities as of
from hydrosim.files.key_rules import exactly_one
from hydrosim.files.quantities import Axes, Scale
from hydrosim.files.schema_class import SchemaClass, schema_class
from hydrosim.files.units import Quantity, problem
from hydrosim.scene.body import TankKeys

SEA_NAME = "sea"
SHAPES = ("box", "table", "mesh", "recipe")
PLACING = ("scale", "axes", "offset", "waterline")  # keys of a mesh
Volume = Annotated[float, Quantity("volume", "m^3", "100 m^3", at_least=0)]
AreaMoment = Annotated[float, Quantity("second moment of area", "m^4", "1000 m^4", at_least=0)]
MixedMoment = Annotated[float, Quantity("second moment of area", "m^4", "-1000 m^4")]
Part = Annotated[float, Quantity("number", "", "98 %", above=0, at_most=1)]
Levels = Annotated[tuple[of.Level, ...], of.RISING, AfterValidator(of.require_start_at_zero)]
Volumes = Annotated[tuple[Volume, ...], of.RISING, AfterValidator(of.require_start_at_zero)]


@schema_class
class TankTableEntry(SchemaClass):
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


@schema_class
class TankEntry(TankKeys):
    """A tank: a ``box`` between two corners, a ``table``, a closed ``mesh`` in a file, or the hull
    of a ``recipe``, in the database's frame; the latter two with the keys that a hull has."""

    own_keys_first: ClassVar[bool] = True
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
        return scene.Tank.build_from(self, name=name, shape=shape)

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
