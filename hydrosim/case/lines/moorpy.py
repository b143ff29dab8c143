"""Reader of MoorPy's YAML files: line types, points and lines (MoorPy 1.3, `System.parseYAML`).
RAFT has the same below its key mooring.

Files of MoorPy in MoorDyn's format are read by `hydrosim.case.lines.moordyn`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NoReturn

from yaml.nodes import Node

from hydrosim.case.lines import sections
from hydrosim.case.lines.sections import read_number
from hydrosim.case.lines.system import LineType, Piece, Point, PointSupport, System
from hydrosim.files.text import Source
from hydrosim.files.units import Quantity, value_text
from hydrosim.files.yaml_nodes import compose_nodes, locate_value, plain_values
from hydrosim.scene import OmittedEntry, Question

REQUIRED_KEYS = ("line_types", "points", "lines")
POINT_TYPES = (  # what holds a point, by what its type contains; the first that does so counts
    ("anch", PointSupport.EARTH),
    ("fix", PointSupport.EARTH),
    ("body", PointSupport.BODY),
    ("fair", PointSupport.BODY),
    ("ves", PointSupport.BODY),
    ("coupl", PointSupport.BODY),
    ("con", PointSupport.LINES),
    ("free", PointSupport.LINES),
)
KNOWN_KEYS = {  # keys that are read, or that a line in static balance does not have
    "": {*REQUIRED_KEYS, "water_depth", "rho", "water_density", "bodies", "anchor_types", "name"},
    "line_types": {
        *("name", "diameter", "mass_density", "stiffness", "transverse_drag", "material"),
        *("breaking_load", "cost", "tangential_drag"),
        *("transverse_added_mass", "tangential_added_mass"),
    },
    "points": {"name", "type", "location", "mass", "volume", "anchor_type"},
    "lines": {"name", "endA", "endB", "type", "lineType", "length"},
}
UNKNOWN_KEY = "No key of this name is known here; see that the line is as you mean it."


@dataclass(frozen=True)
class MappingEntry:
    """A mapping of a file: its ``values``, the ``keys`` that lead to it from the ``node`` of the
    file."""

    source: Source
    node: Node
    keys: tuple[str | int, ...]
    values: Mapping[str, Any]

    @property
    def row(self) -> int:
        """Its line in the file."""
        return locate_value(self.node, self.keys)[1].line + 1

    def refuse(self, text: str, *keys: str | int) -> NoReturn:
        """Raises InputError with key and line."""
        name, mark = locate_value(self.node, (*self.keys, *keys))
        self.source.wrong(f"{name}: {text}" if name else text, mark.line + 1)

    def find_value(self, *keys: str) -> Any:
        """The value of the first of these keys that is there."""
        for key in keys:
            if self.values.get(key) is not None:
                return self.values[key]
        given_keys = ", ".join(key for key, value in self.values.items() if value is not None)
        self.refuse(f"found {given_keys or 'nothing'}; expected a value of {keys[0]} too")

    def read_name(self, *keys: str) -> str:
        """A name: a text or a number."""
        value = self.find_value(*keys)
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            self.refuse(f"found {value_text(value)}; expected a name", keys[0])
        return str(value)

    def number(self, key: str, quantity: Quantity) -> float:
        """A number that must be there."""
        return self._number(self.find_value(key), quantity, key)

    def optional_number(self, key: str, quantity: Quantity) -> float | None:
        """A number that may be missing."""
        value = self.values.get(key)
        return None if value is None else self._number(value, quantity, key)

    def place(self, key: str) -> tuple[float, float, float]:
        """Three coordinates."""
        value = self.find_value(key)
        if not isinstance(value, list) or len(value) != 3:
            self.refuse(f"found {value_text(value)}; expected three coordinates", key)
        x, y, z = (
            self._number(coordinate, sections.COORDINATE, key, k)
            for k, coordinate in enumerate(value)
        )
        return x, y, z

    def _number(self, value: object, quantity: Quantity, *keys: str | int) -> float:
        name, mark = locate_value(self.node, (*self.keys, *keys))
        return read_number(self.source, mark.line + 1, value, quantity, name)

    def entries(self, key: str) -> Iterator[MappingEntry]:
        """The mappings in a list."""
        value = self.find_value(key)
        if not isinstance(value, list):
            self.refuse(f"found {value_text(value)}; expected a list", key)
        for k, entry in enumerate(value):
            if not isinstance(entry, Mapping):
                self.refuse(f"found {value_text(entry)}; expected a mapping", key, k)
            yield MappingEntry(self.source, self.node, (*self.keys, key, k), entry)

    def unknown_keys(self, kind: str) -> Iterator[OmittedEntry]:
        """Keys that are not read."""
        for key in self.values:
            if key not in KNOWN_KEYS[kind]:
                name, mark = locate_value(self.node, (*self.keys, key))
                found_text = f"the key {name} in line {mark.line + 1}"
                yield OmittedEntry(Question.FILES, found_text, "it is left out", UNKNOWN_KEY)


def is_moorpy(values: object) -> bool:
    """Whether values of a YAML file are a mooring system of MoorPy, or hold one."""
    if not isinstance(values, Mapping):
        return False
    return any(
        isinstance(mapping, Mapping) and {*REQUIRED_KEYS} <= {*mapping}
        for mapping in (values, values.get("mooring"))
    )


def read_moorpy(source: Source) -> System:
    """The mooring system of a YAML file. Raises InputError about what is wrong."""
    source.head(1)
    try:
        text = source.file.read_text("utf-8-sig")
    except UnicodeDecodeError:
        source.wrong("found bytes that are no text; expected YAML in UTF-8")
    node = compose_nodes(text, str(source.file))
    values = plain_values(node) if node else None
    if node is None or not isinstance(values, Mapping) or not is_moorpy(values):
        keys = f"{', '.join(REQUIRED_KEYS[:-1])} and {REQUIRED_KEYS[-1]}"
        source.wrong(f"found no keys {keys}; expected a system of MoorPy, or a case of hydrosim")
    if {*REQUIRED_KEYS} <= {*values}:
        return _read_system(MappingEntry(source, node, (), values))
    return _read_system(MappingEntry(source, node, ("mooring",), values["mooring"]))


def _read_system(system: MappingEntry) -> System:
    if system.values.get("bodies"):
        text = "found bodies; expected points of type fairlead; bodies are in the case"
        system.refuse(text, "bodies")
    parts = {kind: list(system.entries(kind)) for kind in REQUIRED_KEYS}
    unknown = [*system.unknown_keys("")]
    for kind, entries in parts.items():
        for entry in entries:
            unknown += entry.unknown_keys(kind)
    density = system.optional_number("rho", sections.DENSITY)
    if density is None:
        density = system.optional_number("water_density", sections.DENSITY)
    lines = {str(entry.values.get("name", k)): entry for k, entry in enumerate(parts["lines"], 1)}
    if len(lines) < len(parts["lines"]):
        system.refuse("found one name of two lines; expected each once", "lines")
    return System(
        system.source.file,
        {name: _read_type(entry) for name, entry in _named_entries(parts["line_types"])},
        {name: _read_point(entry) for name, entry in _named_entries(parts["points"])},
        {name: _read_piece(entry) for name, entry in lines.items()},
        density=density,
        depth=system.optional_number("water_depth", sections.DEPTH),
        left_out=tuple(unknown),
    )


def _named_entries(parts: list[MappingEntry]) -> Iterator[tuple[str, MappingEntry]]:
    """Each with its name, which no other may have."""
    seen = set()
    for entry in parts:
        name = entry.read_name("name")
        if name in seen:
            entry.refuse(f"found {name} twice; expected each name once", "name")
        seen.add(name)
        yield name, entry


def _read_type(entry: MappingEntry) -> LineType:
    return LineType(
        entry.number("diameter", sections.DIAMETER),
        entry.number("mass_density", sections.MASS_PER_LENGTH),
        entry.number("stiffness", sections.AXIAL_STIFFNESS),
        entry.optional_number("transverse_drag", sections.DRAG_COEFFICIENT) or 0.0,
    )


def _read_point(entry: MappingEntry) -> Point:
    kind = entry.read_name("type").lower()
    held = next((held for word, held in POINT_TYPES if word in kind), None)
    if held is None:
        entry.refuse(f"found {value_text(kind)}; expected fixed, fairlead or free", "type")
    return Point(
        held,
        entry.place("location"),
        entry.optional_number("mass", sections.MASS) or 0.0,
        entry.optional_number("volume", sections.VOLUME) or 0.0,
        kind if "body" in kind else "",
        entry.row,
    )


def _read_piece(entry: MappingEntry) -> Piece:
    ends = (entry.read_name("endA"), entry.read_name("endB"))
    kind = entry.read_name("type", "lineType")
    return Piece(kind, ends, entry.number("length", sections.LINE_LENGTH), entry.row)
