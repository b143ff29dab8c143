"""Databases are judged by what a scene uses of them, and by what cannot be noise."""

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest
from scenes import ROOT, hull, in_waves, scene_of, with_body

import hydrosim as hs
from hydrosim.compile.compile import compile_scene
from hydrosim.compile.databases import database_warnings
from hydrosim.compile.hydrodynamic_groups import moving
from hydrosim.database import HydroDatabase, Use, body_of, check, doubt_warnings, load
from hydrosim.database.changes import apply_changes
from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.scene import ChangedDatabase, Changes, SecondOrder, Without

ROLL, SWAY, HEAVE = 3, 1, 2
SWELL = hs.Jonswap(significant_height=2.0, peak_period=12.0)
MATRICES = ("added_mass", "radiation_damping")


def noisy(db: HydroDatabase, share: float, *dofs: int) -> HydroDatabase:
    """The database with asymmetric noise in the coupling of those of the degrees of freedom."""
    random = np.random.default_rng(5)
    which = np.isin(np.arange(6 * db.bodies) % 6, dofs)
    changed = {}
    for name in MATRICES:
        matrix = getattr(db, name).copy()
        largest = np.abs(np.diagonal(matrix, axis1=1, axis2=2)).max(axis=0)
        noise = share * np.sqrt(np.outer(largest, largest)) * np.outer(which, which)
        matrix += noise * np.triu(random.uniform(-1.0, 1.0, matrix.shape), 1)
        changed[name] = matrix
    return replace(db, **changed)


def barge(db: HydroDatabase, dofs: tuple[str, ...] = DOFS, **loads: object) -> hs.Scene:
    """The free barge in oblique waves that hardly have energy above 2 rad/s."""
    scene = in_waves(scene_of("free_floating"), hs.WaveTrain(SWELL, heading=0.6))
    wanted = hs.WaveForces(**loads)
    scene = with_body(scene, hydrodynamics=db, dofs=dofs, wave_forces=wanted)
    return replace(scene, duration=10.0)


def pair(db: HydroDatabase, dofs: tuple[str, ...]) -> hs.Scene:
    """Two bodies of one database in a beam sea."""
    base = in_waves(scene_of("free_floating"), hs.WaveTrain(SWELL, heading=np.pi / 2))
    bodies = []
    for k, centre in enumerate(db.centre_of_gravity):
        mass = float(db.water_density * db.volume[k])
        part = {"hydrodynamics": db, "database_body": k + 1, "centre_of_gravity": tuple(centre)}
        waves = {"radiation": "convolution", "wave_forces": hs.WaveForces()}
        body = replace(base.bodies[0], name=f"barge{k + 1}", mass=mass, dofs=dofs)
        bodies.append(replace(body, **part, **waves))
    return replace(base, bodies=tuple(bodies), forces={}, duration=10.0)


@pytest.fixture(scope="module")
def two() -> HydroDatabase:
    return load(ROOT / "hydro_db" / "two_barges.nc")


@pytest.mark.slow
def test_two_bodies_with_noise_in_sway_and_roll_run_in_heave(two) -> None:
    """As they are; in all that moves they are refused, with frequency, pair and size."""
    bad = noisy(two, 0.2, SWAY, ROLL)
    assert {f.name for f in check(bad) if f.is_refused} >= {"symmetry of added mass"}
    run, sound = (hs.simulate(pair(db, ("heave",))) for db in (bad, two))
    assert run.attrs["status"] == "complete"
    np.testing.assert_array_equal(run.position, sound.position)
    with pytest.raises(InputError) as caught:
        compile_scene(pair(bad, ("sway", "roll")))
    line = next(x for x in str(caught.value).splitlines() if "symmetry of added mass" in x)
    assert "rad/s, in body" in line
    assert "(an error of" in line
    assert "accept: [symmetry of added mass" in str(caught.value)


def sunk(db: HydroDatabase, above: float) -> HydroDatabase:
    """The database with negative damping in heave above a frequency [rad/s]."""
    damping = db.radiation_damping.copy()
    damping[db.frequency > above, HEAVE, HEAVE] = -0.5 * damping[:, HEAVE, HEAVE].max()
    return replace(db, radiation_damping=damping)


@pytest.mark.slow
def test_what_is_above_the_frequencies_of_the_waves_is_a_doubt() -> None:
    assert hull().frequency[-1] > 2.2
    bad = sunk(hull(), 2.2)
    with pytest.raises(InputError, match=r"positive damping: found .* at 2\.\d+ rad/s"):
        doubt_warnings(bad, Use())
    compiled = compile_scene(barge(bad, ("heave",)))
    assert any("positive damping" in text for text in compiled.notes.warnings)
    low = bad.radiation_damping.copy()
    low[bad.frequency < 0.9, HEAVE, HEAVE] *= -1.0
    with pytest.raises(InputError, match="positive damping"):
        compile_scene(barge(replace(bad, radiation_damping=low), ("heave",)))


@pytest.mark.slow
def test_loads_of_second_order_that_nobody_asks_for_are_not_judged() -> None:
    bad = replace(hull(), mean_drift=-hull().mean_drift)
    compile_scene(barge(bad))
    with pytest.raises(InputError, match="drift along the waves"):
        compile_scene(barge(bad, second_order=SecondOrder.NEWMAN))


@pytest.mark.slow
def test_wave_loads_refuse_nothing_in_calm_water() -> None:
    """What they prove of the damping is said all the same."""
    base = in_waves(barge(hull()))
    assert not judged_of(base, replace(hull(), excitation=0 * hull().excitation))
    off = replace(hull(), radiation_damping=hull().radiation_damping / 1025.0)
    assert any("damping against loads: found" in text for text in judged_of(base, off))
    with pytest.raises(InputError, match="damping against loads"):
        compile_scene(barge(off))


def judged_of(scene: hs.Scene, db: HydroDatabase) -> tuple[str, ...]:
    """The warnings of a scene with another database."""
    return compile_scene(with_body(scene, hydrodynamics=db)).notes.warnings


@pytest.mark.parametrize("share", [0.0005, 0.002])
def test_moments_of_noise_are_no_wrong_convention(share) -> None:
    """A roll moment in head waves, of a lever that is a small share of the hull's size."""
    db = hull()
    lever = share * np.cbrt(db.volume[0])
    loads = db.excitation.copy()
    loads[..., ROLL] += lever * loads[..., HEAVE]
    found = [finding for finding in check(replace(db, excitation=loads)) if finding.is_refused]
    assert not found
    loads[..., ROLL] *= -1.0
    assert any(finding.is_refused for finding in check(replace(db, excitation=loads)))


def test_a_database_made_in_python_is_checked() -> None:
    with pytest.raises(InputError, match="phase of the horizontal load"):
        compile_scene(barge(replace(hull(), excitation=hull().excitation.conj())))
    with pytest.raises(InputError, match="headings: found"):
        compile_scene(barge(replace(hull(), heading=np.degrees(hull().heading))))


def test_a_density_that_was_only_assumed_is_said_so() -> None:
    scene = barge(replace(hull(), attributes={"assumed": "length 1, water density 1025"}))
    water = replace(scene.environment, water_density=1000.0)
    with pytest.raises(InputError, match=r"(?s)made for 1025, which is assumed.*density: 1000"):
        compile_scene(replace(scene, environment=water))


def test_doubts_are_said_once_and_recorded(two, recwarn) -> None:
    run = hs.simulate(pair(replace(two, attributes={}), ("sway",)))
    assert not [w for w in recwarn if issubclass(w.category, UserWarning)]
    lines = run.attrs["warnings"].splitlines()
    assert sum("frequency spacing" in line for line in lines) == 1
    known = hs.simulate(pair(two, ("sway",)))
    assert "frequency spacing" not in known.attrs.get("warnings", "")
    said = [str(text) for key, text in known.attrs.items() if key.startswith("database_accepted")]
    assert any("frequency spacing" in text for text in said)


@pytest.mark.parametrize(("height", "uses"), [(-4.9, False), (-3.0, True)])
def test_a_body_that_turns_about_another_point_moves_that_of_the_database(height, uses) -> None:
    """Roll about a centre of gravity above it is sway there, too."""
    bad = noisy(hull(), 0.5, SWAY, HEAVE)
    body = replace(barge(bad, ("heave", "roll")).bodies[0], centre_of_gravity=(0.0, 0.0, height))
    refused = pytest.raises(InputError, match=r"symmetry of .* in sway by heave")
    with refused if uses else nullcontext():
        assert not database_warnings(bad, [body], moving([body]), ())


@pytest.mark.parametrize(
    ("changes", "name", "said"),
    [
        ({"accept": ("positive damping",)}, "accepted", "positive damping"),
        ({"frequencies": (0.0, 2.1)}, "changed", "only frequencies 0 to 2.1 rad/s"),
    ],
)
def test_ways_past_a_refusal_are_recorded(changes, name, said) -> None:
    bad = sunk(hull(), 2.2)
    calm = in_waves(barge(bad, ("heave",)))
    with pytest.raises(InputError, match="positive damping"):
        compile_scene(calm)
    run = hs.simulate(with_body(calm, hydrodynamics=ChangedDatabase(bad, **changes)))
    assert run.attrs[f"database_{name}_barge"] == said
    assert (", accepted" in run.attrs.get("warnings", "")) == (name == "accepted")


def test_symmetrising_mends_noise_and_nothing_else(two) -> None:
    mended = apply_changes(noisy(two, 0.2, SWAY, ROLL), Changes(symmetrise=True))
    assert not any(finding.is_refused for finding in check(mended))
    for name in MATRICES:
        matrix = getattr(mended, name)
        np.testing.assert_array_equal(matrix, matrix.swapaxes(1, 2))
    again = apply_changes(hull(), Changes(symmetrise=True))
    np.testing.assert_allclose(again.added_mass, hull().added_mass, atol=1e-3 * 1.6e8)


def test_bodies_apart_are_by_themselves(two) -> None:
    """One alone at another place as in its own database; both as with zero coupling."""
    apart = ChangedDatabase(two, bodies_apart=True)
    own = body_of(two, 1)
    scene = pair(two, ("heave",))
    second = replace(scene.bodies[1], location=(30.0, 5.0))
    found, expected = (
        hs.simulate(replace(scene, bodies=(replace(second, hydrodynamics=db, database_body=k),)))
        for db, k in ((apart, 2), (own, 1))
    )
    np.testing.assert_array_equal(found.position, expected.position)
    both = tuple(replace(body, hydrodynamics=apart) for body in scene.bodies)
    couple = hs.simulate(replace(scene, bodies=both))
    coupled = apply_changes(two, Changes(bodies_apart=True))
    assert not coupled.added_mass[:, :6, 6:].any()
    assert np.abs(couple.position - hs.simulate(scene).position).max() > 1e-3


def test_a_database_without_loads_serves_in_calm_water() -> None:
    """Memory and decay are those with loads; waves are refused, unless they drive nothing."""
    bare = apply_changes(hull(), Changes(without=(Without.LOADS,)))
    calm = with_body(in_waves(barge(hull(), ("heave",))), position=(0, 0, 1.0, 0, 0, 0))
    runs = [hs.simulate(with_body(calm, hydrodynamics=db)) for db in (bare, hull())]
    found, expected = (run.position for run in runs)
    np.testing.assert_array_equal(found, expected)
    with pytest.raises(InputError, match="has no wave loads, and the scene has waves"):
        compile_scene(barge(bare, ("heave",)))
    compile_scene(barge(bare, ("heave",), first_order=False))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (Changes(accept=("symetry of added mass",)), 'expected "symmetry of added mass"'),
        (Changes(frequencies=(5.0, 9.0)), "in which .* has 0 frequencies"),
    ],
)
def test_changes_that_do_not_fit_are_refused(changes, message) -> None:
    with pytest.raises(InputError, match=message):
        apply_changes(hull(), changes)


def test_coefficients_alone_are_a_damped_oscillator(figure) -> None:
    """m + a, b and c in heave, in closed form; they stay as they are about any axis."""
    mass, a, b, c = 1e6, 5e5, 3e4, 8e5
    given = {"added_mass": a, "damping": b, "stiffness": c}
    numbers = {name: value * np.diag(np.eye(6)[HEAVE]) for name, value in given.items()}
    start = (0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    buoy = hs.Coefficients(**numbers)
    body = hs.Body("buoy", mass, mass * np.eye(3), buoy, dofs=("heave",), position=start)
    run = hs.simulate(hs.Scene("decay", 40.0, (body,), output={"step": 0.5}))
    decay, omega = b / (2 * (mass + a)), np.sqrt(c / (mass + a))
    turn = np.sqrt(omega**2 - decay**2)
    t = run.time.values
    exact = np.exp(-decay * t) * (np.cos(turn * t) + decay / turn * np.sin(turn * t))
    error = np.abs(run.position.values[:, 0, HEAVE] - exact).max()
    figure("error", error)
    assert error < 1e-9
    driving = replace(body, hydrodynamics=replace(buoy, damping=-numbers["damping"]))
    with pytest.raises(InputError, match="damping: found a matrix with a negative eigenvalue"):
        compile_scene(hs.Scene("driven", 1.0, (driving,)))


def test_coefficients_of_another_shape_are_named() -> None:
    given = hs.Coefficients(np.zeros((3, 3)), np.zeros((6, 6)), np.zeros((6, 6)))
    body = hs.Body("buoy", 1.0, np.eye(3), hydrodynamics=given)
    with pytest.raises(InputError, match=r"buoy\.hydrodynamics\.added_mass: found an array"):
        compile_scene(hs.Scene("wrong", 1.0, (body,)))
