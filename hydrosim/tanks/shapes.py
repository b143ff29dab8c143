"""Shapes of tanks: boxes, tables and meshes, and their contents as cubic pieces.

A tank between plane triangles: its contents up to each height, from level sections.

Between two heights of corners the area of a level section is a polynomial of the height of degree
2, its first moments of degree 3, its second ones of degree 4. Five sections determine all of them,
and a Gauss rule with these five integrates them exactly. So S, P, level and J, and their slopes
over V, are exact at the ends of all pieces. Cubics interpolate between the ends; they are exact for
upright walls.

Where a section vanishes, at an edge or a corner, slopes over V are infinite: pieces there are
short, and quadratic. A mesh with more than `MAX_PIECES` heights is cut at the same number of evenly
spaced ones.

A tank given by a table: S is a cubic spline through V times the centroids. Level and J are monotone
between the rows (Fritsch & Carlson 1980). P follows by quadrature of S' S'^T + J / (dV/dh).
"""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from hydrosim.errors import InputError
from hydrosim.scene import Box, TankMesh, TankShape, TankTable
from hydrosim.tanks.surface import (
    FLUID_LEVEL,
    PAIRS,
    PIECE_DTYPE,
    SECOND_MOMENT,
    SURFACE_MOMENT,
    TANK_QUANTITIES,
    hermite,
    quantities_at,
    slopes_at,
    values_at,
    with_ends,
)

MIN_PIECES, MAX_PIECES = 64, 256  # pieces
EQUAL_HEIGHT_RTOL = 1e-9  # of its height: heights this close are equal
VANISHED_SECTION_RTOL = 1e-9  # of the largest section: smaller ones have vanished
# of the mean slope of level over V: with a steeper one the cubic could fall in between
STEEPEST = 3.0
GAUSS_POINTS, GAUSS_WEIGHTS = (0.5 * x for x in np.polynomial.legendre.leggauss(5))
GAUSS_POINTS += 0.5
POWERS = np.linalg.inv(GAUSS_POINTS[:, None] ** np.arange(5))
END_VALUES = POWERS[0], POWERS.sum(axis=0)  # values of a polynomial at both ends, from its nodes
RATES = POWERS[1], np.arange(5) @ POWERS  # derivatives at both ends


def pieces_of_mesh(shape: TankMesh, origin: np.ndarray) -> np.ndarray:
    """The pieces (n,) of `PIECE_DTYPE` of a mesh, about ``origin`` (3,) [m] of the body's frame.
    Raises InputError where a level section of the mesh has no area."""
    return _mesh_pieces(shape, *np.asarray(origin, float).tolist())


class _End(NamedTuple):
    """One end of all pieces: whether the section is ``solid`` there (n,), the ``slope`` over V of
    all quantities (n, 13), and the ``surface`` J (n, 3)."""

    solid: np.ndarray
    slope: np.ndarray
    surface: np.ndarray


@lru_cache(maxsize=64)
def _mesh_pieces(shape: TankMesh, *origin: float) -> np.ndarray:
    corners = shape.corners - np.array(origin)
    heights = _corner_heights(corners)
    step = np.diff(heights)
    z = heights[:-1, None] + step[:, None] * GAUSS_POINTS
    moments = shape.permeability * np.array([[section(corners, h) for h in row] for row in z])
    _check_room(moments[..., 0], z - heights[0], shape.source)
    rates = _rates(moments, z)
    first, last = (_end_of_piece(e, moments, rates, step) for e in (0, 1))
    volume = step * (moments[..., 0] @ GAUSS_WEIGHTS)
    gain = np.zeros((step.size, TANK_QUANTITIES))
    gain[:, :FLUID_LEVEL] = step[:, None] * np.einsum("k,nkq->nq", GAUSS_WEIGHTS, rates)
    gain[:, FLUID_LEVEL], gain[:, SURFACE_MOMENT:] = step, last.surface - first.surface
    start = np.cumsum(gain, axis=0) - gain
    start[:, SURFACE_MOMENT:] = first.surface
    pieces = np.zeros(step.size, dtype=PIECE_DTYPE)
    pieces["start"] = np.cumsum(volume) - volume
    pieces["c"] = hermite(start, gain, *_end_slopes(first, last, gain / volume[:, None]), volume)
    return pieces


def _check_room(area: np.ndarray, level: np.ndarray, source: str) -> None:
    if area.min() <= 0.0:
        raise InputError(
            f"{source}: found no room {level[area <= 0.0][0]:.4g} m above the bottom of the tank;"
            " expected one connected room. Give rooms above each other as separate tanks."
        )


def _corner_heights(corners: np.ndarray) -> np.ndarray:
    """Heights (n + 1,) at which pieces end: the heights of corners, and more, denser towards
    vanishing sections."""
    z = np.unique(corners[..., 2])
    z = z[np.diff(z, prepend=-np.inf) > EQUAL_HEIGHT_RTOL * np.ptp(z)]
    if z.size > MAX_PIECES:
        z = np.linspace(z[0], z[-1], MAX_PIECES + 1)
    parts = -(-MIN_PIECES // (z.size - 1))
    area = [section(corners, h)[0] for h in _heights_beside(z)]
    point = np.array(area) < 1e-3 * max(area)
    even = np.linspace(0.0, 1.0, parts + 1)
    steps = [_densify_ends(even, below, above) for below, above in point.reshape(-1, 2)]
    heights = [a + (b - a) * x[:-1] for a, b, x in zip(z, z[1:], steps, strict=False)]
    return np.append(np.concatenate(heights), z[-1])


def _heights_beside(z: np.ndarray) -> np.ndarray:
    """Heights alternately just above and just below the ends of the intervals of ``z``."""
    inside = 1e-6 * np.diff(z)
    return np.column_stack([z[:-1] + inside, z[1:] - inside]).ravel()


def _densify_ends(x: np.ndarray, below: bool, above: bool) -> np.ndarray:
    """Map of 0 <= x <= 1 that makes points dense at one or both ends."""
    if below and above:
        return np.sin(0.5 * np.pi * x) ** 2
    return x**2 if below else 1.0 - (1.0 - x) ** 2 if above else x


def section(corners: np.ndarray, z: float) -> np.ndarray:
    """Area and moments x, y, xx, xy, yy (6,) of the section at a height, by Green's theorem around
    it. Each triangle that the plane cuts contributes the line from p to q."""
    above = corners[..., 2] > z
    cut = (above.sum(axis=1) % 3) > 0
    of, above = corners[cut], above[cut]
    up = above.sum(axis=1) == 1
    lone = np.where(up, above.argmax(axis=1), above.argmin(axis=1))
    a, b, c = (of[np.arange(lone.size), (lone + k) % 3] for k in range(3))
    p, q = (a + (x - a) * ((z - a[:, 2]) / (x[:, 2] - a[:, 2]))[:, None] for x in (b, c))
    (x, y, _), (u, v, _) = np.where(up[:, None], p, q).T, np.where(up[:, None], q, p).T
    w = x * v - u * y
    return np.array(
        [
            w.sum() / 2.0,
            w @ (x + u) / 6.0,
            w @ (y + v) / 6.0,
            w @ (x * x + x * u + u * u) / 12.0,
            w @ (2.0 * x * y + x * v + u * y + 2.0 * u * v) / 24.0,
            w @ (y * y + y * v + v * v) / 12.0,
        ]
    )


def _rates(moments: np.ndarray, z: np.ndarray) -> np.ndarray:
    """S and P (n, 5, 9) by the height."""
    A, x, y, xx, xy, yy = np.moveaxis(moments, -1, 0)
    return np.stack([x, y, A * z, xx, yy, A * z * z, xy, x * z, y * z], axis=-1)


def _end_of_piece(e: int, moments: np.ndarray, rates: np.ndarray, step: np.ndarray) -> _End:
    at, by = (np.einsum("k,nkq->qn", of[e], moments) for of in (END_VALUES, RATES))
    by, solid = by / step, at[0] > VANISHED_SECTION_RTOL * at[0].max()
    A = np.where(solid, at[0], 1.0)
    slope = np.empty((step.size, TANK_QUANTITIES))
    slope[:, :FLUID_LEVEL] = np.einsum("k,nkq->nq", END_VALUES[e], rates)
    slope[:, FLUID_LEVEL] = 1.0
    x, y = at[1] / A, at[2] / A
    surface = np.stack([at[3] - at[1] * x, at[4] - at[1] * y, at[5] - at[2] * y], axis=1)
    slope[:, SURFACE_MOMENT] = by[3] - 2.0 * x * by[1] + x * x * by[0]
    slope[:, SURFACE_MOMENT + 1] = by[4] - x * by[2] - y * by[1] + x * y * by[0]
    slope[:, SURFACE_MOMENT + 2] = by[5] - 2.0 * y * by[2] + y * y * by[0]
    return _End(solid, slope / A[:, None], np.where(solid[:, None], surface, 0.0))


def _end_slopes(first: _End, last: _End, mean: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Slopes over V at both ends; slopes of a quadratic where the section vanishes."""
    slopes = []
    for end, other in ((first, last), (last, first)):
        slope = np.where(end.solid[:, None], end.slope, 2.0 * mean - other.slope)
        slope[:, FLUID_LEVEL] = np.minimum(slope[:, FLUID_LEVEL], STEEPEST * mean[:, FLUID_LEVEL])
        slopes.append(slope)
    return slopes[0], slopes[1]


def capacity_of_mesh(shape: TankMesh) -> float:
    """Volume of the fluid in a full tank [m^3]."""
    a, b, c = np.moveaxis(shape.corners - shape.corners.mean(axis=(0, 1)), 1, 0)
    return float(shape.permeability * np.sum(a * np.cross(b, c)) / 6.0)


# Tank given by a table: smooth curves through its rows.

PIECES_PER_ROW = 8  # pieces between two rows of a table
TABLE_GAUSS_POINTS, TABLE_GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(5)


def pieces_of_table(shape: TankTable, origin: np.ndarray) -> np.ndarray:
    """The pieces (n,) of `PIECE_DTYPE` of a table, about ``origin`` (3,) [m] of the body's
    frame."""
    from scipy.interpolate import CubicSpline

    volume = np.asarray(shape.volume, float)
    first = CubicSpline(volume, volume[:, None] * (np.asarray(shape.centroid) - origin))
    level, surface = (
        level_of_table(shape),
        _monotone_spline(volume, np.asarray(shape.surface, float)),
    )
    starts = np.concatenate([_subdivide_row(a, b) for a, b in pairwise(volume)])
    ends = np.append(starts[1:], volume[-1])
    pieces = np.zeros(starts.size, dtype=PIECE_DTYPE)
    pieces["start"] = starts
    for k in range(4):
        order = float(max(1, k * (k - 1)))  # k!, up to 3
        for i, curve in (
            (slice(0, 3), first),
            (FLUID_LEVEL, level),
            (slice(SURFACE_MOMENT, TANK_QUANTITIES), surface),
        ):
            pieces["c"][:, i, k] = curve(starts, k) / order

    def rate(v: np.ndarray) -> np.ndarray:
        r, J = first(v, 1), surface(v) * level(v, 1)[:, None]
        spread = np.stack([J[:, 0], J[:, 2], 0.0 * v, J[:, 1], 0.0 * v, 0.0 * v], axis=1)
        return np.stack([r[:, i] * r[:, j] for i, j in PAIRS], axis=1) + spread

    half = 0.5 * (ends - starts)
    grown = sum(
        w * rate(starts + half * (1.0 + x))
        for x, w in zip(TABLE_GAUSS_POINTS, TABLE_GAUSS_WEIGHTS, strict=True)
    )
    grown = half[:, None] * grown
    held = np.vstack([np.zeros(6), np.cumsum(grown, axis=0)[:-1]])
    pieces["c"][:, SECOND_MOMENT:FLUID_LEVEL] = hermite(
        held, grown, rate(starts), rate(ends), 2.0 * half
    )
    return pieces


def _subdivide_row(a: float, b: float) -> np.ndarray:
    return np.linspace(a, b, PIECES_PER_ROW, endpoint=False)


def level_of_table(shape: TankTable) -> Any:
    """The level [m] as a function of the volume [m^3]."""
    return _monotone_spline(np.asarray(shape.volume, float), np.asarray(shape.level, float))


def _monotone_spline(x: np.ndarray, y: np.ndarray) -> Any:
    from scipy.interpolate import PchipInterpolator

    return PchipInterpolator(x, y)


def pieces(shape: TankShape, origin: np.ndarray) -> np.ndarray:
    """The pieces (n,) of `PIECE_DTYPE` of a shape, about ``origin`` (3,) [m] of the body's
    frame."""
    return with_ends(_fit_pieces(shape, origin), capacity(shape))


def _fit_pieces(shape: TankShape, origin: np.ndarray) -> np.ndarray:
    match shape:
        case TankTable():
            return pieces_of_table(shape, origin)
        case TankMesh():
            return pieces_of_mesh(shape, origin)
    return _pieces_of_box(shape, origin)


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
    tank_pieces = _fit_pieces(shape, np.zeros(3))
    level = values_at(tank_pieces, volume, FLUID_LEVEL)
    room = np.maximum(np.minimum(level, height(shape) - level), 0.0)
    spread = np.stack([values_at(tank_pieces, volume, SURFACE_MOMENT + i) for i in (2, 0)], axis=1)
    half = np.sqrt(
        3.0 * np.maximum(spread * slopes_at(tank_pieces, volume, FLUID_LEVEL)[:, None], 0.0)
    )
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
            return _find_root(lambda v: float(curve(v)) - level, capacity(shape))
        case TankMesh():
            tank_pieces = pieces_of_mesh(shape, np.zeros(3))
            return _find_root(
                lambda v: float(quantities_at(tank_pieces, v)[FLUID_LEVEL]) - level, capacity(shape)
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


def _find_root(f: Any, end: float) -> float:
    from scipy.optimize import brentq  # slow to load, and few scenes have such a tank

    if f(0.0) >= 0.0 or f(end) <= 0.0:
        return 0.0 if f(0.0) >= 0.0 else end
    return float(brentq(f, 0.0, end, xtol=1e-14 * end, rtol=1e-14))


def _pieces_of_box(shape: Box, origin: np.ndarray) -> np.ndarray:
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
