"""Closed hull of a recipe: the hull of its database, with a deck."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hydrosim.database.build.barge import Barge, hydrostatics, patch
from hydrosim.database.build.hull_keys import MeshFileHull, SphereHull
from hydrosim.database.build.recipe import load_recipe
from hydrosim.database.hull import close_hull, read_closed, triangles_of
from hydrosim.dofs import about_z
from hydrosim.errors import InputError
from hydrosim.scene import Hull


def hull_of_recipe(path: Path, body: int = 1, depth: float | None = None) -> Hull:
    """Hull of a ``body`` of a recipe, in the database's frame. The sides of barges and boxes extend
    to a flat deck ``depth`` [m] above the keel. Raises `InputError` if that is not possible.
    """
    return close_hull(shape_of_recipe(path, body, depth), str(path))


def shape_of_recipe(path: Path, body: int = 1, depth: float | None = None) -> np.ndarray:
    """Triangles (nt, 3, 3) of the same hull, which may be submerged."""
    recipe = load_recipe(path)
    if body > len(recipe.data.parts):
        raise InputError(f"{path}: has {len(recipe.data.parts)} bodies; expected body {body}.")
    part = recipe.data.parts[body - 1]
    hull = part.hull
    if isinstance(hull, SphereHull) or isinstance(hull, MeshFileHull) == (depth is not None):
        raise InputError(
            f"{path}: its hull is a {hull.type}, and depth is {depth}; expected a barge or a box"
            " with a depth (keel to deck), or a mesh without one. Give a file as mesh instead."
        )
    if isinstance(hull, MeshFileHull):
        own = read_closed(path.parent / hull.file, hull)
    else:
        own = barge_with_deck(hull.shape(recipe.data.water), float(depth or 0.0))
    return np.asarray(own @ about_z(part.heading).T + [*part.position, 0.0])


def barge_with_deck(hull: Barge, depth: float) -> np.ndarray:
    """Triangles (n, 3, 3) of a barge, with the origin above its centre of buoyancy as in its
    database."""
    x = np.array(hull.corners())
    side = hull.half_breadth(x)[:, None] * [-1.0, 1.0]
    low, high = hull.bottom(x)[:, None], np.full((x.size, 1), depth - hull.draught)
    starboard, port = side[:, :1], side[:, 1:]
    x = x[:, None] - hydrostatics(hull).centre_of_buoyancy[0]
    rising = np.hstack([low, high])
    faces = [
        patch(x, side, low)[:, ::-1],
        patch(x, side, high),
        patch(x, starboard, rising),
        patch(x, port, rising)[:, ::-1],
        patch(x[0], side[0][:, None], rising[0])[:, ::-1],
        patch(x[-1], side[-1][:, None], rising[-1]),
    ]
    return triangles_of(np.concatenate(faces))
