"""The velocities that a convolution remembers: nodes at the accepted steps, with any spacing.

Between two nodes the velocity is the cubic with their velocities and accelerations. Where the
acceleration or the velocity jumps, at an event, there are two nodes at one time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import kernel

EVEN = 1e-9  # of a step: nodes this near to the grid are on it


class EvenNodes(NamedTuple):
    """The newest nodes that are one ``step`` apart, the newest first and by DOF, so that sums over
    them run along the memory. They are ``motion[:, :, first:first + count]``; nodes in between,
    at events, are not among them.
    """

    step: float  # [s]; 0 where steps are of any length
    motion: np.ndarray  # (2, dofs, room), velocities and accelerations
    node: np.ndarray  # (room,) int64, the newest node at that time, as counted in the history
    place: np.ndarray  # (2,) int64: first, count


class Memo(NamedTuple):
    """Integrals over the past that were asked for last; see `convolution`. They save time only."""

    node: np.ndarray  # (places,) int64, the newest node in each; -1 for nothing
    time: np.ndarray  # (places,) [s]
    past: np.ndarray  # (places, dofs)
    slope: np.ndarray  # (dofs,), scratch


class VelocityHistory(NamedTuple):
    """Velocities and accelerations at the accepted steps and events, a ring buffer.

    Node i (counted from the first one pushed) is at index i % capacity; ``pushed[0]`` nodes have
    been pushed. Times never decrease; two nodes at one time are the sides of a jump.
    """

    time: np.ndarray  # (capacity,) [s]
    velocity: np.ndarray  # (capacity, dofs)
    acceleration: np.ndarray  # (capacity, dofs)
    pushed: np.ndarray  # (1,) int64
    even: EvenNodes
    memo: Memo


def velocity_history(
    dofs: int, capacity: int, step: float = 0.0, even: int = 0, places: int = 1
) -> VelocityHistory:
    """An empty history of ``dofs`` velocities with room for ``capacity`` nodes.

    The memory is complete if ``capacity`` exceeds the kernel's length divided by the step, plus
    the nodes at events within that length. With ``step`` [s] the newest ``even`` nodes on that
    grid, or more, are kept apart for fast sums; there are ``places`` for integrals.
    """
    room = 2 * even + 1
    return VelocityHistory(
        time=np.zeros(capacity),
        velocity=np.zeros((capacity, dofs)),
        acceleration=np.zeros((capacity, dofs)),
        pushed=np.zeros(1, dtype=np.int64),
        even=EvenNodes(
            step,
            np.zeros((2, dofs, room)),
            np.zeros(room, dtype=np.int64),
            np.array([room, 0], dtype=np.int64),
        ),
        memo=Memo(
            np.full(places, -1, dtype=np.int64),
            np.zeros(places),
            np.zeros((places, dofs)),
            np.zeros(dofs),
        ),
    )


@kernel
def push(history, t, v, a):
    """Append the accepted node (t, v, a); the oldest makes room when the ring is full."""
    capacity = history.time.size
    number = history.pushed[0]
    head = number % capacity
    history.time[head] = t
    for i in range(v.size):
        history.velocity[head, i] = v[i]
        history.acceleration[head, i] = a[i]
    history.pushed[0] += 1
    if history.even.step > 0.0:
        _add_even(number, t, v, a, history)


@kernel
def drop(t, history):
    """Take away the newest node if it is at ``t``: says whether it was."""
    newest = history.pushed[0] - 1
    if newest < oldest_node(history) or history.time[newest % history.time.size] != t:
        return False
    history.pushed[0] = newest
    return True


@kernel
def _add_even(number, t, v, a, history):
    """Take the node among the even ones if it is on their grid or the second at its newest time; a
    node past the next place on the grid begins another grid."""
    even = history.even
    first, count = even.place[0], even.place[1]
    if count > 0:
        newest = history.time[even.node[first] % history.time.size]
        steps = (t - newest) / even.step
        if steps > 1.0 + EVEN:
            count = 0
        elif EVEN < steps < 1.0 - EVEN:
            return
        elif steps <= EVEN:  # the other side of a jump replaces the first
            first, count = first + 1, count - 1
    if first == 0:
        first = _move_to_end(count, even)
        count = min(count, even.node.size // 2)
    first -= 1
    for i in range(v.size):
        even.motion[0, i, first] = v[i]
        even.motion[1, i, first] = a[i]
    even.node[first] = number
    even.place[0], even.place[1] = first, count + 1


@kernel
def _move_to_end(count, even):
    """Make room in front of the newest half of the nodes; returns where they begin."""
    kept = min(count, even.node.size // 2)
    to = even.node.size - kept
    for k in range(kept - 1, -1, -1):
        even.node[to + k] = even.node[k]
        for i in range(even.motion.shape[1]):
            even.motion[0, i, to + k] = even.motion[0, i, k]
            even.motion[1, i, to + k] = even.motion[1, i, k]
    return to


@kernel
def node_before(t, history):
    """The newest node at a time before ``t``; one less than the oldest if there is none."""
    capacity = history.time.size
    node = history.pushed[0] - 1
    while node >= oldest_node(history) and history.time[node % capacity] >= t:
        node -= 1
    return node


@kernel
def oldest_node(history):
    """Number of the oldest node that is still there."""
    return max(history.pushed[0] - history.time.size, 0)
