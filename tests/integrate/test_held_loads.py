"""What holds still until its load reaches a limit: peaks of that load, against closed forms.

A motion shows nothing of such a load, so that adaptive steps could grow over its peaks, and round
steps could meet a sine at its zeros alone.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
import xarray as xr
from markers import few
from scenes import (
    Acting,
    JointFriction,
    block,
    central_force,
    foot,
    joint_of,
    mooring,
    scene,
    steady,
    surge,
)
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

import hydrosim as hs
from hydrosim.compile import clock
from hydrosim.elements import Harmonic, Recorded, Table, constant
from hydrosim.scene import Method

Function = Callable[[float], float]

MASS, HEAVY = 1e4, 1e6  # kg
STATIC, KINETIC = 5e5, 3e5  # N
PERIODS = (
    *(1.0, 2.0, 3.0, 5.0, 7.3, 0.7, 0.9, 1.1, 1.25),
    *(1.6, 2.4, 2.5, 3.3, 4.0, 6.0, 8.0, 9.7, 10.0),
)
OUTPUT_STEPS = (0.1, 1.0, 5.0)
EXCESS = (1.0001, 1.002, 1.05)
CYCLES = 6
ACCURACY = 1e-6  # of the range of the motion
ACCURATE: dict[str, Any] = {"method": Method.AUTOMATIC, "accuracy": ACCURACY, "step": 0.1}


def duration_of(period: float, output_step: float) -> float:
    """Output steps that cover some periods [s]."""
    return output_step * np.ceil(max(CYCLES * period, 10.0) / output_step)


def slider(force: Harmonic, duration: float, output_step: float, **solver: Any) -> hs.Scene:
    """A block on a slider with dry friction, and a force along it."""
    resistance = Acting(friction=JointFriction(STATIC, KINETIC))
    joint = joint_of("slider", "block", None, resistance, axis=(1.0, 0.0, 0.0))
    push = central_force(surge=force)
    made = scene(block(MASS), {"push": push}, duration, output_step, **solver)
    return replace(made, joints={"slider": joint})


def slid(period: float, amplitude: float, times: np.ndarray) -> tuple[np.ndarray, int]:
    """Position (nt,) of a block that `STATIC` holds against a sine from rest, and the number of the
    changes between rest and slip.

    Slip begins where the sine exceeds the limit, in turn to both sides. Its velocity is elementary:
    the zero of it is sought between its largest value and the next zero of the sine.
    """
    w = 2.0 * np.pi / period
    begins = np.arcsin(STATIC / amplitude) / w

    def velocity(t: float) -> float:
        work = amplitude / w * (np.cos(w * begins) - np.cos(w * t))
        return (work - KINETIC * (t - begins)) / MASS

    def way(t: np.ndarray) -> np.ndarray:
        u = t - begins
        swing = amplitude / w * np.cos(w * begins) * u
        swing -= amplitude / w**2 * (np.sin(w * t) - np.sin(w * begins))
        return (swing - 0.5 * KINETIC * u**2) / MASS

    ends = brentq(velocity, begins + 0.25 * period, begins + period, xtol=1e-15)
    assert ends < begins + 0.5 * period  # at rest before the next peak
    position = np.zeros(times.size)
    changes = 0
    for k in range(int(times[-1] / (0.5 * period)) + 1):
        start = 0.5 * k * period
        after = np.clip(times - start, begins, ends)
        position += (-1.0) ** k * way(after)
        changes += int(start + begins < times[-1]) + int(start + ends < times[-1])
    return position, changes


def largest_error(found: np.ndarray, exact: np.ndarray, size: float) -> float:
    return float(np.abs(found - exact).max() / size)


def sliding_error(run: xr.Dataset, period: float, excess: float) -> float:
    """Largest error of a run of `slider`, whose every change of mode is an event."""
    exact, changes = slid(period, excess * STATIC, run.time.values)
    fine, _ = slid(period, excess * STATIC, np.linspace(0.0, period, 1001))
    assert run.attrs["solver_events"] == changes
    return largest_error(surge(run), exact, np.ptp(fine))


@pytest.mark.parametrize("output_step", OUTPUT_STEPS)
@pytest.mark.parametrize("excess", EXCESS)
@pytest.mark.parametrize("period", few(PERIODS, 5))
def test_dry_friction_of_a_joint_gives_way_at_every_peak(period, excess, output_step, figure):
    duration = duration_of(period, output_step)
    run = hs.simulate(slider(Harmonic(excess * STATIC, period), duration, output_step, **ACCURATE))
    error = sliding_error(run, period, excess)
    figure("error", error)
    assert error <= ACCURACY


@pytest.mark.parametrize("output_step", OUTPUT_STEPS)
@pytest.mark.parametrize("excess", [1.002, 1.005, 1.05])
@pytest.mark.parametrize("period", [1.0, 3.0, 7.3])
def test_a_fixed_step_meets_every_peak(period, excess, output_step, figure):
    """Also where it records each step, and where a peak is shorter; the error is rk4's."""
    settings = {"method": Method.RK4, "step": 0.1}
    force = Harmonic(excess * STATIC, period)
    run = hs.simulate(slider(force, duration_of(period, output_step), output_step, **settings))
    error = sliding_error(run, period, excess)
    figure("error", error)
    assert error <= (2.0 * np.pi * 0.1 / period) ** 4 / 150.0


def breaking(force: Harmonic, duration: float, output_step: float, **solver: Any) -> hs.Scene:
    """A block on a fixed joint that breaks, and a force on it."""
    joint = hs.Fixed("block", breaks_at=STATIC)
    push = central_force(surge=force)
    made = scene(block(MASS), {"push": push}, duration, output_step, **solver)
    return replace(made, joints={"bolt": joint})


def flown(excess: float, period: float, times: np.ndarray) -> np.ndarray:
    """Position (nt,) of a block that flies freely from where mean + half amplitude exceeds the
    limit."""
    half = 0.5 * excess * STATIC
    w = 2.0 * np.pi / period
    begins = np.arcsin(2.0 / excess - 1.0) / w
    u = np.maximum(times - begins, 0.0)
    swing = np.cos(w * begins) * u / w - (np.sin(w * (begins + u)) - np.sin(w * begins)) / w**2
    return half * (0.5 * u**2 + swing) / MASS


@pytest.mark.parametrize("output_step", OUTPUT_STEPS)
@pytest.mark.parametrize("excess", EXCESS)
@pytest.mark.parametrize("period", few(PERIODS, 5))
def test_a_joint_breaks_at_its_first_peak(period, excess, output_step, figure):
    half = 0.5 * excess * STATIC
    duration = duration_of(period, output_step)
    pull = Harmonic(half, period, mean=half)
    run = hs.simulate(breaking(pull, duration, output_step, **ACCURATE))
    exact = flown(excess, period, run.time.values)
    error = largest_error(surge(run), exact, np.ptp(exact))
    figure("error", error)
    assert run.attrs["solver_events"] == 1
    assert error <= ACCURACY


@pytest.mark.parametrize("excess", EXCESS)
def test_the_time_of_a_break_has_the_order_of_the_method(excess: float, figure) -> None:
    half = 0.5 * excess * STATIC
    force = Harmonic(half, 2.0, mean=half)
    errors = []
    for step in (0.1, 0.05, 0.025):
        run = hs.simulate(breaking(force, 10.0, 0.1, method=Method.RK4, step=step))
        errors.append(largest_error(surge(run), flown(excess, 2.0, run.time.values), 1.0))
    order = np.log2(errors[0] / errors[-1]) / 2.0
    figure("order", order)
    assert order >= 3.7


def beat(times: np.ndarray) -> np.ndarray:
    """Two sines of about 1 s that are together at 10.5 s alone, with peaks below 1 before."""
    return 0.5 * (np.sin(2.0 * np.pi * times) - np.sin(2.0 * np.pi / 1.05 * times))


TIMES = np.arange(0.0, 26.0, 0.02)  # s, of records


@pytest.mark.parametrize("method", [Method.RK4, Method.AUTOMATIC, Method.ESDIRK4])
def test_a_line_that_is_heaved_in_parts_at_its_first_peak(method: Method) -> None:
    """Both of its ends are at rest: rigid friction holds the block until the line has parted."""
    stiffness, rest, limit, away = 1e6, 3.5e5, 5e5, -3.5e5
    size = 1.002 * (limit - rest)
    length = Recorded(TIMES, 10.0 - (rest + size * beat(TIMES)) / stiffness)
    parts = hs.Active(until=hs.When(0.0, "spring_tension.wire", above=limit))
    curve = np.array([0.0, 1.0]), np.array([0.0, stiffness])
    normal = hs.PrescribedNormal(constant(1e6))
    wire = hs.Spring(
        "block",
        (0.0, 0.0, 0.0),
        (10.0, 0.0, 0.0),
        length,
        curve=hs.TensionCurve(*curve),
        active=parts,
    )
    pad = foot(normal, hs.Coulomb(0.25, 0.1))
    elements = {"foot": pad, "push": steady(surge=away), "wire": wire}
    run = hs.simulate(scene(block(MASS, ["surge"]), elements, 25.0, 5.0, method=method, step=0.1))
    spline = CubicSpline(length.time, length.value)
    begins = spline.solve(10.0 - limit / stiffness, extrapolate=False)[0]
    u = np.maximum(run.time.values - begins, 0.0)
    exact = 0.5 * (away + 0.1e6) / MASS * u**2
    np.testing.assert_allclose(surge(run), exact, atol=1e-9 * np.ptp(exact))


def pressed(
    normal: Harmonic | Recorded, push: Table, duration: float, output_step: float, **solver: Any
) -> hs.Scene:
    """A block on rigid friction under a normal force over time, pushed, on a soft mooring."""
    law = hs.Coulomb(0.3, 0.1)
    along = np.diag([1e5, 0, 0, 0, 0, 0])
    held, pad = hs.LinearMooring("block", along, along), foot(hs.PrescribedNormal(normal), law)
    elements = {"foot": pad, "push": central_force(surge=push), "mooring": held}
    return scene(block(HEAVY, ["surge"]), elements, duration, output_step, **solver)


def pieces(normal: Function, push: Function, times: np.ndarray) -> tuple[np.ndarray, int]:
    """The same block by DOP853, from event to event: position (nt,), and number of events."""
    end = times[-1]
    position = np.zeros(times.size)
    t, x, events = 0.0, 0.0, 0
    while (start := _breaks_away(normal, push, t, x, end)) < end:
        position[(times >= t) & (times <= start)] = x
        slip = _slip(normal, push, start, x, end)
        inside = (times > start) & (times <= slip.t[-1])
        position[inside] = slip.sol(times[inside])[0]
        t, x = slip.t[-1], slip.y[0, -1]
        events += 1 + slip.t_events[0].size
    position[times >= t] = x
    return position, events


def _load(push: Function, t: float, x: float, v: float) -> float:
    return push(t) - 1e5 * x - 1e5 * v


def _breaks_away(normal: Function, push: Function, t: float, x: float, end: float) -> float:
    """Time from ``t`` on at which rest at ``x`` ends; the end if it does not."""

    def beyond(u: float) -> float:
        return abs(_load(push, u, x, 0.0)) - 0.3 * normal(u)

    looks = np.arange(t, end, 1e-3)
    loose = np.flatnonzero([beyond(u) > 0.0 for u in looks])
    if loose.size == 0 or loose[0] == 0:
        return end if loose.size == 0 else t
    return float(brentq(beyond, looks[loose[0] - 1], looks[loose[0]], xtol=1e-14))


def _slip(normal: Function, push: Function, start: float, x: float, end: float) -> Any:
    """Slip from rest at ``x``, until it stops or to the end."""
    way = np.sign(_load(push, start, x, 0.0))

    def rates(t: float, y: np.ndarray) -> list[float]:
        return [y[1], (_load(push, t, *y) - way * 0.1 * normal(t)) / HEAVY]

    def stops(t: float, y: np.ndarray) -> float:
        return float(way * y[1]) if t > start + 1e-6 else 1.0

    stops.terminal, stops.direction = True, -1.0  # type: ignore[attr-defined]
    exact = {"rtol": 1e-12, "atol": 1e-14, "dense_output": True, "max_step": 0.02}
    return solve_ivp(rates, (start, end), [x, 0.0], "DOP853", events=stops, **exact)


@pytest.mark.parametrize("output_step", [0.2, 1.0, 5.0])
@pytest.mark.parametrize(("period", "phase"), [(0.4, -0.75 * np.pi), (1.0, 0.3), (5.0, 0.0)])
def test_a_normal_force_that_dips_lets_go(period, phase, output_step, figure):
    """The push grows to 2.5 % above what the least normal force holds."""
    normal = Harmonic(2e5, period, mean=1e6, phase=phase)
    push = Table(np.array([0.0, 2.0]), np.array([0.0, 1.025 * 0.3 * 8e5]))
    run = hs.simulate(pressed(normal, push, 10.0, output_step, **ACCURATE))
    exact, events = pieces(
        lambda t: 1e6 + 2e5 * np.sin(2.0 * np.pi * t / period + phase),
        lambda t: float(np.interp(t, push.time, push.value)),
        run.time.values,
    )
    error = largest_error(surge(run), exact, np.ptp(exact))
    figure("error", error)
    assert run.attrs["solver_events"] == events
    assert error <= ACCURACY


def test_a_recorded_normal_force_is_followed_as_its_sine(figure) -> None:
    """Its values are 0.02 s apart, and steps between outputs would be 5 s long."""
    time = np.arange(0.0, 11.0, 0.02)
    sine = 1e6 + 2e5 * np.sin(2.0 * np.pi * time / 0.4 - 0.75 * np.pi)
    push = Table(np.array([0.0, 2.0]), np.array([0.0, 1.025 * 0.3 * 8e5]))
    make = partial(pressed, push=push, duration=10.0, output_step=5.0, **ACCURATE)
    smooth = hs.simulate(make(Harmonic(2e5, 0.4, mean=1e6, phase=-0.75 * np.pi)))
    record = hs.simulate(make(Recorded(time, sine)))
    figure("steps", record.attrs["solver_steps"])
    assert record.attrs["solver_events"] == smooth.attrs["solver_events"] >= 1
    assert record.attrs["solver_steps"] < 3 * smooth.attrs["solver_steps"]
    np.testing.assert_allclose(surge(record), surge(smooth), rtol=1e-4)


@pytest.mark.parametrize("method", [Method.AUTOMATIC, Method.ESDIRK4])
def test_a_steep_friction_slope_that_creeps_saturates_at_every_peak(method: Method) -> None:
    """It creeps by less than the tolerance of velocities."""
    limit = 0.3e6
    law = hs.FrictionSlope(0.3, 1e10)
    push = Recorded(TIMES, 1.002 * limit * beat(TIMES))
    normal = hs.PrescribedNormal(constant(1e6))
    elements = {"foot": foot(normal, law), "push": central_force(surge=push)}
    run = hs.simulate(scene(block(MASS, ["surge"]), elements, 25.0, 5.0, method=method, step=0.1))
    spline = CubicSpline(push.time, push.value)
    above = [spline.solve(level, extrapolate=False).size for level in (limit, -limit)]
    peaks = sum(above) // 2
    assert peaks > 1
    assert run.attrs["solver_events"] == 2 * peaks  # into slip and back


def test_where_nothing_holds_no_step_is_spent(monkeypatch: pytest.MonkeyPatch) -> None:
    """The steps of a block that is free are those without a limit for what holds."""
    force = Harmonic(1e5, 0.5)
    push = central_force(surge=force)
    spring = mooring(surge=1e5)
    forces, body = {"push": push, "spring": spring}, block(MASS, ["surge"])
    free = scene(body, forces, 100.0, 5.0, method=Method.DOPRI5)
    run = hs.simulate(free)
    monkeypatch.setattr(clock, "held_step", lambda compiled: np.inf)
    without = hs.simulate(free)
    assert run.attrs["solver_steps"] == without.attrs["solver_steps"]
    xr.testing.assert_equal(run.position, without.position)
