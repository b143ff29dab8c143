"""AQWA's quadratic transfer functions in text form (.QTF), which AQWA-LINE writes beside an .AH1.

The file has a line with the version, AQTF-2.0; the numbers of structures, headings and frequencies;
headings in degrees and frequencies in rad/s. Four rows of six follow for each structure, heading
and pair of frequencies i, j. They are the real and imaginary part of the difference-frequency load,
then of the sum-frequency load. Loads are in N/m^2 and N m/m^2 about the structure's centre of
gravity, per wave elevations there.

Layout: BEMRosetta's reader and writer, and a file by AQWA 2023 R1 (a cube of 2 m sides in water 70
m deep). The conventions were derived from that file and wave theory: with exp(+i w t),

    T-_ij = P- + i Q-         T+_ij = P+ - i Q+

For heading 0, low w_i and w_i < w_j <= 1 rad/s, Q- in surge is 1.76 to 1.88 times the load of the
set-down on the cube's own water. The rest is the cube's added mass (Pinkster 1980). Its sign agrees
with the formula above. Q+ has the size of a pressure integration over the cube, and the opposite
sign. BEMRosetta uses the other sign for Q-. A cube at y = 2 m has the same heave load for all
headings, so elevations are those at the centre of gravity.
"""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from hydrosim.database.database import Complex, Real
from hydrosim.database.readers.assembly import Abscissa, frequencies
from hydrosim.database.readers.qtf import Pairs, quadratic
from hydrosim.database.readers.text import Text, read_text

VERSION = "AQTF-2.0"

_PRINTED = 1e-5  # of frequencies [rad/s] and headings, which both files round

_Rows = list[tuple[int, list[str]]]  # line and words


def second_order(path: Path, centre: Real, depth: float, gravity: float) -> dict[str, Any]:
    """Fields of the database from a .QTF file, for structures with these centres of gravity (nb,
    3). A file of another version gives no fields and a warning. Raises `InputError` for data that
    are missing or do not fit."""
    text = read_text(path)
    if not text.lines[0].startswith(VERSION):
        warnings.warn(
            f"{path}: is of version {text.lines[0].strip()[:40]!r}, expected {VERSION}; its"
            " quadratic transfer functions are left out. Export it with a newer AQWA to use"
            " them.",
            stacklevel=2,
        )
        return {}
    rows = [(i, line.split()) for i, line in enumerate(text.lines) if i > 0 and line.strip()]
    heading, omega, rows = _head(text, rows, len(centre))
    index, load = _loads(text, rows, (len(centre), heading.size, omega.size, omega.size))
    kinds = []
    for difference, sign in ((True, 1j), (False, -1j)):
        real, imaginary = load[:, :2].swapaxes(0, 1) if difference else load[:, 2:].swapaxes(0, 1)
        pairs = _pairs(index, real + sign * imaginary, heading, omega)
        kinds.append(_at_origin(pairs, centre, depth, gravity, difference))
    return quadratic(path, 6 * len(centre), *kinds)


def mean_drift(fields: dict[str, Any], omega: Real, heading: Real) -> Real | None:
    """Diagonal (nw, nh, n) of the difference functions in ``fields``; None without them, or if
    their frequencies or headings differ from these."""
    if "qtf_difference" not in fields:
        return None
    own, towards = fields["qtf_frequency"], fields["qtf_heading"][:, 0]
    rows, columns = np.argsort(omega), np.argsort(heading)
    if own.shape != omega.shape or towards.shape != heading.shape:
        return None
    if not (_is_equal(own, omega[rows]) and _is_equal(towards, heading[columns])):
        return None
    drift = np.empty((own.size, towards.size, fields["qtf_difference"].shape[-1]))
    drift[np.ix_(rows, columns)] = np.einsum("hiid->ihd", fields["qtf_difference"]).real
    return drift


def _is_equal(a: Real, b: Real) -> bool:
    return bool(np.allclose(a, b, atol=_PRINTED))


def _head(text: Text, rows: _Rows, bodies: int) -> tuple[Real, Real, _Rows]:
    """Headings [rad], frequencies, and the rows that follow."""
    words: list[tuple[int, str]] = []
    size = 3
    for number, (line, found) in enumerate(rows):
        words += [(line, word) for word in found]
        if number == 0 and len(words) >= 3:
            structures, headings, count = (text.count(*word) for word in words[:3])
            size = 3 + headings + count
            if structures != bodies or not headings or not count:
                raise text.wrong(
                    line,
                    f"{structures} structures, {headings} headings, {count} frequencies",
                    f"{bodies} structures as in the .AH1 file, and at least one of the others",
                    "Does it belong to another model? Move it away or export both again.",
                )
        if len(words) >= size > 3:
            break
    else:
        raise text.wrong(len(text.lines) - 1, "the end of the file", "headings and frequencies")
    values = np.array([text.number(*word) for word in words[3:]])
    if values.size != size - 3:
        raise text.wrong(words[-1][0], f"{values.size} numbers", f"{size - 3}")
    heading, omega = np.radians(values[:headings]), values[headings:]
    return (
        heading,
        frequencies(text.path, omega, Abscissa.RADIANS_PER_SECOND),
        rows[number + 1 :],
    )


def _loads(text: Text, rows: _Rows, top: tuple[int, ...]) -> tuple[np.ndarray, Real]:
    """Indices (m, 4) of structure, heading and frequencies, from zero, and numbers (m, 4, 6)."""
    if not rows or len(rows) % 4:
        raise text.wrong(len(text.lines) - 1, f"{len(rows)} rows of loads", "four for each pair")
    index, loads = [], []
    for start in range(0, len(rows), 4):
        (line, words), *rest = rows[start : start + 4]
        at = [text.count(line, word) - 1 for word in words[:4]]
        if any(not 0 <= i < n for i, n in zip(at, top, strict=False)):
            raise text.wrong(line, f"indices {words[:4]}", f"four, up to {top}")
        index.append(at)
        loads.append([text.numbers(i, w, 6) for i, w in [(line, words[4:]), *rest]])
    return np.array(index), np.array(loads)


def _pairs(index: np.ndarray, value: Complex, heading: Real, omega: Real) -> Pairs:
    """Rows for each load (m, 6) of all structures."""
    body, towards, first, second = np.repeat(index, 6, axis=0).T
    return Pairs(
        omega=np.stack([omega[first], omega[second]], axis=-1),
        heading=np.stack([heading[towards]] * 2, axis=-1),
        dof=6 * body + np.tile(np.arange(6), len(index)),
        value=value.ravel(),
    )


def _at_origin(pairs: Pairs, centre: Real, depth: float, gravity: float, difference: bool) -> Pairs:
    """Transfer functions per elevations at the origin, from those at each structure's centre of
    gravity."""
    value = pairs.value
    for body, point in enumerate(centre):
        moved = pairs.at_origin(point, depth, gravity, difference).value
        value = np.where(pairs.dof // 6 == body, moved, value)
    return pairs._replace(value=value)
