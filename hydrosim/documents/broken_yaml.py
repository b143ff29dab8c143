"""Messages about a text that is not YAML, in plain words, with its line and a remedy."""

from __future__ import annotations

import re

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
COLUMN = (
    "found a line that begins in another column than the keys around it; expected the keys of one"
    " mapping in one column; mend the blanks at its beginning"
)
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
    if "flow sequence" in context or "flow mapping" in context:
        pair = ('"["', '"]"') if "sequence" in context else ('"{"', '"}"')
        return begun, BRACKET.format(*pair)
    if "simple key" in context:
        return begun, COLON
    if "block mapping" in context or "block collection" in context:
        return at, COLUMN
    if "mapping values are not allowed" in problem and at is not None:
        return at, _of_colon(text.splitlines(), at)
    return at, ", ".join(part for part in (context, problem) if part)


def _of_colon(lines: list[str], at: yaml.Mark) -> str:
    """Description of a colon that makes no key."""
    if ": " in lines[at.line][: at.column]:
        return TWO_COLONS
    above = next((k for k in range(at.line - 1, -1, -1) if lines[k].strip()), None)
    if above is not None and ":" not in lines[above]:
        return NO_COLON_ABOVE.format(above + 1, lines[above].strip()[:60])
    return COLUMN
