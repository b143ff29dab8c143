"""Files of a set of runs: one netCDF file in the end, and a folder of its runs until then.

The folder ``RUNS.nc.partial`` has three files beside the unfinished `result.nc`. `known.nc` has the
data of all runs that are known before the first run. `first.nc` is the first complete run; it
defines the form of all runs. `runs` has a line of JSON for the identity of the set and one for each
run. The bytes of the variables follow each line of a complete run; a failed run has the line only.
A line begins with a checksum of itself and of these bytes. Each run also has the checksums of the
two other files. Entries that were cut off while written, or have changed since, are not read.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple, Self
from zlib import crc32

import numpy as np

from hydrosim.errors import InputError, unwritable
from hydrosim.files.outputs import Output, check_folder, has_mark, is_regular_file, remove_folder
from hydrosim.results.dataset import ResultKind, differing, kind_of

if TYPE_CHECKING:
    import netCDF4
    import xarray as xr

SETS_OF_RUNS = (ResultKind.SET, ResultKind.STUDY)
RUN = "run"
NOT_RUN = "not run"
INTERRUPTED = "interrupted"
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
"""Texts of each run: the first three fields of a `RunOutcome`."""
COUNT_ATTRIBUTES = {
    "solver_steps": "steps of the solver",
    "solver_events": "events of the solver",
    "energy_residual_relative": "largest residual of the energy balance, of the energy exchanged",
}
"""Attributes of a run that are variables of a set, and what they are."""


class RunOutcome(NamedTuple):
    """How a run ended, why, and its warnings. A complete run has the ``dataset`` that is kept of
    it, and its attributes that are those of all."""

    status: str
    message: str = ""
    warnings: str = ""
    dataset: xr.Dataset | None = None
    attributes: Mapping[str, object] = {}


# The netCDF file of a set.


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


def is_complete(path: Path) -> bool:
    """Whether all runs in the file of a set came to an end."""
    import netCDF4

    try:
        with netCDF4.Dataset(path) as runs:  # xarray reads all texts when it opens a file
            return not {NOT_RUN, INTERRUPTED} & {*runs["status"][:].tolist()}
    except (OSError, ValueError, RuntimeError, IndexError):
        return False


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
    """Writer for the outcomes of ``count`` runs in a new file, along a dimension ``run``.

    The first complete run defines variables, coordinates and sizes of all. Missing values of a run
    are NaN, -1 or empty. ``along`` are data of the runs that are known before, with their
    attributes; those that are ``coordinates`` are named. Runs are added in order and written in
    blocks. The same runs give the same bytes.
    """

    def __init__(
        self,
        path: Path,
        count: int,
        along: Mapping[str, xr.Variable],
        coordinates: Collection[str],
        attributes: Mapping[str, str],
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
        self._block: list[tuple[Mapping[str, np.ndarray], Sequence[str]]] = []
        self._file.createDimension(RUN, count)
        self._file.coordinates = " ".join([*coordinates, *attributes.get(BY_RUN, "").split()])
        self._file.setncatts(attributes)
        about_numbers = {"units": "1", "long_name": "number of the run"}
        numbers = xr.Variable(RUN, np.arange(count), about_numbers)
        for name, variable in {RUN: numbers, **along}.items():
            dims = [RUN, *(f"{name}_{i}" for i in range(1, variable.ndim))]
            values = variable.values
            kind = values.dtype.kind
            stored = np.int64 if kind in "iub" else np.float64 if kind == "f" else object
            values = values.astype(stored)
            self._add_values(name, xr.Variable(dims, values, {"long_name": name, **variable.attrs}))
        for name, what in TEXTS.items():
            self._file.createVariable(name, str, (RUN,)).long_name = what

    def __enter__(self) -> Self:
        return self

    def __exit__(self, error: type[BaseException] | None, *_: object) -> None:
        """Finish the file. What ended it early is told, not what follows from that."""
        with suppress(*(() if error is None else (RuntimeError, OSError))):
            self.close()

    def add(self, run: int, outcome: RunOutcome) -> RunOutcome:
        """Add the next run in order, and return it. A run whose coordinates are not those of the
        runs before it has failed. The file keeps the attributes that all complete runs share."""
        if run != self._written + len(self._block):
            raise ValueError(f"run {run} is not the next one")
        dataset = outcome.dataset
        if dataset is not None and self._last is not None:
            name = differing(dataset, self._last)
            if name is not None:
                message = f"its {name} is not that of the runs before it"
                outcome = RunOutcome("failed", message)
        self._block.append((self._take_values(outcome), outcome[:3]))
        if len(self._block) >= BLOCK or self._bytes >= BLOCK_BYTES:
            self._write_block()
        return outcome

    def close(self) -> None:
        """Finish the file; the status of missing runs is "not run"."""
        try:
            self._write_block()
            while self._written < self._count:
                rest = min(BLOCK, self._count - self._written)
                self._block = [({}, (NOT_RUN, "", ""))] * rest
                self._write_block()
        finally:
            self._file.close()

    def _take_values(self, outcome: RunOutcome) -> dict[str, np.ndarray]:
        """The values of a run. The first defines the variables; common attributes stay."""
        dataset, attributes = outcome.dataset, outcome.attributes
        if dataset is None:
            return {}
        if self._last is None:
            self._define(dataset)
            self._attributes = dict(attributes)
            self._file.setncatts(self._attributes)
        self._last = dataset.coords.to_dataset()
        for name, value in list(self._attributes.items()):
            if not _is_identical(attributes.get(name), value):
                del self._attributes[name]
                self._file.delncattr(name)
        values = {name: dataset.variables[name].values for name in self._names}
        self._bytes += sum(array.nbytes for array in values.values())
        return values

    def _define(self, dataset: xr.Dataset) -> None:
        for dimension, size in dataset.sizes.items():
            self._file.createDimension(str(dimension), size)
        for name, variable in dataset.variables.items():
            if name in dataset.coords:
                self._add_values(str(name), variable)
                continue
            fill = {"f": np.nan, "i": MISSING}[variable.dtype.kind]
            chunks = (1, *variable.shape) if variable.size >= LARGE else None
            dims = (RUN, *map(str, variable.dims))
            created = self._file.createVariable(
                str(name), variable.dtype, dims, fill_value=fill, chunksizes=chunks
            )
            created.setncatts(variable.attrs)
            self._names.append(str(name))
        beside = [str(name) for name in dataset.coords if name not in dataset.dims]
        self._file.coordinates = " ".join([self._file.coordinates, *beside]).strip()

    def _add_values(self, name: str, variable: xr.Variable) -> None:
        """Add data that are known, numbers or texts."""
        for dimension, size in variable.sizes.items():
            if dimension not in self._file.dimensions:
                self._file.createDimension(str(dimension), size)
        is_text = variable.dtype.kind in "OU"
        kind: Any = str if is_text else variable.dtype
        created = self._file.createVariable(name, kind, [*map(str, variable.dims)])
        created.setncatts(variable.attrs)
        created[:] = variable.values.astype(object) if is_text else variable.values

    def _write_block(self) -> None:
        """Write the waiting runs into the file, each variable at once."""
        if not self._block:
            return
        rows = slice(self._written, self._written + len(self._block))
        for name in self._names:
            variable: netCDF4.Variable = self._file[name]
            block = np.full((len(self._block), *variable.shape[1:]), variable._FillValue)
            for k, (values, _) in enumerate(self._block):
                if values:
                    block[k] = values[name]
            variable[rows] = block
        for k, name in enumerate(TEXTS):
            self._file[name][rows] = np.array([texts[k] for _, texts in self._block], dtype=object)
        self._written = rows.stop
        self._block = []
        self._bytes = 0


def _is_identical(first: object, second: object) -> bool:
    return type(first) is type(second) and np.array_equal(np.asarray(first), np.asarray(second))


# The folder of an unfinished set.

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


class Journal:
    """Runs in the ``folder`` of a set. With an ``identity`` (texts by name) others are added;
    without, nothing in the folder is changed.

    ``run in journal`` tests for a complete run, ``len(journal)`` counts these.
    """

    def __init__(self, folder: Path, identity: Mapping[str, str] | None = None) -> None:
        self._folder = folder
        self._places: dict[int, int] = {}
        self._complete: set[int] = set()
        there = [name for name in (FIRST_RUN_FILE, KNOWN) if (folder / name).exists()]
        self._beside = {name: _checksum_of_file(folder / name) for name in there}
        self._file: BinaryIO = (folder / RUNS).open("rb" if identity is None else "a+b")
        if identity is None:
            self._index_entries({*there})
        elif identity_of(folder):
            self._file.truncate(self._index_entries({FIRST_RUN_FILE}))
        else:
            self._file.truncate(0)
            self._file.write(_entry_of(dict(identity)))
            self._file.flush()
        self._first = self._last = first_of(folder) if self._complete else None
        if self._complete and self._first is None:
            raise FileNotFoundError(folder / FIRST_RUN_FILE)

    def _index_entries(self, needed: set[str]) -> int:
        """Find the runs, up to the first incomplete entry, and where that begins. Raises InputError
        if no run matches the files beside it that are ``needed``, because one has changed."""
        self._file.seek(0)
        self._file.readline()
        fitting = 0
        changed = ""
        place = self._file.tell()
        with suppress(ValueError, KeyError, TypeError):
            while True:
                record, values = _read_entry(self._file)
                run, sums = record["run"], record["beside"]
                compared = needed & sums.keys() & self._beside.keys()
                altered = [name for name in compared if self._beside[name] != sums[name]]
                if altered:
                    changed = altered[0]
                else:
                    fitting += 1
                    if FIRST_RUN_FILE in self._beside or not values:
                        self._places[run] = place
                        (self._complete.add if values else self._complete.discard)(run)
                place = self._file.tell()
        if changed and not fitting:
            raise InputError(
                f"{self._folder / changed}: is damaged (its checksum has changed), and the runs"
                " beside it cannot be read without it. Restore it from a copy, or start again with"
                " --overwrite."
            )
        return place

    def __contains__(self, run: int) -> bool:
        return run in self._complete

    def __len__(self) -> int:
        return len(self._complete)

    def read(self, run: int) -> RunOutcome:
        """Read a run of the journal; one that it has not is not run."""
        if run not in self._places:
            return RunOutcome(NOT_RUN)
        self._file.seek(self._places[run])
        record, values = _read_entry(self._file)
        texts = (record.get("message", ""), record.get("warnings", ""))
        if not values:
            return RunOutcome(record["status"], *texts)
        assert self._first is not None
        row = np.frombuffer(values, _form_of(self._first))[0]
        names = [str(name) for name in self._first.data_vars]
        dataset = self._first.copy(data={name: np.asarray(row[name]) for name in names})
        return RunOutcome(COMPLETE, *texts, dataset, record["attributes"])

    def take_known(self, file: Path) -> None:
        """Write the file of data that are known before the first run."""
        file.replace(self._folder / KNOWN)
        self._beside[KNOWN] = _checksum_of_file(self._folder / KNOWN)

    def add(self, run: int, outcome: RunOutcome) -> None:
        """Append a run, which is then on the disk or in the system's buffers. A complete one whose
        form differs from the first is left out. Of one that is not complete readers see why, and a
        continued study makes it again."""
        dataset = outcome.dataset
        if dataset is None:
            record = {"run": run, "status": outcome.status, "message": outcome.message}
            self._append(record, b"")
            return
        if self._last is None:
            self._store_first(dataset)
        elif _form_of(dataset) != _form_of(self._last) or differing(dataset, self._last):
            return
        self._last = dataset
        arrays = (dataset.variables[name].values for name in dataset.data_vars)
        values = b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)
        attributes = {name: _encode(value) for name, value in outcome.attributes.items()}
        record = {"run": run, "attributes": attributes, "warnings": outcome.warnings}
        self._append(record, values)
        self._complete.add(run)

    def _append(self, record: dict[str, Any], values: bytes) -> None:
        self._places[record["run"]] = self._file.seek(0, 2)
        self._file.write(
            _entry_of({**record, "beside": self._beside, "bytes": len(values)}, values)
        )
        self._file.flush()

    def _store_first(self, first_run: xr.Dataset) -> None:
        path = self._folder / FIRST_RUN_FILE
        partial = path.with_name(f"{FIRST_RUN_FILE}{PARTIAL}")
        marked = first_run.assign_attrs(history=Output(path, MARKED[FIRST_RUN_FILE], path).mark)
        marked.to_netcdf(partial, engine="netcdf4", format="NETCDF4")
        partial.replace(path)
        self._beside[FIRST_RUN_FILE] = _checksum_of_file(path)
        self._first = first_run

    def close(self) -> None:
        """Close the journal."""
        with suppress(OSError):  # full disk: entries that were not written are computed again
            self._file.close()

    def remove(self) -> None:
        """Remove the journal of a finished study."""
        self.close()
        remove_journal(self._folder)


def folder_of(result: Output) -> Path:
    """Where a set is kept until it is done."""
    return Path(f"{result.path}{PARTIAL}")


@contextmanager
def locked_journal(result: Output, resume: bool, identity: Mapping[str, str]) -> Iterator[Journal]:
    """The journal of the set with this ``identity``, of this process alone: with the runs that are
    there if it is to ``resume``, else a new one. Nothing stays of a set without a run.

    Raises InputError where another process writes the same, where runs would be lost, or where they
    are of another set; WritingError where it cannot be written."""
    folder = folder_of(result)
    with result.hold_lock():
        check_folder(folder, is_part)
        try:
            _check_continuation(result, resume, identity)
            folder.mkdir(exist_ok=True)
            journal = Journal(folder, identity)
            try:
                yield journal
            finally:
                journal.close()
                if not len(journal):
                    journal.remove()
        except (OSError, RuntimeError) as error:  # netCDF raises RuntimeError
            raise unwritable(result.path, error) from None


def _check_continuation(result: Output, resume: bool, identity: Mapping[str, str]) -> None:
    """Remove what is there of a set that is begun anew. Raises InputError where runs would be lost,
    or are of another set."""
    folder = folder_of(result)
    if (folder / FIRST_RUN_FILE).exists() and not (resume or result.overwrite):
        raise InputError(
            f"{folder}: holds runs of a set that did not come to its end; --resume goes on from"
            " them (resume=True in Python), --overwrite begins anew."
        )
    if not resume:
        remove_journal(folder)
        return
    if is_earlier(folder):
        raise InputError(
            f"--resume: the runs in {folder} were kept by an earlier version of the program, in"
            " another form. Go on with that program, or begin anew with --overwrite."
        )
    stored = identity_of(folder)
    changed = [name for name in identity if stored and stored.get(name) != identity[name]]
    if changed:
        raise InputError(
            f"--resume: these have changed since the runs in {folder} were made:"
            f" {'; '.join(changed)}. Restore them to go on, or begin anew with --overwrite, which"
            " replaces the finished runs."
        )


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


def _form_of(first: xr.Dataset) -> np.dtype[np.void]:
    """Layout of the values of a run in its bytes: that of the first run, by name."""
    parts = {name: first.variables[name] for name in first.data_vars}
    return np.dtype([(str(name), part.dtype, part.shape) for name, part in parts.items()])


def first_of(folder: Path) -> xr.Dataset | None:
    """The first complete run in a folder; None if there is none yet."""
    path = folder / FIRST_RUN_FILE
    if not path.is_file():
        return None
    import xarray as xr  # slow to load

    first = xr.load_dataset(path, engine="netcdf4", decode_times=False)
    del first.attrs["history"]
    return first


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


# Runs of an unfinished set, from its folder.

GATHERED = "gathered"  # attribute of unfinished runs: how many are complete, in words


def runs_at(path: Path) -> xr.Dataset | None:
    """Runs in a file of many runs, or in the folder of an unfinished study; None for another file.
    Raises InputError for another folder, or if no run is complete yet."""
    result = path.with_suffix("") if path.suffix == PARTIAL else path
    other = result if path.suffix == PARTIAL else Path(f"{path}{PARTIAL}")
    if os.path.exists(other) and not os.path.exists(path):
        of = "the result of the sweep" if path.suffix == PARTIAL else "an unfinished sweep"
        raise InputError(f"{path}: does not exist; {other} is {of}.")
    rounds = Path(f"{result}.rounds")  # of a study with `until`
    files = sorted(rounds.glob("*.nc*")) if os.path.isdir(rounds) else []
    if not os.path.exists(path) and files:
        raise InputError(
            f"{path}: does not exist. An unfinished study that adds seeds until a mean is precise"
            f" keeps its last round in {files[-1]}."
        )
    return read_unfinished(path) if os.path.isdir(path) else open_runs(path)


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
    if is_earlier(folder):
        raise _earlier(folder, f"lines of {RUNS} have no checksums")
    try:
        layout = xr.load_dataset(folder / KNOWN, engine="netcdf4", decode_times=False)
        journal = Journal(folder)
        try:
            return _gather_runs(folder, layout, journal)
        finally:
            journal.close()
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


def _gather_runs(folder: Path, layout: xr.Dataset, journal: Journal) -> xr.Dataset:
    """The runs of a journal as `RunsWriter` writes them."""
    import xarray as xr

    count = layout.sizes[RUN]
    along = {str(n): v for n, v in layout.variables.items() if n not in {RUN, *TEXTS}}
    failed: list[str] = []
    with TemporaryDirectory() as room:
        path = Path(room, RESULT)
        coordinates = [name for name in along if name in layout.coords]
        with RunsWriter(path, count, along, coordinates, layout.attrs) as file:
            for run in range(count):
                outcome = journal.read(run)
                if outcome.status == "failed":
                    failed.append(f"run {run}: {outcome.message}")
                if outcome.dataset is not None:
                    large = [n for n, of in outcome.dataset.data_vars.items() if of.size >= LARGE]
                    outcome = outcome._replace(dataset=outcome.dataset.drop_vars(large))
                file.add(run, outcome)
        failures = f", {len(failed):,} failed" if failed else ""
        summary = f"{len(journal):,} of {count:,} runs are complete{failures}"
        if not len(journal):
            raise InputError(
                f"{folder}: {summary}. Wait for the first complete run, or continue the sweep with"
                f" --resume. {' '.join(failed[:1])}".strip()
            )
        gathered = xr.load_dataset(path, engine="netcdf4", decode_times=False)
    return index_by_seed(gathered.assign_attrs({GATHERED: summary}))


def _expected_folder_text(folder: Path) -> str:
    """Suggestion for a user who gave another folder."""
    meant = sorted(part.parent.name for part in folder.glob(f"*{PARTIAL}/{FIRST_RUN_FILE}"))
    example = f"{folder / meant[0]}" if meant else "RUNS.nc.partial"
    more = f" (others here: {', '.join(meant)})" if len(meant) > 1 else ""
    way = f"the folder of an unfinished sweep, such as {example}{more}"
    return f"; expected the result of a run or of a study, or {way}"
