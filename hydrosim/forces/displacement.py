"""Buoyancy of a closed hull: the gradient of the potential of the water that it displaces.

    U(z, n) = -rho g int_{Z < 0} Z dV = -rho g / (2 n_3) sum_k A_k m(d_k),    Z = z + n . r
    F = (0, 0, -dU/dz) = rho g V e_z,   M = e_z x R dU/dn

z: height of the centre of gravity; n: the earth's vertical in the body's axes, the last row of R;
r: a point of the hull; d = -(z + n . r): its depth. Gauss's theorem turns the integral over the
volume into one over the plane triangles k of the hull (`hydrosim.rigid.solids`). It is exact for
the mesh, at any draught, heel and trim.

U does not depend on surge, sway and yaw, so that there is no horizontal force and no moment about
the vertical. U has three continuous derivatives unless a face is parallel to the water as it
becomes wet.

If weight is balanced at rest, U includes the weight of the water displaced there, rho g V_0 (z + n
. p). Point p is above the centre of buoyancy at the height of the centre of gravity. A body that
carries its weight has m g in a row of its own (`weight`). Limits: a heel of less than 85 deg; the
pressure is that of still water.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.forces.layout import HYDROSTATIC
from hydrosim.jit.kernels import kernel, root
from hydrosim.rigid.solids import Solids, sums_below
from hydrosim.rigid.vectors import add, dot, matvec, scale, vector


class MeshHulls(NamedTuple):
    """Constants of nh hulls: their ``body`` (nh,) and ``solids`` about the centre of gravity, in
    the body frame; the ``height`` (nh,) of the centre of gravity at rest; ``weight`` (nh, 4), V_0
    and V_0 p if weight is balanced; ``density`` rho g. ``roll`` (nr,) are the entries of y with the
    roll of one of them."""

    body: np.ndarray
    solids: Solids
    height: np.ndarray
    weight: np.ndarray
    density: float
    roll: np.ndarray


@root
def add_displacement(motion, bodies, p, wrench):
    """Add the force of every hull to the hydrostatic row of ``wrench``."""
    force = wrench[HYDROSTATIC]
    for h in range(p.body.size):
        b = p.body[h]
        _, by_height, by_vertical = potential(h, motion, p)
        arm = matvec(motion.rotation[b], by_vertical)
        force[6 * b + 2] -= p.density * by_height
        force[6 * b + 3] -= p.density * arm[1]
        force[6 * b + 4] += p.density * arm[0]


@root
def add_displacement_energy(motion, bodies, p, stored):
    """Add the energy of the water that every hull displaces to the hydrostatic row of
    ``stored``."""
    for h in range(p.body.size):
        stored[HYDROSTATIC] += p.density * potential(h, motion, p)[0]


@kernel
def potential(h, motion, p):
    """U / rho g of hull ``h`` and its derivatives by z and by n, (3,)."""
    b = p.body[h]
    heave = motion.coordinates[6 * b + 2]
    n = vector(motion.rotation[b, 2], 0)
    total, depth, arm = sums_below(p.height[h] + heave, n, h, p.solids)
    arm = (arm[0], arm[1], arm[2] + total / n[2])
    half = 0.5 / n[2]
    V, Vp = p.weight[h, 0], vector(p.weight[h], 1)  # of the balanced weight
    return V * heave + dot(n, Vp) - half * total, V + half * depth, add(Vp, scale(half, arm))
