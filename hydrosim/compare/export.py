"""Export of channels to files of other programs: text, netCDF, MATLAB and Parquet.

Comma-separated values: a comment on the origin, names, units, and numbers with enough digits to
read them back to the bit.

Names and units come from the run. Spreadsheets run a cell as a formula if it begins with =, +, - or
@. Such text is preceded by an apostrophe, also after characters that spreadsheets take for the end
of a cell.

netCDF has one variable per channel, so that each has one unit. ``time`` is in seconds since a date.
A run has no date: without a given one it is `DATE`, and the file states that. ``elapsed_time`` is
in seconds since the start of the run.

MATLAB: the rows of ``channels`` give the name of the variable, the name of the channel, the unit, a
description, and the meanings of mode numbers. Parquet has the last three as JSON in the metadata of
the file, under ``channels``, which every reader of Parquet gives.
"""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import xarray as xr

from hydrosim.errors import InputError
from hydrosim.files.cache import program_version
from hydrosim.files.display_units import Units
from hydrosim.files.series import columns_of, select
from hydrosim.files.text import Source, escape_unprintable, require_finite, require_rising
from hydrosim.results.channels import RUN, channel_names, channel_series, match_channels

# Columns over one time, each with one unit: the content of every format.

EXPORTED_ATTRIBUTES = (
    "title",
    "date_created",
    "status",
    "status_message",
    "warnings",
    "skipped",
    "case",
    "case_resolved",
)
SUFFIXES = (".nc", ".csv", ".mat", ".parquet")
SEVERAL_UNITS = re.compile(r" \[[^]]+ or [^]]+\]$")
"""End of the long name of a variable whose channels have different units."""
NOT_IN_NAMES = re.compile(r"[^A-Za-z0-9]+")


def check_suffix(output: Path) -> str:
    """Suffix of a file to write. Raises InputError if it selects no format, or one that needs a
    package which is not installed."""
    if output.suffix not in SUFFIXES:
        raise InputError(
            f"output: found {output}; expected a name that ends in {', '.join(SUFFIXES)}."
        )
    if output.suffix == ".parquet" and find_spec("pyarrow") is None:
        raise InputError(
            f"output: {output} needs pyarrow, which is not installed:"
            " pip install 'hydrosim[export]'; or choose .csv, .mat or .nc."
        )
    return output.suffix


@dataclass(frozen=True)
class ExportColumn:
    """A channel: its ``values`` (nt,), unit and description. Modes are whole numbers; ``meanings``
    explain them."""

    name: str
    unit: str
    what: str
    values: np.ndarray
    meanings: str = ""


@dataclass(frozen=True)
class ExportTable:
    """``columns`` at the increasing ``time`` (nt,) [s] since the start, and attributes of the
    run."""

    time: np.ndarray
    columns: Sequence[ExportColumn]
    attributes: dict[str, object]

    def read_in(self, units: Units) -> ExportTable:
        """The same table, each column in the unit that it is read in. Modes stay as they are."""
        return replace(self, columns=[_read_in(column, units) for column in self.columns])


def table_of(run: xr.Dataset, patterns: Sequence[str], start: float, end: float) -> ExportTable:
    """Channels of a run that match one of the ``patterns`` (without patterns, all recorded
    channels), from ``start`` to ``end`` [s]. Raises InputError if nothing is left."""
    source = Source(run.encoding.get("source", "run"))
    time = np.asarray(run["time"].values, dtype=float)
    require_finite(source, time, None)
    require_rising(source, time, None)
    inside = (time >= start) & (time <= end)
    if not inside.any():
        there = f"{time[0]:g} to {time[-1]:g} s" if time.size else "no time"
        raise InputError(
            f"start, end: found {start:g} to {end:g} s, but the run has records for {there};"
            " expected an interval that contains some."
        )
    recorded = [*columns_of(run), *columns_of(run, modes=True)]
    channels = dict.fromkeys([*recorded, *channel_names(run)]) if patterns else recorded
    picked, run = match_channels(channels, patterns or ["*"], "channels"), run.isel(time=inside)
    of = {name: select(RUN, run, name) for name in recorded if name in {*picked}}
    columns = [
        _export_column(run, name, *(of.get(name) or channel_series(run, name))) for name in picked
    ]
    attributes = {name: run.attrs[name] for name in EXPORTED_ATTRIBUTES if name in run.attrs}
    return ExportTable(time[inside], columns, attributes)


def _read_in(column: ExportColumn, units: Units) -> ExportColumn:
    unit, factor = units.display_unit(column.unit)
    if factor == 1.0:
        return column
    return replace(column, unit=unit, values=factor * column.values)


def identifiers(
    columns: Iterable[ExportColumn], most: int, *taken: str
) -> Iterator[tuple[str, ExportColumn]]:
    """Columns by valid names: letters, digits and underscores, a letter first, at ``most`` so many
    characters, all different, none of ``taken``."""
    used = {*taken}
    for column in columns:
        bare = NOT_IN_NAMES.sub("_", column.name).strip("_")
        bare = bare if bare[:1].isalpha() else f"channel_{bare}"
        tries = (f"{bare[: most - len(end)]}{end}" for end in _identifier_ends())
        name = next(name for name in tries if name not in used)
        used.add(name)
        yield name, column


def _identifier_ends() -> Iterator[str]:
    yield ""
    for k in range(2, 1_000_000):
        yield f"_{k}"


def _export_column(run: xr.Dataset, name: str, values: np.ndarray, unit: str) -> ExportColumn:
    kind, *of = name.split(".")
    attributes = run[kind].attrs if kind in run else {}
    long_name = str(attributes.get("long_name", kind.replace("_", " ")))
    what = " ".join(SEVERAL_UNITS.sub("", long_name).split())
    what = f"{', '.join(of)}: {what}" if of else what
    if "flag_values" in attributes:
        return ExportColumn(
            name, "1", what, values.astype(np.int8), str(attributes.get("flag_meanings", ""))
        )
    return ExportColumn(name, unit, what, values)


FORMULA = re.compile(r"(^|[,;\t\r\n])(?=\s*[=+\-@＝＋－＠])")


def write_text(table: ExportTable, path: Path, mark: str) -> None:
    """Write the columns of a table as text."""
    with path.open("w", encoding="utf-8", newline="") as file:
        file.write(f"# {escape_unprintable(mark)}\n")
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["time", *(escape_formula(column.name) for column in table.columns)])
        rows.writerow(["s", *(escape_formula(column.unit) for column in table.columns)])
        values = [table.time.tolist(), *(column.values.tolist() for column in table.columns)]
        rows.writerows(zip(*values, strict=True))


def escape_formula(text: str) -> str:
    """Text in one line that no spreadsheet takes for a formula."""
    return escape_unprintable(FORMULA.sub(r"\1'", text))


# netCDF by the conventions CF 1.11.

MAX_CF_NAME_LETTERS = 250  # valid name of a variable
DATE = datetime(2000, 1, 1, tzinfo=UTC)


def write_netcdf(table: ExportTable, path: Path, mark: str, date: datetime | None = None) -> None:
    """Write the columns of a table as netCDF. ``date`` is the date at time 0 s of the run."""
    named = identifiers(table.columns, MAX_CF_NAME_LETTERS, "time", "elapsed_time")
    begin = (date or DATE).strftime("%Y-%m-%d %H:%M:%S")
    of_time = {"units": f"seconds since {begin}", "standard_name": "time", "axis": "T"}
    of_time |= {"calendar": "proleptic_gregorian", "long_name": "time in UTC"}
    of_time["units_metadata"] = "leap_seconds: none"
    if date is None:
        of_time["comment"] = "The run has no date: the date of time 0 s is arbitrary."
    elapsed = {"units": "s", "long_name": "time since the start of the run"}
    dataset = xr.Dataset(
        {name: ("time", column.values, _attributes(column)) for name, column in named},
        {"time": ("time", table.time, of_time), "elapsed_time": ("time", table.time, elapsed)},
        {
            **table.attributes,
            "Conventions": "CF-1.11",
            "history": mark,
            "source": f"hydrosim {program_version()}, simulation in the time domain",
        },
    )
    encoding = {name: {"_FillValue": None} for name in ("time", "elapsed_time")}
    dataset.to_netcdf(path, engine="netcdf4", format="NETCDF4", encoding=encoding)


def _attributes(column: ExportColumn) -> dict[str, object]:
    attributes: dict[str, object] = {"long_name": column.what, "channel": column.name}
    if column.meanings:
        values = np.arange(len(column.meanings.split()), dtype=column.values.dtype)
        return {**attributes, "flag_values": values, "flag_meanings": column.meanings}
    return {**attributes, "units": column.unit} if column.unit else attributes


# MATLAB, version 5.

MAX_MATLAB_NAME_LETTERS = 63  # valid name of a variable


def write_matlab(table: ExportTable, path: Path, mark: str) -> None:
    """Write the columns of a table for MATLAB."""
    from scipy.io import savemat

    reserved_names = ("source", "time", "channels", "run")
    named = list(identifiers(table.columns, MAX_MATLAB_NAME_LETTERS, *reserved_names))
    rows = [[name, c.name, c.unit, c.what, c.meanings] for name, c in named]
    attributes = {name: str(value) for name, value in table.attributes.items()}
    variables = {
        "source": mark,
        "time": table.time,
        "channels": np.array(rows, dtype=object),
        "run": attributes,
        **{name: column.values for name, column in named},
    }
    savemat(path, variables, appendmat=False, long_field_names=True, oned_as="column")


# Parquet: ``time`` and a column for each channel under its own name.


def write_parquet(table: ExportTable, path: Path, mark: str) -> None:
    """Write the columns of a table as Parquet."""
    import pyarrow as pa
    from pyarrow import parquet

    arrays = {"time": table.time} | {column.name: column.values for column in table.columns}
    attributes = {name: str(value) for name, value in table.attributes.items()}
    attributes["channels"] = json.dumps(
        {"time": {"units": "s"}}
        | {column.name: _column_attributes(column) for column in table.columns}
    )
    columns = pa.table({name: pa.array(values) for name, values in arrays.items()})
    with parquet.ParquetWriter(path, columns.schema, store_schema=False) as file:
        file.write_table(columns)
        # last, because `outputs` looks for it there
        file.add_key_value_metadata({**attributes, "source": mark})


def _column_attributes(column: ExportColumn) -> dict[str, str]:
    attributes = {"units": column.unit, "long_name": column.what, "flag_meanings": column.meanings}
    return {key: text for key, text in attributes.items() if text}
