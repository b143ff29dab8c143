"""The runs of a set that are complete, on the disk one by one: what is killed goes on from there.

A journal is two files of a folder, beside the `result.nc` that is made of it. `first.nc` is the
first run that came to its end: the form of them all. `runs` has a line of JSON for what the set is,
and for each run one, then the bytes of its variables, in the order of the first. What was cut off
while it was written is not read.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple
from zlib import crc32

import numpy as np
import xarray as xr

FIRST, RUNS, RESULT = "first.nc", "runs", "result.nc"


class Kept(NamedTuple):
    """A complete run: the variables that are kept of it, its attributes, what there is to say."""

    found: xr.Dataset
    attributes: Mapping[str, object]
    warnings: str


class Journal:
    """The runs of the set with this ``identity`` (texts by name) that are kept in ``folder``.

    ``run in journal`` and ``len(journal)`` say which and how many are there, ``read`` gives one.
    """

    def __init__(self, folder: Path, identity: Mapping[str, str]) -> None:
        self._folder, self._first = folder, _first_of(folder)
        self._places: dict[int, int] = {}
        self._file = (folder / RUNS).open("a+b")
        if not identity_of(folder):
            self._file.truncate(0)
            self._file.write(_line(dict(identity)))
            self._file.flush()
        elif self._first is not None:
            self._file.seek(0)
            self._places = dict(_places(self._file))

    def __contains__(self, run: int) -> bool:
        return run in self._places

    def __len__(self) -> int:
        return len(self._places)

    def read(self, run: int) -> Kept:
        """One of the runs that are there."""
        self._file.seek(self._places[run])
        known, values = _entry(self._file)
        assert self._first is not None
        return Kept(_of_form(self._first, values), known["attributes"], known["warnings"])

    def add(self, run: int, kept: Kept) -> None:
        """Keep a complete run, unless its form is not that of the first; it is on the disk, or with
        the system, when this returns."""
        if self._first is None:
            _store_first(kept.found, self._folder)
            self._first = kept.found
        if not _alike(kept.found, self._first):
            return
        values = b"".join(np.ascontiguousarray(v.values).tobytes() for v in kept.found.values())
        attributes = {name: _encoded(value) for name, value in kept.attributes.items()}
        known = {"run": run, "attributes": attributes, "warnings": kept.warnings}
        line = _line({**known, "bytes": len(values), "check": crc32(values)})
        self._file.seek(0, 2)
        self._places[run] = self._file.tell()
        self._file.write(line + values)
        self._file.flush()

    def close(self) -> None:
        """Nothing more will be added."""
        with suppress(OSError):  # a full disk: what did not get there is run again
            self._file.close()

    def remove(self) -> None:
        """The set is done: nothing of this is needed any more."""
        self.close()
        forget(self._folder)


def is_empty(folder: Path) -> bool:
    """Whether no run is kept there."""
    return not (folder / FIRST).exists()


def identity_of(folder: Path) -> dict[str, str]:
    """What the set in the folder is; nothing if that cannot be read."""
    with suppress(OSError, ValueError), (folder / RUNS).open("rb") as file:
        return dict(json.loads(file.readline()))
    return {}


def forget(folder: Path) -> None:
    """Remove a journal, and its folder if nothing else is in it."""
    for name in (RUNS, FIRST, f"{FIRST}.partial", RESULT):
        (folder / name).unlink(missing_ok=True)
    with suppress(OSError):
        folder.rmdir()


def _places(file: BinaryIO) -> Iterator[tuple[int, int]]:
    """Number and place of each run, up to the first that is not whole; that is cut off."""
    file.readline()
    while True:
        place = file.tell()
        try:
            yield _entry(file)[0]["run"], place
        except (ValueError, KeyError, TypeError):
            file.truncate(place)
            return


def _entry(file: BinaryIO) -> tuple[dict[str, Any], bytes]:
    """What is known of a run, and its values; ValueError if it is not whole."""
    line = file.readline()
    known = json.loads(line, object_hook=_decoded)
    values = file.read(known["bytes"])
    if not line.endswith(b"\n") or len(values) < known["bytes"] or crc32(values) != known["check"]:
        raise ValueError
    return known, values


def _of_form(first: xr.Dataset, values: bytes) -> xr.Dataset:
    arrays, at = {}, 0
    for name, variable in first.items():
        array = np.frombuffer(values, variable.dtype, variable.size, at).reshape(variable.shape)
        arrays[name] = array
        at += array.nbytes
    return first.copy(data=arrays)


def _alike(one: xr.Dataset, other: xr.Dataset) -> bool:
    here, there = (
        [(name, each.dims, each.shape, each.dtype) for name, each in of.items()]
        for of in (one, other)
    )
    return here == there and one.coords.to_dataset().equals(other.coords.to_dataset())


def _first_of(folder: Path) -> xr.Dataset | None:
    path = folder / FIRST
    return xr.load_dataset(path, engine="netcdf4", decode_times=False) if path.is_file() else None


def _store_first(found: xr.Dataset, folder: Path) -> None:
    partial = folder / f"{FIRST}.partial"
    found.to_netcdf(partial, engine="netcdf4", format="NETCDF4")
    partial.replace(folder / FIRST)


def _line(known: dict[str, Any]) -> bytes:
    return json.dumps(known).encode() + b"\n"


def _encoded(value: object) -> object:
    """numpy's numbers and arrays with their type, all else as it is."""
    if not isinstance(value, np.ndarray | np.generic):
        return value
    array = np.asarray(value)
    return {"dtype": array.dtype.str, "shape": array.shape, "values": array.ravel().tolist()}


def _decoded(found: dict[str, Any]) -> Any:
    if found.keys() != {"dtype", "shape", "values"}:
        return found
    array = np.array(found["values"], dtype=found["dtype"]).reshape(found["shape"])
    return array if array.shape else array[()]
