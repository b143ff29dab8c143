"""Tanks whose surface stays level at any heel and trim, as constants of a model."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from hydrosim.compiling.hydrostatics.solids import solids_of
from hydrosim.rigid.kinematics import Bodies
from hydrosim.scene import Box, FreeSurface, Kinematics, Scene, Tank, TankMesh, TankTable
from hydrosim.tanks.contents import changing_tanks
from hydrosim.tanks.pieces import PIECE_DTYPE
from hydrosim.tanks.shapes import capacity, pieces, triangles, volume_at
from hydrosim.tanks.surface import LIQUID, Liquids

CONSTANT_CONTENTS = -1
ROLL_COORDINATE = 3  # index among a body's six coordinates


class Cut(NamedTuple):
    """A ``tank`` of the body with index ``body``; the liquid surface cuts its ``shape``."""

    body: int
    tank: Tank
    shape: Box | TankMesh


def cut_shape(tank: Tank, scene: Scene) -> Box | TankMesh | None:
    """Shape of a tank whose surface is found as a plane that cuts it. None if the shape is unknown,
    and in linear kinematics, where moments are linear in the angles."""
    level = tank.surface == FreeSurface.QUASI_STATIC
    if not level or scene.solver.kinematics == Kinematics.LINEAR:
        return None
    return None if isinstance(tank.shape, TankTable) else tank.shape


def cut_tanks(scene: Scene) -> Iterator[Cut]:
    """All tanks with a cut shape, in the order of `Liquids`."""
    for b, body in enumerate(scene.bodies):
        for tank in body.tanks:
            shape = cut_shape(tank, scene)
            if shape is not None:
                yield Cut(b, tank, shape)


def liquids_of(scene: Scene, bodies: Bodies) -> Liquids:
    """Constants of all tanks with a cut shape."""
    every = list(cut_tanks(scene))
    origins = [np.asarray(scene.bodies[cut.body].centre_of_gravity) for cut in every]
    tables = [pieces(cut.shape, at) for cut, at in zip(every, origins, strict=True)]
    ends = pairwise(np.cumsum([0, *map(len, tables)]))
    index = _places_of_volumes(scene)
    each = [
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
        each=np.array(each, dtype=LIQUID),
        pieces=np.concatenate([np.zeros(0, dtype=PIECE_DTYPE), *tables]),
        solids=solids_of(meshes),
        roll=np.flatnonzero(np.isin(bodies.active, rolls)),
    )


def _places_of_volumes(scene: Scene) -> dict[tuple[int, str], int]:
    """Tanks whose contents change, by body and name, in the order of `Tanks`."""
    every = [(b, tank.name) for b, body in enumerate(scene.bodies) for tank in changing_tanks(body)]
    return {name: k for k, name in enumerate(every)}
