"""Drag of a line, linearised and gathered at its fairlead.

    c = E|w|(w g) / E(g g) 1/2 rho sum C D L2,   m = E|w| w_u / u 1/2 rho sum C D L1,   w = u + g

g: velocity of the fairlead across the line, a Gaussian in two directions; u: current across the
line; L2 and L1: integrals of phi^2 and phi over each segment of what hangs. phi is the share of the
fairlead's motion: linear in the length, 1 at the fairlead, 0 where the line touches down or at its
anchor. c does as much work against g as the quadratic drag (Borgman 1967; Krolikowski and Gay 1980
with a current). In a Gaussian motion along one direction without a current

    c = sqrt(8/pi) sigma 1/2 rho sum C D L2.

In regular waves of an amplitude a of the velocity, 8/(3 pi) a replaces sqrt(8/pi) sigma.

Limits: the motion of the anchor, drag along the line, and inertia of the line are neglected.
"""

from __future__ import annotations

from math import pi, sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from hydrosim.forces.line.catenary import Params

PHASES = 4096  # of a regular motion with a current
NODES = 40  # of Gauss and Hermite, in each direction, with a current


class Linearised(NamedTuple):
    """``damping`` c and ``drift`` m [N s/m] of a line."""

    damping: float
    drift: float


def effective_lengths(length: np.ndarray, touch: float) -> tuple[np.ndarray, np.ndarray]:
    """Integrals (n,) of phi and phi^2 over segments of ``length`` (n,) [m], of which ``touch`` [m]
    from the fairlead hangs."""
    ends = np.minimum(np.concatenate([[0.0], np.cumsum(length)]), touch)
    phi = 1.0 - ends / touch
    return -np.diff(phi**2) * touch / 2.0, -np.diff(phi**3) * touch / 3.0


def linearise_random(covariance: np.ndarray, current: np.ndarray) -> Linearised:
    """E|w|(w g)/E(g g) and E|w| w_u/u [m/s] for a Gaussian velocity g of a ``covariance`` (3, 3)
    and a ``current`` (3,) across the line."""
    values, axes = np.linalg.eigh(covariance)
    sigma = np.sqrt(np.maximum(values[1:], 0.0))
    u = axes[:, 1:].T @ current
    speed = float(np.linalg.norm(current))
    if not sigma.any():
        return Linearised(2.0 * speed, speed)
    if speed == 0.0:
        square = 0.5 * float((sigma**2).sum())
        return Linearised(1.5 * sqrt(pi / 2.0) * _mean_cube(sigma) / square, 0.0)
    nodes, weights = np.polynomial.hermite_e.hermegauss(NODES)
    weights = weights / weights.sum()
    g = np.stack(np.meshgrid(*(s * nodes for s in sigma), indexing="ij"))
    share = np.multiply.outer(weights, weights)
    w = g + u[:, None, None]
    size = np.sqrt((w**2).sum(axis=0))
    c = float((share * size * (w * g).sum(axis=0)).sum() / (sigma**2).sum())
    along = np.tensordot(u, w, axes=1) / float(u @ u)
    return Linearised(c, float((share * size * along).sum()))


def _mean_cube(sigma: np.ndarray) -> float:
    """Mean over all directions of (s1^2 cos^2 + s2^2 sin^2)^(3/2), by elliptic integrals."""
    from scipy.special import ellipe, ellipkm1

    low, high = sorted(float(s) for s in sigma)
    p = (low / high) ** 2
    rest = p * ellipkm1(p) if p > 0.0 else 0.0
    return float(high**3 * (2.0 * (1.0 + p) * ellipe(1.0 - p) - rest) / 3.0 * 2.0 / pi)


def linearise_regular(amplitude: float, current: np.ndarray) -> Linearised:
    """The same for a harmonic velocity of an ``amplitude`` [m/s]; with a current, as if both were
    in one direction."""
    speed = float(np.linalg.norm(current))
    angle = 2.0 * pi * (np.arange(PHASES) + 0.5) / PHASES
    g = amplitude * np.sin(angle)
    w = speed + g
    if amplitude == 0.0:
        return Linearised(2.0 * speed, speed)
    if speed == 0.0:
        return Linearised(8.0 / (3.0 * pi) * amplitude, 0.0)
    c = float(np.mean(np.abs(w) * w * g) / np.mean(g * g))
    return Linearised(c, float(np.mean(np.abs(w) * w)) / speed)


def with_drag_of(p: Params, other: Params) -> Params:
    """Constants of the lines ``p`` with the linearised drag of the same lines in ``other``."""
    lines = p.lines.copy()
    for name in ("damping", "drift"):
        lines[name] = other.lines[name]
    return p._replace(lines=lines)
