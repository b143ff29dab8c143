"""Results of long computations, stored on the disk under a hash of all their inputs."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable
from io import BytesIO
from typing import Any

import numpy as np

from hydrosim.cache import store, stored


def key_of(*parts: str | bytes | float | np.ndarray) -> str:
    """Hash (hex) of numbers and texts; it changes with any bit of them."""
    digest = hashlib.sha256()
    for part in parts:
        if isinstance(part, np.ndarray):
            digest.update(f"{part.shape}{part.dtype.str}".encode())
            part = np.ascontiguousarray(part).tobytes()
        data = part if isinstance(part, bytes) else repr(part).encode()
        digest.update(f"{len(data)}:".encode() + data)
    return digest.hexdigest()


def entry_name(key: str) -> str:
    """Name in the cache of what is stored under ``key``."""
    return f"potential-flow/{key[:32]}.npz"


def remembered(key: str, compute: Callable[[], Iterable[Any]]) -> list[np.ndarray]:
    """Arrays stored under ``key``; if there are none, they are computed and stored.

    A file is complete or absent, so the program may be interrupted at any time.
    """
    name = entry_name(key)
    found = stored(name)
    if found is not None:
        with np.load(BytesIO(found), allow_pickle=False) as file:
            return [file[name] for name in file.files]
    arrays, content = [np.asarray(array) for array in compute()], BytesIO()
    np.savez(content, *arrays)
    store(name, content.getvalue())
    return arrays
