"""Frames of pandas: channels of a run over time, statistics of a run, and one row for each of many
runs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.errors import InputError
from hydrosim.files.display_units import unit_of_dof
from hydrosim.results.channels import (
    channel_names,
    channel_series,
    default_channels,
    match_channels,
)
from hydrosim.results.dataset import ResultKind, kind_of
from hydrosim.results.runs_file import RUN, is_of_runs
from hydrosim.statistics.statistics import CHANNEL_VARIABLES, NAMED_CHANNELS, UNITS_APART

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

LONG_TEXTS = ("case", "case_resolved", "status_message", "warnings")
"""Variables of many runs that are no columns of a frame."""
DEFAULT_STATISTICS = ("smallest", "largest")
"""Statistics of each channel in a frame of many runs, where no others are asked for."""


def frame_of_result(dataset: xr.Dataset | None) -> pd.DataFrame:
    """Numbers of a printed result, by its kind. Raises InputError if it has none."""
    if dataset is None:
        raise InputError("found a text without numbers; expected a result with a dataset.")
    if is_of_runs(dataset):
        return frame_of_runs(dataset)
    if kind_of(dataset) == ResultKind.STATISTICS:
        return frame_of_statistics(dataset)
    return dataset.to_dataframe()


def frame_of_channels(run: xr.Dataset, patterns: Sequence[str] = ()) -> pd.DataFrame:
    """Channels that fit the ``patterns``, by default all that are not zero, over time [s]. The
    units stand in ``frame.attrs["units"]``."""
    import pandas as pd

    names = match_channels(channel_names(run), patterns, "channels") if patterns else []
    series = {name: channel_series(run, name) for name in names or default_channels(run)}
    columns = {name: values for name, (values, _) in series.items()}
    frame = pd.DataFrame(columns, index=pd.Index(run.time.values, name="time"))
    frame.attrs["units"] = {name: unit for name, (_, unit) in series.items()}
    return frame


def frame_of_statistics(statistics: xr.Dataset) -> pd.DataFrame:
    """Statistics of each channel, in SI: a row for each channel, a column for each statistic. The
    units of channels stand in ``frame.attrs["units"]``."""
    import pandas as pd

    by_channel = {name: (values, unit) for name, unit, values in _statistics_by_channel(statistics)}
    rows = {name: values.values for name, (values, _) in by_channel.items()}
    columns = pd.Index(statistics.statistic.values.tolist(), name="statistic")
    frame = pd.DataFrame.from_dict(rows, orient="index", columns=columns).rename_axis("channel")
    frame.attrs["units"] = {name: unit for name, (_, unit) in by_channel.items()}
    return frame


def frame_of_runs(runs: xr.Dataset, statistics: Sequence[str] = DEFAULT_STATISTICS) -> pd.DataFrame:
    """One row for each run, in SI: its seed and parameters, its figures, and the ``statistics`` of
    each channel that moves, such as "position.barge.heave largest". The units of columns that have
    one stand in ``frame.attrs["units"]``."""
    import pandas as pd

    names = runs.statistic.values.tolist() if "statistic" in runs.coords else []
    if unknown := [name for name in statistics if names and name not in names]:
        raise InputError(f"statistics: found {unknown[0]!r}; expected some of {', '.join(names)}.")
    along = [name for name in (*runs.coords, *runs.data_vars) if runs[name].dims == (RUN,)]
    columns = {name: runs[name].values for name in along if name not in (RUN, *LONG_TEXTS)}
    frame = pd.DataFrame(columns, index=pd.Index(runs[RUN].values, name=RUN))
    units = {name: str(runs[name].attrs.get("units", "")) for name in columns}
    for channel, unit, values in _statistics_by_channel(runs):
        if np.nan_to_num(values.sel(statistic="std").values).any():
            for name in statistics:
                frame[f"{channel} {name}"] = values.sel(statistic=name).values
                units[f"{channel} {name}"] = UNITS_APART.get(name, unit)
    frame.attrs["units"] = {name: unit for name, unit in units.items() if unit}
    return frame


def _statistics_by_channel(dataset: xr.Dataset) -> Iterator[tuple[str, str, xr.DataArray]]:
    """Names of channels, each with its unit and its statistics (run, statistic) or (statistic,)."""
    for name, (variable, dims, unit) in CHANNEL_VARIABLES.items():
        if name not in dataset:
            continue
        for labels in product(*(dataset[dim].values.tolist() for dim in dims)):
            values = dataset[name].sel(dict(zip(dims, labels, strict=True)))
            unit_of_channel = unit_of_dof(labels[-1]) if "dof" in dims else unit
            yield ".".join([variable, *labels]), unit_of_channel, values
    if NAMED_CHANNELS in dataset:
        for channel in dataset.channel.values.tolist():
            values = dataset[NAMED_CHANNELS].sel(channel=channel)
            yield channel, str(dataset.unit.sel(channel=channel).values), values
