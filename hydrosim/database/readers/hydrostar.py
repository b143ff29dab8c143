"""HydroStar's folders of text tables: first order, mean drift, quadratic transfer functions.

All files of the folder are read. First-order data come from the tables
(`read_linear`) or from the single WAMIT set (name.1, ...) in the folder. The set is assumed to have
the frame of the tables, and the attribute ``assumed`` says so.

Second-order data have one file for each load. After a head of lines with #, each heading has rows
of a frequency w_1. Each row has, for every difference
in #DIFF, the real and imaginary part of the load in waves of w_1 and w_2 = w_1 + difference. Units
are N/m^2 and N m/m^2 about #COORD. A table with only the difference zero is a mean drift. It comes
from pressures on the hull, or from the far or middle field if its name ends in FF or MF. Between
differences the load is linear; beyond the largest it is zero. Of pairs of headings, only equal ones
are read. Warnings name the data that are left out.

Layout: Snoopy (Bureau Veritas, GPL, not copied here), HydroStar's table of an FPSO in Snoopy's
tests, and an older reader by the same company. The conventions are those of Snoopy's time series.
Elevations are cos(w t + phase) at "Ref.pt incident wave". Difference and sum loads are Re(T a_1
conj(a_2) exp(i (w_1 - w_2) t)) and Re(T a_1 a_2 exp(i (w_1 + w_2) t)) over all ordered pairs.
Headings are 0 for following waves and 90 degrees for waves from starboard. So T is the database's,
and the FPSO's surge in long waves has the sign of a pressure integration over a box of its size.

HydroStar's first-order tables in text: added mass, wave damping and loads of one body.

There is one file for each entry, such as AddedMass_11.dat, Damping_11.dat and fxf1st.rao. After a
head of lines with #, each frequency [rad/s] has the amplitudes for all headings and their phases
[degrees]. Loads lead the elevation at "Ref.pt incident wave" by their phase. Like the matrices,
they refer to "Reference point of body 1". There are no hydrostatics.

Layout: folders for a cylinder, a spar and a semi-submersible, published for the validation of Nemoh
3. They also give the signs: in long waves along x the surge load leads by 90 degrees and the heave
load is in phase. The surge load is that of the displaced and the added mass.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from hydrosim.database.database import Complex, HydroDatabase, Real
from hydrosim.database.readers import assembly, wamit
from hydrosim.database.readers.text import Text, read_text
from hydrosim.errors import InputError
from hydrosim.scene.hydrodynamics import NOTHING_GIVEN, Given, first_given

# HydroStar's text tables: heads of lines with #, and one quadratic transfer function.

DIFFERENCE_TOLERANCE_RAD_S = 1e-6  # rad/s

_FACTS = "Reference length", "Water density", "Gravity acceleration"
_SMALLEST = 0.5  # density in tonnes and gravity in 10 m/s^2; the inverse is the largest value

_NUMBER_PATTERN = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[EeDd][-+]?\d+)?")


@dataclass(frozen=True)
class QtfTable:
    """One load: ``value`` (nh, nw, nd) in rows with the lower frequency and the ``difference``."""

    text: Text
    given: Given
    is_difference: bool
    dof: int
    point: Real  # (3,): of the moments
    wave_point: Real  # (2,)
    heading: Real
    frequency: Real
    difference: Real
    value: Complex
    is_crossed: bool  # of a file that also has waves of two headings

    @property
    def is_mean(self) -> bool:
        """Whether it is a mean drift: only the difference zero."""
        return self.is_difference and self.difference.size == 1


def qtf_table_of(text: Text) -> QtfTable:
    """Table of a file. Raises `InputError` for data that are missing or not supported."""
    head = head_of(text)
    check_head(text, head, ("HEADING", "DIFF", "QTFMODE", "DIRECTION", "COORD"))
    if "CPLXTYPE" in head and numbers_of(text, head, "CPLXTYPE")[0] != 0:
        raise text.wrong(head["CPLXTYPE"], "another type", "0, real and imaginary parts")
    heading = numbers_of(text, head, "HEADING")
    difference = numbers_of(text, head, "DIFF")
    if (np.diff(difference, prepend=-DIFFERENCE_TOLERANCE_RAD_S) <= 0).any() or difference[
        0
    ] > DIFFERENCE_TOLERANCE_RAD_S:
        raise text.wrong(head["DIFF"], "other differences", "ascending ones from zero")
    mode = text.lines[head["QTFMODE"]].split()[1:]
    direction = numbers_of(text, head, "DIRECTION")[-1]
    if mode not in (["Diff"], ["Sum"]) or direction not in (1, 2, 3, 4, 5, 6):
        raise text.wrong(
            head["QTFMODE"],
            f"mode {' '.join(mode)} and direction {direction:g}",
            "Diff or Sum, and 1 to 6",
        )
    crossed = "HEADING1" in head
    frequency, value = _read_rows(text, heading.size, difference.size, crossed)
    return QtfTable(
        text,
        water_of(text),
        mode == ["Diff"],
        int(direction) - 1,
        numbers_of(text, head, "COORD", 3),
        np.array(numbers_after(text, "Ref.pt incident wave", 2)),
        np.radians(heading),
        assembly.frequencies(text.path, frequency, assembly.Abscissa.RADIANS_PER_SECOND),
        difference,
        value,
        crossed,
    )


def head_of(text: Text) -> dict[str, int]:
    """The first line of each name in the head."""
    return {
        line.lstrip("#").split()[0].upper(): index
        for index, line in reversed(list(enumerate(text.lines)))
        if line.startswith("#") and line.strip("# ")
    }


def check_head(text: Text, head: dict[str, int], names: Sequence[str]) -> None:
    """Raises `InputError` if a line of these names is missing, or if the body has a forward
    speed."""
    for name in names:
        if name not in head:
            raise text.wrong(0, f"no line #{name}", "HydroStar's table of a load with one")
    if any(numbers_after(text, "Forward speed", 1)):
        raise text.wrong(0, "a forward speed", "none", "Compute it without.")


def water_of(text: Text) -> Given:
    """Water properties in the head."""
    line = next((line for line in text.lines if line.startswith("#") and "Waterdepth" in line), "")
    deep = "inf" in line.lower()
    length, density, gravity = (numbers_after(text, words, 1)[0] for words in _FACTS)
    depth = np.inf if deep else numbers_after(text, "Waterdepth", 1)[0]
    water = density / 1e3, gravity / 10
    if (
        not _SMALLEST < min(water) <= max(water) < 1 / _SMALLEST
        or not 1e-3 <= length <= 1e4
        or depth <= 0
    ):
        raise text.wrong(
            0,
            f"a length of {length:g}, density of {density:g}, gravity of {gravity:g} and depth of"
            f" {depth:g} in the head",
            "those of water in SI units",
        )
    return NOTHING_GIVEN.with_values(
        length=length, water_density=density, gravity=gravity, water_depth=depth
    )


def numbers_after(text: Text, words: str, count: int) -> list[float]:
    """Numbers after these words and a colon in the head."""
    for index, line in enumerate(text.lines):
        if line.startswith("#") and words in line:
            return text.numbers(index, _NUMBER_PATTERN.findall(line.partition(":")[2]), count)
    raise text.wrong(0, f"no line with {words}", "the head of a HydroStar table")


def numbers_of(text: Text, head: dict[str, int], name: str, count: int | None = None) -> Real:
    """Numbers of the line with this name, at least one."""
    words = _NUMBER_PATTERN.findall(text.lines[head[name]].partition(name)[2])
    if not words:
        raise text.wrong(head[name], "no numbers", f"those of {name}")
    return np.array(text.numbers(head[name], words, count))


def rows_of(text: Text, columns: int) -> Real:
    """Lines without #, each of so many numbers."""
    rows = [
        text.numbers(index, line.split(), columns)
        for index, line in enumerate(text.lines)
        if line.strip() and not line.startswith("#")
    ]
    return np.reshape(np.array(rows, dtype=float), (-1, columns))


def _read_rows(text: Text, headings: int, differences: int, crossed: bool) -> tuple[Real, Complex]:
    """Frequencies (nw,) and values (nh, nw, nd). If the waves are ``crossed``, pairs of different
    headings are skipped."""
    rows = rows_of(text, 1 + 2 * differences)
    last = len(text.lines) - 1
    blocks = headings**2 if crossed else headings
    if not len(rows) or len(rows) % blocks:
        raise text.wrong(last, f"{len(rows)} rows", f"as many for each of {blocks} headings")
    table = rows.reshape(blocks, -1, rows.shape[1])
    frequency = table[0, :, 0]
    if (table[..., 0] != frequency).any() or (np.diff(frequency) <= 0).any():
        raise text.wrong(last, "other frequencies", "the same, ascending, for all headings")
    own_rows = table[:: headings + 1] if crossed else table
    return frequency, own_rows[..., 1::2] + 1j * own_rows[..., 2::2]


MARK = b"#RAOTYPE"
_MASS, _DAMPING, _LOAD = "ADDED-MASS", "WAVE-DAMPING", "LOAD"
_EVERY = {
    _MASS: [10 * i + j for i in range(1, 7) for j in range(1, 7)],
    _DAMPING: [10 * i + j for i in range(1, 7) for j in range(1, 7)],
    _LOAD: [*range(1, 7)],
}


@dataclass(frozen=True)
class LinearEntry:
    """One entry: ``value`` (nw, nh) of a ``component`` that is numbered from 1."""

    text: Text
    given: Given
    kind: str
    component: int
    point: Real  # (3,): of moments and rotations
    wave_point: Real  # (2,)
    heading: Real
    frequency: Real
    value: Complex


def read_linear(paths: Sequence[Path], given: Given) -> HydroDatabase:
    """Database in these files of a folder. Raises `InputError` for data that are missing or do not
    fit."""
    entries = [entry for path in paths if (entry := _read_entry(read_text(path))).kind in _EVERY]
    first = _check_entries(paths[0], entries)
    particulars = first_given(first.given, given)
    loads = np.stack([_entry_of(entries, _LOAD, k).value for k in _EVERY[_LOAD]], axis=-1)
    depth = float(particulars.water_depth or np.inf)
    gravity = float(particulars.gravity or np.nan)
    start = _entry_of(entries, _LOAD, 1)
    omega = start.frequency
    waves = assembly.elevation(omega[:, None], start.heading, first.wave_point, depth, gravity)
    path = paths[0]
    return assembly.assemble(
        path,
        omega,
        start.heading,
        given.port_starboard_symmetric,
        used=given.frequencies,
        added_mass=_fill_matrix(entries, _MASS),
        radiation_damping=_fill_matrix(entries, _DAMPING),
        excitation=loads * waves[..., None],
        reference_point=assembly.points(
            path, "reference point", given.reference_point, first.point, 1
        ),
        volume=assembly.volumes(path, given.volume, None),
        centre_of_buoyancy=assembly.points(
            path, "centre of buoyancy", given.centre_of_buoyancy, None, 1
        ),
        centre_of_gravity=assembly.points(
            path, "centre of gravity", given.centre_of_gravity, None, 1
        ),
        water_depth=depth,
        water_density=float(particulars.water_density or np.nan),
        gravity=gravity,
        attributes={"program": "HydroStar"},
    )


def _entry_of(entries: Sequence[LinearEntry], kind: str, component: int) -> LinearEntry:
    return next(e for e in entries if (e.kind, e.component) == (kind, component))


def _fill_matrix(entries: Sequence[LinearEntry], kind: str) -> Real:
    """(nw, 6, 6), in the order of the components."""
    columns = [_entry_of(entries, kind, component).value[:, 0].real for component in _EVERY[kind]]
    return np.stack(columns, axis=-1).reshape(-1, 6, 6)


def _check_entries(path: Path, entries: Sequence[LinearEntry]) -> LinearEntry:
    """The first entry. Raises `InputError` if one is missing, occurs twice or has other waves."""
    for kind, wanted in _EVERY.items():
        components = [entry.component for entry in entries if entry.kind == kind]
        lost = sorted({*wanted} - {*components})
        if lost or len(components) > len(wanted):
            problem_text = f"no {', '.join(map(str, lost))}" if lost else "one of them twice"
            raise InputError(
                f"{path}: found {problem_text} of the tables #RAOTYPE {kind} in its folder;"
                f" expected each of {wanted[0]} to {wanted[-1]} once. Let HydroStar write all of"
                " them, and keep each computation in a folder of its own."
            )
    first = entries[0]
    loads = [entry for entry in entries if entry.kind == _LOAD]
    for entry in entries:
        names = ("frequency", "point", "wave_point", *(["heading"] if entry in loads else []))
        other = loads[0] if entry in loads else first
        for name in names:
            if not np.array_equal(getattr(entry, name), getattr(other, name)):
                raise InputError(
                    f"{entry.text.path}: has another {name.replace('_', ' ')} than"
                    f" {other.text.path.name}, expected the same in all tables of a folder. Keep"
                    " each computation in a folder of its own."
                )
    return first


def _read_entry(text: Text) -> LinearEntry:
    """Entry of a file. Raises `InputError` for data that are missing or not supported."""
    head = head_of(text)
    check_head(text, head, ("RAOTYPE", "COMPONENT", "HEADING"))
    if not any(line.startswith("#") and "AMP/PHASE" in line for line in text.lines):
        raise text.wrong(0, "no line # AMP/PHASE", "amplitudes and phases")
    if any("Reference point of body 2" in line for line in text.lines):
        raise text.wrong(0, "several bodies", "one", "Let HydroStar write WAMIT's format.")
    kind = text.lines[head["RAOTYPE"]].partition(":")[2].strip()
    heading = numbers_of(text, head, "HEADING")
    rows = rows_of(text, 1 + 2 * heading.size)
    if not len(rows) or (np.diff(rows[:, 0]) <= 0).any():
        raise text.wrong(len(text.lines) - 1, "frequencies out of order", "ascending ones")
    size, phase = rows[:, 1 : 1 + heading.size], rows[:, 1 + heading.size :]
    return LinearEntry(
        text,
        water_of(text),
        kind,
        int(numbers_of(text, head, "COMPONENT", 1)[0]),
        np.array(numbers_after(text, "Reference point of body 1", 3)),
        np.array(numbers_after(text, "Ref.pt incident wave", 2)),
        np.radians(heading),
        assembly.frequencies(text.path, rows[:, 0], assembly.Abscissa.RADIANS_PER_SECOND),
        assembly.polar(size, -np.radians(phase)),
    )


NAME = "HydroStar"

_MARK = b"#QTFMODE"
_HEAD = 4096  # bytes
_SUFFIXES = {".qtf", ".rao", ".dat"}
_FIELDS = ("FF", "MF")  # suffixes of drifts by momentum: far and middle field
_GRID_RTOL = 1e-4  # relative difference of equal frequencies and headings


def sniff(path: Path, head: bytes) -> bool:
    """Whether the head has HydroStar's words."""
    return _MARK in head or MARK in head


def read(path: Path, given: Given = NOTHING_GIVEN) -> HydroDatabase:
    """Database of all HydroStar tables in the folder of ``path``. Raises `InputError` for data that
    are missing or do not fit."""
    tables = [qtf_table_of(read_text(file)) for file in _files_with_mark(path, _MARK)]
    drifts = [table for table in tables if table.is_mean]
    transfers = [table for table in tables if not table.is_mean]
    db = _first_order(path, tables, given)
    if drifts:
        drift, method = _mean_drift(db, drifts)
        attributes = {**db.attributes, "mean_drift_method": method}
        db = replace(db, mean_drift=drift, attributes=attributes)
    return _add_transfers(db, transfers) if transfers else db


def _first_order(path: Path, tables: Sequence[QtfTable], given: Given) -> HydroDatabase:
    """First-order database: the WAMIT set in the folder or, without one, the tables."""
    sets = [file for file in path.parent.iterdir() if file.suffix == ".1" and file.is_file()]
    linear = _files_with_mark(path, MARK)
    if not sets and linear:
        return read_linear(linear, given)
    if len(sets) != 1:
        raise InputError(
            f"{path}: has only quadratic transfer functions, and this folder has {len(sets)} WAMIT"
            " files that end in .1; expected one, with the first-order data. Let HydroStar write"
            " added mass, damping and loads into this folder, in its own format or in WAMIT's."
            " If there are several, keep the one that belongs to these functions."
        )
    db = wamit.read(sets[0], first_given(given, *(table.given for table in tables[:1])))
    if db.bodies != 1:
        raise InputError(
            f"{path}: stands beside {db.source}, which has {db.bodies} bodies; expected one body,"
            " because the tables do not name theirs."
        )
    frame = "HydroStar's tables in the frame of the WAMIT set"
    assumed = ", ".join(filter(None, [db.attributes.get("assumed", ""), frame]))
    return replace(db, attributes={**db.attributes, "assumed": assumed})


def _files_with_mark(path: Path, mark: bytes) -> list[Path]:
    """The files of the folder with this mark in their heads, ``path`` first."""
    files = []
    for file in [path, *sorted(path.parent.iterdir())]:
        if file.suffix.lower() in _SUFFIXES and file.is_file() and file not in files:
            with file.open("rb") as opened:
                if mark in opened.read(_HEAD):
                    files.append(file)
    return files


def _add_transfers(db: HydroDatabase, tables: Sequence[QtfTable]) -> HydroDatabase:
    """Database with quadratic transfer functions."""
    differences = [table for table in tables if table.is_difference]
    sums = [table for table in tables if not table.is_difference]
    _require_equal(tables, ("heading", "frequency", "point", "wave_point"))
    for group in (differences, sums):
        _require_equal(group, ("difference",))
        _require_unique_loads(group)
    if any(table.is_crossed for table in tables):
        warnings.warn(
            f"{tables[0].text.path}: has pairs of headings; only pairs of equal headings are"
            " read. In a sea of several directions, loads of crossing waves are left out.",
            stacklevel=4,
        )
    heading = tables[0].heading
    return replace(
        db,
        qtf_frequency=tables[0].frequency,
        qtf_heading=np.stack([heading, heading], axis=-1),
        qtf_difference=_read_transfer(db, differences),
        qtf_sum=_read_transfer(db, sums),
    )


def _mean_drift(db: HydroDatabase, tables: Sequence[QtfTable]) -> tuple[Real | None, str]:
    """Drift (nw, nh, 6) about the reference point, and its method. Momentum is preferred if it was
    computed; otherwise HydroStar writes zeros."""
    _require_equal(tables, ("heading", "frequency", "point"))
    methods = []
    for field in (*_FIELDS, ""):
        drift_tables = [table for table in tables if _field_of_table(table) == field]
        _require_unique_loads(drift_tables)
        methods.append(drift_tables if any(table.value.any() for table in drift_tables) else [])
    far, middle, pressure = methods
    momentum = far or middle
    return assembly.preferred_drift(
        _read_drift(db, momentum) if momentum else None,
        None,
        _read_drift(db, pressure) if pressure else None,
        1,
    )


def _field_of_table(table: QtfTable) -> str:
    end = table.text.path.stem[-2:].upper()
    return end if end in _FIELDS else ""


def _read_drift(db: HydroDatabase, tables: Sequence[QtfTable]) -> Real:
    """Drift (nw, nh, 6) about the reference point. Raises `InputError` if its waves differ from
    those of the database."""
    first = tables[0]
    for name in ("frequency", "heading"):
        here = getattr(first, name)
        there = getattr(db, name)
        if (
            here.shape != there.shape
            or np.abs(here - there).max() > _GRID_RTOL * np.abs(there).max()
        ):
            raise InputError(
                f"{first.text.path}: has another {name} than the first-order loads; expected the"
                " same. Compute both for the same waves, or move the mean drift out of the"
                " folder."
            )
    drift = np.zeros((first.frequency.size, first.heading.size, 6))
    for table in tables:
        drift[..., table.dof] = table.value[..., 0].real.T
    return np.asarray(
        _loads_at_reference(db, first, drift, len(tables), 3 if _field_of_table(first) else 6)
    )


def _require_equal(tables: Sequence[QtfTable], names: Sequence[str]) -> None:
    """Raises `InputError` if tables differ in one of these properties."""
    for table in tables[1:]:
        for name in names:
            if not np.array_equal(getattr(table, name), getattr(tables[0], name)):
                raise InputError(
                    f"{table.text.path}: has another {name.replace('_', ' ')} than"
                    f" {tables[0].text.path.name}, expected the same in all tables of a folder."
                    " Keep each computation in a folder of its own."
                )


def _require_unique_loads(tables: Sequence[QtfTable]) -> None:
    """Raises `InputError` if two tables have the same load."""
    if len({table.dof for table in tables}) < len(tables):
        names = ", ".join(table.text.path.name for table in tables)
        raise InputError(
            f"{tables[0].text.path}: found two tables of the same load (surge force, ...) among"
            f" {names}; expected one table per load. Keep each computation in its own folder."
        )


def _loads_at_reference(
    db: HydroDatabase, table: QtfTable, loads: Any, count: int, enough: int = 6
) -> Any:
    """Loads (..., 6) with moments about the database's reference point. ``count`` loads are known,
    ``enough`` are needed."""
    arm = table.point - db.reference_point[0]
    if np.abs(arm).max() > 0 and count < enough:
        raise InputError(
            f"{table.text.path}: found {count} loads; expected {enough}, to move the moments from"
            f" {table.point} to {db.reference_point[0]} m, the reference point."
        )
    loads[..., 3:] += np.cross(arm, loads[..., :3])
    return loads


def _read_transfer(db: HydroDatabase, tables: Sequence[QtfTable]) -> Complex | None:
    """Transfer functions (nh, nw, nw, 6) about the database's reference point and per elevations at
    its origin."""
    if not tables:
        return None
    first, w = tables[0], tables[0].frequency
    if w[-1] - w[0] > first.difference[-1] + DIFFERENCE_TOLERANCE_RAD_S:
        warnings.warn(
            f"{first.text.path}: has waves of frequencies up to {first.difference[-1]:g} rad/s"
            " apart; loads of other pairs are assumed zero. Compute larger differences if the"
            " response to them matters.",
            stacklevel=3,
        )
    out = np.zeros((first.heading.size, w.size, w.size, 6), dtype=complex)
    for table in tables:
        out[..., table.dof] = _square_table(table)
    wave = assembly.elevation(
        w[:, None], first.heading, first.wave_point, db.water_depth, db.gravity
    ).T
    second = wave.conj() if first.is_difference else wave
    out *= (wave[:, :, None] * second[:, None, :])[..., None]
    return np.asarray(_loads_at_reference(db, first, out, len(tables)))


def _square_table(table: QtfTable) -> Complex:
    """Transfer functions (nh, nw, nw) for both orders of each pair of frequencies."""
    w, last = table.frequency, table.difference[-1]
    out = np.zeros((table.heading.size, w.size, w.size), dtype=complex)
    for i in range(w.size):
        apart = w[i:] - w[i]
        apart = np.where(apart < last + DIFFERENCE_TOLERANCE_RAD_S, np.minimum(apart, last), apart)
        for h, row in enumerate(table.value[:, i]):
            pairs = np.interp(apart, table.difference, row, right=0.0)
            out[h, i, i:] = pairs
            out[h, i:, i] = pairs.conj() if table.is_difference else pairs
    return out
