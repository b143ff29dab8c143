"""What commands print: tables, and lines of text as they are."""

from __future__ import annotations

import sys
import unicodedata
from collections.abc import Mapping

from rich.console import Console, ConsoleOptions, RenderableType, RenderResult
from rich.segment import Segment


def printable(text: str) -> str:
    """The text, with what would steer a terminal, or is no character, as its number: names in files
    of others may hold anything."""
    if text.isprintable():
        return text
    return "".join(c if c in "\n\t" or not _odd(c) else f"\\u{ord(c):04x}" for c in text)


def _odd(character: str) -> bool:
    return unicodedata.category(character) in ("Cc", "Cf", "Cs")


def show(*parts: RenderableType) -> None:
    """Tables, and lines as they are: no markup, no colours, not broken."""
    out = Console()
    for part in parts:
        if isinstance(part, str):
            out.print(printable(part), markup=False, highlight=False, soft_wrap=True)
        else:
            out.print(_Shown(part))


def say(text: str) -> None:
    """A line of text as it is, to the standard error."""
    Console(stderr=True).print(printable(text), markup=False, highlight=False, soft_wrap=True)


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


class _Shown:
    """What is drawn, of characters that can be printed."""

    def __init__(self, part: RenderableType) -> None:
        self._part = part

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        for text, style, control in console.render(self._part, options):
            yield Segment(text if control else printable(text), style, control)
