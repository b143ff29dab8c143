"""Printing of documents and of plain lines of text."""

from __future__ import annotations

import sys
from collections.abc import Mapping

from rich.console import Console, RenderableType

from hydrosim.presentation.document import Document
from hydrosim.presentation.terminal import print_document, print_parts


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
