"""Errors asked, said and true: scenes of `benchmarks.work_precision`, a few in every run."""

from collections.abc import Callable
from math import isnan
from pathlib import Path

import pytest
from markers import few

from benchmarks import work_precision
from hydrosim.report.evidence import Feature, Kind
from tests.generators.precision_scenes import HARD, scene_names, shipped_cases

ASKED = (1e-3, 1e-5)
QUICK = ("friction_block/exact", "sphere/decay")
OFTEN = [*HARD, *QUICK]
SCENES = few([*OFTEN, *(name for name in shipped_cases() if name not in QUICK)], len(OFTEN))


def test_all_shipped_cases_are_among_the_scenes() -> None:
    assert set(scene_names()) == {*HARD, *shipped_cases()}


@pytest.mark.parametrize("name", SCENES)
def test_a_tolerance_is_kept_or_told(name: str, validated: Callable[..., None]) -> None:
    """Errors beyond the tolerance of automatic, or a thousandth of the range by rk4, are told."""
    trials = list(work_precision.trials_of(name, ASKED))
    assert not any(map(work_precision.is_silent, trials))
    kept = [t.true / t.asked for t in trials if not isnan(t.asked) and t.counts and not t.told]
    claim = "automatic on all shipped cases and hard scenes, error over its tolerance"
    against = "dopri5 at a tolerance of 1e-11"
    validated(Kind.SELF, claim, against, max(kept, default=0.0), 1.0, Feature.ADAPTIVE)


def test_the_table_and_the_picture(tmp_path: Path) -> None:
    """Lost runs, references that are too coarse, and runs that failed have no figure."""
    Trial = work_precision.Trial
    trials = [
        Trial("a", "rk4", float("nan"), 2e-3, 3e-3, 1e-9, 0.1, told=True),
        Trial("a", "1e-04", 1e-4, 2e-5, 1e-5, 1e-9, 0.2, told=False),
        Trial("b", "rk4", float("nan"), 1e-6, 2e-6, 1e-6, 0.1, told=False),
        Trial("b", "1e-04", 1e-4),
    ]
    table = work_precision.page_block(trials).split("\n")
    assert table[2] == "| a | 2.0e-03 / 3.0e-03 (told) / 0.1 | 2.0e-05 / 1.0e-05 / 0.2 |"
    assert table[3] == "| b | 1.0e-06 / < 2e-06 / 0.1 | failed |"
    work_precision.draw(trials).savefig(tmp_path / "picture.png")
    rk4, automatic = work_precision.summary_rows(trials)
    assert (rk4["scenes"], rk4["kept"], rk4["beyond, told"]) == (2, 1, 1)
    assert (automatic["scenes"], automatic["CPU over that of rk4, median"]) == (1, 2.0)
