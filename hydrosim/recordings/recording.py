"""`Recording`: columns of a file, by name or number, with their units if the file has them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hydrosim.documents.text import TIME_COLUMN, Source, name_and_unit
from hydrosim.documents.units import value_text


@dataclass(frozen=True)
class RecordedColumn:
    """Values (n,) of a column ``name``, in ``unit`` ("" for a plain number, None if unknown)."""

    name: str
    unit: str | None
    value: np.ndarray


@dataclass(frozen=True)
class Recording:
    """All columns of a file, including the time, of one length. ``form`` is the format of the file,
    ``lines`` are the line numbers of a text, and ``left_out`` names data that are not over time."""

    source: Source
    form: str
    columns: Sequence[RecordedColumn]
    lines: Sequence[int] | None = None
    left_out: Sequence[str] = ()

    def column(self, key: str | int) -> RecordedColumn:
        """Column of that name, with or without its unit, or of that number, from 1 on. Raises
        InputError that lists the columns."""
        if isinstance(key, int):
            if not 1 <= key <= len(self.columns):
                text = f"found no column {key}; expected a number from 1 to {len(self.columns)}"
                self.source.wrong(text)
            return self.columns[key - 1]
        named = [column for column in self.columns if column.name == key]
        named = named or [c for c in self.columns if name_and_unit(c.name)[0] == key]
        if len(named) > 1:
            self.source.wrong(f"found more than one column {value_text(key)}; use its number")
        if not named:
            self.source.unknown("column", key, [column.name for column in self.columns])
        return named[0]

    def time_column(self) -> RecordedColumn:
        """Column named time or t, else the first."""
        return next((column for column in self.columns if is_time(column.name)), self.columns[0])


def is_time(name: str) -> bool:
    """Whether a name is "time", "Time (s)", "test3.t" or similar."""
    return TIME_COLUMN.fullmatch(name_and_unit(name)[0].rsplit(".")[-1]) is not None


def of_arrays(
    source: Source, form: str, arrays: Mapping[str, np.ndarray], units: Mapping[str, str | None]
) -> Recording:
    """Recording from the arrays of a file. It keeps arrays that are as long as the array of the
    time, or else of the most frequent length. An array (n, m) or (m, n) gives m columns, with their
    number in the name."""
    numbers = {name: a for name, a in arrays.items() if a.dtype.kind in "iuf" and a.size > 1}
    lengths = [max(a.shape) for name, a in numbers.items() if is_time(name)]
    lengths = lengths or [
        n for n, _ in Counter(max(a.shape) for a in numbers.values()).most_common()
    ]
    columns, left_out = list[RecordedColumn](), list[str]()
    for name, array in numbers.items():
        rows = _over_time(np.asarray(array, dtype=float), lengths[0])
        left_out += [] if rows else [name]
        for i, row in enumerate(rows, 1):
            columns.append(
                RecordedColumn(f"{name} {i}" if len(rows) > 1 else name, units.get(name), row)
            )
    if not columns:
        source.wrong(
            "found no numbers over time; expected arrays of one length, one of which is the time"
        )
    return Recording(source, form, columns, left_out=left_out)


def _over_time(array: np.ndarray, count: int) -> list[np.ndarray]:
    """Columns of an array that is over time along either dimension; empty if it is not."""
    flat = np.squeeze(array)
    if flat.ndim == 1 and flat.size == count:
        return [flat]
    if flat.ndim == 2 and count in flat.shape:
        return list(flat.T if flat.shape[0] == count else flat)
    return []
