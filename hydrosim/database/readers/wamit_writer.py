"""Writer of WAMIT's numeric files, with 17 digits and ULEN 1."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hydrosim.database.database import Complex, HydroDatabase, Real, require_array
from hydrosim.database.readers.assembly import bitwise_inverse, invertible_quotient

_NUMBER_FORMAT = "%24.16e"


def write(db: HydroDatabase, stem: Path) -> None:
    """Write ``stem``.1, .3 and, as far as the database has the data, .3fk, .8 (one body), .9, .12d,
    .12s, .hst and .mmx.

    `wamit.read` needs density, gravity, depth and reference points, which the files do not have. It
    returns numbers from such files to the bit, and other numbers to 3e-16. Drift on held bodies and
    the imbalance of the drift have no place in the files.
    """
    period = bitwise_inverse(lambda T: 2 * np.pi / T, 2 * np.pi / db.frequency, db.frequency)
    _write_radiation(db, period, stem)
    weight = db.water_density * db.gravity
    for suffix, loads in ((".3", db.excitation), (".3fk", db.froude_krylov)):
        if loads is not None and db.heading.size:
            _write_rows(
                db,
                stem,
                suffix,
                _load_rows(loads, weight, period, _degrees_of(db.heading)[:, None]),
            )
    if db.mean_drift is not None:
        both = np.repeat(_degrees_of(db.heading)[:, None], 2, axis=1)
        rows = _load_rows(db.mean_drift.astype(complex), weight, period, both)
        _write_rows(db, stem, ".9", rows)
        if db.bodies == 1:
            _write_rows(db, stem, ".8", [row for row in rows if row[3] in (1, 2, 6)])
    for suffix, transfer in ((".12d", db.qtf_difference), (".12s", db.qtf_sum)):
        if transfer is not None:
            _write_rows(db, stem, suffix, _transfer_rows(db, transfer))
    if db.hydrostatic_stiffness is not None:
        _write_rows(
            db,
            stem,
            ".hst",
            _matrix_rows([], invertible_quotient(db.hydrostatic_stiffness, weight)),
        )
    _write_mmx(db, stem)


def _write_radiation(db: HydroDatabase, period: Real, stem: Path) -> None:
    rows = []
    for code, limit in ((-1.0, db.added_mass_zero), (0.0, db.added_mass_infinite)):
        if limit is not None:
            rows += _matrix_rows([code], invertible_quotient(limit, db.water_density))
    mass = invertible_quotient(db.added_mass, db.water_density)
    damping = invertible_quotient(
        db.radiation_damping, db.water_density * db.frequency[:, None, None]
    )
    for T, A, B in zip(period, mass, damping, strict=True):
        rows += _matrix_rows([T], A, B)
    _write_rows(db, stem, ".1", rows)


def _write_mmx(db: HydroDatabase, stem: Path) -> None:
    """The .mmx file; centres are relative to the reference points."""
    lines = [
        f" Gravity: {db.gravity!r} Length scale: 1.0",
        "",
        f" NBODY = {db.bodies} IALTFRC = 1",
    ]
    for body, origin in enumerate(db.reference_point):
        lines += ["", f" WAMIT  Ouputs for body N = {body + 1} IALTFRCN = 1"]
        if db.volume is not None:
            lines.append(_labelled_line("Volumes (VOLX,VOLY,VOLZ):", [db.volume[body]] * 3))
        for label, points in (
            ("Center of Buoyancy (Xb,Yb,Zb):", db.centre_of_buoyancy),
            ("Center of Gravity:  (Xg,Yg,Zg)", db.centre_of_gravity),
        ):
            if points is not None:
                lines.append(_labelled_line(label, _difference(points[body], origin)))
    if db.inertia_matrix is not None:
        lines += ["", " Normalized mass matrix:", "     I     J     MASS(I,J)/RHO"]
        lines += _format_lines(
            _matrix_rows([], invertible_quotient(db.inertia_matrix, db.water_density))
        )
    _write_lines(db, stem, ".mmx", lines)


def _difference(point: Real, origin: Real) -> Real:
    return bitwise_inverse(lambda x: x + origin, point - origin, point)


def _labelled_line(label: str, values: Real | list[float]) -> str:
    return f" {label} " + " ".join(_NUMBER_FORMAT % value for value in values)


def _matrix_rows(before: list[float], *matrices: Real) -> list[list[float | int]]:
    """Rows of the given first columns, I, J and the entry of each matrix."""
    n = len(matrices[0])
    return [
        [*before, i + 1, j + 1, *(float(matrix[i, j]) for matrix in matrices)]
        for i, j in product(range(n), range(n))
    ]


def _load_rows(
    loads: Complex, weight: float, period: Real, heading: Real
) -> list[list[float | int]]:
    """Rows of period, heading (once or twice), DOF and parts, for loads (nw, nh, n)."""
    parts, directions = _complex_columns(loads, weight), heading.tolist()
    return [
        [T, *directions[h], dof + 1, *parts[w][h][dof]]
        for w, T in enumerate(period.tolist())
        for h, dof in product(*map(range, loads.shape[1:]))
    ]


def _transfer_rows(db: HydroDatabase, transfer: Complex) -> list[list[float | int]]:
    w = require_array(db, "qtf_frequency")
    period = bitwise_inverse(lambda T: 2 * np.pi / T, 2 * np.pi / w, w).tolist()
    heading = _degrees_of(require_array(db, "qtf_heading")).tolist()
    parts = _complex_columns(transfer, db.water_density * db.gravity)
    return [
        [period[i], period[j], *heading[p], dof + 1, *parts[p][i][j][dof]]
        for p, i, j, dof in product(*map(range, transfer.shape))
    ]


def _complex_columns(value: Complex, weight: float) -> list:
    """Nested lists of modulus, phase [deg], real and imaginary part."""
    real, imaginary = (
        invertible_quotient(value.real, weight),
        invertible_quotient(value.imag, weight),
    )
    phase = np.degrees(np.arctan2(imaginary, real))
    return list(np.stack([np.hypot(real, imaginary), phase, real, imaginary], axis=-1).tolist())


def _degrees_of(angle: Real) -> Real:
    return bitwise_inverse(np.radians, np.degrees(angle), angle)


def _format_lines(rows: list[list[float | int]]) -> list[str]:
    return [
        "".join(f"{x:6d}" if isinstance(x, int) else _NUMBER_FORMAT % x for x in r) for r in rows
    ]


def _write_rows(db: HydroDatabase, stem: Path, suffix: str, rows: list[list[float | int]]) -> None:
    _write_lines(db, stem, suffix, _format_lines(rows))


def _write_lines(db: HydroDatabase, stem: Path, suffix: str, lines: list[str] | NDArray) -> None:
    """Write ``lines`` below a heading, as WAMIT's files have one."""
    path = stem.with_name(stem.name + suffix)
    by = db.attributes.get("history", "hydrosim")
    title = f" WAMIT Numeric Output -- Filename {path.name}, written by {by}"
    path.write_text("\n".join([title, *lines, ""]), encoding="utf-8")
