"""Weight: m g at the centre of gravity, for bodies that carry it themselves.

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

from hydrosim.forces.layout import HYDROSTATIC
from hydrosim.jit.kernels import kernel, root
from hydrosim.rigid.kinematics import vertical_in_body
from hydrosim.rigid.vectors import add, cross, dot, matvec, scale, vector


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
        levelled = potential(vertical_in_body(b, motion, bodies), moment, surface, bodies.exact)
        stored[p.row] += p.gravity * (contents.mass[b] * height + levelled)
        stored[HYDROSTATIC] -= p.buoyancy[i] * heave


@kernel
def potential(n, moment, surface, exact):
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
