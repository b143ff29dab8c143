"""HydroStar's first-order tables in text: added mass, wave damping and loads of one body.

There is one file for each entry, such as AddedMass_11.dat, Damping_11.dat and fxf1st.rao. After a
head of lines with #, each frequency [rad/s] has the amplitudes for all headings and their phases
[degrees]. Loads lead the elevation at "Ref.pt incident wave" by their phase. Like the matrices,
they refer to "Reference point of body 1". There are no hydrostatics.

Layout: folders for a cylinder, a spar and a semi-submersible, published for the validation of Nemoh
3. They also give the signs: in long waves along x the surge load leads by 90 degrees and the heave
load is in phase. The surge load is that of the displaced and the added mass.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hydrosim.database.database import Complex, HydroDatabase, Real
from hydrosim.database.readers.assembly import (
    Abscissa,
    assemble,
    elevation,
    frequencies,
    points,
    polar,
    volumes,
)
from hydrosim.database.readers.hydrostar_table import (
    check_head,
    head_of,
    numbers_after,
    numbers_of,
    rows_of,
    water_of,
)
from hydrosim.database.readers.text import Text, read_text
from hydrosim.errors import InputError
from hydrosim.scene.hydrodynamics import Given, first_given

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


def read(paths: Sequence[Path], given: Given) -> HydroDatabase:
    """Database in these files of a folder. Raises `InputError` for data that are missing or do not
    fit."""
    entries = [entry for path in paths if (entry := _entry(read_text(path))).kind in _EVERY]
    first = _check_entries(paths[0], entries)
    found = first_given(first.given, given)
    loads = np.stack([_entry_of(entries, _LOAD, k).value for k in _EVERY[_LOAD]], axis=-1)
    depth = float(found.water_depth or np.inf)
    gravity = float(found.gravity or np.nan)
    start = _entry_of(entries, _LOAD, 1)
    omega = start.frequency
    waves = elevation(omega[:, None], start.heading, first.wave_point, depth, gravity)
    path = paths[0]
    return assemble(
        path,
        omega,
        start.heading,
        given.port_starboard_symmetric,
        used=given.frequencies,
        added_mass=_matrix(entries, _MASS),
        radiation_damping=_matrix(entries, _DAMPING),
        excitation=loads * waves[..., None],
        reference_point=points(path, "reference point", given.reference_point, first.point, 1),
        volume=volumes(path, given.volume, None),
        centre_of_buoyancy=points(path, "centre of buoyancy", given.centre_of_buoyancy, None, 1),
        centre_of_gravity=points(path, "centre of gravity", given.centre_of_gravity, None, 1),
        water_depth=depth,
        water_density=float(found.water_density or np.nan),
        gravity=gravity,
        attributes={"program": "HydroStar"},
    )


def _entry_of(entries: Sequence[LinearEntry], kind: str, component: int) -> LinearEntry:
    return next(e for e in entries if (e.kind, e.component) == (kind, component))


def _matrix(entries: Sequence[LinearEntry], kind: str) -> Real:
    """(nw, 6, 6), in the order of the components."""
    columns = [_entry_of(entries, kind, component).value[:, 0].real for component in _EVERY[kind]]
    return np.stack(columns, axis=-1).reshape(-1, 6, 6)


def _check_entries(path: Path, entries: Sequence[LinearEntry]) -> LinearEntry:
    """The first entry. Raises `InputError` if one is missing, occurs twice or has other waves."""
    for kind, wanted in _EVERY.items():
        components = [entry.component for entry in entries if entry.kind == kind]
        lost = sorted({*wanted} - {*components})
        if lost or len(components) > len(wanted):
            found = f"no {', '.join(map(str, lost))}" if lost else "one of them twice"
            raise InputError(
                f"{path}: found {found} of the tables #RAOTYPE {kind} in its folder; expected"
                f" each of {wanted[0]} to {wanted[-1]} once. Let HydroStar write all of them, and"
                " keep each computation in a folder of its own."
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


def _entry(text: Text) -> LinearEntry:
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
        frequencies(text.path, rows[:, 0], Abscissa.RADIANS_PER_SECOND),
        polar(size, -np.radians(phase)),
    )
