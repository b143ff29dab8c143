"""Mean drift of each of several bodies, in the waves of all of them.

The far field gives the drift of all bodies together. The pressure on each hull gives the drift of
that hull: the diagonal of `qtf.quadratic`, which converges slowly with the panels. So the forces
come from the pressures. Their difference from the far field in surge and sway is shared among the
bodies in proportion to their forces. Heave and moments come from the pressures.
"""

from __future__ import annotations

from collections.abc import Iterable

import joblib
import numpy as np

from hydrosim.database.build.assemble import Floating, floating_waves
from hydrosim.database.build.bem import Hull, Progress, Solution, solution_key
from hydrosim.database.build.drift import Drifting, Real, mean_drift
from hydrosim.database.build.near_field import first_order_of_each, parts_of, wetted_surface
from hydrosim.database.build.qtf import mean_load
from hydrosim.database.build.store import key_of, remembered
from hydrosim.database.build.water import Water
from hydrosim.database.build.workers import compute_all


def drift_of_each(
    hull: Hull,
    body: Floating,
    water: Water,
    solutions: Iterable[Solution],
    headings: Real,
    kinds: Iterable[Drifting],
    jobs: int,
    progress: Progress,
) -> dict[Drifting, Real]:
    """Mean drift per amplitude squared (frequencies, headings, n) of the free and of the held
    bodies, by ``jobs`` processes, in deep water. Results are stored on the disk by frequency."""
    _ = hull.body
    solutions, found = list(solutions), {}
    for kind in kinds:
        floating = body if kind is Drifting.FREE else None
        one = joblib.delayed(_stored_drifts)
        calls = (one(hull, floating, water, s.frequency, headings) for s in solutions)
        near = []
        for drift in compute_all(calls, jobs):
            near.append(drift)
            progress(len(near), len(solutions))
        far = np.array([_far_field_drifts(body, kind, s, headings, water) for s in solutions])
        found[kind] = brought_to(np.array(near), far)
    return found


def brought_to(near: Real, far: Real) -> Real:
    """Drift ``near`` (..., n) of the bodies, corrected so that surge and sway add up to those of
    all bodies, ``far`` (..., 6)."""
    each = near.reshape(*near.shape[:-1], -1, 6)
    size = np.abs(each) + np.finfo(float).tiny
    missing = far[..., None, :] - each.sum(axis=-2, keepdims=True)
    shared = missing * size / size.sum(axis=-2, keepdims=True)
    told = np.array([True, True, False, False, False, False])
    return np.where(told, each + shared, each).reshape(near.shape)


def _far_field_drifts(
    body: Floating, kind: Drifting, s: Solution, headings: Real, water: Water
) -> Real:
    """Drift (headings, 6) of all bodies together."""
    free = kind is Drifting.FREE
    waves = (
        floating_waves(body, s, s.added_mass, s.damping, s.excitation)
        if free
        else s.kochin_diffraction
    )
    return mean_drift(waves, s.frequency, headings, water).force


def _stored_drifts(
    hull: Hull, floating: Floating | None, water: Water, frequency: float, headings: Real
) -> Real:
    held = (np.empty(0),) if floating is None else (floating.inertia, floating.stiffness)
    key = key_of("drift of each", solution_key(hull, water, frequency, headings), *held)
    return remembered(
        key, lambda: [_near_field_drifts(hull, floating, water, frequency, headings)]
    )[0]


def _near_field_drifts(
    hull: Hull, floating: Floating | None, water: Water, frequency: float, headings: Real
) -> Real:
    """Drift (headings, n) of each body from the pressures on its hull."""
    parts = parts_of(hull)
    flows = first_order_of_each(hull.body, parts, floating, water, frequency, headings)
    pairs = zip(parts, flows, strict=True)
    each = [mean_load(water, wetted_surface(part), flow) for part, flow in pairs]
    return np.concatenate(each, axis=1)
