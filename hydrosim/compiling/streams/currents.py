"""The current that each body feels: the mean over its draught at rest."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from hydrosim.scene import Body, Scene
from hydrosim.streams.current import current_on_hull, current_table


def draught_of(body: Body) -> float | None:
    """Draught [m] of a body at rest: its own, or that of its hull; None if unknown."""
    if body.draught is not None or body.hydrostatics is None:
        return body.draught
    lowest = -float(body.hydrostatics.corners[..., 2].min())
    return lowest if lowest > 0.0 else None


def currents_on(scene: Scene, wet: Collection[str]) -> np.ndarray:
    """Velocity (nb, 2) [m/s] of the current on the bodies that are ``wet``, which move water; 0 for
    others. Raises InputError if it varies and the draught of one of them is unknown."""
    table = current_table(scene.environment)
    found = np.zeros((len(scene.bodies), 2))
    for b, body in enumerate(scene.bodies):
        if body.name in wet:
            found[b] = current_on_hull(table, draught_of(body), body.name)
    return found
