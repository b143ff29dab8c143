"""`hydrosim operability`: in which seas a case holds its criteria, and what that is worth."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrosim.commands.compiling import announced
from hydrosim.commands.options import Overwrite, StudyFile, Workers, placed
from hydrosim.commands.running import resumable
from hydrosim.commands.terminal import progress_console, show
from hydrosim.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.studies.operability.study import Limits

err = progress_console()


def operability(
    study_file: StudyFile,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="LIMITS.nc", help="Where to write the result."),
    ] = None,
    workers: Workers = None,
    overwrite: Overwrite = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with a search that was killed or interrupted.")
    ] = False,
) -> None:
    """Find limiting significant heights over peak periods, headings and swells, with confidence.

    It also tells the workability in a scatter diagram and waiting times in a hindcast.
    """
    from hydrosim.plot.operability import draw_limits
    from hydrosim.results.netcdf import write
    from hydrosim.studies.many.unfinished import kept
    from hydrosim.studies.operability.study import limits_of, load_limits
    from hydrosim.studies.operability.weather import assessed, read_weather, weather_lines

    with announced(err):
        study = load_limits(study_file)
    name = f"{study_file.stem}_operability"
    result = placed(
        output,
        name,
        "limits",
        study_file,
        inputs=study.inputs,
        overwrite=overwrite,
        settings=study.settings,
    )
    page = result.at(result.path.with_suffix(".png"), "picture").checked()
    weather = read_weather(study_file.parent, study.wanted)
    with (
        resumable("--resume"),
        kept(result, resume, study.identity) as journal,
        announced(err),
        err.status("limits") as status,
    ):

        def report(sea: str, runs: int, done: int) -> None:
            status.update(f"{sea}: {done} seas done, {runs} runs")

        limits = limits_of(study, workers or os.cpu_count() or 1, report, journal)
        found = assessed(limits, weather)
        write(found, result)
        journal.remove()
    draw_limits(found, page)
    show(*_lines(study, found), *weather_lines(found, weather))
    show(f"result    {result.path}, {page.path}")
    if remedy := _nowhere(found.sel(stage="all")):
        raise InputError(f"{study_file}: operability.heights: {remedy}. The result is written.")


def _nowhere(found: xr.Dataset) -> str:
    """What to do where the heights of no sea have the limit between them; nothing where one has."""
    limits = found.limit.values.ravel().tolist()
    sides = {_side(limit, found) for limit in limits}
    if "" in sides:
        return ""
    said = f"found no limit from {found.attrs['lowest']:g} m to {found.attrs['highest']:g} m in any"
    match sorted(sides):
        case ["above"]:
            return f"{said} sea, as all holds; raise the last height, or set narrower limits"
        case ["below"]:
            return f"{said} sea, as the first is too high already; begin with a lower one"
    return f"{said} sea: some hold all, some not the first; take more heights on both sides"


def _side(limit: float, found: xr.Dataset) -> str:
    """On which side of the heights a limit is; of none if it is between them."""
    if limit < found.attrs["lowest"]:
        return "below"
    near = 0.5 * found.attrs["apart"] if found.attrs["runs"] else 0.0
    return "above" if limit >= found.attrs["highest"] - near else ""


def _lines(study: Limits, found: xr.Dataset) -> Iterator[str]:
    yield from found.attrs["criteria"].splitlines()
    share = found.attrs["probability"]
    if found.attrs["runs"]:
        of = found.attrs["runs_of_all"]
        runs = found.attrs["runs"]
        yield (
            f"limits with {share:.3g} of the seas, {found.attrs['method']}: {runs} runs of"
            f" {found.attrs['seeds']} seeds, {runs / of:.0%} of those of a whole grid"
        )
        guessed = int(found.inferred.sum())
        wrong = int(found.otherwise.sum())
        yield f"of {guessed} runs at limits that were inferred from other heights, {wrong} differ"
    else:
        yield f"limits with a probability of {share:.3g}, {found.attrs['method']}"
    if "failed" in found.attrs:
        yield f"warning   {found.attrs['failed']}"
    for stage in found.stage.values:
        for swell in found.swell.values:
            for heading in found.heading.values:
                yield from _curve(found.sel(stage=stage, swell=swell, heading=heading))


def _curve(found: xr.Dataset) -> Iterator[str]:
    from numpy import degrees

    swell = "" if str(found.swell.values) == "none" else f", swell {found.swell.values}"
    yield f"{found.stage.values}, heading {degrees(float(found.heading)):g} deg{swell}:"
    for period in found.peak_period.values:
        at = found.sel(peak_period=period)
        yield f"  Tp {period:g} s: {_limit(at)}  {at.governing.values}".rstrip()


def _limit(at: xr.Dataset) -> str:
    limit, low, high = (float(at[name]) for name in ("limit", "low", "high"))
    lowest = at.attrs["lowest"]
    highest = at.attrs["highest"]
    side = _side(limit, at)
    if side == "below":
        return f"no limit in the range: {lowest:g} m is too high already"
    if side == "above":
        return f"no limit in the range: all holds up to {highest:g} m"
    if not at.attrs["runs"]:
        return f"Hs {limit:.3f} m"
    ends = f"{max(low, 0.0):.2f} to {high:.2f} m" if high <= highest else f"{low:.2f} m or more"
    return f"Hs {limit:.2f} m ({ends})"
