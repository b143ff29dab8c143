"""Fourier transforms of powers of two, without memory of their own.

`transform` leaves its results in an order of its own, that of reversed bits, and `untransform`
takes them in it (Gentleman and Sande 1966; Cooley and Tukey 1965). Products need no other order.
"""

from __future__ import annotations

import numpy as np

from hydrosim.jit.kernels import kernel


def roots_of_unity(half: int) -> np.ndarray:
    """exp(-i pi k / half), k = 0 to half - 1: what transforms of 2 ``half`` values turn by."""
    return np.exp(-1j * np.pi * np.arange(half) / half)


def bit_reversed(size: int) -> np.ndarray:
    """The frequencies (size,) in the order that `transform` leaves them in."""
    order = np.zeros(1, dtype=np.int64)
    while order.size < size:
        order = np.concatenate([2 * order, 2 * order + 1])
    return order


@kernel
def transform(values, turns):
    """Replace ``values`` (n,) by their sums over exp(-2 pi i j k / n), in reversed order."""
    span, stride = turns.size, 1
    while span > 0:
        for start in range(0, values.size, 2 * span):
            for k in range(span):
                a, b = values[start + k], values[start + k + span]
                values[start + k] = a + b
                values[start + k + span] = (a - b) * turns[k * stride]
        span, stride = span // 2, 2 * stride


@kernel
def untransform(values, turns):
    """Undo `transform`."""
    span, stride = 1, turns.size
    while stride > 0:
        for start in range(0, values.size, 2 * span):
            for k in range(span):
                a, b = values[start + k], values[start + k + span] * turns[k * stride].conjugate()
                values[start + k] = a + b
                values[start + k + span] = a - b
        span, stride = 2 * span, stride // 2
    for k in range(values.size):
        values[k] /= values.size


@kernel
def add_products(a, b, total):
    """Add a b to the ``total``, entry by entry."""
    for k in range(total.size):
        total[k] += a[k] * b[k]
