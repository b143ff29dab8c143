"""Files that are written: which may be replaced, and how they come to be, whole or not at all.

A file says in itself what it is and what it was made of, "hydrosim 0.1.0: run of [../base.yaml]":
netCDF and HDF5 in the attribute ``history``, pictures and pages in their metadata, text in its
heading. Paths begin at the folder of the file. Whoever makes the same again replaces it; all else
that exists stays, unless the user says otherwise; what is no plain file, or is read, stays. netCDF
says in the attribute ``settings`` what it was made with: a result of others is kept under another
name, so that a case can be edited and run again without an option, and without a loss.
"""

from __future__ import annotations

import json
import os
import re
import stat
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, replace
from glob import escape
from itertools import count
from pathlib import Path
from shutil import rmtree
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, NoReturn
from urllib.parse import quote
from zlib import crc32

from hydrosim.errors import InputError, unwritable
from hydrosim.interrupts import undisturbed
from hydrosim.locks import alone, is_gone, owner
from hydrosim.program import program_version

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MARK = re.compile(rb"hydrosim [^\s:]+: ([a-z -]+ of \[[\w.~/%-]+\])")
SEEN = 65536  # bytes at both ends of a file, of which one holds the mark
HDF5 = b"\x89HDF\r\n\x1a\n"
SHORT = 80  # bytes of a name that is part of a longer one
LONGEST = 200  # bytes of a name: those of files beside it are longer, and 255 is the most
SETTINGS = "settings"  # attribute of netCDF
LONG = 60  # characters of a value that is told
SHOWN = 3  # settings that differ, of which a message tells
KINDS = {stat.S_IFDIR: "a directory", stat.S_IFLNK: "a link", stat.S_IFIFO: "a pipe"}


@dataclass(frozen=True)
class Output:
    """A file to be written at ``path``: ``what`` it is ("run") of which file, its ``origin``.

    ``inputs`` are files that are read and must stay. ``option`` begins messages: it says who has
    chosen the path. ``settings`` are all that the result is made with (`settings_text`): an earlier
    one of other settings is kept under another name.
    """

    path: Path
    what: str
    origin: Path
    inputs: tuple[Path, ...] = ()
    overwrite: bool = False
    option: str = "--output"
    settings: str = ""

    @property
    def mark(self) -> str:
        """What the file says of itself."""
        return f"hydrosim {program_version()}: {self._content}"

    @property
    def attributes(self) -> dict[str, str]:
        """What a netCDF file says of itself."""
        settings = {SETTINGS: self.settings} if self.settings else {}
        return {"history": self.mark, **settings}

    @property
    def _content(self) -> str:
        origin = os.path.relpath(self.origin.resolve(), self.path.parent.resolve())
        return f"{self.what} of [{quote(Path(origin).as_posix())}]"

    def at(self, path: Path, what: str | None = None) -> Output:
        """Another file of the same origin."""
        return replace(self, path=path, what=what or self.what)

    def checked(self) -> Output:
        """Itself; raises InputError if it cannot be written or must not be replaced."""
        path = self.path
        folder = self.path.parent
        if (size := len(os.fsencode(path.name))) > LONGEST:
            self._refuse(f"{path} has a name of {size} bytes; expected {LONGEST} or fewer")
        if not os.path.isdir(folder):  # Path.is_dir raises where a name is too long
            self._refuse(f"there is no folder {folder}; make it first")
        if not os.access(folder, os.W_OK):
            self._refuse(f"the folder {folder} cannot be written to")
        try:
            kind = stat.S_IFMT(path.lstat().st_mode)
        except FileNotFoundError:
            return self
        except OSError as error:
            self._refuse(f"{path}: {error.strerror}")
        if kind != stat.S_IFREG:
            other = KINDS.get(kind, "a device or a socket")
            self._refuse(f"{path} is {other}, which is never replaced; expected a file")
        if not os.access(path, os.W_OK):
            self._refuse(f"{path} is protected from writing; expected another name")
        if self.reads_itself():
            self._refuse(f"{path} is read here and would be written over; expected another name")
        if not self.overwrite and content(path) != self._content:
            found = content(path)
            there = f"the {found}" if found else "no result of this program"
            self._refuse(
                f"{path} exists and is {there}; expected a new name, or that of an earlier"
                f" {self._content}. Give another name, or --overwrite to replace it"
            )
        return self

    def reads_itself(self) -> bool:
        """Whether it is one of its inputs."""
        return any(_same(self.path, file) for file in self.inputs)

    def aside(self) -> Output:
        """Where it goes if what stands there is better: to a name of its own that is free, or an
        earlier one of that name."""
        names = (f"{self.path.stem}.failed{k}{self.path.suffix}" for k in ("", *range(2, 100)))
        for name in names:
            with suppress(InputError):
                return replace(self.at(self.path.with_name(name)), overwrite=False).checked()
        return self.checked()

    def settled(self) -> Output:
        """Itself, or `aside` if something has come there that must not be replaced."""
        try:
            return self.checked()
        except InputError:
            return self.aside()

    @property
    def _beside(self) -> str:
        """How the names of files and folders begin that are beside it while it is made."""
        name = self.path.name
        whole = os.fsencode(name)
        return f".hydrosim-{name if len(whole) <= SHORT else f'{name[:20]}~{crc32(whole):08x}'}"

    @property
    def _room(self) -> str:
        """How the folders in which it is written begin; who writes comes next."""
        return f"{self._beside}-"

    def held(self) -> AbstractContextManager[None]:
        """Keeps other processes from making the same file meanwhile. Raises InputError if one of
        them does, and names it."""
        return alone(self.path.with_name(f"{self._beside}.lock"), self.path)

    def clear(self) -> None:
        """Remove it, if it says that it is what it is, and what was left where a program was killed
        as it wrote it."""
        if (content(self.path) or "").startswith(f"{self.what} of "):
            self.path.unlink()
        self._tidy()

    def _tidy(self) -> None:
        for room in self.path.parent.glob(f"{escape(self._room)}*"):
            if is_gone(room.name.removeprefix(self._room).rpartition("-")[0]):
                rmtree(room, ignore_errors=True)

    @contextmanager
    def written(self) -> Iterator[Path]:
        """A path to write to; what is there afterwards, with all files beside it, appears under its
        name. Signals that would end the program wait. Raises WritingError if it cannot be written:
        what was there then stays. What a killed process has left of it is removed."""
        self._tidy()
        mine = f"{self._room}{owner()}-"
        try:
            with undisturbed(), TemporaryDirectory(dir=self.path.parent, prefix=mine) as room:
                yield Path(room, self.path.name)
                parts = sorted(Path(room).iterdir())
                outputs = [self.at(self.path.parent / part.name).checked() for part in parts]
                for part in parts:
                    _to_disk(part)
                for part, output in zip(parts, outputs, strict=True):
                    output._put(part)
        except (OSError, RuntimeError) as error:  # netCDF and HDF5 raise RuntimeError
            raise unwritable(self.path, error) from None

    def take(self, path: Path) -> None:
        """Give a file that is complete, in the same file system, its name."""
        self.checked()
        _to_disk(path)
        self._put(path)

    def _put(self, part: Path) -> None:
        """Give a complete file its name. An earlier one of other settings is kept, and that is
        said."""
        if not self.overwrite and (said := _differences(settings_of(self.path), self.settings)):
            stem = self.path.stem
            suffix = self.path.suffix
            names = (self.path.with_name(f"{stem}.{k}{suffix}") for k in count(1))
            spare = next(name for name in names if not os.path.lexists(name))
            self.path.rename(spare)
            warnings.warn(
                f"{self.path} was made with other settings ({said}; in SI and radians). It is kept"
                f" as {spare.name}; --overwrite replaces it.",
                stacklevel=2,
            )
        part.replace(self.path)

    def _refuse(self, text: str) -> NoReturn:
        raise InputError(f"{self.option}: {text}.")


def make_folder(folder: Path) -> None:
    """Make a folder that files are to be written into; InputError if it cannot be made."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made as a folder ({error.strerror}).") from None


def as_output(target: Path | str | Output, what: str) -> Output:
    """What a caller from Python gives, a path or an output: a path holds ``what`` it held."""
    if isinstance(target, Output):
        return target
    return Output(Path(target), what, Path(target), option="output").checked()


def settings_text(*of: Mapping[str, Any]) -> str:
    """All values in nested mappings and lists, by dotted keys: what `Output.settings` are."""
    return json.dumps({key: value for values in of for key, value in _flat(values)})


def _flat(values: Any, above: str = "") -> Iterator[tuple[str, Any]]:
    if isinstance(values, Mapping):
        inside = [*values.items()]
    elif isinstance(values, list | tuple) and any(isinstance(v, Mapping | list) for v in values):
        inside = [*enumerate(values)]
    else:
        yield above, values
        return
    for key, value in inside:
        yield from _flat(value, f"{above}.{key}" if above else str(key))


def settings_of(path: Path) -> str:
    """What a netCDF file says that it was made with; nothing if it does not."""
    return _attribute(path, SETTINGS) if _is_hdf5(path) else ""


def _differences(before: str, now: str) -> str:
    """In which settings two files differ, in words; nothing if one of them is not known."""
    if not before or not now or before == now:
        return ""
    one = json.loads(before)
    other = json.loads(now)
    keys = [key for key in {**one, **other} if one.get(key) != other.get(key)]
    told = [f"{key} {_shown(one, key)}, now {_shown(other, key)}" for key in keys[:SHOWN]]
    more = [f"and {len(keys) - SHOWN} more"] if len(keys) > SHOWN else []
    return "; ".join([*told, *more])


def _shown(values: Mapping[str, Any], key: str) -> str:
    value = values.get(key, "not given")
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return text if len(text) <= LONG else f"{text[:LONG]}..."


def content(path: Path) -> str | None:
    """What a file says that it is: "run of [base.yaml]"; None if no hydrosim has made it."""
    hdf5 = _is_hdf5(path)
    try:
        with path.open("rb") as file:
            ends = file.read(SEEN)
            if not hdf5 and path.stat().st_size > SEEN:
                file.seek(max(SEEN, path.stat().st_size - SEEN))
                ends += file.read()
    except OSError:
        return None
    found = MARK.fullmatch(_attribute(path, "history").encode()) if hdf5 else MARK.search(ends)
    return found[1].decode() if found else None


def save_picture(figure: Figure, target: Path | Output, **options: Any) -> Path:
    """Write a figure of matplotlib in the format of the suffix; its path."""
    output = as_output(target, "picture")
    key = "Software" if output.path.suffix == ".png" else "Creator"
    with output.written() as path:
        figure.savefig(path, metadata={key: output.mark}, **options)
    return output.path


def files_named(values: object, folder: Path) -> Iterator[Path]:
    """The files that any text in nested ``values`` names, from ``folder`` on."""
    if isinstance(values, str | Path):
        with suppress(OSError, ValueError):
            if (path := folder / values).is_file():
                yield path
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


def _attribute(path: Path, name: str) -> str:
    """A text among the attributes of a netCDF or HDF5 file; nothing if it cannot be read. netCDF's
    library, asked for a file that it failed to write, prints all that it has open."""
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


def _same(one: Path, other: Path) -> bool:
    with suppress(OSError):
        return one.samefile(other)
    return False


def _to_disk(path: Path) -> None:
    """Waits until the file is on the disk, so that a disk that is full says so now."""
    with path.open("rb") as file:
        os.fsync(file.fileno())
