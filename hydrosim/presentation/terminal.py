"""A document on a terminal: tables by rich, lines of text as they are, no figures."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator
from io import StringIO

from rich.box import SIMPLE_HEAD
from rich.console import Console, ConsoleOptions, RenderableType, RenderResult
from rich.markup import escape
from rich.segment import Segment
from rich.table import Table as Grid

from hydrosim.presentation.layout import laid_out
from hydrosim.presentation.layout import text_of as words_of
from hydrosim.presentation.nodes import (
    Contents,
    Heading,
    List,
    Node,
    Outcome,
    Sentence,
    Table,
    Verdict,
)
from hydrosim.presentation.units import Units

MARKS = {Outcome.GOOD: "ok", Outcome.WARNING: "warning", Outcome.BAD: "failed"}
WIDTH = len("warning") + 2  # of a mark with the room after it
PRINTED = 120  # characters in a line of a document as text


def text_of(document: Contents, details: bool = True) -> str:
    """The document as text."""
    out = Console(file=StringIO(), width=PRINTED, no_color=True)
    print_document(document, out, details)
    found = out.file.getvalue()  # type: ignore[attr-defined]
    return str(found)


def print_document(document: Contents, out: Console, details: bool = True) -> None:
    """Print a document, without its ``details`` if so asked."""
    subtitle = [document.subtitle] if document.subtitle else []
    print_parts(out, document.title, *subtitle, *parts_of(document, details))


def parts_of(document: Contents, details: bool = True) -> Iterator[RenderableType]:
    """What is printed below the title: texts and grids."""
    for section in document.sections:
        if section.heading.detail and not details:
            continue
        if section.heading.text:
            yield f"\n{section.heading.text}"
        for node in section.nodes:
            if details or not getattr(node, "detail", False):
                yield from _printed(node, document.units)


def print_parts(out: Console, *parts: RenderableType) -> None:
    """Print grids, and lines of text as they are: no markup, no colours, not broken."""
    for part in parts:
        if isinstance(part, str):
            out.print(printable(part), markup=False, highlight=False, soft_wrap=True)
        else:
            out.print(_Printable(part))


def printable(text: str) -> str:
    """The text, with what would steer a terminal, or is no character, as its number: names in files
    of others may hold anything."""
    if text.isprintable():
        return text
    return "".join(c if c in "\n\t" or not _odd(c) else f"\\u{ord(c):04x}" for c in text)


def _odd(character: str) -> bool:
    return unicodedata.category(character) in ("Cc", "Cf", "Cs")


def _printed(node: Node, units: Units) -> Iterator[RenderableType]:
    match node:
        case Sentence():
            yield words_of(node, units)
        case Verdict(outcome=outcome):
            yield f"{MARKS[outcome]:{WIDTH}}{words_of(node.sentence, units)}"
        case List(items=items, title=title):
            if title:
                yield title
            yield from (f"  {words_of(item, units)}" for item in items)
        case Table():
            yield f"\n{node.title}" if node.title else ""
            yield _grid(node, units)
        case Heading():
            yield node.text


def _grid(table: Table, units: Units) -> Grid:
    head, rows = laid_out(table, units)
    grid = Grid(box=SIMPLE_HEAD, pad_edge=False, show_edge=False, show_header=any(head))
    for k, name in enumerate(head):
        numeric = any(row[k].numeric for row in rows)
        words = [*name.split(), *(row[k].text for row in rows if row[k].numeric)]
        grid.add_column(
            escape(name),
            justify="right" if numeric else "left",
            overflow="fold",
            min_width=max(map(len, words), default=None),
        )
    for row in rows:
        grid.add_row(*(escape(cell.text) for cell in row))
    return grid


class _Printable:
    """A grid of characters that can be printed."""

    def __init__(self, part: RenderableType) -> None:
        self._part = part

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        for text, style, control in console.render(self._part, options):
            yield Segment(text if control else printable(text), style, control)
