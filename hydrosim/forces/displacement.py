"""Buoyancy of a closed hull: the gradient of the potential of the water that it displaces.

    U(z, n) = -rho g int_{Z < 0} Z dV = -rho g / (2 n_3) sum_k A_k m(d_k),    Z = z + n . r
    F = (0, 0, -dU/dz) = rho g V e_z,   M = e_z x R dU/dn

z: height of the centre of gravity; n: the earth's vertical in the body's axes, the last row of R;
r: a point of the hull; d = -(z + n . r): how deep it is. By Gauss's theorem the integral over the
volume is one over the plane triangles k of the hull, A_k being their areas seen from above, upward
ones positive, and m(d_k) the mean of max(d, 0)^2 over each, in closed form: exact for the mesh, at
any draught, heel and trim. Triangles that stand upright do not count. They are taken in parcels: of
one that is under water altogether the sum is a polynomial of second degree in z and n, and only
those that the water cuts are looked into.

U does not depend on surge, sway and yaw, so that there is no horizontal force and no moment about
the vertical. Where no face is parallel to the water as it becomes wet, U has three continuous
derivatives. Where weight is balanced at rest, the weight of the water displaced there is in U:
rho g V_0 (z + n . p), p being over the centre of buoyancy at the height of the centre of gravity.
A body that carries its weight has m g in a row of its own (`weight`).
Limits: a heel of less than 85 deg; the pressure is that of still water.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.forces.layout import HYDROSTATIC
from hydrosim.jit.kernels import kernel, root
from hydrosim.rigid.vectors import add, dot, matvec, scale, vector

MOMENTS = np.dtype([("area", float), ("first", float, 3), ("second", float, (3, 3))])
"""Of a parcel: the sums of A_k times the means of 1, r and r r^T over each triangle."""


class Hulls(NamedTuple):
    """Constants of nh hulls: their ``body`` (nh,), where the parcels of each begin, ``first``
    (nh + 1,); where the triangles of each parcel begin, ``begin`` (np + 1,), the middle of the box
    around them and half its sides, ``box`` (np, 2, 3), and their `MOMENTS` (np,); ``corners``
    (nt, 3, 3) of the triangles about the centre of gravity, in the body frame, and their ``area``
    (nt,) seen from above; the ``height`` (nh,) of the centre of gravity
    at rest; ``weight`` (nh, 4), V_0 and V_0 p where weight is balanced; ``density`` rho g; the
    entries of y that are the ``roll`` (nr,) of one of them."""

    body: np.ndarray
    first: np.ndarray
    begin: np.ndarray
    box: np.ndarray
    moments: np.ndarray
    corners: np.ndarray
    area: np.ndarray
    height: np.ndarray
    weight: np.ndarray
    density: float
    roll: np.ndarray


@root
def add_displacement(motion, bodies, p, wrench):
    """Force of every hull into the hydrostatic row of ``wrench``."""
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
    """Energy of the water that every hull displaces, into the hydrostatic row of ``stored``."""
    for h in range(p.body.size):
        stored[HYDROSTATIC] += p.density * potential(h, motion, p)[0]


@kernel
def potential(h, motion, p):
    """U / rho g of hull ``h`` and its derivatives by z and by n, (3,)."""
    b = p.body[h]
    heave, n = motion.coordinates[6 * b + 2], vector(motion.rotation[b, 2], 0)
    z, total, depth, arm = p.height[h] + heave, 0.0, 0.0, (0.0, 0.0, 0.0)
    for k in range(p.first[h], p.first[h + 1]):
        side = vector(p.box[k, 1], 0)
        middle = -z - dot(n, vector(p.box[k, 0], 0))
        reach = abs(n[0]) * side[0] + abs(n[1]) * side[1] + abs(n[2]) * side[2]
        if middle + reach <= 0.0:
            continue
        part = _wet(z, n, p.moments[k]) if middle >= reach else _cut(z, n, k, p)
        total, depth, arm = total + part[0], depth + part[1], add(arm, part[2])
    arm, half = (arm[0], arm[1], arm[2] + total / n[2]), 0.5 / n[2]
    V, Vp = p.weight[h, 0], vector(p.weight[h], 1)  # of the balanced weight
    return V * heave + dot(n, Vp) - half * total, V + half * depth, add(Vp, scale(half, arm))


@kernel
def _wet(z, n, of):
    """Sums over a parcel under water: of A_k m, its derivatives by depth, and these times r."""
    b, turned = vector(of.first, 0), matvec(of.second, n)
    along = dot(n, b)
    total = of.area * z * z + 2.0 * z * along + dot(n, turned)
    return total, -2.0 * (of.area * z + along), scale(-2.0, add(scale(z, b), turned))


@kernel
def _cut(z, n, parcel, p):
    """The same of a parcel that reaches out of the water, triangle by triangle."""
    total, depth, arm = 0.0, 0.0, (0.0, 0.0, 0.0)
    for k in range(p.begin[parcel], p.begin[parcel + 1]):
        r, s, t = vector(p.corners[k, 0], 0), vector(p.corners[k, 1], 0), vector(p.corners[k, 2], 0)
        m = mean_square(-z - dot(n, r), -z - dot(n, s), -z - dot(n, t))
        A = p.area[k]
        total += A * m[0]
        depth += A * (m[1] + m[2] + m[3])
        arm = add(arm, add(scale(A * m[1], r), add(scale(A * m[2], s), scale(A * m[3], t))))
    return total, depth, arm


@kernel
def mean_square(a, b, c):
    """Mean of max(d, 0)^2 over a triangle, d being linear with these values at its corners, and its
    derivatives by them."""
    if a <= 0.0 and b <= 0.0 and c <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    whole = _whole(a, b, c)
    if a >= 0.0 and b >= 0.0 and c >= 0.0:
        return whole
    if (b > 0.0) == (c > 0.0):
        part, lone = _corner(a, b, c), a
    elif (a > 0.0) == (c > 0.0):
        m, mb, mc, ma = _corner(b, c, a)
        part, lone = (m, ma, mb, mc), b
    else:
        m, mc, ma, mb = _corner(c, a, b)
        part, lone = (m, ma, mb, mc), c
    if lone > 0.0:
        return part
    return whole[0] - part[0], whole[1] - part[1], whole[2] - part[2], whole[3] - part[3]


@kernel
def _whole(a, b, c):
    """Mean of d^2, and its derivatives."""
    s = a + b + c
    return (a * a + b * b + c * c + s * s) / 12.0, (a + s) / 6.0, (b + s) / 6.0, (c + s) / 6.0


@kernel
def _corner(a, b, c):
    """The part of the mean of d^2 from the corner where d = a, at which alone d has its sign."""
    p, q = a / (a - b), a / (a - c)
    m = a * p * q / 6.0
    return a * m, m * (4.0 - p - q), m * p, m * q
