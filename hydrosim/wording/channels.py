"""Channels in statistics: what each is called, and its unit."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import xarray as xr

from hydrosim.presentation.document import Between, Value
from hydrosim.presentation.units import unit_of_dof
from hydrosim.statistics.ends import UNIT_DIMS
from hydrosim.statistics.extremes import ExtremeModel
from hydrosim.statistics.statistics import EXTREME_SIDES


class StatisticsChannel(NamedTuple):
    """A channel in statistics: the ``kind`` of variables, the labels ``at`` which it stands there,
    what it is called, and its SI unit."""

    kind: str
    at: dict[str, str]
    title: str
    unit: str

    def figure(self, found: xr.Dataset, name: str) -> Value:
        """A figure by its name among `statistics.STATISTIC_NAMES`."""
        number = float(found[self.kind].sel({**self.at, "statistic": name}))
        return Value(number, "s" if name == "period" else self.unit)

    def basis(self, found: xr.Dataset, side: str) -> ExtremeModel:
        """What the extremes of a side are by, or why there are none."""
        return ExtremeModel(int(found[f"{self.kind}_basis"].sel({**self.at, "side": side})))

    def extreme(self, found: xr.Dataset, side: str, name: str) -> Value:
        """A figure of the extremes of a side."""
        each = found[f"{self.kind}_extreme"].sel({**self.at, "side": side, "extreme": name})
        return Value(float(each), self.unit)

    def interval(self, found: xr.Dataset, side: str, name: str) -> Between:
        """The interval of a figure of the extremes of a side."""
        low, high = (self.extreme(found, side, f"{name}_{end}") for end in ("lower", "upper"))
        return Between(low.number, high.number, self.unit)

    def recorded_mean(self, found: xr.Dataset) -> Value:
        """The mean of the records, where that by impulses is another; else not a number."""
        recorded = found.get(f"{self.kind}_recorded_mean")
        number = float("nan") if recorded is None else float(recorded.sel(self.at))
        return Value(number, self.unit)


def channels_of(found: xr.Dataset) -> Iterator[StatisticsChannel]:
    """The channels of statistics that vary: motions, waves, contacts, lines, those by name."""
    for channel in _all_channels(found):
        if ExtremeModel.CONSTANT not in {channel.basis(found, side) for side in EXTREME_SIDES}:
            yield channel


def _all_channels(found: xr.Dataset) -> Iterator[StatisticsChannel]:
    for body in map(str, found.body.values):
        for dof in map(str, found.dof.values):
            yield StatisticsChannel(
                "motion", {"body": body, "dof": dof}, f"{body} {dof}", unit_of_dof(dof)
            )
    if "wave" in found:
        yield StatisticsChannel("wave", {}, "wave elevation", "m")
    for kind in UNIT_DIMS:
        for name in map(str, found[kind].values if kind in found.coords else ()):
            if f"{kind}_force" in found:
                yield StatisticsChannel(f"{kind}_force", {kind: name}, f"force of {name}", "N")
    for name in map(str, found.channel.values if "channel" in found.dims else ()):
        unit = str(found.unit.sel(channel=name).item())
        yield StatisticsChannel("named", {"channel": name}, name, unit)
