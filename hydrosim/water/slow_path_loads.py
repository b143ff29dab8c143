"""Wave loads on a body along its slow path, which contains its drift but not its wave-frequency
motion.

    F = R(psi) Re sum_i X_i(b_i - psi) a_i exp(i (w_i t - k_i . (r + d) + e_i)), `displaced_loads`,
    d = d_k + d'_k (t - t_k),   psi = psi_k + psi'_k (t - t_k),     t_k <= t < t_k + T

d_k, psi_k and their rates are the output of a causal filter of surge, sway and yaw at t_k,

    (3 c^2 s + c^3) / (s + c)^3 = 3 z_2 - 2 z_3,   z_1' = c (q - z_1), z_2' = c (z_1 - z_2), ...

It follows a steady drift without a lag and leaves 3 (c / w)^2 of a motion of frequency w. Its
cut-off c is a quarter of the mean frequency of the sea, so about a fifth of the wave-frequency
motions remains. The filter and its output at t_k are part of the state, so that the loads depend on
time and state alone.

Within a block the loads are a table of rows as in `loads`, with the same interpolation. X changes
linearly from its value at the block's first heading to its value at the last. For a hull of length
L the error is (psi' T k L / 2)^2 / 8. The waves are summed once for each row. This costs about a
hundredth of sums at each stage.

Second-order loads (`quadratic_loads`) are taken along the same path, linearly from the block's
first heading to its last. If the waves have few headings, `narrow_bands` gives the same sums at a
fraction of the cost. In bands, yaws that differ by less than `FollowingLoads.steady` have
the same loads, so that a body that keeps its heading and its place needs each row once.
"""

from __future__ import annotations

from math import cos, floor, sin
from typing import NamedTuple

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.jit.kernels import assign, clear, kernel, root
from hydrosim.water import narrow_bands, quadratic_loads
from hydrosim.water.displaced_loads import (
    STATES_PER_FOLLOWED_BODY,
    FollowingLoads,
    loads_at_heading,
    turn_to_earth,
)
from hydrosim.water.loads import STENCIL_POINTS, lagrange, rise, rows_at
from hydrosim.water.transfer import has_nodes

TRACKED = (0, 1, 5)
"""The filtered coordinates: surge, sway, yaw."""
BLOCK_POSITION, BLOCK_RATE, BLOCK_BEGIN = 9, 12, 15
"""Offsets in the states of a body: nine filter states, then position and rate at the beginning of
the block, then its time [s]."""
SLOW_STATE_NAMES = (
    *(f"{DOFS[i]} filter {k}" for i in TRACKED for k in (1, 2, 3)),
    *(f"slow {DOFS[i]}" for i in TRACKED),
    *(f"slow rate of {DOFS[i]}" for i in TRACKED),
    "begin of block",
)


class SlowBlock(NamedTuple):
    """Scratch: the states ``known`` (nb, 7) of the bodies for which their ``rows`` (nb, rows, 2, 6)
    of both orders were made, from time index ``first`` (nb,) on. For every wave: z and the factor
    to the next row, (4, nw), and the loads in heading axes at the block's ends, (24, nw). For a
    cell of their table: (2, 2, 6). The ``path`` (4,) of a body: x, y at the first row,
    velocity. Rows ``steady`` (nb, rows, 2, 6), in heading axes, of the last block in which a body
    kept its yaw ``steady_yaw`` (nb,)."""

    known: np.ndarray
    first: np.ndarray
    rows: np.ndarray
    waves: np.ndarray
    ends: np.ndarray
    cell: np.ndarray
    filtered: quadratic_loads.Filtered
    bands: narrow_bands.BandSums
    path: np.ndarray
    steady: np.ndarray
    steady_first: np.ndarray
    steady_yaw: np.ndarray


def new_block(p: FollowingLoads) -> SlowBlock:
    """Scratch for these loads, without any known state."""
    slow = p.body.size if p.slow.any() else 0
    summed = p.slow & (np.diff(p.bands.sets) == 0)
    most = int(np.diff(p.offset)[summed].max(initial=0))
    return SlowBlock(
        np.full((slow, STATES_PER_FOLLOWED_BODY - BLOCK_POSITION), np.nan),
        np.zeros(slow, dtype=np.int64),
        np.zeros((slow, p.rows, 2, 6)),
        np.zeros((4, most)),
        np.zeros((24, most)),
        np.zeros((2, 2, 6), complex),
        quadratic_loads.new_filtered(p.second, p.offset),
        narrow_bands.new_band_sums(p.body.size, p.bands, p.gathered),
        np.zeros(4),
        np.zeros((slow, p.rows, 2, 6)),
        np.zeros(slow, dtype=np.int64),
        np.full(slow, np.nan),
    )


def first_states(p: FollowingLoads, q: np.ndarray, rate: np.ndarray, time: float) -> np.ndarray:
    """States (`STATES_PER_FOLLOWED_BODY` times slow bodies,) at ``time``, from coordinates and
    rates (6 nb,), for bodies that have always moved steadily."""
    states = []
    first = np.unique(p.state[p.slow], return_index=True)[1]
    for k in np.flatnonzero(p.slow)[first]:
        at, v = (x[6 * p.body[k] + np.array(TRACKED)] for x in (q, rate))
        filters = at[:, None] - np.arange(1, 4) * v[:, None] / p.cut[k]
        states.append([*filters.ravel(), *at, *v, time])
    return np.array(states).ravel()


@kernel
def slow_rates(y, coordinates, p, dy):
    """Rates of the filters into ``dy``; the stored values of the block are constant."""
    for k in range(p.body.size):
        if p.slow[k]:
            at, c = p.state[k], p.cut[k]
            for i in range(3):
                behind = coordinates[6 * p.body[k] + TRACKED[i]]
                for j in range(at + 3 * i, at + 3 * i + 3):
                    dy[j] = c * (behind - y[j])
                    behind = y[j]
            clear(dy[at + BLOCK_POSITION : at + STATES_PER_FOLLOWED_BODY])


@root
def begin_block(t, y, p):
    """Start the next block at time t: its position and rate in ``y`` are set from the filters."""
    for k in range(p.body.size):
        if p.slow[k]:
            at, c = p.state[k], p.cut[k]
            for i in range(3):
                z1, z2, z3 = y[at + 3 * i], y[at + 3 * i + 1], y[at + 3 * i + 2]
                y[at + BLOCK_POSITION + i] = 3.0 * z2 - 2.0 * z3
                y[at + BLOCK_RATE + i] = c * (3.0 * z1 - 5.0 * z2 + 2.0 * z3)
            y[at + BLOCK_BEGIN] = t


@kernel
def find_yaws(t, y, coordinates, p, met):
    """The yaw at which waves meet each body that they follow at time t, into ``met`` (nb,)."""
    for k in range(p.body.size):
        b = p.body[k]
        if p.slow[k]:
            met[b] = _yaw_on_path(k, t - y[p.state[k] + BLOCK_BEGIN], y, p)
        elif p.turns[k]:
            met[b] = coordinates[6 * b + 5]


@kernel
def slow_loads(t, y, p, block, first, second):
    """Add the loads of both orders at time t to ``first`` and ``second`` (6 nb,); ``y`` holds the
    states of all slow bodies."""
    for k in range(p.body.size):
        if p.slow[k]:
            if not _is_known(k, y, p, block):
                _fill_block(k, y, p, block)
            at, x = 6 * p.loaded[k], t / p.row_step - block.first[k]
            row, points = rows_at(x, p.rows)
            for m in range(points):
                weight = lagrange(x - row, m, points)
                for j in range(6):
                    first[at + j] += weight * block.rows[k, row + m, 0, j]
                    second[at + j] += weight * block.rows[k, row + m, 1, j]


@kernel
def _is_known(k, y, p, block):
    for i in range(STATES_PER_FOLLOWED_BODY - BLOCK_POSITION):
        if block.known[k, i] != y[p.state[k] + BLOCK_POSITION + i]:
            return False
    return True


@root
def _fill_block(k, y, p, block):
    """Fill the rows of body k for the block in its states."""
    at, begin = p.state[k], y[p.state[k] + BLOCK_BEGIN]
    assign(block.known[k], y[at + BLOCK_POSITION : at + STATES_PER_FOLLOWED_BODY])
    block.first[k] = floor(begin / p.row_step + 1e-9) - STENCIL_POINTS // 2 + 1
    _find_path(k, block.first[k] * p.row_step - begin, y, p, block.path)
    if narrow_bands.has_bands(k, p.bands) and _is_steady(k, y, p):
        _sum_steady(k, y, p, block)
    elif narrow_bands.has_bands(k, p.bands):
        _sum_bands(k, y, p, block)
    else:
        _sum_waves(k, y, p, block)
    for r in range(p.rows):
        t = (block.first[k] + r) * p.row_step
        heading = p.rest[k] + _yaw_on_path(k, t - begin, y, p)
        for order in range(2):
            row = block.rows[k, r, order]
            turn_to_earth(heading, row)
            for j in range(6):
                row[j] = row[j] if p.active[k, j] else 0.0


@root
def _sum_bands(k, y, p, block):
    """Fill the rows of body k in heading axes, from its bands."""
    begin = y[p.state[k] + BLOCK_BEGIN]
    narrow_bands.weigh_bands(k, _yaw_on_path(k, 0.0, y, p), 0, p, block.bands)
    narrow_bands.weigh_bands(k, _yaw_on_path(k, p.block, y, p), 1, p, block.bands)
    start = block.first[k] * p.row_step
    samples = (STENCIL_POINTS - 1) / (p.rows - 1)
    if has_nodes(k, p.gathered):
        middle = begin + p.block / 2.0
        narrow_bands.interpolate_path(
            k, start, middle, p.row_step / samples, block.path, p, block.bands
        )
    narrow_bands.find_phases(k, start, p.row_step, block.path, p.bands, block.bands)
    for r in range(p.rows):
        t = (block.first[k] + r) * p.row_step
        first = block.rows[k, r, 0]
        second = block.rows[k, r, 1]
        clear(first)
        clear(second)
        narrow_bands.add_bands(
            k, t, (t - begin) / p.block, samples * r, p, block.bands, first, second
        )
        narrow_bands.turn_phases(k, p.bands, block.bands)


@kernel
def _steady_yaw(k, y, p):
    """The multiple of `FollowingLoads.steady` that is next to the yaw of body k in its block."""
    return p.steady[k] * floor(_yaw_on_path(k, p.block / 2.0, y, p) / p.steady[k] + 0.5)


@kernel
def _is_steady(k, y, p):
    """True if body k neither drifts nor yaws, as far as its loads show, in its block."""
    if p.placed[k]:
        return False
    yaw = _steady_yaw(k, y, p)
    first = abs(_yaw_on_path(k, 0.0, y, p) - yaw)
    last = abs(_yaw_on_path(k, p.block, y, p) - yaw)
    return max(first, last) <= p.steady[k]


@root
def _sum_steady(k, y, p, block):
    """Fill the rows of body k in heading axes, from its bands at one yaw. Rows that the last block
    has left are used again. So phases at a row depend on its number, not on the block."""
    yaw = _steady_yaw(k, y, p)
    rows = block.steady[k]
    begin = block.first[k]
    shift = begin - block.steady_first[k] if block.steady_yaw[k] == yaw else p.rows
    count = p.rows - shift if 0 <= shift < p.rows else 0
    block.steady_yaw[k] = yaw
    block.steady_first[k] = begin
    narrow_bands.weigh_bands(k, yaw, 0, p, block.bands)
    for r in range(count):
        assign(rows[r, 0], rows[r + shift, 0])
        assign(rows[r, 1], rows[r + shift, 1])
    turns = 0
    for r in range(count, p.rows):
        since = (begin + r - STENCIL_POINTS + 2) % (
            p.rows - STENCIL_POINTS
        )  # so that few blocks begin anew twice
        if r == count or since == 0:
            start = (begin + r - since) * p.row_step
            narrow_bands.find_phases(k, start, p.row_step, block.path, p.bands, block.bands)
            turns = since
        for _ in range(turns):
            narrow_bands.turn_phases(k, p.bands, block.bands)
        turns = 1
        clear(rows[r, 0])
        clear(rows[r, 1])
        t = (begin + r) * p.row_step
        narrow_bands.add_bands(k, t, 0.0, 0.0, p, block.bands, rows[r, 0], rows[r, 1])
    for r in range(p.rows):
        assign(block.rows[k, r, 0], rows[r, 0])
        assign(block.rows[k, r, 1], rows[r, 1])


@root
def _sum_waves(k, y, p, block):
    """Fill the rows of body k in heading axes, from all waves."""
    begin, start = y[p.state[k] + BLOCK_BEGIN], p.offset[k]
    waves = block.waves
    loads_at_heading(k, _yaw_on_path(k, 0.0, y, p), p, block.cell, block.ends[:12])
    loads_at_heading(k, _yaw_on_path(k, p.block, y, p), p, block.cell, block.ends[12:])
    second = quadratic_loads.has_forms(k, p.second)
    if second:
        quadratic_loads.fill_load_factors(k, _yaw_on_path(k, 0.0, y, p), 0, p, block.filtered)
        quadratic_loads.fill_load_factors(k, _yaw_on_path(k, p.block, y, p), 1, p, block.filtered)
    _find_waves(k, block.first[k] * p.row_step, p, block)
    for r in range(p.rows):
        t, row = (block.first[k] + r) * p.row_step, block.rows[k, r, 0]
        part = (t - begin) / p.block
        clear(row)
        i = start
        while i < p.offset[k + 1]:
            last = i + 1
            while last < p.offset[k + 1] and p.ramp[last] == p.ramp[i]:
                last += 1
            narrow_bands.add_waves(
                rise(t, p.ramp[i]), part, i - start, last - start, block.ends, waves, row
            )
            i = last
        other = block.rows[k, r, 1]
        clear(other)
        if second:
            quadratic_loads.add_forms(k, t, 0, 1.0 - part, waves, p.second, block.filtered, other)
            quadratic_loads.add_forms(k, t, 1, part, waves, p.second, block.filtered, other)
        count = p.offset[k + 1] - start
        narrow_bands.rotate_phase(
            waves[2, :count], waves[3, :count], waves[0, :count], waves[1, :count]
        )


@kernel
def _yaw_on_path(k, since, y, p):
    """Yaw on the slow path of body k at the time ``since`` the start of the block; 0 if it does not
    count."""
    at = p.state[k]
    if not p.turns[k]:
        return 0.0
    return y[at + BLOCK_POSITION + 2] + since * y[at + BLOCK_RATE + 2]


@kernel
def _find_path(k, since, y, p, path):
    """Displacement of body k on its slow path at the time ``since`` the start of the block, and its
    velocity, into ``path`` (4,); 0 if they do not count."""
    at = p.state[k]
    clear(path)
    if p.placed[k]:
        for i in range(2):
            path[i] = y[at + BLOCK_POSITION + i] + since * y[at + BLOCK_RATE + i]
            path[2 + i] = y[at + BLOCK_RATE + i]


@kernel
def _find_waves(k, t, p, block):
    """z = exp(i (w t - k . d(t))) of every wave at the first row, and its factor to the next
    row."""
    x, y, vx, vy = block.path[0], block.path[1], block.path[2], block.path[3]
    for i in range(p.offset[k + 1] - p.offset[k]):
        n = p.offset[k] + i
        kx, ky = p.wavenumber[n] * cos(p.heading[n]), p.wavenumber[n] * sin(p.heading[n])
        angle = p.omega[n] * t - kx * x - ky * y
        turn = (p.omega[n] - kx * vx - ky * vy) * p.row_step
        block.waves[0, i], block.waves[1, i] = cos(angle), sin(angle)
        block.waves[2, i], block.waves[3, i] = cos(turn), sin(turn)
