"""The runs of a set that are complete, on the disk one by one: what is killed goes on from there.

A journal is three files of a folder, beside the `result.nc` that is made meanwhile. `known.nc` has
what is known of all runs before the first of them. `first.nc` is the first run that came to its
end: the form of them all. `runs` has a line of JSON for what the set is, and for each run one, then
the bytes of its variables, in the order of the first; of a run that failed there is the line alone.
A line begins with the checksum of all that follows it, up to the next one, and each run has those
of the files beside it: what was cut off while it was written, or has changed since, is not read.
"""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple
from zlib import crc32

import numpy as np
import xarray as xr

from hydrosim.errors import InputError
from hydrosim.leftovers import is_marked, is_plain, remove_folder
from hydrosim.outputs import Output
from hydrosim.results.assembled import differing

FIRST = "first.nc"
RUNS = "runs"
KNOWN = "known.nc"
RESULT = "result.nc"
MARKED = {KNOWN: "sweep", RESULT: "sweep", FIRST: "first run"}
"""What other files than `runs` say that they are."""
PARTIAL = ".partial"  # ends the name of a file that is being written
LINE = re.compile(rb"[0-9a-f]{8} {")
"""How the lines of `runs` begin."""
EARLIER = b'{"the program": '
"""How `runs` began when lines had no checksum."""


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
        self._folder = folder
        self._first: xr.Dataset | None = None
        self._last: xr.Dataset | None = None
        self._places: dict[int, int] = {}
        there = [name for name in (FIRST, KNOWN) if (folder / name).exists()]
        self._beside = {name: _checksum(folder / name) for name in there}
        self._file = (folder / RUNS).open("a+b")
        if not identity_of(folder):
            self._file.truncate(0)
            self._file.write(_entry_of(dict(identity)))
            self._file.flush()
        else:
            self._go_on()

    def _go_on(self) -> None:
        """Find what is there; cut off what is not whole."""
        self._file.seek(0)
        self._file.readline()
        whole = self._file.tell()
        for place, known, values in entries(self._file, self._folder, (FIRST,)):
            whole = self._file.tell()
            if values and (self._folder / FIRST).exists():
                self._places[known["run"]] = place
        self._file.truncate(whole)
        if self._places:
            self._first = self._last = first_of(self._folder)

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

    def take_known(self, file: Path) -> None:
        """Keep the file of what is known of all runs, before the first of them."""
        file.replace(self._folder / KNOWN)
        self._beside[KNOWN] = _checksum(self._folder / KNOWN)

    def add(self, run: int, kept: Kept) -> None:
        """Keep a complete run, unless its form is not that of the first; it is on the disk, or with
        the system, when this returns."""
        if self._last is None:
            _store_first(kept.found, self._folder)
            self._beside[FIRST] = _checksum(self._folder / FIRST)
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
        self._file.write(_entry_of({**known, "beside": self._beside, "bytes": len(values)}, values))
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
        return _entry(file)[0]
    return {}


def is_earlier(folder: Path) -> bool:
    """Whether the journal in the folder is of a version without checksums of lines."""
    return _beginning(folder / RUNS).startswith(EARLIER)


def is_part(path: Path) -> bool:
    """Whether a file is one of a journal's, by its name and by what it says."""
    if path.name != RUNS:
        name = path.name.removesuffix(PARTIAL)
        return name in MARKED and is_marked(path, MARKED[name])
    begins = _beginning(path)
    cut_off = not begins or (LINE.match(begins) is not None and not begins.endswith(b"\n"))
    return is_plain(path) and (
        cut_off or begins.startswith(EARLIER) or bool(identity_of(path.parent))
    )


def _beginning(path: Path) -> bytes:
    """The first line of a file; nothing if it cannot be read."""
    with suppress(OSError), path.open("rb") as file:
        return file.readline()
    return b""


def forget(folder: Path) -> None:
    """Remove a journal, and its folder if nothing else is in it."""
    remove_folder(folder, is_part)


def entries(
    file: BinaryIO, folder: Path, needed: Collection[str] = (FIRST, KNOWN)
) -> Iterator[tuple[int, dict[str, Any], bytes]]:
    """Of each run from here on its place, what is known of it and its values, none of one that
    failed; up to the first that is not whole. Raises InputError if no run fits the files beside it
    that are ``needed``, since one of these has changed."""
    sums = {name: _checksum(folder / name) for name in needed if (folder / name).exists()}
    fitting = 0
    changed = ""
    with suppress(ValueError, KeyError, TypeError):
        while True:
            place = file.tell()
            known, values = _entry(file)
            others = [k for k, each in known["beside"].items() if sums.get(k, each) != each]
            if others:
                changed = others[0]
                continue
            fitting += 1
            yield place, known, values
    if changed and not fitting:
        raise InputError(
            f"{folder / changed}: is damaged (its checksum has changed), and the runs beside it"
            " cannot be read without it. Put it back from a copy, or begin anew with --overwrite."
        )


def _entry_of(known: dict[str, Any], values: bytes = b"") -> bytes:
    """A line, and the values that follow it."""
    text = json.dumps(known).encode() + b"\n" + values
    return b"%08x %s" % (crc32(text), text)


def _entry(file: BinaryIO) -> tuple[dict[str, Any], bytes]:
    """What a line says, and the values that follow it; ValueError if they are not what they
    were."""
    check, _, line = file.readline().partition(b" ")
    known = json.loads(line, object_hook=_decoded)
    values = file.read(known.get("bytes", 0))
    if check != b"%08x" % crc32(line + values):
        raise ValueError
    return known, values


def _checksum(path: Path) -> int:
    return crc32(path.read_bytes())


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
    if not path.is_file():
        return None
    first = xr.load_dataset(path, engine="netcdf4", decode_times=False)
    del first.attrs["history"]
    return first


def _store_first(found: xr.Dataset, folder: Path) -> None:
    partial = folder / f"{FIRST}{PARTIAL}"
    path = folder / FIRST
    marked = found.assign_attrs(history=Output(path, MARKED[FIRST], path).mark)
    marked.to_netcdf(partial, engine="netcdf4", format="NETCDF4")
    partial.replace(path)


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
