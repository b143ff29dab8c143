"""Normal force of a contact point from a compression-force curve and a damper.

    N = f(delta) + c delta',   N >= 0

f: straight lines through the points of the table, the last slope going on beyond; c: damping. The
curve's corners are events: a contact point knows its segment, and on it N is smooth. Stored energy
is the integral of f; dissipation is c delta'^2 while in contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import numpy as np

from hydrosim.kernels import kernel


@dataclass(frozen=True)
class NormalCurve:
    """Per contact point: ``compression`` (n,) [m], rising from 0, ``force`` (n,) [N], not falling
    from 0, and ``damping`` [N s/m]."""

    compression: np.ndarray
    force: np.ndarray
    damping: float = 0.0


class Curves(NamedTuple):
    """Segments of all curves, one after the other: from ``lower`` to ``upper`` the force is
    ``force + slope (delta - start)``, the stored energy at start is ``energy``; contact point i has
    the segments ``first[i]`` to ``last[i]``."""

    first: np.ndarray
    last: np.ndarray
    start: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    force: np.ndarray
    slope: np.ndarray
    energy: np.ndarray
    damping: np.ndarray


def compile_curves(curves: Sequence[NormalCurve]) -> Curves:
    """Segments of one curve per contact point."""
    pieces = [_segments(curve) for curve in curves]
    counts = np.array([p.shape[1] for p in pieces], dtype=np.int64)
    start, lower, upper, force, slope, energy = np.hstack([np.zeros((6, 0)), *pieces])
    last = np.cumsum(counts) - 1
    damping = np.array([c.damping for c in curves], dtype=float)
    return Curves(last - counts + 1, last, start, lower, upper, force, slope, energy, damping)


def _segments(curve: NormalCurve) -> np.ndarray:
    """Rows start, lower, upper, force, slope, energy of the segments of one curve."""
    x, f = np.asarray(curve.compression, float), np.asarray(curve.force, float)
    energy = np.concatenate([[0.0], np.cumsum(np.diff(x) * (f[1:] + f[:-1]) / 2)])
    lower = np.concatenate([[-inf], x[1:-1]])
    upper = np.concatenate([x[1:-1], [inf]])
    return np.array([x[:-1], lower, upper, f[:-1], np.diff(f) / np.diff(x), energy[:-1]])


@kernel
def normal_force(i, k, compression, rate, p):
    """N of contact point ``i`` on segment ``k``, not cut at zero: contact ends at an event."""
    return p.force[k] + p.slope[k] * (compression - p.start[k]) + p.damping[i] * rate


@kernel
def stored_energy(k, compression, p):
    """Integral of the curve up to ``compression`` on segment ``k``."""
    x = compression - p.start[k]
    return p.energy[k] + p.force[k] * x + 0.5 * p.slope[k] * x * x


@kernel
def segment(i, compression, p):
    """Segment of contact point ``i`` that ``compression`` is on."""
    k = p.first[i]
    while k < p.last[i] and compression >= p.upper[k]:
        k += 1
    return k


@kernel
def inside_segment(k, compression, p):
    """Distance [m] to the nearer end of segment ``k``; negative outside."""
    return min(compression - p.lower[k], p.upper[k] - compression)
