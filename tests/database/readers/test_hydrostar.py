import re
from pathlib import Path

import damaged
import numpy as np
import pytest

from hydrosim.database.load import read
from hydrosim.database.readers import hydrostar, wamit
from hydrosim.errors import InputError

OMEGA = np.linspace(0.3, 1.1, 9)
DIFFERENCES = np.arange(9) * 0.1
DEGREES = np.array([0.0, 40.0, 180.0])
POINTS = np.array([[-30.0, 4.0], [11.0, -9.0], [25.0, 2.0]])  # where gauges stand
WEIGHTS = np.array([1.0, 2.5, -0.7])
SIX = np.arange(1.0, 7.0)  # what the loads of the six DOFs are multiples of
WAVES_AT = np.array([12.0, -3.0])  # where tables count phases from
MOMENTS_AT = np.array([2.0, -1.0, 0.5])
T = np.linspace(0.0, 200.0, 4001)


def elevation(waves: dict[int, complex], degrees: float, origin: np.ndarray) -> np.ndarray:
    """At the gauges, of waves cos(w t + phase) at ``origin``, in deep water."""
    towards = np.radians(degrees)
    along = (POINTS - origin) @ [np.cos(towards), np.sin(towards)]
    return sum(
        (a * np.exp(1j * (OMEGA[n] * T[:, None] - OMEGA[n] ** 2 / 9.81 * along))).real
        for n, a in waves.items()
    )


def value(i: int, j: int, degrees: float, difference: bool) -> complex:
    """What Snoopy makes a time series of, from the load of the gauges in time: half of its cosine
    and sine at w_j - w_i, half of its cosine and minus its sine at w_i + w_j."""
    if i == j:
        load = elevation({i: 1.0}, degrees, WAVES_AT) ** 2 @ WEIGHTS
        w = 0.0 if difference else 2 * OMEGA[i]
    else:
        both = elevation({i: 1.0, j: 1.0}, degrees, WAVES_AT) ** 2
        alone = [elevation({n: 1.0}, degrees, WAVES_AT) ** 2 for n in (i, j)]
        load = (both - sum(alone)) @ WEIGHTS / 2  # what they make together
        w = OMEGA[j] - OMEGA[i] if difference else OMEGA[i] + OMEGA[j]
    known = {abs(OMEGA[j] - OMEGA[i]), OMEGA[i] + OMEGA[j]} - {0.0}
    terms = np.stack([np.ones_like(T), *[g(x * T) for x in known for g in (np.cos, np.sin)]], 1)
    found = dict(zip([(0.0, 0), *[(x, g) for x in known for g in (0, 1)]],
                     np.linalg.lstsq(terms, load, rcond=None)[0], strict=True))  # fmt: skip
    sine = found.get((w, 1), 0.0)
    return complex(found[(w, 0)], sine if difference else -sine)


def table(dof: int, difference: bool = True, differences: np.ndarray = DIFFERENCES) -> str:
    """As HydroStar writes it; where w_2 is above the last frequency it has numbers, too."""
    lines = [
        "# Project : ",
        "# User    : ",
        f"# File : qtf_{dof}.qtf",
        "# Constants used in computations :",
        "#     Reference length     :     1.0000 ",
        "#     Water density (rho)  :  1025.0000",
        "#     Gravity acceleration :     9.8100",
        "#     Waterdepth           :  Inf. ",
        f"#     Ref.pt incident wave : ({WAVES_AT[0]:11.4f}{WAVES_AT[1]:8.4f})",
        "#            Forward speed :   0.0000  m/s   ",
        "#",
        "#" + 72 * "-",
        '#QTFTYPE "2NDLOAD"',
        "#CPLXTYPE 0",
        f"#QTFMODE {'Diff' if difference else 'Sum'}",
        f'#DIRECTION  "{dof:12d}',
        "#COORD  " + "".join(f"{x:9.3f}" for x in MOMENTS_AT),
        f"#NBHEADING{DEGREES.size:4d}",
        "#HEADING" + "".join(f"{x:12.2f}" for x in DEGREES),
        "#DIFF" + "".join(f"{x:24.5f}" for x in differences),
        "#---w(r/s)-----------------------------------------------------",
    ]
    for degrees in DEGREES:
        lines.append(f"#Heading ={degrees:8.2f}")
        for i, w in enumerate(OMEGA):
            row = f"{w:13.4E}"
            for n in range(differences.size):
                two = VALUES[difference, degrees, i, i + n] if i + n < OMEGA.size else 9.0
                row += f"{SIX[dof - 1] * two.real:15.6E}{SIX[dof - 1] * two.imag:15.6E}"
            lines.append(row)
        lines += ["", ""]
    return "\n".join(lines)


VALUES = {
    (difference, degrees, i, j): value(i, j, degrees, difference)
    for difference in (True, False)
    for degrees in DEGREES
    for i in range(OMEGA.size)
    for j in range(i, OMEGA.size)
}


@pytest.fixture
def path(made_up, tmp_path) -> Path:
    """Six tables of differences and six of sums beside a WAMIT set."""
    db = made_up(
        qtf_frequency=None, qtf_heading=None, qtf_difference=None, qtf_sum=None,
        reference_point=np.zeros((1, 3)),
    )  # fmt: skip
    wamit.write(db, tmp_path / "hull")
    for dof in range(1, 7):
        (tmp_path / f"qtf_{dof}.qtf").write_text(table(dof))
        (tmp_path / f"sum_{dof}.rao").write_text(table(dof, difference=False))
    return tmp_path / "qtf_1.qtf"


def test_two_waves_feel_what_the_tables_say(path):
    """The gauges' load in time, of waves whose phases are those at the frame's origin; and moments
    about the reference point."""
    db = read(path)
    i, j, h = 1, 4, 1
    waves = {i: 1.3 * np.exp(0.4j), j: 0.8 * np.exp(-1.1j)}
    expected = elevation(waves, DEGREES[h], np.zeros(2)) ** 2 @ WEIGHTS
    np.testing.assert_allclose(db.qtf_frequency, OMEGA)
    load = np.zeros((T.size, 6), dtype=complex)
    for m, a in waves.items():
        for n, b in waves.items():
            slow, fast = OMEGA[m] - OMEGA[n], OMEGA[m] + OMEGA[n]
            load += np.outer(np.exp(1j * slow * T), a * np.conj(b) * db.qtf_difference[h, m, n])
            load += np.outer(np.exp(1j * fast * T), a * b * db.qtf_sum[h, m, n])
    moments = SIX[3:] + np.cross(MOMENTS_AT, SIX[:3])
    np.testing.assert_allclose(
        load.real, np.outer(expected, [*SIX[:3], *moments]), atol=1e-4 * abs(expected).max() * 6
    )
    assert "HydroStar's tables in the frame of the WAMIT set" in db.attributes["assumed"]
    assert (db.water_density, db.gravity) == (1025.0, 9.81)


def test_difference_functions_are_hermitian_about_the_mean_load(path):
    transfer = read(path).qtf_difference
    np.testing.assert_allclose(transfer, transfer.conj().swapaxes(1, 2), atol=1e-12)
    mean = np.einsum("hiid->hid", transfer)[..., :3]
    np.testing.assert_allclose(mean, np.broadcast_to(WEIGHTS.sum() / 2 * SIX[:3], mean.shape))


def test_waves_further_apart_than_the_tables_go(path):
    for dof in range(1, 7):
        path.with_name(f"qtf_{dof}.qtf").write_text(table(dof, differences=DIFFERENCES[:4]))
        path.with_name(f"sum_{dof}.rao").unlink()
    full = {(h, n): VALUES[True, d, 0, n] for h, d in enumerate(DEGREES) for n in (3, 4)}
    with pytest.warns(UserWarning, match=r"up to 0\.3 rad/s apart; .* assumed zero"):
        db = read(path)
    assert db.qtf_sum is None
    for h in range(DEGREES.size):
        assert abs(db.qtf_difference[h, 0, 3, 0]) == pytest.approx(abs(full[h, 3]), rel=1e-5)
        assert db.qtf_difference[h, 0, 4, 0] == 0.0


def test_messages(path):
    text = path.read_text()
    path.write_text(text.replace("   0.0000  m/s", "   2.5700  m/s"))
    with pytest.raises(InputError, match="found a forward speed"):
        read(path)
    path.write_text(text.replace('"           1', '"           2'))
    with pytest.raises(InputError, match=r"two tables of the same load .* among qtf_1\.qtf, "):
        read(path)
    path.write_text(text)
    path.with_name("qtf_2.qtf").unlink()
    with pytest.raises(InputError, match="found 5 loads; expected 6, to move the moments"):
        read(path)
    path.with_name("hull.1").unlink()
    with pytest.raises(InputError, match=r"and this folder has 0 WAMIT files"):
        read(path)


@pytest.mark.filterwarnings("ignore:.*rad/s apart")
def test_damaged_files_are_refused(path):
    for dof in range(2, 7):
        path.with_name(f"qtf_{dof}.qtf").unlink()
        path.with_name(f"sum_{dof}.rao").unlink()
    path.with_name("sum_1.rao").unlink()
    text = path.read_text()
    coord = next(line for line in text.split("\n") if line.startswith("#COORD"))
    content = text.replace(coord, "#COORD      0.000    0.000    0.000").encode()
    assert 50 < damaged.refused(hydrostar.read, path, content, "qtf_1.qtf")


def test_of_pairs_of_headings_waves_of_one_are_read(path):
    """What a file of all pairs has on its diagonal is what one without pairs has."""
    expected = read(path)
    for file in path.parent.glob("*_*.*"):
        if file.suffix not in (".qtf", ".rao"):
            continue
        head, *blocks = re.split("#Heading = .*\n", file.read_text())
        rows = dict(enumerate(blocks))
        other = re.sub(r"-?\d\.\d{6}E", "7.777777E", blocks[0])  # of crossing waves
        pairs = [
            f"##Heading1 = {a}\n#Heading2 = {b}\n{rows[a] if a == b else other}"
            for a in range(DEGREES.size)
            for b in range(DEGREES.size)
        ]
        file.write_text(head + "".join(pairs))
    with pytest.warns(UserWarning, match="only pairs of equal headings are read"):
        found = read(path)
    np.testing.assert_array_equal(found.qtf_difference, expected.qtf_difference)
    np.testing.assert_array_equal(found.qtf_sum, expected.qtf_sum)


# A cylinder of 6 m radius as HydroStar writes it, published with the validation of Nemoh 3 (7, QTF
# of a cylinder): in each row the frequency, added mass, damping and load of surge (amplitude and
# phase), load of heave, and the mean drift; then two rows of the transfer function in surge.
CYLINDER = """
  0.0628  1.285892E+06  8.465437E-03  1.139390E+04   90.0117  1.121641E+06    0.0003 -2.9428E-003
  1.0048  1.496167E+06  7.040896E+05  1.621407E+06   76.5443  1.649609E+05   13.8165  6.5327E+003
  1.2560  9.698175E+05  1.083636E+06  1.437867E+06   69.2976  5.700108E+04   27.7564  1.6434E+004
  2.0096  6.007482E+05  4.613745E+05  4.560993E+05  117.1860  3.354389E+02  113.1608  4.0750E+004
"""
PAIRS = """
  6.2800E-001 -1.6599E+000  0.0000E+000  6.2354E+002 -9.5317E+003
  6.9080E-001  9.5400E+002  0.0000E+000  0.0000E+000  0.0000E+000
"""
HEAD = """# Project :
# User    :
# File : {name}
#
# Constants used in computations :
#     Reference length     :     1.0000
#     Water density (rho)  :  1025.0000
#     Gravity acceleration :     9.8100
#     Waterdepth           :  Inf.
#     Ref.pt incident wave : ({x:11.4f}  -0.0005)
#            Forward speed :   0.0000  m/s
#
"""
LINEAR = """# Reference point of body 1: (    0.000    0.000    {z:5.3f})
# MEANVALUE :   0.0000E+00
#   AMP/PHASE
#------------------------------------------------------------------------
#RAOTYPE    :  {kind}
#COMPONENT  :  {component}
#UNIT       :  {unit}
#NBHEADING   1
#HEADING          0.00
#---w(r/s)-----------------------------------------------------
"""
SECOND = """#------------------------------------------------------------------------
#QTFTYPE "2NDLOAD"
#CPLXTYPE 0
#QTFMODE Diff
#DIRECTION  "           {component}
#COORD       0.000    0.000    0.000
#NBHEADING   1
#HEADING        0.00
#DIFF {differences}
#---w(r/s)-----------------------------------------------------
#Heading =    0.00
"""
AXES = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")


def cylinder(folder: Path, x: float = -0.0015, z: float = 0.0) -> Path:
    """The folder of the cylinder: surge and sway alike, in long waves along x."""
    rows = [line.split() for line in CYLINDER.strip().splitlines()]

    def linear(name: str, kind: str, component: int, *columns: int) -> None:
        values = [[row[0], *(row[k] if k else "0.0" for k in columns)] for row in rows]
        body = LINEAR.format(z=z, kind=kind, component=component, unit="SI")
        lines = ["  ".join(value) for value in values]
        text = HEAD.format(name=name, x=x) + body + "\n".join([*lines, "#---", f"#ENDFILE {name}"])
        (folder / name).write_text(text + "\n")

    def second(name: str, component: int, differences: str, lines: list[str]) -> None:
        head = HEAD.format(name=name, x=x)
        head += SECOND.format(component=component, differences=differences)
        (folder / name).write_text(head + "\n".join([*lines, " ", " "]))

    for i in range(1, 7):
        for j in range(1, 7):
            column = 1 if i == j < 3 else 0
            linear(f"AddedMass_{i}{j}.dat", "ADDED-MASS", 10 * i + j, column, 0)
            linear(f"Damping_{i}{j}.dat", "WAVE-DAMPING", 10 * i + j, 2 * column, 0)
        name = f"{AXES[i - 1].lower()}f1st.rao"
        linear(name, "LOAD", i, *{1: (3, 4), 3: (5, 6)}.get(i, (0, 0)))
        drift = [f"  {row[0]}  {row[7] if i == 1 else 0.0}  0.0" for row in rows]
        second(f"Drift{AXES[i - 1]}.rao", i, "0.00000", drift)
        none = [f"  {row[0]}  0.0000E+000  0.0000E+000" for row in rows]
        if i in (1, 2, 6):
            second(f"Drift{AXES[i - 1]}FF.rao", i, "0.00000", none)
        pairs = PAIRS.strip("\n").splitlines()
        zeros = [line[:14] + "  0.0" * 4 for line in pairs]
        second(f"QTF{AXES[i - 1]}.rao", i, "0.00000  0.06280", pairs if i == 1 else zeros)
    linear("heave.rao", "MOTION", 3, 0, 0)
    return folder / "AddedMass_11.dat"


def test_a_folder_as_hydrostar_writes_it(tmp_path):
    """A cylinder's damping is that of its loads (Haskind's relation: B = w^3 |X|^2 / (4 rho g^3)),
    and its drift in short waves 2/3 rho g R; the transfer function has waves of its own."""
    db = read(cylinder(tmp_path))
    w, surge = db.frequency, db.excitation[:, 0, 0]
    haskind = w**3 * abs(surge) ** 2 / (4 * 1025 * 9.81**3)
    np.testing.assert_allclose(db.radiation_damping[1:, 0, 0], haskind[1:], rtol=0.06)
    assert db.added_mass[0, 1, 1] == 1.285892e6
    assert np.angle(surge[0], deg=True) == pytest.approx(90.0, abs=0.02)
    radius = np.sqrt(db.excitation[0, 0, 2].real / (1025 * 9.81 * np.pi))
    assert radius == pytest.approx(6.0, rel=0.01)
    assert db.mean_drift[-1, 0, 0] == pytest.approx(2 / 3 * 1025 * 9.81 * 6.0, rel=0.02)
    assert db.attributes["mean_drift_method"] == "by pressure integration"
    np.testing.assert_allclose(db.qtf_frequency, [0.628, 0.6908])
    np.testing.assert_allclose(db.qtf_difference[0, 0, :, 0], [-1.6599, 623.54 - 9531.7j], 1e-4)
    assert db.hydrostatic_stiffness is None
    assert (db.water_density, db.gravity, db.water_depth) == (1025.0, 9.81, np.inf)
    assert read(tmp_path / "QTFFx.rao").checksum == db.checksum


def test_phases_and_moments_move_with_their_points(tmp_path):
    """The same numbers per elevations 40 m further on: there the wave comes k times 40 m later."""
    (tmp_path / "far").mkdir()
    here, far = read(cylinder(tmp_path)), read(cylinder(tmp_path / "far", x=40.0, z=-2.0))
    number = here.frequency**2 / 9.81
    lag = np.exp(-1j * number * (40.0 + 0.0015))[:, None, None]
    np.testing.assert_allclose(far.excitation, here.excitation * lag, rtol=1e-12)
    np.testing.assert_allclose(far.reference_point, [[0.0, 0.0, -2.0]])
    np.testing.assert_allclose(far.mean_drift[..., 4], 2.0 * here.mean_drift[..., 0])


def test_momentum_counts_where_it_was_computed(tmp_path):
    cylinder(tmp_path)
    pressure = (tmp_path / "DriftFx.rao").read_text()
    middle = pressure.replace("6.5327E+003", "6.6000E+003").replace("DriftFx", "DriftFxMF")
    (tmp_path / "DriftFxMF.rao").write_text(middle)
    db = read(tmp_path / "DriftFx.rao")
    assert db.mean_drift[1, 0, 0] == 6600.0
    assert "momentum" in db.attributes["mean_drift_method"]


def test_folders_that_are_not_whole_are_refused(tmp_path):
    path = cylinder(tmp_path)
    lost = (tmp_path / "Damping_42.dat").read_text()
    (tmp_path / "Damping_42.dat").unlink()
    with pytest.raises(
        InputError, match=r"found no 42 of the tables #RAOTYPE WAVE-DAMPING in its folder; expected"
    ):
        read(path)
    (tmp_path / "Damping_42.dat").write_text(lost.replace("1.2560", "1.2660"))
    with pytest.raises(InputError, match=r"Damping_42\.dat: has another frequency than"):
        read(path)
    (tmp_path / "Damping_42.dat").write_text(lost)
    drift = tmp_path / "DriftFx.rao"
    for file in tmp_path.glob("Drift*"):
        file.write_text(file.read_text().replace("1.2560", "1.2660"))
    with pytest.raises(InputError, match="frequency than the first-order loads; expected the"):
        read(path)
    drift.write_text(drift.read_text().replace("1.2660", "1.2560"))
    with pytest.raises(InputError, match=r"has another frequency than DriftF.*folder of its own"):
        read(path)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*rad/s apart")
@pytest.mark.parametrize("name", ["AddedMass_11.dat", "fxf1st.rao", "DriftFx.rao", "QTFFx.rao"])
def test_damaged_tables_of_a_folder_are_refused(tmp_path, name):
    path = cylinder(tmp_path)
    content = (tmp_path / name).read_bytes()
    assert damaged.refused(lambda _: read(path), tmp_path / name, content, str(tmp_path)) > 40
