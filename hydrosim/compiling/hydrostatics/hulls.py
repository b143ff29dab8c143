"""Closed hulls of a scene: constants of their buoyancy, and stiffness at rest."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.compiling.hydrostatics.solids import solids_of
from hydrosim.database.database import HydroDatabase, require_array
from hydrosim.database.hull import immersed_triangles, integrals
from hydrosim.dofs import SYMMETRY_RTOL
from hydrosim.forces.displacement import MeshHulls, add_displacement_energy
from hydrosim.forces.layout import HYDROSTATIC
from hydrosim.rigid.kinematics import Bodies, Motion, new_motion
from hydrosim.scene import Body, Environment, Hull, Scene, Weight

if TYPE_CHECKING:
    from hydrosim.database.hydrostatics import Hydrostatics

COMPARED_ATTITUDES = 20  # attitudes at which a hull is compared with its mirror image
ROLL_INDEX = 3  # index among a body's six coordinates


def hulls_of(scene: Scene, bodies: Bodies) -> MeshHulls:
    """Constants of the hulls of all bodies that have one."""
    chosen = [(b, body, body.hydrostatics) for b, body in enumerate(scene.bodies)]
    each = [(b, body, hull) for b, body, hull in chosen if hull is not None]
    water = scene.environment
    places = [6 * b + ROLL_INDEX for b, *_ in each]
    return MeshHulls(
        body=np.array([b for b, *_ in each], dtype=np.int64),
        solids=solids_of([hull.corners - np.array(b.centre_of_gravity) for _, b, hull in each]),
        height=np.array([body.centre_of_gravity[2] for _, body, _ in each], dtype=float),
        weight=np.reshape([_weight(body, hull) for _, body, hull in each], (-1, 4)),
        density=water.water_density * water.gravity,
        roll=np.flatnonzero(np.isin(bodies.active, places)),
    )


def at_rest(body: Body, hull: Hull, water: Environment) -> tuple[Hydrostatics, np.ndarray]:
    """Hydrostatics of a hull at rest, and its stiffness (6, 6) about the centre of gravity."""
    found, (x, y, z) = integrals(immersed_triangles(hull.corners)), body.centre_of_gravity
    below = np.array([x, y, found.centre_of_buoyancy[2]])
    about = replace(found, centre_of_buoyancy=below)
    return found, about.stiffness(z, water.water_density, water.gravity)


def with_hulls(db: HydroDatabase, bodies: Sequence[Body], water: Environment) -> HydroDatabase:
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
        found, own = at_rest(body, body.hydrostatics, water)
        volume[k], centre[k] = found.volume, found.centre_of_buoyancy
        stiffness[6 * k : 6 * k + 6, 6 * k : 6 * k + 6] = own
    return replace(db, hydrostatic_stiffness=stiffness, volume=volume, centre_of_buoyancy=centre)


def asymmetric_hulls(p: MeshHulls, bodies: Bodies) -> Iterator[int]:
    """Bodies whose hull heels differently to port and to starboard: it is not its own mirror
    image."""
    motion, draw = new_motion(bodies), np.random.default_rng(1)
    for h, b in enumerate(p.body):
        solids = p.solids._replace(first=p.solids.first[h : h + 2])
        own = p._replace(body=p.body[h : h + 1], solids=solids)
        own = own._replace(height=p.height[h : h + 1], weight=p.weight[h : h + 1])
        size, depth = (np.ptp(p.solids.corners[..., axis]) for axis in (1, 2))
        for _ in range(COMPARED_ATTITUDES):
            heave, trim, heel = draw.uniform(-0.5, 0.5, 3) * (depth, 0.1, depth / size)
            motion.coordinates[6 * b + 2] = heave
            port, starboard = (
                _hydrostatic_energy(own, bodies, motion, b, trim, x) for x in (heel, -heel)
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


def _weight(body: Body, hull: Hull) -> np.ndarray:
    """V_0 and V_0 p of a body whose weight is balanced at rest; zero for a body that carries its
    weight."""
    if body.weight == Weight.CARRIED:
        return np.zeros(4)
    found = integrals(immersed_triangles(hull.corners))
    over = found.centre_of_buoyancy - body.centre_of_gravity
    return found.volume * np.array([1.0, over[0], over[1], 0.0])
