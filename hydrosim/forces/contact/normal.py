"""Normal force of a contact point: from a compression-force curve and a damper, or prescribed.

    N = f(delta) + c delta'   or   N = f(t),   N >= 0

f(delta): straight lines through the points of the table (`hydrosim.forces.curve`); c: damping;
f(t): a signal. Stored energy is the integral of f; dissipation is c delta'^2 while in contact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrosim.forces.signal import Signal


@dataclass(frozen=True)
class PrescribedNormal:
    """Normal force of each contact point: ``force`` [N] over time. Contact lasts while it is
    positive, at any position of the point."""

    force: Signal


@dataclass(frozen=True)
class NormalCurve:
    """Normal curve of each contact point: ``compression`` (n,) [m], rising from 0, ``force`` (n,)
    [N], not falling from 0, and ``damping`` [N s/m]."""

    compression: np.ndarray
    force: np.ndarray
    damping: float = 0.0


@dataclass(frozen=True)
class NormalLoop:
    """Normal curve with a loop, for each contact point: ``force`` (n,) [N] over ``compression``
    (n,) [m] in loading, and a smaller force over ``unloading_compression`` (m,) in unloading. All
    start at 0 and do not fall. ``stiffness`` [N/m] between the two is above all slopes of both, see
    `hydrosim.forces.contact.loop`."""

    compression: np.ndarray
    force: np.ndarray
    unloading_compression: np.ndarray
    unloading_force: np.ndarray
    stiffness: float


NO_CURVE = NormalCurve(np.array([0.0, 1.0]), np.zeros(2))
"""The curve of a point with prescribed normal force: no corners, nothing stored."""
