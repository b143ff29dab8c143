"""Reader of MoorPy's YAML files: line types, points and lines (MoorPy 1.3, `System.parseYAML`).

Files of MoorPy in MoorDyn's format are read by `hydrosim.case.lines.moordyn`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hydrosim.case.lines.moordyn import number
from hydrosim.case.lines.system import Held, LineType, Piece, Point, System
from hydrosim.documents.nodes import compose, plain
from hydrosim.documents.text import Source

HELD = {"fix": Held.EARTH, "anch": Held.EARTH, "con": Held.LINES, "free": Held.LINES}
ON_BODY = ("fair", "ves", "coupl", "body")


def is_moorpy(values: object) -> bool:
    """Whether values of a YAML file are a mooring system of MoorPy."""
    return isinstance(values, Mapping) and {"line_types", "points", "lines"} <= set(values)


def read_moorpy(source: Source) -> System:
    """The mooring system of a YAML file. Raises InputError about what is wrong."""
    source.head(1)
    node = compose(source.file.read_text("utf-8-sig"), str(source.file))
    values: dict[str, Any] = plain(node) if node else {}
    if not is_moorpy(values):
        source.wrong("found no keys line_types, points and lines; expected a system of MoorPy")
    if values.get("bodies"):
        source.wrong("found bodies; expected points of type fairlead; bodies are in the case")
    density = values.get("rho", values.get("water_density"))
    return System(
        source.file,
        {str(_of(source, d, "name")): _type(source, d) for d in values["line_types"]},
        {str(_of(source, d, "name")): _point(source, d) for d in values["points"]},
        {str(d.get("name", i)): _piece(source, d) for i, d in enumerate(values["lines"], 1)},
        density=None if density is None else number(source, None, density, "rho"),
        depth=_optional(source, values, "water_depth"),
    )


def _of(source: Source, values: Mapping[str, Any], *keys: str) -> Any:
    """The value of the first of these keys that is there."""
    for key in keys:
        if key in values:
            return values[key]
    source.wrong(f"found no {keys[0]} in {dict(values)}; expected it")


def _optional(source: Source, values: Mapping[str, Any], key: str) -> float | None:
    return number(source, None, values[key], key) if key in values else None


def _type(source: Source, values: Mapping[str, Any]) -> LineType:
    return LineType(
        number(source, None, _of(source, values, "diameter"), "diameter"),
        number(source, None, _of(source, values, "mass_density"), "mass_density"),
        number(source, None, _of(source, values, "stiffness"), "stiffness"),
        _optional(source, values, "transverse_drag") or 0.0,
    )


def _point(source: Source, values: Mapping[str, Any]) -> Point:
    kind = str(_of(source, values, "type")).lower()
    held = next((h for word, h in HELD.items() if word in kind), None)
    if any(word in kind for word in ON_BODY):
        held = Held.BODY
    if held is None:
        source.wrong(f"found a point of type {kind}; expected fixed, fairlead or free")
    place = [number(source, None, x, "location") for x in _of(source, values, "location")]
    if len(place) != 3:
        source.wrong(f"found location {place}; expected three numbers")
    return Point(
        held,
        (place[0], place[1], place[2]),
        _optional(source, values, "mass") or 0.0,
        _optional(source, values, "volume") or 0.0,
        kind if "body" in kind else "",
    )


def _piece(source: Source, values: Mapping[str, Any]) -> Piece:
    ends = (str(_of(source, values, "endA")), str(_of(source, values, "endB")))
    length = number(source, None, _of(source, values, "length"), "length")
    return Piece(str(_of(source, values, "type", "lineType")), ends, length)
