"""Arrays kept on disk, so that what takes long to compute is computed once.

A file is believed if it carries the digest of its own content; any other is made again. A folder
that cannot be written costs only the time of the next time.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from hydrosim.cache import cache_root, store

Arrays = Mapping[str, np.ndarray]
T = TypeVar("T")

DIGEST = "digest"


def kept(
    kind: str,
    settings: tuple[object, ...],
    make: Callable[[], T],
    to_arrays: Callable[[T], Arrays],
    of_arrays: Callable[[Arrays], T],
) -> T:
    """What ``make`` makes of the ``settings``, or the same from the folder ``kind`` of the cache.

    The settings, and this package's sources, are the file's name: they must say all that the
    content depends on.
    """
    key = hashlib.sha256(repr((*settings, _version())).encode()).hexdigest()[:24]
    path = cache_root() / kind / f"{key}.npz"
    with suppress(Exception):  # a damaged file may raise anything
        return of_arrays(_read(path))
    made = make()
    with suppress(OSError):
        _write(path, to_arrays(made))
    return made


@lru_cache
def _version() -> str:
    """Hash of this package's sources: another way of computing is another file."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _read(path: Path) -> Arrays:
    """The arrays in a file; raises where they are not what was written."""
    with np.load(path, allow_pickle=False) as data:
        arrays = dict(data)
    if str(arrays.pop(DIGEST)) != _digest(arrays):
        raise ValueError(f"{path}: is damaged")
    return arrays


def _write(path: Path, arrays: Arrays) -> None:
    content: dict[str, Any] = {**arrays, DIGEST: np.array(_digest(arrays))}
    store(path, lambda file: np.savez(file, **content))


def _digest(arrays: Arrays) -> str:
    """SHA-256 (hex) over names, types, shapes and numbers."""
    digest = hashlib.sha256()
    for name, value in sorted(arrays.items()):
        array = np.ascontiguousarray(value)
        digest.update(f"{name} {value.shape} {array.dtype.str}".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()
