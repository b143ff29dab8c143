"""Envelopes of `bands` along the path of a body that drifts, from few frequencies in place of the
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

from collections.abc import Sequence
from math import cos, factorial, floor, sin, sqrt
from typing import NamedTuple

import numpy as np

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
    at = [_share_places(body_sets) for body_sets in bodies]

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


def _share_places(sets: Sequence[NodeSet]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
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
