"""Quadratic transfer functions of a body that turns, as filters and a core (see `forms`).

    T-_ij(psi) = sum_rs C_rs(psi) V_ri conj(V_sj),   V_ri = W_ri exp(-i h_r psi),

and T+ without the conjugate. In frequency W are B-splines; C includes the coefficients that combine
them to the splines of `quadratic`. In heading:

* Each heading of the sea has filters of its own. C(psi) is a trigonometric polynomial, of degree N
  for N headings of the database. If the database has pairs of one heading only, each heading is a
  form of its own.
* In seas of many headings that would need more filters. W_ri then contain exp(i h b_i) of all
  harmonics h, and C is constant.

Polynomials are found by sampling `quadratic`. This is exact for evenly spaced headings; splines
over uneven headings are sampled at a sixteenth of their spacing.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.waves.quadratic import (
    all_pairs,
    is_above_noise,
    own_headings,
    pairs_of,
    qtf_table,
    sea_headings,
    unique_headings,
)
from hydrosim.waves.transfer import angle_between, evenly_round, heading_weights

if TYPE_CHECKING:
    from hydrosim.waves.quadratic import QuadraticFunctions

SAMPLES_PER_HEADING = 16  # samples per heading, where headings are uneven
NEGLIGIBLE = 1e-14  # of the largest: smaller outer harmonics are left out


class QtfFilter(NamedTuple):
    """``weights`` of the waves from ``begin`` on, and the harmonic h."""

    begin: int
    weights: np.ndarray
    harmonic: int


class TurnedQtf(NamedTuple):
    """Filters, r of them, and the harmonics of C from the lowest on, (m, 6, r, r), m odd."""

    filters: list[QtfFilter]
    core: np.ndarray


def turned_qtf(
    database: QuadraticFunctions, omega: np.ndarray, heading: np.ndarray, name: str
) -> Iterator[TurnedQtf]:
    """The forms of waves (nw,) of one sea. Raises InputError in the cases of `quadratic`."""
    table = qtf_table(database, name)
    hermitian = name == "qtf_difference"
    pairs = pairs_of(database)
    blocks = all_pairs(pairs, table, hermitian)
    headings = sea_headings(database, heading) if blocks is None else unique_headings(heading)
    splines = _splines(np.asarray(database.qtf_frequency), omega)
    nodes = unique_headings(pairs)
    if blocks is not None and _use_harmonics(nodes.size, headings.size):
        yield _of_harmonics(nodes, blocks, splines, heading, hermitian)
        return
    filters = [
        _filters(
            splines,
            angle_between(heading, to) == angle_between(heading[:, None], headings).min(axis=1),
        )
        for to in headings
    ]
    if blocks is not None:
        core = _pair_core(nodes, blocks, headings)
        yield _form([one for each in filters for one in each], core, splines)
        return
    own = own_headings(pairs)
    for to, each in zip(headings, filters, strict=True):
        yield _form(each, _own_core(pairs[own, 0], table[own], to), splines)


class _Splines(NamedTuple):
    """B-splines of every wave, (nw, nq), and the matrix (nq, nq) that combines them to the cardinal
    splines."""

    basis: np.ndarray
    cardinal: np.ndarray


def _splines(w: np.ndarray, omega: np.ndarray) -> _Splines:
    from scipy.interpolate import BSpline, make_interp_spline  # slow to load

    spline = make_interp_spline(w, np.eye(w.size), k=min(3, w.size - 1))
    clipped = np.clip(omega, w[0], w[-1])
    basis = BSpline.design_matrix(clipped, spline.t, spline.k).toarray()
    return _Splines(basis, spline.c)


def _filters(
    splines: _Splines, chosen: np.ndarray, phase: np.ndarray | None = None, harmonic: int = 0
) -> list[QtfFilter]:
    """One filter for each B-spline, of the ``chosen`` waves (nw,)."""
    filters = []
    for weights in np.where(chosen[:, None], splines.basis, 0.0).T:
        some = np.flatnonzero(weights)
        begin = int(some[0]) if some.size else 0
        end = int(some[-1]) + 1 if some.size else 0
        values = weights if phase is None else weights * phase
        filters.append(QtfFilter(begin, values[begin:end].astype(complex), harmonic))
    return filters


def _form(filters: list[QtfFilter], core: np.ndarray, splines: _Splines) -> TurnedQtf:
    """The form of a ``core`` (m, ns, ns, nq, nq, 6) between ns groups of waves and nq cardinal
    splines."""
    c = splines.cardinal
    by_basis = np.einsum("ax,by,mghxyj->mjgahb", c, c, core, optimize=True)
    m, n, groups, nq = by_basis.shape[:4]
    return TurnedQtf(filters, by_basis.reshape(m, n, groups * nq, groups * nq))


def _own_core(nodes: np.ndarray, table: np.ndarray, to: float) -> np.ndarray:
    """Harmonics of T (m, 1, 1, nq, nq, 6) of waves ``to`` one heading with each other."""
    yaw = _samples(nodes, nodes.size // 2)
    weights = _weights(nodes, to - yaw)
    values = np.tensordot(weights, table, 1)
    return _harmonics(_unless_noise(values, table))[:, None, None]


def _pair_core(nodes: np.ndarray, blocks: np.ndarray, to: np.ndarray) -> np.ndarray:
    """Harmonics of T (m, ns, ns, nq, nq, 6) between waves ``to`` these headings (ns,)."""
    yaw = _samples(nodes, nodes.size)
    weights = _weights(nodes, (to - yaw[:, None]).ravel()).reshape(yaw.size, to.size, -1)
    values = np.einsum("ygp,yhq,pqvwj->yghvwj", weights, weights, blocks, optimize=True)
    return _harmonics(_unless_noise(values, blocks))


def _of_harmonics(
    nodes: np.ndarray,
    blocks: np.ndarray,
    splines: _Splines,
    heading: np.ndarray,
    hermitian: bool,
) -> TurnedQtf:
    """The form of all harmonics of the heading, for a sea of many headings."""
    to = _samples(nodes, nodes.size // 2)
    weights = _weights(nodes, to)
    values = np.einsum("gp,hq,pqvwj->ghvwj", weights, weights, blocks, optimize=True)
    core = np.fft.fft(_unless_noise(values, blocks), axis=0) / to.size
    # the harmonics of a conjugate second wave are conjugate, too
    back = np.fft.ifft if hermitian else np.fft.fft
    core = back(core, axis=1) * (1.0 if hermitian else 1.0 / to.size)
    order = np.rint(np.fft.fftfreq(to.size, 1.0 / to.size)).astype(int)
    every = np.ones(heading.size, dtype=bool)
    filters = [
        one
        for harmonic in order
        for one in _filters(splines, every, np.exp(1j * harmonic * heading), int(harmonic))
    ]
    return _form(filters, core[None], splines)


def _use_harmonics(nodes: int, headings: int) -> bool:
    """True if harmonics of the heading need fewer filters than the headings of the sea one by
    one."""
    return (2 * nodes + 1) * headings**2 > nodes**2 and headings > 1


def _samples(nodes: np.ndarray, degree: int) -> np.ndarray:
    """Angles round the circle that determine a trigonometric polynomial of this degree."""
    count = 2 * degree + 1 if evenly_round(nodes) else 2 * SAMPLES_PER_HEADING * degree + 1
    return 2.0 * np.pi / count * np.arange(count)


def _weights(nodes: np.ndarray, heading: np.ndarray) -> np.ndarray:
    weights = heading_weights(nodes, heading)
    assert weights is not None  # `quadratic.qtf_all_round`
    return weights


def _unless_noise(values: np.ndarray, table: np.ndarray) -> np.ndarray:
    """``values`` (..., 6), set to zero in the DOFs where they are noise of the ``table``."""
    return np.asarray(values * is_above_noise(values, table))


def _harmonics(values: np.ndarray) -> np.ndarray:
    """Coefficients C_m of sum C_m exp(-i m psi), from the lowest on, for values (M, ...) evenly
    round the circle, M odd. Negligible outer ones are left out."""
    found = np.fft.fftshift(np.fft.ifft(values, axis=0), axes=0)
    size = np.abs(found).reshape(len(found), -1).max(axis=1)
    middle = len(found) // 2
    counts = np.maximum(size, size[::-1])[middle:] > NEGLIGIBLE * size.max()
    most = int(np.flatnonzero(counts)[-1]) if counts.any() else 0
    return np.asarray(found[middle - most : middle + most + 1])
