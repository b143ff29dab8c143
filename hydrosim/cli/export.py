"""`hydrosim export`: write channels of a run for other programs."""

from __future__ import annotations

from datetime import UTC, datetime
from enum import StrEnum
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrosim.cli.options import (
    From,
    Overwrite,
    To,
    names_in,
    one_of,
    output_for,
    seconds,
    window_of,
)
from hydrosim.cli.progress import progress
from hydrosim.cli.terminal import not_complete, print_lines
from hydrosim.errors import InputError

if TYPE_CHECKING:
    from hydrosim.compare.export import ExportTable
    from hydrosim.files.outputs import Output


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
    start: From = "",
    end: To = "",
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
    overwrite: Overwrite = False,
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
        read_in = one_of(ExportUnits, units or ExportUnits.SI, "--units")
        _record(run_file, output, names_in(channels), step, digits, overwrite, read_in)
        return
    if step:
        raise InputError(
            "--step: found no --recording; expected both. Other files have the"
            " output times of the run."
        )
    suffix = _suffix(output)
    unit_system = _chosen_units(units, suffix)
    begin = _date(date, suffix)
    window = window_of(start, end)
    result = output_for(output, "", "export", run_file, overwrite=overwrite, suffix=suffix)
    if (runs := open_runs(run_file)) is not None:
        raise InputError(
            f"{run_file}: holds {runs.sizes['run']} runs; expected the result of one run."
            " `hydrosim case` prints the case of one of them, and `hydrosim run` makes its"
            " result."
        )
    run = read_run(run_file)
    table = table_of(run, names_in(channels), *window)
    if unit_system is ExportUnits.CASE:
        table = table.read_in(units_of(run.attrs))
    with progress("writing"):
        _write(table, result, begin)
    count, span = len(table.columns), f"{table.time[0]:g} to {table.time[-1]:g} s"
    print_lines(f"export    {count} channels at {table.time.size} times, {span}")
    print_lines(*not_complete(table.attributes), f"result    {result.path}")


def _chosen_units(units: str, suffix: str) -> ExportUnits:
    """Whose units a table has. That of CF is in SI."""
    if suffix == ".nc":
        if units not in ("", ExportUnits.SI):
            raise InputError(f"--units: found {units}; expected si, as .nc is always in SI.")
        return ExportUnits.SI
    return one_of(ExportUnits, units or ExportUnits.CASE, "--units")


def _record(
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

    result = output_for(output, "", "recording", run_file, overwrite=overwrite, suffix=None)
    every = seconds("--step", step, 0.0) if step else None
    if every is not None and not every > 0.0:
        raise InputError(f"--step: found {every:g} s; expected a positive time, such as 0.5 s.")
    run = open_run(run_file)
    names = match_channels(columns_of(run), asked, "--channels") if asked else default_channels(run)
    case_units = units_of(run.attrs).display_unit if unit_system is ExportUnits.CASE else None
    write_recording(run, result, names, every, digits, case_units)
    print_lines(f"result    {result.path}, {len(names)} channels")


def _suffix(output: Path) -> str:
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


def _date(text: str, suffix: str) -> datetime | None:
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


def _write(table: ExportTable, result: Output, date: datetime | None) -> None:
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
