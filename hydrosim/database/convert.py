"""Writing a database in the format that the name of the file asks for."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from hydrosim.database import netcdf
from hydrosim.database.database import HydroDatabase
from hydrosim.database.readers import bemio, wamit
from hydrosim.errors import InputError

WRITERS: dict[str, Callable[[HydroDatabase, Path], None]] = {
    ".nc": netcdf.write,
    ".h5": bemio.write,
    ".1": lambda db, path: wamit.write(db, path.with_suffix("")),
}


def writable(path: Path) -> None:
    """Raises `InputError` where a database cannot be written to ``path``."""
    if path.suffix not in WRITERS:
        raise InputError(
            f"{path}: the suffix {path.suffix or '(none)'} is of no format that can be written;"
            f" expected one of {', '.join(WRITERS)}."
        )
    if path.is_dir():
        raise InputError(f"{path}: is a directory; expected a file such as {path}/database.nc.")
    if not path.parent.is_dir():
        raise InputError(f"{path}: there is no folder {path.parent}; make it first.")
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"{path}: the folder {path.parent} cannot be written to.")


def write(db: HydroDatabase, path: Path) -> list[Path]:
    """Write ``db``; the files, which are returned, appear under their names when all are complete.
    Raises `InputError` rather than write over the file that ``db`` was read from."""
    writable(path)
    with TemporaryDirectory(dir=path.parent, prefix=f".{path.name}.partial-") as folder:
        WRITERS[path.suffix](db, Path(folder) / path.name)
        parts = sorted(Path(folder).iterdir())
        files = [path.parent / part.name for part in parts]
        if _holds(files, Path(db.source)):
            raise InputError(f"{path}: is what is converted; expected another name.")
        for part, file in zip(parts, files, strict=True):
            part.replace(file)
    return files


def _holds(files: Sequence[Path], source: Path) -> bool:
    """Whether one of the files is the source, or may be one of the set that was read."""
    if source.resolve() in [file.resolve() for file in files]:
        return True
    of_set = [file for file in files if file.exists() and file.stem == source.stem]
    return len(files) > 1 and any(
        file.resolve().parent == source.resolve().parent for file in of_set
    )
