"""Peaks and Weibull's law of them, against scipy's fit and known laws."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import fmin
from scipy.stats import weibull_min

from hydrosim.statistics.series import fit_weibull, peaks


@pytest.mark.parametrize(("shape", "scale", "count"), [(0.8, 3e6, 40), (2.0, 0.5, 1000), (5, 1, 9)])
def test_the_fit_is_scipys(shape: float, scale: float, count: int) -> None:
    random = np.random.default_rng(count)
    x = weibull_min.rvs(shape, scale=scale, size=count, random_state=random)
    k, _, b = weibull_min.fit(x / scale, floc=0.0, optimizer=_fine)
    law = fit_weibull(x)
    assert (law.shape, law.scale / scale) == pytest.approx((k, b), rel=1e-6)


def _fine(of: Callable, start: np.ndarray, args: tuple, disp: int) -> np.ndarray:
    """scipy's search, but to the rounding of the likelihood."""
    return fmin(of, start, args, xtol=1e-10, ftol=1e-15, maxiter=10_000, maxfun=10_000, disp=disp)


def test_peaks_of_known_waves() -> None:
    """Two in turn about a mean of 3, and none where nothing crosses the mean twice."""
    time = np.arange(0.0, 400.0, 0.01)
    size = np.where(np.floor(time / 10.0) % 2 == 0, 1.0, 2.0)
    x = 3.0 + size * np.sin(2 * np.pi * time / 10.0)
    found = peaks(x)
    assert found.size >= 38
    np.testing.assert_allclose(np.unique(found.round(3)), [1.0, 2.0])
    assert peaks(time).size == 0
    assert np.isnan(fit_weibull(peaks(time))).all()


def test_rayleighs_law_has_the_shape_two() -> None:
    quantiles = np.sqrt(-2.0 * np.log(1.0 - (np.arange(4000) + 0.5) / 4000))
    law = fit_weibull(quantiles)
    assert law.shape == pytest.approx(2.0, rel=2e-3)
    assert law.scale == pytest.approx(np.sqrt(2.0), rel=1e-3)
