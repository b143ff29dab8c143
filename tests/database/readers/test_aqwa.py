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


# One frequency and two headings of the file that AQWA-LINE 2020 R1 wrote for a half-submerged
# sphere of 5 m radius in 50 m of water (WEC-Sim's examples; its mass is no sphere's).
SPHERE = """\
* DATE:29/11/21      TIME:11:55:55
* FILE VERSION NO 5  CREATED BY AQWA-LINE VERSION 2020 R1.
* ADDED MASS AND DAMPING AT LOW-FREQUENCY (0.001RAD/S), AND ADDED MASS AT HIGH-
* FREQUENCY (100.0RAD/S) ARE OUTPUT, IF LHFR OPTION IS ON
*
  1  2   1   -180.00000     0.00000
              0.7976751
GENERAL
  1              50.000    1025.000       9.807     0     0
COG
  1               0.000       0.000      -2.000
DRAFT
  1               5.000
COB
  1               0.000       0.000      -1.874
DISPLACEMENT
  1          2.6135E+02
MASS
  1          2.6788E+05  0.0000E+00  0.0000E+00  0.0000E+00  0.0000E+00  0.0000E+00
             0.0000E+00  2.6788E+05  0.0000E+00  0.0000E+00  0.0000E+00  0.0000E+00
             0.0000E+00  0.0000E+00  2.6788E+05  0.0000E+00  0.0000E+00  0.0000E+00
             0.0000E+00  0.0000E+00  0.0000E+00  2.6788E+05  0.0000E+00  0.0000E+00
             0.0000E+00  0.0000E+00  0.0000E+00  0.0000E+00  2.6788E+05  0.0000E+00
             0.0000E+00  0.0000E+00  0.0000E+00  0.0000E+00  0.0000E+00  2.6788E+05
HYDSTIFFNESS
  1          0.0000E+00  0.0000E+00  0.0000E+00  0.0000E+00  0.0000E+00  0.0000E+00
             0.0000E+00  0.0000E+00  0.0000E+00  0.0000E+00  0.0000E+00  0.0000E+00
             0.0000E+00  0.0000E+00  7.8895E+05 -4.0702E+00  8.4256E-01  0.0000E+00
             0.0000E+00  0.0000E+00 -4.0702E+00  5.2583E+06  1.7251E-01 -1.0410E-02
             0.0000E+00  0.0000E+00  8.4256E-01  1.7251E-01  5.2583E+06 -5.7654E-01
             0.0000E+00  0.0000E+00  0.0000E+00  0.0000E+00  0.0000E+00  0.0000E+00
ADDEDMASS
  1  1   1   1.3819E+05 -9.4695E+02  6.4816E+03 -2.0537E+04  8.3868E+05  5.7943E-01
            -9.4286E+02  1.3828E+05 -6.7909E+03 -8.3705E+05  2.0446E+04 -2.2820E-01
            -1.4219E+03  1.4956E+03 -1.0046E+06  3.2516E+04  3.1276E+04 -3.2717E-01
             3.1444E+03 -3.1288E+05  2.3288E+04 -6.8363E+06 -6.6686E+04  5.0805E-01
             3.1269E+05 -3.2460E+03  2.2903E+04 -6.8888E+04 -6.8333E+06  1.3308E+00
             5.7519E-01 -2.3546E-01 -7.4804E-01  1.0394E+00  3.4763E+00  2.1689E-02
DAMPING
  1  1   1   4.9054E+03 -7.6931E+01 -7.8876E+02 -6.5779E+02  3.1356E+04  2.1927E-02
            -7.6594E+01  4.9123E+03  8.2686E+02 -3.1305E+04  6.5572E+02 -9.3224E-03
            -5.8004E+02  6.1225E+02  1.3063E+05  1.1571E+04  1.1047E+04 -1.3900E-01
             2.1598E+02 -1.1186E+04 -3.1549E+03  7.1118E+04 -1.3698E+03  2.2720E-02
             1.1171E+04 -2.2077E+02 -3.1188E+03 -1.3628E+03  7.1241E+04  5.1384E-02
             2.1895E-02 -9.5362E-03 -2.9136E-01  2.1992E-02  1.0576E-01  4.1509E-07
ADDEDMASS_HF
  1  1       7.4864E+04  3.5326E-01  1.3551E+00 -5.8268E-01  1.4973E+05  2.9995E-01
             3.5637E-01  7.4865E+04  2.9522E+00 -1.4973E+05  5.8445E-01 -1.3168E-01
            -8.6024E+00  1.0761E+01  1.3599E+05 -2.0456E+01 -1.8201E+01 -1.3677E-01
             1.9829E+01 -1.4988E+05 -5.5949E+00  2.9929E+05  4.0511E+01  2.5821E-01
             1.4990E+05 -2.0413E+01  3.4735E+00  4.1195E+01  2.9932E+05  6.0473E-01
             2.9658E-01 -1.3779E-01 -1.7381E-01  2.7006E-01  5.9629E-01  2.1686E-02
FIDD
  1          0.0000E+00  0.0000E+00  0.0000E+00  0.0000E+00  0.0000E+00  0.0000E+00
FORCERAO
  1  1   1   1.9426E+05  4.7340E+03  5.0174E+05  1.6243E+04  4.4442E+05  1.5248E+00
                  91.70      -26.01      -12.07      153.77       92.32      136.76
  1  2   1   1.9292E+05  4.1446E+03  4.9888E+05  1.4279E+04  4.3921E+05  1.2380E+00
                 -90.60       10.64      -11.63     -171.16      -91.24     -151.75
"""


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


def test_a_real_file_loads_the_sphere_as_wamit_does(validation, tmp_path):
    """In size within a sixth and in phase within 10 degrees: AQWA's pressures are poor here, as
    its negative added mass in heave shows."""
    path = tmp_path / "sphere.AH1"
    path.write_text(SPHERE)
    db, other = read(path), read(validation / "sphere" / "sphere.h5")
    w = int(np.argmin(np.abs(other.frequency - 0.8)))
    ahead = db.heading.tolist().index(0.0)
    for dof in (0, 2, 4):
        ratio = db.excitation[0, ahead, dof] / (1.025 * other.excitation[w, 0, dof])
        assert abs(ratio) == pytest.approx(1.0, abs=1 / 6)
        assert abs(np.degrees(np.angle(ratio))) < 10
    astern = db.excitation[0, 1 - ahead, 0] / db.excitation[0, ahead, 0]
    assert astern == pytest.approx(-1.0, abs=0.1)
    assert db.hydrostatic_stiffness[2, 2] == pytest.approx(1025 * 9.807 * np.pi * 25, rel=0.01)
    assert db.volume[0] == 261.35
    np.testing.assert_array_equal(db.centre_of_buoyancy, [[0.0, 0.0, -1.874]])
    assert db.added_mass_infinite[2, 2] == 1.3599e5


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
    with pytest.raises(InputError, match=r"line \d+: found '10a5\.000', expected a finite number"):
        read(path)
    path.write_text(text.replace("  1 73   6", "  1 73 999"))
    with pytest.raises(InputError, match="expected 1075, for 73 headings and 999 frequencies"):
        read(path)


def test_damaged_files_are_refused(barge, path):
    count = damaged.refused(aqwa.read, path, path.read_bytes(), "ANALYSIS.AH1")
    assert 50 < count
