"""HydroStar's quadratic transfer functions in text (.qtf), beside its results in WAMIT's format.

One file for each load: a head of lines with #, then for each heading rows of a frequency w_1 and,
for each of the differences of #DIFF, the real and imaginary part of the load in waves of w_1 and
w_2 = w_1 + difference, in N/m^2 and N m/m^2 about #COORD. All files of the folder are read. What
else a database needs comes from the one WAMIT set (name.1, ...) in the folder; its frame is taken
to be that of the tables, and the attribute ``assumed`` says so. Between differences the load is
linear; beyond the largest it is zero, and a warning says it.

Layout: Snoopy (Bureau Veritas, GPL, of which nothing is here), HydroStar's table of an FPSO that
Snoopy's tests read, and an older reader by the same house. Conventions are those by which Snoopy
makes time series of the table: elevations cos(w t + phase) at "Ref.pt incident wave", difference
and sum loads Re(T a_1 conj(a_2) exp(i (w_1 - w_2) t)) and Re(T a_1 a_2 exp(i (w_1 + w_2) t)) over
all ordered pairs, headings 0 for following waves and 90 degrees for waves from starboard. So T is
the database's, and the signs of the FPSO's surge in long waves are those of a box of its size by
pressure integration.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from hydrosim.database.database import Complex, HydroDatabase
from hydrosim.database.readers import wamit
from hydrosim.database.readers.assembly import elevation
from hydrosim.database.readers.hydrostar_table import CLOSE, Table, table_of
from hydrosim.database.readers.text import read_text
from hydrosim.errors import InputError
from hydrosim.scene.given import NOTHING_GIVEN, Given, first_given

NAME = "HydroStar .qtf"

_MARK = b"#QTFMODE"
_HEAD = 4096  # bytes
_SUFFIXES = {".qtf", ".rao"}


def sniff(path: Path, head: bytes) -> bool:
    """By the words of its head."""
    return _MARK in head


def read(path: Path, given: Given = NOTHING_GIVEN) -> HydroDatabase:
    """The WAMIT set beside ``path`` with the transfer functions of all HydroStar's tables in the
    folder; raises `InputError` for what is missing or does not fit."""
    tables = [table_of(read_text(file)) for file in _tables(path)]
    _alike(tables)
    db = wamit.read(_set_beside(path), first_given(given, tables[0].given))
    if db.bodies != 1:
        raise InputError(
            f"{path}: stands beside {db.source}, which has {db.bodies} bodies; expected one, as the"
            " tables do not say whose they are."
        )
    frame = "HydroStar's QTF in the frame of the WAMIT set"
    assumed = ", ".join(filter(None, [db.attributes.get("assumed", ""), frame]))
    heading = tables[0].heading
    return replace(
        db,
        qtf_frequency=tables[0].frequency,
        qtf_heading=np.stack([heading, heading], axis=-1),
        qtf_difference=_transfer(db, [table for table in tables if table.is_difference]),
        qtf_sum=_transfer(db, [table for table in tables if not table.is_difference]),
        attributes={**db.attributes, "assumed": assumed},
    )


def _tables(path: Path) -> list[Path]:
    """Of the folder, ``path`` first."""
    found = [path]
    for file in sorted(path.parent.iterdir()):
        if file.suffix.lower() in _SUFFIXES and file.is_file() and file != path:
            with file.open("rb") as opened:
                if _MARK in opened.read(_HEAD):
                    found.append(file)
    return found


def _set_beside(path: Path) -> Path:
    found = [file for file in path.parent.iterdir() if file.suffix == ".1" and file.is_file()]
    if len(found) != 1:
        raise InputError(
            f"{path}: has quadratic transfer functions alone, and {len(found)} files .1 are beside"
            " it; expected one, of the set with all else. Let HydroStar write its results in"
            " WAMIT's format, too, into this folder."
        )
    return found[0]


def _alike(tables: Sequence[Table]) -> None:
    """Raises `InputError` where tables are not of the same waves, or two of the same load."""
    first, *others = tables
    for table in others:
        for name in ("heading", "frequency", "difference", "point", "wave_point"):
            if not np.array_equal(getattr(table, name), getattr(first, name)):
                raise InputError(
                    f"{table.text.path}: has another {name.replace('_', ' ')} than"
                    f" {first.text.path.name}, expected the same in all tables of a folder. Keep"
                    " each computation in a folder of its own."
                )
    loads = [(table.is_difference, table.dof) for table in tables]
    if len(set(loads)) < len(loads):
        names = ", ".join(table.text.path.name for table in tables)
        raise InputError(
            f"{first.text.path}: two of {names} have the same load, expected each once in a folder."
        )


def _transfer(db: HydroDatabase, tables: Sequence[Table]) -> Complex | None:
    """(nh, nw, nw, 6) about the database's reference point and per elevations at its origin."""
    if not tables:
        return None
    first, w = tables[0], tables[0].frequency
    if w[-1] - w[0] > first.difference[-1] + CLOSE:
        warnings.warn(
            f"{first.text.path}: has waves of frequencies up to {first.difference[-1]:g} rad/s"
            " apart; loads of waves further apart are taken to be zero. Compute larger differences"
            " if the response to them counts.",
            stacklevel=3,
        )
    out = np.zeros((first.heading.size, w.size, w.size, 6), dtype=complex)
    for table in tables:
        out[..., table.dof] = _square(table)
    wave = elevation(w[:, None], first.heading, first.wave_point, db.water_depth, db.gravity).T
    second = wave.conj() if first.is_difference else wave
    out *= (wave[:, :, None] * second[:, None, :])[..., None]
    arm = first.point - db.reference_point[0]
    if np.abs(arm).max() > 0 and len(tables) < 6:
        raise InputError(
            f"{first.text.path}: {len(tables)} loads are there, expected six to move the moments"
            f" from {first.point} to {db.reference_point[0]} m, the reference point."
        )
    out[..., 3:] += np.cross(arm, out[..., :3])
    return out


def _square(table: Table) -> Complex:
    """(nh, nw, nw) for both orders of each pair of frequencies."""
    w, last = table.frequency, table.difference[-1]
    out = np.zeros((table.heading.size, w.size, w.size), dtype=complex)
    for i in range(w.size):
        apart = w[i:] - w[i]
        apart = np.where(apart < last + CLOSE, np.minimum(apart, last), apart)
        for h, row in enumerate(table.value[:, i]):
            pairs = np.interp(apart, table.difference, row, right=0.0)
            out[h, i, i:] = pairs
            out[h, i:, i] = pairs.conj() if table.is_difference else pairs
    return out
