"""The parts of a report, each from what a result holds of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np
import xarray as xr

from hydrosim.report.blocks import Block, Points, Section

DEGREES = float(np.degrees(1.0))
READ = {  # SI, in which unit it is read, and by what it is multiplied
    "rad": ("deg", DEGREES),
    "rad/s": ("deg/s", DEGREES),
    "N": ("kN", 1e-3),
    "N m": ("kN m", 1e-3),
    "J": ("MJ", 1e-6),
    "1": ("", 1.0),
}
Part = Callable[[xr.Dataset], Iterator[Block]]


def sections_of(parts: Mapping[str, tuple[str, Part]], found: xr.Dataset) -> list[Section]:
    """The sections of a result that have anything in them."""
    each = ((name, title, list(_tried(of, found))) for name, (title, of) in parts.items())
    return [Section(*part) for part in each if part[2]]


def drawn_as(unit: str) -> tuple[str, float]:
    """In which unit people read what is in an SI ``unit``, and what it is multiplied by."""
    return READ.get(unit, (unit, 1.0))


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
