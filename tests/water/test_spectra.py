import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.special import gamma as gamma_function

from hydrosim.scene import (
    Density,
    DirectionalTable,
    Jonswap,
    OchiHubble,
    OchiHubblePeak,
    SpectrumTable,
    Tma,
    Torsethaugen,
    WhiteNoise,
)
from hydrosim.water.spectra import (
    TAIL_ENERGY,
    cut_off,
    density,
    energy,
    kitaigorodskii,
    wavenumber,
    wind_sea_and_swell,
)

HS, TP = 1.5, 8.0
PEAK = 2.0 * np.pi / TP
GAMMAS = [1.0, 2.0, 3.3, 7.0]


TWO_PEAKS = OchiHubble((OchiHubblePeak(1.2, 14.0, 3.0), OchiHubblePeak(0.9, 7.0, 1.2)))
HEIGHTS: list[tuple[Density, float]] = [
    *((Jonswap(HS, TP, gamma), HS) for gamma in GAMMAS),
    *((Tma(HS, TP, depth), HS) for depth in (5.0, 20.0, 200.0, np.inf)),
    (Torsethaugen(6.0, 9.0), 6.0),  # wind sea
    (Torsethaugen(3.0, 15.0), 3.0),  # swell
    (TWO_PEAKS, 1.5),
    (WhiteNoise(2.0, 0.3, 1.5), 2.0),
    (SpectrumTable(np.array([0.4, 0.6, 1.0]), np.array([0.0, 2.0, 0.0])), 4 * np.sqrt(0.6)),
]


def moment(spectrum: Density, order: int, low: float = 0.0) -> float:
    """Trapezoidal moment up to 200 peak frequencies; beyond is 5e-10 of m0, 2e-5 of m2."""
    omega = np.concatenate([np.linspace(low, 4.0, 400_001), np.geomspace(4.0, 200 * PEAK, 400_001)])
    return float(trapezoid(omega**order * density(spectrum, omega), omega))


@pytest.mark.parametrize(("spectrum", "height"), HEIGHTS, ids=str)
def test_significant_height_is_four_root_m0(spectrum: Density, height: float) -> None:
    # n = 4 (Torsethaugen) has 1e-7 above 200 peaks; white noise jumps within a step of 1e-5
    rough = isinstance(spectrum, Torsethaugen | WhiteNoise)
    assert 4.0 * np.sqrt(moment(spectrum, 0)) == pytest.approx(height, rel=5e-6 if rough else 1e-8)
    assert 4.0 * np.sqrt(energy(spectrum)) == pytest.approx(height, rel=1e-12)


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


@pytest.mark.parametrize(("spectrum", "height"), HEIGHTS, ids=str)
def test_cut_off_leaves_the_stated_energy(spectrum: Density, height: float) -> None:
    omega = np.geomspace(cut_off(spectrum), 1000 * cut_off(spectrum), 400_001)
    tail = trapezoid(density(spectrum, omega), omega)
    # a table ends within a step; else the error is that of what is above: (1/1000)^3 or less
    rel = 2e-2 if isinstance(spectrum, WhiteNoise | SpectrumTable) else 1e-6
    assert tail == pytest.approx(TAIL_ENERGY * height**2 / 16, rel=rel)


@pytest.mark.parametrize(("spectrum", "height"), HEIGHTS, ids=str)
def test_nothing_at_and_below_zero_frequency(spectrum: Density, height: float) -> None:
    np.testing.assert_array_equal(density(spectrum, [-1.0, 0.0, 1e-9, 1e-3]), 0.0)


def test_tma_is_jonswap_in_deep_water() -> None:
    omega = np.linspace(0.2, 6.0, 500)
    for depth in (np.inf, 2e4):
        np.testing.assert_allclose(
            density(Tma(HS, TP, depth, 2.0), omega), density(Jonswap(HS, TP, 2.0), omega), rtol=1e-9
        )


def test_kitaigorodskii_factor() -> None:
    # Thompson and Vincent's (1983) parabolas in w sqrt(h / g), which are within 4 %
    depth, gravity = 12.0, 9.81
    reduced = np.linspace(0.05, 1.9, 100)
    fit = np.where(reduced <= 1, 0.5 * reduced**2, 1 - 0.5 * (2 - reduced) ** 2)
    factor = kitaigorodskii(reduced * np.sqrt(gravity / depth), depth, gravity)
    np.testing.assert_allclose(factor, fit, rtol=0.04)
    # kh^2 / 3 is the error of the limit
    long = kitaigorodskii(np.array([1e-3]), depth, gravity)
    assert long[0] == pytest.approx(0.5e-6 * depth / gravity, rel=1e-5)


def test_tail_of_tma_goes_with_the_cube_of_the_wavelength() -> None:
    # S(k) = S(w) dw/dk ~ k^-3 at any depth, where the peak is far below: exp(-1.25 u^-4) = 1
    spectrum, depth = Tma(1.0, 200.0, 15.0, 1.0), 15.0
    omega = np.linspace(0.5, 2.0, 100_001)
    k = wavenumber(omega, depth, 9.81)
    over_k = density(spectrum, omega) * np.gradient(omega, k)
    ratio = (over_k * k**3)[1:-1]
    np.testing.assert_allclose(ratio / ratio[-1], 1.0, rtol=2e-5)


def test_ochi_hubble_as_it_is_printed() -> None:
    omega = np.linspace(0.2, 4.0, 400)
    expected = np.zeros_like(omega)
    for height, period, shape in ((1.2, 14.0, 3.0), (0.9, 7.0, 1.2)):
        n, peak = (4 * shape + 1) / 4, 2 * np.pi / period
        scale = (n * peak**4) ** shape / gamma_function(shape) * height**2 / 4
        expected += scale * omega ** (-4 * n) * np.exp(-n * (peak / omega) ** 4)
    np.testing.assert_allclose(density(TWO_PEAKS, omega), expected, rtol=1e-12)


def test_one_peak_of_shape_one_is_pierson_moskowitz() -> None:
    omega = np.linspace(0.2, 6.0, 500)
    one = OchiHubble((OchiHubblePeak(HS, TP, 1.0),))
    np.testing.assert_allclose(
        density(one, omega), density(Jonswap(HS, TP, 1.0), omega), rtol=1e-13
    )


@pytest.mark.parametrize(
    ("height", "period", "main", "enhancement", "other", "other_period"),
    [
        # by hand from DNV-RP-C205, 3.5.6: T_f = 6.6 Hs^(1/3) is 11.993 s and 9.519 s
        (6.0, 9.0, 5.0832, 2.2276, 3.1877, 13.993),  # wind sea: r = 0.84720
        (3.0, 15.0, 2.0980, 4.0235, 2.1443, 8.5109),  # swell: r = 0.69935
    ],
)
def test_torsethaugen_divides_the_sea(
    height: float, period: float, main: float, enhancement: float, other: float, other_period: float
) -> None:
    one, two = wind_sea_and_swell(Torsethaugen(height, period))
    assert (one.significant_height, two.significant_height) == pytest.approx(
        (main, other), rel=1e-4
    )
    assert (one.peak_period, two.peak_period) == pytest.approx((period, other_period), rel=1e-4)
    assert (one.enhancement, two.enhancement) == pytest.approx((enhancement, 1.0), rel=1e-3)
    # printed scale of a peak, G0 = 3.26 and a fit of the enhanced area, good to 4 %
    hertz = one.significant_height**2 * period / 16 * 3.26 * np.exp(-1)
    hertz *= 1 + 1.1 * np.log(enhancement) ** 1.19
    assert one.density(np.array(2 * np.pi / period)) == pytest.approx(hertz / 2 / np.pi, rel=0.04)


@pytest.mark.parametrize("height", [1.0, 5.0, 14.0])
def test_a_developed_sea_of_torsethaugen_has_one_peak(height: float) -> None:
    developed = 6.6 * height ** (1 / 3)
    for period in (developed, developed * (1 + 1e-9)):
        one, two = wind_sea_and_swell(Torsethaugen(height, period))
        assert one.significant_height == pytest.approx(height, rel=1e-9)
        assert two.significant_height < 1e-3 * height
        steepness = 2 * np.pi * height / (9.81 * developed**2)
        assert one.enhancement == pytest.approx(max(35 * steepness**0.857, 1.0), rel=1e-6)


def test_two_peaks_are_where_they_should_be() -> None:
    omega = np.linspace(0.2, 2.0, 20_001)
    values = density(Torsethaugen(3.0, 15.0), omega)
    top = omega[1:-1][(values[1:-1] > values[:-2]) & (values[1:-1] > values[2:])]
    # the tail of the swell, steep where the wind sea is flat, shifts its top
    np.testing.assert_allclose(2 * np.pi / top, [15.0, 8.511], rtol=0.08)


def test_white_noise_is_flat() -> None:
    spectrum = WhiteNoise(2.0, 0.3, 1.5)
    np.testing.assert_allclose(density(spectrum, [0.31, 1.0, 1.49]), 4.0 / 16 / 1.2, rtol=1e-14)
    np.testing.assert_array_equal(density(spectrum, [0.29, 1.51]), 0.0)


def test_directional_table_is_summed_over_direction() -> None:
    heading = np.radians(np.arange(0.0, 360.0, 10.0))
    over = np.cos(heading / 2) ** 8
    one = np.array([0.0, 2.0, 1.0, 0.0])
    frequency = np.array([0.4, 0.6, 1.0, 1.4])
    table = DirectionalTable(frequency, heading, one[:, None] * over)
    # the sum over a turn is exact: the mean of cos^8(x / 2) is 35 / 128
    total = SpectrumTable(frequency, one * 2 * np.pi * 35 / 128)
    omega = np.linspace(0.1, 1.5, 100)
    np.testing.assert_allclose(density(table, omega), density(total, omega), rtol=1e-12)
    assert energy(table) == pytest.approx(energy(total), rel=1e-12)
