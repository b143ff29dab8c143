"""The memory force of the radiated waves, F(t) = -int_0^t K(t - s) v(s) ds (Cummins 1962).

Two kernels give the same force: `radiation_states` integrates a rational fit of K as extra states,
`radiation_memory` evaluates the integral itself over the velocities kept in a history. Neither
changes what it reads, so both may be called any number of times for one instant.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.kernels import kernel


class RadiationStates(NamedTuple):
    """State-space models of all groups of coupled DOFs, flattened; see `state_space_model`.

    Group g owns the states ``state[g]:state[g+1]``, in the order of `StateSpace`: ``real[g]``
    real poles, then the first states of all pairs, then their second states. It couples the DOFs
    ``dof[member[g]:member[g+1]]``; its B and C are (m, states) and row-major from ``matrix[g]``.
    """

    state: np.ndarray  # (groups + 1,) int64
    member: np.ndarray  # (groups + 1,) int64
    matrix: np.ndarray  # (groups,) int64
    real: np.ndarray  # (groups,) int64
    dof: np.ndarray  # (members,) int64, indices into v and force
    decay: np.ndarray  # (states,) [1/s], negative
    rotation: np.ndarray  # (states,) [rad/s], used on the first state of each pair
    B: np.ndarray  # flat
    C: np.ndarray  # flat, transposed


class ConvolutionKernel(NamedTuple):
    """Retardation functions on a uniform grid of lags, only the entries that are not zero.

    ``K[k, e]`` is the force on DOF ``row[e]`` per velocity of DOF ``column[e]`` at lag k * step.
    """

    step: float  # [s]
    K: np.ndarray  # (lags, entries)
    row: np.ndarray  # (entries,) int64
    column: np.ndarray  # (entries,) int64


class VelocityHistory(NamedTuple):
    """Velocities at the accepted steps, a ring buffer of nodes with any spacing.

    Node i (counted from the first one pushed) is at index i % capacity; ``pushed[0]`` nodes have
    been pushed. Times never decrease; two nodes at one time are a jump of the velocity.
    """

    time: np.ndarray  # (capacity,) [s]
    velocity: np.ndarray  # (capacity, dofs)
    pushed: np.ndarray  # (1,) int64


@kernel
def radiation_states(x, v, p, dx, force):
    """Fill dx = Lambda x + B v and subtract C x from ``force``, for all groups.

    x, dx: (states,) or longer; v, force: all DOFs of the scene; p: `RadiationStates`.
    """
    for g in range(p.real.size):
        first, last = p.state[g], p.state[g + 1]
        own_x, own_dx = x[first:last], dx[first:last]
        _decay_and_rotate(own_x, p.decay[first:last], p.rotation[first:last], p.real[g], own_dx)
        row = p.matrix[g]
        for j in range(p.member[g], p.member[g + 1]):
            d = p.dof[j]
            _add_scaled(p.B[row : row + own_x.size], v[d], own_dx)
            force[d] -= _dot(p.C[row : row + own_x.size], own_x)
            row += own_x.size


@kernel
def _decay_and_rotate(x, decay, rotation, real, dx):
    """dx = Lambda x of one group; contiguous loops without branches, so that they vectorise."""
    pairs = (x.size - real) // 2
    for k in range(x.size):
        dx[k] = decay[k] * x[k]
    for k in range(pairs):
        dx[real + k] += rotation[real + k] * x[real + pairs + k]
        dx[real + pairs + k] -= rotation[real + k] * x[real + k]


@kernel
def _add_scaled(b, u, dx):
    for k in range(dx.size):
        dx[k] += b[k] * u


@kernel
def _dot(c, x):
    """c x with four running sums: one alone waits for each addition in turn."""
    f0, f1, f2, f3 = 0.0, 0.0, 0.0, 0.0
    fours = x.size - x.size % 4
    for k in range(0, fours, 4):
        f0 += c[k] * x[k]
        f1 += c[k + 1] * x[k + 1]
        f2 += c[k + 2] * x[k + 2]
        f3 += c[k + 3] * x[k + 3]
    for k in range(fours, x.size):
        f0 += c[k] * x[k]
    return (f0 + f1) + (f2 + f3)


@kernel
def push(history, t, v):
    """Append the accepted node (t, v); the oldest node makes room when the ring is full."""
    capacity = history.time.size
    head = history.pushed[0] % capacity
    history.time[head] = t
    for i in range(v.size):
        history.velocity[head, i] = v[i]
    history.pushed[0] += 1


@kernel
def _subtract_product(lag, v, weight, p, force):
    """force -= weight * K(lag) v, with K linear between the entries of its table."""
    position = lag / p.step
    k = min(int(position), p.K.shape[0] - 2)
    upper = weight * (position - k)
    lower = weight - upper
    for e in range(p.row.size):
        force[p.row[e]] -= (lower * p.K[k, e] + upper * p.K[k + 1, e]) * v[p.column[e]]


@kernel
def radiation_memory(t, v, history, p, force):
    """Subtract int K(t - s) v(s) ds from ``force``: trapezoids over the nodes and (t, v).

    The integral runs from the first node (v = 0 before it) or from the end of the table of K to
    the current point, which may be a stage between steps; nodes after t are ignored. The error is
    of order 2 in the spacing of the nodes and in the step of K's table. A ring too small for the
    memory cuts it off at its oldest node: see `velocity_history`.

    v, force: all DOFs of the scene; history: `VelocityHistory`; p: `ConvolutionKernel`.
    """
    if p.row.size == 0:
        return
    capacity = history.time.size
    count = history.pushed[0]
    length = (p.K.shape[0] - 1) * p.step
    lag, u, weight = 0.0, v, 0.0  # of the point whose later trapezoid is in the weight
    for i in range(count - 1, max(count - capacity, 0) - 1, -1):
        node = i % capacity
        older_lag = t - history.time[node]
        if older_lag < 0.0:
            continue
        older_u = history.velocity[node]
        half = 0.5 * (min(older_lag, length) - lag)
        _subtract_product(lag, u, weight + half, p, force)
        if older_lag >= length:
            # the velocity where the table ends is on the line between the two nodes
            part = (length - lag) / (older_lag - lag)
            _subtract_product(length, u, half * (1.0 - part), p, force)
            _subtract_product(length, older_u, half * part, p, force)
            return
        lag, u, weight = older_lag, older_u, half
    _subtract_product(lag, u, weight, p, force)
