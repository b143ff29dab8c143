"""Lock files where the file system has locks, and where it has none."""

import errno
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from platform import node
from typing import Any

import pytest

from hydrosim.errors import InputError
from hydrosim.files import locks

ALIVE = os.getppid()


def failing(code: int) -> Callable[..., None]:
    def flock(*_: Any) -> None:
        raise OSError(code, os.strerror(code))

    return flock


def ended_process() -> int:
    """Number of a process that no longer exists."""
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        process.wait()
    return process.pid


@pytest.mark.parametrize("code", [errno.ENOLCK, errno.ENOSYS, errno.ESTALE, errno.EOPNOTSUPP])
@pytest.mark.parametrize(
    ("holder", "is_free"),
    [
        ("", True),
        (f"{ALIVE}@{node()}\n", False),
        ("17@another-machine\n", False),
        ("dead", True),
        ("own", True),
    ],
)
def test_without_locks_the_owner_in_the_file_counts(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, code: int, holder: str, is_free: bool
) -> None:
    names = {"dead": f"{ended_process()}@{node()}\n", "own": f"{locks.this_process()}\n"}
    monkeypatch.setattr(locks, "flock", failing(code))
    path = tmp_path / "run.nc.lock"
    path.write_text(names.get(holder, holder))
    if is_free:
        with locks.file_lock(path, tmp_path / "run.nc"):
            assert path.read_text() == f"{locks.this_process()}\n"
        assert not path.exists()
        return
    with (
        pytest.raises(
            InputError, match=r"is being written by another process, \d+@.* remove .*lock"
        ),
        locks.file_lock(path, tmp_path / "run.nc"),
    ):
        pass
    assert path.read_text() == holder
