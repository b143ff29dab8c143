"""Designs: which combinations there are, and that samples are spread as their names promise."""

from typing import Any

import numpy as np
import pytest

from hydrosim.study.study_file import DesignPlan, Range
from hydrosim.study.sweep import DesignRow, design_rows, design_size


def ends(_: str, spread: Range) -> tuple[float, float]:
    return float(spread.low), float(spread.high)


def of(**keys: Any) -> tuple[DesignPlan, list[DesignRow]]:
    plan = DesignPlan.model_validate(keys)
    found = list(design_rows(plan, ends))
    assert len(found) == design_size(plan)
    return plan, found


def test_one_at_a_time_begins_with_the_case() -> None:
    _, found = of(design="one_at_a_time", parameters={"a": [1, 2], "b": [5]})
    assert [row.settings for row in found] == [{}, {"a": 1}, {"a": 2}, {"b": 5}]
    assert [row.varied for row in found] == ["", "a", "a", "b"]


def test_linked_values_go_together() -> None:
    linked = {"keys": {"a": [1, 2], "b": [3, 4]}, "called": ["x", "y"]}
    _, found = of(parameters={"both": linked, "c": [0, 9]})
    settings = [(row.settings["a"], row.settings["b"], row.settings["c"]) for row in found]
    assert settings == [(1, 3, 0), (1, 3, 9), (2, 4, 0), (2, 4, 9)]
    assert [row.called["both"] for row in found] == ["x", "x", "y", "y"]


RANGES = {"a": {"from": 0, "to": 1}, "b": {"from": 1, "to": 100, "scale": "logarithmic"}}


@pytest.mark.parametrize("design", ["latin_hypercube", "sobol"])
def test_each_parameter_is_once_in_each_part_of_its_range(design: str) -> None:
    """By definition of a Latin hypercube; a scrambled Sobol sequence of 2^k points is one, too."""
    _, found = of(design=design, samples=16, parameters=RANGES)
    a = np.array([row.settings["a"] for row in found])
    b = np.log10([row.settings["b"] for row in found]) / 2.0
    for x in (a, b):
        assert sorted(np.floor(16 * x)) == list(range(16))


def test_whole_numbers_are_all_as_likely() -> None:
    """Of a key that takes whole numbers alone; 1 to 4 in 64 parts, each 16 times."""
    plan = DesignPlan.model_validate(
        {"design": "latin_hypercube", "samples": 64, "parameters": {"n": {"from": 1, "to": 4}}}
    )
    found = [row.settings["n"] for row in design_rows(plan, lambda *_: (1, 4))]
    assert [found.count(n) for n in (1, 2, 3, 4)] == [16] * 4


def test_indices_take_each_column_of_b_into_a() -> None:
    _, found = of(design="sobol_indices", samples=8, parameters=RANGES)
    x = np.array([[row.settings["a"], row.settings["b"]] for row in found])
    A, B, first, second = np.split(x, 4)
    assert np.array_equal(first, np.stack([B[:, 0], A[:, 1]], axis=1))
    assert np.array_equal(second, np.stack([A[:, 0], B[:, 1]], axis=1))
    assert not np.any(A == B)
