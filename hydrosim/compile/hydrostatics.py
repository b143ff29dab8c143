"""Hulls, weights and changing tanks as constants of a model, with closed meshes as `Solids`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from hydrosim import scene as scenes
from hydrosim.database.database import HydroDatabase, require_array
from hydrosim.database.hull import Hydrostatics, Triangles, areas, immersed_triangles, integrals
from hydrosim.dofs import SYMMETRY_RTOL
from hydrosim.elements.hydrostatics import MeshHulls, add_displacement_energy
from hydrosim.elements.kind import HYDROSTATIC
from hydrosim.multibody.kinematics import Bodies, Motion, new_motion
from hydrosim.multibody.solids import MOMENTS, Solids
from hydrosim.tanks.contents import changing_tanks
from hydrosim.tanks.shapes import capacity, pieces, triangles, volume_at
from hydrosim.tanks.surface import LIQUID, PIECE_DTYPE, Liquids

# Solids: groups of neighbouring triangles of closed meshes.

# Ratio of a triangle's horizontal projection to its area, below which it counts as upright.
MIN_WATERPLANE_FRACTION = 1e-12
PARCEL = 16  # triangles of a group at most
HEIGHT_WEIGHT = (
    4.0  # weight of height in the split: triangles at one height get wet at the same time
)


def solids_of(meshes: Sequence[Triangles]) -> Solids:
    """Constants of closed meshes."""
    parcels = [_split_parcels(_box_faces(corners)) for corners in meshes]
    parts = [part for body_parcels in parcels for part in body_parcels]
    every = np.concatenate([np.zeros((0, 3, 3)), *parts])
    return Solids(
        first=np.cumsum([0, *map(len, parcels)]).astype(np.int64),
        begin=np.cumsum([0, *map(len, parts)]).astype(np.int64),
        box=np.reshape([_bounding_box(part) for part in parts], (-1, 2, 3)),
        moments=np.array([_volume_moments(part) for part in parts], dtype=MOMENTS),
        corners=every,
        area=np.ascontiguousarray(areas(every)[:, 2]),
    )


def _box_faces(corners: Triangles) -> Triangles:
    """Triangles that are not upright."""
    vectors = areas(corners)
    return corners[
        np.abs(vectors[:, 2]) > MIN_WATERPLANE_FRACTION * np.linalg.norm(vectors, axis=1)
    ]


def _split_parcels(corners: np.ndarray) -> list[np.ndarray]:
    """Groups of a few neighbouring triangles (nt, 3, 3)."""
    middles, size = corners.mean(axis=1), np.ptp(corners, axis=(0, 1))
    return [corners[rows] for rows in _split_in_groups(middles / size * [1.0, 1.0, HEIGHT_WEIGHT])]


def _split_in_groups(middles: np.ndarray) -> list[np.ndarray]:
    """Indices of points (n, 3), halved along their longest side until groups are small."""
    rows = np.arange(len(middles))
    if rows.size <= PARCEL:
        return [rows]
    order = np.argsort(middles[:, np.ptp(middles, axis=0).argmax()], kind="stable")
    halves = np.array_split(order, 2)
    return [half[indices] for half in halves for indices in _split_in_groups(middles[half])]


def _bounding_box(corners: np.ndarray) -> np.ndarray:
    """Centre of the bounding box of triangles, and its half sides, (2, 3)."""
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    return np.array([(low + high) / 2.0, (high - low) / 2.0])


def _volume_moments(corners: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """`MOMENTS` of triangles. Midpoints of edges integrate quadratic functions exactly."""
    A, points = areas(corners)[:, 2], (corners + np.roll(corners, -1, axis=1)) / 2.0
    second = np.einsum("k,kpi,kpj->ij", A / 3.0, points, points)
    return float(A.sum()), A @ corners.mean(axis=1), second


# Closed hulls of a scene: constants of their buoyancy, and stiffness at rest.

COMPARED_ATTITUDES = 20  # attitudes at which a hull is compared with its mirror image
ROLL_INDEX = 3  # index among a body's six coordinates


def hulls_of(scene: scenes.Scene, bodies: Bodies) -> MeshHulls:
    """Constants of the hulls of all bodies that have one."""
    chosen = [(b, body, body.hydrostatics) for b, body in enumerate(scene.bodies)]
    meshes = [(b, body, hull) for b, body, hull in chosen if hull is not None]
    water = scene.environment
    places = [6 * b + ROLL_INDEX for b, *_ in meshes]
    return MeshHulls(
        body=np.array([b for b, *_ in meshes], dtype=np.int64),
        solids=solids_of([hull.corners - np.array(b.centre_of_gravity) for _, b, hull in meshes]),
        height=np.array([body.centre_of_gravity[2] for _, body, _ in meshes], dtype=float),
        weight=np.reshape([_weight_stiffness(body, hull) for _, body, hull in meshes], (-1, 4)),
        density=water.water_density * water.gravity,
        roll=np.flatnonzero(np.isin(bodies.active, places)),
    )


def at_rest(
    body: scenes.Body, hull: scenes.Hull, water: scenes.Environment
) -> tuple[Hydrostatics, np.ndarray]:
    """Hydrostatics of a hull at rest, and its stiffness (6, 6) about the centre of gravity."""
    hull_integrals, (x, y, z) = integrals(immersed_triangles(hull.corners)), body.centre_of_gravity
    below = np.array([x, y, hull_integrals.centre_of_buoyancy[2]])
    about = replace(hull_integrals, centre_of_buoyancy=below)
    return hull_integrals, about.stiffness(z, water.water_density, water.gravity)


def with_hulls(
    db: HydroDatabase, bodies: Sequence[scenes.Body], water: scenes.Environment
) -> HydroDatabase:
    """Database of these bodies, with the hydrostatics of those that have a hull."""
    if all(body.hydrostatics is None for body in bodies):
        return db
    size = len(bodies)
    stiffness = np.zeros((6 * size, 6 * size))
    if db.hydrostatic_stiffness is not None:
        stiffness += db.hydrostatic_stiffness
    volume, centre = np.zeros(size), np.zeros((size, 3))
    for k, body in enumerate(bodies):
        if body.hydrostatics is None:
            volume[k], centre[k] = (
                require_array(db, "volume")[k],
                require_array(db, "centre_of_buoyancy")[k],
            )
            continue
        body_hydrostatics, body_stiffness = at_rest(body, body.hydrostatics, water)
        volume[k], centre[k] = body_hydrostatics.volume, body_hydrostatics.centre_of_buoyancy
        stiffness[6 * k : 6 * k + 6, 6 * k : 6 * k + 6] = body_stiffness
    return replace(db, hydrostatic_stiffness=stiffness, volume=volume, centre_of_buoyancy=centre)


def asymmetric_hulls(p: MeshHulls, bodies: Bodies) -> Iterator[int]:
    """Bodies whose hull heels differently to port and to starboard: it is not its own mirror
    image."""
    motion, draw = new_motion(bodies), np.random.default_rng(1)
    for h, b in enumerate(p.body):
        solids = p.solids._replace(first=p.solids.first[h : h + 2])
        single_hull = p._replace(body=p.body[h : h + 1], solids=solids)
        single_hull = single_hull._replace(height=p.height[h : h + 1], weight=p.weight[h : h + 1])
        size, depth = (np.ptp(p.solids.corners[..., axis]) for axis in (1, 2))
        for _ in range(COMPARED_ATTITUDES):
            heave, trim, heel = draw.uniform(-0.5, 0.5, 3) * (depth, 0.1, depth / size)
            motion.coordinates[6 * b + 2] = heave
            port, starboard = (
                _hydrostatic_energy(single_hull, bodies, motion, b, trim, x) for x in (heel, -heel)
            )
            if abs(port - starboard) > SYMMETRY_RTOL * abs(port):
                yield int(b)
                break


def _hydrostatic_energy(
    p: MeshHulls, bodies: Bodies, motion: Motion, b: int, trim: float, heel: float
) -> float:
    stored = np.zeros(HYDROSTATIC + 1)
    motion.rotation[b, 2] = np.array([trim, heel, 1.0]) / np.sqrt(1.0 + trim**2 + heel**2)
    add_displacement_energy(motion, bodies, p, stored)
    return float(stored[HYDROSTATIC])


def _weight_stiffness(body: scenes.Body, hull: scenes.Hull) -> np.ndarray:
    """V_0 and V_0 p of a body whose weight is balanced at rest; zero for a body that carries its
    weight."""
    if body.weight == scenes.Weight.CARRIED:
        return np.zeros(4)
    hull_integrals = integrals(immersed_triangles(hull.corners))
    over = hull_integrals.centre_of_buoyancy - body.centre_of_gravity
    return hull_integrals.volume * np.array([1.0, over[0], over[1], 0.0])


# Tanks whose surface stays level at any heel and trim, as constants of a model.

CONSTANT_CONTENTS = -1
ROLL_COORDINATE = 3  # index among a body's six coordinates


class Cut(NamedTuple):
    """A ``tank`` of the body with index ``body``; the liquid surface cuts its ``shape``."""

    body: int
    tank: scenes.Tank
    shape: scenes.Box | scenes.TankMesh


def cut_shape(tank: scenes.Tank, scene: scenes.Scene) -> scenes.Box | scenes.TankMesh | None:
    """Shape of a tank whose surface is found as a plane that cuts it. None if the shape is unknown,
    and in linear kinematics, where moments are linear in the angles."""
    level = tank.free_surface == scenes.FreeSurface.QUASI_STATIC
    if not level or scene.solver.kinematics == scenes.Kinematics.LINEAR:
        return None
    return None if isinstance(tank.shape, scenes.TankTable) else tank.shape


def cut_tanks(scene: scenes.Scene) -> Iterator[Cut]:
    """All tanks with a cut shape, in the order of `Liquids`."""
    for b, body in enumerate(scene.bodies):
        for tank in body.tanks:
            shape = cut_shape(tank, scene)
            if shape is not None:
                yield Cut(b, tank, shape)


def liquids_of(scene: scenes.Scene, bodies: Bodies) -> Liquids:
    """Constants of all tanks with a cut shape."""
    every = list(cut_tanks(scene))
    origins = [np.asarray(scene.bodies[cut.body].centre_of_gravity) for cut in every]
    tables = [pieces(cut.shape, at) for cut, at in zip(every, origins, strict=True)]
    ends = pairwise(np.cumsum([0, *map(len, tables)]))
    index = _places_of_volumes(scene)
    liquids = [
        (
            cut.body,
            index.get((cut.body, cut.tank.name), CONSTANT_CONTENTS),
            volume_at(cut.shape, cut.tank.level),
            first,
            end - 1,
            cut.tank.density,
            capacity(cut.shape),
            cut.shape.permeability,
        )
        for cut, (first, end) in zip(every, ends, strict=True)
    ]
    meshes = [triangles(cut.shape) - at for cut, at in zip(every, origins, strict=True)]
    rolls = [6 * cut.body + ROLL_COORDINATE for cut in every]
    return Liquids(
        each=np.array(liquids, dtype=LIQUID),
        pieces=np.concatenate([np.zeros(0, dtype=PIECE_DTYPE), *tables]),
        solids=solids_of(meshes),
        roll=np.flatnonzero(np.isin(bodies.active, rolls)),
    )


def _places_of_volumes(scene: scenes.Scene) -> dict[tuple[int, str], int]:
    """Tanks whose contents change, by body and name, in the order of `Tanks`."""
    every = [(b, tank.name) for b, body in enumerate(scene.bodies) for tank in changing_tanks(body)]
    return {name: k for k, name in enumerate(every)}
