"""`hydrodynamics` (a database with changes, or coefficients) and `hydrostatics` in a case file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Discriminator, StrictBool, StrictStr, Tag, model_validator

from hydrosim import scene
from hydrosim.errors import InputError
from hydrosim.files import quantities as of
from hydrosim.files.messages import fields_of
from hydrosim.files.quantities import MeshKeys, SchemaModel
from hydrosim.files.units import Quantity, problem
from hydrosim.scene import Coefficients, FrequencyColumn, Hull, Without
from hydrosim.scene.hydrodynamics import key_of

Place = Callable[[str], Path]
Volume = Annotated[float, Quantity("volume", "m^3", "1000 m^3", above=0)]
Draught = Annotated[float, Quantity("draught", "m", "12.4 m", above=0)]


def _read_points(value: Any) -> Any:
    """A point of one body as a list of one."""
    return value if isinstance(value, list) and value and isinstance(value[0], list) else [value]


Points = Annotated[tuple[of.Point, ...], of.one_or_more(of.Point, _read_points)]
Volumes = Annotated[tuple[Volume, ...], of.one_or_more(Volume)]


class DatabaseFile(SchemaModel):
    """A database in a ``file``: values that the file lacks, and changes to it."""

    file: StrictStr
    """Database file, relative to the case file. Example: ../hydro_db/barge.nc."""
    density: of.Density | None = None
    """Water density of the database, where the file does not hold it."""
    gravity: of.Gravity | None = None
    """Gravity of the database, where the file does not hold it."""
    depth: of.Depth | None = None
    """Water depth of the database, where the file does not hold it."""
    length: of.LineLength | None = None
    """Length that the file's values are made dimensionless with (WAMIT's ULEN)."""
    volume: Volumes | None = None
    """Displaced volume of the hull, or a list with one of each body."""
    centre_of_buoyancy: Points | None = None
    """Centre of buoyancy in the database's frame, or a list with one of each body."""
    centre_of_gravity: Points | None = None
    """Centre of gravity that the database was computed with, or a list with one of each body."""
    reference_point: Points | None = None
    """Point that moments and motions of the file are about, or a list with one of each body."""
    frequency_column: FrequencyColumn | None = None
    """Kind of the frequency column in the file's tables."""
    symmetric: StrictBool | None = None
    """Whether the hull is its own mirror image, port and starboard."""
    accept: tuple[StrictStr, ...] = ()
    """Names of findings of the database check that are accepted. Example: [positive damping]."""
    frequencies: tuple[of.TableFrequency, of.TableFrequency] | None = None
    """Lowest and highest frequency that are used. Example: [0 rad/s, 3 rad/s]."""
    symmetrise: StrictBool = False
    """Whether matrices are made symmetric and values that symmetry forbids are removed."""
    without: tuple[Without, ...] = ()
    """Parts of the database that are left out."""
    bodies_apart: StrictBool = False
    """Whether each body of the database is taken by itself, with the others held."""
    draught: StrictStr | None = None
    """Name of one of several draughts in the file. Example: draught_6m."""

    @model_validator(mode="after")
    def _check_range(self) -> Self:
        if self.frequencies is not None and not self.frequencies[0] < self.frequencies[1]:
            range_text = "frequencies {:g} to {:g} rad/s".format(*self.frequencies)
            raise problem(range_text, "the lower one first")
        return self

    def build(self, place: Place) -> scene.ChangedDatabase:
        """As a scene has it."""
        changes = {item.name: getattr(self, item.name) for item in fields(scene.Changes)}
        given = {
            item.name: _flatten(getattr(self, key_of(item.name))) for item in fields(scene.Given)
        }
        return scene.ChangedDatabase(
            place(self.file), scene.Changes(**changes), scene.Given(**given)
        )


def _flatten(value: Any) -> Any:
    """Points one after the other."""
    nested = isinstance(value, tuple) and value and isinstance(value[0], tuple)
    return tuple(x for point in value for x in point) if nested else value


class MemberFile(DatabaseFile):
    """The database of one ``draught`` of a hull."""

    draught: Draught  # type: ignore[assignment]
    """Draught that this database of the hull was computed at."""

    def build_member(self, place: Place) -> scene.AtDraught:
        """As a scene has it."""
        unnamed = self.model_copy(update={"draught": None})
        built = DatabaseFile.build(unnamed, place)
        plain = built == scene.ChangedDatabase(built.source)
        return scene.AtDraught(self.draught, built.source if plain else built)


def _database_form(value: object) -> str:
    """Tag of what is read, or of what was read and is written again."""
    if isinstance(value, Coefficients):
        return "numbers"
    if isinstance(value, DatabaseFile):
        return "changed"
    if isinstance(value, list | tuple):
        return "family"
    if isinstance(value, dict):
        numbers = fields_of(Coefficients).keys() & value.keys()
        return "numbers" if not value or (numbers and "file" not in value) else "changed"
    return "plain"


Hydrodynamics = Annotated[
    Annotated[StrictStr, Tag("plain")]
    | Annotated[DatabaseFile, Tag("changed")]
    | Annotated[tuple[MemberFile, ...], Tag("family")]
    | Annotated[Coefficients, Tag("numbers")],
    Discriminator(_database_form),
]


def files_of(value: Any) -> list[tuple[tuple[str | int, ...], str]]:
    """The files that are named, with the keys to them."""
    match value:
        case str():
            return [((), value)]
        case DatabaseFile():
            return [(("file",), value.file)]
        case tuple():
            return [((k, "file"), member.file) for k, member in enumerate(value)]
    return []


def accepted_of(value: Any) -> list[tuple[tuple[str | int, ...], str]]:
    """The findings that are accepted, with the keys to them."""
    match value:
        case DatabaseFile():
            return [(("accept", k), finding) for k, finding in enumerate(value.accept)]
        case tuple():
            return [
                ((k, *keys), x) for k, member in enumerate(value) for keys, x in accepted_of(member)
            ]
    return []


def build_hydrodynamics(value: Any, place: Place) -> Any:
    """As a scene has it; ``place`` is where a file of that name is."""
    if value is None:
        return None
    if isinstance(value, tuple):
        return scene.Family(tuple(member.build_member(place) for member in value))
    if isinstance(value, Coefficients):
        return value
    return place(value) if isinstance(value, str) else value.build(place)


# `hydrostatics` of a body: the matrix of its database, or a closed hull.

MATRIX = "matrix"
Depth = Annotated[float, Quantity("depth", "m", "15 m", above=0)]


class MeshHull(MeshKeys):
    """A closed hull in the file ``mesh``."""

    mesh: StrictStr
    """File with a closed mesh of the hull. Example: hull.stl."""

    def read(self, folder: Path, _: int) -> Hull:
        """The hull."""
        from hydrosim.database.hull import read_hull

        return read_hull(folder / self.mesh, self)

    def triangles(self, folder: Path) -> np.ndarray:
        """Those of a closed mesh that need not be in the water, (nt, 3, 3)."""
        from hydrosim.database.hull import read_closed

        return read_closed(folder / self.mesh, self)


class RecipeHull(SchemaModel):
    """The hull that the ``recipe`` of the database describes, ``depth`` from keel to deck."""

    recipe: StrictStr
    """Recipe file that describes the hull. Example: ../hydro_db/barge.yaml."""
    depth: Depth | None = None
    """Height from keel to deck."""

    def read(self, folder: Path, body: int) -> Hull:
        """The hull of this body of the recipe."""
        from hydrosim.database.build.recipe import hull_of_recipe

        return hull_of_recipe(folder / self.recipe, body, self.depth)

    def triangles(self, folder: Path) -> np.ndarray:
        """Those of the hull of its first body, (nt, 3, 3)."""
        return self.read(folder, 1).corners


def _hydrostatics_form(value: object) -> str:
    """Its tag; no key may be called so, for messages take what is a key for one."""
    if isinstance(value, dict):
        return "of a recipe" if "recipe" in value else "of a mesh"
    return MATRIX


def _check_text(value: Any) -> Any:
    if isinstance(value, str) and value != MATRIX:
        expected = "matrix, {mesh: FILE} or {recipe: FILE}"
        raise problem(f'"{value}"', expected, f"a hull is in a file: {{mesh: {value}}}")
    return value


Hydrostatics = Annotated[
    Annotated[Literal["matrix"], Tag(MATRIX)]
    | Annotated[MeshHull, Tag("of a mesh")]
    | Annotated[RecipeHull, Tag("of a recipe")],
    Discriminator(_hydrostatics_form),
    BeforeValidator(_check_text),
]


def hull_of(value: Any, key: str, folder: Path, body: int) -> Hull | None:
    """The hull at the ``key`` of a case in ``folder``, if it has one; raises InputError."""
    if value == MATRIX:
        return None
    try:
        hull: Hull = value.read(folder, body)
    except InputError as error:
        raise InputError(f"{key}: {error}") from None
    return hull
