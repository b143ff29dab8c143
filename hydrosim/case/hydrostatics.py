"""`hydrostatics` of a body in a case file: the matrix of its database, or a closed hull."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, StrictStr, Tag

from hydrosim.documents.mesh_keys import MeshKeys
from hydrosim.documents.quantities import SchemaModel
from hydrosim.documents.units import Quantity, problem
from hydrosim.errors import InputError
from hydrosim.scene import Hull

if TYPE_CHECKING:
    import numpy as np

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
        from hydrosim.database.build.closed import hull_of_recipe

        return hull_of_recipe(folder / self.recipe, body, self.depth)

    def triangles(self, folder: Path) -> np.ndarray:
        """Those of the hull of its first body, (nt, 3, 3)."""
        return self.read(folder, 1).corners


def _form(value: object) -> str:
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
    Discriminator(_form),
    BeforeValidator(_check_text),
]


def hull_of(value: Any, key: str, folder: Path, body: int) -> Hull | None:
    """The hull at the ``key`` of a case in ``folder``, if it has one; raises InputError."""
    if value == MATRIX:
        return None
    try:
        found: Hull = value.read(folder, body)
    except InputError as error:
        raise InputError(f"{key}: {error}") from None
    return found
