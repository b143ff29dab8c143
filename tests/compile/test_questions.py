"""What is asked of scenes that are possible and hardly meant; nothing is asked of others."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scenes
from markers import few
from scenes import Acting, Stops, joint_of
from scipy.spatial import ConvexHull

import hydrosim as hs
from hydrosim.analysis.response import responder
from hydrosim.case import load_case
from hydrosim.compile.compile import compile_scene
from hydrosim.compile.questions import QUESTIONS
from hydrosim.compile.questions.query import extents, text_beyond
from hydrosim.compile.questions.waters import mode_period, surface_width
from hydrosim.database import HydroDatabase, load
from hydrosim.elements import Harmonic, StreamLoad, constant
from hydrosim.errors import InputError
from hydrosim.scene import (
    Box,
    FreeSurface,
    Hull,
    LinearScenes,
    Question,
    TankMesh,
    TankTable,
    Weight,
)

ROOT = Path(__file__).parents[2]
CASES = sorted((ROOT / "cases").glob("*/*.yaml"))
FREE = hs.Frictionless()


def warnings(scene: hs.Scene) -> list[str]:
    return [text for text in compile_scene(scene).notes.warnings if "accept: [" in text]


def afloat(**changes: object) -> hs.Scene:
    """The moored barge of the base case in calm water, its body changed."""
    return scenes.with_body(scenes.in_waves(scenes.scene_of("free_floating")), **changes)


def in_sea(spectrum: hs.Jonswap | hs.RegularWave, **train: float) -> hs.Scene:
    """The barge in another sea."""
    (waves,) = scenes.scene_of("free_floating").environment.waves
    return scenes.in_waves(afloat(), replace(waves, spectrum=spectrum, **train))  # type: ignore[arg-type]


def around(**changes: object) -> hs.Scene:
    """The barge in another environment."""
    scene = afloat()
    return replace(scene, environment=replace(scene.environment, **changes))  # type: ignore[arg-type]


def in_brine() -> hs.Scene:
    """The barge in another liquid, which its database was made for."""
    scene = around(water_density=1200.0)
    database = scene.bodies[0].hydrodynamics
    assert isinstance(database, HydroDatabase)
    return scenes.with_body(scene, hydrodynamics=replace(database, water_density=1200.0))


def with_force(element: object, name: str = "it") -> hs.Scene:
    scene = afloat()
    return replace(scene, forces={**scene.forces, name: element})  # type: ignore[dict-item]


def dry(forces: dict[str, object], **changes: object) -> hs.Scene:
    return hs.Scene("dry", 1.0, (scenes.block(1e4, **changes),), forces=forces)  # type: ignore[arg-type]


def on_pad(z: float, plane: hs.Plane, law: scenes.Law = FREE, **changes: object) -> hs.Scene:
    """The block with a fender at ``z`` [m]."""
    return dry({"f": scenes.on_floor(1e5, law, [[0, 0, z]], plane)}, **changes)


def with_ratio(ratio: float) -> hs.LinearMooring:
    stiffness = np.diag([1e6, 0.0, 0.0, 0.0, 0.0, 0.0])
    return hs.LinearMooring("barge", stiffness, damping_ratio=np.array([ratio, 0, 0, 0, 0, 0]))


def stiff(k: float) -> hs.LinearMooring:
    return scenes.mooring("barge", surge=k)


def line(length: float) -> hs.Spring:
    table = np.array([0.0, 1.0])
    return hs.Spring(
        "block", (0, 0, 0), (10.0, 0, 0), length, curve=hs.TensionCurve(table, 1000.0 * table)
    )


def lifted(force: float) -> hs.AppliedForce:
    return scenes.central_force("barge", heave=constant(force))


def alongside(
    side: float, stiffness: float = 1e8, thickness: float = 0.5, **changes: float
) -> hs.Scene:
    """The barge, 57 m broad, at a quay, with two fenders ``side`` [m] from its middle."""
    points = np.array([[60.0, side, 6.0], [-60.0, side, 6.0]])
    quay = hs.Plane((0.0, side + thickness, 0.0), (0.0, -1.0, 0.0))
    curve = scenes.straight_curve(stiffness)
    return with_force(hs.Fender("barge", points, quay, curve, FREE))


def two_boxes(apart: float, heading: float = 0.0) -> hs.Scene:
    """Two boxes of 100 m by 20 m, abeam of each other with that much water between."""
    scene = in_sea(hs.Jonswap(1.0, 9.0))
    mass = 1025.0 * 100.0 * 20.0 * 5.0
    box = hs.Body("a", mass, mass * np.diag([49.0, 676.0, 676.0]), ROOT / "hydro_db" / "box.nc")
    other = replace(box, name="b", location=(0.0, 20.0 + apart), heading=heading)
    return replace(scene, bodies=(box, other), forces={})


def filled(level: float, heading: float, breadth: float = 54.0, **more: object) -> hs.Scene:
    """The barge with a tank across it, in a sea of 12 s."""
    tank = hs.Tank("mid", Box((-50, -breadth / 2, -12), (50, breadth / 2, 2)), level, **more)  # type: ignore[arg-type]
    scene = in_sea(hs.RegularWave(1.0, 12.0), heading=heading)
    return scenes.with_body(scene, tanks=(tank,), weight=Weight.CARRIED)


def pressed_through(capacity: float) -> hs.Scene:
    """The block on a line that pulls it with 1 kN at the start."""
    return dry({"l": replace(line(9.0), capacity=capacity)})


def hinged(axis: tuple[float, ...], point: tuple[float, ...] = (0.0, 0.0, -1.0)) -> hs.Scene:
    """The block on a hinge about y to the earth, with a torsion spring about another axis."""
    spring = hs.TorsionSpring(
        "block", curve=hs.TorsionCurve(np.array([0.0, 1.0]), np.array([0.0, 10000.0])), axis=axis
    )
    hinge = hs.Hinge("block", point=point, axis=(0.0, 1.0, 0.0))
    return replace(dry({"s": spring}), joints={"hinge": hinge})


def with_mesh(aside: float) -> hs.Scene:
    """The block with a box of 4 m as its hull, this far [m] aside of its centre of gravity."""
    triangles = box_triangles(Box((-2.0, -2.0, -2.0), (2.0, 2.0, 2.0)))
    first, second, third = triangles.swapaxes(0, 1)
    normals = np.cross(second - first, third - first)
    inward = (normals * triangles.mean(axis=1)).sum(axis=1) < 0.0
    triangles[inward] = triangles[inward][:, ::-1]
    return dry({}, hydrostatics=Hull(triangles + np.array([aside, 0, 0])), weight=Weight.CARRIED)


def box_triangles(box: Box) -> np.ndarray:
    """The twelve triangles of a box."""
    cloud = np.array(np.meshgrid(*zip(box.low, box.high, strict=True))).reshape(3, -1).T
    return cloud[ConvexHull(cloud).simplices]


def coarse_steps() -> hs.Scene:
    scene = scenes.scene_of("free_floating")
    solver = replace(scene.solver, step=1.0, linear=LinearScenes.STEP)
    return replace(scene, solver=solver).with_output(step=1.0)


HEADINGS = np.radians([0.0, 90.0, 180.0, 270.0])
DRAG = np.array([1e5, 0.0, -1e5, 0.0])
THIN = 1e4 * np.diag([1.0, 1.0, 3.0])
BELOW = hs.Plane((0.0, 0.0, -1.0), (0.0, 0.0, 1.0))
REVERSED = hs.Plane((0.0, 0.0, -1.0), (0.0, 0.0, -1.0))
FAR = hs.Plane((0.0, 0.0, -10.0), (0.0, 0.0, 1.0))
ODD = {
    Question.ANGLES: (in_sea(hs.Jonswap(1.5, 8.0), heading=45.0), "2578.3 deg"),
    Question.SPEED: (dry({}, velocity=scenes.moving(surge=50.0)), "50 m/s"),
    Question.OVERLAP: (on_pad(-4.0, BELOW), "that point 1 is 3.0 m behind"),
    Question.PLANE: (on_pad(-0.9, REVERSED), "which is 1.0 m behind the plane"),
    Question.LINES: (dry({"l": line(5.0)}), "5 m further"),
    Question.FALL: (
        on_pad(-0.9, FAR, weight=Weight.CARRIED),
        "a gap of 9.1 m between block and all",
    ),
    Question.POINTS: (alongside(20.0), "point 1 inside the hull of barge"),
    Question.MASS: (
        afloat(mass=1.4e8),
        "a displaced mass of 1.568e+08 kg in its database. Weight and buoyancy are assumed to"
        " balance. If lines or contacts carry the difference, write `weight: carried`",
    ),
    Question.INERTIA: (dry({}, inertia=THIN), "principal moments"),
    Question.TRIM: (afloat(centre_of_gravity=(5.0, 0.0, -4.9)), "a pitch of 0.59 deg"),
    Question.STABILITY: (afloat(centre_of_gravity=(0.0, 0.0, 40.0)), "metacentric height of -"),
    Question.PERIODS: (with_force(stiff(1e11)), "natural period of 0.2"),
    Question.LIFT: (with_force(lifted(1e9)), "lift by 65% of the weight"),
    Question.SOFTNESS: (alongside(28.5, 2000.0), "4e+03 N/m in all: 1.57e+08 kg at 0.1 m/s"),
    Question.FRICTION: (on_pad(-0.9, BELOW, hs.Coulomb(20.0, 20.0)), "coefficient of 20"),
    Question.DAMPING: (with_force(with_ratio(20.0)), 'Then it is "20 %"'),
    Question.WATER: (in_brine(), "1200 kg/m^3"),
    Question.STREAMS: (around(current=hs.Stream(1.0)), "1 m/s and no force element that it loads"),
    Question.SHIELDING: (two_boxes(10.0), "10 m apart, with a breadth of 20 m"),
    Question.SLOSHING: (filled(9.0, np.pi / 2), "along y with a period of 12 s at levels of 9 m"),
    Question.WAVES: (in_sea(hs.RegularWave(0.1, 40.0)), "a period of 40 s"),
    Question.STEEPNESS: (in_sea(hs.Jonswap(15.0, 8.0)), "waves break above 0.1"),
    Question.RAMP: (in_sea(hs.Jonswap(1.5, 8.0), ramp=1e5), "never reaches its full height"),
    Question.CAPACITY: (pressed_through(900.0), "900 N, and 1000 N of tension at the start"),
    Question.AXES: (hinged((1.0, 0.0, 0.0)), "an axis at 90 deg to that of hinge"),
    Question.HULL: (with_mesh(34.0), "a hull 32 m aside of the centre of gravity of block"),
    Question.STEP: (coarse_steps(), "a tenth of the waves' period"),
}


BY_OTHER_TESTS = {Question.RANGE, Question.BENDING, Question.FILES}
"""Refusals; what files of other programs say is in tests/case/test_mooring_files.py."""


def test_a_lightship_without_inertia_is_asked_about() -> None:
    """A moment of 1e9 kg m^2, and 2000 t at 30 m from the middle: m y^2 = 1.8e9 kg m^2."""
    wings = tuple(hs.Tank(f"{y}", Box((-1, y - 1, -5), (1, y + 1, 0)), 2.5, 1e5) for y in (-30, 30))
    hulls = (afloat(weight=Weight.CARRIED, inertia=m * np.eye(3), tanks=wings) for m in (1e9, 3e9))
    little, enough = (asked_of(scene, "inertia") for scene in hulls)
    (said,) = little
    assert "bodies.barge.inertia, radii_of_gyration: found a moment of inertia of -8" in said
    assert not enough


@pytest.mark.parametrize("question", ODD)
def test_an_odd_value_is_asked_about_once_and_not_if_it_is_accepted(question: Question) -> None:
    scene, found = ODD[question]
    (text,) = [text for text in warnings(scene) if text.endswith(f"accept: [{question}].")]
    assert found in text
    assert not [text for text in warnings(replace(scene, accept=(question,))) if question in text]


def test_every_question_has_a_function_and_an_example() -> None:
    assert set(QUESTIONS) == set(Question) == {*ODD, *BY_OTHER_TESTS}


@pytest.mark.parametrize("path", few(CASES, 8), ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_nothing_is_asked_of_the_shipped_cases(path: Path) -> None:
    case = load_case(path)
    if case.stages():
        pytest.skip("needs the run of another case first")
    assert warnings(case.scene()) == []


@pytest.mark.parametrize("ratio", [1e-3, 1e3])
def test_a_mass_that_cannot_float_is_refused_unless_accepted(ratio: float) -> None:
    scene = afloat(mass=1.568e8 * ratio, inertia=ratio * afloat().bodies[0].inertia)
    with pytest.raises(InputError, match=r"bodies\.barge\.mass: found .* No body of that mass"):
        compile_scene(scene)
    accepted = replace(scene, accept=(Question.MASS,))
    assert not [text for text in warnings(accepted) if "displaced mass" in text]


def test_a_sea_beyond_the_database_is_refused_unless_accepted() -> None:
    """Short waves that load nothing; not a sea of 5 s with 5 per cent outside."""
    short = in_sea(hs.Jonswap(0.2, 2.5))
    with pytest.raises(InputError, match=r"environment\.waves: found .*accept: \[range\]"):
        compile_scene(short)
    accepted = compile_scene(replace(short, accept=(Question.RANGE,)))
    assert any("of the energy of its loads" in text for text in accepted.notes.skipped)
    usable = compile_scene(in_sea(hs.Jonswap(0.5, 5.0))).notes
    assert any("4.9% of the waves' energy outside" in text for text in usable.skipped)


def test_a_lift_of_more_than_the_weight_is_refused() -> None:
    with pytest.raises(InputError, match="lift by 130% of the weight"):
        compile_scene(with_force(lifted(2e9)))


def test_a_value_close_to_its_limit_differs_from_it_in_the_message() -> None:
    (body,) = scenes.scene_of("free_floating").bodies
    force = 0.503 * body.mass * 9.81
    (text,) = warnings(with_force(lifted(force)))
    assert "lift by 50.3% of the weight; usual is up to 50%" in text
    assert text_beyond(0.1421, 0.142, ".2g") == "0.1421"
    assert text_beyond(3.7, 3.0) == "3.7"
    assert text_beyond(0.65, 0.5, ".0%") == "65%"


def test_a_wrong_mass_is_asked_about_before_a_lift_that_follows_from_it() -> None:
    """The barge in kg, as if they were tonnes: its cargo lifts it by thousands of its weight."""
    light = with_force(lifted(1e9))
    body = replace(light.bodies[0], mass=1.568e5, inertia=1e-3 * light.bodies[0].inertia)
    scene = replace(light, bodies=(body, *light.bodies[1:]))
    with pytest.raises(InputError) as refused:
        compile_scene(scene)
    assert "bodies.barge.mass: found 1.568e+05 kg" in str(refused.value)
    assert "of the weight" not in str(refused.value)
    with pytest.raises(InputError, match="lift by 65011% of the weight"):
        compile_scene(replace(scene, accept=(Question.MASS,)))


def test_an_unknown_question_is_refused_with_the_list(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    path.write_text("{title: t, duration: 1, accept: [heading], bodies: {b: {mass: 1}}}")
    with pytest.raises(InputError, match="accept") as caught:
        load_case(path)
    assert all(question in str(caught.value) for question in Question)


def test_a_question_is_a_warning_of_the_run(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    fender = (
        "{type: fender, body: b, points: [[0, 0, -3]], normal: {stiffness: 1e5},"
        " plane: {point: [0, 0, -1], normal: [0, 0, 1]}, friction: {law: none}}"
    )
    text = "{title: t, duration: 1, bodies: {b: {mass: 1e4, dofs: [heave]}}, forces: {f: %s}}"
    path.write_text(text % fender)
    warning = "forces.f: found that point 1 is 2.0 m behind its plane at the start"
    assert str(hs.simulate(load_case(path)).attrs["warnings"]).count(warning) == 1
    path.write_text((text % fender)[:-1] + ", accept: [overlap]}")
    assert warning not in str(hs.simulate(load_case(path)).attrs.get("warnings", ""))


def asked_of(scene: hs.Scene, question: str) -> list[str]:
    return [text for text in warnings(scene) if text.endswith(f"accept: [{question}].")]


def test_extents_of_a_box_are_its_own() -> None:
    scene = two_boxes(10.0)
    database = compile_scene(scene).derived.databases["a"]
    size = extents(replace(scene.bodies[0], centre_of_gravity=(0.0, 0.0, 0.0)), database)
    assert size is not None
    assert size.half == pytest.approx([50.0, 10.0], rel=1e-6)
    assert (size.filled, size.draught) == pytest.approx((1.0, 5.0), rel=1e-6)


def test_a_centre_of_gravity_is_asked_about_where_the_weight_would_tilt_the_hull() -> None:
    """By m g d over the hydrostatic stiffness; a body that carries its weight does tilt."""
    level = afloat(centre_of_gravity=(2.0, 0.05, -4.9))
    assert not asked_of(level, Question.TRIM)
    (text,) = asked_of(afloat(centre_of_gravity=(0.0, -2.0, -4.9)), Question.TRIM)
    assert f"a roll of {np.degrees(2.0 / 18.82):.2g} deg" in text  # GM of hydro_db/README
    carried = afloat(centre_of_gravity=(5.0, 0.0, -4.9), weight=Weight.CARRIED)
    assert not asked_of(carried, Question.TRIM)


@pytest.mark.parametrize(
    ("side", "found"), [(5.0, "inside"), (28.5, ""), (31.5, ""), (28.5 / 0.3048, "outside")]
)
def test_fenders_belong_at_the_side_of_a_hull(side: float, found: str) -> None:
    texts = asked_of(alongside(side), Question.POINTS)
    assert bool(texts) == bool(found)
    assert all(found in text for text in texts)


def test_fenders_on_deck_are_not_asked_about() -> None:
    """Neither below a topside, nor a stop against the wall of a dry body."""
    points = np.array([[20.0, 5.0, 9.5]])
    above = hs.Plane((0.0, 0.0, 5.5), (0.0, 0.0, -1.0))
    curve = scenes.straight_curve(1e8)
    for plane in (above, hs.Plane((0.0, 6.0, 0.0), (0.0, -1.0, 0.0))):
        scene = with_force(hs.Fender("barge", points, plane, curve, FREE))
        assert not asked_of(scene, Question.POINTS)


def test_many_soft_fenders_are_as_good_as_a_few_stiff_ones() -> None:
    """Half m v^2 = half k x^2: 100 kN/m are pressed by 4 m, 20 of them by 0.9 m."""
    one = alongside(28.5, 5e4)
    assert "by 3.96 m" in asked_of(one, Question.SOFTNESS)[0]
    fender = one.forces["it"]
    many = replace(one, forces={**one.forces, **{f"f{i}": fender for i in range(19)}})
    assert not asked_of(many, Question.SOFTNESS)


def test_a_dry_body_whose_weight_presses_its_fenders_by_metres_is_asked_about() -> None:
    """98.1 kN on 2 kN/m, for 2 MN/m: 49 m; a line that carries it, or enough points, do."""
    soft, firm = (scenes.on_floor(k, FREE, [[0, 0, -1.0]], BELOW) for k in (2e3, 2e6))
    (text,) = asked_of(dry({"f": soft}, weight=Weight.CARRIED), Question.SOFTNESS)
    assert "whose weight of 9.81e+04 N compresses it by 49 m" in text
    for forces in ({"f": soft, "l": line(9.9)}, {"f": firm}):
        assert not asked_of(dry(forces, weight=Weight.CARRIED), Question.SOFTNESS)
    assert not asked_of(dry({"f": soft}), Question.SOFTNESS)


def test_a_body_that_hangs_or_is_held_does_not_fall() -> None:
    fall = on_pad(-0.9, FAR, weight=Weight.CARRIED)
    hanging = replace(fall, forces={**fall.forces, "l": line(9.9)})
    assert not asked_of(hanging, Question.FALL)
    assert not asked_of(on_pad(-0.9, FAR), Question.FALL)


def test_a_run_that_presses_a_fender_by_metres_says_so() -> None:
    """A block of 1e4 kg at 0.5 m/s against 100 N/m: v sqrt(m / k) = 5 m deep."""
    fender = scenes.on_floor(100.0, FREE, [[0, 0, -1.0]], BELOW)
    scene = replace(dry({"f": fender}, velocity=scenes.moving(heave=-0.5)), duration=20.0)
    run = hs.simulate(scene)
    assert "forces.f: point 1 was compressed by 5 m at 15.5 s" in str(run.attrs["warnings"])
    accepted = hs.simulate(replace(scene, accept=(Question.SOFTNESS,)))
    assert "was compressed" not in str(accepted.attrs.get("warnings", ""))


LOADS = [
    (hs.CurrentLoad("barge", (0, 0, 0), HEADINGS, DRAG, DRAG, 0 * DRAG), "current"),
    (hs.QuadraticDamping("barge", np.eye(6)), "current"),
    (hs.LinearDamping("barge", np.eye(6), relative_to_current=True), "current"),
    (hs.WindLoad("barge", (0, 0, 0), HEADINGS, DRAG, DRAG, 0 * DRAG), "wind"),
]


@pytest.mark.parametrize(("load", "stream"), LOADS)
def test_a_stream_is_asked_about_that_no_element_feels(load: StreamLoad, stream: str) -> None:
    bare = around(**{stream: hs.Stream(1.0)})
    assert f"environment.{stream}: found 1 m/s and no force element" in warnings(bare)[0]
    assert not asked_of(replace(bare, forces={**bare.forces, "it": load}), Question.STREAMS)


def test_hulls_with_a_database_each_are_asked_about_if_they_are_near() -> None:
    """A turned one reaches nearer: 50 sin 20 deg + 10 cos 20 deg - 10 = 16.5 m."""
    assert not asked_of(two_boxes(41.0), Question.SHIELDING)
    (text,) = asked_of(two_boxes(41.0, np.radians(20.0)), Question.SHIELDING)
    assert "about 24.5 m apart" in text
    assert not asked_of(scenes.in_waves(two_boxes(10.0)), Question.SHIELDING)


def test_hulls_of_one_database_are_not_asked_about() -> None:
    database = load(ROOT / "hydro_db" / "two_barges.nc")
    scene = in_sea(hs.Jonswap(1.0, 8.0))
    assert database.volume is not None
    assert database.centre_of_gravity is not None
    masses, centres = 1025.0 * database.volume, database.centre_of_gravity
    first, second = (
        hs.Body(name, mass, mass * np.diag([16.0, 200.0, 200.0]), database, tuple(centre))
        for name, mass, centre in zip("ab", masses, centres, strict=True)
    )
    both = replace(scene, bodies=(first, replace(second, database_body=2)), forces={})
    assert not asked_of(both, Question.SHIELDING)


def in_feet(feet: float) -> hs.Scene:
    radii = feet * np.array([0.4 * 57.0, 0.28 * 260.0, 0.28 * 260.0])
    return afloat(inertia=1.56758e8 * np.diag(radii**2))


def in_current(speed: float) -> hs.Scene:
    scene = around(current=hs.Stream(speed))
    return replace(scene, forces={**scene.forces, "d": hs.QuadraticDamping("barge", np.eye(6))})


def hung(mass: float) -> hs.Scene:
    """A block on a slack line of 1 kN."""
    table = np.array([0.0, 1.0])
    rope = hs.Spring(
        "block",
        (0, 0, 0),
        (0, 0, 10.0),
        10.0,
        curve=hs.TensionCurve(table, 100000.0 * table),
        capacity=1000.0,
    )
    return hs.Scene(
        "hangs", 1.0, (scenes.block(mass, weight=Weight.CARRIED),), forces={"rope": rope}
    )


NEAR = (Question.POINTS, Question.CAPACITY, Question.AXES, Question.HULL)


@pytest.mark.parametrize(
    ("question", "scene", "asked"),
    [
        (Question.INERTIA, in_feet(1.0), 0),
        (Question.INERTIA, in_feet(1.0 / 0.3048), 3),
        (Question.STREAMS, in_current(2.4), 0),  # the Gulf Stream is slower than 3 m/s
        (Question.STREAMS, in_current(3.0), 1),
        (Question.SLOSHING, filled(9.0, 0.0), 0),  # 19 s along 100 m, and nothing across
        (Question.SLOSHING, filled(9.0, np.pi / 2, 20.0), 0),  # 5.2 s
        (Question.SLOSHING, filled(13.95, np.pi / 2), 0),  # full
        (Question.SLOSHING, filled(9.0, np.pi / 2, free_surface=FreeSurface.FROZEN), 0),
        (Question.SLOSHING, filled(2.0, np.pi / 2), 0),  # 24 s
        (Question.SLOSHING, filled(9.0, np.pi / 4), 1),
        (Question.CAPACITY, pressed_through(1100.0), 0),
        (Question.CAPACITY, hung(100.0), 0),  # 981 N on a line of 1 kN
        (Question.CAPACITY, hung(110.0), 1),
        (Question.HULL, with_mesh(3.0), 0),
        (Question.AXES, hinged((0.1, 1.0, 0.0)), 0),
        (Question.POINTS, hinged((0.0, 1.0, 0.0), (500.0, 0.0, -1.0)), 1),
        (Question.POINTS, hinged((0.0, 1.0, 0.0), (20.0, 0.0, -1.0)), 0),
    ],
)
def test_what_is_near_its_limit_is_asked_about_beyond_it(question, scene, asked):
    questions = NEAR if question in NEAR else (question,)
    texts = [text for each in questions for text in asked_of(scene, each)]
    assert len(texts) == asked
    if "rope" in scene.forces:
        assert all("hangs from lines of 1e+03 N in all" in text for text in texts)


def test_the_roll_beside_sloshing_is_that_of_the_linear_analysis() -> None:
    """Free surfaces make it slower: 12 s of the hull by itself, 16 s with them."""
    scene = filled(5.0, np.pi / 2)
    waves = replace(scene.environment.waves[0], spectrum=hs.RegularWave(1.0, 15.0))
    scene = scenes.in_waves(scene, waves)
    (text,) = asked_of(scene, Question.SLOSHING)
    (roll,) = (mode for mode in responder(scene).natural_modes() if mode.dof == "roll")
    assert roll.natural_period > 14.0
    assert f"a roll of about {roll.natural_period:.3g} s" in text


def test_levels_of_resonance_are_those_that_a_plan_goes_through() -> None:
    """10 % about 12 s across 54 m are 10.8 to 13.2 s: omega^2 = g k tanh k h, k = pi / b; roll is
    farther away in a scene without it."""
    plan = hs.Plan(np.array([0.0, 10.0]), np.array([12.0, 6.0]))
    scene = scenes.with_body(filled(12.0, np.pi / 2, plan=plan), dofs=("sway",))
    (text,) = asked_of(scene, Question.SLOSHING)
    k = np.pi / 54.0
    levels = [np.arctanh((2 * np.pi / (12 * x)) ** 2 / (9.81 * k)) / k for x in (1 / 0.9, 1 / 1.1)]
    low, high = (float(x) for x in text.split("at levels of ")[1].split(" m (")[0].split(" to "))
    assert low == pytest.approx(max(levels[0], 6.0), abs=0.16)  # a fortieth of 6 m
    assert high == pytest.approx(min(levels[1], 12.0), abs=0.16)


@pytest.mark.parametrize(
    ("depth", "period"),
    [(0.05, 2 * 54.0 / np.sqrt(9.81 * 0.05)), (200.0, 2 * np.pi * np.sqrt(54.0 / (9.81 * np.pi)))],
)
def test_the_lowest_mode_has_the_limits_of_deep_and_of_shallow_water(depth, period) -> None:
    found = mode_period(np.array([54.0]), np.array([depth]), 9.81)
    assert found == pytest.approx(period, rel=1e-5)


def test_a_box_is_as_wide_by_its_table_and_by_its_mesh() -> None:
    box = Box((-50.0, -27.0, -12.0), (50.0, 27.0, 2.0))
    level = np.linspace(0.0, 14.0, 8)
    area = 100.0 * 54.0
    centroid = np.column_stack([0 * level, 0 * level, level / 2 - 12.0])
    second = np.array([area * 100.0**2 / 12.0, 0.0, area * 54.0**2 / 12.0])
    table = TankTable(level, area * level, centroid, np.tile(second, (8, 1)))
    mesh = TankMesh(box_triangles(box))
    for axis, own in ((0, 100.0), (1, 54.0)):
        widths = [surface_width(shape, 9.0, axis) for shape in (box, table, mesh)]
        assert widths == pytest.approx([own] * 3, rel=1e-12)


def test_a_mesh_with_corners_at_the_level_is_as_wide_there() -> None:
    low, high = (box_triangles(Box((-5.0, -2.0, z), (5.0, 2.0, z + 3.0))) for z in (0.0, 3.0))
    mesh = TankMesh(np.concatenate([low, high]))
    assert surface_width(mesh, 3.0, 0) == pytest.approx(10.0, rel=1e-12)


def test_a_fender_without_stiffness_is_soft() -> None:
    assert "by inf m" in asked_of(alongside(28.5, 0.0), Question.SOFTNESS)[0]


def test_struts_of_another_length_are_asked_about() -> None:
    """Longer and shorter by more than a fifth, and beyond their curve; nothing without a spring."""
    points = np.array([-1.0, 1.0])
    ends = {"point": (0, 0, 0), "anchor": (10.0, 0, 0)}
    strut = hs.Strut("block", curve=hs.StrutCurve(points, 1000.0 * points), **ends, length=5.0)
    for other, said in (
        (strut, "5 m longer"),
        (replace(strut, length=13.0), "3 m shorter"),
        (replace(strut, length=9.0), None),
        (replace(strut, curve=hs.StrutCurve(7.0 * points, 1e3 * points)), None),
        (replace(strut, curve=None, damping=1.0), None),
    ):
        texts = asked_of(dry({"s": other}), Question.LINES)
        assert said in str(texts) if said else not texts


def on_hinge(**acting: object) -> hs.Scene:
    motions = (Acting(**acting),)  # type: ignore[arg-type]
    pin = joint_of("hinge", "block", None, *motions, axis=(0.0, 1.0, 0.0))
    return replace(dry({}), joints={"pin": pin})


def test_stops_that_press_at_the_start_are_asked_about() -> None:
    """A block 2 m below its anchor: the way counts from there, and not from rest."""
    keys = {"point": (0.0, 0.0, 0.0), "anchor": (0.0, 0.0, 2.0), "stiffness": 1e6}
    scene = dry({"ends": hs.Stop("block", lowest=2.5, highest=3.5, **keys)})
    (text,) = asked_of(scene, Question.OVERLAP)
    assert text.startswith("forces.ends.lowest: found 2.5 m, while it is at 2 m at the start")
    assert "presses with 5e+05 N" in text
    assert not asked_of(dry({"ends": hs.Stop("block", lowest=1.5, **keys)}), Question.OVERLAP)


@pytest.mark.parametrize(("period", "asked"), [(1.0, 1), (1.1, 0)])
def test_periods_that_records_miss_are_asked_about(period: float, asked: int) -> None:
    """Records every 0.5 s of a sine of 1 s are all alike."""
    push = hs.AppliedForce("block", (0.0, 0.0, 0.0), {"surge": Harmonic(1e3, period)})
    scene = dry({"push": push})
    texts = asked_of(scene.with_output(step=0.5), Question.STEP)
    assert len([text for text in texts if "the period of forces.push" in text]) == asked


def test_starts_of_joints_beyond_their_stops_are_asked_about() -> None:
    ends = Stops(-0.5, 0.5, 1e6)
    (text,) = asked_of(on_hinge(stops=ends, position=1.0), Question.OVERLAP)
    assert "joints.pin: found that pin starts 28.6 deg beyond a stop, at 57.3 deg" in text
    assert not asked_of(on_hinge(stops=ends, position=0.52), Question.OVERLAP)
    assert not asked_of(on_hinge(position=1.0), Question.OVERLAP)


def test_angles_of_joints_in_radians_are_asked_about() -> None:
    assert "20 rad, which is 1145.9 deg" in asked_of(on_hinge(position=20.0), Question.ANGLES)[0]
    assert asked_of(on_hinge(stiffness=1.0, neutral=-20.0), Question.ANGLES)
    assert not asked_of(on_hinge(position=3.0), Question.ANGLES)


def test_rates_of_joints_that_throw_their_body_are_asked_about() -> None:
    far = on_hinge(velocity=20.0)
    away = replace(far.joints["pin"], point=(0.0, 0.0, 1.0))
    (text,) = asked_of(replace(far, joints={"pin": away}), Question.SPEED)
    assert "joints.pin: found a rate that moves" in text
    assert "at 20 m/s" in text
    assert not asked_of(far, Question.SPEED)  # about its centre of gravity


@pytest.mark.parametrize(("damping", "asked"), [(1e3, 1), (1e6, 0), (1e9, 1)])
def test_drag_is_that_of_a_hull_of_this_size(damping: float, asked: int) -> None:
    """Sway of the barge: 0.5 rho L T = 1.6e6 N s^2/m^2, or about that."""
    of = hs.QuadraticDamping("barge", np.diag([0.0, damping, 0.0, 0.0, 0.0, 0.0]))
    told = [text for text in warnings(with_force(of)) if "forces.it.damping.sway" in text]
    assert len(told) == asked


def moored(point: tuple[float, ...], anchor: tuple[float, ...], **changes: Any) -> hs.Scene:
    """The barge in 50 m of water, on a chain of 330 m of 1 kN/m."""
    one = {"length": 330.0, "weight": 1e3, "stiffness": 1e9, "friction": 0.5}
    scene = with_force(scenes.catenary_of("barge", point, anchor, **{**one, **changes}))
    scene = scenes.with_body(scene, hydrodynamics=ROOT / "hydro_db" / "h851_50m.nc")
    return replace(scene, environment=replace(scene.environment, water_depth=50.0))


SIDE, ANCHOR = (80.0, 28.0, -2.0), (200.0, 320.0, -50.0)
ROUTES = [
    (moored(SIDE, ANCHOR), None),
    (moored(SIDE, ANCHOR, friction=None), "a line down to"),
    (moored(SIDE, (200.0, 320.0, -6.0)), "an anchor 44 m above the seabed"),
    (moored((80.0, -28.0, -2.0), ANCHOR), "m under the hull of barge"),
    (moored((80.0, 28.0, -27.0), ANCHOR), "m under the keel of barge"),
    (moored(SIDE, ANCHOR, stiffness=1e6), "an EA of 1e+06 N"),
]


@pytest.mark.parametrize(("scene", "found"), ROUTES)
def test_lines_run_outside_of_bed_and_hull(scene: hs.Scene, found: str | None) -> None:
    told = [text for text in warnings(scene) if "forces.it" in text]
    assert any(found in text for text in told) if found else not told


@pytest.mark.parametrize(
    ("shortest", "longest", "found"),
    [(10.0, 100.0, None), (60.0, 100.0, "The wire starts slack"), (5.0, 20.0, "5 m to 20 m")],
)
def test_drums_hold_the_wire_of_the_start(
    shortest: float, longest: float, found: str | None
) -> None:
    """The ends are 50 m apart, and the wire stretches by 0.1 %."""
    drum = hs.Drum(shortest, longest)
    tug = hs.Winch("block", (0, 0, 0), (50, 0, 0), 1e8, tension=1e5, speed=0.3, drum=drum)
    told = [text for text in warnings(dry({"tug": tug})) if "forces.tug.drum" in text]
    assert any(found in text for text in told) if found else not told


def test_stops_are_asked_about_that_are_pressed_by_a_part_of_their_range() -> None:
    stops = Stops(np.radians(1.0), np.radians(4.0), 1e9)
    (text,) = warnings(on_hinge(stops=stops))

    assert "starts 1 deg beyond a stop, at 0 deg" in text


def test_forces_along_the_water_are_compared_with_the_weight() -> None:
    push = scenes.central_force("barge", sway=constant(-9e9))
    (text,) = [text for text in warnings(with_force(push)) if "accept: [lift]" in text]
    assert "forces.it.force.sway: found 9e+09 N" in text


def test_a_hull_that_starts_above_the_water_is_asked_about() -> None:
    assert any(
        "a heave of 50 m" in text for text in warnings(afloat(position=scenes.moving(heave=50.0)))
    )


def test_a_jointed_hull_of_a_hundred_displacements_is_asked_about() -> None:
    scene = load_case(ROOT / "cases" / "flap" / "decay.yaml").scene()
    (flap,) = scene.bodies
    heavy = replace(flap, mass=250.0 * flap.mass, inertia=250.0 * flap.inertia)
    (text,) = warnings(replace(scene, bodies=(heavy,)))
    assert "bodies.flap.mass: found 4.1e+07 kg" in text


def test_a_dry_body_lighter_than_air_is_asked_about() -> None:
    told = warnings(dry({}, inertia=1e4 * 1600.0**2 * np.eye(3)))
    assert any("usual is above 1.2 kg/m^3" in text for text in told)
    sliding = warnings(dry({}, inertia=1e4 * 1600.0**2 * np.eye(3), dofs=("surge",)))
    assert not any("kg/m^3" in text for text in sliding)
