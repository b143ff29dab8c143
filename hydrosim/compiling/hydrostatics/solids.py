"""Closed meshes as `Solids`: groups of neighbouring triangles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hydrosim.database.hull import Triangles, areas
from hydrosim.rigid.solids import MOMENTS, Solids

# projected horizontal area over area of a triangle, below which it counts as upright
MIN_WATERPLANE_FRACTION = 1e-12
PARCEL = 16  # triangles of a group at most
HEIGHT_WEIGHT = (
    4.0  # weight of height in the split: triangles at one height get wet at the same time
)


def solids_of(meshes: Sequence[Triangles]) -> Solids:
    """Constants of closed meshes."""
    parcels = [_parcels(_faces(corners)) for corners in meshes]
    parts = [part for own in parcels for part in own]
    every = np.concatenate([np.zeros((0, 3, 3)), *parts])
    return Solids(
        first=np.cumsum([0, *map(len, parcels)]).astype(np.int64),
        begin=np.cumsum([0, *map(len, parts)]).astype(np.int64),
        box=np.reshape([_box(part) for part in parts], (-1, 2, 3)),
        moments=np.array([_moments(part) for part in parts], dtype=MOMENTS),
        corners=every,
        area=np.ascontiguousarray(areas(every)[:, 2]),
    )


def _faces(corners: Triangles) -> Triangles:
    """Triangles that are not upright."""
    vectors = areas(corners)
    return corners[
        np.abs(vectors[:, 2]) > MIN_WATERPLANE_FRACTION * np.linalg.norm(vectors, axis=1)
    ]


def _parcels(corners: np.ndarray) -> list[np.ndarray]:
    """Groups of a few neighbouring triangles (nt, 3, 3)."""
    middles, size = corners.mean(axis=1), np.ptp(corners, axis=(0, 1))
    return [corners[rows] for rows in _split_in_groups(middles / size * [1.0, 1.0, HEIGHT_WEIGHT])]


def _split_in_groups(middles: np.ndarray) -> list[np.ndarray]:
    """Indices of points (n, 3), halved along their longest side until groups are small."""
    rows = np.arange(len(middles))
    if rows.size <= PARCEL:
        return [rows]
    order = np.argsort(middles[:, np.ptp(middles, axis=0).argmax()], kind="stable")
    halves = np.array_split(order, 2)
    return [half[own] for half in halves for own in _split_in_groups(middles[half])]


def _box(corners: np.ndarray) -> np.ndarray:
    """Centre of the bounding box of triangles, and its half sides, (2, 3)."""
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    return np.array([(low + high) / 2.0, (high - low) / 2.0])


def _moments(corners: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """`MOMENTS` of triangles. Midpoints of edges integrate quadratic functions exactly."""
    A, points = areas(corners)[:, 2], (corners + np.roll(corners, -1, axis=1)) / 2.0
    second = np.einsum("k,kpi,kpj->ij", A / 3.0, points, points)
    return float(A.sum()), A @ corners.mean(axis=1), second
