"""What commands print: documents, and lines of text as they are."""

from __future__ import annotations

import sys
from collections.abc import Mapping

from rich.console import Console, RenderableType

from hydrosim.presentation.document import Document
from hydrosim.presentation.terminal import print_document, print_parts


def show(*parts: RenderableType) -> None:
    """Tables, and lines as they are: no markup, no colours, not broken."""
    print_parts(Console(), *parts)


def show_document(document: Document, verbose: bool = False) -> None:
    """A document, with its details if ``verbose``."""
    print_document(document, Console(), verbose)


def say(text: str) -> None:
    """A line of text as it is, to the standard error."""
    print_parts(Console(stderr=True), text)


def not_complete(attributes: Mapping[str, object]) -> list[str]:
    """A line on how a run ended that is not complete, by its attributes; none of one that is."""
    status = attributes.get("status", "complete")
    said = f"warning   the run is {status}: {attributes.get('status_message', '')}"
    return [] if status == "complete" else [said]


def progress_console() -> Console:
    """Where bars of progress go: to a terminal alone, though notebooks and others may force colours
    upon a stream that keeps every state of a bar."""
    is_terminal = sys.stderr is not None and sys.stderr.isatty()
    return Console(stderr=True, force_terminal=is_terminal)
