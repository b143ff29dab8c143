"""Databases of a scene: opened, and grouped with their bodies."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hydrosim.compiling.coefficients import CONSTANT, database_of
from hydrosim.database.changes import BODIES_APART, apply_changes
from hydrosim.database.checks import in_order
from hydrosim.database.database import HydroDatabase
from hydrosim.database.load import overruled_values, read
from hydrosim.database.transfer import body_of
from hydrosim.errors import InputError
from hydrosim.scene import (
    Body,
    ChangedDatabase,
    Coefficients,
    ConstantRadiation,
    Environment,
    Family,
    Hydrodynamics,
    Scene,
)
from hydrosim.scene.given import NOTHING_GIVEN, Given, key_of

Source = Path | Hydrodynamics | ChangedDatabase


def open_database(source: Source, given: Given = NOTHING_GIVEN) -> HydroDatabase:
    """Database of a body: read from its file unless it is in memory, with the requested changes.
    Raises InputError if it cannot be read or changed, or if its frequencies or headings are out of
    order."""
    if isinstance(source, ChangedDatabase):
        given = replace(source.given, frequencies=source.changes.frequencies)
        return apply_changes(open_database(source.source, given), source.changes)
    if isinstance(source, Path):
        return in_order(_check_given(read(source, given), given))
    if isinstance(source, HydroDatabase):
        return in_order(source)
    raise InputError(
        f"hydrodynamics: found an object of type {type(source).__name__}; expected a"
        " pathlib.Path, a HydroDatabase or a ChangedDatabase."
    )


def _check_given(db: HydroDatabase, given: Given) -> HydroDatabase:
    """Return the database. Raises InputError if its file contradicts a given value."""
    for name in overruled_values(db, given):
        raise InputError(
            f"hydrodynamics.{key_of(name)}: found {getattr(given, name)}, but {db.source} itself"
            f" states {np.ravel(getattr(db, name))}; expected the same value. Leave the key out."
        )
    return db


class DatabaseGroup(NamedTuple):
    """Bodies of a scene that share a database, and their ``places`` among all bodies."""

    database: HydroDatabase
    bodies: list[Body]
    places: list[int]


def database_groups(scene: Scene) -> list[DatabaseGroup]:
    """Databases of the scene as read, without families, and their bodies in order. Raises
    InputError if one cannot be read, or has no loads though the scene has waves."""
    known: dict[Source, HydroDatabase] = {}
    found: dict[tuple[object, ...], DatabaseGroup] = {}
    for i, body in enumerate(scene.bodies):
        source = body.hydrodynamics
        if source is None or isinstance(source, Family):
            continue
        db, body = _of_body(body, source, scene.environment, known)
        # several bodies may be copies of the body of one database, far from each other
        key = (i,) if db.bodies == 1 else (source, *body.location, body.heading)
        group = found.setdefault(key, DatabaseGroup(db, [], []))
        group.bodies.append(body)
        group.places.append(i)
    for group in found.values():
        order = np.argsort([body.database_body for body in group.bodies], kind="stable")
        group.bodies[:] = [group.bodies[k] for k in order]
        group.places[:] = [group.places[k] for k in order]
    return list(found.values())


def _of_body(
    body: Body,
    source: Source | Coefficients,
    water: Environment,
    known: dict[Source, HydroDatabase],
) -> tuple[HydroDatabase, Body]:
    """Database of the body, read once, and the body as a body of that database."""
    if isinstance(source, Coefficients):
        db = database_of(source, body, water)
        body = replace(body, radiation=ConstantRadiation(CONSTANT))
    else:
        db = known[source] = known[source] if source in known else open_database(source)
        if BODIES_APART in db.attributes and 1 <= body.database_body <= db.bodies:
            db = body_of(db, body.database_body - 1)
            body = replace(body, database_body=1)
    if water.waves and not db.heading.size:
        _check_unloaded(db, body)
    return db, body


def _check_unloaded(db: HydroDatabase, body: Body) -> None:
    """Raises InputError if the scene has waves and the database no wave loads."""
    if body.dofs and body.wave_forces.has_loads:
        raise InputError(
            f"bodies.{body.name}: {db.source} has no wave loads, and the scene has waves. Use a"
            " database with loads, leave the waves out, or set wave_forces.first_order to false."
        )
