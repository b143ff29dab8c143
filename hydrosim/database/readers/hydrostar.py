"""HydroStar's folders of text tables: first order, mean drift, quadratic transfer functions.

All files of the folder are read. First-order data come from the tables of `hydrostar_linear` or
from the single WAMIT set (name.1, ...) in the folder. The set is assumed to have the frame of the
tables, and the attribute ``assumed`` says so. Second-order data have one file for each load. After
a head of lines with #, each heading has rows of a frequency w_1. Each row has, for every difference
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
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from hydrosim.database.database import Complex, HydroDatabase, Real
from hydrosim.database.readers import hydrostar_linear, wamit
from hydrosim.database.readers.assembly import elevation
from hydrosim.database.readers.common import preferred_drift
from hydrosim.database.readers.hydrostar_table import DIFFERENCE_TOLERANCE_RAD_S, QtfTable, table_of
from hydrosim.database.readers.text import read_text
from hydrosim.errors import InputError
from hydrosim.scene.hydrodynamics import NOTHING_GIVEN, Given, first_given

NAME = "HydroStar"

_MARK = b"#QTFMODE"
_HEAD = 4096  # bytes
_SUFFIXES = {".qtf", ".rao", ".dat"}
_FIELDS = ("FF", "MF")  # suffixes of drifts by momentum: far and middle field
_GRID_RTOL = 1e-4  # relative difference of equal frequencies and headings


def sniff(path: Path, head: bytes) -> bool:
    """Whether the head has HydroStar's words."""
    return _MARK in head or hydrostar_linear.MARK in head


def read(path: Path, given: Given = NOTHING_GIVEN) -> HydroDatabase:
    """Database of all HydroStar tables in the folder of ``path``. Raises `InputError` for data that
    are missing or do not fit."""
    tables = [table_of(read_text(file)) for file in _files_with_mark(path, _MARK)]
    drifts = [table for table in tables if table.is_mean]
    transfers = [table for table in tables if not table.is_mean]
    db = _first_order(path, tables, given)
    if drifts:
        drift, method = _mean_drift(db, drifts)
        attributes = {**db.attributes, "mean_drift_method": method}
        db = replace(db, mean_drift=drift, attributes=attributes)
    return _with_transfers(db, transfers) if transfers else db


def _first_order(path: Path, tables: Sequence[QtfTable], given: Given) -> HydroDatabase:
    """First-order database: the WAMIT set in the folder or, without one, the tables."""
    sets = [file for file in path.parent.iterdir() if file.suffix == ".1" and file.is_file()]
    linear = _files_with_mark(path, hydrostar_linear.MARK)
    if not sets and linear:
        return hydrostar_linear.read(linear, given)
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
    found = []
    for file in [path, *sorted(path.parent.iterdir())]:
        if file.suffix.lower() in _SUFFIXES and file.is_file() and file not in found:
            with file.open("rb") as opened:
                if mark in opened.read(_HEAD):
                    found.append(file)
    return found


def _with_transfers(db: HydroDatabase, tables: Sequence[QtfTable]) -> HydroDatabase:
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
        qtf_difference=_transfer(db, differences),
        qtf_sum=_transfer(db, sums),
    )


def _mean_drift(db: HydroDatabase, tables: Sequence[QtfTable]) -> tuple[Real | None, str]:
    """Drift (nw, nh, 6) about the reference point, and its method. Momentum is preferred if it was
    computed; otherwise HydroStar writes zeros."""
    _require_equal(tables, ("heading", "frequency", "point"))
    methods = []
    for field in (*_FIELDS, ""):
        own = [table for table in tables if _field(table) == field]
        _require_unique_loads(own)
        methods.append(own if any(table.value.any() for table in own) else [])
    far, middle, pressure = methods
    momentum = far or middle
    return preferred_drift(
        _drift(db, momentum) if momentum else None,
        None,
        _drift(db, pressure) if pressure else None,
        1,
    )


def _field(table: QtfTable) -> str:
    end = table.text.path.stem[-2:].upper()
    return end if end in _FIELDS else ""


def _drift(db: HydroDatabase, tables: Sequence[QtfTable]) -> Real:
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
    return np.asarray(_loads_at_reference(db, first, drift, len(tables), 3 if _field(first) else 6))


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


def _transfer(db: HydroDatabase, tables: Sequence[QtfTable]) -> Complex | None:
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
        out[..., table.dof] = _square(table)
    wave = elevation(w[:, None], first.heading, first.wave_point, db.water_depth, db.gravity).T
    second = wave.conj() if first.is_difference else wave
    out *= (wave[:, :, None] * second[:, None, :])[..., None]
    return np.asarray(_loads_at_reference(db, first, out, len(tables)))


def _square(table: QtfTable) -> Complex:
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
