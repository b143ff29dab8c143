"""netCDF by the conventions CF 1.11, with one variable per channel, so that each has one unit.

``time`` is in seconds since a date. A run has no date: without a given one it is `DATE`, and the
file states that. ``elapsed_time`` is in seconds since the start of the run.
"""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import xarray as xr

from hydrosim.program import program_version
from hydrosim.results.export.table import ExportColumn, ExportTable, identifiers

MAX_CF_NAME_LETTERS = 250  # valid name of a variable
DATE = datetime(2000, 1, 1, tzinfo=UTC)


def write(table: ExportTable, path: Path, mark: str, date: datetime | None = None) -> None:
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
    said: dict[str, object] = {"long_name": column.what, "channel": column.name}
    if column.meanings:
        values = np.arange(len(column.meanings.split()), dtype=column.values.dtype)
        return {**said, "flag_values": values, "flag_meanings": column.meanings}
    return {**said, "units": column.unit} if column.unit else said
