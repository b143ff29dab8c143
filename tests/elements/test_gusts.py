"""Gusts: spectra and profiles against their formulas, series against sums, motions in gusts."""

from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scenes import block, errors, observed_orders, scene
from scipy.integrate import quad, solve_ivp
from scipy.special import beta, betainc

import hydrosim as hs
from hydrosim.analysis.seakeeping import LinearRequest, linear_analysis
from hydrosim.scene import Amplitudes, GustSpectrum
from hydrosim.study.seas import Sea, scene_in_sea
from hydrosim.study.sweep import scenes_with_seeds
from hydrosim.water.components import GUSTS, phases
from hydrosim.water.wind import (
    density,
    gust_at,
    gust_components,
    gust_factor,
    gust_table,
    mean_wind,
    turbulence_intensity,
    variance,
)

FOOT = 0.3048
HEADINGS = np.radians(np.arange(0.0, 360.0, 10.0))
C = 400.0  # N s^2/m^2
MASS, STIFFNESS, DAMPING = 2e4, 5e3, 1e3
SPEED, HEIGHT = 20.0, 30.0


def gusty(speed: float = SPEED, heading: float = 0.0, **gusts: Any) -> hs.Environment:
    """Wind with the profile and the gusts of NPD."""
    settings = {"spectrum": "npd", "repeat_period": 600.0, "seed": 3, **gusts}
    return hs.Environment(wind=hs.Wind(speed, heading, profile="npd", gusts=settings))


def round_load(height: float = HEIGHT) -> hs.WindLoad:
    """F = c |w| w, exact along the x axis."""
    along, aside = C * np.cos(HEADINGS), C * np.sin(HEADINGS)
    return hs.WindLoad("block", (3.0, -1.0, height), HEADINGS, along, aside, 0.0 * HEADINGS)


def moored(environment: hs.Environment, duration: float = 30.0, **solver: Any) -> hs.Scene:
    """A block on a mooring in surge and sway, in the wind."""
    size = np.diag([1.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    lines = hs.LinearMooring("block", STIFFNESS * size, DAMPING * size)
    forces = {"wind": round_load(), "lines": lines}
    body = block(MASS, dofs=["surge", "sway"])
    still = scene(body, forces, duration, 0.5, **{"step": 0.1, **solver})
    return replace(still, environment=environment)


def npd_speed(height: float) -> float:
    """Mean of one hour, by hand."""
    return SPEED * (1.0 + 0.0573 * np.sqrt(1.0 + 0.15 * SPEED) * np.log(height / 10.0))


def npd_density(f: float | np.ndarray, height: float) -> Any:
    """Density [(m/s)^2/Hz], by hand."""
    x = 172.0 * f * (height / 10.0) ** (2 / 3) * (SPEED / 10.0) ** -0.75
    whole = 320.0 * (SPEED / 10.0) ** 2 * (height / 10.0) ** 0.45
    return whole / (1.0 + x**0.468) ** (5.0 / (3.0 * 0.468))


def gusts_by_hand(environment: hs.Environment, height: float, time: np.ndarray) -> np.ndarray:
    """Sum of components whose amplitudes are from the formula, one by one."""
    gusts = environment.gusts
    assert gusts is not None
    spacing = 1.0 / gusts.repeat_period
    found = gust_components(gusts, mean_wind(environment), [height])
    total = np.zeros(np.shape(time))
    for omega, phase in zip(found.omega, found.phase, strict=True):
        f = omega / (2.0 * np.pi)
        low = max(f - spacing / 2.0, 1.0 / 600.0)
        high = min(f + spacing / 2.0, 0.5)
        power = quad(npd_density, low, high, args=(height,))[0]
        total = total + np.sqrt(2.0 * power) * np.cos(omega * time + phase)
    return total


@pytest.mark.parametrize(("speed", "height"), [(10.0, 10.0), (20.0, 50.0), (40.0, 4.0)])
def test_npd_against_the_same_formulas_in_feet(speed: float, height: float) -> None:
    """API RP 2A-WSD 21st edition, 2.3.2, has them in feet, with constants of three digits."""
    U, z = speed / FOOT, height / FOOT
    wind = mean_wind(hs.Environment(wind=hs.Wind(speed, profile="npd")))
    mean = U * (1.0 + 0.0573 * np.sqrt(1.0 + 0.0457 * U) * np.log(z / 32.8))
    assert wind.speed_at(height) == pytest.approx(mean * FOOT, rel=1e-3)
    intensity = 0.06 * (1.0 + 0.0131 * U) * (z / 32.8) ** -0.22
    assert turbulence_intensity(speed, height) == pytest.approx(intensity, rel=1e-3)
    for time in (3.0, 60.0, 600.0):
        factor = 1.0 - 0.41 * intensity * np.log(time / 3600.0)
        assert gust_factor(speed, height, time) == pytest.approx(factor, rel=1e-3)
    f, n = np.array([0.002, 0.02, 0.2]), 0.468
    x = 172.0 * f * (z / 32.8) ** (2 / 3) * (U / 32.8) ** -0.75
    S = 3444.0 * (U / 32.8) ** 2 * (z / 32.8) ** 0.45 / (1.0 + x**n) ** (5.0 / (3.0 * n))
    assert density(GustSpectrum.NPD, f, height, wind) == pytest.approx(S * FOOT**2, rel=2e-3)


def test_another_averaging_time_and_height_are_the_same_wind() -> None:
    """10 min at 30 m from one hour at 10 m and back; an hour at 10 m is as given to the bit."""
    given = npd_speed(30.0) * gust_factor(SPEED, 30.0, 600.0)
    gusts = hs.Gusts("npd", averaging=600.0)
    water = hs.Environment(wind=hs.Wind(given, height=30.0, profile="npd", gusts=gusts))
    assert mean_wind(water).hour_mean == pytest.approx(SPEED, rel=1e-12)
    assert mean_wind(gusty()).hour_mean == SPEED
    power = hs.Wind(12.0, height=30.0, profile={"exponent": 0.125})
    wind = mean_wind(hs.Environment(wind=power))
    assert wind.speed_at(30.0) == pytest.approx(12.0, rel=1e-12)
    assert wind.speed_at(80.0) == pytest.approx(12.0 * (80.0 / 30.0) ** 0.125, rel=1e-12)
    uniform = mean_wind(hs.Environment(wind=hs.Stream(12.0)))
    assert uniform.speed_at(80.0) == uniform.speed_at(1.0) == 12.0


@pytest.mark.parametrize("height", [10.0, 60.0])
def test_variance_of_npd_gusts_against_its_closed_form(height: float) -> None:
    """With v = (a f)^n / (1 + (a f)^n) the integral of S is an incomplete beta function."""
    n, a = 0.468, 172.0 * (height / 10.0) ** (2 / 3) * (SPEED / 10.0) ** -0.75
    first, second = 1.0 / n, 2.0 / (3.0 * n)
    whole = npd_density(0.0, height) / (a * n) * beta(first, second)

    def up_to(f: float) -> float:
        v = (a * f) ** n / (1.0 + (a * f) ** n)
        return float(whole * betainc(first, second, v))

    band = up_to(0.5) - up_to(1.0 / 600.0)
    wind = mean_wind(gusty())
    for period in (600.0, 10800.0):
        found = gust_components(hs.Gusts("npd", repeat_period=period), wind, [height])
        assert 0.5 * np.sum(found.amplitude**2) == pytest.approx(band, rel=1e-7)
    below, within, above = variance(GustSpectrum.NPD, height, wind, 1.0 / 600.0, 0.5)
    assert within == pytest.approx(band, rel=1e-6)
    assert below == pytest.approx(up_to(1.0 / 600.0), rel=1e-4)
    assert above == pytest.approx(whole - up_to(0.5), rel=1e-3)


def test_other_spectra() -> None:
    """API's integral is its s^2; Ochi and Shin's three pieces meet within their digits."""
    wind = mean_wind(gusty())
    s = 0.15 * npd_speed(40.0) * 2.0**-0.275
    assert sum(variance(GustSpectrum.API, 40.0, wind, 0.01, 0.1)) == pytest.approx(s**2, rel=2e-3)
    for F in (0.003, 0.1):
        f = F * SPEED / 10.0 * np.array([1.0 - 1e-9, 1.0 + 1e-9])
        before, after = density(GustSpectrum.OCHI_SHIN, f, 10.0, wind)
        assert after == pytest.approx(before, rel=2e-3)


def test_spectrum_over_seeds() -> None:
    """Periodograms of 60 series with random amplitudes in five bands: means are good to 0.4 %."""
    period, dt, edges = 10800.0, 0.5, np.array([1.0 / 600.0, 0.1, 0.2, 0.3, 0.4, 0.5])
    total = np.zeros(5)
    for seed in range(60):
        gusts = {"repeat_period": period, "seed": seed, "amplitudes": Amplitudes.RAYLEIGH}
        table = gust_table(gusty(**gusts), [10.0], dt, period)
        first = round(-table.start / table.step)
        points = round(period / table.step)
        lines = np.fft.rfft(table.values[first : first + points, 0]) / points
        f = np.arange(lines.size) / period
        total += np.histogram(f, edges, weights=2.0 * np.abs(lines) ** 2)[0] / 60
    exact = [quad(npd_density, *band, args=(10.0,))[0] for band in pairwise(edges)]
    assert total == pytest.approx(exact, rel=0.01)
    assert total.sum() == pytest.approx(sum(exact), rel=0.01)


def test_series_against_the_sum_at_any_time() -> None:
    """At nodes of the table to rounding; between them to the error that the table states."""
    water = gusty()
    table = gust_table(water, [10.0, HEIGHT], 0.05, 600.0)
    nodes = table.start + table.step * np.arange(3, table.values.shape[0] - 3, 97)
    between = np.random.default_rng(1).uniform(0.0, 600.0, 200)
    for column, height in enumerate((10.0, HEIGHT)):
        for time, within in ((nodes, 1e-12), (between, 1e-6)):
            found = [gust_at(t, column, table) for t in time]
            parts = gust_components(water.gusts, mean_wind(water), [height])
            angle = np.multiply.outer(time, parts.omega) + parts.phase
            assert np.abs(found - np.cos(angle) @ parts.amplitude[:, 0]).max() < within
    phases = np.multiply.outer(nodes, parts.omega) + parts.phase
    exact = np.cos(phases) @ parts.amplitude[:, 0]
    assert np.abs(gusts_by_hand(water, HEIGHT, nodes) - exact).max() < 1e-6


def test_a_series_knows_neither_the_run_nor_the_waves() -> None:
    """The same in a longer run; independent of a train with the same seed; another of another."""
    short = gust_table(gusty(), [10.0], 0.05, 30.0)
    long = gust_table(gusty(), [10.0, 50.0], 0.05, 300.0)
    assert np.array_equal(short.values[:, 0], long.values[: len(short.values), 0])
    train = hs.WaveTrain(hs.RegularWave(1.0, 8.0), seed=3)
    waves = phases(train, 0, 4000)
    gusts = phases(hs.Gusts("npd", seed=3), GUSTS, 4000)
    assert abs(np.corrcoef(waves, gusts)[0, 1]) < 0.06
    assert not np.isin(gusts, waves).any()
    other = gust_table(gusty(seed=4), [10.0], 0.05, 300.0)
    assert abs(np.corrcoef(long.values[:, 0], other.values[:, 0])[0, 1]) < 0.5
    with pytest.raises(hs.InputError, match=r"gusts.repeat_period: 600 s is shorter than the run"):
        gust_table(gusty(), [10.0], 0.05, 601.0)
    with pytest.raises(hs.InputError, match=r"gusts.repeat_period: 30 s gives 15 components"):
        gust_table(gusty(repeat_period=30.0), [10.0], 0.05, 20.0)


@cache
def run_moored() -> xr.Dataset:
    """Motions in gusts along an oblique wind."""
    return hs.simulate(moored(gusty(heading=0.6, ramp=5.0)))


def test_force_and_record() -> None:
    """c |U + u - v| (U + u - v) at the height of the point, with a ramp; the record is at 10 m."""
    run = run_moored()
    water = gusty(heading=0.6)
    time = run.time.values
    ramp = np.where(time < 5.0, 0.5 - 0.5 * np.cos(np.pi * time / 5.0), 1.0)
    at_10 = SPEED + ramp * gusts_by_hand(water, 10.0, time)
    assert np.abs(run.wind_speed.values - at_10).max() < 1e-7
    speed = npd_speed(HEIGHT) + ramp * gusts_by_hand(water, HEIGHT, time)
    w = speed[:, None] * [np.cos(0.6), np.sin(0.6)] - run.velocity.values[:, 0, :2]
    force = C * np.linalg.norm(w, axis=1)[:, None] * w
    found = run.force_wind.values[:, 0, :2]
    assert np.abs(found - force).max() < 1e-5 * np.abs(force).max()
    assert "standard deviation 2.28 m/s" in run.attrs["streams"]
    assert "12.5% of its variance below and 14.1% above" in run.attrs["streams"]
    assert "1.32 over 3 s and 1.19 over 1 min" in run.attrs["streams"]
    assert run.attrs["seeds"] == [3]
    assert float(run.attrs["energy_residual_relative"]) < 1e-5


@cache
def surge_by_hand() -> tuple[np.ndarray, np.ndarray]:
    """Surge of the moored block by another method, from a series of its own."""
    parts = gust_components(gusty().gusts, mean_wind(gusty()), [HEIGHT])
    amplitude, U = parts.amplitude[:, 0], npd_speed(HEIGHT)

    def rate(t: float, z: np.ndarray) -> list[float]:
        w = U + amplitude @ np.cos(parts.omega * t + parts.phase) - z[1]
        return [z[1], (C * abs(w) * w - STIFFNESS * z[0] - DAMPING * z[1]) / MASS]

    time = np.arange(0.0, 30.25, 0.5)
    found = solve_ivp(rate, (0.0, 30.0), [0.0, 0.0], "DOP853", time, rtol=1e-12, atol=1e-12)
    return time, found.y[0]


def test_a_moored_mass_in_gusts() -> None:
    """rk4 at its order, and an adaptive method, against DOP853."""
    _, exact = surge_by_hand()
    still = moored(gusty())
    steps = (0.1, 0.05, 0.025)
    found = errors(still, steps, exact)
    assert found[-1] < 1e-8 * np.abs(exact).max()
    assert observed_orders(steps, found) == pytest.approx([4.0, 4.0], abs=0.3)
    tight = {"method": hs.scene.Method.DOPRI5, "tolerance": hs.Tolerance(1e-9, 1e-9, 1e-9)}
    adaptive = replace(still, solver=replace(still.solver, **tight))
    run = hs.simulate(adaptive)
    assert np.abs(run.position.values[:, 0, 0] - exact).max() < 1e-6


def test_a_restart_in_gusts_goes_on_to_the_bit() -> None:
    whole = run_moored()
    still = moored(gusty(heading=0.6, ramp=5.0))
    before = hs.simulate(replace(still, duration=12.0))
    after = hs.simulate(replace(still, duration=18.0, initial=hs.Start(before)))
    for name in ("position", "velocity", "wind_speed", "force_wind"):
        assert np.array_equal(after[name].values, whole[name].sel(time=after.time).values), name


def test_a_turned_scene_in_gusts_turns() -> None:
    """Wind and body turned by 50 deg; the mooring is the same in all directions."""
    whole, by = run_moored(), np.radians(50.0)
    still = moored(gusty(heading=0.6 + by, ramp=5.0))
    run = hs.simulate(replace(still, bodies=(replace(still.bodies[0], heading=by),)))
    c, s = np.cos(by), np.sin(by)
    turned = whole.position.values[:, 0, :2] @ np.array([[c, s], [-s, c]])
    assert np.abs(run.position.values[:, 0, :2] - turned).max() < 1e-11


def test_linear_response_to_gusts() -> None:
    """Along the wind the load changes by 2 c U u, and damps by 2 c U."""
    found = linear_analysis(moored(gusty(repeat_period=10800.0)), LinearRequest())
    wind = mean_wind(gusty())
    parts = gust_components(hs.Gusts("npd", seed=3), wind, [HEIGHT])
    U, w = npd_speed(HEIGHT), parts.omega
    D = STIFFNESS - w**2 * MASS + 1j * w * (DAMPING + 2.0 * C * U)
    exact = np.sqrt(0.5 * np.sum(np.abs(2.0 * C * U * parts.amplitude[:, 0] / D) ** 2))
    assert float(found.gust_std[0, 0]) == pytest.approx(exact, rel=1e-5)
    assert "squares of the gusts are left out" in found.attrs["remarks"]


def test_seeds_of_studies_draw_gusts_too() -> None:
    """A sweep and a search for limits give the gusts the seed that they give the waves."""
    train = hs.WaveTrain(hs.scene.Jonswap(2.0, 8.0))
    water = replace(gusty(), waves=(train,))
    still = moored(water)
    for one in (scenes_with_seeds(still, [7])[0], scene_in_sea(still, Sea(8.0, 0.0), 2.0, 7)):
        assert one.environment.seeds == [7, 7]
    known = replace(still, environment=water.with_seed(5)).environment.without_waves()
    assert known == water.without_waves()
    gusty_seas = scenes_with_seeds(replace(still, environment=gusty()), [7, 8])
    runs = hs.simulate_many(gusty_seas, channels=["wind_speed"], workers=1)
    assert runs.seed.values.tolist() == [7, 8]


def test_a_load_too_low_for_the_profile_is_refused() -> None:
    low = replace(moored(gusty()), forces={"wind": round_load(0.2)})
    with pytest.raises(hs.InputError, match=r"forces.wind.height: found a height of 0.2 m"):
        hs.compile_scene(low)
    given = replace(round_load(0.2), height=25.0)
    compiled = hs.compile_scene(replace(low, forces={"wind": given}))
    stream = compiled.model.elements.stream_loads.each[0]["stream"]
    assert np.hypot(*stream) == pytest.approx(npd_speed(25.0), rel=1e-12)
