"""The folder of everything that hydrosim may compute again.

What is kept there is found by name, and counts only if it stands below the digest of its name and
itself: what was cut off, changed, exchanged or left by another version is made again. A digest
tells of damage, not of malice, and machine code is taken from there: a folder or a file that others
may write, or exchange, is not used. A file appears whole or not at all, by its renaming, so that
several processes and a home on another machine need no locks.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import shutil
import stat
import tempfile
import warnings
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

OWNER_ONLY = 0o700
DIGEST = hashlib.sha256


def cache_root() -> Path:
    """``HYDROSIM_CACHE_DIR``, or a folder in the user's cache; one of this process alone, with a
    warning, where that is not safe or cannot be written."""
    chosen = os.environ.get("HYDROSIM_CACHE_DIR")
    base = os.environ.get("XDG_CACHE_HOME")
    return _usable(Path(chosen or Path(base or os.path.expanduser("~/.cache"), "hydrosim")))


def cache_folder(name: str) -> Path:
    """A folder of the cache, or one of this process alone as for `cache_root`."""
    return _usable(cache_root() / name)


def store(name: str, content: bytes) -> None:
    """Keep ``content`` under a ``name``, a relative path. Where that cannot be, it costs the time
    of the next time."""
    with suppress(OSError):
        path = _path(name)
        handle, partial = tempfile.mkstemp(dir=path.parent, suffix=".partial")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(_digest(name, content) + content)
            os.replace(partial, path)
        finally:
            with suppress(FileNotFoundError):
                os.remove(partial)


def stored(name: str) -> bytes | None:
    """What was stored under a ``name``; None if nothing was, or it is not what it was."""
    path = _path(name)
    try:
        trusted = path.is_file() and not _exposed(path)
        found = path.read_bytes() if trusted else b""
    except OSError:
        return None
    size = DIGEST().digest_size
    return found[size:] if found[:size] == _digest(name, found[size:]) else None


def _path(name: str) -> Path:
    folder, file = os.path.split(name)
    return cache_folder(folder) / file


def _digest(name: str, content: bytes) -> bytes:
    return DIGEST(f"{name}\0".encode() + content).digest()


@lru_cache
def _usable(folder: Path) -> Path:
    """The folder, or a new one that is removed at the end of this process."""
    reason = _refusal(folder)
    if not reason:
        return folder
    private = tempfile.mkdtemp(prefix="hydrosim-")
    atexit.register(shutil.rmtree, private, ignore_errors=True)
    warnings.warn(
        f"the cache folder {folder} is not used: {reason}. What is computed anew is kept in"
        f" {private}, until the end of this process. HYDROSIM_CACHE_DIR names another folder.",
        stacklevel=2,
    )
    return Path(private)


def _refusal(folder: Path) -> str:
    """Why a folder cannot be used; empty if it can."""
    try:
        folder.mkdir(mode=OWNER_ONLY, parents=True, exist_ok=True)
        parents = folder.resolve().parents
    except OSError as error:
        return f"it cannot be made ({error.strerror})"
    if not os.access(folder, os.W_OK | os.X_OK):
        return "it cannot be written to"
    for parent in filter(_lets_all_rename, parents):
        return f"{parent} lets everybody rename it (chmod +t {parent})"
    return _exposed(folder)


def _exposed(path: Path) -> str:
    """Why others may have written a file or a folder; empty if they may not."""
    about = path.stat()
    if hasattr(os, "geteuid") and about.st_uid not in (os.geteuid(), 0):
        return "it belongs to another user"
    if os.name == "posix" and about.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        return f"others may write in it (if nobody did: chmod go-w {path})"
    return ""


def _lets_all_rename(folder: Path) -> bool:
    """Whether everybody may rename what others have in a folder."""
    mode = folder.stat().st_mode
    return os.name == "posix" and bool(mode & stat.S_IWOTH) and not mode & stat.S_ISVTX
