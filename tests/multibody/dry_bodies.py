"""Dry bodies for the tests, and rigid-body formulas that do not come from hydrosim."""

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from hydrosim.multibody.kinematics import BODY, Bodies, Motion, new_motion, place_bodies
from hydrosim.scene import Body

INERTIA = np.array([[3.0, 0.2, -0.4], [0.2, 4.0, 0.3], [-0.4, 0.3, 6.0]])
SLENDER = np.array([[1.5, -0.1, 0.2], [-0.1, 5.0, 0.1], [0.2, 0.1, 4.2]])


def rotation(angles: np.ndarray) -> np.ndarray:
    """Rz(yaw) Ry(pitch) Rx(roll)."""
    return Rotation.from_euler("ZYX", angles[::-1]).as_matrix()


def rate_map(angles: np.ndarray) -> np.ndarray:
    """E: its columns are the axes about which roll, pitch and yaw turn, in the earth frame."""
    roll, pitch, yaw = np.eye(3)
    level, upright = rotation([0.0, angles[1], angles[2]]), rotation([0.0, 0.0, angles[2]])
    return np.column_stack([level @ roll, upright @ pitch, yaw])


def skew(w: np.ndarray) -> np.ndarray:
    """The matrix of w x."""
    return np.cross(np.eye(3), w)


def two_bodies(exact: bool = True) -> Bodies:
    """Two bodies, all coordinates free."""
    each = [(2.0, INERTIA, (1.0, -2.0, 0.5)), (3.0, SLENDER, (4.0, 1.0, -0.3))]
    return Bodies(np.array(each, dtype=BODY), np.arange(12), np.zeros(12), exact)


def placed(bodies: Bodies, q: np.ndarray, u: np.ndarray) -> Motion:
    """The motion at coordinates ``q`` and rates ``u``."""
    motion = new_motion(bodies)
    place_bodies(q, u, bodies, motion)
    return motion


def dry_body(**changes: Any) -> Body:
    """A small dry body with an inertia that is not diagonal."""
    return Body(**({"name": "body", "mass": 2.0, "inertia": INERTIA} | changes))
