"""Closed hulls of plane triangles: reading of mesh files, and hydrostatics at rest.

Frame: the database's, z up from the still water. By Gauss's theorem, integrals over the volume
below the water are integrals over the wetted triangles with the vertical part of their normal. The
midpoints of a triangle's edges integrate quadratic functions exactly.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from hydrosim.errors import InputError
from hydrosim.files.quantities import MeshKeys
from hydrosim.scene import Hull

# `Hydrostatics`: integrals over the submerged hull, and stiffness.


@dataclass(frozen=True)
class Hydrostatics:
    """Integrals over the hull [m]: waterplane area, its first and second moments about the axes of
    the frame, the volume, and the centre of buoyancy (3,)."""

    area: float
    moment_x: float
    second_xx: float
    second_yy: float
    volume: float
    centre_of_buoyancy: np.ndarray
    moment_y: float = 0.0
    second_xy: float = 0.0

    def stiffness(self, height: float, density: float, gravity: float) -> np.ndarray:
        """Stiffness (6, 6) about a centre of gravity at ``height`` [m] above the centre of
        buoyancy, for weight equal to buoyancy (Newman 1977, Marine Hydrodynamics, chapter 6)."""
        x, y, z = self.centre_of_buoyancy
        lever = self.volume * (z - height)
        C = np.zeros((6, 6))
        C[2, 2] = self.area
        C[2, 3] = C[3, 2] = self.moment_y - self.area * y
        C[2, 4] = C[4, 2] = self.area * x - self.moment_x
        C[3, 3] = self.second_yy - 2 * y * self.moment_y + y**2 * self.area + lever
        C[3, 4] = C[4, 3] = (
            x * self.moment_y + y * self.moment_x - self.second_xy - x * y * self.area
        )
        C[4, 4] = self.second_xx - 2 * x * self.moment_x + x**2 * self.area + lever
        return density * gravity * C


Triangles = np.ndarray  # (nt, 3 corners, 3 coordinates), normals into the water

OPEN_FRACTION = 1e-6  # of the area and of the volume: rounding of the file of a closed hull
WATERPLANE_ROUNDING = 1e-9  # of the volume to 2/3: area of a waterplane that is only rounding


def read_hull(path: Path, keys: MeshKeys = MeshKeys()) -> Hull:
    """Closed hull in a mesh file of any format that meshio reads; the ``keys`` place it. Raises
    `InputError` if it cannot be read, is open, or does not cross the water surface."""
    return close_hull(keys.to_database_frame(_read_triangles(path)), str(path))


def read_closed(path: Path, keys: MeshKeys = MeshKeys()) -> Triangles:
    """The triangles of any closed mesh file, as `read_hull` reads it."""
    return with_outward_normals(keys.to_database_frame(_read_triangles(path)), str(path))


def close_hull(corners: Triangles, source: str) -> Hull:
    """Hull with normals outward. Raises `InputError` if it is open, or if no part of it is below or
    above the water."""
    triangles = with_outward_normals(corners, source)
    low = corners[..., 2].min()
    high = corners[..., 2].max()
    if not low < 0.0 < high:
        raise InputError(
            f"{source}: found a hull from {low:.4g} to {high:.4g} m above the still water;"
            " expected a hull that crosses the water surface. Correct waterline, scale, axes,"
            " offset or depth. A load that starts in air is lifted by initial.position, not by its"
            " mesh."
        )
    return Hull(triangles, source)


def with_outward_normals(corners: Triangles, source: str) -> Triangles:
    """Closed mesh with normals outward. If it has no holes and consistent normals, its area vectors
    add up to zero, and its volumes by x, y and z are equal. Otherwise `InputError` is raised."""
    area = areas(corners)
    volumes = np.sum(area * corners.mean(axis=1), axis=0)
    open_by = np.abs(area.sum(axis=0)).max() / np.abs(area).sum()
    if open_by > OPEN_FRACTION or np.ptp(volumes) > OPEN_FRACTION * np.abs(volumes).max():
        volumes_text = ", ".join(f"{volume:.6g}" for volume in volumes)
        raise InputError(
            f"{source}: found an open mesh: the sum of its area vectors is {open_by:.1e} of its"
            f" area, and its volumes by x, y and z are {volumes_text} m^3; expected zero and equal"
            " volumes. Close the mesh, with a deck or lid, and turn all normals outward. A mesh"
            " that ends at the waterline has no shape above it."
        )
    return corners if volumes[2] > 0 else corners[:, ::-1]


def integrals(corners: Triangles) -> Hydrostatics:
    """Hydrostatics of a hull with these triangles below the water."""
    weight = areas(corners)[:, 2] / 3
    x, y, z = np.moveaxis((corners + np.roll(corners, -1, axis=1)) / 2, -1, 0)

    def surface_integral(f: np.ndarray) -> float:
        return float(np.sum(weight @ f))

    volume = surface_integral(z)
    moments = [surface_integral(x * z), surface_integral(y * z), surface_integral(z * z) / 2]
    waterplane = {
        "area": -surface_integral(np.ones_like(x)),
        "moment_x": -surface_integral(x),
        "moment_y": -surface_integral(y),
        "second_xx": -surface_integral(x * x),
        "second_yy": -surface_integral(y * y),
        "second_xy": -surface_integral(x * y),
    }
    if abs(waterplane["area"]) < WATERPLANE_ROUNDING * abs(volume) ** (2 / 3):
        waterplane = dict.fromkeys(waterplane, 0.0)
    return Hydrostatics(volume=volume, centre_of_buoyancy=np.array(moments) / volume, **waterplane)


def immersed_triangles(corners: Triangles) -> Triangles:
    """Parts of the triangles below z = 0."""
    wet = (corners[..., 2] < 0.0).sum(axis=1)
    cut = [
        part
        for triangle in corners[(wet == 1) | (wet == 2)]
        for part in _cut_at_waterline(triangle)
    ]
    return np.concatenate([corners[wet == 3], np.reshape(cut, (-1, 3, 3))])


def areas(corners: Triangles) -> np.ndarray:
    """Area vectors (nt, 3) of triangles."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2


def triangles_of(panels: np.ndarray) -> Triangles:
    """The halves (2 n, 3, 3) of panels (n, 4, 3)."""
    return np.concatenate([panels[:, [0, 1, 2]], panels[:, [0, 2, 3]]])


def _cut_at_waterline(triangle: np.ndarray) -> list[np.ndarray]:
    """One or two triangles for the part below z = 0 of a triangle that crosses it."""
    below = triangle[:, 2] < 0.0
    lone = int(np.flatnonzero(below if below.sum() == 1 else ~below)[0])
    a, b, c = np.roll(triangle, -lone, axis=0)
    ab, ac = (a + (x - a) * a[2] / (a[2] - x[2]) for x in (b, c))
    if below[lone]:
        return [np.array([a, ab, ac])]
    return [np.array([ab, b, c]), np.array([ab, c, ac])]


def read_quietly(read: Callable[[Path], Any], path: Path, formats: str) -> Any:
    """Mesh from a library's reader. Readers of many formats raise exceptions of many types; meshio
    prints messages and ends the program. This function turns all of that into one InputError."""
    output = StringIO()
    try:
        with redirect_stdout(output), redirect_stderr(output), np.errstate(all="ignore"):
            return read(path)
    except (Exception, SystemExit) as error:
        reason = error if isinstance(error, Exception) else " ".join(output.getvalue().split())
        raise InputError(
            f"{path}: cannot be read as a mesh ({reason}); expected a file that {formats}. Check"
            " that its suffix names its format, or export the mesh again."
        ) from error


def _read_triangles(path: Path) -> Triangles:
    if not os.path.isfile(path):
        raise InputError(f"{path}: no such file; expected the mesh of a closed hull.")
    parts = read_quietly(_split_parts, path, "meshio knows, such as .stl, .obj, .ply or .msh")
    if not parts or not np.isfinite(np.concatenate(parts)).all():
        raise InputError(
            f"{path}: found no triangles or quadrilaterals, or coordinates that are not finite"
            " numbers; expected the surface of a closed hull. Export the mesh again."
        )
    return np.concatenate(parts).astype(float)


def _split_parts(path: Path) -> list[Triangles]:
    import meshio  # slow to load, and few scenes need it

    mesh = meshio.read(path)
    kinds = {"triangle": [[0, 1, 2]], "quad": [[0, 1, 2], [0, 2, 3]]}
    return [
        mesh.points[block.data[:, corners]]
        for block in mesh.cells
        for corners in kinds.get(block.type, [])
    ]
