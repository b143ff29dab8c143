"""`hydrodynamics` of a body in a case file: a database and what is done to it, or coefficients."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Discriminator, StrictBool, StrictStr, Tag, model_validator

from hydrosim import scene
from hydrosim.documents import quantities as of
from hydrosim.documents.quantities import Strict, as_matrix
from hydrosim.documents.units import Quantity, problem
from hydrosim.scene import Without

Place = Callable[[str], Path]
Draught = Annotated[float, Quantity("draught", "m", "12.4 m", above=0)]


class DatabaseFile(Strict):
    """A database in a ``file``, and what is done to it; see `hydrosim.scene.Changes`."""

    file: StrictStr
    accept: tuple[StrictStr, ...] = ()
    frequencies: tuple[of.TableFrequency, of.TableFrequency] | None = None
    symmetrise: StrictBool = False
    without: tuple[Without, ...] = ()
    bodies_apart: StrictBool = False
    draught: StrictStr | None = None

    @model_validator(mode="after")
    def _check_range(self) -> Self:
        if self.frequencies is not None and not self.frequencies[0] < self.frequencies[1]:
            found = "frequencies {:g} to {:g} rad/s".format(*self.frequencies)
            raise problem(found, "the lower one first")
        return self

    def build(self, place: Place) -> scene.ChangedDatabase:
        """As a scene has it."""
        changes = dict(self)
        file, draught = place(changes.pop("file")), changes.pop("draught")
        return scene.ChangedDatabase(file, scene.Changes(**changes), draught)


class MemberFile(DatabaseFile):
    """The database of one ``draught`` of a hull."""

    draught: Draught  # type: ignore[assignment]

    def build_member(self, place: Place) -> scene.AtDraught:
        """As a scene has it."""
        plain = self.model_copy(update={"draught": None})
        built = DatabaseFile.build(plain, place)
        return scene.AtDraught(
            self.draught, built if built.changes != scene.Changes() else built.source
        )


class Coefficients(Strict):
    """Numbers instead of a database: constant, and without wave loads."""

    added_mass: of.AddedMassMatrix | None = None
    damping: of.DampingMatrix | None = None
    stiffness: of.StiffnessMatrix | None = None

    @model_validator(mode="after")
    def _check_some(self) -> Self:
        if not self.given("added_mass", "damping", "stiffness"):
            raise problem("none of them", "a file, or some of added_mass, damping, stiffness")
        return self

    def build(self, _: Place) -> scene.Coefficients:
        """As a scene has them."""
        values = {name: getattr(self, name) for name in ("added_mass", "damping", "stiffness")}
        return scene.Coefficients(
            **{
                name: np.zeros((6, 6)) if value is None else as_matrix(value)
                for name, value in values.items()
            }
        )


def _form(value: object) -> str:
    if isinstance(value, list | tuple):
        return "family"
    if isinstance(value, dict):
        return "changed" if "file" in value else "numbers"
    return "plain"


Hydrodynamics = Annotated[
    Annotated[StrictStr, Tag("plain")]
    | Annotated[DatabaseFile, Tag("changed")]
    | Annotated[tuple[MemberFile, ...], Tag("family")]
    | Annotated[Coefficients, Tag("numbers")],
    Discriminator(_form),
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


def built(value: Any, place: Place) -> Any:
    """As a scene has it; ``place`` is where a file of that name is."""
    if value is None:
        return None
    if isinstance(value, tuple):
        return scene.Family(tuple(member.build_member(place) for member in value))
    return place(value) if isinstance(value, str) else value.build(place)
