"""A hull from a mesh file: reading, clipping at the waterline, symmetry, hydrostatics, lid."""

from __future__ import annotations

import os
from pathlib import Path

import capytaine as cpt
import numpy as np
import scipy

from hydrosim.database import hull
from hydrosim.database.build.barge import Panels
from hydrosim.database.build.bem import mesh_of
from hydrosim.database.hull import Hydrostatics
from hydrosim.errors import InputError
from hydrosim.files.quantities import MeshKeys

NO_PANELS: Panels = np.empty((0, 4, 3))
_MERGE_FRACTION = 1e-5  # of the hull's size: closer points are merged
EDGE_POINTS = 5  # points along the edge of a panel, by which gaps are measured
NEIGHBOUR_GAPS = 1.5  # times a gap: distance of the panels that are looked at
_INSIDE = 1e-3  # of a panel's size: depth of the point behind it
_CLOSED = 0.01  # largest relative difference of the volumes of a closed hull


def read_panels(path: Path, keys: MeshKeys) -> Panels:
    """Panels (n, 4, 3) below the waterline, with normals into the water, from a file in any format
    of Capytaine or meshio. The ``keys`` place the hull. Raises `InputError` if it is no closed
    hull."""
    panels = keys.to_database_frame(_read(path))
    if not (panels[..., 2] < 0).any():
        lowest = panels[..., 2].min() + keys.waterline
        raise InputError(
            f"{path}: found no panel below the water; the lowest point is at {lowest:g} m;"
            f" expected a hull that extends below {keys.waterline:g} m. Correct `waterline`,"
            " `scale`, `axes` or `offset`."
        )
    wet = panels_of(mesh_of(panels).immersed_part())
    below = wet[..., 2].min(axis=1) < -_MERGE_FRACTION * np.ptp(wet[..., 2])
    wet = wet[below]  # no panels in the waterplane
    return _with_outward_normals(wet, path)


def integrals(panels: Panels) -> Hydrostatics:
    """Hydrostatics of a whole hull, exact for plane panels."""
    return hull.integrals(hull.triangles_of(panels))


def is_symmetric(panels: Panels) -> bool:
    """Whether every panel has its mirror image in y = 0."""
    middles = centres(panels)
    apart, _ = scipy.spatial.cKDTree(middles).query(middles * [1, -1, 1])
    return bool(apart.max() < _MERGE_FRACTION * np.ptp(middles, axis=0).max())


def centres(panels: Panels) -> np.ndarray:
    """Centres (n, 3) of the panels."""
    return np.asarray(mesh_of(panels).faces_centers)


def inner_points(panels: Panels) -> np.ndarray:
    """Points (n, 3) just inside the hull, behind the centre of each panel."""
    made = mesh_of(panels)
    depth = _INSIDE * np.sqrt(made.faces_areas)[:, None]
    return np.asarray(made.faces_centers - depth * made.faces_normals)


def windings(panels: Panels, points: np.ndarray) -> np.ndarray:
    """How often the wetted hull and its image above the water wind around each of the ``points``
    (n, 3): 1 or -1 inside the hull, 0 outside. They are solid angles over 4 pi (van Oosterom and
    Strackee 1983)."""
    corners = hull.triangles_of(np.concatenate([panels, panels[:, ::-1] * [1, 1, -1]]))
    return np.array([_solid_angle(corners - point) for point in points]) / (4.0 * np.pi)


def _solid_angle(corners: np.ndarray) -> float:
    """Solid angle of triangles (nt, 3, 3) seen from the origin."""
    a, b, c = corners.transpose(1, 0, 2)
    la, lb, lc = np.linalg.norm(corners, axis=2).T
    ab, bc, ca = (np.einsum("ij,ij->i", *pair) for pair in ((a, b), (b, c), (c, a)))
    above = np.einsum("ij,ij->i", a, np.cross(b, c))
    return float(2.0 * np.arctan2(above, la * lb * lc + ab * lc + bc * la + ca * lb).sum())


def port_half(panels: Panels) -> Panels:
    """Panels at y >= 0; panels that cross the plane are cut."""
    return panels_of(mesh_of(panels).clipped(origin=(0, 0, 0), normal=(0, -1, 0)))


def lid_of(panels: Panels) -> Panels:
    """Capytaine's lid of a whole hull: squares inside its waterline."""
    return panels_of(mesh_of(panels).generate_lid())


def panels_of(mesh: cpt.Mesh) -> Panels:
    """Mesh as (n, 4, 3); the last corner of triangles is doubled."""
    return np.asarray(mesh.vertices[mesh.faces]) if mesh.nb_faces else NO_PANELS


def _read(path: Path) -> Panels:
    if not os.path.isfile(path):
        raise InputError(f"{path}: no such file; expected the mesh of a hull.")
    formats = "Capytaine or meshio knows, such as .gdf, .mar, .stl, .obj or .vtk"
    mesh = hull.read_quietly(cpt.load_mesh, path, formats)
    panels = panels_of(mesh.merged())
    if not len(panels) or not np.isfinite(panels).all():
        raise InputError(f"{path}: has no panels, or coordinates that are not numbers.")
    return panels


def _with_outward_normals(panels: Panels, path: Path) -> Panels:
    """Panels with normals into the water. The volumes by x, y and z are equal if the panels leave
    no holes and have consistent normals."""
    corners = hull.triangles_of(panels)
    volumes = np.sum(hull.areas(corners) * corners.mean(axis=1), axis=0)
    if np.ptp(volumes) > _CLOSED * np.abs(volumes).max():
        volumes_text = ", ".join(f"{volume:.4g}" for volume in volumes)
        raise InputError(
            f"{path}: the volumes by x, y and z are {volumes_text} m^3; expected equal values. The"
            " hull has holes below the water, or inconsistent normals."
        )
    return panels if volumes[2] > 0 else panels[:, ::-1]


def narrowest_gap(first: Panels, second: Panels) -> tuple[float, tuple[float, float]]:
    """Least distance [m] between points of the panels (n, 4, 3) of two hulls, and the longest edge
    [m] of the panels of each that are hardly farther from the other hull."""
    clouds = [_points_on(first), _points_on(second)]
    trees = [scipy.spatial.cKDTree(cloud.reshape(-1, 3)) for cloud in clouds]
    away = [trees[1].query(clouds[0])[0].min(axis=1), trees[0].query(clouds[1])[0].min(axis=1)]
    gap = float(away[0].min())
    edges = [np.linalg.norm(p - np.roll(p, 1, axis=1), axis=2).max(axis=1) for p in (first, second)]
    widest = [float(e[a <= NEIGHBOUR_GAPS * gap].max()) for e, a in zip(edges, away, strict=True)]
    return gap, (widest[0], widest[1])


def _points_on(panels: Panels) -> Panels:
    """A grid of points (n, m, 3) on each panel."""
    s, t = (x.ravel() for x in np.meshgrid(*2 * [np.linspace(0.0, 1.0, EDGE_POINTS)]))
    weights = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t], axis=1)
    return np.einsum("mk,nkd->nmd", weights, panels)
