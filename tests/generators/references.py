"""References of runs: the same scene by dopri5 at tight tolerances."""

from __future__ import annotations

from dataclasses import replace
from math import ceil

import xarray as xr

from hydrosim.compiling.compile import compile_scene
from hydrosim.compiling.compiled import Compiled
from hydrosim.linear.stability import smallest_step
from hydrosim.scene import LinearScenes, Method, Scene, Solver, Tolerance
from hydrosim.scene.solver import fitting_step
from hydrosim.studies.run.resolution import scene_combinations
from hydrosim.studies.run.simulation import run_compiled

COARSE, FINE = 1e-10, 1e-11  # tolerances of references
SPACING = 0.05
"""Time between records of a reference [s], at most: it sees the peaks of loads."""
SAFE = 0.9  # of the largest stable step


def compile_reference(scene: Scene, spacing: float = SPACING) -> tuple[Compiled, int]:
    """The scene compiled with the finer tolerance, and its records per record of the scene."""
    finer = ceil(scene.output_step / spacing - 1e-9)
    output_step = scene.output_step / finer
    solver = Solver(
        Method.DOPRI5,
        min(0.005, output_step),
        Tolerance(FINE, FINE, FINE),
        linear=LinearScenes.STEP,
        kinematics=scene.solver.kinematics,
    )
    scene = replace(scene, solver=solver, output_step=output_step)
    return compile_scene(scene, in_plane=True), finer


def run_reference(compiled: Compiled, tolerance: float) -> xr.Dataset:
    """Run what `compile_reference` made with a tolerance. Raises as `simulate` does."""
    solver = replace(compiled.scene.solver, tolerance=Tolerance(*3 * (tolerance,)))
    scene = replace(compiled.scene, solver=solver)
    return run_compiled(replace(compiled, scene=scene), estimates=False)


def at_stable_step(scene: Scene) -> Scene:
    """The scene by rk4 at its own step, or at a smaller one that is stable."""
    solver = replace(scene.solver, method=Method.RK4, accuracy=None)
    step = fitting_step(scene.output_step, solver.step)
    scene = replace(scene, solver=replace(solver, step=step))
    compiled = compile_scene(scene, in_plane=True)
    if compiled.facts.exact:
        return scene
    limit = SAFE * smallest_step(scene_combinations(compiled), compiled.method)
    if scene.solver.step <= limit:
        return scene
    return replace(scene, solver=replace(scene.solver, step=fitting_step(scene.output_step, limit)))
