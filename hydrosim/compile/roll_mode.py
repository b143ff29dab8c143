"""Natural mode of roll of a body, which a decay test shows.

With all other motions eliminated, roll obeys S(w) = 0 at a complex frequency w. S is the Schur
complement of roll in

    D(w) = K - w^2 (M + A(w)) + i w B(w).

At the real w_n with Re S = 0, let b = Im S / w_n and m = -Re S' / (2 w_n). A weak damping B1 of
roll moves the zero to w_n + i (b + B1) / (2 m). So roll decays as exp(-p1 t / 2), with p1 = (b +
B1) / m.
If nothing couples to roll, b is B44 and m is I44 + A44 + w A44' / 2.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy
from scipy.linalg import block_diag, eigh

from hydrosim.database import database
from hydrosim.database.database import HydroDatabase
from hydrosim.dofs import DOFS
from hydrosim.elements.kind import RollMode
from hydrosim.scene import Body

ROLL_COORDINATE = DOFS.index("roll")
MAX_ROLL_ITERATIONS = 50  # iterations
FREQUENCY_RTOL = 1e-10  # relative change of the frequency at which they end
SLOPE_STEP_FRACTION = 1e-3  # of the frequency: step of the slope S'

Matrices = Callable[[float], tuple[np.ndarray, np.ndarray]]


def roll_mode(body: Body, stiffness: np.ndarray, db: HydroDatabase | None) -> RollMode:
    """Mode of a body with the largest share of kinetic energy in roll, along its axes at rest, in
    the degrees of freedom that it has in the scene.

    ``stiffness`` (6, 6) comes besides hydrostatics; ``db`` is None for a dry body. Without a free
    roll, the mode is roll alone.
    """
    free = [i for i, dof in enumerate(DOFS) if dof in body.dofs]
    free = free if ROLL_COORDINATE in free else [ROLL_COORDINATE]
    free_block = np.ix_(free, free)
    at = free.index(ROLL_COORDINATE)
    M = block_diag(body.mass * np.eye(3), body.inertia)[free_block]
    total = stiffness.copy()
    if db is not None:
        total = total + database.require_array(db, "hydrostatic_stiffness")
    K = 0.5 * (total + total.T)[free_block]
    coefficients = _roll_coefficients(db)

    def schur(w: float) -> complex:
        A, B = coefficients(w)
        D = K - w * w * (M + A[free_block]) + 1j * w * B[free_block]
        others = [i for i in range(len(free)) if i != at]
        rest = D[np.ix_(others, others)]
        return complex(D[at, at] - D[at, others] @ np.linalg.solve(rest, D[others, at]))

    omega, mass = _undamped_roll(K, M, coefficients, free_block, at)
    if omega == 0.0:
        return RollMode(0.0, mass, 0.0)
    for _ in range(MAX_ROLL_ITERATIONS):
        step = SLOPE_STEP_FRACTION * omega
        mass = -(schur(omega + step) - schur(omega - step)).real / (4.0 * step * omega)
        change = schur(omega).real / (2.0 * omega * mass)
        omega += change
        if abs(change) <= FREQUENCY_RTOL * omega:
            break
    return RollMode(omega, mass, schur(omega).imag / omega)


def _undamped_roll(
    K: np.ndarray,
    M: np.ndarray,
    coefficients: Matrices,
    free_block: tuple[np.ndarray, ...],
    at: int,
) -> tuple[float, float]:
    """Frequency and mass per roll of the undamped mode."""
    omega = 0.0
    for _ in range(MAX_ROLL_ITERATIONS):
        H = M + coefficients(omega)[0][free_block]
        values, shapes = eigh(K, H)
        k = int(np.argmax(shapes[at] * (H @ shapes)[at]))
        before = omega
        omega = float(np.sqrt(max(values[k], 0.0)))
        if abs(omega - before) <= SLOPE_STEP_FRACTION * omega:
            break
    u = shapes[:, k] / shapes[at, k]
    return omega, float(u @ H @ u)


def _roll_coefficients(db: HydroDatabase | None) -> Matrices:
    """Added mass and radiation damping (6, 6) over frequency [rad/s]: cubic splines, constant
    beyond those of the database."""
    if db is None:
        none = np.zeros((6, 6))
        return lambda w: (none, none)
    A = scipy.interpolate.CubicSpline(
        db.frequency, 0.5 * (db.added_mass + db.added_mass.transpose(0, 2, 1))
    )
    B = scipy.interpolate.CubicSpline(db.frequency, db.radiation_damping)
    least, most = db.frequency[0], db.frequency[-1]

    def coefficients_at(w: float) -> tuple[np.ndarray, np.ndarray]:
        clipped = min(max(w, least), most)
        return A(clipped), B(clipped)

    return coefficients_at
