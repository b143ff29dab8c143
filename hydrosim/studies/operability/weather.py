"""The weather that a study of limits names, and what the limits are worth in it."""

from __future__ import annotations

from calendar import month_name
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from hydrosim.documents.text import Source
from hydrosim.errors import InputError
from hydrosim.statistics.waiting import Hindcast, waiting
from hydrosim.statistics.weather import (
    AlphaFactors,
    LimitCurve,
    LimitSurface,
    ScatterDiagram,
    workability,
)
from hydrosim.studies.operability.weather_files import read_hindcast, read_scatter

if TYPE_CHECKING:
    from hydrosim.studies.operability_file import Operability, Operation

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

    def alpha(self) -> AlphaFactors | None:
        """The table of alpha factors, if there is one."""
        table = self.operation.alpha if self.operation is not None else None
        if table is None:
            return None
        arrays = (np.array(x) for x in (table.planned, table.heights, table.factors))
        return AlphaFactors(table.source, *arrays)


def read_weather(folder: Path, wanted: Operability) -> Weather:
    """The files that a study names; InputError says what is wrong in them, and an operation that
    its table of factors does not have."""
    scatter = wanted.scatter and read_scatter(Source(folder / wanted.scatter, "scatter"))
    hindcast = wanted.hindcast and read_hindcast(Source(folder / wanted.hindcast, "hindcast"))
    if wanted.bearing is not None and hindcast and hindcast.coming is None:
        raise InputError(
            f"operability.bearing: {folder / str(wanted.hindcast)}: found no column direction, the"
            " bearing that waves come from; expected one, or no bearing."
        )
    weather = Weather(scatter or None, hindcast or None, wanted.bearing, wanted.operation)
    if (alpha := weather.alpha()) is not None and wanted.operation is not None:
        alpha.factor(wanted.operation.planned, alpha.heights)
    return weather


def assess_weather(found: xr.Dataset, weather: Weather) -> xr.Dataset:
    """The limits ``found`` with what they are worth in the weather: ``scatter_workable`` and
    ``scatter_outside``; ``alpha`` [1] of each limit; of the hindcast, over the ``season``, the
    year and each month, the shares ``workable``, ``startable`` and ``never``, and ``waiting`` [s]
    by ``quantile``. The least limit of all swells counts, stages together; of all headings, too,
    unless a bearing turns the directions of the hindcast into headings."""
    limit = found.limit.sel(stage="all").min("swell").transpose("heading", "peak_period")
    is_open = limit >= _lowest_open_height(found)
    new: dict[str, xr.DataArray] = {}
    if weather.scatter is not None:
        least = limit.min("heading").values
        curve = LimitCurve(found.peak_period.values, least, is_open.all("heading").values)
        workable, outside = workability(weather.scatter, curve)
        new["scatter_workable"] = _share(workable, "share of the seas that is workable")
        new["scatter_outside"] = _share(outside, "share of the seas at other peak periods")
    operation, alpha = weather.operation, weather.alpha()
    bare = limit
    if operation is not None and alpha is not None:
        factors = alpha.factor(operation.planned, limit.values)
        new["alpha"] = limit.copy(data=factors).assign_attrs(long_name=alpha.source, units="1")
        limit = limit * factors
    if operation is not None and weather.hindcast is not None:
        held, known = (_limits_over_time(of, is_open, weather) for of in (limit, bare))
        new |= _hindcast_variables(weather.hindcast, held, known, window_length(operation))
    return found.assign(new).assign_attrs(_assumption_attributes(weather))


def _lowest_open_height(found: xr.Dataset) -> float:
    """The height [m] from which a limit is open: the largest that was tried, or near it where runs
    tried heights apart."""
    near = 0.5 * found.attrs.get("apart", 0.0) if found.attrs.get("runs") else 0.0
    return float(found.attrs.get("highest", np.inf)) - near


def _assumption_attributes(weather: Weather) -> dict[str, str | float]:
    """What the worth of the limits depends on, as attributes."""
    attributes: dict[str, str | float] = {}
    if weather.operation is not None:
        attributes = {
            "planned": weather.operation.planned,
            "window": window_length(weather.operation),
        }
    if (alpha := weather.alpha()) is not None:
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
            [getattr(one, name) for one in waits], season, attrs=_attributes(text, "1")
        )
        for name, text in descriptions.items()
    }
    times = [[one.median, one.p90] for one in waits]
    coordinates = {**season, "quantile": list(WAITING_QUANTILES)}
    attributes = _attributes("time until a window begins; infinite beyond the record", "s")
    values["waiting"] = xr.DataArray(times, coordinates, attrs={**attributes, "window": length})
    spans = hindcast.ends - hindcast.time
    outside, unknown = (float(spans[np.isnan(of)].sum() / spans.sum()) for of in (bare, limit))
    values["hindcast_outside"] = _share(outside, "share of the time that has no limit")
    if unknown > outside:
        text = "share of the time whose limits are below the table of alpha factors"
        values["hindcast_below_alpha"] = _share(unknown - outside, text)
    return values


def _share(value: float, text: str) -> xr.DataArray:
    return xr.DataArray(value, attrs=_attributes(text, "1"))


def _attributes(text: str, unit: str) -> dict[str, str]:
    return {"long_name": text, "units": unit}
