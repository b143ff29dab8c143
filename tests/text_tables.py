"""Tables of cases in text: a line a row, bars between the cells."""

import re


def rows(table: str) -> list[tuple[str, ...]]:
    """Cells of each line, without needless blanks; a backslash at its end joins the next line."""
    lines = filter(None, map(str.strip, table.splitlines()))
    cells = (re.split(r"(?:^|\s)\|(?=\s|$)", line) for line in lines)
    return [tuple(" ".join(cell.split()) for cell in row) for row in cells]


def sections(tables: str) -> dict[str, list[tuple[str, ...]]]:
    """Rows below each line of one cell, which is their name."""
    named: dict[str, list[tuple[str, ...]]] = {}
    for row in rows(tables):
        if len(row) == 1:
            named[row[0]] = under = []
        else:
            under.append(row)
    return named
