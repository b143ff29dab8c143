"""Commands on results: `hydrosim show`, `report`, `compare` and `export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hydrosim.cli import options, terminal
from hydrosim.cli.options import argument, option
from hydrosim.errors import InputError


def show(
    context: typer.Context,
    file: options.ResultFile,
    statistics: Annotated[
        bool, option("Means, periods, extremes with intervals; crawl.", "--statistics")
    ] = False,
    direction: Annotated[
        str | None,
        option(
            "Why a body moved: surge, sway or heave; barge.surge.", "--why", metavar="[BODY.]DOF"
        ),
    ] = None,
    plot: Annotated[bool, option("Pictures.", "--plot")] = False,
    channels: options.Channels = "",
    start: options.From = "",
    end: options.To = "",
    duration: Annotated[
        str,
        option('Duration of extremes: "3 hour"; default: the record.', metavar="TIME"),
    ] = "",
    format: Annotated[str, option("Of pictures.", metavar="png|svg|pdf")] = "",
    output: Annotated[
        Path | None,
        option("File to write; folder of pictures.", "--output", "-o", metavar="FILE"),
    ] = None,
    verbose: options.Verbose = False,
    overwrite: options.Overwrite = False,
) -> None:
    """Show a result: summary, --statistics, --why it moved, or --plot.

    The summary is the text that the command printed which wrote the result. The other three also
    write files. --why needs a run with `output: {impulses: true}`.
    """
    from hydrosim.interface import show as showing

    given = terminal.given_options(context, "file", *VIEWS, "verbose")
    views = [name for name, view in zip(VIEWS, (statistics, direction, plot), strict=True) if view]
    if len(views) > 1:
        raise InputError(f"{', '.join(views)}: found several; expected one of them.")
    view = views[0] if views else ""
    if foreign := [name for name in given if name not in VIEWS.get(view, ())]:
        reason = f"`{view}`" if view else "a summary; expected `statistics`, `direction` or `plot`"
        raise InputError(f"{', '.join(foreign)}: not possible with {reason}.")
    match view:
        case "statistics":
            given["output"] = output or True
            with terminal.progress("statistics"):
                result = showing.find_extremes(file, **given)
        case "direction":
            given["output"] = output or True
            with terminal.progress("explaining"):
                result = showing.explain(file, direction=str(direction), **given)
        case "plot":
            folder = given.pop("output", None)
            with terminal.progress("drawing"):
                result = showing.draw_pictures(file, folder, **given)
        case _:
            result = showing.summarise(file)
    terminal.show_result(result, verbose)


FILES = ("output", "overwrite")
VIEWS = {
    "statistics": ("channels", "start", "duration", *FILES),
    "direction": ("start", "end", *FILES),
    "plot": ("channels", "start", "end", "format", *FILES),
}
"""Options of each view."""


def report(
    file: options.ResultFile,
    replay: Annotated[bool, option("Its three-dimensional animation alone.", "--replay")] = False,
    output: options.Output = None,
    overwrite: options.Overwrite = False,
) -> None:
    """Write the report of a result: one HTML file without network.

    The report of a run shows its case, assumptions, stages, statistics with intervals, time series
    and energy. Studies, limits of operation and comparisons have reports, too.
    """
    from hydrosim.interface.show import write_report

    with terminal.progress("replay" if replay else "report"):
        result = write_report(file, output or True, replay=replay, overwrite=overwrite)
    terminal.print_lines(*result.lines)


def compare(
    context: typer.Context,
    file: Annotated[Path, argument("RUN.nc", "Result of a run, or of a study.")],
    recorded: Annotated[
        Path, argument("RECORDED", "Recording: text, MATLAB, HDF5, netCDF; or another result.")
    ],
    mapping: Annotated[
        Path | None,
        option("Assigns columns to channels.", "--mapping", "-m", metavar="MAP.yaml"),
    ] = None,
    tolerance: Annotated[
        list[str],
        option(
            "Exit code 1 if rms of the difference over standard deviation exceeds this.",
            metavar="[CHANNEL=]NUMBER",
        ),
    ] = [],  # noqa: B006  typer copies it
    shift: Annotated[bool, option("Estimate a shift in time.", "--shift")] = False,
    channels: options.Channels = "",
    start: options.From = "",
    end: options.To = "",
    bands: Annotated[str | None, option("Wave band (rad/s); default: 0.1,2.5.")] = None,
    exact: Annotated[
        bool, option("Whether two results are identical to the bit; exit code 1 if not.", "--exact")
    ] = False,
    ignore: Annotated[
        str, option("Variables that --exact skips, with commas.", metavar="NAMES")
    ] = "",
    output: options.Output = None,
    verbose: options.Verbose = False,
    overwrite: options.Overwrite = False,
) -> None:
    """Compare a run with a recording, channel by channel; or two results.

    Both series and their difference are written as netCDF, with a picture. The tolerance of a
    constant channel is absolute. If both files hold many runs, the command prints which figures
    differ by more than chance. With --exact it prints every difference, and writes no file.
    """
    from hydrosim.files.arguments import numbers
    from hydrosim.interface.compare import compare as compare_files

    given = terminal.given_options(context, "file", "recorded", "verbose")
    if tolerance:
        pairs = [text.rpartition("=") for text in tolerance]
        limits = {name.strip() or "*": numbers(text, "tolerance")[0] for name, _, text in pairs}
        given["tolerance"] = limits
    given.setdefault("output", True)
    result = compare_files(file, recorded, **given)
    terminal.show_result(result, verbose)
    if result.failed:
        raise typer.Exit(1)


def export(
    context: typer.Context,
    file: options.RunFile,
    channels: options.Channels = "",
    start: options.From = "",
    end: options.To = "",
    units: Annotated[
        str, option("Units of the case, or SI; default: by the format.", metavar="case|si")
    ] = "",
    date: Annotated[
        str, option("Date (UTC) of time 0 s, for .nc: 2026-05-31T06:00.", metavar="DATE")
    ] = "",
    recording: Annotated[
        bool, option("Text table with names and units, for compare.", "--recording")
    ] = False,
    step: Annotated[
        str, option('Time step of a recording: "0.5 s"; default: all times.', metavar="TIME")
    ] = "",
    digits: Annotated[
        int | None,
        typer.Option(min=1, max=17, help="Significant digits of a recording; default: 17, exact."),
    ] = None,
    case: Annotated[
        bool, option("Print the case that repeats the run, with every default.", "--case")
    ] = False,
    number: Annotated[
        int | None, option("Number of the run in a file of many, from 0.", "--run")
    ] = None,
    output: Annotated[
        Path | None,
        option(".nc (CF), .csv, .mat or .parquet; of a recording, any.", "-o", "--output"),
    ] = None,
    overwrite: options.Overwrite = False,
) -> None:
    """Write a run for other programs, or as a --case that repeats it.

    CSV, MATLAB and Parquet have the units that the case wrote, else deg, kN, m, t. CF netCDF and
    recordings are in SI. With --case, a file of MoorDyn or MoorPy gives its lines as keys.
    """
    from hydrosim.interface import compare as exporting

    given = terminal.given_options(context, "file")
    if case:
        if foreign := [name for name in given if name not in ("case", "number")]:
            hint = "Leave it out; the case is printed: > CASE.yaml writes it."
            raise InputError(f"{', '.join(foreign)}: not possible with `case`. {hint}")
        typer.echo(exporting.repeating_case(file, number), nl=False)
        return
    if number is not None:
        raise InputError("number: found no `case`; expected both.")
    if output is None:
        raise InputError(
            "output: found none; expected a file that ends in .nc, .csv, .mat or .parquet, or"
            " `case`."
        )
    with terminal.progress("writing"):
        result = exporting.export(file, **given)
    terminal.print_lines(*result.lines)
