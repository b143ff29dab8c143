"""Scatter diagrams and hindcasts from files.

A scatter diagram is a text: its first line names the peak periods [s] of the columns, each other
line begins with a significant height [m], both at the middle of their classes. A hindcast is a text
with columns time [s], hs [m] and tp [s] (other units in brackets, "time [h]"), or netCDF with hs
and tp over time, or with spectra, efth over time, freq [Hz] and dir, as wavespectra has them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hydrosim.documents.series import NETCDF
from hydrosim.documents.text import (
    Source,
    Table,
    name_and_unit,
    parse,
    require_finite,
    require_rising,
)
from hydrosim.documents.units import factor
from hydrosim.results.weather import Hindcast, Scatter

if TYPE_CHECKING:
    import xarray as xr

NAMES = {
    "time": ("time", "t"),
    "hs": ("hs", "hm0", "swh", "vhm0", "significant_height"),
    "tp": ("tp", "pp1d", "vtpk", "peak_period"),
}
UNITS = {"time": "s", "hs": "m", "tp": "s"}
NEEDED = "time, hs and tp"


def read_scatter(source: Source) -> Scatter:
    """The scatter diagram in a text file; InputError says what is wrong with it."""
    source.head(4)
    table = parse(source)
    try:
        periods = np.array([float(name) for name in table.names[1:]])
    except ValueError:
        periods = np.zeros(0)
    count = table.rows[:, 1:]
    if periods.size == 0 or periods.size != count.shape[1]:
        source.wrong(
            "found no peak periods above the columns; expected a first line such as hs, 5, 6, 7"
        )
    require_finite(source, table.rows.ravel())
    if np.any(count < 0.0) or not count.sum() > 0.0:
        source.wrong("found counts that are negative, or none at all; expected how often seas are")
    return Scatter(table.rows[:, 0], periods, count)


def read_hindcast(source: Source) -> Hindcast:
    """The states of the sea in a file; InputError says what is wrong with it."""
    netcdf = source.head(4).startswith(NETCDF)
    time, height, period = _read_netcdf(source) if netcdf else _read_text(source)
    for values in (time, height, period):
        require_finite(source, values)
    require_rising(source, time)
    if time.size < 2 or np.any(height < 0.0) or np.any(period <= 0.0):
        source.wrong("found fewer than two states, or heights or periods below zero")
    return Hindcast(time, height, period)


def _read_text(source: Source) -> tuple[np.ndarray, ...]:
    table = parse(source)
    return tuple(_column(source, table, what) for what in NAMES)


def _column(source: Source, table: Table, what: str) -> np.ndarray:
    for k, name in enumerate(table.names):
        bare, unit = name_and_unit(name)
        if bare.strip().lower() in NAMES[what]:
            said = table.units[k].strip("[]()") if table.units else unit
            try:
                scale = factor(said, UNITS[what]) if said else 1.0
            except ValueError as error:
                source.wrong(f"found {name}; expected it in {UNITS[what]}; {error}")
            return np.asarray(table.rows[:, k] * scale)
    source.wrong(f"found columns {', '.join(table.names) or 'without names'}; expected {NEEDED}")


def _read_netcdf(source: Source) -> tuple[np.ndarray, ...]:
    import xarray as xr

    try:
        data = xr.load_dataset(source.file, engine="netcdf4")
    except (OSError, ValueError, RuntimeError) as error:
        source.wrong(f"cannot be read as netCDF ({error}); expected {NEEDED}")
    if "time" not in data.coords:
        source.wrong(f"found {', '.join(map(str, data.variables))}; expected {NEEDED}")
    found = [_variable(data, what) for what in ("hs", "tp")]
    if any(each is None for each in found) and "efth" in data:
        found = [*_of_spectra(source, data["efth"])]
    if any(each is None or each.dims != ("time",) for each in found):
        source.wrong(
            f"found {', '.join(map(str, data.variables))}; expected {NEEDED}, or efth, of one place"
        )
    time = data["time"].values
    seconds = (time - time[0]) / np.timedelta64(1, "s") if time.dtype.kind == "M" else time
    return np.asarray(seconds, dtype=float), *(np.asarray(x, dtype=float) for x in found)


def _variable(data: xr.Dataset, what: str) -> xr.DataArray | None:
    for name in data.data_vars:
        if str(name).lower() in NAMES[what]:
            return data[name].squeeze(drop=True)
    return None


def _of_spectra(source: Source, efth: xr.DataArray) -> tuple[xr.DataArray, xr.DataArray]:
    """4 sqrt(m0), and the period of the largest density over frequency."""
    if not {"freq", "dir"} <= {*efth.dims} or "freq" not in efth.coords:
        source.wrong("found efth without freq or dir; expected both, as wavespectra has them")
    bearing = np.sort(np.mod(efth["dir"].values.astype(float), 360.0))
    step = 360.0 / bearing.size
    density = (efth.sum("dir") * step).squeeze(drop=True)
    peak = density["freq"][density.argmax("freq")].drop_vars("freq")
    return 4.0 * density.integrate("freq") ** 0.5, 1.0 / peak
