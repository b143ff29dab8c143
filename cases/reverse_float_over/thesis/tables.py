"""Means over seeds of each figure, as rows and as files."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from benchmarks.report import Row
from cases.reverse_float_over.thesis.aggregates import mean_of
from cases.reverse_float_over.thesis.runner import Record


def rows_of(records: Sequence[Record]) -> list[Row]:
    """A row for each variant and figure of one table. Runs without figures do not count."""
    rows: list[Row] = []
    for variant, found in _by_variant(record for record in records if record.figures).items():
        for name in found[0].figures:
            mean = mean_of(record.figures[name] for record in found)
            rows.append({"variant": variant, "figure": name, **mean._asdict()})
    return rows


def write_rows(rows: Iterable[Row], path: Path) -> None:
    """Rows with the same keys as a CSV file, numbers to six digits."""
    rows = list(rows)
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows({key: _text(value) for key, value in row.items()} for row in rows)


def read_rows(path: Path) -> list[dict[str, str]]:
    """The rows of a CSV file, as texts."""
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def _by_variant(records: Iterable[Record]) -> Mapping[str, list[Record]]:
    found: dict[str, list[Record]] = {}
    for record in records:
        found.setdefault(record.variant, []).append(record)
    return found


def _text(value: str | float) -> str | int:
    return f"{value:.6g}" if isinstance(value, float) else value
