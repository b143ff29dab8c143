"""The folder of everything that hydrosim may compute again."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO


def cache_root() -> Path:
    """``HYDROSIM_CACHE_DIR``, or a folder in the user's cache."""
    chosen = os.environ.get("HYDROSIM_CACHE_DIR")
    if chosen:
        return Path(chosen)
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "hydrosim"


def store(path: Path, fill: Callable[[BinaryIO], object]) -> None:
    """Make the file ``path`` of what ``fill`` writes: all or nothing, also when several processes
    make the same file at once."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, partial = tempfile.mkstemp(dir=path.parent, suffix=".partial")
    try:
        with os.fdopen(handle, "wb") as file:
            fill(file)
        os.replace(partial, path)
    finally:
        with suppress(FileNotFoundError):
            os.remove(partial)
