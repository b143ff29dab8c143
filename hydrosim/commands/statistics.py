"""`hydrosim statistics`: what a run comes down to in figures."""

from __future__ import annotations

from math import inf
from pathlib import Path
from typing import Annotated

import typer

from hydrosim.commands.options import From, Overwrite, Verbose, names_in, placed, seconds
from hydrosim.commands.progress import progress
from hydrosim.commands.terminal import not_complete, show, show_document

SHORTEST = 0.1  # of the record: what extremes can be asked for


def statistics(
    run_file: Annotated[
        Path,
        typer.Argument(
            metavar="RUN.nc", help="The result of a run, or of a study; a study's RUNS.nc.partial."
        ),
    ],
    start: From = "",
    duration: Annotated[
        str,
        typer.Option(
            metavar="TIME",
            help='Tell extremes of "3 hour", or seconds; else of the record.',
        ),
    ] = "",
    channels: Annotated[
        str,
        typer.Option(metavar="NAMES", help='Take these channels, too: "speed.*,force_mooring.*".'),
    ] = "",
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="STATISTICS.nc", help="Where to write the result."),
    ] = None,
    verbose: Verbose = False,
    overwrite: Overwrite = False,
) -> None:
    """Print means, periods, extremes with two kinds of intervals, and crawl by phase."""
    from hydrosim.commands.study import place_table, show_study
    from hydrosim.errors import InputError
    from hydrosim.results.channels import chosen, names
    from hydrosim.results.growing import runs_at
    from hydrosim.results.netcdf import read, write
    from hydrosim.statistics.statistics import enough_from
    from hydrosim.statistics.statistics import statistics as of_run
    from hydrosim.wording.statistics import statistics_document

    if (runs := runs_at(run_file)) is not None:
        table = place_table(run_file, output, overwrite=overwrite)
        show_study(runs, table, verbose)
        return
    name = f"{run_file.stem}_statistics"
    result = placed(output, name, "statistics", run_file, overwrite=overwrite)
    run = read(run_file)
    begin, end = seconds("--from", start, 0.0), float(run.time[-1])
    if not enough_from(run, begin):
        raise InputError(
            f"--from: found {begin:g} s; expected a time well before the end of the run, {end:g} s."
        )
    least = SHORTEST * (end - max(begin, float(run.time[0])))
    exposure = seconds("--duration", duration, inf) if duration else None
    if exposure is not None and not least <= exposure < inf:
        raise InputError(
            f"--duration: found {exposure:g} s; expected a tenth of the record, {least:g} s, or"
            " more: of a shorter time the record itself holds many."
        )
    asked = names_in(channels)
    known = names(run)
    asked += ["utilisation.*"] if any(name.startswith("utilisation.") for name in known) else []
    with progress("statistics"):
        found = of_run(run, begin, exposure, chosen(known, asked, "--channels"))
        write(found, result)
    show(*not_complete(run.attrs))
    show_document(statistics_document(run, found), verbose)
    show(f"result    {result.path}")
