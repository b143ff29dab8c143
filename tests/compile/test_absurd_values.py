"""Values of engineers that are wrong by a unit, a sign or a frame: asked about; the right value of
the same key is not."""

from collections.abc import Mapping
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from markers import few
from scenes import in_waves

from hydrosim.case import load_case
from hydrosim.compile.compile import compile_scene
from hydrosim.errors import InputError
from hydrosim.report.sentences.check import check, describe_direction
from hydrosim.scene.force import strongest_breaking_load

Mistake = tuple[str, str, Any, Any, str]
"""Case, key, wrong value, right value, text of the question."""
CASES = Path(__file__).parents[2] / "cases"
TENDER = "tender_alongside/alongside.yaml"
FLOAT_OVER = "reverse_float_over/base.yaml"
TANKER = "turret_tanker/storm.yaml"
NO_ROLL = {"type": "viscous_roll", "body": "barge", "includes_waves": False}
PRESSED = {"compression": ["0 m", "1.2 m"], "force": ["0 kN", "700 kN"]}
MISTAKES: list[Mistake] = [
    (TENDER, "bodies.barge.centre_of_gravity", [0, 0, 4.0], [0, 0, 1.0], "Is it the height above"),
    (
        TENDER,
        "bodies.barge.radii_of_gyration",
        [0.0063, 0.0156, 0.0156],
        [6, 15, 15],
        "Check its u",
    ),
    (FLOAT_OVER, "bodies.barge.heading", "1.5708 deg", "1.5 deg", "1.5708 rad are 90 deg"),
    (FLOAT_OVER, "bodies.barge.heading", 90, "90 deg", "90 rad, which is 5156.6 deg"),
    (FLOAT_OVER, "environment.waves.heading", "3.1416 deg", "3.1 deg", "3.1416 rad are 180 deg"),
    (FLOAT_OVER, "environment.waves.peak_enhancement", 33, 3.3, "usual is 1 to 7"),
    (FLOAT_OVER, "output.step", "5 s", "2 s", "miss the motion in waves"),
    (TENDER, "forces.chain_1.point", [28, 8, -6.5], [28, 8, -4.0], "m under the keel of barge"),
    (TENDER, "forces.chain_1.point", [8, 28, -2], [28, 10, -2], "m outside of barge"),
    (TENDER, "forces.chain_1.point", [28, 8, 20], [28, 8, 4], "20.5 m above the water"),
    (TANKER, "forces.line_1.anchor", [507, 457, -90], [507, 457, -99], "10 m above the seabed"),
    (TENDER, "forces.chain_1.capacity", "25 MN", "2.2 MN", "of grade R5 breaks at 3.2e+06 N"),
    (TENDER, "forces.chain_1.capacity", "1300 N", "1.3 MN", "of grade R5 breaks at 3.2e+06 N"),
    (TENDER, "forces.bow_breast.capacity", "225 GN", "450 kN", "m longer; usual is up to 10"),
    (TENDER, "forces.fenders.points", [[8, 6, 0.2]], [[8, -6, 0.2]], "at the far side of the hull"),
    (
        TENDER,
        "forces.fenders.plane",
        {"body": "barge", "point": [0, -9, 0], "normal": [0, 1, 0]},
        {"body": "barge", "point": [0, 9, 0], "normal": [0, 1, 0]},
        "a plane that barge exceeds by",
    ),
    (TANKER, "forces.roll_damping.damping_ratio.roll", 0.0004, "4 %", "5 % are 0.05"),
    (TENDER, "forces.tender_roll.damping.roll", 1.0, "1 MN*m*s/rad", "of critical"),
    (TENDER, "forces.tender_roll.damping.roll", "1 GN*m*s/rad", "2 MN*m*s/rad", "of critical"),
    (TENDER, "forces.barge_roll", NO_ROLL | {"p1": 1e-5}, NO_ROLL | {"p1": 0.03}, "of critical"),
    (TENDER, "forces.barge_roll", NO_ROLL | {"p1": 2.0}, NO_ROLL | {"p1": 0.1}, "of critical"),
    (TENDER, "forces.barge_roll.ikeda.length", "600 m", "62 m", "the hull of barge has about"),
    (TANKER, "forces.slow_damping.damping.sway", 300.0, "200 kN*s/m", "of m sqrt(g/L)"),
    (TANKER, "forces.slow_damping.damping.sway", 3e9, "400 kN*s/m", "of m sqrt(g/L)"),
    (TANKER, "forces.yaw_drag.damping.yaw", 4.5e8, 4e11, "a drag coefficient of 0.00"),
    (TANKER, "forces.yaw_drag.damping.yaw", 4.5e15, 5e11, "a drag coefficient of 8.4e+03"),
    (TANKER, "bodies.tanker.draught", "1.4 m", "13 m", "the hull of its database has about 12.7"),
    (FLOAT_OVER, "forces.interface.normal.stiffness", "160 GN/m", "2 GN/m", "a bar of steel"),
    (FLOAT_OVER, "forces.interface.friction.stiffness", "100 N/m", "100 MN/m", "before it slips"),
    (FLOAT_OVER, "forces.interface.friction.stiffness", 5.6e14, 1e9, "up to 100 times the normal"),
    (FLOAT_OVER, "forces.interface.friction.damping", 3.3e11, 3.3e8, "times critical"),
    (FLOAT_OVER, "forces.interface.friction.slip_damping", 1e11, 1e7, "times critical"),
    (TENDER, "forces.fenders.normal", PRESSED | {"damping": 1.5e10}, PRESSED, "times critical"),
    (TENDER, "forces.bow_breast.length", "79.5 m", "8.2 m", "at the start; usual is up to 5"),
    (TENDER, "forces.tender_wind.surge", [-25, -18, 0, 18, 25], [25, 18, 0, -18, -25], "against"),
    (TENDER, "forces.tender_wind.sway", [0, -36, -51, -36, 0], [0, 36, 51, 36, 0], "against the s"),
    (TENDER, "forces.barge_current.sway", [0, 65e6, 129e6, 65e6, 0], [0, 6e4, 1e5, 6e4, 0], "kN?"),
    (
        TENDER,
        "forces.barge_current.sway",
        [0, 0, 1e-3, 0, 0],
        [0, 6e4, 1e5, 6e4, 0],
        "Is it in kN?",
    ),
]


def said(case: str, key: str, value: Any) -> list[str]:
    """The refusal or questions of a case with another value; waves only where they are meant."""
    try:
        scene = load_case(CASES / case, {key: value}).scene()
        calm = in_waves(scene) if key.startswith(("bodies", "forces")) else scene
        notes = compile_scene(calm).notes
    except InputError as error:
        return [str(error)]
    return [text for text in notes.warnings if "accept: [" in text]


@pytest.mark.parametrize("mistake", few(MISTAKES, 12))
def test_a_mistake_is_told_and_the_right_value_is_not(mistake: Mistake) -> None:
    case, key, wrong, right, text = mistake
    told = said(case, key, wrong)
    assert any(text in each for each in told), told
    assert said(case, key, right) == []


def test_a_place_at_rest_that_is_not_found_names_odd_values() -> None:
    settings = {"forces.fenders.normal": {"stiffness": "40 GN/m"}}
    with pytest.raises(InputError, match=r"none found(.|\n)*A cause may be: .*a bar of steel"):
        compile_scene(load_case(CASES / TENDER, settings).scene())


def test_ratios_without_stiffness_in_roll_point_to_the_centre_of_gravity() -> None:
    (text,) = said(TANKER, "bodies.tanker.centre_of_gravity", [0, 0, 12])
    assert "check the height of the centre of gravity" in text


def test_breaking_loads_are_those_of_the_published_table() -> None:
    """Chain of 50 and 76 mm of grade R4 breaks at 2740 and 6001 kN (tables of makers to IACS UR
    W22); R5 has 0.0320 / 0.0274 of it."""
    for diameter, grade_4 in ((0.050, 2740e3), (0.076, 6001e3)):
        expected = grade_4 * 0.0320 / 0.0274
        assert strongest_breaking_load(diameter) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(
    ("going_to", "heading", "text"),
    [
        (0.0, 0.0, "towards +x of the earth frame; from astern of a"),
        (180.0, 0.0, "towards -x of the earth frame; from ahead of a"),
        (90.0, 0.0, "towards +y of the earth frame; from starboard abeam of a"),
        (90.0, 180.0, "towards +y of the earth frame; from port abeam of a"),
        (225.0, 0.0, "towards -x and -y of the earth frame; from the port bow of a"),
        (-315.0, 90.0, "towards +x and +y of the earth frame; from the port quarter of a"),
        (359.0, 0.0, "towards +x of the earth frame; from astern of a"),
    ],
)
def test_directions_in_words(going_to: float, heading: float, text: str) -> None:
    """With x ahead and y to port, what goes to +y comes from starboard."""
    assert describe_direction(np.radians(going_to), {"a": np.radians(heading)}) == text


def test_directions_name_bodies_together_that_they_meet_alike() -> None:
    headings = {"a": 0.0, "b": 0.1, "c": pi}
    text = describe_direction(pi, headings)
    assert text.endswith("from ahead of a, b; from astern of c")
    many = describe_direction(pi, dict.fromkeys("abcdef", 0.0))
    assert many.endswith("from ahead of a, b, c, d and 2 more")


def checked(case: str, settings: Mapping[str, Any]) -> str:
    return " ".join(str(check(load_case(CASES / case, settings))).split())


def test_check_shows_how_bodies_float_and_where_lines_are_tied() -> None:
    """The metacentric height is the stiffness over the weight."""
    settings = {
        "bodies.barge.centre_of_gravity": [0, 0, -3.9],
        "bodies.barge.initial": {"position": {"heave": "0.5 m", "roll": "3 deg"}},
    }
    text = checked(FLOAT_OVER, settings)
    scene = load_case(CASES / FLOAT_OVER, settings).scene()
    (database,) = compile_scene(scene).derived.databases.values()
    assert database.hydrostatic_stiffness is not None
    transverse = database.hydrostatic_stiffness[3, 3] / (scene.bodies[0].mass * 9.81)
    assert "Bodies afloat at the start" in text
    assert f"barge 0 3 0 11.6 -3.4 {transverse:.3g}" in text
    assert "waves towards +x of the earth frame; from astern of barge" in text


def test_check_shows_heights_of_fairleads_and_anchors() -> None:
    text = checked(TANKER, {"forces.line_1.anchor": [507.3, 456.8, -99.0], "initial": None})
    row = text.split("Loads of lines")[1].split("line_1 ")[1].split(" line_2")[0].split()
    assert row[-2:] == ["-14", "1"]
