"""Datasets that share coordinates with earlier ones, and the netCDF files of runs.

xarray takes longer to index names or times than to build the rest of a small dataset. Runs of one
study have the same coordinates, so indexes are kept and used again.
"""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from enum import StrEnum
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from hydrosim.errors import InputError
from hydrosim.files.outputs import Output, as_output, content
from hydrosim.files.text import unreadable_reason

if TYPE_CHECKING:
    from pathlib import Path

    import xarray as xr


MAX_CACHED_INDEXES = 16  # sets of indexes


def new_dataset(
    data: Mapping[Any, Any], coords: Mapping[str, Any], attributes: Mapping[str, Any] | None = None
) -> xr.Dataset:
    """`xarray.Dataset` with the same arguments. Coordinates along their own dimension come first,
    so that titles of plots begin with them."""
    import xarray as xr  # slow to load, and no run needs it before its end

    indexes = {
        name: values
        for name, values in coords.items()
        if _dims_of_variable(name, values) == (name,)
    }
    others = {name: values for name, values in coords.items() if name not in indexes}
    made = xr.Dataset({**data, **others}, _cached_coordinates(pickle.dumps(indexes)), attributes)
    return made.set_coords([*others])[[*indexes, *data, *others]]


def differing(first: xr.Dataset, second: xr.Dataset) -> str | None:
    """Name of a coordinate that differs between two datasets or is missing in one; None if all
    agree. Indexes that are the same object, as in datasets that are `new_dataset`, are not
    compared."""
    here, there = first.xindexes, second.xindexes
    for name in dict.fromkeys([*first.coords, *second.coords]):
        if name in here and name in there:
            same = here[name] is there[name] or here[name].equals(there[name])
        else:
            both = name in first.coords and name in second.coords
            same = both and first.variables[name].equals(second.variables[name])
        if not same:
            return str(name)
    return None


def _dims_of_variable(name: str, coordinate: Any) -> tuple[str, ...]:
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


# What a result is.

KIND = "kind"  # attribute


class ResultKind(StrEnum):
    """Kinds of results, as their attribute `kind` says."""

    RUN = "run"
    SET = "set"
    STUDY = "study"
    OPERABILITY = "operability"
    COMPARISON = "comparison"
    SET_COMPARISON = "comparison of sets"
    ANALYSIS = "analysis"
    CONVERGENCE = "convergence"
    STATISTICS = "statistics"
    EXPLANATION = "explanation"
    EXTREMES = "extremes over seeds"


REQUIRED_NAMES: dict[ResultKind, str] = {
    ResultKind.SET: "run status",
    ResultKind.STUDY: "run status",
    ResultKind.OPERABILITY: "stage swell heading peak_period limit low high governing",
    ResultKind.COMPARISON: "channel ours recorded residual verdict",
    ResultKind.SET_COMPARISON: "channel ours theirs difference low high chance differs",
    ResultKind.ANALYSIS: "mode rao_amplitude",
    ResultKind.RUN: "position wave_elevation energy_kinetic energy_residual",
}
"""Dimensions and variables of the kinds that are shown. A file of an earlier version, which does
not state its kind, is recognised by them."""


def kind_of(dataset: xr.Dataset) -> str:
    """Kind of a result, by its attribute; empty if it is none, or lacks names of its kind."""
    stated = dataset.attrs.get(KIND)
    names = {*dataset.dims, *dataset.data_vars}
    for kind, required in REQUIRED_NAMES.items():
        if stated in (None, kind) and names.issuperset(required.split()):
            return kind
    return "" if stated in REQUIRED_NAMES else str(stated or "")


# netCDF files of runs: written completely, and read only if they are results of runs.

FORMAT, LATEST = "hydrosim run", 2
"""Format of files of runs: "hydrosim run 2". Files of the first format have no such text."""
PURPOSE, RESTART = "purpose", "restart"
"""Attribute of variables that a run keeps to be continued, and its value: their group in a file."""
RECORDED = ("recorded_from", "recorded_to")
"""Attributes: times of the first and the last record of the run [s]."""
RUN_FILE_HINT = "expected the result of `hydrosim run`, such as run.nc"
REPORTED_KINDS = ("limits of ", "comparison of ")  # results that are no run, and have a report


def write_run(dataset: xr.Dataset, target: Path | Output) -> None:
    """Write netCDF; the file appears under its name when it is complete. Its group `restart` has
    the variables that a run keeps to be continued. Raises as `Output` does if it must not be
    written."""
    output = as_output(target, "result")
    variables = dataset.variables.items()
    restart = {name for name, variable in variables if variable.attrs.get(PURPOSE) == RESTART}
    continuation = dataset.drop_vars({*dataset.variables} - restart)
    continuation.attrs = {}
    marked = dataset.drop_vars(restart).assign_attrs(output.attributes)
    complete = {  # coordinates have no missing values
        name: {"_FillValue": None} for name, of in marked.coords.items() if of.dims == (name,)
    }
    with output.write_complete() as path:
        marked.to_netcdf(path, engine="netcdf4", format="NETCDF4", encoding=complete)
        if restart:
            continuation.to_netcdf(path, mode="a", group=RESTART, engine="netcdf4")


def load_result(path: Path, decode_times: bool = True) -> xr.Dataset:
    """All variables of a netCDF file, in memory, with those of the group `restart` of a run."""
    import xarray as xr  # slow to load

    # the file is opened once: the library may fail where it is opened again
    groups = xr.open_groups(path, engine="netcdf4", decode_times=decode_times)
    with groups.pop("/") as root:
        result = root.load()
        for group in groups.values():
            result = result.merge(group.load(), join="exact", combine_attrs="override")
    return result


def read_run(path: Path, expected: str = RUN_FILE_HINT) -> xr.Dataset:
    """Dataset of the run in the netCDF file ``path``, in memory. Raises InputError if the file is
    missing, is not netCDF or is not the result of a run. ``expected`` ends the message."""
    if reason := unreadable_reason(path):
        raise InputError(f"{path}: {reason}; {expected}.")
    try:
        run = load_result(path)
    except (OSError, ValueError, RuntimeError) as error:
        raise InputError(f"{path}: cannot be read as netCDF ({error}); {expected}.") from None
    missing = [name for name in REQUIRED_NAMES[ResultKind.RUN].split() if name not in run]
    if missing:
        found_text = f"is netCDF without {', '.join(missing)}"
        if (made := content(path) or "").startswith(REPORTED_KINDS):
            found_text = f"holds the {made}, which `hydrosim report` shows"
        elif "run" in run.dims:
            found_text = f"holds {run.sizes['run']} runs" + (
                ", a study that xarray.open_dataset reads"
                if "status" in run
                else " without their status, so it is no result of a study"
            )
        raise InputError(f"{path}: {found_text}; {expected}.")
    _require_known(path, str(run.attrs.get("format", "")))
    from hydrosim.results.validation import check_run  # loads the models of cases

    check_run(path, run)
    return run


def _require_known(path: Path, version: str) -> None:
    """Refuse files of later versions."""
    number = version.removeprefix(FORMAT).strip()
    if number.isdecimal() and int(number) > LATEST:
        expected = f"expected {FORMAT} {LATEST} or older; read it with a later version of hydrosim"
        raise InputError(f"{path}: has the format {version}; {expected}.")


def is_part(run: xr.Dataset) -> bool:
    """Whether the first or the last record of a run were cut off."""
    ends = [run.attrs.get(name) for name in RECORDED]
    if None in ends:
        return False
    return run.time.size == 0 or run.time.values[[0, -1]].tolist() != ends
