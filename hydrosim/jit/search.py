"""Search for the piece of a piecewise function that holds a number."""

from __future__ import annotations

from hydrosim.jit.kernels import kernel


@kernel
def piece_of(x, low, high, pieces):
    """Index, from ``low`` to ``high``, of the last of ``pieces`` that starts at or before ``x``. It
    is ``low`` if all pieces start later."""
    while low < high:
        middle = (low + high + 1) // 2
        if x < pieces[middle].start:
            high = middle - 1
        else:
            low = middle
    return low
