"""Reader of MoorDyn's input files, versions 1 and 2, which MoorPy reads and writes too.

A section begins with a line of dashes that names it. A table has two lines of heading: names of its
columns and their units. Columns are found by their names, which differ between versions (Hall, M.,
MoorDyn's documentation, "Inputs").

Refused, because a line in static balance cannot follow them: rods, free bodies, control, failures,
loads on points, tables of tension over strain, bending stiffness, a seabed that is not level.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite
from typing import NoReturn

from hydrosim.case.lines.system import Held, LineType, Piece, Point, System
from hydrosim.documents.text import Source

SECTIONS = {  # words in the title of a section
    "types": ("LINE DICTIONARY", "LINE TYPES"),
    "rod types": ("ROD DICTIONARY", "ROD TYPES"),
    "bodies": ("BODIES", "BODY LIST", "BODY PROPERTIES"),
    "rods": ("RODS", "ROD LIST", "ROD PROPERTIES"),
    "points": (
        *("POINTS", "POINT LIST", "POINT PROPERTIES"),
        *("CONNECTIONS", "CONNECTION PROPERTIES", "NODE PROPERTIES"),
    ),
    "lines": ("LINES", "LINE LIST", "LINE PROPERTIES"),
    "options": ("OPTIONS",),
    "outputs": ("OUTPUTS",),
    "end": ("NEED THIS LINE",),
}
HARMLESS = {"rod types", "outputs", "end"}
COLUMNS = {  # names of columns, or their beginnings
    "diameter": ("diam",),
    "mass": ("mass", "m"),
    "stiffness": ("ea",),
    "bending": ("ei",),
    "drag": ("cdn", "cd"),
    "volume": ("vol", "v"),
    "length": ("unstr", "len"),
    "first": ("attacha", "nodeanch", "enda"),
    "second": ("attachb", "nodefair", "endb"),
}
WORDS = {  # what holds a point, by what its type begins with
    **dict.fromkeys(("fix", "anch", "ground"), Held.EARTH),
    **dict.fromkeys(("vess", "fair", "coupl", "cpld", "body", "turb"), Held.BODY),
    **dict.fromkeys(("con", "free", "point"), Held.LINES),
}
DENSITY = ("wtrdnsty", "rho", "rhow")
GRAVITY = ("g", "gravity")
DEPTH = ("wtrdpth", "depth", "wtrdepth")
FRICTION = ("frictioncoefficient", "mu_kt")  # cb is a damping


@dataclass(frozen=True)
class Section:
    """A section: its ``kind`` ("" if unknown), ``title``, and the words of its lines by number."""

    kind: str
    title: str
    rows: dict[int, list[str]] = field(default_factory=dict)


@dataclass(frozen=True)
class Rows:
    """The table of a section, read from a ``source``."""

    source: Source
    section: Section

    def __iter__(self) -> Iterator[tuple[int, list[str]]]:
        return iter([*self.section.rows.items()][2:])

    @property
    def names(self) -> list[str]:
        """Names of the columns, in small letters."""
        return [name.lower() for name in next(iter(self.section.rows.values()), [])]

    def column(self, what: str) -> int | None:
        """Number of a column of `COLUMNS`; None if there is none."""
        for begins in COLUMNS[what]:
            for i, name in enumerate(self.names):
                if name == begins or (len(begins) > 2 and name.startswith(begins)):
                    return i
        return None

    def number(self, line: int, words: Sequence[str], column: int | None, what: str) -> float:
        """The number in a column of a line; of several, such as 1e8|2e8, the first."""
        if column is None:
            self.source.wrong(f"{self.section.title}: found no column for {what}", line)
        if column >= len(words):
            text = f"found {len(words)} words; expected {what} in column {column + 1}"
            self.source.wrong(text, line)
        return number(self.source, line, words[column].split("|")[0], what)


def read_moordyn(source: Source) -> System:
    """The mooring system of a file. Raises InputError with the line of what is wrong."""
    sections = {s.kind: s for s in _sections(source)}
    for kind, what in (("types", "LINE TYPES"), ("points", "POINTS"), ("lines", "LINES")):
        if kind not in sections:
            source.wrong(f"found no section {what}; expected an input file of MoorDyn or MoorPy")
    for section in sections.values():
        _refuse(source, section)
    options = _options(source, sections.get("options", Section("", "")))
    depth = _first(options, DEPTH)
    return System(
        source.file,
        _types(Rows(source, sections["types"])),
        _points(Rows(source, sections["points"]), depth),
        _pieces(Rows(source, sections["lines"])),
        density=_first(options, DENSITY),
        gravity=_first(options, GRAVITY),
        depth=depth,
        friction=_first(options, FRICTION) or 0.0,
    )


def _sections(source: Source) -> Iterator[Section]:
    """The sections of a file; lines before the first one are remarks."""
    section = None
    for number, line in enumerate(_lines(source), 1):
        if "---" in line:
            if section is not None:
                yield section
            section = Section(_kind(line), line.strip("- \t\r\n"))
        elif section is not None and line.strip():
            section.rows[number] = line.split()
    if section is not None:
        yield section


def _lines(source: Source) -> list[str]:
    source.head(1)
    return source.file.read_text("utf-8-sig", errors="replace").splitlines()


def _kind(line: str) -> str:
    title = line.upper()
    words = re.split(r"[^A-Z ]+", title)
    for kind, names in SECTIONS.items():
        if any(name in word for word in words for name in names):
            return kind
    return ""


def _refuse(source: Source, section: Section) -> None:
    """Refuse what no `catenary` can be."""
    rows = [*section.rows.items()][2:]
    if section.kind in HARMLESS or not rows:
        return
    line, words = rows[0]
    if section.kind == "rods":
        text = "found a rod; expected lines and points alone; model it as a body of the case"
        source.wrong(text, line)
    if section.kind == "bodies":
        for line, words in rows:
            kind = words[1].lower() if len(words) > 1 else ""
            if _held(kind) is not Held.BODY:
                text = f"found a body that is {kind}; expected coupled; model it in the case"
                source.wrong(text, line)
    if section.kind == "" and "INPUT FILE" not in section.title.upper():
        text = f"found entries in {section.title}; expected none; hydrosim does not know it"
        source.wrong(text, line)


def _types(rows: Rows) -> dict[str, LineType]:
    """Types of lines by name."""
    found = {}
    for line, words in rows:
        bending = rows.column("bending")
        if bending is not None and rows.number(line, words, bending, "EI") > 0.0:
            text = f"found EI {words[bending]}; expected 0; lines have no bending stiffness here"
            rows.source.wrong(text, line)
        drag = rows.column("drag")
        found[words[0]] = LineType(
            rows.number(line, words, rows.column("diameter"), "the diameter"),
            rows.number(line, words, rows.column("mass"), "the mass per length"),
            rows.number(line, words, rows.column("stiffness"), "EA"),
            0.0 if drag is None else rows.number(line, words, drag, "the drag coefficient"),
        )
    return found


def _points(rows: Rows, depth: float | None) -> dict[str, Point]:
    """Points by number."""
    found = {}
    columns = [rows.names.index(name) if name in rows.names else None for name in "xyz"]
    for line, words in rows:
        if len(words) < 5:
            text = f"found {len(words)} words; expected number, type, x, y, z"
            rows.source.wrong(text, line)
        for name in ("fx", "fy", "fz"):
            at = rows.names.index(name) if name in rows.names else None
            if at is not None and rows.number(line, words, at, "the force") != 0.0:
                text = f"found a force on point {words[0]}; expected 0"
                rows.source.wrong(f"{text}; give mass and volume, or a load in the case", line)
        if words[4].lower() == "seabed" and depth is not None:
            words = [*words[:4], str(-depth), *words[5:]]
        x, y, z = (rows.number(line, words, c, "the place") for c in columns)
        mass, volume = (rows.column(name) for name in ("mass", "volume"))
        number_ = _identity(rows.source, line, words[0])
        found[number_] = Point(
            _held_by(rows.source, line, words[1].lower()),
            (x, y, z),
            0.0 if mass is None else rows.number(line, words, mass, "the mass"),
            0.0 if volume is None else rows.number(line, words, volume, "the volume"),
            _body(words[1]),
        )
    return found


def _body(kind: str) -> str:
    """Name of the body that a point says it is on; "" for the vessel."""
    digits = re.sub(r"\D", "", kind)
    return f"Body{digits}" if kind.lower().startswith(("body", "turb")) else ""


def _held(kind: str) -> Held | None:
    return next((held for word, held in WORDS.items() if kind.startswith(word)), None)


def _held_by(source: Source, line: int, kind: str) -> Held:
    held = _held(kind)
    if held is None:
        source.wrong(f"found a point of type {kind}; expected Fixed, Coupled, BodyN or Free", line)
    return held


def _pieces(rows: Rows) -> dict[str, Piece]:
    """Lines by number."""
    found = {}
    first, second = rows.column("first"), rows.column("second")
    if first is None or second is None:
        rows.source.wrong(f"{rows.section.title}: found no columns AttachA and AttachB")
    for line, words in rows:
        if len(words) <= max(first, second):
            rows.source.wrong(f"found {len(words)} words; expected type, ends and length", line)
        ends = tuple(_identity(rows.source, line, words[c]) for c in (first, second))
        length = rows.number(line, words, rows.column("length"), "the unstretched length")
        found[words[0]] = Piece(words[1], (ends[0], ends[1]), length)
    return found


def _identity(source: Source, line: int, word: str) -> str:
    """Number of a point, which may be written P3 or Con3."""
    if word[:1].lower() == "r":
        source.wrong(f"found the end {word} of a rod; expected a point", line)
    digits = re.sub(r"\D", "", word)
    if not digits:
        source.wrong(f"found the point {word}; expected a number", line)
    return str(int(digits))


def _options(source: Source, section: Section) -> dict[str, float]:
    """Options that are numbers, by their names in small letters. A depth must be one."""
    found = {}
    for line, words in section.rows.items():
        if len(words) < 2:
            continue
        name = words[1].lower()
        if name in (*DENSITY, *GRAVITY, *DEPTH, *FRICTION):
            found[name] = number(source, line, words[0], name)
    return found


def _first(options: Mapping[str, float], names: Sequence[str]) -> float | None:
    return next((options[name] for name in names if name in options), None)


def number(source: Source, line: int | None, word: object, what: str) -> float:
    """A finite number. Raises InputError that says what was expected."""
    try:
        value = float(str(word).replace("D", "e").replace("d", "e"))
    except ValueError:
        _no_number(source, line, word, what)
    if not isfinite(value):
        _no_number(source, line, word, what)
    return value


def _no_number(source: Source, line: int | None, word: object, what: str) -> NoReturn:
    remedy = "tables in files of their own are not read"
    source.wrong(f'found "{word}"; expected a number for {what}; {remedy}', line)
