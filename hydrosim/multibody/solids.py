"""Volume of closed meshes below a plane.

    int_{d > 0} d dV = -1 / (2 n_3) sum_k A_k m(d_k),    d = -(z + n . r)

n: the vertical in the axes of the mesh; r: a point of it; d: its depth below the plane; z: the
height of the origin above the plane. Gauss's theorem turns the integral over the volume into one
over the plane triangles k. A_k are their areas seen from above, positive for upward ones. m(d_k) is
the mean of max(d, 0)^2 over each triangle, in closed form. Upright triangles do not count.

Triangles are grouped in parcels. For a parcel wholly below the plane the sum is a polynomial of
second degree in z and n. Only parcels that the plane cuts are summed by triangle. Limit: n_3 > 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import kernel
from hydrosim.multibody.vectors import add, dot, matvec, scale, vector

MOMENTS = np.dtype([("area", float), ("first", float, 3), ("second", float, (3, 3))])
"""Constants of a parcel: the sums of A_k times the means of 1, r and r r^T over each triangle."""


class Solids(NamedTuple):
    """Constants of ns meshes: the first parcel of each, ``first`` (ns + 1,); the first triangle of
    each parcel, ``begin`` (np + 1,); the centre and the half sides of its bounding box, ``box``
    (np, 2, 3); its `MOMENTS` (np,); ``corners`` (nt, 3, 3) of the triangles, and their ``area``
    (nt,) seen from above."""

    first: np.ndarray
    begin: np.ndarray
    box: np.ndarray
    moments: np.ndarray
    corners: np.ndarray
    area: np.ndarray


@kernel
def sums_below(z, n, h, p):
    """Sums of mesh ``h``: sum A_k m(d_k), its derivative by the depth d, and this times r, (3,).
    The volume below the plane is -1 / (2 n_3) times the second."""
    total = 0.0
    depth = 0.0
    arm = (0.0, 0.0, 0.0)
    for k in range(p.first[h], p.first[h + 1]):
        middle, reach = _depths(z, n, p.box[k])
        if middle + reach <= 0.0:
            continue
        part = _wet_box(z, n, p.moments[k]) if middle >= reach else _cut_parcel(z, n, k, p)
        total, depth, arm = total + part[0], depth + part[1], add(arm, part[2])
    return total, depth, arm


@kernel
def area_below(z, n, h, p):
    """Sum, for mesh ``h``, of the parts of A_k below the plane. The area of the mesh's section by
    the plane is -1 / n_3 times this sum."""
    total = 0.0
    for k in range(p.first[h], p.first[h + 1]):
        middle, reach = _depths(z, n, p.box[k])
        if middle >= reach:
            total += p.moments[k].area
        elif middle + reach > 0.0:
            for i in range(p.begin[k], p.begin[k + 1]):
                r, s, t = p.corners[i, 0], p.corners[i, 1], p.corners[i, 2]
                total += p.area[i] * _submerged_fraction(
                    _depth(z, n, r), _depth(z, n, s), _depth(z, n, t)
                )
    return total


@kernel
def _depths(z, n, box):
    """Depth of the centre of a box, and the largest difference from it inside the box."""
    side = vector(box[1], 0)
    middle = -z - dot(n, vector(box[0], 0))
    return middle, abs(n[0]) * side[0] + abs(n[1]) * side[1] + abs(n[2]) * side[2]


@kernel
def _depth(z, n, r):
    return -z - dot(n, vector(r, 0))


@kernel
def _submerged_fraction(a, b, c):
    """Fraction of a triangle below the plane, from the depths of its corners."""
    if a <= 0.0 and b <= 0.0 and c <= 0.0:
        return 0.0
    if a >= 0.0 and b >= 0.0 and c >= 0.0:
        return 1.0
    if (b > 0.0) == (c > 0.0):
        lone = a
        part = a * a / ((a - b) * (a - c))
    elif (a > 0.0) == (c > 0.0):
        lone = b
        part = b * b / ((b - c) * (b - a))
    else:
        lone = c
        part = c * c / ((c - a) * (c - b))
    return part if lone > 0.0 else 1.0 - part


@kernel
def _wet_box(z, n, of):
    """Sums over a parcel below the plane: A_k m, its derivatives by depth, and these times r."""
    b, turned = vector(of.first, 0), matvec(of.second, n)
    along = dot(n, b)
    total = of.area * z * z + 2.0 * z * along + dot(n, turned)
    return total, -2.0 * (of.area * z + along), scale(-2.0, add(scale(z, b), turned))


@kernel
def _cut_parcel(z, n, parcel, p):
    """`_wet_box` for a parcel that reaches above the plane, triangle by triangle."""
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
    """Mean of max(d, 0)^2 over a triangle, and its derivatives by the values of d at the corners; d
    is linear between them."""
    if a <= 0.0 and b <= 0.0 and c <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    whole = _mean_square_whole(a, b, c)
    if a >= 0.0 and b >= 0.0 and c >= 0.0:
        return whole
    if (b > 0.0) == (c > 0.0):
        part, lone = _mean_square_corner(a, b, c), a
    elif (a > 0.0) == (c > 0.0):
        m, mb, mc, ma = _mean_square_corner(b, c, a)
        part, lone = (m, ma, mb, mc), b
    else:
        m, mc, ma, mb = _mean_square_corner(c, a, b)
        part, lone = (m, ma, mb, mc), c
    if lone > 0.0:
        return part
    return whole[0] - part[0], whole[1] - part[1], whole[2] - part[2], whole[3] - part[3]


@kernel
def _mean_square_whole(a, b, c):
    """Mean of d^2, and its derivatives."""
    s = a + b + c
    return (a * a + b * b + c * c + s * s) / 12.0, (a + s) / 6.0, (b + s) / 6.0, (c + s) / 6.0


@kernel
def _mean_square_corner(a, b, c):
    """Share of the mean of d^2 from the corner where d = a, the only corner with that sign of d."""
    p, q = a / (a - b), a / (a - c)
    m = a * p * q / 6.0
    return a * m, m * (4.0 - p - q), m * p, m * q
