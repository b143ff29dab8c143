"""The force of the radiated waves by extra states, or by constant coefficients.

`radiation_states` integrates a rational fit of the retardation functions. Its force is the memory
integral -int_0^t K(t - s) v(s) ds (Cummins 1962). `convolution` evaluates that integral directly.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from hydrosim.jit.kernels import kernel, summing

if TYPE_CHECKING:
    from hydrosim.water.radiation.state_space import StateSpace

# Products along the memory.


@summing
def dot(a, b):
    """a b."""
    total = 0.0
    for k in range(a.size):
        total += a[k] * b[k]
    return total


@summing
def dot_three(a, b):
    """Products of the three rows of ``a``, which follow each other, and b."""
    n = b.size
    first, second, third = 0.0, 0.0, 0.0
    for k in range(n):
        first += a[k] * b[k]
        second += a[n + k] * b[k]
        third += a[2 * n + k] * b[k]
    return first, second, third


AT_ONCE = 3
"""Number of DOFs of a group that are read together, in one pass along its states."""


class RadiationStates(NamedTuple):
    """State-space models of all groups of coupled DOFs, flattened; see `state_space_model`.

    Group g owns the states ``state[g]:state[g+1]``, in the order of `StateSpace`: ``real[g]`` real
    poles, then the first states of all pairs, then their second states. It couples the DOFs
    ``dof[member[g]:member[g+1]]``. Its B and C are (m, states) and row-major from ``matrix[g]``. If
    one more DOF completes a multiple of `AT_ONCE`, the last is repeated, with zeros in B and C.
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


class ConstantDamping(NamedTuple):
    """Radiation damping at one frequency, with the non-zero entries only: ``B[e]`` is the force on
    DOF ``row[e]`` per velocity of DOF ``column[e]``."""

    B: np.ndarray  # (entries,) [N s/m, N s, N m s]
    row: np.ndarray  # (entries,) int64
    column: np.ndarray  # (entries,) int64


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
        end = p.member[g + 1]
        for j in range(p.member[g], end - AT_ONCE + 1, AT_ONCE):
            d = (p.dof[j], p.dof[j + 1], p.dof[j + 2])
            felt = dot_three(p.C[row:], own_x)
            _drive_by_three(p.B[row:], (v[d[0]], v[d[1]], v[d[2]]), own_dx)
            for i in range(AT_ONCE):
                force[d[i]] -= felt[i]
            row += AT_ONCE * own_x.size
        if (end - p.member[g]) % AT_ONCE == 1:
            d = p.dof[end - 1]
            force[d] -= dot(p.C[row : row + own_x.size], own_x)
            _drive(p.B[row:], v[d], own_dx)


@summing
def _decay_and_rotate(x, decay, rotation, real, dx):
    """dx = Lambda x of one group; contiguous loops without branches, so that they vectorise."""
    for k in range(real):
        dx[k] = decay[k] * x[k]
    pairs = (x.size - real) // 2
    first, second = x[real : real + pairs], x[real + pairs :]
    d_first, d_second = dx[real : real + pairs], dx[real + pairs :]
    a, b = decay[real:], rotation[real:]
    for k in range(pairs):
        d_first[k] = a[k] * first[k] + b[k] * second[k]
        d_second[k] = a[k] * second[k] - b[k] * first[k]


@summing
def _drive(b, u, dx):
    for k in range(dx.size):
        dx[k] += b[k] * u


@summing
def _drive_by_three(B, u, dx):
    """dx += u B for the three rows of B, which follow each other in memory."""
    n = dx.size
    for k in range(n):
        dx[k] += B[k] * u[0] + B[n + k] * u[1] + B[2 * n + k] * u[2]


@kernel
def radiation_damping(v, p, force):
    """Subtract B v from ``force``; v, force: all DOFs of the scene; p: `ConstantDamping`."""
    for e in range(p.row.size):
        force[p.row[e]] -= p.B[e] * v[p.column[e]]


# Arrays for the kernels in `memory`, made from fits and coefficients.


def _find_offsets(sizes: Sequence[int]) -> np.ndarray:
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)


def _join(parts: list[np.ndarray], dtype: type = np.float64) -> np.ndarray:
    return np.concatenate([np.empty(0, dtype), *(np.ravel(part) for part in parts)]).astype(dtype)


def _pad_rows(rows: np.ndarray, mode: Literal["edge", "constant"]) -> np.ndarray:
    """``rows`` plus one more, the last again or zeros, if that completes a multiple of
    `AT_ONCE`."""
    more = 1 if len(rows) % AT_ONCE == AT_ONCE - 1 else 0
    return np.pad(rows, [(0, more)] + [(0, 0)] * (rows.ndim - 1), mode)


def state_space_model(groups: Sequence[StateSpace]) -> RadiationStates:
    """All groups of all bodies as one set of arrays; their ``dofs`` index the scene's DOFs.

    The states of the model follow each other in the order of ``groups``. An empty list costs
    nothing in a run.
    """
    pairs = [group.decay.size - group.real for group in groups]
    dofs = [_pad_rows(group.dofs, "edge") for group in groups]
    B = [_pad_rows(group.B.T, "constant") for group in groups]
    return RadiationStates(
        state=_find_offsets([group.B.shape[0] for group in groups]),
        member=_find_offsets([of_group.size for of_group in dofs]),
        matrix=_find_offsets([of_group.size for of_group in B])[:-1],
        real=np.array([group.real for group in groups], dtype=np.int64),
        dof=_join(dofs, np.int64),
        decay=_join([np.diag(group.matrix) for group in groups]),
        rotation=_join(
            [
                np.append(group.frequency, np.zeros(n))
                for group, n in zip(groups, pairs, strict=True)
            ]
        ),
        B=_join(B),
        C=_join([_pad_rows(group.C, "constant") for group in groups]),
    )


def input_rates(states: RadiationStates) -> np.ndarray:
    """B summed over the DOFs, (states,): the rate of every state if all DOFs have a unit
    velocity."""
    sizes = zip(states.matrix, np.diff(states.member), np.diff(states.state), strict=True)
    return _join([states.B[at:][: m * n].reshape(m, n).sum(axis=0) for at, m, n in sizes])


def constant_damping(damping: np.ndarray) -> ConstantDamping:
    """B (n, n) on all DOFs of the scene for `radiation_damping`; B = 0 costs nothing."""
    row, column = np.nonzero(damping)
    return ConstantDamping(
        damping[row, column].astype(np.float64), row.astype(np.int64), column.astype(np.int64)
    )
