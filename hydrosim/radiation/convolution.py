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
"""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import kernel, root
from hydrosim.radiation.dots import dot
from hydrosim.radiation.history import (
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
    point_time,
    velocity_history,
)
from hydrosim.radiation.state_space import coupled_groups


class ConvolutionKernel(NamedTuple):
    """Retardation functions on a uniform grid of lags, with the non-zero entries only.

    ``K[k, e]`` is the force on DOF ``row[e]`` per velocity of DOF ``column[e]`` at lag k * step.
    """

    step: float  # H [s]
    K: np.ndarray  # (lags, entries)
    bend: np.ndarray  # (entries, lags), b_k
    row: np.ndarray  # (entries,) int64
    column: np.ndarray  # (entries,) int64


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
    return ConvolutionKernel(
        step=float(step),
        K=K,
        bend=np.ascontiguousarray(np.diff(slopes, axis=0).T),
        row=row.astype(np.int64),
        column=column.astype(np.int64),
    )


def history_for(kernel: ConvolutionKernel, dofs: int, longest: float) -> VelocityHistory:
    """An empty history of ``dofs`` velocities for steps of ``longest`` [s] at most. It has no room
    if the kernel is empty."""
    entries, points = kernel.row.size, len(kernel.K) + 1
    return velocity_history(dofs if entries else 0, kernel.step, points, longest, entries)


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
        _along_parabola(k * p.step, t, v, history.node[base], history.time[base], motion)
    else:
        _along_gap(t - k * p.step, base, known, history, motion)
    for e in range(p.row.size):
        j = p.column[e]
        total = p.bend[e, k] * motion[TWICE, j]
        if k == 0:
            total += p.K[0, e] * motion[ONCE, j]
        if k == last:
            total -= p.K[last, e] * motion[ONCE, j]
        force[p.row[e]] -= total


@kernel
def _along_parabola(lag, t, v, node, begin, motion):
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
def _along_gap(time, base, known, history, motion):
    """Y and X at a ``time`` between the grid's point ``known`` and a later node."""
    grid, node = history.grid, history.node[base]
    column = history.place[0] + history.place[1] - known
    begin = point_time(known, history)
    h = history.time[base] - begin
    y0, x0, v0, y1, x1, v1 = quintic((time - begin) / h, h)
    d0, e0, f0, d1, e1, f1 = quintic_slope((time - begin) / h, h)
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
    high = sums[_sums(upper, known, history, p)]
    low = sums[_sums(upper - 1, known, history, p)]
    y0, x0, v0, y1, x1, v1 = quintic(part, p.step)
    d0, e0, f0, d1, e1, f1 = quintic_slope(part, p.step)
    grid, newest = history.grid, history.place[0] + history.place[1] - known
    end = history.place[0] + history.place[1] - (upper - last)
    for e in range(p.row.size):
        j = p.column[e]
        total = y1 * high[TWICE, e] + x1 * high[ONCE, e] + v1 * high[BEFORE, e]
        total += y0 * low[TWICE, e] + x0 * low[ONCE, e] + v0 * low[AFTER, e]
        if near > 0:  # this one is in the lower sums, and not in the interval
            Y, X, V = grid[TWICE, j, newest], grid[ONCE, j, newest], grid[AFTER, j, newest]
            total -= p.bend[e, near] * (y0 * Y + x0 * X + v0 * V)
        if p.K[last, e] != 0.0:
            Y1, X1, V1 = grid[TWICE, j, end], grid[ONCE, j, end], grid[BEFORE, j, end]
            Y0, X0, V0 = grid[TWICE, j, end + 1], grid[ONCE, j, end + 1], grid[AFTER, j, end + 1]
            X = d0 * Y0 + e0 * X0 + f0 * V0 + d1 * Y1 + e1 * X1 + f1 * V1
            total -= p.K[last, e] * X
        force[p.row[e]] -= total


@kernel
def _sums(point, known, history, p):
    """Index in the memo of the sums of b_k times each row of the grid at ``point`` - k. The sums
    run over the lags k > 0 for which that is a grid point up to ``known``."""
    memo = history.memo
    known = min(known, point - 1)
    place = point % memo.key.shape[0]
    if memo.key[place, 0] == point and memo.key[place, 1] == known:
        return place
    memo.key[place, 0], memo.key[place, 1] = point, known
    k = point - known
    first = history.place[0] + history.place[1] - known
    count = p.bend.shape[1] - k
    for e in range(p.row.size):
        b = p.bend[e, k:]
        for m in range(4):
            memo.sums[place, m, e] = dot(b, history.grid[m, p.column[e], first : first + count])
    return place


@kernel
def quintic(x, h):
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
def quintic_slope(x, h):
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
