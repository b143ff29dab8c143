"""The sections of a document, each from what a result holds of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeVar

import xarray as xr

from hydrosim.documents.digits import digits_of
from hydrosim.presentation.document import Heading, Node, Outcome, Verdict

Result = TypeVar("Result")
SectionBuilder = Callable[[Result], Iterator[Node]]
Sections = Mapping[str, tuple[str, SectionBuilder[Result]]]
"""Sections by name: the heading, and what gives the nodes below it."""
MAX_TABLE_ROWS = 300
"""Rows of a table, and remarks of a list."""


def build_sections(parts: Sections[Result], result: Result) -> list[Node]:
    """The headings and nodes of those parts of a result that have anything to say."""
    nodes: list[Node] = []
    for name, (title, part) in parts.items():
        if below := list(_build_section(part, result)):
            nodes += [Heading(title, name), *below]
    return nodes


def title_of(result: xr.Dataset) -> str:
    """The title of a result, or that it has none."""
    return str(result.attrs.get("title", "")).strip() or "Result without a title"


def lines_of(result: xr.Dataset, attribute: str) -> list[str]:
    """The lines of an attribute; none where it is absent."""
    return str(result.attrs.get(attribute, "")).splitlines()


def attribute_text(value: Any) -> str:
    """An attribute of a result: lines as sentences, numbers as numbers."""
    if isinstance(value, str):
        return "; ".join(value.splitlines())
    try:
        return digits_of(float(value), 6)
    except (TypeError, ValueError):
        return str(value)


def _build_section(part: SectionBuilder[Result], result: Result) -> Iterator[Node]:
    """The nodes of a part. A result of another version or origin gives those that can be made."""
    try:
        yield from part(result)
    except (KeyError, ValueError, AttributeError, IndexError) as error:
        yield Verdict(
            Outcome.BAD,
            "This result lacks what this version of hydrosim writes, so the rest of this part is"
            " missing ({}). Run the case again.",
            [f"{type(error).__name__}: {error}"],
        )
