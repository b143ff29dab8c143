"""Faults planted in the barge's database, as they come from other programs and from haste."""

import warnings
from dataclasses import replace
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from validation_data import unpacked

from hydrosim.database import check, load, netcdf
from hydrosim.database.changes import apply_changes as changed_database
from hydrosim.database.checks import CHECKS, accepted_findings, doubt_warnings
from hydrosim.database.checks.finding import EVERYTHING, radius
from hydrosim.database.load import read
from hydrosim.errors import InputError
from hydrosim.scene import Changes
from hydrosim.scene.hydrodynamics import NOTHING_GIVEN, Given

ROOT = Path(__file__).parents[2]
RHO_G = 1025 * 9.81
OPTIONAL = [name for name, variable in netcdf.VARIABLES.items() if variable.optional]


def failed(db) -> set[str]:
    return {finding.name for finding in check(db) if not finding.has_passed}


def changed(db, **changes):
    """The database with functions of its arrays in their place."""
    return replace(db, **{name: change(getattr(db, name)) for name, change in changes.items()})


def times(factor):
    return lambda array: array * factor


def scaled(*index, by):
    """Function that multiplies the part of an array at ``index``, from the last axis backwards."""

    def scale(array):
        copy = array.copy()
        copy[(..., *index)] *= by
        return copy

    return scale


def in_order(*dofs):
    """Function that takes the DOFs of a matrix in another order."""
    return lambda array: array[..., dofs, :][..., dofs]


def turned(array):
    """The matrix in axes turned by 30 degrees."""
    c, s = np.cos(np.radians(30)), np.sin(np.radians(30))
    T = np.kron(np.eye(2), [[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return T @ array @ T.T


def with_bow_up(matrix):
    return matrix * np.outer(BOW_UP, BOW_UP)


def spiked(array):
    copy = array.copy()
    copy[60, 2, 2] *= 1.5
    return copy


def swapped_frequencies(frequency):
    order = np.arange(frequency.size)
    order[[3, 4]] = 4, 3
    return frequency[order]


def coming_from(loads):
    return loads[:, ::-1] * [1, -1, 1, -1, 1, -1]


def with_radians_taken_for_degrees(loads):
    return np.abs(loads) * np.exp(1j * np.degrees(np.angle(loads)))


def per_square_frequency(db):
    return replace(db, radiation_damping=db.radiation_damping / db.frequency[:, None, None])


def far_origin(db):
    k = db.frequency**2 / db.gravity
    phase = 3000.0 * np.outer(k, np.cos(db.heading))
    return replace(db, excitation=db.excitation * np.exp(-1j * phase)[..., None])


def stiffness_of_gravity(db, height):
    """What a centre of gravity at that height takes from roll and pitch stiffness."""
    weight = db.water_density * db.gravity * db.volume[0]
    return np.diag([0, 0, 0, height * weight, height * weight, 0])


def without_gravity(db):
    """Roll and pitch stiffness of the buoyancy alone, about the frame's origin."""
    lost = stiffness_of_gravity(db, -db.centre_of_gravity[0, 2])
    return replace(db, hydrostatic_stiffness=db.hydrostatic_stiffness - lost)


def capsizing(db):
    stiffness = db.hydrostatic_stiffness - stiffness_of_gravity(db, 25.0)
    centre = np.add(db.centre_of_gravity, [0.0, 0.0, 25.0])
    return replace(db, hydrostatic_stiffness=stiffness, centre_of_gravity=centre)


def without_conjugate(qtf):
    """The upper half filled up as if it were symmetric."""
    return np.where(UPPER, qtf, qtf.swapaxes(1, 2))


def with_conjugate(qtf):
    return np.where(UPPER, qtf, qtf.swapaxes(1, 2).conj())


def every(step):
    return lambda db: of_frequencies(db, np.arange(db.frequency.size) % step == 0)


def of_frequencies(db, keep):
    by_frequency = ("frequency", A, B, *PER_HEADING)
    return replace(db, **{name: getattr(db, name)[keep] for name in by_frequency})


def between(db, lowest, highest):
    return of_frequencies(db, (db.frequency >= lowest) & (db.frequency <= highest))


UPPER = np.triu(np.ones((15, 15), dtype=bool))[None, :, :, None]
PER_DEGREE = np.sqrt([1, 1, 1, np.pi / 180, np.pi / 180, 1])
BOW_UP = np.array([1, 1, 1, 1, -1, 1])
DRIFTS = ("mean_drift", "mean_drift_held", "drift_imbalance")
PER_HEADING = ("excitation", "froude_krylov", *DRIFTS)
HORIZONTAL, HEAVE = "phase of the horizontal load in long waves", "heave load in long waves"
SLOPE, HASKIND = "roll and pitch moments in long waves", "damping against loads"
DEPTH = "size of the horizontal load in long waves"

A, B, X, C = "added_mass", "radiation_damping", "excitation", "hydrostatic_stiffness"
FROUDE_KRYLOV, QTF = "froude_krylov", "qtf_difference"
POSITIVE, SIDES, HEAVE_SIZE = "positive damping", "port and starboard", f"size of the {HEAVE}"
SYMMETRIC_A, SYMMETRIC_B = "symmetry of added mass", "symmetry of radiation damping"
LONG_WAVES, ALONG = "Froude-Krylov loads in long waves", "drift along the waves"
SWAY_AND_HEAVE, SURGE_AND_SWAY = in_order(0, 2, 1, 3, 4, 5), in_order(1, 0, 2, 4, 3, 5)

# A change of the database, and the check that refuses it.
REFUSED = {
    "frequencies not sorted": ({"frequency": swapped_frequencies}, "frequencies"),
    "periods for frequencies": ({"frequency": lambda w: 2 * np.pi / w}, "frequencies"),
    "zero frequency among the others": ({"frequency": lambda w: w - w[0]}, "frequencies"),
    "frequencies in Hz": ({"frequency": times(1 / (2 * np.pi))}, HASKIND),
    "headings in degrees": ({"heading": np.degrees}, "headings"),
    "headings not sorted": ({"heading": np.flip}, "headings"),
    "loads for exp(-i w t)": ({X: np.conj}, HORIZONTAL),
    "headings that waves come from": ({X: coming_from}, HORIZONTAL),
    "loads with the other sign": ({X: times(-1)}, f"phase of the {HEAVE}"),
    "loads over rho g": ({X: times(1 / RHO_G)}, HEAVE_SIZE),
    "loads times rho g": ({X: times(RHO_G)}, HEAVE_SIZE),
    "loads over g": ({X: times(1 / 9.81)}, HEAVE_SIZE),
    "loads per wave height": ({X: times(0.5)}, HEAVE_SIZE),
    "loads in kN": ({X: times(1e-3)}, HASKIND),
    "pitch positive bow up, in the loads": ({X: scaled(4, by=-1)}, SLOPE),
    "pitch positive bow up, in the damping": ({B: with_bow_up}, HASKIND),
    "roll loads with the other sign": ({X: scaled(3, by=-1)}, SLOPE),
    "roll and pitch loads swapped": ({X: lambda X: X[..., [0, 1, 2, 4, 3, 5]]}, SLOPE),
    "Froude-Krylov loads over rho g": ({FROUDE_KRYLOV: times(1 / RHO_G)}, LONG_WAVES),
    "Froude-Krylov loads for exp(-i w t)": ({FROUDE_KRYLOV: np.conj}, LONG_WAVES),
    "damping with the other sign": ({B: times(-1)}, POSITIVE),
    "roll damping with the other sign": ({B: scaled(3, 3, by=-1)}, POSITIVE),
    "damping over rho": ({B: times(1 / 1025)}, HASKIND),
    "damping over w": (per_square_frequency, HASKIND),
    "added mass and damping over rho": ({A: times(1 / 1025), B: times(1 / 1025)}, HASKIND),
    "coupling in another unit": ({A: scaled(0, 4, by=10)}, SYMMETRIC_A),
    "coupling damping in another unit": ({B: scaled(0, 4, by=10)}, SYMMETRIC_B),
    "columns in another order": ({A: lambda A: A[..., [0, 2, 1, 3, 4, 5]]}, SYMMETRIC_A),
    "sway and heave swapped": ({A: SWAY_AND_HEAVE, B: SWAY_AND_HEAVE}, SIDES),
    "axes turned by 30 degrees": ({A: turned, B: turned}, SIDES),
    "axes turned by 90 degrees": ({A: SURGE_AND_SWAY, B: SURGE_AND_SWAY}, HASKIND),
    "stiffness with the other sign": ({C: times(-1)}, "heave stiffness"),
    "stiffness in kN": ({C: times(1e-3)}, HEAVE_SIZE),
    "coupling stiffness with the other sign": ({C: with_bow_up}, SLOPE),
    "mass in tonnes": ({"inertia_matrix": times(1e-3)}, "weight"),
    "roll and pitch stiffness per degree": (
        {C: lambda C: C * np.outer(PER_DEGREE, PER_DEGREE)},
        "moments of the waterplane",
    ),
    "degrees taken for radians in the phases": ({X: with_radians_taken_for_degrees}, HORIZONTAL),
    "water density in t/m3": (lambda db: replace(db, water_density=1.025), HASKIND),
    "drift with the other sign": ({"mean_drift": times(-1)}, ALONG),
    "drift of headings that waves come from": ({"mean_drift": coming_from}, ALONG),
    "drift over rho g": ({"mean_drift": times(1 / RHO_G)}, "size of the drift"),
    "half of the QTF without conjugate": ({QTF: without_conjugate}, "QTF is Hermitian"),
    "half of the sum QTF with conjugate": ({"qtf_sum": with_conjugate}, "sum QTF is symmetric"),
    "QTF over rho g": ({QTF: times(RHO_G)}, "QTF against mean drift"),
}
# A change of the database, and the check that warns of it.
DOUBTED = {
    "no high frequencies": (lambda db: between(db, 0.02, 0.8), "kernel truncation"),
    "frequencies far apart": (every(12), "frequency spacing"),
    "volume in another unit": ({"volume": times(1.5)}, DEPTH),
    "depth of 100 m instead of deep water": (lambda db: replace(db, water_depth=100.0), DEPTH),
    "irregular frequency": ({A: spiked}, "irregular frequencies"),
    "phases at a place 3 km away": (far_origin, "smooth loads"),
    "added mass over rho": ({A: times(1 / 1025)}, "added mass against damping"),
    "infinite frequency over rho": (
        {"added_mass_infinite": times(1 / 1025)},
        "added mass at infinite frequency",
    ),
    "zero and infinite frequency swapped": (
        lambda db: replace(db, added_mass_zero=db.added_mass_infinite),
        "added mass at zero frequency",
    ),
    "a little asymmetry": ({A: scaled(0, 4, by=1.1)}, SYMMETRIC_A),
    "a little negative damping": ({B: lambda B: B - 0.01 * B.max(axis=0)}, POSITIVE),
    "stiffness without gravity": (without_gravity, SLOPE),
    "stiffness coupling on one side": ({C: scaled(2, 4, by=-1)}, "symmetry of the stiffness"),
    "centre of gravity 25 m higher": (capsizing, "metacentric heights"),
    "mass with 5 % more": ({"inertia_matrix": times(1.05)}, "weight"),
    "drift doubled in the file": (
        lambda db: replace(
            db, attributes={**db.attributes, netcdf.NUMBERS_ATTRIBUTE: netcdf.ALTERED}
        ),
        "numbers as written",
    ),
    "QTF per two amplitudes": ({QTF: times(2)}, "QTF against mean drift"),
}


def planted(db, change):
    return change(db) if callable(change) else changed(db, **change)


@pytest.fixture(scope="module")
def whole(barge):
    """The barge with quadratic transfer functions that have the right symmetries and diagonal."""
    w = barge.frequency[9:80:5]
    drift = np.stack([np.interp(w, barge.frequency, row) for row in barge.mean_drift[:, 0].T], -1)
    mean = (drift[:, None] + drift) / 2
    apart, together = w[:, None] - w, w[:, None] + w
    inertia = np.zeros((6, 6))
    inertia[[0, 1, 2], [0, 1, 2]] = barge.water_density * barge.volume
    return replace(
        barge,
        inertia_matrix=inertia if barge.inertia_matrix is None else barge.inertia_matrix,
        qtf_frequency=w,
        qtf_heading=np.zeros((1, 2)),
        qtf_difference=(mean * np.exp(1j * apart)[..., None])[None],
        qtf_sum=(mean * np.exp(1j * together)[..., None])[None],
    )


def test_the_barge_passes_everything(whole):
    assert failed(whole) == set()
    assert not any(finding.left_out for finding in check(whole))


@pytest.mark.parametrize("fault", REFUSED)
def test_a_fault_is_refused_by_name(whole, tmp_path, fault):
    change, name = REFUSED[fault]
    netcdf.write(planted(whole, change), tmp_path / "db.nc")
    with pytest.raises(InputError, match=rf"(?s)db\.nc.*\n  {name}: found [^\n]* expected"):
        load(tmp_path / "db.nc")


@pytest.mark.filterwarnings("ignore::UserWarning")  # what else it raises
@pytest.mark.parametrize("doubt", DOUBTED)
def test_a_doubt_is_a_warning(whole, tmp_path, doubt):
    change, name = DOUBTED[doubt]
    netcdf.write(planted(whole, change), tmp_path / "db.nc")
    with pytest.warns(UserWarning, match=rf"db\.nc: (.*; )?{name}: found"):
        load(tmp_path / "db.nc")


def test_a_refusal_says_how_noise_is_taken_away(whole):
    turned = replace(whole, added_mass=scaled(0, 4, by=5.0)(whole.added_mass))
    with pytest.raises(InputError, match=r"accept: \[symmetry of added mass.*symmetrise=true"):
        doubt_warnings(turned, EVERYTHING)
    with pytest.raises(InputError) as caught:
        doubt_warnings(replace(whole, excitation=whole.excitation.conj()), EVERYTHING)
    assert "symmetrise" not in str(caught.value)


def test_every_check_finds_a_fault():
    found = {name for _, name in (*REFUSED.values(), *DOUBTED.values())}
    assert found == {one.name for one in CHECKS}


def test_the_documentation_lists_every_check():
    page = (ROOT / "docs" / "databases.md").read_text()
    rows = [line.split("|")[1] for line in page.splitlines() if line.startswith("| ")]
    listed = {name.strip() for row in rows for name in row.split(",")}
    assert {one.name for one in CHECKS} <= listed


@pytest.mark.parametrize("name", ["added_mass", "radiation_damping", "excitation"])
def test_a_check_that_cannot_be_made_is_left_out(whole, name):
    """Without what a file may lack, the checks of the rest stay and still find faults."""
    bare = replace(whole, **dict.fromkeys(OPTIONAL))
    assert failed(bare) == set()
    left_out = {finding.name: finding.advice for finding in check(bare) if finding.left_out}
    assert left_out["weight"] == "left out: the database has no inertia matrix"
    assert HASKIND not in left_out
    assert failed(changed(bare, **{name: times(-1)}))


@pytest.mark.parametrize("bodies", [1, 2])
@pytest.mark.parametrize("attributes", [{}, {"panels": "{}"}])
def test_wide_panels_are_a_cause_where_bodies_were_built_from_them(made_up, bodies, attributes):
    heading = np.radians([0.0, 45.0, 90.0, 135.0, 180.0])
    loads = np.ones((4, 5, 6 * bodies), complex)
    bare = dict.fromkeys(("froude_krylov", *DRIFTS))
    db = made_up(bodies, heading=heading, excitation=loads, attributes=attributes, **bare)
    (check_of_damping,) = (each for each in CHECKS if each.name == HASKIND)
    finding = check_of_damping(db)
    assert not finding.left_out
    assert ("wider than the gap" in str(finding)) == (bodies == 2 and bool(attributes))


@pytest.mark.parametrize("bodies", [1, 2])
def test_nonsense_is_refused_without_an_error(made_up, bodies):
    findings = check(made_up(bodies))
    assert all(np.isfinite(finding.figure) for finding in findings)
    assert any(finding.is_refused for finding in findings)


def test_few_frequencies_and_headings_are_no_error(barge):
    few = of_frequencies(barge, barge.frequency == barge.frequency[5])
    few = replace(
        few,
        heading=few.heading[:1],
        port_starboard_symmetric=False,
        **{name: getattr(few, name)[:, :1] for name in PER_HEADING},
    )
    left_out = {finding.name for finding in check(few) if finding.left_out}
    assert {HASKIND, "irregular frequencies", "port and starboard"} < left_out


def test_nan_is_refused(barge, tmp_path):
    netcdf.write(barge, tmp_path / "db.nc")
    with netCDF4.Dataset(tmp_path / "db.nc", "a") as file:
        file["excitation"][5, 3, 2, 0] = np.nan
    with pytest.raises(InputError, match="excitation has 1 values"):
        load(tmp_path / "db.nc")


@pytest.mark.parametrize(("name", "said"), [("db.nc", "no such file"), (".", "is a directory")])
def test_no_file_and_no_directory(tmp_path, name, said):
    with pytest.raises(InputError, match=said):
        load(tmp_path / name)


def test_short_lowest_wave_is_no_proof_of_convention(barge):
    """From 0.6 rad/s the loads are far from the limit of long waves: doubts, not refusals."""
    short = between(barge, 0.6, 2.2)
    findings = [finding for finding in check(short) if "long waves" in finding.name]
    assert not all(finding.has_passed for finding in findings)
    assert not any(finding.is_refused for finding in findings)


def test_two_barges_far_from_the_origin_are_in_phase_with_their_own_waves(barge):
    """Moved by d, a body has the loads X exp(-i k d cos b); the check must see through that."""
    k = barge.frequency**2 / barge.gravity
    d = 2000.0 * np.cos(barge.heading)
    moved = barge.excitation * np.exp(-1j * k[:, None] * d)[..., None]
    two = np.kron(np.eye(2), np.ones((6, 6)))
    none = ("added_mass_zero", "added_mass_infinite", "froude_krylov", "inertia_matrix")
    qtf = ("qtf_frequency", "qtf_heading", "qtf_difference")
    places = ("centre_of_buoyancy", "centre_of_gravity", "reference_point")
    db = replace(
        barge,
        added_mass=np.tile(barge.added_mass, (1, 2, 2)) * two,
        radiation_damping=np.tile(barge.radiation_damping, (1, 2, 2)) * two,
        excitation=np.concatenate([barge.excitation, moved], axis=2),
        hydrostatic_stiffness=np.tile(barge.hydrostatic_stiffness, (2, 2)) * two,
        volume=np.tile(barge.volume, 2),
        **{name: np.add(getattr(barge, name), [[0, 0, 0], [2000, 0, 0]]) for name in places},
        **dict.fromkeys((*none, "mean_drift", "mean_drift_held", *qtf)),
    )
    assert failed(db) == set()
    at_origin = replace(db, centre_of_buoyancy=np.tile(barge.centre_of_buoyancy, (2, 1)))
    assert "phase of the heave load in long waves" not in failed(db)
    phase = {f.name: f.figure for f in check(at_origin)}["phase of the heave load in long waves"]
    assert phase == pytest.approx(np.degrees(k[0] * 2000.0), rel=0.01)


def test_load_is_silent_on_the_barge(barge):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load(barge.source)


# What the checks say of other people's databases. The sphere's was computed in deep water and says
# 200 m. The hemisphere has irregular frequencies
# above 5 rad/s, the semi-submersible above 4 and trapped waves between its columns.
OTHERS = {
    "sphere/sphere.h5": {DEPTH},
    "hemisphere/hemisphere.1": {
        "irregular frequencies",
        "positive damping",
        "added mass against damping",
    },
    "volturnus/volturnus.1": {
        "irregular frequencies",
        "positive damping",
        "symmetry of radiation damping",
    },
}


@pytest.mark.parametrize("name", OTHERS)
def test_databases_of_others(name):
    given = Given(water_density=1000.0) if "hemi" in name else NOTHING_GIVEN
    findings = check(read(unpacked(name), given))
    assert {finding.name for finding in findings if not finding.has_passed} == OTHERS[name]
    assert not any(finding.is_refused for finding in findings)


def test_what_somebody_has_looked_into_is_not_warned_of_again(barge):
    """But stands in the table of `db check`; and what would be refused is still warned of."""
    short, name = between(barge, 0.02, 0.8), "kernel truncation"
    assert any(name in said for said in doubt_warnings(short, EVERYTHING))
    known = changed_database(short, Changes(accept=(name,)))
    assert not any(name in said for said in doubt_warnings(known, EVERYTHING))
    (finding,) = (one for one in check(known) if one.name == name)
    assert not finding.has_passed
    assert ", accepted" in str(finding)
    both = changed_database(known, Changes(accept=("positive damping",)))
    assert accepted_findings(both) == [name, "positive damping"]
    refused = replace(barge, radiation_damping=-barge.radiation_damping)
    names = tuple(one.name for one in check(refused) if one.is_refused)
    assert names
    said = doubt_warnings(changed_database(refused, Changes(accept=names)), EVERYTHING)
    assert all(any(name in line for line in said) for name in names)


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_doubts_are_one_short_line_that_names_the_command(whole, tmp_path):
    """The advice of each is what `hydrosim db check` prints."""
    change, _ = DOUBTED["depth of 100 m instead of deep water"]
    changed = planted(whole, change)
    (line,) = doubt_warnings(changed, EVERYTHING)
    doubted = [finding for finding in check(changed, EVERYTHING) if finding.is_doubted]
    assert len(doubted) > 1
    assert line.endswith(". `hydrosim db check` explains each.")
    assert line.count(changed.source) == 1
    for finding in doubted:
        assert finding.summary in line
        assert finding.advice not in line
        assert finding.advice in str(finding)
    assert len(line) < 0.5 * sum(len(str(finding)) for finding in doubted)


def test_the_size_of_a_hull_does_not_shrink_in_shallow_water():
    """The water under a keel adds ten times the mass in heave, and hardly more in pitch. Half the
    diagonal of the box of 100 by 20 m is 51 m."""
    box = load(ROOT / "hydro_db" / "box.nc")
    shallow = changed(box, added_mass=scaled(2, 2, by=10.0))
    half_diagonal = np.hypot(100.0, 20.0) / 2.0
    assert 0.9 * half_diagonal < radius(shallow)[0] <= radius(box)[0]
