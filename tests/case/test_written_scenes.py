"""Scenes written in Python with the classes that are the keys of a case file."""

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hydrosim as hs
from hydrosim.run.checkpoint import digest
from hydrosim.scene import signal
from hydrosim.scene.body import Box
from hydrosim.scene.hydrodynamics import Hull

ROOT = Path(__file__).parents[2]
CASE = """
title: A block on a quay
duration: 10 s
bodies:
  block: {mass: 100 tonne, radii_of_gyration: [1 m, 2 m, 2 m]}
forces:
  quay:
    type: fender
    body: block
    points: [[1 m, 0, 0], [-1 m, 0, 0]]
    plane: {point: [0, 2 m, 0], normal: [0, -1, 0]}
    normal: {stiffness: 2 MN/m, damping: 10 kN*s/m, total: true}
    friction:
      law: stick_slip
      static: 30 %
      kinetic: 20 %
      stiffness: 400 kN/m
      damping: 4 kN*s/m
      total: true
    active: {until: 8 s}
  push:
    type: applied_force
    body: block
    force: {sway: 5 kN, yaw: {amplitude: 1 kN*m, period: 4 s}}
  mooring:
    type: linear_mooring
    body: block
    stiffness: {surge: 40 kN/m}
    damping_ratio: {surge: 10 %}
  wind:
    {type: wind_load, body: block, headings: [0 deg, 90 deg, 180 deg], sway: [0, 2 kN*s^2/m^2, 0]}
environment: {water_depth: infinite, wind: {speed: 10 m/s}}
"""


@pytest.fixture
def written() -> dict[str, hs.scene.ForceElement]:
    """The same elements in Python."""
    points = [["1 m", 0, 0], ["-1 m", 0, 0]]
    plane = hs.Plane((0, "2 m", 0), (0, -1, 0))
    normal = {"stiffness": "2 MN/m", "damping": "10 kN*s/m", "total": True}
    law = hs.StickSlip("30 %", "20 %", "400 kN/m", "4 kN*s/m", total=True)
    sway = ["0 kN*s^2/m^2", "2 kN*s^2/m^2", 0]
    return {
        "quay": hs.Fender("block", points, plane, normal, law, active=hs.Active(until="8 s")),
        "push": hs.AppliedForce(
            "block", force={"sway": "5 kN", "yaw": {"amplitude": "1 kN*m", "period": "4 s"}}
        ),
        "mooring": hs.LinearMooring("block", {"surge": "40 kN/m"}, damping_ratio={"surge": "10 %"}),
        "wind": hs.WindLoad("block", headings=["0 deg", "90 deg", "180 deg"], sway=sway),
    }


def test_a_scene_in_python_is_that_of_the_file(written, tmp_path) -> None:
    path = tmp_path / "case.yaml"
    path.write_text(CASE)
    scene = hs.load_case(path).scene()
    built = replace(scene, forces=written).forces
    assert np.array_equal(built["wind"].headings, scene.forces["wind"].headings)
    for name in ("push", "mooring"):
        assert repr(built[name]) == repr(scene.forces[name])
    for key in ("plane", "friction", "active", "points"):
        ours, theirs = (getattr(forces["quay"], key) for forces in (built, scene.forces))
        assert np.array_equal(ours, theirs) if key == "points" else ours == theirs
    assert built["quay"].normal.damping == scene.forces["quay"].normal.damping == 5e3


def test_elements_of_a_scene_are_not_built_twice(written, tmp_path) -> None:
    path = tmp_path / "case.yaml"
    path.write_text(CASE)
    scene = hs.load_case(path).scene()
    again = replace(scene, duration=5.0)
    assert all(again.forces[name] is scene.forces[name] for name in scene.forces)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: hs.Plane((0, "2 kg", 0), (0, 0, 1)), 'Plane.point.1: found "2 kg"; expected a le'),
        (lambda: hs.Plane((0, 0, 0), (0, 0, 0)), r"Plane: found the normal \[0, 0, 0\]; expected"),
        (lambda: hs.Coulomb(0.1, 0.2), "Coulomb: found static 0.1, kinetic 0.2; expected"),
        (lambda: hs.Coulomb(0.2, kinetics=0.1), "Coulomb.kinetics: found an unknown key"),
        (lambda: hs.Coulomb(0.2), 'Coulomb.kinetic: found no key "kinetic"'),
    ],
)
def test_wrong_values_are_told_as_those_of_a_file(make, said) -> None:
    with pytest.raises(hs.InputError, match=said):
        make()


def test_values_by_position_are_not_more_than_there_are() -> None:
    with pytest.raises(TypeError, match="expected static, kinetic"):
        hs.Coulomb(0.2, 0.1, 0.1)


def test_conditions_take_texts_with_a_unit() -> None:
    assert hs.When("2 min") == hs.When(120.0)
    assert hs.When(channel="stop_load.end", above="2 kN").above == 2e3
    assert hs.When(channel="speed.block", below=0.0, lasting="1 min").lasting == 60.0


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"time": "3 m"}, 'When.time: found "3 m"; expected a time in s'),
        ({"time": float("nan")}, "When.time: found nan; expected a time in s"),
        ({"time": 3.0, "channel": "speed.block", "above": 1.0}, "When.time: found an unknown key"),
        ({"channel": "speed.block"}, "When: found no value; expected either above or below"),
        ({"channel": "speed.block", "above": "1 m"}, "When: found 1 m; expected a value in m/s"),
        ({"channel": "height.block", "above": 1.0}, "When: found the channel height.block"),
        ({"above": 1.0}, 'When.channel: found no key "channel"; expected one'),
    ],
)
def test_conditions_that_no_file_may_have_are_refused(values, text) -> None:
    with pytest.raises(hs.InputError, match=f"^{text}"):
        hs.When(**values)


def base_case() -> hs.Scene:
    """The base case of the thesis with the words of its file."""
    waves = hs.WaveTrain(hs.Jonswap("1.5 m", "8 s"), ramp="200 s", repeat_period="3 hour")
    barge = hs.Body(
        "barge",
        mass="1.56758e8 kg",
        hydrodynamics=str(ROOT / "hydro_db/h851.nc"),
        centre_of_gravity=["0 m", "0 m", "-4.9 m"],
        radii_of_gyration=["22.05 m", "67.6 m", "68.9 m"],
        wave_forces={"first_order": True, "second_order": "newman"},
    )
    mooring = hs.LinearMooring(
        "barge",
        {"surge": "40 tonne_force/m", "sway": "40 tonne_force/m"},
        damping_ratio={"surge": "20 %", "sway": "20 %"},
    )
    deballast = hs.AppliedForce(
        "barge",
        frame="earth",
        time=["0 s", "500 s", "4100 s"],
        force={"heave": ["0 kN", "119900 kN", "316100 kN"]},
    )
    interface = hs.Fender(
        "barge",
        [[x, y, "7.5 m"] for x in ("20 m", "-20 m") for y in ("20 m", "-20 m")],
        hs.Plane(["0 m", "0 m", "3.6 m"], [0, 0, -1]),
        {"stiffness": "40000 tonne_force/m", "total": True},
        hs.StickSlip(0.2, 0.1, "5.6e8 N/m", "3.3e7 N*s/m", "1e6 N*s/m", total=True),
    )
    return hs.Scene(
        "Reverse float-over, base case",
        duration="2000 s",
        bodies=(barge,),
        environment=hs.Environment(waves=(waves,)),
        forces={"mooring": mooring, "deballast": deballast, "interface": interface},
        solver=hs.Solver(method="rk4", step="0.1 s", unstable="error"),
        output={"step": "0.5 s"},
    )


def test_the_base_case_in_python_runs_as_its_file_to_the_bit() -> None:
    file = hs.load_case(ROOT / "cases/reverse_float_over/base.yaml").scene()
    written = base_case()
    for key in ("bodies", "environment", "forces", "solver", "duration", "output"):
        assert digest(getattr(written, key)) == digest(getattr(file, key)), key
    runs = [hs.simulate(replace(scene, duration=60.0)) for scene in (written, file)]
    assert runs[0].variables.keys() == runs[1].variables.keys()
    for name in runs[0].variables:
        assert digest(runs[0][name].values) == digest(runs[1][name].values), name


def test_a_body_takes_the_words_of_a_case_file() -> None:
    body = hs.Body("b", "2 tonne", mass_matrix=np.diag([2e3] * 3 + [1e3, 2e3, 3e3]), dofs=["yaw"])
    assert np.array_equal(body.inertia, np.diag([1e3, 2e3, 3e3]))
    assert replace(body, mass=1.0).inertia is not None
    body = hs.Body("b", 1.0, inertia={"roll": 1, "pitch": 2, "yaw": "3 tonne*m^2"})
    assert np.array_equal(body.inertia, np.diag([1.0, 2.0, 3e3]))
    moved = hs.Body("b", 1.0, np.eye(3), initial={"position": {"yaw": "90 deg"}})
    assert moved.position == (0.0, 0.0, 0.0, 0.0, 0.0, np.pi / 2)
    assert hs.Body("b", 1.0, np.eye(3), radiation="convolution").radiation.step == 0.1
    assert hs.WaveTrain(hs.Jonswap(1.0, 8.0), seed=np.int64(7)).seed == 7
    water = hs.Environment(wind={"speed": "20 knot", "gusts": {"spectrum": "iso"}})
    assert water.gusts == hs.Gusts("npd")


def test_a_scene_with_values_by_name_is_pickled() -> None:
    values = hs.Coefficients({"surge": 1.0, "roll": 2.0}, {"heave": "1 kN*s/m"}, {"yaw": 3.0})
    body = _body(hydrodynamics=values)
    assert pickle.loads(pickle.dumps(body)) == body
    same = pickle.loads(pickle.dumps(values))
    assert same.as_written("damping").heave == 1000.0


@pytest.mark.parametrize(
    ("word", "kind"),
    [("revolute", "hinge"), ("prismatic", "slider"), ("spherical", "ball"), ("weld", "fixed")],
)
def test_words_of_other_programs_for_joints_are_known(word, kind, tmp_path) -> None:
    path = tmp_path / "case.yaml"
    path.write_text(f"{CASE}joints:\n  held: {{type: {word}, body: block}}\n")
    with pytest.raises(hs.InputError, match=f'joints.held.type: found "{word}".*"{kind}"\\?'):
        hs.load_case(path)


BOX = Box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))


def test_signals_are_equal_by_their_values() -> None:
    winch = _winch(length=signal.Table([0.0, 1.0], [9.0, 8.0]), speed=None)
    assert winch == replace(winch)
    assert winch == pickle.loads(pickle.dumps(winch))
    assert winch != replace(winch, length=signal.Table([0.0, 1.0], [9.0, 7.0]))
    assert hash(winch) == hash(replace(winch))


def test_scenes_with_arrays_are_equal_to_their_copies() -> None:
    curve = hs.NormalCurve([0.0, 1.0], [0.0, 1e6])
    segment = hs.Segment(9.0, 1e3, hs.StretchCurve([0.0, 1.0], [0.0, 1e3]))
    line = hs.Catenary("b", (0, 0, 0), (9, 0, -9), segments=[segment])
    hull = Hull(np.zeros((4, 3, 3)))
    for value in (curve, line, hull):
        assert pickle.loads(pickle.dumps(value)) == value
    assert curve != replace(curve, force=[0.0, 2e6])
    assert line != replace(line, segments=[replace(segment, stiffness=1e3)])
    assert hull != Hull(np.ones((4, 3, 3)))


def _body(**values) -> hs.Body:
    return hs.Body("b", 1.0, np.eye(3), **values)


def _winch(**values) -> hs.Winch:
    return hs.Winch("b", (0, 0, 0), (0, 0, 9), stiffness=1e6, **{"speed": 0.1, **values})


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: hs.Body("b", "1 m", np.eye(3)), 'Body.mass: found "1 m"; expected a mass in kg'),
        (lambda: hs.Body("b", 1.0), "Body: found none; expected one of radii_of_gyration"),
        (lambda: hs.Body("b", 1.0, np.eye(3), dofs=["heav"]), r"Body.dofs: found \[heav\]"),
        (lambda: hs.Jonswap("1.5 s", 8.0), "Jonswap.significant_height: found"),
        (lambda: hs.WaveTrain(hs.Jonswap(1.0, 8.0), seed=-1), "WaveTrain.seed: found -1"),
        (lambda: hs.Current(heading=1.0), "Current: found no speed; expected speed, or those in"),
        (lambda: hs.Pump("p", 1.0, "a", None, stop={"tank": "a"}), "Pump.stop.*: found neither"),
        (lambda: hs.Tank("t", BOX, level="-1 m"), 'Tank.level: found "-1 m"'),
        (
            lambda: hs.Body("b", 1.0, -np.eye(3)),
            "Body: found a matrix that is not positive definite",
        ),
        (lambda: hs.Body("b", 1.0, np.eye(2)), "Body: found an inertia of 2 x 2 values"),
        (lambda: _body(database_body=0), "Body.database_body: found 0; expected 1 or more"),
        (lambda: _body(tanks=[3]), "Body.tanks.0: found 3; expected an object of Tank"),
        (
            lambda: _body(hydrostatics="x"),
            'Body.hydrostatics: found "x"; expected an object of Hull',
        ),
        (
            lambda: hs.WaveTrain("jonswap"),
            'WaveTrain.spectrum: found "jonswap"; expected an object',
        ),
        (lambda: hs.Environment(waves=hs.Jonswap(1.0, 8.0)), "Environment.waves: found Jonswap"),
        (lambda: hs.Scene("x", 1.0, 3), "scene: bodies: found 3; expected hs.Body"),
        (lambda: hs.Scene("x", "2 m", [_body()]), 'Scene.duration: found "2 m"; expected a time'),
        (lambda: hs.Scene("x", -1.0, [_body()]), "Scene.duration: found -1.0; expected a time"),
        (
            lambda: hs.Scene("x", 1.0, [_body()], output={"step": "0 s"}),
            'RunOutput.step: found "0 s"',
        ),
        (lambda: hs.Scene("x", 1.0, [_body()], output=3), "scene: output: found 3; expected hs"),
        (lambda: hs.Scene("x", 1.0, [_body()], 3), "scene: environment: found 3; expected hs"),
        (
            lambda: hs.Scene("x", 1.0, [_body()], output={"steps": 1.0}),
            "RunOutput.steps: found an unknown key",
        ),
        (
            lambda: hs.Scene("x", 1.0, [_body()], joints={"j": _body()}),
            "scene: joi",
        ),
        (
            lambda: hs.Scene("x", 1.0, [_body()], joints={"j": hs.Joint("b")}),
            "scene: joints.j: found",
        ),
        (lambda: hs.Body("b", 10**400, np.eye(3)), "Body.mass: found 1000.*give a finite number"),
        (lambda: hs.Body("b", 1.0, [1, 2, 3]), r"Body.inertia: found a list of values[^\n]*$"),
        (lambda: hs.Body("b", 1.0, np.eye(3), position=(0, 0)), r"Body.position: found[^\n]*$"),
        (
            lambda: _body(position=[1] * 6, initial={"velocity": [1] * 6}),
            "Body: found initial, and",
        ),
        (lambda: signal.Table([0.0, 0.0], [1.0, 2.0]), "Table: found times that do not rise"),
        (lambda: signal.Table([0.0, 1.0], [1.0, np.nan]), "Table: found what is no number"),
        (lambda: _winch(length=-9.0), "Winch.length: found -9.0; expected a length in m"),
        (lambda: _winch(length=np.nan), "Winch.length: found nan; expected a length in m"),
        (lambda: _winch(speed=np.inf), "Winch.speed: found inf; expected a velocity in m/s"),
        (lambda: _winch(length={"time": [0], "length": [-1]}), "Winch.length.length.0: found -1"),
        (
            lambda: _winch(length=signal.Table([0.0], [-1.0])),
            "Winch: found a length that falls to -1 m",
        ),
        (lambda: _winch(friction={"heave_in": 0.1}), "Winch.friction.heave_in: found an unknown"),
        (lambda: _winch(active={"start": 1.0}), "Winch.active.start: found an unknown key"),
        (lambda: hs.Ball("b", breaks_at=1.0, initial={"rate": (0, 0, 1)}), "Ball: found breaks_at"),
        (lambda: hs.Spring("b", (0, 0, 0), (0, 0, 1), length=0.0, stiffness=1.0), "Spring.length"),
    ],
)
def test_wrong_bodies_and_seas_are_told_as_those_of_a_file(make, said) -> None:
    with pytest.raises(hs.InputError, match=f"^{said}"):
        make()
