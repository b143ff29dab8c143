"""Check that a database has the data that a scene uses. All faults are reported at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hydrosim.compiling.coefficients import SOURCE
from hydrosim.database.checks import (
    SYMMETRIES,
    CheckSubject,
    Use,
    doubt_warnings,
    refusing_findings,
)
from hydrosim.database.database import HydroDatabase
from hydrosim.database.transfer import velocity_transfer
from hydrosim.errors import InputError
from hydrosim.scene import Body, Environment, SecondOrder, Weight
from hydrosim.scene.given import ORIGIN_ASSUMED, POINTS_UNKNOWN, key_of

if TYPE_CHECKING:
    from hydrosim.waves.components import WaveComponents

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
    bodies: Sequence[Body],
    free: np.ndarray,
    water: Environment,
    seas: Sequence[WaveComponents],
) -> HydroDatabase:
    """Database with all data for ``bodies`` that move in the DOFs ``free``. Raises InputError with
    all faults and their remedies."""
    if db.source == SOURCE:
        return db
    findings = refusing_findings(db, _use(db, bodies, free, seas))
    faults = [*_other_water(db, water), *_gaps(db, bodies, water)]
    if findings:
        faults.append(_unproven([finding.name for finding in findings], findings))
    if faults:
        raise InputError(_fault_message(db, bodies, faults))
    return _complete_database(db, bodies)


def database_warnings(
    db: HydroDatabase, bodies: Sequence[Body], free: np.ndarray, seas: Sequence[WaveComponents]
) -> tuple[str, ...]:
    """Warnings about the data that the ``bodies``, which move in the DOFs ``free``, use of their
    database as read, in the ``seas``. Raises InputError if such data cannot be right."""
    if db.source == SOURCE:  # checked where it is made
        return ()
    found = doubt_warnings(db, _use(db, bodies, free, seas))
    return (*found, *_unsaid_points(db, free))


def _use(
    db: HydroDatabase, bodies: Sequence[Body], free: np.ndarray, seas: Sequence[WaveComponents]
) -> Use:
    parts = frozenset(part for body in bodies for part in _parts(body, bool(seas)))
    offset = db.reference_point - np.array([body.centre_of_gravity for body in bodies])
    moving = np.flatnonzero(velocity_transfer(offset)[:, free].any(axis=1))
    return Use(parts, tuple(map(int, moving)), _highest(db, seas))


def _unsaid_points(db: HydroDatabase, free: np.ndarray) -> Iterator[str]:
    """Warning about an assumed reference point, which matters for bodies that rotate."""
    assumed = db.attributes.get("assumed", "")
    if POINTS_UNKNOWN in assumed:
        yield (
            f"{db.source}: it does not state the reference point of its moments. Recorded moments"
            " of bodies that do not turn are about its origin. Give the point as"
            " reference_point."
        )
    if ORIGIN_ASSUMED in assumed and (free % 6 > 2).any():
        yield (
            f"{db.source}: its files do not state the reference point of moments and rotations;"
            f" the origin was assumed. Give it: `hydrodynamics: {{file: ..., reference_point: [0"
            f" m, 0 m, 0 m]}}`."
        )


def _parts(body: Body, waves: bool) -> Iterator[CheckSubject]:
    wanted = body.wave_forces
    yield from (CheckSubject.ORDER, CheckSubject.RADIATION, CheckSubject.STIFFNESS)
    if not waves:
        return
    if wanted.first_order:
        yield CheckSubject.LOADS
    if wanted.second_order != SecondOrder.NONE:
        yield CheckSubject.DRIFT
    if wanted.second_order == SecondOrder.QTF:
        yield CheckSubject.DIFFERENCE
    if wanted.sum_frequency:
        yield CheckSubject.SUM


def _highest(db: HydroDatabase, seas: Sequence[WaveComponents]) -> float:
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


def _fault_message(db: HydroDatabase, bodies: Sequence[Body], faults: Sequence[Fault]) -> str:
    names = ", ".join(f"bodies.{body.name}" for body in bodies)
    reasons = "\n".join(f"  {fault.reason}" for fault in faults)
    keys = [key for fault in faults for key in fault.keys]
    remedy = f"\nAdd to the case: `hydrodynamics: {{file: ..., {', '.join(keys)}}}`."
    return f"{db.source} does not suit {names}:\n{reasons}{remedy if keys else ''}"


def _other_water(db: HydroDatabase, water: Environment) -> Iterator[Fault]:
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
            yield Fault(reason, (f"{key_of(name)}: {here:g}",))
        else:
            yield Fault(f"{found_text}. Use a database made for this water, or change the case.")


def _gaps(db: HydroDatabase, bodies: Sequence[Body], water: Environment) -> Iterator[Fault]:
    """Faults: data that the bodies need and the database lacks."""
    assumed = db.attributes.get("assumed", "")
    density = water.water_density if "water density" in assumed else db.water_density
    by_matrix = [body for body in bodies if body.hydrostatics is None]
    stiff = any({"heave", "roll", "pitch"} & {*body.dofs} for body in by_matrix)
    tilting = any({"roll", "pitch"} & {*body.dofs} for body in by_matrix)
    weighed = any(body.weight == Weight.CARRIED or body.tanks for body in by_matrix)
    turning = any({"roll", "pitch", "yaw"} & {*body.dofs} for body in bodies)
    if stiff and db.hydrostatic_stiffness is None:
        yield Fault(
            "It has no hydrostatic stiffness, and its bodies heave, roll or pitch. Write it into"
            " the file, or give them a closed hull: `hydrostatics: {mesh: FILE}`."
        )
    if turning and POINTS_UNKNOWN in assumed:
        points = [[float(x) for x in body.centre_of_gravity] for body in bodies]
        yield Fault(
            "It does not state the reference points of moments and rotations, and its bodies"
            " turn. Capytaine stores them as rotation_center or, if that was not set, as"
            " center_of_mass.",
            (f"reference_point: {_example(points)}",),
        )
    if tilting and db.centre_of_gravity is None:
        yield _lacking_centres(db, bodies)
    if (tilting or weighed) and db.volume is None:
        yield _lacking_volumes(bodies, density)


def _lacking_centres(db: HydroDatabase, bodies: Sequence[Body]) -> Fault:
    """Fault: nobody says with which centres of gravity the stiffness was made. It may be those of
    the case, or the weight is left out, which is a centre at the waterline. A stiffness that
    capsizes in roll or pitch was made without weight."""
    own = [[float(x) for x in body.centre_of_gravity] for body in bodies]
    at_waterline = [[x, y, 0.0] for x, y, _ in own]
    reason = (
        "It does not state the centres of gravity with which its stiffness was made, and its"
        f" bodies roll or pitch. They are those of the bodies, {_example(own)}, if the weight is in"
        f" the stiffness, and {_example(at_waterline)} if it was made without weight, as OpenFAST's"
        " .hst is."
    )
    stiffness = db.hydrostatic_stiffness
    turns = np.zeros(1) if stiffness is None else np.diag(stiffness).reshape(-1, 6)[:, 3:5]
    if own == at_waterline:
        return Fault(reason, (f"centre_of_gravity: {_example(own)}",))
    if np.any(turns < 0.0):
        weightless = " Its roll or pitch stiffness is negative, so it was made without weight."
        return Fault(reason + weightless, (f"centre_of_gravity: {_example(at_waterline)}",))
    return Fault(reason, (f"centre_of_gravity: {_example([UNKNOWN_POINT] * len(bodies))}",))


def _lacking_volumes(bodies: Sequence[Body], density: float) -> Fault:
    """Fault: displaced volumes, which follow from the mass only of bodies that float by
    themselves."""
    volumes: list[Any] = [float(f"{body.mass / density:.6g}") for body in bodies]
    reason = (
        "It does not state the displaced volumes, and its bodies roll or pitch, have tanks or"
        " carry their weight."
    )
    carried = [body.weight == Weight.CARRIED for body in bodies]
    if any(carried):
        names = ", ".join(body.name for body, own in zip(bodies, carried, strict=True) if own)
        reason += (
            f" The weight of {names} is carried, not balanced, so the volume does not follow from"
            " the mass: give that of the hull below the water at rest."
        )
        volumes = [UNKNOWN_NAME if own else v for v, own in zip(volumes, carried, strict=True)]
    return Fault(reason, (f"volume: {_example(volumes)}",))


def _example(values: list[Any]) -> str:
    """One value for each body, as in a case."""
    return str(values[0] if len(values) == 1 else values).replace("'", "")


def _unproven(names: list[str], findings: Sequence[object]) -> Fault:
    """Fault: findings that refuse a database."""
    reasons = "\n  ".join(map(str, findings))
    noise = (
        " If the asymmetry is noise, remove it with `symmetrise: true`."
        if SYMMETRIES & {*names}
        else ""
    )
    reason = (
        f"{reasons}\n  These data cannot be right: accept them only if you know that they"
        f" are.{noise}"
    )
    return Fault(reason, (f"accept: [{', '.join(names)}]",))


def _complete_database(db: HydroDatabase, bodies: Sequence[Body]) -> HydroDatabase:
    """Database in which data that no motion of the ``bodies`` needs are completed."""
    size = 6 * len(bodies)
    fill: dict[str, Any] = {
        "hydrostatic_stiffness": np.zeros((size, size)),
        "centre_of_gravity": np.array([body.centre_of_gravity for body in bodies], dtype=float),
        "volume": np.array([body.mass / db.water_density for body in bodies]),
    }
    lacking = {name: value for name, value in fill.items() if getattr(db, name) is None}
    return replace(db, **lacking) if lacking else db
