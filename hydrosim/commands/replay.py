"""`hydrosim replay`: write a page that shows a run in three dimensions."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hydrosim.commands.options import Overwrite, output_for, require_file
from hydrosim.commands.progress import progress
from hydrosim.commands.terminal import print_lines


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
