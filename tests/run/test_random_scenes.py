"""Random scenes with contacts, a few of those that `benchmarks.scene_trials` runs."""

from pathlib import Path

import pytest
from markers import few

from hydrosim.case import load_case
from tests.generators.mixed_cases import mixed_case
from tests.generators.random_cases import ASTRAY, random_case, text_of
from tests.generators.scene_trials import offences, tried


@pytest.mark.parametrize("number", range(2_000_000, 2_000_040))
def test_a_random_case_is_one_that_a_case_file_may_hold(number: int, tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    path.write_text(text_of(random_case(number)))
    assert 1 <= len(load_case(path).scene().bodies) <= 4
    assert text_of(random_case(number)) == path.read_text()


def test_a_family_of_draughts_lies_in_still_water() -> None:
    """As the program asks for; wind and the currents of other hulls are drawn as ever."""
    cases = [mixed_case(number) for number in range(60)]
    families = [isinstance(case["bodies"]["barge"]["hydrodynamics"], list) for case in cases]
    currents = ["current" in case["environment"] for case in cases]
    assert any(families)
    assert not any(a and b for a, b in zip(families, currents, strict=True))
    assert all(("current" in case["forces"]) == b for case, b in zip(cases, currents, strict=True))
    assert sum(currents) > 20


@pytest.mark.parametrize("number", few(range(2_000_000, 2_000_020), 8))
def test_a_random_scene_runs_or_says_why_not(number: int) -> None:
    """Its ledger is closed, and it goes on to the bit from a state on the way."""
    case = random_case(number)
    if any("hydrodynamics" in body for body in case["bodies"].values()):
        pytest.skip("afloat: radiation is fitted first, which takes longer than the run")
    trial = tried(random_case, number, turns=False)
    assert trial.status in ("complete", "failed", "refused"), trial.said
    assert trial.said or trial.status == "complete"
    assert list(offences(trial)) == []


def test_bodies_head_where_the_scene_is_turned_to() -> None:
    """But for one scene in eight they do not start turned from their headings at rest."""
    for number in range(2_000_000, 2_000_040):
        for body in random_case(number)["bodies"].values():
            yaw = body.get("initial", {}).get("position", [0.0] * 6)[5]
            assert yaw == 0.0 or number % ASTRAY == 0
            assert not (yaw and "heading" in body)
