"""Comma-separated values: a comment on the origin, names, units, and numbers with enough digits to
read them back to the bit.

Names and units come from the run. Spreadsheets run a cell as a formula if it begins with =, +, - or
@. Such text is preceded by an apostrophe, also after characters that spreadsheets take for the end
of a cell.
"""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import TYPE_CHECKING

from hydrosim.documents.text import escape_unprintable

if TYPE_CHECKING:
    from hydrosim.results.export.table import ExportTable

FORMULA = re.compile(r"(^|[,;\t\r\n])(?=\s*[=+\-@＝＋－＠])")


def write(table: ExportTable, path: Path, mark: str) -> None:
    """Write the columns of a table as text."""
    with path.open("w", encoding="utf-8", newline="") as file:
        file.write(f"# {escape_unprintable(mark)}\n")
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["time", *(escape_formula(column.name) for column in table.columns)])
        rows.writerow(["s", *(escape_formula(column.unit) for column in table.columns)])
        values = [table.time.tolist(), *(column.values.tolist() for column in table.columns)]
        rows.writerows(zip(*values, strict=True))


def escape_formula(text: str) -> str:
    """Text in one line that no spreadsheet takes for a formula."""
    return escape_unprintable(FORMULA.sub(r"\1'", text))
