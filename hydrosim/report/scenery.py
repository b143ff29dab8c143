"""Scenery of a replay, from the case of a run: hulls, contacts, planes, lines, waves."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
import xarray as xr

from hydrosim.case.load import load_case
from hydrosim.errors import InputError
from hydrosim.scene import Body, ChangedDatabase, Family, Scene
from hydrosim.studies.run.repeat import case_of
from hydrosim.waves import WaveComponents, sea

DECK_HEIGHT_RATIO = 1.2  # times the draught: depth of a hull whose recipe gives none
UNKNOWN_BOX_SIDE_M = 10.0  # m: side of the box for a body of unknown size
MIN_SIDE_RATIO = 0.1  # of its longest side: the shortest side of a box
MAX_COMPONENTS = 1200  # wave components on a page
ELEVATION_RTOL = 1e-6  # of the largest elevation: accuracy of recomputed waves
RECORDS_COMPARED = 50  # records at which they are compared
BOX_FACES = np.array(
    [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
)
BOX_CORNERS = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


class Shape(NamedTuple):
    """Triangles (nt, 3, 3) about the centre of gravity of a body, and their description."""

    triangles: np.ndarray
    said: str


def scene_of(run: xr.Dataset) -> Scene | None:
    """Scene of a run, from the case in it; None if that cannot be read again."""
    try:
        text = case_of(run)
        with TemporaryDirectory() as folder:
            path = Path(folder, "case.yaml")
            path.write_text(text, "utf-8")
            scene = load_case(path).scene()
    except (InputError, KeyError, TypeError, OSError, UnicodeError):
        return None
    return scene if [b.name for b in scene.bodies] == list(map(str, run.body.values)) else None


def shape_of(body: Body | None, keel: float | None = None) -> Shape:
    """Shape of a body: its hull, or else a box with its radii of gyration, down to its ``keel`` [m]
    if known, which is the height at which it is touched from below."""
    if body is None:
        corners = box(np.full(3, UNKNOWN_BOX_SIDE_M))
        return Shape(corners, "a box, because its case cannot be read again")
    if body.hydrostatics is not None:
        return Shape(body.hydrostatics.corners - body.centre_of_gravity, "its hull")
    found = _recipe_hull(body)
    if found is not None:
        deck = f"a deck at {DECK_HEIGHT_RATIO:g} times the draught"
        said = f"the hull of its database's recipe, with {deck}"
        return Shape(found - body.centre_of_gravity, said)
    square = np.diag(body.inertia) / body.mass
    sides = 6.0 * (square.sum() - 2.0 * square)  # of a homogeneous box
    least = max(float(sides.max()), 1e-6) * MIN_SIDE_RATIO**2
    made = box(np.sqrt(np.maximum(sides, least)))
    if keel is None:
        return Shape(made, "a box with its radii of gyration")
    made[..., 2] = np.where(made[..., 2] < 0.0, keel, made[..., 2])
    return Shape(made, "a box with its radii of gyration, down to its contact from below")


def box(sides: np.ndarray) -> np.ndarray:
    """Triangles (12, 3, 3) of a box about the origin."""
    quads = (BOX_CORNERS * sides)[BOX_FACES]
    return np.concatenate([quads[:, [0, 2, 1]], quads[:, [0, 3, 2]]])


def _recipe_hull(body: Body) -> np.ndarray | None:
    """Triangles of the hull of the recipe beside the database, if it exists and has a draught."""
    import netCDF4

    from hydrosim.database.build.closed import shape_of_recipe

    source = body.hydrodynamics
    if isinstance(source, Family):
        source = source.members[0].source
    if isinstance(source, ChangedDatabase):
        source = source.source
    if not isinstance(source, Path):
        return None
    try:
        with netCDF4.Dataset(source) as file:
            name = str(getattr(file, "recipe", ""))
    except (OSError, RuntimeError):
        return None
    recipe = source.parent / Path(name).name
    if not (name and recipe.is_file()):
        return None
    for depth in (_recipe_depth(recipe, body.database_body), None):
        try:
            return shape_of_recipe(recipe, body.database_body, depth)
        except (InputError, ValueError, OSError):
            continue
    return None


def _recipe_depth(recipe: Path, body: int) -> float | None:
    from hydrosim.database.build.recipe import load_recipe

    parts = load_recipe(recipe).data.parts
    draught = getattr(parts[body - 1].hull, "draught", None) if body <= len(parts) else None
    return DECK_HEIGHT_RATIO * float(draught) if draught else None


def waves_of(scene: Scene | None, run: xr.Dataset) -> tuple[list[WaveComponents], str]:
    """Largest components of the waves of a run, and their description. Empty if the waves of its
    case are not those in the run."""
    if not np.any(run.wave_elevation):
        return [], "There are no waves."
    level = (
        "The water is drawn flat, because the waves of the run cannot be recomputed from its case."
    )
    if scene is None:
        return [], level
    try:
        sets = list(sea(scene.environment))
    except InputError:
        return [], level
    at = np.unique(np.linspace(0, run.time.size - 1, RECORDS_COMPARED).astype(int))
    time, known = run.time.values[at], run.wave_elevation.values[at]
    made = np.sum([_at_origin(waves, time) for waves in sets], axis=0)
    if not np.allclose(
        made, known, rtol=0.0, atol=ELEVATION_RTOL * np.abs(run.wave_elevation).max().item()
    ):
        return [], level
    return _largest_components(sets)


def _at_origin(waves: WaveComponents, time: np.ndarray) -> np.ndarray:
    """Elevation (nt,) at the origin."""
    grown = np.clip(time / waves.ramp, 0.0, 1.0) if waves.ramp > 0.0 else np.ones(time.size)
    angle = np.outer(time, waves.omega) + waves.phase
    return np.asarray(0.5 * (1.0 - np.cos(np.pi * grown)) * (np.cos(angle) @ waves.amplitude))


def _largest_components(sets: list[WaveComponents]) -> tuple[list[WaveComponents], str]:
    amplitude = np.concatenate([waves.amplitude for waves in sets])
    if amplitude.size <= MAX_COMPONENTS:
        return sets, f"The water is the sum of all {amplitude.size} components of the waves."
    least = np.sort(amplitude)[-MAX_COMPONENTS]
    share = np.sum(amplitude[amplitude >= least] ** 2) / np.sum(amplitude**2)
    kept = [_select_components(waves, waves.amplitude >= least) for waves in sets]
    return kept, (
        f"The water is the sum of the {MAX_COMPONENTS} largest of {amplitude.size} components of"
        f" the waves, which have {share:.0%} of their energy."
    )


def _select_components(waves: WaveComponents, these: np.ndarray) -> WaveComponents:
    each = ("omega", "amplitude", "phase", "wavenumber", "heading")
    return replace(waves, **{name: getattr(waves, name)[these] for name in each})
