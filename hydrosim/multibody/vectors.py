"""Vectors of two, three and six, quaternions, and differences of attitudes.

Vectors are tuples: no allocation, and formulas that read like formulas.

Unit quaternions (q0, q1, q2, q3), scalar first, are rotations R(q), with R(a b) = R(a) R(b).
"""

from __future__ import annotations

from math import atan2, cos, sin, sqrt, tan

import numpy as np

from hydrosim.jit.kernels import kernel

ALMOST_ZERO = 1e-4  # rad: below it series replace quotients that lose digits


@kernel
def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@kernel
def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@kernel
def scale(c, a):
    return (c * a[0], c * a[1], c * a[2])


@kernel
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@kernel
def vector(array, k):
    """The three entries of a flat array from index k."""
    return (array[k], array[k + 1], array[k + 2])


@kernel
def matvec(A, a):
    """Product of a (3, 3) array and a vector."""
    return (
        A[0, 0] * a[0] + A[0, 1] * a[1] + A[0, 2] * a[2],
        A[1, 0] * a[0] + A[1, 1] * a[1] + A[1, 2] * a[2],
        A[2, 0] * a[0] + A[2, 1] * a[1] + A[2, 2] * a[2],
    )


@kernel
def length(a):
    """|a| of a vector of two."""
    return sqrt(a[0] * a[0] + a[1] * a[1])


@kernel
def product(A, x, k):
    """Product of a (6, 6) array and the six entries of ``x`` from index k, as a tuple."""
    y = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for j in range(6):
        a = x[k + j]
        y = (
            y[0] + A[0, j] * a,
            y[1] + A[1, j] * a,
            y[2] + A[2, j] * a,
            y[3] + A[3, j] * a,
            y[4] + A[4, j] * a,
            y[5] + A[5, j] * a,
        )
    return y


@kernel
def quaternion_about(axis, angle):
    """Rotation by an angle about a unit vector."""
    s = sin(0.5 * angle)
    return (cos(0.5 * angle), s * axis[0], s * axis[1], s * axis[2])


@kernel
def multiply(a, b):
    """The product a b."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


@kernel
def rotate_vector(q, v):
    """R(q) v."""
    axis = (q[1], q[2], q[3])
    across = cross(axis, v)
    return add(v, scale(2.0, add(scale(q[0], across), cross(axis, across))))


@kernel
def fill_rotation(q, R):
    """Fill ``R`` (3, 3) with R(q)."""
    for j in range(3):
        column = rotate_vector(q, (1.0 * (j == 0), 1.0 * (j == 1), 1.0 * (j == 2)))
        for i in range(3):
            R[i, j] = column[i]


@kernel
def quaternion_of_parameters(s):
    """Rotation of the modified Rodrigues parameters s = tan(angle / 4) axis (Schaub & Junkins,
    Analytical Mechanics of Space Systems, 2003, eq. 3.138)."""
    square = dot(s, s)
    c = 1.0 / (1.0 + square)
    return ((1.0 - square) * c, 2.0 * c * s[0], 2.0 * c * s[1], 2.0 * c * s[2])


@kernel
def parameter_rates(s, omega):
    """Rates of 4 s for the angular velocity in the fixed frame (the same, eq. 3.153, whose body
    frame changes one sign). They equal omega at s = 0."""
    rates = add(scale(1.0 - dot(s, s), omega), scale(2.0, cross(omega, s)))
    return add(rates, scale(2.0 * dot(s, omega), s))


@kernel
def rotation_vector(q):
    """Rotation vector with an angle of at most 180 deg."""
    sign = 1.0 if q[0] >= 0.0 else -1.0
    axis = (sign * q[1], sign * q[2], sign * q[3])
    s = sqrt(dot(axis, axis))
    if s < ALMOST_ZERO:
        return scale(2.0 * (1.0 + s * s / 6.0), axis)
    return scale(2.0 * atan2(s, sign * q[0]) / s, axis)


@kernel
def vector_rates(vector, omega):
    """Rates of a rotation vector for the angular velocity in the fixed frame."""
    across = cross(vector, omega)
    change = add(scale(-0.5, across), scale(_third_coefficient(vector), cross(vector, across)))
    return add(omega, change)


@kernel
def conjugate_moment(vector, force):
    """Moment in the fixed frame whose power is ``force`` times the rates of a rotation vector."""
    across = cross(vector, force)
    change = add(scale(0.5, across), scale(_third_coefficient(vector), cross(vector, across)))
    return add(force, change)


@kernel
def _third_coefficient(vector):
    """(1 - (a/2) cot(a/2)) / a^2 of an angle a."""
    square = dot(vector, vector)
    if square < ALMOST_ZERO:
        return 1.0 / 12.0 + square / 720.0 + square * square / 30240.0
    half = 0.5 * sqrt(square)
    return (1.0 - half / tan(half)) / square


# Differences of attitudes (roll, pitch, yaw) at many times.


def rotation_vectors(ours: np.ndarray, theirs: np.ndarray) -> np.ndarray:
    """Rotation vectors (..., 3) [rad] from the attitudes ``theirs`` to ``ours``, both (..., 3) as
    roll, pitch and yaw. Axes are those of the earth, turned by the yaw of ``theirs``."""
    w, x, y, z = _multiply_quaternions(
        _quaternions_of_angles(ours), _conjugate_quaternion(_quaternions_of_angles(theirs))
    )
    size = np.sqrt(x * x + y * y + z * z)
    angle = 2.0 * np.arctan2(size, np.abs(w)) * np.where(w < 0.0, -1.0, 1.0)
    scale = np.divide(angle, size, out=np.full_like(size, 2.0), where=size > 0.0)
    c = np.cos(theirs[..., 2])
    s = np.sin(theirs[..., 2])
    return np.stack([scale * (c * x + s * y), scale * (c * y - s * x), scale * z], axis=-1)


def _quaternions_of_angles(angles: np.ndarray) -> tuple[np.ndarray, ...]:
    """Unit quaternions (w, x, y, z) of roll, pitch and yaw (..., 3), intrinsic z, y', x''."""
    roll, pitch, yaw = np.moveaxis(0.5 * angles, -1, 0)
    zero = np.zeros_like(yaw)
    about_x = (np.cos(roll), np.sin(roll), zero, zero)
    about_y = (np.cos(pitch), zero, np.sin(pitch), zero)
    about_z = (np.cos(yaw), zero, zero, np.sin(yaw))
    return _multiply_quaternions(about_z, _multiply_quaternions(about_y, about_x))


def _conjugate_quaternion(q: tuple[np.ndarray, ...]) -> tuple[np.ndarray, ...]:
    w, x, y, z = q
    return w, -x, -y, -z


def _multiply_quaternions(
    p: tuple[np.ndarray, ...], q: tuple[np.ndarray, ...]
) -> tuple[np.ndarray, ...]:
    a, b, c, d = p
    w, x, y, z = q
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )
