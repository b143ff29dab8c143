"""A document: what a result says, as a list of nodes. Renderers add no words of their own.

Its `Units` say in which unit a value is read. So one document gives the same figures on the
terminal, on a page and in a notebook.
"""

from __future__ import annotations

from hydrosim.presentation.nodes import (
    Between,
    Cell,
    DocumentContents,
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
from hydrosim.presentation.notebook import html_of
from hydrosim.presentation.terminal import text_of

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
        return text_of(self)

    def _repr_html_(self) -> str:
        return html_of(self)
