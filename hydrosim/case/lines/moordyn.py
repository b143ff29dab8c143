"""Reader of MoorDyn's input files, versions 1 and 2, which MoorPy reads and writes too.

Columns are found by their names, which differ between versions. Rotations of a body are about its x
axis, its turned y axis, and its turned z axis; MoorPy has another order, so one of them alone is
read. Places of coupled points are in the axes of the vessel; those of points of a body are in the
axes of that body, which has a place of its own (Hall, M., MoorDyn's documentation, "Inputs").

Refused, because a line in static balance cannot follow them: rods, pinned bodies, control,
failures, loads on points, a seabed that is not level. What is left out (bending stiffness, the mass
of a free body, options that are not known) is told.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import cos, radians, sin

import numpy as np
from pydantic import ValidationError

from hydrosim.case.lines import sections, system
from hydrosim.case.lines.sections import (
    COLUMN_NAMES,
    WITHOUT_TABLE,
    FileSection,
    SectionTable,
    read_options,
    read_sections,
    read_table,
)
from hydrosim.files.text import Source, parse
from hydrosim.scene import OmittedEntry, Question
from hydrosim.scene.catenary import StretchCurve

REQUIRED_SECTIONS = {"types": "LINE TYPES", "points": "POINTS", "lines": "LINES"}
POINT_TYPES = {  # what holds a point, by what its type begins with
    **dict.fromkeys(("fix", "anch", "ground"), system.PointSupport.EARTH),
    **dict.fromkeys(("vess", "fair", "coupl", "cpld", "body", "turb"), system.PointSupport.BODY),
    **dict.fromkeys(("con", "free", "point"), system.PointSupport.LINES),
}
PASSED_COLUMNS = {  # names of columns that are not read
    "types": r"(line|type)?name|(line)?type|ba\b.*|cintdamp.*|c[ad](ax|n|t)?|c[ad]end|cl|df|cf",
    "points": r"id|node|point|con.*|type|att.*|c[ad]a?\*?",
    "lines": r"id|line|(line)?type|(line)?name|num(segs|nodes)|.*(flags|out).*",
}
BODY_COLUMN_INITIALS = ("x", "y", "z", "r", "p", "y")
"""What the names of the columns of a body begin with, from the third on: places and angles."""
REFUSED_SECTIONS = {
    "rods": "found a rod; expected lines and points alone; model it as a body of the case",
    "failures": "found a failure; expected none; the case has breaks_at for its lines",
    "control": "found lines under control; expected none; the case has winches",
    "loads": "found a load on a body or point; expected none; the case has forces",
    "ropes": "found a rope of the Syrope model; expected EA as a number",
}
MAP_REMEDY = (
    "expected one of MoorDyn or MoorPy, which differs: a number in place of each # and depth, a"
    " column NumSegs in LINE PROPERTIES, each option behind its value, and each line of repeat"
    " written out"
)


@dataclass(frozen=True, eq=False)
class FileBody:
    """A body of a file in a ``line``: what holds its points, its ``place`` (3,) [m] and its
    ``rotation`` (3, 3); whether it is ``free``, so that it has a mass there."""

    held: system.PointSupport
    place: np.ndarray
    rotation: np.ndarray
    free: bool
    line: int


Bodies = Mapping[str, FileBody]


def read_moordyn(source: Source) -> system.System:
    """The mooring system of a file. Raises InputError with the line of what is wrong."""
    sections = read_sections(source)
    for kind, what in REQUIRED_SECTIONS.items():
        if kind not in sections:
            expected = "an input file of MoorDyn or MoorPy with lines"
            source.wrong(f"found no section {what}; expected {expected}")
    _refuse_map(source, sections)
    tables = {
        kind: read_table(source, section)
        for kind, section in sections.items()
        if section.kind not in WITHOUT_TABLE
    }
    _refuse_sections(source, sections, tables)
    options = read_options(source, sections.get("options", FileSection("options", "", 0)))
    bodies = dict(_read_bodies(tables["bodies"])) if "bodies" in tables else None
    stiffness = tuple(_find_stiffness_left_out(tables["types"]))
    return system.System(
        source.file,
        _read_types(tables["types"]),
        _read_points(tables["points"], options.depth, bodies),
        _read_pieces(tables["lines"]),
        density=options.density,
        gravity=options.gravity,
        depth=options.depth,
        friction=options.friction,
        left_out=(
            *stiffness,
            *(entry for kind in PASSED_COLUMNS for entry in _unknown_columns(kind, tables[kind])),
            *_free_bodies(bodies or {}),
            *options.left_out,
        ),
    )


def _unknown_columns(kind: str, table: SectionTable) -> Iterator[OmittedEntry]:
    """Columns that are neither read nor among those that a line in static balance lacks."""
    read = {table.column(what) for what in COLUMN_NAMES}
    for number, name in enumerate(table.names):
        if number not in read and not re.fullmatch(PASSED_COLUMNS[kind], name):
            found_text = f"the column {name} of {table.title}"
            advice = "No column of this name is known here; see that the line is as you mean it."
            yield OmittedEntry(Question.FILES, found_text, "it is left out", advice)


def _refuse_map(source: Source, sections: Mapping[str, FileSection]) -> None:
    """Refuse an input file of MAP++, from which MoorDyn's format comes."""
    rows = [
        (line, words, len(next((w for w in rows.values() if len(w) > 2), ())))
        for kind in ("types", "points", "lines")
        for rows in [sections[kind].rows]
        for line, words in rows.items()
    ]
    for line, words, columns in rows:
        names = [word.lower() for word in words]
        is_line = "unstrlen" in names and not any(name.startswith("num") for name in names)
        iterated = any(re.fullmatch(r"#[-+.\d]*", word) for word in words[2:columns])
        if "cintdamp" in names and "cb" in names:
            text = "found the column CB"
        elif is_line:
            text = "found no column NumSegs"
        elif iterated or "depth" in names[4:5]:
            text = f"found {next(w for w in words[2:] if w[0] == '#' or w.lower() == 'depth')}"
        else:
            continue
        source.wrong(f"{text}, so this is an input file of MAP++; {MAP_REMEDY}", line)


def _refuse_sections(
    source: Source, sections: Mapping[str, FileSection], tables: Mapping[str, SectionTable]
) -> None:
    """Refuse what no `catenary` can be."""
    for kind, rows in tables.items():
        line = next(iter(rows.rows), None)
        if kind in REFUSED_SECTIONS and line is not None:
            source.wrong(REFUSED_SECTIONS[kind], line)
        if not sections[kind].kind and line is not None:
            text = f"found entries in {rows.title}; expected none; hydrosim does not know it"
            source.wrong(text, line)


def _read_types(rows: SectionTable) -> dict[str, system.LineType]:
    """Types of lines by name."""
    diameter, mass, stiffness = (rows.required_column(w) for w in ("diameter", "mass", "stiffness"))
    types_by_name: dict[str, system.LineType] = {}
    for line, words in rows:
        _refuse_repeated(rows.source, types_by_name, words[0], "line type", line)
        types_by_name[words[0]] = system.LineType(
            rows.number(line, words, diameter, sections.DIAMETER, "the diameter"),
            rows.number(line, words, mass, sections.MASS_PER_LENGTH, "the mass per length"),
            _read_stiffness(rows, line, words, stiffness),
            rows.optional_number(line, words, "drag", sections.DRAG_COEFFICIENT),
        )
    return types_by_name


def _read_stiffness(
    rows: SectionTable, line: int, words: Sequence[str], column: int
) -> float | StretchCurve:
    """EA, or the curve in the file that is named there: rows of stretch and tension [N] below lines
    of heading."""
    name = words[column].partition("|")[0]
    file = rows.source.file.parent / name
    if sections.is_number(name) or not file.is_file():
        return rows.number(line, words, column, sections.AXIAL_STIFFNESS, "EA")
    source = Source(file, f"{rows.source.wanted or rows.source.file}: EA in line {line}")
    table = parse(source, first="a stretch").rows
    if table.shape[1] != 2:
        source.wrong(f"found {table.shape[1]} columns; expected stretch and tension")
    keys = dict(zip(("stretch", "tension"), table.T.tolist(), strict=True))
    try:
        return StretchCurve.model_validate(keys)
    except ValidationError as error:
        source.wrong(error.errors()[0]["msg"])


def _find_stiffness_left_out(rows: SectionTable) -> Iterator[OmittedEntry]:
    """Bending stiffness, and what follows the first number of EA: the stiffness under fast
    loads."""
    axial = rows.required_column("stiffness")
    for line, words in rows:
        _, _, fast = words[axial].partition("|")
        if fast:
            found_text = f"EA of {fast} under fast loads for {words[0]} in line {line}"
            advice = "The stiffness of the line is that of slow loads. In waves it is too soft."
            yield OmittedEntry(Question.FILES, found_text, "it is left out", advice)
        stiffness = rows.optional_number(line, words, "bending", sections.BENDING_STIFFNESS)
        if stiffness > 0.0:
            yield OmittedEntry(
                Question.BENDING,
                f"EI of {stiffness:g} N m^2 for {words[0]} in line {line}",
                "lines in static balance have no bending stiffness here",
                "The shape is wrong near ends and touch-down, within some sqrt(EI / tension) of"
                " them.",
                refused=True,
            )


def _refuse_repeated(
    source: Source, names_so_far: Mapping[str, object], name: str, what: str, line: int
) -> None:
    if name in names_so_far:
        source.wrong(f"found {what} {name} twice; expected each once", line)


def _read_bodies(rows: SectionTable) -> Iterator[tuple[str, FileBody]]:
    """Bodies by number."""
    names = rows.names[2:8]
    if len(rows.rows) > 0 and [name[:1] for name in names] != list(BODY_COLUMN_INITIALS):
        expected = "ID, Attachment, X0, Y0, Z0, r0, p0, y0"
        text = f"{rows.title}: found {' '.join(rows.names)}; expected {expected}"
        rows.source.wrong(text, rows.line)
    seen: dict[str, FileBody] = {}
    for line, words in rows:
        kind = words[1].lower()
        held = _support_of(kind)
        if held is None or "pin" in kind:
            text = f"found a body that is {words[1]}; expected coupled, fixed or free"
            rows.source.wrong(f"{text}; model its joint in the case", line)
        place = [rows.number(line, words, c, sections.COORDINATE) for c in (2, 3, 4)]
        angles = [rows.number(line, words, c, sections.ANGLE_DEG) for c in (5, 6, 7)]
        if np.count_nonzero(angles) > 1:
            text = "found rotations about several axes; expected one of r0, p0, y0"
            rows.source.wrong(f"{text}: MoorDyn and MoorPy differ in their order", line)
        number = _read_identity(rows.source, line, words[0])
        _refuse_repeated(rows.source, seen, number, "body", line)
        fixed = held is system.PointSupport.EARTH
        support = held if fixed else system.PointSupport.BODY
        seen[number] = FileBody(
            support,
            np.array(place),
            _rotation_matrix(angles),
            held is system.PointSupport.LINES,
            line,
        )
        yield number, seen[number]


def _free_bodies(bodies: Bodies) -> Iterator[OmittedEntry]:
    for number, body in bodies.items():
        if body.free:
            yield OmittedEntry(
                Question.FILES,
                f"the free body {number} in line {body.line}",
                "its mass and its loads are left out",
                "The body of the case has its place, with its own mass and buoyancy.",
            )


def _rotation_matrix(angles: Sequence[float]) -> np.ndarray:
    """Matrix (3, 3) of a rotation about one of the axes by an angle [deg]."""
    axis = int(np.argmax(np.abs(angles)))
    c, s = cos(radians(angles[axis])), sin(radians(angles[axis]))
    j, k = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[[j, j, k, k], [j, k, j, k]] = c, -s, s, c
    return matrix


def _read_points(
    rows: SectionTable, depth: float | None, bodies: Bodies | None
) -> dict[str, system.Point]:
    """Points by number."""
    columns = [rows.required_column(name) for name in "xyz"]
    points_by_name: dict[str, system.Point] = {}
    for line, words in rows:
        for name in ("fx", "fy", "fz"):
            if rows.optional_number(line, words, name, sections.ANY_FORCE) != 0.0:
                text = f"found a force on point {words[0]}; expected 0"
                rows.source.wrong(f"{text}; give mass and volume, or a load in the case", line)
        if words[columns[2]].lower() == "seabed" and depth is not None:
            words[columns[2]] = str(-depth)
        x, y, z = (rows.number(line, words, c, sections.COORDINATE) for c in columns)
        number = _read_identity(rows.source, line, words[0])
        _refuse_repeated(rows.source, points_by_name, number, "point", line)
        held, body, place = _locate_point(rows.source, line, words[1], (x, y, z), bodies)
        mass = rows.optional_number(line, words, "mass", sections.MASS)
        volume = rows.optional_number(line, words, "volume", sections.VOLUME)
        points_by_name[number] = system.Point(held, place, mass, volume, body, line)
    return points_by_name


def _locate_point(
    source: Source, line: int, kind: str, place: system.Place, bodies: Bodies | None
) -> tuple[system.PointSupport, str, system.Place]:
    """What holds a point, the name of the body that does so, and its place in the axes of the file.
    A body that the file does not list has its own axes there."""
    held = _support_of(kind.lower())
    if held is None:
        source.wrong(f"found a point of type {kind}; expected Fixed, Coupled, BodyN or Free", line)
    digits = re.sub(r"\D", "", kind)
    if not kind.lower().startswith(("body", "turb")):
        return held, "", place
    if kind.lower().startswith("turb") or bodies is None:
        return held, f"Body{digits}", place
    if digits not in bodies:
        body_names = ", ".join(f"Body{number}" for number in bodies) or "none"
        source.wrong(f"found a point on {kind}; expected one of the bodies: {body_names}", line)
    body = bodies[digits]
    x, y, z = map(float, body.place + body.rotation @ place)
    name = f"Body{digits}" if body.held is system.PointSupport.BODY else ""
    return body.held, name, (x, y, z)


def _support_of(kind: str) -> system.PointSupport | None:
    return next((held for word, held in POINT_TYPES.items() if kind.startswith(word)), None)


def _read_pieces(rows: SectionTable) -> dict[str, system.Piece]:
    """Lines by number."""
    first, second, length = (rows.required_column(what) for what in ("first", "second", "length"))
    pieces_by_name: dict[str, system.Piece] = {}
    for line, words in rows:
        ends = tuple(_read_identity(rows.source, line, words[c]) for c in (first, second))
        _refuse_repeated(rows.source, pieces_by_name, words[0], "line", line)
        size = rows.number(
            line,
            words,
            length,
            sections.LINE_LENGTH,
            f"the unstretched length of line {words[0]}",
        )
        pieces_by_name[words[0]] = system.Piece(words[1], (ends[0], ends[1]), size, line)
    return pieces_by_name


def _read_identity(source: Source, line: int, word: str) -> str:
    """Number of a point, which may be written P3 or Con3."""
    if word[:1].lower() == "r":
        source.wrong(f"found the end {word} of a rod; expected a point", line)
    digits = re.sub(r"\D", "", word)
    if not digits:
        source.wrong(f"found the point {word}; expected a number", line)
    return str(int(digits))
