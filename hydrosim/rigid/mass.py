"""Mass: the matrix in the earth frame, its Cholesky factor, and the kinetic energy."""

from __future__ import annotations

from math import sqrt

from hydrosim.jit.kernels import assign, kernel
from hydrosim.rigid.heading import turn_matrix
from hydrosim.rigid.vectors import matvec, vector


@kernel
def mass_matrix(bodies, contents, headings, motion, added_mass, M):
    """Fill M (6 nb, 6 nb) about the bodies' origins: mass m, m [c x] and inertia R I R^T of every
    body, plus ``added_mass`` of their heading axes."""
    for i in range(M.shape[0]):
        assign(M[i], added_mass[i])
    turn_matrix(headings, motion, M)
    for b in range(bodies.each.size):
        R, moment = motion.rotation[b], vector(contents.moving_moment[b], 0)
        for i in range(3):
            M[6 * b + i, 6 * b + i] += contents.moving_mass[b]
            add_earth_inertia(6 * b + 3, i, contents.inertia[b], R, bodies.exact, M)
        if moment[0] != 0.0 or moment[1] != 0.0 or moment[2] != 0.0:
            _add_moment(6 * b, matvec(R, moment) if bodies.exact else moment, M)


@kernel
def _add_moment(k, moment, M):
    """Add m [c x] to ``M``, which couples rotations and translations."""
    for i in range(3):
        j, h = (i + 1) % 3, (i + 2) % 3
        M[k + i, k + 3 + j] += moment[h]
        M[k + i, k + 3 + h] -= moment[j]
        M[k + 3 + j, k + i] += moment[h]
        M[k + 3 + h, k + i] -= moment[j]


@kernel
def add_earth_inertia(k, j, inertia, R, exact, M):
    """Add column j of R I R^T to ``M`` from (k, k) on; of I itself in linear kinematics."""
    if exact:
        column = matvec(R, matvec(inertia, (R[j, 0], R[j, 1], R[j, 2])))
    else:
        column = (inertia[0, j], inertia[1, j], inertia[2, j])
    for i in range(3):
        M[k + i, k + j] += column[i]


@kernel
def kinetic_energy(v, M):
    """v^T M v / 2."""
    energy = 0.0
    for i in range(v.size):
        for j in range(v.size):
            energy += 0.5 * v[i] * M[i, j] * v[j]
    return energy


@kernel
def cholesky(H):
    """Lower Cholesky factor of ``H`` in place, with 1 / L_jj on the diagonal; NaN where H is not
    positive definite."""
    for i in range(H.shape[0]):
        for j in range(i):
            entry = H[i, j]
            for k in range(j):
                entry -= H[i, k] * H[j, k]
            H[i, j] = entry * H[j, j]
        square = H[i, i]
        for k in range(i):
            square -= H[i, k] * H[i, k]
        H[i, i] = 1.0 / sqrt(square)


@kernel
def cholesky_solve(L, x):
    """Solve L L^T x = x in place, for the factor of `cholesky`."""
    n = x.size
    for i in range(n):
        entry = x[i]
        for k in range(i):
            entry -= L[i, k] * x[k]
        x[i] = entry * L[i, i]
    for i in range(n - 1, -1, -1):
        entry = x[i]
        for k in range(i + 1, n):
            entry -= L[k, i] * x[k]
        x[i] = entry * L[i, i]
