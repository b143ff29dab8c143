"""Random scenes, a few of those that `python -m benchmarks.random_scenes` runs by the thousand."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.random_cases import random_case, text_of
from benchmarks.random_trial import OPEN, tried
from hydrosim.case import load_case


@pytest.mark.parametrize("number", range(2_000_000, 2_000_040))
def test_a_random_case_is_one_that_a_case_file_may_hold(number: int, tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    path.write_text(text_of(random_case(number)))
    assert 1 <= len(load_case(path).scene().bodies) <= 4
    assert text_of(random_case(number)) == path.read_text()


@pytest.mark.parametrize("number", range(2_000_000, 2_000_020))
def test_a_random_scene_runs_or_says_why_not(number: int) -> None:
    case = random_case(number)
    if any("hydrodynamics" in body for body in case["bodies"].values()):
        pytest.skip("afloat: radiation is fitted first, which takes longer than the run")
    outcome = tried(case)
    assert outcome.status in ("complete", "failed", "refused"), outcome.message
    assert outcome.message or outcome.status == "complete"
    assert outcome.warnings or outcome.residual <= OPEN
