"""Databases of one hull at several draughts: opened, checked against the hull, interpolated at the
start."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from math import cos, pi, sin
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.compile import hydrodynamic_groups
from hydrosim.compile.databases import database_groups
from hydrosim.compile.hydrostatics import with_hulls
from hydrosim.database.hull import immersed_triangles, integrals
from hydrosim.errors import InputError
from hydrosim.integrate import draught_interpolation
from hydrosim.scene import AutomaticRadiation, Body, ConvolutionRadiation, Family, Scene
from hydrosim.water import radiation
from hydrosim.water.transfer import excitation_at, mean_drift_at

if TYPE_CHECKING:
    from hydrosim.compile.restart import MemoryBefore
    from hydrosim.database.database import HydroDatabase
    from hydrosim.water.components import WaveComponents

VOLUME, CENTRE = 0.02, 0.01
"""Largest difference between a database and the hull at its draught, relative to volume and
length."""


def scene_groups(
    scene: Scene, seas: Sequence[WaveComponents], before: MemoryBefore
) -> list[hydrodynamic_groups.HydrodynamicGroup]:
    """Hydrodynamics of all wet bodies; families have all their members. Raises InputError as
    `wet_groups` does, or if a family does not fit its hull or the scene."""
    families = [
        _family_group(i, body, body.hydrodynamics, scene, seas, before)
        for i, body in enumerate(scene.bodies)
        if isinstance(body.hydrodynamics, Family)
    ]
    return [*hydrodynamic_groups.wet_groups(scene, seas, before), *families]


def members_of_families(
    wet: Sequence[hydrodynamic_groups.HydrodynamicGroup],
) -> list[hydrodynamic_groups.HydrodynamicGroup]:
    """All members of all families, as groups."""
    return [member for group in wet for member in group.members]


def groups_with_dofs(
    wet: Sequence[hydrodynamic_groups.HydrodynamicGroup], bodies: int
) -> Iterator[tuple[np.ndarray, hydrodynamic_groups.HydrodynamicGroup]]:
    """All databases and their DOFs (m,), with all members of families."""
    members = members_of_families(wet)
    for group in wet:
        if not group.members:
            yield group.dofs, group
    for k, member in enumerate(members):
        yield 6 * (bodies + k) + np.arange(6), member


def family_constants(
    scene: Scene, wet: Sequence[hydrodynamic_groups.HydrodynamicGroup]
) -> draught_interpolation.DraughtFamilies:
    """Constants of the families of a scene for the equation of motion."""
    chosen = [group for group in wet if group.members]
    members = members_of_families(wet)
    counts = [len(group.members) for group in chosen]
    body = np.array([group.dofs[0] // 6 for group in chosen], dtype=np.int64)
    return draught_interpolation.DraughtFamilies(
        body=body,
        rest=np.array([_draught_at_rest(scene.bodies[b]) for b in body]),
        first=np.cumsum([0, *counts]).astype(np.int64),
        owner=np.repeat(body, counts).astype(np.int64),
        draught=np.array([member.draught for member in members], dtype=float),
        added_mass=np.reshape([member.added_mass for member in members], (-1, 6, 6)),
    )


def _draught_at_rest(body: Body) -> float:
    """Draught of a body at its position at rest [m]."""
    assert isinstance(body.hydrodynamics, Family)
    return body.hydrodynamics.members[0].draught


def _family_group(
    i: int,
    body: Body,
    family: Family,
    scene: Scene,
    seas: Sequence[WaveComponents],
    before: MemoryBefore,
) -> hydrodynamic_groups.HydrodynamicGroup:
    """Group of a body: its members, and their interpolation at the start as its database."""
    _check_family(body, family, scene)
    rest = _draught_at_rest(body)
    members = []
    for member in sorted(family.members, key=lambda member: member.draught):
        x, y, z = body.centre_of_gravity
        alone = replace(
            _with_state_radiation(body),
            hydrodynamics=member.source,
            hydrostatics=None,
            centre_of_gravity=(x, y, z + rest - member.draught),
            database_checksum=None,
        )
        (group,) = database_groups(replace(scene, bodies=(alone,)))
        _check_draught(group.database, body, member.draught, rest)
        member_group = hydrodynamic_groups.group_of(group._replace(places=[i]), scene, seas, before)
        member_group = member_group.with_states(
            radiation.TOLERANCE
        )  # a family cannot use convolutions
        radiation.check_fits(member_group.fits, member_group.database.source)
        members.append(replace(member_group, draught=member.draught))
    return _group_at_start(body, rest, tuple(members), scene)


def _with_state_radiation(body: Body) -> Body:
    """Body with state-space radiation in place of automatic, with the fits nearest to the
    memory."""
    chosen = hydrodynamic_groups.radiation_of(body)
    return (
        hydrodynamic_groups.with_states(body, chosen.tolerance)
        if isinstance(chosen, AutomaticRadiation)
        else body
    )


def _check_family(body: Body, family: Family, scene: Scene) -> None:
    draughts = [member.draught for member in family.members]
    key = f"bodies.{body.name}"
    draughts_text = ", ".join(f"{d:g}" for d in draughts)
    if len({*draughts}) < max(len(draughts), 2):
        raise InputError(
            f"{key}.hydrodynamics: found draughts of {draughts_text} m; expected two or more"
            " different draughts."
        )
    if body.hydrostatics is None:
        raise InputError(
            f"{key}.hydrostatics: found a matrix, and databases at draughts of {draughts_text} m;"
            f" expected a closed hull, {{mesh: FILE}} or {{recipe: FILE, depth: ...}}. An"
            " interpolated stiffness would create energy."
        )
    if isinstance(hydrodynamic_groups.radiation_of(body), ConvolutionRadiation):
        raise InputError(
            f"{key}.radiation: found convolution, and databases at draughts of {draughts_text} m;"
            " expected state_space or automatic, which uses states for a family. A convolution"
            " has one velocity history per body, and a family needs one per draught."
        )
    if scene.environment.current.top_speed != 0.0:
        raise InputError(
            f"{key}.hydrodynamics: found databases at draughts of {draughts_text} m, and a current;"
            " expected still water. The effect of a current on changing added mass is not"
            " modelled. Use one database, or a current of 0."
        )


def _check_draught(db: HydroDatabase, body: Body, draught: float, rest: float) -> None:
    """Raises InputError if a database and the hull at its draught differ in displaced volume or in
    the position of the origin."""
    assert body.hydrostatics is not None
    corners = body.hydrostatics.corners + np.array([0.0, 0.0, rest - draught])
    low = corners[..., 2].min()
    high = corners[..., 2].max()
    key = f"bodies.{body.name}.hydrodynamics: {db.source} for a draught of {draught:g} m"
    if not low < 0.0 < high:
        raise InputError(
            f"{key}: at this draught the lowest point of the hull is {low:.4g} m and the highest"
            f" {high:.4g} m above the water; expected the water surface between them. Correct the"
            " draught, or the hull."
        )
    body_integrals = integrals(immersed_triangles(corners))
    if (
        db.volume is not None
        and abs(db.volume[0] - body_integrals.volume) > VOLUME * body_integrals.volume
    ):
        raise InputError(
            f"{key}: found a displaced volume of {db.volume[0]:.6g} m^3; expected the volume of"
            f" the hull at this draught, {body_integrals.volume:.6g} m^3. Correct the draught, or"
            " the hull."
        )
    if db.centre_of_buoyancy is not None:
        there = db.centre_of_buoyancy[0, :2]
        here = body_integrals.centre_of_buoyancy[:2]
        if np.abs(there - here).max() > CENTRE * np.ptp(corners[..., 0]):
            raise InputError(
                f"{key}: found its centre of buoyancy at x = {there[0]:.4g}, y = {there[1]:.4g}"
                f" m; expected the hull's, {here[0]:.4g} and {here[1]:.4g} m. All databases of a"
                " family have the same origin on the hull. In a recipe, `position` moves it."
            )


def _group_at_start(
    body: Body,
    rest: float,
    members: tuple[hydrodynamic_groups.HydrodynamicGroup, ...],
    scene: Scene,
) -> hydrodynamic_groups.HydrodynamicGroup:
    """Group of the member nearest to the draught at the start, with the interpolated database."""
    weights = _draught_weights(rest - body.position[2], [member.draught for member in members])
    nearest = members[int(weights.argmax())]
    db = _weighted_mean(nearest.database, [member.database for member in members], weights)
    db = with_hulls(db, (body,), scene.environment)
    return replace(
        nearest,
        bodies=(body,),
        database=db,
        alone={body.name: db},
        members=members,
        added_mass=np.tensordot(weights, [member.added_mass for member in members], 1),
    )


def _draught_weights(draught: float, draughts: Sequence[float]) -> np.ndarray:
    """Square roots of the weights at a draught, see `integrate.draught_interpolation`."""
    weights = np.zeros(len(draughts))
    k = int(np.clip(np.searchsorted(draughts, draught) - 1, 0, len(draughts) - 2))
    part = np.clip((draught - draughts[k]) / (draughts[k + 1] - draughts[k]), 0.0, 1.0)
    weights[k] = cos(0.5 * pi * part) ** 2
    weights[k + 1] = sin(0.5 * pi * part) ** 2
    return weights


def _weighted_mean(
    grid: HydroDatabase, databases: Sequence[HydroDatabase], weights: np.ndarray
) -> HydroDatabase:
    """Weighted mean of databases, at the frequencies and headings of one of them."""
    if weights.max() > 1.0 - 1e-12:
        return grid
    omega = grid.frequency
    heading = grid.heading
    waves = np.tile(heading, omega.size), np.repeat(omega, heading.size)
    shape = (omega.size, heading.size, 6)

    def weighted_sum(of: Iterable[np.ndarray]) -> np.ndarray:
        return np.asarray(np.tensordot(weights, list(of), 1))

    drift = None
    if all(db.mean_drift is not None for db in databases):
        drift = weighted_sum(mean_drift_at(db, *waves).reshape(shape) for db in databases)
    return replace(
        grid,
        added_mass=weighted_sum(
            _interpolate_matrices(omega, db.frequency, db.added_mass) for db in databases
        ),
        radiation_damping=weighted_sum(
            _interpolate_matrices(omega, db.frequency, db.radiation_damping) for db in databases
        ),
        excitation=weighted_sum(excitation_at(db, *waves).reshape(shape) for db in databases),
        mean_drift=drift,
        froude_krylov=None,
        mean_drift_held=None,
        drift_imbalance=None,
        qtf_frequency=None,
        qtf_heading=None,
        qtf_difference=None,
        qtf_sum=None,
        added_mass_zero=None,
        added_mass_infinite=None,
    )


def _interpolate_matrices(omega: np.ndarray, nodes: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Matrices (nw, n, n) at other frequencies, linear between the ``nodes``."""
    columns = values.reshape(nodes.size, -1).T
    return np.array([np.interp(omega, nodes, value) for value in columns]).T.reshape(-1, 6, 6)
