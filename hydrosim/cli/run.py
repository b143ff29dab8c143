"""Commands that simulate: `hydrosim run` a case, `hydrosim study` many runs of it."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime, timedelta
from math import nan
from pathlib import Path
from shutil import disk_usage
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

import typer

from hydrosim.cli import options, terminal
from hydrosim.cli.options import option
from hydrosim.cli.terminal import simulate_with_progress
from hydrosim.errors import InputError, SimulationError

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.case import Case
    from hydrosim.files.outputs import Output


def run(
    case_file: options.CaseFile,
    plot: options.Plot = False,
    resume: options.Resume = False,
    checkpoint: Annotated[
        str,
        option("Interval at which the state is saved: 10 min, or seconds.", metavar="TIME"),
    ] = "60 s",
    output: options.Output = None,
    verbose: options.Verbose = False,
    overwrite: options.Overwrite = False,
    settings: options.Settings = [],  # noqa: B006  typer copies it
) -> None:
    """Simulate a case; write netCDF and print a summary."""
    from hydrosim.case.load import load_case
    from hydrosim.files.arguments import seconds
    from hydrosim.report.sentences.run import run_document
    from hydrosim.simulation import require_two_records, run_output, save_run

    case = load_case(case_file, settings)
    result = run_output(case, output or True, overwrite)
    if plot:  # no picture would replace another file
        from hydrosim.report.charts.pictures import draw, picture_outputs

        picture_outputs(result.path.parent, result.path.stem, result.path, overwrite)
    interval = seconds("checkpoint", checkpoint, 60.0)
    if interval < 0.0:
        raise InputError(f"checkpoint: found {interval:g} s; expected a time of 0 s or more.")

    def simulate_case(case: Case, result: Output) -> xr.Dataset:
        return simulate_with_progress(case, result, resume, interval)

    terminal.print_status(terminal.case_summary_line(case))
    with result.hold_lock():
        terminal.run_earlier_stages(case, simulate_case)
        _require_room(case, result.path)
        try:
            dataset = simulate_case(case, result)
        except SimulationError as error:
            terminal.print_lines(f"result    {save_run(error.run_data, result)}")
            raise
        path = save_run(dataset, result)
    terminal.show_document(run_document(_locate_warnings(dataset, case)), verbose)
    terminal.print_lines(f"result    {path}")
    if plot:
        require_two_records(dataset, path)
        with terminal.progress("drawing"):
            pictures = draw(dataset, path.parent, path.stem, path, overwrite)
        terminal.print_lines(*(f"picture   {picture}" for picture in pictures))
    if dataset.attrs["status"] == "interrupted":
        raise typer.Exit(130)


def _locate_warnings(dataset: xr.Dataset, case: Case) -> xr.Dataset:
    """Dataset of the run, whose warnings name file and line of a key when printed; the result
    itself stores no paths."""
    from hydrosim.files.yaml_nodes import add_source_lines

    text = dataset.attrs.get("warnings")
    return dataset.assign_attrs(warnings=add_source_lines(text, case.places)) if text else dataset


def _require_room(case: Case, path: Path) -> None:
    """Raises InputError if the result of a run would not fit on the disk."""
    from hydrosim.compile import sizes

    size = sizes.result_size(case.scene())
    free = disk_usage(path.parent).free
    if size > free:
        found_text = f"about {sizes.size_text(size)}, and {sizes.size_text(free)} are free"
        raise InputError(
            f"output: the result is {found_text} in {path.parent}; free some space there, choose"
            " another place, or record less often (a larger output.step)."
        )


# `hydrosim study`: many runs of a case, as a file says.

# Seconds and number of runs after which the total time is estimated.
MIN_PACE_TIME_S = 10.0
MIN_PACE_RUNS = 100
MIN_ESTIMATED_TIME_S = 60.0  # s: shorter studies get no estimate


def study(
    study_file: options.StudyFile,
    workers: options.Workers = None,
    scheduler: Annotated[
        str | None,
        option("Dask scheduler, tcp://HOST:8786 or tls://; local: processes.", metavar="ADDRESS"),
    ] = None,
    plot: options.Plot = False,
    resume: options.Resume = False,
    output: options.Output = None,
    verbose: options.Verbose = False,
    overwrite: options.Overwrite = False,
) -> None:
    """Run a case many times, as STUDY.yaml says.

    A study has parameters and seeds, or the key `operability`. The former gives one netCDF file and
    tables. The latter gives limiting significant wave heights with confidence, workability in a
    scatter diagram and waiting times in a hindcast.
    """
    from hydrosim.interface import study as studies

    pace = None if resume else _Pace()  # what is read again of a folder says nothing of it

    def tell(done: float, total: float, remark: str) -> None:
        report(done, total, remark)
        if pace is not None and not remark and pace.has_become_known(int(done)):
            folder = Path(f"{output or f'{study_file.stem}.nc'}.partial")
            for line in _duration_lines(pace, int(total), folder):
                terminal.print_status(line)

    with terminal.print_resume_hint("--resume"), terminal.computing("study", "runs") as report:
        result = studies.study(
            study_file,
            output=output or True,
            workers=workers,
            scheduler=scheduler,
            resume=resume,
            plot=plot,
            overwrite=overwrite,
            progress=tell,
            announce=terminal.print_status,
        )
    terminal.show_result(result, verbose)
    dataset = result.dataset
    assert dataset is not None
    if "status" not in dataset:
        if remedy := studies.no_limits_text(dataset):
            raise InputError(
                f"{study_file}: operability.heights: {remedy}. The result was written."
            )
        return
    with dataset:
        statuses = {*dataset.status.values.tolist()}
    if {"interrupted", "not run"} & statuses:
        terminal.print_lines("completed runs are kept: --resume continues")
        raise typer.Exit(130)
    if result.failed:
        raise typer.Exit(3)


class _Pace:
    """Pace of a study: ``each`` is the time of one run [s], after ``done`` runs."""

    def __init__(self) -> None:
        self.first: tuple[int, float] | None = None
        self.done = 0
        self.each = nan

    def has_become_known(self, done: int) -> bool:
        """Whether the pace has just become known; True once."""
        now = perf_counter()
        self.first = self.first or (done, now)
        count = done - self.first[0]
        took = now - self.first[1]
        if (
            self.done
            or took < MIN_PACE_TIME_S
            or (count < MIN_PACE_RUNS and took < MIN_ESTIMATED_TIME_S)
        ):
            return False
        self.done = done
        self.each = took / count
        return True


def _duration_lines(pace: _Pace, total: int, folder: Path) -> Iterator[str]:
    """Estimated duration and size of a study; no line if it ends soon."""
    left = (total - pace.done) * pace.each
    if left < MIN_ESTIMATED_TIME_S:
        return
    end = datetime.now() + timedelta(seconds=left)
    room = 2e-6 * total / pace.done * (folder / "runs").stat().st_size
    free = 1e-6 * disk_usage(folder).free
    yield (
        f"estimate  {total:,} runs at {1.0 / pace.each:.3g} per second: until {end:%d %b %H:%M},"
        f" in {timedelta(seconds=round(left))}; about {room:,.0f} MB of {free:,.0f} MB free"
    )
