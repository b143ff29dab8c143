from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import trapezoid

from hydrosim.scene import Jonswap
from hydrosim.waves.spectra import TAIL_ENERGY, cut_off, density

HS, TP = 1.5, 8.0
PEAK = 2.0 * np.pi / TP
GAMMAS = [1.0, 2.0, 3.3, 7.0]


def moment(spectrum: Jonswap, order: int, low: float = 0.0) -> float:
    """Trapezoidal moment up to 200 peak frequencies; beyond is 5e-10 of m0, 2e-5 of m2."""
    omega = np.concatenate([np.linspace(low, 4.0, 400_001), np.geomspace(4.0, 200 * PEAK, 400_001)])
    return float(trapezoid(omega**order * density(spectrum, omega), omega))


@pytest.mark.parametrize("gamma", GAMMAS)
def test_significant_height_is_four_root_m0(gamma: float) -> None:
    assert 4.0 * np.sqrt(moment(Jonswap(HS, TP, gamma), 0)) == pytest.approx(HS, rel=1e-8)


def test_without_enhancement_it_is_pierson_moskowitz() -> None:
    omega = np.linspace(0.2, 6.0, 500)
    bretschneider = 5.0 / 16.0 * HS**2 * PEAK**4 * omega**-5 * np.exp(-1.25 * (PEAK / omega) ** 4)
    np.testing.assert_allclose(density(Jonswap(HS, TP, 1.0), omega), bretschneider, rtol=1e-12)


@pytest.mark.parametrize("gamma", GAMMAS)
def test_scale_is_goda_s(gamma: float) -> None:
    # the common fit 1 - 0.287 ln(gamma), which is good to about 2 % up to gamma = 7
    peak = (1 - 0.287 * np.log(gamma)) * 5 / 16 * HS**2 / PEAK * np.exp(-1.25) * gamma
    assert density(Jonswap(HS, TP, gamma), PEAK) == pytest.approx(peak, rel=0.02)


@pytest.mark.parametrize("gamma", GAMMAS)
def test_zero_crossing_period(gamma: float) -> None:
    # DNV-RP-C205 (2014), 3.5.5.5: a fit for gamma from 1 to 7
    fit = TP * (0.6673 + 0.05037 * gamma - 0.006230 * gamma**2 + 0.0003341 * gamma**3)
    spectrum = Jonswap(HS, TP, gamma)
    crossing = 2 * np.pi * np.sqrt(moment(spectrum, 0) / moment(spectrum, 2))
    assert crossing == pytest.approx(fit, rel=0.005)


@pytest.mark.parametrize("gamma", GAMMAS)
def test_cut_off_leaves_the_stated_energy(gamma: float) -> None:
    spectrum = Jonswap(HS, TP, gamma)
    omega = np.geomspace(cut_off(spectrum), 1000 * PEAK, 200_001)
    tail = trapezoid(density(spectrum, omega), omega)
    assert tail == pytest.approx(TAIL_ENERGY * HS**2 / 16, rel=1e-6)


def test_nothing_at_and_below_zero_frequency() -> None:
    np.testing.assert_array_equal(density(Jonswap(HS, TP), [-1.0, 0.0, 1e-9, 1e-3]), 0.0)
