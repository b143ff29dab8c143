"""Scenes written in Python with the classes that are the keys of a case file."""

from dataclasses import replace

import numpy as np
import pytest

import hydrosim as hs

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
