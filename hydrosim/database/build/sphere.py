"""A sphere with its centre on the waterline: hydrostatics and panels of the lower half.

Frame: the origin is the centre, x forward, y to port, z up. Panels lie between meridians and
circles of latitude. They shrink towards the waterline, because short waves decay with depth. Their
corners are slightly outside the sphere, so the panels enclose its volume.
"""

from __future__ import annotations

import math

import numpy as np

from hydrosim.database.build.barge import Panels, patch
from hydrosim.database.hydrostatics import Hydrostatics


def hydrostatics(radius: float) -> Hydrostatics:
    """Hydrostatics in closed form, of the half under water."""
    return Hydrostatics(
        area=math.pi * radius**2,
        moment_x=0.0,
        second_xx=math.pi * radius**4 / 4,
        second_yy=math.pi * radius**4 / 4,
        volume=2 * math.pi * radius**3 / 3,
        centre_of_buoyancy=np.array([0.0, 0.0, -3 * radius / 8]),
    )


def half_hull(radius: float, size: float) -> Panels:
    """Panels (n, 4, 3) of the wetted hull at y >= 0, normals into the water, ``size`` [m] wide at
    the waterline. At the lowest point they are triangles with a doubled last corner."""
    polar, (x, y) = _circles(radius, size), _meridians(radius, size)
    r = radius * _corner_radius(polar, len(x) - 1)
    return _triangles_last(patch(x * r * np.sin(polar), y * r * np.sin(polar), -r * np.cos(polar)))


def half_lid(radius: float, size: float) -> Panels:
    """Panels (n, 4, 3) of the waterplane inside the hull at y >= 0, normals down."""
    polar, (x, y) = _circles(radius, size), _meridians(radius, size)
    edge = radius * _corner_radius(polar, len(x) - 1)
    r = np.linspace(0.0, edge, math.ceil(radius / size) + 1)
    return _triangles_last(patch(x * r, y * r, 0.0))


def _circles(radius: float, size: float) -> np.ndarray:
    """Angles [rad] from the lowest point to the circles of latitude."""
    count = max(2, math.ceil(math.pi / 2 * radius / size))
    return math.pi / 2 * np.sin(np.linspace(0.0, math.pi / 2, count + 1))


def _meridians(radius: float, size: float) -> tuple[np.ndarray, np.ndarray]:
    count = 2 * max(2, math.ceil(math.pi / 2 * radius / size))
    angle = np.linspace(0.0, math.pi, count + 1)[:, None]
    return np.cos(angle), np.sin(angle)


def _corner_radius(polar: np.ndarray, count: int) -> float:
    """Distance of the corners from the centre over the radius. Two circles of latitude bound a
    frustum whose ends are regular polygons with 2 ``count`` corners."""
    wide, deep = np.sin(polar), np.cos(polar)
    mean_square = (wide[1:] ** 2 + wide[1:] * wide[:-1] + wide[:-1] ** 2) / 3
    polygon = count * math.sin(math.pi / count)  # on the unit circle
    return float(np.cbrt(2 * math.pi / 3 / (polygon * np.sum(mean_square * -np.diff(deep)))))


def _triangles_last(panels: Panels) -> Panels:
    """Triangles with a doubled last corner, from a patch with a doubled first corner."""
    return np.roll(panels, -2, axis=1)
