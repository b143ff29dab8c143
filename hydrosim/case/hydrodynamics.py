"""`hydrodynamics` (a database with changes, or coefficients) and `hydrostatics` in a case file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Discriminator, StrictStr, Tag

from hydrosim import scene
from hydrosim.errors import InputError
from hydrosim.files.messages import fields_of
from hydrosim.files.quantities import MeshKeys, SchemaModel
from hydrosim.files.schema_class import schema_class
from hydrosim.files.units import Quantity, problem
from hydrosim.scene import ChangedDatabase, Coefficients, Hull

Place = Callable[[str], Path]
Draught = Annotated[float, Quantity("draught", "m", "12.4 m", above=0)]


@schema_class
class MemberFile(ChangedDatabase):
    """The database of one ``draught`` of a hull."""

    draught: Draught = field(kw_only=True)  # type: ignore[assignment]
    """Draught that this database of the hull was computed at."""

    def build_member(self, place: Place) -> scene.AtDraught:
        """As a scene has it."""
        built = place_database(self, place, draught=None)
        plain = built == ChangedDatabase(source=built.source)
        return scene.AtDraught(self.draught, built.source if plain else built)


def place_database(read: ChangedDatabase, place: Place, **values: Any) -> ChangedDatabase:
    """A database of a case with the place of its file, and other ``values``."""
    source = place(str(read.source))
    return ChangedDatabase.build_from(read, source=source, **values)


def _database_form(value: object) -> str:
    """Tag of what is read, or of what was read and is written again."""
    if isinstance(value, Coefficients):
        return "numbers"
    if isinstance(value, ChangedDatabase):
        return "changed"
    if isinstance(value, list | tuple):
        return "family"
    if isinstance(value, dict):
        numbers = fields_of(Coefficients).keys() & value.keys()
        return "numbers" if not value or (numbers and "file" not in value) else "changed"
    return "plain"


Hydrodynamics = Annotated[
    Annotated[StrictStr, Tag("plain")]
    | Annotated[ChangedDatabase, Tag("changed")]
    | Annotated[tuple[MemberFile, ...], Tag("family")]
    | Annotated[Coefficients, Tag("numbers")],
    Discriminator(_database_form),
]


def files_of(value: Any) -> list[tuple[tuple[str | int, ...], str]]:
    """The files that are named, with the keys to them."""
    match value:
        case str():
            return [((), value)]
        case ChangedDatabase():
            return [(("file",), str(value.source))]
        case tuple():
            return [((k, "file"), str(member.source)) for k, member in enumerate(value)]
    return []


def accepted_of(value: Any) -> list[tuple[tuple[str | int, ...], str]]:
    """The findings that are accepted, with the keys to them."""
    match value:
        case ChangedDatabase():
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
    return place(value) if isinstance(value, str) else place_database(value, place)


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
