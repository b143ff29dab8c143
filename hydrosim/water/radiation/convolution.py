"""The memory force as the integral itself, F(t) = -int_0^t K(t - s) v(s) ds (Cummins 1962).

K is linear between the entries of its table, at the lags k H, so its second derivative is a comb.
With X = int v and Y = int X, integration by parts twice gives

    int K(t - s) v(s) ds = K_0 X(t) - K_n X(t - n H) + sum_k=0^n b_k Y(t - k H),

where b_k are the bends (K_k+1 - 2 K_k + K_k-1) / H; the slopes beyond both ends are zero. The past
(`history`) is known on a grid of the same interval H. On it Y is the polynomial of degree 5 with
the right Y, X and v at the ends.

So the integral consists of sums of b_k times Y, X and v at points of the grid. These sums are the
same for all times within an interval, and are computed once, for steps of any length. From the
newest node to t the velocity is a parabola that ends in the velocity at t, which may belong to a
stage that is not accepted. The error is of order 4 in the steps.

The sums over a long past are partitioned (Stockham 1966; Gardner 1995). Blocks of the grid that are
complete are transformed once. What they add to a whole block of later points is one inverse
transform of products with the transformed b. The newest points are summed directly.
"""

from __future__ import annotations

from math import ceil, log2, sqrt
from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import kernel, root
from hydrosim.water.radiation.history import (
    ACCELERATION,
    AFTER,
    BEFORE,
    EVEN,
    NOW,
    ONCE,
    THEN,
    TWICE,
    VELOCITY,
    VelocityHistory,
    new_velocity_history,
    point_time,
)
from hydrosim.water.radiation.memory import dot
from hydrosim.water.radiation.state_space import coupled_groups

# Fourier transforms of powers of two, without memory of their own.
#
# `transform` leaves its results in an order of its own, that of reversed bits, and `untransform`
# takes them in it (Gentleman and Sande 1966; Cooley and Tukey 1965). Products need no other order.


def roots_of_unity(half: int) -> np.ndarray:
    """exp(-i pi k / half), k = 0 to half - 1: what transforms of 2 ``half`` values turn by."""
    return np.exp(-1j * np.pi * np.arange(half) / half)


def find_bit_reversal(size: int) -> np.ndarray:
    """The frequencies (size,) in the order that `transform` leaves them in."""
    order = np.zeros(1, dtype=np.int64)
    while order.size < size:
        order = np.concatenate([2 * order, 2 * order + 1])
    return order


@kernel
def transform(values, turns):
    """Replace ``values`` (n,) by their sums over exp(-2 pi i j k / n), in reversed order."""
    span, stride = turns.size, 1
    while span > 0:
        for start in range(0, values.size, 2 * span):
            for k in range(span):
                a, b = values[start + k], values[start + k + span]
                values[start + k] = a + b
                values[start + k + span] = (a - b) * turns[k * stride]
        span, stride = span // 2, 2 * stride


@kernel
def untransform(values, turns):
    """Undo `transform`."""
    span, stride = 1, turns.size
    while stride > 0:
        for start in range(0, values.size, 2 * span):
            for k in range(span):
                a, b = values[start + k], values[start + k + span] * turns[k * stride].conjugate()
                values[start + k] = a + b
                values[start + k + span] = a - b
        span, stride = 2 * span, stride // 2
    for k in range(values.size):
        values[k] /= values.size


@kernel
def add_products(a, b, total):
    """Add a b to the ``total``, entry by entry."""
    for k in range(total.size):
        total[k] += a[k] * b[k]


SQUARED_BLOCK_PER_LAG = 4.0
"""Square of the points of a block, over the lags of the table."""
FEWEST_BLOCKS = 4
"""Blocks in the table of K from which on they are worth their transforms."""


class ConvolutionKernel(NamedTuple):
    """Retardation functions on a uniform grid of lags, with the non-zero entries only.

    ``K[k, e]`` is the force on DOF ``row[e]`` per velocity of DOF ``column[e]`` at lag k * step.
    ``spectrum[d]`` takes a block of points to the block d + 1 later. A short table has none.
    """

    step: float  # H [s]
    K: np.ndarray  # (lags, entries)
    bend: np.ndarray  # (entries, lags), b_k
    row: np.ndarray  # (entries,) int64
    column: np.ndarray  # (entries,) int64
    dofs: np.ndarray  # int64, all rows and columns
    spectrum: np.ndarray  # (distances, entries, 2 block) complex, in the order of `transform`
    turns: np.ndarray  # (block,) complex, see `roots_of_unity`


def convolution_model(step: float, retardation: np.ndarray) -> ConvolutionKernel:
    """Table for the direct convolution from K (nt, n, n) at the lags 0, step, 2 step, ...

    n are all DOFs of the scene, six per body. The entries kept are those that a state-space model
    would fit, see `coupled_groups`. K = 0 throughout gives an empty table, which costs nothing.
    """
    kept = np.zeros(retardation.shape[1:], dtype=bool)
    for dofs in coupled_groups(retardation):
        kept[dofs[:, None], dofs] = True
    column, row = np.nonzero(kept.T)
    K = np.ascontiguousarray(retardation[:, row, column], dtype=np.float64)
    slopes = np.diff(K, axis=0, prepend=K[:1], append=K[-1:]) / step
    bend = np.ascontiguousarray(np.diff(slopes, axis=0).T)
    block = _choose_block_size(len(K))
    return ConvolutionKernel(
        step=float(step),
        K=K,
        bend=bend,
        row=row.astype(np.int64),
        column=column.astype(np.int64),
        dofs=np.unique(column).astype(np.int64),
        spectrum=_transform_bends(bend, block),
        turns=roots_of_unity(block),
    )


def _choose_block_size(lags: int) -> int:
    """Points of a block, a power of two: about as much work for blocks as for single points."""
    return 2 ** round(log2(sqrt(SQUARED_BLOCK_PER_LAG * lags)))


def _transform_bends(bend: np.ndarray, block: int) -> np.ndarray:
    """Transforms (distances, entries, 2 block) of ``bend`` (entries, lags): from each block of
    points to those that are one, two, ... blocks later. None for a short table."""
    entries, lags = bend.shape
    distances = (lags + block - 2) // block if lags >= FEWEST_BLOCKS * block else 0
    spectrum = np.zeros((distances, entries, 2 * block), dtype=np.complex128)
    padded = np.pad(bend, ((0, 0), (0, (distances + 1) * block)))
    for d in range(distances):
        ahead = padded[:, (d + 1) * block : (d + 2) * block]
        behind = padded[:, d * block + 1 : (d + 1) * block]
        around = np.hstack([ahead, np.zeros((entries, 1)), behind])
        spectrum[d] = np.fft.fft(around)[:, find_bit_reversal(2 * block)]
    return spectrum


def new_history(kernel: ConvolutionKernel, dofs: int, longest: float) -> VelocityHistory:
    """An empty history of ``dofs`` velocities for steps of ``longest`` [s] at most. It has no room
    if the kernel is empty."""
    points = len(kernel.K) + 1
    distances, block = len(kernel.spectrum), kernel.turns.size
    return new_velocity_history(
        dofs if kernel.row.size else 0, kernel.step, points, longest, distances, block
    )


@root
def radiation_memory(t, v, history, p, force):
    """Subtract int K(t - s) v(s) ds from ``force``, for the velocities known before ``t`` and ``v``
    at t.

    The integral runs to t from the first node (v = 0 before it), or from the end of the table of K.
    t may be a stage between steps. The newest node is ignored if it is at or after t.

    v, force: all DOFs of the scene; history: `VelocityHistory`; p: `ConvolutionKernel`.
    """
    base = NOW if history.time[NOW] < t else THEN
    if p.row.size == 0 or not history.time[base] < t:
        return
    known = history.place[1] if base == NOW else history.place[2]
    since = (t - history.begin[0]) / p.step
    upper = max(ceil(since - EVEN), known + 1)
    part = min(max(since - (upper - 1), 0.0), 1.0)
    if 1.0 - part < EVEN:
        part = 1.0
    near = min(upper - known - 1, p.bend.shape[1] - 1)  # lags up to this one lie after the grid
    for k in range(near + 1):
        _add_lag(k, t, v, base, known, history, p, force)
    _add_grid(upper, known, part, history, p, force)


@kernel
def _add_lag(k, t, v, base, known, history, p, force):
    """Subtract b_k Y(t - k H), with X at both ends, for a time after the grid."""
    motion, last = history.memo.motion, p.bend.shape[1] - 1
    if k == 0 or t - k * p.step >= history.time[base]:
        _follow_parabola(k * p.step, t, v, history.node[base], history.time[base], motion)
    else:
        _bridge_gap(t - k * p.step, base, known, history, motion)
    for e in range(p.row.size):
        j = p.column[e]
        total = p.bend[e, k] * motion[TWICE, j]
        if k == 0:
            total += p.K[0, e] * motion[ONCE, j]
        if k == last:
            total -= p.K[last, e] * motion[ONCE, j]
        force[p.row[e]] -= total


@kernel
def _follow_parabola(lag, t, v, node, begin, motion):
    """Y and X at ``t - lag``, in the step from the node at ``begin``."""
    h = t - begin
    s = h - lag
    for j in range(v.size):
        u, a = node[VELOCITY, j], node[ACCELERATION, j]
        c = (v[j] - u - h * a) / (h * h)
        motion[ONCE, j] = node[ONCE, j] + s * (u + s * (a / 2.0 + s * c / 3.0))
        motion[TWICE, j] = node[TWICE, j] + s * (
            node[ONCE, j] + s * (u / 2.0 + s * (a / 6.0 + s * c / 12.0))
        )


@kernel
def _bridge_gap(time, base, known, history, motion):
    """Y and X at a ``time`` between the grid's point ``known`` and a later node."""
    grid, node = history.grid, history.node[base]
    column = history.place[0] + history.place[1] - known
    begin = point_time(known, history)
    h = history.time[base] - begin
    y0, x0, v0, y1, x1, v1 = quintic_weights((time - begin) / h, h)
    d0, e0, f0, d1, e1, f1 = quintic_slope_weights((time - begin) / h, h)
    for j in range(motion.shape[1]):
        Y0, X0, V0 = grid[TWICE, j, column], grid[ONCE, j, column], grid[AFTER, j, column]
        Y1, X1, V1 = node[TWICE, j], node[ONCE, j], node[VELOCITY, j]
        motion[TWICE, j] = y0 * Y0 + x0 * X0 + v0 * V0 + y1 * Y1 + x1 * X1 + v1 * V1
        motion[ONCE, j] = d0 * Y0 + e0 * X0 + f0 * V0 + d1 * Y1 + e1 * X1 + f1 * V1


@kernel
def _add_grid(upper, known, part, history, p, force):
    """Subtract b_k Y(t - k H) for all lags within the grid, and K_n X(t - n H).

    t - k H is at the fraction ``part`` of the interval from the point ``upper`` - k - 1 to the next
    one.
    """
    near, last = upper - known - 1, p.bend.shape[1] - 1
    if near >= last:
        return
    sums = history.memo.sums
    high = sums[_find_sums(upper, known, history, p)]
    low = sums[_find_sums(upper - 1, known, history, p)]
    y0, x0, v0, y1, x1, v1 = quintic_weights(part, p.step)
    d0, e0, f0, d1, e1, f1 = quintic_slope_weights(part, p.step)
    for i in p.dofs:
        total = y1 * high[TWICE, i] + x1 * high[ONCE, i] + v1 * high[BEFORE, i]
        total += y0 * low[TWICE, i] + x0 * low[ONCE, i] + v0 * low[AFTER, i]
        force[i] -= total
    grid, newest = history.grid, history.place[0] + history.place[1] - known
    end = history.place[0] + history.place[1] - (upper - last)
    for e in range(p.row.size):
        j = p.column[e]
        if near > 0:  # this one is in the lower sums, and not in the interval
            Y, X, V = grid[TWICE, j, newest], grid[ONCE, j, newest], grid[AFTER, j, newest]
            force[p.row[e]] += p.bend[e, near] * (y0 * Y + x0 * X + v0 * V)
        if p.K[last, e] != 0.0:
            Y1, X1, V1 = grid[TWICE, j, end], grid[ONCE, j, end], grid[BEFORE, j, end]
            Y0, X0, V0 = grid[TWICE, j, end + 1], grid[ONCE, j, end + 1], grid[AFTER, j, end + 1]
            X = d0 * Y0 + e0 * X0 + f0 * V0 + d1 * Y1 + e1 * X1 + f1 * V1
            force[p.row[e]] += p.K[last, e] * X


@kernel
def _find_sums(point, known, history, p):
    """Index in the memo of the sums of b_k times each row of the grid at ``point`` - k. The sums
    run over the lags k > 0 for which that is a grid point up to ``known``."""
    memo = history.memo
    known = min(known, point - 1)
    place = point % memo.key.shape[0]
    if memo.key[place, 0] == point and memo.key[place, 1] == known:
        return place
    memo.key[place, 0], memo.key[place, 1] = point, known
    sums = memo.sums[place]
    k = point - known
    first = history.place[0] + history.place[1] - known
    count = p.bend.shape[1] - k
    if p.spectrum.shape[0] == 0:
        for i in p.dofs:
            for m in range(4):
                sums[m, i] = 0.0
    else:
        block = p.turns.size
        complete = (known + 1) // block - 1
        count = min(count, known + 1 - (complete + 1) * block)
        later = memo.later[_find_block_sums(point // block, complete, history, p)]
        for i in p.dofs:
            for m in range(4):
                sums[m, i] = later[m, i, point % block]
    for e in range(p.row.size):
        b = p.bend[e, k : k + count]
        for m in range(4):
            sums[m, p.row[e]] += dot(b, history.grid[m, p.column[e], first : first + count])
    return place


@kernel
def _find_block_sums(block, complete, history, p):
    """Index in the memo of the same sums for all points of a ``block``, over the points of blocks
    up to ``complete``."""
    memo, distances = history.memo, p.spectrum.shape[0]
    place = block % memo.later.shape[0]
    if memo.later_key[place, 0] == block and memo.later_key[place, 1] == complete:
        return place
    memo.later_key[place, 0], memo.later_key[place, 1] = block, complete
    total = memo.total
    total[:] = 0.0
    for distance in range(block - complete, distances + 1):
        past = memo.blocks[_find_block_transform(block - distance, history, p)]
        for e in range(p.row.size):
            for pair in range(2):
                add_products(
                    p.spectrum[distance - 1, e], past[pair, p.column[e]], total[pair, p.row[e]]
                )
    for i in p.dofs:
        for pair in range(2):
            untransform(total[pair, i], p.turns)
            for n in range(p.turns.size):
                memo.later[place, 2 * pair, i, n] = total[pair, i, n].real
                memo.later[place, 2 * pair + 1, i, n] = total[pair, i, n].imag
    return place


@kernel
def _find_block_transform(block, history, p):
    """Index in the memo of the transforms of a ``block`` of the grid: Y + i X, and v before
    + i v after a jump."""
    memo, size = history.memo, p.turns.size
    place = block % memo.number.size
    if memo.number[place] == block:
        return place
    memo.number[place] = block
    first = history.place[0] + history.place[1] - block * size
    for j in p.dofs:
        for pair in range(2):
            values = memo.blocks[place, pair, j]
            values[size:] = 0.0
            for n in range(size):
                values[n] = complex(
                    history.grid[2 * pair, j, first - n], history.grid[2 * pair + 1, j, first - n]
                )
            transform(values, p.turns)
    return place


@kernel
def quintic_weights(x, h):
    """Polynomial of degree 5 at the fraction x of an interval h: weights of value, slope and
    curvature at its start, and at its end."""
    y = 1.0 - x
    end = x * x * x * (10.0 - 15.0 * x + 6.0 * x * x)
    return (
        1.0 - end,
        h * x * y * y * y * (1.0 + 3.0 * x),
        0.5 * h * h * x * x * y * y * y,
        end,
        -h * y * x * x * x * (1.0 + 3.0 * y),
        0.5 * h * h * y * y * x * x * x,
    )


@kernel
def quintic_slope_weights(x, h):
    """The derivatives of the weights of `quintic` by h x."""
    y = 1.0 - x
    end = 30.0 * x * x * y * y / h
    return (
        -end,
        y * y * (1.0 + 2.0 * x - 15.0 * x * x),
        0.5 * h * x * y * y * (2.0 - 5.0 * x),
        end,
        x * x * (1.0 + 2.0 * y - 15.0 * y * y),
        -0.5 * h * y * x * x * (2.0 - 5.0 * y),
    )
