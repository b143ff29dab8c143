"""Stability of the step of a scene, and alternatives to an unstable step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from hydrosim.errors import InputError
from hydrosim.integrate import methods_for_any_step
from hydrosim.linear.stability import smallest_step, step_limits
from hydrosim.radiation.threads import one_thread
from hydrosim.scene import Unstable
from hydrosim.scene.solver import fitting_step
from hydrosim.studies.ballast.loading import with_contents_at
from hydrosim.studies.run.resolution import (
    scene_combinations,
    scene_vibrations,
)

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled
    from hydrosim.linear.stability import Combination, StepLimit
    from hydrosim.scene import Scene


@one_thread
def add_step_warnings(compiled: Compiled) -> Compiled:
    """Compiled scene with its largest stable step, with warnings about a step above it, and with
    the modes that the step does not resolve. Raises InputError if the scene refuses such a step."""
    scene = compiled.scene
    step = scene.solver.step
    if compiled.method.adapts or compiled.facts.exact:
        return compiled
    scene_contacts = scene_combinations(compiled)
    stable = smallest_step(scene_contacts, compiled.method)
    limits = _limits_below(step, compiled, scene_contacts, stable)
    texts = [limit.describe(step) for limit in limits]
    if not texts and compiled.model.tanks.each.size:
        end = compiled.begin + scene.duration
        later = with_contents_at(compiled, end)
        combinations = scene_combinations(later)
        limits = _limits_below(step, later, combinations, smallest_step(combinations, later.method))
        now = f", with tanks as at the end, {end:g} s"
        texts = [limit.describe(step) + now for limit in limits]
    if texts and scene.solver.unstable == Unstable.ERROR:
        raise InputError(f"solver.step {step:g} s: {'. '.join(texts)}. {_advice(scene, limits[0])}")
    return replace(
        compiled,
        stable_step=stable,
        step_warnings=tuple(f"solver.step {step:g} s: {text}" for text in texts),
        vibrations=scene_vibrations(compiled, scene_contacts),
    )


def _limits_below(
    step: float, compiled: Compiled, found: Sequence[Combination], stable: float
) -> list[StepLimit]:
    """Limits of a scene below this ``step``, for the combinations ``found``. Their largest
    ``stable`` step needs eigenvalues alone. Names of limits need eigenvectors."""
    if compiled.method.any_step or stable >= step:
        return []
    return [limit for limit in scene_step_limits(compiled, found) if limit.step < step]


def _advice(scene: Scene, limit: StepLimit) -> str:
    """Alternatives to a step above its limit: a step of few digits that fits the output, or another
    method."""
    step = fitting_step(scene.output_step, limit.step)
    others = ", ".join(
        f"solver.method: {method.name} ({method.why_any_step})" for method in methods_for_any_step()
    )
    return (
        f"Choose solver.step: {step:.10g} s or less, {others}, or run this step anyway with"
        " solver.unstable: warn."
    )


def scene_step_limits(compiled: Compiled, found: Sequence[Combination] = ()) -> list[StepLimit]:
    """Limits of the step of a scene with its method, for the combinations of contacts ``found``,
    see `stability.step_limits`."""
    found = found or scene_combinations(compiled)
    return step_limits(found, compiled.method, compiled.facts.layout, compiled.scene.solver.step)
