"""Normal force of a contact point: from a compression-force curve and a damper, or prescribed.

    N = f(delta) + c delta'   or   N = f(t),   N >= 0

f(delta): straight lines through the points of the table, the last slope going on beyond; c:
damping; f(t): a signal. The curve's corners are events: a contact point knows its segment, and on
it N is smooth. Stored energy is the integral of f; dissipation is c delta'^2 while in contact.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from hydrosim.forces.signal import Signal
from hydrosim.jit.kernels import kernel


@dataclass(frozen=True)
class PrescribedNormal:
    """Per contact point: ``force`` [N] over time. Contact is while it is positive, wherever the
    point is."""

    force: Signal


@dataclass(frozen=True)
class NormalCurve:
    """Per contact point: ``compression`` (n,) [m], rising from 0, ``force`` (n,) [N], not falling
    from 0, and ``damping`` [N s/m]."""

    compression: np.ndarray
    force: np.ndarray
    damping: float = 0.0


SEGMENT = np.dtype(
    [(name, float) for name in ("start", "lower", "upper", "force", "slope", "energy")]
)
"""A straight piece of a curve over the compression x: from ``lower`` to ``upper`` the force is
``force + slope (x - start)``; ``energy`` is what is stored at start."""

FLAT = NormalCurve(np.array([0.0, 1.0]), np.zeros(2))
"""The curve of a point whose normal force is prescribed: no corners, nothing stored."""


def segments(curve: NormalCurve) -> np.ndarray:
    """The straight pieces of a curve, of `SEGMENT`."""
    x, f = np.asarray(curve.compression, float), np.asarray(curve.force, float)
    pieces = np.zeros(x.size - 1, dtype=SEGMENT)
    pieces["start"], pieces["force"] = x[:-1], f[:-1]
    pieces["lower"] = np.concatenate([[-inf], x[1:-1]])
    pieces["upper"] = np.concatenate([x[1:-1], [inf]])
    pieces["slope"] = np.diff(f) / np.diff(x)
    pieces["energy"][1:] = np.cumsum(np.diff(x) * (f[1:] + f[:-1]) / 2)[:-1]
    return pieces


@kernel
def curve_force(piece, x):
    """f(x) on one piece of a curve."""
    return piece.force + piece.slope * (x - piece.start)


@kernel
def stored_energy(piece, compression):
    """Integral of the curve up to ``compression`` on one piece."""
    x = compression - piece.start
    return piece.energy + piece.force * x + 0.5 * piece.slope * x * x


@kernel
def find_segment(first, last, pieces, x):
    """Index of the piece, from ``first`` to ``last``, that x is on."""
    k = first
    while k < last and x >= pieces[k].upper:
        k += 1
    return k


@kernel
def next_segment(k, piece, x):
    """Index of the neighbour of piece ``k`` at its end that x is nearer to."""
    return k + 1 if piece.upper - x < x - piece.lower else k - 1


@kernel
def inside_segment(piece, x):
    """Distance to the nearer end of a piece; negative outside."""
    return min(x - piece.lower, piece.upper - x)
