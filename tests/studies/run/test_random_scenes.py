"""Random scenes, a few of those that `python -m benchmarks.random_scenes` runs by the thousand."""

from __future__ import annotations

from pathlib import Path

import pytest
from markers import few

from benchmarks.random_scenes import Finding, offences
from benchmarks.random_trial import OPEN, Convergence, Outcome, tried
from hydrosim.case import load_case
from tests.generators.mixed_cases import mixed_case
from tests.generators.random_cases import ASTRAY, random_case, text_of


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
    case = random_case(number)
    if any("hydrodynamics" in body for body in case["bodies"].values()):
        pytest.skip("afloat: radiation is fitted first, which takes longer than the run")
    outcome = tried(case)
    assert outcome.status in ("complete", "failed", "refused"), outcome.message
    assert outcome.message or outcome.status == "complete"
    assert outcome.warnings or outcome.residual <= OPEN


def test_a_finer_step_is_a_judge_of_solutions_alone() -> None:
    """What is wrong with a scene that does not converge is that nothing was said of its solution,
    whatever was said of its headings."""
    apart = Convergence(0.1)
    for text, wrong in (
        ("", True),
        ("bodies.hull1: waves act on it at its heading at rest", True),
        ("bodies.hull1: waves act on it\nsolver.step 0.1 s does not resolve heave", False),
        ("the energy balance is open", False),
    ):
        finding = Finding(1, "rk4", Outcome("complete", warnings=text), apart)
        assert list(offences(finding)) == (["not converged, no warning"] if wrong else [])


def test_bodies_head_where_the_scene_is_turned_to() -> None:
    """But for one scene in eight they do not start turned from their headings at rest."""
    for number in range(2_000_000, 2_000_040):
        for body in random_case(number)["bodies"].values():
            yaw = body.get("initial", {}).get("position", [0.0] * 6)[5]
            assert yaw == 0.0 or number % ASTRAY == 0
            assert not (yaw and "heading" in body)
