"""What the waves need to know of a body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrosim.scene import WaveForces
from hydrosim.waves.quadratic import QuadraticFunctions


@dataclass(frozen=True, eq=False)
class WaveBody:
    """A body in waves.

    ``database``: transfer functions of n loads, about the centre of gravity, for all headings;
    None for a dry body. ``location`` (2,): where the origin of the database's frame is at rest, in
    the earth's x, y [m]; ``centre`` (2,): where in that frame the centre of gravity is. ``offset``:
    index of the body's first DOF among those of the scene. ``active`` (n,): which DOFs are not
    locked.
    """

    database: QuadraticFunctions | None
    location: tuple[float, ...]
    wave_forces: WaveForces
    offset: int
    active: np.ndarray
    centre: tuple[float, ...] = (0.0, 0.0)
