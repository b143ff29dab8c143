"""Bisection on common seeds, against all runs of a grid: of seeds that each fail above a height of
their own, and of such that do not."""

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.stats import binom

from hydrosim.errors import InputError
from hydrosim.study.operability import HeightLimit, LimitSearch, allowed_failures, fewest_seeds

HEIGHTS, SEEDS = 64, 50


def of_table(held: np.ndarray) -> tuple[LimitSearch, list[tuple[int, int]]]:
    """A search in a table (heights, seeds, criteria) of what holds, and the runs that it made."""
    made: list[tuple[int, int]] = []

    def outcomes(runs: Sequence[tuple[int, int]]) -> np.ndarray:
        made.extend(runs)
        return np.array([held[run] for run in runs])

    return LimitSearch(*held.shape, outcomes), made


def by_all(held: np.ndarray, most: int) -> int:
    """The last height before the first at which more fail."""
    failing = np.sum(~held.all(axis=2), axis=1)
    return int(np.argmax(failing > most)) - 1 if (failing > most).any() else len(failing) - 1


def monotone(random: np.random.Generator, criteria: int = 1) -> np.ndarray:
    """Each seed holds each criterion up to a height of its own."""
    own = random.normal(30.0, 8.0, (SEEDS, criteria))
    return np.arange(HEIGHTS)[:, None, None] < own


@pytest.mark.parametrize("seed", range(20))
def test_the_limit_is_that_of_the_grid_by_few_runs(seed: int) -> None:
    held = monotone(np.random.default_rng(seed), 2)
    search, made = of_table(held)
    found = search.find_limit([0, 1], 0.9)
    most, least, largest = allowed_failures(SEEDS, 0.9)
    expected = [by_all(held, k) for k in (most, least, largest)]
    assert [found.limit, found.low, found.high - 1] == expected
    assert found.otherwise == 0
    assert len(made) == len({*made}) < 0.1 * HEIGHTS * SEEDS
    alone = search.find_limit([1], 0.9)
    assert alone.limit == by_all(held[:, :, 1:], most)


def test_no_seed_at_the_limit_is_inferred() -> None:
    """Where a tenth of all runs are otherwise than their heights say, the share that is found at
    the limit is that of runs."""
    random = np.random.default_rng(3)
    for _ in range(20):
        held = monotone(random) ^ (random.random((HEIGHTS, SEEDS, 1)) < 0.1)
        search, made = of_table(held)
        found = search.find_limit([0], 0.8)
        if found.limit >= 0:
            assert {s for h, s in made if h == found.limit} == set(range(SEEDS))
            assert np.sum(~held[found.limit]) <= 0.2 * SEEDS


def test_ends_of_the_range() -> None:
    nothing, everything = np.zeros((8, SEEDS, 1), bool), np.ones((8, SEEDS, 1), bool)
    assert of_table(nothing)[0].find_limit([0], 0.9)[:3] == (-1, -1, 0)
    assert of_table(everything)[0].find_limit([0], 0.9)[:3] == (7, 7, 8)


def test_intervals_hold_the_true_limit() -> None:
    """150 searches; the true limit is the 10 % quantile of a normal law. 90 % or more, as
    thresholds are whole numbers and the ends are heights of the grid."""
    true = 30.0 + 8.0 * -1.2815515655446004
    random = np.random.default_rng(4)
    bounds: list[HeightLimit] = [
        of_table(monotone(random))[0].find_limit([0], 0.9) for _ in range(150)
    ]
    inside = np.mean([b.low < true <= b.high for b in bounds])
    assert 0.86 < inside  # 0.9 less two standard deviations


def test_too_few_seeds_bound_nothing() -> None:
    """0.9^n < 5 % from 29 on."""
    assert fewest_seeds(0.9) == 29
    assert 0.9**29 < 0.05 < 0.9**28
    allowed_failures(29, 0.9)
    with pytest.raises(InputError, match="found 28; expected 29 or more"):
        allowed_failures(28, 0.9)
    most, least, largest = allowed_failures(50, 0.9)
    assert (most, least, largest) == (5, 1, 9)
    assert binom.cdf(least, 50, 0.1) < 0.05 < 1 - binom.cdf(largest - 1, 50, 0.1)
