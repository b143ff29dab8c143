"""From a mooring system to single lines of segments, also as keys of a case.

Lines in series through free points become the segments of one line.
A free point between two lines is the lower end of a segment; its mass and volume are a clump or a
buoy there. Three lines at a free point are a bridle, which is refused.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import inf, pi
from pathlib import Path
from typing import Any, NoReturn

import yaml

from hydrosim.case.lines.moordyn import read_moordyn
from hydrosim.case.lines.moorpy import is_moorpy, read_moorpy
from hydrosim.case.lines.system import (
    LineType,
    MooringLine,
    PointSupport,
    System,
)
from hydrosim.errors import InputError
from hydrosim.files.text import Source
from hydrosim.files.yaml_nodes import compose_nodes, plain_values
from hydrosim.scene.catenary import MAX_SEGMENTS, LineDrag, Segment, StretchCurve

Water = tuple[float, float]
"""Density [kg/m^3] and gravity [m/s^2]."""
ON_SEABED_RTOL = 1e-3  # of the depth: an anchor this little below the seabed is on it
YAML = (".yaml", ".yml")
CASE_KEYS = {"title", "duration", "environment", "bodies", "forces", "joints", "extends"}
MAX_PIECES = 1000
"""Lines of a file; a wind farm has some hundreds."""


def read_mooring_system(source: Source) -> System:
    """The mooring system in a file of MoorDyn or MoorPy. Raises InputError."""
    if source.file.suffix.lower() in YAML:
        return read_moorpy(source)
    return read_moordyn(source)


def water_of_system(system: System, water: Water) -> Water:
    """The water that weights in ``system`` are for: what its file says, or else ``water``."""
    density, gravity = water
    return (
        density if system.density is None else system.density,
        gravity if system.gravity is None else system.gravity,
    )


def mooring_lines(system: System, water: Water, source: Source) -> dict[str, MooringLine]:
    """The lines of a system by the name of the piece at the fairlead. Raises InputError for what is
    no line from a body to the earth."""
    _check_names(system, source)
    bodies = {point.body for point in system.points.values() if point.held is PointSupport.BODY}
    if len(bodies) > 1:
        source.wrong(
            f"found points on {', '.join(sorted(b or 'the vessel' for b in bodies))}; expected one"
            " body; make a file for each"
        )
    at = _lines_at(system)
    lines_by_name = {}
    used = set()
    for name, point in system.points.items():
        if point.held is not PointSupport.BODY:
            continue
        for first in at[name]:
            pieces, end = _follow_chain(system, at, name, first, source)
            if len(pieces) > MAX_SEGMENTS:
                text = f"found {len(pieces)} lines in series from line {first}"
                text += f"; expected at most {MAX_SEGMENTS}; join those that are alike"
                source.wrong(text, system.pieces[first].row)
            used.update(pieces)
            lines_by_name[first] = _build_line(system, name, end, pieces, water)
    left = [name for name in system.pieces if name not in used]
    if left:
        text = f"found line {left[0]}, which leads to no point of a body; expected lines to bodies"
        source.wrong(text, system.pieces[left[0]].row)
    if not lines_by_name:
        source.wrong("found no line that ends on a body; expected a point of type Coupled")
    return lines_by_name


def _check_names(system: System, source: Source) -> None:
    if len(system.pieces) > MAX_PIECES:
        source.wrong(f"found {len(system.pieces):,} lines; expected at most {MAX_PIECES:,}")
    for name, piece in system.pieces.items():
        if piece.type not in system.types:
            source.unknown(f"line type of line {name},", piece.type, [*system.types], piece.row)
        for end in piece.ends:
            if end not in system.points:
                source.unknown(f"point at an end of line {name},", end, [*system.points], piece.row)
    _check_depths(system, source)


def _check_depths(system: System, source: Source) -> None:
    """Refuse points below the seabed, but for what digits of a file leave."""
    depth = inf if system.depth is None else system.depth
    for name, point in system.points.items():
        if point.held is PointSupport.EARTH and -point.place[2] > depth * (1.0 + ON_SEABED_RTOL):
            source.wrong(
                f"found point {name} {-point.place[2]:g} m below the water, and a depth of"
                f" {depth:g} m; expected points on the seabed or above it",
                point.row,
            )


def _lines_at(system: System) -> Mapping[str, list[str]]:
    """Names of the lines at each point."""
    at: dict[str, list[str]] = {name: [] for name in system.points}
    for name, piece in system.pieces.items():
        for end in piece.ends:
            at[end].append(name)
    return at


def _follow_chain(
    system: System, at: Mapping[str, list[str]], start: str, first: str, source: Source
) -> tuple[list[str], str]:
    """Pieces from the fairlead ``start`` to a point of the earth, and that point."""
    pieces = []
    point = start
    name = first
    while True:
        pieces.append(name)
        a, b = system.pieces[name].ends
        point = b if point == a else a
        held = system.points[point].held
        if held is PointSupport.EARTH:
            return pieces, point
        if held is PointSupport.BODY:
            source.wrong(
                f"found line {name} from one point of a body to another; expected an anchor;"
                " lines between bodies are a catenary with anchor_body in the case",
                system.pieces[name].row,
            )
        name = _next_line(system, at, point, name, source)
        if name in pieces:
            text = f"found a ring of lines at point {point}; expected a line to an anchor"
            source.wrong(text, system.points[point].row)


def _next_line(
    system: System, at: Mapping[str, list[str]], point: str, name: str, source: Source
) -> str:
    """The line behind a free ``point``."""
    others = [other for other in at[point] if other != name]
    if not others:
        text = f"found the free end {point} of line {name}; expected a line or an anchor"
        source.wrong(text, system.points[point].row)
    if len(others) > 1:
        _refuse_bridle(system, at, point, source)
    return others[0]


def _refuse_bridle(
    system: System, at: Mapping[str, list[str]], point: str, source: Source
) -> NoReturn:
    source.wrong(
        f"found a bridle: lines {', '.join(at[point])} meet at the free point {point}; expected two"
        " lines at a free point. Model the point as a small body of the case, or lead one line"
        " of the joint stiffness to the vessel",
        system.points[point].row,
    )


def _build_line(
    system: System, start: str, end: str, pieces: list[str], water: Water
) -> MooringLine:
    density, gravity = water
    segments = []
    for name, hung in zip(pieces, _hung_weights(system, start, pieces, water), strict=True):
        kind = system.types[system.pieces[name].type]
        segments.append(
            Segment.build_from(
                kind,
                length=system.pieces[name].length,
                weight=weight_in_water(kind, density) * gravity,
                clump=hung if hung > 0.0 else None,
                buoy=-hung if hung < 0.0 else None,
                drag=LineDrag(kind.drag, kind.diameter) if kind.drag > 0.0 else None,
            )
        )
    return MooringLine(system.points[start].place, system.points[end].place, segments)


def weight_in_water(kind: LineType, density: float) -> float:
    """Mass per length less that of the water in its place [kg/m]."""
    return kind.mass - density * pi / 4.0 * kind.diameter**2


def _hung_weights(system: System, start: str, pieces: list[str], water: Water) -> Iterator[float]:
    """Weight in water at the lower end of each piece [N]; none at the anchor."""
    density, gravity = water
    point = start
    for name in pieces[:-1]:
        a, b = system.pieces[name].ends
        point = b if point == a else a
        between = system.points[point]
        yield (between.mass - density * between.volume) * gravity
    yield 0.0


def is_mooring_file(file: Path) -> bool:
    """Whether a file is another program's, not a case. YAML without any key of a case is."""
    if file.suffix.lower() not in YAML:
        return True
    try:
        node = compose_nodes(file.read_text("utf-8-sig"), str(file))
    except (OSError, UnicodeDecodeError, InputError):
        return False  # the reader of cases says what is wrong
    values = plain_values(node) if node is not None else None
    if not isinstance(values, Mapping):
        return False
    return is_moorpy(values) or not CASE_KEYS & {*values}


# The lines of a file as keys of a case, in YAML.

DEFAULT_WATER = (1025.0, 9.81)
SIGNIFICANT_DIGITS = 12
HEAD = """\
# Lines of {file}, for {density:g} kg/m^3 and {gravity:g} m/s^2.
# Points count from the origin of the file. In a case they count from the centre of gravity:
# subtract it. Anchors are in the earth frame, for a body at [0 m, 0 m] with heading 0.
"""


def case_keys(file: Path) -> str:
    """YAML of ``forces``, and of the depth if the file says it. Raises InputError."""
    source = Source(file)
    system = read_mooring_system(source)
    water = water_of_system(system, DEFAULT_WATER)
    lines = mooring_lines(system, water, source)
    keys: dict[str, object] = {}
    if system.depth is not None:
        keys["environment"] = {"water_depth": _text_with_unit(system.depth, "m")}
    keys["forces"] = {f"line_{name}": _line_keys(line, system) for name, line in lines.items()}
    text = yaml.dump(keys, sort_keys=False, default_flow_style=None, width=100)
    head = HEAD.format(file=file.name, density=water[0], gravity=water[1])
    left_out = "".join(f"# Left out: {entry.message}\n" for entry in system.left_out)
    return head + left_out + text


def _line_keys(line: MooringLine, system: System) -> dict[str, object]:
    """The keys of a catenary."""
    keys: dict[str, object] = {
        "type": "catenary",
        "body": "vessel",
        "point": [_text_with_unit(x, "m") for x in line.fairlead],
        "anchor": [_text_with_unit(x, "m") for x in line.anchor],
        "segments": [],
    }
    segments = []
    for s in line.segments:
        section_keys: dict[str, object] = {
            "length": _text_with_unit(s.length, "m"),
            "weight": _text_with_unit(s.weight, "N/m"),
            "stiffness": _stiffness_keys(s.stiffness),
        }
        if s.drag is not None:
            section_keys["drag"] = {
                "coefficient": s.drag.coefficient,
                "diameter": _text_with_unit(s.drag.diameter, "m"),
            }
        if s.hung != 0.0:
            section_keys["clump" if s.hung > 0.0 else "buoy"] = _text_with_unit(abs(s.hung), "N")
        segments.append(section_keys)
    keys["segments"] = segments
    if system.depth is not None:
        keys["seabed"] = {"friction": system.friction}
    return keys


def _stiffness_keys(stiffness: float | StretchCurve | None) -> object:
    if not isinstance(stiffness, StretchCurve):
        return _text_with_unit(stiffness, "N")
    tension = [_text_with_unit(T, "N") for T in stiffness.tension]
    return {"stretch": list(stiffness.stretch), "tension": tension}


def _text_with_unit(value: Any, unit: str) -> str:
    return f"{value:.{SIGNIFICANT_DIGITS}g} {unit}"
