from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from known_box import Box, froude_krylov, smooth_drift
from numpy.testing import assert_allclose, assert_array_equal

from hydrosim.errors import InputError
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Environment, Jonswap, RegularWave, SecondOrder, WaveForces, WaveTrain
from hydrosim.water.body import WaveBody
from hydrosim.water.build import first_order, wave_loads_model
from hydrosim.water.components import check_span, components, sea
from hydrosim.water.loads import WaveLoads, elevation_at, wave_loads
from hydrosim.water.spectra import density
from hydrosim.water.transfer import mean_drift_at

ALL = np.ones(6, dtype=bool)
NEWMAN = WaveForces(True, SecondOrder.NEWMAN)
SWELL = WaveTrain(Jonswap(2.0, 16.0, 3.3), heading=np.radians(30), repeat_period=1800.0)
REGULAR = WaveTrain(RegularWave(0.8, 9.0, phase=0.4), heading=np.radians(30))
OMEGA = 2 * np.pi / 9.0


def body(box: Box | None, forces: WaveForces = NEWMAN, **changes: object) -> WaveBody:
    return replace(WaveBody(box, (0.0, 0.0), forces, 0, ALL), **changes)


def environment(*trains: WaveTrain) -> Environment:
    return Environment(waves=trains)


def loads_model(
    water: Environment, bodies: list[WaveBody], start: float, dt: float, duration: float
) -> WaveLoads:
    """The loads of a scene with this water, over a time that its waves must last."""
    check_span(water, start, start + duration)
    return wave_loads_model(sea(water), bodies, start, dt, duration)


def loads(model: WaveLoads, times: np.ndarray, dofs: int = 6) -> tuple[np.ndarray, ...]:
    """Elevation (nt,), first- and second-order loads (nt, dofs) by the kernel."""
    first, second = np.zeros((times.size, dofs)), np.zeros((times.size, dofs))
    rows = zip(times, first, second, strict=True)
    elevation = np.array([wave_loads(t, model, f, s) for t, f, s in rows])
    return elevation, first, second


def direct_first_order(waves_on: WaveBody, train: WaveTrain, times: np.ndarray) -> np.ndarray:
    lines = first_order(components(train, Environment()), [waves_on])
    return (np.exp(1j * np.outer(times, lines.omega)) @ lines.amplitude).real


def test_stages_are_exact(box: Box) -> None:
    at = body(box, location=(30.0, -12.0))
    times = 700.0 + 0.05 * np.arange(200)
    model = loads_model(environment(SWELL), [at], 650.0, 0.05, 100.0)
    elevation, first, _ = loads(model, times)
    waves = components(SWELL, Environment())
    # rounding over angles of up to 1500 rad
    assert_allclose(elevation, elevation_at(waves, 0.0, 0.0, times), atol=1e-12)
    exact = direct_first_order(at, SWELL, times)
    assert_allclose(first, exact, atol=1e-12 * np.abs(exact).max())


def test_error_between_stages_falls_with_the_sixth_power(box: Box) -> None:
    at, times = body(box), 700.0 + 0.0317 * np.arange(1000)
    exact = direct_first_order(at, SWELL, times)[:, 0]

    def error(dt: float) -> float:
        model = loads_model(environment(SWELL), [at], 650.0, dt, 100.0)
        assert model.step[0] == pytest.approx(dt)  # not refined
        return float(np.abs(loads(model, times)[1][:, 0] - exact).max())

    assert 2**5.5 < error(0.1) / error(0.05) < 2**6.5
    lines = first_order(components(SWELL, Environment()), [at])
    bound = 225 / 46080 * np.sum((lines.omega * 0.1) ** 6 * np.abs(lines.amplitude[:, 0]))
    assert error(0.1) < bound


def test_stages_closer_than_the_waves_need_are_interpolated(box: Box) -> None:
    """Stages every 0.001 s read a table every 0.05 s or so: the sum of the components' bounds."""
    at, times = body(box), 700.0 + 0.001 * np.arange(4000)
    model = loads_model(environment(SWELL), [at], 650.0, 0.001, 100.0)
    waves, [h] = components(SWELL, Environment()), model.step
    assert 0.0625 < waves.omega.max() * h <= 0.125
    lines = first_order(waves, [at])
    exact = direct_first_order(at, SWELL, times)
    error = np.abs(loads(model, times)[1] - exact)
    bound = 225 / 46080 * (lines.omega * h) ** 6 @ np.abs(lines.amplitude)
    rounding = 1e-12 * np.abs(exact).max()
    assert np.all(error < bound + rounding)
    assert np.all(bound < 1.9e-8 * np.abs(lines.amplitude).sum(axis=0) + rounding)
    nodes = np.abs(times / h - np.rint(times / h)) < 1e-6
    assert np.count_nonzero(nodes) > 50
    assert np.all(error[nodes] < rounding)


def test_coarse_steps_do_not_spoil_the_table(box: Box) -> None:
    at, times = body(box), 700.0 + 0.317 * np.arange(100)
    model = loads_model(environment(SWELL), [at], 650.0, 2.0, 100.0)
    exact = direct_first_order(at, SWELL, times)
    assert_allclose(loads(model, times)[1], exact, atol=1.2e-6 * np.abs(exact).max())


def test_ramp_on_the_elevation_and_its_square_on_second_order(box: Box) -> None:
    times = np.array([0.0, 10.0, 50.0, 73.21, 100.0, 150.0])
    steady, growing = (
        loads(loads_model(environment(train), [body(box)], 0.0, 0.05, 200.0), times)
        for train in (SWELL, replace(SWELL, ramp=100.0))
    )
    ramp = np.where(times < 100.0, 0.5 * (1 - np.cos(np.pi * times / 100.0)), 1.0)
    assert_allclose(growing[0], ramp * steady[0], atol=1e-14)
    assert_allclose(growing[1], ramp[:, None] * steady[1], rtol=1e-12)
    assert_allclose(growing[2], ramp[:, None] ** 2 * steady[2], rtol=1e-12)
    assert steady[0][0] != 0.0


def test_regular_wave_in_closed_form(box: Box, validated: Callable[..., None]) -> None:
    x, y, times = 37.0, -18.0, np.linspace(0.0, 40.0, 101)
    train = replace(REGULAR, ramp=20.0)
    model = loads_model(environment(train), [body(box, location=(x, y))], 0.0, 0.05, 40.0)
    elevation, first, second = loads(model, times)
    ramp = np.where(times < 20.0, 0.5 * (1 - np.cos(np.pi * times / 20.0)), 1.0)
    assert_allclose(elevation, ramp * 0.8 * np.cos(OMEGA * times + 0.4), atol=1e-14)
    heading = np.array([np.radians(30)])
    load = 0.8 * froude_krylov(np.array([OMEGA]), heading)[0, 0]
    along = x * np.cos(np.radians(30)) + y * np.sin(np.radians(30))
    angle = OMEGA * times + 0.4 - OMEGA**2 / 9.81 * along
    expected = ramp[:, None] * np.real(load * np.exp(1j * angle)[:, None])
    # the spline over frequency is good to 1e-4
    error = np.abs(first - expected).max() / np.abs(load).max()
    claim = "first-order loads on a box in an oblique regular wave"
    against = "Froude-Krylov loads of a box"
    validated(Kind.CLOSED_FORM, claim, against, error, 1e-4, Feature.WAVES)
    drift = 0.8**2 * smooth_drift(np.array([OMEGA]), heading)[0, 0]
    assert_allclose(second, ramp[:, None] ** 2 * drift, rtol=1e-4, atol=1e-4 * np.abs(drift).max())


@pytest.mark.parametrize("train", [SWELL, REGULAR])
def test_mean_drift_is_the_mean_of_the_slow_load(
    box: Box, train: WaveTrain, validated: Callable[..., None]
) -> None:
    times = np.arange(0.0, 1800.0, 0.5)
    constant = body(box, WaveForces(True, SecondOrder.MEAN_DRIFT))
    newman, mean = (
        loads(loads_model(environment(train), [on], 0.0, 0.5, 1800.0), times)[2]
        for on in (body(box), constant)
    )
    waves = components(train, Environment())
    expected = waves.amplitude**2 @ smooth_drift(waves.omega, np.array([train.heading]))[:, 0]
    assert_array_equal(mean, np.tile(mean[0], (times.size, 1)))
    assert_allclose(newman.mean(axis=0), mean[0], rtol=1e-10)
    # drift between the frequencies of the database: a spline, 1e-4; above it the last value
    assert_allclose(mean[0], expected, rtol=1e-3, atol=1e-12)
    error = np.abs(mean[0] - expected).max() / np.abs(expected).max()
    claim = "mean drift in a swell and in a random sea"
    validated(Kind.CLOSED_FORM, claim, "Σ a² D(ω)", error, 1e-3, Feature.MEAN_DRIFT)


def test_slow_load_is_the_double_sum_at_the_place_of_the_body(box: Box) -> None:
    x, y, times = 70.0, 40.0, np.array([100.0, 117.5, 160.0])
    at = body(box, location=(x, y))
    found = loads(loads_model(environment(SWELL), [at], 90.0, 0.5, 80.0), times)[2]
    waves = components(SWELL, Environment())
    D = mean_drift_at(box, waves.heading, waves.omega)
    along = x * np.cos(waves.heading) + y * np.sin(waves.heading)
    for t, load in zip(times, found, strict=True):
        theta = waves.omega * t - waves.wavenumber * along + waves.phase
        pairs = np.cos(theta[:, None] - theta) * np.outer(waves.amplitude, waves.amplitude)
        double = np.array([np.sum(pairs * 0.5 * (d[:, None] + d)) for d in D.T])
        assert_allclose(load, double, atol=1e-12 * np.abs(pairs).sum() * D.max())


def test_spectrum_of_the_surge_force(box: Box) -> None:
    """Over the repeat period each line of the force is |X|^2 S dw."""
    train = replace(SWELL, heading=0.0)
    model = loads_model(environment(train), [body(box)], 0.0, 0.05, 1800.0)
    surge = model.values[3:-4, 1 + list(model.first_dof).index(0)]
    lines = 2 * np.abs(np.fft.rfft(surge) / surge.size) ** 2
    index = np.arange(1, 500)
    omega = index * 2 * np.pi / 1800.0
    load = froude_krylov(omega, np.zeros(1))[:, 0, 0]
    expected = np.abs(load) ** 2 * density(train.spectrum, omega) * 2 * np.pi / 1800.0
    # the spline over frequency: 5e-4 of the largest load
    assert_allclose(np.sqrt(lines[index]), np.sqrt(expected), atol=5e-4 * np.sqrt(expected.max()))


def test_sea_does_not_change_with_duration_or_step(box: Box) -> None:
    times = np.arange(0.0, 20.0, 0.5)
    elevation = loads(loads_model(environment(SWELL), [body(box)], 0.0, 0.05, 20.0), times)[0]
    for dt, duration in ((0.05, 1800.0), (0.1, 20.0), (0.5, 300.0)):
        other = loads_model(environment(SWELL), [body(box)], 0.0, dt, duration)
        assert_allclose(loads(other, times)[0], elevation, atol=1e-13)


def test_same_scene_same_bytes(box: Box) -> None:
    one, other = (
        loads_model(environment(SWELL, REGULAR), [body(box)], 0.0, 0.05, 50.0) for _ in range(2)
    )
    assert [a.tobytes() for a in one] == [a.tobytes() for a in other]


def test_trains_add_up(box: Box) -> None:
    times = np.array([3.0, 17.13, 29.9])
    sea = replace(REGULAR, heading=1.0, ramp=10.0)
    both, alone, other = (
        loads(loads_model(environment(*trains), [body(box)], 0.0, 0.05, 30.0), times)
        for trains in ((SWELL, sea), (SWELL,), (sea,))
    )
    for together, one, two in zip(both, alone, other, strict=True):
        assert_allclose(together, one + two, rtol=1e-12)


def test_two_bodies_each_have_their_own_loads(box: Box) -> None:
    times, place = np.array([5.0, 17.13]), (50.0, 20.0)
    only_first = WaveForces(True, SecondOrder.NONE)
    pair = [body(box), body(box, only_first, location=place, offset=6)]
    _, first, second = loads(loads_model(environment(SWELL), pair, 0.0, 0.05, 30.0), times, dofs=12)
    for at, dofs in ((pair[0], slice(0, 6)), (replace(pair[1], offset=0), slice(6, 12))):
        alone = loads(loads_model(environment(SWELL), [at], 0.0, 0.05, 30.0), times)
        assert_allclose(first[:, dofs], alone[1], rtol=1e-13)
        assert_allclose(second[:, dofs], alone[2], rtol=1e-13)


def test_what_has_no_load_has_no_column(box: Box) -> None:
    head_on = replace(SWELL, heading=0.0)
    model = loads_model(environment(head_on), [body(box)], 0.0, 0.05, 10.0)
    assert (list(model.first_dof), list(model.second_dof)) == ([0, 2], [0])
    locked = body(box, active=np.array([False, *[True] * 5]))
    model = loads_model(environment(head_on), [locked], 0.0, 0.05, 10.0)
    assert (list(model.first_dof), list(model.second_dof)) == ([2], [])


@pytest.mark.parametrize("trains", [(), (SWELL,), (REGULAR,)])
def test_dry_body_and_calm_water(box: Box, trains: tuple[WaveTrain, ...]) -> None:
    at = body(None) if trains else body(box)
    model = loads_model(environment(*trains), [at], 0.0, 0.05, 10.0)
    elevation, first, second = loads(model, np.array([1.0, 5.0]))
    assert not np.any(first)
    assert not np.any(second)
    assert np.all(elevation == 0.0) != bool(trains)
    assert model.first_dof.size == model.second_dof.size == 0


def test_calm_water_without_bodies() -> None:
    model = loads_model(environment(), [], 0.0, 0.05, 10.0)
    assert model.values.size == model.ramp.size == 0


def test_sea_that_would_repeat_itself_is_refused(box: Box) -> None:
    with pytest.raises(InputError, match=r"waves\.repeat_period.*1800 s.*2000 s"):
        loads_model(environment(SWELL), [body(box)], 0.0, 0.05, 2000.0)
    loads_model(environment(REGULAR), [body(box)], 0.0, 0.05, 2000.0)
