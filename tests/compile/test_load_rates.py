"""Steps at which held units look at their loads: is a cubic through their looks exact enough?"""

from dataclasses import replace
from math import inf, pi
from pathlib import Path

import numpy as np
import pytest
from scenes import block, central_force, scene, steady
from scipy.interpolate import CubicSpline

import hydrosim as hs
from hydrosim.compile.clock import MAX_PHASE_RAD, held_step, signal_step
from hydrosim.compile.compile import compile_scene
from hydrosim.elements import Harmonic, Recorded, Signal, Table, constant
from hydrosim.elements.signal import signal_rate
from hydrosim.scene import ForceElement, Method, Scene
from hydrosim.water.wind import gust_components, mean_wind

SPHERE = Path(__file__).parents[2] / "cases" / "sphere"
MISSED = 3.3e-5  # of the amplitude: MAX_PHASE_RAD^4 / 1944
TIME = np.linspace(0.0, 30.0, 301)


def pushed(signal: Signal, **solver: object) -> Scene:
    push = central_force(surge=signal)
    return scene(block(1e3), {"push": push}, 10.0, 1.0, **solver)


def pressed(signal: Signal) -> Scene:
    plane = hs.Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    normal = hs.PrescribedNormal(signal)
    foot: ForceElement = hs.Fender("block", np.zeros((1, 3)), plane, normal, hs.Frictionless())
    return scene(block(1e3), {"foot": foot}, 10.0, 1.0)


@pytest.mark.parametrize(
    ("signal", "rate"),
    [
        (constant(3.0), 0.0),
        (Harmonic(0.0, 2.0, mean=1.0), 0.0),
        (Harmonic(2.0, 4.0, mean=1.0, phase=0.3), pi / 2.0),
        (Table(TIME, np.sin(TIME)), 0.0),
        (Recorded(TIME, np.ones(TIME.size)), 0.0),
        (Recorded(TIME, 5.0 + 2.0 * np.sin(3.0 * TIME)), 3.0),
    ],
)
def test_the_rate_of_a_signal_is_that_of_its_sine(signal: Signal, rate: float) -> None:
    assert signal_rate(signal) == pytest.approx(rate, rel=0.02)


def test_only_signals_that_limits_depend_on_shorten_every_step() -> None:
    sine = Harmonic(1.0, 2.0, mean=3.0)
    assert signal_step(pushed(sine)) == inf
    assert signal_step(pressed(sine)) == pytest.approx(MAX_PHASE_RAD / pi)
    assert held_step(compile_scene(pushed(sine))) == pytest.approx(MAX_PHASE_RAD / pi)
    assert held_step(compile_scene(pushed(constant(1.0)))) == inf


def test_equal_steps_without_events_are_those_of_the_scene() -> None:
    sine = Harmonic(1.0, 2.0)
    assert held_step(compile_scene(pushed(sine, events=False))) == inf
    adaptive = pushed(sine, events=False, method=Method.DOPRI5)
    assert held_step(compile_scene(adaptive)) == pytest.approx(MAX_PHASE_RAD / pi)


def test_a_function_of_the_user_is_asked_at_the_step_of_the_solver() -> None:
    push = hs.UserForce("block", lambda t, state: np.zeros(6))
    called = scene(block(1e3), {"push": push, "more": steady(surge=1.0)}, 10.0, 1.0, step=0.05)
    assert held_step(compile_scene(called)) == 0.05


def rest_of_cubics(series: np.ndarray, points: int) -> float:
    """Largest difference [sd] of a series from cubics through every ``points``-th value."""
    node = np.arange(0, len(series) - 3 * points, points)
    worst = 0.0
    for part in np.linspace(0.0, 1.0, 21):
        x = round(part * points) / points + 1.0
        weights = [
            -(x - 1.0) * (x - 2.0) * (x - 3.0) / 6.0,
            x * (x - 2.0) * (x - 3.0) / 2.0,
            -x * (x - 1.0) * (x - 3.0) / 2.0,
            x * (x - 1.0) * (x - 2.0) / 6.0,
        ]
        cubic = sum(w * series[node + k * points] for k, w in enumerate(weights))
        exact = series[node + round(x * points)]
        worst = max(worst, float(np.sqrt(np.mean((cubic - exact) ** 2))))
    return worst / float(np.std(series))


def summed(omega: np.ndarray, amplitude: np.ndarray, phase: np.ndarray, h: float) -> np.ndarray:
    """A sum of waves at 30 times in each third of ``h``."""
    t = np.arange(15_000) * h / 90.0
    return sum(a * np.cos(w * t + e) for w, a, e in zip(omega, amplitude, phase, strict=True))


def test_the_step_in_an_irregular_sea_leaves_what_it_says() -> None:
    compiled = compile_scene(hs.load_case(SPHERE / "irregular.yaml").scene())
    h = held_step(compiled)
    (waves,) = compiled.sea
    assert rest_of_cubics(summed(waves.omega, waves.amplitude, waves.phase, h), 30) < MISSED


def test_the_step_in_gusts_leaves_what_it_says() -> None:
    gusts = {"spectrum": "npd", "repeat_period": "1 hour"}
    wind = {"speed": "20 m/s", "heading": "0 deg", "gusts": gusts}
    windy = {"environment.wind": wind, "environment.waves": None}
    made = hs.load_case(SPHERE / "irregular.yaml", windy).scene()
    gusts = made.environment.gusts
    assert gusts is not None
    waves = gust_components(gusts, mean_wind(made.environment))
    h = held_step(compile_scene(made))
    assert rest_of_cubics(summed(waves.omega, waves.amplitude[:, 0], waves.phase, h), 30) < MISSED


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_bolt_in_an_irregular_sea_breaks_at_its_largest_load(seed: int) -> None:
    """At a strength of 0.2 % below that load, it breaks in the output step of its peak."""
    calm = hs.load_case(SPHERE / "irregular.yaml", {"environment.waves.seed": seed}).scene()
    calm = replace(calm, duration=200.0)
    held = replace(calm, joints={"bolt": hs.Fixed("sphere", breaks_at=1e12)})
    fine = held.with_output(step=0.1)
    run = hs.simulate(fine)
    load = CubicSpline(run.time, np.linalg.norm(run.joint_force.values[:, 0, :3], axis=1))
    peaks = load.derivative().roots(extrapolate=False)
    strength = 0.998 * float(load(peaks).max())
    breaks = float(load.solve(strength, extrapolate=False)[0])
    bolt = hs.Fixed("sphere", breaks_at=strength)
    solver = replace(held.solver, method=Method.AUTOMATIC, accuracy=1e-6)
    weak = replace(held, joints={"bolt": bolt}, solver=solver).with_output(step=5.0)
    result = hs.simulate(weak)
    is_open = result.lock_mode.values[:, 0] == 0
    assert float(result.time[is_open.argmax()]) == 5.0 * np.ceil(breaks / 5.0)
