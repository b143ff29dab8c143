"""`simulate`: runs a case or a scene, and returns its dataset."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from hydrosim.case import load_case
from hydrosim.compiling.compile import compile_scene
from hydrosim.compiling.compiled import Compiled
from hydrosim.documents.yaml_nodes import source_context
from hydrosim.errors import InputError
from hydrosim.forces import externals_of, function_errors, with_own_functions
from hydrosim.linear.propagate import propagate
from hydrosim.scene import ForceElement, Scene
from hydrosim.studies.run.accuracy import repeat_until_accurate
from hydrosim.studies.run.asked import check_criteria
from hydrosim.studies.run.checkpoint import Checkpoint
from hydrosim.studies.run.course import RunInProgress
from hydrosim.studies.run.error_estimate import estimate_error
from hydrosim.studies.run.functions import resume_functions
from hydrosim.studies.run.stages import complete_stages
from hydrosim.studies.run.step_limits import add_step_warnings

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.case import Case
    from hydrosim.results.error_figures import ErrorEstimate

FORCE_NAME = re.compile(r"\w+")
Progress = Callable[[float, int], None]
"""Function that is called at times with the simulated time [s] and the number of steps. While the
error of a run is measured, it is called with those at the end. If the run is made again, the time
begins anew."""


def simulate(
    case: Case | Scene | Compiled | str | Path,
    progress: Progress | None = None,
    kept: Checkpoint | None = None,
    forces: Mapping[str, ForceElement] | None = None,
) -> xr.Dataset:
    """Run a case, the case in a file, a scene or a compiled scene. `hydrosim.results.output`
    describes the dataset.
    Runs that a case needs are made first, see `hydrosim.studies.run.stages`. Cases and scenes are
    compiled ``in_plane``, which leaves out motions that are zero by symmetry; a compiled scene is
    run as it is. With ``kept``, checkpoints are saved to disk; the caller removes them after
    writing the result. ``forces`` are added to those of the case, by name: functions of Python
    (`hydrosim.External`), or other elements.

    An interrupt from the keyboard ends the run early, with ``status`` "interrupted". Raises
    InputError if the scene cannot be compiled or has not the channels of its criteria, and
    SimulationError if the run cannot continue. That error carries the ``dataset`` until then, with
    ``status`` "failed".
    """
    if isinstance(case, Compiled):
        if forces:
            raise InputError("forces: found a compiled scene; add them to the scene before.")
        return run_compiled(check_compiled(case), progress, kept)
    if isinstance(case, Scene):
        scene = with_forces(case, forces or {})
        # no name for the compiled scene: `run_compiled` lets go of its waves
        return run_compiled(compiled_to_run(scene), progress, kept)
    return simulate(prepare_scene(case, progress), progress, kept, forces)


def compiled_to_run(scene: Scene) -> Compiled:
    """The scene compiled to run, with warnings of its step. Raises InputError if that cannot be,
    or if the function of an external force fails."""
    if externals_of(scene.forces):
        scene = replace(scene, forces=with_own_functions(scene.forces))
    with source_context(scene.places):
        try:
            compiled = check_compiled(compile_scene(scene, in_plane=True))
        except Exception:
            _check_functions(scene)  # the cause, if it is one of them
            raise
        _check_functions(scene)
        return resume_functions(compiled)


def _check_functions(scene: Scene) -> None:
    """Raises InputError if the function of an external force has failed."""
    for name, error in function_errors(scene.forces):
        if isinstance(error, KeyboardInterrupt):
            raise error
        raise InputError(
            f"forces.{name}.function: it fails ({type(error).__name__}: {error}); expected a"
            " wrench (6,) [N, N m] for f(t, state). It is called before the run too, near the"
            " start, for periods and step limits. Correct the function: its traceback is the"
            " cause of this error."
        ) from error


def with_forces(scene: Scene, forces: Mapping[str, ForceElement]) -> Scene:
    """The scene with ``forces`` besides its own. Raises InputError if one is there already."""
    for name in forces:
        if name in scene.forces:
            raise InputError(f"forces.{name}: the case has one of that name; choose another.")
        if not FORCE_NAME.fullmatch(name):
            raise InputError(
                f"forces: found the name {name!r}; expected letters, digits and underscores, as"
                " in a case file."
            )
    extended = replace(scene, forces={**scene.forces, **forces})
    delayed = [name for name, e in externals_of(extended.forces).items() if e.delayed]
    if extended.at_rest and delayed:
        raise InputError(
            f"forces.{', '.join(delayed)}: at_rest looks for the place of rest before the run, and"
            " a function that is called once per step gives no force by then. Give the positions"
            " of the bodies instead, or coupling stage."
        )
    return extended


def check_compiled(compiled: Compiled) -> Compiled:
    """The scene with warnings of its step, once its run is known to have what its criteria ask."""
    check_criteria(compiled)
    return add_step_warnings(compiled)


def prepare_scene(case: Case | Scene | str | Path, progress: Progress | None = None) -> Scene:
    """Scene of a case or of the case in a file, after the runs that it needs were made."""
    if isinstance(case, Scene):
        return case
    read = load_case(case) if isinstance(case, str | Path) else case
    complete_stages(read, lambda stage, _: simulate(stage, progress))
    return read.scene()


def run_compiled(
    compiled: Compiled,
    progress: Progress | None = None,
    kept: Checkpoint | None = None,
    estimates: bool = True,
    repeats: bool = True,
) -> xr.Dataset:
    """`simulate` for a compiled scene whose step limits are known. With ``estimates``, a companion
    measures the error of the run. With ``repeats``, a run that misses the accuracy of its scene is
    then made again."""
    course = RunInProgress(compiled, kept, propagate if compiled.facts.exact else None)
    del compiled  # the course lets go of its waves

    def advance(course: RunInProgress) -> RunInProgress:
        for time in course.chunks():
            if progress is not None:
                progress(time, course.steps)
        return course

    def solve(compiled: Compiled) -> RunInProgress:
        return advance(RunInProgress(compiled))

    def watch(_: float) -> None:
        if progress is not None:
            progress(course.time, course.steps)

    def measure(course: RunInProgress) -> ErrorEstimate:
        return estimate_error(course.compiled, course.run, watch)

    estimate = None
    try:
        advance(course)
        if estimates and can_measure_error(course):
            if repeats:
                course, estimate = repeat_until_accurate(course, solve, measure)
            else:
                estimate = measure(course)
    except KeyboardInterrupt as interrupt:
        course.interrupt(interrupt)
    return course.dataset(estimate)


def can_measure_error(course: RunInProgress) -> bool:
    """True if the error of a course can be measured: it is complete and stepped, and no function is
    called once per step, which may remember."""
    compiled = course.compiled
    once = any(external.delayed for external in externals_of(compiled.scene.forces).values())
    return course.complete and not once and not compiled.facts.exact
