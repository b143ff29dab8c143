"""The six degrees of freedom of a rigid body: names, order, and what a mirror does to them."""

from __future__ import annotations

import numpy as np

DOFS = ("surge", "sway", "heave", "roll", "pitch", "yaw")

MIRROR_SIGN = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
"""+1 where a mirror image in y = 0 keeps the sign of a load or motion: surge, heave, pitch."""


def about_z(heading: float) -> np.ndarray:
    """Rz(heading), (3, 3): turns translations, or rotations, by heading axes into the earth's."""
    c, s = np.cos(heading), np.sin(heading)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
