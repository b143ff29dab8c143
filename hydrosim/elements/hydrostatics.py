"""Hydrostatics of bodies: linear restoring force, buoyancy of closed hulls, and weight.

Hydrostatic restoring force, linear about the position at rest.

    Q = -C q,   F = S^-T Q

q: displacements and angles from rest; C: hydrostatic stiffness (6, 6) of each body, weight included
(Newman 1977, sec. 6.16). Q is conjugate to the coordinates, so that its power is -d/dt of the
stored energy q^T C q / 2 at any angle. Limits: small changes of the waterplane.

Buoyancy of a closed hull: the gradient of the potential of the water that it displaces.

    U(z, n) = -rho g int_{Z < 0} Z dV = -rho g / (2 n_3) sum_k A_k m(d_k),    Z = z + n . r
    F = (0, 0, -dU/dz) = rho g V e_z,   M = e_z x R dU/dn

z: height of the centre of gravity; n: the earth's vertical in the body's axes, the last row of R;
r: a point of the hull; d = -(z + n . r): its depth. Gauss's theorem turns the integral over the
volume into one over the plane triangles k of the hull (`hydrosim.multibody.solids`). It is exact
for the mesh, at any draught, heel and trim.

U does not depend on surge, sway and yaw, so that there is no horizontal force and no moment about
the vertical. U has three continuous derivatives unless a face is parallel to the water as it
becomes wet.

If weight is balanced at rest, U includes the weight of the water displaced there, rho g V_0 (z + n
. p). Point p is above the centre of buoyancy at the height of the centre of gravity. A body that
carries its weight has m g in a row of its own (`add_weight`). Limits: a heel of less than 85 deg;
the pressure is that of still water.

Weight: m g at the centre of gravity, for bodies that carry it themselves.

    U = g [m z + n . (m c) - (n_x, n_y) J (n_x, n_y)^T / (2 n_z)],   n = R^T e_z
    F = -m g e_z,   M = R (n x dU/dn)

z: height of the body's origin above the still water; c: centre of gravity from there, in the body
frame. It includes the shift by free surfaces of boxes and meshes (`hydrosim.tanks.surface`).
Further n: the vertical there; J: density times second moments of all other free surfaces of the
contents, about their centroids.

The last term is exact if the walls of a tank are upright in the body and its surface meets neither
bottom nor top. A surface that stays level shifts its fluid by J tan(angle), for a ship by `rho i
phi`; Newman 1977, sec. 6.16, has the same for a waterplane. In linear kinematics J includes all
surfaces, and U is exact to second order in the angles.

The weight of all other bodies is balanced: it is included in the position at rest and in the
hydrostatic stiffness. If a body with linear hydrostatics carries its weight, the hydrostatic force
includes the buoyancy at rest rho g V, upwards through the origin.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.elements.kind import HYDROSTATIC
from hydrosim.jit.kernels import kernel, root
from hydrosim.multibody.kinematics import vertical_in_body, wrench_of_coordinates
from hydrosim.multibody.mass import spring_energy, spring_force
from hydrosim.multibody.solids import Solids, sums_below
from hydrosim.multibody.vectors import add, cross, dot, matvec, scale, vector


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
        _, by_height, by_vertical = displacement_potential(h, motion, p)
        arm = matvec(motion.rotation[b], by_vertical)
        force[6 * b + 2] -= p.density * by_height
        force[6 * b + 3] -= p.density * arm[1]
        force[6 * b + 4] += p.density * arm[0]


@root
def add_displacement_energy(motion, bodies, p, stored):
    """Add the energy of the water that every hull displaces to the hydrostatic row of
    ``stored``."""
    for h in range(p.body.size):
        stored[HYDROSTATIC] += p.density * displacement_potential(h, motion, p)[0]


@kernel
def displacement_potential(h, motion, p):
    """U / rho g of hull ``h`` and its derivatives by z and by n, (3,)."""
    b = p.body[h]
    heave = motion.coordinates[6 * b + 2]
    n = vector(motion.rotation[b, 2], 0)
    total, depth, arm = sums_below(p.height[h] + heave, n, h, p.solids)
    arm = (arm[0], arm[1], arm[2] + total / n[2])
    half = 0.5 / n[2]
    V, Vp = p.weight[h, 0], vector(p.weight[h], 1)  # of the balanced weight
    return V * heave + dot(n, Vp) - half * total, V + half * depth, add(Vp, scale(half, arm))


class Weights(NamedTuple):
    """Constants: the bodies (nw,) that carry their weight, the ``buoyancy`` (nw,) [N] of each at
    rest, the ``row`` of forces, ``gravity`` [m/s^2]."""

    body: np.ndarray
    buoyancy: np.ndarray
    row: int
    gravity: float


@root
def add_weight(motion, bodies, p, contents, wrench):
    """Add the weight of all bodies that carry it to its row of ``wrench``, and their buoyancy at
    rest to the hydrostatic row."""
    for i in range(p.body.size):
        b = p.body[i]
        k = 6 * b
        row = wrench[p.row]
        row[k + 2] -= p.gravity * contents.mass[b]
        turning = _weight_moment(b, p.gravity, motion, bodies, contents)
        for j in range(3):
            row[k + 3 + j] += turning[j]
        wrench[HYDROSTATIC, k + 2] += p.buoyancy[i]


@root
def add_weight_energy(motion, bodies, p, contents, stored):
    """Add the energy of the weight, zero at the still water, to its row of ``stored``, and the
    energy of the buoyancy at rest to the hydrostatic row."""
    for i in range(p.body.size):
        b = p.body[i]
        heave = motion.coordinates[6 * b + 2]
        height = bodies.each[b].origin[2] + heave
        moment = _moment_of(b, contents)
        surface = vector(contents.surface[b], 0)
        levelled = weight_potential(
            vertical_in_body(b, motion, bodies), moment, surface, bodies.exact
        )
        stored[p.row] += p.gravity * (contents.mass[b] * height + levelled)
        stored[HYDROSTATIC] -= p.buoyancy[i] * heave


@kernel
def weight_potential(n, moment, surface, exact):
    """U / g - m z."""
    square = surface[0] * n[0] * n[0] + 2.0 * surface[1] * n[0] * n[1] + surface[2] * n[1] * n[1]
    if exact:
        return dot(n, moment) - square / (2.0 * n[2])
    lowered = moment[2] * (1.0 - 0.5 * (n[0] * n[0] + n[1] * n[1]))
    return n[0] * moment[0] + n[1] * moment[1] + lowered - 0.5 * square


@kernel
def _moment_of(b, contents):
    """m c, including the shift by level surfaces."""
    return add(vector(contents.moment[b], 0), vector(contents.shift[b], 0))


@kernel
def _weight_moment(b, gravity, motion, bodies, contents):
    """Moment of the weight about the origin of body ``b``."""
    n = vertical_in_body(b, motion, bodies)
    moment = _moment_of(b, contents)
    J = vector(contents.surface[b], 0)
    x = J[0] * n[0] + J[1] * n[1]
    y = J[1] * n[0] + J[2] * n[1]
    if not bodies.exact:  # -dU/droll, -dU/dpitch
        turning = (moment[2] * n[1] + y - moment[1], moment[0] - moment[2] * n[0] - x, 0.0)
        return scale(gravity, turning)
    slope = (-x / n[2], -y / n[2], 0.5 * (x * n[0] + y * n[1]) / (n[2] * n[2]))
    return scale(gravity, matvec(motion.rotation[b], cross(n, add(moment, slope))))
