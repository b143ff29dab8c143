"""What a tank holds, over the volume V of the fluid in it.

    S(V) = int r dV,   P(V) = int r r^T dV,   level h(V),   J(V) of the free surface

in the body frame, as cubics in V on pieces. What is added or taken lies at the surface, about its
centroid S'(V); so P' = S' S'^T + J / (dV/dh) for a surface level in the body.
"""

from __future__ import annotations

import numpy as np

FIRST, SECOND, LEVEL, SURFACE, ALL = 0, 3, 9, 10, 13
"""Where S (3), P (xx, yy, zz, xy, xz, yz), h and J (xx, xy, yy) begin; their number."""
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
PIECE = np.dtype([("start", float), ("c", float, (ALL, 4))])
"""Coefficients of 1, x, x^2, x^3, x = V - start."""


def at(table: np.ndarray, volume: float) -> np.ndarray:
    """All quantities (13,) of the pieces of a tank at a volume [m^3]."""
    piece = table[max(int(np.searchsorted(table["start"], volume, side="right")) - 1, 0)]
    return np.asarray(piece["c"] @ (volume - piece["start"]) ** np.arange(4))


def hermite(
    start: np.ndarray, gain: np.ndarray, slope: np.ndarray, last: np.ndarray, length: np.ndarray
) -> np.ndarray:
    """Coefficients (n, 6, 4) of cubics with these values and slopes at both ends."""
    x = length[:, None]
    bend = (3.0 * gain / x - 2.0 * slope - last) / x
    return np.stack([start, slope, bend, (slope + last - 2.0 * gain / x) / x**2], axis=2)
