"""Contents of a tank over the volume V of its fluid.

    S(V) = int r dV,   P(V) = int r r^T dV,   level h(V),   J(V) of the free surface

in the body frame, as cubics in V on pieces. Added or removed fluid lies at the surface, about its
centroid S'(V). So P' = S' S'^T + J / (dV/dh) for a surface that is level in the body. An empty tank
and a full one have no free surface: J vanishes smoothly over the last `SHALLOW` of the volume. J
counts where the tilted surface is not computed (`hydrosim.tanks.surface`): in tables, and in linear
kinematics.
"""

from __future__ import annotations

import numpy as np

from hydrosim.jit.kernels import kernel

FIRST_MOMENT, SECOND_MOMENT, FLUID_LEVEL, SURFACE_MOMENT, TANK_QUANTITIES = 0, 3, 9, 10, 13
"""First entries of S (3), P (xx, yy, zz, xy, xz, yz), h and J (xx, xy, yy); number of all
entries."""
SHALLOW = 0.01  # of a tank's volume
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
PIECE_DTYPE = np.dtype([("start", float), ("c", float, (TANK_QUANTITIES, 4))])
"""Coefficients of 1, x, x^2, x^3, x = V - start."""


def quantities_at(table: np.ndarray, volume: float) -> np.ndarray:
    """All quantities (13,) of the pieces of a tank at a volume [m^3]."""
    piece = table[max(int(np.searchsorted(table["start"], volume, side="right")) - 1, 0)]
    return np.asarray(piece["c"] @ (volume - piece["start"]) ** np.arange(4))


def values_at(table: np.ndarray, volume: np.ndarray, which: int) -> np.ndarray:
    """One quantity (n,) of the pieces of a tank at volumes (n,) [m^3]."""
    c, x = _cubics(table, volume, which)
    return np.asarray(np.einsum("nk,nk->n", c, x[:, None] ** np.arange(4)))


def slopes_at(table: np.ndarray, volume: np.ndarray, which: int) -> np.ndarray:
    """Derivatives (n,) of one quantity by the volume."""
    c, x = _cubics(table, volume, which)
    return np.asarray(c[:, 1] + x * (2.0 * c[:, 2] + x * 3.0 * c[:, 3]))


def _cubics(table: np.ndarray, volume: np.ndarray, which: int) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients (n, 4) of a quantity at volumes (n,), and the offsets of these from the start of
    their piece."""
    of = np.maximum(np.searchsorted(table["start"], volume, side="right") - 1, 0)
    return table["c"][of, which], volume - table["start"][of]


def hermite(
    start: np.ndarray, gain: np.ndarray, slope: np.ndarray, last: np.ndarray, length: np.ndarray
) -> np.ndarray:
    """Coefficients (n, 6, 4) of cubics with these values and slopes at both ends."""
    x = length[:, None]
    bend = (3.0 * gain / x - 2.0 * slope - last) / x
    return np.stack([start, slope, bend, (slope + last - 2.0 * gain / x) / x**2], axis=2)


def with_ends(table: np.ndarray, full: float) -> np.ndarray:
    """The pieces of a tank of this volume [m^3], with a surface J that vanishes at both ends."""
    low, high = SHALLOW * full, (1.0 - SHALLOW) * full
    starts = np.union1d(table["start"], [low, high])
    of = np.searchsorted(table["start"], starts, side="right") - 1
    pieces = np.zeros(starts.size, dtype=PIECE_DTYPE)
    pieces["start"], pieces["c"] = (
        starts,
        _shift_cubics(table["c"][of], starts - table["start"][of]),
    )
    inner = [pieces["c"][np.searchsorted(starts, v), SURFACE_MOMENT:, :2].T for v in (low, high)]
    nothing = np.zeros((1, TANK_QUANTITIES - SURFACE_MOMENT))
    for begin, first, last in ((0.0, nothing, inner[0]), (high, inner[1], nothing)):
        ends = (
            np.broadcast_to(end, (2, TANK_QUANTITIES - SURFACE_MOMENT))[:, None]
            for end in (first, last)
        )
        (value, slope), (then, slope_then) = ends
        curve = hermite(value, then - value, slope, slope_then, np.array([low]))[0]
        in_piece = (starts >= begin) & (starts < begin + low)
        pieces["c"][in_piece, SURFACE_MOMENT:] = _shift_cubics(
            curve[None], starts[in_piece] - begin
        )
    return pieces


def _shift_cubics(c: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Coefficients (n, m, 4) of the same cubics about a point shifted by x (n,)."""
    a, b, d, e = np.moveaxis(c, -1, 0)
    x = x[:, None]
    coefficients = (a + x * (b + x * (d + x * e)), b + x * (2 * d + x * 3 * e), d + x * 3 * e)
    return np.stack([*coefficients, np.broadcast_to(e, coefficients[0].shape)], axis=-1)


@kernel
def value(piece, i, x):
    """Quantity i at x from the start of a piece."""
    c = piece.c
    return c[i, 0] + x * (c[i, 1] + x * (c[i, 2] + x * c[i, 3]))


@kernel
def slope(piece, i, x):
    """Derivative of quantity i by V."""
    c = piece.c
    return c[i, 1] + x * (2.0 * c[i, 2] + x * 3.0 * c[i, 3])


@kernel
def bend(piece, i, x):
    """Second derivative of quantity i by V."""
    c = piece.c
    return 2.0 * c[i, 2] + x * 6.0 * c[i, 3]
