import numpy as np
import pytest

from hydrosim.scene import Environment, Jonswap, RegularWave, WaveTrain
from hydrosim.water.components import sea
from hydrosim.water.loads import elevations

POINTS = np.array([[0.0, 0.0], [120.0, -35.0]])
SEAS = sea(
    Environment(
        water_depth=40.0,
        waves=(
            WaveTrain(Jonswap(1.5, 8.0), 0.4, repeat_period=900.0, ramp=50.0, spreading=8.0),
            WaveTrain(RegularWave(0.7, 11.0, 0.3), heading=1.0),
        ),
    )
)


def direct(time: np.ndarray) -> np.ndarray:
    total = np.zeros((time.size, len(POINTS)))
    for waves in SEAS:
        ramp = np.clip(time / waves.ramp, 0.0, 1.0) if waves.ramp else np.ones(time.size)
        for i, (x, y) in enumerate(POINTS):
            along = waves.wavenumber * (x * np.cos(waves.heading) + y * np.sin(waves.heading))
            angle = np.outer(time, waves.omega) - along + waves.phase
            steady = np.sum(waves.amplitude * np.cos(angle), axis=1)
            total[:, i] += (0.5 - 0.5 * np.cos(np.pi * ramp)) * steady
    return total


@pytest.mark.parametrize(
    "time",
    [
        0.5 * np.arange(1001),  # a part of the repeat period: by FFT
        100.0 + 1.5 * np.arange(300),  # too coarse for the highest components
        np.append(0.5 * np.arange(1001), 500.13),  # the end of a run is off the grid
        0.37 * np.arange(300),  # no part of the repeat period
        np.array([3.0, 7.0]),
    ],
    ids=["fft", "coarse", "end", "off", "few"],
)
def test_probes_are_the_sum_of_the_components(time: np.ndarray) -> None:
    # rounding: 900 components x eps x angles of up to 2000 rad
    np.testing.assert_allclose(elevations(SEAS, POINTS, time), direct(time), atol=1e-12)


def test_no_waves_no_elevation() -> None:
    np.testing.assert_array_equal(elevations((), POINTS, np.arange(3.0)), np.zeros((3, 2)))
