"""Parametric hulls, a launch barge and a sphere: hydrostatics and panels.

A launch barge: plane faces, vertical sides, raked ends.

Frame: x forward from the stern, y to port, z up from the waterline. The hull is symmetric about y =
0. Half-breadth and bottom are piecewise linear in x, so every face is plane and the hydrostatic
integrals are exact.

A sphere with its centre on the waterline: hydrostatics and panels of the lower half.

Frame: the origin is the centre, x forward, y to port, z up. Panels lie between meridians and
circles of latitude. They shrink towards the waterline, because short waves decay with depth. Their
corners are slightly outside the sphere, so the panels enclose its volume.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from hydrosim.database.hull import Hydrostatics

Panels = np.ndarray  # (number of panels, 4 corners, 3 coordinates)


@dataclass(frozen=True)
class Barge:
    """Main dimensions [m].

    The beam is full over ``stern_length`` from the stern and ``bow_beam`` over ``bow_length`` from
    the bow, with a linear taper between. Both ends are vertical down to ``wall_depth`` below the
    waterline and run from there to the keel over ``rake_length``.
    """

    length: float
    beam: float
    draught: float
    bow_beam: float
    bow_length: float
    stern_length: float
    wall_depth: float
    rake_length: float

    def half_breadth(self, x: np.ndarray) -> np.ndarray:
        """Half-breadth [m] at ``x`` [m], the same at all depths."""
        taper = [self.stern_length, self.length - self.bow_length]
        return np.interp(x, taper, [self.beam / 2, self.bow_beam / 2])

    def bottom(self, x: np.ndarray) -> np.ndarray:
        """Height of the bottom [m], negative, at ``x`` [m]."""
        corners = [0.0, self.rake_length, self.length - self.rake_length, self.length]
        wall = -self.wall_depth
        keel = -self.draught
        return np.interp(x, corners, [wall, keel, keel, wall])

    def corners(self) -> list[float]:
        """Stations [m] at which the breadth or the bottom has a corner, including both ends."""
        ends = [0.0, self.rake_length, self.length - self.rake_length, self.length]
        return sorted({*ends, self.stern_length, self.length - self.bow_length})


def hydrostatics(hull: Barge) -> Hydrostatics:
    """Closed form: Gauss's rule with four points is exact for the cubics between the corners."""
    nodes, weights = np.polynomial.legendre.leggauss(4)
    knots = np.array(hull.corners())
    half = np.diff(knots)[:, None] / 2
    x = ((knots[:-1] + knots[1:])[:, None] / 2 + half * nodes).ravel()
    dx = (half * weights).ravel()
    breadth = 2 * hull.half_breadth(x)
    depth = -hull.bottom(x)
    volume = np.sum(dx * breadth * depth)
    moments = [np.sum(dx * breadth * depth * x), 0.0, -np.sum(dx * breadth * depth**2 / 2)]
    return Hydrostatics(
        area=float(np.sum(dx * breadth)),
        moment_x=float(np.sum(dx * breadth * x)),
        second_xx=float(np.sum(dx * breadth * x**2)),
        second_yy=float(np.sum(dx * breadth**3 / 12)),
        volume=float(volume),
        centre_of_buoyancy=np.array(moments) / volume,
    )


@dataclass(frozen=True)
class Resolution:
    """Numbers of panels of the half hull. ``along`` is between the hull's corners, first and last
    on the rakes; ``across`` is over the half bottom; ``down`` is over the side. ``wall_across`` and
    ``wall_down`` are on each end wall. ``lid_along`` of the half lid is between the corners of the
    waterline."""

    along: tuple[int, ...] = (10, 8, 24, 17, 10)
    across: int = 9
    down: int = 7
    wall_across: int = 10
    wall_down: int = 4
    lid_along: tuple[int, ...] = (11, 24, 22)
    lid_across: int = 8


def half_hull(hull: Barge, mesh: Resolution) -> Panels:
    """Panels of the hull at y >= 0, normals into the water.

    Panels shrink towards the bilge, the keel and both edges of the rakes, where the flow turns
    round a corner. They also shrink towards the waterline, because short waves decay with depth.
    """
    x = _stations(hull, mesh)
    to_bilge = np.sin(np.linspace(0, np.pi / 2, mesh.across + 1))
    breadth = hull.half_breadth(x)
    bottom = hull.bottom(x)
    below = patch(x[:, None], breadth[:, None] * to_bilge, bottom[:, None])
    side = patch(x[:, None], breadth[:, None], bottom[:, None] * _cosine(mesh.down))
    across = np.linspace(0, 1, mesh.wall_across + 1)[:, None]
    down = np.linspace(-hull.wall_depth, 0, mesh.wall_down + 1)
    stern = patch(0.0, breadth[0] * across, down)
    bow = patch(hull.length, breadth[-1] * across, down)
    return np.concatenate([below[:, ::-1], side, stern[:, ::-1], bow])


def half_lid(hull: Barge, mesh: Resolution) -> Panels:
    """Panels of the waterplane inside the hull at y >= 0, normals down."""
    knots = [0.0, hull.stern_length, hull.length - hull.bow_length, hull.length]
    x = _concatenate_pieces(_uniform(knots, mesh.lid_along))
    across = np.linspace(0, 1, mesh.lid_across + 1)
    return patch(x[:, None], hull.half_breadth(x)[:, None] * across, 0.0)[:, ::-1]


def box(length: float, beam: float, draught: float) -> Barge:
    """A barge without taper and rakes; its corners only separate groups of panels."""
    third = length / 3
    end = min(length / 5, beam / 2)
    return Barge(length, beam, draught, beam, third, third, draught, end)


def resolution(hull: Barge, size: float) -> Resolution:
    """Numbers of panels for a largest size of about ``size`` [m]."""

    def count(span: float, finer: float = 1.0) -> int:
        return max(2, math.ceil(finer * span / size))

    spans = [b - a for a, b in pairwise(hull.corners())]
    taper = [0.0, hull.stern_length, hull.length - hull.bow_length, hull.length]
    across = count(hull.beam / 2, math.pi / 2)
    return Resolution(
        along=tuple(count(x, math.pi / 2 if i in (0, 4) else 1) for i, x in enumerate(spans)),
        across=across,
        down=count(hull.draught, math.pi / 2),
        wall_across=across,
        wall_down=count(hull.wall_depth, math.pi / 2),
        lid_along=tuple(count(b - a) for a, b in pairwise(taper)),
        lid_across=count(hull.beam / 2),
    )


def with_mirror_image(panels: Panels) -> Panels:
    """The panels and their mirror image in y = 0. The last corner of triangles is doubled there,
    too."""
    return np.concatenate([panels, panels[:, [1, 0, 3, 2]] * [1, -1, 1]])


def _stations(hull: Barge, mesh: Resolution) -> np.ndarray:
    pieces = _uniform(hull.corners(), mesh.along)
    pieces[0] = _cosine(mesh.along[0]) * hull.rake_length
    pieces[-1] = hull.length - hull.rake_length * _cosine(mesh.along[-1])[::-1]
    return _concatenate_pieces(pieces)


def _cosine(count: int) -> np.ndarray:
    """Values from 0 to 1 in ``count`` steps that are small at both ends."""
    return (1 - np.cos(np.linspace(0, np.pi, count + 1))) / 2


def _uniform(knots: Sequence[float], counts: Sequence[int]) -> list[np.ndarray]:
    spans = zip(pairwise(knots), counts, strict=True)
    return [np.linspace(a, b, count + 1) for (a, b), count in spans]


def _concatenate_pieces(pieces: list[np.ndarray]) -> np.ndarray:
    return np.concatenate([piece[:-1] for piece in pieces[:-1]] + [pieces[-1]])


def patch(x: np.ndarray | float, y: np.ndarray, z: np.ndarray | float) -> Panels:
    """Quadrilaterals (n, 4, 3) of a grid of points given by broadcast coordinates."""
    grid = np.stack(np.broadcast_arrays(x, y, z), axis=-1)
    rings = [grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]]
    return np.stack(rings, axis=2).reshape(-1, 4, 3)


def sphere_hydrostatics(radius: float) -> Hydrostatics:
    """Hydrostatics in closed form, of the half under water."""
    return Hydrostatics(
        area=math.pi * radius**2,
        moment_x=0.0,
        second_xx=math.pi * radius**4 / 4,
        second_yy=math.pi * radius**4 / 4,
        volume=2 * math.pi * radius**3 / 3,
        centre_of_buoyancy=np.array([0.0, 0.0, -3 * radius / 8]),
    )


def half_sphere(radius: float, size: float) -> Panels:
    """Panels (n, 4, 3) of the wetted hull at y >= 0, normals into the water, ``size`` [m] wide at
    the waterline. At the lowest point they are triangles with a doubled last corner."""
    polar, (x, y) = _circles(radius, size), _meridians(radius, size)
    r = radius * _corner_radius(polar, len(x) - 1)
    return _triangles_last(patch(x * r * np.sin(polar), y * r * np.sin(polar), -r * np.cos(polar)))


def sphere_lid(radius: float, size: float) -> Panels:
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
