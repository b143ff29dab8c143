"""The parts of a report, each from what a result holds of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import xarray as xr

from hydrosim.report.blocks import Block, Points, Section

Part = Callable[[xr.Dataset], Iterator[Block]]


def sections_of(parts: Mapping[str, tuple[str, Part]], found: xr.Dataset) -> list[Section]:
    """The sections of a result that have anything in them."""
    each = ((name, title, list(_tried(of, found))) for name, (title, of) in parts.items())
    return [Section(*part) for part in each if part[2]]


def title_of(found: xr.Dataset) -> str:
    """The title of a result, or that it has none."""
    return str(found.attrs.get("title", "")).strip() or "Result without a title"


def _tried(of: Part, found: xr.Dataset) -> Iterator[Block]:
    """A part of the report; of a result of another version or origin, what of it can be made."""
    try:
        yield from of(found)
    except (KeyError, ValueError, AttributeError, IndexError) as error:
        said = f"{type(error).__name__}: {error}"
        text = (
            "The rest cannot be made of this result, which lacks or has otherwise what this"
            f" version of hydrosim writes ({said}). Run the case again."
        )
        yield Points([text], grave=True)
