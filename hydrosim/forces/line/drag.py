"""Drag of a line, linearised along it and gathered at its fairlead.

    c = int 1/2 rho C D phi^2 E|w|(w g') / E(g' g') ds,   m = int 1/2 rho C D phi E|w| w_u / u ds

g: velocity of the fairlead across the line, a Gaussian in two directions; g' = phi g: that of the
line; u: current across the line; w = u + g'. phi is the share of the fairlead's motion: linear in
the length, 1 at the fairlead, 0 where the line touches down or at its anchor. c takes as much power
from g as the quadratic drag of all places (Borgman 1967; Krolikowski and Gay 1980 with a current).
In a Gaussian motion along one direction without a current

    c = sqrt(8/pi) sigma 1/2 rho int C D phi^3 ds.

In regular waves of an amplitude a of the velocity, 8/(3 pi) a replaces sqrt(8/pi) sigma.

Limits: the motion of the anchor, drag along the line, and inertia of the line are neglected.
"""

from __future__ import annotations

from math import pi, sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from hydrosim.forces.line.catenary import CatenaryConstants

PHASES = 4096  # of a regular motion with a current
QUADRATURE_NODES = 40  # of Gauss and Hermite, in each direction, with a current
NODES_PER_SEGMENT = 4  # of Gauss and Legendre, on each segment


class LinearisedDrag(NamedTuple):
    """``damping`` c and ``drift`` m [N s/m] of a line."""

    damping: float
    drift: float


class DragPoints(NamedTuple):
    """Places (k,) along what hangs of a line: ``phi``, and the length [m] that each stands for."""

    phi: np.ndarray
    length: np.ndarray
    segment: np.ndarray


def drag_points(length: np.ndarray, touch: float) -> DragPoints:
    """`DragPoints` of Gauss's quadrature on segments of ``length`` (n,) [m], of which ``touch`` [m]
    from the fairlead hangs; each with the number of its ``segment``."""
    ends = np.minimum(np.concatenate([[0.0], np.cumsum(length)]), touch)
    nodes, weights = np.polynomial.legendre.leggauss(NODES_PER_SEGMENT)
    half = 0.5 * np.diff(ends)
    middle = 0.5 * (ends[1:] + ends[:-1])
    arc = middle[:, None] + np.multiply.outer(half, nodes)
    each = np.multiply.outer(half, weights)
    segment = np.repeat(np.arange(half.size), NODES_PER_SEGMENT)
    return DragPoints(1.0 - arc.ravel() / touch, each.ravel(), segment)


def linearise_random(covariance: np.ndarray, current: np.ndarray) -> LinearisedDrag:
    """E|w|(w g)/E(g g) and E|w| w_u/u [m/s] for a Gaussian velocity g of a ``covariance`` (3, 3)
    and a ``current`` (3,) across the line."""
    values, axes = np.linalg.eigh(covariance)
    sigma = np.sqrt(np.maximum(values[1:], 0.0))
    u = axes[:, 1:].T @ current
    speed = float(np.linalg.norm(current))
    if not sigma.any():
        return LinearisedDrag(2.0 * speed, speed)
    if speed == 0.0:
        square = 0.5 * float((sigma**2).sum())
        return LinearisedDrag(1.5 * sqrt(pi / 2.0) * _mean_cube(sigma) / square, 0.0)
    nodes, weights = np.polynomial.hermite_e.hermegauss(QUADRATURE_NODES)
    weights = weights / weights.sum()
    g = np.stack(np.meshgrid(*(s * nodes for s in sigma), indexing="ij"))
    share = np.multiply.outer(weights, weights)
    w = g + u[:, None, None]
    size = np.sqrt((w**2).sum(axis=0))
    c = float((share * size * (w * g).sum(axis=0)).sum() / (sigma**2).sum())
    along = np.tensordot(u, w, axes=1) / float(u @ u)
    return LinearisedDrag(c, float((share * size * along).sum()))


def _mean_cube(sigma: np.ndarray) -> float:
    """Mean over all directions of (s1^2 cos^2 + s2^2 sin^2)^(3/2), by elliptic integrals."""
    from scipy.special import ellipe, ellipkm1

    low, high = sorted(float(s) for s in sigma)
    p = (low / high) ** 2
    rest = p * ellipkm1(p) if p > 0.0 else 0.0
    return float(high**3 * (2.0 * (1.0 + p) * ellipe(1.0 - p) - rest) / 3.0 * 2.0 / pi)


def linearise_regular(amplitude: float, current: np.ndarray) -> LinearisedDrag:
    """The same for a harmonic velocity of an ``amplitude`` [m/s]; with a current, as if both were
    in one direction."""
    speed = float(np.linalg.norm(current))
    angle = 2.0 * pi * (np.arange(PHASES) + 0.5) / PHASES
    g = amplitude * np.sin(angle)
    w = speed + g
    if amplitude == 0.0:
        return LinearisedDrag(2.0 * speed, speed)
    if speed == 0.0:
        return LinearisedDrag(8.0 / (3.0 * pi) * amplitude, 0.0)
    c = float(np.mean(np.abs(w) * w * g) / np.mean(g * g))
    return LinearisedDrag(c, float(np.mean(np.abs(w) * w)) / speed)


def with_drag_of(p: CatenaryConstants, other: CatenaryConstants) -> CatenaryConstants:
    """Constants of the lines ``p`` with the linearised drag of the same lines in ``other``."""
    lines = p.lines.copy()
    for name in ("damping", "drift"):
        lines[name] = other.lines[name]
    return p._replace(lines=lines)
