"""A document in a notebook: a fragment of HTML, in which every text is shown as it is."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape

from hydrosim.presentation.figures import Drawing
from hydrosim.presentation.layout import render_table, text_of
from hydrosim.presentation.nodes import (
    DocumentContents,
    Heading,
    List,
    Node,
    Sentence,
    Table,
    Verdict,
)
from hydrosim.presentation.units import Units


def html_of(document: DocumentContents) -> str:
    """The document without its details and without charts."""
    return "".join(_parts(document))


def element(tag: str, *texts: str) -> str:
    """Texts in an element, line by line."""
    return f"<{tag}>{'<br>'.join(escape(text) for text in texts)}</{tag}>"


def _parts(document: DocumentContents) -> Iterator[str]:
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
            said = "".join(element("li", text_of(item, units)) for item in items)
            return f"{element('p', title) if title else ''}<ul>{said}</ul>"
        case Table():
            return _table(node, units)
        case Heading():
            return element("h4", node.text)
        case Drawing():
            return node.svg
    return ""


def _table(node: Table, units: Units) -> str:
    head, rows = render_table(node, units)
    top = "".join(element("th", name) for name in head)
    body = (f"<tr>{''.join(element('td', cell.text) for cell in row)}</tr>" for row in rows)
    caption = element("caption", node.title) if node.title else ""
    return f"<table>{caption}<thead><tr>{top}</tr></thead><tbody>{''.join(body)}</tbody></table>"
