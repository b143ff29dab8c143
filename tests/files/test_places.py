"""File and line of keys in messages that are made after the file was read."""

import pickle
from pathlib import Path

import pytest

from hydrosim.case import load_case
from hydrosim.errors import InputError
from hydrosim.files.yaml_nodes import add_source_lines, compose_nodes, places_of, source_context

TEXT = """\
bodies:
  barge:
    mass: 3
    radii_of_gyration: [1, 2, 3]
waves:
  - {seed: 1}
  - {seed: 2}
"""
node = compose_nodes(TEXT, "a.yaml")
assert node is not None
PLACES = places_of(node)


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("bodies.barge.mass: found 3", "a.yaml:3: "),
        ("bodies.barge.weight: found none", "a.yaml:2: "),  # what it belongs in
        ("bodies.barge.inertia, radii_of_gyration: found 3", "a.yaml:4: "),
        ("scene: bodies.barge.mass is 3", "a.yaml:3: "),
        ("waves.1.seed: found 2", "a.yaml:7: "),
        ("bodies: found none", "a.yaml:1: "),
        ("no key; choose another bodies.barge.mass", ""),  # a remedy
        ("some bodies: all of them", ""),
        ("a.yaml:3: bodies.barge.mass: found 3", ""),  # it is said already
    ],
)
def test_a_message_begins_with_the_place_of_its_key(text: str, place: str) -> None:
    assert add_source_lines(text, PLACES) == f"{place}{text}"


def test_each_line_has_its_own_place_and_a_file_is_named_once() -> None:
    text = "a.yaml: bodies.barge.mass: found 3\nwaves.0.seed: found 1"
    assert add_source_lines(text, PLACES) == (
        "a.yaml:3: bodies.barge.mass: found 3\na.yaml:6: waves.0.seed: found 1"
    )


def test_a_line_that_is_indented_stays_so() -> None:
    text = "barge.nc does not suit:\n  bodies.barge.mass: found 3"
    found = add_source_lines(text, PLACES)
    assert found == "barge.nc does not suit:\n  a.yaml:3: bodies.barge.mass: found 3"


def test_an_error_on_its_way_out_gets_the_place() -> None:
    with (
        pytest.raises(InputError, match=r"^a\.yaml:3: bodies\.barge\.mass"),
        source_context(PLACES),
    ):
        raise InputError("bodies.barge.mass: found 3")


def test_keys_of_a_base_file_have_its_name_and_settings_have_none(tmp_path: Path) -> None:
    base, over = tmp_path / "base.yaml", tmp_path / "over.yaml"
    base.write_text("title: a\nduration: 3 s\nbodies: {b: {mass: 1, dofs: [surge]}}\n")
    over.write_text("extends: base.yaml\nduration: 4 s\n")
    case = load_case(over, ["solver.step=0.5 s"])
    assert case.places["bodies.b.mass"] == f"{tmp_path}/base.yaml:3"
    assert case.places["duration"] == f"{over}:2"
    assert add_source_lines("solver.step: found 0.5 s", case.places) == "solver.step: found 0.5 s"
    assert pickle.loads(pickle.dumps(case.scene())).places == case.places
