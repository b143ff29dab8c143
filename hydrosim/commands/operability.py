"""`hydrosim operability`: sea states in which a case meets its criteria, with confidence."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrosim.commands.compiling import announce_compiling
from hydrosim.commands.options import Overwrite, StudyFile, Verbose, Workers, output_for
from hydrosim.commands.progress import progress
from hydrosim.commands.running import print_resume_hint
from hydrosim.commands.terminal import print_lines, progress_console, show_document
from hydrosim.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

err = progress_console()


def operability(
    study_file: StudyFile,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="LIMITS.nc", help="netCDF file to write."),
    ] = None,
    workers: Workers = None,
    overwrite: Overwrite = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue a search that was killed or interrupted.")
    ] = False,
    verbose: Verbose = False,
) -> None:
    """Find limiting significant wave heights over peak periods, headings and swells, with
    confidence.

    It also computes the workability in a scatter diagram and waiting times in a hindcast.
    """
    from hydrosim.plot.operability import draw_limits
    from hydrosim.results.netcdf import write_run
    from hydrosim.studies.many.unfinished import locked_journal
    from hydrosim.studies.operability.study import limits_of, load_limits
    from hydrosim.studies.operability.weather import assess_weather, read_weather
    from hydrosim.wording.limits import limits_tables

    with announce_compiling(err):
        study = load_limits(study_file)
    name = f"{study_file.stem}_operability"
    result = output_for(
        output,
        name,
        "limits",
        study_file,
        inputs=study.inputs,
        overwrite=overwrite,
        settings=study.settings,
    )
    page = result.output_at(result.path.with_suffix(".png"), "picture").checked_output()
    weather = read_weather(study_file.parent, study.wanted)
    with (
        print_resume_hint("--resume"),
        locked_journal(result, resume, study.identity) as journal,
        announce_compiling(err),
        progress("limits", "seas") as report,
    ):

        def tell(sea: str, runs: int, done: int) -> None:
            report(done, study.seas, f"{sea}, {runs} runs")

        limits = limits_of(study, workers or os.cpu_count() or 1, tell, journal)
        found = assess_weather(limits, weather)
        write_run(found, result)
        journal.remove()
    draw_limits(found, page)
    show_document(limits_tables(found), verbose)
    print_lines(f"result    {result.path}, {page.path}")
    if remedy := _nowhere(found.sel(stage="all")):
        raise InputError(f"{study_file}: operability.heights: {remedy}. The result was written.")


def _nowhere(found: xr.Dataset) -> str:
    """Remedy if the limit of no sea state lies between the heights; empty if one does."""
    from hydrosim.wording.limits import side_of

    limits = found.limit.values.ravel().tolist()
    sides = {side_of(limit, found) for limit in limits}
    if "" in sides:
        return ""
    text = f"found no limit from {found.attrs['lowest']:g} m to {found.attrs['highest']:g} m in any"
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
