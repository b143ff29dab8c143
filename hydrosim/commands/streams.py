"""Standard output and error that are closed, or that nobody reads any more, end no command."""

from __future__ import annotations

import io
import os
import sys
from typing import Any

LOST: dict[str, type[OSError]] = {"stdout": BrokenPipeError, "stderr": OSError}
"""What may happen to a stream, besides that its terminal is closed. A full disk below the standard
output is told; messages and progress are a courtesy, and nobody can be told that they are lost."""


class _Lasting(io.FileIO):
    """A file descriptor that takes everything, also after it has failed with ``lost`` or, if it is
    a terminal, with any error."""

    def __init__(self, descriptor: int, lost: type[OSError]) -> None:
        super().__init__(descriptor, "w", closefd=False)
        self._lost = OSError if os.isatty(descriptor) else lost

    def write(self, data: Any, /) -> int:
        try:
            return super().write(data)
        except self._lost:
            return memoryview(data).nbytes


def make_streams_last() -> None:
    """From now on standard output and error can be written to until the end, and what they have no
    character for is printed as its number."""
    _open_closed_descriptors()
    for number, name in enumerate(("stdout", "stderr"), 1):
        stream = getattr(sys, name)
        if stream is getattr(sys, f"__{name}__"):  # None if closed; no one else has put another
            setattr(sys, name, _lasting(number, name, stream))


def _open_closed_descriptors() -> None:
    """Put nothing where standard streams are closed: the next file opened, a result perhaps, would
    take their place, and what is printed."""
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free


def _lasting(descriptor: int, name: str, stream: io.TextIOWrapper | None) -> io.TextIOWrapper:
    return io.TextIOWrapper(
        io.BufferedWriter(_Lasting(descriptor, LOST[name])),
        encoding=stream.encoding if stream else "utf-8",
        errors="backslashreplace",
        line_buffering=stream is not None and stream.line_buffering,
    )
