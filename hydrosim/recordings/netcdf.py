"""Recordings in netCDF. Columns of a run have the names of `hydrosim.documents.series`."""

from __future__ import annotations

import xarray as xr

from hydrosim.documents.series import columns_of, select
from hydrosim.documents.text import Source, readable_unit
from hydrosim.recordings.recording import RecordedColumn, Recording, is_time


def read(source: Source) -> Recording:
    """Variables over time, ``VARIABLE.SELECTION``. Entries of a dimension without names are
    numbered from 1 on."""
    try:
        with xr.open_dataset(source.file, engine="netcdf4", decode_times=False) as opened:
            found = opened.load()
    except (OSError, ValueError, RuntimeError) as error:
        source.wrong(f"cannot be read as netCDF ({error}); is it complete?")
    time = next((dim for dim in map(str, found.dims) if is_time(dim)), None)
    if time is None:
        names = ", ".join(map(str, found.dims))
        source.wrong(f"found the dimensions {names or 'none'}; expected time, or t, among them")
    if time not in found.coords:
        source.wrong(f"found a dimension {time} without values; expected the times [s]")
    stamp = found[time]
    first = RecordedColumn(time, _unit(stamp.attrs.get("units")), stamp.values.astype(float))
    over_time = _label_dimensions(found, time)
    columns = [first]
    for name in columns_of(over_time):
        values, unit = select(source, over_time, name)
        columns.append(RecordedColumn(name, _unit(unit or None), values))
    return Recording(source, "netCDF", columns)


def _label_dimensions(found: xr.Dataset, time: str) -> xr.Dataset:
    """Numeric variables over a dimension called time, with names for the entries of other
    dimensions."""
    renamed = found.rename({time: "time"}) if time != "time" else found
    numbers = renamed[[name for name, array in renamed.items() if array.dtype.kind in "iuf"]]
    labels = {
        dim: [str(x) for x in (numbers[dim].values if dim in numbers.coords else range(1, n + 1))]
        for dim, n in numbers.sizes.items()
        if dim != "time"
    }
    return numbers.assign_coords(labels)


def _unit(text: str | None) -> str | None:
    """Unit from an attribute, such as "s" from "seconds since 2020-01-01"."""
    return None if text is None else readable_unit(text.split(" since ")[0])
