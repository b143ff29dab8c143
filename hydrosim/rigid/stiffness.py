"""A linear spring on a body's coordinates: force -K q, potential q^T K q / 2."""

from __future__ import annotations

from hydrosim.kernels import kernel


@kernel
def spring_force(k, q, K):
    """-K q (6,) as a tuple, for the six coordinates from index ``k``."""
    Q = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for j in range(6):
        x = q[k + j]
        Q = (
            Q[0] - K[0, j] * x,
            Q[1] - K[1, j] * x,
            Q[2] - K[2, j] * x,
            Q[3] - K[3, j] * x,
            Q[4] - K[4, j] * x,
            Q[5] - K[5, j] * x,
        )
    return Q


@kernel
def spring_energy(k, q, K):
    """q^T K q / 2 of the six coordinates from index ``k``."""
    energy = 0.0
    for i in range(6):
        for j in range(6):
            energy += 0.5 * q[k + i] * K[i, j] * q[k + j]
    return energy
