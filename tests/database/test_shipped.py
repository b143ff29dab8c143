"""The other databases in hydro_db: the box in deep water, the launch barge in 50 m."""

from pathlib import Path

import numpy as np
import pytest

from hydrosim.database import HydroDatabase, check, load
from hydrosim.database.load import read

HYDRO_DB = Path(__file__).parents[2] / "hydro_db"
RHO_G = 1025.0 * 9.81


@pytest.fixture(scope="module")
def box() -> HydroDatabase:
    return load(HYDRO_DB / "box.nc")


@pytest.fixture(scope="module")
def shallow() -> HydroDatabase:
    return load(HYDRO_DB / "h851_50m.nc")


KERNEL, IRREGULAR = "kernel truncation", "irregular frequencies"
DOUBTS = {  # why: hydro_db/README.md
    "two_barges": {KERNEL, IRREGULAR, "frequency spacing", "added mass against damping"},
    "hinged_barges": {KERNEL},
    "point_absorber": {KERNEL, "heave stiffness"},
    "tanker": {KERNEL},
    "barge_and_tender": {
        *(KERNEL, IRREGULAR, "positive damping"),
        *("added mass at infinite frequency", "damping against loads"),
    },
}


def test_checks_find_nothing_that_is_not_known():
    for path in HYDRO_DB.glob("*.nc"):
        assert path.stat().st_size < (5_000_000 if path.stem == "h851" else 2_000_000)
        found = {finding.name for finding in check(read(path)) if not finding.has_passed}
        assert found == DOUBTS.get(path.stem, set())


def test_hydrostatics_of_the_box(box):
    L, B, T = 100.0, 20.0, 5.0
    lever = L * B * T * (-T / 2 - 0.0)
    expected = RHO_G * np.array([0, 0, L * B, L * B**3 / 12 + lever, B * L**3 / 12 + lever, 0])
    np.testing.assert_allclose(box.hydrostatic_stiffness, np.diag(expected), atol=1e-3)
    assert box.volume[0] == pytest.approx(L * B * T)
    assert box.inertia_matrix[0, 0] == pytest.approx(1025.0 * L * B * T)


def test_box_is_the_same_from_both_ends(box):
    """Waves towards 180 - b load it as those towards b, with surge, pitch and yaw reversed and, in
    first order, nothing else, because the phase is that amidships."""
    turned = np.array([-1, 1, 1, 1, -1, -1])
    for name in ("excitation", "froude_krylov", "mean_drift", "mean_drift_held"):
        loads = getattr(box, name)
        scale = np.abs(loads).max(axis=(0, 1)) + 1e-6 * np.abs(loads).max()
        image = loads[:, ::-1] * turned
        np.testing.assert_allclose(image / scale, loads / scale, atol=1e-3)


def test_short_waves_are_thrown_back(box):
    """rho g / 2 times the breadth that they meet (Newman 1967)."""
    i = int(np.argmin(np.abs(box.frequency - 2.4)))
    assert box.mean_drift[i, 0, 0] == pytest.approx(RHO_G / 2 * 20, rel=0.05)
    assert box.mean_drift[i, 6, 1] == pytest.approx(RHO_G / 2 * 100, rel=0.05)


def test_energy_balance_of_the_drift(box, shallow):
    """Along and across the hull, in waves short enough to be scattered: 1.5 per cent for the box,
    2.3 for the barge in 50 m."""
    for db, lowest, bound in ((box, 0.8, 0.02), (shallow, 0.5, 0.03)):
        used = (db.frequency > lowest - 1e-6) & (db.frequency < 2.001)
        assert np.abs(db.drift_imbalance[used][:, [0, 6, 12]]).max() < bound


def test_short_waves_do_not_feel_the_sea_bed(barge, shallow):
    """From 1.2 rad/s, where k h is 7 and more, loads are those of deep water within 1 per cent of
    the largest, and damping within 3.5: added mass, which the bed keeps changing, leaks into it,
    and the panels differ, by 1 per cent because only the deep one's damping is extrapolated."""
    rows = [i for i, w in enumerate(shallow.frequency) if w > 1.199 and round(w * 100) % 2 == 0]
    deep = [int(np.argmin(np.abs(barge.frequency - shallow.frequency[i]))) for i in rows]
    some = [int(np.argmin(np.abs(barge.heading - b))) for b in shallow.heading]
    for name in ("radiation_damping", "excitation"):
        there, here = getattr(shallow, name), getattr(barge, name)
        here = here[:, some] if name == "excitation" else here
        diagonal = np.abs(np.diagonal(there, axis1=1, axis2=2)).max(axis=0)
        scale = (
            np.sqrt(np.outer(diagonal, diagonal))
            if name == "radiation_damping"
            else np.abs(there).max(axis=(0, 1))
        )
        bound = 0.035 if name == "radiation_damping" else 0.01
        assert (np.abs(there[rows] - here[deep]) / scale).max() < bound


def test_sea_bed_adds_to_the_mass(barge, shallow):
    """In heave, by the image of the double hull under the bed: 15 per cent at infinite frequency
    (by images in deep water, see test_build)."""
    ratio = shallow.added_mass_infinite[2, 2] / barge.added_mass_infinite[2, 2]
    assert ratio == pytest.approx(1.15, abs=0.02)
    assert shallow.added_mass_zero is None
