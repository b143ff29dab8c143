"""The error of motions of a run, relative to their range.

Positions and angles of a body are judged apart. Of positions it is the largest difference of the
three coordinates over their largest range. Of angles it is the largest component of the rotation
vector between both attitudes over the largest range of the three angles. Ranges are at least
those of `least_ranges`.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from hydrosim.scene import Solver
from hydrosim.studies.run.error_estimate import MIN_CHOSEN_RANGE, TOLERANCES_IN_RANGE

SMALLEST_RANGES = (1e-6, 1e-6)  # m, rad


def least_ranges(solver: Solver, accuracy: float | None) -> tuple[float, float]:
    """Least ranges of positions [m] and of angles [rad] of a run, as it states its own error. With
    an ``accuracy`` its method was chosen by the program."""
    if accuracy is not None:
        return MIN_CHOSEN_RANGE
    if not solver.method.adapts:
        return SMALLEST_RANGES
    asked = (solver.tolerance.position, solver.tolerance.angle)
    places, angles = (TOLERANCES_IN_RANGE * tolerance for tolerance in asked)
    return max(places, SMALLEST_RANGES[0]), max(angles, SMALLEST_RANGES[1])


def motion_errors(
    ours: np.ndarray,
    theirs: np.ndarray,
    exact: bool = True,
    least: tuple[float, float] = SMALLEST_RANGES,
) -> np.ndarray:
    """Errors (nt, nb) of ``ours`` against ``theirs``, both (nt, nb, 6) in m and rad as `position`
    is recorded. ``exact`` is false for small angles. ``least`` ranges are in m and rad."""
    ranges = np.ptp(theirs, axis=0).reshape(-1, 2, 3).max(axis=2)
    gaps = ours - theirs
    if exact:
        gaps = np.concatenate([gaps[..., :3], _rotation_vectors(ours, theirs)], axis=2)
    largest = np.abs(gaps).reshape(*gaps.shape[:2], 2, 3).max(axis=3)
    return np.asarray((largest / np.maximum(ranges, least)).max(axis=2))


def _rotation_vectors(ours: np.ndarray, theirs: np.ndarray) -> np.ndarray:
    """Rotation vectors (nt, nb, 3) from their attitudes to ours."""
    to_ours = _attitudes(ours) * _attitudes(theirs).inv()
    return np.asarray(to_ours.as_rotvec()).reshape(*ours.shape[:2], 3)


def _attitudes(position: np.ndarray) -> Rotation:
    """Attitudes (nt nb,) of roll, pitch and yaw, R = Rz(yaw) Ry(pitch) Rx(roll)."""
    return Rotation.from_euler("ZYX", position[..., :2:-1].reshape(-1, 3))
