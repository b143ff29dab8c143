"""`hydrosim statistics`: what a run comes down to in figures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hydrosim.commands.options import result_path
from hydrosim.commands.terminal import show


def statistics(
    run_file: Annotated[Path, typer.Argument(metavar="RUN.nc", help="Result of a run.")],
    start: Annotated[
        float, typer.Option("--from", metavar="SECONDS", help="Leave out what is before.")
    ] = 0.0,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="STATISTICS.nc", help="Result file.")
    ] = None,
) -> None:
    """Means, periods and extremes of motions with their confidence, spectra, crawl by phase."""
    from hydrosim.errors import InputError
    from hydrosim.results.output import read, write
    from hydrosim.results.statistics import lines
    from hydrosim.results.statistics import statistics as of_run

    path = result_path(output, run_file.with_stem(f"{run_file.stem}_statistics"))
    run = read(run_file)
    end = float(run.time[-1])
    if not start < end or run.sel(time=slice(start, None)).time.size < 4:
        raise InputError(
            f"--from: found {start:g} s; expected a time well before the end of the run, {end:g} s."
        )
    found = of_run(run, start)
    write(found, path)
    show(*lines(found), f"result    {path}")
