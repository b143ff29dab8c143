"""Write a database; the suffix of the file selects the format."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from glob import escape
from pathlib import Path

from hydrosim.database import netcdf
from hydrosim.database.database import HydroDatabase
from hydrosim.database.readers import bemio, wamit
from hydrosim.errors import InputError
from hydrosim.outputs import Output, as_output

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
