"""Meshes of the point absorber: a float with a rod, and the spar below it with a plate at its foot.

python hydro_db/point_absorber.py
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
FLOAT = [(0.0, -4.5), (0.6, -4.5), (0.6, -2.0), (6.0, -2.0), (6.0, 1.5), (0.0, 1.5)]
SPAR = [(0.0, -30.0), (5.0, -30.0), (5.0, -29.0), (2.0, -29.0), (2.0, -5.0), (0.0, -5.0)]
Profile = Sequence[tuple[float, float]]


def refined(profile: Profile, size: float) -> Profile:
    """The ``profile`` of radius and height [m] with points no more than ``size`` apart, and one
    where it crosses the waterline."""
    points = [profile[0]]
    for (r1, z1), (r2, z2) in pairwise(profile):
        crosses = z1 * z2 < 0.0 and r1 == r2
        ends = [(r1, z1), (r1, 0.0), (r2, z2)] if crosses else [(r1, z1), (r2, z2)]
        for start, end in pairwise(np.array(ends)):
            count = int(np.ceil(np.hypot(*(end - start)) / size))
            points += [tuple(start + (end - start) * k / count) for k in range(1, count + 1)]
    return points


def turned(profile: Profile, sectors: int) -> tuple[np.ndarray, np.ndarray]:
    """Corners (n, 3) and quadrilaterals (m, 4) of the surface that a ``profile`` makes about the z
    axis, with normals to the right of its direction seen from y < 0."""
    angle = 2.0 * np.pi * (np.arange(sectors) + 0.5) / sectors
    corners = [(r * np.cos(a), r * np.sin(a), z) for r, z in profile for a in angle]
    rows = np.arange(len(profile) - 1)[:, None] * sectors
    here = np.arange(sectors)
    there = (here + 1) % sectors
    faces = [rows + here, rows + there, rows + sectors + there, rows + sectors + here]
    return np.array(corners), np.stack(faces, axis=-1).reshape(-1, 4)


def write(name: str, profile: Profile, size: float, sectors: int) -> None:
    """Write the mesh of a ``profile`` as a Wavefront file."""
    corners, faces = turned(refined(profile, size), sectors)
    lines = [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in corners]
    lines += [f"f {a} {b} {c} {d}" for a, b, c, d in faces + 1]
    (HERE / f"{name}.obj").write_text("\n".join([*lines, ""]))


if __name__ == "__main__":
    write("float", FLOAT, 0.8, 32)
    write("spar", SPAR, 1.0, 24)
