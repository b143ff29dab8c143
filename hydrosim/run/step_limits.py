"""Stability and accuracy of the step of a scene, and alternatives to an unstable step."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.analysis.ballast import with_contents_at
from hydrosim.errors import InputError
from hydrosim.integrate.methods import methods_for_any_step
from hydrosim.integrate.record import unpack_channels
from hydrosim.linear.stability import (
    WRONG,
    Combination,
    StepLimit,
    Vibration,
    Watch,
    combinations,
    smallest_step,
    step_limits,
    vibrations,
    without_progress,
)
from hydrosim.multibody.kinematics import coordinate_groups
from hydrosim.scene import Scene, Unstable
from hydrosim.scene.scene import fitting_step
from hydrosim.water.radiation.threads import one_thread

if TYPE_CHECKING:
    from hydrosim.compile.compiled import Compiled
    from hydrosim.integrate.state import Record

# Accuracy of the step: modes that a run excites and that its method does not resolve.

MAX_MOTION_ERROR = 1e-3  # of the range of a motion: an error that is worth a warning
MAX_FADING, FADING_ERROR_RATIO = 0.1, 8.0
"""If the method damps a vibration by more than the first number, a finer step leaves more of it.
Its accepted error is then smaller by the second number."""
MAX_AMPLITUDE_ERROR = 1e-2  # of the amplitude of a vibration, at the end of a run
MIN_MOTION_RANGE = 1e-6  # m, rad: a smaller range counts as none


class StepNeed(NamedTuple):
    """The ``step`` [s] that a vibration needs, and the ``error`` of motions, relative to their
    range, at the step of the run."""

    step: float
    error: float
    vibration: Vibration


@one_thread
def scene_combinations(
    compiled: Compiled, each_alone: bool = False, watch: Watch = without_progress
) -> list[Combination]:
    """Combinations of contacts for which a scene is linearised, see `linear.stability`."""
    return combinations(compiled.scene, compiled.model, compiled.state, each_alone, watch)


@one_thread
def scene_vibrations(
    compiled: Compiled, mode_combinations: Sequence[Combination], error: float = MAX_MOTION_ERROR
) -> tuple[Vibration, ...]:
    """Vibrations in the ``mode_combinations`` with an error of more than ``error`` of
    their amplitude at the step of the scene, see `linear.stability`."""
    scene = compiled.scene
    of = (scene.duration, scene.solver.step, error)
    return tuple(
        vibrations(mode_combinations, compiled.method, compiled.model, compiled.derived.layout, *of)
    )


def accuracy_limit(compiled: Compiled, mode_combinations: Sequence[Combination]) -> str:
    """Line on the largest step that resolves all possible vibrations in the combinations of
    contacts ``mode_combinations``. Only a run can tell which vibrations are excited."""
    scene = compiled.scene
    of = (compiled.method, scene.solver.step, scene.duration, MAX_AMPLITUDE_ERROR)
    needs = [
        (v.accurate_step(*of), v)
        for v in scene_vibrations(compiled, mode_combinations, MAX_AMPLITUDE_ERROR)
    ]
    if not needs:
        return (
            f"at {scene.solver.step:g} s all vibrations are accurate within"
            f" {MAX_AMPLITUDE_ERROR:g} of their amplitude"
        )
    step, vibration = min(needs, key=lambda need: need[0])
    return (
        f"largest accurate step {step:.3g} s, within {MAX_AMPLITUDE_ERROR:g} of its amplitude over"
        f" the run: {describe_vibration(vibration, compiled)} at {scene.solver.step:g} s. It"
        " matters if waves, impacts or the start excite it; the run reports whether they do"
    )


def unresolved_vibration_warnings(compiled: Compiled, record: Record, count: int) -> Iterator[str]:
    """Warning if a vibration that a run with ``count`` records excited has an error above
    `MAX_MOTION_ERROR` of the range of a motion. The error is that of one vibration alone. If
    contacts change often, errors are several times as large, see
    `hydrosim.run.error_estimate`."""
    needs = list(_step_needs(compiled, record, count))
    if needs:
        step = min(need.step for need in needs)
        scene = compiled.scene
        worst = max(needs, key=lambda need: need.error)
        yield (
            f"solver.step {scene.solver.step:g} s does not resolve"
            f" {describe_vibration(worst.vibration, compiled)}. The run excites it, and motions"
            f" may be wrong by {worst.error:.1g} of their range. Choose solver.step:"
            f" {fitting_step(scene.output_step, step):.6g} s, or solver.method: dopri5."
        )


def describe_vibration(vibration: Vibration, compiled: Compiled) -> str:
    """Text on a vibration, and on the error of the method."""
    scene = compiled.scene
    omega = vibration.eigenvalue.imag
    error = vibration.error(compiled.method, scene.solver.step, 2 * np.pi / omega)
    return (
        f"{vibration.what} at {omega:.3g} rad/s ({vibration.contact}), which"
        f" {scene.solver.method} changes by {error:.1g} of its amplitude in each period"
    )


def _step_needs(compiled: Compiled, record: Record, count: int) -> Iterator[StepNeed]:
    if count < 2 or not compiled.vibrations:
        return
    values = unpack_channels(compiled.model, record, count)
    scene = compiled.scene
    bodies = compiled.model.bodies
    n = bodies.active.size
    method = compiled.method
    place, rate = values["y"][:n], values["y"][n : 2 * n]
    ranges = _motion_ranges(place, coordinate_groups(bodies))
    for vibration in compiled.vibrations:
        fading = vibration.fading(method, scene.solver.step)
        seen = values["time"], rate, record.modes[:count]
        excited, lasting = vibration.largest_amplitudes(*seen, fading)
        part = min(float((excited / ranges).max()), 1.0)
        error = part * vibration.error(method, scene.solver.step, lasting)
        if error > MAX_MOTION_ERROR:
            room = FADING_ERROR_RATIO if fading * lasting > MAX_FADING else 1.0
            of = (method, scene.solver.step, lasting, MAX_MOTION_ERROR / (room * part))
            yield StepNeed(vibration.accurate_step(*of), min(error, WRONG), vibration)


def _motion_ranges(motion: np.ndarray, kind: np.ndarray) -> np.ndarray:
    """Range (n,) of each coordinate of ``motion`` (nt, n): that of its body in the direction of its
    largest range, or about the axis of its largest range."""
    ranges = np.ptp(motion, axis=0)
    return np.maximum([ranges[kind == k].max() for k in kind], MIN_MOTION_RANGE)


@one_thread
def add_step_warnings(compiled: Compiled) -> Compiled:
    """Compiled scene with its largest stable step, with warnings about a step above it, and with
    the modes that the step does not resolve. Raises InputError if the scene refuses such a step."""
    scene = compiled.scene
    step = scene.solver.step
    if compiled.method.adapts or compiled.derived.exact:
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
        raise InputError(
            f"solver.step {step:g} s: {'. '.join(texts)}. {_advice_text(scene, limits[0])}"
        )
    return replace(
        compiled,
        stable_step=stable,
        step_warnings=tuple(f"solver.step {step:g} s: {text}" for text in texts),
        vibrations=scene_vibrations(compiled, scene_contacts),
    )


def _limits_below(
    step: float, compiled: Compiled, mode_combinations: Sequence[Combination], stable: float
) -> list[StepLimit]:
    """Limits of a scene below this ``step``, for the ``mode_combinations``. Their
    largest ``stable`` step needs eigenvalues alone. Names of limits need eigenvectors."""
    if compiled.method.any_step or stable >= step:
        return []
    return [limit for limit in scene_step_limits(compiled, mode_combinations) if limit.step < step]


def _advice_text(scene: Scene, limit: StepLimit) -> str:
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


def scene_step_limits(
    compiled: Compiled, mode_combinations: Sequence[Combination] = ()
) -> list[StepLimit]:
    """Limits of the step of a scene with its method, for the combinations of contacts
    ``mode_combinations``, see `stability.step_limits`."""
    mode_combinations = mode_combinations or scene_combinations(compiled)
    return step_limits(
        mode_combinations, compiled.method, compiled.derived.layout, compiled.scene.solver.step
    )
