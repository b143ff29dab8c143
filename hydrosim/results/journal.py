"""Journal of a study's complete runs on disk, to continue a killed study or read an unfinished one.

A journal has three files in a folder beside the unfinished `result.nc`. `known.nc` has the data of
all runs that are known before the first run. `first.nc` is the first complete run; it defines the
form of all runs. `runs` has a line of JSON for the identity of the study and one for each run. The
bytes of the variables follow each line of a complete run; a failed run has the line only. A line
begins with a checksum of itself and of these bytes. Each run also has the checksums of the two
other files. Entries that were cut off while written, or have changed since, are not read.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple
from zlib import crc32

import numpy as np
from numpy.lib.recfunctions import repack_fields

from hydrosim.errors import InputError
from hydrosim.files.outputs import Output, has_mark, is_regular_file, remove_folder
from hydrosim.results import runs_file
from hydrosim.results.dataset import differing

if TYPE_CHECKING:
    import xarray as xr

FIRST_RUN_FILE = "first.nc"
RUNS = "runs"
KNOWN = "known.nc"
RESULT = "result.nc"
MARKED = {KNOWN: "sweep", RESULT: "sweep", FIRST_RUN_FILE: "first run"}
"""Marks of the other files than `runs`."""
PARTIAL = ".partial"  # suffix of a file that is being written
LINE_BEGINNING = re.compile(rb"[0-9a-f]{8} {")
"""Beginning of the lines of `runs`."""
EARLIER = b'{"the program": '
"""Beginning of `runs` in the version without checksums."""


class StoredRun(NamedTuple):
    """A complete run: its kept variables, its attributes, its warnings."""

    found: xr.Dataset
    attributes: Mapping[str, object]
    warnings: str


class Journal:
    """Journal in ``folder`` of the runs of the study with this ``identity`` (texts by name).

    ``run in journal`` tests for a run, ``len(journal)`` counts the runs, and ``read`` returns one.
    """

    def __init__(self, folder: Path, identity: Mapping[str, str]) -> None:
        self._folder = folder
        self._first: xr.Dataset | None = None
        self._last: xr.Dataset | None = None
        self._places: dict[int, int] = {}
        there = [name for name in (FIRST_RUN_FILE, KNOWN) if (folder / name).exists()]
        self._beside = {name: _checksum_of_file(folder / name) for name in there}
        self._file = (folder / RUNS).open("a+b")
        if not identity_of(folder):
            self._file.truncate(0)
            self._file.write(_entry_of(dict(identity)))
            self._file.flush()
        else:
            self._continue_journal()

    def _continue_journal(self) -> None:
        """Index the entries; cut off an incomplete one."""
        self._file.seek(0)
        self._file.readline()
        whole = self._file.tell()
        for place, record, values in entries(self._file, self._folder, (FIRST_RUN_FILE,)):
            whole = self._file.tell()
            if values and (self._folder / FIRST_RUN_FILE).exists():
                self._places[record["run"]] = place
        self._file.truncate(whole)
        if self._places:
            self._first = self._last = first_of(self._folder)

    def __contains__(self, run: int) -> bool:
        return run in self._places

    def __len__(self) -> int:
        return len(self._places)

    def read(self, run: int) -> StoredRun:
        """Read a run of the journal."""
        self._file.seek(self._places[run])
        record, values = _read_entry(self._file)
        assert self._first is not None
        return StoredRun(
            _dataset_of_form(self._first, values), record["attributes"], record["warnings"]
        )

    def take_known(self, file: Path) -> None:
        """Write the file of data that are known before the first run."""
        file.replace(self._folder / KNOWN)
        self._beside[KNOWN] = _checksum_of_file(self._folder / KNOWN)

    def add(self, run: int, stored: StoredRun) -> None:
        """Append a complete run, unless its form differs from the first. On return, it is on the
        disk or in the system's buffers."""
        if self._last is None:
            _store_first(stored.found, self._folder)
            self._beside[FIRST_RUN_FILE] = _checksum_of_file(self._folder / FIRST_RUN_FILE)
            self._first = self._last = stored.found
        if not _is_same_start(stored.found, self._last):
            return
        self._last = stored.found
        arrays = (stored.found.variables[name].values for name in stored.found.data_vars)
        values = b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)
        attributes = {name: _encode(value) for name, value in stored.attributes.items()}
        record = {"run": run, "attributes": attributes, "warnings": stored.warnings}
        self._places[run] = self._append(record, values)

    def note(self, run: int, status: str, message: str) -> None:
        """Record that a run is not complete. Readers see it, and a continued study makes the run
        again."""
        self._append({"run": run, "status": status, "message": message}, b"")

    def _append(self, record: dict[str, Any], values: bytes) -> int:
        """Append an entry and return its place; it is then on the disk or in the system's
        buffers."""
        place = self._file.seek(0, 2)
        self._file.write(
            _entry_of({**record, "beside": self._beside, "bytes": len(values)}, values)
        )
        self._file.flush()
        return place

    def close(self) -> None:
        """Close the journal."""
        with suppress(OSError):  # full disk: entries that were not written are computed again
            self._file.close()

    def remove(self) -> None:
        """Remove the journal of a finished study."""
        self.close()
        remove_journal(self._folder)


def is_empty(folder: Path) -> bool:
    """Whether the journal has no run."""
    return not (folder / FIRST_RUN_FILE).exists()


def identity_of(folder: Path) -> dict[str, str]:
    """Identity of the study in the folder; empty if that cannot be read."""
    with suppress(OSError, ValueError), (folder / RUNS).open("rb") as file:
        return _read_entry(file)[0]
    return {}


def is_earlier(folder: Path) -> bool:
    """Whether the journal in the folder belongs to the version without checksums of lines."""
    return _first_line(folder / RUNS).startswith(EARLIER)


def is_part(path: Path) -> bool:
    """Whether a file belongs to a journal, by its name and its mark."""
    if path.name != RUNS:
        name = path.name.removesuffix(PARTIAL)
        return name in MARKED and has_mark(path, MARKED[name])
    begins = _first_line(path)
    cut_off = not begins or (
        LINE_BEGINNING.match(begins) is not None and not begins.endswith(b"\n")
    )
    return is_regular_file(path) and (
        cut_off or begins.startswith(EARLIER) or bool(identity_of(path.parent))
    )


def _first_line(path: Path) -> bytes:
    """First line of a file; empty if it cannot be read."""
    with suppress(OSError), path.open("rb") as file:
        return file.readline()
    return b""


def remove_journal(folder: Path) -> None:
    """Remove a journal, and its folder if that is empty."""
    remove_folder(folder, is_part)


def entries(
    file: BinaryIO, folder: Path, needed: Collection[str] = (FIRST_RUN_FILE, KNOWN)
) -> Iterator[tuple[int, dict[str, Any], bytes]]:
    """Yield place, description and values of each run from the current position on, up to the first
    incomplete entry. Values of a failed run are empty. Raises InputError if no run matches the
    files beside it that are ``needed``, because one of them has changed."""
    sums = {name: _checksum_of_file(folder / name) for name in needed if (folder / name).exists()}
    fitting = 0
    changed = ""
    with suppress(ValueError, KeyError, TypeError):
        while True:
            place = file.tell()
            record, values = _read_entry(file)
            others = [k for k, digest in record["beside"].items() if sums.get(k, digest) != digest]
            if others:
                changed = others[0]
                continue
            fitting += 1
            yield place, record, values
    if changed and not fitting:
        raise InputError(
            f"{folder / changed}: is damaged (its checksum has changed), and the runs beside it"
            " cannot be read without it. Restore it from a copy, or start again with"
            " --overwrite."
        )


def _entry_of(record: dict[str, Any], values: bytes = b"") -> bytes:
    """A line with its checksum, and the values that follow it."""
    text = json.dumps(record).encode() + b"\n" + values
    return b"%08x %s" % (crc32(text), text)


def _read_entry(file: BinaryIO) -> tuple[dict[str, Any], bytes]:
    """Description of a run, and its values. Raises ValueError if the checksum does not match."""
    check, _, line = file.readline().partition(b" ")
    record = json.loads(line, object_hook=_decode)
    values = file.read(record.get("bytes", 0))
    if check != b"%08x" % crc32(line + values):
        raise ValueError
    return record, values


def _checksum_of_file(path: Path) -> int:
    return crc32(path.read_bytes())


def form_of(first: xr.Dataset) -> np.dtype[np.void]:
    """Layout of the values of a run in its bytes: that of the first run, by name."""
    parts = {name: first.variables[name] for name in first.data_vars}
    return np.dtype([(str(name), part.dtype, part.shape) for name, part in parts.items()])


def _dataset_of_form(first: xr.Dataset, values: bytes) -> xr.Dataset:
    row = np.frombuffer(values, form_of(first))[0]
    return first.copy(data={name: np.asarray(row[str(name)]) for name in first.data_vars})


def _is_same_start(first: xr.Dataset, second: xr.Dataset) -> bool:
    return _forms(first) == _forms(second) and differing(first, second) is None


def _forms(of: xr.Dataset) -> list[Any]:
    parts = ((name, of.variables[name]) for name in of.data_vars)
    return [(name, part.dims, part.shape, part.dtype) for name, part in parts]


def first_of(folder: Path) -> xr.Dataset | None:
    import xarray as xr  # slow to load

    path = folder / FIRST_RUN_FILE
    if not path.is_file():
        return None
    first = xr.load_dataset(path, engine="netcdf4", decode_times=False)
    del first.attrs["history"]
    return first


def _store_first(first_run: xr.Dataset, folder: Path) -> None:
    partial = folder / f"{FIRST_RUN_FILE}{PARTIAL}"
    path = folder / FIRST_RUN_FILE
    marked = first_run.assign_attrs(history=Output(path, MARKED[FIRST_RUN_FILE], path).mark)
    marked.to_netcdf(partial, engine="netcdf4", format="NETCDF4")
    partial.replace(path)


def _encode(value: object) -> object:
    """JSON for numbers and arrays of numpy with their type; other values are unchanged."""
    if not isinstance(value, np.ndarray | np.generic):
        return value
    array = np.asarray(value)
    return {"dtype": array.dtype.str, "shape": array.shape, "values": array.ravel().tolist()}


def _decode(decoded: dict[str, Any]) -> Any:
    if decoded.keys() != {"dtype", "shape", "values"}:
        return decoded
    array = np.array(decoded["values"], dtype=decoded["dtype"]).reshape(decoded["shape"])
    return array if array.shape else array[()]


# Runs of an unfinished study, from its folder `RUNS.nc.partial`.

GATHERED = "gathered"  # attribute of unfinished runs: how many are complete, in words


def runs_at(path: Path) -> xr.Dataset | None:
    """Runs in a file of many runs, or in the folder of an unfinished study; None for another file.
    Raises InputError for another folder, or if no run is complete yet."""
    other = path.with_suffix("") if path.suffix == PARTIAL else Path(f"{path}{PARTIAL}")
    if os.path.exists(other) and not os.path.exists(path):
        of = "the result of the sweep" if path.suffix == PARTIAL else "an unfinished sweep"
        raise InputError(f"{path}: does not exist; {other} is {of}.")
    if not os.path.exists(path) and (rounds := _round_files(path)):
        raise InputError(
            f"{path}: does not exist. An unfinished study that adds seeds until a mean is precise"
            f" keeps its last round in {rounds[-1]}."
        )
    return read_unfinished(path) if os.path.isdir(path) else runs_file.open_runs(path)


def _round_files(path: Path) -> list[Path]:
    """Rounds of a study with `until`, see `hydrosim.study.many_runs`."""
    result = path.with_suffix("") if path.suffix == PARTIAL else path
    folder = Path(f"{result}.rounds")
    return sorted(folder.glob("*.nc*")) if os.path.isdir(folder) else []


def read_unfinished(folder: Path) -> xr.Dataset:
    """Dataset of an unfinished study, in memory, in the form of its later file. Runs that are not
    complete have NaN or -1, and the status "not run". Variables of a thousand or more values per
    run are left out. The attribute ``gathered`` says how many runs are complete. Nothing in the
    folder is changed, and the study may continue meanwhile."""
    import xarray as xr  # slow to load

    if not (folder / RUNS).is_file():
        raise InputError(f"{folder}: has no runs of a sweep{_expected_folder_text(folder)}.")
    if not (folder / KNOWN).is_file():
        raise _earlier(folder, f"lacks {KNOWN}")
    try:
        if is_earlier(folder):
            raise _earlier(folder, f"lines of {RUNS} have no checksums")
        layout = xr.load_dataset(folder / KNOWN, engine="netcdf4", decode_times=False)
        first = first_of(folder)
        with (folder / RUNS).open("rb") as file:
            return _gather_runs(folder, layout, first, file)
    except FileNotFoundError:
        raise InputError(f"{folder}: no longer exists, because its sweep has ended.") from None
    except (OSError, RuntimeError, ValueError) as error:
        raise InputError(
            f"{folder}: cannot be read ({error}); sweep --resume tells whether the sweep can"
            " continue."
        ) from None


def _earlier(folder: Path, text: str) -> InputError:
    return InputError(
        f"{folder}: {text}, because an earlier version of the program began it; expected a"
        " folder of this version. Let that program finish, or continue with it."
    )


def _gather_runs(
    folder: Path, layout: xr.Dataset, first: xr.Dataset | None, file: BinaryIO
) -> xr.Dataset:
    count = layout.sizes[runs_file.RUN]
    status, messages, warnings = (
        layout[name].values.astype(object) for name in ("status", "status_message", "warnings")
    )
    whole = np.dtype([]) if first is None else form_of(first)
    small = [name for name in whole.names or () if whole[name].itemsize < 8 * runs_file.LARGE]
    chosen = whole[small]
    table = _empty_rows(count, repack_fields(chosen))
    common: dict[str, object] | None = None
    file.readline()
    for _, entry, values in entries(file, folder):
        if values and first is None:
            continue
        run = entry["run"]
        status[run] = entry.get("status", runs_file.COMPLETE)
        messages[run] = entry.get("message", "")
        warnings[run] = entry.get("warnings", "")
        if values:
            table[run] = np.frombuffer(values, chosen)[0]
            common = runs_file.common_attributes(
                entry["attributes"] if common is None else common, entry["attributes"]
            )
    done = int(np.sum(status == runs_file.COMPLETE))
    failed = [f"run {k}: {messages[k]}" for k in np.flatnonzero(status == "failed")]
    summary = f"{done:,} of {count:,} runs are complete" + (
        f", {len(failed):,} failed" if failed else ""
    )
    if first is None or not done:
        raise InputError(
            f"{folder}: {summary}. Wait for the first complete run, or continue the sweep with"
            f" --resume. {' '.join(failed[:1])}".strip()
        )
    texts = {"status": status, "status_message": messages, "warnings": warnings}
    gathered = layout.assign({name: layout[name].copy(data=text) for name, text in texts.items()})
    parts = {
        name: ((runs_file.RUN, *first[name].dims), _column_values(table[name])) for name in small
    }
    gathered = gathered.assign({n: (*part, first[n].attrs) for n, part in parts.items()})
    by_run = [name for name in str(layout.attrs.get(runs_file.BY_RUN, "")).split() if name in small]
    gathered = gathered.assign_coords(first.coords).set_coords(by_run)
    return runs_file.index_by_seed(gathered.assign_attrs({**(common or {}), GATHERED: summary}))


def _column_values(column: np.ndarray) -> np.ndarray:
    """Values as xarray reads them from a file: integers with missing values become floats."""
    if column.dtype.kind == "f":
        return np.ascontiguousarray(column)
    values = column.astype(np.promote_types(column.dtype, np.float32))
    values[column == runs_file.MISSING] = np.nan
    return values


def _empty_rows(count: int, form: np.dtype[np.void]) -> np.ndarray:
    """An empty row for each run."""
    row = np.zeros((), form)
    for name in form.names or ():
        row[name] = np.nan if form[name].base.kind == "f" else runs_file.MISSING
    return np.full(count, row)


def _expected_folder_text(folder: Path) -> str:
    """Suggestion for a user who gave another folder."""
    meant = sorted(part.parent.name for part in folder.glob(f"*{PARTIAL}/{FIRST_RUN_FILE}"))
    example = f"{folder / meant[0]}" if meant else "RUNS.nc.partial"
    more = f" (others here: {', '.join(meant)})" if len(meant) > 1 else ""
    way = f"the folder of an unfinished sweep, such as {example}{more}"
    return f"; expected the result of a run or of a study, or {way}"
