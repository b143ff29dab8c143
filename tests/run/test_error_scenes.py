"""Cases by which errors of runs are judged, and the norm and the questions of the judge."""

from collections import Counter

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks import error_scenes
from tests.generators.error_cases import KINDS, drawn_scene
from tests.generators.random_cases import text_of
from tests.generators.references import motion_errors

FIRST = 3_000_000


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_case_is_one_that_a_case_file_may_hold(kind: str) -> None:
    lasting = Counter[bool]()
    for number in range(FIRST, FIRST + 24):
        assert text_of(KINDS[kind](number)) == text_of(KINDS[kind](number))
        with drawn_scene(kind, number) as scene:
            lasting[60.0 <= scene.duration <= 120.0] += 1
    assert lasting[True] >= 8


def test_errors_of_positions_and_of_attitudes() -> None:
    """A body that turns about a skew axis, and is a little off in place or in attitude."""
    time = np.linspace(0.0, 1.0, 50)
    turns = Rotation.from_rotvec(np.outer(time, [0.5, 1.2, -0.4]))
    theirs = np.zeros((50, 1, 6))
    theirs[:, 0, 0] = 4.0 * time
    theirs[:, 0, 3:] = turns.as_euler("ZYX")[:, ::-1]
    ours = theirs.copy()
    ours[:, 0, 1] += 0.02
    assert motion_errors(ours, theirs).max() == pytest.approx(0.02 / 4.0)
    off = Rotation.from_rotvec([0.0, 0.01, 0.0])
    ours = theirs.copy()
    ours[:, 0, 3:] = (off * turns).as_euler("ZYX")[:, ::-1]
    widest = np.ptp(theirs[:, 0, 3:], axis=0).max()
    assert motion_errors(ours, theirs).max() == pytest.approx(0.01 / widest)


def record(**values: object) -> dict[str, object]:
    """A run by default that is complete and unwarned."""
    usual = {"way": "default", "kind": "joints", "number": 1, "status": "complete", "cpu": 1.0}
    figures = {"evaluations": 100, "error_evaluations": 60, "stepped": True, "warnings": []}
    apart = dict.fromkeys(("apart", "apart_strictly", "force_apart"), 1e-9)
    return {**usual, **figures, **apart, "true_strictly": values.get("true"), **values}


@pytest.mark.parametrize(
    ("said", "true", "apart", "ratio"),
    [
        (2e-4, 1e-4, 1e-9, 2.0),
        (2e-4, 1e-4, 1e-4, None),  # the reference is no better
        (3e-8, 5e-8, 1e-12, None),  # too small to matter
        (0.5, 7.0, 1e-9, 0.5),  # lost
        (None, 1e-3, 1e-9, None),
    ],
)
def test_what_is_said_over_what_is_true(
    said: float | None, true: float, apart: float, ratio: float | None
) -> None:
    found = error_scenes.ratio_of(record(said=said, true=true, apart=apart))
    assert found == (ratio if ratio is None else pytest.approx(ratio))


def test_what_is_silent_and_what_cries_wolf() -> None:
    """Warnings of the model are none of the solution."""
    told = "the motion of b may be wrong by 0.01 of its range"
    records = [
        record(number=1, true=2e-3, said=2e-3),
        record(number=2, true=2e-3, said=2e-3, warnings=[told]),
        record(number=3, true=1e-5, said=2e-3, warnings=[told]),
        record(number=4, true=2e-3, said=2e-3, warnings=["waves act on it at its heading"]),
    ]
    (silent,) = error_scenes.unwarned_table(records)
    assert (silent["complete and unwarned"], silent["wrong"]) == (2, 2)
    (false,) = error_scenes.false_alarm_table(records)
    assert (false["judged"], false["warned though right"]) == (4, 1)
    assert false["warned of the model alone"] == 1
    assert "joints 1 (2.0e-03), joints 4 (2.0e-03)" in error_scenes.report(records)
