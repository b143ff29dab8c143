"""What the order of runs says of another, drawn from laws of all kinds."""

from collections.abc import Callable

import numpy as np
import pytest

from hydrosim.statistics.gumbel import (
    VALUES_FOR_INTERVAL,
    find_confidence,
    find_prediction,
    fit_maxima,
    fits_gumbel,
    length_ratio,
)

Draw = Callable[[np.random.Generator, int], np.ndarray]
STUDIES = 600


def with_and_without_impact(random: np.random.Generator, count: int) -> np.ndarray:
    """Six runs of ten have waves alone, the others an impact."""
    waves = random.normal(3.7, 0.25, count)
    impacts = 5.0 + random.exponential(2.0, count)
    return np.where(random.random(count) < 0.6, waves, impacts)


def held(random: np.random.Generator, count: int) -> np.ndarray:
    """Something stops the motion."""
    return np.minimum(random.normal(3.7, 0.5, count), 4.0 + 0.01 * random.random(count))


@pytest.mark.parametrize("count", [2, 10, VALUES_FOR_INTERVAL, 50])
@pytest.mark.parametrize("draw", [with_and_without_impact, held])
def test_another_is_held_as_often_as_is_said(draw: Draw, count: int) -> None:
    """Whatever the law; three standard errors of a share."""
    random = np.random.default_rng(count)
    inside = []
    for _ in range(STUDIES):
        *values, other = draw(random, count + 1)
        found = find_prediction(np.array(values))
        inside.append(found.low <= other <= found.high)
    said = find_prediction(np.arange(float(count))).probability
    assert np.mean(inside) == pytest.approx(said, abs=3.0 * np.sqrt(said * (1.0 - said) / STUDIES))
    assert said == pytest.approx((count - 1) / (count + 1)) or count > VALUES_FOR_INTERVAL
    assert (said >= 0.9 - 1e-12) == (count >= VALUES_FOR_INTERVAL)


@pytest.mark.parametrize(("probability", "count"), [(np.exp(-1.0), 10), (0.9, 50), (0.9, 19)])
def test_quantiles_are_held(probability: float, count: int) -> None:
    """In 90 % or more. Nineteen runs do not know how large P90 may be."""
    random = np.random.default_rng(7)
    true = np.quantile(with_and_without_impact(random, 400000), probability)
    inside = []
    for _ in range(STUDIES):
        low, high = find_confidence(with_and_without_impact(random, count), probability)
        inside.append(low <= true <= high)
    assert np.mean(inside) >= 0.9 - 3.0 * np.sqrt(0.09 / STUDIES)
    assert np.isinf(high) == (count == 19)


def test_maxima_of_two_kinds_do_not_follow_gumbels_law() -> None:
    """One in ten that does is doubted; of two kinds nearly all are, by 19 runs."""
    random = np.random.default_rng(8)
    drawn = [random.gumbel(size=VALUES_FOR_INTERVAL) for _ in range(STUDIES)]
    doubted = np.mean([not fits_gumbel(x, fit_maxima(x)) for x in drawn])
    assert doubted == pytest.approx(0.1, abs=3.0 * np.sqrt(0.09 / STUDIES))
    drawn = [with_and_without_impact(random, VALUES_FOR_INTERVAL) for _ in range(STUDIES)]
    assert np.mean([not fits_gumbel(x, fit_maxima(x)) for x in drawn]) > 0.9


@pytest.mark.slow
@pytest.mark.parametrize("count", [VALUES_FOR_INTERVAL, 50])
@pytest.mark.parametrize("draw", [with_and_without_impact, held])
def test_runs_of_an_operation(draw: Draw, count: int) -> None:
    """By Gumbel's law where they follow it, else by their order: intervals of another run and of
    the most probable value hold in 85 to 96 %, within three standard errors."""
    random = np.random.default_rng(9)
    true = np.quantile(draw(random, 400000), np.exp(-1.0))
    inside = []
    for _ in range(STUDIES):
        *drawn, other = draw(random, count + 1)
        values = np.array(drawn)
        law = fit_maxima(values)
        if fits_gumbel(values, law):
            low, high = law.confidence_interval(length_ratio(np.exp(-1.0)))
            least, most = law.prediction_interval(1.0)
        else:
            low, high = find_confidence(values, np.exp(-1.0))
            least, most, _ = find_prediction(values)
        inside.append((low <= true <= high, least <= other <= most))
    shares = np.mean(inside, axis=0)
    assert np.all(shares >= 0.85 - 3.0 * np.sqrt(0.13 / STUDIES))
    assert np.all(shares <= 0.96 + 3.0 * np.sqrt(0.04 / STUDIES))
