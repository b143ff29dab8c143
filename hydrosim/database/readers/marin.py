"""MARIN's hydrodynamic files (.hyd): first-order records of one body.

Records have eight fields of ten characters; the first is a keyword, and numbers may touch. Units
are tonnes, kN, metres and degrees. The layout comes from a public reader and from a file that its
author exported; no file of MARIN's own was available. These conventions come from there and are not
proven. Headings are directions that waves go to. FEPS is the lag of the load behind the crest at
the origin. Coefficients and centres refer to one origin. REFS gives the depth (0 for infinite), the
draught and the waterline above the origin. In that sample, loads in long waves have the right
phase. But its centre of flotation refers to another origin than its coefficients; such a stiffness
is refused.

The stiffness is computed from the waterplane and the metacentres, whose heights are above the keel
(or the origin, if the draught is zero). It needs the centre of gravity, which the file lacks.
Density and gravity are also missing. Records after PARA2, presumably second-order, are left out.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from hydrosim.database.database import Complex, HydroDatabase, Real
from hydrosim.database.readers import assembly
from hydrosim.database.readers.text import Text, read_text
from hydrosim.scene.hydrodynamics import NOTHING_GIVEN, Given

NAME = "MARIN .hyd"

_FIELD_WIDTH = 10
_KILO = 1e3  # tonnes to kilogrammes, kN to N
_SYMMETRIES = (0, 1, 2)  # none; port-starboard; port-starboard and fore-aft
_OFF_CENTRE = 0.1  # of V^(1/3): largest difference of centres of flotation
_LONG = 0.3  # k V^(1/3) of waves that show the centre of flotation

_PARA = "numbers of frequencies and headings, above zero, and a symmetry of 0, 1 or 2"


class _KeywordRecord(NamedTuple):
    line: int
    keyword: str
    fields: list[str]


class _Spring(NamedTuple):
    """Hydrostatics; metacentres above the keel, centres along the hull."""

    volume: float
    waterplane: float
    flotation: float
    buoyancy: float
    transverse_metacentre: float
    longitudinal_metacentre: float


class _Block(NamedTuple):
    """Data of one OMEGA. Loads are in SI units, other data in the file's units."""

    omega: float
    heading: Real
    added_mass: list[list[float]]
    damping: list[list[float]]
    loads: Complex  # (nh, 6)


class _Tables(NamedTuple):
    """Data by frequency, in SI units; the symmetry as numbered in the file."""

    omega: Real
    heading: Real
    added_mass: Real
    damping: Real
    loads: Complex
    symmetry: int


class _Reader:
    """Records in the order of the file; each is requested by its keyword."""

    def __init__(self, text: Text) -> None:
        self.text = text
        rows = ((line, content[:80]) for line, content in enumerate(text.lines))
        cut = [
            _KeywordRecord(
                line,
                row[:_FIELD_WIDTH].strip(),
                [row[i : i + 10] for i in range(_FIELD_WIDTH, 80, 10)],
            )
            for line, row in rows
            if row.strip()
        ]
        self.records = [record for record in cut if record.keyword != "IDENT"]
        self.next = 0

    def take(self, keyword: str, count: int) -> list[float]:
        """The numbers of the next record, which must have this keyword."""
        record = self.peek(keyword)
        if record.keyword != keyword:
            raise self.text.wrong(record.line, repr(record.keyword), f"keyword {keyword}")
        self.next += 1
        return self.text.numbers(record.line, record.fields[:count], count)

    def peek(self, expected: str) -> _KeywordRecord:
        """The next record. Raises `InputError` at the end of the file."""
        if self.next >= len(self.records):
            self.text.line(len(self.text.lines), expected)
        return self.records[self.next]

    def matrix(self, keyword: str) -> list[list[float]]:
        """Six records of six numbers."""
        return [self.take(keyword, 6) for _ in range(6)]


def sniff(path: Path, head: bytes) -> bool:
    """Whether name and first keyword fit; AQWA's files of that name are binary."""
    return path.suffix.lower() == ".hyd" and head.lstrip().startswith((b"IDENT", b"REFS"))


def read(path: Path, given: Given = NOTHING_GIVEN) -> HydroDatabase:
    """Database in a .hyd file. Raises `InputError` for data that are missing or do not fit."""
    reader = _Reader(read_text(path))
    depth, draught, waterline, _ = reader.take("REFS", 4)
    line = reader.peek("keyword SPRING").line
    spring = _Spring(*reader.take("SPRING", 6))
    tables = _read_tables(reader)
    density = assembly.require_number(path, "water density", given.water_density)
    gravity = assembly.require_number(path, "gravity", given.gravity)
    centre = assembly.points(path, "centre of gravity", given.centre_of_gravity, None, 1)
    stiffness = None
    if centre is not None:
        _check_flotation(reader.text, line, tables, spring, gravity)
        keel = -(draught if draught > 0 else waterline)
        stiffness = density * gravity * _build_stiffness(spring, centre[0, 2] - keel)
    symmetric = given.port_starboard_symmetric
    return assembly.assemble(
        path,
        tables.omega,
        tables.heading,
        tables.symmetry > 0 if symmetric is None else symmetric,
        used=given.frequencies,
        added_mass=tables.added_mass,
        radiation_damping=tables.damping,
        excitation=tables.loads,
        hydrostatic_stiffness=stiffness,
        volume=assembly.volumes(path, given.volume, spring.volume),
        centre_of_gravity=centre,
        centre_of_buoyancy=assembly.points(
            path, "centre of buoyancy", given.centre_of_buoyancy, None, 1
        ),
        reference_point=np.array([[0.0, 0.0, -waterline]]),
        water_depth=depth if depth > 0 else np.inf,
        water_density=density,
        gravity=gravity,
        attributes={"solver": "MARIN .hyd file"},
    )


def _read_tables(reader: _Reader) -> _Tables:
    line = reader.peek("keyword PARA").line
    count, headings, symmetry = reader.take("PARA", 3)
    if symmetry not in _SYMMETRIES or min(count, headings) < 1:
        raise reader.text.wrong(line, f"{count:g}, {headings:g} and {symmetry:g}", _PARA)
    blocks: list[_Block] = []
    while len(blocks) < count:
        blocks.append(_read_block(reader, headings))
        if (blocks[-1].heading != blocks[0].heading).any():
            raise reader.text.wrong(
                reader.records[reader.next - 1].line, "other headings", "the same as before"
            )
    _require_end(reader)
    heading: Real = np.radians(blocks[0].heading)
    loads: Complex = np.array([block.loads for block in blocks])
    if symmetry == 2:
        heading, loads = assembly.with_fore_aft_headings(heading, loads)
    omega = assembly.frequencies(
        reader.text.path, [block.omega for block in blocks], assembly.Abscissa.RADIANS_PER_SECOND
    )
    added_mass = _KILO * np.array([block.added_mass for block in blocks])
    damping = _KILO * np.array([block.damping for block in blocks])
    return _Tables(omega, heading, added_mass, damping, loads, int(symmetry))


def _read_block(reader: _Reader, headings: float) -> _Block:
    (omega,) = reader.take("OMEGA", 1)
    added_mass, damping = reader.matrix("ADMAS"), reader.matrix("BDAMP")
    directions: list[float] = []
    loads: list[Complex] = []
    while len(loads) < headings:
        directions += reader.take("WDIR", 1)
        size, lag = reader.take("FAMP", 6), reader.take("FEPS", 6)
        loads.append(_KILO * assembly.polar(size, np.radians(lag)))
    return _Block(omega, np.array(directions), added_mass, damping, np.array(loads))


def _require_end(reader: _Reader) -> None:
    record = reader.peek("keyword PARA2 or END")
    if record.keyword not in ("PARA2", "END"):
        raise reader.text.wrong(
            record.line,
            repr(record.keyword),
            "PARA2 or END after the last frequency",
            "Files of several bodies are not supported: export one body.",
        )


def _build_stiffness(spring: _Spring, height: float) -> Real:
    """Stiffness over rho g, about the origin, for a centre of gravity at ``height`` above the
    keel."""
    C = np.zeros((6, 6))
    C[2, 2] = spring.waterplane
    C[2, 4] = C[4, 2] = -spring.waterplane * spring.flotation
    C[3, 3] = spring.volume * (spring.transverse_metacentre - height)
    C[4, 4] = spring.volume * (spring.longitudinal_metacentre - height)
    C[4, 4] += spring.waterplane * spring.flotation**2
    return C


def _check_flotation(
    text: Text, line: int, tables: _Tables, spring: _Spring, gravity: float
) -> None:
    """Raises `InputError` if long waves, whose pitch moment is -x_F times the heave force, show
    another centre of flotation."""
    lowest = int(np.argmin(tables.omega))
    heave, pitch = tables.loads[lowest, :, 2], tables.loads[lowest, :, 4]
    length = np.cbrt(abs(spring.volume))
    if tables.omega[lowest] ** 2 * length > _LONG * gravity or not heave.all():
        return
    with np.errstate(over="ignore"):
        shown = -np.mean(np.real(pitch / heave))
    if abs(shown - spring.flotation) > _OFF_CENTRE * length:
        raise text.wrong(
            line,
            f"a centre of flotation at {spring.flotation:g} m, while long waves show {shown:.2f} m",
            "one from the origin of the coefficients",
            "Correct the third and fourth number of SPRING.",
        )
