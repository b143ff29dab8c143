import shutil
from pathlib import Path

import damaged
import numpy as np
import pytest

from hydrosim.database import HydroDatabase, load
from hydrosim.database.load import read
from hydrosim.database.readers import veres
from hydrosim.errors import InputError

USED = slice(0, 60, 10)
HEADINGS = [36, 45, 63]  # of the barge: waves to 180, 225 and 315 degrees
TURN = np.diag([-1.0, -1.0, 1.0, -1.0, -1.0, 1.0])  # x forward, y to port: x aft, y to starboard
LENGTH, BREADTH, DRAUGHT = 260.0, 63.0, 12.4
AFT, KEEL = 3.5, 15.0  # centre of gravity from amidships and the keel
SPEEDS = (5.0, 0.0)


def _row(*numbers: float) -> str:
    return "".join(f"{x:16.8E}" for x in numbers)


def _head(title: str) -> list[str]:
    text = [f" {title} - VERES Version  4.02.3", *[" hull"] * 5]
    return [*text, _row(1025.0, 9.81), _row(LENGTH, BREADTH, DRAUGHT)]


def _counts(*more: int) -> str:
    return "".join(f"{n:6d}" for n in (len(SPEEDS), len(HEADINGS), 6, *more))


def coefficients(db: HydroDatabase) -> str:
    """The barge's, whose motions are about a point 1 m behind its centre of gravity, on the
    waterline; where the ship sails numbers are others."""
    lines = [*_head("HYDRODYNAMIC COEFFICIENTS"), _row(AFT, KEEL), "    -1     2", _counts(6)]
    lines += [_row(*row) for row in TURN @ db.inertia_matrix @ TURN]
    for speed in SPEEDS:
        lines.append(_row(speed, 0.0, 0.0, AFT + 1.0, DRAUGHT))
        for heading in HEADINGS:
            lines.append(f"{np.degrees(db.heading[heading]) - 180:11.2f}")
            for w in range(60)[USED]:
                lines.append(f"  {db.frequency[w]:.8f}")
                kinds = db.added_mass[w], db.radiation_damping[w], db.hydrostatic_stiffness
                for kind in kinds:
                    moved = TURN @ kind @ TURN * (1 + speed)
                    lines += [_row(*row) for row in moved]
                    lines += [_row(*[0.0] * 6)] * 6
                lines.append(_row(0.0, 0.0, 0.0))
    return "\n".join(lines) + "\n"


def loads(db: HydroDatabase) -> str:
    lines = [*_head("WAVE EXCITATION FORCE TRANSFER FUNCTIONS"), _row(AFT, KEEL), _counts(6)]
    for speed in SPEEDS:
        lines.append(_row(speed, 0.0, 0.0, AFT + 1.0, DRAUGHT))
        for heading in HEADINGS:
            lines.append(f"{np.degrees(db.heading[heading]) - 180:11.2f}")
            for w in range(60)[USED]:
                lines.append(f"  {db.frequency[w]:.8f}")
                for dof, value in enumerate(TURN @ db.excitation[w, heading] * (1 + speed), 1):
                    lines.append(f"{dof:3d}{_row(value.real, value.imag)}")
    return "\n".join(lines) + "\n"


def drift(db: HydroDatabase) -> str:
    lines = [*_head("ADDED RESISTANCE"), _counts()]
    scale = 1025.0 * 9.81 * BREADTH**2 * np.array([1 / LENGTH, 1 / LENGTH, 1.0])
    for speed in SPEEDS:
        for heading in HEADINGS:
            lines.append(f"{speed:11.5f}{np.degrees(db.heading[heading]) - 180:11.2f}")
            for w in range(60)[USED]:
                three = (TURN @ db.mean_drift[w, heading])[[0, 1, 5]] / scale * (1 + speed)
                lines.append(f"{db.frequency[w]:9.4f}" + "".join(f"{x:15.6E}" for x in three))
    return "\n".join(lines) + "\n"


@pytest.fixture
def path(barge, tmp_path) -> Path:
    (tmp_path / "hull.re8").write_text(loads(barge))
    (tmp_path / "hull.re2").write_text(drift(barge))
    out = tmp_path / "hull.re7"
    out.write_text(coefficients(barge))
    return out


@pytest.fixture
def supply(validation, tmp_path) -> Path:
    """The files of MSS's supply vessel, to be changed."""
    shutil.copytree(validation / "veres", tmp_path / "veres")
    return tmp_path / "veres" / "supply.re7"


@pytest.mark.parametrize("named", ["hull.re7", "hull.re8", "hull"])
def test_reads_what_was_written(barge, path, named):
    db = read(path.with_name(named))
    np.testing.assert_allclose(db.frequency, barge.frequency[USED], rtol=1e-7)
    np.testing.assert_allclose(db.heading, barge.heading[HEADINGS], atol=1e-12)
    close = {"rtol": 1e-7, "atol": 1e-3}
    for name in ("added_mass", "radiation_damping"):
        np.testing.assert_allclose(getattr(db, name), getattr(barge, name)[USED], **close)
    for name in ("inertia_matrix", "hydrostatic_stiffness"):
        np.testing.assert_allclose(getattr(db, name), getattr(barge, name), **close)
    np.testing.assert_allclose(db.excitation, barge.excitation[USED][:, HEADINGS], **close)
    kept = barge.mean_drift[USED][:, HEADINGS] * [1, 1, 0, 0, 0, 1]
    np.testing.assert_allclose(db.mean_drift, kept, rtol=1e-5, atol=1e-3)
    np.testing.assert_array_equal(db.centre_of_gravity, [[1.0, 0.0, KEEL - DRAUGHT]])
    np.testing.assert_array_equal(db.reference_point, [[0.0, 0.0, 0.0]])
    assert db.port_starboard_symmetric
    assert db.attributes["assumed"] == "water depth inf"


@pytest.mark.filterwarnings("ignore:.*are left out")
def test_a_real_ship_moves_as_veres_says(supply):
    """VERES's own motions (.re1) from its loads and matrices, in its axes; what it adds in roll,
    tanks and bilge keels, is put in, too. Tanks make roll nonlinear: 1 %."""
    db = read(supply)
    rows = [line.split() for line in supply.with_suffix(".re1").read_text().split("\n")]
    motions = np.array([row[1:] for row in rows if len(row) == 3 and row[0] in "123456"], float)
    motions = (motions @ [1, 1j]).reshape(2, 3, 6).swapaxes(0, 1) @ TURN
    tank = [(4.4201472e9, 0.0), (1.2279909e9, 2.1158725e6), (-3.2053572e7, 4.2857376e7)]
    skin = [8.3058977e4 + 3.5464816e-2, 1.4886069e5 + 4.5630138e-2, 4.8267175e5 + 5.9424138]
    for w, omega in enumerate(db.frequency):
        mass, damping = db.inertia_matrix + db.added_mass[w], db.radiation_damping[w].copy()
        mass[3, 3] += tank[w][0]
        damping[3, 3] += tank[w][1] + skin[w]
        impedance = db.hydrostatic_stiffness - omega**2 * mass + 1j * omega * damping
        found = np.linalg.solve(impedance, db.excitation[w].T).T
        tolerance = np.array([2e-4, 2e-3, 2e-4, 1e-2, 2e-4, 2e-3])
        assert (abs(found - motions[w]) <= tolerance * abs(motions[w]) + 1e-6).all(), omega


@pytest.mark.filterwarnings("ignore")
def test_a_real_ship_passes_the_checks_of_physics(supply):
    """Long waves lift it by its stiffness and push it by rho g k V; drift is along the waves."""
    db = load(supply)
    k = db.frequency[0] ** 2 / db.gravity
    head, oblique = db.excitation[0]
    push = -1j * db.water_density * db.gravity * k * db.volume[0]
    assert head[0] == pytest.approx(push, rel=0.01)
    assert oblique[0] == pytest.approx(push * np.cos(np.radians(10)), rel=0.01)
    assert head[2] == pytest.approx(db.hydrostatic_stiffness[2, 2], rel=0.03)
    assert oblique[1].imag < 0  # to starboard
    assert (db.mean_drift[..., 0] < 0).all()
    mass = db.inertia_matrix[0, 0]
    assert db.hydrostatic_stiffness[3, 3] == pytest.approx(mass * 9.81 * 2.144, rel=1e-3)  # GM


def test_what_makes_no_waves_is_left_out_and_told(supply):
    with pytest.warns(UserWarning, match=r"mass of up to 4\.42e\+09 .*up to 4\.83e\+05 N m s/rad"):
        read(supply)


def test_without_loads_and_drift(path):
    path.with_suffix(".re8").unlink()
    db = read(path)
    assert db.excitation.shape == (6, 0, 6)
    assert db.mean_drift is None


def test_messages(path):
    text = path.read_text()
    path.write_text(text.replace(_row(0.0, 0.0, 0.0, AFT + 1, DRAUGHT), _row(2, 0, 0, 4.5, 12.4)))
    with pytest.raises(InputError, match=r"found speeds of 5, 2 m/s, expected one of zero"):
        read(path)
    path.write_text(text.replace(_row(0.0, 0.0, 0.0, AFT + 1), _row(0.0, 0.0, 0.3, AFT + 1)))
    with pytest.raises(InputError, match=r"trim of 0\.3 degrees, expected none"):
        read(path)
    path.write_text(text.replace("    -1     2", "    -1     1"))
    with pytest.raises(InputError, match=r"hull\.re7: line 10: found -1 1, expected -1 2"):
        read(path)
    path.unlink()
    with pytest.raises(InputError, match=r"hull\.re7: no such file, expected it beside hull\.re8"):
        read(path.with_suffix(".re8"))


@pytest.mark.filterwarnings("ignore:.*are left out")
@pytest.mark.parametrize("suffix", ["re2", "re7", "re8"])
def test_damaged_files_are_refused(supply, suffix):
    path = supply.with_suffix(f".{suffix}")
    assert 30 < damaged.refused(veres.read, path, path.read_bytes(), f"supply.{suffix}")
