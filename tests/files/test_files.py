"""What is no plain file is not waited for: a pipe, a socket or a device may never end."""

import os
import socket
from collections.abc import Callable
from pathlib import Path

import pytest

from hydrosim.compare.dataset import read_result
from hydrosim.errors import InputError
from hydrosim.files.recordings import read_recording
from hydrosim.files.series import read_series
from hydrosim.files.text import Source
from hydrosim.results.dataset import read_run

READERS: dict[str, Callable[[Path], object]] = {
    "a run": read_run,
    "a result": read_result,
    "a recording": read_recording,
    "a series": lambda path: read_series(Source(path), ["x"]),
}


@pytest.mark.parametrize("what", READERS)
def test_what_is_no_file_is_not_waited_for(
    what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # a socket's name must be short
    os.mkfifo("pipe")
    socket.socket(socket.AF_UNIX).bind("socket")
    Path("loop").symlink_to("loop")
    expected = {
        "pipe": "is a pipe or a device",
        "socket": "is a pipe or a device",
        "/dev/zero": "is a pipe or a device",
        ".": "is a directory",
        "none": "there is no such file",
        "loop": "cannot be read",
        "x" * 300: "cannot be read",
        "\0": "cannot be read",
    }
    for name, words in expected.items():
        with pytest.raises(InputError, match=words):
            READERS[what](Path(name))
