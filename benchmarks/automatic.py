"""Is `solver: {method: automatic, tolerance: E}` as exact as asked, and how dear beside the best?

Six scenes, each at tolerances of 1e-4 to 1e-8. Every scene is also run by rk4 over steps, each half
of the last, and by dopri5 and esdirk4 over tolerances, each a tenth of the last. The best is the
cheapest of these that is within E. Errors are the largest ones of places, and of angles, over their
range, against dopri5 at 1e-10; CPU times are those of the time loop alone. An error beyond E counts
as told if the run says so.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import ceil, inf, nan, radians
from pathlib import Path

import numpy as np
import xarray as xr

from benchmarks.base_case import SHORT, short_case
from benchmarks.compiled import compiled
from benchmarks.method_costs import stiff_case
from benchmarks.report import ROOT, Answer, Row
from benchmarks.timing import time_loop
from hydrosim import SimulationError, load_case
from hydrosim.scene import LinearScenes, Method, Scene, Tolerance, Unstable

ASKED = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
STEPS = tuple(0.2 / 2**k for k in range(8))
STIFF_STEPS = (1 / 700, 1 / 1400)
TOLERANCES = tuple(10.0**-k for k in range(3, 11))
FINE = 1e-10
LEAST = 1e-6  # m, rad: a smaller range is none
REPEATS = 2


@dataclass(frozen=True)
class Trial:
    """A run: its ``error`` over the range, CPU time [s], and whether it ``tells`` of an error."""

    solver: str
    error: float
    seconds: float
    tells: bool


def answer() -> Answer:
    """Errors and CPU times of automatic beside the best of the three."""
    rows: list[Row] = []
    for name, make in SCENES.items():
        scene = make()
        scene = replace(scene, solver=replace(scene.solver, unstable=Unstable.WARN))
        fine = _motions(time_loop(compiled(_tolerant(scene, Method.DOPRI5, FINE), True)).result)
        trials = [_trial(each, fine) for each in _by_hand(scene, name)]
        rows.extend(_row(name, scene, asked, fine, trials) for asked in ASKED)
    worst = max(float(row["CPU over the best"]) for row in rows)
    silent = [row for row in rows if row["within, or told"] == "no"]
    return Answer(
        {"automatic beside the cheapest of rk4, dopri5 and esdirk4 within the tolerance": rows},
        [f"Largest ratio {worst:.2g}; {len(silent)} of {len(rows)} beyond and not told."],
    )


def _row(
    name: str, scene: Scene, asked: float, fine: np.ndarray, trials: list[Trial]
) -> dict[str, str | float]:
    solver = replace(scene.solver, method=Method.AUTOMATIC, accuracy=asked)
    found = _trial(replace(scene, solver=solver), fine)
    good = [trial for trial in trials if trial.error <= asked]
    best = min(good, key=lambda trial: trial.seconds, default=Trial("none", nan, inf, False))
    kept = found.error <= asked or found.tells
    return {
        "scene": name,
        "tolerance": f"{asked:g}",
        "chosen": found.solver,
        "error": f"{found.error:.1e}",
        "within, or told": "within" if found.error <= asked else "told" if kept else "no",
        "CPU [s]": found.seconds,
        "best": best.solver,
        "CPU over the best": found.seconds / best.seconds,
    }


def _by_hand(scene: Scene, name: str) -> list[Scene]:
    """The scene by all methods, steps and tolerances that an engineer would try."""
    steps = STIFF_STEPS if name == STIFF else STEPS
    equal = [_stepped(scene, step) for step in steps]
    methods = (Method.DOPRI5, Method.ESDIRK4)
    return [*equal, *(_tolerant(scene, m, relative) for m in methods for relative in TOLERANCES)]


def _stepped(scene: Scene, step: float) -> Scene:
    """By rk4 with about this step [s], which fits the records."""
    fitting = scene.output_step / ceil(scene.output_step / step - 1e-9)
    return replace(scene, solver=replace(scene.solver, method=Method.RK4, step=fitting))


def _tolerant(scene: Scene, method: Method, relative: float) -> Scene:
    tolerance = Tolerance(relative, relative, relative / 100)
    return replace(scene, solver=replace(scene.solver, method=method, tolerance=tolerance))


def _trial(scene: Scene, fine: np.ndarray) -> Trial:
    """The error of a run, and the least of its times; a run that fails is infinitely wrong."""
    several = compiled(scene, in_plane=True)
    solver = several.scene.solver
    setting = solver.tolerance.relative if solver.method.adapts else solver.step
    label = f"{solver.method} {setting:.2g}"
    try:
        runs = [time_loop(several) for _ in range(REPEATS)]
    except SimulationError:
        return Trial(label, inf, inf, True)
    seconds = min(run.seconds for run in runs)
    tells = "of its range by" in str(runs[0].result.attrs.get("warnings", ""))
    return Trial(label, _error(_motions(runs[0].result), fine), seconds, tells)


def _motions(run: xr.Dataset) -> np.ndarray:
    return np.asarray(run.position.values)


def _error(motions: np.ndarray, fine: np.ndarray) -> float:
    """Largest error of places and of angles of any body, over their range."""
    shape = (fine.shape[1], 2, 3)
    ranges = np.ptp(fine, axis=0).reshape(shape).max(axis=2)
    errors = np.abs(motions - fine).max(axis=0).reshape(shape).max(axis=2)
    return float((errors / np.maximum(ranges, LEAST)).max())


def _oblique() -> Scene:
    scene = short_case(0.1)
    (train,) = scene.environment.waves
    sea = replace(scene.environment, waves=(replace(train, heading=radians(30.0)),))
    return replace(scene, environment=sea)


def _beginning(case: str, duration: float) -> Callable[[], Scene]:
    """The first ``duration`` [s] of a case, stepped."""

    def made() -> Scene:
        scene = load_case(ROOT / "cases" / Path(case)).scene()
        solver = replace(scene.solver, linear=LinearScenes.STEP)
        return replace(scene, duration=duration, output_step=0.5, solver=solver)

    return made


STIFF = "the same with K2 a hundred times as stiff"
SCENES: dict[str, Callable[[], Scene]] = {
    f"base case, {SHORT:g} s": lambda: short_case(0.1),
    "the same in a sea to 30 deg": _oblique,
    STIFF: lambda: stiff_case(0.1, Method.RK4),
    "sphere, 600 s": _beginning("sphere/irregular.yaml", 600.0),
    "removal, 600 s": _beginning("topside_removal/removal.yaml", 600.0),
    "mating, 300 s": _beginning("mating/mating.yaml", 300.0),
}
