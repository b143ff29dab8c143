"""Quadratic transfer functions of a database at the frequencies and headings of a sea.

Both frequencies are interpolated by cubic splines that are exact at the nodes. Below and above its
frequencies a QTF keeps its value at their end. The change of the mean drift of the database beyond
that end is added by Newman's approximation, so that the diagonal continues as mean drift.

Headings are interpolated like those of first-order loads if the database has all pairs of its
headings. If it has pairs of one heading only, waves of different headings cause no second-order
load together.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

from hydrosim.errors import InputError
from hydrosim.waves.second_order import Factors, add_factors, newman
from hydrosim.waves.transfer import (
    NOISE,
    TransferFunctions,
    angle_between,
    heading_weights,
    mean_drift_at,
)

if TYPE_CHECKING:
    from hydrosim.waves.components import WaveComponents

_SAME = 1e-6  # rad: headings closer than this are one
MOST_HEADINGS = 8  # headings of a sea in which waves of different headings load nothing together


class QuadraticFunctions(TransferFunctions, Protocol):
    """QTFs that this module reads of a database: ``qtf_frequency`` (nq,) [rad/s], pairs
    ``qtf_heading`` (np, 2) [rad], and ``qtf_difference`` and ``qtf_sum`` (np, nq, nq, n)."""

    @property
    def qtf_frequency(self) -> np.ndarray | None: ...
    @property
    def qtf_heading(self) -> np.ndarray | None: ...
    @property
    def qtf_difference(self) -> np.ndarray | None: ...
    @property
    def qtf_sum(self) -> np.ndarray | None: ...


def difference_factors(database: QuadraticFunctions, waves: WaveComponents) -> Factors:
    """T- of all loads for the waves. Raises InputError if the database has none, or none for the
    waves' headings."""
    found = _factors(database, waves, "qtf_difference")
    if database.mean_drift is None:
        return found
    ends = np.clip(waves.omega, *_ends(database))
    drift = [mean_drift_at(database, waves.heading, omega) for omega in (waves.omega, ends)]
    beyond = drift[0] - drift[1]
    return add_factors(found, newman(beyond)) if np.any(beyond) else found


def sum_factors(database: QuadraticFunctions, waves: WaveComponents) -> Factors:
    """T+ of all loads for the waves; raises as `difference_factors` does."""
    return _factors(database, waves, "qtf_sum")


def separate_headings(database: QuadraticFunctions, waves: WaveComponents) -> bool:
    """True if waves of different headings load a body together at first order only."""
    pairs = pairs_of(database)
    nodes = unique_headings(pairs).size
    return unique_headings(waves.heading).size > 1 and len(pairs) < nodes * (nodes + 1) // 2


def qtf_all_round(database: QuadraticFunctions) -> bool:
    """True if any heading has QTFs around it, or the database has no QTF."""
    if database.qtf_heading is None:
        return True
    pairs = pairs_of(database)
    nodes = unique_headings(pairs)
    if len(pairs) < nodes.size * (nodes.size + 1) // 2:
        nodes = pairs[own_headings(pairs), 0]
    every = np.radians(np.arange(0.0, 360.0, 5.0))
    return nodes.size > 0 and heading_weights(nodes, every) is not None


def qtf_table(database: QuadraticFunctions, name: str) -> np.ndarray:
    """The QTF called ``name``; raises InputError if the database has none."""
    table: np.ndarray | None = getattr(database, name)
    if table is None or database.qtf_frequency is None or database.qtf_heading is None:
        raise InputError(
            f"{database.source}: has no {name}, which wave_forces.second_order: qtf"
            f"{' with sum_frequency' if name == 'qtf_sum' else ''} needs; choose newman, or a"
            " database that has it (see `hydrosim db info`)."
        )
    return table


def _factors(database: QuadraticFunctions, waves: WaveComponents, name: str) -> Factors:
    """T of all loads as factors: weights are products of the weights of frequency and heading
    nodes, heading by heading."""
    from scipy.interpolate import make_interp_spline  # slow to load, and few scenes have a QTF

    table = qtf_table(database, name)
    w = np.asarray(database.qtf_frequency)
    clipped = np.clip(waves.omega, *_ends(database))
    splines = make_interp_spline(w, np.eye(w.size), k=min(3, w.size - 1))(clipped).T
    headings, blocks = _blocks(database, waves, name)
    weights = (headings[:, None] * splines).reshape(-1, waves.omega.size)
    nh, nq, n = len(headings), w.size, table.shape[-1]
    core = blocks.transpose(4, 0, 2, 1, 3).reshape(n, nh * nq, nh * nq)
    return Factors(weights, core * is_above_noise(core.T, table)[:, None, None])


def is_above_noise(values: np.ndarray, table: np.ndarray) -> np.ndarray:
    """True for each load (n,) of ``values`` (..., n) from a ``table`` that is above the solver's
    noise."""
    n = table.shape[-1]
    largest = np.abs(table).reshape(-1, n).max(axis=0).reshape(-1, 3).max(axis=1)
    return np.asarray(np.abs(values).reshape(-1, n).max(axis=0) > NOISE * np.repeat(largest, 3))


def _ends(database: QuadraticFunctions) -> np.ndarray:
    return np.asarray(database.qtf_frequency)[[0, -1]]


def pairs_of(database: QuadraticFunctions) -> np.ndarray:
    """Pairs of headings (np, 2) [rad]."""
    return np.asarray(database.qtf_heading)


def _blocks(
    database: QuadraticFunctions, waves: WaveComponents, name: str
) -> tuple[np.ndarray, np.ndarray]:
    """Weights of the waves at heading nodes (nh, nw), and T (nh, nh, nq, nq, n) between these
    nodes."""
    pairs = pairs_of(database)
    table = qtf_table(database, name)
    blocks = all_pairs(pairs, table, name == "qtf_difference")
    if blocks is None:
        return _each_heading(database, waves, table)
    weights = heading_weights(unique_headings(pairs), waves.heading)
    if weights is None:
        raise InputError(_no_heading(database, waves.heading))
    used = np.any(weights != 0.0, axis=0)
    return weights[:, used].T, blocks[used][:, used]


def _each_heading(
    database: QuadraticFunctions, waves: WaveComponents, table: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """`_blocks` with the headings of the sea as nodes; T between different headings is zero."""
    headings = sea_headings(database, waves.heading)
    pairs = pairs_of(database)
    own = own_headings(pairs)
    weights = heading_weights(pairs[own, 0], headings)
    if weights is None:
        raise InputError(_no_heading(database, headings))
    shape = (headings.size, headings.size, *table.shape[1:])
    blocks = np.zeros(shape, dtype=complex)
    for k, row in enumerate(weights):
        blocks[k, k] = np.tensordot(row, table[own], 1)
    return (angle_between(waves.heading, headings[:, None]) < _SAME).astype(float), blocks


def own_headings(pairs: np.ndarray) -> np.ndarray:
    """Indices of the ``pairs`` (np, 2) of a heading with itself."""
    return np.flatnonzero(angle_between(*pairs.T) < _SAME)


def sea_headings(database: QuadraticFunctions, heading: np.ndarray) -> np.ndarray:
    """The different headings of a sea of waves to ``heading`` (nw,). Raises InputError if the sea
    has too many headings for a database without pairs of different headings."""
    headings = unique_headings(heading)
    if headings.size > MOST_HEADINGS:
        raise InputError(
            f"{database.source}: has QTFs for pairs of waves of one heading only, and the sea has"
            f" {headings.size} headings; expected at most {MOST_HEADINGS}. Choose"
            " wave_forces.second_order: newman, or a database with all pairs of headings."
        )
    return headings


def all_pairs(pairs: np.ndarray, table: np.ndarray, hermitian: bool) -> np.ndarray | None:
    """T (nh, nh, nq, nq, n) between all headings; None if a pair is missing in both orders."""
    nodes = unique_headings(pairs)
    number = np.argmin(angle_between(pairs[:, :, None], nodes), axis=-1)
    known = np.zeros((nodes.size, nodes.size), dtype=bool)
    blocks = np.zeros((*known.shape, *table.shape[1:]), dtype=complex)
    for (i, j), block in zip(number, table, strict=True):
        swapped = block.swapaxes(0, 1)
        blocks[j, i] = blocks[j, i] if known[j, i] else swapped.conj() if hermitian else swapped
        blocks[i, j] = block
        known[i, j] = known[j, i] = True
    return blocks if known.all() else None


def unique_headings(heading: np.ndarray) -> np.ndarray:
    """The different headings, ascending."""
    angle = np.sort(np.mod(np.ravel(heading), 2.0 * np.pi))
    different = angle_between(angle, np.roll(angle, 1)) >= _SAME
    return angle[different] if np.any(different) else angle[:1]


def _no_heading(database: QuadraticFunctions, headings: np.ndarray) -> str:
    have = ", ".join(f"{h:.4g}" for h in np.degrees(unique_headings(pairs_of(database))))
    wanted = ", ".join(f"{h:.4g}" for h in np.degrees(unique_headings(headings))[:5])
    return (
        f"{database.source}: found QTFs for waves to {have} deg; expected headings around"
        f" {wanted} deg, at most 45 deg apart. Choose wave_forces.second_order: newman, other"
        " waves, or a database with these headings."
    )
