"""Files that stand beside a result until it is complete: nothing of others is touched among them.

A folder of such files is taken up, or removed, if all that is in it has a name that this program
gives and a mark that it writes. Links are not followed.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from hydrosim.errors import InputError
from hydrosim.outputs import HDF5, content

IsOwn = Callable[[Path], bool]
"""Whether a path in a folder is one that this program has made there."""


def check_folder(folder: Path, is_own: IsOwn) -> None:
    """Raises InputError if the folder is there and is a link, is no folder, or holds anything that
    is not ``is_own``."""
    if not os.path.lexists(folder):
        return
    if not is_folder(folder):
        found = "a link" if folder.is_symlink() else "no folder"
        raise InputError(
            f"{folder}: is {found}; expected nothing, or the folder in which this program keeps"
            " runs until all are done. Move it away, or give the result another name."
        )
    for path in sorted(folder.iterdir()):
        if not is_own(path):
            found = "a link" if path.is_symlink() else "no file of this program, or damaged"
            raise InputError(
                f"{path}: is {found}; expected in {folder} what this program keeps there until all"
                " runs are done. Move it away, or give the result another name."
            )


def remove_folder(folder: Path, is_own: IsOwn) -> None:
    """Remove the files in the folder that are ``is_own``, then the folder if nothing is left."""
    for path in folder.iterdir() if is_folder(folder) else ():
        if is_own(path) and not path.is_dir():
            path.unlink()
    with suppress(OSError):
        folder.rmdir()


def is_folder(path: Path) -> bool:
    """Whether a path is a folder and no link to one."""
    return path.is_dir() and not path.is_symlink()


def is_plain(path: Path) -> bool:
    """Whether a path is a plain file and no link to one."""
    return path.is_file() and not path.is_symlink()


def is_marked(path: Path, what: str) -> bool:
    """Whether a plain file says that it is ``what`` ("sweep"). netCDF that a killed process has
    left, or of which a bit has changed, can say nothing: it counts as marked."""
    if not is_plain(path):
        return False
    said = content(path)
    return said.startswith(f"{what} of ") if said else _says_nothing(path)


def _says_nothing(path: Path) -> bool:
    """Whether a file is netCDF that cannot be read, or has not been begun. netCDF's library, asked
    for a file that it failed to write, prints all that it has open."""
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
