"""Documents, what results say as lists of nodes, and how terminals and notebooks show them.

Renderers add no words of their own.
Its `Units` say in which unit a value is read. So one document gives the same figures on the
terminal, on a page and in a notebook.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator, Sequence
from html import escape
from io import StringIO
from typing import NamedTuple

from rich.box import Box
from rich.console import Console, ConsoleOptions, JustifyMethod, RenderableType, RenderResult
from rich.segment import Segment
from rich.table import Table as Grid
from rich.text import Text

from hydrosim.files.display_units import Units
from hydrosim.files.document_layout import RenderedCell, render_table, text_of
from hydrosim.files.document_nodes import (
    Between,
    Cell,
    DocumentContents,
    Drawing,
    Heading,
    List,
    Node,
    Outcome,
    Part,
    Section,
    Sentence,
    Table,
    Value,
    Verdict,
    warnings,
)

# Notebooks: a fragment of HTML, in which every text is shown as it is.


def html_of(document: DocumentContents) -> str:
    """The document without its details and without charts."""
    return "".join(_rendered_parts(document))


def element(tag: str, *texts: str) -> str:
    """Texts in an element, line by line."""
    return f"<{tag}>{'<br>'.join(escape(text) for text in texts)}</{tag}>"


def _rendered_parts(document: DocumentContents) -> Iterator[str]:
    yield element("h3", document.title)
    if document.subtitle:
        yield element("p", document.subtitle)
    for section in document.sections:
        if section.heading.detail:
            continue
        if section.heading.text:
            yield element("h4", section.heading.text)
        for node in section.nodes:
            if not getattr(node, "detail", False):
                yield _node_html(node, document.units)


def _node_html(node: Node, units: Units) -> str:
    match node:
        case Sentence():
            return element("p", text_of(node, units))
        case Verdict(outcome=outcome):
            return element("p", f"{outcome.value}: {text_of(node.sentence, units)}")
        case List(items=items, title=title):
            items_html = "".join(element("li", text_of(item, units)) for item in items)
            return f"{element('p', title) if title else ''}<ul>{items_html}</ul>"
        case Table():
            return _table_text(node, units)
        case Heading():
            return element("h4", node.text)
        case Drawing():
            return node.svg
    return ""


def _table_text(node: Table, units: Units) -> str:
    head, rows = render_table(node, units)
    top = "".join(element("th", name) for name in head)
    body = (f"<tr>{''.join(element('td', cell.text) for cell in row)}</tr>" for row in rows)
    caption = element("caption", node.title) if node.title else ""
    return f"<table>{caption}<thead><tr>{top}</tr></thead><tbody>{''.join(body)}</tbody></table>"


# Terminals: tables by rich, lines of text as they are, no figures.

OUTCOME_MARKS = {Outcome.GOOD: "ok", Outcome.WARNING: "warning", Outcome.BAD: "failed"}
MARK_WIDTH = len("warning") + 2  # of a mark with the room after it
COLUMN_GAP = 2  # of columns: a blank on the right, and one between
TABLE_BOX = Box("    \n" * 2 + " ── \n" + "    \n" * 5)
"""A line below the head alone."""
MAX_UNBROKEN_WORD = 20  # characters of a word that is not broken
TEXT_WIDTH = 120  # characters in a line of a document as text


class TextColumn(NamedTuple):
    """A column of a table: its ``name``, its ``texts``, and whether they are numbers."""

    name: str
    texts: list[str]
    numeric: bool

    @property
    def min_width(self) -> int:
        """The least width: numbers are never broken, words where they are longer than
        `MAX_UNBROKEN_WORD`."""
        if self.numeric:
            return max(map(len, [*self.texts, *self.name.split()]))
        words = [word for text in (self.name, *self.texts) for word in text.split()]
        return min(max(map(len, words), default=0), MAX_UNBROKEN_WORD)


def document_text(document: DocumentContents, details: bool = True) -> str:
    """The document as text."""
    out = Console(file=StringIO(), width=TEXT_WIDTH, no_color=True)
    print_document(document, out, details)
    text = out.file.getvalue()  # type: ignore[attr-defined]
    return str(text)


def print_document(document: DocumentContents, out: Console, details: bool = True) -> None:
    """Print a document, without its ``details`` if so asked."""
    subtitle = [document.subtitle] if document.subtitle else []
    print_parts(out, document.title, *subtitle, *_parts_of(document, details, out.width))


def _parts_of(document: DocumentContents, details: bool, width: int) -> Iterator[RenderableType]:
    """What is printed below the title: texts and grids, with a blank line on both sides of a table
    and above a heading."""
    blank = False
    for node in _select_nodes(document, details):
        parts = list(_render_node(node, document.units, width))
        if parts and isinstance(node, Table | Heading) and not blank:
            yield ""
        yield from parts
        blank = isinstance(node, Table) if parts else blank


def _select_nodes(document: DocumentContents, details: bool) -> Iterator[Node]:
    """Headings and what is below them, without details if so asked."""
    for section in document.sections:
        if details or not section.heading.detail:
            nodes = [section.heading, *section.nodes]
            yield from (node for node in nodes if details or not getattr(node, "detail", False))


def print_parts(out: Console, *parts: RenderableType) -> None:
    """Print grids, and lines of text as they are: no markup, no colours, not broken."""
    for part in parts:
        if isinstance(part, str):
            out.print(printable(part), markup=False, emoji=False, highlight=False, soft_wrap=True)
        else:
            out.print(_PrintableRendering(part), crop=False)


def printable(text: str) -> str:
    """The text, with what would steer a terminal, or is no character, as its number: names in files
    of others may hold anything."""
    if text.isprintable():
        return text
    return "".join(c if c in "\n\t" or not _is_control(c) else f"\\u{ord(c):04x}" for c in text)


def _is_control(character: str) -> bool:
    return unicodedata.category(character) in ("Cc", "Cf", "Cs")


def _render_node(node: Node, units: Units, width: int) -> Iterator[RenderableType]:
    match node:
        case Sentence():
            yield text_of(node, units)
        case Verdict(outcome=outcome):
            yield f"{OUTCOME_MARKS[outcome]:{MARK_WIDTH}}{text_of(node.sentence, units)}"
        case List(items=items, title=title):
            yield from filter(None, [title])
            yield from (f"  {text_of(item, units)}" for item in items)
        case Table():
            yield from filter(None, [node.title])
            yield _lay_out_grid(*render_table(node, units), width)
            yield ""
        case Heading():
            yield from filter(None, [node.text])


def _lay_out_grid(head: list[str], rows: list[list[RenderedCell]], width: int) -> Grid:
    """A table, as wide as the terminal where it can be."""
    columns = [
        TextColumn(name, [row[k].text for row in rows], any(row[k].numeric for row in rows))
        for k, name in enumerate(head)
    ]
    widths = _column_widths(columns, width)
    total = sum(widths) + COLUMN_GAP * (len(columns) - 1)
    grid = Grid(
        box=TABLE_BOX,
        padding=(0, 1, 0, 0),
        pad_edge=False,
        show_edge=False,
        show_header=any(head),
        width=total if total > width else None,
    )
    for column, wide in zip(columns, widths, strict=True):
        justify: JustifyMethod = "right" if column.numeric else "left"
        grid.add_column(Text(column.name), justify=justify, overflow="fold", width=wide)
    for row in rows:
        grid.add_row(*(Text(cell.text) for cell in row))
    return grid


def _column_widths(columns: Sequence[TextColumn], width: int) -> list[int]:
    """The width of each column. Where the terminal is too narrow, heads of numbers are broken
    between words, then texts."""
    widths = [max(map(len, [column.name, *column.texts])) for column in columns]
    excess = sum(widths) + COLUMN_GAP * (len(columns) - 1) - width
    for k in sorted(range(len(columns)), key=lambda k: not columns[k].numeric):
        cut = min(max(excess, 0), widths[k] - columns[k].min_width)
        widths[k] -= cut
        excess -= cut
    return widths


class _PrintableRendering:
    """A grid of characters that can be printed."""

    def __init__(self, part: RenderableType) -> None:
        self._part = part

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        for text, style, control in console.render(self._part, options):
            yield Segment(text if control else printable(text), style, control)


__all__ = [
    "Between",
    "Cell",
    "Document",
    "Heading",
    "List",
    "Node",
    "Outcome",
    "Part",
    "Section",
    "Sentence",
    "Table",
    "Value",
    "Verdict",
    "warnings",
]


class Document(DocumentContents):
    """What a result says. In Python, `print` and notebooks show it."""

    def __str__(self) -> str:
        return document_text(self)

    def _repr_html_(self) -> str:
        return html_of(self)
