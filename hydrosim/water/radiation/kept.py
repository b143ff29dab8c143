"""Arrays stored on disk, so that slow computations run once.

A damaged file is made again, see `hydrosim.files.cache`. Results for the databases of the shipped
cases come with the package, see `hydrosim.water.radiation.ship`.
"""

from __future__ import annotations

import hashlib
import zlib
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any, TypeVar
from zipfile import BadZipFile, ZipFile

import numpy as np

from hydrosim.files.cache import PACKAGE, SHIPPED_FITS, digest_of_sources, store, stored

Arrays = Mapping[str, np.ndarray]
T = TypeVar("T")
WITHOUT_FITS = (
    "__init__.py",
    "convolution.py",
    "history.py",
    "kept.py",
    "ship.py",
    "threads.py",
)
"""Modules that compute nothing that is stored."""


def read_or_make(
    kind: str,
    settings: tuple[object, ...],
    make: Callable[[], T],
    to_arrays: Callable[[T], Arrays],
    of_arrays: Callable[[Arrays], T],
) -> T:
    """The result of ``make`` for the ``settings``, or the stored one from the folder ``kind`` of
    the cache or of `SHIPPED_FITS`.

    The file's name is a hash of the settings and of the sources that compute. So the settings must
    include everything that the content depends on.
    """
    key = hashlib.sha256(repr((*settings, _version())).encode()).hexdigest()[:24]
    name = f"{kind}/{key}.npz"
    content = stored(name) or read_shipped(name)
    if content is not None:
        with np.load(BytesIO(content), allow_pickle=False) as arrays:
            return of_arrays(dict(arrays))
    result = make()
    file = BytesIO()
    np.savez(file, **dict[str, Any](to_arrays(result)))
    store(name, file.getvalue())
    return result


def read_shipped(name: str, archive: Path = SHIPPED_FITS) -> bytes | None:
    """The content of ``name`` in an ``archive``; None if it is not there, or is damaged."""
    with suppress(KeyError, OSError, BadZipFile, zlib.error), ZipFile(archive) as entries:
        return entries.read(name)
    return None


@cache
def _version() -> str:
    """Hash of the sources that compute results: a change of the computation changes the file."""
    home = PACKAGE / "water" / "radiation"
    computing = {path.name for path in home.glob("*.py")} - {*WITHOUT_FITS}
    return digest_of_sources(home, *sorted(computing))
