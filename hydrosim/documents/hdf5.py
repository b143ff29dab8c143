"""Whether an HDF5 file is whole. netCDF's library keeps open what it fails to read, and may bring
the whole process down when it is asked again; h5py tells before."""

from __future__ import annotations

from pathlib import Path

import h5py

MAGIC = b"\x89HDF"


def fault(path: Path) -> str | None:
    """What is wrong with the structure of a file, None if nothing; sizes and attributes of all
    that it holds are read, data are not."""
    try:
        with h5py.File(path) as file:
            dict(file.attrs)
            file.visititems(_touch)
    except (OSError, RuntimeError, KeyError, TypeError, ValueError, OverflowError) as error:
        return str(error)
    return None


def _touch(name: str, item: h5py.Group | h5py.Dataset) -> None:
    dict(item.attrs)
    if isinstance(item, h5py.Dataset):
        _ = item.shape, item.dtype
