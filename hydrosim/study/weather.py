"""Weather of a study of limits, read from files, and the share of time that limits allow in it.

Scatter diagrams and hindcasts from files.

A scatter diagram is a text: its first line names the peak periods [s] of the columns, each other
line begins with a significant height [m], or in the unit of that column's name, "hs [ft]", both at
the middle of their classes. A hindcast is a text
with columns time [s] or dates (2020-01-31T12:00), hs [m] and tp [s] (other units in brackets, "time
[h]"), and, where it is known, direction [deg], the bearing that waves come from; or netCDF with
these over time, or with spectra, efth over time, freq [Hz] and dir, as wavespectra has them: of
those the direction is that of the mean of the energy. Attributes may say that waves go to it.
"""

from __future__ import annotations

from calendar import month_name
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from hydrosim.errors import InputError
from hydrosim.files import text as texts
from hydrosim.files.series import NETCDF
from hydrosim.files.units import factor
from hydrosim.results.variables import quantity_attributes
from hydrosim.statistics.weather import (
    AlphaFactors,
    Hindcast,
    LimitCurve,
    LimitSurface,
    ScatterDiagram,
    waiting,
    workability,
)

if TYPE_CHECKING:
    from hydrosim.study.study_file import Operability, Operation

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


def read_scatter(source: texts.Source) -> ScatterDiagram:
    """The scatter diagram in a text file; InputError says what is wrong with it."""
    source.head(4)
    table = texts.parse(source, first="a significant height [m]")
    try:
        periods = np.array([float(name) for name in table.names[1:]])
    except ValueError:
        periods = np.zeros(0)
    count = table.rows[:, 1:]
    if periods.size == 0 or periods.size != count.shape[1]:
        source.wrong(
            "found no peak periods above the columns; expected a first line such as hs, 5, 6, 7"
        )
    texts.require_finite(
        source, table.rows.ravel(), np.repeat(table.lines, table.rows.shape[1]).tolist()
    )
    heights = table.rows[:, 0] * _unit_scale(source, table, 0, "hs")
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
        lowest = int(count.min(axis=1).argmin())
        text = "found counts that are negative, or none at all; expected how often seas are"
        source.wrong(text, table.lines[lowest])
    return ScatterDiagram(heights, periods, count)


def read_hindcast(source: texts.Source) -> Hindcast:
    """The states of the sea in a file; InputError says what is wrong with it."""
    netcdf = source.head(4).startswith(NETCDF)
    hindcast, lines = (_read_netcdf(source), None) if netcdf else _read_text(source)
    time = hindcast.time
    height = hindcast.height
    period = hindcast.period
    for values in (time, height, period, hindcast.coming):
        if values is not None:
            texts.require_finite(source, values, lines)
    texts.require_rising(source, time, lines)
    if time.size < 2:
        source.wrong(f"found {time.size} state; expected two or more")
    for name, values, bad in (("height", height, height < 0.0), ("period", period, period <= 0.0)):
        if bad.any():
            k = int(np.argmax(bad))
            source.wrong(
                f"found a {name} of {values[k]:g} in record {k + 1}; expected one above zero; leave"
                " out states that are not known",
                lines[k] if lines else None,
            )
    if hindcast.coming is not None and np.abs(hindcast.coming).max() > 2.0 * np.pi + 1e-6:
        k = int(np.abs(hindcast.coming).argmax())
        source.wrong(
            f"found a direction of {np.degrees(hindcast.coming[k]):g} deg in record {k + 1};"
            " expected one within a turn; leave out states that are not known",
            lines[k] if lines else None,
        )
    return hindcast


def _read_text(source: texts.Source) -> tuple[Hindcast, list[int]]:
    """The states in a text, and their lines."""
    table = texts.parse(source, dates=True)
    columns = [_find_column(source, table, what) for what in COLUMN_NAMES]
    needed = [column for column in columns[:3] if column is not None]
    if len(needed) < 3:
        names = ", ".join(table.names) or "without names"
        source.wrong(f"found columns {names}; expected {REQUIRED_VARIABLES}")
    time, height, period = needed
    if not table.dated:
        return Hindcast(time, None, height, period, columns[3]), table.lines
    date = texts.EPOCH + np.timedelta64(round(1e3 * float(time[0])), "ms")
    return Hindcast(time - time[0], date, height, period, columns[3]), table.lines


def _find_column(source: texts.Source, table: texts.TextTable, what: str) -> np.ndarray | None:
    """A column in the program's unit, None if the table has none of its names."""
    for k, name in enumerate(table.names):
        bare, unit = texts.name_and_unit(name)
        if bare.strip().lower() in COLUMN_NAMES[what]:
            values = table.rows[:, k]
            if what == "direction" and not (unit or table.units):
                _refuse_radians(source, name, values)
            return np.asarray(values * _unit_scale(source, table, k, what))
    return None


def _unit_scale(source: texts.Source, table: texts.TextTable, k: int, what: str) -> float:
    """From the unit of a column, if the file says one, to the program's."""
    name = table.names[k]
    try:
        return factor(texts.unit_of_column(table, k) or DEFAULT_UNITS[what], COLUMN_UNITS[what])
    except ValueError as error:
        source.wrong(f"found {name}; expected it in {DEFAULT_UNITS[what]}; {error}")


def _refuse_radians(source: texts.Source, name: str, values: np.ndarray) -> None:
    """Directions all around that look like radians, of a file that does not say which."""
    size = np.abs(values[np.isfinite(values)]).max(initial=0.0)
    if values.size >= MIN_DIRECTIONS and np.pi / 2 < size <= 2.0 * np.pi + 1e-6:
        source.wrong(
            f"found {values.size} values of {name} up to {size:.3g} and no unit: degrees or"
            f" radians? Name the column {name} [deg] or {name} [rad]"
        )


def _read_netcdf(source: texts.Source) -> Hindcast:
    import xarray as xr

    try:
        data = xr.load_dataset(source.file, engine="netcdf4")
    except (OSError, ValueError, RuntimeError) as error:
        source.wrong(f"cannot be read as netCDF ({error}); expected {REQUIRED_VARIABLES}")
    if "time" not in data.coords and "valid_time" in data.coords:
        data = data.rename(valid_time="time")
    if "time" not in data.coords:
        source.wrong(f"found {', '.join(map(str, data.variables))}; expected {REQUIRED_VARIABLES}")
    states = {what: _find_variable(data, what) for what in ("hs", "tp", "direction")}
    if (states["hs"] is None or states["tp"] is None) and "efth" in data:
        states = _states_from_spectra(source, data["efth"])
    for what in ("hs", "tp"):
        if (state := states[what]) is None or state.dims != ("time",):
            source.wrong(
                f"found {', '.join(map(str, data.variables))}; expected {REQUIRED_VARIABLES}, or"
                " efth, of one place"
            )
    height, period, coming = (
        None if state is None else _convert_values(source, state, what)
        for what, state in states.items()
    )
    assert height is not None
    assert period is not None
    return Hindcast(*_read_times(source, data["time"]), height, period, coming)


def _read_times(
    source: texts.Source, time: xr.DataArray
) -> tuple[np.ndarray, np.datetime64 | None]:
    """Seconds, and the date of zero: none in a calendar that is not ours."""
    values = time.values
    if values.dtype.kind == "M":
        return (values - values[0]) / np.timedelta64(1, "s"), values[0].astype("M8[ms]")
    if values.dtype.kind == "O":
        return np.array([(time - values[0]).total_seconds() for time in values]), None
    return _convert_values(source, time, "time"), None


def _convert_values(source: texts.Source, values: xr.DataArray, what: str) -> np.ndarray:
    """Numbers in the program's unit; directions those that waves come from, as a file has them
    unless its standard name says that they go there."""
    unit = str(values.attrs.get("units", DEFAULT_UNITS[what]))
    unit = "deg" if unit.lower().startswith("deg") else texts.readable_unit(unit) or unit
    try:
        scale = factor(unit, COLUMN_UNITS[what])
    except ValueError as error:
        source.wrong(f"{values.name or what}: {error}; expected {DEFAULT_UNITS[what]}")
    going = what == "direction" and texts.is_heading(source, str(values.name or what), values.attrs)
    return np.asarray(values.values.astype(float) * scale + (np.pi if going else 0.0))


def _find_variable(data: xr.Dataset, what: str) -> xr.DataArray | None:
    for name in data.data_vars:
        if str(name).lower() in COLUMN_NAMES[what]:
            return data[name].squeeze(drop=True)
    return None


def _states_from_spectra(
    source: texts.Source, efth: xr.DataArray
) -> dict[str, xr.DataArray | None]:
    """4 sqrt(m0), the period of the largest density over frequency, the mean direction."""
    import xarray as xr

    if not {"freq", "dir"} <= {*efth.dims} or not {"freq", "dir"} <= {*efth.coords}:
        source.wrong("found efth without freq or dir; expected both, as wavespectra has them")
    texts.check_spectral_units(source, efth)
    efth = texts.without_repeats(source, efth.sortby("freq"))
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


SECONDS_PER_HOUR = 3600.0
WHOLE_YEAR = "year"  # the whole record
WAITING_QUANTILES = (0.5, 0.9)
MAX_RELATIVE_GAP = 3.0  # times as long as usual: what a state is not taken to last without a word


@dataclass(frozen=True)
class Weather:
    """A scatter diagram, a hindcast, the bearing of the x axis [rad] by which its directions are
    headings, and the operation that needs a window."""

    scatter: ScatterDiagram | None
    hindcast: Hindcast | None
    bearing: float | None
    operation: Operation | None

    def alpha_factors(self) -> AlphaFactors | None:
        """The table of alpha factors, if there is one."""
        table = self.operation.alpha if self.operation is not None else None
        if table is None:
            return None
        arrays = (np.array(x) for x in (table.planned, table.heights, table.factors))
        return AlphaFactors(table.source, *arrays)


def read_weather(folder: Path, wanted: Operability) -> Weather:
    """The files that a study names; InputError says what is wrong in them, and an operation that
    its table of factors does not have."""
    scatter = wanted.scatter and read_scatter(texts.Source(folder / wanted.scatter, "scatter"))
    hindcast = wanted.hindcast and read_hindcast(texts.Source(folder / wanted.hindcast, "hindcast"))
    if wanted.bearing is not None and hindcast and hindcast.coming is None:
        raise InputError(
            f"operability.bearing: {folder / str(wanted.hindcast)}: found no column direction, the"
            " bearing that waves come from; expected one, or no bearing."
        )
    weather = Weather(scatter or None, hindcast or None, wanted.bearing, wanted.operation)
    if (alpha := weather.alpha_factors()) is not None and wanted.operation is not None:
        alpha.factor(wanted.operation.planned, alpha.heights)
    return weather


def assess_weather(limits: xr.Dataset, weather: Weather) -> xr.Dataset:
    """The ``limits`` with what they are worth in the weather: ``scatter_workable`` and
    ``scatter_outside``; ``alpha`` [1] of each limit; of the hindcast, over the ``season``, the
    year and each month, the shares ``workable``, ``startable`` and ``never``, and ``waiting`` [s]
    by ``quantile``. The least limit of all swells counts, stages together; of all headings, too,
    unless a bearing turns the directions of the hindcast into headings."""
    limit = limits.limit.sel(stage="all").min("swell").transpose("heading", "peak_period")
    is_open = limit >= _lowest_open_height(limits)
    new: dict[str, xr.DataArray] = {}
    if weather.scatter is not None:
        least = limit.min("heading").values
        curve = LimitCurve(limits.peak_period.values, least, is_open.all("heading").values)
        workable, outside = workability(weather.scatter, curve)
        new["scatter_workable"] = _share_variable(workable, "share of the seas that is workable")
        new["scatter_outside"] = _share_variable(outside, "share of the seas at other peak periods")
    operation, alpha = weather.operation, weather.alpha_factors()
    bare = limit
    if operation is not None and alpha is not None:
        factors = alpha.factor(operation.planned, limit.values)
        new["alpha"] = limit.copy(data=factors).assign_attrs(long_name=alpha.source, units="1")
        limit = limit * factors
    if operation is not None and weather.hindcast is not None:
        held, bare_limits = (_limits_over_time(of, is_open, weather) for of in (limit, bare))
        new |= _hindcast_variables(weather.hindcast, held, bare_limits, window_length(operation))
    return limits.assign(new).assign_attrs(_assumption_attributes(weather))


def _lowest_open_height(limits: xr.Dataset) -> float:
    """The height [m] from which a limit is open: the largest that was tried, or near it where runs
    tried heights apart."""
    near = 0.5 * limits.attrs.get("apart", 0.0) if limits.attrs.get("runs") else 0.0
    return float(limits.attrs.get("highest", np.inf)) - near


def _assumption_attributes(weather: Weather) -> dict[str, str | float]:
    """What the worth of the limits depends on, as attributes."""
    attributes: dict[str, str | float] = {}
    if weather.operation is not None:
        attributes = {
            "planned": weather.operation.planned,
            "window": window_length(weather.operation),
        }
    if (alpha := weather.alpha_factors()) is not None:
        attributes["alpha_table"] = alpha.source
        attributes["alpha_lowest"] = float(alpha.heights[0])
    if weather.bearing is not None:
        attributes["bearing"] = weather.bearing
    if weather.hindcast is not None:
        attributes["hindcast"] = describe_record(weather.hindcast)
    return attributes


def describe_record(hindcast: Hindcast) -> str:
    """How long a hindcast is, from when on, and how far apart its states are."""
    apart = np.diff(hindcast.time)
    usual, most, k = float(np.median(apart)), float(apart.max()), int(apart.argmax())
    begins = "" if hindcast.date is None else f" from {np.datetime_as_string(hindcast.date, 'D')}"
    days = float(hindcast.ends[-1] - hindcast.time[0]) / (24.0 * SECONDS_PER_HOUR)
    states = f"{hindcast.time.size} states {usual / SECONDS_PER_HOUR:.3g} h apart"
    text = f"{days:.4g} days{begins}, {states}"
    if most > MAX_RELATIVE_GAP * usual:
        where = f"{float(hindcast.time[k]) / SECONDS_PER_HOUR:.6g} h after it begins"
        text += f"; one is taken to last for {most / SECONDS_PER_HOUR:.4g} h, {where}, as none"
        text += " follows sooner"
    return text


def window_length(operation: Operation) -> float:
    """The planned time and its contingency [s]."""
    spare = operation.planned if operation.contingency is None else operation.contingency
    return operation.planned + spare


def _limits_over_time(limit: xr.DataArray, is_open: xr.DataArray, weather: Weather) -> np.ndarray:
    """The limit [m] in each state of a hindcast, NaN where it is not known."""
    hindcast, bearing = weather.hindcast, weather.bearing
    assert hindcast is not None
    heading, period = limit.heading.values, limit.peak_period.values
    if bearing is None or hindcast.coming is None:
        least = limit.min("heading", skipna=False).values
        return LimitCurve(period, least, is_open.all("heading").values).limit_at(hindcast.period)
    going = bearing - hindcast.coming - np.pi  # bearings turn clockwise, headings the other way
    return LimitSurface(heading, period, limit.values, is_open.values).limit_at(
        going, hindcast.period
    )


def _hindcast_variables(
    hindcast: Hindcast, limit: np.ndarray, bare: np.ndarray, length: float
) -> dict[str, xr.DataArray]:
    """What a hindcast says of a ``limit`` in each of its states, and of the ``bare`` one without an
    alpha factor, which has more of them where the table of factors begins above the limits."""
    is_workable = hindcast.height <= limit
    months = list(hindcast.months())
    waits = [waiting(hindcast, is_workable, length)]
    waits += [waiting(hindcast, is_workable, length, spans) for _, spans in months]
    season = {"season": [WHOLE_YEAR, *(month_name[month] for month, _ in months)]}
    descriptions = {
        "workable": "share of the time that is workable",
        "startable": "share of the time in which a window may be begun",
        "none": "share of the time after the last window of the record",
    }
    values = {
        "hindcast_" + ("never" if name == "none" else name): xr.DataArray(
            [getattr(wait, name) for wait in waits], season, attrs=quantity_attributes(text, "1")
        )
        for name, text in descriptions.items()
    }
    times = [[wait.median, wait.p90] for wait in waits]
    coordinates = {**season, "quantile": list(WAITING_QUANTILES)}
    attributes = quantity_attributes("time until a window begins; infinite beyond the record", "s")
    values["waiting"] = xr.DataArray(times, coordinates, attrs={**attributes, "window": length})
    spans = hindcast.ends - hindcast.time
    outside, unknown = (float(spans[np.isnan(of)].sum() / spans.sum()) for of in (bare, limit))
    values["hindcast_outside"] = _share_variable(outside, "share of the time that has no limit")
    if unknown > outside:
        text = "share of the time whose limits are below the table of alpha factors"
        values["hindcast_below_alpha"] = _share_variable(unknown - outside, text)
    return values


def _share_variable(value: float, text: str) -> xr.DataArray:
    return xr.DataArray(value, attrs=quantity_attributes(text, "1"))
