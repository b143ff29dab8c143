"""The databases of a scene: opened, and judged by what the scene uses of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.compiling.coefficients import CONSTANT, SOURCE, database_of
from hydrosim.database.changes import APART, changed
from hydrosim.database.checks import Part, Use, doubts, in_order
from hydrosim.database.database import HydroDatabase
from hydrosim.database.load import overruled, read
from hydrosim.database.transfer import body_of, velocity_transfer
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
    SecondOrder,
)
from hydrosim.scene.given import NOTHING_GIVEN, ORIGIN_ASSUMED, Given, key_of

if TYPE_CHECKING:
    from hydrosim.waves.components import Components

_WATER = ("water_density", "gravity", "water_depth")
HARDLY = 0.01  # share of a sea's energy that a database may lack, too


Source = Path | Hydrodynamics | ChangedDatabase


def opened(source: Source, given: Given = NOTHING_GIVEN) -> HydroDatabase:
    """The database of a body: read from its file, unless it is in memory, and changed as asked for.
    Raises InputError where that cannot be, or its frequencies and headings are out of order."""
    if isinstance(source, ChangedDatabase):
        return changed(opened(source.source, source.given), source.changes)
    if isinstance(source, Path):
        return in_order(_unmistaken(read(source, given), given))
    if isinstance(source, HydroDatabase):
        return in_order(source)
    raise InputError(
        f"hydrodynamics: found {type(source).__name__}; expected a file or a HydroDatabase."
    )


def _unmistaken(db: HydroDatabase, given: Given) -> HydroDatabase:
    """The database; raises InputError where its file says something else than what is given."""
    for name in overruled(db, given):
        raise InputError(
            f"hydrodynamics.{key_of(name)}: found {getattr(given, name)}, but {db.source} itself"
            f" says {np.ravel(getattr(db, name))}; expected the same. Leave the key out."
        )
    return db


class Group(NamedTuple):
    """The bodies of a scene, and their ``places`` among all, that share a database."""

    database: HydroDatabase
    bodies: list[Body]
    places: list[int]


def groups(scene: Scene) -> list[Group]:
    """The databases of the scene but those of families, as they are read, and their bodies, in
    their order. Raises
    InputError where one cannot be read, is of other water or has no loads though waves ask."""
    known: dict[Source, HydroDatabase] = {}
    found: dict[tuple[object, ...], Group] = {}
    for i, body in enumerate(scene.bodies):
        source = body.hydrodynamics
        if source is None or isinstance(source, Family):
            continue
        db, body = _of_body(body, source, scene.environment, known)
        # several bodies may be copies of the one in a database, far from each other
        key = (i,) if db.bodies == 1 else (source, *body.location, body.heading)
        group = found.setdefault(key, Group(db, [], []))
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
    """Its database, read once, and the body as one of that database."""
    if isinstance(source, Coefficients):
        db = database_of(source, body, water)
        body = replace(body, radiation=ConstantRadiation(CONSTANT))
    else:
        db = known[source] = known[source] if source in known else opened(source)
        check_water(db, body, water)
        if APART in db.attributes and 1 <= body.database_body <= db.bodies:
            db = body_of(db, body.database_body - 1)
            body = replace(body, database_body=1)
    if water.waves and not db.heading.size:
        _check_unloaded(db, body)
    return db, body


def _check_unloaded(db: HydroDatabase, body: Body) -> None:
    """Raises InputError where wave loads are asked for that there are none of."""
    wanted, none = body.wave_forces, SecondOrder.NONE
    if body.dofs and (wanted.first_order or wanted.sum_frequency or wanted.second_order != none):
        raise InputError(
            f"bodies.{body.name}: {db.source} has no wave loads, and the scene has waves. Use a"
            " database with loads, leave the waves out, or set wave_forces.first_order to false."
        )


def judged(
    db: HydroDatabase, bodies: Sequence[Body], free: np.ndarray, seas: Sequence[Components]
) -> tuple[str, ...]:
    """Doubts about what the ``bodies``, which move in the DOFs ``free``, use of their database, as
    it was read, in the ``seas``. Raises InputError where that cannot be right."""
    parts = frozenset(part for body in bodies for part in _parts(body, bool(seas)))
    if db.source == SOURCE:  # which is checked where it is made
        return ()
    offset = db.reference_point - np.array([body.centre_of_gravity for body in bodies])
    moving = np.flatnonzero(velocity_transfer(offset)[:, free].any(axis=1))
    found = doubts(db, Use(parts, tuple(map(int, moving)), _highest(db, seas)))
    return (*found, *_unsaid_points(db, free))


def _unsaid_points(db: HydroDatabase, free: np.ndarray) -> Iterator[str]:
    """A doubt about points that nobody gave; about which a body turns matters if it turns."""
    if ORIGIN_ASSUMED in db.attributes.get("assumed", "") and (free % 6 > 2).any():
        yield (
            f"{db.source}: its files do not say which point its moments and rotations refer to,"
            " and the origin was assumed. Say it: `hydrodynamics: {file: ..., reference_point:"
            " [0 m, 0 m, 0 m]}`."
        )


def _parts(body: Body, waves: bool) -> Iterator[Part]:
    wanted = body.wave_forces
    yield from (Part.ORDER, Part.RADIATION, Part.STIFFNESS)
    if not waves:
        return
    if wanted.first_order:
        yield Part.LOADS
    if wanted.second_order != SecondOrder.NONE:
        yield Part.DRIFT
    if wanted.second_order == SecondOrder.QTF:
        yield Part.DIFFERENCE
    if wanted.sum_frequency:
        yield Part.SUM


def _highest(db: HydroDatabase, seas: Sequence[Components]) -> float:
    """Of the database's frequencies the first above which the waves have next to nothing, or
    infinity: so that seas that differ little are judged once."""
    if not seas:
        return inf
    omega, energy = (
        np.concatenate(parts)
        for parts in zip(*((waves.omega, waves.amplitude**2) for waves in seas), strict=True)
    )
    order = np.argsort(omega)
    above = np.cumsum(energy[order][::-1])[::-1] - energy[order]
    last = omega[order][int(np.argmax(above <= HARDLY * energy.sum()))]
    return min((float(w) for w in db.frequency if w >= last), default=inf)


def check_water(db: HydroDatabase, body: Body, water: Environment) -> None:
    """Raises InputError where a database was made for other water than that of the scene."""
    assumed = db.attributes.get("assumed", "")
    unlike = [name for name in _WATER if not _is_alike(getattr(water, name), getattr(db, name))]
    if not unlike:
        return
    unsaid = [name for name in unlike if name.replace("_", " ") in assumed]
    found = "; ".join(
        f"environment.{name}: found {getattr(water, name):g}, but {db.source} of"
        f" bodies.{body.name} was made for {getattr(db, name):g}"
        + (", which is assumed: its files do not say it" if name in unsaid else "")
        for name in unlike
    )
    advice = []
    if unsaid:
        keys = ", ".join(f"{key_of(name)}: {getattr(water, name):g}" for name in unsaid)
        advice.append(f"Say what it was made for, such as `hydrodynamics: {{file: ..., {keys}}}`.")
    if len(unsaid) < len(unlike):
        advice.append("Use a database made for this water, or change the case.")
    raise InputError(f"{found}. {' '.join(advice)}")


def _is_alike(here: float, there: float) -> bool:
    return here == there or (here < inf and abs(here - there) <= 1e-3 * here)
