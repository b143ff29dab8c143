"""Steps that are stable and not accurate: closed forms, and runs as wrong as it is said of them."""

import re
from dataclasses import replace

import numpy as np
import pytest
from reading import texts
from scenes import SEA, block, central_force, in_waves, scene_of, steady, straight_curve, with_body

import hydrosim as hs
from hydrosim.elements import Harmonic
from hydrosim.elements.contact.law import SLIP, STICK
from hydrosim.integrate import methods
from hydrosim.integrate.methods import ESDIRK4, HEUN, RK2, RK4
from hydrosim.linear.linearise import linearise
from hydrosim.linear.modes import natural_modes
from hydrosim.linear.stability import Vibration, memory_response, vibration_errors
from hydrosim.report.sentences.check import check_document
from hydrosim.run.step_limits import MAX_MOTION_ERROR
from hydrosim.scene import LinearScenes, Method


@pytest.mark.parametrize(
    ("method", "part"), [(RK2, 1 / 6), (HEUN, 1 / 6), (RK4, 1 / 120)], ids=["rk2", "heun", "rk4"]
)
def test_errors_of_an_undamped_vibration(method: methods.IntegrationMethod, part: float) -> None:
    """(w h)^p w / (p + 1)! per unit of time, the first term that R leaves out of the exponential;
    the next is smaller by w h."""
    w, step, time = 2.0, 0.01, 7.0
    found = vibration_errors(method, step, time, np.array([1j * w]))[0]
    assert found == pytest.approx(part * (w * step) ** method.order * w * time, rel=0.02)


def test_what_damping_makes_a_mode_forget_does_not_count() -> None:
    damped = np.array([-0.5 + 3.0j])
    short, long, longer = (vibration_errors(RK4, 0.1, T, damped)[0] for T in (0.1, 10.0, 1e4))
    assert short < long == longer
    assert vibration_errors(RK4, 1.0, 1e6, np.array([3.0j]))[0] == 2.0
    at = np.log(1 + 0.3j + 0.5 * 0.3j**2) / 0.1  # by hand, of rk2
    assert vibration_errors(RK2, 0.1, 1.0, np.array([3.0j]))[0] == pytest.approx(abs(at - 3.0j))
    assert vibration_errors(ESDIRK4, 10.0, 1e6, np.array([3.0j]))[0] == 2.0


def ringing(method: Method, step: float, damping: float, push: float = 0.0) -> hs.Scene:
    """A mass on a spring, w = 3 rad/s, that swings freely or is pushed slowly."""
    spring = hs.LinearMooring("block", np.diag([9.0, 0, 0, 0, 0, 0]), damping * np.eye(6))
    slow = central_force(surge=Harmonic(push, 2 * np.pi / 0.3))
    free = 0.0 if push else 1.0
    body = block(1.0, ["surge"], position=(free, 0, 0, 0, 0, 0))
    solver = hs.Solver(method=method, step=step, linear=LinearScenes.STEP)
    forces = {"spring": spring, "push": slow}
    return hs.Scene("ringing", 60.0, (body,), forces=forces, solver=solver, output={"step": 0.25})


def told(run: object) -> list[str]:
    """The warning of what is not resolved."""
    return [line for line in run.attrs.get("warnings", "").splitlines() if "resolve" in line]


def apart(scene: hs.Scene) -> float:
    """How far motions are from those at a quarter of the step, over the range of their body."""
    finer = replace(scene, solver=replace(scene.solver, step=scene.solver.step / 4.0))
    ours, theirs = (hs.simulate(each).position.values for each in (scene, finer))
    worst = 0.0
    for part in (slice(0, 3), slice(3, 6)):
        ranges = np.ptp(theirs[..., part], axis=0).max(axis=1)
        differences = np.abs(ours - theirs)[..., part].max(axis=(0, 2))
        worst = max(worst, float((differences / np.maximum(ranges, 1e-6)).max()))
    return worst


@pytest.mark.parametrize(
    ("method", "step"), [(Method.RK2, 0.01), (Method.HEUN, 0.01), (Method.RK4, 0.125)]
)
@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_a_run_is_as_wrong_as_it_says(method, step, damping, figure):
    """Free swings: the error said, against the true one over the range, twice the amplitude; a
    damped one is largest after 1 / |Re lambda|, as 1 / e of what is said. At the step that would
    do nothing is said, and it does."""
    run = hs.simulate(ringing(method, step, damping))
    time = run.time.values
    decay, w = -damping / 2.0, np.sqrt(9.0 - damping**2 / 4.0)
    exact = np.exp(decay * time) * (np.cos(w * time) - decay / w * np.sin(w * time))
    error = np.abs(run.position.values[:, 0, 0] - exact).max() / np.ptp(exact)
    (warning,) = told(run)
    said = float(re.search(r"wrong by (\S+) of their range", warning).group(1))
    figure(f"{method}, damping {damping:g}: said over true error", said / error)
    assert error / 1.5 < said < 4.0 * error
    enough = float(re.search(r"solver.step: (\S+) s", warning).group(1))
    finer = ringing(method, enough, damping)
    assert not told(hs.simulate(finer))
    assert apart(finer) < MAX_MOTION_ERROR


def seen(decay: float, mode: int) -> tuple[float, float]:
    """Amplitude and time [s] of a 5 rad/s vibration that dies out at ``decay`` in this ``mode``."""
    sticking = np.array([[STICK, 0, 0]])
    one = np.ones(1)
    vibration = Vibration("all contacts sticking", sticking, 5.0j, "surge", one, one + 0.0j)
    time = np.arange(0.0, 40.0, 0.05)
    velocity = (np.exp(-decay * time) * np.cos(5.0 * time))[:, None]
    modes = np.full((time.size, 1, 3), [mode, 0, 0])
    amplitude, lasting = vibration.largest_amplitudes(time, velocity, modes)
    return float(amplitude[0]), lasting


def test_what_dies_out_is_as_wrong_as_its_amplitudes_add_up() -> None:
    """int exp(-d t) dt = 1 / d, of a decay that friction or impacts bring about and that is not in
    the eigenvalue; the mean over four periods smooths the start. What slips does not stick."""
    whole, quick = seen(0.0, STICK), seen(0.2, STICK)
    assert whole[0] == pytest.approx(0.5, rel=0.02)
    assert whole[1] == pytest.approx(40.0, rel=0.1)
    assert quick[0] * quick[1] == pytest.approx(0.5 / 0.2, rel=0.1)
    assert seen(0.2, SLIP)[0] == 0.0


def test_slow_forces_on_a_fast_mode_are_no_reason_to_warn() -> None:
    """The same spring pushed at a tenth of its frequency: 0.01 s is then enough for rk2."""
    scene = ringing(Method.RK2, 0.01, 0.0, push=1.0)
    moved = replace(scene.bodies[0], velocity=(0.3 / 8.91, 0, 0, 0, 0, 0))
    settled = replace(scene, bodies=(moved,))
    assert not told(hs.simulate(settled))
    assert apart(settled) < MAX_MOTION_ERROR


def float_over(step: float) -> hs.Scene:
    """A topside of 20 000 t bounces on four legs at 9 rad/s in waves of 3 m, undamped."""
    base, mass = scene_of("free_floating"), 2e7
    waves = hs.WaveTrain(replace(SEA, significant_height=3.0), ramp=50.0)
    barge = with_body(in_waves(base, waves), wave_forces=hs.WaveForces(first_order=True))
    inertia = mass * np.diag([225.0, 225.0, 324.0])
    topside = hs.Body("topside", mass, inertia, centre_of_gravity=(0.0, 0.0, 22.6))
    places = np.array([[x, y, -20.0] for x in (-20, 20) for y in (-20, 20)])
    curve = straight_curve(4e8)
    deck = hs.Plane((0.0, 0.0, 7.5), (0.0, 0.0, 1.0), "barge")
    guide = 0.05 * mass * np.diag([1.0, 1.0, 0.0, 0.0, 0.0, 300.0])
    weight, lift = steady("topside", heave=-9.81 * mass), steady("barge", heave=9.81 * mass)
    legs = hs.Fender("topside", places, deck, curve, hs.Frictionless())
    guides = hs.LinearMooring("topside", guide, damping=guide)
    forces = {**base.forces, "weight": weight, "lift": lift, "legs": legs, "guide": guides}

    bodies = (*barge.bodies, topside)
    solver = hs.Solver(step=step)
    return replace(barge, duration=300.0, bodies=bodies, forces=forces, solver=solver)


@pytest.mark.slow
def test_a_stable_step_that_damps_a_contact_away_is_warned_of(figure) -> None:
    """Far below the limit, 20 % off; nothing at the step asked for. `check` has both limits."""
    run, scene = hs.simulate(float_over(0.1)), float_over(0.1)
    (warning,) = told(run)
    assert "heave of topside at 9.14 rad/s" in warning
    figure("apart at 0.1 s", apart(scene))
    assert apart(scene) > 0.1
    enough = float(re.search(r"solver.step: (\S+) s", warning).group(1))
    assert not told(hs.simulate(float_over(enough)))
    figure("step that is asked for [s]", enough)
    figure("apart there", apart(float_over(enough)))
    assert apart(float_over(enough)) < MAX_MOTION_ERROR
    said = texts(check_document(scene).nodes)
    assert any("the largest stable step is" in line for line in said)
    assert any(line.startswith("Largest accurate step") for line in said)


def test_many_runs_are_warned_too() -> None:
    scene = ringing(Method.RK2, 0.01, 0.0)
    runs = hs.simulate_many([scene, scene])
    assert all("does not resolve surge of block" in str(text) for text in runs.warnings.values)


def test_the_memory_of_a_convolution_damps_what_it_should() -> None:
    """K^(i w) is i w (A(w) - A_inf) + B(w) within 1e-3; so heave dies out by convolution, too."""
    still = in_waves(scene_of("free_floating"))
    convolved, _ = hs.compile_scene(with_body(still, radiation="convolution"))
    model, state = hs.compile_scene(with_body(still, radiation="state_space"))
    linear, w = linearise(model, state), 0.6
    bare = replace(linear, jacobian=linear.jacobian[:12, :12], states=linear.states[:12])
    expected = (linear.dynamic_stiffness(w) - bare.dynamic_stiffness(w)) / (1j * w)
    found = memory_response(convolved, w)
    scale = np.sqrt(np.abs(np.diag(expected)))
    assert np.abs((found - expected) / np.multiply.outer(scale, scale)).max() < 5e-3
    heave = next(m for m in natural_modes(linear) if m.dof == "heave")
    assert heave.damping_ratio > 0.1


def test_the_base_case_is_resolved() -> None:
    case = replace(scene_of("base"), duration=700.0)
    compiled = hs.compile_scene(case)
    assert compiled.method.order == 4
    assert not told(hs.simulate(case))
