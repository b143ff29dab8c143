import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from hydrosim.water.transfer import interpolate_spline


@pytest.mark.parametrize("n", [2, 3, 4, 5, 40])
def test_agrees_with_scipy(n: int) -> None:
    """To rounding: the same spline, by the same equations for its slopes."""
    random = np.random.default_rng(n)
    x = np.cumsum(random.uniform(0.1, 1.0, n))
    y = random.normal(size=(n, 3, 2)) + 1j * random.normal(size=(n, 3, 2))
    at = np.concatenate([random.uniform(x[0], x[-1], 100), x])
    np.testing.assert_allclose(interpolate_spline(x, y, at), CubicSpline(x, y)(at), atol=1e-12)


def test_cubics_are_exact() -> None:
    x, at = np.array([0.0, 0.5, 1.5, 2.0, 4.0]), np.linspace(0.0, 4.0, 50)
    found = interpolate_spline(x, x**3 - 2.0 * x, at)
    np.testing.assert_allclose(found, at**3 - 2.0 * at, atol=1e-12)
