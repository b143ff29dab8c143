"""Tables of cases in text: a line a row, bars between the cells."""

import re


def rows(table: str) -> list[tuple[str, ...]]:
    r"""Cells of each line, without blanks around them. A backslash at its end joins the next line;
    the two letters \n in a cell are a line end."""
    lines = re.sub(r"\s*\\?\n\s*", lambda end: " " if "\\" in end[0] else "\n", table.strip())
    cells = (re.split(r"(?:^|\s)\|(?=\s|$)", line) for line in lines.split("\n"))
    return [tuple(cell.strip().replace(r"\n", "\n") for cell in row) for row in cells]


def sections(tables: str) -> dict[str, list[tuple[str, ...]]]:
    """Rows below each line of one cell, which is their name."""
    named: dict[str, list[tuple[str, ...]]] = {}
    for row in rows(tables):
        if len(row) == 1:
            named[row[0]] = under = []
        else:
            under.append(row)
    return named
