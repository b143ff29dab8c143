import numpy as np
import pytest

from hydrosim.water.spectra import wavenumber

G = 9.81


@pytest.mark.parametrize("depth", [0.5, 30.0, 4000.0])
def test_inverse_of_the_dispersion_relation(depth: float) -> None:
    # omega from a known k: k's relative error is at most that of omega^2, a few roundings
    k = np.logspace(-3, 3, 2001) / depth
    omega = np.sqrt(G * k * np.tanh(k * depth))
    np.testing.assert_allclose(wavenumber(omega, depth, G), k, rtol=5e-15)


def test_infinite_depth_is_the_limit_of_deep_water() -> None:
    omega = np.linspace(0.1, 5.0, 50)
    np.testing.assert_array_equal(wavenumber(omega, np.inf, G), omega**2 / G)
    np.testing.assert_allclose(wavenumber(omega, 1e5, G), omega**2 / G, rtol=1e-15)


def test_long_waves_in_shallow_water_travel_at_root_gh() -> None:
    omega = np.array([1e-4])  # (k h)^2 / 6 = 5e-9 is the relative error of the limit
    np.testing.assert_allclose(wavenumber(omega, 30.0, G), omega / np.sqrt(G * 30.0), rtol=1e-8)


def test_no_wave_has_no_wavenumber() -> None:
    np.testing.assert_array_equal(wavenumber([[0.0, 0.0]], 30.0, G), [[0.0, 0.0]])
