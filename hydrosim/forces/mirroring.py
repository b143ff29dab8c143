"""Functions with which elements describe their mirror images in a vertical plane along x."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hydrosim.dofs import DOFS, MIRROR_SIGN

LATERAL = tuple(dof for dof, sign in zip(DOFS, MIRROR_SIGN, strict=True) if sign < 0.0)

Vector = Sequence[float] | np.ndarray


def mirrored_vector(vector: Vector) -> tuple[float, ...]:
    """The mirror image of a position or a force (3,)."""
    return tuple(np.asarray(vector) * MIRROR_SIGN[:3])


def foot_of_perpendicular(point: Vector, normal: Vector, y: float) -> tuple[float, ...]:
    """The point (3,) [m] of a plane that is nearest to the origin, in axes whose origin is at
    (0, ``y``, 0). The plane has the ``normal`` and goes through ``point``, in the old axes."""
    n = np.array(normal, dtype=float)
    return tuple(n * (np.subtract(point, (0.0, y, 0.0)) @ n) / (n @ n))
