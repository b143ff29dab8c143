"""Text of MoorDyn's input files: sections, their tables, options, and numbers within bounds.

A section begins with a line of dashes that names it. A table has two lines of heading: names of its
columns and their units. Files of version 1 for FAST 8 have the count of rows above them. Remarks
begin with !, # or % (Hall, M., MoorDyn's documentation, "Inputs").
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import NoReturn

from pydantic_core import PydanticCustomError

from hydrosim.files.text import Source
from hydrosim.files.units import Quantity, value_text
from hydrosim.files.yaml_nodes import with_hint
from hydrosim.scene import OmittedEntry, Question

# Bounds of quantities in mooring files.

DIAMETER = Quantity("diameter", "m", "0.1", at_least=0)
MASS_PER_LENGTH = Quantity("mass per length", "kg/m", "150", at_least=0)
AXIAL_STIFFNESS = Quantity("axial stiffness EA", "N", "1e8", above=0)
BENDING_STIFFNESS = Quantity("bending stiffness", "N*m^2", "0", at_least=0)
DRAG_COEFFICIENT = Quantity("drag coefficient", "", "1.2", at_least=0)
MASS = Quantity("mass", "kg", "0", at_least=0)
VOLUME = Quantity("volume", "m^3", "0", at_least=0)
COORDINATE = Quantity("coordinate", "m", "-150")
LINE_LENGTH = Quantity("length", "m", "300", above=0)
ANY_FORCE = Quantity("force", "N", "0")
DENSITY = Quantity("density", "kg/m^3", "1025", above=0)
GRAVITY = Quantity("acceleration", "m/s^2", "9.81", above=0)
DEPTH = Quantity("depth", "m", "150", above=0)
FRICTION_COEFFICIENT = Quantity("coefficient of friction", "", "0.5", at_least=0, at_most=3)
ANGLE_DEG = Quantity("angle in degrees", "", "90")


SECTION_TITLES = {  # what the title of a section holds; the first that does so counts
    "front": "INPUT FILE",
    "end": "NEED THIS LINE|^END",
    "rod types": "ROD DICTIONARY|ROD TYPE",
    "types": "LINE DICTIONARY|LINE TYPE",
    "failures": "FAILURE",
    "control": "CONTROL",
    "loads": "EXTERNAL LOAD",
    "ropes": "SYROPE",
    "options": "OPTIONS",
    "outputs": "OUTPUT",
    "bodies": "BODIES|BODY LIST|BODY PROPERTIES",
    "rods": "RODS|ROD LIST|ROD PROPERTIES",
    "points": "POINTS|POINT LIST|POINT PROPERTIES|CONNECTION|NODES|NODE LIST|NODE PROPERTIES",
    "lines": "LINES|LINE LIST|LINE PROPERTIES",
}
WITHOUT_TABLE = ("front", "end", "options", "outputs")
REPEATED_SECTIONS = ("front", "outputs", "ropes")
COLUMN_NAMES = {  # names of columns, or their beginnings
    "diameter": ("diam", "d"),
    "mass": ("mass", "m"),
    "stiffness": ("ea",),
    "bending": ("ei",),
    "drag": ("cdn", "cd"),
    "volume": ("vol", "v"),
    "length": ("unstr", "len"),
    "first": ("attacha", "nodeanch", "nodea", "enda", "node1", "anchor"),
    "second": ("attachb", "nodefair", "nodeb", "endb", "node2", "fairlead"),
    "x": ("x",),
    "y": ("y",),
    "z": ("z",),
    "fx": ("fx",),
    "fy": ("fy",),
    "fz": ("fz",),
}
OPTIONAL_COLUMNS = ("cl", "df", "cf")
"""Columns that a row may lack: of vibration by vortices."""
OUTPUT_COLUMNS = ("output", "flag")
"""Parts of the name of a column with letters for outputs, which a row may lack."""
REMARK_MARKS = ("!", "#", "%")
MAX_FILE_BYTES = 5_000_000
"""Size of a file; one of 1000 lines has a twentieth of it."""
MIN_NUMBERS_OF_DATA = 2
"""Numbers in a line of heading from which it is taken for a row of the table."""


@dataclass(frozen=True)
class FileSection:
    """A section: its ``kind`` ("" if unknown), its ``title`` in ``line``, and the words of its
    lines by number."""

    kind: str
    title: str
    line: int
    rows: dict[int, list[str]] = field(default_factory=dict)


@dataclass(frozen=True)
class SectionTable:
    """The table of a section that begins in a ``line``: ``names`` of columns in small letters, and
    words by line."""

    source: Source
    title: str
    line: int
    names: list[str]
    rows: dict[int, list[str]]

    def __iter__(self) -> Iterator[tuple[int, list[str]]]:
        return iter(self.rows.items())

    def column(self, what: str) -> int | None:
        """Number of a column of `COLUMN_NAMES`; None if there is none."""
        for begins in COLUMN_NAMES[what]:
            for i, name in enumerate(self.names):
                if name == begins or (len(begins) > 2 and name.startswith(begins)):
                    return i
        return None

    def required_column(self, what: str) -> int:
        """Number of a column that must be there."""
        column = self.column(what)
        if column is None:
            expected = " or ".join(name.upper() for name in COLUMN_NAMES[what])
            column_names = " ".join(self.names) or "no columns"
            text = f"{self.title}: found {column_names}; expected a column {expected}"
            self.source.wrong(text, self.line)
        return column

    def number(
        self, line: int, words: Sequence[str], column: int, quantity: Quantity, what: str = ""
    ) -> float:
        """The number in a column of a line; of several, such as 1e8|2e8, the first."""
        if column >= len(words):
            text = f"found {len(words)} words; expected {quantity.what} in column {column + 1}"
            self.source.wrong(text, line)
        return read_number(self.source, line, words[column].split("|")[0], quantity, what)

    def optional_number(
        self, line: int, words: Sequence[str], what: str, quantity: Quantity
    ) -> float:
        """The number in a column, 0 in a file that lacks it."""
        column = self.column(what)
        return 0.0 if column is None else self.number(line, words, column, quantity)


def read_sections(source: Source) -> dict[str, FileSection]:
    """The sections of a file by their kind, with those that are not known by their titles. What is
    behind the end of the file is left out. Raises InputError for two sections of a kind."""
    sections_by_title: dict[str, FileSection] = {}
    for section in _split_sections(source):
        if section.kind == "end":
            break
        name = section.kind or section.title
        if name in sections_by_title and section.kind not in REPEATED_SECTIONS and section.rows:
            source.wrong(
                f"found a second section {section.title}; expected one, as in line"
                f" {sections_by_title[name].line}; join the tables",
                section.line,
            )
        sections_by_title.setdefault(name, section)
    return sections_by_title


def _split_sections(source: Source) -> Iterator[FileSection]:
    """The sections in their order; lines before the first one are remarks."""
    section = None
    for number, line in enumerate(_content_lines(source), 1):
        if "---" in line:
            if section is not None:
                yield section
            title = line.strip("- \t\r\n")
            kind = _kind_of(title)
            section = FileSection("front" if section is None and not kind else kind, title, number)
        elif section is not None and line.split() and not line.lstrip().startswith(REMARK_MARKS):
            section.rows[number] = line.split()
    if section is not None:
        yield section


def _content_lines(source: Source) -> list[str]:
    source.head(1)
    size = source.file.stat().st_size
    if size > MAX_FILE_BYTES:
        source.wrong(
            f"found {size:,} bytes; expected at most {MAX_FILE_BYTES:,} in an input file of MoorDyn"
        )
    return source.file.read_text("utf-8-sig", errors="replace").splitlines()


def _kind_of(title: str) -> str:
    words = re.sub(r"[^A-Z ]+", "  ", title.upper()).strip()
    return next((kind for kind, names in SECTION_TITLES.items() if re.search(names, words)), "")


def read_table(source: Source, section: FileSection) -> SectionTable:
    """The table of a section. Raises InputError if its count is not that of its rows, if a line of
    heading is missing, or if a row has fewer words than columns."""
    rows = {**section.rows}
    count = _take_count(rows)
    heading = [rows.pop(line) for line in [*rows][:2]]
    names = [name.lower() for name in (heading[0] if heading else [])]
    units = heading[1] if len(heading) > 1 else []
    if sum(map(is_number, units)) >= MIN_NUMBERS_OF_DATA:
        line = [*section.rows][2 if count is not None else 1]
        source.wrong("found numbers; expected the units of the columns", line)
    whole = [name for name in names if name not in OPTIONAL_COLUMNS]
    whole = [name for name in whole if not any(part in name for part in OUTPUT_COLUMNS)]
    data: dict[int, list[str]] = {}
    for line, words in rows.items():
        remark = next((k for k, word in enumerate(words) if word.startswith(REMARK_MARKS)), None)
        data[line] = words[:remark]
        if len(data[line]) < len(whole):
            text = f"found {len(data[line])} values under {len(names)} names of columns"
            source.wrong(f"{text}; expected a value in each", line)
    if count is not None and count != len(data):
        source.wrong(
            f"{section.title}: found {len(data)} rows and the count {count}; expected the same",
            next(iter(section.rows)),
        )
    return SectionTable(source, section.title, section.line, names, data)


def _take_count(rows: dict[int, list[str]]) -> int | None:
    """Removes the count of rows above a table, such as "1  NTypes - number of line types"."""
    line, words = next(iter(rows.items()), (0, [""]))
    if not re.fullmatch(r"\d{1,6}", words[0]):
        return None
    del rows[line]
    return int(words[0])


def is_number(word: str) -> bool:
    """Whether a word is a number."""
    try:
        float(word)
    except ValueError:
        return False
    return True


def read_number(
    source: Source, line: int | None, word: object, quantity: Quantity, what: str = ""
) -> float:
    """A number within the bounds of a quantity, which messages call ``what``. Raises InputError."""
    value: object = word
    if isinstance(word, str):
        try:
            value = float(re.sub("[dD]", "e", word))
        except ValueError:
            _refuse_text(source, line, word, what or quantity.what)
    try:
        return quantity.read(value)
    except PydanticCustomError as error:
        _, _, remedy = error.message().partition("; expected ")[2].partition("; ")
        name = f" for {what}" if what else ""
        unit = f" in {quantity.unit}" if quantity.unit else ""
        word_text = word if isinstance(word, str) else value_text(word)
        text = f"found {word_text}{name}; expected {quantity.what}{unit}"
        source.wrong(with_hint(text, remedy), line)


def _refuse_text(source: Source, line: int | None, word: str, what: str) -> NoReturn:
    remedy = "a table is read for EA alone, from a file beside this one"
    source.wrong(f"found {value_text(word)}; expected a number for {what}; {remedy}", line)


# Options: value and name, in either order; those that matter to statics but are not read are told.

NUMBER_OPTIONS: dict[str, tuple[tuple[str, ...], Quantity]] = {
    "density": (("wtrdnsty", "rho", "rhow"), DENSITY),
    "gravity": (("g", "gravity"), GRAVITY),
    "depth": (("wtrdpth", "depth", "wtrdepth"), DEPTH),
    "friction": (("frictioncoefficient", "mu_ka"), FRICTION_COEFFICIENT),
}
SOLUTION_OPTIONS = {
    *(
        "dtm",
        "dt",
        "cfl",
        "tscheme",
        "dtout",
        "fileic",
        "echo",
        "writelog",
        "writeunits",
        "outswitch",
    ),
    *("disableoutput", "disableouttime", "inertialf", "inertialf_rampt"),
    *("kb", "kbot", "cb", "cbot", "fricdamp", "cv", "statdynfricscale", "mc"),
    *("dtic", "icdt", "tmaxic", "ictmax", "cdscaleic", "icdfac", "threshic", "icthresh"),
    *("icgendynamic", "dtwave", "wavekin_rampt", "unifycurrentgrid"),
}
"""Options that a line in static balance does not have. The stiffness of the bed is one of them: the
bed is rigid here."""
WATER_OPTIONS = {"wavekin", "waterkin", "currents", "wavekinfile"}
"""Options for waves and current, which the case has."""
BATHYMETRY_OPTIONS = ("seafloorfile", "seafloorpath", "bathymetry", "bathymetryfile")
EMPTY_VALUES = ("0", "0.0", "none", "null", "false", "-", '""', "''")


@dataclass(frozen=True)
class Options:
    """What the options of a file say, None where they do not: ``density`` [kg/m^3], ``gravity``
    [m/s^2], ``depth`` [m]; ``friction`` along the line; what is ``left_out``."""

    density: float | None
    gravity: float | None
    depth: float | None
    friction: float
    left_out: tuple[OmittedEntry, ...]


def read_options(source: Source, section: FileSection) -> Options:
    """The options of a section. Raises InputError for values out of bounds, for two values of one
    quantity, and for a seabed in a file of its own."""
    values: dict[str, tuple[float, int]] = {}
    left_out: list[OmittedEntry] = []
    for line, words in section.rows.items():
        name, value = _name_and_value(words)
        what = next((key for key, (names, _) in NUMBER_OPTIONS.items() if name in names), None)
        if name in BATHYMETRY_OPTIONS and value.lower() not in EMPTY_VALUES:
            source.wrong(f"found {name} {value}; expected a level seabed, by WtrDpth", line)
        if what is None:
            left_out.extend(_describe_left_out(name, value, line))
            continue
        number = read_number(source, line, value, NUMBER_OPTIONS[what][1], name)
        if what in values and values[what][0] != number:
            text = f"found {what} {number:g}; expected {values[what][0]:g} again, as in line"
            source.wrong(f"{text} {values[what][1]}, or one of both", line)
        values[what] = number, line
    density, gravity, depth, friction = (values.get(key, (None,))[0] for key in NUMBER_OPTIONS)
    return Options(density, gravity, depth, friction or 0.0, tuple(left_out))


def _name_and_value(words: Sequence[str]) -> tuple[str, str]:
    """Name in small letters and value of an option, which may be written ``depth = 150``."""
    apart = " ".join(words).replace("=", " = ").split()
    if len(apart) > 2 and apart[1] == "=":
        return apart[0].lower(), apart[2]
    if len(apart) < 2:
        return apart[0].lower(), ""
    value, name = apart[:2]
    return (
        (value.lower(), name) if not _is_known(name) and _is_known(value) else (name.lower(), value)
    )


def _is_known(word: str) -> bool:
    name = word.lower()
    numbers = {name for names, _ in NUMBER_OPTIONS.values() for name in names}
    return name in {*numbers, *SOLUTION_OPTIONS, *WATER_OPTIONS, *BATHYMETRY_OPTIONS, "mu_kt"}


def _describe_left_out(name: str, value: str, line: int) -> Iterator[OmittedEntry]:
    """What is left out by passing over an option."""
    is_known = name in WATER_OPTIONS or name in BATHYMETRY_OPTIONS or name == "mu_kt"
    if name in SOLUTION_OPTIONS or (is_known and value.lower() in EMPTY_VALUES):
        return
    if name in WATER_OPTIONS:
        advice = "Waves and current are those of the case."
    elif name == "mu_kt":
        advice = "Friction across a line is neglected."
    else:
        advice = "No option of this name is known here; see that the line is as you mean it."
    option_text = f"the option {name} {value}".strip()
    yield OmittedEntry(Question.FILES, f"{option_text} in line {line}", "it is left out", advice)
