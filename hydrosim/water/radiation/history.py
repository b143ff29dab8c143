"""The velocities v that a convolution remembers: v and its integrals X = int v and Y = int X, at
the points of a grid of times. The grid is that of the table of K, not of the steps.

Within an interval of the grid v is the cubic with the right v at both ends and the right X and Y.
If steps equal the grid or are longer, this is the cubic through the velocities and accelerations of
the steps. If they are shorter, or cut at events, the cubic has their total displacement and first
moment. The error is of order 4 in the interval.

X and Y count from a time that moves along. Results that depend on v only do not depend on it.
"""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import assign, kernel, root

EVEN = 1e-9  # of an interval: times this close to a point of the grid are at it
TWICE, ONCE, BEFORE, AFTER = range(4)
"""Rows of the grid: Y, X, and v before and after a jump."""
LONGEST_REMEMBERED = 1.5
"""Longest step that a history has room for, over the step of its run."""
NO_NUMBER = -(2**62)
"""No point and no block has this number."""
VELOCITY, ACCELERATION = 2, 3  # rows of a node, after Y and X
NOW, THEN = range(2)  # the newest node, and the newest node at an earlier time


class VelocityHistory(NamedTuple):
    """Velocities at the points of a grid, the newest first, and at two nodes.

    Point n of the grid is at ``begin[0] + n * step``. The newest is n = ``place[1]``, in the column
    ``place[0]``; older ones follow, and motion before the first is zero. ``place[2]`` is the newest
    point at the node THEN; at the point ``place[3]`` Y and X are zero.
    """

    step: float  # [s]
    begin: np.ndarray  # (1,) [s]
    grid: np.ndarray  # (4, dofs, room), so that sums run along the memory
    place: np.ndarray  # (4,) int64
    time: np.ndarray  # (2,) [s] of the nodes; infinite if there is none
    node: np.ndarray  # (2, 4, dofs): Y, X, velocity, acceleration
    memo: Memo


class Memo(NamedTuple):
    """Sums over the grid that were computed last, see `convolution`. They only save time."""

    key: np.ndarray  # (places, 2) int64: the point, and the newest point known then
    sums: np.ndarray  # (places, 4, dofs)
    later_key: np.ndarray  # (places, 2) int64: the block, and the newest complete block then
    later: np.ndarray  # (places, 4, dofs, block): sums for all points of a block
    number: np.ndarray  # (distances,) int64: the blocks in `blocks`
    blocks: np.ndarray  # (distances, 2, dofs, 2 block) complex: transforms of blocks of the grid
    total: np.ndarray  # (2, dofs, 2 block) complex, scratch
    motion: np.ndarray  # (2, dofs), scratch


def new_velocity_history(
    dofs: int, step: float, points: int, longest: float, distances: int = 0, block: int = 1
) -> VelocityHistory:
    """An empty history of ``dofs`` velocities: ``points`` of a grid, one ``step`` [s] apart, filled
    in steps of ``longest`` [s] at most. There is room for steps that are `LONGEST_REMEMBERED` times
    as long, and for blocks of ``block`` points that are felt for so many ``distances``."""
    ahead = ceil(LONGEST_REMEMBERED * longest / step) + 2 if dofs else 0
    parts = 2 * block if distances else 0  # of the newest and the oldest block, parts are felt
    kept = points + ahead + parts
    later = ahead // block + 2 if distances else 0
    return VelocityHistory(
        step=step,
        begin=np.zeros(1),
        grid=np.zeros((4, dofs, 2 * kept + ahead)),
        place=np.array([kept + ahead - 1, 0, 0, 0], dtype=np.int64),
        time=np.full(2, np.inf),
        node=np.zeros((2, 4, dofs)),
        memo=Memo(
            key=np.full((ahead, 2), NO_NUMBER),
            sums=np.zeros((ahead, 4, dofs)),
            later_key=np.full((later, 2), NO_NUMBER),
            later=np.zeros((later, 4, dofs, block)),
            number=np.full(distances, NO_NUMBER),
            blocks=np.zeros((distances, 2, dofs, 2 * block), dtype=np.complex128),
            total=np.zeros((2, dofs, 2 * block), dtype=np.complex128),
            motion=np.zeros((2, dofs)),
        ),
    )


@root
def append_node(history, t, v, a):
    """Append the accepted node (t, v, a). At the time of the newest node it replaces that node, as
    the other side of a jump."""
    time, node, place = history.time, history.node, history.place
    if time[NOW] == np.inf:
        history.begin[0] = t
    elif t > time[NOW]:
        h = t - time[NOW]
        place[2] = place[1]
        time[THEN] = time[NOW]
        for m in range(4):
            assign(node[THEN, m], node[NOW, m])
        _add_points(t, v, a, history)
        for i in range(v.size):
            Y, X, u, b = node[THEN, 0, i], node[THEN, 1, i], node[THEN, 2, i], node[THEN, 3, i]
            node[NOW, TWICE, i], node[NOW, ONCE, i], _ = interpolate_cubic(
                1.0, h, Y, X, u, b, v[i], a[i]
            )
    time[NOW] = t
    assign(node[NOW, VELOCITY], v)
    assign(node[NOW, ACCELERATION], a)
    if abs(t - point_time(place[1], history)) <= EVEN * history.step:
        after = history.grid[AFTER]
        for i in range(v.size):
            if after[i, place[0]] != v[i]:
                after[i, place[0]] = v[i]
                discard_sums(place[1], history)


@kernel
def _add_points(t, v, a, history):
    """Add the points of the grid from the newest node to ``t``, on the cubic between them."""
    time, node, place, step = history.time, history.node, history.place, history.step
    h = t - time[NOW]
    while point_time(place[1] + 1, history) <= t + EVEN * step:
        x = min((point_time(place[1] + 1, history) - time[NOW]) / h, 1.0)
        if h - x * h <= EVEN * step:
            x = 1.0
        column = _next_column(history)
        for i in range(v.size):
            Y, X, u = interpolate_cubic(
                x, h, node[NOW, 0, i], node[NOW, 1, i], node[NOW, 2, i], node[NOW, 3, i], v[i], a[i]
            )
            history.grid[TWICE, i, column], history.grid[ONCE, i, column] = Y, X
            history.grid[BEFORE, i, column] = history.grid[AFTER, i, column] = u


@kernel
def interpolate_cubic(x, h, Y, X, v0, a0, v1, a1):
    """Y, X and v at the fraction ``x`` of an interval h, for the cubic from (v0, a0) to (v1,
    a1)."""
    s = x * h
    rise, sag = (v1 - v0) / h, (a0 + a1) / h
    b, c = (3.0 * rise - 2.0 * a0 - a1) / h, (sag - 2.0 * rise / h) / h
    v = v0 + s * (a0 + s * (b + s * c)) if x < 1.0 else v1
    once = X + s * (v0 + s * (a0 / 2.0 + s * (b / 3.0 + s * c / 4.0)))
    twice = Y + s * (X + s * (v0 / 2.0 + s * (a0 / 6.0 + s * (b / 12.0 + s * c / 20.0))))
    return twice, once, v


@kernel
def _next_column(history):
    """Make room for a new point; returns its column."""
    grid, place = history.grid, history.place
    if place[0] == 0:
        kept = grid.shape[2] // 2
        to = grid.shape[2] - kept
        for k in range(kept - 1, -1, -1):
            for m in range(4):
                for i in range(grid.shape[1]):
                    grid[m, i, to + k] = grid[m, i, k]
        place[0] = to
    place[0] -= 1
    place[1] += 1
    return place[0]


@kernel
def recount_integrals(history):
    """Restart X and Y at the newest point of the grid from time to time: growing numbers would lose
    digits."""
    grid, place = history.grid, history.place
    if place[1] - place[3] < grid.shape[2] // 4 or grid.shape[1] == 0:
        return
    newest, now = place[0], point_time(place[1], history)
    place[3] = place[1]
    for i in range(grid.shape[1]):
        Y, X = grid[TWICE, i, newest], grid[ONCE, i, newest]
        for c in range(grid.shape[2]):
            grid[TWICE, i, c] -= Y + X * (newest - c) * history.step
            grid[ONCE, i, c] -= X
        for node in range(2):
            history.node[node, TWICE, i] -= Y + X * (history.time[node] - now)
            history.node[node, ONCE, i] -= X
    discard_sums(NO_NUMBER + 1, history)


@kernel
def discard_sums(first, history):
    """Discard the computed sums and transforms that hold points of the grid from the ``first`` on:
    they belong to another past."""
    memo = history.memo
    block = first // memo.later.shape[3]
    for place in range(memo.key.shape[0]):
        if memo.key[place, 1] >= first:
            memo.key[place, 0] = NO_NUMBER
    for place in range(memo.later_key.shape[0]):
        if memo.later_key[place, 1] >= block:
            memo.later_key[place, 0] = NO_NUMBER
    for place in range(memo.number.size):
        if memo.number[place] >= block:
            memo.number[place] = NO_NUMBER


@kernel
def remove_newest_node(t, history):
    """Remove the newest node if it is at ``t``; returns true if it was."""
    time, node, place = history.time, history.node, history.place
    if time[NOW] != t or time[THEN] == np.inf:
        return False
    place[0] += place[1] - place[2]
    place[1] = place[2]
    time[NOW], time[THEN] = time[THEN], np.inf
    for m in range(4):
        assign(node[NOW, m], node[THEN, m])
    discard_sums(place[1] + 1, history)
    return True


@kernel
def point_time(n, history):
    """Time of point ``n`` of the grid [s]."""
    return history.begin[0] + n * history.step
