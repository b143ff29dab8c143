"""Database files: `load` reads and checks one, `write` writes one."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import fields, replace
from glob import escape
from pathlib import Path

import numpy as np

from hydrosim.database import netcdf
from hydrosim.database.changes import apply_changes
from hydrosim.database.checks import EVERYTHING, doubt_warnings, require_ascending
from hydrosim.database.database import HydroDatabase
from hydrosim.database.readers import READERS, Reader, bemio, wamit
from hydrosim.database.readers.orcaflex import NAME as DRAUGHTS
from hydrosim.errors import InputError
from hydrosim.files.outputs import Output, as_output
from hydrosim.files.text import unreadable_reason
from hydrosim.scene import Changes
from hydrosim.scene.hydrodynamics import NOTHING_GIVEN, POINTS_UNKNOWN, Given

HEAD_BYTES = 4096  # bytes by which a format is recognised
NOTHING_CHANGED = Changes()
NOT_READ = {  # files beside databases, or files of programs without a reader
    ".lis": "a listing of AQWA, which is read beside an .AH1 file; give the .AH1 file",
    ".in": "an input file, such as that of HAMS; give its Output/Wamit_format/NAME.1",
    ".dat": "an input file, such as that of HydroDyn; give the .1 file that its PotFile names",
    ".ss": "a state-space model; give the .1 file of the same hull",
    ".4": "motions of WAMIT; give the .1 file of the same hull",
    ".owr": "results of OrcaWave; load them into OrcaFlex and save its text data file (.yml)",
    ".rao": "a table without the header of HydroStar; let HydroStar write WAMIT's format",
    ".tec": "a table for Tecplot that belongs to no Nemoh project",
}


def load(
    path: Path | str, given: Given = NOTHING_GIVEN, changes: Changes = NOTHING_CHANGED
) -> HydroDatabase:
    """Read and check the database in the file ``path``, of any format that `readers` know, with
    ``changes``.

    Raises `InputError` if the file is missing, no database, incomplete, or so inconsistent that a
    sign, unit or convention must be wrong. Milder findings are warnings.
    """
    given = given.with_values(frequencies=changes.frequencies)
    db = apply_changes(require_ascending(read(path, given)), changes)
    if POINTS_UNKNOWN in db.attributes.get("assumed", ""):
        raise InputError(
            f"{path}: found no points of rotation (Capytaine's rotation_center); expected one for"
            f" each body. Give x, y and z of each as reference_point, in `hydrodynamics: {{file:"
            f" ...}}` of a case or with --given. In Capytaine it is the rotation_center or, if"
            " that was not set, the center_of_mass."
        )
    for doubt in doubt_warnings(db, EVERYTHING):
        warnings.warn(doubt, stacklevel=2)
    return db


def read(path: Path | str, given: Given = NOTHING_GIVEN) -> HydroDatabase:
    """Database in the file ``path``, unchecked. A name without suffix means the files with that
    name; the first that a reader recognises is read."""
    reader, file = recognise(path)
    if given.draught is not None and reader.NAME != DRAUGHTS:
        raise InputError(
            f"{path}: draught: found {given.draught}, but a file of {reader.NAME} has only one"
            " draught. Leave the draught out, and give the file for that draught."
        )
    return reader.read(file, given)


def overruled_values(db: HydroDatabase, given: Given) -> list[str]:
    """Names of ``given`` values that are not used because the file has other values."""
    return [
        item.name
        for item in fields(Given)
        if getattr(given, item.name) is not None
        and hasattr(db, item.name)
        and not np.array_equal(
            np.ravel(getattr(db, item.name)), np.ravel(getattr(given, item.name))
        )
    ]


def recognise(path: Path | str) -> tuple[Reader, Path]:
    """Reader of ``path``, and the file to read. Raises `InputError` if it is missing or of no known
    format."""
    path = Path(path)
    for file in _files_of_database(path):
        head = _first_bytes(file)
        for reader in READERS:
            if reader.sniff(file, head):
                return reader, file
    names = ", ".join(reader.NAME for reader in READERS)
    if what := NOT_READ.get(path.suffix.lower()):
        raise InputError(f"{path}: found {what}; expected one of {names}.")
    raise InputError(f"{path}: found a file of no known format; expected one of {names}.")


def _files_of_database(path: Path) -> list[Path]:
    """The file itself, or files with its name and any suffix."""
    reason = unreadable_reason(path)
    if not reason:
        return [path]
    named = sorted(path.parent.glob(f"{escape(path.name)}.*")) if path.name else []
    files = [file for file in named if not unreadable_reason(file)]
    if not files:
        raise InputError(f"{path}: {reason}; expected a hydrodynamic database.")
    return files


def _first_bytes(file: Path) -> bytes:
    try:
        with file.open("rb") as opened:
            return opened.read(HEAD_BYTES).removeprefix(b"\xef\xbb\xbf")  # of UTF-8
    except OSError as error:
        raise InputError(f"{file}: cannot be read ({error.strerror}).") from None


# `write`: the suffix of the file selects the format.

WRITERS: dict[str, Callable[[HydroDatabase, Path], None]] = {
    ".nc": netcdf.write,
    ".h5": bemio.write,
    ".1": lambda db, path: wamit.write(db, path.with_suffix("")),
}
ONE_FILE_SUFFIXES = {".nc", ".h5"}  # formats of one file


def format_of(path: Path) -> str:
    """Suffix of ``path``. Raises `InputError` if no database can be written with it."""
    if path.suffix not in WRITERS:
        raise InputError(
            f"{path}: found the suffix {path.suffix or '(none)'}; expected one of"
            f" {', '.join(WRITERS)}."
        )
    return path.suffix


def set_of(path: Path) -> list[Path]:
    """A database file, and files in its folder with its name that may be read with it."""
    if path.suffix in ONE_FILE_SUFFIXES:
        return [path]
    beside = path.parent.glob(f"{escape(path.stem)}.*")
    return [path, *(file for file in beside if file.suffix not in ONE_FILE_SUFFIXES)]


def write(db: HydroDatabase, target: Path | Output) -> list[Path]:
    """Write ``db`` and return the paths. The files appear under their names when all are complete.
    Raises `InputError` if one would replace a file that must be kept."""
    output = as_output(target, "database")
    marked = replace(db, attributes={**db.attributes, **output.attributes})
    with output.write_complete() as path:
        WRITERS[format_of(path)](marked, path)
        names = sorted(part.name for part in path.parent.iterdir())
    return [output.path.parent / name for name in names]
