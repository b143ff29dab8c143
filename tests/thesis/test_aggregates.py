"""Means over seeds and shares of seeds, with their intervals."""

import numpy as np
import pytest
from scipy.stats import norm, t

from cases.reverse_float_over.thesis.aggregates import mean_of, share_of


def test_mean_has_the_interval_of_student():
    values = np.random.default_rng(1).normal(-1.2, 0.3, 50)
    mean = mean_of(values)
    error = values.std(ddof=1) / np.sqrt(50)
    assert (mean.n, mean.least, mean.most) == (50, values.min(), values.max())
    assert mean.mean == pytest.approx(values.mean(), rel=1e-14)
    assert mean.deviation == pytest.approx(values.std(ddof=1), rel=1e-14)
    expected = t.interval(0.9, 49, values.mean(), error)
    assert (mean.lower, mean.upper) == pytest.approx(expected, rel=1e-14)


def test_interval_of_the_mean_holds_it_in_nine_of_ten_samples():
    samples = np.random.default_rng(2).normal(3.0, 2.0, (4000, 6))
    held = [mean_of(sample).lower <= 3.0 <= mean_of(sample).upper for sample in samples]
    assert np.mean(held) == pytest.approx(0.9, abs=3 * np.sqrt(0.09 / 4000))


def test_values_that_are_no_numbers_do_not_count():
    assert mean_of([1.0, np.nan, 3.0]) == mean_of([1.0, 3.0])
    assert mean_of([1.0, np.nan, 3.0]).n == 2


def test_one_value_or_none_has_no_interval():
    assert mean_of([2.0])[:2] == (1, 2.0)
    assert np.isnan(mean_of([2.0]).upper)
    assert mean_of([]).n == 0
    assert np.isnan(mean_of([]).mean)


@pytest.mark.parametrize(("agree", "n"), [(0, 50), (1, 50), (31, 50), (50, 50), (2, 3)])
def test_share_has_the_interval_of_wilson(agree, n):
    share = share_of([True] * agree + [False] * (n - agree))
    z = norm.ppf(0.95)
    p = agree / n
    middle = (p + z**2 / (2 * n)) / (1 + z**2 / n)
    half = z / (1 + z**2 / n) * np.sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
    assert share[:3] == (agree, n, p)
    assert (share.lower, share.upper) == pytest.approx((middle - half, middle + half), abs=1e-12)


def test_no_seeds_have_no_share():
    assert share_of([]).n == 0
    assert np.isnan(share_of([]).share)
