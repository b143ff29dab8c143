"""Commands that show results: `hydrosim report`, `plot`, `replay`, `statistics` and `explain`."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrosim.cli import terminal
from hydrosim.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from hydrosim.files.outputs import Output
    from hydrosim.report.charts.pictures import View

# Tables and pictures of the runs of a study.

HERE = Path()  # folder in which the command was given


def stem_of(file: Path) -> str:
    """Stem of the results of a file of runs; "runs" for "runs.partial"."""
    return file.stem.replace(".nc", ".partial") if file.suffix == ".partial" else file.stem


def status_lines(runs: xr.Dataset) -> list[str]:
    """Numbers of runs by status if not all are complete, and the reason why the first failed."""
    from hydrosim.report.sentences.study import counts_by_status
    from hydrosim.results.journal import GATHERED
    from hydrosim.results.runs_file import COMPLETE

    if GATHERED in runs.attrs:
        return [f"so far    {runs.attrs[GATHERED]}"]
    if "status" not in runs or set(ends := runs.status.values.tolist()) == {COMPLETE}:
        return []
    first = ends.index("failed") if "failed" in ends else None
    failed = [f"run {first}: {runs.status_message.values[first]}"] if first is not None else []
    return [counts_by_status(runs), *failed]


def output_for_table(
    file: Path,
    output: Path | None,
    folder: Path = HERE,
    inputs: Iterable[Path] = (),
    overwrite: bool = False,
) -> Output:
    """Output for the tables of a ``file`` of runs: ``output``, or else a file in ``folder`` with
    the same stem. Raises InputError if it cannot be written; ``inputs`` are never replaced."""
    default = str(folder / stem_of(file))
    return terminal.output_for(
        output, default, "table", file, inputs=inputs, overwrite=overwrite, suffix=".csv"
    )


def show_study(runs: xr.Dataset, table: Output | None, verbose: bool = False) -> None:
    """Print a study; with a ``table``, also write it as comma-separated values."""
    from hydrosim.report.sentences.study import study_tables
    from hydrosim.statistics.over_seeds import as_csv

    terminal.show_document(study_tables(runs), verbose)
    if table is not None:
        with table.write_complete() as path:
            path.write_text(f"# {table.mark}\n{as_csv(runs)}")
        terminal.print_lines(f"table     {table.path}")


def draw_runs(
    runs: xr.Dataset, folder: Path, file: Path, overwrite: bool = False, form: str = "png"
) -> None:
    """Draw a study in the format ``form``, and print where the pictures are."""
    from hydrosim.files.outputs import Output, make_folder
    from hydrosim.report.charts.studies import draw_study

    make_folder(folder)
    pictures = Output(
        folder / f"{stem_of(file)}.{form}", "picture", file, (file,), overwrite, "pictures"
    )
    for path in draw_study(runs, pictures):
        terminal.print_lines(f"picture   {path}")


# `hydrosim plot`: pictures of a run, or of a study.


def plot(
    run_file: Annotated[
        Path, typer.Argument(metavar="RUN.nc", help="Result of a run, or of a study.")
    ],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FOLDER", help="Folder for the pictures."),
    ] = None,
    channels: Annotated[
        str,
        typer.Option(
            metavar="NAMES",
            help='Channels to draw in one picture, separated by commas: "position.*.heave".',
        ),
    ] = "",
    start: terminal.From = "",
    end: terminal.To = "",
    form: Annotated[
        str, typer.Option("--format", metavar="png|svg|pdf", help="Format of the pictures.")
    ] = "png",
    overwrite: terminal.Overwrite = False,
) -> None:
    """Draw motions, forces, contact and energies of a run, or the figures of a study.

    Titles name the sea. Grey and white show the phases of the first contact that begins open. In
    long runs, bands show the smallest and largest values of each interval.
    """
    from hydrosim.report.charts.panels import TimeWindow
    from hydrosim.report.charts.pictures import Format, View
    from hydrosim.results.channels import channel_names, match_channels
    from hydrosim.results.journal import runs_at
    from hydrosim.simulation import open_run

    folder = run_file.parent if output is None else output
    if os.path.exists(folder) and not os.path.isdir(folder):
        raise InputError(f"{folder}: is a file; expected a folder for the pictures.")
    if output is not None and output.suffix[1:] in [*Format] and not os.path.isdir(output):
        raise InputError(
            f"--output: found {output}; expected a folder for several pictures. --format"
            f" {output.suffix[1:]} selects their format."
        )
    kind = terminal.one_of(Format, form, "--format")
    window = TimeWindow(*terminal.window_of(start, end))
    if (runs := runs_at(run_file)) is not None:
        if channels or start or end:
            raise InputError(
                f"--channels, --from, --to: {run_file} is a study, which has no time series;"
                " expected the result of a run."
            )
        terminal.print_lines(*status_lines(runs))
        draw_runs(runs, folder, run_file, overwrite, kind)
        return
    dataset = open_run(run_file)
    asked = terminal.names_in(channels)
    picked = match_channels(channel_names(dataset), asked, "--channels") if asked else ()
    draw_run(dataset, folder, run_file, overwrite, View(window, picked, kind))


def draw_run(
    run: xr.Dataset, folder: Path, run_file: Path, overwrite: bool, view: View | None = None
) -> None:
    """Draw the pictures of the ``run`` in a file, by default the usual ones; print their paths."""
    from hydrosim.report.charts.pictures import DEFAULT_VIEW, draw

    with terminal.progress("drawing"):
        pictures = draw(run, folder, run_file.stem, run_file, overwrite, view or DEFAULT_VIEW)
    terminal.print_lines(*(f"picture   {picture}" for picture in pictures))


def report(
    run_file: Annotated[
        Path,
        typer.Argument(metavar="RESULT.nc", help="Result of run, sweep, operability or compare."),
    ],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="REPORT.html", help="Page to write."),
    ] = None,
    overwrite: terminal.Overwrite = False,
) -> None:
    """Write a report as one HTML file that needs no network. The report of a run shows its case,
    assumptions, stages, statistics with intervals, time series and energy. Studies, limits of
    operation and comparisons have reports, too."""
    from hydrosim.report.document import report_of
    from hydrosim.report.page import written_page

    name = f"{run_file.stem}_report"
    terminal.require_file(
        run_file, "the result of `hydrosim run`, `sweep`, `operability` or `compare`"
    )
    page = terminal.output_for(
        output, name, "report", run_file, overwrite=overwrite, suffix=".html"
    )
    with terminal.progress("report"):
        size = written_page(report_of(run_file), page)
    terminal.print_lines(f"report    {page.path}, {size / 1e6:.1f} MB")


# `hydrosim replay`: write a page that shows a run in three dimensions.


def replay(
    run_file: Annotated[Path, typer.Argument(metavar="RUN.nc", help="Result of a run.")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="REPLAY.html", help="Page to write."),
    ] = None,
    overwrite: terminal.Overwrite = False,
) -> None:
    """Write a three-dimensional animation of a run: one HTML file that needs no network."""
    from hydrosim.report.document import replay_of
    from hydrosim.report.page import written_page

    name = f"{run_file.stem}_replay"
    terminal.require_file(run_file, "the result of a run (RUN.nc)")
    page = terminal.output_for(
        output, name, "replay", run_file, overwrite=overwrite, suffix=".html"
    )
    with terminal.progress("replay"):
        size = written_page(replay_of(run_file), page)
    terminal.print_lines(f"replay    {page.path}, {size / 1e6:.1f} MB")


# `hydrosim statistics`: means, periods and extremes of a run.

MIN_EXTREME_SHARE = 0.1  # shortest duration of extremes, as a part of the record


def statistics(
    run_file: Annotated[
        Path,
        typer.Argument(
            metavar="RUN.nc",
            help="Result of a run or of a study, also of an unfinished one (RUNS.nc.partial).",
        ),
    ],
    start: terminal.From = "",
    duration: Annotated[
        str,
        typer.Option(
            metavar="TIME",
            help='Duration of the extremes: "3 hour", or a number in seconds; default: the record.',
        ),
    ] = "",
    channels: Annotated[
        str,
        typer.Option(
            metavar="NAMES",
            help='Further channels, separated by commas: "speed.*,force_mooring.*".',
        ),
    ] = "",
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="STATISTICS.nc", help="netCDF file to write."),
    ] = None,
    verbose: terminal.Verbose = False,
    overwrite: terminal.Overwrite = False,
) -> None:
    """Print means, periods, extremes with two kinds of intervals, and crawl in each contact
    phase."""
    from hydrosim.report.sentences.statistics import statistics_document
    from hydrosim.results.channels import channel_names, match_channels
    from hydrosim.results.dataset import read_run, write_run
    from hydrosim.results.journal import runs_at
    from hydrosim.statistics.statistics import has_enough_records
    from hydrosim.statistics.statistics import statistics as of_run

    if (runs := runs_at(run_file)) is not None:
        table = output_for_table(run_file, output, overwrite=overwrite)
        show_study(runs, table, verbose)
        return
    terminal.require_file(run_file, "the result of a run or of a study (RUN.nc)")
    name = f"{run_file.stem}_statistics"
    result = terminal.output_for(output, name, "statistics", run_file, overwrite=overwrite)
    run = read_run(run_file)
    begin, end = terminal.seconds("--from", start, 0.0), float(run.time[-1])
    if not has_enough_records(run, begin):
        raise InputError(
            f"--from: found {begin:g} s; expected a time well before the end of the run at"
            f" {end:g} s."
        )
    least = MIN_EXTREME_SHARE * (end - max(begin, float(run.time[0])))
    exposure = terminal.seconds("--duration", duration, inf) if duration else None
    if exposure is not None and not least <= exposure < inf:
        raise InputError(
            f"--duration: found {exposure:g} s; expected at least a tenth of the record,"
            f" {least:g} s. The record itself holds many samples of shorter durations."
        )
    asked = terminal.names_in(channels)
    known_channels = channel_names(run)
    asked += (
        ["utilisation.*"] if any(name.startswith("utilisation.") for name in known_channels) else []
    )
    with terminal.progress("statistics"):
        statistics_found = of_run(
            run, begin, exposure, match_channels(known_channels, asked, "--channels")
        )
        write_run(statistics_found, result)
    terminal.print_lines(*terminal.incomplete_run_warnings(run.attrs))
    terminal.show_document(statistics_document(run, statistics_found), verbose)
    terminal.print_lines(f"result    {result.path}")


# `hydrosim explain`: why a body moved, by force, contact mode and direction.


def explain(
    run_file: Annotated[
        Path, typer.Argument(metavar="RUN.nc", help="Result of a run, or of a study.")
    ],
    direction: Annotated[
        str, typer.Option(help="Direction of the motion: surge, sway or heave.")
    ] = "surge",
    body: Annotated[
        str | None, typer.Option(help="Body to explain; default: the first that moves.")
    ] = None,
    start: terminal.From = "",
    end: Annotated[
        str,
        typer.Option(
            "--to",
            "--until",
            metavar="TIME",
            help='Ignore everything after this time: "1 hour", or a number in seconds.',
        ),
    ] = "",
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="EXPLAINED.nc", help="netCDF file to write."),
    ] = None,
    verbose: terminal.Verbose = False,
    overwrite: terminal.Overwrite = False,
) -> None:
    """Explain why a body moved: mean forces, causes of friction, displacement and work by contact
    mode.

    The run needs `output: {impulses: true}`. For a study, the table shows means over the runs of
    each combination of parameters, with 90 % intervals. The picture shows the first combination.
    """
    from hydrosim.report.charts.explain import draw_explained
    from hydrosim.report.sentences.series import explanation_document
    from hydrosim.results.dataset import read_run, write_run
    from hydrosim.results.journal import runs_at
    from hydrosim.statistics.explain import DIRECTION_AXES

    if direction not in DIRECTION_AXES:
        raise InputError(
            f"--direction: found {direction}; expected one of {', '.join(DIRECTION_AXES)}."
        )
    name = f"{stem_of(run_file)}_explained"
    run = runs_at(run_file)
    terminal.require_file(run_file, "the result of a run or of a study (RUN.nc)")
    result = terminal.output_for(output, name, "explanation", run_file, overwrite=overwrite)
    page = result.output_at(result.path.with_suffix(".png"), "picture").checked_output()
    between = terminal.window_of(start, end)
    many = run is not None
    if run is None:
        run = read_run(run_file)
    try:
        with terminal.progress("explaining"):
            explanations, parts = (
                _explain_runs(run, between) if many else _explain_run(run, between)
            )
    except InputError as error:
        raise InputError(f"{run_file}: {error}") from None
    moved = _choose_body(explanations, direction, body)
    write_run(explanations, result)
    terminal.print_lines(*status_lines(run))
    first, of_first = next(iter(parts.items()))
    draw_explained(run, of_first, moved, direction, page, first)
    terminal.show_document(explanation_document(run, parts, moved, direction), verbose)
    terminal.print_lines(f"result    {result.path}, {page.path}")


Parts = dict[str, "xr.Dataset"]
"""Runs to explain, by name: one run, or each combination of parameters of a study."""


def _explain_run(run: xr.Dataset, between: tuple[float, float]) -> tuple[xr.Dataset, Parts]:
    from hydrosim.statistics.explain import explain_run

    explanations = explain_run(run, *between)
    return explanations, {"": explanations}


def _explain_runs(runs: xr.Dataset, between: tuple[float, float]) -> tuple[xr.Dataset, Parts]:
    from hydrosim.results.runs_file import COMPLETE
    from hydrosim.statistics.explain import explanations_of_runs

    if between != (-inf, inf):
        raise InputError("found a study; expected one run, because of --from or --to.")
    explanations = explanations_of_runs(runs)
    complete = runs.status.values == COMPLETE
    if not complete.any():
        raise InputError("found no complete run; see the variable status_message of the file.")
    return explanations, {
        t: explanations.isel(run=at) for t, at in _runs_by_combination(runs) if complete[at].any()
    }


def _runs_by_combination(runs: xr.Dataset) -> Iterator[tuple[str, np.ndarray]]:
    """Name of each combination of parameters of a study, with the indices of its runs."""
    import numpy as np

    from hydrosim.report.sentences.series import named_values
    from hydrosim.statistics.effects import combinations, plans

    if "design" not in runs.attrs:
        yield "", np.arange(runs.sizes["run"])
        return
    for plan in plans(runs):
        plan_runs = np.flatnonzero(np.isin(runs.run.values, plan.runs.run.values))
        for values, at in combinations(plan):
            values_text = named_values(plan, values)
            yield ": ".join(part for part in (plan.name, values_text) if part), plan_runs[at]


def _choose_body(explanations: xr.Dataset, direction: str, name: str | None) -> str:
    """Body that was asked for, or the first that moves."""
    body_names = [str(body) for body in explanations.body.values]
    if name is not None and name not in body_names:
        raise InputError(f"--body: found {name}; expected one of {', '.join(body_names)}.")
    displacement = abs(explanations.displacement.sel(dof=direction)).fillna(0.0)
    moved = displacement.max([dim for dim in displacement.dims if dim != "body"]).values
    return name or (body_names[int(moved.argmax())])
