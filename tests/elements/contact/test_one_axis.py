"""Blocks that are pressed on a floor and pushed along it, against `one_axis`."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
import xarray as xr
from markers import few
from one_axis import OPEN, SLIP, STICK, Block, Exact, integrate
from scenes import block, foot, moving, on_floor, scene, steady, straight_curve
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

import hydrosim as hs
from hydrosim import simulate
from hydrosim.elements import Harmonic, Recorded, Table
from hydrosim.report.evidence import Feature, Kind

TIME = np.arange(0.0, 20.25, 0.25)
STEPS = (0.005, 0.0025, 0.00125)
LAWS = {hs.StickSlip: Feature.STICK_SLIP, hs.FrictionSlope: Feature.SLOPE}
EXACT = 1e-7  # of the range of the motion, at the smallest step
STEEL = hs.StickSlip(static=0.2, kinetic=0.1, stiffness=1.4e7, damping=8e5, slip_damping=1e5)


def line(stiffness: float, damping: float = 0.0) -> hs.NormalCurve:
    return straight_curve(stiffness, damping)


def sine(amplitude: float, period: float, phase: float = 0.0) -> np.ndarray:
    """A sine at the points of the table; both programs draw straight lines between them."""
    return amplitude * np.sin(2 * np.pi * TIME / period + phase)


WEIGHT = np.full(TIME.size, -2e6)
STEADY = Block(1e6, line(2e7), STEEL, TIME, sine(4.3e5, 7.3), WEIGHT, start=(0, 0, -0.1, 0))
BREATHING = replace(STEADY, start=(0, 0, -0.1, 0.2))
BLOCKS = {
    "steady normal force": STEADY,
    "breathing normal force": BREATHING,
    "bouncing": replace(STEADY, start=(0, 0.3, 0.2, 0)),
    "no slip damping": replace(BREATHING, friction=replace(STEEL, slip_damping=0.0)),
    "slip damping alone": replace(
        BREATHING, friction=replace(STEEL, damping=0.0, slip_damping=1e6)
    ),
    "static as kinetic": replace(BREATHING, friction=replace(STEEL, kinetic=0.2)),
    "on a spring": replace(BREATHING, push=0 * TIME, spring=(1e6, 0.0), start=(1, 0, -0.1, 0.2)),
    "friction slope": replace(
        BREATHING, friction=hs.FrictionSlope(0.15, 2e6), spring=(4e5, 0.0), start=(0, 0, -0.1, 0.2)
    ),
    "the base case's four fenders": Block(
        *(1.7e8, line(392.4e6), hs.StickSlip(0.2, 0.1, 5.6e8, 3.3e7, 1e6), TIME, sine(9e6, 7.6)),
        press=-3.5e7 + sine(8e6, 8.3, 1.0),
        spring=(1.57e6, 1.32e8),
        start=(0, 0, -0.06, 0),
    ),
}
PULSES = Harmonic(3e6, 4.7, mean=1e6, phase=0.4)
TABLED = Table(TIME[::8], 1e6 + 3e6 * np.sin(TIME[::8]))
RECORDED = Recorded(TIME, 1e6 + 3e6 * np.sin(2 * np.pi * TIME / 4.7 + 0.4))
PRESCRIBED = replace(STEADY, press=0 * TIME, spring=(2e5, 1e8), start=(0, 0, 0.5, 0))
for name, force, law in (
    *(("a sine", PULSES, STEEL), ("a sine, friction slope", PULSES, hs.FrictionSlope(0.15, 2e6))),
    *(("a table", TABLED, STEEL), ("a record", RECORDED, STEEL)),
):
    curve = hs.PrescribedNormal(force)
    BLOCKS[f"prescribed, {name}"] = replace(PRESCRIBED, curve=curve, friction=law)
KNEES = hs.NormalCurve(np.array([0.0, 0.1, 0.2, 0.3]), np.array([0.0, 1e5, 4e5, 2e6]))
LOADS = (TIME, 0 * TIME, np.full(TIME.size, -9.81e4))
FALLING = Block(1e4, KNEES, hs.Frictionless(), *LOADS, start=(0, 0, 0.6, 0), duration=4.0)


@lru_cache
def exact(name: str) -> Exact:
    block = BLOCKS[name]
    return integrate(block, output_times(block))


def output_times(block: Block) -> np.ndarray:
    return 0.1 * np.arange(round(block.duration / 0.1) + 1)


def error(run: xr.Dataset, reference: Exact) -> float:
    """Largest error of surge and heave, each relative to its range."""
    motion, expected = run.position.values[:, 0, [0, 2]], reference.states[:, [0, 2]]
    span = np.maximum(np.ptp(expected, axis=0), 1e-6)
    return float((np.abs(motion - expected).max(axis=0) / span).max())


def order(errors: list[float]) -> float:
    return float(np.log2(errors[0] / errors[-1]) / (len(errors) - 1))


@pytest.mark.kernels
@pytest.mark.parametrize("name", BLOCKS)
def test_motion_is_that_of_an_independent_integration(name, figure, validated):
    """To 1e-7 of its range, at order 4, with the same modes and the same number of events."""
    runs = [simulate(BLOCKS[name].scene(step)) for step in STEPS]
    errors = [error(run, exact(name)) for run in runs]
    figure("order", order(errors))
    assert order(errors) >= 3.5
    law = LAWS[type(BLOCKS[name].friction)]
    claim = f"block that is pressed on a floor and pushed, {law}, of its range"
    features = (Feature.FENDERS, law)
    validated(Kind.INDEPENDENT, claim, "DOP853 by events", errors[-1], EXACT, *features)
    for run in runs:
        assert np.array_equal(run.fender_mode.values[:, 0], exact(name).modes)
        assert run.solver_events == exact(name).events.size
    assert exact(name).events.size >= 4  # that there is something to hit


@pytest.mark.parametrize("name", ["steady normal force", "bouncing", "on a spring"])
def test_without_events_every_method_falls_to_low_order(name: str, figure) -> None:
    steps = [0.05 / 2**i for i in range(5)]
    errors = [error(simulate(BLOCKS[name].scene(h, events=False)), exact(name)) for h in steps]
    figure("order without events", order(errors))
    assert order(errors) <= 2.2
    cut = error(simulate(BLOCKS[name].scene(steps[-1])), exact(name))
    figure("gain of events", errors[-1] / cut)
    assert errors[-1] >= 100 * cut


def test_curve_with_corners(figure, validated) -> None:
    """A body bounces through all pieces of its curve: order 4, its energy conserved."""
    reference = integrate(FALLING, output_times(FALLING))
    runs = [simulate(FALLING.scene(step)) for step in (0.004, 0.002, 0.001)]
    errors = [error(run, reference) for run in runs]
    losses = [run.energy_residual_relative for run in runs]
    figure("order", order(errors))
    figure("energy lost", losses[-1])
    claim = "body that bounces on a fender of three stiffnesses, of its range"
    validated(Kind.INDEPENDENT, claim, "DOP853 by events", errors[-1], EXACT, Feature.FENDERS)
    assert order(errors) >= 3.5
    assert order(losses) >= 3.5
    assert losses[-1] <= 1e-6
    assert all(run.solver_events == reference.events.size for run in runs)
    assert runs[-1].fender_compression.max() > 0.2  # the last piece


MASS = 1.945e8  # kg, of which 5 % of critical damping on 5.6e8 N/m is 3.3e7 N s/m
SLIP_DAMPING = (0.0, 1e6, 1e8, 1e10)  # N s/m
PAIRS = ((0.7, 0.4), (0.4, 0.2), (0.2, 0.04), (0.2, 0.1), (0.7, 0.6))  # static, kinetic
SAMPLES = 0.01 * np.arange(1001)


def one_dimensional(k: int) -> Block:
    """The 1-D model of Plasterk (2017, chapter 5), set ``k``: every C3 with every pair of friction
    factors, K2 from 5.6e6 to 5.6e8 N/m, C2 5 % of critical; waves push it and press it against the
    topside, in every third set so fast and hard that contact opens and closes every second."""
    rng, time, fast = np.random.default_rng(k), 0.25 * np.arange(41), k % 3 == 1
    K2 = 5.6e6 * 100.0 ** rng.uniform()
    law = hs.StickSlip(*PAIRS[k % 5], K2, 0.05 * 2 * np.sqrt(K2 * MASS), SLIP_DAMPING[k % 4])
    contact, N = 392.4e6, rng.uniform(1e7, 4e7)

    def waves(amplitude: float, period: float) -> np.ndarray:
        return amplitude * np.sin(2 * np.pi * time / period + rng.uniform(0, 2 * np.pi))

    push = sum(waves(law.static * N * rng.uniform(0.8, 2.0), rng.uniform(3, 9)) for _ in range(2))
    press = waves(rng.uniform(0.2, 1.2) * N, rng.uniform(3, 9))
    press += 5e8 * np.cos(2 * np.pi * time) if fast else 0.0
    speeds = rng.uniform(-0.1, 0.1, 2)
    start = {"spring": (392.4e3, 1.32e8), "start": (0.0, speeds[0], -N / 5.244e8, speeds[1])}
    loads = (time, np.asarray(push), press - N)
    return Block(MASS, line(contact), law, *loads, **start, duration=10.0)


@pytest.mark.parametrize("k", few(range(20), 6))
def test_one_dimensional_model_with_random_parameters(k, figure, validated):
    """To 1e-7 of the range at 0.01 s. The same sequence of modes: as many changes, and the same
    mode every 0.01 s (but where a change is at the very sample)."""
    block = one_dimensional(k)
    reference = integrate(block, SAMPLES)
    run = simulate(block.scene(0.01, output_step=0.01))
    figure("events", reference.events.size)
    off = error(run, reference)
    claim = "one-dimensional model of Plasterk 2017, 20 random sets, of its range"
    features = (Feature.FENDERS, Feature.STICK_SLIP)
    validated(Kind.INDEPENDENT, claim, "DOP853 by events", off, EXACT, *features)
    assert run.solver_events == reference.events.size >= (10 if k % 3 == 1 else 2)
    apart = np.abs(SAMPLES[:, None] - reference.events).min(axis=1) > 1e-6
    assert np.array_equal(run.fender_mode.values[apart, 0], reference.modes[apart])


def stretch(run: xr.Dataset) -> np.ndarray:
    return run.position.values[:, 0, 0] - run.fender_node.values[:, 0, 0]


@pytest.mark.parametrize(
    "name", [n for n, b in BLOCKS.items() if isinstance(b.friction, hs.StickSlip)]
)
def test_traction_of_stick_slip(name: str) -> None:
    """At most mu_s N in stick, mu_k N + C3 |v2| in slip, none when open."""
    law, run = BLOCKS[name].friction, simulate(BLOCKS[name].scene(0.01))
    assert isinstance(law, hs.StickSlip)
    size = np.linalg.norm(run.fender_friction.values[:, 0], axis=1)
    N, mode = run.fender_normal_force.values[:, 0], run.fender_mode.values[:, 0]
    T = law.stiffness * stretch(run) + law.damping * run.velocity.values[:, 0, 0]
    node = (np.abs(T) - law.kinetic * N) / (law.damping + law.slip_damping)
    tiny = 1e-9 * N.max()
    assert np.all(size[mode == STICK] <= law.static * N[mode == STICK] + tiny)
    assert np.all(node[mode == SLIP] >= -tiny / law.stiffness)
    expected = law.kinetic * N + law.slip_damping * node
    np.testing.assert_allclose(size[mode == SLIP], expected[mode == SLIP], atol=tiny)
    assert np.all(size[mode == OPEN] == 0.0)
    assert np.all(N[mode != OPEN] >= 0.0)


def test_an_open_node_springs_back() -> None:
    """Once the block is lifted off, the stretch decays as exp(-K2 t / C2)."""
    loads = {"time": np.array([0.0, 20.0]), "push": np.full(2, 1.5e5), "press": np.full(2, 5e4)}
    start = {"start": (0, 0, -1e-3, 0), "friction": replace(STEEL, damping=7e6)}
    lifted = replace(STEADY, **loads, **start, duration=4.0)
    run = simulate(lifted.scene(0.01, output_step=0.05))
    open_ = np.flatnonzero(run.fender_mode.values[:, 0] == OPEN)
    s, t = stretch(run)[open_], run.time.values[open_]
    assert abs(s[0]) > 1e-6
    np.testing.assert_allclose(s[:40], s[0] * np.exp(-2.0 * (t[:40] - t[0])), rtol=1e-7)


def test_planar_slip_dissipates_kinetic_friction_times_the_path(figure) -> None:
    """mu_k N along the node's path, and C2 |s'|^2 + C3 |v2|^2 apart; path and velocities are taken
    from the recorded motion by splines."""
    N, law = 2e5, hs.StickSlip(0.3, 0.2, 2e6, 1e5, 2e4)
    start = {"position": moving(heave=-0.02), "velocity": moving(surge=5.0, sway=1.0)}
    body = block(1e5, ("surge", "sway", "heave"), **start)
    wind = steady(heave=-N, sway=2e4)
    run = simulate(scene(body, {"wind": wind, "fender": on_floor(1e7, law)}, 2.0, 0.01, step=0.005))
    sliding = run.fender_mode.values[:, 0] == SLIP
    assert sliding[1:].all()
    t = run.time.values
    node = CubicSpline(t, run.fender_node.values[:, 0, :2])
    s = CubicSpline(t, run.position.values[:, 0, :2] - run.fender_node.values[:, 0, :2])
    fine = np.linspace(0.5, 2.0, 3001)  # past the rise of the stretch, which splines round off
    speed = np.linalg.norm(node(fine, 1), axis=1)
    path = np.trapezoid(speed, fine)
    losses = law.damping * np.linalg.norm(s(fine, 1), axis=1) ** 2 + law.slip_damping * speed**2
    begin = np.searchsorted(t, 0.5)
    lost = float(run.fender_dissipated[-1, 0] - run.fender_dissipated[begin, 0])
    slid = float(run.fender_slip_distance[-1, 0] - run.fender_slip_distance[begin, 0])
    figure("path", path)
    assert slid == pytest.approx(path, rel=1e-7)
    assert lost == pytest.approx(law.kinetic * N * path + np.trapezoid(losses, fine), rel=1e-6)
    assert np.ptp(np.arctan2(*node(fine, 1).T)) > 0.05  # the path is curved


def test_normal_damping(figure) -> None:
    """One impact of a mass on a spring and damper, which lets go where N = 0 (not at delta = 0)."""
    m, k, c, speed = 1e3, 1e6, 1.2e4, 2.0
    n, w = c / (2 * m), np.sqrt(k / m - (c / (2 * m)) ** 2)

    def rate(t: float) -> float:
        return float(speed * np.exp(-n * t) * (np.cos(w * t) - n / w * np.sin(w * t)))

    def force(t: float) -> float:
        return float(k * speed / w * np.exp(-n * t) * np.sin(w * t) + c * rate(t))

    let_go = brentq(force, 0.5 * np.pi / w, np.pi / w, xtol=1e-14)
    body = block(m, ("heave",), position=moving(heave=speed * 0.05), velocity=moving(heave=-speed))
    floor = foot(line(k, c), hs.Frictionless())
    runs = [simulate(scene(body, {"floor": floor}, 0.4, 0.1, step=h)) for h in (0.002, 0.001)]
    errors = [abs(-rate(let_go) - run.velocity.values[-1, 0, 2]) for run in runs]
    figure("speed afterwards", -rate(let_go))
    figure("error", errors[-1])
    figure("order", order(errors))
    assert errors[-1] <= 1e-6
    assert order(errors) >= 3.5
    assert all(run.solver_events == 2 for run in runs)


def test_without_rates_a_prescribed_normal_force_is_felt_at_once(figure) -> None:
    """C2 = C3 = 0: in slip the friction is mu_k N(t) at any instant, so a sliding block loses
    mu_k N / m of its speed per second; between the corners of N, where steps end, its speed is a
    parabola and its place a cubic."""
    m, v, law = 1e5, 9.0, hs.StickSlip(0.3, 0.2, 2e7, 0.0)
    time, N = np.array([0.0, 0.33, 0.7, 1.24, 2.0]), np.array([1e5, 9e5, 2e5, 2e5, 1.5e6])
    body = block(m, ("surge",), velocity=moving(surge=v))
    pad = foot(hs.PrescribedNormal(Table(time, N)), law)
    run = simulate(scene(body, {"pad": pad}, 2.0, 0.1, step=0.1))
    sliding = run.time.values > 0.1
    assert (run.fender_mode.values[sliding] == SLIP).all()
    expected = 0.2 * np.interp(run.time.values, time, N)
    felt = -run.force_pad.values[:, 0, 0]
    figure("largest difference to mu_k N", np.abs(felt - expected)[sliding].max())
    np.testing.assert_allclose(felt[sliding], expected[sliding], rtol=1e-10)
