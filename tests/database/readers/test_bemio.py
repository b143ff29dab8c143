import warnings
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from pathlib import Path

import h5py
import numpy as np
import pytest

from hydrosim.database import HydroDatabase, check, load, move_reference, netcdf
from hydrosim.database.load import read
from hydrosim.database.readers import bemio, wamit
from hydrosim.errors import InputError
from hydrosim.scene.hydrodynamics import FrequencyColumn, Given

NO_PLACE = {"added_mass_zero", "inertia_matrix", "mean_drift_held", "drift_imbalance"}
QTF = ("qtf_frequency", "qtf_heading", "qtf_difference", "qtf_sum")


@pytest.fixture(scope="session")
def path(validation) -> Path:
    return validation / "sphere" / "sphere.h5"


@pytest.fixture(scope="session")
def sphere(path) -> HydroDatabase:
    return read(path)


@pytest.fixture
def at_centre(made_up) -> Callable[..., HydroDatabase]:
    """Random numbers about the centres of gravity, with one pair of headings."""

    def make(bodies: int = 1, **given) -> HydroDatabase:
        db = made_up(bodies, **given)
        return replace(
            db,
            reference_point=db.centre_of_gravity,
            qtf_heading=db.qtf_heading[1:],
            qtf_difference=db.qtf_difference[1:],
            qtf_sum=db.qtf_sum[1:],
            hydrostatic_stiffness=own_blocks(db.hydrostatic_stiffness),
        )

    return make


def own_blocks(stiffness: np.ndarray) -> np.ndarray:
    """Bodies do not support each other, and the file holds no more."""
    body = np.arange(len(stiffness)) // 6
    return np.where(body[:, None] == body, stiffness, 0.0)


# The sphere of the OES task, from WEC-Sim.


def test_sphere_has_the_limits_of_theory(sphere):
    """At infinite frequency a floating sphere has in heave half the displaced mass (the surface is
    a mirror); in long waves heave is the waterplane's and surge that of (displaced + added mass)
    times the water's acceleration, 90 degrees ahead: panels within 0.1 %."""
    half = 1000 * 2 / 3 * np.pi * 5**3 / 2
    assert sphere.added_mass_infinite[2, 2] == pytest.approx(half, rel=1e-3)
    stiffness = 9810 * np.pi * 25
    assert sphere.hydrostatic_stiffness[2, 2] == pytest.approx(stiffness, rel=1e-3)
    assert sphere.excitation[0, 0, 2] == pytest.approx(stiffness, rel=2e-3)
    surge = 1j * 3 * half * sphere.frequency[0] ** 2
    assert sphere.excitation[0, 0, 0] == pytest.approx(surge, rel=2e-3)
    assert sphere.volume == pytest.approx([2 / 3 * np.pi * 5**3], rel=1e-3)
    assert sphere.water_depth == 200.0
    assert sphere.attributes["program"] == "WAMIT"


def test_damping_agrees_with_the_retardation_function_in_the_file(sphere, path):
    """BEMIO's own K/rho is 2/pi int B/rho cos(w t) dw over the frequencies of the file: a factor w
    or rho would show. Its interpolation of B/(rho w) and ours of B differ by 0.3 %."""
    with h5py.File(path) as file:
        group = file["body1/hydro_coeffs/radiation_damping/impulse_response_fun"]
        t, K = group["t"][:, 0], group["K"][:]
    w = np.linspace(sphere.frequency[0], sphere.frequency[-1], 4000)
    for i, j in ((0, 0), (2, 2), (0, 4), (4, 4)):
        B = np.interp(w, sphere.frequency, sphere.radiation_damping[:, i, j])
        for sample in (0, 50, 200, 400):
            ours = 2 / np.pi * np.trapezoid(B * np.cos(w * t[sample]), w)
            assert ours == pytest.approx(1000 * K[i, j, sample], abs=3e-3 * 1000 * K[i, j, 0])


def test_sphere_agrees_with_the_wamit_run_where_both_are_deep(sphere, validation):
    """Two runs of the same sphere: this one in deep water, the other in 50 m and with other panels
    (volume 0.06 % apart). From 1 to 3 rad/s depth plays no role and the panels' 1 % remains."""
    given = Given(
        water_density=1000.0, gravity=9.81, water_depth=50.0, reference_point=(0.0, 0.0, -2.0)
    )
    other = read(validation / "sphere" / "wamit" / "sphere.1", given)
    common = [
        (int(np.argmin(abs(sphere.frequency - w))), int(np.argmin(abs(other.frequency - w))))
        for w in np.arange(1.0, 3.05, 0.1)
    ]
    a, b = np.transpose(common)
    np.testing.assert_allclose(sphere.frequency[a], other.frequency[b], rtol=1e-5)
    for i, j in ((0, 0), (1, 1), (2, 2), (4, 4), (0, 4), (1, 3)):
        for name in ("added_mass", "radiation_damping"):
            ours, theirs = getattr(sphere, name)[a, i, j], getattr(other, name)[b, i, j]
            np.testing.assert_allclose(ours, theirs, atol=0.01 * abs(ours).max())
    for dof in (0, 2, 4):
        ours, theirs = sphere.excitation[a, 0, dof], other.excitation[b, 0, dof]
        np.testing.assert_allclose(ours, theirs, atol=0.01 * abs(ours).max())


def test_sphere_is_the_same_bit_for_bit_by_either_reader(sphere, validation, tmp_path, differences):
    """The data of this file as WAMIT text, and of the WAMIT text as such a file."""
    wamit.write(sphere, tmp_path / "text")
    given = Given(
        water_density=1000.0,
        water_depth=200.0,
        reference_point=(0.0, 0.0, -2.0),
        frequency_column=FrequencyColumn.PERIOD,
    )
    assert not differences(sphere, read(tmp_path / "text", given))
    given = replace(given, gravity=9.81, water_depth=50.0, centre_of_gravity=(0.0, 0.0, -2.0))
    text = read(validation / "sphere" / "wamit" / "sphere.1", given)
    bemio.write(text, tmp_path / "text.h5")
    assert set(differences(text, read(tmp_path / "text.h5"))) == {"added_mass_zero"}


def test_sphere_loads(path):
    """Nothing is refused. The warnings are true: the damping of surge, 2 % of its largest value at
    12 rad/s, decays there more slowly than 1/w; and the loads of long waves are those of deep
    water, not of the 200 m that the file says."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        db = load(path)
    assert db.port_starboard_symmetric
    assert {f.name for f in check(db) if not f.has_passed} <= {
        "kernel truncation",
        "size of the horizontal load in long waves",
    }
    assert len(caught) <= 2


# Files made up by other means than our writer.


def by_hand(db: HydroDatabase, path: Path, scaled: bool) -> None:
    """A file as BEMIO writes it from MATLAB: everything a column or row, frequencies descending,
    headings out of order, and duplicates of the coefficients for each pair of DOFs."""
    rho, weight = (1.0, 1.0) if scaled else (db.water_density, db.water_density * db.gravity)
    down = np.argsort(-db.frequency)
    turned = np.array([2, 0, 1])
    w = db.frequency[down]
    rate = np.ones_like(w) if scaled else w
    with h5py.File(path, "w") as file:
        parameters = file.create_group("simulation_parameters")
        parameters["w"], parameters["T"] = w[:, None], 2 * np.pi / w[:, None]
        parameters["wave_dir"] = np.degrees(db.heading[turned])[None, :]
        parameters["water_depth"] = "infinite"
        for name, value in (("rho", db.water_density), ("g", db.gravity), ("scaled", scaled)):
            parameters[name] = [[float(value)]]
        for body, point in enumerate(db.reference_point):
            rows = slice(6 * body, 6 * body + 6)
            group = file.create_group(f"body{body + 1}")
            group["properties/cg"] = point[:, None]
            group["properties/disp_vol"] = [[db.volume[body]]]
            coefficients = group.create_group("hydro_coeffs")
            A = db.added_mass[down][:, rows].transpose(1, 2, 0) / rho
            B = db.radiation_damping[down][:, rows].transpose(1, 2, 0) / rho / rate
            coefficients["added_mass/all"], coefficients["radiation_damping/all"] = A, B
            for i, j in product(range(6), range(12)):
                pair = np.stack([2 * np.pi / w, A[i, j]], axis=1)
                coefficients[f"added_mass/components/{i + 1}_{j + 1}"] = pair
            X = db.excitation[down][:, turned][..., rows].transpose(2, 1, 0) / weight
            coefficients["excitation/re"], coefficients["excitation/im"] = X.real, X.imag
            for part in ("re", "im"):
                coefficients[f"excitation/froude-krylov/{part}"] = np.full(X.shape, np.nan)
            drift = db.mean_drift[down][:, turned][..., rows].transpose(2, 1, 0) / weight
            coefficients["mean_drift/pressure_integration/val"] = drift
            order = np.argsort(-db.qtf_frequency)
            for dof in range(6):
                T = db.qtf_difference[0, ..., 6 * body + dof][order][:, order]
                name = f"excitation/QTF{body + 1}/Diff{dof + 1}"
                inner = coefficients.create_group(name)
                inner["PER_i"] = 2 * np.pi / db.qtf_frequency[order][None, :]
                for wave, angle in zip("ij", np.degrees(db.qtf_heading[0]), strict=True):
                    inner[f"BETA_{wave}"] = np.full((1, order.size), angle)
                column = [T[i, j] for j in range(order.size) for i in range(order.size)]
                inner["Re_F_ij"] = np.real(column)[None, :]
                inner["Im_F_ij"] = np.imag(column)[None, :]


@pytest.mark.parametrize("scaled", [False, True])
def test_normalisation_order_and_duplicates(at_centre, tmp_path, scaled):
    db = at_centre(2)
    by_hand(db, tmp_path / "two.h5", scaled)
    back = read(tmp_path / "two.h5")
    for name in ("frequency", "heading", "added_mass", "radiation_damping", "excitation", "volume"):
        np.testing.assert_allclose(getattr(back, name), getattr(db, name), rtol=1e-13, err_msg=name)
    for name in ("mean_drift", "reference_point", "qtf_frequency", "qtf_heading", "qtf_difference"):
        np.testing.assert_allclose(getattr(back, name), getattr(db, name), rtol=1e-13, err_msg=name)
    for name in ("froude_krylov", "added_mass_infinite", "centre_of_buoyancy", "qtf_sum"):
        assert getattr(back, name) is None
    assert np.isinf(back.water_depth)


def test_two_waves_feel_the_difference_function_as_wec_sim_uses_it(at_centre, tmp_path):
    """WEC-Sim sums a(row) conj(a(column)) T(row, column) exp(+i (w_row - w_column) t), the rows
    running fastest in the file: the load on a gauge that squares the elevation at x = 20 m."""
    db = at_centre(2)
    w = db.qtf_frequency
    eta = np.exp(-1j * w**2 / 9.81 * 20.0)
    transfer = np.zeros_like(db.qtf_difference)
    transfer[0, ..., 0] = np.outer(eta, eta.conj()) / 2
    by_hand(replace(db, qtf_difference=transfer), tmp_path / "gauge.h5", False)
    T = read(tmp_path / "gauge.h5").qtf_difference[0, ..., 0]
    t = np.linspace(0.0, 200.0, 1001)
    a = {1: 0.7 * np.exp(0.3j), 3: 1.1 * np.exp(-2j)}
    slow = sum(
        (a[i] * np.conj(a[j]) * T[i, j] * np.exp(1j * (w[i] - w[j]) * t)).real
        for i, j in product(a, a)
    )
    # The square of the sum of two cosines: its part that varies slowly, in closed form.
    phase = {i: np.angle(a[i] * eta[i]) + w[i] * t for i in a}
    expected = (0.7**2 + 1.1**2) / 2 + 0.7 * 1.1 * np.cos(phase[1] - phase[3])
    np.testing.assert_allclose(slow, expected, atol=1e-12)


# Round trips.


@pytest.mark.parametrize("bodies", [1, 2])
@pytest.mark.parametrize("depth", [30.0, np.inf])
def test_round_trip(at_centre, tmp_path, bodies, depth, differences):
    """Numbers that no quotient gives exactly differ by one bit the first time, then none does."""
    db = at_centre(bodies, water_depth=depth)
    bemio.write(db, tmp_path / "a.h5")
    first = read(tmp_path / "a.h5")
    found = differences(db, first)
    assert {name for name, d in found.items() if d > 3e-16} == NO_PLACE
    assert first.water_depth == depth
    bemio.write(first, tmp_path / "b.h5")
    assert not differences(first, read(tmp_path / "b.h5"))
    netcdf.write(first, tmp_path / "b.nc")
    assert not differences(first, read(tmp_path / "b.nc"))


def test_real_file_round_trips_bit_for_bit(sphere, tmp_path, differences):
    bemio.write(sphere, tmp_path / "a.h5")
    assert not differences(sphere, read(tmp_path / "a.h5"))
    netcdf.write(sphere, tmp_path / "a.nc")
    assert read(tmp_path / "a.nc").checksum == sphere.checksum


def test_coefficients_are_written_about_the_centre_of_gravity(made_up, tmp_path):
    db = made_up(**dict.fromkeys(QTF))
    bemio.write(db, tmp_path / "a.h5")
    back = read(tmp_path / "a.h5")
    moved = move_reference(db, db.centre_of_gravity)
    np.testing.assert_allclose(back.added_mass, moved.added_mass, rtol=1e-14)
    np.testing.assert_array_equal(back.reference_point, db.centre_of_gravity)
    assert "centres of gravity" in back.attributes["assumed"]
    told = read(tmp_path / "a.h5", Given(reference_point=(1.0, 2.0, 3.0)))
    np.testing.assert_array_equal(told.reference_point, [[1.0, 2.0, 3.0]])


def test_several_pairs_of_headings_are_left_out_with_a_warning(made_up, tmp_path):
    with pytest.warns(UserWarning, match="one pair of headings; those of 2 are left out"):
        bemio.write(made_up(), tmp_path / "a.h5")
    assert read(tmp_path / "a.h5").qtf_difference is None


# Damage.

COEFFICIENTS = "body1/hydro_coeffs"


def removed(name: str) -> Callable[[h5py.File], None]:
    return lambda file: file.__delitem__(name)


def put(name: str, value) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        del file[name]
        file[name] = value

    return change


def nan(name: str) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        file[name][(0,) * file[name].ndim] = np.nan

    return change


def enormous(file: h5py.File) -> None:
    del file["simulation_parameters/w"]
    file.create_dataset("simulation_parameters/w", (10**12, 1), dtype="f8", chunks=(1024, 1))


def nested(file: h5py.File) -> None:
    del file["simulation_parameters/rho"]
    file["simulation_parameters/rho/deep"] = 1.0


W, DEPTH = "simulation_parameters/w", "simulation_parameters/water_depth"
A, B = f"{COEFFICIENTS}/added_mass/all", f"{COEFFICIENTS}/radiation_damping/all"
X = f"{COEFFICIENTS}/excitation"
TURNED = np.zeros((240, 6, 6))
DAMAGE = {
    "a group": (nested, "rho is not an array of numbers"),
    "no frequencies": (removed(W), "found no simulation_parameters/w"),
    "no density": (removed("simulation_parameters/rho"), "found no simulation_parameters/rho"),
    "no depth": (removed(DEPTH), "found no simulation_parameters/water_depth"),
    "no body": (removed("body1"), "0 bodies"),
    "no added mass": (removed(A), "body1 has no hydro_coeffs/added_mass/all"),
    "no loads": (removed(f"{X}/re"), "body1 has no hydro_coeffs/excitation/re"),
    "no centre": (removed("body1/properties/cg"), "body1 has no properties/cg; expected one for"),
    "negative w": (put(W, [[-1.0], [1.0]]), "frequencies above zero"),
    "fewer w": (put(W, [[0.1], [1.0]]), r"has shape .*, expected"),
    "enormous": (enormous, r"w has shape \(1000000000000, 1\)"),
    "text": (put(A, "much"), "not an array of numbers"),
    "transposed": (put(B, TURNED), r"has shape \(240, 6, 6\), expected \(6, 6, 240\)"),
    "nan": (nan(f"{X}/im"), "not numbers"),
    "nan frequency": (nan(W), "not numbers"),
    "depth in words": (put(DEPTH, "deep"), "is 'deep', expected"),
    "negative depth": (put(DEPTH, [[-5.0]]), "water_depth is -5"),
    "modes": (put(A, np.zeros((7, 7, 240))), "expected"),
}


@pytest.mark.parametrize("kind", DAMAGE)
def test_damage_is_named(sphere, tmp_path, kind):
    bemio.write(sphere, tmp_path / "x.h5")
    change, message = DAMAGE[kind]
    with h5py.File(tmp_path / "x.h5", "a") as file:
        change(file)
    with pytest.raises(InputError, match=message) as caught:
        read(tmp_path / "x.h5")
    assert "x.h5" in str(caught.value)


def test_damaged_files_are_refused_or_read(at_centre, tmp_path, damaged):
    """100 files: a message with the name, or a database."""
    bemio.write(at_centre(), tmp_path / "x.h5")
    content = (tmp_path / "x.h5").read_bytes()
    messages = []
    for changed in damaged(content, 100):
        (tmp_path / "x.h5").write_bytes(changed)
        try:
            read(tmp_path / "x.h5")
        except InputError as error:
            messages.append(str(error))
    assert len(messages) >= 30
    assert all(text.startswith(f"{tmp_path}/x.h5") for text in messages)
