"""Lock files: one process at a time writes to a path."""

from __future__ import annotations

import os
import re
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from platform import node
from typing import TextIO

from hydrosim.errors import InputError, unwritable

if sys.platform != "win32":
    from fcntl import LOCK_EX, LOCK_NB, flock

HOLDER_PATTERN = re.compile(r"(\d+@\S*\n)?")
"""Line that a lock file holds: its `this_process`."""


def this_process() -> str:
    """Name of this process for other processes: number, start and machine."""
    return f"{os.getpid()}@{node()}"


def is_dead_process(who: str) -> bool:
    """Whether an `this_process` was a process of this machine that no longer exists."""
    number, _, host = who.partition("@")
    if os.name != "posix" or host != node() or not number.isdecimal():
        return False
    try:
        os.kill(int(number), 0)
    except (ProcessLookupError, OverflowError):
        return True
    except PermissionError:
        pass
    return False


@contextmanager
def file_lock(path: Path, what: Path) -> Iterator[None]:
    """Hold the lock file ``path`` while ``what`` is made; remove it at the end.

    Raises InputError if another process holds it, or if it is not a lock file. The system releases
    the lock of a process that was killed, so its remaining file blocks nobody.
    """
    with _lock_held(path, what):
        try:
            yield
        finally:
            with suppress(OSError):
                path.unlink()


@contextmanager
def _lock_held(path: Path, what: Path) -> Iterator[None]:
    """Open and lock the file. Try again if its earlier owner removed it meanwhile."""
    while True:
        with _open_lock(path) as file:
            if not _try_lock(file):
                raise InputError(
                    f"{what}: is being written by another process, {file.read(100).strip()}. Wait"
                    f" until it ends, or give another name. If it no longer exists, remove {path}."
                )
            if _is_at(file, path):
                _write_owner(file, path, what)
                yield
                return


def _write_owner(file: TextIO, path: Path, what: Path) -> None:
    """Write the owner of the lock. On a full disk, WritingError is raised and the file is
    removed."""
    try:
        file.truncate(0)
        os.lseek(file.fileno(), 0, os.SEEK_SET)
        os.write(file.fileno(), f"{this_process()}\n".encode())  # write at once, without a buffer
    except OSError as error:
        path.unlink()
        raise unwritable(what, error) from None


def _open_lock(path: Path) -> TextIO:
    """Opened lock file, at its beginning. Raises InputError if another kind of file stands
    there."""
    try:
        number = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o666)
    except OSError as error:
        raise _lock_error(path, str(error.strerror)) from None
    file = os.fdopen(number, "r+", encoding="utf-8", errors="replace")
    if not stat.S_ISREG(os.fstat(number).st_mode) or not HOLDER_PATTERN.fullmatch(file.read(300)):
        file.close()
        raise _lock_error(path, "it is no lock file")
    file.seek(0)
    return file


def is_lock(path: Path) -> bool:
    """Whether a plain file is the lock file of a process, dead or alive."""
    if path.is_symlink() or not path.is_file():
        return False
    with path.open(encoding="utf-8", errors="replace") as file:
        return HOLDER_PATTERN.fullmatch(file.read(300)) is not None


def _lock_error(path: Path, reason: str) -> InputError:
    text = f"{path}: expected no file, or a lock file of this program ({reason}). Move it away."
    return InputError(text)


def _try_lock(file: TextIO) -> bool:
    """Try to lock the file. True if no other process has it. Where the file system has no locks
    (ENOLCK, ENOSYS, ESTALE), the owner that the file names has it while it lives."""
    if sys.platform != "win32":
        try:
            flock(file, LOCK_EX | LOCK_NB)
        except BlockingIOError:
            return False
        except OSError:
            return not _has_owner(file)
    return True


def _has_owner(file: TextIO) -> bool:
    """Whether the file names another process that may live: one of another machine may."""
    name = file.read(300).strip()
    file.seek(0)
    return name not in ("", this_process()) and not is_dead_process(name)


def _is_at(file: TextIO, path: Path) -> bool:
    with suppress(OSError):
        return os.path.samestat(os.fstat(file.fileno()), path.stat())
    return False
