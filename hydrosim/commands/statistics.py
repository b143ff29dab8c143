"""`hydrosim statistics`: means, periods and extremes of a run."""

from __future__ import annotations

from math import inf
from pathlib import Path
from typing import Annotated

import typer

from hydrosim.commands.options import (
    From,
    Overwrite,
    Verbose,
    names_in,
    output_for,
    require_file,
    seconds,
)
from hydrosim.commands.progress import progress
from hydrosim.commands.terminal import not_complete, print_lines, show_document

MIN_EXTREME_SHARE = 0.1  # shortest duration of extremes, as a part of the record


def statistics(
    run_file: Annotated[
        Path,
        typer.Argument(
            metavar="RUN.nc",
            help="Result of a run or of a study, also of an unfinished one (RUNS.nc.partial).",
        ),
    ],
    start: From = "",
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
    verbose: Verbose = False,
    overwrite: Overwrite = False,
) -> None:
    """Print means, periods, extremes with two kinds of intervals, and crawl in each contact
    phase."""
    from hydrosim.commands.study import place_table, show_study
    from hydrosim.errors import InputError
    from hydrosim.results.channels import channel_names, match_channels
    from hydrosim.results.netcdf import read_run, write_run
    from hydrosim.results.unfinished import runs_at
    from hydrosim.statistics.statistics import enough_from
    from hydrosim.statistics.statistics import statistics as of_run
    from hydrosim.wording.statistics import statistics_document

    if (runs := runs_at(run_file)) is not None:
        table = place_table(run_file, output, overwrite=overwrite)
        show_study(runs, table, verbose)
        return
    require_file(run_file, "the result of a run or of a study (RUN.nc)")
    name = f"{run_file.stem}_statistics"
    result = output_for(output, name, "statistics", run_file, overwrite=overwrite)
    run = read_run(run_file)
    begin, end = seconds("--from", start, 0.0), float(run.time[-1])
    if not enough_from(run, begin):
        raise InputError(
            f"--from: found {begin:g} s; expected a time well before the end of the run at"
            f" {end:g} s."
        )
    least = MIN_EXTREME_SHARE * (end - max(begin, float(run.time[0])))
    exposure = seconds("--duration", duration, inf) if duration else None
    if exposure is not None and not least <= exposure < inf:
        raise InputError(
            f"--duration: found {exposure:g} s; expected at least a tenth of the record,"
            f" {least:g} s. The record itself holds many samples of shorter durations."
        )
    asked = names_in(channels)
    known = channel_names(run)
    asked += ["utilisation.*"] if any(name.startswith("utilisation.") for name in known) else []
    with progress("statistics"):
        found = of_run(run, begin, exposure, match_channels(known, asked, "--channels"))
        write_run(found, result)
    print_lines(*not_complete(run.attrs))
    show_document(statistics_document(run, found), verbose)
    print_lines(f"result    {result.path}")
