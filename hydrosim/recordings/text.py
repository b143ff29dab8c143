"""Recordings in text: csv, columns separated by blanks or tabs, and tables of aNySIM."""

from __future__ import annotations

from itertools import zip_longest

from hydrosim.documents.text import Source, name_and_unit, parse, readable_unit
from hydrosim.recordings.recording import RecordedColumn, Recording


def read(source: Source) -> Recording:
    """Columns of a text file; columns without names are called "column 2" and so on."""
    table = parse(source)
    names = table.names or [f"column {i}" for i in range(1, table.rows.shape[1] + 1)]
    columns = [
        RecordedColumn(name, name_and_unit(name)[1] if unit is None else readable_unit(unit), value)
        for name, unit, value in zip_longest(names, table.units, table.rows.T)
    ]
    return Recording(source, "text", columns, table.lines)
