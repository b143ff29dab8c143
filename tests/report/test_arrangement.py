"""The drawing of the arrangement: to scale, turned as bodies are, names as they are."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from hydrosim.files.display_units import DEFAULT, Units
from hydrosim.report.arrangement import DrawnBody, DrawnLine, SceneArrangement, svg

BOX = np.array([(x, y, z) for x in (-50.0, 50.0) for y in (-10.0, 10.0) for z in (-4.0, 6.0)])
POINTS = np.array([[-30.0, 0.0, 6.0], [30.0, 0.0, 6.0]])


def drawn(name: str = "barge", heading: float = 0.0) -> SceneArrangement:
    turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
    box, points = BOX.copy(), POINTS.copy()
    box[:, :2] = BOX[:, :2] @ turn.T
    points[:, :2] = POINTS[:, :2] @ turn.T
    lines = [DrawnLine("bow", points[1], points[1] + [500.0, 0.0, -90.0])]
    return SceneArrangement(
        [DrawnBody(name, box)], {"pads": points}, lines, [("waves", np.pi / 3)], {}
    )


def elements(picture: str, tag: str) -> list[ElementTree.Element]:
    return [each for each in ElementTree.fromstring(picture).iter() if each.tag == tag]


def pixels(picture: str) -> np.ndarray:
    """Places of the contacts, of the plan and then of the side."""
    dots = elements(picture, "circle")
    return np.array([[float(dot.attrib["cx"]), float(dot.attrib["cy"])] for dot in dots])


@pytest.mark.parametrize("units", [DEFAULT, Units({"m": "ft"})])
@pytest.mark.parametrize("heading", [0.0, 0.7])
def test_the_bar_has_the_length_that_it_says(heading: float, units: Units) -> None:
    picture = svg(drawn(heading=heading), units)
    bar = next(e for e in elements(picture, "line") if e.attrib["class"] == "scale")
    length = float(bar.attrib["x2"]) - float(bar.attrib["x1"])
    text = elements(picture, "text")[-1].text or ""
    found = re.fullmatch(r"([\d.,]+) (m|ft)", text)
    assert found is not None
    said = float(found[1].replace(",", "")) * {"m": 1.0, "ft": 0.3048}[found[2]]
    a, b = pixels(picture)[:2]
    assert np.hypot(*(b - a)) / length == pytest.approx(60.0 / said, rel=0.01)


def test_plan_and_side_have_one_scale_and_stand_above_each_other() -> None:
    first, second, third, fourth = pixels(svg(drawn(), DEFAULT))
    np.testing.assert_allclose(second - first, fourth - third, atol=0.2)
    assert third[0] == pytest.approx(first[0], abs=0.2)
    assert third[1] > first[1]


def test_the_arrow_points_where_the_waves_go() -> None:
    picture = svg(drawn(), DEFAULT)
    arrow = next(e for e in elements(picture, "line") if e.attrib["class"] == "arrow")
    x1, y1, x2, y2 = (float(arrow.attrib[key]) for key in ("x1", "y1", "x2", "y2"))
    assert np.arctan2(y1 - y2, x2 - x1) == pytest.approx(np.pi / 3, abs=0.01)


def test_names_are_texts() -> None:
    hostile = '</svg><script>alert("x")</script>&'
    texts = [each.text for each in elements(svg(drawn(hostile), DEFAULT), "text")]
    assert texts.count(hostile) == 2


def test_what_is_flat_is_drawn() -> None:
    flat = SceneArrangement([DrawnBody("plate", BOX * [1.0, 0.0, 0.0])], {}, [], [], {})
    assert elements(svg(flat, DEFAULT), "polygon")
