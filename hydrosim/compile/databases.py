"""Databases of a scene: opened or made of numbers, grouped with their bodies, checked for use."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hydrosim import scene as scenes
from hydrosim.database import checks
from hydrosim.database.changes import BODIES_APART, apply_changes, body_of, velocity_transfer
from hydrosim.database.database import HydroDatabase
from hydrosim.database.load import overruled_values, read
from hydrosim.errors import InputError
from hydrosim.scene import hydrodynamics
from hydrosim.water.radiation.retardation import KernelReport, Retardation

if TYPE_CHECKING:
    from hydrosim.water.components import WaveComponents

# Hydrodynamics given as numbers: a database that is constant and has no wave loads.

SOURCE = "coefficients of the case"
CONSTANT = 1.0  # s: placeholder period, because coefficients are the same at all periods
_FREQUENCIES = np.array([1e-3, 1e3])  # rad/s, a range that holds all motions


def database_of(
    given: scenes.Coefficients, body: scenes.Body, water: scenes.Environment
) -> HydroDatabase:
    """Database of a body about its centre of gravity. Raises InputError if a matrix is not that of
    a passive body."""
    for name in ("added_mass", "damping", "stiffness"):
        _check_matrix(f"bodies.{body.name}.hydrodynamics.{name}", np.asarray(getattr(given, name)))
    centre = np.array([body.centre_of_gravity])
    return HydroDatabase(
        source=SOURCE,
        frequency=_FREQUENCIES,
        heading=np.zeros(0),
        added_mass=np.array([given.added_mass] * 2),
        radiation_damping=np.array([given.damping] * 2),
        excitation=np.zeros((2, 0, 6), dtype=complex),
        reference_point=centre,
        centre_of_gravity=centre,
        volume=np.array([body.mass / water.water_density]),
        hydrostatic_stiffness=np.array(given.stiffness),
        water_depth=water.water_depth,
        water_density=water.water_density,
        gravity=water.gravity,
        port_starboard_symmetric=bool(_is_symmetric(given)),
    )


def constant_retardation(db: HydroDatabase) -> Retardation:
    """Retardation of constant coefficients: A_inf alone."""
    K = np.zeros((2, *db.added_mass.shape[1:]))
    report = KernelReport(0.0, 0.0, 0.0, 0.0, K[0])
    return Retardation(np.array([0.0, 1.0]), K, db.added_mass[0], report)


def _check_matrix(key: str, matrix: np.ndarray) -> None:
    """Check a matrix: a scene written in Python may have any."""
    if matrix.shape != (6, 6) or not np.isfinite(matrix).all():
        raise InputError(
            f"{key}: found an array of shape {matrix.shape}; expected numbers of shape (6, 6)."
        )
    size = np.sqrt(np.where(np.diag(matrix) > 0.0, np.diag(matrix), 1.0))
    scaled = matrix / np.outer(size, size)
    odd = np.abs(scaled - scaled.T)
    if odd.max() > 1e-6:
        i, j = np.unravel_index(int(odd.argmax()), odd.shape)
        raise InputError(
            f"{key}: found {matrix[i, j]:g} in row {i + 1}, column {j + 1} but {matrix[j, i]:g} in"
            f" row {j + 1}, column {i + 1}; expected a symmetric matrix."
        )
    if np.linalg.eigvalsh(scaled)[0] < -1e-9:
        raise InputError(
            f"{key}: found a matrix with a negative eigenvalue, which adds energy in some"
            " motion; expected eigenvalues of zero or more. Check signs and couplings."
        )


def _is_symmetric(given: scenes.Coefficients) -> bool:
    """Whether no entry couples surge, heave and pitch with sway, roll and yaw."""
    even = np.arange(6) % 2 == 0
    matrices = (given.added_mass, given.damping, given.stiffness)
    return not any(np.asarray(matrix)[np.ix_(even, ~even)].any() for matrix in matrices)


Source = Path | scenes.Hydrodynamics | scenes.ChangedDatabase


def open_database(
    source: Source, given: hydrodynamics.Given = hydrodynamics.NOTHING_GIVEN
) -> HydroDatabase:
    """Database of a body: read from its file unless it is in memory, with the requested changes.
    Raises InputError if it cannot be read or changed, or if its frequencies or headings are out of
    order."""
    if isinstance(source, scenes.ChangedDatabase):
        return apply_changes(open_database(source.source, source), source)
    if isinstance(source, Path):
        return checks.require_ascending(_check_given(read(source, given), given))
    if isinstance(source, HydroDatabase):
        return checks.require_ascending(source)
    raise InputError(
        f"hydrodynamics: found an object of type {type(source).__name__}; expected a"
        " pathlib.Path, a HydroDatabase or a ChangedDatabase."
    )


def _check_given(db: HydroDatabase, given: hydrodynamics.Given) -> HydroDatabase:
    """Return the database. Raises InputError if its file contradicts a given value."""
    for name in overruled_values(db, given):
        raise InputError(
            f"hydrodynamics.{hydrodynamics.key_of(name)}: found {getattr(given, name)}, but"
            f" {db.source} itself"
            f" states {np.ravel(getattr(db, name))}; expected the same value. Leave the key out."
        )
    return db


class DatabaseGroup(NamedTuple):
    """Bodies of a scene that share a database, and their ``places`` among all bodies."""

    database: HydroDatabase
    bodies: list[scenes.Body]
    places: list[int]


def database_groups(scene: scenes.Scene) -> list[DatabaseGroup]:
    """Databases of the scene as read, without families, and their bodies in order. Raises
    InputError if one cannot be read, or has no loads though the scene has waves."""
    databases: dict[Source, HydroDatabase] = {}
    groups: dict[tuple[object, ...], DatabaseGroup] = {}
    for i, body in enumerate(scene.bodies):
        source = body.hydrodynamics
        if source is None or isinstance(source, scenes.Family):
            continue
        db, body = _read_database_of_body(body, source, scene.environment, databases)
        # several bodies may be copies of the body of one database, far from each other
        key = (i,) if db.bodies == 1 else (source, *body.location, body.heading)
        group = groups.setdefault(key, DatabaseGroup(db, [], []))
        group.bodies.append(body)
        group.places.append(i)
    for group in groups.values():
        order = np.argsort([body.database_body for body in group.bodies], kind="stable")
        group.bodies[:] = [group.bodies[k] for k in order]
        group.places[:] = [group.places[k] for k in order]
    return list(groups.values())


def _read_database_of_body(
    body: scenes.Body,
    source: Source | scenes.Coefficients,
    water: scenes.Environment,
    databases: dict[Source, HydroDatabase],
) -> tuple[HydroDatabase, scenes.Body]:
    """Database of the body, read once, and the body as a body of that database."""
    if isinstance(source, scenes.Coefficients):
        db = database_of(source, body, water)
        body = replace(body, radiation=scenes.ConstantRadiation(CONSTANT))
    else:
        db = databases[source] = databases[source] if source in databases else open_database(source)
        if BODIES_APART in db.attributes and 1 <= body.database_body <= db.bodies:
            db = body_of(db, body.database_body - 1)
            body = replace(body, database_body=1)
    if water.waves and not db.heading.size:
        _check_unloaded(db, body)
    return db, body


def _check_unloaded(db: HydroDatabase, body: scenes.Body) -> None:
    """Raises InputError if the scene has waves and the database no wave loads."""
    if body.dofs and body.wave_forces.has_loads:
        raise InputError(
            f"bodies.{body.name}: {db.source} has no wave loads, and the scene has waves. Use a"
            " database with loads, leave the waves out, or set wave_forces.first_order to false."
        )


# Check that a database has the data that a scene uses; all faults are reported at once.

HARDLY = 0.01  # also the fraction of a sea's energy that a database may lack
UNKNOWN_NAME = "?"
UNKNOWN_POINT = ["?", "?", "?"]
"""Values of a remedy that nobody but the user knows."""
_WATER = ("water_density", "gravity", "water_depth")


class Fault(NamedTuple):
    """Reason why a database does not suit a scene, and the ``keys`` of a case that remedy it."""

    reason: str
    keys: tuple[str, ...] = ()


def suitable_database(
    db: HydroDatabase,
    bodies: Sequence[scenes.Body],
    free: np.ndarray,
    water: scenes.Environment,
    seas: Sequence[WaveComponents],
) -> HydroDatabase:
    """Database with all data for ``bodies`` that move in the DOFs ``free``. Raises InputError with
    all faults and their remedies."""
    if db.source == SOURCE:
        return db
    findings = checks.refusing_findings(db, _use_of_database(db, bodies, free, seas))
    faults = [*_other_water(db, water), *_database_gaps(db, bodies, water)]
    if findings:
        faults.append(_unproven_fault([finding.name for finding in findings], findings))
    if faults:
        raise InputError(_fault_message(db, bodies, faults))
    return _complete_database(db, bodies)


def database_warnings(
    db: HydroDatabase,
    bodies: Sequence[scenes.Body],
    free: np.ndarray,
    seas: Sequence[WaveComponents],
) -> tuple[str, ...]:
    """Warnings about the data that the ``bodies``, which move in the DOFs ``free``, use of their
    database as read, in the ``seas``. Raises InputError if such data cannot be right."""
    if db.source == SOURCE:  # checked where it is made
        return ()
    warnings = checks.doubt_warnings(db, _use_of_database(db, bodies, free, seas))
    return (*warnings, *_unsaid_points(db, free))


def _use_of_database(
    db: HydroDatabase,
    bodies: Sequence[scenes.Body],
    free: np.ndarray,
    seas: Sequence[WaveComponents],
) -> checks.Use:
    parts = frozenset(part for body in bodies for part in _check_subjects(body, bool(seas)))
    offset = db.reference_point - np.array([body.centre_of_gravity for body in bodies])
    moving = np.flatnonzero(velocity_transfer(offset)[:, free].any(axis=1))
    return checks.Use(parts, tuple(map(int, moving)), _highest_frequency(db, seas))


def _unsaid_points(db: HydroDatabase, free: np.ndarray) -> Iterator[str]:
    """Warning about an assumed reference point, which matters for bodies that rotate."""
    assumed = db.attributes.get("assumed", "")
    if hydrodynamics.POINTS_UNKNOWN in assumed:
        yield (
            f"{db.source}: it does not state the reference point of its moments. Recorded moments"
            " of bodies that do not turn are about its origin. Give the point as"
            " reference_point."
        )
    if hydrodynamics.ORIGIN_ASSUMED in assumed and (free % 6 > 2).any():
        yield (
            f"{db.source}: its files do not state the reference point of moments and rotations;"
            f" the origin was assumed. Give it: `hydrodynamics: {{file: ..., reference_point: [0"
            f" m, 0 m, 0 m]}}`."
        )


def _check_subjects(body: scenes.Body, waves: bool) -> Iterator[checks.CheckSubject]:
    wanted = body.wave_forces
    yield from (
        checks.CheckSubject.ORDER,
        checks.CheckSubject.RADIATION,
        checks.CheckSubject.STIFFNESS,
    )
    if not waves:
        return
    if wanted.first_order:
        yield checks.CheckSubject.LOADS
    if wanted.second_order != scenes.SecondOrder.NONE:
        yield checks.CheckSubject.DRIFT
    if wanted.second_order == scenes.SecondOrder.QTF:
        yield checks.CheckSubject.DIFFERENCE
    if wanted.sum_frequency:
        yield checks.CheckSubject.SUM


def _highest_frequency(db: HydroDatabase, seas: Sequence[WaveComponents]) -> float:
    """First frequency of the database above which the waves have almost no energy, or infinity.
    Seas that differ little have the same frequency, so they are checked once."""
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


def _fault_message(
    db: HydroDatabase, bodies: Sequence[scenes.Body], faults: Sequence[Fault]
) -> str:
    names = ", ".join(f"bodies.{body.name}" for body in bodies)
    reasons = "\n".join(f"  {fault.reason}" for fault in faults)
    keys = [key for fault in faults for key in fault.keys]
    remedy = f"\nAdd to the case: `hydrodynamics: {{file: ..., {', '.join(keys)}}}`."
    return f"{db.source} does not suit {names}:\n{reasons}{remedy if keys else ''}"


def _other_water(db: HydroDatabase, water: scenes.Environment) -> Iterator[Fault]:
    """Faults: water that a database was not made for."""
    assumed = db.attributes.get("assumed", "")
    for name in _WATER:
        here = getattr(water, name)
        there = getattr(db, name)
        if here == there or (here < inf and abs(here - there) <= 1e-3 * here):
            continue
        found_text = f"environment.{name}: found {here:g}, but the database was made for {there:g}"
        if name.replace("_", " ") in assumed:
            reason = f"{found_text}, which is assumed, because its files do not state it."
            yield Fault(reason, (f"{hydrodynamics.key_of(name)}: {here:g}",))
        else:
            yield Fault(f"{found_text}. Use a database made for this water, or change the case.")


def _database_gaps(
    db: HydroDatabase, bodies: Sequence[scenes.Body], water: scenes.Environment
) -> Iterator[Fault]:
    """Faults: data that the bodies need and the database lacks."""
    assumed = db.attributes.get("assumed", "")
    density = water.water_density if "water density" in assumed else db.water_density
    by_matrix = [body for body in bodies if body.hydrostatics is None]
    stiff = any({"heave", "roll", "pitch"} & {*body.dofs} for body in by_matrix)
    tilting = any({"roll", "pitch"} & {*body.dofs} for body in by_matrix)
    weighed = any(body.weight == scenes.Weight.CARRIED or body.tanks for body in by_matrix)
    turning = any({"roll", "pitch", "yaw"} & {*body.dofs} for body in bodies)
    if stiff and db.hydrostatic_stiffness is None:
        yield Fault(
            "It has no hydrostatic stiffness, and its bodies heave, roll or pitch. Write it into"
            " the file, or give them a closed hull: `hydrostatics: {mesh: FILE}`."
        )
    if turning and hydrodynamics.POINTS_UNKNOWN in assumed:
        points = [[float(x) for x in body.centre_of_gravity] for body in bodies]
        yield Fault(
            "It does not state the reference points of moments and rotations, and its bodies"
            " turn. Capytaine stores them as rotation_center or, if that was not set, as"
            " center_of_mass.",
            (f"reference_point: {_example_text(points)}",),
        )
    if tilting and db.centre_of_gravity is None:
        yield _lacking_centres(db, bodies)
    if (tilting or weighed) and db.volume is None:
        yield _lacking_volumes(bodies, density)


def _lacking_centres(db: HydroDatabase, bodies: Sequence[scenes.Body]) -> Fault:
    """Fault: nobody says with which centres of gravity the stiffness was made. It may be those of
    the case, or the weight is left out, which is a centre at the waterline. A stiffness that
    capsizes in roll or pitch was made without weight."""
    centres = [[float(x) for x in body.centre_of_gravity] for body in bodies]
    at_waterline = [[x, y, 0.0] for x, y, _ in centres]
    reason = (
        "It does not state the centres of gravity with which its stiffness was made, and its"
        " bodies roll or pitch. They are those of the bodies,"
        f" {_example_text(centres)}, if the weight"
        f" is in the stiffness, and {_example_text(at_waterline)} if it was made without weight, as"
        " OpenFAST's .hst is."
    )
    stiffness = db.hydrostatic_stiffness
    turns = np.zeros(1) if stiffness is None else np.diag(stiffness).reshape(-1, 6)[:, 3:5]
    if centres == at_waterline:
        return Fault(reason, (f"centre_of_gravity: {_example_text(centres)}",))
    if np.any(turns < 0.0):
        weightless = " Its roll or pitch stiffness is negative, so it was made without weight."
        return Fault(reason + weightless, (f"centre_of_gravity: {_example_text(at_waterline)}",))
    return Fault(reason, (f"centre_of_gravity: {_example_text([UNKNOWN_POINT] * len(bodies))}",))


def _lacking_volumes(bodies: Sequence[scenes.Body], density: float) -> Fault:
    """Fault: displaced volumes, which follow from the mass only of bodies that float by
    themselves."""
    volumes: list[Any] = [float(f"{body.mass / density:.6g}") for body in bodies]
    reason = (
        "It does not state the displaced volumes, and its bodies roll or pitch, have tanks or"
        " carry their weight."
    )
    carried = [body.weight == scenes.Weight.CARRIED for body in bodies]
    if any(carried):
        names = ", ".join(
            body.name for body, is_carried in zip(bodies, carried, strict=True) if is_carried
        )
        reason += (
            f" The weight of {names} is carried, not balanced, so the volume does not follow from"
            " the mass: give that of the hull below the water at rest."
        )
        volumes = [
            UNKNOWN_NAME if is_carried else v
            for v, is_carried in zip(volumes, carried, strict=True)
        ]
    return Fault(reason, (f"volume: {_example_text(volumes)}",))


def _example_text(values: list[Any]) -> str:
    """One value for each body, as in a case."""
    return str(values[0] if len(values) == 1 else values).replace("'", "")


def _unproven_fault(names: list[str], findings: Sequence[object]) -> Fault:
    """Fault: findings that refuse a database."""
    reasons = "\n  ".join(map(str, findings))
    noise = (
        " If the asymmetry is noise, remove it with `symmetrise: true`."
        if checks.SYMMETRIES & {*names}
        else ""
    )
    reason = (
        f"{reasons}\n  These data cannot be right: accept them only if you know that they"
        f" are.{noise}"
    )
    return Fault(reason, (f"accept: [{', '.join(names)}]",))


def _complete_database(db: HydroDatabase, bodies: Sequence[scenes.Body]) -> HydroDatabase:
    """Database in which data that no motion of the ``bodies`` needs are completed."""
    size = 6 * len(bodies)
    fill: dict[str, Any] = {
        "hydrostatic_stiffness": np.zeros((size, size)),
        "centre_of_gravity": np.array([body.centre_of_gravity for body in bodies], dtype=float),
        "volume": np.array([body.mass / db.water_density for body in bodies]),
    }
    lacking = {name: value for name, value in fill.items() if getattr(db, name) is None}
    return replace(db, **lacking) if lacking else db
