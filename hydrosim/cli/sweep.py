"""Commands of many runs: `hydrosim sweep` over parameters and seeds, and `hydrosim operability`."""

from __future__ import annotations

import os
from collections.abc import Iterator
from datetime import datetime, timedelta
from math import nan
from pathlib import Path
from shutil import disk_usage
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

import typer

from hydrosim.cli import terminal
from hydrosim.cli.results import draw_runs, output_for_table, show_study
from hydrosim.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.files.outputs import Output
    from hydrosim.study.executors import Pool
    from hydrosim.study.study_file import SeedTarget
    from hydrosim.study.sweep import ParameterStudy

# Seconds and number of runs after which the total time is estimated.
MIN_PACE_TIME_S = 10.0
MIN_PACE_RUNS = 100
MIN_ESTIMATED_TIME_S = 60.0  # s: shorter sweeps get no estimate
LOCAL = "local"
err = terminal.progress_console()


def sweep(
    study_file: terminal.StudyFile,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="RUNS.nc", help="netCDF file to write."),
    ] = None,
    workers: terminal.Workers = None,
    overwrite: terminal.Overwrite = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue a sweep that was killed or interrupted.")
    ] = False,
    scheduler: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            help="Address of a dask scheduler, tcp://HOST:8786 or tls://; local: processes of"
            " this machine.",
        ),
    ] = None,
    plot_too: Annotated[bool, typer.Option("--plot", help="Also draw the figures.")] = False,
    verbose: terminal.Verbose = False,
) -> None:
    """Run a case over the parameters and seeds of a study; write one netCDF file and tables."""
    from hydrosim.study.shared import describe_outside_ranges
    from hydrosim.study.sweep import load_study

    study = load_study(study_file)
    for line in describe_outside_ranges(study.scenes):
        terminal.print_status(f"warning   {line}")
    result = terminal.output_for(
        output,
        study_file.stem,
        "sweep",
        study_file,
        inputs=study.inputs,
        overwrite=overwrite,
        settings=study.settings,
    )
    table = _table_beside(result.path, study, overwrite) if study.figures else None
    if study.until is not None:
        _run_until_accurate(
            study, study.until, result, (workers, scheduler), resume, table, plot_too, verbose
        )
        return
    pool = _open_pool(scheduler, workers)
    with (
        terminal.announce_compiling(err),
        _run_with_progress(study, result, workers, resume, pool) as runs,
    ):
        path = Path(runs.encoding["source"])
        if table is not None and path.name != result.path.name:  # a better result stands there
            table = _table_beside(path, study, overwrite)
        _show_runs(runs, study, path, table, overwrite, plot_too, verbose)


def _table_beside(path: Path, study: ParameterStudy, overwrite: bool) -> Output:
    """Output for the tables of the runs at ``path``. Raises InputError if it cannot be written."""
    return output_for_table(path, None, path.parent, study.inputs, overwrite)


def _show_runs(
    runs: xr.Dataset,
    study: ParameterStudy,
    path: Path,
    table: Output | None,
    overwrite: bool,
    plot_too: bool,
    verbose: bool,
) -> None:
    """Print and draw the runs, with a ``table`` of figures. The exit code is that of the worst
    run."""
    status = runs.status.values.tolist()
    has_table = table is not None and "complete" in status
    show_study(runs, table if has_table else None, verbose)
    terminal.print_lines(f"result    {path}")
    if has_table and plot_too:
        draw_runs(runs, path.parent, path, overwrite)
    elif plot_too:
        lacks = "no run is complete" if study.figures else "the study asks for no figures"
        terminal.print_lines(f"picture   none: {lacks}")
    if {"interrupted", "not run"} & {*status}:
        terminal.print_lines("completed runs are kept: --resume continues")
        raise typer.Exit(130)
    if "failed" in status:
        raise typer.Exit(3)


def _run_until_accurate(
    study: ParameterStudy,
    wanted: SeedTarget,
    result: Output,
    by: tuple[int | None, str | None],
    resume: bool,
    table: Output | None,
    plot_too: bool,
    verbose: bool,
) -> None:
    """Run a study with more and more seeds; ``by`` is the number of workers and the scheduler."""
    from hydrosim.files.interrupts import raise_if_interrupted
    from hydrosim.results.runs_file import open_runs
    from hydrosim.study.many_runs import run_study, run_until

    def run(part: ParameterStudy, path: Path) -> xr.Dataset:
        pool = _open_pool(by[1], by[0])
        runs = run_study(part, path, by[0], resume=True, pool=pool)
        raise_if_interrupted()
        if {"interrupted", "not run"} & {*runs.status.values.tolist()}:
            raise KeyboardInterrupt
        return runs

    with (
        terminal.print_resume_hint("--resume"),
        terminal.announce_compiling(err),
        terminal.progress("runs"),
    ):
        summary = run_until(study, study.seeds, wanted, run, result, resume)
    runs = open_runs(result.path)
    assert runs is not None
    terminal.print_lines(summary)
    _show_runs(runs, study, result.path, table, result.overwrite, plot_too, verbose)


def _open_pool(scheduler: str | None, workers: int | None) -> Pool | None:
    """Processes of this machine, or the workers of a scheduler if one is named."""
    if scheduler is None:
        return None
    if scheduler == LOCAL:
        from hydrosim.study.executors import Processes

        return Processes(workers or os.cpu_count() or 1)
    from hydrosim.study.cluster import Cluster

    pool = Cluster(scheduler)
    terminal.print_status(f"cluster   {pool.title}")
    return pool


def _run_with_progress(
    study: ParameterStudy, result: Output, workers: int | None, resume: bool, pool: Pool | None
) -> xr.Dataset:
    from hydrosim.study.many_runs import run_study
    from hydrosim.study.shared import folder_of

    pace = None if resume else _Pace()  # what is read again of a folder says nothing of it
    with terminal.progress("sweep", "runs") as report:

        def tell(done: int, total: int) -> None:
            report(done, total)
            if pace is not None and pace.has_become_known(done):
                for line in _duration_lines(pace, len(study.scenes), folder_of(result)):
                    terminal.print_status(line)

        return run_study(study, result, workers, tell, resume, pool)


class _Pace:
    """Pace of a sweep: ``each`` is the time of one run [s], after ``done`` runs."""

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
    """Estimated duration and size of a sweep; no line if it ends soon."""
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


# `hydrosim operability`: sea states in which a case meets its criteria, with confidence.


def operability(
    study_file: terminal.StudyFile,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="LIMITS.nc", help="netCDF file to write."),
    ] = None,
    workers: terminal.Workers = None,
    overwrite: terminal.Overwrite = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue a search that was killed or interrupted.")
    ] = False,
    verbose: terminal.Verbose = False,
) -> None:
    """Find limiting significant wave heights over peak periods, headings and swells, with
    confidence.

    It also computes the workability in a scatter diagram and waiting times in a hindcast.
    """
    from hydrosim.report.charts.studies import draw_limits
    from hydrosim.report.sentences.limits import limits_tables
    from hydrosim.results.dataset import write_run
    from hydrosim.study.operability import limits_of, load_limits
    from hydrosim.study.shared import locked_journal
    from hydrosim.study.weather import assess_weather, read_weather

    with terminal.announce_compiling(err):
        study = load_limits(study_file)
    name = f"{study_file.stem}_operability"
    result = terminal.output_for(
        output,
        name,
        "limits",
        study_file,
        inputs=study.inputs,
        overwrite=overwrite,
        settings=study.settings,
    )
    page = result.output_at(result.path.with_suffix(".png"), "picture").checked_output()
    weather = read_weather(study_file.parent, study.wanted)
    with (
        terminal.print_resume_hint("--resume"),
        locked_journal(result, resume, study.identity) as journal,
        terminal.announce_compiling(err),
        terminal.progress("limits", "seas") as report,
    ):

        def tell(sea: str, runs: int, done: int) -> None:
            report(done, study.seas, f"{sea}, {runs} runs")

        limits = limits_of(study, workers or os.cpu_count() or 1, tell, journal)
        assessed = assess_weather(limits, weather)
        write_run(assessed, result)
        journal.remove()
    draw_limits(assessed, page)
    terminal.show_document(limits_tables(assessed), verbose)
    terminal.print_lines(f"result    {result.path}, {page.path}")
    if remedy := _no_limits_text(assessed.sel(stage="all")):
        raise InputError(f"{study_file}: operability.heights: {remedy}. The result was written.")


def _no_limits_text(assessed: xr.Dataset) -> str:
    """Remedy if the limit of no sea state lies between the heights; empty if one does."""
    from hydrosim.report.sentences.limits import side_of

    limits = assessed.limit.values.ravel().tolist()
    sides = {side_of(limit, assessed) for limit in limits}
    if "" in sides:
        return ""
    lowest, highest = assessed.attrs["lowest"], assessed.attrs["highest"]
    text = f"found no limit from {lowest:g} m to {highest:g} m in any"
    match sorted(sides):
        case ["above"]:
            return (
                f"{text} sea state: the criteria hold at all heights. Raise the last height,"
                " or tighten the criteria"
            )
        case ["below"]:
            return (
                f"{text} sea state: the criteria fail at the first height. Begin with a lower"
                " height"
            )
    return (
        f"{text} sea state: in some the criteria hold at all heights, in others they fail at"
        " the first. Add lower and higher heights"
    )
