"""Error against run time of a scene, for methods and steps.

Every run is compared with a reference: rk4 at a quarter of the smallest step. Richardson's rule
estimates the error of the reference from a run at twice its step, |x_h - x_2h| / (2^p - 1) with p =
4. Errors below that figure are meaningless.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import isclose, log

import numpy as np
import xarray as xr

from hydrosim.errors import InputError, SimulationError
from hydrosim.results.dataset import KIND, ResultKind
from hydrosim.results.variables import MIXED, describe_values
from hydrosim.scene import LinearScenes, Method, Scene, Tolerance
from hydrosim.simulation import simulate

REFERENCE_STEP_RATIO = 4  # ratio of the smallest step to the step of the reference
REFERENCE_METHOD_ORDER = 4  # of the reference
Report = Callable[[str], None]


@dataclass(frozen=True)
class ConvergenceTrial:
    """One run. ``setting`` is its step [s], or the tolerance of an adaptive method. Errors are the
    largest over bodies and times: ``motion`` [m], ``angle`` [rad], and ``crawl`` [m], the error of
    the final horizontal position. They are NaN with a ``remark`` if the run failed or was
    refused."""

    method: Method
    setting: float
    motion: float
    angle: float
    crawl: float
    energy: float
    evaluations: int
    seconds: float
    remark: str = ""

    def order(self, coarser: ConvergenceTrial) -> float:
        """Observed order of convergence, against a run of the same method with a larger step."""
        if self.method.adapts or not (self.motion > 0.0 and coarser.motion > 0.0):
            return np.nan
        return log(coarser.motion / self.motion) / log(coarser.setting / self.setting)


@dataclass(frozen=True)
class ConvergenceStudy:
    """All ``trials``, and the step and estimated error [m] of their reference."""

    trials: tuple[ConvergenceTrial, ...]
    reference_step: float
    reference_error: float


def converge(
    scene: Scene,
    methods: Sequence[Method],
    steps: Sequence[float],
    tolerances: Sequence[float],
    report: Report = lambda text: None,
) -> ConvergenceStudy:
    """Run the scene with every method and step (adaptive methods: tolerance).

    Raises InputError if the steps have no common multiple at which to compare, and SimulationError
    if the reference fails.
    """
    fine = min(steps) / REFERENCE_STEP_RATIO
    scene = scene.with_output(step=common_multiple([*steps, 2 * fine], scene.output_step))
    report(f"reference: rk4 at {fine:g} s")
    reference = simulate(_scene_with_setting(scene, Method.RK4, fine))
    coarser = simulate(_scene_with_setting(scene, Method.RK4, 2 * fine))
    reference_error = _errors_of_run(coarser, reference)[0] / (2**REFERENCE_METHOD_ORDER - 1)
    trials = []
    for method, setting in _all_settings(methods, steps, tolerances):
        report(f"{method} at {setting:g}")
        trials.append(_make_trial(scene, method, setting, reference))
    return ConvergenceStudy(tuple(trials), fine, reference_error)


def common_multiple(steps: Sequence[float], wanted: float) -> float:
    """Multiple of all steps nearest above ``wanted`` [s], or the smallest one above it."""
    largest = max(steps)
    for k in range(max(1, round(wanted / largest)), 1000):
        if all(isclose(k * largest / s, round(k * largest / s), rel_tol=1e-9) for s in steps):
            return k * largest
    raise InputError(
        f"--steps: found {list(steps)} without a common multiple; expected simple"
        " ratios, such as 0.1,0.05."
    )


def to_dataset(study: ConvergenceStudy, title: str) -> xr.Dataset:
    """Study as a dataset over ``trial``."""
    trials = study.trials
    quantities = {
        "motion_error": ("motion", "largest error of a motion", "m"),
        "angle_error": ("angle", "largest error of an angle", "rad"),
        "crawl_error": ("crawl", "error of the crawl", "m"),
        "energy_error": ("energy", "relative residual of the energy balance", "1"),
        "wall_time": ("seconds", "run time", "s"),
        "evaluations": ("evaluations", "evaluations of the equation of motion", "1"),
        "setting": ("setting", "step [s], or relative tolerance", MIXED),
    }
    data = {
        name: describe_values("trial", [getattr(trial, field) for trial in trials], *of)
        for name, (field, *of) in quantities.items()
    }
    methods = [str(trial.method) for trial in trials]
    coords = {"method": describe_values("trial", methods, "method of integration")}
    attributes = {
        KIND: ResultKind.CONVERGENCE.value,
        "title": title,
        "reference_step": study.reference_step,
        "reference_error": study.reference_error,
    }
    return xr.Dataset(data, coords=coords, attrs=attributes)


def _all_settings(
    methods: Sequence[Method], steps: Sequence[float], tolerances: Sequence[float]
) -> Iterator[tuple[Method, float]]:
    for method in methods:
        for setting in sorted(tolerances if method.adapts else steps, reverse=True):
            yield method, setting


def _scene_with_setting(scene: Scene, method: Method, setting: float) -> Scene:
    """Scene with this method and step, or with this tolerance in m and 1; the tolerance of angles
    is a hundredth of it, as for an arm of 100 m."""
    solver = replace(scene.solver, linear=LinearScenes.STEP, accuracy=None)
    if method.adapts:
        tolerance = Tolerance(setting, setting, setting / 100)
        return replace(scene, solver=replace(solver, method=method, tolerance=tolerance))
    return replace(scene, solver=replace(solver, method=method, step=setting))


def _make_trial(
    scene: Scene, method: Method, setting: float, reference: xr.Dataset
) -> ConvergenceTrial:
    try:
        run = simulate(_scene_with_setting(scene, method, setting))
    except (InputError, SimulationError) as error:  # refused, or failed
        figures = (np.nan, np.nan, np.nan, np.nan, 0, np.nan)
        return ConvergenceTrial(method, setting, *figures, remark=str(error).splitlines()[0])
    a = run.attrs
    costs = (a["energy_residual_relative"], a["solver_evaluations"], a["wall_time"])
    return ConvergenceTrial(method, setting, *_errors_of_run(run, reference), *costs)


def _errors_of_run(run: xr.Dataset, reference: xr.Dataset) -> tuple[float, float, float]:
    """Largest differences of positions [m], of angles [rad], and of the final horizontal
    position."""
    difference = np.abs(run.position.values - reference.position.values)
    end = np.hypot(*(run.position.values - reference.position.values)[-1, :, :2].T)
    return float(difference[..., :3].max()), float(difference[..., 3:].max()), float(end.max())
