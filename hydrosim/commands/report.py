"""`hydrosim report`: write one HTML file that shows a result."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hydrosim.commands.options import Overwrite, output_for, require_file
from hydrosim.commands.progress import progress
from hydrosim.commands.terminal import print_lines


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
