from dataclasses import replace
from pathlib import Path

import damaged
import numpy as np
import pytest

from hydrosim.database import HydroDatabase, move_reference
from hydrosim.database.load import load, read
from hydrosim.database.readers import marin
from hydrosim.errors import InputError
from hydrosim.scene.hydrodynamics import Given

USED = slice(0, 40, 8)
WATERLINE = 12.4  # above the file's origin, which is at the keel
CENTRE = (0.0, 0.0, -4.9)
GIVEN = Given(water_density=1025.0, gravity=9.81, centre_of_gravity=CENTRE)
PRINTED = 1e-4  # a number that fills its field has five digits, with an exponent


def _field(value: float) -> str:
    """Ten characters, all of them if need be: neighbours then touch."""
    digits = next(d for d in range(9, 0, -1) if len(f"{value:.{d}g}") <= 10)
    return f"{value:.{digits}g}".rjust(10)


def _record(keyword: str, *values: float) -> str:
    return keyword.ljust(10) + "".join(_field(value) for value in values)


def _at_keel(db: HydroDatabase) -> HydroDatabase:
    """The barge's coefficients about the origin of the file."""
    return move_reference(db, [[0.0, 0.0, -WATERLINE]])


def written(db: HydroDatabase, symmetry: int = 1, flotation: float | None = None) -> str:
    """By the description of the format: tonnes, kN, degrees, lags behind the crest."""
    keel, c, weight = _at_keel(db), db.hydrostatic_stiffness, 1025.0 * 9.81
    volume, area = db.volume[0], c[2, 2] / weight
    x = -c[2, 4] / c[2, 2] if flotation is None else flotation
    height = WATERLINE + CENTRE[2]
    longitudinal = (c[4, 4] - c[2, 2] * x**2) / weight / volume
    metacentres = c[3, 3] / weight / volume + height, longitudinal + height
    lines = ["IDENT     a barge"] * 15
    lines += [_record("REFS", 0, 12.4, WATERLINE, 0)]
    lines += [_record("SPRING", volume, area, x, 0, *metacentres)]
    lines += [_record("PARA", len(keel.frequency[USED]), keel.heading.size, symmetry)]
    for w in range(len(keel.frequency))[USED]:
        lines += [_record("OMEGA", keel.frequency[w])]
        lines += [_record("ADMAS", *row) for row in keel.added_mass[w] / 1e3]
        lines += [_record("BDAMP", *row) for row in keel.radiation_damping[w] / 1e3]
        for beta, force in zip(keel.heading, keel.excitation[w] / 1e3, strict=True):
            lines += [_record("WDIR", np.degrees(beta)), _record("FAMP", *np.abs(force))]
            lines += [_record("FEPS", *-np.degrees(np.angle(force)))]
    return "\n".join([*lines, _record("PARA2", 0, 0), "END", ""])


@pytest.fixture
def path(barge, tmp_path) -> Path:
    out = tmp_path / "barge.hyd"
    out.write_text(written(barge))
    return out


def close(actual: np.ndarray, expected: np.ndarray, tolerance: float) -> None:
    """In parts of the largest for each DOF, for small numbers lose digits in moving."""
    scale = np.abs(expected).max(axis=tuple(range(expected.ndim - 1)))
    assert (np.abs(actual - expected) <= tolerance * scale + 1e-6).all()


def test_reads_what_was_written(barge, path):
    db, keel = read(path, GIVEN), _at_keel(barge)
    np.testing.assert_allclose(db.frequency, barge.frequency[USED], rtol=PRINTED)
    np.testing.assert_allclose(db.heading, barge.heading, atol=1e-12)
    close(db.added_mass, keel.added_mass[USED], PRINTED)
    close(db.radiation_damping, keel.radiation_damping[USED], PRINTED)
    close(db.excitation, keel.excitation[USED], PRINTED)
    assert db.volume[0] == pytest.approx(barge.volume[0], rel=PRINTED)
    np.testing.assert_array_equal(db.reference_point, [[0.0, 0.0, -12.4]])
    assert db.port_starboard_symmetric
    assert np.isinf(db.water_depth)


def test_the_sample_has_numbers_that_touch(path):
    text = path.read_text()
    assert any(len(row.split()) < 7 for row in text.split("\n") if row.startswith("ADMAS"))


def test_stiffness_from_waterplane_and_metacentres(barge, path):
    """That of the barge about its centre of gravity, at the same height as the origin or not:
    pitching about another height moves no waterplane."""
    stiffness, expected = read(path, GIVEN).hydrostatic_stiffness, barge.hydrostatic_stiffness
    np.testing.assert_allclose(stiffness, expected, rtol=1e-5, atol=1e-6 * expected[4, 4])
    assert read(path, Given(water_density=1025.0, gravity=9.81)).hydrostatic_stiffness is None


def test_long_waves_lift_the_hull(path):
    db = read(path, GIVEN)
    assert db.excitation[0, 0, 2] == pytest.approx(db.hydrostatic_stiffness[2, 2], rel=0.02)
    assert np.angle(db.excitation[0, 0, 0]) == pytest.approx(np.pi / 2, abs=0.02)


@pytest.mark.filterwarnings("ignore:.*kernel truncation")
def test_passes_the_checks_of_physics(path):
    load(path, replace(GIVEN, centre_of_buoyancy=(0.0, 0.0, -6.0)))


def test_symmetry_fore_and_aft_gives_the_other_headings(barge, tmp_path):
    """The load on a hull by waves from ahead is the image of that by waves from behind."""
    some = [0, 12, 36]
    db = replace(
        barge,
        heading=barge.heading[some],
        excitation=barge.excitation[:, some],
        froude_krylov=None,
        mean_drift=None,
        mean_drift_held=None,
        drift_imbalance=None,
    )
    path = tmp_path / "box.hyd"
    path.write_text(written(db, symmetry=2))
    other = read(path, Given(water_density=1025.0, gravity=9.81))
    np.testing.assert_allclose(np.degrees(other.heading), [0, 30, 90, 150, 180], atol=1e-6)
    images = other.excitation[:, [0, 1]] * [-1, 1, 1, 1, -1, -1]
    np.testing.assert_array_equal(other.excitation[:, [4, 3]], images)


def test_what_the_file_lacks_must_be_given(path):
    with pytest.raises(InputError, match=r"barge\.hyd: found no water density"):
        read(path)


def test_a_centre_of_flotation_from_another_origin_is_refused(barge, path):
    path.write_text(written(barge, flotation=118.0))
    with pytest.raises(
        InputError, match="line 17: found a centre of flotation at 118 m, while long waves show -0"
    ):
        read(path, GIVEN)


def test_messages_name_the_line(path):
    text = path.read_text()
    path.write_text(text.replace("PARA               5", "PARA               9"))
    with pytest.raises(InputError, match=r"found 'PARA2', expected keyword OMEGA"):
        read(path, GIVEN)
    path.write_text(text.replace("\nEND", "").replace("PARA2", "ADMAS"))
    with pytest.raises(InputError, match="Files of several bodies"):
        read(path, GIVEN)


def test_damaged_files_are_refused(path):
    count = damaged.refused(lambda p: marin.read(p, GIVEN), path, path.read_bytes(), "barge.hyd")
    assert 50 < count
