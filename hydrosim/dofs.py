"""The six degrees of freedom of a rigid body: names, order, and what a mirror does to them."""

from __future__ import annotations

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
    each = loads.reshape(*loads.shape[:-1], -1, 3)
    return np.asarray((each @ about_z(heading).T).reshape(loads.shape))
