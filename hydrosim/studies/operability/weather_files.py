"""Scatter diagrams and hindcasts from files.

A scatter diagram is a text: its first line names the peak periods [s] of the columns, each other
line begins with a significant height [m], or in the unit of that column's name, "hs [ft]", both at
the middle of their classes. A hindcast is a text
with columns time [s] or dates (2020-01-31T12:00), hs [m] and tp [s] (other units in brackets, "time
[h]"), and, where it is known, direction [deg], the bearing that waves come from; or netCDF with
these over time, or with spectra, efth over time, freq [Hz] and dir, as wavespectra has them: of
those the direction is that of the mean of the energy. Attributes may say that waves go to it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hydrosim.documents.series import NETCDF
from hydrosim.documents.text import (
    EPOCH,
    Source,
    TextTable,
    check_spectral_units,
    is_heading,
    name_and_unit,
    parse,
    readable_unit,
    require_finite,
    require_rising,
    unit_of_column,
    without_repeats,
)
from hydrosim.documents.units import factor
from hydrosim.statistics.waiting import Hindcast
from hydrosim.statistics.weather import ScatterDiagram

if TYPE_CHECKING:
    import xarray as xr

COLUMN_NAMES = {
    "time": ("time", "t"),
    "hs": ("hs", "hm0", "swh", "vhm0", "significant_height"),
    "tp": ("tp", "pp1d", "vtpk", "peak_period"),
    "direction": ("direction", "dir", "dm", "dp", "dpm", "mwd", "mdir", "vmdr", "vpd"),
}
COLUMN_UNITS = {"time": "s", "hs": "m", "tp": "s", "direction": "rad"}
DEFAULT_UNITS = {**COLUMN_UNITS, "direction": "deg"}  # where a file says none
REQUIRED_VARIABLES = "time, hs and tp"
MAX_HEIGHT_M = 30.0  # m: significant heights of a scatter diagram
MIN_DIRECTIONS = 10  # directions, of which some should be more than 6.28 degrees


def read_scatter(source: Source) -> ScatterDiagram:
    """The scatter diagram in a text file; InputError says what is wrong with it."""
    source.head(4)
    table = parse(source, first="a significant height [m]")
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
    heights = table.rows[:, 0] * _scale(source, table, 0, "hs")
    for name, values in (("height", heights), ("peak period", periods)):
        if values.min() < 0.0 or np.unique(values).size < values.size:
            source.wrong(
                f"found {name}s {', '.join(f'{x:g}' for x in values)}; expected each once, none"
                " below zero"
            )
    if heights.max() > MAX_HEIGHT_M:
        source.wrong(
            f"found heights up to {heights.max():g} m; expected at most {MAX_HEIGHT_M:g} m; name"
            " another unit in the first line, hs [cm]"
        )
    if np.any(count < 0.0) or not count.sum() > 0.0:
        source.wrong("found counts that are negative, or none at all; expected how often seas are")
    return ScatterDiagram(heights, periods, count)


def read_hindcast(source: Source) -> Hindcast:
    """The states of the sea in a file; InputError says what is wrong with it."""
    netcdf = source.head(4).startswith(NETCDF)
    hindcast = _read_netcdf(source) if netcdf else _read_text(source)
    time = hindcast.time
    height = hindcast.height
    period = hindcast.period
    for values in (time, height, period, hindcast.coming):
        if values is not None:
            require_finite(source, values)
    require_rising(source, time)
    if time.size < 2:
        source.wrong(f"found {time.size} state; expected two or more")
    for name, values, bad in (("height", height, height < 0.0), ("period", period, period <= 0.0)):
        if bad.any():
            k = int(np.argmax(bad))
            source.wrong(
                f"found a {name} of {values[k]:g} in record {k + 1}; expected one above zero; leave"
                " out states that are not known"
            )
    if hindcast.coming is not None and np.abs(hindcast.coming).max() > 2.0 * np.pi + 1e-6:
        k = int(np.abs(hindcast.coming).argmax())
        source.wrong(
            f"found a direction of {np.degrees(hindcast.coming[k]):g} deg in record {k + 1};"
            " expected one within a turn; leave out states that are not known"
        )
    return hindcast


def _read_text(source: Source) -> Hindcast:
    table = parse(source, dates=True)
    columns = [_column(source, table, what) for what in COLUMN_NAMES]
    needed = [column for column in columns[:3] if column is not None]
    if len(needed) < 3:
        names = ", ".join(table.names) or "without names"
        source.wrong(f"found columns {names}; expected {REQUIRED_VARIABLES}")
    time, height, period = needed
    if not table.dated:
        return Hindcast(time, None, height, period, columns[3])
    date = EPOCH + np.timedelta64(round(1e3 * float(time[0])), "ms")
    return Hindcast(time - time[0], date, height, period, columns[3])


def _column(source: Source, table: TextTable, what: str) -> np.ndarray | None:
    """A column in the program's unit, None if the table has none of its names."""
    for k, name in enumerate(table.names):
        bare, unit = name_and_unit(name)
        if bare.strip().lower() in COLUMN_NAMES[what]:
            values = table.rows[:, k]
            if what == "direction" and not (unit or table.units):
                _refuse_radians(source, name, values)
            return np.asarray(values * _scale(source, table, k, what))
    return None


def _scale(source: Source, table: TextTable, k: int, what: str) -> float:
    """From the unit of a column, if the file says one, to the program's."""
    name = table.names[k]
    try:
        return factor(unit_of_column(table, k) or DEFAULT_UNITS[what], COLUMN_UNITS[what])
    except ValueError as error:
        source.wrong(f"found {name}; expected it in {DEFAULT_UNITS[what]}; {error}")


def _refuse_radians(source: Source, name: str, values: np.ndarray) -> None:
    """Directions all around that look like radians, of a file that does not say which."""
    size = np.abs(values[np.isfinite(values)]).max(initial=0.0)
    if values.size >= MIN_DIRECTIONS and np.pi / 2 < size <= 2.0 * np.pi + 1e-6:
        source.wrong(
            f"found {values.size} values of {name} up to {size:.3g} and no unit: degrees or"
            f" radians? Name the column {name} [deg] or {name} [rad]"
        )


def _read_netcdf(source: Source) -> Hindcast:
    import xarray as xr

    try:
        data = xr.load_dataset(source.file, engine="netcdf4")
    except (OSError, ValueError, RuntimeError) as error:
        source.wrong(f"cannot be read as netCDF ({error}); expected {REQUIRED_VARIABLES}")
    if "time" not in data.coords and "valid_time" in data.coords:
        data = data.rename(valid_time="time")
    if "time" not in data.coords:
        source.wrong(f"found {', '.join(map(str, data.variables))}; expected {REQUIRED_VARIABLES}")
    states = {what: _variable(data, what) for what in ("hs", "tp", "direction")}
    if (states["hs"] is None or states["tp"] is None) and "efth" in data:
        states = _states_from_spectra(source, data["efth"])
    for what in ("hs", "tp"):
        if (each := states[what]) is None or each.dims != ("time",):
            source.wrong(
                f"found {', '.join(map(str, data.variables))}; expected {REQUIRED_VARIABLES}, or"
                " efth, of one place"
            )
    height, period, coming = (
        None if each is None else _convert_values(source, each, what)
        for what, each in states.items()
    )
    assert height is not None
    assert period is not None
    return Hindcast(*_times(source, data["time"]), height, period, coming)


def _times(source: Source, time: xr.DataArray) -> tuple[np.ndarray, np.datetime64 | None]:
    """Seconds, and the date of zero: none in a calendar that is not ours."""
    values = time.values
    if values.dtype.kind == "M":
        return (values - values[0]) / np.timedelta64(1, "s"), values[0].astype("M8[ms]")
    if values.dtype.kind == "O":
        return np.array([(each - values[0]).total_seconds() for each in values]), None
    return _convert_values(source, time, "time"), None


def _convert_values(source: Source, values: xr.DataArray, what: str) -> np.ndarray:
    """Numbers in the program's unit; directions those that waves come from, as a file has them
    unless its standard name says that they go there."""
    unit = str(values.attrs.get("units", DEFAULT_UNITS[what]))
    unit = "deg" if unit.lower().startswith("deg") else readable_unit(unit) or unit
    try:
        scale = factor(unit, COLUMN_UNITS[what])
    except ValueError as error:
        source.wrong(f"{values.name or what}: {error}; expected {DEFAULT_UNITS[what]}")
    going = what == "direction" and is_heading(source, str(values.name or what), values.attrs)
    return np.asarray(values.values.astype(float) * scale + (np.pi if going else 0.0))


def _variable(data: xr.Dataset, what: str) -> xr.DataArray | None:
    for name in data.data_vars:
        if str(name).lower() in COLUMN_NAMES[what]:
            return data[name].squeeze(drop=True)
    return None


def _states_from_spectra(source: Source, efth: xr.DataArray) -> dict[str, xr.DataArray | None]:
    """4 sqrt(m0), the period of the largest density over frequency, the mean direction."""
    import xarray as xr

    if not {"freq", "dir"} <= {*efth.dims} or not {"freq", "dir"} <= {*efth.coords}:
        source.wrong("found efth without freq or dir; expected both, as wavespectra has them")
    check_spectral_units(source, efth)
    efth = without_repeats(source, efth.sortby("freq"))
    bearing = efth["dir"].astype(float)
    around = np.sort(bearing.values % 360.0)
    step = 360.0 / around.size
    if not np.allclose(np.diff(around, append=around[0] + 360.0), step, rtol=1e-3):
        source.wrong(
            f"found {around.size} directions that are not evenly all around; expected steps of"
            f" {step:g} deg, each direction once"
        )
    density = (efth.sum("dir") * step).squeeze(drop=True)
    peak = density["freq"][density.argmax("freq")].drop_vars("freq").drop_attrs()
    spectrum_over_directions = efth.integrate("freq").squeeze(drop=True)
    parts = [
        (spectrum_over_directions * turned(np.deg2rad(bearing))).sum("dir")
        for turned in (np.cos, np.sin)
    ]
    attributes = {key: text for key, text in bearing.attrs.items() if key != "units"}
    mean = xr.apply_ufunc(np.arctan2, parts[1], parts[0]).drop_attrs()
    mean = mean.rename("dir").assign_attrs(attributes, units="rad")
    height = 4.0 * density.integrate("freq").drop_attrs() ** 0.5
    return {"hs": height, "tp": 1.0 / peak, "direction": mean}
