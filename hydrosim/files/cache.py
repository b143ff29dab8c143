"""Cache of the program on disk, versions of packages and digests of sources.

Folder for everything that hydrosim can compute again.

An entry is found by its name. It is used only if the digest at its top matches its name and
content. Entries that were truncated, changed, exchanged or left by another version are made again.
A digest detects damage, not malice, and machine code is loaded from here. So a folder or file that
other users may write or exchange is not used. A file appears complete by renaming, so several
processes and network file systems need no locks.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import shutil
import stat
import tempfile
import time
import warnings
from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import cache, lru_cache
from pathlib import Path
from platform import python_version

PACKAGE = Path(__file__).parents[1]
SHIPPED_FITS = PACKAGE / "water" / "radiation" / "shipped.zip"
"""Fits of radiation that came with the package, under their names in the cache."""
NUMERICAL = ("numpy", "scipy", "numba", "llvmlite")


def version_of(package: str) -> str:
    """Version of an installed package."""
    from importlib.metadata import PackageNotFoundError, version  # slow to load

    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def program_version() -> str:
    """Version of this program."""
    return version_of("hydrosim")


def versions() -> str:
    """Versions of Python and of the packages that numbers depend on."""
    packages = (f"{name} {version_of(name)}" for name in NUMERICAL)
    return ", ".join([f"Python {python_version()}", *packages])


@cache
def digest_of_sources(home: Path, *parts: str) -> str:
    """SHA-256 (hex) of the files ``parts`` of the folder ``home``, and of all modules in folders
    among them. It does not depend on where ``home`` is."""
    digest = hashlib.sha256()
    for path in _files(home, parts):
        content = path.read_bytes()
        digest.update(f"{path.relative_to(home).as_posix()} {len(content)} ".encode() + content)
    return digest.hexdigest()


def _files(home: Path, parts: Sequence[str]) -> Iterator[Path]:
    for place in map(home.joinpath, parts):
        yield from [place] if place.is_file() else sorted(place.rglob("*.py"))


OWNER_ONLY = 0o700
DIGEST = hashlib.sha256
USE_RESOLUTION_S = 3600.0
"""The time of last use of an entry is known to within this."""


def cache_root() -> Path:
    """``HYDROSIM_CACHE_DIR``, or a folder in the user's cache. If it is not safe or not writable, a
    folder of this process alone, with a warning."""
    chosen = os.environ.get("HYDROSIM_CACHE_DIR")
    base = os.environ.get("XDG_CACHE_HOME")
    return _require_usable(Path(chosen or Path(base or os.path.expanduser("~/.cache"), "hydrosim")))


def cache_folder(name: str) -> Path:
    """Folder of the cache, or a folder of this process alone as for `cache_root`."""
    return _require_usable(cache_root() / name)


def store(name: str, content: bytes) -> None:
    """Store ``content`` under ``name``, a relative path. A failure is ignored: the next process
    computes the content again."""
    with suppress(OSError):
        path = _path_in_cache(name)
        handle, partial = tempfile.mkstemp(dir=path.parent, suffix=".partial")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(_content_digest(name, content) + content)
            os.replace(partial, path)
        finally:
            with suppress(FileNotFoundError):
                os.remove(partial)


def stored(name: str) -> bytes | None:
    """Content stored under ``name``; None if there is none, or if it was changed."""
    path = _path_in_cache(name)
    try:
        trusted = path.is_file() and not _exposure_text(path)
        content = path.read_bytes() if trusted else b""
    except OSError:
        return None
    _mark_used(path)
    size = DIGEST().digest_size
    return content[size:] if content[:size] == _content_digest(name, content[size:]) else None


def limit_size(pattern: str, limit: int) -> None:
    """Remove entries with names of a ``pattern``, as in a shell, until the others take at most
    ``limit`` bytes. Those whose last use is longest ago go first. Processes that still want one
    make it again."""
    files = []
    for path in cache_root().glob(pattern):
        with suppress(OSError):  # another process may have removed it
            about = path.stat()
            files.append((about.st_mtime, about.st_size, path))
    total = 0
    for _, size, path in sorted(files, reverse=True):
        total += size
        if total > limit:
            with suppress(OSError):
                path.unlink()
                path.parent.rmdir()  # fails unless it is empty


def _mark_used(path: Path) -> None:
    """Set the file's time to now, for `limit_size`."""
    with suppress(OSError):
        if time.time() - path.stat().st_mtime > USE_RESOLUTION_S:
            os.utime(path)


def _path_in_cache(name: str) -> Path:
    folder, file = os.path.split(name)
    return cache_folder(folder) / file


def _content_digest(name: str, content: bytes) -> bytes:
    return DIGEST(f"{name}\0".encode() + content).digest()


@lru_cache
def _require_usable(folder: Path) -> Path:
    """Use the folder, or a new one that is removed at the end of this process."""
    reason = _refusal_text(folder)
    if not reason:
        return folder
    private = tempfile.mkdtemp(prefix="hydrosim-")
    atexit.register(shutil.rmtree, private, ignore_errors=True)
    warnings.warn(
        f"the cache folder {folder} is not used: {reason}. Computed entries are kept in {private}"
        " until this process ends. Set HYDROSIM_CACHE_DIR to another folder.",
        stacklevel=2,
    )
    return Path(private)


def _refusal_text(folder: Path) -> str:
    """Reason why a folder cannot be used; empty if it can."""
    try:
        folder.mkdir(mode=OWNER_ONLY, parents=True, exist_ok=True)
        parents = folder.resolve().parents
    except OSError as error:
        return f"it cannot be made ({error.strerror})"
    if not os.access(folder, os.W_OK | os.X_OK):
        return "it cannot be written to"
    for parent in filter(_lets_all_rename, parents):
        return f"every user may rename it in {parent} (to prevent this: chmod +t {parent})"
    return _exposure_text(folder)


def _exposure_text(path: Path) -> str:
    """Reason why other users may have written a file or a folder; empty if they may not."""
    about = path.stat()
    if hasattr(os, "geteuid") and about.st_uid not in (os.geteuid(), 0):
        return "it belongs to another user"
    if os.name == "posix" and about.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        return f"others may write in it (if nobody did: chmod go-w {path})"
    return ""


def _lets_all_rename(folder: Path) -> bool:
    """Whether every user may rename files of others in a folder."""
    mode = folder.stat().st_mode
    return os.name == "posix" and bool(mode & stat.S_IWOTH) and not mode & stat.S_ISVTX
