import copy
import re
from time import process_time
from typing import Any

import damaged
import numpy as np
import pytest
from orcaflex_files import CENTRE, COLUMNS, HULL, USED, contents, pair_columns, wave, write

from hydrosim.database.load import load, read
from hydrosim.database.readers import orcaflex
from hydrosim.errors import InputError
from hydrosim.scene.hydrodynamics import Given
from hydrosim.water.spectra import wavenumber


@pytest.fixture(scope="module")
def model(barge) -> dict[str, Any]:
    return contents(barge)


def draught_of(model: dict[str, Any]) -> dict[str, Any]:
    return model["VesselTypes"][0]["Draughts"][0]


@pytest.mark.parametrize("other", [False, True])
def test_all_conventions_give_the_barge(barge, tmp_path, other):
    """Its frame is OrcaFlex's vessel axes, lowered to the waterline."""
    db = read(write(tmp_path / "barge.yml", contents(barge, other)))
    place = HULL * [1, 1, 0]
    np.testing.assert_allclose(db.frequency, barge.frequency[USED], rtol=1e-12)
    np.testing.assert_allclose(db.heading, barge.heading, atol=1e-12)
    np.testing.assert_allclose(db.reference_point, barge.reference_point + place, atol=1e-12)
    np.testing.assert_allclose(db.centre_of_gravity, barge.centre_of_gravity + place, atol=1e-12)
    np.testing.assert_allclose(db.centre_of_buoyancy, barge.centre_of_buoyancy + place, atol=1e-9)
    for name in ("added_mass", "radiation_damping"):
        np.testing.assert_allclose(getattr(db, name), getattr(barge, name)[USED], rtol=1e-12)
    np.testing.assert_allclose(db.added_mass_infinite, barge.added_mass_infinite, rtol=1e-12)
    expected = barge.excitation[USED] * wave(barge, place)[..., None]
    scale = np.abs(expected).max(axis=(0, 1))
    assert (np.abs(db.excitation - expected) < 1e-9 * scale).all()
    drift = barge.mean_drift[USED]
    assert (np.abs(db.mean_drift - drift) < 1e-9 * np.abs(drift).max()).all()
    assert db.water_density == 1025.0
    assert db.port_starboard_symmetric


def columns_scaled(table: Any, first: int, force: float, moment: float) -> list[list[float]]:
    """Rows with the amplitudes of three forces and three moments over their units."""
    values = np.array(table)
    values[:, first : first + 6 : 2] /= force
    values[:, first + 6 :: 2] /= moment
    return values.tolist()


def in_units(model: dict[str, Any], general: dict[str, Any], *units: float) -> dict[str, Any]:
    """A model in m, te and kN, written in other units of length [m], mass [te] and force [kN]."""
    length, mass, force = units
    six = np.array([1.0, 1.0, 1.0, length, length, length])
    other = copy.deepcopy(model)
    other["General"] = general
    other["Environment"]["Density"] *= length**3 / mass
    draught = draught_of(other)
    draught["CentreOfMass"] = draught.pop("CentreOfGravity")
    for key in ("CentreOfMass", "ReferenceOrigin", "CentreOfBuoyancy"):
        draught[key] = (np.array(draught[key]) / length).tolist()
    draught["ReferenceOriginDatumPosition"][0] /= length
    draught["DisplacedVolume"] /= length**3
    draught["Mass"] /= mass
    for key, value in draught.items():
        if key.startswith("MomentOfInertia"):
            draught[key] = (np.array(value) / (mass * length**2)).tolist()
        if key.startswith("HydrostaticStiffness"):
            arms = np.array([1.0, length, length])
            draught[key] = (np.array(value) * length / force / np.outer(arms, arms)).tolist()
    for item in draught["FrequencyDependentAddedMassAndDamping"]:
        for key, value in item.items():
            if key.startswith("Added"):
                item[key] = (np.array(value) / mass / np.outer(six, six)).tolist()
            if key.startswith("Damping"):
                item[key] = (np.array(value) * length / force / np.outer(six, six)).tolist()
    for name, waves in (("LoadRAOs", 1), ("WaveDrift", 2)):
        table = draught[name]
        for key in ("RAOOrigin", "PhaseOrigin"):
            if key in table:
                table[key] = (np.array(table[key]) / length).tolist()
        over = length**waves
        for direction in table["RAOs"]:
            (key,) = (key for key in direction if key.startswith("RAOPeriod"))
            scaled = columns_scaled(direction[key], 1, force / over, force * length / over)
            direction[key] = scaled
    return other


LB = 0.45359237e-3  # te


def user(length: str, mass: str, force: str) -> dict[str, Any]:
    """The user's own units."""
    units = {"LengthUnits": length, "MassUnits": mass, "ForceUnits": force}
    return {"UnitsSystem": "User"} | units


USER = user("ft", "lbm", "lbf")


@pytest.mark.parametrize(
    ("general", "units"),
    [
        ({"UnitsSystem": "SI"}, (1.0, 1.0, 1.0)),
        ({"UnitsSystem": "US"}, (0.3048, 1e3 * LB, 1e3 * LB * 9.80665)),
        (USER | {"g": 32.17404855643044}, (0.3048, LB, LB * 9.80665)),
        (user("mm", "kg", "te"), (1e-3, 1e-3, 9.80665)),
        (user("m", "te", "kN") | {"TimeUnits": "s", "g": 9.80665}, (1.0, 1.0, 1.0)),
    ],
)
def test_files_of_later_versions_in_any_units(model, tmp_path, general, units):
    """From 11.0 to 11.4 the centre of gravity is CentreOfMass."""
    expected = read(write(tmp_path / "si.yml", model))
    found = read(write(tmp_path / "other.yml", in_units(model, general, *units)))
    for name in (
        *("added_mass", "added_mass_infinite", "radiation_damping", "excitation", "mean_drift"),
        *("hydrostatic_stiffness", "inertia_matrix", "volume", "centre_of_gravity"),
        *("centre_of_buoyancy", "reference_point", "water_density", "gravity", "frequency"),
    ):
        value = np.asarray(getattr(expected, name))
        error = np.abs(np.asarray(getattr(found, name)) - value).max()
        assert error <= 1e-9 * np.abs(value).max(), name


def test_units_that_are_not_known_and_two_centres_are_refused(model, tmp_path):
    no_mass = {key: unit for key, unit in USER.items() if key != "MassUnits"}
    both = draught_of(model) | {"CentreOfMass": [0, 0, 0]}
    kind = model["VesselTypes"][0] | {"Draughts": [both]}
    for said, change in (
        ("LengthUnits: found furlong, exp", {"General": USER | {"LengthUnits": "furlong"}}),
        ("MassUnits: found nothing, expected an entry", {"General": no_mass}),
        ("TimeUnits: found min, expected one of s", {"General": USER | {"TimeUnits": "min"}}),
        ("found CentreOfMass and CentreOfGravity, expected one", {"VesselTypes": [kind]}),
    ):
        with pytest.raises(InputError, match=said):
            read(write(tmp_path / "barge.yml", model | change))


def test_hydrostatics_do_not_depend_on_phases(barge, model, tmp_path):
    db = read(write(tmp_path / "barge.yml", model))
    for name in ("hydrostatic_stiffness", "inertia_matrix"):
        np.testing.assert_allclose(getattr(db, name), getattr(barge, name), rtol=1e-9, atol=1e2)
    assert db.volume[0] == pytest.approx(barge.volume[0])


@pytest.mark.filterwarnings("ignore:.*kernel truncation")
@pytest.mark.filterwarnings("ignore:.*size of the heave load")
def test_passes_the_checks_of_physics(model, tmp_path):
    load(write(tmp_path / "barge.yml", model))


def test_a_real_file_lifts_a_barge_in_long_waves(model, tmp_path):
    """Numbers at 40 s that OrcaFlex 11.0 saved of a diffraction result for a barge of 100 x 30 m,
    4 m deep in 100 m of water. Its waves are 1200 m long: kL/2 = 0.26 and kT = 0.02 take 1/6 of the
    square of the first and the second off the heave load, 4 per cent, where added mass takes more;
    towards 345 degrees they push it to starboard."""
    drag = draught_of(model)["FrequencyDependentAddedMassAndDamping"][0]
    centre = ["2.53", "0", "-1.974"]
    ahead = ("0", "328.15900265121195 270.0014 0 0", "27.980206114700053e3", "0 0")
    oblique = (
        *("345", "317.0370832911547 270.0014 106.821434537249 90.0035635611914"),
        *("27.984570519054476e3", "1437.6545864352545 270.0035621645656"),
    )
    loads = [real_direction(*direction) for direction in (ahead, oblique)]
    own = draught_of(model) | {
        "Mass": "1",
        "CentreOfGravity": centre,
        "LoadRAOs": {"RAOOrigin": centre, "PhaseOrigin": centre, "RAOs": loads},
        "WaveDrift": {"RAOOrigin": ["0", "0", "0"], "RAOs": []},
        "ReferenceOrigin": centre,
        "ReferenceOriginDatumPosition": ["0", "0", "0"],
        "DisplacedVolume": "12e3",
        "CentreOfBuoyancy": ["2.53", "0", "-3.974"],
        "HydrostaticStiffnessz, HydrostaticStiffnessRx, HydrostaticStiffnessRy": [
            ["30.155448749999992e3", "0", "0"],
            ["0", "2.0179021121874996e6", "0"],
            ["0", "0", "24.87824521875e6"],
        ],
        "FrequencyDependentAddedMassAndDamping": [drag | {"AMDPeriodOrFrequency": "40"}],
    }
    kind = model["VesselTypes"][0] | {"Symmetry": "xz and yz planes", "Draughts": [own]}
    water = {"Environment": {"Density": "1.025", "WaterDepth": "100"}}
    db = read(write(tmp_path / "barge.yml", model | water | {"VesselTypes": [kind]}))
    np.testing.assert_allclose(np.degrees(db.heading), [0, 345])
    assert db.hydrostatic_stiffness[2, 2] == pytest.approx(1025 * 9.80665 * 3000, rel=1e-6)
    np.testing.assert_allclose(db.reference_point, [[2.53, 0, 0]], atol=1e-12)
    np.testing.assert_allclose(db.centre_of_buoyancy, [[2.53, 0, -2]], atol=1e-12)
    k = wavenumber(2 * np.pi / 40, 100.0, 9.80665)
    load = db.excitation[0] * np.exp(1j * k * 2.53 * np.cos(db.heading))[:, None]
    np.testing.assert_allclose(load[:, 2], db.hydrostatic_stiffness[2, 2], rtol=0.08)
    along = load[:, 0] * np.cos(db.heading) + load[:, 1] * np.sin(db.heading)
    np.testing.assert_allclose(np.angle(along), np.pi / 2, atol=1e-3)
    assert load[1, 1].imag < 0


def real_direction(heading: str, horizontal: str, heave: str, roll: str) -> dict[str, Any]:
    """The columns of surge to roll at 40 s."""
    key = ", ".join(["RAOPeriodOrFrequency", *COLUMNS[:8]])
    row = ["40", *horizontal.split(), heave, "359.4952", *roll.split()]
    return {"RAODirection": heading, key: [row]}


def test_phase_by_hand(model, tmp_path):
    """A load of 2 kN that lags the crest at the hull by 30 degrees, in a wave of 10 s that travels
    along x: at the origin, 30 m behind, the crest is earlier by k x = 0.04026 x 30 rad."""
    draught = draught_of(model)
    raos = {
        "RAODirection": "0",
        "RAOPeriodOrFrequency, RAOSurgeAmp, RAOSurgePhase": [["10", "2", "30"]],
    }
    origin = {"RAOOrigin": CENTRE.tolist(), "PhaseOrigin": ["~", "~", "~"], "RAOs": [raos]}
    drag = draught["FrequencyDependentAddedMassAndDamping"][0] | {"AMDPeriodOrFrequency": "10"}
    own = draught | {
        "LoadRAOs": origin,
        "WaveDrift": {"RAOs": []},
        "FrequencyDependentAddedMassAndDamping": [drag],
    }
    other = model | {"VesselTypes": [model["VesselTypes"][0] | {"Draughts": [own]}]}
    db = read(write(tmp_path / "barge.yml", other))
    load = db.excitation[0, 0, 0]
    assert abs(load) == pytest.approx(2000.0)
    assert np.angle(load) == pytest.approx(-np.radians(30) - 0.040257 * 30, abs=1e-4)


def test_quadratic_transfer_functions(barge, model, tmp_path):
    """Half of the pairs, 20 kN/m^2 that lag by 40 degrees with phases at the hull."""
    periods = [10.0, 12.0]
    pairs = [(p, q) for p in periods for q in periods if p <= q]
    table = [[p, q, 0.0, 0.0, 20.0, 40.0, *[0.0] * 10] for p, q in pairs]
    key = ", ".join([*pair_columns(), *COLUMNS])
    rao = {"RAOOrigin": CENTRE.tolist(), "PhaseOrigin": ["~", "~", "~"], key: table}
    own = draught_of(model) | {"WaveDrift": rao, "SumFrequencyQTFs": rao}
    other = model | {"VesselTypes": [model["VesselTypes"][0] | {"Draughts": [own]}]}
    db = read(write(tmp_path / "barge.yml", other))
    np.testing.assert_allclose(db.qtf_frequency, 2 * np.pi / np.array(periods[::-1]))
    k = db.qtf_frequency**2 / 9.80665
    value = 20e3 * np.exp(-1j * np.radians(40))
    difference, total = db.qtf_difference[0, ..., 0], db.qtf_sum[0, ..., 0]
    assert difference[1, 0] == pytest.approx(value * np.exp(-1j * (k[1] - k[0]) * 30))
    assert difference[0, 1] == pytest.approx(np.conj(difference[1, 0]))
    assert total[1, 0] == pytest.approx(value * np.exp(-1j * (k[1] + k[0]) * 30))
    assert total[0, 1] == total[1, 0]
    for old, new in (("RAOYawPhase", "RAOYawLag"), ("RAODirection1", "Heading1")):
        own["SumFrequencyQTFs"] = {k: v for k, v in rao.items() if k != key}
        own["SumFrequencyQTFs"][key.replace(old, new)] = table
        with pytest.raises(InputError, match=rf"SumFrequencyQTFs.*{new}"):
            read(write(tmp_path / "barge.yml", other))
    own["SumFrequencyQTFs"] = rao | {key: table[:1]}
    with pytest.raises(InputError, match="have other waves"):
        read(write(tmp_path / "barge.yml", other))


def test_messages_name_the_key(model, tmp_path):
    path = tmp_path / "barge.yml"
    kind = model["VesselTypes"][0]
    with pytest.raises(InputError, match=r"General\.UnitsSystem: found cgs, expected one of SI"):
        read(write(path, model | {"General": {"UnitsSystem": "cgs"}}))
    with pytest.raises(InputError, match=r"RAOWaveUnit: found steepness, expected one of amp"):
        read(write(path, model | {"VesselTypes": [kind | {"RAOWaveUnit": "steepness"}]}))
    with pytest.raises(InputError, match=r"draughts with load RAOs: .* and .*, expected one"):
        read(write(path, model | {"VesselTypes": [kind, kind]}))
    with pytest.raises(InputError, match=r"no draught with load RAOs, .* a .drive. prescribes"):
        read(write(path, model | {"VesselTypes": [kind | {"Draughts": []}]}))
    draught = draught_of(model) | {"ReferenceOrigin": [0, "x", 0]}
    said = r'line (\d+): VesselTypes\[0\]\.Draughts\[0\]\.ReferenceOrigin: found "x", expected'
    with pytest.raises(InputError, match=said) as caught:
        read(write(path, model | {"VesselTypes": [kind | {"Draughts": [draught]}]}))
    line = int(re.findall(said, str(caught.value))[0])
    assert "ReferenceOrigin:" in path.read_text().splitlines()[line - 1]
    path.write_text("General:\n  UnitsSystem: SI\n :\n")
    with pytest.raises(InputError, match=r"line 3: .*expected YAML"):
        read(path)


@pytest.mark.slow
def test_damaged_files_are_refused(model, tmp_path):
    path = write(tmp_path / "barge.yml", model)
    assert 50 < damaged.refused(orcaflex.read, path, path.read_bytes(), "barge.yml")


@pytest.mark.parametrize("text", ["[" * 100_000 + "]" * 100_000, "\n  " + "- " * 100_000 + "1"])
def test_lists_too_deep_in_each_other_are_refused(tmp_path, text):
    path = tmp_path / "barge.yml"
    path.write_text(f"General:\n  UnitsSystem: SI\nVesselTypes: {text}\n")
    said = (
        r"line [34]: (found more than 40 nested lists|exceeded maximum nesting)"  # ours or PyYAML's
    )
    with pytest.raises(InputError, match=said):
        read(path)


def test_one_of_several_draughts_is_chosen_by_name(model, tmp_path):
    kind = model["VesselTypes"][0]
    deep = draught_of(model) | {"Name": "Ballast", "DisplacedVolume": 17.0}
    both = kind | {"Name": "Barge", "Draughts": [*kind["Draughts"], deep]}
    path = write(tmp_path / "barge.yml", model | {"VesselTypes": [both]})
    with pytest.raises(InputError, match="'Barge, Ballast', expected one: choose it by its name"):
        read(path)
    assert read(path, Given(draught="Barge, Ballast")).volume == pytest.approx([17.0])
    with pytest.raises(InputError, match="expected one"):
        read(path, Given(draught="Barge, Light"))


@pytest.mark.parametrize("keys", ["LoadRAOs.RAOs", "ReferenceOrigin", "AMDMethod", "Name"])
def test_aliases_of_aliases_are_refused_at_once(model, tmp_path, keys):
    """Nine levels of nine, 4e8 values if they were written out."""
    bomb: Any = "1"
    for _ in range(9):
        bomb = [bomb] * 9
    changed = copy.deepcopy(model)
    place = draught_of(changed)
    *above, last = keys.split(".")
    for key in above:
        place = place[key]
    place[last] = bomb
    path = write(tmp_path / "barge.yml", changed)
    started = process_time()
    found = damaged.message(read, path)
    assert process_time() - started < 5.0
    assert found is None or len(found) < 500
    assert found is not None or keys == "Name"
