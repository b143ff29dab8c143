"""Arrays for the kernels in `memory`, made from fits and coefficients."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np

from hydrosim.radiation.memory import AT_ONCE, ConstantDamping, RadiationStates

if TYPE_CHECKING:
    from hydrosim.radiation.state_space import StateSpace


def _offsets(sizes: Sequence[int]) -> np.ndarray:
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)


def _joined(parts: list[np.ndarray], dtype: type = np.float64) -> np.ndarray:
    return np.concatenate([np.empty(0, dtype), *(np.ravel(part) for part in parts)]).astype(dtype)


def _filled_up(rows: np.ndarray, mode: Literal["edge", "constant"]) -> np.ndarray:
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
    dofs = [_filled_up(group.dofs, "edge") for group in groups]
    B = [_filled_up(group.B.T, "constant") for group in groups]
    return RadiationStates(
        state=_offsets([group.B.shape[0] for group in groups]),
        member=_offsets([of_group.size for of_group in dofs]),
        matrix=_offsets([of_group.size for of_group in B])[:-1],
        real=np.array([group.real for group in groups], dtype=np.int64),
        dof=_joined(dofs, np.int64),
        decay=_joined([np.diag(group.matrix) for group in groups]),
        rotation=_joined(
            [
                np.append(group.frequency, np.zeros(n))
                for group, n in zip(groups, pairs, strict=True)
            ]
        ),
        B=_joined(B),
        C=_joined([_filled_up(group.C, "constant") for group in groups]),
    )


def input_rates(states: RadiationStates) -> np.ndarray:
    """B summed over the DOFs, (states,): the rate of every state if all DOFs have a unit
    velocity."""
    sizes = zip(states.matrix, np.diff(states.member), np.diff(states.state), strict=True)
    return _joined([states.B[at:][: m * n].reshape(m, n).sum(axis=0) for at, m, n in sizes])


def constant_damping(damping: np.ndarray) -> ConstantDamping:
    """B (n, n) on all DOFs of the scene for `radiation_damping`; B = 0 costs nothing."""
    row, column = np.nonzero(damping)
    return ConstantDamping(
        damping[row, column].astype(np.float64), row.astype(np.int64), column.astype(np.int64)
    )
