"""Velocity history of a convolution in the dataset of a run, see
`hydrosim.water.radiation.history`.

The stored history ends at the last step but one. A continued run computes the node at its start
anew.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hydrosim.integrate.names import memory_names
from hydrosim.water.radiation.history import NOW, THEN, push

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.integrate.dynamics import Model
    from hydrosim.scene import Scene
    from hydrosim.water.radiation.history import VelocityHistory

HISTORY_ROWS = ("double integral", "integral", "velocity before", "velocity")
NODE = ("double integral", "integral", "velocity", "acceleration")
MIN_NODE_DISTANCE = (
    1e-6  # of a step of the grid: smaller distances from a point of the grid count as zero
)

MEMORY_PREFIX = "memory_"
"""Begins the names of all that a run keeps of a convolution."""


def encode_history(
    scene: Scene, model: Model, history: VelocityHistory
) -> tuple[dict[str, tuple[tuple[str, ...], np.ndarray]], dict[str, object]]:
    """Points of the grid, oldest first, and the node, with their dimensions and coordinates. Empty
    without a convolution. Before the first point integrals are zero until they are counted anew;
    then those points are kept too."""
    if not history.time[THEN] < np.inf:
        return {}, {}
    dofs, newest = np.unique(model.convolution.column), history.place[2]
    first = history.place[0] + history.place[1] - newest
    oldest = newest + 1 - (history.grid.shape[2] - first)
    if history.place[3] == 0:
        oldest = max(oldest, 0)
    points = np.arange(oldest, newest + 1)
    time = history.begin[0] + points * history.step
    coords: dict[str, object] = {
        "memory_row": ("memory_row", list(HISTORY_ROWS), {"long_name": "remembered quantity"}),
        "memory_dof": ("memory_dof", memory_names(scene, model), {"long_name": "coordinate"}),
        "memory_time": ("memory_time", time, {"units": "s", "long_name": "time"}),
        "memory_node_row": ("memory_node_row", list(NODE), {"long_name": "remembered quantity"}),
        "memory_node_time": ((), history.time[THEN], {"units": "s", "long_name": "time"}),
        "memory_begin": ((), history.begin[0], {"units": "s", "long_name": "time of point 0"}),
        "memory_origin": (
            (),
            history.place[3],
            {"long_name": "index of the point at which integrals begin"},
        ),
    }
    past = history.grid[:, dofs][:, :, first + newest - points]
    node = history.node[THEN][:, dofs]
    about = ("memory_row", "memory_dof", "memory_time")
    return {
        "memory_past": (about, past),
        "memory_node": (("memory_node_row", about[1]), node),
    }, coords


def take_over(run: xr.Dataset, dofs: np.ndarray, history: VelocityHistory) -> bool:
    """Fill the empty ``history`` with the history of ``run`` for these ``dofs``, in its order.
    Returns False and changes nothing if the grids differ."""
    time = run.memory_time.values
    begin, step = float(run.memory_begin), history.step
    points = np.rint((time - begin) / step).astype(int)
    if np.any(time != begin + points * step):
        return False
    newest = points[-1]
    columns = history.place[0] + newest - points
    inside = columns < history.grid.shape[2]
    history.grid[:, dofs[:, None], columns[inside]] = run.memory_past.values[:, :, inside]
    history.begin[0], history.place[1:] = begin, (newest, newest, int(run.memory_origin))
    history.time[NOW] = float(run.memory_node_time)
    history.node[NOW][:, dofs] = run.memory_node.values
    return True


def push_again(run: xr.Dataset, until: float, dofs: np.ndarray, history: VelocityHistory) -> None:
    """Fill the empty ``history`` with the history of ``run`` before the time ``until`` [s]: cubics
    between the points of its grid."""
    time, past = run.memory_time.values, run.memory_past.values
    count = int(np.searchsorted(time, until - MIN_NODE_DISTANCE * history.step))
    starts, ends = _accelerations(time[:count], past[:, :, :count])
    v, a = np.zeros((2, history.node.shape[2]))
    for i in range(count):
        for velocity, acceleration in ((past[2, :, i], ends[:, i]), (past[3, :, i], starts[:, i])):
            v[dofs], a[dofs] = velocity, acceleration
            push(history, time[i], v, a)


def _accelerations(time: np.ndarray, past: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Accelerations (dofs, points) after and before each point. They are third derivatives at both
    ends of the polynomials of degree 5 through the double integral; zero before the first point."""
    h, (Y, X) = np.diff(time), past[:2]
    rise, v0, v1 = 60.0 * np.diff(Y), past[3, :, :-1] * h * h, past[2, :, 1:] * h * h
    X0, X1 = X[:, :-1] * h, X[:, 1:] * h
    after = (rise - 36.0 * X0 - 24.0 * X1 - 9.0 * v0 + 3.0 * v1) / h**3
    before = (rise - 24.0 * X0 - 36.0 * X1 - 3.0 * v0 + 9.0 * v1) / h**3
    edge = np.zeros((len(Y), 1))
    return np.hstack([after, before[:, -1:] if h.size else edge]), np.hstack([edge, before])
