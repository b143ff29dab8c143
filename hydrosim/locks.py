"""One process at a time, wherever two would write to one place."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from platform import node
from typing import TextIO

from hydrosim.errors import InputError

if sys.platform != "win32":
    from fcntl import LOCK_EX, LOCK_NB, flock


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
    """Holds a lock file, in a folder that is made for it, as long as ``what`` is written; both are
    removed in the end, the folder if it is empty.

    Raises InputError if another process holds it. The system takes the lock from one that was
    killed, so that what such a one has left counts for nothing.
    """
    path.parent.mkdir(exist_ok=True)
    with _locked(path, what):
        try:
            yield
        finally:
            with suppress(OSError):
                path.unlink()
    with suppress(OSError):
        path.parent.rmdir()


@contextmanager
def _locked(path: Path, what: Path) -> Iterator[None]:
    """Holds the lock; who had it before may have removed the file as this one opened it."""
    while True:
        with path.open("a+") as file:
            if not _lock(file):
                file.seek(0)
                raise InputError(
                    f"{what}: is being written by another process, {file.read(100).strip()}; wait"
                    " until that has ended, or give another name."
                )
            if _is_at(file, path):
                file.truncate(0)
                print(owner(), file=file, flush=True)
                yield
                return


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
