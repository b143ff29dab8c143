from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Environment, Jonswap, WaveTrain
from hydrosim.water.components import WaveComponents, components
from hydrosim.water.loads import Grid, SpectralLines, add_sum, time_grid
from hydrosim.water.second_order import difference_loads, newman
from hydrosim.water.spectra import density

JONSWAP = Jonswap(1.5, 8.0, 3.3)


def sea(repeat_period: float = 600.0, seed: int = 1) -> WaveComponents:
    train = WaveTrain(JONSWAP, seed=seed, repeat_period=repeat_period)
    return components(train, Environment())


def grid_of(waves: WaveComponents, start: float, dt: float, duration: float) -> Grid:
    return time_grid(waves.spacing, waves.omega.max(), start, dt, duration)


def summed(grid: Grid, lines: SpectralLines) -> np.ndarray:
    """The loads on the grid, (rows, n)."""
    total = np.zeros((grid.rows, lines.amplitude.shape[1]))
    add_sum(grid, lines, total)
    return total


def elevation(waves: WaveComponents, grid: Grid) -> np.ndarray:
    return summed(grid, SpectralLines(waves.omega, waves.amplitudes_at(0.0, 0.0)[:, None]))[:, 0]


def slow_load(waves: WaveComponents, grid: Grid, drift: np.ndarray) -> np.ndarray:
    return summed(grid, difference_loads(waves, waves.amplitudes_at(0.0, 0.0), newman(drift)))


def some_amplitudes(waves: WaveComponents, columns: int) -> np.ndarray:
    random = np.random.default_rng(7)
    shape = (waves.omega.size, columns)
    return random.normal(size=shape) + 1j * random.normal(size=shape)


@pytest.mark.parametrize(
    ("start", "dt", "duration"),
    [(0.0, 0.05, 600.0), (123.4, 0.05, 50.0), (0.0, 0.5, 100.0), (7.0, 0.07, 100.0)],
)
def test_transform_is_the_direct_sum(start: float, dt: float, duration: float) -> None:
    waves = sea()
    amplitude = some_amplitudes(waves, 3)
    grid = grid_of(waves, start, dt, duration)
    rows = np.linspace(0, grid.rows - 1, 50).astype(int)
    time = (grid.first + rows) * grid.step
    expected = np.exp(1j * np.outer(time, waves.omega)) @ amplitude
    # rounding: sqrt(components) x size x eps x the angle of up to 2500 rad at the end
    atol = 1e-12 * np.abs(amplitude).sum(axis=0).max()
    found = summed(grid, SpectralLines(waves.omega, amplitude))
    np.testing.assert_allclose(found[rows], expected.real, atol=atol)


def test_lines_in_any_order_and_any_number_of_times() -> None:
    waves = sea()
    amplitude = some_amplitudes(waves, 2)
    grid = grid_of(waves, 0.0, 0.5, 60.0)
    order = np.random.default_rng(5).permutation(waves.omega.size)
    shuffled = SpectralLines(
        np.tile(waves.omega[order], 2), np.tile(0.5 * amplitude[order], (2, 1))
    )
    expected = summed(grid, SpectralLines(waves.omega, amplitude))
    np.testing.assert_allclose(summed(grid, shuffled), expected, atol=1e-12)


@pytest.mark.parametrize("dt", [0.05, 0.25, 0.5, 1.0 / 3.0])
def test_stages_are_nodes(dt: float) -> None:
    grid = grid_of(sea(), 30.0, dt, 100.0)
    index = np.arange(30.0, 130.0, dt) / grid.step
    np.testing.assert_allclose(index, np.round(index), atol=1e-9)
    assert grid.start <= 30.0 - 3 * grid.step + 1e-9
    assert grid.start + (grid.rows - 1) * grid.step >= 130.0 + 3 * grid.step - 1e-9


@pytest.mark.parametrize("dt", [1e-5, 0.001, 0.01, 0.0137, 0.05, 0.07, 0.3, 2.0])
def test_grid_resolves_the_highest_component(dt: float) -> None:
    waves = sea()
    grid = grid_of(waves, 0.0, dt, 10.0)
    phase = waves.omega[-1] * grid.step
    assert phase <= 0.25
    assert grid.step <= dt * (1 + 1e-12) or phase <= 0.125
    assert grid.step * grid.period == pytest.approx(600.0, rel=1e-14)


@pytest.mark.parametrize("dt", [1e-5, 0.0005, 0.001, 0.004, 0.0137, 1.0 / 300.0])
def test_grid_is_no_finer_than_it_must_be_and_its_points_are_stages(dt: float) -> None:
    """At most twice as fine; for any stages, even if their number in the period has no divisors."""
    waves = sea()
    grid = grid_of(waves, 30.0, dt, 10.0)
    assert 0.0625 < waves.omega[-1] * grid.step <= 0.125
    if abs(600.0 / dt - round(600.0 / dt)) < 1e-6:
        assert grid.step / dt == pytest.approx(round(grid.step / dt), rel=1e-12)
    other = grid_of(waves, 0.0, dt, 600.0)
    assert (other.step, other.period) == (grid.step, grid.period)


def test_newman_is_the_double_sum(validated: Callable[..., None]) -> None:
    waves = sea(repeat_period=300.0)
    random = np.random.default_rng(3)
    drift = random.normal(size=(waves.omega.size, 2))
    grid = grid_of(waves, 0.0, 0.5, 20.0)
    found = slow_load(waves, grid, drift)
    for row in range(0, grid.rows, 7):
        t = (grid.first + row) * grid.step
        for column in range(2):
            D = drift[:, column]
            theta = waves.omega * t + waves.phase
            pairs = np.cos(theta[:, None] - theta) * np.outer(waves.amplitude, waves.amplitude)
            double = np.sum(pairs * 0.5 * (D[:, None] + D))
            scale = np.sum(np.abs(pairs))
            error = abs(found[row, column] - double) / scale
            claim = "slow drift of a random sea after Newman"
            against = "double sum, pair by pair"
            validated(Kind.INDEPENDENT, claim, against, error, 1e-12, Feature.NEWMAN)


def test_mean_of_the_slow_load_is_the_mean_drift() -> None:
    waves = sea()
    drift = np.cos(waves.omega)[:, None] + 0.3
    grid = grid_of(waves, 0.0, 0.05, 600.0)
    slow = slow_load(waves, grid, drift)[3 : 3 + grid.period]
    assert slow.mean() == pytest.approx(np.sum(waves.amplitude**2 * drift[:, 0]), rel=1e-12)


def test_slow_load_of_equal_drift_is_the_envelope_squared() -> None:
    # with one D for all frequencies Newman's sum is D |eta_complex|^2: two tones beat from
    # D (a - b)^2 to D (a + b)^2
    waves = replace(
        sea(),
        omega=2 * np.pi / 600 * np.array([80, 90]),
        amplitude=np.array([1.0, 0.6]),
        phase=np.zeros(2),
        wavenumber=np.zeros(2),
        heading=np.zeros(2),
    )
    grid = grid_of(waves, 0.0, 0.05, 60.0)
    slow = slow_load(waves, grid, np.full((2, 1), 5.0))
    assert slow.max() == pytest.approx(5.0 * 1.6**2, rel=1e-9)
    assert slow.min() == pytest.approx(5.0 * 0.4**2, rel=1e-6)


def test_over_the_repeat_period_every_line_is_the_spectrum() -> None:
    waves = sea(repeat_period=10800.0)
    grid = grid_of(waves, 0.0, 0.05, 10800.0)
    record = elevation(waves, grid)[3 : 3 + grid.period]
    lines = np.abs(np.fft.rfft(record) / grid.period * 2) ** 2 / 2
    expected = np.zeros(lines.size)
    expected[waves.index] = density(JONSWAP, waves.omega) * waves.spacing
    np.testing.assert_allclose(lines, expected, rtol=1e-9, atol=1e-20)


def test_shorter_records_have_the_spectrum_within_sampling() -> None:
    """Records of 3 hours out of a sea of 12: 172 Fourier lines of a record in each 0.1 rad/s.

    Their energy has the relative standard deviation 1/sqrt(lines) where the spectrum is flat, and
    sqrt(sum S^2) / sum S in general; over 8 seeds it is sqrt(8) less. Leakage through a Hann
    window, which makes neighbouring lines depend on each other, widens it by sqrt(35/18).
    """
    duration, seeds = 10800.0, 8
    band = np.arange(0.5, 2.0, 0.1)
    energy = []
    for seed in range(1, seeds + 1):
        waves = sea(repeat_period=4 * duration, seed=seed)
        grid = grid_of(waves, 5000.0, 0.1, duration)
        record = elevation(waves, grid)
        window = np.hanning(record.size)
        omega = 2 * np.pi * np.fft.rfftfreq(record.size, grid.step)
        power = 2 * np.abs(np.fft.rfft(window * record)) ** 2 / np.sum(window**2) / record.size
        energy.append(np.histogram(omega, band, weights=power)[0])
    lines = np.arange(0.5, 1.9, 2 * np.pi / duration)
    line_energy = density(JONSWAP, lines) * 2 * np.pi / duration
    expected = np.histogram(lines, band, weights=line_energy)[0]
    spread = np.sqrt(np.histogram(lines, band, weights=line_energy**2)[0] * 35 / 18 / seeds)
    deviation = (np.mean(energy, axis=0) - expected) / spread
    assert np.max(np.abs(deviation)) < 4.0
