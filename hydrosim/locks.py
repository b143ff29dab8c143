"""One process at a time, wherever two would write to one place."""

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

HOLDER = re.compile(r"(\d+@\S*\n)?")
"""All that a lock file holds: its `owner`."""


def owner() -> str:
    """This process, as others can know it."""
    return f"{os.getpid()}@{node()}"


def is_gone(who: str) -> bool:
    """Whether an `owner` was a process of this machine that is there no more."""
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
def alone(path: Path, what: Path) -> Iterator[None]:
    """Holds the lock file ``path`` as long as ``what`` is made; removes it in the end.

    Raises InputError if another process holds it, or if it is not a lock file. The system takes the
    lock from a process that was killed, so that a file which such a process has left blocks nobody.
    """
    with _locked(path, what):
        try:
            yield
        finally:
            with suppress(OSError):
                path.unlink()


@contextmanager
def _locked(path: Path, what: Path) -> Iterator[None]:
    """Holds the lock; who had it before may have removed the file as this one opened it."""
    while True:
        with _opened(path) as file:
            if not _lock(file):
                raise InputError(
                    f"{what}: is being written by another process, {file.read(100).strip()}; wait"
                    " until that has ended, or give another name."
                )
            if _is_at(file, path):
                _sign(file, path, what)
                yield
                return


def _sign(file: TextIO, path: Path, what: Path) -> None:
    """Write who holds the lock; on a full disk WritingError is raised and the file goes again."""
    try:
        file.truncate(0)
        os.lseek(file.fileno(), 0, os.SEEK_SET)
        os.write(file.fileno(), f"{owner()}\n".encode())  # nothing stays in a buffer
    except OSError as error:
        path.unlink()
        raise unwritable(what, error) from None


def _opened(path: Path) -> TextIO:
    """The lock file, at its beginning; InputError if something else stands there."""
    try:
        number = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o666)
    except OSError as error:
        raise _no_lock(path, str(error.strerror)) from None
    file = os.fdopen(number, "r+", encoding="utf-8", errors="replace")
    if not stat.S_ISREG(os.fstat(number).st_mode) or not HOLDER.fullmatch(file.read(300)):
        file.close()
        raise _no_lock(path, "it holds something else")
    file.seek(0)
    return file


def is_lock(path: Path) -> bool:
    """Whether a plain file is one that a process has locked, be it there no more."""
    if path.is_symlink() or not path.is_file():
        return False
    with path.open(encoding="utf-8", errors="replace") as file:
        return HOLDER.fullmatch(file.read(300)) is not None


def _no_lock(path: Path, reason: str) -> InputError:
    text = f"{path}: expected no file, or a lock file of this program ({reason}). Move it away."
    return InputError(text)


def _lock(file: TextIO) -> bool:
    """Whether nobody else has it; a file system, or a machine, that knows no locks has none."""
    if sys.platform != "win32":
        try:
            flock(file, LOCK_EX | LOCK_NB)
        except BlockingIOError:
            return False
        except OSError:
            pass
    return True


def _is_at(file: TextIO, path: Path) -> bool:
    with suppress(OSError):
        return os.path.samestat(os.fstat(file.fileno()), path.stat())
    return False
