"""The smallest and the largest value of each run of a study, of every channel in its file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import xarray as xr

from hydrosim.dofs import DOFS
from hydrosim.presentation.units import unit_of_dof
from hydrosim.results.channels import lowest_value
from hydrosim.results.runs_file import RUN
from hydrosim.results.stages import FIGURES
from hydrosim.statistics.figures import SIDE_ATTRIBUTE
from hydrosim.statistics.results import LARGEST_RESULTS, LOWEST_ATTRIBUTE
from hydrosim.statistics.statistics import CHANNELS, EXTREME_SIDES, NAMED_CHANNELS

UNIT_DIMS = ("fender", "spring", "line", "winch", "compensator")
"""Dimensions of what pushes or pulls, whose forces have statistics."""
FORCE_DIMS = {f"{unit}_force": unit for unit in UNIT_DIMS}
"""Statistics of forces, and the dimension of what they are of."""
SUMMARISED_SERIES = {variable for variable, *_ in CHANNELS.values()}
"""Variables over time that have statistics of their own."""
MAX_SERIES_SIZE = 50_000_000
"""Values of a variable over time: of more, extremes are not looked for."""


class SmallestAndLargest(NamedTuple):
    """The smallest and the largest value (n,) of each run that has some, of a channel with an SI
    ``unit`` that is never below ``lowest``; of a figure one of them is None."""

    name: str
    unit: str
    low: np.ndarray | None
    high: np.ndarray | None
    lowest: float = -np.inf

    def sides(self) -> Iterator[tuple[str, float, np.ndarray]]:
        """What is known of its sides: name, sign, and the values times that sign."""
        for side, sign, values in zip(
            EXTREME_SIDES, (-1.0, 1.0), (self.low, self.high), strict=True
        ):
            if values is not None:
                yield side, sign, sign * values


def ends_of_motions(runs: xr.Dataset) -> Iterator[SmallestAndLargest]:
    """Of each motion that there is."""
    for body in map(str, runs.body.values):
        for dof in map(str, runs.dof.values):
            motion = runs.motion.sel(body=body, dof=dof)
            unit = unit_of_dof(dof)
            yield from _ends_if_moving(f"{body} {dof}", unit, motion)


def ends_of_channels(runs: xr.Dataset) -> Iterator[SmallestAndLargest]:
    """Of the wave, of each contact point and line, of results of contacts, of channels that are
    asked for, and of what is kept over time."""
    if "wave" in runs:
        yield from _ends_if_moving("wave elevation", "m", runs.wave)
    for name, dim in FORCE_DIMS.items():
        for label in runs[dim].values.tolist() if name in runs else []:
            title = f"{name.replace('_', ' ')} {label}"
            yield from _ends_if_moving(title, "N", runs[name].sel({dim: label}), 0.0)
    for name in LARGEST_RESULTS:
        for group in runs.contact_group.values.tolist() if name in runs else []:
            values = _finite_values(runs[name].sel(contact_group=group).values)
            title = f"{FIGURES[name][0]}, {group}"
            yield SmallestAndLargest(title, FIGURES[name][1], None, values, 0.0)
    for name in runs.channel.values.tolist() if NAMED_CHANNELS in runs else []:
        unit = str(runs["unit"].sel(channel=name).values)
        yield from _ends_if_moving(
            name, unit, runs[NAMED_CHANNELS].sel(channel=name), lowest_value(name)
        )
    yield from _ends_of_series(runs)


def ends_of_figures(runs: xr.Dataset, figures: list[str]) -> Iterator[SmallestAndLargest]:
    """Of the figures that are the largest or the smallest of something."""
    for name in figures:
        side = runs[name].attrs.get(SIDE_ATTRIBUTE)
        values = _finite_values(runs[name].values)
        unit = str(runs[name].attrs.get("units", ""))
        lowest = float(runs[name].attrs.get(LOWEST_ATTRIBUTE, -np.inf))
        if side == EXTREME_SIDES[0]:
            yield SmallestAndLargest(name, unit, values, None, lowest)
        elif side == EXTREME_SIDES[1]:
            yield SmallestAndLargest(name, unit, None, values, lowest)


def _ends_if_moving(
    name: str, unit: str, of: xr.DataArray, lowest: float = -np.inf
) -> Iterator[SmallestAndLargest]:
    """A channel by its statistics (run, statistic), if it changes."""
    own = of.transpose(RUN, "statistic").dropna(RUN, how="all")
    if own.sizes[RUN] and float(own.sel(statistic="std").max()) > 0.0:
        low, high = (own.sel(statistic=side).values for side in EXTREME_SIDES)
        yield SmallestAndLargest(name, unit, low, high, lowest)


def _ends_of_series(runs: xr.Dataset) -> Iterator[SmallestAndLargest]:
    """Of variables that are kept over time, from the start of statistics on."""
    late = runs.time.values >= float(runs.attrs.get("start", 0.0)) if "time" in runs else []
    for name, variable in runs.data_vars.items():
        if (
            "time" not in variable.dims
            or str(name) in SUMMARISED_SERIES
            or variable.size > MAX_SERIES_SIZE
        ):
            continue
        if RUN not in variable.dims or variable.dtype.kind != "f":
            continue
        own = variable.isel(time=late)
        low, high = own.min("time"), own.max("time")
        labels = [dim for dim in low.dims if dim != RUN]
        stacked = (
            each.stack(_of=labels) if labels else each.expand_dims("_of") for each in (low, high)
        )
        for least, most in zip(
            *(list(each.transpose("_of", RUN)) for each in stacked), strict=True
        ):
            of = [str(least[dim].values) for dim in labels]
            ends = _finite_values(least.values), _finite_values(most.values)
            if ends[0].size and np.ptp(np.concatenate(ends)) > 0.0:
                unit = _unit(str(variable.attrs.get("units", "")), of)
                yield SmallestAndLargest(
                    ".".join([str(name), *of]), unit, *ends, lowest_value(str(name))
                )


def _unit(units: str, labels: list[str]) -> str:
    """The unit of one channel of a variable: of "m or rad" the first along an axis."""
    first, _, second = units.partition(" or ")
    return second if second and labels and labels[-1] in DOFS[3:] else first


def _finite_values(values: np.ndarray) -> np.ndarray:
    return values[np.isfinite(values)]
