"""Figures of wave trains, against their closed forms and against components that are drawn."""

import math

import numpy as np
import pytest

from hydrosim.scene import (
    Amplitudes,
    Density,
    DirectionalTable,
    Environment,
    GivenComponents,
    Jonswap,
    OchiHubble,
    OchiHubblePeak,
    RecordedElevation,
    RegularWave,
    SpectrumTable,
    WaveTrain,
    WhiteNoise,
)
from hydrosim.water.components import components, energy_outside, energy_outside_band, sea_state

WATER = Environment()
HEADING = math.radians(30.0)
ONE_SIDED = DirectionalTable(
    np.array([0.3, 0.6, 0.9, 1.2]),
    np.radians([0.0, 20.0, 40.0, 60.0]),
    np.outer([0.0, 2.0, 1.0, 0.0], [1.0, 3.0, 2.0, 0.5]),
)
DENSITIES: list[Density] = [
    Jonswap(1.5, 8.0),
    OchiHubble((OchiHubblePeak(1.2, 14.0, 3.0), OchiHubblePeak(0.9, 7.0, 1.2))),
    SpectrumTable(np.array([0.4, 0.6, 1.0]), np.array([0.0, 2.0, 0.0])),
    WhiteNoise(2.0, 0.3, 1.5),
    ONE_SIDED,
]


@pytest.mark.parametrize("spectrum", DENSITIES, ids=lambda each: type(each).__name__)
@pytest.mark.parametrize("spreading", [None, 6.0])
def test_a_random_sea_is_as_its_draws(spectrum: Density, spreading: float | None) -> None:
    """400 draws of the components have the height, the directions and the shares outside."""
    band = (0.5, 0.9)
    squares, resultant, outside, energy = 0.0, 0j, 0.0, 0.0
    for seed in range(400):
        train = WaveTrain(spectrum, HEADING, seed, 0.0, 3600.0, Amplitudes.RAYLEIGH, spreading)
        waves = components(train, WATER)
        half = waves.amplitude**2 / 2.0
        squares += half.sum() / 400
        resultant += np.sum(half * np.exp(1j * waves.heading))
        outside += sum(energy_outside(waves, np.array(band))) * half.sum()
        energy += half.sum()
    state = sea_state(train, WATER)
    assert state.significant_height == pytest.approx(4.0 * math.sqrt(squares), rel=5e-3)
    mean = resultant / energy
    assert state.heading == pytest.approx(np.angle(mean), abs=math.radians(0.5))
    assert state.spreading == pytest.approx(math.sqrt(max(2.0 * (1.0 - abs(mean)), 0.0)), abs=0.01)
    share = energy_outside_band(train, WATER, *band)
    assert share == pytest.approx(outside / energy, abs=3e-3)


def test_the_peak_is_that_of_the_density() -> None:
    periods = [sea_state(WaveTrain(spectrum), WATER).peak_period for spectrum in DENSITIES]
    assert periods[0] == pytest.approx(8.0, rel=1e-3)
    assert periods[1] == pytest.approx(14.0, rel=0.01)
    assert periods[2] == pytest.approx(2.0 * math.pi / 0.6, rel=1e-3)
    assert math.isnan(periods[3])
    assert periods[4] == pytest.approx(2.0 * math.pi / 0.6, rel=1e-3)


def test_a_regular_wave_and_given_components() -> None:
    regular = sea_state(WaveTrain(RegularWave(2.0, 9.0), -HEADING), WATER)
    assert regular.significant_height == pytest.approx(4.0 * math.sqrt(2.0))
    assert regular.peak_period == pytest.approx(9.0)
    assert regular.heading == pytest.approx(2.0 * math.pi - HEADING)
    assert regular.spreading == pytest.approx(0.0, abs=1e-7)
    omega, heading = np.array([0.4, 0.8]), np.array([0.0, math.pi / 2.0])
    given = GivenComponents(omega, np.array([2.0, 1.0]), np.zeros(2), heading)
    state = sea_state(WaveTrain(given), WATER)
    assert state.significant_height == pytest.approx(4.0 * math.sqrt(2.5))
    assert state.peak_period == pytest.approx(2.0 * math.pi / 0.4)
    assert state.heading == pytest.approx(math.atan2(0.5, 2.0))
    assert state.spreading == pytest.approx(math.sqrt(2.0 * (1.0 - math.hypot(2.0, 0.5) / 2.5)))
    assert energy_outside_band(WaveTrain(given), WATER, 0.5, 1.0) == pytest.approx(0.8)


def test_opposite_waves_have_no_mean_direction() -> None:
    omega, heading = np.array([0.5, 0.5]), np.array([0.0, math.pi])
    given = GivenComponents(omega, np.ones(2), np.zeros(2), heading)
    state = sea_state(WaveTrain(given), WATER)
    assert math.isnan(state.heading)
    assert state.spreading == pytest.approx(math.sqrt(2.0))


def test_a_record_has_the_peak_of_the_sea_that_it_is_from() -> None:
    """A record's own lines scatter; the density over a tenth of the frequency does not."""
    sea = components(WaveTrain(Jonswap(2.0, 10.0), repeat_period=3600.0), WATER)
    time = np.arange(0.0, 3600.0, 0.5)
    lines = sea.amplitude * np.exp(1j * sea.phase)
    elevation = np.real(np.exp(1j * np.outer(time, sea.omega)) @ lines)
    state = sea_state(WaveTrain(RecordedElevation(time, elevation), HEADING), WATER)
    assert state.significant_height == pytest.approx(2.0, rel=2e-3)
    assert state.peak_period == pytest.approx(10.0, rel=0.03)
    assert state.heading == pytest.approx(HEADING)
