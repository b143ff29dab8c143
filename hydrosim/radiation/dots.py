"""Products along the memory."""

from __future__ import annotations

from hydrosim.kernels import kernel


@kernel
def dot(a, b):
    """a b with eight running sums: one alone waits for each addition in turn."""
    f0, f1, f2, f3, f4, f5, f6, f7 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    eights = a.size - a.size % 8
    for k in range(0, eights, 8):
        f0 += a[k] * b[k]
        f1 += a[k + 1] * b[k + 1]
        f2 += a[k + 2] * b[k + 2]
        f3 += a[k + 3] * b[k + 3]
        f4 += a[k + 4] * b[k + 4]
        f5 += a[k + 5] * b[k + 5]
        f6 += a[k + 6] * b[k + 6]
        f7 += a[k + 7] * b[k + 7]
    for k in range(eights, a.size):
        f0 += a[k] * b[k]
    return ((f0 + f1) + (f2 + f3)) + ((f4 + f5) + (f6 + f7))
