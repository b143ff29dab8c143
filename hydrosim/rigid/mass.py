"""Mass: the matrix in the earth frame, its Cholesky factor, and the kinetic energy."""

from __future__ import annotations

from math import sqrt

from hydrosim.kernels import assign, kernel


@kernel
def mass_matrix(bodies, rotation, added_mass, M):
    """M (6 nb, 6 nb): rigid mass m and inertia R I R^T of every body, plus ``added_mass``."""
    for i in range(M.shape[0]):
        assign(M[i], added_mass[i])
    for b in range(bodies.each.size):
        for i in range(3):
            M[6 * b + i, 6 * b + i] += bodies.each[b].mass
            for j in range(3):
                M[6 * b + 3 + i, 6 * b + 3 + j] += _earth_inertia(b, i, j, bodies, rotation)


@kernel
def _earth_inertia(b, i, j, bodies, rotation):
    """Entry i, j of R I R^T; in linear kinematics I itself."""
    if not bodies.exact:
        return bodies.each[b].inertia[i, j]
    R, I = rotation[b], bodies.each[b].inertia  # noqa: E741
    entry = 0.0
    for k in range(3):
        for m in range(3):
            entry += R[i, k] * I[k, m] * R[j, m]
    return entry


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
    """Lower Cholesky factor of ``H`` in place; NaN where H is not positive definite."""
    for j in range(H.shape[0]):
        for k in range(j):
            H[j, j] -= H[j, k] * H[j, k]
        H[j, j] = sqrt(H[j, j])
        for i in range(j + 1, H.shape[0]):
            for k in range(j):
                H[i, j] -= H[i, k] * H[j, k]
            H[i, j] /= H[j, j]


@kernel
def cholesky_solve(L, x):
    """Solve L L^T x = x in place."""
    n = x.size
    for i in range(n):
        for k in range(i):
            x[i] -= L[i, k] * x[k]
        x[i] /= L[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            x[i] -= L[k, i] * x[k]
        x[i] /= L[i, i]
