"""What a tank holds, over the volume V of the fluid in it.

    S(V) = int r dV,   P(V) = int r r^T dV,   level h(V),   J(V) of the free surface

in the body frame, as cubics in V on pieces. What is added or taken lies at the surface, about its
centroid S'(V); so P' = S' S'^T + J / (dV/dh) for a surface level in the body. A box is exact; of a
table S is a cubic spline through V times the centroids, h and J are monotone between the rows
(Fritsch & Carlson 1980), and P follows from these by quadrature.
"""

from __future__ import annotations

from functools import singledispatch
from itertools import pairwise
from typing import Any

import numpy as np

from hydrosim.scene import Box, TankTable

FIRST, SECOND, LEVEL, SURFACE, ALL = 0, 3, 9, 10, 13
"""Where S (3), P (xx, yy, zz, xy, xz, yz), h and J (xx, xy, yy) begin; their number."""
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
PIECE = np.dtype([("start", float), ("c", float, (ALL, 4))])
"""Coefficients of 1, x, x^2, x^3, x = V - start."""
PARTS = 8  # pieces between two rows of a table
NODES, WEIGHTS = np.polynomial.legendre.leggauss(5)


@singledispatch
def pieces(shape: Box | TankTable, origin: np.ndarray) -> np.ndarray:
    """The pieces (n,) of `PIECE` of a shape, about ``origin`` (3,) [m] of the body's frame."""
    raise TypeError(shape)


def capacity(shape: Box | TankTable) -> float:
    """Volume of the fluid in a full tank [m^3]."""
    if isinstance(shape, TankTable):
        return float(shape.volume[-1])
    return float(shape.permeability * np.prod(np.subtract(shape.high, shape.low)))


def at(table: np.ndarray, volume: float) -> np.ndarray:
    """All quantities (13,) of the pieces of a tank at a volume [m^3]."""
    piece = table[max(int(np.searchsorted(table["start"], volume, side="right")) - 1, 0)]
    return np.asarray(piece["c"] @ (volume - piece["start"]) ** np.arange(4))


def volume_at(shape: Box | TankTable, level: float) -> float:
    """Volume of the fluid [m^3] up to a level above the tank's bottom [m]."""
    if isinstance(shape, TankTable):
        return _root(lambda v: float(_level(shape)(v)) - level, capacity(shape))
    return capacity(shape) * level / (shape.high[2] - shape.low[2])


def height(shape: Box | TankTable) -> float:
    """Level of a full tank [m]."""
    if isinstance(shape, TankTable):
        return float(shape.level[-1])
    return shape.high[2] - shape.low[2]


def _root(f: Any, end: float) -> float:
    from scipy.optimize import brentq  # slow to load, and few scenes have a table

    if f(0.0) >= 0.0 or f(end) <= 0.0:
        return 0.0 if f(0.0) >= 0.0 else end
    return float(brentq(f, 0.0, end, xtol=1e-14 * end, rtol=1e-14))


@pieces.register
def _(shape: Box, origin: np.ndarray) -> np.ndarray:
    low, high = np.subtract(shape.low, origin), np.subtract(shape.high, origin)
    size, middle, bottom = high - low, 0.5 * (high + low), low[2]
    rise = 1.0 / (shape.permeability * size[0] * size[1])  # dh/dV
    c = np.zeros((ALL, 4))
    c[0, 1], c[1, 1] = middle[:2]
    c[2, 1:3] = bottom, 0.5 * rise
    c[SECOND, 1], c[SECOND + 1, 1] = middle[:2] ** 2 + size[:2] ** 2 / 12.0
    c[SECOND + 2, 1:] = bottom**2, bottom * rise, rise**2 / 3.0
    c[SECOND + 3, 1] = middle[0] * middle[1]
    for i in (0, 1):
        c[SECOND + 4 + i] = middle[i] * c[2]
    c[LEVEL, 1] = rise
    c[SURFACE, 0], c[SURFACE + 2, 0] = size[:2] ** 2 / (12.0 * rise)
    return np.array([(0.0, c)], dtype=PIECE)


@pieces.register
def _(shape: TankTable, origin: np.ndarray) -> np.ndarray:
    from scipy.interpolate import CubicSpline

    volume = np.asarray(shape.volume, float)
    first = CubicSpline(volume, volume[:, None] * (np.asarray(shape.centroid) - origin))
    level, surface = _level(shape), _monotone(volume, np.asarray(shape.surface, float))
    starts = np.concatenate([_within(a, b) for a, b in pairwise(volume)])
    ends = np.append(starts[1:], volume[-1])
    found = np.zeros(starts.size, dtype=PIECE)
    found["start"] = starts
    for k in range(4):
        order = float(max(1, k * (k - 1)))  # k!, up to 3
        for i, curve in ((slice(0, 3), first), (LEVEL, level), (slice(SURFACE, ALL), surface)):
            found["c"][:, i, k] = curve(starts, k) / order

    def rate(v: np.ndarray) -> np.ndarray:
        r, J = first(v, 1), surface(v) * level(v, 1)[:, None]
        spread = np.stack([J[:, 0], J[:, 2], 0.0 * v, J[:, 1], 0.0 * v, 0.0 * v], axis=1)
        return np.stack([r[:, i] * r[:, j] for i, j in PAIRS], axis=1) + spread

    half = 0.5 * (ends - starts)
    grown = sum(w * rate(starts + half * (1.0 + x)) for x, w in zip(NODES, WEIGHTS, strict=True))
    grown = half[:, None] * grown
    held = np.vstack([np.zeros(6), np.cumsum(grown, axis=0)[:-1]])
    found["c"][:, SECOND:LEVEL] = _hermite(held, grown, rate(starts), rate(ends), 2.0 * half)
    return found


def _within(a: float, b: float) -> np.ndarray:
    return np.linspace(a, b, PARTS, endpoint=False)


def _level(shape: TankTable) -> Any:
    return _monotone(np.asarray(shape.volume, float), np.asarray(shape.level, float))


def _monotone(x: np.ndarray, y: np.ndarray) -> Any:
    from scipy.interpolate import PchipInterpolator

    return PchipInterpolator(x, y)


def _hermite(
    start: np.ndarray, gain: np.ndarray, slope: np.ndarray, last: np.ndarray, length: np.ndarray
) -> np.ndarray:
    """Coefficients (n, 6, 4) of cubics with these values and slopes at both ends."""
    x = length[:, None]
    bend = (3.0 * gain / x - 2.0 * slope - last) / x
    return np.stack([start, slope, bend, (slope + last - 2.0 * gain / x) / x**2], axis=2)
