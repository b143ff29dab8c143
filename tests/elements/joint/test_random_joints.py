"""Random articulated scenes, a few of those that `tests.generators.scene_trials` runs."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
from markers import few

from hydrosim.case import load_case
from tests.generators.articulated_cases import TYPES, articulated_case
from tests.generators.random_cases import text_of
from tests.generators.random_links import LINKED_FROM
from tests.generators.scene_trials import offences, scene_of, tried

FIRST = 1_000_000


def test_a_random_articulated_case_is_one_that_a_case_file_may_hold(tmp_path: Path) -> None:
    """All types of joints are drawn, and trees of all sizes."""
    path = tmp_path / "case.yaml"
    types, sizes = Counter[str](), Counter[int]()
    for number in range(FIRST, FIRST + 40):
        text = text_of(articulated_case(number))
        assert text == text_of(articulated_case(number))
        path.write_text(text)
        scene = load_case(path).scene()
        types.update(joint.type.value for joint in scene.joints.values())
        sizes[len(scene.bodies)] += 1
    assert types.keys() == TYPES.keys()
    assert sizes.keys() == {2, 3, 4, 5, 6}


def test_a_case_is_turned_as_a_whole() -> None:
    scene, turned = scene_of(articulated_case, FIRST), scene_of(articulated_case, FIRST, 0.7)
    for body, other in zip(scene.bodies, turned.bodies, strict=True):
        assert other.heading == pytest.approx(body.heading + 0.7)
        assert other.mass == body.mass
    assert {name: j.point for name, j in scene.joints.items()} == {
        name: j.point for name, j in turned.joints.items()
    }


@pytest.mark.parametrize(
    "number", [*few(range(FIRST, FIRST + 40), 12), *few(range(LINKED_FROM, LINKED_FROM + 40), 6)]
)
def test_a_random_articulated_scene(number: int) -> None:
    """It runs or says why not; its ledger is closed; turned, it turns; it goes on to the bit from a
    state on the way."""
    trial = tried(articulated_case, number)
    assert trial.status in ("complete", "failed", "refused"), trial.said
    assert trial.said or trial.status == "complete"
    assert list(offences(trial)) == []
