"""A netCDF file of many runs, written one after another."""

from __future__ import annotations

import json
import os
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hydrosim.results.dataset import ResultKind, differing, kind_of

if TYPE_CHECKING:
    import netCDF4
    import xarray as xr

SETS_OF_RUNS = (ResultKind.SET, ResultKind.STUDY)
RUN = "run"
NOT_RUN = "not run"
COMPLETE = "complete"
MISSING = -1  # whole numbers of runs that have none
IN_RUN = "_in_run"  # ends the name of a coordinate that says which names a run has
DIFFERING_ATTRIBUTE = "runs_differ"  # attribute: what not all runs have, in words, a line each
BY_RUN = "by_run"  # attribute: coordinates that have a value for each run
KEY = "key"  # attribute of a coordinate: the key of the case whose values it has
LETTERS = "letters"  # attribute of a coordinate: what its letters stand for, as JSON
LARGE = 1024  # values of a run from which on they are stored apart from those of other runs
# runs that are written at once, or as many as have so many bytes
BLOCK = 256
BLOCK_BYTES = 2**24
TEXTS = {
    "status": f"complete, failed, interrupted, or {NOT_RUN}",
    "status_message": "reason why a run failed",
    "warnings": "warnings of the run",
}


def open_result(path: Path, kinds: Collection[str]) -> xr.Dataset | None:
    """Result of one of these ``kinds`` in a netCDF file; None if the file holds none of them."""
    if not os.path.isfile(path):
        return None
    import xarray as xr  # slow to load

    try:
        result = xr.open_dataset(path, engine="netcdf4", decode_times=False)
    except (OSError, ValueError, RuntimeError):
        return None
    if kind_of(result) in kinds:
        from hydrosim.results.validation import check_result  # loads the models of cases

        check_result(path, result)
        return index_by_seed(result)
    result.close()
    return None


def open_runs(path: Path) -> xr.Dataset | None:
    """Runs in a netCDF file of many runs; None if the file is of another kind."""
    return open_result(path, SETS_OF_RUNS)


def index_by_seed(runs: xr.Dataset) -> xr.Dataset:
    """Runs that `sel(seed=7)` selects by their seeds; other datasets as they are, and files of
    earlier versions that have a seed for each wave train."""
    has_seed = "seed" in runs.coords and runs.seed.dims == (RUN,)
    return runs.set_xindex("seed") if has_seed else runs


def with_keys(runs: xr.Dataset) -> xr.Dataset:
    """Runs whose parameters are called by their keys, and lists by their text, as in files of
    earlier versions."""
    keys = {str(name): str(of.attrs[KEY]) for name, of in runs.coords.items() if KEY in of.attrs}
    lists = {name: of for name, of in runs.coords.items() if LETTERS in of.attrs}
    for name, of in lists.items():
        meaning = json.loads(of.attrs[LETTERS])
        texts = np.array([meaning[letter] for letter in of.values.tolist()], dtype=object)
        runs = runs.assign_coords({name: of.copy(data=texts)})
    return runs.rename({name: key for name, key in keys.items() if key != name})


def is_of_runs(dataset: xr.Dataset) -> bool:
    """Whether a dataset holds many runs."""
    return kind_of(dataset) in SETS_OF_RUNS


class RunsWriter:
    """Writer for the datasets of ``count`` runs in a new file, along a dimension ``run``.

    The first run that is added defines variables, coordinates and sizes of all. Missing values of a
    run are NaN, -1 or empty. ``along`` are coordinates or texts of the runs that are known before,
    with their attributes. ``mark`` is the history of the file, ``attributes`` are its attributes.
    Runs are added in order and written in blocks. The same runs give the same bytes.
    """

    def __init__(
        self,
        path: Path,
        count: int,
        along: Mapping[str, xr.Variable],
        coordinates: Sequence[str],
        mark: str = "",
        attributes: Mapping[str, str] | None = None,
    ) -> None:
        import netCDF4
        import xarray as xr

        self._file = netCDF4.Dataset(path, "w", format="NETCDF4")
        self._file.set_auto_maskandscale(False)
        self._last: xr.Dataset | None = None
        self._attributes: dict[str, object] = {}
        self._names: list[str] = []
        self._count = count
        self._written = 0
        self._bytes = 0
        self._block: list[tuple[Mapping[str, np.ndarray], tuple[str, ...]]] = []
        self._file.createDimension(RUN, count)
        self._file.coordinates = " ".join(coordinates)
        if mark:
            self._file.history = mark
        self._file.setncatts(attributes or {})
        numbers = xr.Variable(
            RUN, np.arange(count), {"units": "1", "long_name": "number of the run"}
        )
        for name, values in {RUN: numbers, **along}.items():
            self._write_per_run(name, values.values).setncatts({"long_name": name, **values.attrs})
        for name, what in TEXTS.items():
            self._file.createVariable(name, str, (RUN,)).long_name = what

    def _write_per_run(self, name: str, values: np.ndarray) -> netCDF4.Variable:
        """Write data of all runs: numbers or texts, one or several per run."""
        more = [f"{name}_{i}" for i in range(1, values.ndim)]
        for dimension, size in zip(more, values.shape[1:], strict=True):
            self._file.createDimension(dimension, size)
        text = values.dtype.kind not in "iufb"
        kind = str if text else np.int64 if values.dtype.kind in "iub" else np.float64
        variable = self._file.createVariable(name, kind, (RUN, *more))
        variable[:] = values.astype(object if text else kind)
        return variable

    def add(
        self,
        run: int,
        run_results: xr.Dataset,
        attributes: Mapping[str, object],
        warnings: str = "",
    ) -> None:
        """Add a complete run, the next in order. Of its ``attributes``, the file keeps those that
        all runs share."""
        if self._last is None:
            self._define(run_results, attributes)
        self._last = run_results.coords.to_dataset()
        common = common_attributes(self._attributes, attributes)
        for other in sorted(self._attributes.keys() - common.keys()):
            self._file.delncattr(other)
        self._attributes = common
        values = {name: run_results.variables[name].values for name in self._names}
        self._take(run, values, (COMPLETE, "", warnings))

    def mark(self, run: int, status: str, message: str = "", warnings: str = "") -> None:
        """Add the status of a run without values, the next in order."""
        self._take(run, {}, (status, message, warnings))

    def _take(self, run: int, values: Mapping[str, np.ndarray], texts: tuple[str, ...]) -> None:
        if run != self._written + len(self._block):
            raise ValueError(f"run {run} is not the next one")
        self._block.append((values, texts))
        self._bytes += sum(array.nbytes for array in values.values())
        if len(self._block) >= BLOCK or self._bytes >= BLOCK_BYTES:
            self._write()

    def _write(self) -> None:
        """Write the waiting runs into the file, each variable at once."""
        if not self._block:
            return
        rows = slice(self._written, self._written + len(self._block))
        for name in self._names:
            variable = self._file[name]
            block = np.full((len(self._block), *variable.shape[1:]), variable._FillValue)
            for k, (values, _) in enumerate(self._block):
                if values:
                    block[k] = values[name]
            variable[rows] = block
        for name, texts in zip(TEXTS, zip(*(t for _, t in self._block), strict=True), strict=True):
            self._file[name][rows] = np.array(texts, dtype=object)
        self._written = rows.stop
        self._block = []
        self._bytes = 0

    def differs(self, run_results: xr.Dataset) -> str | None:
        """Name of a coordinate of a run that differs from earlier runs."""
        return None if self._last is None else differing(run_results, self._last)

    def close(self) -> None:
        """Finish the file; the status of missing runs is "not run"."""
        try:
            self._write()
            while self._written < self._count:
                rest = min(BLOCK, self._count - self._written)
                self._block = [({}, (NOT_RUN, "", ""))] * rest
                self._write()
        finally:
            self._file.close()

    def _define(self, run_results: xr.Dataset, attributes: Mapping[str, object]) -> None:
        for dimension, size in run_results.sizes.items():
            self._file.createDimension(str(dimension), size)
        for name, variable in run_results.variables.items():
            if name in run_results.coords:
                self._coordinate(str(name), variable)
            else:
                self._variable(str(name), variable)
                self._names.append(str(name))
        beside = [str(name) for name in run_results.coords if name not in run_results.dims]
        self._file.coordinates = " ".join([self._file.coordinates, *beside]).strip()
        self._attributes = dict(attributes)
        self._file.setncatts(self._attributes)

    def _coordinate(self, name: str, variable: xr.Variable) -> None:
        text = variable.dtype.kind in "OU"
        kind: Any = str if text else variable.dtype
        made = self._file.createVariable(name, kind, [*map(str, variable.dims)])
        made.setncatts(variable.attrs)
        made[:] = variable.values.astype(object) if text else variable.values

    def _variable(self, name: str, variable: xr.Variable) -> None:
        kind: Any = variable.dtype
        fill = {"f": np.nan, "i": MISSING}[kind.kind]
        chunks = (1, *variable.shape) if variable.size >= LARGE else None
        dims = (RUN, *map(str, variable.dims))
        made = self._file.createVariable(name, kind, dims, fill_value=fill, chunksizes=chunks)
        made.setncatts(variable.attrs)


def common_attributes(
    first: Mapping[str, object], second: Mapping[str, object]
) -> dict[str, object]:
    """Attributes that both have, with equal values of the same type."""
    return {name: value for name, value in first.items() if _is_identical(second.get(name), value)}


def _is_identical(first: object, second: object) -> bool:
    return type(first) is type(second) and np.array_equal(np.asarray(first), np.asarray(second))
