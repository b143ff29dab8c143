"""Connected components of a linear system: parts that nothing couples, each solved by itself.

Work on a whole system grows with the cube of its size, work on its parts with their number. Only an
exact zero is no coupling, so that no weak line is left out.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable

import numpy as np
from scipy import linalg


def find_components(coupled: np.ndarray) -> list[np.ndarray]:
    """Indices, rising, of the components of a graph whose edges are the entries of ``coupled``
    (n, n) that are not zero, in either direction."""
    n = len(coupled)
    edge = coupled != 0
    edge |= edge.T
    edge[np.arange(n), np.arange(n)] = True
    row, column = np.nonzero(edge)
    first = np.searchsorted(row, np.arange(n))
    label = np.arange(n)
    while n:
        least = np.minimum.reduceat(label[column], first)
        least = least[least]  # labels are members, so this goes on to the label of the label
        if np.array_equal(least, label):
            break
        label = least
    return [np.flatnonzero(label == k) for k in np.unique(label)]


def digest_arrays(arrays: Iterable[np.ndarray]) -> bytes:
    """What tells arrays apart, to the bit: components of equal arrays are solved once."""
    digest = hashlib.sha256()
    for x in arrays:
        digest.update(f"{x.dtype}{x.shape}".encode())
        digest.update(np.ascontiguousarray(x).data)
    return digest.digest()


def find_eigenvalues(matrix: np.ndarray) -> np.ndarray:
    """The eigenvalues (n,) of a ``matrix`` (n, n), component by component."""
    solved: dict[bytes, np.ndarray] = {}
    found = [np.zeros(0, dtype=complex)]
    for places in find_components(matrix):
        block = matrix[np.ix_(places, places)]
        content = digest_arrays([block])
        if content not in solved:
            solved[content] = linalg.eigvals(block)
        found.append(solved[content])
    return np.concatenate(found)
