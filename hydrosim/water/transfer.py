"""Transfer functions of a database in a sea: splines, headings, envelopes of drifting bodies.

In frequency, cubic splines interpolate real and imaginary parts, exactly at the nodes. With nodes
0.02 rad/s apart, the error on a 260 m barge is below 0.02 % of the largest load up to 1 rad/s.

In heading, trigonometric polynomials are used if the headings are evenly spaced round the circle,
else cubic splines; both are exact at the nodes. The load of a hull of length L has harmonics of the
heading up to about k L / 2. N headings lose the harmonics above N / 2.

On a 260 m barge with headings 15 deg apart, the error halfway between two is 0.2 % of the largest
load of that frequency at 0.8 rad/s (waves of 96 m). It is 2 % at 0.9 rad/s and more above. With
headings 7.5 deg apart it is 0.2 % at 1.2 rad/s. Modulus and phase would be less accurate: between
two headings the modulus of a long hull's load passes through zero, and the phase jumps.

Envelopes of `bands` along the path of a body that drifts, from few frequencies in place of the
waves.

    E_f(t) = sum_i H_f(w_i) a_i exp(i (w_i t - k_i . d))
           = sum_p H_f(w_p) A_p exp(i (w_p s - k_p . e)),    s = t - t_a,    e = d - d_a
    A_p = sum_i L_p(w_i) a_i exp(i (w_i t_a - k_i . d_a))

Between two frequencies of a database, H_f and the exponential of s and e are smooth functions of
the frequency. So their polynomial through few nodes w_p stands for them; L_p are its Lagrange
weights. The nodes are those of Chebyshev, so that the error of a wave is at most

    x^(P - 3) / ((P - 3)! 2^(P + 1)),    x = (w - w_c) (s + e / c_g)

for P nodes about w_c: the cubic H_f has a leading coefficient of 1/4 there. P keeps this below the
error that is asked for between rows, at the largest x. The A_p are made anew if the body or time
leaves a cell of a lattice about the anchor (t_a, d_a). The anchor follows from the block alone, so
the loads depend on time and state alone, however far the body drifts.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from math import cos, factorial, floor, sin, sqrt
from typing import NamedTuple, Protocol

import numpy as np
from scipy.linalg import solve_banded

from hydrosim.errors import InputError
from hydrosim.jit.kernels import clear, kernel, root, summing
from hydrosim.water.loads import STENCIL_POINTS

ANCHOR_S = 8.0  # shortest time for which amplitudes at nodes are used
SPEED_RATIO = 3.0  # largest drift speed over the group velocity of the shortest wave
MAX_NODES = 24  # nodes of a cell
NARROWEST = 1e-3  # of the widest cell
SAMPLING_ERROR = 0.0235  # of interpolation by 6 even points: max |x (x - 1) ... (x - 5)| / 6!


class NodeSpan(NamedTuple):
    """Over what amplitudes at nodes are used: ``period`` [s] and ``distance`` [m] between anchors,
    and the time ``reach`` [s] from the middle of a block to its outermost rows."""

    period: float
    distance: float
    reach: float


class NodeSet(NamedTuple):
    """Nodes of the waves of one sea on a body. Cell c has the waves begin[c] to end[c] of the body,
    (nc,), and the nodes from c P on. ``weight`` (nw, P); frequencies ``omega`` and wavenumbers
    along the earth's x and y, (nc P,). A share (m,) is the ``factor`` of a ``node`` in a ``band``;
    shares of a node are adjacent."""

    begin: np.ndarray
    end: np.ndarray
    weight: np.ndarray
    omega: np.ndarray
    kx: np.ndarray
    ky: np.ndarray
    node: np.ndarray
    band: np.ndarray
    factor: np.ndarray


class FrequencyNodes(NamedTuple):
    """The nodes of all bodies that drift, body by body; as in `NodeSet`.

    ``cells``, ``nodes``, ``shares`` (nb + 1,) give the first ones of each body, and ``table`` (nb,)
    the first of its weights. ``per_cell`` (nb,): nodes. Of a share, ``at`` is the index of
    the real part of its first sample, see `fill_envelopes`, and ``size`` the number of bands in its
    set.
    """

    cells: np.ndarray
    nodes: np.ndarray
    shares: np.ndarray
    table: np.ndarray
    per_cell: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    weight: np.ndarray
    omega: np.ndarray
    kx: np.ndarray
    ky: np.ndarray
    node: np.ndarray
    at: np.ndarray
    size: np.ndarray
    factor: np.ndarray
    period: float
    distance: float


def span_of(omega: np.ndarray, wavenumber: np.ndarray, block: float, step: float) -> NodeSpan:
    """The span for waves (nw,) and rows ``step`` apart in a ``block`` [s]."""
    period = max(ANCHOR_S, block)
    slowest = float(np.min(omega / (2.0 * wavenumber), initial=np.inf))  # group velocity
    return NodeSpan(period, slowest * period / sqrt(2.0), block / 2.0 + STENCIL_POINTS / 2.0 * step)


def count_nodes(width: float, span: NodeSpan, missed: float) -> int:
    """Nodes per cell of up to this ``width`` [rad/s] for an error of ``missed``; more than
    `MAX_NODES` if it needs too many, or envelopes change too fast for `STENCIL_POINTS` samples per
    block."""
    apart = 2.0 * span.reach / (STENCIL_POINTS - 1)
    if SAMPLING_ERROR * (width * apart) ** STENCIL_POINTS > missed:
        return MAX_NODES + 1
    x = width / 2.0 * (span.period + (1.0 + SPEED_RATIO) * span.reach)
    for count in range(4, MAX_NODES + 1):
        if x ** (count - 3) <= missed * factorial(count - 3) * 2.0 ** (count + 1):
            return count
    return MAX_NODES + 1


def lagrange_weights(nodes: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """Weights (nw, P) at ``omega`` (nw,) of values at the ``nodes`` (nw, P) of each."""
    weight = np.ones(nodes.shape)
    for i in range(nodes.shape[1]):
        for j in range(nodes.shape[1]):
            if j != i:
                weight[:, i] *= (omega - nodes[:, j]) / (nodes[:, i] - nodes[:, j])
    return weight


def nodes_model(bodies: Sequence[Sequence[NodeSet]], spans: Sequence[NodeSpan]) -> FrequencyNodes:
    """The nodes of all bodies as arrays; a body that is not summed by nodes has no sets."""
    sets = [node_set for body_sets in bodies for node_set in body_sets]
    at = [_share_layout(body_sets) for body_sets in bodies]

    def join_arrays(arrays: Sequence[np.ndarray], kind: type = float) -> np.ndarray:
        return np.concatenate([np.zeros(0, kind), *(array.ravel() for array in arrays)])

    def firsts(name: str) -> np.ndarray:
        sizes = (
            sum(getattr(node_set, name).size for node_set in body_sets) for body_sets in bodies
        )
        return np.cumsum([0, *sizes])

    index = np.int64
    return FrequencyNodes(
        cells=firsts("begin"),
        nodes=firsts("omega"),
        shares=firsts("node"),
        table=firsts("weight")[:-1],
        per_cell=np.array(
            [body_sets[0].weight.shape[1] if body_sets else 0 for body_sets in bodies], dtype=index
        ),
        begin=join_arrays([node_set.begin for node_set in sets], index),
        end=join_arrays([node_set.end for node_set in sets], index),
        weight=join_arrays([node_set.weight for node_set in sets]),
        omega=join_arrays([node_set.omega for node_set in sets]),
        kx=join_arrays([node_set.kx for node_set in sets]),
        ky=join_arrays([node_set.ky for node_set in sets]),
        node=join_arrays([node for node, _, _ in at], index),
        at=join_arrays([place for _, place, _ in at], index),
        size=join_arrays([size for _, _, size in at], index),
        factor=join_arrays([node_set.factor for node_set in sets]),
        period=min((span.period for span in spans), default=1.0),
        distance=min((span.distance for span in spans), default=1.0),
    )


def _share_layout(sets: Sequence[NodeSet]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of all shares of a body: its node, where its first sample is, and the bands of its set."""
    places = [np.zeros((3, 0), np.int64)]
    nodes = 0
    bands = 0
    for node_set in sets:
        size = int(node_set.band.max()) + 1
        at = 2 * STENCIL_POINTS * bands + node_set.band
        places.append(np.stack([nodes + node_set.node, at, np.full(node_set.node.size, size)]))
        nodes += node_set.omega.size
        bands += size
    node, at, size = np.concatenate(places, axis=1)
    return node, at, size


class NodeSums(NamedTuple):
    """Scratch: the ``anchor`` (nb, 3), t_a and d_a over the lattice's spacings, at which the
    ``amplitude`` (2, nn) of all nodes was made. Samples of a node, (2, `STENCIL_POINTS`)."""

    anchor: np.ndarray
    amplitude: np.ndarray
    sample: np.ndarray


def new_node_sums(p: FrequencyNodes) -> NodeSums:
    """Scratch for these nodes, without any known amplitude."""
    return NodeSums(
        np.full((p.per_cell.size, 3), np.nan),
        np.zeros((2, p.omega.size)),
        np.zeros((2, STENCIL_POINTS)),
    )


@kernel
def has_nodes(k, p):
    """True if the waves on the k-th body are gathered at nodes."""
    return p.per_cell[k] > 0


@root
def gather_waves(k, t, x, y, p, work):
    """Amplitudes at the nodes of the k-th body for the anchor next to the time t and the
    displacement x, y, if they are not known."""
    nodes = p.gathered
    anchor = work.anchor[k]
    at = floor(t / nodes.period) + 0.5
    along_x = floor(x / nodes.distance + 0.5)
    along_y = floor(y / nodes.distance + 0.5)
    if at == anchor[0] and along_x == anchor[1] and along_y == anchor[2]:
        return
    anchor[0] = at
    anchor[1] = along_x
    anchor[2] = along_y
    clear(work.amplitude[0, nodes.nodes[k] : nodes.nodes[k + 1]])
    clear(work.amplitude[1, nodes.nodes[k] : nodes.nodes[k + 1]])
    count = nodes.per_cell[k]
    for c in range(nodes.cells[k], nodes.cells[k + 1]):
        first = nodes.nodes[k] + count * (c - nodes.cells[k])
        re = work.amplitude[0, first : first + count]
        im = work.amplitude[1, first : first + count]
        wave = p.offset[k] + nodes.begin[c]
        kx = nodes.distance * along_x * cos(p.heading[wave])
        ky = nodes.distance * along_y * sin(p.heading[wave])
        for i in range(nodes.begin[c], nodes.end[c]):
            n = p.offset[k] + i
            angle = p.omega[n] * at * nodes.period - p.wavenumber[n] * (kx + ky)
            a = p.second.wave[n] * (cos(angle) + 1j * sin(angle))
            weight = nodes.weight[nodes.table[k] + i * count : nodes.table[k] + (i + 1) * count]
            _add_to_nodes(a.real, a.imag, weight, re, im)


@summing
def _add_to_nodes(a, b, weight, re, im):
    for m in range(weight.size):
        re[m] += weight[m] * a
        im[m] += weight[m] * b


@root
def fill_envelopes(k, t, apart, path, p, work, out):
    """Samples of E_f of all bands of the k-th body at `STENCIL_POINTS` times ``apart``, from t on.
    ``path``: displacement x, y at t and velocity. ``out`` has, for every set, (STENCIL_POINTS, 2,
    bands), real and imaginary parts."""
    nodes = p.gathered
    anchor = work.anchor[k]
    since = t - anchor[0] * nodes.period
    x = path[0] - anchor[1] * nodes.distance
    y = path[1] - anchor[2] * nodes.distance
    last = -1
    for m in range(nodes.shares[k], nodes.shares[k + 1]):
        n = nodes.nodes[k] + nodes.node[m]
        if n != last:
            last = n
            angle = nodes.omega[n] * since - nodes.kx[n] * x - nodes.ky[n] * y
            turn = apart * (nodes.omega[n] - nodes.kx[n] * path[2] - nodes.ky[n] * path[3])
            z = (work.amplitude[0, n] + 1j * work.amplitude[1, n]) * (cos(angle) + 1j * sin(angle))
            _find_samples(z, cos(turn) + 1j * sin(turn), work.sample)
        factor = nodes.factor[m]
        size = nodes.size[m]
        at = nodes.at[m]
        for s in range(STENCIL_POINTS):
            out[at + 2 * size * s] += factor * work.sample[0, s]
            out[at + 2 * size * s + size] += factor * work.sample[1, s]


@kernel
def _find_samples(z, turn, sample):
    """z times powers of ``turn``, into ``sample`` (2, n)."""
    for s in range(sample.shape[1]):
        sample[0, s] = z.real
        sample[1, s] = z.imag
        z *= turn


# Cubic spline, not-a-knot at its ends (de Boor 1978, chapter 4): equal to scipy's, quick to load.


def interpolate_spline(x: np.ndarray, y: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The spline through ``y`` (n, ...), real or complex, at rising ``x`` (n,), n 2 or more.
    Returns its values (m, ...) ``at`` (m,) places between the first x and the last."""
    values = y.reshape(len(x), -1)
    if len(x) < 4:  # one polynomial
        values_there = np.vander(at, len(x)) @ np.linalg.solve(np.vander(x), values)
        return values_there.reshape(at.shape + y.shape[1:])
    h, slope = np.diff(x), slopes(x, values)
    i = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)
    u = ((at - x[i]) / h[i])[:, None]
    v, width = 1.0 - u, h[i, None]
    ends = v * v * (1.0 + 2.0 * u) * values[i] + u * u * (1.0 + 2.0 * v) * values[i + 1]
    values_there = ends + width * u * v * (v * slope[i] - u * slope[i + 1])
    return values_there.reshape(at.shape + y.shape[1:])


def slopes(x: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Derivatives (n, ...) at x (n,) of the spline through ``values`` (n, ...), n 4 or more."""
    y, h = values.reshape(len(x), -1), np.diff(x)
    rise, d = np.diff(y, axis=0) / h[:, None], x[2:] - x[:-2]
    bands, right = np.zeros((3, x.size)), np.empty_like(y, dtype=np.result_type(y, 1.0))
    bands[0, 2:], bands[1, 1:-1], bands[2, :-2] = h[:-1], 2.0 * d, h[1:]
    right[1:-1] = 3.0 * (h[1:, None] * rise[:-1] + h[:-1, None] * rise[1:])
    bands[1, 0], bands[0, 1] = h[1], d[0]
    right[0] = ((h[0] + 2.0 * d[0]) * h[1] * rise[0] + h[0] ** 2 * rise[1]) / d[0]
    bands[1, -1], bands[2, -2] = h[-2], d[-1]
    right[-1] = (h[-1] ** 2 * rise[-2] + (2.0 * d[-1] + h[-1]) * h[-2] * rise[-1]) / d[-1]
    return np.asarray(solve_banded((1, 1), bands, right)).reshape(values.shape)


_TURN = 2.0 * np.pi
_WIDEST_GAP = np.radians(45.0) + 1e-6  # [rad] largest gap between two headings for interpolation
_NODE = 1e-9  # [rad] angles this close to a heading of the database are that heading
_END = 1.0 + 1e-9  # includes, despite rounding, a regular wave at the highest frequency
_FEWEST = 12  # headings round the circle of a table
_KEPT = 8  # weights of headings
_TABLES = 4  # of tens of megabytes each
NOISE = 1e-12
"""Of the largest force or moment: below it a transfer function is zero."""


class TransferFunctions(Protocol):
    """Data that this module reads of a database: loads per wave amplitude, for exp(+i w t).

    ``source`` names it in messages. ``frequency`` (nw,) [rad/s] ascends; ``heading`` (nh,) [rad]
    are distinct directions, mirror images included. ``excitation`` (nw, nh, n) is complex, forces
    [N/m] and moments [N m/m] alternate in threes; ``mean_drift`` (nw, nh, n) [N/m^2, N m/m^2].
    """

    def __hash__(self) -> int: ...
    @property
    def source(self) -> str: ...
    @property
    def frequency(self) -> np.ndarray: ...
    @property
    def heading(self) -> np.ndarray: ...
    @property
    def excitation(self) -> np.ndarray: ...
    @property
    def mean_drift(self) -> np.ndarray | None: ...


def excitation_at(
    database: TransferFunctions, heading: np.ndarray, omega: np.ndarray
) -> np.ndarray:
    """First-order transfer functions (nc, n) of waves of ``omega`` and ``heading`` (nc,).

    Zero above the highest frequency of the database; the first value below its lowest frequency.
    Raises InputError if a wave heading lies outside the headings of the database. The result is
    cached, because seas of several seeds and equal bodies ask for the same. Do not write to it.
    """
    to, of = (np.asarray(coordinates, float).tobytes() for coordinates in (heading, omega))
    return _excitation_at(_content_of(database, _excitation_of), to, of)


class _Content:
    """``values`` (nw, nh, n) of a ``database`` at its frequencies and headings. Two of them are
    equal if their numbers are equal, so that databases of equal hulls share derived tables."""

    def __init__(self, database: TransferFunctions, values: np.ndarray) -> None:
        self.database = database
        self.values = values
        arrays = (database.frequency, database.heading, values)
        self._bytes = tuple(array.tobytes() for array in arrays)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Content) and self._bytes == other._bytes

    def __hash__(self) -> int:
        return hash(self._bytes)


def _content_of(
    database: TransferFunctions, of: Callable[[TransferFunctions], np.ndarray]
) -> _Content:
    return _Content(database, of(database))


@lru_cache(maxsize=_KEPT)
def _excitation_at(content: _Content, of_heading: bytes, of_omega: bytes) -> np.ndarray:
    database = content.database
    heading, omega = np.frombuffer(of_heading), np.frombuffer(of_omega)
    inside = omega <= database.frequency[-1] * _END
    loads = np.where(
        inside[:, None], _interpolate_transfer(database, content.values, heading, omega), 0.0
    )
    loads.setflags(write=False)
    return loads


def transfer_table(database: TransferFunctions, between: int) -> tuple[np.ndarray, np.ndarray]:
    """First-order transfer functions and their slopes (nf, nodes, 2, n) at frequencies (nf,), four
    or more. The nodes of heading are evenly spaced round the circle from 0, ``between`` per heading
    of the database. The result is one cached array for equal bodies and runs of one study. Do not
    write to it.

    Raises InputError if its headings are not all round the circle.
    """
    return _table(_content_of(database, _excitation_of), between)


def drift_table(database: TransferFunctions, between: int) -> tuple[np.ndarray, np.ndarray]:
    """`transfer_table` for mean drift of waves that are not below its frequencies, see
    `drift_above`."""
    return _table(_content_of(database, _drift_of), between)


@lru_cache(maxsize=_TABLES)
def _table(content: _Content, between: int) -> tuple[np.ndarray, np.ndarray]:
    database = content.database
    nodes = between * max(database.heading.size, _FEWEST)
    weights = heading_weights(database.heading, _TURN / nodes * np.arange(nodes))
    if weights is None:
        raise InputError(
            f"{database.source}: waves that follow a body (wave_forces.headings, position) need"
            " headings all round the circle, at most 45 deg apart; choose mean, or compute"
            " more headings."
        )
    w, values = _four_frequencies(database.frequency, content.values)
    table = weights @ values
    slope = weights @ slopes(w, values)  # in this order: a database has far fewer headings
    loaded = np.abs(table) > NOISE * _largest_values(content.values)
    table = np.where(loaded, table, 0.0)
    slope = np.where(loaded.any(axis=0), slope, 0.0)
    rows = np.stack([table, slope], axis=2)
    rows.setflags(write=False)
    return w, rows


def _four_frequencies(w: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies and ``values`` (nf, ...), interpolated where there are fewer than four."""
    if w.size >= 4:
        return w, values
    more = np.linspace(w[0], w[-1], 4)
    return more, interpolate_spline(w, values, more)


def _largest_values(values: np.ndarray) -> np.ndarray:
    """The largest force or moment among ``values`` (nw, nh, n), for each of the n."""
    return np.repeat(np.abs(values).max(axis=(0, 1)).reshape(-1, 3).max(axis=1), 3)


def has_headings_around(database: TransferFunctions) -> bool:
    """True if any heading has headings of the database around it."""
    every = np.radians(np.arange(0.0, 360.0, 5.0))
    return database.heading.size > 0 and heading_weights(database.heading, every) is not None


def mean_drift_at(
    database: TransferFunctions, heading: np.ndarray, omega: np.ndarray
) -> np.ndarray:
    """Mean drift transfer functions (nc, n) of waves of ``omega`` and ``heading`` (nc,).

    Above the highest frequency of the database the last value is used, because all short waves are
    reflected alike. Below the lowest frequency it falls linearly to zero at zero frequency. Raises
    InputError if the database has no mean drift, or a wave heading lies outside its headings.
    """
    fade = drift_above(database, omega)
    return _interpolate_transfer(database, _drift_of(database), heading, omega) * fade[:, None]


def drift_above(database: TransferFunctions, omega: np.ndarray) -> np.ndarray:
    """Factors (nc,) of mean drift, less than 1 below the lowest frequency of the database."""
    low = database.frequency[0]
    return np.asarray(np.where(omega < low, omega / (low or 1.0), 1.0))


def _excitation_of(database: TransferFunctions) -> np.ndarray:
    return database.excitation


def _drift_of(database: TransferFunctions) -> np.ndarray:
    if database.mean_drift is None:
        raise InputError(
            f"{database.source}: found no mean drift; expected it for second-order wave forces. Set"
            " wave_forces.second_order of the body to none, to qtf if the database has QTFs, or use"
            " a database with mean drift: `hydrosim db build` computes it if the recipe says"
            " `drift: [free]`."
        )
    return database.mean_drift


def angle_between(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Angle between two directions [rad]."""
    return np.abs(np.mod(first - second + np.pi, _TURN) - np.pi)


def heading_weights(nodes: np.ndarray, heading: np.ndarray) -> np.ndarray | None:
    """Weights (nc, nh) of values at the ``nodes`` (nh,) for values at ``heading`` (nc,) [rad].

    None if a heading is between two nodes that are more than 45 degrees apart. The result is
    cached, because runs of one study ask for the same. Do not write to it.
    """
    return _interpolation_weights(
        np.asarray(nodes, float).tobytes(), np.asarray(heading, float).tobytes()
    )


@lru_cache(maxsize=_KEPT)
def _interpolation_weights(of_nodes: bytes, of_heading: bytes) -> np.ndarray | None:
    nodes, heading = np.frombuffer(of_nodes), np.frombuffer(of_heading)
    order, angle = _round_the_circle(nodes)
    x = np.mod(heading - nodes[order[0]], _TURN)
    from_node = angle_between(x[:, None], angle)
    gap = np.diff(angle, append=_TURN)
    between = gap[np.searchsorted(angle, x, side="right") - 1] > _WIDEST_GAP
    if np.any(between & (from_node.min(axis=1) >= _NODE)):
        return None
    weights = np.empty((heading.size, nodes.size))
    weights[:, order] = np.where(
        from_node.min(axis=1, keepdims=True) < _NODE,
        np.eye(nodes.size)[from_node.argmin(axis=1)],
        _weights_between_nodes(x, angle, gap),
    )
    weights.setflags(write=False)
    return weights


def _interpolate_transfer(
    database: TransferFunctions, values: np.ndarray, heading: np.ndarray, omega: np.ndarray
) -> np.ndarray:
    """``values`` (nw, nh, n) at frequencies and headings (nc,): (nc, n); noise becomes zero."""
    inside = np.clip(omega, *database.frequency[[0, -1]])
    headings, which = np.unique(heading, return_inverse=True)
    weights = heading_weights(database.heading, headings)
    if weights is None:
        raise InputError(_missing_headings_text(database, headings))
    if headings.size == 1:  # four times faster than the other way round
        values_there = interpolate_spline(
            database.frequency, np.tensordot(weights[0], values, (0, 1)), inside
        )
    else:
        at_nodes = interpolate_spline(database.frequency, values, inside)
        values_there = np.einsum("ch,chj->cj", weights[which], at_nodes)
    loaded = np.abs(values_there).max(axis=0, initial=0.0) > NOISE * _largest_values(values)
    return np.where(loaded, values_there, 0.0)


def _weights_between_nodes(x: np.ndarray, angle: np.ndarray, gap: np.ndarray) -> np.ndarray:
    """Weights (nc, nh) at x (nc,) of values at ascending ``angle`` (nh,) in one turn."""
    if _is_even(gap):
        return _trigonometric_weights(x[:, None] - angle)
    if angle.size == 1:
        return np.ones((x.size, 1))
    from scipy.interpolate import CubicSpline  # slow to load, and few databases are uneven

    if gap[-1] > _WIDEST_GAP:
        return np.asarray(CubicSpline(angle, np.eye(angle.size))(x))
    nodes = np.vstack([np.eye(angle.size), np.eye(angle.size)[:1]])
    return np.asarray(CubicSpline(np.append(angle, _TURN), nodes, bc_type="periodic")(x))


def are_evenly_spaced(nodes: np.ndarray) -> bool:
    """True if headings are evenly spaced round the circle. Values between them then follow from a
    trigonometric polynomial."""
    _, angle = _round_the_circle(nodes)
    return _is_even(np.diff(angle, append=_TURN))


def _is_even(gap: np.ndarray) -> bool:
    return bool(gap.size > 2 and np.ptp(gap) < _NODE)


def _trigonometric_weights(x: np.ndarray) -> np.ndarray:
    """The trigonometric polynomial that is one at x = 0 and zero at the other multiples of
    2 pi / n, for x (nc, n)."""
    n = x.shape[1]
    half = 0.5 * np.where(np.abs(np.sin(0.5 * x)) < 1e-12, 1.0, x)
    ratio = np.sin(n * half) / (n * (np.tan(half) if n % 2 == 0 else np.sin(half)))
    return np.where(np.abs(np.sin(0.5 * x)) < 1e-12, 1.0, ratio)


def _round_the_circle(headings: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Order (nh,) of the headings from the one after the widest gap, and their angles from that
    one."""
    order = np.argsort(np.mod(headings, _TURN))
    angle = np.mod(headings[order], _TURN)
    start = int(np.argmax(np.diff(angle, prepend=angle[-1] - _TURN)))
    order = np.roll(order, -start)
    return order, np.mod(headings[order] - headings[order[0]], _TURN)


def _missing_headings_text(database: TransferFunctions, headings: np.ndarray) -> str:
    low, high = np.degrees([database.heading.min(), database.heading.max()])
    missed = [h for h in headings if heading_weights(database.heading, np.array([h])) is None]
    return (
        f"{database.source}: wave heading {np.degrees(missed[0]):g} deg is not covered, the"
        f" headings are {low:g} to {high:g} deg. Change environment.waves.heading, or compute the"
        f" database for headings around it, at most {np.degrees(_WIDEST_GAP):.0f} deg apart."
    )
