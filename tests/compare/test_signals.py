"""Lags, bands and fits against what was made."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from recorded_runs import sea

from hydrosim.compare.comparison import best_lag, correlation, fit, rms, split_bands

STEP = 0.2
TIME = STEP * np.arange(3001)


@pytest.mark.parametrize("lag", [0.0, 0.3, -0.3, 1.234, -7.9])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_lag_of_waves(lag: float, sign: float) -> None:
    """The series is known between its times; the spline through ours is what is not exact."""
    ours, recorded = sea(TIME, 3), sign * sea(TIME - lag, 3)
    assert best_lag(TIME, ours, recorded, 30.0) == pytest.approx(lag, abs=1e-3)


def test_smallest_of_equal_lags() -> None:
    """A sine is itself a period later: the smaller lag is meant, not the better rounding."""
    omega = 2.0 * np.pi / 7.77
    ours, recorded = np.sin(omega * TIME), np.sin(omega * (TIME - 0.3))
    assert best_lag(TIME, ours, recorded, 60.0) == pytest.approx(0.3, abs=1e-3)


def test_lag_of_uneven_times() -> None:
    time = np.sort(TIME + 0.05 * np.sin(TIME))
    assert best_lag(time, sea(time, 3), sea(time - 0.3, 3), 30.0) == pytest.approx(0.3, abs=2e-3)


def test_fit() -> None:
    """Gain, lag and offset at once, with noise that remains."""
    noise = 0.01 * np.random.default_rng(1).normal(size=TIME.size)
    ours = 0.8 * sea(TIME, 3) + 4.0
    recorded = 1.02 * (0.8 * sea(TIME - 0.3, 3) + 4.0) + 0.05 + noise
    found = fit(TIME, ours, recorded, 30.0)
    assert found.gain == pytest.approx(1.02, abs=1e-3)
    assert found.lag == pytest.approx(0.3, abs=5e-3)
    assert found.offset + (found.gain - 1.02) * 4.0 == pytest.approx(0.05, abs=2e-3)
    assert found.rest == pytest.approx(0.01, rel=0.05)


def test_fit_of_constants() -> None:
    found = fit(TIME, np.full(TIME.size, 2.0), sea(TIME, 1), 30.0)
    assert (found.lag, found.correlation) == (0.0, 0.0)
    assert np.isfinite(found).all()


def test_bands() -> None:
    """Sines of whole periods are in the band of their frequency, and a mean with a trend is slow;
    together they are the series."""
    length = TIME[-1] + STEP
    omega = 2.0 * np.pi / length * np.array([5, 80, 400])
    sines = np.sin(np.multiply.outer(omega, TIME))
    parts = split_bands(TIME, 2.0 + sines.sum(axis=0), (0.1, 2.5))
    assert omega[0] < 0.1 < omega[1] < 2.5 < omega[2]
    assert_allclose(sum(parts), 2.0 + sines.sum(axis=0), atol=1e-12)
    # the trend taken off first is not quite zero: 3 / (pi n) of a sine of n periods
    assert rms(parts[1] - sines[1]) < 0.06
    assert rms(parts[2] - sines[2]) < 0.06
    trend = split_bands(TIME, 3.0 + 0.01 * TIME, (0.1, 2.5))
    assert_allclose(trend[0], 3.0 + 0.01 * TIME, atol=1e-9)


def test_correlation_is_numpys() -> None:
    a, b = sea(TIME, 1), sea(TIME, 2) + 0.3 * sea(TIME, 1)
    assert correlation(a, b) == pytest.approx(np.corrcoef(a, b)[0, 1], abs=1e-12)
