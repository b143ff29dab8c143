"""Shapes of tanks: boxes, tables and meshes, and their contents as `pieces`."""

from __future__ import annotations

from typing import Any

import numpy as np

from hydrosim.scene import Box, TankMesh, TankShape, TankTable
from hydrosim.tanks.mesh import capacity_of_mesh, pieces_of_mesh
from hydrosim.tanks.pieces import (
    FLUID_LEVEL,
    PIECE_DTYPE,
    SECOND_MOMENT,
    SURFACE_MOMENT,
    TANK_QUANTITIES,
    quantities_at,
    slopes_at,
    values_at,
    with_ends,
)
from hydrosim.tanks.table import level_of_table, pieces_of_table


def pieces(shape: TankShape, origin: np.ndarray) -> np.ndarray:
    """The pieces (n,) of `PIECE_DTYPE` of a shape, about ``origin`` (3,) [m] of the body's
    frame."""
    return with_ends(_pieces(shape, origin), capacity(shape))


def _pieces(shape: TankShape, origin: np.ndarray) -> np.ndarray:
    match shape:
        case TankTable():
            return pieces_of_table(shape, origin)
        case TankMesh():
            return pieces_of_mesh(shape, origin)
    return _of_box(shape, origin)


def capacity(shape: TankShape) -> float:
    """Volume of the fluid in a full tank [m^3]."""
    match shape:
        case TankTable():
            return float(shape.volume[-1])
        case TankMesh():
            return capacity_of_mesh(shape)
    return float(shape.permeability * np.prod(np.subtract(shape.high, shape.low)))


def heel_and_trim(shape: TankShape, volume: np.ndarray) -> np.ndarray:
    """The heel and the trim (n, 2) [rad] at which the level surface reaches bottom or top. They are
    computed for a box whose area and second moments equal those of the surface at volumes (n,)
    [m^3]."""
    own = _pieces(shape, np.zeros(3))
    level = values_at(own, volume, FLUID_LEVEL)
    room = np.maximum(np.minimum(level, height(shape) - level), 0.0)
    spread = np.stack([values_at(own, volume, SURFACE_MOMENT + i) for i in (2, 0)], axis=1)
    half = np.sqrt(3.0 * np.maximum(spread * slopes_at(own, volume, FLUID_LEVEL)[:, None], 0.0))
    return np.arctan2(room[:, None], half)


def triangles(shape: Box | TankMesh) -> np.ndarray:
    """The closed surface (nt, 3, 3) of a tank, normals outward."""
    if isinstance(shape, TankMesh):
        return shape.corners
    ends = np.array([shape.low, shape.high])
    corner = [[[ends[[i, j, k], [0, 1, 2]] for k in (0, 1)] for j in (0, 1)] for i in (0, 1)]
    c = np.reshape(corner, (8, 3))
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return np.array([c[list(half)] for a, b, d, e in faces for half in ((a, b, d), (a, d, e))])


def volume_at(shape: TankShape, level: float) -> float:
    """Volume of the fluid [m^3] up to a level above the tank's bottom [m]."""
    match shape:
        case TankTable():
            curve = level_of_table(shape)
            return _root(lambda v: float(curve(v)) - level, capacity(shape))
        case TankMesh():
            own = pieces_of_mesh(shape, np.zeros(3))
            return _root(
                lambda v: float(quantities_at(own, v)[FLUID_LEVEL]) - level, capacity(shape)
            )
    return capacity(shape) * level / (shape.high[2] - shape.low[2])


def height(shape: TankShape) -> float:
    """Level of a full tank [m]."""
    match shape:
        case TankTable():
            return float(shape.level[-1])
        case TankMesh():
            return float(np.ptp(shape.corners[..., 2]))
    return shape.high[2] - shape.low[2]


def _root(f: Any, end: float) -> float:
    from scipy.optimize import brentq  # slow to load, and few scenes have such a tank

    if f(0.0) >= 0.0 or f(end) <= 0.0:
        return 0.0 if f(0.0) >= 0.0 else end
    return float(brentq(f, 0.0, end, xtol=1e-14 * end, rtol=1e-14))


def _of_box(shape: Box, origin: np.ndarray) -> np.ndarray:
    """A box has one piece, which is exact."""
    low, high = np.subtract(shape.low, origin), np.subtract(shape.high, origin)
    size, middle, bottom = high - low, 0.5 * (high + low), low[2]
    rise = 1.0 / (shape.permeability * size[0] * size[1])  # dh/dV
    c = np.zeros((TANK_QUANTITIES, 4))
    c[0, 1], c[1, 1] = middle[:2]
    c[2, 1:3] = bottom, 0.5 * rise
    c[SECOND_MOMENT, 1], c[SECOND_MOMENT + 1, 1] = middle[:2] ** 2 + size[:2] ** 2 / 12.0
    c[SECOND_MOMENT + 2, 1:] = bottom**2, bottom * rise, rise**2 / 3.0
    c[SECOND_MOMENT + 3, 1] = middle[0] * middle[1]
    for i in (0, 1):
        c[SECOND_MOMENT + 4 + i] = middle[i] * c[2]
    c[FLUID_LEVEL, 1] = rise
    c[SURFACE_MOMENT, 0], c[SURFACE_MOMENT + 2, 0] = size[:2] ** 2 / (12.0 * rise)
    return np.array([(0.0, c)], dtype=PIECE_DTYPE)
