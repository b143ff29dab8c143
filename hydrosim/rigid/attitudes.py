"""Differences of attitudes that are given as roll, pitch and yaw, for many times at once."""

from __future__ import annotations

import numpy as np


def rotation_vectors(ours: np.ndarray, theirs: np.ndarray) -> np.ndarray:
    """Rotation vectors (..., 3) [rad] from the attitudes ``theirs`` to ``ours``, both (..., 3) as
    roll, pitch and yaw. Axes are those of the earth, turned by the yaw of ``theirs``."""
    w, x, y, z = _product(_quaternions(ours), _conjugate(_quaternions(theirs)))
    size = np.sqrt(x * x + y * y + z * z)
    angle = 2.0 * np.arctan2(size, np.abs(w)) * np.where(w < 0.0, -1.0, 1.0)
    scale = np.divide(angle, size, out=np.full_like(size, 2.0), where=size > 0.0)
    c = np.cos(theirs[..., 2])
    s = np.sin(theirs[..., 2])
    return np.stack([scale * (c * x + s * y), scale * (c * y - s * x), scale * z], axis=-1)


def _quaternions(angles: np.ndarray) -> tuple[np.ndarray, ...]:
    """Unit quaternions (w, x, y, z) of roll, pitch and yaw (..., 3), intrinsic z, y', x''."""
    roll, pitch, yaw = np.moveaxis(0.5 * angles, -1, 0)
    zero = np.zeros_like(yaw)
    about_x = (np.cos(roll), np.sin(roll), zero, zero)
    about_y = (np.cos(pitch), zero, np.sin(pitch), zero)
    about_z = (np.cos(yaw), zero, zero, np.sin(yaw))
    return _product(about_z, _product(about_y, about_x))


def _conjugate(q: tuple[np.ndarray, ...]) -> tuple[np.ndarray, ...]:
    w, x, y, z = q
    return w, -x, -y, -z


def _product(p: tuple[np.ndarray, ...], q: tuple[np.ndarray, ...]) -> tuple[np.ndarray, ...]:
    a, b, c, d = p
    w, x, y, z = q
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )
