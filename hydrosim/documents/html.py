"""Small pieces of HTML for notebooks, in which every text is shown as it is."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape


def element(tag: str, *texts: str) -> str:
    """Texts in an element, line by line."""
    return f"<{tag}>{'<br>'.join(escape(text) for text in texts)}</{tag}>"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Rows of texts under a ``head``."""
    top = "".join(element("th", cell) for cell in head)
    body = (f"<tr>{''.join(element('td', cell) for cell in row)}</tr>" for row in rows)
    return f"<table><thead><tr>{top}</tr></thead><tbody>{''.join(body)}</tbody></table>"
