"""`build` computes a database from a recipe, and tells the time that it takes.

How long a database takes, from samples of its panels.

Each pair of panels takes the same time in the matrices of influence, and each panel the same in
far fields and pressures. So a frequency of n panels takes a n^2 + b n + c n^3. Two samples of
panels give a and b; a matrix that is factorised gives c. Samples are solved near one of the
frequencies; their results have no meaning.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from itertools import combinations, count
from time import perf_counter, process_time

import capytaine
import numpy as np
from scipy.linalg import lu_factor

from hydrosim.database import HydroDatabase
from hydrosim.database.build import bem
from hydrosim.database.build import recipe as recipes
from hydrosim.database.build.afloat import FloatingHulls, floating, hulls_afloat
from hydrosim.database.build.assemble import (
    CoarseRadiation,
    Floating,
    Rules,
    assemble,
    asymmetry,
    by_far_field,
    extrapolate_radiation,
)
from hydrosim.database.build.drift import MIN_TESTED_KH, Drifting, Real, Water
from hydrosim.database.build.mesh import narrowest_gap
from hydrosim.database.build.near_field import first_order_all, wetted_surface, whole
from hydrosim.database.build.second_order import difference_qtf, drift_of_each
from hydrosim.database.database import PANELS_ATTRIBUTE
from hydrosim.errors import InputError
from hydrosim.files.cache import stored

SAMPLE_PANELS = (150, 600)  # panels
SAMPLE_MATRIX_SIZE = 700  # size of the sample of a matrix
FACTORISATION_TRIALS = 3  # factorisations that are timed
SHORTEST_S = 1e-3  # of a sample, by the resolution of clocks


def estimated_seconds(hull: bem.Hull, water: Water, frequencies: Real, headings: Real) -> float:
    """Time [s] that one process takes for all ``frequencies`` [rad/s] that are not stored."""
    missing = [w for w in frequencies if not _is_stored(hull, water, float(w), headings)]
    if not missing:
        return 0.0
    seconds = _seconds_of_one(hull, water, float(missing[len(missing) // 2]), headings)
    return seconds * (len(missing) + _missing_limits(hull, water))


def _is_stored(hull: bem.Hull, water: Water, frequency: float, headings: Real) -> bool:
    return stored(bem.entry_name(bem.solution_key(hull, water, frequency, headings))) is not None


def _missing_limits(hull: bem.Hull, water: Water) -> int:
    """Number of the limits of added mass that are not stored; each takes about a frequency."""
    limits = [0.0, np.inf] if water.is_deep else [np.inf]
    return sum(not _is_stored(hull, water, w, np.empty(0)) for w in limits)


def _seconds_of_one(hull: bem.Hull, water: Water, frequency: float, headings: Real) -> float:
    """Time [s] of one frequency near ``frequency`` [rad/s], in this process."""
    begin = perf_counter(), process_time()
    samples = [
        _sample_seconds(hull, water, frequency, headings, wanted) for wanted in SAMPLE_PANELS
    ]
    factorisations = _factorisation_seconds()
    # other programs delay short samples by chance, so that all share one delay
    delay = (perf_counter() - begin[0]) / max(process_time() - begin[1], SHORTEST_S)
    size = len(hull.panels) + len(hull.lid)
    if samples[0][0] == samples[1][0]:  # a hull of few panels
        return delay * samples[1][1]
    powers = np.array([[count**2, count] for count, _ in samples], dtype=float)
    quadratic, linear = np.linalg.solve(powers, [seconds for _, seconds in samples])
    matrices = (2 if hull.symmetric else 1) * (2 if hull.direct else 1)
    factorised = matrices * factorisations * (size / SAMPLE_MATRIX_SIZE) ** 3
    return delay * float(max(quadratic, 0.0) * size**2 + max(linear, 0.0) * size + factorised)


def _factorisation_seconds() -> float:
    """CPU time [s] of the factorisation of a matrix of the size `SAMPLE_MATRIX_SIZE`."""
    matrix = np.eye(SAMPLE_MATRIX_SIZE) + 1j / (1.0 + np.arange(SAMPLE_MATRIX_SIZE))
    begin = process_time()
    for _ in range(FACTORISATION_TRIALS):
        lu_factor(matrix)
    return max(process_time() - begin, SHORTEST_S) / FACTORISATION_TRIALS


def _sample_seconds(
    hull: bem.Hull, water: Water, frequency: float, headings: Real, wanted: int
) -> tuple[int, float]:
    """Number of panels of a sample with about as many as ``wanted``, and its CPU time [s]."""
    size = len(hull.panels) + len(hull.lid)
    stride = max(size // wanted, 1)
    owner = np.array(hull.owner, dtype=int)
    sides = owner.reshape(2 if hull.symmetric else 1, -1)[:, ::stride]
    sample = replace(
        hull,
        panels=hull.panels[::stride],
        lid=hull.lid[::stride],
        owner=tuple(sides.ravel().tolist()),
    )
    # the first loads tables and makes the mesh, the second shows what all others take
    for share in (1.0, 1.01):
        begin = process_time()
        bem.solve(sample, water, share * frequency, headings)
    return len(sample.panels) + len(sample.lid), max(process_time() - begin, SHORTEST_S)


QTF = "near field, with Pinkster's second-order potential; surge, sway and yaw scaled to mean_drift"


def ignore_progress(done: int, total: int) -> None:
    """Default for ``progress``: ignores it."""


def build(
    recipe: recipes.Recipe,
    jobs: int = 1,
    progress: bem.Progress = ignore_progress,
    announce: Callable[[float], None] | None = None,
) -> HydroDatabase:
    """Database of ``recipe``, computed by ``jobs`` processes.

    ``progress`` receives the number of completed frequencies and `Recipe.steps`. Completed
    frequencies are stored on the disk, and the same recipe continues from there. ``announce``
    receives an estimate of the time [s] before anything is computed. Raises `InputError` if the
    database cannot be computed; warns of irregular frequencies.
    """
    data = recipe.data
    water = Water(data.water.density, data.water.gravity, data.water.depth)
    floats = hulls_afloat(recipe)
    body = floating(recipe, floats, water)
    _check_depth(recipe, floats, water)
    _warn_of_irregular(recipe, floats, water)
    _warn_of_gaps(recipe, floats)
    if announce is not None:
        announce(_remaining_seconds(recipe, floats.hull, water, jobs))
    progress(0, recipe.steps)
    limits = _limits(floats.hull, water)
    progress = _all_of(recipe.steps, progress)
    solutions = bem.solve_all(
        floats.hull, water, recipe.frequencies, recipe.headings, jobs, progress
    )
    attributes = _attributes(recipe, floats, solutions)
    if data.far_field is not None:
        solutions = by_far_field(solutions, recipe.headings, data.far_field, water)
    db = assemble(
        body,
        water,
        recipe.headings,
        solutions,
        limits,
        attributes,
        symmetric=floats.alike,
        drift=data.drift if isinstance(data, recipes.OneBody) else (),
    )
    if isinstance(data, recipes.SeveralBodies) and data.drift:
        given = solutions, recipe.headings, data.drift, jobs, progress
        drifts = drift_of_each(floats.hull, body, water, *given)
        free, held = (drifts.get(kind) for kind in (Drifting.FREE, Drifting.HELD))
        db = replace(db, mean_drift=free, mean_drift_held=held)
    if isinstance(data, recipes.OneBody) and data.extrapolate is not None:
        db = _extrapolate_from_coarse(db, recipe, data.extrapolate, water, jobs, progress)
    if isinstance(data, recipes.OneBody) and data.qtf is not None:
        db = _with_qtf(db, data.qtf, floats.hull, body, jobs, progress)
    return db


def _remaining_seconds(recipe: recipes.Recipe, hull: bem.Hull, water: Water, jobs: int) -> float:
    """Time [s] that all frequencies take which are not stored yet; those of QTFs, of fewer panels
    and of drifts count as all others."""
    seconds = estimated_seconds(hull, water, recipe.frequencies, recipe.headings)
    return seconds * recipe.steps / recipe.frequencies.size / jobs


def _all_of(total: int, progress: bem.Progress) -> bem.Progress:
    """Report the number of completed frequencies to ``progress``, over all computations."""
    done = count(1)
    return lambda _, __: progress(next(done), total)


def _limits(hull: bem.Hull, water: Water) -> tuple[Real | None, Real]:
    """Added mass at zero frequency (deep water only) and at infinite frequency."""
    zero = bem.limit_added_mass(hull, water, 0.0) if water.is_deep else None
    return zero, bem.limit_added_mass(hull, water, np.inf)


def _extrapolate_from_coarse(
    db: HydroDatabase,
    recipe: recipes.Recipe,
    share: float,
    water: Water,
    jobs: int,
    progress: bem.Progress,
) -> HydroDatabase:
    """``db`` with added mass and damping extrapolated from a ``share`` of its panels."""
    floats = hulls_afloat(recipe, share)
    solved = bem.solve_all(floats.hull, water, recipe.frequencies, np.empty(0), jobs, progress)
    rules = Rules(floats.alike, recipe.headings)
    zero = bem.limit_added_mass(floats.hull, water, 0.0) if water.is_deep else None
    coarse = CoarseRadiation(
        rules.matrices(np.array([s.added_mass for s in solved])),
        rules.matrices(np.array([s.damping for s in solved])),
        None if zero is None else rules.matrices(zero),
    )
    draught = -float(floats.hull.panels[..., 2].min())
    return extrapolate_radiation(db, coarse, share, draught)


def _with_qtf(
    db: HydroDatabase,
    wanted: recipes.DifferenceQtf,
    hull: bem.Hull,
    body: Floating,
    jobs: int,
    progress: bem.Progress,
) -> HydroDatabase:
    """``db`` with the ``wanted`` QTFs of the ``body``, floating freely in deep water."""
    frequency, headings = np.array(wanted.frequencies), np.array(wanted.headings)
    water = Water(db.water_density, db.gravity)
    flows = first_order_all(hull, body, water, frequency, headings, jobs, progress)
    pairs, transfer = difference_qtf(db, wetted_surface(whole(hull.body)), flows, headings)
    return replace(
        db,
        qtf_frequency=frequency,
        qtf_heading=pairs,
        qtf_difference=transfer,
        attributes={**db.attributes, "qtf_difference_by": QTF},
    )


def _check_depth(recipe: recipes.Recipe, floats: FloatingHulls, water: Water) -> None:
    draught = -floats.hull.panels[..., 2].min()
    if draught >= water.depth:
        raise InputError(
            f"{recipe.path}: water.depth: found {water.depth:g} m; expected more than the hull's"
            f" draught of {draught:g} m."
        )
    lowest = recipe.frequencies[0]
    least = water.lowest_frequency
    if lowest < least:
        raise InputError(
            f"{recipe.path}: frequencies: found {lowest:g} rad/s; expected at least {least:.3g}"
            f" rad/s in {water.depth:g} m of water. The solver cannot compute waves more than"
            f" {2 * np.pi / MIN_TESTED_KH:.0f} times longer than the depth."
        )


def _warn_of_irregular(recipe: recipes.Recipe, floats: FloatingHulls, water: Water) -> None:
    """Warn of irregular frequencies: without a lid, the water inside the hull has resonances that
    spoil the results."""
    if len(floats.hull.lid):
        return
    first = floats.hull.body.first_irregular_frequency_estimate(g=water.gravity)
    if recipe.frequencies[-1] > 0.95 * first:
        warnings.warn(
            f"{recipe.path}: without a lid, the coefficients have spikes at irregular"
            f" frequencies, the first near {first:.3g} rad/s. Use lower frequencies, or set lid:"
            " auto.",
            stacklevel=3,
        )


def _warn_of_gaps(recipe: recipes.Recipe, floats: FloatingHulls) -> None:
    """Warn of panels that are wider than a gap between two hulls: the water in it comes out wrong,
    and a run may refuse the database."""
    if not isinstance(recipe.data, recipes.SeveralBodies):
        return
    names = [*recipe.data.bodies]
    owner = np.array(floats.hull.owner)
    panels = [floats.panels[owner == number] for number in range(len(names))]
    for i, j in combinations(range(len(names)), 2):
        gap, widest = narrowest_gap(panels[i], panels[j])
        wide = {names[k]: size for k, size in zip((i, j), widest, strict=True) if size > gap}
        if wide:
            gaps = " and ".join(f"{size:.3g} m on {name}" for name, size in wide.items())
            keys = ", ".join(f"bodies.{name}.hull" for name in wide)
            warnings.warn(
                f"{recipe.path}: {keys}: found panels of {gaps} at the gap of {gap:.3g} m between"
                f" {names[i]} and {names[j]}; expected panels narrower than the gap. Damping would"
                " not agree with wave loads, and a run may refuse the database. Give smaller"
                " panels, or a finer mesh.",
                stacklevel=3,
            )


def _attributes(
    recipe: recipes.Recipe, floats: FloatingHulls, solutions: Sequence[bem.Solution]
) -> dict[str, str]:
    raw = {
        "added_mass": asymmetry(np.array([s.added_mass for s in solutions])).max(),
        "radiation_damping": asymmetry(np.array([s.damping for s in solutions])).max(),
    }
    halves = 2 if floats.hull.symmetric else 1
    panels = {"hull": halves * len(floats.hull.panels), "lid": halves * len(floats.hull.lid)}
    return {
        "title": recipe.data.title,
        "hull": json.dumps(_hull_descriptions(recipe)),
        PANELS_ATTRIBUTE: json.dumps(panels),
        "solver": f"Capytaine {capytaine.__version__}, {recipe.data.method} method",
        "mean_drift_of": "without viscous damping; Maruo's far field",
        "raw_asymmetry": json.dumps(raw),
        "recipe": recipe.path.name,
        "recipe_text": recipe.text,
        **recipe.data.attributes,
    }


def _hull_descriptions(recipe: recipes.Recipe) -> dict[str, object]:
    data = recipe.data
    if isinstance(data, recipes.SeveralBodies):
        return {name: _hull(recipe, part.hull) for name, part in data.bodies.items()}
    return _hull(recipe, data.hull)


def _hull(recipe: recipes.Recipe, hull: recipes.AnyHull) -> dict[str, object]:
    if isinstance(hull, recipes.MeshFileHull | recipes.SphereHull):
        return dict(hull)
    return asdict(hull.shape(recipe.data.water))
