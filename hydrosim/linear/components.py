"""Connected components of a linear system: parts without coupling, each solved by itself.

Work on a whole system grows with the cube of its size, work on its parts with their number. Only an
exact zero counts as no coupling, so that no weak line is left out.
"""

from __future__ import annotations

import numpy as np


def find_components(coupled: np.ndarray) -> list[np.ndarray]:
    """Indices, rising, of the components of a graph. Its edges are the non-zero entries of
    ``coupled`` (n, n), in either direction."""
    edge = coupled != 0
    edge |= edge.T
    left = np.ones(len(edge), dtype=bool)
    found = []
    while left.any():
        reached = np.arange(left.size) == left.argmax()
        new = reached
        while new.any():
            new = edge[new].any(axis=0) & ~reached
            reached = reached | new
        found.append(np.flatnonzero(reached))
        left &= ~reached
    return found


def expand_to_active(values: np.ndarray, own: np.ndarray, active: np.ndarray) -> np.ndarray:
    """Expand the ``values`` (k,) of the coordinates ``own`` (k,) to all ``active`` coordinates
    (n,), rising; zero elsewhere."""
    every = np.zeros(active.size, dtype=values.dtype)
    every[np.searchsorted(active, own)] = values
    return every
