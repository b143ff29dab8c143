"""Layers of a case file: the file that it `extends` lies below, settings of the command line lie
above.

Nodes are never changed in place: an anchor may share the same node elsewhere.
"""

from __future__ import annotations

import json
import os
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml
from yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from hydrosim.errors import InputError
from hydrosim.files import yaml_nodes
from hydrosim.files.messages import suggestion
from hydrosim.files.units import value_text

DUMPER = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
"""Writes the same text either way; that of libyaml takes a quarter of the time."""
EXTENDS = "extends"
MAX_WHOLE_FLOAT = 2.0**53  # up to which every whole number is a float
ORCAFLEX_KEYS = {"General", "VesselTypes", "LineTypes"}
MAX_SETTING_LETTERS = 200  # characters of a setting in a message
MAP = "tag:yaml.org,2002:map"
TEXT = "tag:yaml.org,2002:str"
REPLACING_KEYS = {
    "type",
    "law",
    "spectrum",
}  # a mapping with one of these keys replaces the one below
NAMED = {"bodies", "forces", "joints"}  # mappings whose keys are names given by the user
# keys of files, which are relative to the folder of their own file
FILES = {"hydrodynamics", "file", "case", "run", "mesh", "recipe"}


def read_case(path: Path, above: tuple[Path, ...] = ()) -> tuple[str, Node]:
    """Text and nodes of a case file, laid over the file that its key `extends` names, if any.

    Mappings are merged key by key, except one with a `type`, `law` or `spectrum` of its own, which
    replaces the one below. null removes a key. Relative paths in the file below start at its
    folder; they are changed to start at the folder of ``path``. ``above`` are the files that led
    here.

    Returns the file's own text, or the text of the merged file if it extends another. Raises
    InputError if a file cannot be read.
    """
    text = _read_text(path)
    node = yaml_nodes.compose_nodes(text, str(path))
    if not isinstance(node, MappingNode):
        raise InputError(f"{path}:1: found no keys; expected a case file with lines `key: value`")
    over = yaml_nodes.entry_nodes(node)
    if ORCAFLEX_KEYS & over.keys():
        raise InputError(
            f"{path}: found data of OrcaFlex; expected a case of hydrosim. A case may name it as"
            f" `hydrodynamics: {path.name}`, for its vessel type; the rest is described anew."
        )
    if EXTENDS not in over:
        return text, node
    _, named = over.pop(EXTENDS)
    if not isinstance(named, ScalarNode):
        named_text = value_text(yaml_nodes.plain_values(named))
        text = f"{EXTENDS}: found {named_text}; expected the name of a case file"
        raise yaml_nodes.error_at(named.start_mark, text)
    base = path.parent / str(yaml_nodes.plain_values(named))
    chain = (*above, path.resolve())
    if not os.path.isfile(base):  # Path.is_file raises where a name is too long
        raise yaml_nodes.error_at(
            named.start_mark, f"{EXTENDS}: found no file {base}; expected a case file"
        )
    if base.resolve() in chain:
        raise yaml_nodes.error_at(
            named.start_mark, f"{EXTENDS}: {base} leads back here; expected another file"
        )
    under = _prefix_paths(
        read_case(base, chain)[1], Path(str(yaml_nodes.plain_values(named))).parent
    )
    whole = _merge_nodes(under, _mapping(over, node))
    return f"# {path.name} over {base.name}\n{yaml_text(whole)}", whole


def apply_setting(node: Node, setting: str, option: str = yaml_nodes.SETTING) -> Node:
    """``node`` with the ``KEY=VALUE`` of an ``option`` laid over it. The key is dotted; a number in
    it is an index into a list. The value is YAML, and null removes the key. Raises InputError for
    an unknown key, with the keys that exist."""
    key, _, text = setting.partition("=")
    name = option + (
        setting if len(setting) <= MAX_SETTING_LETTERS else f"{setting[:MAX_SETTING_LETTERS]}..."
    )
    value = yaml_nodes.compose_nodes(text, name)
    if not key.strip() or value is None:
        raise InputError(f"{name}: found no key or no value; expected KEY=VALUE; null removes")
    return _assign_value(node, key.strip().split("."), value)


def settings_of(values: Mapping[str, Any]) -> list[str]:
    """``KEY=VALUE`` of each entry; values are numbers, texts, lists, mappings, arrays or None.
    Whole numbers are written as such, because a row of a table makes all of its numbers floats."""
    return [
        f"{key}={json.dumps(_whole_if_possible(value), default=_plain_value, ensure_ascii=False)}"
        for key, value in values.items()
    ]


def _whole_if_possible(value: Any) -> Any:
    is_whole = isinstance(value, float) and value.is_integer() and abs(value) < MAX_WHOLE_FLOAT
    return int(value) if is_whole else value


def _plain_value(value: Any) -> Any:
    """numpy's numbers and arrays as Python's, other values (a path) as text."""
    return value.tolist() if hasattr(value, "tolist") else str(value)


def yaml_text(node: Node) -> str:
    """The nodes as YAML text."""
    return str(yaml.serialize(node, Dumper=DUMPER, allow_unicode=True, width=100))


def _read_text(path: Path) -> str:
    if os.path.isdir(path):
        raise InputError(f"{path}: found a directory; expected a case file (YAML)")
    if os.path.exists(path) and not os.path.isfile(path):
        raise InputError(f"{path}: found a pipe or a device; expected a case file (YAML)")
    try:
        return path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        text = f"found no such file; expected a YAML file in the folder {path.parent.absolute()}"
        raise InputError(f"{path}: {text}; check its name and its folder") from None
    except OSError as error:
        text = f"found a file that cannot be read ({error.strerror}); expected a YAML file"
        raise InputError(f"{path}: {text}") from None
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise InputError(f"{path}:{line}: found bytes that are no text; expected UTF-8") from None


def _prefix_paths(node: Node, folder: Path) -> Node:
    """``node`` with ``folder`` before all relative paths."""
    if isinstance(node, SequenceNode):
        items = [_prefix_paths(item, folder) for item in node.value]
        return SequenceNode(node.tag, items, *_marks_of_node(node), node.flow_style)
    if not isinstance(node, MappingNode):
        return node
    moved = {
        key: (name, _prefix_paths(value, folder))
        for key, (name, value) in yaml_nodes.entry_nodes(node).items()
    }
    for key in FILES & moved.keys():
        name, value = moved[key]
        if isinstance(value, ScalarNode) and not _is_null(value):
            path = str(folder / value.value)
            moved[key] = name, ScalarNode(value.tag, path, *_marks_of_node(value), value.style)
    return _mapping(moved, node)


def _merge_nodes(base: Node | None, over: Node) -> Node:
    if not isinstance(base, MappingNode) or not isinstance(over, MappingNode):
        return over
    if REPLACING_KEYS & yaml_nodes.entry_nodes(over).keys():
        return over
    result = yaml_nodes.entry_nodes(base)
    for key, (name, value) in yaml_nodes.entry_nodes(over).items():
        if _is_null(value):
            _require_keys(key, result, name)
            del result[key]
        else:
            _, under = result.get(key, (name, None))
            result[key] = name, _merge_nodes(under, value)
    return _mapping(result, base)


def _assign_value(node: Node | None, keys: Sequence[str], value: Node) -> Node:
    """``node``, or a new mapping, with ``value`` at ``keys``; list entries, bodies and forces must
    exist already."""
    if not keys:
        return value
    key = keys[0]
    rest = keys[1:]
    if isinstance(node, SequenceNode):
        return _assigned_item(node, key, rest, value)
    if isinstance(node, ScalarNode) and not _is_null(node):
        text = f'found the value "{node.value}" there; expected no key "{key}" below it'
        raise yaml_nodes.error_at(value.start_mark, text)
    inside = yaml_nodes.entry_nodes(node)
    new = ScalarNode(TEXT, key, *_marks_of_node(value))
    name, under = inside.get(key, (new, None))
    if key in NAMED and len(rest) > 1:
        _require_keys(rest[0], yaml_nodes.entry_nodes(under), value)
    inside[key] = name if rest else new, _assign_value(under, rest, value)
    if not rest and _is_null(value):
        _require_keys(key, yaml_nodes.entry_nodes(node), value)
        del inside[key]
    return _mapping(inside, node or value)


def _assigned_item(node: SequenceNode, key: str, rest: Sequence[str], value: Node) -> SequenceNode:
    items = {str(i): item for i, item in enumerate(node.value)}
    _require_keys(key, items, value)
    items[key] = _assign_value(items[key], rest, value)
    return SequenceNode(node.tag, list(items.values()), *_marks_of_node(node), node.flow_style)


def _require_keys(key: str, names: Collection[str], at: Node) -> None:
    if key not in names:
        text = f'found no "{key}" there; expected one of: {", ".join(names) or "nothing"}'
        raise yaml_nodes.error_at(at.start_mark, yaml_nodes.with_hint(text, suggestion(key, names)))


def _mapping(inside: Mapping[str, tuple[ScalarNode, Node]], like: Node) -> MappingNode:
    flow = like.flow_style if isinstance(like, MappingNode) else False
    return MappingNode(MAP, list(inside.values()), *_marks_of_node(like), flow)


def _marks_of_node(node: Node) -> tuple[yaml.Mark, yaml.Mark]:
    return node.start_mark, node.end_mark


def _is_null(node: Node) -> bool:
    return yaml_nodes.plain_values(node) is None
