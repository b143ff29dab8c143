"""The weather that a study of limits names, and what the limits are worth in it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from hydrosim.documents.text import Source
from hydrosim.results.weather import Alpha, Curve, Hindcast, Scatter, Waiting, waiting, workability
from hydrosim.results.weather_files import read_hindcast, read_scatter
from hydrosim.studies.operability.file import Operability, Operation

HOUR = 3600.0


@dataclass(frozen=True)
class Weather:
    """A scatter diagram, a hindcast, and the operation that needs a window."""

    scatter: Scatter | None
    hindcast: Hindcast | None
    operation: Operation | None

    def alpha(self) -> Alpha | None:
        """The table of alpha factors, if there is one."""
        table = self.operation.alpha if self.operation is not None else None
        if table is None:
            return None
        arrays = (np.array(x) for x in (table.planned, table.heights, table.factors))
        return Alpha(table.source, *arrays)


def read_weather(folder: Path, wanted: Operability) -> Weather:
    """The files that a study names; InputError says what is wrong in them, and an operation that
    its table of factors does not have."""
    scatter = wanted.scatter and read_scatter(Source(folder / wanted.scatter, "scatter"))
    hindcast = wanted.hindcast and read_hindcast(Source(folder / wanted.hindcast, "hindcast"))
    weather = Weather(scatter or None, hindcast or None, wanted.operation)
    if (alpha := weather.alpha()) is not None and wanted.operation is not None:
        alpha.factor(wanted.operation.planned, alpha.heights)
    return weather


def least_curve(found: xr.Dataset) -> Curve:
    """The least limit of all headings and swells over the peak periods, all stages together."""
    limit = found.limit.sel(stage="all").min(("swell", "heading"))
    return Curve(found.peak_period.values, limit.values)


def weather_lines(found: xr.Dataset, weather: Weather) -> Iterator[str]:
    """Workability and waiting times in words."""
    curve = least_curve(found)
    if found.sizes["heading"] * found.sizes["swell"] > 1 and (weather.scatter or weather.hindcast):
        yield "weather: by the least limit of all headings and swells"
    if weather.scatter is not None:
        share, unknown = workability(weather.scatter, curve)
        yield f"scatter diagram: {share:.1%} workable; {_beyond(curve, unknown)}"
    if weather.operation is not None:
        yield from _of_operation(curve, weather, weather.operation)


def _of_operation(curve: Curve, weather: Weather, operation: Operation) -> Iterator[str]:
    planned, contingency = operation.planned, operation.contingency
    length = planned + (planned if contingency is None else contingency)
    yield (
        f"operation: {planned / HOUR:g} h planned, {(length - planned) / HOUR:g} h contingency"
        f"{' (as long again, as none is given)' if contingency is None else ''}"
    )
    alpha = weather.alpha()
    if alpha is not None:
        factors = alpha.factor(planned, curve.height)
        curve = Curve(curve.period, curve.height * factors)
        shown = ", ".join(f"{a:.3f}" for a in factors)
        periods = ", ".join(f"{period:g}" for period in curve.period)
        yield f"alpha by {alpha.source}: {shown} at Tp {periods} s"
        if np.isnan(factors).any():
            yield f"  no factor below {alpha.heights[0]:g} m: those seas count as not workable"
    if weather.hindcast is not None:
        yield from _waiting(waiting(weather.hindcast, curve, length), length)


def _waiting(found: Waiting, length: float) -> Iterator[str]:
    times = [
        f"{w / HOUR:.1f} h" if np.isfinite(w) else "beyond the record"
        for w in (found.median, found.p90)
    ]
    yield (
        f"hindcast: {found.workable:.1%} of the time workable; {length / HOUR:g} h can begin in"
        f" {found.startable:.1%}; waiting P50 {times[0]}, P90 {times[1]}; after the last window"
        f" {found.none:.1%} of the record is left"
    )


def _beyond(curve: Curve, unknown: float) -> str:
    return (
        f"{unknown:.1%} of the seas are outside Tp {curve.period[0]:g} to {curve.period[-1]:g} s"
        " and count as not workable"
    )
