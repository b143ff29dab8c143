"""Impulses and works of forces, as variables of a run that records them (`Scene.output_impulses`).
All are integrals since the start of the run.

`impulse` and `work` (time, force, body, dof) have a row for each force. Their sums are the changes
of `momentum` (time, body, dof) and of `energy_kinetic`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.stepping.names import force_names

if TYPE_CHECKING:
    from hydrosim.forces.kind import RecordedStates
    from hydrosim.scene import Scene
    from hydrosim.stepping.dynamics import Model


def coordinates(scene: Scene) -> dict[str, object]:
    """Names of forces."""
    return {"force": ("force", list(force_names(scene)))} if scene.output_impulses else {}


def tallies(model: Model, y: RecordedStates, units: int) -> np.ndarray:
    """Further integrals (nt, units, k) of units, from the states y."""
    forces = 2 * model.rows * 6 * model.bodies.each.size
    return y[model.impulse + forces :].reshape(len(y), units, -1)


def impulse_variables(
    scene: Scene, model: Model, values: Mapping[str, np.ndarray]
) -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
    """Variables from the ``values`` (nt, ...) of a record by name."""
    if not scene.output_impulses:
        return {}
    integrals = values["y"][model.impulse :]
    count = len(integrals)
    each = model.rows * values["momentum"].shape[1]
    forces = integrals[:, : 2 * each].reshape(count, 2, model.rows, -1, 6)
    dims = ("time", "force", "body", "dof")
    return {
        "momentum": (("time", "body", "dof"), values["momentum"].reshape(count, -1, 6)),
        "impulse": (dims, forces[:, 0]),
        "work": (dims, forces[:, 1]),
    }
