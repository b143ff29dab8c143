"""Limits on the size of a YAML text and on its characters. Nobody writes more by hand, but a
program or an attacker may."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator

import yaml
from yaml.nodes import CollectionNode, MappingNode, Node, ScalarNode

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
    yield from _measure(node, sizes, set())
    for scalar, kind in _scalars(node, set()):
        yield from _of_text(scalar, kind)


def _measure(
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
    for child in _children(node):
        for excess in _measure(child, sizes, above | {id(node)}):
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


def _children(node: Node) -> list[Node]:
    if isinstance(node, MappingNode):
        return [part for pair in node.value for part in pair]
    return node.value if isinstance(node, CollectionNode) else []


def _scalars(node: Node, seen: set[int]) -> Iterator[tuple[ScalarNode, str]]:
    """All scalars of a node once, each with its kind: key or text."""
    if id(node) in seen:
        return
    seen.add(id(node))
    if isinstance(node, ScalarNode):
        yield node, "text"
    keys = [key for key, _ in node.value] if isinstance(node, MappingNode) else []
    yield from ((key, "key") for key in keys if isinstance(key, ScalarNode))
    for child in _children(node):
        if child not in keys:
            yield from _scalars(child, seen)


def _of_text(node: ScalarNode, kind: str) -> Iterator[tuple[yaml.Mark, str]]:
    text = str(node.value)
    most = MAX_LETTERS[kind]
    if len(text) > most:
        yield node.start_mark, f"found a {kind} of {len(text)} characters; expected at most {most}"
    odd = [c for c in text if c not in "\t\n\r" and unicodedata.category(c) in ("Cc", "Cs")]
    if odd:
        found_text = f"found the character U+{ord(odd[0]):04X} in a {kind}"
        yield node.start_mark, f"{found_text}; expected characters that can be printed"
