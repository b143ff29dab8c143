"""`hydrosim compare`: compare a run with a recording, or two results with each other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrosim.cli.options import (
    From,
    Overwrite,
    To,
    Verbose,
    numbers,
    output_for,
    refuse_options,
    require_file,
    window_of,
)
from hydrosim.cli.terminal import print_lines, show_document
from hydrosim.errors import InputError
from hydrosim.files.display_units import unit_choice_attribute, units_of

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.files.outputs import Output

RunFile = Annotated[Path, typer.Argument(metavar="RUN.nc", help="Result of a run, or of a study.")]
Channels = Annotated[
    str | None,
    typer.Option(
        help='Channels, separated by commas; * matches anything: "position.*,wave_elevation".'
    ),
]


def compare(
    context: typer.Context,
    run_file: RunFile,
    recorded: Annotated[
        Path,
        typer.Argument(
            metavar="RECORDED", help="Recording: text, MATLAB, HDF5, netCDF or another run."
        ),
    ],
    mapping: Annotated[
        Path | None,
        typer.Option(
            "--mapping",
            "-m",
            metavar="MAP.yaml",
            help="File that assigns columns of the recording to channels.",
        ),
    ] = None,
    tolerance: Annotated[
        list[str],
        typer.Option(
            metavar="[CHANNEL=]NUMBER",
            help="End with exit code 1 if rms of the difference over"
            " standard deviation exceeds this.",
        ),
    ] = [],  # noqa: B006  typer copies it
    shift: Annotated[
        bool, typer.Option("--shift", help="Estimate a time shift between run and recording.")
    ] = False,
    channels: Channels = None,
    start: From = "",
    end: To = "",
    bands: Annotated[
        str,
        typer.Option(
            help="Lowest and highest frequency (rad/s) of the wave band; the rest is slow or fast."
        ),
    ] = "0.1,2.5",
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="RESIDUALS.nc",
            help="netCDF file for both series and their differences.",
        ),
    ] = None,
    exact: Annotated[
        bool,
        typer.Option(
            "--exact",
            help="Check that two results are identical to the bit; end with exit code 1 if not.",
        ),
    ] = False,
    ignore: Annotated[
        str, typer.Option(metavar="NAMES", help="Comma-separated variables that --exact skips.")
    ] = "",
    verbose: Verbose = False,
    overwrite: Overwrite = False,
) -> None:
    """Compare a run with a recorded series, channel by channel.

    The command writes both series and their difference as netCDF, and a picture. It ends with exit
    code 1 if a channel exceeds its --tolerance. The tolerance of a constant channel is absolute.
    With --exact, the command prints every difference between two results and writes no file. If
    both are files of many runs, it prints and writes which figures differ by more than chance. For
    such files only --output and --overwrite apply. `hydrosim report` makes a page of the written
    file.
    """
    if exact:
        refuse_options(context, {"exact", "ignore"}, "--exact, which compares all variables")
        _compare_exactly(run_file, recorded, _patterns(ignore))
        return
    if ignore:
        raise InputError(
            "--ignore: found no --exact; expected both. --ignore names variables"
            " that --exact skips."
        )
    name = f"{run_file.stem}_compare"
    from hydrosim.results.runs_file import open_runs

    if (runs := open_runs(run_file)) is not None:
        refuse_options(
            context, {"output", "overwrite", "verbose"}, f"{run_file}, a file of many runs"
        )
        result = output_for(
            output, name, "comparison", run_file, inputs=[recorded], overwrite=overwrite
        )
        _of_many(runs, run_file, recorded, result, verbose)
        return
    from hydrosim.compare import compare as comparison_of
    from hydrosim.compare import read_mapping
    from hydrosim.compare.comparison import by_channel, exceeded_tolerances
    from hydrosim.compare.dataset import to_dataset
    from hydrosim.files.recordings import read_recording
    from hydrosim.report.charts.compare import draw_comparison
    from hydrosim.report.sentences.comparison import comparison_tables
    from hydrosim.results.dataset import write_run
    from hydrosim.simulation import open_run

    require_file(run_file, "the result of a run (RUN.nc)")
    require_file(recorded, "a recorded series (csv, MATLAB, HDF5 or netCDF)")
    inputs = [path for path in (recorded, mapping) if path]
    result = output_for(output, name, "comparison", run_file, inputs=inputs, overwrite=overwrite)
    page = result.output_at(result.path.with_suffix(".png"), "picture").checked_output()
    between = window_of(start, end)
    given = dict(_tolerance(text) for text in tolerance)
    run = open_run(run_file)
    comparison = comparison_of(
        run,
        read_recording(recorded),
        None if mapping is None else read_mapping(mapping),
        shift=shift,
        between=between,
        edges=_edges(bands),
        only=_patterns(channels) or ("*",),
    )
    out_of = exceeded_tolerances(comparison, given)
    attributes = _comparison_attributes(run, run_file, recorded)
    dataset = to_dataset(comparison, attributes, by_channel(comparison, given))
    write_run(dataset, result)
    title = f"{run_file.name} and {recorded.name}"
    draw_comparison(comparison, title, page, units_of(dataset.attrs))
    show_document(comparison_tables(dataset), verbose)
    print_lines(f"result    {result.path}, {page.path}")
    if out_of:
        raise typer.Exit(1)


def _of_many(
    ours: xr.Dataset, run_file: Path, recorded: Path, result: Output, verbose: bool
) -> None:
    """Compare two files of many runs. Raises InputError if ``recorded`` is not such a file."""
    from hydrosim.compare.dataset import studies_dataset
    from hydrosim.compare.studies import compare_studies
    from hydrosim.report.sentences.comparison import studies_tables
    from hydrosim.results.dataset import write_run
    from hydrosim.results.runs_file import open_runs

    theirs = open_runs(recorded)
    if theirs is None:
        raise InputError(
            f"{recorded}: is a result of one run; expected a file of many runs, because"
            f" {run_file} is one."
        )
    comparison = compare_studies(ours, theirs)
    dataset = studies_dataset(comparison, _comparison_attributes(ours, run_file, recorded))
    write_run(dataset, result)
    show_document(studies_tables(dataset), verbose)
    print_lines(f"result    {result.path}")


def _comparison_attributes(ours: xr.Dataset, run_file: Path, recorded: Path) -> dict[str, object]:
    """Title, files and units of a comparison, for the attributes of its result."""
    title = str(ours.attrs.get("title", ""))
    return {
        "title": title,
        "run": str(run_file),
        "recording": str(recorded),
        **unit_choice_attribute(ours.attrs),
    }


def _compare_exactly(first_file: Path, second_file: Path, but: Sequence[str]) -> None:
    """Print the differences between two results, or that they are identical. Exit code 1 if any."""
    from hydrosim.compare.exact import OF_MAKING, differences, read_result

    first, second = read_result(first_file), read_result(second_file)
    difference_lines = differences(first, second, but)
    print_lines(*difference_lines)
    if difference_lines:
        raise typer.Exit(1)
    apart = ", ".join(sorted({*OF_MAKING, *but}))
    counts = f"{len(first.variables)} variables and {len(first.attrs)} attributes"
    print_lines(f"identical: {counts}, apart from {apart}")


def _patterns(text: str | None) -> list[str]:
    return [part.strip() for part in text.split(",")] if text else []


def _tolerance(text: str) -> tuple[str, float]:
    """Channel or pattern, and its tolerance, from CHANNEL=NUMBER or NUMBER."""
    name, _, number = text.rpartition("=")
    return name.strip() or "*", numbers(number, "--tolerance")[0]


def _edges(text: str) -> tuple[float, float]:
    edges = numbers(text, "--bands")
    if len(edges) != 2 or edges[0] >= edges[1]:
        raise InputError(
            f"--bands: found {text!r}; expected two increasing frequencies in rad/s,"
            " such as 0.1,2.5."
        )
    return edges[0], edges[1]
