"""Datasets that share coordinates with earlier datasets, and their comparison.

xarray takes longer to index names or times than to build the rest of a small dataset. Runs of one
study have the same coordinates, so indexes are kept and used again.
"""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr

MAX_CACHED_INDEXES = 16  # sets of indexes


def new_dataset(
    data: Mapping[Any, Any], coords: Mapping[str, Any], attributes: Mapping[str, Any] | None = None
) -> xr.Dataset:
    """`xarray.Dataset` with the same arguments."""
    import xarray as xr  # slow to load, and no run needs it before its end

    indexes = {name: each for name, each in coords.items() if _dims(name, each) == (name,)}
    others = {name: each for name, each in coords.items() if name not in indexes}
    made = xr.Dataset({**data, **others}, _cached_coordinates(pickle.dumps(indexes)), attributes)
    return made.set_coords(others) if others else made


def differing(one: xr.Dataset, other: xr.Dataset) -> str | None:
    """Name of a coordinate that differs between two datasets or is missing in one; None if all
    agree. Indexes that are the same object, as in datasets that are `new_dataset`, are not
    compared."""
    here, there = one.xindexes, other.xindexes
    for name in dict.fromkeys([*one.coords, *other.coords]):
        if name in here and name in there:
            same = here[name] is there[name] or here[name].equals(there[name])
        else:
            both = name in one.coords and name in other.coords
            same = both and one.variables[name].equals(other.variables[name])
        if not same:
            return str(name)
    return None


def _dims(name: str, coordinate: Any) -> tuple[str, ...]:
    """Dimensions of an array of xarray, of a tuple (dimensions, values, ...), or of values along
    ``name``."""
    if hasattr(coordinate, "dims"):
        return tuple(map(str, coordinate.dims))
    dims = coordinate[0] if isinstance(coordinate, tuple) else name
    return (dims,) if isinstance(dims, str) else tuple(dims)


@lru_cache(maxsize=MAX_CACHED_INDEXES)
def _cached_coordinates(indexes: bytes) -> xr.Coordinates:
    import xarray as xr

    return xr.Dataset(coords=pickle.loads(indexes)).coords
