import re
import shutil
import warnings
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from hydrosim.database import HydroDatabase, check, load, netcdf
from hydrosim.database.load import read
from hydrosim.database.readers import READERS, bemio, wamit
from hydrosim.errors import InputError
from hydrosim.scene.hydrodynamics import FrequencyColumn, Given

SPHERE = Given(
    water_density=1000.0,
    gravity=9.81,
    water_depth=50.0,
    centre_of_gravity=(0.0, 0.0, -2.0),
    reference_point=(0.0, 0.0, -2.0),
)
VOLTURNUS = Given(water_density=1025.0, gravity=9.80665, water_depth=200.0)
NOT_MIRRORED = ("mean_drift_held", "drift_imbalance")  # no WAMIT file holds them


def known(db: HydroDatabase, **more: object) -> Given:
    """What the numeric files of ``db`` do not say."""
    return Given(
        water_density=db.water_density,
        gravity=db.gravity,
        water_depth=db.water_depth,
        reference_point=tuple(db.reference_point.ravel()),
        frequency_column=FrequencyColumn.PERIOD,
        **more,
    )


def rewrite(path: Path, change) -> None:
    """Replace the rows of a table, each a list of words, by ``change`` of them."""
    title, *lines = path.read_text().splitlines()
    rows = change([line.split() for line in lines])
    path.write_text("\n".join([title, *(" ".join(row) for row in rows), ""]))


@pytest.fixture(scope="session")
def sphere(validation) -> HydroDatabase:
    return read(validation / "sphere" / "wamit" / "sphere.1", SPHERE)


@pytest.fixture(scope="session")
def hemisphere(validation) -> HydroDatabase:
    return read(validation / "hemisphere" / "hemisphere.1")


@pytest.fixture(scope="session")
def volturnus(validation) -> HydroDatabase:
    return read(validation / "volturnus" / "volturnus.1", VOLTURNUS)


@pytest.fixture
def volturnus_set(validation, tmp_path) -> Path:
    """The set with its main output beside it."""
    for path in (validation / "volturnus").glob("volturnus.*"):
        shutil.copyfile(path, tmp_path / path.name)
    out = validation / "volturnus" / "volturnus_first_order.out"
    shutil.copyfile(out, tmp_path / "volturnus.out")
    return tmp_path / "volturnus"


# Other programs' files: the limits of theory.


def test_sphere_has_the_added_mass_of_a_sphere_in_infinite_fluid(sphere):
    """At zero frequency the surface is a rigid lid: surge is half a sphere's 2/3 pi rho R^3; at
    infinite frequency heave is. The panels leave 0.05 % (volume 0.06 % low)."""
    displaced = 1000 * 2 / 3 * np.pi * 5**3
    assert sphere.added_mass_zero[0, 0] == pytest.approx(displaced / 2, rel=1e-3)
    assert sphere.added_mass_infinite[2, 2] == pytest.approx(displaced / 2, rel=1e-3)
    assert sphere.hydrostatic_stiffness[2, 2] == pytest.approx(9810 * np.pi * 25, rel=1e-3)


def test_sphere_in_long_waves(sphere):
    """Heave follows the waterplane; surge is (displaced + added mass) times the acceleration of
    the water, w^2/tanh(kh) of the elevation, which leads it by 90 degrees."""
    w, h, g = sphere.frequency[0], 50.0, 9.81
    k = w / np.sqrt(g * h)  # shallow: kh is 0.05
    mass = 1000 * 2 / 3 * np.pi * 5**3 * 1.5
    load = sphere.excitation[0, 0]
    assert load[0] == pytest.approx(1j * mass * w**2 / np.tanh(k * h), rel=0.01)
    assert load[2] == pytest.approx(9810 * np.pi * 25, rel=2e-3)


def test_phase_of_the_sphere_follows_its_reference_point(sphere):
    """A sphere whose centre is at the origin has pressures through it: about a point 2 m below it
    the moment is 2 m times the surge load."""
    np.testing.assert_allclose(sphere.excitation[..., 4], 2 * sphere.excitation[..., 0], rtol=0.02)
    np.testing.assert_allclose(
        sphere.added_mass[:, 4, 0], 2 * sphere.added_mass[:, 0, 0], rtol=0.02
    )


def test_hemisphere_limits(hemisphere):
    """Added mass at infinite frequency, 0.5 and 0.273 of the displaced mass in heave and surge;
    drift in short waves, 2/3 rho g R a^2 on a vertical wall; both within the panels' 2 % and, at
    k R = 2.6, a tenth."""
    db = hemisphere
    displaced = db.water_density * 2 / 3 * np.pi
    assert db.added_mass_infinite[2, 2] == pytest.approx(0.5 * displaced, rel=0.02)
    assert db.added_mass_infinite[0, 0] == pytest.approx(0.273 * displaced, rel=0.02)
    wall = 2 / 3 * db.water_density * db.gravity
    assert db.mean_drift[100, 0, 0] == pytest.approx(wall, rel=0.1)
    assert abs(db.mean_drift[:20, 0, 0]).max() < 1e-5 * wall
    assert "momentum" in db.attributes["mean_drift_method"]


def test_hemisphere_header(hemisphere):
    assert hemisphere.gravity == 9.80665
    assert hemisphere.volume == pytest.approx([2.07293])
    np.testing.assert_allclose(hemisphere.centre_of_buoyancy, [[0, 0, -0.373589]])
    np.testing.assert_allclose(hemisphere.inertia_matrix[3:, 3:], np.eye(3) * 0.3316688 * 1025)
    assert hemisphere.attributes["assumed"] == (
        "water density 1025, water depth inf, reference points at the origin, first column period"
    )


def test_hemisphere_is_doubted_for_the_range_its_makers_do_not_trust(hemisphere, validation):
    """Above 5 rad/s there are irregular frequencies: spikes, negative damping of 6 % of the
    largest, and added mass that does not go with it. Nothing else is wrong with the file. Up to
    5 rad/s the damping of surge has not decayed."""
    failed = {finding.name for finding in check(hemisphere) if not finding.has_passed}
    assert failed == {"positive damping", "irregular frequencies", "added mass against damping"}
    with pytest.warns(UserWarning, match="positive damping"):
        load(validation / "hemisphere" / "hemisphere.1")
    trusted = hemisphere.frequency <= 5.0
    names = ("frequency", "added_mass", "radiation_damping", "excitation", "mean_drift")
    lower = replace(hemisphere, **{name: getattr(hemisphere, name)[trusted] for name in names})
    failed = {finding.name for finding in check(lower) if not finding.has_passed}
    assert failed == {"kernel truncation"}


def test_volturnus_loads(volturnus_set):
    """Nothing is refused; above 4 rad/s the panels leave the damping of surge and pitch 2.7 %
    asymmetric and 1 % negative, with spikes there and at 1 rad/s, which may be warned of."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        db = load(volturnus_set)
    allowed = ("symmetry of radiation damping", "positive damping", "irregular frequencies")
    assert all(any(name in str(w.message) for name in allowed) for w in caught)
    assert db.port_starboard_symmetric
    assert db.water_depth == 200.0
    assert db.volume == pytest.approx([20148.4])
    np.testing.assert_allclose(db.centre_of_buoyancy, [[0.000451, 0, -13.627908]])
    assert "assumed" not in db.attributes or db.attributes["assumed"] == "first column period"


def test_volturnus_is_the_same_by_any_file_of_the_set(volturnus_set):
    one = read(volturnus_set).checksum
    for suffix in (".1", ".3", ".12d", ".hst", ".out"):
        assert read(volturnus_set.with_suffix(suffix)).checksum == one


def test_volturnus_difference_function(volturnus, validation):
    """Hermitian, and its diagonal is the drift by pressure integration that WAMIT's listing has,
    printed with six digits."""
    transfer, w = volturnus.qtf_difference[0], volturnus.qtf_frequency
    scale = abs(transfer).max(axis=(0, 1))
    skew = abs(transfer - transfer.conj().transpose(1, 0, 2)).max(axis=(0, 1))
    np.testing.assert_allclose(volturnus.qtf_heading, [[0.0, 0.0]])
    assert (skew[[0, 2, 4]] <= 1e-6 * scale[[0, 2, 4]]).all()
    listing = (validation / "volturnus" / "volturnus_second_order.out").read_text()
    blocks = listing.split("Wave period (sec) =")[1:]
    assert len(blocks) == w.size == 46
    for block in blocks:
        i = int(np.argmin(abs(w - 2 * np.pi / float(block.split()[0]))))
        rows = block.split("(Pressure Integration)")[1].splitlines()[6:12]
        for dof in (0, 2, 4):
            modulus, phase = (float(x) for x in rows[dof].split()[1:3])
            drift = 1025 * 9.80665 * modulus * np.cos(np.radians(phase))
            assert transfer[i, i, dof] == pytest.approx(drift, rel=2e-5, abs=2e-6 * scale[dof])


def test_volturnus_difference_function_has_the_set_down_behind_its_waves(volturnus):
    """The diagonal cannot tell T from its conjugate, but the incident second-order potential can.
    Pinkster (1980, Low frequency second order wave exciting forces on floating structures) takes
    its load in deep water to be that of a first-order wave of the wavenumber k1 - k2:
    T = -(w1/2) (w1 - w2)/g X(k1 - k2) for w1 > w2. Its share in the surge of short waves, beside a
    smooth function of k1 - k2, is found by least squares: it must be one, which it is within the
    scatter of the columns' own reflections, and the conjugate must have none of it."""
    g, depth = volturnus.gravity, volturnus.water_depth
    w, T = volturnus.qtf_frequency, volturnus.qtf_difference[0, ..., 0]
    k = w**2 / g
    i, j = np.nonzero((w[:, None] > w) & (w > 1.4) & (k[:, None] - k < 0.25))
    number = k[i] - k[j]
    first = volturnus.excitation[:, int(np.argmin(abs(volturnus.heading))), 0]
    rate = np.sqrt(g * number * np.tanh(number * depth))
    load = np.interp(rate, volturnus.frequency, first.real) + 1j * np.interp(
        rate, volturnus.frequency, first.imag
    )
    size = np.sqrt(abs(T[i, i] * T[j, j]))
    potential = -w[i] / 2 * (w[i] - w[j]) / g * load / size
    terms = np.stack([potential, np.ones_like(load), 1j * number, number**2], axis=1)

    def share(transfer: np.ndarray) -> float:
        equations = np.concatenate([terms.real, terms.imag])
        wanted = np.concatenate([transfer.real, transfer.imag])
        return float(np.linalg.lstsq(equations, wanted, rcond=None)[0][0])

    assert share(T[i, j] / size) == pytest.approx(1.0, abs=0.2)
    assert abs(share(T[i, j].conj() / size)) < 0.2


# Conventions.


@pytest.mark.parametrize("sum_too", [False, True])
def test_two_waves_feel_what_the_transfer_function_says(made_up, tmp_path, sum_too):
    """A gauge whose load is the square of an elevation, summed over points: computed wave by wave
    in time, and by the transfer functions from a file that holds one triangle of each."""
    db = made_up(qtf_frequency=None, qtf_heading=None, qtf_difference=None, qtf_sum=None)
    db = replace(db, port_starboard_symmetric=False)
    wamit.write(db, tmp_path / "gauge")
    w = np.array([0.5, 0.62, 0.9])
    points, weights = np.array([[-30.0, 4.0], [11.0, -9.0], [25.0, 2.0]]), [1.0, 2.5, -0.7]
    headings = (0.0, 40.0)

    def elevation(i: int, degrees: float) -> np.ndarray:
        b = np.radians(degrees)
        return np.exp(-1j * w[i] ** 2 / 9.81 * (points @ [np.cos(b), np.sin(b)]))

    def line(i, j, b, c, value) -> str:
        value = value / (db.water_density * db.gravity)
        parts = abs(value), np.degrees(np.angle(value)), value.real, value.imag
        numbers = " ".join(f"{x:.15E}" for x in (2 * np.pi / w[i], 2 * np.pi / w[j], b, c))
        return f"{numbers} 1 " + " ".join(f"{x:.15E}" for x in parts)

    difference, total = [], []
    for i, j in product(range(3), range(3)):
        for b, c in product(headings, headings):
            if i > j or (b != c and i == j and b > c):
                continue
            first, second = elevation(i, b), elevation(j, c)
            difference.append(line(i, j, b, c, (weights * first * second.conj()).sum() / 2))
            total.append(line(i, j, b, c, (weights * first * second).sum() / 2))
    (tmp_path / "gauge.12d").write_text("\r\n".join(difference))
    if sum_too:
        (tmp_path / "gauge.12s").write_text("\n".join(total))
    back = read(tmp_path / "gauge", known(db))
    assert len(back.qtf_heading) == 4
    waves = [(0, 0.0, 0.7 * np.exp(0.3j)), (2, 40.0, 1.1 * np.exp(-2j)), (1, 40.0, 0.5)]
    t = np.linspace(0.0, 60.0, 400)
    eta = sum((a * np.exp(1j * w[i] * t)[:, None] * elevation(i, b)).real for i, b, a in waves)
    expected = (eta**2) @ weights
    slow, fast = np.zeros_like(t), np.zeros_like(t)
    for (i, b, a), (j, c, d) in product(waves, waves):
        p = int(np.argmin(abs(np.degrees(back.qtf_heading) - [b, c]).sum(axis=1)))
        slow += (
            a * np.conj(d) * back.qtf_difference[p, i, j, 0] * np.exp(1j * (w[i] - w[j]) * t)
        ).real
        if sum_too:
            fast += (a * d * back.qtf_sum[p, i, j, 0] * np.exp(1j * (w[i] + w[j]) * t)).real
    if sum_too:
        np.testing.assert_allclose(slow + fast, expected, atol=1e-10 * abs(expected).max())
    else:
        assert np.mean(slow) == pytest.approx(np.mean(expected), rel=0.2)
        assert np.corrcoef(slow, np.convolve(expected, np.ones(51) / 51, "same"))[0, 1] > 0.7


def scaled(path: Path, length: float, water: float, column: str) -> None:
    """Make the files that hydrosim wrote with length 1 those of another length and first column,
    by the formulas of the manual."""

    def number(period: str) -> str:
        w = (
            2 * np.pi / float(period)
            if float(period) > 0
            else {-1: 0.0, 0: -1.0}[int(float(period))]
        )
        if column == "period":
            return period
        return f"{w if column == 'frequency' or w <= 0 else w * w * length / 9.81:.17g}"

    def power(dof: str) -> int:
        return (int(dof) - 1) % 6 // 3

    def change(suffix: str, columns: int, exponent) -> None:
        file = path.with_name(path.name + suffix)
        if file.exists():
            rewrite(
                file,
                lambda rows: [
                    [
                        *(number(x) for x in row[:columns]),
                        *row[columns : -len(tail)],
                        *(f"{float(x) / length ** exponent(row):.17g}" for x in tail),
                    ]
                    for row in rows
                    for tail in [
                        row[3:] if suffix == ".1" else row[2:] if suffix == ".hst" else row[-2:]
                    ]
                ],
            )

    change(".1", 1, lambda row: 3 + power(row[1]) + power(row[2]))
    change(".3", 1, lambda row: 2 + power(row[2]))
    change(".3fk", 1, lambda row: 2 + power(row[2]))
    change(".8", 1, lambda row: 1 + power(row[3]))
    change(".9", 1, lambda row: 1 + power(row[3]))
    change(".12d", 2, lambda row: 1 + power(row[4]))
    change(".12s", 2, lambda row: 1 + power(row[4]))
    change(".hst", 0, lambda row: 2 + power(row[0]) + power(row[1]))


@pytest.mark.parametrize("column", ["period", "frequency", "deep wavenumber"])
def test_length_and_first_column(made_up, tmp_path, column, differences):
    db = made_up(2, gravity=9.81)
    wamit.write(db, tmp_path / "two")
    scaled(tmp_path / "two", 7.0, 9.81, column)
    (tmp_path / "two.mmx").unlink()
    (tmp_path / "two.gdf").write_text("two barges\n7.0 9.81\n0 0\n")
    given = replace(known(db), frequency_column=FrequencyColumn(column))
    back = read(tmp_path / "two", replace(given, gravity=None))
    found = differences(db, back)
    centres = {"volume", "centre_of_buoyancy", "centre_of_gravity", "inertia_matrix"}
    assert {name for name, d in found.items() if d > 1e-13} == {*NOT_MIRRORED, *centres}


@pytest.mark.parametrize("column", ["frequency", "deep wavenumber"])
def test_first_column_is_guessed_by_physics(hemisphere, tmp_path, column):
    wamit.write(hemisphere, tmp_path / "h")
    for path in tmp_path.iterdir():
        path.write_text(path.read_text().replace(repr(hemisphere.gravity), "9.81"))
    given = replace(known(hemisphere), frequency_column=None, gravity=9.81)
    assert read(tmp_path / "h", given).attributes["assumed"] == "first column period"
    scaled(tmp_path / "h", 1.0, 9.81, column)
    back = read(tmp_path / "h", given)
    assert back.attributes["assumed"] == f"first column {column}"
    np.testing.assert_allclose(back.frequency, hemisphere.frequency, rtol=1e-12)


def test_finite_depth_wavenumbers(hemisphere, tmp_path):
    wamit.write(hemisphere, tmp_path / "h")
    given = replace(
        known(hemisphere), frequency_column=FrequencyColumn.WAVENUMBER, water_depth=0.4, length=2.0
    )
    (tmp_path / "h.mmx").unlink()
    number = 2 * np.pi / hemisphere.frequency[::-1]  # what stands in the first column
    w = np.sqrt(hemisphere.gravity * number / 2 * np.tanh(number / 2 * 0.4))
    (tmp_path / "h.8").unlink(), (tmp_path / "h.9").unlink()
    np.testing.assert_allclose(read(tmp_path / "h", given).frequency, w, rtol=1e-12)


# Traps of the files.


def test_order_line_ends_headings_and_zero_pairs_do_not_matter(hemisphere, tmp_path, differences):
    wamit.write(hemisphere, tmp_path / "h")
    expected = read(tmp_path / "h", known(hemisphere))
    random = np.random.default_rng(1)
    for suffix in (".1", ".3", ".8", ".9", ".hst"):
        path = tmp_path / f"h{suffix}"
        lines = path.read_text().splitlines()[1:]
        if suffix == ".1":
            zero = [line for line in lines if all(float(x) == 0 for x in line.split()[3:])]
            assert zero
            lines = [line for line in lines if line not in zero]
        random.shuffle(lines)
        path.write_bytes("\r\n".join(["", *(line.replace("e", "D") for line in lines)]).encode())
    assert not differences(expected, read(tmp_path / "h", known(hemisphere)))


def test_negative_indices_of_drift_and_crossing_waves_are_left_out(made_up, tmp_path, differences):
    db = made_up()
    wamit.write(db, tmp_path / "x")
    expected = read(tmp_path / "x", known(db))

    def more(rows: list[list[str]]) -> list[list[str]]:
        turned = [[*row[:3], f"-{row[3]}", "9", "9", "9", "9"] for row in rows]
        crossing = [[*row[:2], "12.5", *row[3:6], "9", "9"] for row in rows]
        return [*turned, *rows, *crossing]

    rewrite(tmp_path / "x.8", more)
    rewrite(tmp_path / "x.9", more)
    assert not differences(expected, read(tmp_path / "x", known(db)))


def test_momentum_is_preferred_for_one_body_only(made_up, tmp_path):
    db = made_up()
    wamit.write(db, tmp_path / "x")
    rewrite(tmp_path / "x.8", lambda rows: [[*row[:6], "77", "0"] for row in rows])
    back = read(tmp_path / "x", known(db))
    weight = db.water_density * db.gravity
    np.testing.assert_allclose(back.mean_drift[..., [0, 1, 5]], 77 * weight)
    np.testing.assert_allclose(back.mean_drift[..., [2, 3, 4]], db.mean_drift[..., [2, 3, 4]])
    shutil.copyfile(tmp_path / "x.9", tmp_path / "x.7")
    rewrite(tmp_path / "x.9", lambda rows: [[*row[:6], "55", "0"] for row in rows])
    back = read(tmp_path / "x", known(db))
    np.testing.assert_allclose(back.mean_drift[..., [2, 3, 4]], db.mean_drift[..., [2, 3, 4]])
    two = made_up(2)
    wamit.write(two, tmp_path / "two")
    shutil.copyfile(tmp_path / "x.8", tmp_path / "two.8")
    np.testing.assert_allclose(read(tmp_path / "two", known(two)).mean_drift, two.mean_drift)
    (tmp_path / "two.9").unlink()
    alone = read(tmp_path / "two", known(two))
    assert alone.mean_drift is None
    assert "left out" in alone.attributes["mean_drift_method"]


def test_excitation_by_other_files(made_up, tmp_path):
    db = made_up()
    wamit.write(db, tmp_path / "x")
    (tmp_path / "x.3").rename(tmp_path / "x.2")
    np.testing.assert_allclose(read(tmp_path / "x.2", known(db)).excitation, db.excitation)
    (tmp_path / "x.2").rename(tmp_path / "x.3sc")
    both = read(tmp_path / "x.3sc", known(db))
    np.testing.assert_allclose(both.excitation, db.excitation + db.froude_krylov)
    np.testing.assert_allclose(both.froude_krylov, db.froude_krylov)


def test_what_nobody_says_is_assumed_and_told(made_up, tmp_path):
    db = made_up(gravity=9.80665, water_density=1025.0)
    wamit.write(db, tmp_path / "x")
    (tmp_path / "x.mmx").unlink()
    back = read(tmp_path / "x", Given(frequency_column=FrequencyColumn.PERIOD))
    assert back.attributes["assumed"] == (
        "length 1, water density 1025, gravity 9.80665, water depth inf,"
        " reference points at the origin"
    )
    np.testing.assert_allclose(back.added_mass, db.added_mass, rtol=1e-14)
    assert back.volume is None
    assert back.centre_of_gravity is None
    given = Given(volume=(3.0,), centre_of_gravity=(1.0, 2.0, 3.0))
    told = read(tmp_path / "x", given)
    np.testing.assert_array_equal(told.volume, [3.0])
    np.testing.assert_array_equal(told.centre_of_gravity, [[1.0, 2.0, 3.0]])


# The control file of one body, and of two as published with a wave energy converter (RM3).
ONE_BODY = """hull.POT
200.0  0.5 0. -3. {phi}        HBOT, XBODY(1-4)
 1   1                 IRAD, IDIFF
 1  1  1  1  1  1      IMODE(1-6)
 -46                   NPER
 0.25 0.05             PER
 2                     NBETA
 0.0 45.0              BETA
"""
TWO_BODIES = """rm3.pot -- file type .gdf, ILOWHI=0, IRR=1
0.                             HBOT
1           1                  \tIRAD, IDIFF
 -262                         \tNPER
 -0.02 0.02                    \tPER
  1                          \tNBETA
0.0                       \tBETA
 2 \t\t\t\tNBODY
float.gdf
 0.0 0.0 -0.72 0.0 \t\tXBODY(1-4)
 1  1  1  1  1  1               IMODE(1-6)
spar.gdf
 0.0 0.0 -21.29 0.0 \t\tXBODY(1-4)
 1  1  1  1  1  1               IMODE(1-6)
"""


@pytest.mark.parametrize(
    ("text", "points", "depth"),
    [
        (ONE_BODY.format(phi="0."), [[0.5, 0, -3]], 200.0),
        (ONE_BODY.format(phi="0.").replace("  0.5 0.", "\n0.5 0."), [[0.5, 0, -3]], 200.0),
        (TWO_BODIES, [[0, 0, -0.72], [0, 0, -21.29]], np.inf),
    ],
)
def test_the_control_file_tells_reference_points_and_depth(made_up, tmp_path, text, points, depth):
    wamit.write(made_up(len(points)), tmp_path / "x")
    (tmp_path / "x.pot").write_text(text)
    db = read(tmp_path / "x.1")
    np.testing.assert_array_equal(db.reference_point, points)
    assert db.water_depth == depth
    assert "reference" not in db.attributes["assumed"]
    assert "depth" not in db.attributes["assumed"]


def test_a_control_file_of_something_else_is_refused(made_up, tmp_path):
    wamit.write(made_up(), tmp_path / "x")
    path = tmp_path / "x.pot"
    turned = ONE_BODY.format(phi="90.")
    path.write_text(turned)
    with pytest.raises(InputError, match=r"x\.pot: PHIBODY is 90 degrees"):
        read(tmp_path / "x.1")
    path.write_text(turned.replace(" 1  1  1 ", " 7  1  1 "))
    with pytest.raises(InputError, match=r"x\.pot: found other numbers .* give the reference"):
        read(tmp_path / "x.1")
    path.write_text(TWO_BODIES)
    with pytest.raises(InputError, match=r"x\.pot.*given for 2 bodies, but the \.1 file has 1"):
        read(tmp_path / "x.1")


def test_centres_in_the_header_are_relative_to_the_reference_point(made_up, tmp_path):
    db = made_up(2)
    wamit.write(db, tmp_path / "x")
    text = (tmp_path / "x.mmx").read_text()
    bodies = [
        f" XBODY = {x!r} YBODY = {y!r} ZBODY = {z!r} PHIBODY = 0.0"
        for x, y, z in db.reference_point.tolist()
    ]
    water = f" Water depth: infinite   Water density: {db.water_density}"
    (tmp_path / "x.out").write_text("\n".join([water, *bodies, text]))
    (tmp_path / "x.mmx").unlink()
    back = read(tmp_path / "x")
    for name in ("reference_point", "centre_of_gravity", "centre_of_buoyancy", "volume"):
        np.testing.assert_allclose(getattr(back, name), getattr(db, name), rtol=1e-14)
    assert np.isinf(back.water_depth)


def test_external_masses_are_as_given_to_wamit(made_up, tmp_path):
    db = made_up()
    wamit.write(db, tmp_path / "x")
    (tmp_path / "x.mmx").write_text(
        "Gravity: 9.81 Length scale: 1.0\nNBODY = 1 IALTFRC = 2\n\n External force matrices\n"
        " I J MASS DAMPING STIFFNESS\n 1 1 5.0 7.0 8.0\n 5 1 -3.0 0 0\n"
    )
    inertia = read(tmp_path / "x", known(db)).inertia_matrix
    assert inertia[0, 0] == 5.0
    assert inertia[4, 0] == -3.0
    assert np.count_nonzero(inertia) == 2


def test_symmetry_is_seen_or_told(hemisphere, volturnus, sphere, made_up, tmp_path):
    assert all(db.port_starboard_symmetric for db in (hemisphere, volturnus, sphere))
    db = made_up()
    wamit.write(db, tmp_path / "x")
    assert not read(tmp_path / "x", known(db)).port_starboard_symmetric
    assert read(tmp_path / "x", known(db, port_starboard_symmetric=True)).port_starboard_symmetric


# Round trips.


@pytest.mark.parametrize("bodies", [1, 2])
def test_round_trip(made_up, tmp_path, bodies, differences):
    """Numbers that no quotient times density gives exactly differ by one bit the first time;
    from then on nothing changes."""
    db = made_up(bodies)
    wamit.write(db, tmp_path / "a")
    first = read(tmp_path / "a", known(db))
    found = differences(db, first)
    assert {name for name, d in found.items() if d > 3e-16} == set(NOT_MIRRORED)
    wamit.write(first, tmp_path / "b")
    assert not differences(first, read(tmp_path / "b", known(first)))


@pytest.mark.parametrize("name", ["sphere", "hemisphere", "volturnus"])
def test_real_files_round_trip_bit_for_bit(request, tmp_path, name, differences):
    """Through WAMIT text with 17 digits, through BEMIO and through our own file."""
    db = request.getfixturevalue(name)
    wamit.write(db, tmp_path / "a")
    assert not differences(db, read(tmp_path / "a", known(db)))
    netcdf.write(db, tmp_path / "a.nc")
    assert not differences(db, read(tmp_path / "a.nc"))
    if db.centre_of_gravity is None:
        db = replace(db, centre_of_gravity=db.reference_point)
    bemio.write(db, tmp_path / "a.h5")
    found = differences(db, read(tmp_path / "a.h5"))
    assert set(found) <= {"added_mass_zero", "inertia_matrix"}


# Damage.

DAMAGE = {
    "cut": (".3", lambda t: t[: len(t) // 2], r"line \d+: found .* (columns|row)"),
    "lost row": (
        ".3",
        lambda t: t.rsplit("\n", 2)[0] + "\n",
        r"line \d+: found the end and no row",
    ),
    "twice": (".1", lambda t: t + t.splitlines()[-1], r"line \d+: found the same indices as in"),
    "huge": (".1", lambda t: t.replace("     6     6", " 99999     6", 1), r"whole number from 1"),
    "fraction": (".hst", lambda t: t.replace("     6     6", "   5.5     6"), r"line 37: .*whole"),
    "nan": (".3", lambda t: t.replace("e+00", "NaN", 1), r"line 2: found .*NaN.* a number"),
    "stars": (".1", lambda t: t.replace("     3     3", "     3 *****"), r"found '\*+'"),
    "period": (".3", lambda t: t.replace("3.1415", "3.2415"), r"line \d+: found .* in column 1"),
    "no number": (".hst", lambda t: "nothing here\n", r"found no rows of numbers"),
    "empty": (".1", lambda t: "", r"found no rows of numbers"),
    "other set": (".hst", lambda t: t + "  7  7  1.0\n", r"line 38: found 7, expected a whole"),
    "unpaired": (".12d", lambda t: "\n".join(t.splitlines()[:-6]), r"no row .* rad/s"),
    "one heading": (".9", lambda t: "\n".join(t.splitlines()[:-1]), r"no row .* rad/s"),
    "feet": (".mmx", lambda t: t.replace("9.81", "32.2"), r"gravity is 32\.2.*feet"),
    "no scale": (".mmx", lambda t: t.replace("9.81", "g"), r"line 2: found 'g' after 'Gravity:'"),
    "three bodies": (".mmx", lambda t: t + t, r"given for 2 bodies, but the \.1 file has 1"),
    "mass": (".mmx", lambda t: t.replace("     6     6", "     6     9"), r"line \d+: found '6 9"),
    "damping": (".1", lambda t: "\n".join(x[:60] for x in t.splitlines()), r"damping in the fifth"),
}


@pytest.mark.parametrize("kind", DAMAGE)
def test_damage_is_named_with_file_and_line(made_up, tmp_path, kind):
    db = made_up(frequency=np.array([0.5, 1.0, 2.0, 4.0]))
    wamit.write(db, tmp_path / "x")
    suffix, change, message = DAMAGE[kind]
    path = tmp_path / f"x{suffix}"
    text = path.read_text()
    assert change(text) != text
    path.write_text(change(text))
    with pytest.raises(InputError, match=message) as caught:
        read(tmp_path / "x", replace(known(db), gravity=None))
    assert f"x{suffix}" in str(caught.value)


def test_a_single_huge_index_makes_no_huge_array(made_up, tmp_path):
    db = made_up()
    wamit.write(db, tmp_path / "x")
    (tmp_path / "x.mmx").unlink()
    rewrite(tmp_path / "x.1", lambda rows: [*rows[:-1], [rows[-1][0], "6000", *rows[-1][2:]]])
    with pytest.raises(InputError, match=r"x\.1: .* rows for 6 x 6000 x 6000 numbers"):
        read(tmp_path / "x", replace(known(db), reference_point=None))


def test_missing_files_are_named(made_up, tmp_path):
    db = made_up()
    wamit.write(db, tmp_path / "x")
    (tmp_path / "x.3").rename(tmp_path / "x.3sc")
    for suffix in (".2", ".3fk"):
        (tmp_path / f"x{suffix}").unlink(missing_ok=True)
    with pytest.raises(InputError, match=r"x\.3: no such file, and \.3sc without its other half"):
        read(tmp_path / "x")
    (tmp_path / "x.1").unlink()
    with pytest.raises(InputError, match=r"x\.1: no such file"):
        read(tmp_path / "x.hst")
    with pytest.raises(InputError, match=r"y: there is no such file"):
        read(tmp_path / "y")


def test_turned_bodies_are_refused(volturnus_set):
    out = volturnus_set.with_suffix(".out")
    out.write_text(out.read_text().replace("PHIBODY =   0.0", "PHIBODY =  90.0"))
    with pytest.raises(InputError, match=r"volturnus\.out: PHIBODY is 90 degrees, expected 0"):
        read(volturnus_set)


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".1", ".3", ".8", ".12d", ".hst", ".mmx", ".out"])
def test_damaged_files_are_refused_or_read(made_up, tmp_path, suffix, damaged):
    """350 files: a message with the name of a file of the set, or a database."""
    db = made_up()
    wamit.write(db, tmp_path / "x")
    mmx = (tmp_path / "x.mmx").read_text()
    (tmp_path / "x.out").write_text(
        "Water depth: 30.0 Water density: 1000.0\nXBODY = 0.0 YBODY = 0.0 ZBODY = 0.0"
        " PHIBODY = 0.0\n" + mmx[: mmx.index("Normalized")]
    )
    path = tmp_path / f"x{suffix}"
    content = path.read_bytes()
    messages = []
    for changed in damaged(content, 50):
        path.write_bytes(changed)
        try:
            read(tmp_path / "x")
        except InputError as error:
            messages.append(str(error))
    assert len(messages) >= 15
    named = re.compile(rf"{re.escape(str(tmp_path))}/x(\.\w+)?(, line \d+|, /|:)")
    assert [text for text in messages if not named.match(text)] == []


def test_our_formats_are_told_apart(validation, made_up, tmp_path):
    netcdf.write(made_up(), tmp_path / "x.nc")
    files = {
        "hydrosim netCDF": tmp_path / "x.nc",
        "BEMIO HDF5": validation / "sphere" / "sphere.h5",
        "WAMIT": validation / "sphere" / "wamit" / "sphere.hst",
    }
    for name, path in files.items():
        first = next(r for r in READERS if r.sniff(path, path.read_bytes()[:4096]))
        assert name == first.NAME


def test_a_set_without_loads_has_no_headings(hemisphere_copy):
    """The rest is what it was; periods are what tables are taken to have."""
    whole = read(hemisphere_copy)
    hemisphere_copy.with_suffix(".3").unlink()
    bare = read(hemisphere_copy)
    assert bare.heading.size == 0
    assert bare.excitation.shape == (bare.frequency.size, 0, 6)
    np.testing.assert_array_equal(bare.added_mass, whole.added_mass)
    assert bare.mean_drift is None
    assert not any(finding.is_refused for finding in check(bare))


@pytest.fixture
def hemisphere_copy(validation, tmp_path):
    for path in (validation / "hemisphere").iterdir():
        shutil.copy(path, tmp_path)
    return tmp_path / "hemisphere.1"


def test_a_height_alone_is_a_centre_of_gravity_on_the_axis(volturnus_set):
    out = volturnus_set.with_suffix(".out")
    text = re.sub(r"(\(Xg,Yg,Zg\):).*", r"\1    -1.000000", out.read_text(errors="replace"))
    out.write_text(text)
    db = read(volturnus_set)
    np.testing.assert_allclose(db.centre_of_gravity - db.reference_point, [[0.0, 0.0, -1.0]])
