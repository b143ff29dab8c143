"""The record of runs and texts tells a last digit, a word and a key, each by its own part."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import hydrosim as hs
from benchmarks import checksums
from tests.generators.random_cases import text_of
from tests.generators.transition_cases import transition_cases

SCHEMA: dict[str, Any] = {"properties": {"mass": {"type": "number", "description": "Mass."}}}


def recorded(force: float = 1.0, word: str = "force", **keys: Any) -> checksums.Record:
    """A record of one variable and one schema."""
    record: checksums.Record = {part: {} for part in checksums.PARTS}
    attributes = {"units": "N", "long_name": f"a {word}"}
    run = xr.Dataset({"force": ("time", np.array([0.0, force]), attributes)}, {"time": [0.0, 1.0]})
    checksums.add_dataset(record, "run", run, Path("folder"))
    checksums.add_schema(record, "case", {"properties": SCHEMA["properties"] | keys})
    return record


@pytest.mark.parametrize(
    ("changed", "part", "name"),
    [
        (recorded(force=float(np.nextafter(1.0, 2.0))), "numbers", "run: force"),
        (recorded(word="load"), "texts", "run: force (attributes)"),
        (recorded(length={"type": "number"}), "schemas", "case.length"),
    ],
)
def test_a_change_is_told_by_its_part(changed: checksums.Record, part: str, name: str) -> None:
    before = recorded()
    differences = {p: checksums.find_differences(changed[p], before[p]) for p in checksums.PARTS}
    assert [*differences.pop(part)] == [name]
    assert not any(differences.values())


def test_what_differs_is_shown_line_by_line() -> None:
    assert checksums.first_difference("a\nb\nc", "a\nd\nc").split("\n    ") == ["", "- b", "+ d"]
    assert checksums.first_difference("a", "a\nb").split("\n    ") == ["", "- ", "+ b"]
    assert checksums.first_difference(None, "a") == "new"


def test_transitions_are_counted_by_the_names_of_modes() -> None:
    flags = {"flag_meanings": "open stick slip"}
    run = xr.Dataset(
        {
            "fender_mode": (("time", "fender"), np.int8([[0, 1], [2, 1], [1, 1], [2, 0]]), flags),
            "fender_segment": (("state_time", "fender"), np.int16([[0, 3], [1, 2]])),
        }
    )
    assert checksums.count_transitions(run) == {
        "fender_mode open>slip": 1,
        "fender_mode slip>stick": 1,
        "fender_mode stick>slip": 1,
        "fender_mode stick>open": 1,
        "fender_segment up": 1,
        "fender_segment down": 1,
    }


@pytest.mark.parametrize("name", ["locks", "pumps", "drums"])
def test_a_case_goes_through_its_transitions(name: str, tmp_path: Path) -> None:
    case = transition_cases()[name]
    case["output"] = {"step": 0.01, "states": True}
    path = tmp_path / "case.yaml"
    path.write_text(text_of(case))
    counts = checksums.count_transitions(hs.simulate(hs.load_case(path)))
    expected = {
        "locks": {"lock_mode waiting>closed", "lock_mode running>closed", "lock_mode closed>open"},
        "pumps": {"pump_mode waiting>running", "pump_mode running>over", "pump_mode waiting>over"},
        "drums": {"winch_mode fast_out>empty", "winch_mode speeding_in>full"},
    }
    assert expected[name] <= {*counts}
