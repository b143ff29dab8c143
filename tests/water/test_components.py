from dataclasses import replace

import numpy as np
import pytest

from hydrosim.errors import InputError
from hydrosim.scene import (
    Environment,
    GivenComponents,
    Jonswap,
    RecordedElevation,
    RegularWave,
    Spectrum,
    Tma,
    Torsethaugen,
    WaveTrain,
    WhiteNoise,
)
from hydrosim.water.components import check_span, components, energy_outside, sea
from hydrosim.water.loads import elevation_at
from hydrosim.water.spectra import TAIL_ENERGY, density

JONSWAP = Jonswap(1.5, 8.0, 3.3)
IRREGULAR = WaveTrain(JONSWAP, heading=0.5, seed=1)
DEEP = Environment()


def test_energy_of_an_irregular_sea_is_that_of_its_height() -> None:
    # a sum over 1300 lines below the peak is as good as the integral, up to the last line's half
    waves = components(IRREGULAR, DEEP)
    line = density(JONSWAP, waves.omega[-1]) * waves.spacing
    missing = 1.5**2 / 16 - np.sum(waves.amplitude**2) / 2
    assert abs(missing - TAIL_ENERGY * 1.5**2 / 16) <= 0.51 * line


def test_components_are_equally_spaced_multiples() -> None:
    waves = components(replace(IRREGULAR, repeat_period=600.0), DEEP)
    np.testing.assert_array_equal(waves.omega, 2 * np.pi / 600 * np.arange(1, waves.omega.size + 1))
    np.testing.assert_array_equal(waves.index * waves.spacing, waves.omega)


def test_same_seed_same_bytes() -> None:
    one, other = (components(IRREGULAR, DEEP).phase for _ in range(2))
    assert one.tobytes() == other.tobytes()


def correlation(one: np.ndarray, other: np.ndarray, amplitude: np.ndarray) -> float:
    """Of two records over the repeat period, from their phases, in units of its standard
    deviation for independent phases: sum a^2/2 cos(difference) has variance sum a^4/8."""
    return np.sum(amplitude**2 * np.cos(one - other)) / np.sqrt(np.sum(amplitude**4) / 2)


def test_seeds_are_independent() -> None:
    trains = [components(replace(IRREGULAR, seed=seed), DEEP) for seed in range(1, 9)]
    pairs = [
        correlation(one.phase, other.phase, one.amplitude)
        for i, one in enumerate(trains)
        for other in trains[:i]
    ]
    assert np.max(np.abs(pairs)) < 4.0  # of 28 standard deviations, one in 600 is above
    assert 0.5 < np.std(pairs) < 1.5


def test_trains_of_one_seed_are_independent() -> None:
    (both,) = sea(Environment(waves=(IRREGULAR, IRREGULAR)))
    one, other = np.split(both.phase, 2)
    assert abs(correlation(one, other, both.amplitude[: one.size])) < 4.0


def test_trains_are_one_sea_if_they_grow_and_repeat_together() -> None:
    other = replace(IRREGULAR, heading=1.0)
    (both,) = sea(Environment(waves=(IRREGULAR, other)))
    alone = components(other, Environment(), stream=1)
    for name in ("omega", "amplitude", "phase", "wavenumber", "heading"):
        one, two = np.split(getattr(both, name), 2)
        np.testing.assert_array_equal(one, getattr(components(IRREGULAR, Environment()), name))
        np.testing.assert_array_equal(two, getattr(alone, name))
    for apart in (replace(other, ramp=7.0), replace(other, repeat_period=20000.0)):
        assert len(sea(Environment(waves=(IRREGULAR, apart)))) == 2


def test_phases_are_uniform() -> None:
    phase = components(IRREGULAR, DEEP).phase
    lowest = np.abs([np.mean(np.exp(1j * m * phase)) for m in (1, 2, 3)])
    assert np.all((phase >= 0) & (phase < 2 * np.pi))
    assert np.all(lowest < 4.0 / np.sqrt(phase.size))


def test_regular_wave_in_finite_depth() -> None:
    train = WaveTrain(RegularWave(0.8, 9.0, phase=0.3), heading=np.radians(30))
    waves = components(train, Environment(water_depth=20.0))
    omega, k = 2 * np.pi / 9.0, waves.wavenumber[0]
    assert omega**2 == pytest.approx(9.81 * k * np.tanh(20.0 * k), rel=1e-14)
    t, x, y = np.linspace(0.0, 30.0, 61), 40.0, -25.0
    along = x * np.cos(np.radians(30)) + y * np.sin(np.radians(30))
    expected = 0.8 * np.cos(omega * t - k * along + 0.3)
    np.testing.assert_allclose(elevation_at(waves, x, y, t), expected, atol=1e-14)


def test_elevation_travels_towards_the_heading() -> None:
    waves = components(WaveTrain(RegularWave(1.0, 10.0), heading=np.pi / 2), DEEP)
    speed, t = waves.omega[0] / waves.wavenumber[0], np.linspace(100.0, 110.0, 21)
    later = elevation_at(waves, 0.0, 50.0, t + 50.0 / speed)
    np.testing.assert_allclose(later, elevation_at(waves, 0.0, 0.0, t), atol=1e-12)


def test_ramp_of_the_elevation() -> None:
    steady = components(IRREGULAR, DEEP)
    growing = components(replace(IRREGULAR, ramp=200.0), DEEP)
    t = np.array([-5.0, 0.0, 50.0, 100.0, 150.0, 200.0, 300.0])
    quarter = 0.5 * (1 - np.sqrt(0.5))
    rise = [0.0, 0.0, quarter, 0.5, 1.0 - quarter, 1.0, 1.0]
    expected = rise * elevation_at(steady, 0.0, 0.0, t)
    np.testing.assert_allclose(elevation_at(growing, 0.0, 0.0, t), expected, atol=1e-14)
    assert elevation_at(steady, 0.0, 0.0, np.zeros(1)) != 0.0


def test_too_short_a_repeat_period_is_refused() -> None:
    with pytest.raises(InputError, match=r"waves\.repeat_period: 100 s.*160 s"):
        components(replace(IRREGULAR, repeat_period=100.0), DEEP)
    for gamma in (1.0, 3.3, 7.0):
        shortest = replace(IRREGULAR, spectrum=Jonswap(1.5, 8.0, gamma), repeat_period=160.0)
        energy = np.sum(components(shortest, DEEP).amplitude ** 2) / 2
        assert energy == pytest.approx((1 - TAIL_ENERGY) * 1.5**2 / 16, rel=1e-3)


def test_energy_outside_the_frequencies_of_a_database() -> None:
    waves = components(WaveTrain(Jonswap(2.0, 8.0, 1.0)), DEEP)
    peak, low, high = 2 * np.pi / 8, 0.6, 1.2
    below, above = energy_outside(waves, np.array([low, 1.0, high]))
    # Pierson-Moskowitz integrated by hand, of which the sea has all but TAIL_ENERGY;
    # a line on either side of a limit is 0.001
    assert below == pytest.approx(np.exp(-1.25 * (peak / low) ** 4), abs=2e-3)
    assert above == pytest.approx(1 - np.exp(-1.25 * (peak / high) ** 4), abs=2e-3)
    tone = components(WaveTrain(RegularWave(1.0, 2.0)), DEEP)
    assert energy_outside(tone, np.array([low, high])) == (0.0, 1.0)
    calm = components(WaveTrain(RegularWave(0.0, 8.0)), DEEP)
    assert energy_outside(calm, np.array([0.3, 2.0])) == (0.0, 0.0)


@pytest.mark.parametrize(
    "spectrum",
    [Jonswap(0.0, 8.0), RegularWave(0.0, 8.0), Torsethaugen(0.0, 8.0), RegularWave(1e-300, 8.0)],
    ids=str,
)
def test_trains_of_no_height_are_left_out(spectrum: Spectrum) -> None:
    """Nor is a wave one whose energy is below all numbers."""
    assert sea(Environment(waves=(WaveTrain(spectrum),))) == ()
    (left,) = sea(Environment(waves=(WaveTrain(spectrum), IRREGULAR)))
    alone = components(IRREGULAR, DEEP, stream=1)  # phases are those of its place in the list
    np.testing.assert_array_equal(left.phase, alone.phase)


def given(omega: np.ndarray) -> GivenComponents:
    random = np.random.default_rng(3)
    n = omega.size
    amplitude, phase, heading = random.random(n), random.normal(size=n), random.normal(size=n)
    return GivenComponents(omega, amplitude, phase, heading)


@pytest.mark.parametrize(
    ("omega", "spacing"),
    [
        (np.array([0.3, 0.7123, 1.1]), 0.0),
        (2 * np.pi / np.array([12.0, 8.0, 7.5]), 2 * np.pi / 10800),  # multiples
    ],
)
def test_given_components_are_summed(omega: np.ndarray, spacing: float) -> None:
    one = given(omega)
    waves = components(WaveTrain(one), Environment(water_depth=25.0))
    assert waves.spacing == spacing
    t, x, y = np.linspace(0.0, 300.0, 301), 20.0, 35.0
    complex_amplitude = one.amplitude * np.exp(1j * one.phase)
    k = waves.wavenumber
    np.testing.assert_allclose(9.81 * k * np.tanh(25 * k), omega**2, rtol=1e-12)
    along = k * (x * np.cos(one.heading) + y * np.sin(one.heading))
    expected = np.sum(complex_amplitude * np.exp(1j * (np.outer(t, omega) - along)), axis=1).real
    np.testing.assert_allclose(elevation_at(waves, x, y, t), expected, atol=1e-12)


def test_a_tma_sea_has_the_depth_of_the_water() -> None:
    with pytest.raises(InputError, match=r"TMA spectrum of 20 m of water; expected .* inf m"):
        components(WaveTrain(Tma(1.5, 8.0, 20.0)), DEEP)


def test_a_narrow_band_needs_a_long_period() -> None:
    narrow = WaveTrain(WhiteNoise(1.0, 0.5, 0.51), repeat_period=10800.0)
    with pytest.raises(InputError, match=r"10800 s gives too few .* band, of 628.* 12566"):
        components(narrow, DEEP)
    # 20 lines in the band, or one more or less
    wide = components(replace(narrow, repeat_period=12600.0), DEEP)
    assert np.sum(wide.amplitude**2) / 2 == pytest.approx(1 / 16, rel=0.06)


class TestRecorded:
    """A record that is replayed is itself."""

    @pytest.fixture(params=[600, 601], ids=["even", "odd"])
    def record(self, request: pytest.FixtureRequest) -> RecordedElevation:
        time = 3.0 + 0.5 * np.arange(request.param)
        return RecordedElevation(time, np.random.default_rng(4).normal(size=time.size) + 0.3)

    @pytest.mark.parametrize("place", [(0.0, 0.0), (70.0, -20.0)])
    def test_at_its_own_times_and_place(
        self, record: RecordedElevation, place: tuple[float, float]
    ) -> None:
        train = WaveTrain(replace(record, position=place), heading=0.4)
        waves = components(train, Environment(water_depth=30.0))
        assert waves.spacing == pytest.approx(2 * np.pi / (0.5 * record.time.size), rel=1e-14)
        expected = record.elevation - record.elevation.mean()
        found = elevation_at(waves, *place, record.time)
        np.testing.assert_allclose(found, expected, atol=1e-12)

    def test_elsewhere_the_waves_arrive_later(self) -> None:
        omega = 2 * np.pi / 10.0
        time = 0.5 * np.arange(400)
        record = RecordedElevation(time, np.cos(omega * time + 0.2), (10.0, 0.0))
        waves = components(WaveTrain(record, heading=np.pi / 2), DEEP)
        along = omega**2 / 9.81 * 25.0
        expected = np.cos(omega * time + 0.2 - along)
        np.testing.assert_allclose(elevation_at(waves, -4.0, 25.0, time), expected, atol=1e-11)

    def test_high_frequencies_can_be_left_out(self, record: RecordedElevation) -> None:
        whole = components(WaveTrain(record), DEEP)
        part = components(WaveTrain(replace(record, highest_frequency=2.0)), DEEP)
        assert part.omega[-1] <= 2.0 < part.omega[-1] + part.spacing
        np.testing.assert_array_equal(part.amplitude, whole.amplitude[: part.omega.size])

    def test_times_of_single_precision_are_even(self) -> None:
        """Three hours every 0.1 s: rounded by half a millisecond."""
        time = 0.1 * np.arange(108_000)
        wave = np.cos(0.7 * time)
        exact, rounded = (
            components(WaveTrain(RecordedElevation(at.astype(float), wave)), DEEP)
            for at in (time, time.astype(np.float32))
        )
        np.testing.assert_allclose(rounded.omega, exact.omega, rtol=1e-7)
        time[5000] += 0.002
        with pytest.raises(InputError, match=r"up to 0\.002 s off from steps of 0\.1 s"):
            components(WaveTrain(RecordedElevation(time, wave)), DEEP)

    def test_steps_must_be_equal(self, record: RecordedElevation) -> None:
        record.time[7] += 0.1
        with pytest.raises(InputError, match=r"up to 0\.1 s off from steps of 0\.5 s"):
            components(WaveTrain(record), DEEP)


def test_a_run_is_no_longer_than_its_waves() -> None:
    time = 10.0 + np.arange(100.0)
    record = WaveTrain(RecordedElevation(time, np.sin(time)))
    check_span(Environment(waves=(record,)), 10.0, 109.0)
    said = "times from 10 to 109 s; expected times that cover the whole run"
    for start, end in ((0.0, 50.0), (20.0, 110.0)):
        with pytest.raises(InputError, match=said):
            check_span(Environment(waves=(record,)), start, end)
    with pytest.raises(InputError, match=r"repeat_period: 10800 s is shorter than the run"):
        check_span(Environment(waves=(IRREGULAR,)), 0.0, 10801.0)
    regular = WaveTrain(RegularWave(1.0, 8.0)), WaveTrain(given(np.array([0.5])))
    check_span(Environment(waves=regular), 0.0, 1e9)
