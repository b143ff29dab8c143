"""What took long to compute, kept on disk under a hash of everything it depends on."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any

import numpy as np

from hydrosim.cache import cache_root


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


def remembered(key: str, compute: Callable[[], Iterable[Any]]) -> list[np.ndarray]:
    """The arrays of ``key`` from the disk, or else computed and put there.

    A file is there whole or not at all, so that any moment is good for an interruption.
    """
    path = cache_root() / "potential-flow" / f"{key[:32]}.npz"
    if path.is_file():
        with np.load(path) as file:
            return [file[name] for name in file.files]
    arrays = [np.asarray(array) for array in compute()]
    path.parent.mkdir(parents=True, exist_ok=True)
    _write(path, arrays)
    return arrays


def _write(path: Path, arrays: Sequence[np.ndarray]) -> None:
    with NamedTemporaryFile(dir=path.parent, suffix=".part", delete=False) as file:
        np.savez(file, *arrays)
    os.replace(file.name, path)
