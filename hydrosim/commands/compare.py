"""`hydrosim compare`: a run against a recording, or two results against each other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrosim.commands.options import (
    From,
    Overwrite,
    To,
    Verbose,
    numbers,
    placed,
    refuse_options,
    window_of,
)
from hydrosim.commands.terminal import show, show_document
from hydrosim.errors import InputError
from hydrosim.presentation.units import choice_in, units_of

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.outputs import Output

RunFile = Annotated[
    Path, typer.Argument(metavar="RUN.nc", help="The result of a run, or of a study.")
]
Channels = Annotated[
    str | None,
    typer.Option(
        help='Take these channels, by commas; * is anything: "position.*,wave_elevation".'
    ),
]


def compare(
    context: typer.Context,
    run_file: RunFile,
    recorded: Annotated[
        Path,
        typer.Argument(
            metavar="RECORDED", help="What to lay it over: text, MATLAB, HDF5, netCDF or a run."
        ),
    ],
    mapping: Annotated[
        Path | None,
        typer.Option(
            "--mapping",
            "-m",
            metavar="MAP.yaml",
            help="Read from this file which column is which channel.",
        ),
    ] = None,
    tolerance: Annotated[
        list[str],
        typer.Option(
            metavar="[CHANNEL=]NUMBER", help="End with code 1 if rms over std is beyond this."
        ),
    ] = [],  # noqa: B006  typer copies it
    shift: Annotated[bool, typer.Option("--shift", help="Estimate a shift of the times.")] = False,
    channels: Channels = None,
    start: From = "",
    end: To = "",
    bands: Annotated[
        str, typer.Option(help="Count as waves what is between these frequencies (rad/s).")
    ] = "0.1,2.5",
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="RESIDUALS.nc", help="Write series and figures there."
        ),
    ] = None,
    exact: Annotated[
        bool,
        typer.Option(
            "--exact", help="Say whether two results are identical; end with code 1 if not."
        ),
    ] = False,
    but: Annotated[
        str, typer.Option(metavar="NAMES", help="Leave these names out of --exact, by commas.")
    ] = "",
    verbose: Verbose = False,
    overwrite: Overwrite = False,
) -> None:
    """Lay a run over a recorded series, and say channel by channel what differs.

    Writes both series and their difference as netCDF, and a picture. Exit code 1 if a channel is
    beyond its --tolerance; that of a channel that is constant is absolute. With --exact it is said
    what differs between any two results, to the bit, and nothing is written. Of two files of many
    runs it is said, and written, which of their numbers differ by more than chance; of the options
    they take --output and --overwrite alone. `hydrosim report` makes a page of what is written.
    """
    if exact:
        refuse_options(context, {"exact", "but"}, "--exact, which compares all there is")
        _exactly(run_file, recorded, _patterns(but))
        return
    if but:
        raise InputError("--but: found no --exact; expected it, of which it leaves names out.")
    name = f"{run_file.stem}_compare"
    from hydrosim.results.runs_file import open_runs

    if (runs := open_runs(run_file)) is not None:
        refuse_options(
            context, {"output", "overwrite", "verbose"}, f"{run_file}, a file of many runs"
        )
        result = placed(
            output, name, "comparison", run_file, inputs=[recorded], overwrite=overwrite
        )
        _of_many(runs, run_file, recorded, result, verbose)
        return
    from hydrosim.compare import compare as comparison_of
    from hydrosim.compare import read_mapping
    from hydrosim.compare.comparison import beyond, by_channel
    from hydrosim.compare.dataset import to_dataset
    from hydrosim.plot.compare import draw_comparison
    from hydrosim.plot.load import open_run
    from hydrosim.recordings import read_recording
    from hydrosim.results.netcdf import write
    from hydrosim.wording.comparison import comparison_tables

    inputs = [path for path in (recorded, mapping) if path]
    result = placed(output, name, "comparison", run_file, inputs=inputs, overwrite=overwrite)
    page = result.at(result.path.with_suffix(".png"), "picture").checked()
    between = window_of(start, end)
    given = dict(_tolerance(text) for text in tolerance)
    run = open_run(run_file)
    found = comparison_of(
        run,
        read_recording(recorded),
        None if mapping is None else read_mapping(mapping),
        shift=shift,
        between=between,
        edges=_edges(bands),
        only=_patterns(channels) or ("*",),
    )
    out_of = beyond(found, given)
    said = _compared(run, run_file, recorded)
    dataset = to_dataset(found, said, by_channel(found, given))
    write(dataset, result)
    title = f"{run_file.name} and {recorded.name}"
    draw_comparison(found, title, page, units_of(dataset.attrs))
    show_document(comparison_tables(dataset), verbose)
    show(f"result    {result.path}, {page.path}")
    if out_of:
        raise typer.Exit(1)


def _of_many(ours: xr.Dataset, one: Path, other: Path, result: Output, verbose: bool) -> None:
    """Compare two files of many runs; InputError if the other is none."""
    from hydrosim.compare.dataset import studies_dataset
    from hydrosim.compare.studies import compare_studies
    from hydrosim.results.netcdf import write
    from hydrosim.results.runs_file import open_runs
    from hydrosim.wording.compared_studies import studies_tables

    theirs = open_runs(other)
    if theirs is None:
        raise InputError(f"{other}: is no file of many runs, as {one} is; expected another such.")
    found = compare_studies(ours, theirs)
    dataset = studies_dataset(found, _compared(ours, one, other))
    write(dataset, result)
    show_document(studies_tables(dataset), verbose)
    show(f"result    {result.path}")


def _compared(ours: xr.Dataset, one: Path, other: Path) -> dict[str, object]:
    """What was compared with what, as the result says it."""
    title = str(ours.attrs.get("title", ""))
    return {"title": title, "run": str(one), "recording": str(other), **choice_in(ours.attrs)}


def _exactly(one: Path, other: Path, but: Sequence[str]) -> None:
    """Say what differs between two results, or that they are identical."""
    from hydrosim.compare.exact import OF_MAKING, differences, read_result

    first, second = read_result(one), read_result(other)
    found = differences(first, second, but)
    show(*found)
    if found:
        raise typer.Exit(1)
    apart = ", ".join(sorted({*OF_MAKING, *but}))
    counts = f"{len(first.variables)} variables and {len(first.attrs)} attributes"
    show(f"identical: {counts}, apart from {apart}")


def _patterns(text: str | None) -> list[str]:
    return [part.strip() for part in text.split(",")] if text else []


def _tolerance(text: str) -> tuple[str, float]:
    """Channel or pattern, and the number."""
    name, _, number = text.rpartition("=")
    return name.strip() or "*", numbers(number, "--tolerance")[0]


def _edges(text: str) -> tuple[float, float]:
    edges = numbers(text, "--bands")
    if len(edges) != 2 or edges[0] >= edges[1]:
        raise InputError(f"--bands: found {text!r}; expected two numbers that rise, as in 0.1,2.5.")
    return edges[0], edges[1]
