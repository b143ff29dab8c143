"""File and line of the keys of a YAML file, for messages that name a key after the file was read.

Messages name a key such as "bodies.barge.mass". Code that computes knows keys, not files. The code
that read the file adds the place once, where a message leaves the program.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import yaml
from yaml.nodes import MappingNode, Node, SequenceNode

from hydrosim.documents.nodes import SETTING, compose_nodes, entry_nodes, place_text
from hydrosim.errors import InputError

Places = Mapping[str, str]
"""``file:line`` by dotted key, "environment.waves.0.seed"."""

MOST_ITEMS = 20  # of a list: longer ones are tables of numbers
WORD = re.compile(r"[A-Za-z_]\w*(?:\.\w+)*")
SUBJECT = re.compile(rf"(?:^|: )({WORD.pattern})((?:, \w+)*)")


def places_of(node: Node) -> dict[str, str]:
    """The places of all keys of a document; keys set by the command line have none."""
    return {key: _mark_text(mark) for key, mark in _marks(node, "")}


def _mark_text(mark: yaml.Mark) -> str:
    return "" if mark.name.startswith(SETTING) else place_text(mark)


def _marks(node: Node, above: str) -> Iterator[tuple[str, yaml.Mark]]:
    if isinstance(node, MappingNode):
        for key, (name, value) in entry_nodes(node).items():
            yield f"{above}{key}", name.start_mark
            yield from _marks(value, f"{above}{key}.")
    elif isinstance(node, SequenceNode) and len(node.value) <= MOST_ITEMS:
        for k, item in enumerate(node.value):
            yield f"{above}{k}", item.start_mark
            yield from _marks(item, f"{above}{k}.")


def add_source_lines(text: str, places: Places) -> str:
    """A message with file and line before each of its lines that names a key."""
    return "\n".join(_add_source_line(line, places) for line in text.split("\n"))


def _add_source_line(line: str, places: Places) -> str:
    place = next(_named_places(line, places), "")
    file = place.rpartition(":")[0]
    if not place or place in line:
        return line
    return f"{place}: {line.removeprefix(f'{file}: ')}"


def _named_places(line: str, places: Places) -> Iterator[str]:
    """Places of the keys that a line begins with, or that follow its first colon: a dotted name, or
    a single word. For "bodies.barge.inertia, mass" the keys that exist, or else the mapping that
    should have them."""
    for found in SUBJECT.finditer(line):
        key, others = found.groups()
        if "." not in key and not line.startswith(f"{key}:"):
            continue
        above = key.rpartition(".")[0]
        beside = [f"{above}.{name}" for name in others.split(", ")[1:]]
        known = [each for each in (key, *beside, *_parent_keys(key)) if each in places]
        yield from [places[known[0]]] if known else []


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
        text = "\n".join(_in_file(line, path) for line in str(error).split("\n"))
        raise InputError(text) from error


def _in_file(line: str, path: Path) -> str:
    begin = f"{path}: "
    word = WORD.match(line, len(begin)) if line.startswith(begin) else None
    if word is None:
        return line
    node = compose_nodes(path.read_text(encoding="utf-8-sig"), str(path))
    places = places_of(node) if node else {}
    found = [place for key, place in places.items() if f".{key}".endswith(f".{word[0]}")]
    return f"{found[0]}: {line.removeprefix(begin)}" if found else line
