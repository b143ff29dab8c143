"""What is drawn: amplitudes, phases and directions, and what seas of many seeds have in common."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2, kstest

from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Amplitudes, DirectionalTable, Environment, Jonswap, WaveTrain
from hydrosim.water.components import WaveComponents, components, spreading_angles
from hydrosim.water.loads import elevations
from hydrosim.water.spectra import density, energy

SEA = WaveTrain(Jonswap(1.5, 8.0), heading=0.5, repeat_period=600.0)
RAYLEIGH = replace(SEA, amplitudes=Amplitudes.RAYLEIGH)
LONG = replace(SEA, repeat_period=10800.0)
DEEP = Environment()
SEEDS = range(100)


def seas(train: WaveTrain) -> list[WaveComponents]:
    return [components(replace(train, seed=seed), DEEP) for seed in SEEDS]


def test_neither_amplitudes_nor_directions_change_the_phases() -> None:
    plain = components(SEA, DEEP)
    for other in (RAYLEIGH, replace(SEA, spreading=5.0), replace(RAYLEIGH, spreading=5.0)):
        np.testing.assert_array_equal(components(other, DEEP).phase, plain.phase)
    one, both = components(RAYLEIGH, DEEP), components(replace(RAYLEIGH, spreading=5.0), DEEP)
    np.testing.assert_array_equal(one.amplitude, both.amplitude)


def test_streams_are_independent() -> None:
    waves = components(replace(LONG, amplitudes=Amplitudes.RAYLEIGH, spreading=5.0), DEEP)
    energies = waves.amplitude**2 / np.maximum(2 * density(SEA.spectrum, waves.omega), 1e-300)
    for one, other in (
        (waves.phase, waves.heading),
        (waves.phase, energies),
        (waves.heading, energies),
    ):
        kept = waves.amplitude > 1e-12
        correlation = np.corrcoef(one[kept], other[kept])[0, 1]
        assert abs(correlation) < 4 / np.sqrt(np.sum(kept))


def test_rayleigh_amplitudes_have_energies_of_two_degrees_of_freedom() -> None:
    waves = components(replace(LONG, amplitudes=Amplitudes.RAYLEIGH), DEEP)
    expected = density(LONG.spectrum, waves.omega) * waves.spacing
    kept = expected > 1e-12
    assert kstest(waves.amplitude[kept] ** 2 / expected[kept], chi2(2).cdf).pvalue > 1e-3


def test_hs_of_a_hundred_seeds(validated: Callable[..., None]) -> None:
    lines = density(SEA.spectrum, components(SEA, DEEP).omega) * 2 * np.pi / 600
    time = 0.5 * np.arange(1200)
    for train, spread_of_m0 in ((SEA, 0.0), (RAYLEIGH, np.sqrt(np.sum(lines**2)))):
        m0 = [elevations([w], np.zeros((1, 2)), time).var() for w in seas(train)]
        # four standard deviations of the mean and of the standard deviation of 100 values
        assert np.mean(m0) == pytest.approx(lines.sum(), abs=0.4 * spread_of_m0 + 1e-12)
        assert np.std(m0) == pytest.approx(spread_of_m0, rel=0.4, abs=1e-12)
    # and of the whole axis: 0.1 % is above the cut-off
    error = abs(lines.sum() / energy(SEA.spectrum) - 1.0)
    claim = "energy of a random sea"
    validated(Kind.CLOSED_FORM, claim, "integral of its spectrum", error, 2e-3, Feature.SEA)


@pytest.mark.parametrize("train", [SEA, RAYLEIGH], ids=["deterministic", "rayleigh"])
def test_spectrum_of_records_is_the_spectrum(train: WaveTrain) -> None:
    """Periodograms of whole repeat periods, averaged over 100 seeds and bands of ten lines."""
    step, count = 0.5, 1200
    records = [
        elevations([w], np.zeros((1, 2)), step * np.arange(count))[:, 0] for w in seas(train)
    ]
    power = 2 * np.abs(np.fft.rfft(records, axis=1) / count) ** 2 / (2 * np.pi / 600)
    omega = 2 * np.pi / 600 * np.arange(power.shape[1])
    bands = slice(40, 240)  # 0.42 to 2.5 rad/s
    found = power.mean(axis=0)[bands].reshape(-1, 10).mean(axis=1)
    lines = density(train.spectrum, omega)[bands].reshape(-1, 10)
    # of Rayleigh amplitudes each line has its own size as standard deviation
    error = np.sqrt(np.sum(lines**2, axis=1) / 100) / 10 * (train.amplitudes == "rayleigh")
    assert np.all(np.abs(found - lines.mean(axis=1)) < 4.5 * error + 1e-10)


@pytest.mark.parametrize("exponent", [0.5, 2.0, 10.0, 75.0])
def test_directions_have_the_moments_of_cosine_2s(
    exponent: float, validated: Callable[..., None]
) -> None:
    # Longuet-Higgins et al. (1963): mean of cos is s / (s + 1), of cos 2x s(s-1)/((s+1)(s+2))
    waves = components(replace(LONG, spreading=exponent), DEEP)
    angle, s = waves.heading - LONG.heading, exponent
    first, second = s / (s + 1), s * (s - 1) / ((s + 1) * (s + 2))
    root = np.sqrt(angle.size)
    scatter = np.sqrt((1 + second) / 2 - first**2) / root
    error = abs(np.mean(np.cos(angle)) - first) / scatter
    claim, against = "mean cosine of a spread sea [standard errors]", "Longuet-Higgins 1963"
    validated(Kind.CLOSED_FORM, claim, against, error, 4.0, Feature.SPREADING)
    assert np.mean(np.cos(angle)) == pytest.approx(
        first, abs=4 * np.sqrt((1 + second) / 2 - first**2) / root
    )
    assert np.mean(np.sin(angle)) == pytest.approx(0.0, abs=4 * np.sqrt((1 - second) / 2) / root)
    assert np.mean(np.cos(2 * angle)) == pytest.approx(second, abs=4 / root)


def test_density_of_directions() -> None:
    # middles of equal shares of probability: their density is that of the distribution
    shares = (np.arange(100_000) + 0.5) / 100_000
    angle = spreading_angles(shares, 4.0)
    assert np.all(np.diff(angle) > 0)
    found, edges = np.histogram(angle, np.linspace(-2.5, 2.5, 51), density=False)
    middle = 0.5 * (edges[1:] + edges[:-1])
    expected = np.cos(middle / 2) ** 8
    # integral of cos^8(x / 2) over a turn: 2 pi 35 / 128; a bin of 0.1 rad has a curvature of 0.2 %
    expected *= 128 / 35 / (2 * np.pi) * 0.1 * 100_000
    np.testing.assert_allclose(found, expected, rtol=0.01, atol=5.0)


def test_directions_of_a_table() -> None:
    heading = np.radians(np.arange(-90.0, 91.0, 15.0))
    frequency = np.array([0.4, 0.8, 1.6])
    lobes = np.exp(-8 * (heading - np.array([[-0.6], [0.0], [0.6]])) ** 2)
    table = DirectionalTable(frequency, heading, np.array([[1.0], [2.0], [1.0]]) * lobes)
    waves = components(replace(LONG, spectrum=table), DEEP)
    for i, near in enumerate(frequency):
        around = np.abs(waves.omega - near) < 0.05
        # sectors of 15 deg widen a lobe of 14 deg: standard deviation 15 / sqrt(12) deg
        mean = waves.heading[around].mean()
        weights = lobes[i] / lobes[i].sum()
        assert mean == pytest.approx(weights @ heading, abs=0.08 + 4 * 0.3 / np.sqrt(around.sum()))
        low, high = heading[0] - np.radians(7.5), heading[-1] + np.radians(7.5)
        assert np.all((waves.heading >= low) & (waves.heading <= high))
    flat = replace(table, density=np.ones((3, heading.size)))
    angles = components(replace(LONG, spectrum=flat), DEEP).heading
    share = (angles - heading[0] + np.radians(7.5)) / np.radians(195.0)
    assert (
        kstest(share[components(replace(LONG, spectrum=flat), DEEP).omega > 0.4], "uniform").pvalue
        > 1e-3
    )


def test_a_sector_of_a_table_is_filled_evenly() -> None:
    """All energy in one of 15 deg about 30 deg."""
    heading = np.radians(np.arange(-90.0, 91.0, 15.0))
    density = np.zeros((2, heading.size))
    density[:, 8] = 1.0
    table = DirectionalTable(np.array([0.4, 1.6]), heading, density)
    share = np.degrees(components(replace(LONG, spectrum=table), DEEP).heading) / 15.0 - 1.5
    assert np.all((share >= 0.0) & (share <= 1.0))
    assert kstest(share, "uniform").pvalue > 1e-3
