"""The runs of a set that are complete, on the disk one by one: what is killed goes on from there.

A journal is three files of a folder, beside the `result.nc` that is made meanwhile. `known.nc` has
what is known of all runs before the first of them. `first.nc` is the first run that came to its
end: the form of them all. `runs` has a line of JSON for what the set is, and for each run one, then
the bytes of its variables, in the order of the first; of a run that failed there is the line alone.
What was cut off while it was written is not read.
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

from hydrosim.results.assembled import differing

FIRST, RUNS, KNOWN, RESULT = "first.nc", "runs", "known.nc", "result.nc"


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
        self._folder, self._first = folder, first_of(folder)
        self._last = self._first
        self._places: dict[int, int] = {}
        self._file = (folder / RUNS).open("a+b")
        if not identity_of(folder):
            self._file.truncate(0)
            self._file.write(_line(dict(identity)))
            self._file.flush()
        else:
            self._go_on()

    def _go_on(self) -> None:
        """Find what is there; cut off what is not whole."""
        self._file.seek(0)
        self._file.readline()
        whole = self._file.tell()
        for place, known, values in entries(self._file):
            whole = self._file.tell()
            if values and self._first is not None:
                self._places[known["run"]] = place
        self._file.truncate(whole)

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
        if self._last is None:
            _store_first(kept.found, self._folder)
            self._first = self._last = kept.found
        if not _alike(kept.found, self._last):
            return
        self._last = kept.found
        arrays = (kept.found.variables[name].values for name in kept.found.data_vars)
        values = b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)
        attributes = {name: _encoded(value) for name, value in kept.attributes.items()}
        known = {"run": run, "attributes": attributes, "warnings": kept.warnings}
        self._places[run] = self._append(known, values)

    def note(self, run: int, status: str, message: str) -> None:
        """Say that a run is not complete: readers are told, a set that goes on makes it again."""
        self._append({"run": run, "status": status, "message": message}, b"")

    def _append(self, known: dict[str, Any], values: bytes) -> int:
        """The place of an entry, which is on the disk, or with the system, when this returns."""
        place = self._file.seek(0, 2)
        self._file.write(_line({**known, "bytes": len(values), "check": crc32(values)}) + values)
        self._file.flush()
        return place

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
    for name in (RUNS, FIRST, f"{FIRST}.partial", KNOWN, f"{KNOWN}.partial", RESULT):
        (folder / name).unlink(missing_ok=True)
    with suppress(OSError):
        folder.rmdir()


def entries(file: BinaryIO) -> Iterator[tuple[int, dict[str, Any], bytes]]:
    """Of each run from here on its place, what is known of it and its values, none of one that
    failed; up to the first that is not whole."""
    with suppress(ValueError, KeyError, TypeError):
        while True:
            yield file.tell(), *_entry(file)


def _entry(file: BinaryIO) -> tuple[dict[str, Any], bytes]:
    """What is known of a run, and its values; ValueError if it is not whole."""
    line = file.readline()
    known = json.loads(line, object_hook=_decoded)
    values = file.read(known["bytes"])
    if not line.endswith(b"\n") or len(values) < known["bytes"] or crc32(values) != known["check"]:
        raise ValueError
    return known, values


def form_of(first: xr.Dataset) -> np.dtype[np.void]:
    """How the values of a run lie in its bytes: those of the first, by name."""
    parts = {name: first.variables[name] for name in first.data_vars}
    return np.dtype([(str(name), part.dtype, part.shape) for name, part in parts.items()])


def _of_form(first: xr.Dataset, values: bytes) -> xr.Dataset:
    row = np.frombuffer(values, form_of(first))[0]
    return first.copy(data={name: np.asarray(row[str(name)]) for name in first.data_vars})


def _alike(one: xr.Dataset, other: xr.Dataset) -> bool:
    return _forms(one) == _forms(other) and differing(one, other) is None


def _forms(of: xr.Dataset) -> list[Any]:
    parts = ((name, of.variables[name]) for name in of.data_vars)
    return [(name, part.dims, part.shape, part.dtype) for name, part in parts]


def first_of(folder: Path) -> xr.Dataset | None:
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
