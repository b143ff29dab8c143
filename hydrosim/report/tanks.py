"""Tanks in a replay: boxes on their bodies, filled to their level at each moment."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from hydrosim.report.envelopes import base64_of
from hydrosim.scene import Box, Scene, TankMesh
from hydrosim.scene.tanks import TankShape

TANKS_NOTE = (
    "Tanks are drawn as boxes, filled to their levels; hulls are translucent. A mesh tank is the"
    " box around it; tanks given by tables have no shape and are left out."
)


def tanks_of(frames: xr.Dataset, scene: Scene | None) -> dict[str, Any]:
    """Corners of tanks about the centres of gravity of their bodies, and the filled fractions of
    their heights (nt, nk)."""
    every = [(k, body) for k, body in enumerate(scene.bodies if scene else ()) if body.tanks]
    known = _levels(frames)
    drawn, full = [], []
    for number, body in every:
        for tank in body.tanks:
            if (ends := _ends(tank.shape)) is not None:
                low, high = ends - np.asarray(body.centre_of_gravity)
                drawn.append({"name": tank.name, "body": number, "low": [*low], "high": [*high]})
                still = np.full(frames.time.size, tank.level)
                level = known.get(f"{tank.name} of {body.name}", still)
                full.append(level / (high - low)[2])
    return {"tanks": drawn, "levels": base64_of(np.array(full).T.ravel())}


def _levels(frames: xr.Dataset) -> dict[str, np.ndarray]:
    """Levels (nt,) of the changing tanks."""
    if "tank_level" not in frames:
        return {}
    levels = frames.tank_level.transpose("tank", "time")
    return dict(zip(map(str, frames.tank.values), levels.values, strict=True))


def _ends(shape: TankShape) -> np.ndarray | None:
    """Lowest and highest corner (2, 3) of the box of a tank."""
    if isinstance(shape, Box):
        return np.array([shape.low, shape.high], float)
    if isinstance(shape, TankMesh):
        return np.array([shape.corners.min(axis=(0, 1)), shape.corners.max(axis=(0, 1))])
    return None
