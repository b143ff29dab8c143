"""Second-order loads: sums over pairs of waves, interpolated QTFs, and QTFs of turning bodies.

Two waves of complex elevations a_i, a_j load a body at the difference of their frequencies, and at
the sum:

    F-(t) = Re sum_ij a_i conj(a_j) T-_ij exp(i (w_i - w_j) t),   T-_ji = conj T-_ij
    F+(t) = Re sum_ij a_i a_j T+_ij exp(i (w_i + w_j) t),         T+_ji = T+_ij

Every transfer function here has few factors, T_ij = sum_rs C_rs W_ri W_sj. So sums over pairs of
waves become sums over pairs of filtered elevations. Fourier transforms give these for all waves of
a grid:

    F-(t) = Re sum_rs C_rs z_r conj(z_s),   F+(t) = Re sum_rs C_rs z_r z_s,
    z_r(t) = sum_i W_ri a_i exp(i w_i t)

The factors of Newman's approximation are drift coefficients. The factors of a quadratic transfer
function are the splines that interpolate it (`difference_factors`, `sum_factors`).

Quadratic transfer functions of a database at the frequencies and headings of a sea.

Both frequencies are interpolated by cubic splines that are exact at the nodes. Below and above its
frequencies a QTF keeps its value at their end. The change of the mean drift of the database beyond
that end is added by Newman's approximation, so that the diagonal continues as mean drift.

Headings are interpolated like those of first-order loads if the database has all pairs of its
headings. If it has pairs of one heading only, waves of different headings cause no second-order
load together.

Quadratic transfer functions of a body that turns, as filters and a core (`TurnedQtf`).

    T-_ij(psi) = sum_rs C_rs(psi) V_ri conj(V_sj),   V_ri = W_ri exp(-i h_r psi),

and T+ without the conjugate. In frequency W are B-splines; C includes the coefficients that combine
them to the splines of `difference_factors`. In heading:

* Each heading of the sea has filters of its own. C(psi) is a trigonometric polynomial, of degree N
  for N headings of the database. If the database has pairs of one heading only, each heading is a
  form of its own.
* In seas of many headings that would need more filters. W_ri then contain exp(i h b_i) of all
  harmonics h, and C is constant.

Polynomials are found by sampling `qtf_table`. This is exact for evenly spaced headings; splines
over uneven headings are sampled at a sixteenth of their spacing.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
import scipy

from hydrosim.errors import InputError
from hydrosim.water import transfer
from hydrosim.water.loads import SpectralLines

if TYPE_CHECKING:
    from hydrosim.water.components import WaveComponents

MOST_WAVES = 60  # waves off a grid: their pairs are summed one by one, at every stage of every step


@dataclass(frozen=True, eq=False)
class Factors:
    """T_ij of n loads for nw waves: ``weights`` W (r, nw) and ``core`` C (n, r, r)."""

    weights: np.ndarray
    core: np.ndarray

    def pairs(self) -> np.ndarray:
        """T as a full matrix, (n, nw, nw)."""
        return np.asarray(self.weights.T @ self.core @ self.weights)


def newman(drift: np.ndarray) -> Factors:
    """T-_ij = (D_i + D_j) / 2 from mean drift D (nw, n) [N/m^2, N m/m^2] (Newman 1974)."""
    waves, loads = drift.shape
    core = np.zeros((loads, 1 + loads, 1 + loads))
    load_indices = np.arange(loads)
    core[load_indices, 0, 1 + load_indices] = core[load_indices, 1 + load_indices, 0] = 0.5
    return Factors(np.vstack([np.ones((1, waves)), drift.T]), core)


def newman_square_root(drift: np.ndarray) -> Factors:
    """T-_ij = sign(D_i) sqrt(D_i D_j) from mean drift D (nw, n), zero where the signs differ
    (Newman's approximation with a geometric mean, as in Standing, Brendling and Wilson 1987)."""
    loads = drift.shape[1]
    parts = np.hstack([np.maximum(drift, 0.0), np.maximum(-drift, 0.0)])
    core = np.zeros((loads, 2 * loads, 2 * loads))
    load_indices = np.arange(loads)
    core[load_indices, load_indices, load_indices] = 1.0
    core[load_indices, loads + load_indices, loads + load_indices] = -1.0
    return Factors(np.sqrt(parts).T, core)


def add_factors(first: Factors, second: Factors) -> Factors:
    """The sum of two transfer functions."""
    n, r, s = len(first.core), len(first.weights), len(second.weights)
    core = np.zeros((n, r + s, r + s), dtype=np.result_type(first.core, second.core))
    core[:, :r, :r], core[:, r:, r:] = first.core, second.core
    return Factors(np.vstack([first.weights, second.weights]), core)


def mean_load(elevation: np.ndarray, drift: np.ndarray) -> SpectralLines:
    """The mean load sum_i D_i |a_i|^2 alone, as a line at zero frequency; ``elevation`` (nw,) [m],
    ``drift`` (nw, n)."""
    return SpectralLines(np.zeros(1), (np.abs(elevation) ** 2 @ drift + 0j)[None])


def difference_loads(
    waves: WaveComponents, elevation: np.ndarray, factors: Factors
) -> SpectralLines:
    """Lines of F- for waves of complex ``elevation`` (nw,) [m] at the body.

    Raises InputError if there are more than `MOST_WAVES` and they are not on a grid.
    """
    if waves.spacing == 0.0:
        pairs = factors.pairs() * np.outer(elevation, elevation.conj())
        i, j = _each_pair(waves)
        return SpectralLines(
            np.abs(waves.omega[i] - waves.omega[j]), _difference_amplitudes(waves, pairs, i, j)
        )
    z = _filter_elevation(waves, elevation, factors)
    record = [np.sum((z @ core) * z.conj(), axis=1).real for core in factors.core]
    lines = scipy.fft.rfft(np.array(record).T, axis=0) / len(z)
    lines[1:] *= 2.0
    lines = lines[: int(waves.index.max())]
    return SpectralLines(waves.spacing * np.arange(len(lines)), lines)


def sum_loads(waves: WaveComponents, elevation: np.ndarray, factors: Factors) -> SpectralLines:
    """Lines of F+ for waves of complex ``elevation`` (nw,) [m] at the body, see
    `difference_loads`."""
    if waves.spacing == 0.0:
        pairs = factors.pairs() * np.outer(elevation, elevation)
        i, j = _each_pair(waves)
        twice = np.where(i == j, 1.0, 2.0)[:, None]
        return SpectralLines(waves.omega[i] + waves.omega[j], twice * pairs[:, i, j].T)
    z = _filter_elevation(waves, elevation, factors)
    record = [np.sum((z @ core) * z, axis=1) for core in factors.core]
    lines = scipy.fft.fft(np.array(record).T, axis=0) / len(z)
    lines = lines[: 2 * int(waves.index.max()) + 1]
    return SpectralLines(waves.spacing * np.arange(len(lines)), lines)


def _filter_elevation(waves: WaveComponents, elevation: np.ndarray, factors: Factors) -> np.ndarray:
    """z (N, r) at N times of the repeat period; N is large enough that no product of two is
    aliased."""
    count = scipy.fft.next_fast_len(2 * int(waves.index.max()) + 1)
    lines = np.zeros((count, len(factors.weights)), dtype=complex)
    np.add.at(lines, waves.index, (factors.weights * elevation).T)
    return np.asarray(scipy.fft.ifft(lines, axis=0)) * count


def _each_pair(waves: WaveComponents) -> tuple[np.ndarray, np.ndarray]:
    """Indices (i, j) of every pair of waves off the grid, once, and of each wave with itself."""
    if waves.omega.size > MOST_WAVES:
        raise InputError(
            f"environment.waves: found {waves.omega.size} given waves whose frequencies are not on"
            f" a grid; expected at most {MOST_WAVES}, because their second-order loads are summed"
            " pair by pair. Give fewer waves, or set wave_forces.second_order: mean_drift."
        )
    return np.tril_indices(waves.omega.size)


def _difference_amplitudes(
    waves: WaveComponents, pairs: np.ndarray, i: np.ndarray, j: np.ndarray
) -> np.ndarray:
    """Amplitudes (m, n) of the lines of the pairs (i, j), each with (j, i), at |w_i - w_j|."""
    values = pairs[:, i, j].T
    turned = np.where((waves.omega[i] >= waves.omega[j])[:, None], values, values.conj())
    return np.where((i == j)[:, None], turned, 2.0 * turned)


_SAME = 1e-6  # rad: headings closer than this are one
MOST_HEADINGS = 8  # headings of a sea in which waves of different headings load nothing together


class QuadraticFunctions(transfer.TransferFunctions, Protocol):
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
    factors = _factors_of_database(database, waves, "qtf_difference")
    if database.mean_drift is None:
        return factors
    ends = np.clip(waves.omega, *_frequency_ends(database))
    drift = [
        transfer.mean_drift_at(database, waves.heading, omega) for omega in (waves.omega, ends)
    ]
    beyond = drift[0] - drift[1]
    return add_factors(factors, newman(beyond)) if np.any(beyond) else factors


def sum_factors(database: QuadraticFunctions, waves: WaveComponents) -> Factors:
    """T+ of all loads for the waves; raises as `difference_factors` does."""
    return _factors_of_database(database, waves, "qtf_sum")


def has_separate_headings(database: QuadraticFunctions, waves: WaveComponents) -> bool:
    """True if waves of different headings load a body together at first order only."""
    pairs = pairs_of(database)
    nodes = unique_headings(pairs).size
    return unique_headings(waves.heading).size > 1 and len(pairs) < nodes * (nodes + 1) // 2


def has_qtf_around(database: QuadraticFunctions) -> bool:
    """True if any heading has QTFs around it, or the database has no QTF."""
    if database.qtf_heading is None:
        return True
    pairs = pairs_of(database)
    nodes = unique_headings(pairs)
    if len(pairs) < nodes.size * (nodes.size + 1) // 2:
        nodes = pairs[own_headings(pairs), 0]
    every = np.radians(np.arange(0.0, 360.0, 5.0))
    return nodes.size > 0 and transfer.heading_weights(nodes, every) is not None


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


def _factors_of_database(database: QuadraticFunctions, waves: WaveComponents, name: str) -> Factors:
    """T of all loads as factors: weights are products of the weights of frequency and heading
    nodes, heading by heading."""
    from scipy.interpolate import make_interp_spline  # slow to load, and few scenes have a QTF

    table = qtf_table(database, name)
    w = np.asarray(database.qtf_frequency)
    clipped = np.clip(waves.omega, *_frequency_ends(database))
    splines = make_interp_spline(w, np.eye(w.size), k=min(3, w.size - 1))(clipped).T
    headings, blocks = _blocks_of_headings(database, waves, name)
    weights = (headings[:, None] * splines).reshape(-1, waves.omega.size)
    nh, nq, n = len(headings), w.size, table.shape[-1]
    core = blocks.transpose(4, 0, 2, 1, 3).reshape(n, nh * nq, nh * nq)
    return Factors(weights, core * is_above_noise(core.T, table)[:, None, None])


def is_above_noise(values: np.ndarray, table: np.ndarray) -> np.ndarray:
    """True for each load (n,) of ``values`` (..., n) from a ``table`` that is above the solver's
    noise."""
    n = table.shape[-1]
    largest = np.abs(table).reshape(-1, n).max(axis=0).reshape(-1, 3).max(axis=1)
    return np.asarray(
        np.abs(values).reshape(-1, n).max(axis=0) > transfer.NOISE * np.repeat(largest, 3)
    )


def _frequency_ends(database: QuadraticFunctions) -> np.ndarray:
    return np.asarray(database.qtf_frequency)[[0, -1]]


def pairs_of(database: QuadraticFunctions) -> np.ndarray:
    """Pairs of headings (np, 2) [rad]."""
    return np.asarray(database.qtf_heading)


def _blocks_of_headings(
    database: QuadraticFunctions, waves: WaveComponents, name: str
) -> tuple[np.ndarray, np.ndarray]:
    """Weights of the waves at heading nodes (nh, nw), and T (nh, nh, nq, nq, n) between these
    nodes."""
    pairs = pairs_of(database)
    table = qtf_table(database, name)
    blocks = all_pairs(pairs, table, name == "qtf_difference")
    if blocks is None:
        return _each_heading(database, waves, table)
    weights = transfer.heading_weights(unique_headings(pairs), waves.heading)
    if weights is None:
        raise InputError(_missing_heading_text(database, waves.heading))
    used = np.any(weights != 0.0, axis=0)
    return weights[:, used].T, blocks[used][:, used]


def _each_heading(
    database: QuadraticFunctions, waves: WaveComponents, table: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """`_blocks_of_headings` with the headings of the sea as nodes; T between"
    " different headings is zero."""
    headings = sea_headings(database, waves.heading)
    pairs = pairs_of(database)
    rows = own_headings(pairs)
    weights = transfer.heading_weights(pairs[rows, 0], headings)
    if weights is None:
        raise InputError(_missing_heading_text(database, headings))
    shape = (headings.size, headings.size, *table.shape[1:])
    blocks = np.zeros(shape, dtype=complex)
    for k, row in enumerate(weights):
        blocks[k, k] = np.tensordot(row, table[rows], 1)
    return (transfer.angle_between(waves.heading, headings[:, None]) < _SAME).astype(float), blocks


def own_headings(pairs: np.ndarray) -> np.ndarray:
    """Indices of the ``pairs`` (np, 2) of a heading with itself."""
    return np.flatnonzero(transfer.angle_between(*pairs.T) < _SAME)


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
    number = np.argmin(transfer.angle_between(pairs[:, :, None], nodes), axis=-1)
    is_known = np.zeros((nodes.size, nodes.size), dtype=bool)
    blocks = np.zeros((*is_known.shape, *table.shape[1:]), dtype=complex)
    for (i, j), block in zip(number, table, strict=True):
        swapped = block.swapaxes(0, 1)
        blocks[j, i] = blocks[j, i] if is_known[j, i] else swapped.conj() if hermitian else swapped
        blocks[i, j] = block
        is_known[i, j] = is_known[j, i] = True
    return blocks if is_known.all() else None


def unique_headings(heading: np.ndarray) -> np.ndarray:
    """The different headings, ascending."""
    angle = np.sort(np.mod(np.ravel(heading), 2.0 * np.pi))
    different = transfer.angle_between(angle, np.roll(angle, 1)) >= _SAME
    return angle[different] if np.any(different) else angle[:1]


def _missing_heading_text(database: QuadraticFunctions, headings: np.ndarray) -> str:
    have = ", ".join(f"{h:.4g}" for h in np.degrees(unique_headings(pairs_of(database))))
    wanted = ", ".join(f"{h:.4g}" for h in np.degrees(unique_headings(headings))[:5])
    return (
        f"{database.source}: found QTFs for waves to {have} deg; expected headings around"
        f" {wanted} deg, at most 45 deg apart. Choose wave_forces.second_order: newman, other"
        " waves, or a database with these headings."
    )


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
    """Filters and core of the waves (nw,) of one sea. Raises InputError as `qtf_table` does."""
    table = qtf_table(database, name)
    hermitian = name == "qtf_difference"
    pairs = pairs_of(database)
    blocks = all_pairs(pairs, table, hermitian)
    headings = sea_headings(database, heading) if blocks is None else unique_headings(heading)
    splines = _splines_over_frequency(np.asarray(database.qtf_frequency), omega)
    nodes = unique_headings(pairs)
    if blocks is not None and _are_harmonics_fewer(nodes.size, headings.size):
        yield _form_of_harmonics(nodes, blocks, splines, heading, hermitian)
        return
    filters = [
        _make_filters(
            splines,
            transfer.angle_between(heading, to)
            == transfer.angle_between(heading[:, None], headings).min(axis=1),
        )
        for to in headings
    ]
    if blocks is not None:
        core = _pair_core(nodes, blocks, headings)
        yield _make_form(
            [filter_ for heading_filters in filters for filter_ in heading_filters], core, splines
        )
        return
    headings_of_pairs = own_headings(pairs)
    for to, heading_filters in zip(headings, filters, strict=True):
        yield _make_form(
            heading_filters,
            _own_core(pairs[headings_of_pairs, 0], table[headings_of_pairs], to),
            splines,
        )


class _Splines(NamedTuple):
    """B-splines of every wave, (nw, nq), and the matrix (nq, nq) that combines them to the cardinal
    splines."""

    basis: np.ndarray
    cardinal: np.ndarray


def _splines_over_frequency(w: np.ndarray, omega: np.ndarray) -> _Splines:
    from scipy.interpolate import BSpline, make_interp_spline  # slow to load

    spline = make_interp_spline(w, np.eye(w.size), k=min(3, w.size - 1))
    clipped = np.clip(omega, w[0], w[-1])
    basis = BSpline.design_matrix(clipped, spline.t, spline.k).toarray()
    return _Splines(basis, spline.c)


def _make_filters(
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


def _make_form(filters: list[QtfFilter], core: np.ndarray, splines: _Splines) -> TurnedQtf:
    """The form of a ``core`` (m, ns, ns, nq, nq, 6) between ns groups of waves and nq cardinal
    splines."""
    c = splines.cardinal
    by_basis = np.einsum("ax,by,mghxyj->mjgahb", c, c, core, optimize=True)
    m, n, groups, nq = by_basis.shape[:4]
    return TurnedQtf(filters, by_basis.reshape(m, n, groups * nq, groups * nq))


def _own_core(nodes: np.ndarray, table: np.ndarray, to: float) -> np.ndarray:
    """Harmonics of T (m, 1, 1, nq, nq, 6) of waves ``to`` one heading with each other."""
    yaw = _sample_angles(nodes, nodes.size // 2)
    weights = _heading_weights(nodes, to - yaw)
    values = np.tensordot(weights, table, 1)
    return _harmonics_of_values(_unless_noise(values, table))[:, None, None]


def _pair_core(nodes: np.ndarray, blocks: np.ndarray, to: np.ndarray) -> np.ndarray:
    """Harmonics of T (m, ns, ns, nq, nq, 6) between waves ``to`` these headings (ns,)."""
    yaw = _sample_angles(nodes, nodes.size)
    weights = _heading_weights(nodes, (to - yaw[:, None]).ravel()).reshape(yaw.size, to.size, -1)
    values = np.einsum("ygp,yhq,pqvwj->yghvwj", weights, weights, blocks, optimize=True)
    return _harmonics_of_values(_unless_noise(values, blocks))


def _form_of_harmonics(
    nodes: np.ndarray,
    blocks: np.ndarray,
    splines: _Splines,
    heading: np.ndarray,
    hermitian: bool,
) -> TurnedQtf:
    """The form of all harmonics of the heading, for a sea of many headings."""
    to = _sample_angles(nodes, nodes.size // 2)
    weights = _heading_weights(nodes, to)
    values = np.einsum("gp,hq,pqvwj->ghvwj", weights, weights, blocks, optimize=True)
    core = np.fft.fft(_unless_noise(values, blocks), axis=0) / to.size
    # the harmonics of a conjugate second wave are conjugate, too
    back = np.fft.ifft if hermitian else np.fft.fft
    core = back(core, axis=1) * (1.0 if hermitian else 1.0 / to.size)
    order = np.rint(np.fft.fftfreq(to.size, 1.0 / to.size)).astype(int)
    every = np.ones(heading.size, dtype=bool)
    filters = [
        filter_
        for harmonic in order
        for filter_ in _make_filters(splines, every, np.exp(1j * harmonic * heading), int(harmonic))
    ]
    return _make_form(filters, core[None], splines)


def _are_harmonics_fewer(nodes: int, headings: int) -> bool:
    """True if harmonics of the heading need fewer filters than the headings of the sea one by
    one."""
    return (2 * nodes + 1) * headings**2 > nodes**2 and headings > 1


def _sample_angles(nodes: np.ndarray, degree: int) -> np.ndarray:
    """Angles round the circle that determine a trigonometric polynomial of this degree."""
    count = (
        2 * degree + 1
        if transfer.are_evenly_spaced(nodes)
        else 2 * SAMPLES_PER_HEADING * degree + 1
    )
    return 2.0 * np.pi / count * np.arange(count)


def _heading_weights(nodes: np.ndarray, heading: np.ndarray) -> np.ndarray:
    weights = transfer.heading_weights(nodes, heading)
    assert weights is not None  # `has_qtf_around`
    return weights


def _unless_noise(values: np.ndarray, table: np.ndarray) -> np.ndarray:
    """``values`` (..., 6), set to zero in the DOFs where they are noise of the ``table``."""
    return np.asarray(values * is_above_noise(values, table))


def _harmonics_of_values(values: np.ndarray) -> np.ndarray:
    """Coefficients C_m of sum C_m exp(-i m psi), from the lowest on, for values (M, ...) evenly
    round the circle, M odd. Negligible outer ones are left out."""
    harmonics = np.fft.fftshift(np.fft.ifft(values, axis=0), axes=0)
    size = np.abs(harmonics).reshape(len(harmonics), -1).max(axis=1)
    middle = len(harmonics) // 2
    counts = np.maximum(size, size[::-1])[middle:] > NEGLIGIBLE * size.max()
    most = int(np.flatnonzero(counts)[-1]) if counts.any() else 0
    return np.asarray(harmonics[middle - most : middle + most + 1])
