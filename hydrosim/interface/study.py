"""`study` runs a case many times, as its file says: over parameters and seeds, or over sea states
to find the limits of an operation."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import xarray as xr

from hydrosim.errors import InputError
from hydrosim.files.arguments import Target, output_for, picture_beside
from hydrosim.files.interrupts import raise_if_interrupted
from hydrosim.files.outputs import Output
from hydrosim.interface.printed import PrintedResult, draw_runs, table_output, write_table
from hydrosim.report.sentences.limits import limits_tables, side_of
from hydrosim.report.sentences.study import study_tables
from hydrosim.results.dataset import write_run
from hydrosim.results.runs_file import COMPLETE, locked_journal, open_runs
from hydrosim.study.executors import Processes
from hydrosim.study.many_runs import run_study, run_until
from hydrosim.study.operability import limits_of, load_limits
from hydrosim.study.scene_cache import describe_outside_ranges
from hydrosim.study.sweep import ParameterStudy, load_study, read_study
from hydrosim.study.weather import assess_weather, read_weather

if TYPE_CHECKING:
    from hydrosim.study.executors import Pool

Progress = Callable[[float, float, str], None]
"""Receives how much is done, of how much, and a remark."""
Announce = Callable[[str], None]
"""Receives a line about what is going on."""
LOCAL = "local"


class Destination(NamedTuple):
    """Where a study is written, whether one that was interrupted there goes on, and whether an
    earlier one is replaced."""

    output: Target
    resume: bool
    overwrite: bool


def study(
    file: str | Path,
    *,
    output: Target = None,
    workers: int | None = None,
    scheduler: str | None = None,
    resume: bool = False,
    plot: bool = False,
    overwrite: bool = False,
    progress: Progress = lambda *_: None,
    announce: Announce = lambda _: None,
) -> PrintedResult:
    """Run the study in a YAML file on so many ``workers``, by default all cores.

    A study of parameters and seeds gives the dataset of its runs; ``plot`` draws its figures, and
    ``scheduler`` is the address of a dask scheduler, or "local" for processes of this machine. A
    study with the key ``operability`` gives limiting significant wave heights, with workability and
    waiting times. ``resume`` continues one that was killed or interrupted. With ``output``, files
    are written as by `hydrosim study`; without, runs are kept in memory.

    >>> case = "cases/friction_block/exact.yaml"
    >>> text = f"{{case: {case}, parameters: {{solver.step: [0.05 s, 0.1 s]}}}}"
    >>> _ = Path("steps.yaml").write_text(text)
    >>> hs.study("steps.yaml").dataset.solver_step.values.tolist()
    [0.05, 0.1]
    """
    if not isinstance(file, str | os.PathLike):
        raise InputError(
            "file: found no name of a file; expected one, such as study.yaml. Cases that are made"
            " in Python are run by hs.simulate_many(cases)."
        )
    file = Path(file)
    where = Destination(output, resume, overwrite)
    if read_study(file).operability is None:
        return sweep(file, where, workers, scheduler, plot, progress, announce)
    for name, value in {"scheduler": scheduler, "plot": plot}.items():
        if value:
            raise InputError(
                f"{name}: not possible with {file}, a study of limits, which runs in threads and"
                " always draws its picture. Leave this option out."
            )
    return find_limits(file, where, workers, progress)


def sweep(
    file: Path,
    where: Destination,
    workers: int | None,
    scheduler: str | None,
    plot: bool,
    progress: Progress,
    announce: Announce,
) -> PrintedResult:
    """Run a case over the parameters and seeds of a study; write one file, a table and pictures."""
    planned = load_study(file)
    for line in describe_outside_ranges(planned.scenes):
        announce(f"warning   {line}")
    result = output_for(
        where.output,
        file.stem,
        "sweep",
        file,
        inputs=planned.inputs,
        overwrite=where.overwrite,
        settings=planned.settings,
    )
    table = (
        _table_beside(result.path, planned, where.overwrite) if result and planned.figures else None
    )
    lines: list[str] = []
    path: Path | None
    if planned.data.until is not None:
        runs, path, summary = _run_until_accurate(
            planned, result, workers, scheduler, where.resume, announce
        )
        lines = [summary]
    else:
        pool = _open_pool(scheduler, workers, announce)

        def tell(done: int, total: int) -> None:
            progress(done, total, "")

        runs = run_study(planned, result, workers, tell, where.resume, pool)
        path = Path(runs.encoding["source"]) if result else None
    if path and result and table and path.name != result.path.name:  # a better result stands there
        table = _table_beside(path, planned, where.overwrite)
    statuses = runs.status.values.tolist()
    has_table = table is not None and COMPLETE in statuses
    files = [write_table(runs, table)] if table and has_table else []
    if path and plot and has_table:
        lines += [
            f"picture   {drawn}" for drawn in draw_runs(runs, path.parent, path, where.overwrite)
        ]
    elif plot:
        lacks = "no run is complete" if planned.figures else "the study asks for no figures"
        lines += [f"picture   none: {lacks}"]
    files += [path] if path else []
    return PrintedResult(study_tables(runs), runs, tuple(files), tuple(lines), "failed" in statuses)


def _run_until_accurate(
    planned: ParameterStudy,
    result: Output | None,
    workers: int | None,
    scheduler: str | None,
    resume: bool,
    announce: Announce,
) -> tuple[xr.Dataset, Path, str]:
    """Run a study with more and more seeds."""
    if result is None:
        raise InputError("output: found none; expected one, as the study adds seeds to a file.")

    def run(part: ParameterStudy, path: Path) -> xr.Dataset:
        pool = _open_pool(scheduler, workers, announce)
        runs = run_study(part, path, workers, resume=True, pool=pool)
        raise_if_interrupted()
        if {"interrupted", "not run"} & {*runs.status.values.tolist()}:
            raise KeyboardInterrupt
        return runs

    summary = run_until(planned, run, result, resume)
    runs = open_runs(result.path)
    assert runs is not None
    return runs, result.path, summary


def _open_pool(scheduler: str | None, workers: int | None, announce: Announce) -> Pool | None:
    """Processes of this machine, or the workers of a scheduler if one is named."""
    if scheduler is None:
        return None
    if scheduler == LOCAL:
        return Processes(workers or os.cpu_count() or 1)
    from hydrosim.study.cluster import Cluster

    pool = Cluster(scheduler)
    announce(f"cluster   {pool.title}")
    return pool


def _table_beside(path: Path, planned: ParameterStudy, overwrite: bool) -> Output | None:
    """Output for the tables of the runs at ``path``. Raises InputError if it cannot be written."""
    return table_output(True, path, path.parent, planned.inputs, overwrite)


# Limits of an operation.


def find_limits(
    file: Path,
    where: Destination,
    workers: int | None,
    progress: Progress,
) -> PrintedResult:
    """Limiting significant wave heights over peak periods, headings and swells, with confidence;
    workability in a scatter diagram and waiting times in a hindcast."""
    planned = load_limits(file)
    result = output_for(
        where.output,
        f"{file.stem}_operability",
        "limits",
        file,
        inputs=planned.inputs,
        overwrite=where.overwrite,
        settings=planned.settings,
    )
    page = picture_beside(result)
    weather = read_weather(file.parent, planned.wanted)

    def tell(sea: str, runs: int, done: int) -> None:
        progress(done, len(planned.seas), f"{sea}, {runs} runs")

    count = workers or os.cpu_count() or 1
    if result is None or page is None:
        limits = assess_weather(limits_of(planned, count, tell), weather)
        return PrintedResult(limits_tables(limits), limits)
    from hydrosim.report.charts.studies import draw_limits

    with locked_journal(result, where.resume, planned.identity) as journal:
        limits = assess_weather(limits_of(planned, count, tell, journal), weather)
        write_run(limits, result)
        journal.remove()
    draw_limits(limits, page)
    return PrintedResult(limits_tables(limits), limits, (result.path, page.path))


def no_limits_text(limits: xr.Dataset) -> str:
    """Remedy if the limit of no sea state lies between the heights; empty if one does."""
    of_all = limits.sel(stage="all")
    sides = {side_of(limit, of_all) for limit in of_all.limit.values.ravel().tolist()}
    if "" in sides:
        return ""
    lowest, highest = of_all.attrs["lowest"], of_all.attrs["highest"]
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
