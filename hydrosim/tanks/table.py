"""A tank given by a table: smooth curves through its rows.

S is a cubic spline through V times the centroids. Level and J are monotone between the rows
(Fritsch & Carlson 1980). P follows by quadrature of S' S'^T + J / (dV/dh).
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from hydrosim.scene import TankTable
from hydrosim.tanks.pieces import (
    FLUID_LEVEL,
    PAIRS,
    PIECE_DTYPE,
    SECOND_MOMENT,
    SURFACE_MOMENT,
    TANK_QUANTITIES,
    hermite,
)

PIECES_PER_ROW = 8  # pieces between two rows of a table
GAUSS_POINTS, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(5)


def pieces_of_table(shape: TankTable, origin: np.ndarray) -> np.ndarray:
    """The pieces (n,) of `PIECE_DTYPE` of a table, about ``origin`` (3,) [m] of the body's
    frame."""
    from scipy.interpolate import CubicSpline

    volume = np.asarray(shape.volume, float)
    first = CubicSpline(volume, volume[:, None] * (np.asarray(shape.centroid) - origin))
    level, surface = level_of_table(shape), _monotone(volume, np.asarray(shape.surface, float))
    starts = np.concatenate([_subdivide(a, b) for a, b in pairwise(volume)])
    ends = np.append(starts[1:], volume[-1])
    found = np.zeros(starts.size, dtype=PIECE_DTYPE)
    found["start"] = starts
    for k in range(4):
        order = float(max(1, k * (k - 1)))  # k!, up to 3
        for i, curve in (
            (slice(0, 3), first),
            (FLUID_LEVEL, level),
            (slice(SURFACE_MOMENT, TANK_QUANTITIES), surface),
        ):
            found["c"][:, i, k] = curve(starts, k) / order

    def rate(v: np.ndarray) -> np.ndarray:
        r, J = first(v, 1), surface(v) * level(v, 1)[:, None]
        spread = np.stack([J[:, 0], J[:, 2], 0.0 * v, J[:, 1], 0.0 * v, 0.0 * v], axis=1)
        return np.stack([r[:, i] * r[:, j] for i, j in PAIRS], axis=1) + spread

    half = 0.5 * (ends - starts)
    grown = sum(
        w * rate(starts + half * (1.0 + x))
        for x, w in zip(GAUSS_POINTS, GAUSS_WEIGHTS, strict=True)
    )
    grown = half[:, None] * grown
    held = np.vstack([np.zeros(6), np.cumsum(grown, axis=0)[:-1]])
    found["c"][:, SECOND_MOMENT:FLUID_LEVEL] = hermite(
        held, grown, rate(starts), rate(ends), 2.0 * half
    )
    return found


def _subdivide(a: float, b: float) -> np.ndarray:
    return np.linspace(a, b, PIECES_PER_ROW, endpoint=False)


def level_of_table(shape: TankTable) -> Any:
    """The level [m] as a function of the volume [m^3]."""
    return _monotone(np.asarray(shape.volume, float), np.asarray(shape.level, float))


def _monotone(x: np.ndarray, y: np.ndarray) -> Any:
    from scipy.interpolate import PchipInterpolator

    return PchipInterpolator(x, y)
