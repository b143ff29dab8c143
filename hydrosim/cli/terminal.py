"""Printing of documents and of plain lines of text."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Mapping
from typing import Any

from rich.console import Console, RenderableType

from hydrosim.files.document import Document, print_document, print_parts

# Standard streams that are closed, or that nobody reads, do not end a command.

LOST_WRITE_ERRORS: dict[str, type[OSError]] = {"stdout": BrokenPipeError, "stderr": OSError}
"""Errors of a stream, besides a closed terminal. A full disk below the standard output is reported.
Messages and progress may be lost in silence."""


class _Lasting(io.FileIO):
    """File descriptor that accepts all writes, also after a write failed with ``lost`` or, on a
    terminal, with any error."""

    def __init__(self, descriptor: int, lost: type[OSError]) -> None:
        super().__init__(descriptor, "w", closefd=False)
        self._lost = OSError if os.isatty(descriptor) else lost

    def write(self, data: Any, /) -> int:
        try:
            return super().write(data)
        except self._lost:
            return memoryview(data).nbytes


def make_streams_last() -> None:
    """Make standard output and error writable until the process ends. Characters outside their
    encoding are printed as numbers."""
    _open_closed_descriptors()
    for number, name in enumerate(("stdout", "stderr"), 1):
        stream = getattr(sys, name)
        if stream is getattr(sys, f"__{name}__"):  # None if closed; other objects are left alone
            setattr(sys, name, _lasting(number, name, stream))


def _open_closed_descriptors() -> None:
    """Open the null device for closed standard streams. Otherwise the next file opened, such as a
    result, would take their number and receive the printed text."""
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # open takes the lowest free number


def _lasting(descriptor: int, name: str, stream: io.TextIOWrapper | None) -> io.TextIOWrapper:
    return io.TextIOWrapper(
        io.BufferedWriter(_Lasting(descriptor, LOST_WRITE_ERRORS[name])),
        encoding=stream.encoding if stream else "utf-8",
        errors="backslashreplace",
        line_buffering=stream is not None and stream.line_buffering,
    )


def print_lines(*parts: RenderableType) -> None:
    """Print tables and plain lines: no markup, no colours, no line breaks."""
    print_parts(Console(), *parts)


def show_document(document: Document, verbose: bool = False) -> None:
    """Print a document, with its details if ``verbose``."""
    print_document(document, Console(), verbose)


def print_status(text: str) -> None:
    """Print a plain line of text to the standard error."""
    print_parts(Console(stderr=True), text)


def not_complete(attributes: Mapping[str, object]) -> list[str]:
    """Warning about the end of a run, from its attributes; empty if the run is complete."""
    status = attributes.get("status", "complete")
    text = f"warning   the run is {status}: {attributes.get('status_message', '')}"
    return [] if status == "complete" else [text]


def progress_console() -> Console:
    """Console for progress bars, which are drawn on terminals only. Notebooks and others may force
    colours upon streams that keep every state of a bar."""
    is_terminal = sys.stderr is not None and sys.stderr.isatty()
    return Console(stderr=True, force_terminal=is_terminal)
