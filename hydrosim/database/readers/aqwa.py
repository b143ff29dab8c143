"""AQWA's databases in text form (.AH1) and its quadratic transfer functions (.QTF), by AQWA-LINE.

Verified with real files of versions before 2020 and of 2020 R1. The former have one head for all
structures, GENERAL without a structure number, and neither COB nor DISPLACEMENT. The latter has a
head for each structure. The files show the order of sections, the indices of matrices (structure,
structure, frequency) and loads (structure, heading, frequency), and a stiffness with gravity about
the centre of gravity. Their loads in long waves, and a sphere that WAMIT has, too, show that phases
are lags in degrees and headings are directions that waves go to. AQWA's users report that phases
refer to the wave at each structure's centre of gravity; no file proves it. Frequency-independent
damping (FIDD) is left out, because it radiates no waves: add it to the case.

Older files lack volumes and centres of buoyancy; these are read from the listing (.LIS) beside
them. Quadratic transfer functions are read from the .QTF, which may be named as well;
their diagonal is the mean drift.

AQWA's quadratic transfer functions in text form (.QTF), which AQWA-LINE writes beside an .AH1.

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

import re
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hydrosim.database.database import Complex, HydroDatabase, Real
from hydrosim.database.readers.assembly import (
    Abscissa,
    Pairs,
    assemble,
    at_origin,
    block_diagonal,
    frequencies,
    points,
    polar,
    quadratic,
    volumes,
)
from hydrosim.database.readers.text import Text, read_text
from hydrosim.errors import InputError
from hydrosim.scene.hydrodynamics import NOTHING_GIVEN, Given

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
    heading, omega, rows = _qtf_head(text, rows, len(centre))
    index, load = _qtf_loads(text, rows, (len(centre), heading.size, omega.size, omega.size))
    kinds = []
    for difference, sign in ((True, 1j), (False, -1j)):
        real, imaginary = load[:, :2].swapaxes(0, 1) if difference else load[:, 2:].swapaxes(0, 1)
        pairs = _read_pairs(index, real + sign * imaginary, heading, omega)
        kinds.append(_move_to_origin(pairs, centre, depth, gravity, difference))
    return quadratic(path, 6 * len(centre), *kinds)


def mean_drift(fields: dict[str, Any], omega: Real, heading: Real) -> Real | None:
    """Diagonal (nw, nh, n) of the difference functions in ``fields``; None without them, or if
    their frequencies or headings differ from these."""
    if "qtf_difference" not in fields:
        return None
    frequencies, towards = fields["qtf_frequency"], fields["qtf_heading"][:, 0]
    rows, columns = np.argsort(omega), np.argsort(heading)
    if frequencies.shape != omega.shape or towards.shape != heading.shape:
        return None
    if not (_is_equal(frequencies, omega[rows]) and _is_equal(towards, heading[columns])):
        return None
    drift = np.empty((frequencies.size, towards.size, fields["qtf_difference"].shape[-1]))
    drift[np.ix_(rows, columns)] = np.einsum("hiid->ihd", fields["qtf_difference"]).real
    return drift


def _is_equal(a: Real, b: Real) -> bool:
    return bool(np.allclose(a, b, atol=_PRINTED))


def _qtf_head(text: Text, rows: _Rows, bodies: int) -> tuple[Real, Real, _Rows]:
    """Headings [rad], frequencies, and the rows that follow."""
    words: list[tuple[int, str]] = []
    size = 3
    for number, (line, row_values) in enumerate(rows):
        words += [(line, word) for word in row_values]
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


def _qtf_loads(text: Text, rows: _Rows, top: tuple[int, ...]) -> tuple[np.ndarray, Real]:
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


def _read_pairs(index: np.ndarray, value: Complex, heading: Real, omega: Real) -> Pairs:
    """Rows for each load (m, 6) of all structures."""
    body, towards, first, second = np.repeat(index, 6, axis=0).T
    return Pairs(
        omega=np.stack([omega[first], omega[second]], axis=-1),
        heading=np.stack([heading[towards]] * 2, axis=-1),
        dof=6 * body + np.tile(np.arange(6), len(index)),
        value=value.ravel(),
    )


def _move_to_origin(
    pairs: Pairs, centre: Real, depth: float, gravity: float, difference: bool
) -> Pairs:
    """Transfer functions per elevations at the origin, from those at each structure's centre of
    gravity."""
    value = pairs.value
    for body, point in enumerate(centre):
        moved = pairs.at_origin(point, depth, gravity, difference).value
        value = np.where(pairs.dof // 6 == body, moved, value)
    return pairs._replace(value=value)


NAME = "AQWA .AH1"

_KEYWORD = re.compile(r"[A-Z][A-Z_]+\s*$")
_NUMBER_AFTER_EQUALS = r"=\s*([-+]?\d*\.?\d+(?:[EeDd][-+]?\d+)?)"
_LISTED_VOLUME = re.compile(r"MESH BASED DISPLACEMENT[^=\n]*" + _NUMBER_AFTER_EQUALS)
_LISTED_CENTRE = re.compile(
    r"POSITION OF THE CENTRE OF BUOYANCY"
    + r"[^\n]*\n".join(rf"[^=\n]*{_NUMBER_AFTER_EQUALS}" for _ in range(3))
)


class _Head(NamedTuple):
    heading: Real
    omega: Real


def sniff(path: Path, head: bytes) -> bool:
    """Whether the name, or AQWA's first words, fit."""
    listed = head.startswith(b"*") and b"AQWA-LINE" in head
    return path.suffix.lower() == ".ah1" or listed or head.startswith(b"AQTF")


def read(path: Path, given: Given = NOTHING_GIVEN) -> HydroDatabase:
    """Database in an .AH1 file, and in the .QTF beside it. Raises `InputError` for data that are
    missing or do not fit."""
    path, table = _find_files(path)
    text = read_text(path)
    top, sections = _find_sections(text)
    head = _read_head(text, top)
    centre = _read_table(text, sections, "COG", 3)
    bodies = len(centre)
    depth, density, gravity = _read_general(text, sections)
    depth = given.water_depth or depth  # AQWA has no infinite depth, and users give a large one
    loads = _read_loads(text, sections, head, bodies)
    excitation = [
        at_origin(loads[..., body, :], head.omega, head.heading, point, depth, gravity)
        for body, point in enumerate(centre)
    ]
    volume, buoyancy = _read_displacement(text, sections, bodies)
    quadratic = second_order(table, centre, depth, gravity) if table else {}
    drift = mean_drift(quadratic, head.omega, head.heading)
    method = {} if drift is None else {"mean_drift_method": "diagonal of the QTF"}
    return assemble(
        path,
        head.omega,
        head.heading,
        given.port_starboard_symmetric,
        used=given.frequencies,
        added_mass=_read_matrices(text, sections, "ADDEDMASS", head, bodies),
        radiation_damping=_read_matrices(text, sections, "DAMPING", head, bodies),
        added_mass_zero=_read_limit(text, sections, "ADDEDMASS_LF", bodies),
        added_mass_infinite=_read_limit(text, sections, "ADDEDMASS_HF", bodies),
        excitation=np.concatenate(excitation, axis=-1),
        hydrostatic_stiffness=_read_matrix_per_body(text, sections, "HYDSTIFFNESS", bodies),
        inertia_matrix=_read_matrix_per_body(text, sections, "MASS", bodies),
        reference_point=centre,
        centre_of_gravity=centre,
        centre_of_buoyancy=points(
            path, "centre of buoyancy", given.centre_of_buoyancy, buoyancy, bodies
        ),
        volume=volumes(path, given.volume, volume),
        water_depth=depth,
        water_density=density,
        gravity=gravity,
        attributes={"solver": "AQWA", **method},
        mean_drift=drift,
        **quadratic,
    )


def _find_files(path: Path) -> tuple[Path, Path | None]:
    """The .AH1 file and the .QTF beside it, either of which may be named."""
    if path.suffix.lower() != ".qtf":
        return path, _sibling_file(path, ".QTF")
    database = _sibling_file(path, ".AH1")
    if database is None:
        raise InputError(
            f"{path}: has only AQWA's quadratic transfer functions; expected"
            f" {path.with_suffix('.AH1').name} beside it with all other data. Export the database"
            " in text form (.AH1), too."
        )
    return database, path


def _sibling_file(path: Path, suffix: str) -> Path | None:
    """File of the same name with this suffix, in upper or lower case."""
    names = (path.with_suffix(suffix), path.with_suffix(suffix.lower()))
    return next((name for name in names if name.is_file()), None)


def _find_sections(text: Text) -> tuple[_Rows, dict[str, _Rows]]:
    """Rows before the first keyword, and those after each."""
    top: _Rows = []
    sections: dict[str, _Rows] = {}
    rows = top
    for index, line in enumerate(text.lines):
        if _KEYWORD.match(line):
            rows = sections.setdefault(line.strip(), [])
        elif line.strip() and not line.startswith("*"):
            rows.append((index, line.split()))
    return top, sections


def _require_section(text: Text, sections: dict[str, _Rows], name: str) -> _Rows:
    if name not in sections:
        raise InputError(
            f"{text.path}: section {name} is missing, expected AQWA's hydrodynamic database in"
            " text form (.AH1). Did the analysis finish?"
        )
    return sections[name]


def _read_head(text: Text, top: _Rows) -> _Head:
    """Headings and frequencies; several structures must share them."""
    words = [(index, word) for index, line in top for word in line]
    if len(words) < 3:
        raise text.wrong(0, "no numbers before the sections", "counts, headings and frequencies")
    headings, count = (text.count(*words[i]) for i in (1, 2))
    size = 3 + headings + count
    if headings == 0 or count == 0 or len(words) % size:
        raise text.wrong(
            words[0][0],
            f"{len(words)} numbers before the sections",
            f"{size}, for {headings} headings and {count} frequencies, or those for each structure",
        )
    values = np.array([text.number(*word) for word in words]).reshape(-1, size)[:, 3:]
    if (values != values[0]).any():
        raise text.wrong(
            words[0][0],
            "structures with different headings or frequencies",
            "the same for all structures",
            "Run AQWA with one set of them.",
        )
    return _Head(
        np.radians(values[0, :headings]),
        frequencies(text.path, values[0, headings:], Abscissa.RADIANS_PER_SECOND),
    )


def _read_general(text: Text, sections: dict[str, _Rows]) -> tuple[float, float, float]:
    """Depth, density, gravity; a structure number precedes them in newer files."""
    rows = _require_section(text, sections, "GENERAL")
    if not rows:
        raise InputError(f"{text.path}: section GENERAL is empty, expected depth, density, gravity")
    index, words = rows[0]
    numbered = bool(text.lines[index][:3].strip())
    depth, density, gravity = text.numbers(index, words[numbered : numbered + 3], 3)
    return depth, density, gravity


def _read_table(text: Text, sections: dict[str, _Rows], name: str, width: int) -> Real:
    """Rows of a structure number and ``width`` values: (nb, width)."""
    rows = _require_section(text, sections, name)
    if not rows:
        raise InputError(f"{text.path}: section {name} is empty, expected a row for each structure")
    return np.array([text.numbers(index, words[1:], width) for index, words in rows])


def _read_blocks(
    text: Text, rows: _Rows, top: tuple[int, ...], lines: int
) -> Iterator[tuple[tuple[int, ...], list[list[float]]]]:
    """Tables of ``lines`` rows of six. The first row begins with indices up to ``top``, which are
    returned from zero."""
    for start in range(0, len(rows), lines):
        block = rows[start : start + lines]
        index, words = block[0]
        if len(block) < lines:
            raise text.wrong(index, f"{len(block)} rows", f"a table of {lines}")
        at = tuple(text.count(index, word) - 1 for word in words[: len(top)])
        if len(at) < len(top) or any(not 0 <= i < n for i, n in zip(at, top, strict=True)):
            raise text.wrong(index, f"indices {words[: len(top)]}", f"{len(top)}, up to {top}")
        words = words[len(top) :]
        yield (
            at,
            [text.numbers(i, w, 6) for i, w in [(index, words), *block[1:]]],
        )


def _read_matrix_per_body(text: Text, sections: dict[str, _Rows], name: str, bodies: int) -> Real:
    """Block-diagonal matrix (n, n)."""
    blocks = np.full((bodies, 6, 6), np.nan)
    for (body,), block in _read_blocks(text, _require_section(text, sections, name), (bodies,), 6):
        blocks[body] = block
    return block_diagonal(blocks)


def _read_matrices(
    text: Text, sections: dict[str, _Rows], name: str, head: _Head, bodies: int
) -> Real:
    """Matrices (nw, n, n); those between structures are absent if AQWA had no interaction."""
    rows = _require_section(text, sections, name)
    count = head.omega.size
    _require_count(text, name, len(rows), 6 * bodies * count)
    out = np.zeros((count, bodies, 6, bodies, 6))
    out[:, np.arange(bodies), :, np.arange(bodies), :] = np.nan
    for (a, b, w), block in _read_blocks(text, rows, (bodies, bodies, count), 6):
        out[w, a, :, b, :] = block
    return out.reshape(count, 6 * bodies, 6 * bodies)


def _read_limit(text: Text, sections: dict[str, _Rows], name: str, bodies: int) -> Real | None:
    """Matrix (n, n) at 0.001 or 100 rad/s, which AQWA computes on request."""
    if name not in sections:
        return None
    out = np.zeros((bodies, 6, bodies, 6))
    for (a, b), block in _read_blocks(text, sections[name], (bodies, bodies), 6):
        out[a, :, b, :] = block
    return out.reshape(6 * bodies, 6 * bodies)


def _read_loads(text: Text, sections: dict[str, _Rows], head: _Head, bodies: int) -> Complex:
    """Loads (nw, nh, nb, 6) per elevation at the structures' centres of gravity."""
    rows = _require_section(text, sections, "FORCERAO")
    count, headings = head.omega.size, head.heading.size
    _require_count(text, "FORCERAO", len(rows), 2 * bodies * count * headings)
    out = np.full((count, headings, bodies, 6), np.nan, dtype=complex)
    for (body, b, w), (size, lag) in _read_blocks(text, rows, (bodies, headings, count), 2):
        out[w, b, body] = polar(size, np.radians(lag))
    return out


def _require_count(text: Text, name: str, count: int, expected: int) -> None:
    """Check before memory is reserved by the numbers in the head of the file."""
    if count < expected:
        raise InputError(
            f"{text.path}: section {name} has {count} rows, expected at least {expected} for the"
            " structures, headings and frequencies in the head. The file is cut off; export it"
            " again."
        )


def _read_displacement(
    text: Text, sections: dict[str, _Rows], bodies: int
) -> tuple[Real | None, Real | None]:
    """Volumes and centres of buoyancy, from the file or the listing beside it."""
    if "DISPLACEMENT" in sections and "COB" in sections:
        return (
            _read_table(text, sections, "DISPLACEMENT", 1)[:, 0],
            _read_table(text, sections, "COB", 3),
        )
    listing = _sibling_file(text.path, ".LIS")
    return _listed_values(listing, bodies) if listing else (None, None)


def _listed_values(listing: Path, bodies: int) -> tuple[Real | None, Real | None]:
    content = "\n".join(read_text(listing).lines)
    volume = np.array(_LISTED_VOLUME.findall(content), dtype=float)
    centre = np.array(_LISTED_CENTRE.findall(content), dtype=float)
    return (
        volume if len(volume) == bodies else None,
        centre if len(centre) == bodies else None,
    )
