"""Products along the memory."""

from __future__ import annotations

from hydrosim.jit.kernels import summing


@summing
def dot(a, b):
    """a b."""
    total = 0.0
    for k in range(a.size):
        total += a[k] * b[k]
    return total


@summing
def dot_three(a, b):
    """Products of the three rows of ``a``, which follow each other, and b."""
    n = b.size
    first, second, third = 0.0, 0.0, 0.0
    for k in range(n):
        first += a[k] * b[k]
        second += a[n + k] * b[k]
        third += a[2 * n + k] * b[k]
    return first, second, third
