"""Files to read. Opening a pipe or a device would wait without end, so only plain files are
accepted."""

from __future__ import annotations

import os
import stat
from functools import lru_cache
from pathlib import Path
from time import time_ns
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import h5py


def no_file(path: Path) -> str:
    """Reason why a path cannot be read, in words; empty if it is a plain file."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return "there is no such file"
    except (OSError, ValueError) as error:  # a name that is too long, or no valid name
        return f"cannot be read ({getattr(error, 'strerror', None) or error})"
    if stat.S_ISDIR(mode):
        return "is a directory"
    if not stat.S_ISREG(mode):
        return "is a pipe or a device, not a file"
    return "" if os.access(path, os.R_OK) else "may not be read"


# Test whether an HDF5 file is complete. netCDF's library keeps a file open that it fails to read.
# It may crash the whole process at the next attempt; h5py detects the damage first. A file must be
# complete by itself: links to other files are refused.

MAGIC = b"\x89HDF"
# ns: the times of a file that has just changed may not show the next change
SETTLED = 10_000_000_000


def fault(path: Path) -> str | None:
    """Fault in the structure of a file, None if it has none. Sizes and attributes of everything in
    the file are read, data are not. The result is cached until the file changes."""
    try:
        status = path.stat()
    except OSError as error:
        return str(error)
    changes = status.st_mtime_ns, status.st_ctime_ns
    if time_ns() - max(changes) < SETTLED:
        return _fault(path)
    return _stored_fault(path.absolute(), status.st_ino, status.st_size, *changes)


@lru_cache(maxsize=64)
def _stored_fault(path: Path, *state: int) -> str | None:
    """Fault of the file in this state."""
    return _fault(path)


def _fault(path: Path) -> str | None:
    import h5py  # slow to load, and dry scenes have no databases

    try:
        with h5py.File(path) as file:
            _touch("/", file)
            file.visititems(_touch)
    except (OSError, RuntimeError, KeyError, TypeError, ValueError, OverflowError) as error:
        return str(error)
    return None


def _touch(name: str, item: h5py.Group | h5py.Dataset) -> None:
    import h5py

    dict(item.attrs)
    if isinstance(item, h5py.Dataset):
        _ = item.shape, item.dtype
        outside = bool(item.external) or item.is_virtual
    else:
        links = (item.get(key, getlink=True) for key in item)
        outside = any(isinstance(link, h5py.ExternalLink) for link in links)
    if outside:
        raise ValueError(f"{name} points to another file; links to files are not followed")
