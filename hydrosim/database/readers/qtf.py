"""Quadratic transfer functions from rows of pairs of waves; files often have half of the pairs."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrosim.database.database import Complex, Real
from hydrosim.database.readers.assembly import elevation
from hydrosim.errors import InputError


class Pairs(NamedTuple):
    """Rows of two waves each: ``omega`` and ``heading`` (m, 2), ``dof`` (m,) counted from zero over
    all bodies, and the load ``value`` (m,)."""

    omega: Real
    heading: Real
    dof: NDArray[np.intp]
    value: Complex

    def at_origin(self, point: Real, depth: float, gravity: float, difference: bool) -> Pairs:
        """Loads per elevations at the frame's origin, from those per elevations at ``point``."""
        waves = elevation(self.omega, self.heading, point, depth, gravity)
        second = waves[:, 1].conj() if difference else waves[:, 1]
        return self._replace(value=self.value * waves[:, 0] * second)


def quadratic(
    path: Path, dofs: int, difference: Pairs | None, total: Pairs | None
) -> dict[str, Any]:
    """Fields of the database. Missing rows follow from T-_21 = conj T-_12 and T+_21 = T+_12. Raises
    `InputError` if both orders are missing, or if the two files have different waves."""
    present = [pairs for pairs in (difference, total) if pairs is not None]
    if not present:
        return {}
    frequency, heading = np.unique(present[0].omega), np.unique(present[0].heading, axis=0)
    for other in present[1:]:
        if not _is_equal(np.unique(other.omega), frequency) or not _is_equal(
            np.unique(other.heading, axis=0), heading
        ):
            raise InputError(
                f"{path}: difference- and sum-frequency transfer functions have other waves,"
                " expected the same pairs. Export both for the same waves."
            )
    return {
        "qtf_frequency": frequency,
        "qtf_heading": heading,
        "qtf_difference": _fill(path, dofs, frequency, heading, difference, np.conj),
        "qtf_sum": _fill(path, dofs, frequency, heading, total, np.array),
    }


def _is_equal(a: Real, b: Real) -> bool:
    return a.shape == b.shape and bool((a == b).all())


def _fill(
    path: Path, dofs: int, frequency: Real, heading: Real, pairs: Pairs | None, swapped: Any
) -> Complex | None:
    """Array (np, nq, nq, n); ``swapped`` converts a value to that of the waves in reverse order."""
    if pairs is None:
        return None
    kinds, nq = np.unique(pairs.dof), frequency.size
    least = len(heading) * nq * (nq + 1) // 2 * kinds.size
    if len(pairs.value) < least:  # before memory is reserved for them
        raise _incomplete(path, f"{len(pairs.value)} rows", f"at least {least}")
    lookup = {tuple(pair): number for number, pair in enumerate(heading)}
    first = np.array([lookup[tuple(pair)] for pair in pairs.heading])
    second = np.array([lookup.get(tuple(pair[::-1]), -1) for pair in pairs.heading])
    i, j = np.searchsorted(frequency, pairs.omega).T
    out = np.full((len(heading), nq, nq, dofs), np.nan, dtype=complex)
    known = second >= 0
    out[second[known], j[known], i[known], pairs.dof[known]] = swapped(pairs.value[known])
    out[first, i, j, pairs.dof] = pairs.value
    out[..., np.setdiff1d(np.arange(dofs), kinds)] = 0.0
    missing = np.count_nonzero(np.isnan(out))
    if missing:
        raise _incomplete(path, f"{out.size - missing} values", f"{out.size}")
    return out


def _incomplete(path: Path, found: str, expected: str) -> InputError:
    return InputError(
        f"{path}: found {found} of quadratic transfer functions, expected {expected} for all pairs"
        " of its frequencies, at least those with w_1 >= w_2. Export all pairs, or none."
    )
