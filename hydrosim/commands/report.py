"""`hydrosim report`: one HTML file that shows a result to people."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hydrosim.commands.options import Overwrite, placed
from hydrosim.commands.progress import progress
from hydrosim.commands.terminal import show


def report(
    run_file: Annotated[
        Path,
        typer.Argument(metavar="RESULT.nc", help="What run, sweep, operability or compare wrote."),
    ],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="REPORT.html", help="Where to write the page."),
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """Write a report as one HTML file that needs no network: of a run its case, assumptions,
    stages, statistics with intervals, series to look closer at and energy; or what a study, its
    limits of operation or a comparison has found."""
    from hydrosim.report.document import report_of
    from hydrosim.report.page import written_page

    name = f"{run_file.stem}_report"
    page = placed(output, name, "report", run_file, overwrite=overwrite, suffix=".html")
    with progress("report"):
        size = written_page(report_of(run_file), page)
    show(f"report    {page.path}, {size / 1e6:.1f} MB")
