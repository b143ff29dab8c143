"""A linear spring on a body's coordinates: force -K q, potential q^T K q / 2."""

from __future__ import annotations

from hydrosim.jit.kernels import kernel
from hydrosim.rigid.vectors import product


@kernel
def spring_force(k, q, K):
    """-K q (6,) as a tuple, for the six coordinates from index ``k``."""
    f = product(K, q, k)
    return (-f[0], -f[1], -f[2], -f[3], -f[4], -f[5])


@kernel
def spring_energy(k, q, K):
    """q^T K q / 2 of the six coordinates from index ``k``."""
    energy = 0.0
    for i in range(6):
        for j in range(6):
            energy += 0.5 * q[k + i] * K[i, j] * q[k + j]
    return energy
