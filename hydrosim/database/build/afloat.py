"""Hulls of a recipe as they float: geometry for the solver, and hydrostatics.

The origin of barges, boxes and spheres is above their centre of buoyancy; the origin of a mesh is
that of its file. A single body is at the database's origin. Several bodies are placed and turned.
If together they are symmetric about y = 0, one half is computed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import scipy
from scipy.linalg import block_diag

from hydrosim.database.build import barge, mesh
from hydrosim.database.build import recipe as recipes
from hydrosim.database.build.assemble import Floating, coarsen
from hydrosim.database.build.barge import Panels, with_mirror_image
from hydrosim.database.build.bem import Hull
from hydrosim.database.build.drift import Water
from hydrosim.database.hull import Hydrostatics
from hydrosim.errors import InputError


@dataclass(frozen=True)
class FloatingHulls:
    """Hulls in the database's frame for the solver, and the hydrostatics of each hull in its own
    frame. ``alike``: each body is symmetric about y = 0."""

    hull: Hull
    integrals: tuple[Hydrostatics, ...]
    alike: bool

    @property
    def panels(self) -> Panels:
        """All panels of the wetted hulls (n, 4, 3)."""
        return with_mirror_image(self.hull.panels) if self.hull.symmetric else self.hull.panels


@dataclass(frozen=True)
class _PartHull:
    """A hull in its own frame: its panels (n, 4, 3) and those of its lid. If ``halved``, the panels
    of both are those at y >= 0."""

    panels: Panels
    lid: Panels
    halved: bool
    integrals: Hydrostatics

    def all_panels(self) -> tuple[Panels, Panels]:
        """All panels of the hull and all panels of the lid."""
        return (
            (with_mirror_image(self.panels), with_mirror_image(self.lid))
            if self.halved
            else (self.panels, self.lid)
        )


def hulls_afloat(recipe: recipes.Recipe, share: float = 1.0) -> FloatingHulls:
    """Hulls of ``recipe``, with a ``share`` of its number of panels."""
    hulls = [_hull_of_part(recipe, part, share) for part in recipe.data.parts]
    integrals = tuple(hull.integrals for hull in hulls)
    direct = recipe.data.method is recipes.IntegralEquation.DIRECT
    centres = tuple(
        _in_database_frame(part, np.array(part.centre_of_gravity)) for part in recipe.data.parts
    )
    points = tuple((float(x), float(y), float(z)) for x, y, z in centres)
    if len(hulls) == 1 and not _is_moved(recipe.data.parts[0]):
        (still_hull,) = hulls
        hull = Hull(still_hull.panels, still_hull.lid, still_hull.halved, points, direct)
        return FloatingHulls(hull, integrals, still_hull.halved)
    whole = [hull.all_panels() for hull in hulls]
    panels, lids = (
        [
            _in_database_frame(part, both[k])
            for part, both in zip(recipe.data.parts, whole, strict=True)
        ]
        for k in (0, 1)
    )
    _check_apart(recipe, panels)
    hull, alike = _combine_hulls(panels, lids, recipe.data.symmetry is recipes.HullSymmetry.AUTO)
    return FloatingHulls(replace(hull, centres=points, direct=direct), integrals, alike)


def floating(recipe: recipes.Recipe, floats: FloatingHulls, water: Water) -> Floating:
    """Mass and stiffness of all bodies, each with its weight equal to its buoyancy and above it."""
    pairs = zip(recipe.data.parts, floats.integrals, strict=True)
    bodies = [_floating_body(recipe, part, integrals, water) for part, integrals in pairs]
    return Floating(
        centre_of_gravity=np.array([body.centre_of_gravity for body in bodies]),
        centre_of_buoyancy=np.array([body.centre_of_buoyancy for body in bodies]),
        volume=np.array([body.volume for body in bodies]),
        inertia=block_diag(*(body.inertia for body in bodies)),
        stiffness=block_diag(*(body.stiffness for body in bodies)),
    )


def _is_moved(part: recipes.RecipeBody) -> bool:
    return bool(np.any(part.position) or part.heading)


def _heading_rotation(part: recipes.RecipeBody) -> np.ndarray:
    c, s = math.cos(part.heading), math.sin(part.heading)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _in_database_frame(part: recipes.RecipeBody, points: np.ndarray) -> np.ndarray:
    """Points (..., 3) of the body's own frame in the database's frame."""
    if not _is_moved(part):
        return points
    turned = points @ _heading_rotation(part).T if part.heading else points
    return np.asarray(turned + np.array([*part.position, 0.0]))


def _combine_hulls(panels: list[Panels], lids: list[Panels], halve: bool) -> tuple[Hull, bool]:
    """All hulls; if they may be halved and are symmetric, those at y >= 0. The second value says
    which bodies are symmetric."""
    every, lid = np.concatenate(panels), np.concatenate(lids)
    owner = np.repeat(np.arange(len(panels)), [len(hull_panels) for hull_panels in panels])
    none = ((0.0, 0.0, 0.0),)
    if not (halve and mesh.is_symmetric(every)):
        return Hull(every, lid, False, none, owner=tuple(owner.tolist())), False
    centres = mesh.centres(every)
    port = centres[:, 1] > 0
    _, image = scipy.spatial.cKDTree(centres).query(centres[port] * [1, -1, 1])
    both = np.concatenate([owner[port], owner[image]])
    lid = lid[mesh.centres(lid)[:, 1] > 0] if len(lid) else lid
    alike = bool((owner[port] == owner[image]).all())
    return Hull(every[port], lid, True, none, owner=tuple(both.tolist())), alike


def _check_apart(recipe: recipes.Recipe, panels: Sequence[Panels]) -> None:
    """Refuse hulls with panels inside each other. One may float within a ring or under another."""
    names = [*getattr(recipe.data, "bodies", {"hull": None})]
    for i, j in combinations(range(len(panels)), 2):
        if _contains_panel(panels[i], panels[j]) or _contains_panel(panels[j], panels[i]):
            raise InputError(
                f"{recipe.path}: bodies.{names[j]}.position: found panels inside {names[i]};"
                " expected hulls that do not overlap."
            )


def _contains_panel(panels: Panels, others: Panels) -> bool:
    """Whether a panel of the ``others`` is inside the hull of the ``panels``."""
    points = mesh.inner_points(others)
    low, high = panels.min(axis=(0, 1)), panels.max(axis=(0, 1))
    near = ((points > low) & (points < high)).all(axis=1)
    return bool((np.abs(mesh.windings(panels, points[near])) > 0.5).any())


def _hull_of_part(recipe: recipes.Recipe, part: recipes.RecipeBody, share: float) -> _PartHull:
    if isinstance(part.hull, recipes.MeshFileHull):
        return _of_file(recipe, part.hull)
    if isinstance(part.hull, recipes.SphereHull):
        radius, size = part.hull.radius, part.hull.size() / share
        half, lid = barge.half_sphere(radius, size), barge.sphere_lid(radius, size)
        integrals = barge.sphere_hydrostatics(radius)
    else:
        shape = part.hull.shape(recipe.data.water)
        counts = coarsen(recipes.resolution(part.hull, shape), share)
        integrals = barge.hydrostatics(shape)
        shift = [-integrals.centre_of_buoyancy[0], 0.0, 0.0]
        half, lid = barge.half_hull(shape, counts) + shift, barge.half_lid(shape, counts) + shift
    if recipe.data.lid is recipes.Lid.NONE:
        lid = mesh.NO_PANELS
    if recipe.data.symmetry is recipes.HullSymmetry.NONE:
        return _PartHull(with_mirror_image(half), with_mirror_image(lid), False, integrals)
    return _PartHull(half, lid, True, integrals)


def _of_file(recipe: recipes.Recipe, given: recipes.MeshFileHull) -> _PartHull:
    file = recipe.path.parent / given.file
    panels = mesh.read_panels(file, given)
    lid = mesh.lid_of(panels) if recipe.data.lid is recipes.Lid.AUTO else mesh.NO_PANELS
    integrals = mesh.integrals(panels)
    symmetric = recipe.data.symmetry is recipes.HullSymmetry.AUTO and mesh.is_symmetric(panels)
    if symmetric:
        panels = mesh.port_half(panels)
        lid = mesh.port_half(lid) if len(lid) else lid
    return _PartHull(panels, lid, symmetric, integrals)


def _floating_body(
    recipe: recipes.Recipe, part: recipes.RecipeBody, integrals: Hydrostatics, water: Water
) -> Floating:
    """One body, in the database's frame."""
    gravity, buoyancy = np.array(part.centre_of_gravity), integrals.centre_of_buoyancy.copy()
    if not isinstance(part.hull, recipes.MeshFileHull):
        buoyancy[0] = 0.0
    aside = np.hypot(*(gravity - buoyancy)[:2])
    if aside > 0.01 * np.cbrt(integrals.volume):
        x, y = buoyancy[:2]
        raise InputError(
            f"{recipe.path}: centre_of_gravity: found it {aside:g} m beside the centre of"
            f" buoyancy; expected it above or below that, at x = {x:g} m, y = {y:g} m. Otherwise"
            " the hull heels or trims."
        )
    mass = water.density * integrals.volume
    inertia = block_diag(mass * np.eye(3), _moments_of_inertia(part, mass))
    stiffness = integrals.stiffness(gravity[2], water.density, water.gravity)
    if part.heading:
        turn = block_diag(_heading_rotation(part), _heading_rotation(part))
        inertia, stiffness = (turn @ matrix @ turn.T for matrix in (inertia, stiffness))
    return Floating(
        centre_of_gravity=_in_database_frame(part, gravity),
        centre_of_buoyancy=_in_database_frame(part, buoyancy),
        volume=np.array(integrals.volume),
        inertia=inertia,
        stiffness=stiffness,
    )


def _moments_of_inertia(part: recipes.RecipeBody, mass: float) -> np.ndarray:
    """Moments of inertia (3, 3) about the centre of gravity."""
    if part.radii_of_gyration is None:
        return np.array(part.inertia)
    return np.diag([mass * radius**2 for radius in part.radii_of_gyration])
