"""Piecewise straight curves of force over compression or extension, whose corners are events.

A curve consists of rows of `SEGMENT`. On each the force is smooth; the owner of a curve stores the
present segment in a column of its modes. The last slope continues beyond the last point.
"""

from __future__ import annotations

from math import inf

import numpy as np

from hydrosim.jit.kernels import kernel

SEGMENT = np.dtype(
    [(name, float) for name in ("start", "lower", "upper", "force", "slope", "energy")]
)
"""A straight piece of a curve over x. From ``lower`` to ``upper`` the force is ``force + slope (x -
start)``; ``energy`` is the stored energy at start."""


def segments(x: np.ndarray, force: np.ndarray) -> np.ndarray:
    """The straight pieces, of `SEGMENT`, through the points x (n,) [m], rising, and ``force`` (n,)
    [N]."""
    x, f = np.asarray(x, float), np.asarray(force, float)
    pieces = np.zeros(x.size - 1, dtype=SEGMENT)
    pieces["start"], pieces["force"] = x[:-1], f[:-1]
    pieces["lower"] = np.concatenate([[-inf], x[1:-1]])
    pieces["upper"] = np.concatenate([x[1:-1], [inf]])
    pieces["slope"] = np.diff(f) / np.diff(x)
    pieces["energy"][1:] = np.cumsum(np.diff(x) * (f[1:] + f[:-1]) / 2)[:-1]
    return pieces


def piece_at(pieces: np.ndarray, x: float) -> int:
    """Number of the piece of a curve that holds x."""
    return int(np.searchsorted(pieces["upper"], x, side="right"))


@kernel
def curve_force(piece, x):
    """f(x) on one piece of a curve."""
    return piece.force + piece.slope * (x - piece.start)


@kernel
def stored_energy(piece, x):
    """Integral of the curve up to x on one piece."""
    d = x - piece.start
    return piece.energy + piece.force * d + 0.5 * piece.slope * d * d


@kernel
def find_segment(first, last, pieces, x):
    """Index of the piece, from ``first`` to ``last``, that holds x."""
    k = first
    while k < last and x >= pieces[k].upper:
        k += 1
    return k


@kernel
def next_segment(k, piece, x):
    """Index of the neighbour of piece ``k`` at its end nearer to x."""
    return k + 1 if piece.upper - x < x - piece.lower else k - 1


@kernel
def inside_segment(piece, x):
    """Distance to the nearer end of a piece; negative outside."""
    return min(x - piece.lower, piece.upper - x)
