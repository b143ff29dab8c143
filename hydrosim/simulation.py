"""`simulate` runs a case or a scene, with its earlier stages; `open_run` reads a run from its file.

Runs in stages: cases that use the results of other cases.

A recorded series of a case may name the case that produces it. `complete_stages` simulates such a
case if its result is missing, or was made from a different text of that case or by another version
of the program.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydrosim.case import as_case
from hydrosim.case.criteria import CRITERIA
from hydrosim.compile.clock import compile_clock
from hydrosim.compile.compile import compile_scene
from hydrosim.compile.compiled import Compiled
from hydrosim.elements import externals_of, function_errors, with_own_functions
from hydrosim.errors import InputError, SimulationError
from hydrosim.files.arguments import Target, output_for
from hydrosim.files.cache import program_version
from hydrosim.files.outputs import Output, read_attribute
from hydrosim.files.units import factor
from hydrosim.files.yaml_nodes import source_context
from hydrosim.integrate.record import new_record
from hydrosim.linear.propagate import propagate
from hydrosim.results.dataset import RUN_FILE_HINT, read_run, write_run
from hydrosim.results.output import to_dataset
from hydrosim.results.run_data import as_xarray
from hydrosim.run.checkpoint import Checkpoint, checkpoint_of
from hydrosim.run.course import RunInProgress
from hydrosim.run.error_estimate import estimate_error, repeat_until_accurate
from hydrosim.run.functions import resume_functions
from hydrosim.run.step_limits import add_step_warnings
from hydrosim.scene import ForceElement, Scene
from hydrosim.statistics.figures import figure_asked, figure_of

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.case.load import Case, Stage
    from hydrosim.results.ledger import ErrorEstimate

# Criteria before a run: whether it will have the channels and contacts that they name.


class NotAskable(InputError):
    """Criteria of a case that its run cannot be held against."""


def check_criteria(compiled: Compiled) -> None:
    """Raises NotAskable with a line for each criterion that the run cannot be held against."""
    asked = json.loads(compiled.scene.source.get(CRITERIA, "[]"))
    if not asked:
        return
    run = blank_run(compiled)
    reasons = [text for criterion in asked if (text := _refusal_reason(run, criterion))]
    if reasons:
        raise NotAskable("\n".join(reasons))


def blank_run(compiled: Compiled) -> xr.Dataset:
    """The dataset of a run with a single record of zeros: names, dimensions and units."""
    model = compiled.model
    record = new_record(model, compile_clock(compiled), compiled.scene.output.accelerations)
    history = compiled.first_state().history
    layout = compiled.derived.layout
    run = to_dataset(compiled.scene, model, layout, compiled.sea, record, 1, history, {})
    return as_xarray(run)


def _refusal_reason(run: xr.Dataset, asked: dict[str, str]) -> str:
    """Why a criterion cannot be judged, at its key; empty if it can be."""
    try:
        figure = figure_of(run, figure_asked(asked))
    except InputError as error:
        given = [key for key in ("group", "phase", "channel") if asked.get(key)]
        wrong = next((key for key in given if asked[key] in str(error)), "result")
        return f"criteria.{asked['name']}.{wrong}: {error}"
    return _unit_refusal_reason(str(figure.attrs["units"]), asked)


def _unit_refusal_reason(channel_unit: str, asked: dict[str, str]) -> str:
    """Why a limit cannot be compared with a figure in ``channel_unit`` (SI); empty if it can be."""
    unit = "" if channel_unit == "1" else channel_unit
    try:
        if asked["unit"]:
            factor(asked["unit"], unit)
    except ValueError as error:
        return (
            f'criteria.{asked["name"]}.limit: found "{asked["text"]}"; expected a limit in'
            f" {unit or 'plain numbers'}, which {asked['channel'] or asked['result']} has; {error}"
        )
    return ""


def outdated_reason(stage: Stage) -> str | None:
    """Reason why the case of a stage must be run, for the first time or again. None if the
    existing result belongs to the present case and program."""
    if not os.path.isfile(stage.file):
        return f"{stage.file} does not exist"
    case, program, status = (
        read_attribute(stage.file, name) for name in ("case", "program", "status")
    )
    if not (case or program or status):
        return f"{stage.file} is not the result of a run"
    if case != stage.case.text:
        return f"{stage.file} was made from a different text of {stage.case.path}"
    if program != f"hydrosim {program_version()}":
        return f"{stage.file} was made by {program}"
    if status != "complete":
        return f"{stage.file} is the result of an incomplete run"
    return None


def complete_stages(
    case: Case,
    run: Callable[[Case, Output], xr.Dataset],
    announce: Callable[[str], None] = lambda _: None,
    above: tuple[Path, ...] = (),
) -> bool:
    """Make the runs that ``case`` needs with ``run``, which receives the path of the result, in
    order; True if any was made.

    ``announce`` receives the reason for each run. ``above`` are the cases that need this one.
    Raises InputError if cases need each other, and KeyboardInterrupt if a run is interrupted; only
    complete runs are written.
    """

    chain = (*above, case.path.resolve())
    made = False
    for stage in case.stages():
        if stage.case.path.resolve() in chain:
            raise InputError(
                f"{case.path}: found a series from a run of {stage.case.path}, which itself needs"
                " a run of this case; expected cases that do not need each other."
            )
        anew = complete_stages(stage.case, run, announce, chain)
        reason = f"{stage.file} needs another run" if anew else outdated_reason(stage)
        if reason:
            result = _stage_output(stage)
            announce(f"{reason}: simulating {stage.case.path}")
            with result.hold_lock():
                dataset = run(stage.case, result)
                if dataset.attrs["status"] == "interrupted":
                    raise KeyboardInterrupt
                write_run(dataset, result)
                checkpoint_of(result).clear()
            made = True
    return made


def _stage_output(stage: Stage) -> Output:
    """Output of a stage, beside its own case. A case file writes no file elsewhere, and replaces
    only an earlier run of that case."""
    home = stage.case.path.parent
    key = f"file: {stage.file.name} (a run of {stage.case.path})"
    if not stage.file.parent.resolve() == home.resolve() or stage.file.suffix != ".nc":
        raise InputError(
            f"{key}: found {stage.file}; expected a file that ends in .nc, in the folder {home}."
            " hydrosim runs the earlier case first, and writes its result into that case's folder."
        )
    inputs = stage.case.inputs()
    made = Output(
        stage.file, "run", stage.case.path, inputs, option=key, settings=stage.case.settings()
    )
    return made.checked_output()


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
    *,
    output: Target = None,
    overwrite: bool = False,
    resume: bool = False,
) -> xr.Dataset:
    """Run a case, the case in a file, a scene or a compiled scene. `hydrosim.results.output`
    describes the dataset.
    Runs that a case needs are made first, see `complete_stages`. Cases and scenes are
    compiled ``in_plane``, which leaves out motions that are zero by symmetry; a compiled scene is
    run as it is. With ``kept``, checkpoints are saved to disk; the caller removes them after
    writing the result. ``forces`` are added to those of the case, by name: functions of Python
    (`hydrosim.UserForce`), or other elements.

    An interrupt from the keyboard ends the run early, with ``status`` "interrupted". Raises
    InputError if the scene cannot be compiled or has not the channels of its criteria, and
    SimulationError if the run cannot continue. That error carries the ``dataset`` until then, with
    ``status`` "failed".

    A case is also written to the file ``output``, as by `hydrosim run`: True stands for the name of
    the case, and ``resume`` continues a run that was killed.

    >>> run = hs.simulate(hs.load_case("cases/friction_block/exact.yaml", {"duration": "20 s"}))
    >>> run.position.dims
    ('time', 'body', 'dof')
    """
    if isinstance(progress, Mapping):
        raise InputError(
            "progress: found a mapping; expected a function. To change values of a case, give"
            " hs.load_case(path, {key: value})."
        )
    if output in (None, False):
        return as_xarray(simulate_data(case, progress, kept, forces))
    if isinstance(case, Compiled | Scene):
        raise InputError("output: found a scene; expected a case. Call to_netcdf on its run.")
    read = as_case(case)
    result = run_output(read, output, overwrite)
    checkpoint = kept or Checkpoint(checkpoint_of(result), resume=resume)
    with result.hold_lock():
        scene = prepare_scene(read, progress)
        try:
            data = simulate_data(scene, progress, checkpoint, forces)
        except SimulationError as error:
            save_run(error.run_data, result)
            raise
        save_run(data, result)
    return as_xarray(data)


def run_output(case: Case, output: Target, overwrite: bool = False) -> Output:
    """Output for the run of a case; raises InputError as `output_for` does."""
    result = output_for(
        output,
        case.path.stem,
        "run",
        case.path,
        inputs=case.inputs(),
        overwrite=overwrite,
        settings=case.settings(),
    )
    if result is None:
        raise InputError("output: found none; expected a file.")
    return result


def save_run(dataset: xr.Dataset, result: Output) -> Path:
    """Write a run; return its path. A run that did not complete never replaces a complete one. No
    run replaces a file that appeared while it was computed."""
    status = dataset.attrs["status"]
    is_worse = status != "complete" and read_attribute(result.path, "status") == "complete"
    place = result.fallback_path() if is_worse else result.resolve_path()
    write_run(dataset, place)
    if status != "interrupted":
        checkpoint_of(result).clear()
    return place.path


def simulate_data(
    case: Case | Scene | Compiled | str | Path,
    progress: Progress | None = None,
    kept: Checkpoint | None = None,
    forces: Mapping[str, ForceElement] | None = None,
) -> xr.Dataset:
    """`simulate` without loading xarray: its `RunData`."""
    if isinstance(case, Compiled):
        if forces:
            raise InputError("forces: found a compiled scene; add them to the scene before.")
        return advance_to_end(check_compiled(case), progress, kept)
    if isinstance(case, Scene):
        scene = with_forces(case, forces or {})
        # no name for the compiled scene: `advance_to_end` lets go of its waves
        return advance_to_end(compiled_to_run(scene), progress, kept)
    return simulate_data(prepare_scene(case, progress), progress, kept, forces)


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
    read = as_case(case)
    complete_stages(read, lambda stage, _: simulate(stage, progress))
    return read.scene()


def run_compiled(compiled: Compiled, *arguments: Any, **options: Any) -> xr.Dataset:
    """The dataset of `advance_to_end`, which takes the same arguments."""
    return as_xarray(advance_to_end(compiled, *arguments, **options))


def advance_to_end(
    compiled: Compiled,
    progress: Progress | None = None,
    checkpoint: Checkpoint | None = None,
    estimates: bool = True,
    repeats: bool = True,
) -> xr.Dataset:
    """`simulate_data` for a compiled scene whose step limits are known. With ``estimates``, a
    companion measures the error of the run. With ``repeats``, a run that misses the accuracy of its
    scene is then made again."""
    course = RunInProgress(compiled, checkpoint, propagate if compiled.derived.exact else None)
    del compiled  # the course lets go of its waves

    def advance(course: RunInProgress) -> RunInProgress:
        for time in course.chunks():
            if progress is not None:
                progress(time, course.steps)
        return course

    def solve(compiled: Compiled) -> RunInProgress:
        return advance(RunInProgress(compiled))

    def report_repeat_progress(_: float) -> None:
        if progress is not None:
            progress(course.time, course.steps)

    def measure(course: RunInProgress) -> ErrorEstimate:
        return estimate_error(course.compiled, course.run, report_repeat_progress)

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
    return course.data(estimate)


def can_measure_error(course: RunInProgress) -> bool:
    """True if the error of a course can be measured: it is complete and stepped, and no function is
    called once per step, which may remember."""
    compiled = course.compiled
    once = any(external.delayed for external in externals_of(compiled.scene.forces).values())
    return course.complete and not once and not compiled.derived.exact


# `open_run`: reads the dataset of a run from its file.


def open_run(path: str | Path) -> xr.Dataset:
    """Dataset of the run in the netCDF file ``path``, in memory. Raises InputError if the file is
    missing, is not netCDF, is not the result of a run, or has fewer than two records.

    >>> case = hs.load_case("cases/friction_block/exact.yaml", {"duration": "20 s"})
    >>> run = hs.simulate(case, output="block.nc")
    >>> hs.open_run("block.nc").position.identical(run.position)
    True
    """
    run = read_run(Path(path))
    require_two_records(run, path)
    return run


def require_two_records(run: xr.Dataset, path: str | Path) -> None:
    """Raises InputError if the run in a file has fewer than two records."""
    if run.sizes["time"] < 2:
        raise InputError(
            f"{path}: has fewer than two recorded times, so there is nothing to draw;"
            f" {RUN_FILE_HINT}."
        )
