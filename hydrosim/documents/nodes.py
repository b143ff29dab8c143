"""YAML as nodes that know their line, and their values.

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
from collections.abc import Iterator, Sequence
from typing import Any

import yaml
from yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from hydrosim.documents.broken_yaml import describe
from hydrosim.documents.limits import limit_complaints, too_long
from hydrosim.documents.units import NUMBER
from hydrosim.errors import InputError

SCALAR_WORDS = {"true": True, "false": False, "null": None, "~": None, "": None}
MERGE = "tag:yaml.org,2002:merge"
INTEGER_TEXT = re.compile(r"[-+]?\d{1,18}", re.ASCII)
SETTING = "--set "
COMMAND_LINE_PREFIX = "--given "
"""Prefix of the name of a text that came from the command line."""


def compose_nodes(text: str, name: str) -> Node | None:
    """Nodes of a YAML text that messages call ``name``; None if it is empty.

    Raises InputError with the line of text that is not YAML, exceeds a limit (`limits`), or repeats
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
        node = _merge(node, {}) if node else None
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
        return _scalar(node)
    return [plain_values(item) for item in node.value]


def _scalar(node: ScalarNode) -> str | float | bool | None:
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
    return {key.value: (key, value) for key, value in _pairs(node)}


def _pairs(node: Node | None) -> list[tuple[ScalarNode, Node]]:
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
    for mapping in _mappings(node):
        seen: dict[str, int] = {}
        for key, _ in mapping.value:
            if not isinstance(key, ScalarNode):
                raise error_at(key.start_mark, "found a list or mapping as key; expected a word")
            line = key.start_mark.line + 1
            if key.value in seen:
                first = f'found the key "{key.value}" twice, first in line {seen[key.value]}'
                raise error_at(key.start_mark, f"{first}; expected it once; remove one")
            seen[key.value] = line


def _mappings(node: Node | None) -> Iterator[MappingNode]:
    if isinstance(node, MappingNode):
        yield node
        for _, value in node.value:
            yield from _mappings(value)
    elif isinstance(node, SequenceNode):
        for value in node.value:
            yield from _mappings(value)


def _merge(node: Node, done: dict[int, Node]) -> Node:
    """The node with the entries of its merge keys; anchors stay shared."""
    if isinstance(node, ScalarNode):
        return node
    if id(node) not in done:
        ends = node.start_mark, node.end_mark, getattr(node, "flow_style", None)
        if isinstance(node, SequenceNode):
            items = [_merge(item, done) for item in node.value]
            done[id(node)] = SequenceNode(node.tag, items, *ends)
        else:
            own = [(key, _merge(x, done)) for key, x in node.value]
            every = [pair for key, x in own if key.tag == MERGE for pair in _merge_entries(key, x)]
            under = {key.value: (key, x) for key, x in reversed(every)}
            said = {key.value: (key, x) for key, x in own if key.tag != MERGE}
            removed = {
                name for name in under.keys() & said.keys() if plain_values(said[name][1]) is None
            }
            found = {n: pair for n, pair in {**under, **said}.items() if n not in removed}
            done[id(node)] = MappingNode(node.tag, [*found.values()], *ends)
    return done[id(node)]


def _merge_entries(key: ScalarNode, value: Node) -> Iterator[tuple[ScalarNode, Node]]:
    """The entries of the mappings in the value of a merge key."""
    for each in value.value if isinstance(value, SequenceNode) else [value]:
        if not isinstance(each, MappingNode):
            text = 'found no mapping after "<<"; expected one by its anchor, as in <<: *bow_line'
            raise error_at(key.start_mark, text)
        yield from each.value
