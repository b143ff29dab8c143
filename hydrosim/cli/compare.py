"""Commands `hydrosim compare` (a run with a recording, or two results) and `hydrosim export`."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from enum import StrEnum
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrosim.cli import terminal
from hydrosim.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.compare.export import ExportTable
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
    start: terminal.From = "",
    end: terminal.To = "",
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
    verbose: terminal.Verbose = False,
    overwrite: terminal.Overwrite = False,
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
        terminal.refuse_options(
            context, {"exact", "ignore"}, "--exact, which compares all variables"
        )
        _compare_exactly(run_file, recorded, _split_patterns(ignore))
        return
    if ignore:
        raise InputError(
            "--ignore: found no --exact; expected both. --ignore names variables"
            " that --exact skips."
        )
    name = f"{run_file.stem}_compare"
    from hydrosim.results.runs_file import open_runs

    if (runs := open_runs(run_file)) is not None:
        terminal.refuse_options(
            context, {"output", "overwrite", "verbose"}, f"{run_file}, a file of many runs"
        )
        result = terminal.output_for(
            output, name, "comparison", run_file, inputs=[recorded], overwrite=overwrite
        )
        _compare_studies(runs, run_file, recorded, result, verbose)
        return
    from hydrosim.compare import compare as comparison_of
    from hydrosim.compare import read_mapping
    from hydrosim.compare.comparison import exceeded_tolerances, tolerances_by_channel
    from hydrosim.compare.dataset import to_dataset
    from hydrosim.files.display_units import units_of
    from hydrosim.files.recordings import read_recording
    from hydrosim.report.charts.explain import draw_comparison
    from hydrosim.report.sentences.comparison import comparison_tables
    from hydrosim.results.dataset import write_run
    from hydrosim.simulation import open_run

    terminal.require_file(run_file, "the result of a run (RUN.nc)")
    terminal.require_file(recorded, "a recorded series (csv, MATLAB, HDF5 or netCDF)")
    inputs = [path for path in (recorded, mapping) if path]
    result = terminal.output_for(
        output, name, "comparison", run_file, inputs=inputs, overwrite=overwrite
    )
    page = result.output_at(result.path.with_suffix(".png"), "picture").checked_output()
    between = terminal.window_of(start, end)
    given = dict(_read_tolerance(text) for text in tolerance)
    run = open_run(run_file)
    comparison = comparison_of(
        run,
        read_recording(recorded),
        None if mapping is None else read_mapping(mapping),
        shift=shift,
        between=between,
        edges=_read_band_edges(bands),
        only=_split_patterns(channels) or ("*",),
    )
    out_of = exceeded_tolerances(comparison, given)
    attributes = _comparison_attributes(run, run_file, recorded)
    dataset = to_dataset(comparison, attributes, tolerances_by_channel(comparison, given))
    write_run(dataset, result)
    title = f"{run_file.name} and {recorded.name}"
    draw_comparison(comparison, title, page, units_of(dataset.attrs))
    terminal.show_document(comparison_tables(dataset), verbose)
    terminal.print_lines(f"result    {result.path}, {page.path}")
    if out_of:
        raise typer.Exit(1)


def _compare_studies(
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
    terminal.show_document(studies_tables(dataset), verbose)
    terminal.print_lines(f"result    {result.path}")


def _comparison_attributes(ours: xr.Dataset, run_file: Path, recorded: Path) -> dict[str, object]:
    """Title, files and units of a comparison, for the attributes of its result."""
    from hydrosim.files.display_units import unit_choice_attribute

    title = str(ours.attrs.get("title", ""))
    return {
        "title": title,
        "run": str(run_file),
        "recording": str(recorded),
        **unit_choice_attribute(ours.attrs),
    }


def _compare_exactly(first_file: Path, second_file: Path, but: Sequence[str]) -> None:
    """Print the differences between two results, or that they are identical. Exit code 1 if any."""
    from hydrosim.compare.dataset import OF_MAKING, differences, read_result

    first, second = read_result(first_file), read_result(second_file)
    difference_lines = differences(first, second, but)
    terminal.print_lines(*difference_lines)
    if difference_lines:
        raise typer.Exit(1)
    apart = ", ".join(sorted({*OF_MAKING, *but}))
    counts = f"{len(first.variables)} variables and {len(first.attrs)} attributes"
    terminal.print_lines(f"identical: {counts}, apart from {apart}")


def _split_patterns(text: str | None) -> list[str]:
    return [part.strip() for part in text.split(",")] if text else []


def _read_tolerance(text: str) -> tuple[str, float]:
    """Channel or pattern, and its tolerance, from CHANNEL=NUMBER or NUMBER."""
    name, _, number = text.rpartition("=")
    return name.strip() or "*", terminal.numbers(number, "--tolerance")[0]


def _read_band_edges(text: str) -> tuple[float, float]:
    edges = terminal.numbers(text, "--bands")
    if len(edges) != 2 or edges[0] >= edges[1]:
        raise InputError(
            f"--bands: found {text!r}; expected two increasing frequencies in rad/s,"
            " such as 0.1,2.5."
        )
    return edges[0], edges[1]


# `hydrosim export`: write channels of a run for other programs.


class ExportUnits(StrEnum):
    """Whose units are written."""

    CASE = "case"
    SI = "si"


SUFFIXES = (".nc", ".csv", ".mat", ".parquet")


def export(
    run_file: Annotated[Path, typer.Argument(metavar="RUN.nc", help="Result of a run.")],
    output: Annotated[
        Path,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="File to write: .nc (CF), .csv, .mat (MATLAB) or .parquet; a recording may have"
            " any name.",
        ),
    ],
    channels: Annotated[
        str,
        typer.Option(
            metavar="NAMES",
            help='Channels to write, separated by commas: "position.*,speed.barge".',
        ),
    ] = "",
    start: terminal.From = "",
    end: terminal.To = "",
    date: Annotated[
        str,
        typer.Option(
            metavar="DATE",
            help="Date (UTC) at which time 0 s of the run falls, for .nc: 2026-05-31T06:00.",
        ),
    ] = "",
    recording: Annotated[
        bool,
        typer.Option(
            "--recording",
            help="Write a text table with names and units, which hydrosim compare reads.",
        ),
    ] = False,
    step: Annotated[
        str,
        typer.Option(
            metavar="TIME",
            help='Time step of the recording: "0.5 s", or a number in seconds;'
            " default: the output times of the run.",
        ),
    ] = "",
    digits: Annotated[
        int,
        typer.Option(
            min=1, max=17, help="Significant digits of numbers in the recording; 17 are exact."
        ),
    ] = 17,
    units: Annotated[
        str,
        typer.Option(
            metavar="case|si", help="Write the units of the case, or SI; else as said above."
        ),
    ] = "",
    overwrite: terminal.Overwrite = False,
) -> None:
    """Write the channels of a run as CF netCDF, CSV, MATLAB, Parquet, or as a recording in text.

    CSV, MATLAB and Parquet have the units that the case wrote, else deg, kN, m, t. CF netCDF and
    recordings are in SI.
    """
    from hydrosim.compare.export import table_of
    from hydrosim.files.display_units import units_of
    from hydrosim.results.dataset import read_run
    from hydrosim.results.runs_file import open_runs

    if recording:
        read_in = terminal.one_of(ExportUnits, units or ExportUnits.SI, "--units")
        _write_recording(
            run_file, output, terminal.names_in(channels), step, digits, overwrite, read_in
        )
        return
    if step:
        raise InputError(
            "--step: found no --recording; expected both. Other files have the"
            " output times of the run."
        )
    suffix = _check_suffix(output)
    unit_system = _chosen_units(units, suffix)
    begin = _read_date(date, suffix)
    window = terminal.window_of(start, end)
    result = terminal.output_for(output, "", "export", run_file, overwrite=overwrite, suffix=suffix)
    if (runs := open_runs(run_file)) is not None:
        raise InputError(
            f"{run_file}: holds {runs.sizes['run']} runs; expected the result of one run."
            " `hydrosim case` prints the case of one of them, and `hydrosim run` makes its"
            " result."
        )
    run = read_run(run_file)
    table = table_of(run, terminal.names_in(channels), *window)
    if unit_system is ExportUnits.CASE:
        table = table.read_in(units_of(run.attrs))
    with terminal.progress("writing"):
        _write_table(table, result, begin)
    count, span = len(table.columns), f"{table.time[0]:g} to {table.time[-1]:g} s"
    terminal.print_lines(f"export    {count} channels at {table.time.size} times, {span}")
    terminal.print_lines(
        *terminal.incomplete_run_warnings(table.attributes), f"result    {result.path}"
    )


def _chosen_units(units: str, suffix: str) -> ExportUnits:
    """Whose units a table has. That of CF is in SI."""
    if suffix == ".nc":
        if units not in ("", ExportUnits.SI):
            raise InputError(f"--units: found {units}; expected si, as .nc is always in SI.")
        return ExportUnits.SI
    return terminal.one_of(ExportUnits, units or ExportUnits.CASE, "--units")


def _write_recording(
    run_file: Path,
    output: Path,
    asked: list[str],
    step: str,
    digits: int,
    overwrite: bool,
    unit_system: ExportUnits,
) -> None:
    """Write channels as a recording. Without names, it has the channels of motions, waves, forces,
    fenders and springs that are not zero."""
    from hydrosim.files.display_units import units_of
    from hydrosim.files.recordings import write_recording
    from hydrosim.files.series import columns_of
    from hydrosim.results.channels import default_channels, match_channels
    from hydrosim.simulation import open_run

    result = terminal.output_for(
        output, "", "recording", run_file, overwrite=overwrite, suffix=None
    )
    every = terminal.seconds("--step", step, 0.0) if step else None
    if every is not None and not every > 0.0:
        raise InputError(f"--step: found {every:g} s; expected a positive time, such as 0.5 s.")
    run = open_run(run_file)
    names = match_channels(columns_of(run), asked, "--channels") if asked else default_channels(run)
    case_units = units_of(run.attrs).display_unit if unit_system is ExportUnits.CASE else None
    write_recording(run, result, names, every, digits, case_units)
    terminal.print_lines(f"result    {result.path}, {len(names)} channels")


def _check_suffix(output: Path) -> str:
    if output.suffix not in SUFFIXES:
        raise InputError(
            f"--output: found {output}; expected a name that ends in {', '.join(SUFFIXES)}."
        )
    if output.suffix == ".parquet" and find_spec("pyarrow") is None:
        raise InputError(
            f"--output: {output} needs pyarrow, which is not installed:"
            " pip install 'hydrosim[export]'; or choose .csv, .mat or .nc."
        )
    return output.suffix


def _read_date(text: str, suffix: str) -> datetime | None:
    if not text:
        return None
    if suffix != ".nc":
        raise InputError(
            f"--date: only .nc has dates; {suffix} has times since the start of the"
            " run. Leave --date out."
        )
    try:
        date = datetime.fromisoformat(text)
    except ValueError:
        raise InputError(
            f"--date: found {text!r}; expected a date such as 2026-05-31T06:00."
        ) from None
    return date.astimezone(UTC) if date.tzinfo else date.replace(tzinfo=UTC)


def _write_table(table: ExportTable, result: Output, date: datetime | None) -> None:
    from hydrosim.compare import export

    with result.write_complete() as path:
        match path.suffix:
            case ".nc":
                export.write_netcdf(table, path, result.mark, date)
            case ".csv":
                export.write_text(table, path, result.mark)
            case ".mat":
                export.write_matlab(table, path, result.mark)
            case _:
                export.write_parquet(table, path, result.mark)
