"""YAML texts: nodes that know their line, limits on size, places of keys, messages about mistakes.

YAML as nodes that know their line, and their values.

PyYAML's own values are not used, because YAML 1.1 has traps. `1e6` is a text, `off` is false, `010`
is eight, `1:30` is ninety, and the last of two equal keys wins without a message.

Here a plain scalar is a number if it looks like one. Only `true` and `false` are switches. `null`,
`~` and an empty value are no value. Everything else, and everything in quotes, is text. Equal keys
are refused.

Merge keys, `<<: *anchor` or `<<: [*one, *other]`, provide keys that a mapping does not have itself.
Of several anchors the first has priority. null removes a merged key.
"""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import yaml
from yaml.nodes import CollectionNode, MappingNode, Node, ScalarNode, SequenceNode

from hydrosim.errors import InputError

NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?", re.ASCII)

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
        return at, _comma_problem(text.splitlines()[at.line], at.column)
    if is_flow:
        pair = ('"["', '"]"') if "sequence" in context else ('"{"', '"}"')
        return begun, BRACKET.format(*pair)
    if "simple key" in context:
        return begun, COLON
    if at is not None and ("block mapping" in context or "block collection" in context):
        return _column_problem(text.splitlines(), at)
    if "mapping values are not allowed" in problem and at is not None:
        return _colon_problem(text.splitlines(), at)
    return at, ", ".join(part for part in (context, problem) if part)


def _comma_problem(line: str, column: int) -> str:
    """Description of two entries without a comma between. At ``column`` is the colon of the second,
    or its beginning."""
    if line[column : column + 1] != ":":
        return COMMA.format(line[column:].split()[0].rstrip("}],"))
    words = re.split(r"[,{\[]|:\s", line[:column])[-1].split()
    return COMMA.format(words[-1]) if len(words) > 1 else TWO_COLONS


def _column_problem(lines: list[str], at: yaml.Mark) -> tuple[yaml.Mark, str]:
    """Place and description of a key in a wrong column.

    The parser reports a later, correct line if the first of several keys is in a wrong column. So
    of the reported line and the nearest line above that begins further left, the one is named whose
    column is rarer in the file.
    """
    columns = {k: _indent_of_line(line) for k, line in enumerate(lines) if _is_entry(line)}
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
        f'column {columns[k] + 1}, as "{_key_of_line(lines[k])}" in line {k + 1}' for k in others
    )
    words = _key_of_line(lines[odd]), columns[odd] + 1
    mark = yaml.Mark(at.name, 0, odd, columns[odd], None, 0)
    return mark, COLUMN.format(*words, expected or IN_ONE)


def _indent_of_line(line: str) -> int:
    """Number of blanks before the text of a line."""
    return len(line) - len(line.lstrip())


def _is_entry(line: str) -> bool:
    """Whether a line has more than blanks and a remark."""
    return bool(line.strip()) and not line.lstrip().startswith("#")


def _line_above(columns: dict[int, int], line: int) -> int | None:
    """The nearest line above that begins further left; ``columns`` are by line."""
    return next((k for k in reversed(columns) if k < line and columns[k] < columns[line]), None)


def _key_of_line(line: str) -> str:
    """Key of a line, or the beginning of its text."""
    return re.split(r"(?<=:)\s", line.strip())[0][:40]


def _colon_problem(lines: list[str], at: yaml.Mark) -> tuple[yaml.Mark, str]:
    """Place and description of a colon that makes no key."""
    if ": " in lines[at.line][: at.column]:
        return at, TWO_COLONS
    above = next((k for k in range(at.line - 1, -1, -1) if lines[k].strip()), None)
    if above is not None and ":" not in lines[above]:
        return at, NO_COLON_ABOVE.format(above + 1, lines[above].strip()[:60])
    return _column_problem(lines, at)


# Limits on the size of a YAML text and on its characters: more is not written by hand.

MOST_TEXT = 250_000  # characters: read in a few seconds
MOST_VALUES = 100_000  # values, with aliases expanded
MAX_NESTING = 40  # nested lists and mappings
MAX_LETTERS = {"key": 100, "text": 10_000}  # characters


def too_long(text: str) -> str:
    """Complaint about the length of a text; empty if it is acceptable."""
    if len(text) <= MOST_TEXT:
        return ""
    return (
        f"found {len(text):,} characters; expected at most {MOST_TEXT:,}; what is long belongs"
        " in files of their own: series as {file: FILE, column: NAME}, waves of a sea as"
        " components: {file: FILE}"
    )


def limit_complaints(node: Node | None) -> Iterator[tuple[yaml.Mark, str]]:
    """Complaints about nodes that are too large, too deep, or contain unprintable characters, with
    their places."""
    if node is None:
        return
    sizes: dict[int, tuple[int, int]] = {}
    yield from _measure_nodes(node, sizes, set())
    for scalar, kind in _all_scalars(node, set()):
        yield from _text_nodes(scalar, kind)


def _measure_nodes(
    node: Node, sizes: dict[int, tuple[int, int]], above: set[int]
) -> Iterator[tuple[yaml.Mark, str]]:
    """Enter the number of values in a node, and its depth, in ``sizes``; ``above`` are the nodes
    around it."""
    if id(node) in above:
        yield node.start_mark, "found an alias within what it stands for; expected it elsewhere"
        return
    if id(node) in sizes:
        return
    count = 1
    depth = 0
    for child in _child_nodes(node):
        for excess in _measure_nodes(child, sizes, above | {id(node)}):
            yield excess
            return
        inside, deep = sizes[id(child)]
        count = count + inside
        depth = max(depth, deep + 1)
    sizes[id(node)] = count, depth
    if depth > MAX_NESTING:
        yield node.start_mark, f"found {depth} levels in each other; expected {MAX_NESTING} at most"
    elif count > MOST_VALUES:
        text = f"found {count:,} values, with what aliases stand for; expected at most"
        yield node.start_mark, f"{text} {MOST_VALUES:,}"


def _child_nodes(node: Node) -> list[Node]:
    if isinstance(node, MappingNode):
        return [part for pair in node.value for part in pair]
    return node.value if isinstance(node, CollectionNode) else []


def _all_scalars(node: Node, seen: set[int]) -> Iterator[tuple[ScalarNode, str]]:
    """All scalars of a node once, each with its kind: key or text."""
    if id(node) in seen:
        return
    seen.add(id(node))
    if isinstance(node, ScalarNode):
        yield node, "text"
    keys = [key for key, _ in node.value] if isinstance(node, MappingNode) else []
    yield from ((key, "key") for key in keys if isinstance(key, ScalarNode))
    for child in _child_nodes(node):
        if child not in keys:
            yield from _all_scalars(child, seen)


def _text_nodes(node: ScalarNode, kind: str) -> Iterator[tuple[yaml.Mark, str]]:
    text = str(node.value)
    most = MAX_LETTERS[kind]
    if len(text) > most:
        yield node.start_mark, f"found a {kind} of {len(text)} characters; expected at most {most}"
    odd = [c for c in text if c not in "\t\n\r" and unicodedata.category(c) in ("Cc", "Cs")]
    if odd:
        found_text = f"found the character U+{ord(odd[0]):04X} in a {kind}"
        yield node.start_mark, f"{found_text}; expected characters that can be printed"


SCALAR_WORDS = {"true": True, "false": False, "null": None, "~": None, "": None}
MERGE = "tag:yaml.org,2002:merge"
INTEGER_TEXT = re.compile(r"[-+]?\d{1,18}", re.ASCII)
SETTING = "--set "
COMMAND_LINE_PREFIX = "--given "
"""Prefix of the name of a text that came from the command line."""


def compose_nodes(text: str, name: str) -> Node | None:
    """Nodes of a YAML text that messages call ``name``; None if it is empty.

    Raises InputError with the line of text that is not YAML, exceeds a limit, or repeats
    a key.
    """
    if excess := too_long(text):
        raise InputError(f"{name}: {excess}")
    try:
        loader = yaml.SafeLoader(text)
        loader.name = name
        node = loader.get_single_node()
        for mark, excess in limit_complaints(node):
            raise error_at(mark, excess)
        _refuse_bad_keys(node)
        node = _merge_anchors(node, {}) if node else None
    except yaml.MarkedYAMLError as error:
        at, what = describe(error, text)
        place = place_text(at) if at else name
        raise InputError(f"{place}: not valid YAML: {what}") from None
    except (yaml.YAMLError, ValueError, OverflowError) as error:  # bad escapes raise the latter
        raise InputError(f"{name}: not valid YAML: {str(error).splitlines()[0]}") from None
    except RecursionError:
        raise InputError(f"{name}: not valid YAML: nested too deeply, or in itself") from None
    return node


def plain_values(node: Node) -> Any:
    """The values of a node: dict, list, str, int, float, bool or None."""
    if isinstance(node, MappingNode):
        return {key: plain_values(value) for key, (_, value) in entry_nodes(node).items()}
    if isinstance(node, ScalarNode):
        return _scalar_value(node)
    return [plain_values(item) for item in node.value]


def _scalar_value(node: ScalarNode) -> str | float | bool | None:
    text = str(node.value)
    if node.style is not None:
        return text
    if text in SCALAR_WORDS:
        return SCALAR_WORDS[text]
    if INTEGER_TEXT.fullmatch(text):
        return int(text)
    return float(text) if NUMBER.fullmatch(text) else text


def entry_nodes(node: Node | None) -> dict[str, tuple[ScalarNode, Node]]:
    """Key node and value node of each entry of a mapping; empty for None."""
    return {key.value: (key, value) for key, value in _pairs_of_mapping(node)}


def _pairs_of_mapping(node: Node | None) -> list[tuple[ScalarNode, Node]]:
    return node.value if isinstance(node, MappingNode) else []


def locate_value(node: Node, keys: Sequence[str | int]) -> tuple[str, yaml.Mark]:
    """Dotted key and mark of the value at ``keys``; keys that do not exist are skipped (pydantic
    puts the names of union members between)."""
    names, mark = [], node.start_mark
    for key in keys:
        if isinstance(node, SequenceNode) and isinstance(key, int) and key < len(node.value):
            node = node.value[key]
            mark = node.start_mark
        elif key in (inside := entry_nodes(node)):
            name, node = inside[str(key)]
            mark = name.start_mark
        else:
            continue
        names.append(str(key))
    return ".".join(names), mark


def place_text(mark: yaml.Mark) -> str:
    """``file:line``; a setting of the command line has no lines."""
    return (
        mark.name
        if mark.name.startswith((SETTING, COMMAND_LINE_PREFIX))
        else f"{mark.name}:{mark.line + 1}"
    )


def error_at(mark: yaml.Mark, text: str) -> InputError:
    """An error about the place ``mark``."""
    return InputError(f"{place_text(mark)}: {text}")


def with_hint(text: str, remedy: str) -> str:
    """A message with its remedy, if there is one."""
    return f"{text}; {remedy}" if remedy else text


def empty_keys(node: Node, above: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """The keys to each entry of a mapping without a value."""
    for key, (_, value) in entry_nodes(node).items():
        if plain_values(value) is None:
            yield (*above, key)
        yield from empty_keys(value, (*above, key))
    for i, item in enumerate(node.value if isinstance(node, SequenceNode) else ()):
        yield from empty_keys(item, (*above, i))


def _refuse_bad_keys(node: Node | None) -> None:
    for mapping in _all_mappings(node):
        seen: dict[str, int] = {}
        for key, _ in mapping.value:
            if not isinstance(key, ScalarNode):
                raise error_at(key.start_mark, "found a list or mapping as key; expected a word")
            line = key.start_mark.line + 1
            if key.value in seen:
                first = f'found the key "{key.value}" twice, first in line {seen[key.value]}'
                raise error_at(key.start_mark, f"{first}; expected it once; remove one")
            seen[key.value] = line


def _all_mappings(node: Node | None) -> Iterator[MappingNode]:
    if isinstance(node, MappingNode):
        yield node
        for _, value in node.value:
            yield from _all_mappings(value)
    elif isinstance(node, SequenceNode):
        for value in node.value:
            yield from _all_mappings(value)


def _merge_anchors(node: Node, done: dict[int, Node]) -> Node:
    """The node with the entries of its merge keys; anchors stay shared."""
    if isinstance(node, ScalarNode):
        return node
    if id(node) not in done:
        ends = node.start_mark, node.end_mark, getattr(node, "flow_style", None)
        if isinstance(node, SequenceNode):
            items = [_merge_anchors(item, done) for item in node.value]
            done[id(node)] = SequenceNode(node.tag, items, *ends)
        else:
            entries = [(key, _merge_anchors(x, done)) for key, x in node.value]
            every = [
                pair for key, x in entries if key.tag == MERGE for pair in _merge_entries(key, x)
            ]
            under = {key.value: (key, x) for key, x in reversed(every)}
            entries_by_key = {key.value: (key, x) for key, x in entries if key.tag != MERGE}
            removed = {
                name
                for name in under.keys() & entries_by_key.keys()
                if plain_values(entries_by_key[name][1]) is None
            }
            merged = {
                n: pair for n, pair in {**under, **entries_by_key}.items() if n not in removed
            }
            done[id(node)] = MappingNode(node.tag, [*merged.values()], *ends)
    return done[id(node)]


def _merge_entries(key: ScalarNode, value: Node) -> Iterator[tuple[ScalarNode, Node]]:
    """The entries of the mappings in the value of a merge key."""
    for node in value.value if isinstance(value, SequenceNode) else [value]:
        if not isinstance(node, MappingNode):
            text = 'found no mapping after "<<"; expected one by its anchor, as in <<: *bow_line'
            raise error_at(key.start_mark, text)
        yield from node.value


# File and line of the keys of a YAML file, added once where a message leaves the program.

Places = Mapping[str, str]
"""``file:line`` by dotted key, "environment.waves.0.seed"."""

MOST_ITEMS = 20  # of a list: longer ones are tables of numbers
WORD = re.compile(r"[A-Za-z_]\w*(?:\.\w+)*")
SUBJECT = re.compile(rf"(?:^|: )({WORD.pattern})((?:, \w+)*)")


def places_of(node: Node) -> dict[str, str]:
    """The places of all keys of a document; keys set by the command line have none."""
    return {key: _mark_text(mark) for key, mark in _all_marks(node, "")}


def _mark_text(mark: yaml.Mark) -> str:
    return "" if mark.name.startswith(SETTING) else place_text(mark)


def _all_marks(node: Node, above: str) -> Iterator[tuple[str, yaml.Mark]]:
    if isinstance(node, MappingNode):
        for key, (name, value) in entry_nodes(node).items():
            yield f"{above}{key}", name.start_mark
            yield from _all_marks(value, f"{above}{key}.")
    elif isinstance(node, SequenceNode) and len(node.value) <= MOST_ITEMS:
        for k, item in enumerate(node.value):
            yield f"{above}{k}", item.start_mark
            yield from _all_marks(item, f"{above}{k}.")


def add_source_lines(text: str, places: Places) -> str:
    """A message with file and line before each of its lines that names a key."""
    return "\n".join(_add_source_line(line, places) for line in text.split("\n"))


def _add_source_line(line: str, places: Places) -> str:
    text = line.lstrip(" ")
    place = next(_named_places(text, places), "")
    file = place.rpartition(":")[0]
    if not place or place in text:
        return line
    return f"{line.removesuffix(text)}{place}: {text.removeprefix(f'{file}: ')}"


def _named_places(line: str, places: Places) -> Iterator[str]:
    """Places of the keys that a line begins with, or that follow its first colon: a dotted name, or
    a single word. For "bodies.barge.inertia, mass" the keys that exist, or else the mapping that
    should have them."""
    for match in SUBJECT.finditer(line):
        key, others = match.groups()
        if "." not in key and not line.startswith(f"{key}:"):
            continue
        above = key.rpartition(".")[0]
        beside = [f"{above}.{name}" for name in others.split(", ")[1:]]
        keys_there = [
            place_key for place_key in (key, *beside, *_parent_keys(key)) if place_key in places
        ]
        yield from [places[keys_there[0]]] if keys_there else []


def _parent_keys(key: str) -> Iterator[str]:
    """The mappings that contain a key, the nearest first."""
    while key := key.rpartition(".")[0]:
        yield key


@contextmanager
def source_context(places: Places) -> Iterator[None]:
    """Adds file and line to the messages of an InputError raised in this context."""
    try:
        yield
    except InputError as error:
        text = add_source_lines(str(error), places)
        if text == str(error):
            raise
        raise type(error)(text) from error


@contextmanager
def locating_in(path: Path) -> Iterator[None]:
    """Adds the line to the messages of an InputError that begin with a ``path`` and a key of that
    file. The key may itself be a dotted name, such as a parameter of a study."""
    try:
        yield
    except InputError as error:
        text = "\n".join(_text_with_file(line, path) for line in str(error).split("\n"))
        raise InputError(text) from error


def _text_with_file(line: str, path: Path) -> str:
    begin = f"{path}: "
    word = WORD.match(line, len(begin)) if line.startswith(begin) else None
    if word is None:
        return line
    node = compose_nodes(path.read_text(encoding="utf-8-sig"), str(path))
    places = places_of(node) if node else {}
    places_in_file = [place for key, place in places.items() if f".{key}".endswith(f".{word[0]}")]
    return f"{places_in_file[0]}: {line.removeprefix(begin)}" if places_in_file else line
