"""The six degrees of freedom of a rigid body: names, order, and what a mirror does to them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

DOFS = ("surge", "sway", "heave", "roll", "pitch", "yaw")

MIRROR_SIGN = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
"""+1 where a mirror image in y = 0 keeps the sign of a load or motion: surge, heave, pitch."""
SYMMETRY_RTOL = 1e-6
"""Relative size below which a coefficient that symmetry makes zero counts as zero (tables of six
digits)."""


def about_z(heading: float) -> np.ndarray:
    """Rotation matrix Rz(heading), (3, 3): transforms vectors from heading axes to the earth's
    axes."""
    c = np.cos(heading)
    s = np.sin(heading)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def loads_about_z(loads: np.ndarray, heading: float) -> np.ndarray:
    """Loads (..., n) of heading axes in earth axes; n is a multiple of three (forces, moments)."""
    vectors = loads.reshape(*loads.shape[:-1], -1, 3)
    return np.asarray((vectors @ about_z(heading).T).reshape(loads.shape))


# Mirror images of elements in a vertical plane along x.

LATERAL = tuple(dof for dof, sign in zip(DOFS, MIRROR_SIGN, strict=True) if sign < 0.0)

Vector = Sequence[float] | np.ndarray


def mirrored_vector(vector: Vector) -> tuple[float, float, float]:
    """The mirror image of a position or a force (3,)."""
    x, y, z = np.asarray(vector) * MIRROR_SIGN[:3]
    return x, y, z


def foot_of_perpendicular(point: Vector, normal: Vector, y: float) -> tuple[float, float, float]:
    """The point (3,) [m] of a plane that is nearest to the origin, in axes whose origin is at
    (0, ``y``, 0). The plane has the ``normal`` and goes through ``point``, in the old axes."""
    n = np.array(normal, dtype=float)
    foot = n * (np.subtract(point, (0.0, y, 0.0)) @ n) / (n @ n)
    return foot[0], foot[1], foot[2]
