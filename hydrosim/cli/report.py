"""`hydrosim report`: write one HTML file that shows a result."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrosim.cli.options import (
    From,
    Overwrite,
    To,
    names_in,
    one_of,
    output_for,
    require_file,
    window_of,
)
from hydrosim.cli.progress import progress
from hydrosim.cli.terminal import print_lines, show_document
from hydrosim.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.files.outputs import Output

# Tables and pictures of the runs of a study.

HERE = Path()  # folder in which the command was given


def stem_of(file: Path) -> str:
    """Stem of the results of a file of runs; "runs" for "runs.partial"."""
    return file.stem.replace(".nc", ".partial") if file.suffix == ".partial" else file.stem


def so_far(runs: xr.Dataset) -> list[str]:
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


def place_table(
    file: Path,
    output: Path | None,
    folder: Path = HERE,
    inputs: Iterable[Path] = (),
    overwrite: bool = False,
) -> Output:
    """Output for the tables of a ``file`` of runs: ``output``, or else a file in ``folder`` with
    the same stem. Raises InputError if it cannot be written; ``inputs`` are never replaced."""
    default = str(folder / stem_of(file))
    return output_for(
        output, default, "table", file, inputs=inputs, overwrite=overwrite, suffix=".csv"
    )


def show_study(runs: xr.Dataset, table: Output | None, verbose: bool = False) -> None:
    """Print a study; with a ``table``, also write it as comma-separated values."""
    from hydrosim.report.sentences.study import study_tables
    from hydrosim.statistics.over_seeds import as_csv

    show_document(study_tables(runs), verbose)
    if table is not None:
        with table.write_complete() as path:
            path.write_text(f"# {table.mark}\n{as_csv(runs)}")
        print_lines(f"table     {table.path}")


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
        print_lines(f"picture   {path}")


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
    start: From = "",
    end: To = "",
    form: Annotated[
        str, typer.Option("--format", metavar="png|svg|pdf", help="Format of the pictures.")
    ] = "png",
    overwrite: Overwrite = False,
) -> None:
    """Draw motions, forces, contact and energies of a run, or the figures of a study.

    Titles name the sea. Grey and white show the phases of the first contact that begins open. In
    long runs, bands show the smallest and largest values of each interval.
    """
    from hydrosim.report.charts.panels import TimeWindow
    from hydrosim.report.charts.pictures import Format, View, draw
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
    kind = one_of(Format, form, "--format")
    window = TimeWindow(*window_of(start, end))
    if (runs := runs_at(run_file)) is not None:
        if channels or start or end:
            raise InputError(
                f"--channels, --from, --to: {run_file} is a study, which has no time series;"
                " expected the result of a run."
            )
        print_lines(*so_far(runs))
        draw_runs(runs, folder, run_file, overwrite, kind)
        return
    dataset = open_run(run_file)
    asked = names_in(channels)
    picked = match_channels(channel_names(dataset), asked, "--channels") if asked else ()
    view = View(window, picked, kind)
    with progress("drawing"):
        pictures = draw(dataset, folder, run_file.stem, run_file, overwrite, view)
    print_lines(*(f"picture   {picture}" for picture in pictures))


def report(
    run_file: Annotated[
        Path,
        typer.Argument(metavar="RESULT.nc", help="Result of run, sweep, operability or compare."),
    ],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="REPORT.html", help="Page to write."),
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """Write a report as one HTML file that needs no network. The report of a run shows its case,
    assumptions, stages, statistics with intervals, time series and energy. Studies, limits of
    operation and comparisons have reports, too."""
    from hydrosim.report.document import report_of
    from hydrosim.report.page import written_page

    name = f"{run_file.stem}_report"
    require_file(run_file, "the result of `hydrosim run`, `sweep`, `operability` or `compare`")
    page = output_for(output, name, "report", run_file, overwrite=overwrite, suffix=".html")
    with progress("report"):
        size = written_page(report_of(run_file), page)
    print_lines(f"report    {page.path}, {size / 1e6:.1f} MB")


# `hydrosim replay`: write a page that shows a run in three dimensions.


def replay(
    run_file: Annotated[Path, typer.Argument(metavar="RUN.nc", help="Result of a run.")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="REPLAY.html", help="Page to write."),
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """Write a three-dimensional animation of a run: one HTML file that needs no network."""
    from hydrosim.report.document import replay_of
    from hydrosim.report.page import written_page

    name = f"{run_file.stem}_replay"
    require_file(run_file, "the result of a run (RUN.nc)")
    page = output_for(output, name, "replay", run_file, overwrite=overwrite, suffix=".html")
    with progress("replay"):
        size = written_page(replay_of(run_file), page)
    print_lines(f"replay    {page.path}, {size / 1e6:.1f} MB")
