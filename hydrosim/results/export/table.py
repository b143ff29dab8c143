"""Channels of a run as columns over one time, each with one unit: the content of every format."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from hydrosim.documents.series import columns_of, select
from hydrosim.documents.text import Source, require_finite, require_rising
from hydrosim.errors import InputError
from hydrosim.presentation.units import Units
from hydrosim.results.channels import RUN, channel_names, channel_series, match_channels

EXPORTED_ATTRIBUTES = (
    "title",
    "date_created",
    "status",
    "status_message",
    "warnings",
    "skipped",
    "case",
    "case_resolved",
)
NOT_IN_NAMES = re.compile(r"[^A-Za-z0-9]+")


@dataclass(frozen=True)
class ExportColumn:
    """A channel: its ``values`` (nt,), unit and description. Modes are whole numbers; ``meanings``
    explain them."""

    name: str
    unit: str
    what: str
    values: np.ndarray
    meanings: str = ""


@dataclass(frozen=True)
class ExportTable:
    """``columns`` at the increasing ``time`` (nt,) [s] since the start, and attributes of the
    run."""

    time: np.ndarray
    columns: Sequence[ExportColumn]
    attributes: dict[str, object]

    def read_in(self, units: Units) -> ExportTable:
        """The same table, each column in the unit that it is read in. Modes stay as they are."""
        return replace(self, columns=[_read_in(column, units) for column in self.columns])


def table_of(run: xr.Dataset, patterns: Sequence[str], start: float, end: float) -> ExportTable:
    """Channels of a run that match one of the ``patterns`` (without patterns, all recorded
    channels), from ``start`` to ``end`` [s]. Raises InputError if nothing is left."""
    source = Source(run.encoding.get("source", "run"))
    time = np.asarray(run["time"].values, dtype=float)
    require_finite(source, time, None)
    require_rising(source, time, None)
    inside = (time >= start) & (time <= end)
    if not inside.any():
        there = f"{time[0]:g} to {time[-1]:g} s" if time.size else "no time"
        raise InputError(
            f"--from, --to: found {start:g} to {end:g} s, but the run has records for {there};"
            " expected an interval that contains some."
        )
    recorded = [*columns_of(run), *columns_of(run, modes=True)]
    known = dict.fromkeys([*recorded, *channel_names(run)]) if patterns else recorded
    picked, run = match_channels(known, patterns or ["*"], "--channels"), run.isel(time=inside)
    of = {name: select(RUN, run, name) for name in recorded if name in {*picked}}
    columns = [_column(run, name, *(of.get(name) or channel_series(run, name))) for name in picked]
    said = {name: run.attrs[name] for name in EXPORTED_ATTRIBUTES if name in run.attrs}
    return ExportTable(time[inside], columns, said)


def _read_in(column: ExportColumn, units: Units) -> ExportColumn:
    unit, factor = units.display_unit(column.unit)
    if factor == 1.0:
        return column
    return replace(column, unit=unit, values=factor * column.values)


def identifiers(
    columns: Iterable[ExportColumn], most: int, *taken: str
) -> Iterator[tuple[str, ExportColumn]]:
    """Columns by valid names: letters, digits and underscores, a letter first, at ``most`` so many
    characters, all different, none of ``taken``."""
    used = {*taken}
    for column in columns:
        bare = NOT_IN_NAMES.sub("_", column.name).strip("_")
        bare = bare if bare[:1].isalpha() else f"channel_{bare}"
        tries = (f"{bare[: most - len(end)]}{end}" for end in _ends())
        name = next(name for name in tries if name not in used)
        used.add(name)
        yield name, column


def _ends() -> Iterator[str]:
    yield ""
    for k in range(2, 1_000_000):
        yield f"_{k}"


def _column(run: xr.Dataset, name: str, values: np.ndarray, unit: str) -> ExportColumn:
    kind, *of = name.split(".")
    said = run[kind].attrs if kind in run else {}
    what = " ".join(str(said.get("long_name", kind.replace("_", " "))).split())
    what = f"{', '.join(of)}: {what}" if of else what
    if "flag_values" in said:
        return ExportColumn(
            name, "1", what, values.astype(np.int8), str(said.get("flag_meanings", ""))
        )
    return ExportColumn(name, unit, what, values)
