"""Vectors of two, three and six as tuples: no allocation, and formulas that read like formulas."""

from __future__ import annotations

from math import sqrt

from hydrosim.jit.kernels import kernel


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
