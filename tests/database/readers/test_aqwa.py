from __future__ import annotations

from pathlib import Path

import damaged
import numpy as np
import pytest

from hydrosim.database import HydroDatabase
from hydrosim.database.load import read
from hydrosim.database.readers import aqwa
from hydrosim.errors import InputError

CENTRE = np.array([30.0, -12.0, -4.9])  # of the barge in the file's frame
USED = slice(0, 60, 10)
PRINTED = 1e-4  # five digits
DEEP = 9e29  # AQWA has no infinite depth


def _values(values: np.ndarray, indices: tuple[int, ...] = ()) -> list[str]:
    head = "".join(f"{i:3d}" for i in indices[:2]) + "".join(f"{i:4d}" for i in indices[2:])
    rows = ["".join(f"{value:12.4E}" for value in row) for row in values]
    return [f"{head if number == 0 else '':10}" + row for number, row in enumerate(rows)]


def _by_frequency(name: str, matrices: np.ndarray) -> list[str]:
    return [name] + [r for w, m in enumerate(matrices) for r in _values(m, (1, 1, w + 1))]


def _loads(db: HydroDatabase) -> list[str]:
    lines = ["FORCERAO"]
    for b in range(db.heading.size):
        for w, load in enumerate(db.excitation[USED, b]):
            lag = -np.degrees(np.angle(load))
            lines += _values(np.abs(load)[None], (1, b + 1, w + 1))
            lines += [f"{'':10}" + "".join(f"{value:12.2f}" for value in lag)]
    return lines


def _wrapped(values: np.ndarray, form: str, first: str) -> list[str]:
    """Six on a line."""
    rows = ["".join(f"{v:{form}}" for v in values[i : i + 6]) for i in range(0, len(values), 6)]
    return [f"{first if number == 0 else '':10}" + row for number, row in enumerate(rows)]


def written(db: HydroDatabase) -> str:
    """As AQWA-LINE 2020 R1 does, for one structure."""
    omega, heading = db.frequency[USED], np.degrees(db.heading)
    lines = [
        "* DATE:01/01/22",
        "* FILE VERSION NO 5  CREATED BY AQWA-LINE VERSION 2020 R1.",
        *_wrapped(heading, "12.5f", f"  1 {heading.size:2d}{omega.size:4d}"),
        *_wrapped(omega, "12.7f", ""),
        "GENERAL",
        f"  1       {DEEP:12.1E}    1025.000       9.810     0     0",
        "COG",
        "  1       " + "".join(f"{x:12.3f}" for x in CENTRE),
        "DRAFT",
        "  1              12.400",
        "COB",
        "  1       " + "".join(f"{x:12.3f}" for x in CENTRE + np.array([0.0, 0.0, -1.1])),
        "DISPLACEMENT",
        f"  1       {db.volume[0]:12.4E}",
        "MASS",
        *_values(db.inertia_matrix, (1,)),
        "HYDSTIFFNESS",
        *_values(db.hydrostatic_stiffness, (1,)),
        *_by_frequency("ADDEDMASS", db.added_mass[USED]),
        *_by_frequency("DAMPING", db.radiation_damping[USED]),
        "ADDEDMASS_HF",
        *_values(db.added_mass_infinite, (1, 1)),
        "FIDD",
        *_values(np.zeros((1, 6)), (1,)),
        *_loads(db),
    ]
    return "\n".join(lines) + "\n"


@pytest.fixture
def path(barge, tmp_path) -> Path:
    out = tmp_path / "ANALYSIS.AH1"
    out.write_text(written(barge))
    return out


def test_reads_what_was_written(barge, path):
    db = read(path)
    np.testing.assert_allclose(db.frequency, barge.frequency[USED], atol=1e-7)
    np.testing.assert_allclose(db.heading, barge.heading, atol=1e-7)
    for name in ("added_mass", "radiation_damping"):
        np.testing.assert_allclose(getattr(db, name), getattr(barge, name)[USED], rtol=PRINTED)
    for name in ("inertia_matrix", "hydrostatic_stiffness", "added_mass_infinite"):
        np.testing.assert_allclose(getattr(db, name), getattr(barge, name), rtol=PRINTED)
    np.testing.assert_allclose(db.volume, barge.volume, rtol=PRINTED)
    np.testing.assert_array_equal(db.reference_point, [CENTRE])
    assert db.added_mass_zero is None
    assert (db.water_density, db.gravity) == (1025.0, 9.81)


def test_phases_move_from_the_centre_of_gravity_to_the_origin(barge, path):
    """The wave that has crests at the origin is late at the hull by k (x cos b + y sin b)."""
    db = read(path)
    k = barge.frequency[USED] ** 2 / 9.81
    along = CENTRE[0] * np.cos(barge.heading) + CENTRE[1] * np.sin(barge.heading)
    expected = barge.excitation[USED] * np.exp(-1j * np.outer(k, along))[..., None]
    error = np.abs(db.excitation - expected)
    assert (error <= 2e-4 * np.abs(expected)).all()  # 0.01 degrees


def test_long_waves_lift_the_hull(barge, path):
    db = read(path)
    head = int(np.argmin(np.abs(db.heading)))
    load = db.excitation[0, head] * np.exp(1j * db.frequency[0] ** 2 / 9.81 * CENTRE[0])
    assert load[2] == pytest.approx(db.hydrostatic_stiffness[2, 2], rel=0.02)
    assert np.angle(load[0]) == pytest.approx(np.pi / 2, abs=0.02)


def test_older_files_and_their_listing(barge, tmp_path):
    """Before version 2020: no numbers in GENERAL, volume and centre of buoyancy in the listing."""
    lines = written(barge).split("\n")
    start = lines.index("COB")
    lines[start : start + 4] = []
    general = lines.index("GENERAL") + 1
    lines[general] = "               1000.000    1025.000       9.810     1"
    path = tmp_path / "old.AH1"
    path.write_text("\n".join(lines))
    assert read(path).volume is None
    (tmp_path / "old.LIS").write_text(
        "MESH BASED DISPLACEMENT. . . . . . . =   1.52935E+05\n"
        "POSITION OF THE CENTRE OF BUOYANCY   BX =    30.0\n"
        "                                     BY =   -12.0\n"
        "                                     BZ =    -6.0\n"
    )
    db = read(path)
    assert db.volume[0] == 152935.0
    np.testing.assert_array_equal(db.centre_of_buoyancy, [[30.0, -12.0, -6.0]])
    assert db.water_depth == 1000.0


def test_two_structures_and_their_coupling(tmp_path):
    """Rows are of the first structure named, columns of the second."""
    numbers = np.arange(36.0).reshape(6, 6)
    pairs = [(a, b) for a in (1, 2) for b in (1, 2)]
    lines = [
        *[line for s in (1, 2) for line in (f"  {s}  1   1     0.00000", "            0.5000000")],
        "GENERAL",
        "  1             100.000    1000.000      10.000     0     0",
        "COG",
        "  1               0.000       0.000       0.000",
        "  2              50.000       0.000       0.000",
        "MASS",
        *_values(numbers, (1,)),
        *_values(numbers + 100, (2,)),
        "HYDSTIFFNESS",
        *_values(numbers, (1,)),
        *_values(numbers, (2,)),
        "ADDEDMASS",
        *[r for a, b in pairs for r in _values(numbers + 100 * a + 1000 * b, (a, b, 1))],
        "DAMPING",
        *[r for a in (1, 2) for r in _values(numbers, (a, a, 1))],
        "FORCERAO",
        *[r for a in (1, 2) for r in _values(np.ones((2, 6)), (a, 1, 1))],
    ]
    path = tmp_path / "two.AH1"
    path.write_text("\n".join(lines))
    db = read(path)
    assert db.bodies == 2
    assert db.added_mass[0, 1, 8] == 1 * 100 + 2 * 1000 + 8
    assert db.added_mass[0, 8, 1] == 2 * 100 + 1 * 1000 + 13
    assert not db.radiation_damping[0, :6, 6:].any()
    assert db.inertia_matrix[6, 7] == 101
    assert np.angle(db.excitation[0, 0, 0]) == pytest.approx(-np.radians(1.0))


def test_messages_name_line_and_section(barge, path):
    text = path.read_text()
    path.write_text(text.replace("HYDSTIFFNESS", "STIFFNESS"))
    with pytest.raises(InputError, match=r"ANALYSIS\.AH1: section HYDSTIFFNESS is missing"):
        read(path)
    path.write_text(text.replace("1025.000", "10a5.000"))
    with pytest.raises(InputError, match=r"line 8: found '10a5\.000', expected a finite number"):
        read(path)
    path.write_text(text.replace("  1 13   6", "  1 13 999"))
    with pytest.raises(InputError, match="expected 1015, for 13 headings and 999 frequencies"):
        read(path)


def test_damaged_files_are_refused(barge, path):
    count = damaged.refused(aqwa.read, path, path.read_bytes(), "ANALYSIS.AH1")
    assert 50 < count
