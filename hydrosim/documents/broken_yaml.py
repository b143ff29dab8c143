"""Messages about a text that is not YAML, in plain words, with its line and a remedy."""

from __future__ import annotations

import re
from collections import Counter

import yaml

TAB = 'found a tab; expected blanks: indent each level by two blanks, "  key: value"'
ODD = "found the character {0} at the beginning of a value; put the value in quotes"
QUOTE = "found a quote that is not closed; expected the same quote again at the end of the text"
BRACKET = "found a bracket {0} that is not closed; expected {1} after its last value"
COLON = (
    'found no colon with a blank after it; expected "key: value"; write "body: barge", not'
    ' "body:barge"'
)
TWO_COLONS = (
    "found a second colon in a value; expected a text in quotes if it has a colon in it:"
    ' title: "Barge: moored"'
)
COMMA = (
    'found no comma between two entries, before "{0}"; expected "{{key: value, key: value}}" or'
    ' "[value, value]"; put a comma before "{0}"'
)
COLUMN = (
    'found "{0}" in column {1}, another column than the keys around it; expected {2}; mend the'
    " blanks at the beginning of the line"
)
IN_ONE = "the keys of one mapping in one column"
NO_COLON_ABOVE = (
    'found no colon in line {0}, "{1}", above keys that belong to it; expected "key: value" or'
    ' "key:" there'
)


def describe(error: yaml.MarkedYAMLError, text: str) -> tuple[yaml.Mark | None, str]:
    """Place and description of the mistake, from an error of PyYAML."""
    problem = error.problem or ""
    context = error.context or ""
    at = error.problem_mark or error.context_mark
    begun = error.context_mark or at
    if "'\\t'" in problem:
        return at, TAB
    if odd := re.search(r"found character ('.') that cannot start", problem):
        return at, ODD.format(odd[1])
    if "quoted scalar" in context:
        return begun, QUOTE
    is_flow = "flow sequence" in context or "flow mapping" in context
    is_entry = re.search(r"got '(:|\{|\[|<scalar>)'", problem)
    if is_flow and is_entry and at is not None and begun is not None and at.line == begun.line:
        return at, _of_comma(text.splitlines()[at.line], at.column)
    if is_flow:
        pair = ('"["', '"]"') if "sequence" in context else ('"{"', '"}"')
        return begun, BRACKET.format(*pair)
    if "simple key" in context:
        return begun, COLON
    if at is not None and ("block mapping" in context or "block collection" in context):
        return _of_column(text.splitlines(), at)
    if "mapping values are not allowed" in problem and at is not None:
        return _of_colon(text.splitlines(), at)
    return at, ", ".join(part for part in (context, problem) if part)


def _of_comma(line: str, column: int) -> str:
    """Description of two entries without a comma between. At ``column`` is the colon of the second,
    or its beginning."""
    if line[column : column + 1] != ":":
        return COMMA.format(line[column:].split()[0].rstrip("}],"))
    words = re.split(r"[,{\[]|:\s", line[:column])[-1].split()
    return COMMA.format(words[-1]) if len(words) > 1 else TWO_COLONS


def _of_column(lines: list[str], at: yaml.Mark) -> tuple[yaml.Mark, str]:
    """Place and description of a key in a wrong column.

    The parser reports a later, correct line if the first of several keys is in a wrong column. So
    of the reported line and the nearest line above that begins further left, the one is named whose
    column is rarer in the file.
    """
    columns = {k: _column(line) for k, line in enumerate(lines) if _is_entry(line)}
    if at.line not in columns:
        return at, COLUMN.format("", at.column + 1, IN_ONE)
    usual = Counter(columns.values())
    above = _line_above(columns, at.line)
    is_above = above is not None and usual[columns[above]] < usual[columns[at.line]]
    odd = above if above is not None and is_above else at.line
    parent = _line_above(columns, odd)
    others = [] if parent is None else [parent]
    if is_above:
        others.append(at.line)
    elif parent is not None:
        others += [k for k in columns if parent < k < odd][:1]
    expected = ", or ".join(
        f'column {columns[k] + 1}, as "{_words(lines[k])}" in line {k + 1}' for k in others
    )
    found = _words(lines[odd]), columns[odd] + 1
    mark = yaml.Mark(at.name, 0, odd, columns[odd], None, 0)
    return mark, COLUMN.format(*found, expected or IN_ONE)


def _column(line: str) -> int:
    """Number of blanks before the text of a line."""
    return len(line) - len(line.lstrip())


def _is_entry(line: str) -> bool:
    """Whether a line has more than blanks and a remark."""
    return bool(line.strip()) and not line.lstrip().startswith("#")


def _line_above(columns: dict[int, int], line: int) -> int | None:
    """The nearest line above that begins further left; ``columns`` are by line."""
    return next((k for k in reversed(columns) if k < line and columns[k] < columns[line]), None)


def _words(line: str) -> str:
    """Key of a line, or the beginning of its text."""
    return re.split(r"(?<=:)\s", line.strip())[0][:40]


def _of_colon(lines: list[str], at: yaml.Mark) -> tuple[yaml.Mark, str]:
    """Place and description of a colon that makes no key."""
    if ": " in lines[at.line][: at.column]:
        return at, TWO_COLONS
    above = next((k for k in range(at.line - 1, -1, -1) if lines[k].strip()), None)
    if above is not None and ":" not in lines[above]:
        return at, NO_COLON_ABOVE.format(above + 1, lines[above].strip()[:60])
    return _of_column(lines, at)
