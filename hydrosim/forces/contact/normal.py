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


@dataclass(frozen=True)
class NormalLoop:
    """Per contact point: ``force`` (n,) [N] over ``compression`` (n,) [m] as it is pressed, less of
    it over ``unloading_compression`` (m,) as it lets go, all from 0 and not falling, and the
    ``stiffness`` [N/m] between, above all slopes of both, see `hydrosim.forces.contact.loop`."""

    compression: np.ndarray
    force: np.ndarray
    unloading_compression: np.ndarray
    unloading_force: np.ndarray
    stiffness: float


FLAT = NormalCurve(np.array([0.0, 1.0]), np.zeros(2))
"""The curve of a point whose normal force is prescribed: no corners, nothing stored."""
