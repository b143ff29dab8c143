"""The channels of a run, ``VARIABLE.SELECTION.SELECTION``, and which of them are asked for."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import NamedTuple

import xarray as xr

from hydrosim.documents.nodes import joined, suggestion
from hydrosim.documents.series import columns_of, select
from hydrosim.documents.text import Source
from hydrosim.errors import InputError

RUN = Source(Path("run"))
USUAL = ("position.*", "velocity.*", "wave_elevation", "force_*", "fender_*", "spring_*")


class Channel(NamedTuple):
    """A channel of a run, and its unit."""

    name: str
    unit: str


def channels(run: xr.Dataset) -> list[Channel]:
    """All channels of a run."""
    return [Channel(name, select(RUN, run, name)[1]) for name in columns_of(run)]


def usual(run: xr.Dataset) -> list[str]:
    """The channels of motions, waves, forces, fenders and springs that are not zero throughout."""
    known = columns_of(run)
    return [name for name in known if _fits(name, USUAL) and select(RUN, run, name)[0].any()]


def chosen(names: Iterable[str], patterns: Sequence[str], option: str) -> list[str]:
    """The names that one of the patterns ("position.*") fits; InputError if a pattern of the
    ``option`` fits none."""
    known = list(names)
    for pattern in patterns:
        if not any(fnmatchcase(name, pattern) for name in known):
            text = f"{option}: found {pattern}; expected one of: {', '.join(known)}"
            raise InputError(joined(text, suggestion(pattern, known)))
    return [name for name in known if _fits(name, patterns)]


def _fits(name: str, patterns: Sequence[str]) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in patterns)
