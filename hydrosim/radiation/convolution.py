"""The memory force as the integral itself, F(t) = -int_0^t K(t - s) v(s) ds (Cummins 1962).

K is linear between the entries of its table; v is the cubic through the velocities and
accelerations of two nodes, and the parabola from the last node to the velocity at t: a stage of a
step, which need not be the state that is accepted there. Their product is integrated exactly. The
error is of order 4 in the spacing of the nodes, which has nothing to do with that of the table.

At the stages of steps of one length the weights of the nodes are known beforehand. Then the
integral over the past is a sum of products along the memory, corrected where nodes at events lie
between those of the grid. It depends on the nodes and the time alone, so the stages at one time
share it: it is kept in `Memo`.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import clear, kernel, root
from hydrosim.radiation.dots import dot
from hydrosim.radiation.history import EVEN, VelocityHistory, node_before, oldest_node
from hydrosim.radiation.history import velocity_history as new_history
from hydrosim.radiation.state_space import coupled_groups

# Gauss and Legendre's rule of three points on [0, 1]: exact for degree 5, where 4 is asked for.
POINTS = (0.5 - 0.1**0.5 * 1.5**0.5, 0.5, 0.5 + 0.1**0.5 * 1.5**0.5)
WEIGHTS = (5 / 18, 8 / 18, 5 / 18)


class ConvolutionKernel(NamedTuple):
    """Retardation functions on a uniform grid of lags, only the entries that are not zero.

    ``K[k, e]`` is the force on DOF ``row[e]`` per velocity of DOF ``column[e]`` at lag k * step;
    columns ascend. ``weight[i, 0, e, k]`` is the integral's part of a unit velocity, and
    ``weight[i, 1, e, k]`` that of a unit acceleration, in the k-th node before the time which is
    ``offset[i]`` steps of `EvenNodes` after the newest one.
    """

    step: float  # [s]
    K: np.ndarray  # (lags, entries)
    row: np.ndarray  # (entries,) int64
    column: np.ndarray  # (entries,) int64
    offset: np.ndarray  # (offsets,)
    weight: np.ndarray  # (offsets, 2, entries, nodes)
    even_step: float  # [s], 0 without offsets


def convolution_model(
    step: float, retardation: np.ndarray, even_step: float = 0.0, stages: Sequence[float] = ()
) -> ConvolutionKernel:
    """Table for the direct convolution from K (nt, n, n) at the lags 0, step, 2 step, ...

    n are all DOFs of the scene, six per body. The entries kept are those that a state-space model
    fits too, see `coupled_groups`; K = 0 throughout gives an empty table, which costs nothing.
    The integral is fast at ``stages``, fractions of steps of length ``even_step`` [s].
    """
    kept = np.zeros(retardation.shape[1:], dtype=bool)
    for dofs in coupled_groups(retardation):
        kept[dofs[:, None], dofs] = True
    column, row = np.nonzero(kept.T)
    K = np.ascontiguousarray(retardation[:, row, column], dtype=np.float64)
    fast = row.size > 0 and even_step > 0.0
    offset = np.unique([c for c in stages if c > 0.0] + [1.0]) if fast else np.empty(0)
    nodes = ceil((len(K) - 1) * step / even_step - EVEN) + 1 if fast else 0
    weight = np.zeros((offset.size, 2, row.size, nodes))
    for i, c in enumerate(offset):
        weight[i] = _weights(step, K, even_step, c, nodes)
    return ConvolutionKernel(
        step=float(step),
        K=K,
        row=row.astype(np.int64),
        column=column.astype(np.int64),
        offset=offset,
        weight=weight,
        even_step=even_step if fast else 0.0,
    )


def _weights(step: float, K: np.ndarray, even: float, offset: float, nodes: int) -> np.ndarray:
    """Integrals of K (lags, entries) times the cubics of all nodes: (2, entries, nodes)."""
    length = (len(K) - 1) * step
    newest = offset * even
    edges = np.concatenate([newest + even * np.arange(nodes), step * np.arange(len(K))])
    edges = np.unique(edges[(edges >= newest) & (edges <= length)])
    width, middle = np.diff(edges), 0.5 * (edges[1:] + edges[:-1])
    cell = np.minimum((middle / step).astype(int), len(K) - 2)
    node = np.minimum(((middle - newest) / even).astype(int), nodes - 2)
    result = np.zeros((2, nodes, K.shape[1]))
    for point, weight in zip(POINTS, WEIGHTS, strict=True):
        lag = edges[:-1] + point * width
        part = (lag / step - cell)[:, None]
        force = (weight * width)[:, None] * ((1.0 - part) * K[cell] + part * K[cell + 1])
        basis = _cubic(node + 1 - (lag - newest) / even, even)
        for older, (v, a) in ((1, basis[:2]), (0, basis[2:])):
            np.add.at(result[0], node + older, v[:, None] * force)
            np.add.at(result[1], node + older, a[:, None] * force)
    return np.ascontiguousarray(result.transpose(0, 2, 1))


def history_for(kernel: ConvolutionKernel, dofs: int, capacity: int) -> VelocityHistory:
    """An empty history of ``dofs`` velocities with room for ``capacity`` nodes and for what the
    kernel's fast sums need; of none for an empty kernel."""
    if kernel.row.size == 0:
        return new_history(dofs, 0)
    places = kernel.offset.size + 1
    return new_history(dofs, capacity, kernel.even_step, kernel.weight.shape[-1], places)


@root
def radiation_memory(t, v, history, p, force):
    """Subtract int K(t - s) v(s) ds from ``force``, for the velocities of the nodes and ``v`` at t.

    The integral runs from the first node (v = 0 before it) or from the end of the table of K to
    the current point, which may be a stage between steps; nodes from t on are ignored. A ring too
    small for the memory cuts it off at its oldest node: see `velocity_history`.

    v, force: all DOFs of the scene; history: `VelocityHistory`; p: `ConvolutionKernel`.
    """
    if p.row.size == 0:
        return
    node = node_before(t, history)
    if node < oldest_node(history):
        return
    past = history.memo.past[_past(t, node, history, p)]
    for i in range(force.size):
        force[i] -= past[i]
    last = node % history.time.size
    u, a, slope = history.velocity[last], history.acceleration[last], history.memo.slope
    h = t - history.time[last]
    for j in range(v.size):
        slope[j] = 2.0 * (v[j] - u[j]) / h - a[j]
    _add_piece(-1.0, h, 0.0, u, a, v, slope, p, force)


@kernel
def _past(t, node, history, p):
    """Place in the memo of the integral up to ``node`` as felt at ``t``."""
    memo, even = history.memo, history.even
    shift = _shift(node, even)
    offset = -1
    if shift >= 0:
        offset = _offset((t - history.time[node % history.time.size]) / even.step, p)
    place = offset if offset >= 0 else memo.node.size - 1
    past = memo.past[place]
    if memo.node[place] == node and (offset >= 0 or memo.time[place] == t):
        return place
    memo.node[place], memo.time[place] = node, t
    clear(past)
    if offset >= 0:
        t = history.time[node % history.time.size] + p.offset[offset] * even.step
        node = _add_even_nodes(offset, shift, t, history, p, past)
    _add_pieces(t, node, oldest_node(history), history, p, past)
    return place


@kernel
def _shift(node, even):
    """Where ``node`` is among the even nodes, counted from the newest: 0 or 1, or -1 if not."""
    first, count = even.place[0], even.place[1]
    for shift in range(min(count, 2)):
        if even.node[first + shift] == node:
            return shift
    return -1


@kernel
def _offset(steps, p):
    for i in range(p.offset.size):
        if abs(steps - p.offset[i]) < EVEN:
            return i
    return -1


@kernel
def _add_even_nodes(offset, shift, t, history, p, total):
    """Add the integral over the even nodes from the one at ``shift`` on, and the nodes between
    them; returns the oldest of them."""
    even, nodes = history.even, p.weight.shape[3]
    first, count = even.place[0] + shift, min(even.place[1] - shift, nodes)
    while even.node[first + count - 1] < oldest_node(history):
        count -= 1
    for e in range(p.row.size):
        j = p.column[e]
        v, a = even.motion[0, j, first : first + count], even.motion[1, j, first : first + count]
        total[p.row[e]] += dot(p.weight[offset, 0, e, :count], v)
        total[p.row[e]] += dot(p.weight[offset, 1, e, :count], a)
    capacity = history.time.size
    for k in range(count - 1):
        newer, older = even.node[first + k], even.node[first + k + 1]
        if newer - older > 1:
            _add_interval(-1.0, t, older % capacity, newer % capacity, history, p, total)
            _add_pieces(t, newer, older, history, p, total)
    oldest = even.node[first + count - 1]
    if count < nodes:  # its weight has a part for an interval that is not there
        at, nothing = oldest % capacity, history.memo.slope
        clear(nothing)
        lag = t - history.time[at]
        v, a = history.velocity[at], history.acceleration[at]
        _add_piece(-1.0, lag + even.step, lag, nothing, nothing, v, a, p, total)
    return oldest


@kernel
def _add_pieces(t, newer, older, history, p, total):
    """Add the integral between two nodes, or from where the table of K ends."""
    capacity, length = history.time.size, (p.K.shape[0] - 1) * p.step
    while newer > older and t - history.time[newer % capacity] < length:
        _add_interval(1.0, t, (newer - 1) % capacity, newer % capacity, history, p, total)
        newer -= 1


@kernel
def _add_interval(sign, t, older, newer, history, p, total):
    """Add ``sign`` times the integral over the cubic between two nodes at these indices."""
    time, velocity, acceleration = history.time, history.velocity, history.acceleration
    v0, a0, v1, a1 = velocity[older], acceleration[older], velocity[newer], acceleration[newer]
    _add_piece(sign, t - time[older], t - time[newer], v0, a0, v1, a1, p, total)


@kernel
def _add_piece(sign, older, newer, v0, a0, v1, a1, p, total):
    """Add ``sign`` int K v over the lags from ``newer`` to ``older``, cell by cell of K's table,
    with the cubic from (v0, a0) at the older lag to (v1, a1) at the newer."""
    cells, h = p.K.shape[0] - 1, older - newer
    lag, k = newer, int(newer / p.step)
    while k < cells and lag < older:
        end = min((k + 1) * p.step, older)
        if end > lag:
            _add_cell(sign, k, lag, end, older, h, v0, a0, v1, a1, p, total)
            lag = end
        k += 1


@kernel
def _add_cell(sign, k, lag, end, older, h, v0, a0, v1, a1, p, total):
    """`_add_piece` within the cell k of K's table: K_k times one mean of the velocity plus K_k+1
    times another."""
    l0, l1, l2, l3 = 0.0, 0.0, 0.0, 0.0
    u0, u1, u2, u3 = 0.0, 0.0, 0.0, 0.0
    for i in range(3):
        x = lag + POINTS[i] * (end - lag)
        upper = sign * WEIGHTS[i] * (end - lag) * (x / p.step - k)
        lower = sign * WEIGHTS[i] * (end - lag) - upper
        b0, b1, b2, b3 = _cubic_kernel((older - x) / h, h)
        l0, l1, l2, l3 = l0 + lower * b0, l1 + lower * b1, l2 + lower * b2, l3 + lower * b3
        u0, u1, u2, u3 = u0 + upper * b0, u1 + upper * b1, u2 + upper * b2, u3 + upper * b3
    last, low, high = -1, 0.0, 0.0
    for e in range(p.row.size):
        j = p.column[e]
        if j != last:
            low = l0 * v0[j] + l1 * a0[j] + l2 * v1[j] + l3 * a1[j]
            high = u0 * v0[j] + u1 * a0[j] + u2 * v1[j] + u3 * a1[j]
            last = j
        total[p.row[e]] += p.K[k, e] * low + p.K[k + 1, e] * high


def _cubic(x, h):
    """Of the cubic at x in [0, 1] of an interval h: weights of the velocity and acceleration at
    its start, and at its end."""
    end = x * x * (3.0 - 2.0 * x)
    return 1.0 - end, h * x * (1.0 - x) ** 2, end, -h * x * x * (1.0 - x)


_cubic_kernel = kernel(_cubic)
