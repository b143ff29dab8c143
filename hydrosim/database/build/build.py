"""`build`: from a recipe to a database."""

from __future__ import annotations

import json
import warnings
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

import capytaine
import numpy as np

from hydrosim.database import HydroDatabase
from hydrosim.database.build import barge, mesh, sphere
from hydrosim.database.build.assemble import Floating, assemble, asymmetry
from hydrosim.database.build.barge import Hydrostatics, Panels, mirrored
from hydrosim.database.build.bem import Hull, Progress, Solution, limit_added_mass, solve_all
from hydrosim.database.build.green import SHALLOWEST
from hydrosim.database.build.near_field import first_order_all, wetted_surface
from hydrosim.database.build.qtf import difference_qtf
from hydrosim.database.build.recipe import (
    BargeHull,
    BoxHull,
    DifferenceQtf,
    Lid,
    MeshHull,
    Method,
    Recipe,
    SphereHull,
    Symmetry,
)
from hydrosim.database.build.water import Water
from hydrosim.errors import InputError

QTF = "near field, with Pinkster's second-order potential; surge, sway and yaw scaled to mean_drift"


@dataclass(frozen=True)
class Afloat:
    """A hull in the database's frame: what the solver sees, and its hydrostatics."""

    hull: Hull
    integrals: Hydrostatics

    @property
    def panels(self) -> Panels:
        """All panels of the wetted hull (n, 4, 3)."""
        return mirrored(self.hull.panels) if self.hull.symmetric else self.hull.panels


def silent(done: int, total: int) -> None:
    """Progress that nobody watches."""


def build(recipe: Recipe, jobs: int = 1, progress: Progress = silent) -> HydroDatabase:
    """The database of ``recipe``, computed by ``jobs`` processes.

    ``progress`` is told after each frequency how many are done of `Recipe.steps`. What is done is
    kept on disk: the same recipe started again goes on from there. Raises `InputError` for
    what cannot be computed; warns of irregular frequencies.
    """
    data = recipe.data
    water = Water(data.water.density, data.water.gravity, data.water.depth)
    floats = afloat(recipe)
    body = floating(recipe, floats.integrals, water)
    _check_depth(recipe, floats, water)
    _warn_of_irregular(recipe, floats, water)
    zero = limit_added_mass(floats.hull, water, 0.0) if water.is_deep else None
    limits = zero, limit_added_mass(floats.hull, water, np.inf)
    first = len(recipe.frequencies)

    def linear(done: int, _: int) -> None:
        progress(done, recipe.steps)

    def quadratic(done: int, _: int) -> None:
        progress(first + done, recipe.steps)

    solutions = solve_all(floats.hull, water, recipe.frequencies, recipe.headings, jobs, linear)
    attributes = _attributes(recipe, floats, solutions)
    db = assemble(
        body,
        water,
        recipe.headings,
        solutions,
        limits,
        attributes,
        symmetric=floats.hull.symmetric,
        drift=data.drift,
    )
    return db if data.qtf is None else _with_qtf(db, data.qtf, floats.hull, body, jobs, quadratic)


def _with_qtf(
    db: HydroDatabase,
    wanted: DifferenceQtf,
    hull: Hull,
    body: Floating,
    jobs: int,
    progress: Progress,
) -> HydroDatabase:
    """``db`` with the QTFs that are ``wanted`` of the ``body`` floating free in deep water."""
    frequency, headings = np.array(wanted.frequencies), np.array(wanted.headings)
    water = Water(db.water_density, db.gravity)
    flows = first_order_all(hull, body, water, frequency, headings, jobs, progress)
    pairs, transfer = difference_qtf(db, wetted_surface(hull.body), flows, headings)
    return replace(
        db,
        qtf_frequency=frequency,
        qtf_heading=pairs,
        qtf_difference=transfer,
        attributes={**db.attributes, "qtf_difference_by": QTF},
    )


def afloat(recipe: Recipe) -> Afloat:
    """The hull of ``recipe``. Barges, boxes and spheres have the origin over their centre of
    buoyancy, a mesh where its file has it."""
    hull = recipe.data.hull
    if isinstance(hull, MeshHull):
        return _mesh(recipe, hull)
    if isinstance(hull, SphereHull):
        panels = sphere.half_hull, sphere.half_lid
        half, lid = (half_of(hull.radius, hull.panels) for half_of in panels)
        return _of_halves(recipe, half, lid, sphere.hydrostatics(hull.radius))
    return _barge(recipe, hull)


def _barge(recipe: Recipe, given: BargeHull | BoxHull) -> Afloat:
    shape, panels = given.shape(recipe.data.water), given.panels
    counts = barge.resolution(shape, panels) if isinstance(panels, float) else panels.resolution()
    integrals = barge.hydrostatics(shape)
    shift = [-integrals.centre_of_buoyancy[0], 0.0, 0.0]
    half, lid = barge.half_hull(shape, counts) + shift, barge.half_lid(shape, counts) + shift
    return _of_halves(recipe, half, lid, integrals)


def _of_halves(recipe: Recipe, half: Panels, lid: Panels, integrals: Hydrostatics) -> Afloat:
    """A hull of the panels at y >= 0 and their mirror image, with or without the lid."""
    if recipe.data.lid is Lid.NONE:
        lid = mesh.NONE
    if recipe.data.symmetry is Symmetry.NONE:
        half, lid = mirrored(half), mirrored(lid)
    symmetric = recipe.data.symmetry is Symmetry.AUTO
    return Afloat(_hull(recipe, half, lid, symmetric), integrals)


def _mesh(recipe: Recipe, given: MeshHull) -> Afloat:
    file = recipe.path.parent / given.file
    panels = mesh.read_panels(file, given.scale, given.waterline)
    lid = mesh.lid_of(panels) if recipe.data.lid is Lid.AUTO else mesh.NONE
    integrals = mesh.integrals(panels)
    symmetric = recipe.data.symmetry is Symmetry.AUTO and mesh.is_symmetric(panels)
    if symmetric:
        panels = mesh.port_half(panels)
        lid = mesh.port_half(lid) if len(lid) else lid
    return Afloat(_hull(recipe, panels, lid, symmetric), integrals)


def _hull(recipe: Recipe, panels: Panels, lid: Panels, symmetric: bool) -> Hull:
    direct = recipe.data.method is Method.DIRECT
    return Hull(panels, lid, symmetric, recipe.data.centre_of_gravity, direct)


def floating(recipe: Recipe, integrals: Hydrostatics, water: Water) -> Floating:
    """Mass and stiffness with the weight equal to the buoyancy and over it."""
    data = recipe.data
    gravity, buoyancy = np.array(data.centre_of_gravity), integrals.centre_of_buoyancy.copy()
    if not isinstance(data.hull, MeshHull):
        buoyancy[0] = 0.0
    aside = np.hypot(*(gravity - buoyancy)[:2])
    if aside > 0.01 * np.cbrt(integrals.volume):
        x, y = buoyancy[:2]
        raise InputError(
            f"{recipe.path}: centre_of_gravity: found it {aside:g} m beside the centre of buoyancy;"
            f" expected it above or below that, at x = {x:g} m, y = {y:g} m, or the hull heels."
        )
    mass = water.density * integrals.volume
    turning = _turning(recipe, mass)
    inertia = np.diag([mass] * 3 + [0.0] * 3)
    inertia[3:, 3:] = turning
    return Floating(
        centre_of_gravity=gravity,
        centre_of_buoyancy=buoyancy,
        volume=integrals.volume,
        inertia=inertia,
        stiffness=integrals.stiffness(gravity[2], water.density, water.gravity),
    )


def _turning(recipe: Recipe, mass: float) -> np.ndarray:
    """Moments of inertia (3, 3) about the centre of gravity."""
    if recipe.data.radii_of_gyration is None:
        return np.array(recipe.data.inertia)
    return np.diag([mass * radius**2 for radius in recipe.data.radii_of_gyration])


def _check_depth(recipe: Recipe, floats: Afloat, water: Water) -> None:
    draught = -floats.hull.panels[..., 2].min()
    if draught >= water.depth:
        raise InputError(
            f"{recipe.path}: water.depth: found {water.depth:g} m; expected more than the hull's"
            f" draught of {draught:g} m."
        )
    if water.is_deep:
        return
    lowest = recipe.frequencies[0]
    if water.wavenumber(lowest) * water.depth < SHALLOWEST:
        k = SHALLOWEST / water.depth
        least = np.sqrt(water.gravity * k * np.tanh(SHALLOWEST))
        raise InputError(
            f"{recipe.path}: frequencies: found {lowest:g} rad/s; expected {least:.3g} rad/s or"
            f" more in {water.depth:g} m of water: waves more than {2 * np.pi / SHALLOWEST:.0f}"
            " times longer than the depth are beyond the solver."
        )


def _warn_of_irregular(recipe: Recipe, floats: Afloat, water: Water) -> None:
    """Without a lid the water inside the hull has its own resonances, which spoil the results."""
    if len(floats.hull.lid):
        return
    first = floats.hull.body.first_irregular_frequency_estimate(g=water.gravity)
    if recipe.frequencies[-1] > 0.95 * first:
        warnings.warn(
            f"{recipe.path}: without a lid, the coefficients have spikes at irregular frequencies,"
            f" the first near {first:.3g} rad/s; stay below, or set lid: auto.",
            stacklevel=3,
        )


def _attributes(recipe: Recipe, floats: Afloat, solutions: Sequence[Solution]) -> dict[str, str]:
    raw = {
        "added_mass": asymmetry(np.array([s.added_mass for s in solutions])).max(),
        "radiation_damping": asymmetry(np.array([s.damping for s in solutions])).max(),
    }
    halves = 2 if floats.hull.symmetric else 1
    panels = {"hull": halves * len(floats.hull.panels), "lid": halves * len(floats.hull.lid)}
    return {
        "title": recipe.data.title,
        "hull": json.dumps(_described(recipe)),
        "panels": json.dumps(panels),
        "solver": f"Capytaine {capytaine.__version__}, {recipe.data.method} method",
        "mean_drift_of": "without viscous damping; Maruo's far field",
        "raw_asymmetry": json.dumps(raw),
        "recipe": recipe.path.name,
        "recipe_text": recipe.text,
        **recipe.data.attributes,
    }


def _described(recipe: Recipe) -> dict[str, object]:
    hull = recipe.data.hull
    if isinstance(hull, MeshHull | SphereHull):
        return dict(hull)
    return asdict(hull.shape(recipe.data.water))
