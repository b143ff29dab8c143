"""From fits and tables of K to the arrays that the kernels in `memory` read."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hydrosim.radiation.memory import ConvolutionKernel, RadiationStates, VelocityHistory
from hydrosim.radiation.state_space import StateSpace, coupled_groups


def _offsets(sizes: Sequence[int]) -> np.ndarray:
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)


def _joined(parts: list[np.ndarray], dtype: type = np.float64) -> np.ndarray:
    return np.concatenate([np.empty(0, dtype), *(np.ravel(part) for part in parts)]).astype(dtype)


def state_space_model(groups: Sequence[StateSpace]) -> RadiationStates:
    """All groups of all bodies as one set of arrays; their ``dofs`` index the scene's DOFs.

    The states of the model follow each other in the order of ``groups``. No groups, no cost.
    """
    pairs = [group.decay.size - group.real for group in groups]
    return RadiationStates(
        state=_offsets([group.B.shape[0] for group in groups]),
        member=_offsets([group.dofs.size for group in groups]),
        matrix=_offsets([group.B.size for group in groups])[:-1],
        real=np.array([group.real for group in groups], dtype=np.int64),
        dof=_joined([group.dofs for group in groups], np.int64),
        decay=_joined([np.diag(group.matrix) for group in groups]),
        rotation=_joined(
            [
                np.append(group.frequency, np.zeros(n))
                for group, n in zip(groups, pairs, strict=True)
            ]
        ),
        B=_joined([group.B.T for group in groups]),
        C=_joined([group.C for group in groups]),
    )


def input_rates(states: RadiationStates) -> np.ndarray:
    """B summed over the DOFs, (states,): what a unit velocity of them all does to every state."""
    sizes = zip(states.matrix, np.diff(states.member), np.diff(states.state), strict=True)
    return _joined([states.B[at:][: m * n].reshape(m, n).sum(axis=0) for at, m, n in sizes])


def convolution_model(step: float, retardation: np.ndarray) -> ConvolutionKernel:
    """Table for the direct convolution from K (nt, n, n) at the lags 0, step, 2 step, ...

    n are all DOFs of the scene, six per body. The entries kept are those that a state-space model
    fits too, see `coupled_groups`; K = 0 throughout gives an empty table, which costs nothing.
    """
    kept = np.zeros(retardation.shape[1:], dtype=bool)
    for dofs in coupled_groups(retardation):
        kept[dofs[:, None], dofs] = True
    row, column = np.nonzero(kept)
    return ConvolutionKernel(
        step=float(step),
        K=np.ascontiguousarray(retardation[:, row, column], dtype=np.float64),
        row=row.astype(np.int64),
        column=column.astype(np.int64),
    )


def velocity_history(dofs: int, capacity: int) -> VelocityHistory:
    """An empty history of ``dofs`` velocities with room for ``capacity`` nodes.

    The memory is complete if ``capacity`` exceeds the kernel's length divided by the step, plus
    the nodes at events within that length.
    """
    return VelocityHistory(
        time=np.zeros(capacity),
        velocity=np.zeros((capacity, dofs)),
        pushed=np.zeros(1, dtype=np.int64),
    )
