"""What is asked of scenes that are possible and hardly meant; nothing is asked of others."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dry_scenes import block, moving, on_floor
from markers import few
from moored_barge import scene_of

import hydrosim as hs
from hydrosim.case import load_case
from hydrosim.compiling.compile import compile_scene
from hydrosim.compiling.questions import QUESTIONS
from hydrosim.database import HydroDatabase
from hydrosim.errors import InputError
from hydrosim.forces import (
    AppliedForce,
    Coulomb,
    Frictionless,
    LinearMooring,
    Plane,
    Spring,
    constant,
)
from hydrosim.scene import (
    Box,
    Jonswap,
    LinearScenes,
    Question,
    RegularWave,
    Scene,
    Stream,
    Tank,
    Weight,
)

CASES = sorted((Path(__file__).parents[2] / "cases").glob("*/*.yaml"))


def warnings(scene: Scene) -> list[str]:
    return [text for text in compile_scene(scene).notes.warnings if "accept: [" in text]


def afloat(**changes: object) -> Scene:
    """The moored barge of the base case, its body changed."""
    scene = scene_of("free_floating")
    (body,) = scene.bodies
    return replace(scene, bodies=(replace(body, **changes),))  # type: ignore[arg-type]


def in_sea(spectrum: Jonswap | RegularWave, **train: float) -> Scene:
    """The barge in another sea."""
    scene = afloat()
    waves = (replace(scene.environment.waves[0], spectrum=spectrum, **train),)  # type: ignore[arg-type]
    return replace(scene, environment=replace(scene.environment, waves=waves))


def around(**changes: object) -> Scene:
    """The barge in another environment."""
    scene = afloat()
    return replace(scene, environment=replace(scene.environment, **changes))  # type: ignore[arg-type]


def in_brine() -> Scene:
    """The barge in another liquid, which its database was made for."""
    scene = around(water_density=1200.0)
    (body,) = scene.bodies
    assert isinstance(body.hydrodynamics, HydroDatabase)
    database = replace(body.hydrodynamics, water_density=1200.0)
    return replace(scene, bodies=(replace(body, hydrodynamics=database),))


def with_force(element: object, name: str = "it") -> Scene:
    scene = afloat()
    return replace(scene, forces={**scene.forces, name: element})  # type: ignore[dict-item]


def dry(forces: dict[str, object], **changes: object) -> Scene:
    return Scene("dry", 1.0, (block(1e4, **changes),), forces=forces)  # type: ignore[arg-type]


def with_ratio(ratio: float) -> LinearMooring:
    stiffness = np.diag([1e6, 0.0, 0.0, 0.0, 0.0, 0.0])
    return LinearMooring("barge", stiffness, damping_ratio=np.array([ratio, 0, 0, 0, 0, 0]))


def stiff(k: float) -> LinearMooring:
    return LinearMooring("barge", np.diag([k, 0.0, 0.0, 0.0, 0.0, 0.0]))


def line(length: float) -> Spring:
    table = np.array([0.0, 1.0])
    return Spring("block", (0, 0, 0), (10.0, 0, 0), length, table, 1e3 * table)


def lifted(force: float) -> AppliedForce:
    return AppliedForce("barge", (0.0, 0.0, 0.0), {"heave": constant(force)})


THIN = 1e4 * np.diag([1.0, 1.0, 3.0])
BELOW = Plane((0.0, 0.0, -1.0), (0.0, 0.0, 1.0))
REVERSED = Plane((0.0, 0.0, -1.0), (0.0, 0.0, -1.0))
POINTS = [[0.0, 0.0, -0.9]]
ODD = {
    Question.ANGLES: (in_sea(Jonswap(1.5, 8.0), heading=45.0), "2578.3 deg"),
    Question.SPEED: (dry({}, velocity=moving(surge=50.0)), "50 m/s"),
    Question.OVERLAP: (
        dry({"f": on_floor(1e5, Frictionless(), [[0, 0, -4.0]], BELOW)}),
        "point 1 3 m inside",
    ),
    Question.PLANE: (
        dry({"f": on_floor(1e5, Frictionless(), POINTS, REVERSED)}),
        "1 m behind the plane",
    ),
    Question.LINES: (dry({"l": line(5.0)}), "5 m more"),
    Question.MASS: (afloat(mass=1.4e8), "displaces 1.568e+08 kg"),
    Question.INERTIA: (dry({}, inertia=THIN), "principal moments"),
    Question.STABILITY: (afloat(centre_of_gravity=(0.0, 0.0, 40.0)), "metacentric height of -"),
    Question.PERIODS: (with_force(stiff(1e11)), "natural period of 0.2"),
    Question.LIFT: (with_force(lifted(1e9)), "lift by 65% of the weight"),
    Question.FRICTION: (
        dry({"f": on_floor(1e5, Coulomb(20.0, 20.0), POINTS, BELOW)}),
        "coefficient of 20",
    ),
    Question.DAMPING: (with_force(with_ratio(20.0)), 'Then it is "20 %"'),
    Question.WATER: (in_brine(), "1200 kg/m^3"),
    Question.STREAMS: (around(current=Stream(8.0)), "8 m/s"),
    Question.WAVES: (in_sea(RegularWave(0.1, 40.0)), "a period of 40 s"),
    Question.STEEPNESS: (in_sea(Jonswap(15.0, 8.0)), "waves break beyond 0.1"),
    Question.RAMP: (in_sea(Jonswap(1.5, 8.0), ramp=1e5), "The sea is never full"),
    Question.STEP: (
        replace(
            afloat(),
            solver=replace(afloat().solver, step=1.0, linear=LinearScenes.STEP),
            output_step=1.0,
        ),
        "a tenth of the waves' period",
    ),
}


def test_a_lightship_without_inertia_is_asked_about() -> None:
    """A moment of 1e9 kg m^2, and 2000 t at 30 m from the middle: m y^2 = 1.8e9 kg m^2."""
    wings = [Tank(f"{y:g}", Box((-1, y - 1, -5), (1, y + 1, 0)), 2.5, 1e5) for y in (-30.0, 30.0)]
    little, enough = (
        afloat(weight=Weight.CARRIED, inertia=moment * np.eye(3), tanks=tuple(wings))
        for moment in (1e9, 3e9)
    )
    (said,) = [text for text in warnings(little) if "accept: [inertia]" in text]
    assert "bodies.barge.inertia, radii_of_gyration: found a moment of inertia of -8" in said
    assert not [text for text in warnings(enough) if "accept: [inertia]" in text]


@pytest.mark.parametrize("question", ODD)
def test_an_odd_value_is_asked_about_once_and_not_if_it_is_accepted(question: Question) -> None:
    scene, found = ODD[question]
    (text,) = [text for text in warnings(scene) if text.endswith(f"accept: [{question}].")]
    assert found in text
    assert not [text for text in warnings(replace(scene, accept=(question,))) if question in text]


def test_every_question_has_a_function_and_an_example() -> None:
    assert set(QUESTIONS) == set(Question) == {*ODD, Question.RANGE}


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
    assert not [text for text in warnings(accepted) if "displaces" in text]


def test_a_sea_beyond_the_database_is_refused_unless_accepted() -> None:
    """Short waves that load the barge with nothing; a sea of 5 s, of which 5 per cent are outside,
    with a thousandth of the loads, is none."""
    short = in_sea(Jonswap(0.2, 2.5))
    with pytest.raises(InputError, match=r"environment\.waves: found .*accept: \[range\]"):
        compile_scene(short)
    accepted = compile_scene(replace(short, accept=(Question.RANGE,)))
    assert any("of the energy of its loads" in text for text in accepted.notes.skipped)
    usable = compile_scene(in_sea(Jonswap(0.5, 5.0))).notes
    assert any("4.9% of the waves' energy outside" in text for text in usable.skipped)


def test_a_lift_of_more_than_the_weight_is_refused() -> None:
    with pytest.raises(InputError, match="lift by 130% of the weight"):
        compile_scene(with_force(lifted(2e9)))


def test_an_unknown_question_is_refused_with_the_list(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    path.write_text(
        "{title: t, duration: 1, accept: [heading], bodies: {b: {mass: 1, dofs: [surge]}}}"
    )
    with pytest.raises(InputError) as caught:
        load_case(path)
    assert "accept" in str(caught.value)
    assert all(question in str(caught.value) for question in Question)


def test_a_question_is_a_warning_of_the_run(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    fender = (
        "{type: fender, body: b, points: [[0, 0, -3]], normal: {stiffness: 1e5},"
        " plane: {point: [0, 0, -1], normal: [0, 0, 1]}, friction: {law: none}}"
    )
    text = "{title: t, duration: 1, bodies: {b: {mass: 1e4, dofs: [heave]}}, forces: {f: %s}}"
    path.write_text(text % fender)
    warning = "forces.f: found point 1 2 m inside its plane at the start"
    assert str(hs.simulate(load_case(path)).attrs["warnings"]).count(warning) == 1
    path.write_text((text % fender)[:-1] + ", accept: [overlap]}")
    assert warning not in str(hs.simulate(load_case(path)).attrs.get("warnings", ""))
