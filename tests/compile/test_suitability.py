"""Sets of other programs as they are: a scene asks for what it uses, in one message with cure."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray
from scenes import ROOT

import hydrosim as hs
from hydrosim.compile.compile import compile_scene
from hydrosim.database import HydroDatabase, load, netcdf
from hydrosim.database.readers import wamit
from hydrosim.errors import InputError
from hydrosim.linear.linearise import linearise

CASE = """
title: Two barges side by side
duration: 5 s
environment:
  {{water_depth: infinite, water_density: 1000 kg/m^3, gravity: 9.81 m/s^2, waves: {{
    spectrum: regular, amplitude: 1 m, period: 9 s, heading: 30 deg}}}}
bodies:
  port: &barge
    hydrodynamics: {{{hydrodynamics}}}
    mass: 1200 tonne
    centre_of_gravity: [0 m, 7 m, 0 m]
    radii_of_gyration: [3.5 m, 10.4 m, 10.4 m]
    dofs: [{dofs}]
    radiation: convolution
  starboard: {{<<: *barge, database_body: 2, centre_of_gravity: [0 m, -7 m, 0 m]}}
"""


@pytest.fixture(scope="module")
def two() -> HydroDatabase:
    """Two barges in fresh water, without what sets of other programs often lack."""
    db = load(ROOT / "hydro_db" / "two_barges.nc")
    names = ("added_mass", "radiation_damping", "excitation", "hydrostatic_stiffness")
    fresh = {name: getattr(db, name) / 1.025 for name in names}
    lacking = dict.fromkeys(("volume", "centre_of_gravity", "centre_of_buoyancy", "mean_drift"))
    return replace(db, **fresh, **lacking, water_density=1000.0, attributes={})


@pytest.fixture(scope="module")
def noisy(two) -> HydroDatabase:
    """With noise in sway and roll, as coarse panels leave it."""
    random = np.random.default_rng(5)
    sideways = np.isin(np.arange(12) % 6, (1, 3))
    changed = {}
    for name in ("added_mass", "radiation_damping"):
        matrix = getattr(two, name)
        largest = np.abs(np.diagonal(matrix, axis1=1, axis2=2)).max(axis=0)
        size = 0.2 * np.sqrt(np.outer(largest, largest)) * np.outer(sideways, sideways)
        changed[name] = matrix + size * np.triu(random.uniform(-1.0, 1.0, matrix.shape), 1)
    return replace(two, **changed)


@pytest.fixture
def wamit_set(noisy, tmp_path) -> Path:
    """Numbers alone: no density, no reference points, no volumes."""
    wamit.write(noisy, tmp_path / "two")
    (tmp_path / "two.mmx").unlink(missing_ok=True)
    return tmp_path / "two.1"


@pytest.fixture
def capytaine_set(noisy, tmp_path) -> Path:
    """As version 2 writes it for several bodies: without points and volumes."""
    names = [f"{body}__{dof}" for body in ("port", "starboard") for dof in hs.dofs.DOFS]
    matrix = ("influenced_dof", "radiating_dof")
    load = np.stack([noisy.excitation.real, -noisy.excitation.imag])
    xarray.Dataset(
        {
            "added_mass": (("omega", *matrix), noisy.added_mass),
            "radiation_damping": (("omega", *matrix), noisy.radiation_damping),
            "hydrostatic_stiffness": (matrix, noisy.hydrostatic_stiffness),
            "excitation_force": (("complex", "omega", "wave_direction", "influenced_dof"), load),
        },
        coords={
            "omega": noisy.frequency,
            "wave_direction": noisy.heading,
            "influenced_dof": names,
            "radiating_dof": names,
            "complex": ["re", "im"],
            "rho": 1000.0,
            "g": 9.81,
            "water_depth": np.inf,
        },
    ).to_netcdf(tmp_path / "two.nc")
    return tmp_path / "two.nc"


def scene_of(hydrodynamics: str, folder: Path, dofs: str = "heave") -> hs.Scene:
    path = folder / "case.yaml"
    path.write_text(CASE.format(hydrodynamics=hydrodynamics, dofs=dofs))
    return hs.load_case(path).scene()


@pytest.mark.slow
def test_sets_with_gaps_and_noise_run_in_heave(two, wamit_set, capytaine_set) -> None:
    """As the database without noise and gaps does, within the digits of the tables."""
    folder = wamit_set.parent
    known = "file: two.1, density: 1000 kg/m^3, gravity: 9.81 m/s^2"
    own = scene_of(known, folder)
    centres = np.array([[0.0, 7.0, 0.0], [0.0, -7.0, 0.0]])
    whole = replace(two, volume=np.full(2, 1200.0), centre_of_gravity=centres)
    bodies = tuple(replace(body, hydrodynamics=whole) for body in own.bodies)
    expected = hs.simulate(replace(own, bodies=bodies)).position
    largest = float(np.abs(expected).max())
    for hydrodynamics in (known, "file: two.nc"):
        found = hs.simulate(scene_of(hydrodynamics, folder)).position
        np.testing.assert_allclose(found, expected, atol=1e-5 * largest)


def test_a_density_that_nobody_says_is_asked_for(wamit_set) -> None:
    said = r"1025, which is assumed(.|\n)*9\.7\.(.|\n)*density: 1000}"
    with pytest.raises(InputError, match=said):
        compile_scene(scene_of("file: two.1, gravity: 9.7", wamit_set.parent))


def test_one_message_has_one_remedy_for_all_gaps(capytaine_set) -> None:
    """What it proposes is right here, but for the noise, which is taken away."""
    with pytest.raises(InputError) as caught:
        compile_scene(scene_of("file: two.nc", capytaine_set.parent, "sway, heave, roll"))
    text = str(caught.value)
    remedy = re.search(r"hydrodynamics: \{file: ..., (.*), accept: \[(.*)\]\}", text)
    assert remedy is not None
    keys, findings = remedy.groups()
    names = [word.split(":")[0] for word in re.findall(r"\w+:", keys)]
    assert names == ["reference_point", "centre_of_gravity", "volume"]
    assert findings == "symmetry of added mass, symmetry of radiation damping"
    for way in (f"accept: [{findings}]", "symmetrise: true"):
        hydrodynamics = f"file: two.nc, {keys}, {way}"
        compile_scene(scene_of(hydrodynamics, capytaine_set.parent, "sway, heave, roll"))


def test_volumes_that_are_proposed_are_of_the_water_that_is_proposed(wamit_set) -> None:
    """1200 t in water of 1000 kg/m^3, and not in that of 1025 kg/m^3 which was assumed."""
    with pytest.raises(InputError, match=r"density: 1000,.* volume: \[1200\.0, 1200\.0\]"):
        compile_scene(scene_of("file: two.1", wamit_set.parent, "roll"))


def test_points_that_nobody_says_are_warned_of_where_a_body_turns(wamit_set) -> None:
    known = "file: two.1, density: 1000, gravity: 9.81, symmetrise: true, volume: [1200, 1200]"
    points = "[[0, 7, 0], [0, -7, 0]]"
    for given, says in (("", True), (f", reference_point: {points}", False)):
        hydrodynamics = f"{known}, centre_of_gravity: {points}{given}"
        notes = compile_scene(scene_of(hydrodynamics, wamit_set.parent, "heave, yaw")).notes
        assert any("the origin was assumed" in text for text in notes.warnings) == says


def test_what_the_file_says_is_not_given_otherwise(capytaine_set) -> None:
    scene = scene_of("file: two.nc, density: 1025 kg/m^3", capytaine_set.parent)
    with pytest.raises(InputError, match=r"hydrodynamics\.density: found 1025.*Leave the key out"):
        compile_scene(scene)


def test_points_of_one_body_and_of_several_are_read_alike(tmp_path) -> None:
    (tmp_path / "two.1").touch()
    one, several = (
        scene_of(f"file: two.1, reference_point: {points}", tmp_path).bodies[0].hydrodynamics
        for points in ("[1 m, 2 m, -30 cm]", "[[1, 2, -0.3], [4, 5, 6]]")
    )
    assert one.reference_point == (1.0, 2.0, -0.3)
    assert several.reference_point == (1.0, 2.0, -0.3, 4.0, 5.0, 6.0)


SPAR = """
title: A deep hull
duration: 5 s
environment: {{water_depth: infinite, water_density: 1000 kg/m^3, gravity: 9.81 m/s^2}}
bodies:
  spar:
    hydrodynamics: {{file: spar.nc{keys}}}
    mass: 1200 tonne
    centre_of_gravity: [0 m, 0 m, {height} m]
    radii_of_gyration: [20 m, 20 m, 10 m]
    dofs: [heave, roll]
    weight: {weight}
    radiation: {{model: constant, period: 12 s}}
"""


@pytest.fixture(scope="module")
def weightless(two) -> HydroDatabase:
    """A stiffness of buoyancy alone, (I - V d) rho g, with a long lever, as OpenFAST has it."""
    own = slice(0, 6)
    absent = ("added_mass_zero", "added_mass_infinite", "froude_krylov")
    unknown = ("inertia_matrix", "drift_imbalance", "mean_drift_held")
    return replace(
        two,
        added_mass=two.added_mass[:, own, own],
        radiation_damping=two.radiation_damping[:, own, own],
        excitation=two.excitation[..., own],
        hydrostatic_stiffness=np.diag([0.0, 0.0, 1e6, -2e7, -2e7, 0.0]),
        reference_point=np.zeros((1, 3)),
        **dict.fromkeys(absent + unknown),
    )


def spar_of(
    db: HydroDatabase, folder: Path, keys: str = "", weight: str = "balanced", height: float = -8.0
) -> hs.Scene:
    netcdf.write(db, folder / "spar.nc")
    path = folder / "case.yaml"
    path.write_text(SPAR.format(keys=keys, weight=weight, height=height))
    return hs.load_case(path).scene()


def test_a_stiffness_without_weight_asks_for_a_centre_at_the_waterline(weightless, tmp_path):
    """With the proposed keys roll is stiff by -2e7 N m + m g 8 m."""
    with pytest.raises(InputError) as caught:
        compile_scene(spar_of(weightless, tmp_path))
    text = str(caught.value)
    assert "negative, so it was made without weight" in text
    assert "[0.0, 0.0, -8.0], if the weight is in the stiffness" in text
    keys = re.search(r"hydrodynamics: \{file: \.\.\.(, .*)\}`", text)
    assert keys is not None
    assert keys.group(1) == ", centre_of_gravity: [0.0, 0.0, 0.0], volume: 1200.0"
    model = compile_scene(spar_of(weightless, tmp_path, keys.group(1)))
    found = linearise(model.model, model.state).dynamic_stiffness(0.0).real
    assert found[1, 1] == pytest.approx(-2e7 + 1.2e6 * 9.81 * 8.0, rel=1e-9)


def test_a_centre_that_could_be_either_is_left_to_the_user(weightless, tmp_path) -> None:
    """A wide hull is stiff with and without its weight."""
    wide = replace(weightless, hydrostatic_stiffness=np.diag([0.0, 0.0, 1e6, 3e7, 3e7, 0.0]))
    with pytest.raises(InputError, match=r"centre_of_gravity: \[\?, \?, \?\], volume: 1200\.0\}"):
        compile_scene(spar_of(wide, tmp_path))
    with pytest.raises(InputError, match=r"centre_of_gravity: \[0\.0, 0\.0, 0\.0\], volume"):
        compile_scene(spar_of(wide, tmp_path, height=0.0))


def test_the_volume_of_a_body_that_carries_its_weight_is_asked_for(weightless, tmp_path) -> None:
    with pytest.raises(InputError, match=r"volume: \?\}") as caught:
        compile_scene(spar_of(weightless, tmp_path, weight="carried"))
    said = "The weight of spar is carried, not balanced, so the volume does not"
    assert said in str(caught.value)
