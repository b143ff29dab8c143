"""References of runs, the same scene by dopri5 at tight tolerances, and errors against them.

Errors of motions are relative to their range. Positions and angles of a body are judged apart. Of
positions it is the largest difference of the three coordinates over their largest range. Of angles
it is the largest component of the rotation vector between both attitudes over the largest range of
the three angles. Ranges are at least those of `least_ranges`.
"""

from dataclasses import replace
from math import ceil

import numpy as np
import xarray as xr
from scipy.spatial.transform import Rotation

from hydrosim.compile.compile import compile_scene
from hydrosim.compile.compiled import Compiled
from hydrosim.linear.stability import smallest_step
from hydrosim.run.error_estimate import MIN_CHOSEN_RANGE, TOLERANCES_IN_RANGE
from hydrosim.run.step_limits import scene_combinations
from hydrosim.scene import LinearScenes, Method, Scene, Solver, Tolerance
from hydrosim.scene.scene import fitting_step
from hydrosim.simulation import run_compiled

COARSE, FINE = 1e-10, 1e-11  # tolerances of references
SPACING = 0.05
"""Time between records of a reference [s], at most: it sees the peaks of loads."""
SMALLEST_RANGES = (1e-6, 1e-6)  # m, rad
SAFE = 0.9  # of the largest stable step


def compile_reference(scene: Scene, spacing: float = SPACING) -> tuple[Compiled, int]:
    """The scene compiled with the finer tolerance, and its records per record of the scene."""
    finer = ceil(scene.output_step / spacing - 1e-9)
    output_step = scene.output_step / finer
    tight = Tolerance(FINE, FINE, FINE)
    exactly = {"linear": LinearScenes.STEP, "kinematics": scene.solver.kinematics}
    solver = Solver(Method.DOPRI5, min(0.005, output_step), tight, **exactly)
    scene = replace(scene, solver=solver).with_output(step=output_step)
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
    if compiled.derived.exact:
        return scene
    limit = SAFE * smallest_step(scene_combinations(compiled), compiled.method)
    if scene.solver.step <= limit:
        return scene
    return replace(scene, solver=replace(scene.solver, step=fitting_step(scene.output_step, limit)))


def least_ranges(solver: Solver, accuracy: float | None) -> tuple[float, float]:
    """Least ranges of positions [m] and of angles [rad] of a run, as it states its own error. With
    an ``accuracy`` its method was chosen by the program."""
    if accuracy is not None:
        return MIN_CHOSEN_RANGE
    if not solver.method.adapts:
        return SMALLEST_RANGES
    asked = (solver.tolerance.position, solver.tolerance.angle)
    places, angles = (TOLERANCES_IN_RANGE * tolerance for tolerance in asked)
    return max(places, SMALLEST_RANGES[0]), max(angles, SMALLEST_RANGES[1])


def motion_errors(
    ours: np.ndarray,
    theirs: np.ndarray,
    exact: bool = True,
    least: tuple[float, float] = SMALLEST_RANGES,
) -> np.ndarray:
    """Errors (nt, nb) of ``ours`` against ``theirs``, both (nt, nb, 6) in m and rad as `position`
    is recorded. ``exact`` is false for small angles. ``least`` ranges are in m and rad."""
    ranges = np.ptp(theirs, axis=0).reshape(-1, 2, 3).max(axis=2)
    gaps = ours - theirs
    if exact:
        gaps = np.concatenate([gaps[..., :3], _rotation_vectors(ours, theirs)], axis=2)
    largest = np.abs(gaps).reshape(*gaps.shape[:2], 2, 3).max(axis=3)
    return np.asarray((largest / np.maximum(ranges, least)).max(axis=2))


def _rotation_vectors(ours: np.ndarray, theirs: np.ndarray) -> np.ndarray:
    """Rotation vectors (nt, nb, 3) from their attitudes to ours."""
    to_ours = _attitudes(ours) * _attitudes(theirs).inv()
    return np.asarray(to_ours.as_rotvec()).reshape(*ours.shape[:2], 3)


def _attitudes(position: np.ndarray) -> Rotation:
    """Attitudes (nt nb,) of roll, pitch and yaw, R = Rz(yaw) Ry(pitch) Rx(roll)."""
    return Rotation.from_euler("ZYX", position[..., :2:-1].reshape(-1, 3))
