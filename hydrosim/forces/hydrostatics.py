"""Hydrostatic restoring force, linear about the position at rest.

    Q = -C q,   F = S^-T Q

q: displacements and angles from rest; C: hydrostatic stiffness (6, 6) of each body, weight included
(Newman 1977, sec. 6.16). Q is conjugate to the coordinates, so that its power is -d/dt of the
stored energy q^T C q / 2 at any angle. Limits: small changes of the waterplane.
"""

from __future__ import annotations

from hydrosim.forces.layout import HYDROSTATIC
from hydrosim.jit.kernels import kernel
from hydrosim.rigid.kinematics import wrench_of_coordinates
from hydrosim.rigid.stiffness import spring_energy, spring_force


@kernel
def add_hydrostatics(motion, bodies, stiffness, wrench):
    """Add the hydrostatic force and moment [N, N m] of every body, -``stiffness`` (nb, 6, 6) times
    its coordinates, to the hydrostatic row of ``wrench`` in place."""
    for b in range(bodies.each.size):
        Q = spring_force(6 * b, motion.coordinates, stiffness[b])
        wrench_of_coordinates(b, Q, bodies, motion, wrench[HYDROSTATIC])


@kernel
def add_hydrostatic_energy(motion, bodies, stiffness, stored):
    """Add the energy stored in the restoring forces to the hydrostatic row of ``stored``."""
    for b in range(bodies.each.size):
        stored[HYDROSTATIC] += spring_energy(6 * b, motion.coordinates, stiffness[b])
