"""Files beside an unfinished result. Files of others among them are never touched.

A folder of such files is continued or removed only if each file in it has a name and a mark that
this program writes. Links are not followed.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from hydrosim.errors import InputError
from hydrosim.outputs import HDF5, content

IsOwn = Callable[[Path], bool]
"""Test whether this program made a path in a folder."""


def check_folder(folder: Path, is_own: IsOwn) -> None:
    """Raises InputError if the path is a link, is no folder, or holds a file that is not
    ``is_own``."""
    if not os.path.lexists(folder):
        return
    if not is_folder(folder):
        found = "a link" if folder.is_symlink() else "no folder"
        raise InputError(
            f"{folder}: is {found}; expected no file, or the folder in which this program keeps"
            " finished runs. Move it away, or give the result another name."
        )
    for path in sorted(folder.iterdir()):
        if not is_own(path):
            found = "a link" if path.is_symlink() else "not a file of this program, or damaged"
            raise InputError(
                f"{path}: is {found}; expected only files of this program in {folder}, where it"
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
    said = content(path)
    return said.startswith(f"{what} of ") if said else _says_nothing(path)


def _says_nothing(path: Path) -> bool:
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
