"""Natural mode of roll of a body, which a decay test shows."""

from __future__ import annotations

import numpy as np
from scipy.linalg import block_diag, eigh

from hydrosim.database import database
from hydrosim.database.database import HydroDatabase
from hydrosim.dofs import DOFS
from hydrosim.forces.layout import RollMode
from hydrosim.scene import Body

ROLL = DOFS.index("roll")
MOST = 100  # iterations
SAME = 1e-12  # relative change of the frequency at which they end


def roll_mode(body: Body, stiffness: np.ndarray, db: HydroDatabase | None) -> RollMode:
    """Undamped mode of a body with the largest share of kinetic energy in roll, along its axes at
    rest, in the degrees of freedom that it has in the scene.

    ``stiffness`` (6, 6) comes besides hydrostatics. Added mass and damping of ``db`` are those at
    the natural frequency; it is None for a dry body. Without a free roll, the mode is roll alone.
    """
    free = [i for i, dof in enumerate(DOFS) if dof in body.dofs]
    free = free if ROLL in free else [ROLL]
    own = np.ix_(free, free)
    mass = block_diag(body.mass * np.eye(3), body.inertia)
    total = stiffness.copy()
    if db is not None:
        total = total + database.needed(db, "hydrostatic_stiffness")
    K = 0.5 * (total + total.T)[own]
    omega = 0.0
    for _ in range(MOST):
        A, B = _coefficients(db, omega)
        H = (mass + 0.5 * (A + A.T))[own]
        values, shapes = eigh(K, H)
        share = shapes[free.index(ROLL)] * (H @ shapes)[free.index(ROLL)]
        k = int(np.argmax(share))
        before = omega
        omega = float(np.sqrt(max(values[k], 0.0)))
        if abs(omega - before) <= SAME * omega:
            break
    u = shapes[:, k] / shapes[free.index(ROLL), k]
    return RollMode(omega, float(u @ H @ u), float(u @ B[own] @ u))


def _coefficients(db: HydroDatabase | None, omega: float) -> tuple[np.ndarray, np.ndarray]:
    """Added mass and radiation damping (6, 6) at a frequency [rad/s]."""
    if db is None:
        return np.zeros((6, 6)), np.zeros((6, 6))
    w = db.frequency
    k = int(np.clip(np.searchsorted(w, omega), 1, w.size - 1))
    x = float(np.clip((omega - w[k - 1]) / (w[k] - w[k - 1]), 0.0, 1.0))
    A, B = ((1.0 - x) * v[k - 1] + x * v[k] for v in (db.added_mass, db.radiation_damping))
    return A, B
