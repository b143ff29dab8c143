"""Signals: values and rates against numpy and scipy, motions under them against closed forms."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import block, central_force, errors, observed_orders, scene, surge
from scipy.interpolate import CubicSpline

import hydrosim as hs
from hydrosim.elements import Harmonic, Recorded, Signal, Table, constant
from hydrosim.elements.signal import compile_signals, corners, rate, time_of_largest, value
from hydrosim.report.evidence import Feature, Kind

RNG = np.random.default_rng(3)
EVEN = np.linspace(2.0, 12.0, 41)
UNEVEN = np.sort(RNG.uniform(2.0, 12.0, 41))
CLUSTERED = np.array([0.0, 1e-6, 2e-6, 5.0, 5.0001, 9.0, 100.0])
TIMES = {"even": EVEN, "nearly even": EVEN + RNG.uniform(-0.1, 0.1, 41), "uneven": UNEVEN}


def evaluate(signal: Signal, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values and rates of a signal that is compiled behind others."""
    each, pieces = compile_signals([constant(7.0), Table(EVEN, np.sin(EVEN)), signal])
    return tuple(np.array([f(t, each[2], pieces) for t in times]) for f in (value, rate))


@pytest.mark.parametrize("time", [*TIMES.values(), CLUSTERED], ids=[*TIMES, "clustered"])
def test_a_table_is_straight_lines(time: np.ndarray) -> None:
    force = RNG.normal(size=time.size)
    between = RNG.uniform(time[0] - 3.0, time[-1] + 3.0, 500)
    at = np.concatenate([between, time, np.nextafter(time, -np.inf)])
    values, rates = evaluate(Table(time, force), at)
    assert_allclose(values, np.interp(at, time, force), rtol=0, atol=1e-13)
    slopes = np.array([0.0, *np.diff(force) / np.diff(time), 0.0])
    assert_allclose(rates, slopes[np.searchsorted(time, at, side="right")], rtol=1e-15)


@pytest.mark.parametrize("time", TIMES.values(), ids=TIMES)
def test_a_record_is_a_cubic_spline(time: np.ndarray) -> None:
    """Of scipy, to rounding: values are of order 1, rates of order 10 where points are close."""
    force = np.sin(time) + 0.1 * np.cos(7 * time)
    at = np.concatenate([np.linspace(time[0], time[-1], 1001), time])
    values, rates = evaluate(Recorded(time, force), at)
    spline = CubicSpline(time, force)
    assert_allclose(values, spline(at), rtol=0, atol=1e-14)
    assert_allclose(rates, spline(at, 1), rtol=0, atol=1e-12)


def test_a_harmonic() -> None:
    at = np.linspace(-5.0, 50.0, 301)
    values, rates = evaluate(Harmonic(3.0, 8.0, mean=-2.0, phase=0.7), at)
    assert_allclose(values, -2.0 + 3.0 * np.sin(2 * pi * at / 8.0 + 0.7), rtol=1e-14, atol=1e-14)
    assert_allclose(rates, 3.0 * 2 * pi / 8.0 * np.cos(2 * pi * at / 8.0 + 0.7), atol=1e-14)


def test_only_tables_have_corners() -> None:
    assert np.array_equal(corners(Table(UNEVEN, UNEVEN)), UNEVEN)
    assert corners(Recorded(UNEVEN, UNEVEN)).size == corners(Harmonic(1.0, 2.0)).size == 0


@pytest.mark.parametrize(
    "signal",
    [
        Table(UNEVEN, np.sin(UNEVEN)),
        Recorded(EVEN, np.cos(EVEN)),
        Harmonic(2.0, 5.0, phase=0.4),
        Harmonic(-2.0, 5.0, mean=1.0, phase=0.4),
    ],
)
def test_the_crest_of_a_signal(signal: Signal) -> None:
    each, pieces = compile_signals([constant(9.0), signal])
    at = UNEVEN if isinstance(signal, Table) else np.linspace(0.0, 20.0, 801)
    highest = max(value(t, each[1], pieces) for t in at)
    assert value(time_of_largest(each[1], pieces), each[1], pieces) >= highest * (1 - 1e-3)


def test_what_a_record_misses_bounds_its_error() -> None:
    """The error of cubic splines is of order 4: halving the spacing divides it by 16."""
    fine = np.linspace(0.0, 20.0, 4001)
    for spacing in (0.1, 0.05, 0.025):
        time = np.arange(0.0, 20.0 + spacing / 2, spacing)
        record = Recorded(time, np.sin(2.0 * time))
        error = np.abs(CubicSpline(time, record.value)(fine) - np.sin(2.0 * fine)).max()
        assert record.largest_miss() / 16 == pytest.approx(error, rel=0.2)


MASS = 5.0


def pushed(signal: Signal, step: float = 0.02, **solver: object) -> hs.Scene:
    """A mass at rest that a signal pushes along x for 20 s."""
    push = central_force(surge=signal)
    body = block(MASS, ("surge",))
    return scene(body, {"push": push}, 20.0, 0.5, step=step, **solver)


def test_motion_under_a_sine(validated) -> None:
    """The double integral of (mean + A sin(w t + phase)) / m; rk4 is Simpson's rule for it, off
    by no more than T A w^4 h^4 / 2880 w / m."""
    force, w = Harmonic(3.0, 8.0, mean=0.5, phase=0.7), 2 * pi / 8.0
    run = hs.simulate(pushed(force))
    t, A, phase = run.time.values, force.amplitude, force.phase
    wave = A / w**2 * (np.sin(phase) - np.sin(w * t + phase)) + A / w * np.cos(phase) * t
    exact = (wave + 0.5 * force.mean * t**2) / MASS
    error = np.abs(surge(run) - exact).max()
    claim = "body under a harmonic force [m]"
    validated(Kind.CLOSED_FORM, claim, "double integral", error, 1e-8, Feature.APPLIED)
    assert run.energy_residual_relative < 1e-8


@pytest.mark.parametrize("time", [EVEN - 2.0, UNEVEN], ids=["even", "uneven"])
def test_motion_under_a_table_is_exact(time: np.ndarray) -> None:
    """Steps end at the corners, and between them the motion is a cubic, which rk4 integrates
    without error; the reference is the second antiderivative of the lines."""
    force = RNG.normal(size=time.size)
    corner = np.unique([0.0, *time, 20.0])
    at_corners = np.interp(corner, time, force)
    run = hs.simulate(pushed(Table(time, force), step=0.5))
    speed, place, expected = 0.0, 0.0, []
    for a, b, f, g in zip(corner, corner[1:], at_corners, at_corners[1:], strict=False):
        for t in run.time.values[(run.time.values >= a) & (run.time.values < b)]:
            x, slope = t - a, (g - f) / (b - a)
            expected.append(place + speed * x + (f * x**2 / 2 + slope * x**3 / 6) / MASS)
        h = b - a
        place += speed * h + (f * h**2 / 3 + g * h**2 / 6) / MASS
        speed += (f + g) * h / 2 / MASS
    assert_allclose(surge(run)[:-1], expected, rtol=0, atol=1e-11)
    assert surge(run)[-1] == pytest.approx(place, abs=1e-11)


def test_a_record_keeps_the_order_of_rk4(figure) -> None:
    """Against the antiderivatives of scipy's spline; steps miss the record's values."""
    time = np.linspace(0.0, 20.0, 53)
    record = Recorded(time, np.sin(time) + 0.3 * np.sin(2.3 * time))
    at = 0.5 * np.arange(41)
    exact = CubicSpline(time, record.value).antiderivative(2)(at) / MASS
    steps = (0.1, 0.05, 0.025)
    size = errors(pushed(record), steps, exact)
    figure("order", observed_orders(steps, size).mean())
    assert observed_orders(steps, size).mean() > 3.8
    assert size[-1] < 1e-7


@pytest.mark.parametrize(("first", "last"), [(0.0, 19.9), (0.1, 20.0)])
def test_a_run_beyond_its_record_is_refused(first: float, last: float) -> None:
    time = np.linspace(first, last, 50)
    found = rf"forces\.push\.force\.surge: found a record from {first:g} s to {last:g} s;.* 20 s"
    with pytest.raises(hs.InputError, match=found):
        hs.simulate(pushed(Recorded(time, time)))


def test_a_run_that_goes_on_beyond_its_record_is_refused() -> None:
    time = np.linspace(0.0, 30.0, 50)
    whole = pushed(Recorded(time, np.sin(time)))
    run = hs.simulate(whole)
    begun = replace(whole, initial=hs.Start(run))
    with pytest.raises(hs.InputError, match="whole run, from 20 s to its end at 40 s"):
        hs.simulate(begun)
    later = time + 15.0
    hs.simulate(replace(begun, forces=pushed(Recorded(later, np.sin(later))).forces))


def test_a_run_as_long_as_its_record() -> None:
    time = np.linspace(0.0, 20.0, 50)
    record = Recorded(time, time)
    assert hs.simulate(pushed(record)).time[-1] == 20.0
    barely = replace(record, time=time * (1.0 - 1e-12))
    assert hs.simulate(pushed(barely)).time[-1] == 20.0
