"""`hydrosim sweep`: a case over parameters and seeds, on all cores."""

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

from hydrosim.commands.compiling import announced
from hydrosim.commands.options import Overwrite, StudyFile, Verbose, Workers, placed
from hydrosim.commands.progress import progress
from hydrosim.commands.running import resumable
from hydrosim.commands.study import draw_runs, place_table, show_study
from hydrosim.commands.terminal import progress_console, say, show

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.outputs import Output
    from hydrosim.studies.many.pools import Pool
    from hydrosim.studies.study_file import Enough
    from hydrosim.studies.sweep.study import Study

# s and runs, after which the time of all is told
LOOKED_AT = 10.0
ENOUGH = 100
MUCH = 60.0  # s: if it is more than that
LOCAL = "local"
err = progress_console()


def sweep(
    study_file: StudyFile,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="RUNS.nc", help="Where to write the result."),
    ] = None,
    workers: Workers = None,
    overwrite: Overwrite = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with a sweep that was killed or interrupted.")
    ] = False,
    scheduler: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            help="Run on the workers of dask at tcp://HOST:8786 (or tls://); local: own processes.",
        ),
    ] = None,
    plot_too: Annotated[bool, typer.Option("--plot", help="Also draw the figures.")] = False,
    verbose: Verbose = False,
) -> None:
    """Run a case over parameters and seeds, as a study says; write one netCDF file, tables."""
    from hydrosim.studies.many.reach import out_of_reach
    from hydrosim.studies.sweep.study import load_study

    study = load_study(study_file)
    for line in out_of_reach(study.scenes):
        say(f"warning   {line}")
    result = placed(
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
        _until(study, study.until, result, (workers, scheduler), resume, table, plot_too, verbose)
        return
    pool = _pool(scheduler, workers)
    with announced(err), _with_progress(study, result, workers, resume, pool) as runs:
        path = Path(runs.encoding["source"])
        if table is not None and path.name != result.path.name:  # what stands there is better
            table = _table_beside(path, study, overwrite)
        _told(runs, study, path, table, overwrite, plot_too, verbose)


def _table_beside(path: Path, study: Study, overwrite: bool) -> Output:
    """Where the tables of the runs at ``path`` go. Raises InputError if they cannot go there."""
    return place_table(path, None, path.parent, study.inputs, overwrite)


def _told(
    runs: xr.Dataset,
    study: Study,
    path: Path,
    table: Output | None,
    overwrite: bool,
    plot_too: bool,
    verbose: bool,
) -> None:
    """Say and draw what came of the runs, with a ``table`` of figures; the exit code is that of the
    worst of them."""
    status = runs.status.values.tolist()
    known = table is not None and "complete" in status
    show_study(runs, table if known else None, verbose)
    show(f"result    {path}")
    if known and plot_too:
        draw_runs(runs, path.parent, path, overwrite)
    elif plot_too:
        lacks = "no run is complete" if study.figures else "the study asks for no figures"
        show(f"picture   none: {lacks}")
    if {"interrupted", "not run"} & {*status}:
        show("what is complete is kept: --resume goes on from there")
        raise typer.Exit(130)
    if "failed" in status:
        raise typer.Exit(3)


def _until(
    study: Study,
    wanted: Enough,
    result: Output,
    by: tuple[int | None, str | None],
    resume: bool,
    table: Output | None,
    plot_too: bool,
    verbose: bool,
) -> None:
    """A study with more and more seeds, ``by`` so many workers, or those of a scheduler."""
    from hydrosim.interrupts import raise_if_interrupted
    from hydrosim.results.runs_file import open_runs
    from hydrosim.studies.sweep.precise import run_until
    from hydrosim.studies.sweep.sweep import run_study

    def run(part: Study, path: Path) -> xr.Dataset:
        pool = _pool(by[1], by[0])
        runs = run_study(part, path, by[0], resume=True, pool=pool)
        raise_if_interrupted()
        if {"interrupted", "not run"} & {*runs.status.values.tolist()}:
            raise KeyboardInterrupt
        return runs

    with resumable("--resume"), announced(err), progress("runs"):
        said = run_until(study, study.seeds, wanted, run, result, resume)
    runs = open_runs(result.path)
    assert runs is not None
    show(said)
    _told(runs, study, result.path, table, result.overwrite, plot_too, verbose)


def _pool(scheduler: str | None, workers: int | None) -> Pool | None:
    """Processes of this machine, or the workers of a scheduler, if one was named."""
    if scheduler is None:
        return None
    if scheduler == LOCAL:
        from hydrosim.studies.many.processes import Processes

        return Processes(workers or os.cpu_count() or 1)
    from hydrosim.studies.many.cluster import Cluster

    pool = Cluster(scheduler)
    say(f"cluster   {pool.title}")
    return pool


def _with_progress(
    study: Study, result: Output, workers: int | None, resume: bool, pool: Pool | None
) -> xr.Dataset:
    from hydrosim.studies.many.unfinished import folder_of
    from hydrosim.studies.sweep.sweep import run_study

    pace = None if resume else _Pace()  # what is read again of a folder says nothing of it
    with progress("sweep", "runs") as report:

        def tell(done: int, total: int) -> None:
            report(done, total)
            if pace is not None and pace.known(done):
                for line in _estimate(pace, len(study.scenes), folder_of(result)):
                    say(line)

        return run_study(study, result, workers, tell, resume, pool)


class _Pace:
    """How many runs are made in a second, from the first on: ``done`` after so many seconds."""

    def __init__(self) -> None:
        self.first: tuple[int, float] | None = None
        self.done = 0
        self.each = nan

    def known(self, done: int) -> bool:
        """Whether it is known now, the first time."""
        now = perf_counter()
        self.first = self.first or (done, now)
        count = done - self.first[0]
        took = now - self.first[1]
        if self.done or took < LOOKED_AT or (count < ENOUGH and took < MUCH):
            return False
        self.done = done
        self.each = took / count
        return True


def _estimate(pace: _Pace, total: int, folder: Path) -> Iterator[str]:
    """How long a sweep will take, and how much room; nothing if it is soon at its end."""
    left = (total - pace.done) * pace.each
    if left < MUCH:
        return
    end = datetime.now() + timedelta(seconds=left)
    room = 2e-6 * total / pace.done * (folder / "runs").stat().st_size
    free = 1e-6 * disk_usage(folder).free
    yield (
        f"estimate  {total:,} runs, {1.0 / pace.each:.3g} a second: until {end:%d %b %H:%M}, in"
        f" {timedelta(seconds=round(left))}; about {room:,.0f} MB of {free:,.0f} that are free"
    )
