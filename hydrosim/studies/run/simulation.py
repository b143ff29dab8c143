"""`simulate`: runs a case or a scene, and returns its dataset."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from hydrosim.case import load_case
from hydrosim.compiling.compile import compile_scene
from hydrosim.compiling.compiled import Compiled
from hydrosim.documents.places import locating
from hydrosim.scene import Scene
from hydrosim.studies.run.asked import check_criteria
from hydrosim.studies.run.checkpoint import Checkpoint
from hydrosim.studies.run.course import Course
from hydrosim.studies.run.stages import complete
from hydrosim.studies.run.step_limits import warned_of_steps

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.case import Case

Progress = Callable[[float, int], None]
"""Function that is called at times with the simulated time [s] and the number of steps."""


def simulate(
    case: Case | Scene | Compiled | str | Path,
    progress: Progress | None = None,
    kept: Checkpoint | None = None,
) -> xr.Dataset:
    """Run a case, the case in a file, a scene or a compiled scene. `hydrosim.results.output`
    describes the dataset.
    Runs that a case needs are made first, see `hydrosim.studies.run.stages`. Cases and scenes are
    compiled ``in_plane``, which leaves out motions that are zero by symmetry; a compiled scene is
    run as it is. With ``kept``, checkpoints are saved to disk; the caller removes them after
    writing the result.

    An interrupt from the keyboard ends the run early, with ``status`` "interrupted". Raises
    InputError if the scene cannot be compiled or has not the channels of its criteria, and
    SimulationError if the run cannot continue. That error carries the ``dataset`` until then, with
    ``status`` "failed".
    """
    if isinstance(case, Compiled):
        return run_compiled(_checked(case), progress, kept)
    if isinstance(case, Scene):
        with locating(case.places):
            # no name for the compiled scene: `run_compiled` lets go of its waves
            return run_compiled(_checked(compile_scene(case, in_plane=True)), progress, kept)
    return simulate(prepared(case, progress), progress, kept)


def _checked(compiled: Compiled) -> Compiled:
    """The scene with warnings of its step, once its run is known to have what its criteria ask."""
    check_criteria(compiled)
    return warned_of_steps(compiled)


def prepared(case: Case | Scene | str | Path, progress: Progress | None = None) -> Scene:
    """Scene of a case or of the case in a file, after the runs that it needs were made."""
    if isinstance(case, Scene):
        return case
    read = load_case(case) if isinstance(case, str | Path) else case
    complete(read, lambda stage, _: simulate(stage, progress))
    return read.scene()


def run_compiled(
    compiled: Compiled,
    progress: Progress | None = None,
    kept: Checkpoint | None = None,
    estimates: bool = True,
) -> xr.Dataset:
    """`simulate` for a compiled scene whose step limits are known. With ``estimates``, a twin run
    estimates its error."""
    course = Course(compiled, kept)
    del compiled  # the course lets go of its waves
    return run_to_end(course, progress, estimates)


def run_to_end(
    course: Course, progress: Progress | None = None, estimates: bool = True
) -> xr.Dataset:
    """Advance a course to its end, or to an interrupt; its dataset."""
    try:
        for time in course.chunks():
            if progress is not None:
                progress(time, course.steps)
    except KeyboardInterrupt as interrupt:
        course.interrupt(interrupt)
    return course.dataset(estimates)
