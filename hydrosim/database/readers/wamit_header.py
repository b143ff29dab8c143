"""Units and bodies in WAMIT's text files: .out, .pot, .mmx, second line of .gdf."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from hydrosim.database.database import Real
from hydrosim.database.readers.text import number_in, read_lines
from hydrosim.errors import InputError
from hydrosim.scene.hydrodynamics import NOTHING_GIVEN, Given

_MOST_BODIES = 1000
_MAX_NUMBER = 1e12
_GRAVITY, _CENTRE = "Gravity:", "Center of Gravity:"
_PLACE = "HBOT, XBODY(1-4), IRAD, IDIFF and six MODE, or bodies with the names of geometry files"


def main_output(path: Path) -> Given:
    """Data from the top of the main output, .out; centres are relative to the reference points."""
    lines = read_lines(path)
    points = [_read_items(path, lines, f"{axis}BODY =", 1) for axis in "XYZ"]
    turned = _read_items(path, lines, "PHIBODY =", 1)
    _check_unturned(path, [angle for (angle,) in turned])
    if len({len(axis) for axis in points}) > 1:
        raise InputError(
            f"{path}: XBODY, YBODY and ZBODY have different counts; is the file incomplete?"
        )
    flat = tuple(x for point in zip(*points, strict=True) for (x,) in point)
    water = NOTHING_GIVEN.with_values(
        water_depth=_single_value(_read_items(path, lines, "Water depth:", 1)),
        water_density=_single_value(_read_items(path, lines, "Water density:", 1)),
        reference_point=flat or None,
    )
    return _read_bodies(path, lines, water)


def control_file(path: Path) -> Given:
    """Depth and reference points from the potential control file, .pot. It has one of two forms.
    Either HBOT and XBODY of one body come first; or NBODY comes first, with an XBODY after the name
    of each geometry file.
    """
    rows = [_leading_numbers(line) for line in read_lines(path)[1:] if line.strip()]
    stream = [x for row in rows for x in row]
    after_names = [
        [x for row in rows[k + 1 :] for x in row] for k, row in enumerate(rows) if not row
    ]
    places = [numbers[:4] for numbers in after_names if _is_flags(numbers[4:10], 6)]
    if not places and _is_flags(stream[5:13], 8):
        places = [stream[1:5]]
    if not places:
        raise InputError(
            f"{path}: found other numbers after the heading, expected {_PLACE}. Is it the .pot"
            " file that WAMIT read? Repair it, or move it out of the folder and give the"
            " reference points and the depth."
        )
    _check_unturned(path, [place[3] for place in places])
    return NOTHING_GIVEN.with_values(
        water_depth=stream[0] if stream[0] > 0 else math.inf,
        reference_point=tuple(x for place in places for x in place[:3]),
    )


def _is_flags(numbers: list[float], count: int) -> bool:
    """Whether this number of WAMIT's switches is there."""
    return len(numbers) == count and {-1, 0, 1}.issuperset(numbers)


def _check_unturned(path: Path, degrees: list[float]) -> None:
    """Raises `InputError` if a body is rotated in the frame."""
    turned = [angle for angle in degrees if angle != 0]
    if turned:
        raise InputError(
            f"{path}: PHIBODY is {turned[0]:g} degrees, expected 0. Rotated bodies are not"
            " supported: run WAMIT with PHIBODY = 0 and a rotated geometry."
        )


def _leading_numbers(line: str) -> list[float]:
    """Numbers before the first word, as Fortran reads a line."""
    numbers = [number_in(token) for token in line.replace(",", " ").split()]
    words = [k for k, number in enumerate(numbers) if not abs(number) < _MAX_NUMBER]
    return numbers[: words[0]] if words else numbers


def matrix_file(path: Path) -> Given:
    """Data from the top of the .mmx file."""
    return _read_bodies(path, read_lines(path), NOTHING_GIVEN)


def _read_bodies(path: Path, lines: list[str], particulars: Given) -> Given:
    volumes = _read_items(path, lines, "(VOLX,VOLY,VOLZ):", 3)
    return particulars.with_values(
        gravity=_single_value(_read_items(path, lines, _GRAVITY, 1)),
        length=_single_value(_read_items(path, lines, "Length scale:", 1)),
        # WAMIT integrates the volume in three ways; its users take the median.
        volume=tuple(float(np.median(v)) for v in volumes) or None,
        centre_of_buoyancy=_flatten(_read_items(path, lines, "(Xb,Yb,Zb):", 3)),
        centre_of_gravity=_flatten(_read_items(path, lines, "(Xg,Yg,Zg)", 3, or_last=True)),
    )


def geometry_file(path: Path) -> Given:
    """ULEN and GRAV from the second line of the .gdf file."""
    lines = read_lines(path)
    numbers = [number_in(token) for token in lines[1].split()[:2]] if len(lines) > 1 else []
    if len(numbers) < 2 or not all(math.isfinite(x) for x in numbers):
        line_text = repr(lines[1][:40]) if len(lines) > 1 else "nothing"
        raise InputError(f"{path}, line 2: found {line_text}, expected ULEN and GRAV.")
    return NOTHING_GIVEN.with_values(length=numbers[0], gravity=numbers[1])


def inertia(path: Path, bodies: int, density: float) -> Real | None:
    """Inertia matrix (n, n) of all bodies about their reference points from the .mmx file, or None.

    ``MASS(I,J)/RHO`` (IALTFRC = 1) is per density. In ``External force matrices`` (IALTFRC = 2, 3),
    the third column is the mass as it was given to WAMIT. Indices of a body's matrix are its own, 1
    to 6, unless the file has higher ones.
    """
    entries = []
    body, factor = 1, 0.0
    for number, line in enumerate(read_lines(path), 1):
        tokens = line.split()
        if "body N" in line:
            body = _read_body_number(path, number, tokens, bodies)
        elif "MASS(I,J)/RHO" in line:
            factor = density
        elif "External force matrices" in line:
            factor = 1.0
        elif factor and len(tokens) >= 3 and tokens[0].isdigit():
            row, column, mass = _read_matrix_entry(path, number, tokens, bodies)
            entries.append((body, row, column, factor * mass))
    fits_one_body = all(max(row, column) <= 6 for _, row, column, _ in entries)
    matrix = np.zeros((6 * bodies, 6 * bodies))
    for body, row, column, mass in entries:
        before = 6 * (body - 1) - 1 if fits_one_body else -1
        matrix[before + row, before + column] = mass
    return matrix if entries else None


def _read_body_number(path: Path, number: int, tokens: list[str], bodies: int) -> int:
    after = tokens[tokens.index("=") + 1] if "=" in tokens[:-1] else ""
    if not after.isdecimal() or not 1 <= int(after[:6]) <= bodies:
        raise InputError(
            f"{path}, line {number}: found body {after[:40]!r}, expected 1 to {bodies}."
        )
    return int(after)


def _read_matrix_entry(
    path: Path, number: int, tokens: list[str], bodies: int
) -> tuple[int, int, float]:
    row, column, mass = (number_in(token) for token in tokens[:3])
    whole = row == round(row) and math.isfinite(column) and column == round(column)
    if not (whole and 1 <= row <= 6 * bodies and 1 <= column <= 6 * bodies and abs(mass) < 1e30):
        raise InputError(
            f"{path}, line {number}: found {' '.join(tokens[:3])[:60]!r}, expected two indices"
            f" from 1 to {6 * bodies} and a mass."
        )
    return int(row), int(column), mass


def _read_items(
    path: Path, lines: list[str], label: str, count: int, or_last: bool = False
) -> list[tuple[float, ...]]:
    """The ``count`` numbers after each occurrence of ``label``. If WAMIT was given only the height
    of a centre, it prints one number, ``or_last``, and the others are zero."""
    items = []
    for number, line in enumerate(lines, 1):
        if label in line and not (label == _GRAVITY and _CENTRE in line):
            tokens = line.split(label, 1)[1].lstrip(" :").split()[:count]
            values = tuple(math.inf if t == "infinite" else number_in(t) for t in tokens)
            if or_last and len(values) == 1:
                values = (*[0.0] * (count - 1), *values)
            if len(values) < count or any(
                math.isnan(v) or _MAX_NUMBER < abs(v) < math.inf for v in values
            ):
                raise InputError(
                    f"{path}, line {number}: found {' '.join(tokens)[:60]!r} after {label!r},"
                    f" expected {count} number{'s' if count > 1 else ''}."
                )
            items.append(values)
    if len(items) > _MOST_BODIES:
        raise InputError(f"{path}: {label!r} occurs {len(items)} times, expected once per body.")
    return items


def _single_value(items: list[tuple[float, ...]]) -> float | None:
    return items[0][0] if items else None


def _flatten(items: list[tuple[float, ...]]) -> tuple[float, ...] | None:
    return tuple(x for item in items for x in item) or None
