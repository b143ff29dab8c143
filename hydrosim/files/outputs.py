"""Output files: which files may be replaced, and how a file appears complete or not at all.

A file states what it is and its origin: "hydrosim 0.1.0: run of [../base.yaml]". netCDF and HDF5
have this text in the attribute ``history``, pictures and pages in their metadata, text in its
heading. Paths are relative to the folder of the file. A new result may replace an earlier one of
the same kind and origin. All other files are kept, unless the user gives --overwrite; inputs and
special files are always kept. netCDF has its settings in the attribute ``settings``. An earlier
result of other settings is kept under another name, so a case can be edited and run again without a
loss.

A folder beside an unfinished result is continued or removed only if each file in it has a name and
a mark that this program writes. Files of others are never touched, and links are not followed.
"""

from __future__ import annotations

import json
import os
import re
import stat
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, fields, is_dataclass, replace
from glob import escape
from itertools import count
from pathlib import Path
from shutil import rmtree
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, NoReturn
from urllib.parse import quote
from zlib import crc32

from hydrosim.errors import InputError, unwritable
from hydrosim.files.cache import program_version
from hydrosim.files.interrupts import delay_interrupts
from hydrosim.files.locks import file_lock, is_dead_process, this_process

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MARK = re.compile(rb"hydrosim [^\s:]+: ([a-z -]+ of \[[\w.~/%-]+\])")
MARK_SEARCH_BYTES = 65536  # bytes at both ends of a file; one of them holds the mark
HDF5 = b"\x89HDF\r\n\x1a\n"
MAX_PART_BYTES = 80  # bytes of a name that is part of a longer one
MAX_NAME_BYTES = 200  # bytes of a name: files beside it have longer names, and 255 is the limit
SETTINGS = "settings"  # attribute of netCDF
MAX_VALUE_CHARACTERS = 60  # characters of a value in a message
MAX_SETTINGS_TOLD = 3  # different settings in a message
SPECIAL_FILES = {stat.S_IFDIR: "a directory", stat.S_IFLNK: "a link", stat.S_IFIFO: "a pipe"}


@dataclass(frozen=True)
class Output:
    """A file to be written at ``path``: ``what`` it is ("run"), made of the file ``origin``.

    ``inputs`` are files that must not be replaced. ``option`` begins messages and names where the
    path was given. ``settings`` are all settings of the result (`settings_text`). An earlier result
    of other settings is kept under another name.
    """

    path: Path
    what: str
    origin: Path
    inputs: tuple[Path, ...] = ()
    overwrite: bool = False
    option: str = "--output"
    settings: str = ""

    def __fspath__(self) -> str:
        """The path."""
        return os.fspath(self.path)

    @property
    def mark(self) -> str:
        """Text that describes the file in itself."""
        return f"hydrosim {program_version()}: {self._content}"

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes that describe a netCDF file in itself."""
        settings = {SETTINGS: self.settings} if self.settings else {}
        return {"history": self.mark, **settings}

    @property
    def _content(self) -> str:
        origin = os.path.relpath(self.origin.resolve(), self.path.parent.resolve())
        return f"{self.what} of [{quote(Path(origin).as_posix())}]"

    def output_at(self, path: Path, what: str | None = None) -> Output:
        """Output of the same origin at another path."""
        return replace(self, path=path, what=what or self.what)

    def checked_output(self) -> Output:
        """Return the output; raises InputError if it cannot be written or must not be replaced."""
        path = self.path
        folder = self.path.parent
        if (size := len(os.fsencode(path.name))) > MAX_NAME_BYTES:
            self._refuse(f"{path} has a name of {size} bytes; expected {MAX_NAME_BYTES} or fewer")
        if not os.path.isdir(folder):  # Path.is_dir raises where a name is too long
            self._refuse(f"there is no folder {folder}; make it first")
        if not os.access(folder, os.W_OK):
            self._refuse(f"the folder {folder} is not writable")
        try:
            kind = stat.S_IFMT(path.lstat().st_mode)
        except FileNotFoundError:
            return self
        except OSError as error:
            self._refuse(f"{path}: {error.strerror}")
        if kind != stat.S_IFREG:
            other = SPECIAL_FILES.get(kind, "a device or a socket")
            self._refuse(f"{path} is {other}, which is never replaced; expected a file")
        if not os.access(path, os.W_OK):
            self._refuse(f"{path} is write-protected; expected another name")
        if self.is_own_input():
            self._refuse(f"{path} is an input and would be overwritten; expected another name")
        if not self.overwrite and content(path) != self._content:
            mark = content(path)
            there = f"the {mark}" if mark else "not a result of this program"
            self._refuse(
                f"{path} exists and is {there}; expected a new name, or the name of an earlier"
                f" {self._content}. Give another name, or replace it with --overwrite"
            )
        return self

    def is_own_input(self) -> bool:
        """Whether the path is one of the inputs."""
        return any(_is_same_file(self.path, file) for file in self.inputs)

    def fallback_path(self) -> Output:
        """Output at another path if the existing file is better: at a free name, or at the name of
        an earlier such file."""
        names = (f"{self.path.stem}.failed{k}{self.path.suffix}" for k in ("", *range(2, 100)))
        for name in names:
            with suppress(InputError):
                return replace(
                    self.output_at(self.path.with_name(name)), overwrite=False
                ).checked_output()
        return self.checked_output()

    def resolve_path(self) -> Output:
        """The output, or `fallback_path` if a file has appeared that must not be replaced."""
        try:
            return self.checked_output()
        except InputError:
            return self.fallback_path()

    @property
    def _temporary_prefix(self) -> str:
        """Prefix of temporary files and folders beside the output."""
        name = self.path.name
        whole = os.fsencode(name)
        short = name if len(whole) <= MAX_PART_BYTES else f"{name[:20]}~{crc32(whole):08x}"
        return f".hydrosim-{short}"

    @property
    def _temporary_folder_prefix(self) -> str:
        """Prefix of temporary folders for writing; the name of the process follows."""
        return f"{self._temporary_prefix}-"

    def hold_lock(self) -> AbstractContextManager[None]:
        """Keep other processes from writing the same file. Raises InputError that names such a
        process."""
        return file_lock(self.path.with_name(f"{self._temporary_prefix}.lock"), self.path)

    def clear(self) -> None:
        """Remove an earlier file of the same kind, and remains of a killed process."""
        if (content(self.path) or "").startswith(f"{self.what} of "):
            self.path.unlink()
        self._remove_leftovers()

    def _remove_leftovers(self) -> None:
        for room in self.path.parent.glob(f"{escape(self._temporary_folder_prefix)}*"):
            if is_dead_process(
                room.name.removeprefix(self._temporary_folder_prefix).rpartition("-")[0]
            ):
                rmtree(room, ignore_errors=True)

    @contextmanager
    def write_complete(self) -> Iterator[Path]:
        """Yield a path to write to; then rename it, with all files beside it, to the final name.
        Signals that would end the program wait. Raises WritingError if the file cannot be written;
        an earlier file is then unchanged. Remains of a killed process are removed."""
        self._remove_leftovers()
        mine = f"{self._temporary_folder_prefix}{this_process()}-"
        try:
            with delay_interrupts(), TemporaryDirectory(dir=self.path.parent, prefix=mine) as room:
                yield Path(room, self.path.name)
                parts = sorted(Path(room).iterdir())
                outputs = [
                    self.output_at(self.path.parent / part.name).checked_output() for part in parts
                ]
                for part in parts:
                    _flush_to_disk(part)
                for part, output in zip(parts, outputs, strict=True):
                    output._put_file(part)
        except (OSError, RuntimeError) as error:  # netCDF and HDF5 raise RuntimeError
            raise unwritable(self.path, error) from None

    def take(self, path: Path) -> None:
        """Rename a complete file of the same file system to its final name."""
        self.checked_output()
        _flush_to_disk(path)
        self._put_file(path)

    def _put_file(self, part: Path) -> None:
        """Rename a complete file to its final name. An earlier file of other settings is kept, with
        a warning."""
        if not self.overwrite and (
            differences := _differing_keys(settings_of(self.path), self.settings)
        ):
            stem = self.path.stem
            suffix = self.path.suffix
            names = (self.path.with_name(f"{stem}.{k}{suffix}") for k in count(1))
            spare = next(name for name in names if not os.path.lexists(name))
            self.path.rename(spare)
            warnings.warn(
                f"{self.path} was made with other settings ({differences}; in SI and radians). It"
                f" is kept as {spare.name}; --overwrite replaces it instead.",
                stacklevel=2,
            )
        part.replace(self.path)

    def _refuse(self, text: str) -> NoReturn:
        raise InputError(f"{self.option}: {text}.")


def make_folder(folder: Path) -> None:
    """Make a folder for files. Raises InputError if it cannot be made."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: the folder cannot be made ({error.strerror}).") from None


def as_output(target: str | os.PathLike[str], what: str) -> Output:
    """Output of a path or an output given in Python. A plain path may replace an earlier file of
    the same kind."""
    if isinstance(target, Output):
        return target
    return Output(Path(target), what, Path(target), option="output").checked_output()


def settings_text(*of: Mapping[str, Any]) -> str:
    """All values in nested mappings and lists, by dotted keys, as JSON: `Output.settings`."""
    return json.dumps({key: value for values in of for key, value in _flatten(values)})


def _flatten(values: Any, above: str = "") -> Iterator[tuple[str, Any]]:
    if isinstance(values, Mapping):
        inside = [*values.items()]
    elif isinstance(values, list | tuple) and any(isinstance(v, Mapping | list) for v in values):
        inside = [*enumerate(values)]
    else:
        yield above, values
        return
    for key, value in inside:
        yield from _flatten(value, f"{above}.{key}" if above else str(key))


def settings_of(path: Path) -> str:
    """Settings in a netCDF file; empty if it has none."""
    return read_attribute(path, SETTINGS) if _is_hdf5(path) else ""


def _differing_keys(before: str, now: str) -> str:
    """Differences between the settings of two files, as text; empty if either is unknown."""
    if not before or not now or before == now:
        return ""
    try:
        settings_before = dict(json.loads(before))
    except (ValueError, TypeError):  # the file was changed after it was written
        return "settings that cannot be read"
    other = json.loads(now)
    keys = [
        key for key in {**settings_before, **other} if settings_before.get(key) != other.get(key)
    ]
    told = [
        f"{key} {_value_text(settings_before, key)}, now {_value_text(other, key)}"
        for key in keys[:MAX_SETTINGS_TOLD]
    ]
    more = [f"and {len(keys) - MAX_SETTINGS_TOLD} more"] if len(keys) > MAX_SETTINGS_TOLD else []
    return "; ".join([*told, *more])


def _value_text(values: Mapping[str, Any], key: str) -> str:
    value = values.get(key, "not given")
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return text if len(text) <= MAX_VALUE_CHARACTERS else f"{text[:MAX_VALUE_CHARACTERS]}..."


def content(path: Path) -> str | None:
    """Description that a file states: "run of [base.yaml]"; None if hydrosim did not make it."""
    hdf5 = _is_hdf5(path)
    try:
        with path.open("rb") as file:
            ends = file.read(MARK_SEARCH_BYTES)
            if not hdf5 and path.stat().st_size > MARK_SEARCH_BYTES:
                file.seek(max(MARK_SEARCH_BYTES, path.stat().st_size - MARK_SEARCH_BYTES))
                ends += file.read()
    except OSError:
        return None
    match = MARK.fullmatch(read_attribute(path, "history").encode()) if hdf5 else MARK.search(ends)
    return match[1].decode() if match else None


def save_picture(figure: Figure, target: Path | Output, **options: Any) -> Path:
    """Write a figure of matplotlib in the format of the suffix; return its path."""
    output = as_output(target, "picture")
    is_png = output.path.suffix == ".png"
    key = "Software" if is_png else "Creator"
    engine = figure.get_layout_engine()
    if is_png and engine is not None and not options:  # otherwise matplotlib draws it twice
        engine.execute(figure)
        figure.set_layout_engine(None)
    with output.write_complete() as path:
        figure.savefig(path, metadata={key: output.mark}, **options)
    return output.path


def files_named(values: object, folder: Path) -> Iterator[Path]:
    """Existing files named by texts in nested ``values``, relative to ``folder``."""
    if isinstance(values, str | Path):
        with suppress(OSError, ValueError):
            if (path := folder / values).is_file():
                yield path
    elif is_dataclass(values):
        yield from files_named([getattr(values, field.name) for field in fields(values)], folder)
    elif isinstance(values, dict):
        for value in values.values():
            yield from files_named(value, folder)
    elif isinstance(values, Iterable):
        for value in values:
            yield from files_named(value, folder)


def _is_hdf5(path: Path) -> bool:
    with suppress(OSError), path.open("rb") as file:
        return file.read(len(HDF5)) == HDF5
    return False


def read_attribute(path: Path, name: str) -> str:
    """Text attribute of a netCDF or HDF5 file; empty if it cannot be read. It is read by h5py,
    because the library of netCDF prints all its open files after a failed write."""
    import h5py

    try:
        with h5py.File(path) as file:
            value = file.attrs.get(name, "")
            value = value.item() if getattr(value, "size", None) == 1 else value
    except (OSError, RuntimeError, KeyError, ValueError, TypeError):
        return ""
    if isinstance(value, bytes):
        return value.decode(errors="replace")
    return value if isinstance(value, str) else ""


def _is_same_file(first: Path, second: Path) -> bool:
    with suppress(OSError):
        return first.samefile(second)
    return False


def _flush_to_disk(path: Path) -> None:
    """Wait until the file is on the disk, so that a full disk is reported now."""
    with path.open("rb") as file:
        os.fsync(file.fileno())


# Folders beside an unfinished result.

IsOwn = Callable[[Path], bool]
"""Test whether this program made a path in a folder."""


def check_folder(folder: Path, is_own: IsOwn) -> None:
    """Raises InputError if the path is a link, is no folder, or holds a file that is not
    ``is_own``."""
    if not os.path.lexists(folder):
        return
    if not is_folder(folder):
        file_kind = "a link" if folder.is_symlink() else "no folder"
        raise InputError(
            f"{folder}: is {file_kind}; expected no file, or the folder in which this program keeps"
            " finished runs. Move it away, or give the result another name."
        )
    for path in sorted(folder.iterdir()):
        if not is_own(path):
            file_kind = "a link" if path.is_symlink() else "not a file of this program, or damaged"
            raise InputError(
                f"{path}: is {file_kind}; expected only files of this program in {folder}, where it"
                " keeps finished runs. Move it away, or give the result another name."
            )


def remove_folder(folder: Path, is_own: IsOwn) -> None:
    """Remove the files of the folder that are ``is_own``, then the folder if it is empty."""
    for path in folder.iterdir() if is_folder(folder) else ():
        if is_own(path) and not path.is_dir():
            path.unlink()
    with suppress(OSError):
        folder.rmdir()


def is_folder(path: Path) -> bool:
    """Whether a path is a folder, not a link to one."""
    return path.is_dir() and not path.is_symlink()


def is_regular_file(path: Path) -> bool:
    """Whether a path is a plain file, not a link to one."""
    return path.is_file() and not path.is_symlink()


def has_mark(path: Path, what: str) -> bool:
    """Whether a plain file is marked as ``what`` ("sweep"). netCDF that a killed process left, or
    that is damaged, has no readable mark: it counts as marked."""
    if not is_regular_file(path):
        return False
    mark = content(path)
    return mark.startswith(f"{what} of ") if mark else _is_unreadable_netcdf(path)


def _is_unreadable_netcdf(path: Path) -> bool:
    """Whether a file is netCDF that cannot be read or is still empty. It is read by h5py, because
    the library of netCDF prints all its open files after a failed write."""
    import h5py

    with path.open("rb") as file:
        begins = file.read(len(HDF5))
    if begins not in (HDF5, b"") and begins.strip(b"\0"):
        return False
    try:
        with h5py.File(path) as file:
            dict(file.attrs)
            file.visititems(lambda _, item: dict(item.attrs) and None)
    except (OSError, RuntimeError, KeyError, TypeError, ValueError):
        return True
    return False
