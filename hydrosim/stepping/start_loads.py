"""Forces of elements on their bodies at the start of a run: pretensions of lines."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hydrosim.stepping.dynamics import Model, new_work, rhs

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hydrosim.scene import Scene
    from hydrosim.stepping.state import State


def start_loads(
    scene: Scene, model: Model, state: State, rows: Sequence[str], time: float
) -> dict[str, float]:
    """Magnitudes of the forces of all elements on their bodies [N], by name, in a ``state`` at a
    ``time`` [s]; ``rows`` are the names of the rows of forces."""
    work = new_work(model)
    rates = np.empty(state.y.size)
    rhs(time, state.y, state.modes, state.history, model, work, rates)
    first = {body.name: 6 * b for b, body in enumerate(scene.bodies)}
    forces = {}
    for name, element in scene.forces.items():
        own = work.wrench[rows.index(name), first[element.body] :][:3]
        forces[name] = float(np.linalg.norm(own))
    return forces
