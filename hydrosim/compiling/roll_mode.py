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
    the natural frequency w; it is None for a dry body. Without a free roll, the mode is roll alone.

    The amplitude of a weakly damped mode u falls at the rate p1 = u^T B u / m, where m is u^T (M +
    A + w A' / 2) u: the derivative of D(w) = K - w^2 (M + A(w)) + i w B(w) by w is -2 w m. The
    slope A' is there because a decay is a band of frequencies.
    """
    free = [i for i, dof in enumerate(DOFS) if dof in body.dofs]
    free = free if ROLL in free else [ROLL]
    own = np.ix_(free, free)
    mass = block_diag(body.mass * np.eye(3), body.inertia)
    total = stiffness.copy()
    if db is not None:
        total = total + database.needed(db, "hydrostatic_stiffness")
    K = 0.5 * (total + total.T)[own]
    at = free.index(ROLL)
    omega = 0.0
    for _ in range(MOST):
        A, _, _ = _coefficients(db, omega)
        H = (mass + A)[own]
        values, shapes = eigh(K, H)
        k = int(np.argmax(shapes[at] * (H @ shapes)[at]))
        before = omega
        omega = float(np.sqrt(max(values[k], 0.0)))
        if abs(omega - before) <= SAME * omega:
            break
    u = shapes[:, k] / shapes[at, k]
    _, B, slope = _coefficients(db, omega)
    moved = H + 0.5 * omega * slope[own]
    return RollMode(omega, float(u @ moved @ u), float(u @ B[own] @ u))


def _coefficients(
    db: HydroDatabase | None, omega: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Added mass (6, 6) and radiation damping at a frequency [rad/s], linear between those of the
    database, and the slope of the added mass over frequency."""
    if db is None:
        return np.zeros((6, 6)), np.zeros((6, 6)), np.zeros((6, 6))
    w = db.frequency
    added = 0.5 * (db.added_mass + db.added_mass.transpose(0, 2, 1))
    slopes = np.gradient(added, w, axis=0)
    k = int(np.clip(np.searchsorted(w, omega), 1, w.size - 1))
    x = float(np.clip((omega - w[k - 1]) / (w[k] - w[k - 1]), 0.0, 1.0))
    A, B, slope = (
        (1.0 - x) * values[k - 1] + x * values[k]
        for values in (added, db.radiation_damping, slopes)
    )
    return A, B, slope
