"""Linear scenes are propagated exactly: against closed forms, matrix exponentials, stepped runs."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scenes
import xarray as xr
from numpy.testing import assert_allclose
from reading import texts
from scipy import linalg

import hydrosim as hs
from hydrosim.compile.compiled import solution
from hydrosim.dofs import DOFS
from hydrosim.elements import Harmonic, Recorded, Table, constant
from hydrosim.integrate.dynamics import new_work, rhs
from hydrosim.integrate.exponential import (
    NODES_BESIDE,
    area_weights,
    extend_nodes,
    propagation_interval,
)
from hydrosim.linear.propagate import division, linear_equation, stretches
from hydrosim.report.evidence import Feature, Kind
from hydrosim.report.sentences.check import check_document
from hydrosim.scene import (
    Box,
    ConstantRadiation,
    ForceElement,
    Kinematics,
    LinearScenes,
    Method,
    Place,
    SecondOrder,
    Weight,
)

Change = Callable[[hs.Scene], hs.Scene]
PLANAR = ("surge", "heave", "pitch")
ROUNDING = 1e-10  # of what is propagated over some hundred intervals
OSCILLATOR = np.array([[0.0, 1.0], [-4.0, -0.3]])
CHAIN = np.diag(np.ones(3), 1)  # defective: one eigenvalue, zero, and one eigenvector
PUSH = {2: np.array([[0.0], [1.0]]), 4: np.array([[0.0], [0.5], [0.0], [1.0]])}


def dry(
    bodies: hs.Body | tuple[hs.Body, ...],
    forces: Mapping[str, ForceElement],
    duration: float = 20.0,
    **solver: Any,
) -> hs.Scene:
    """A scene without water, recorded every 0.5 s, with small angles unless asked otherwise."""
    settings = hs.Solver(**{"step": 0.1, "kinematics": Kinematics.LINEAR, **solver})
    bodies = (bodies,) if isinstance(bodies, hs.Body) else bodies
    return hs.Scene("dry", duration, bodies, forces=forces, solver=settings, output={"step": 0.5})


def barge(step: float = 0.1, **changes: Any) -> hs.Scene:
    """The H-851 in its plane in its sea, second order too; the ramp ends between records."""
    loads = hs.WaveForces(second_order=SecondOrder.NEWMAN)
    scene = scenes.with_body(scenes.scene_of("free_floating"), dofs=PLANAR, wave_forces=loads)
    scene = scenes.in_waves(scene, hs.WaveTrain(scenes.SEA, ramp=73.33))
    changes = {
        "duration": 200.0,
        "output": {"step": 0.4},
        "solver": hs.Solver(step=step),
        **changes,
    }
    return replace(scene, **changes)


def stepped(scene: hs.Scene, **changes: Any) -> hs.Scene:
    return replace(scene, solver=replace(scene.solver, linear=LinearScenes.STEP, **changes))


def with_force(J: np.ndarray, G: np.ndarray, omega: float) -> np.ndarray:
    """The system with cos(omega t) as a force, and that force and its rate / omega as states."""
    m = len(J)
    turn = omega * np.array([[0.0, 1.0], [-1.0, 0.0]])
    return np.block([[J, G, np.zeros((m, 1))], [np.zeros((2, m)), turn]])


@pytest.mark.parametrize("J", [OSCILLATOR, CHAIN])
def test_response_to_a_harmonic_force(J: np.ndarray) -> None:
    parts, length, omega = 10, 0.5, 1.3
    step, z = length / parts, np.linspace(0.3, -0.2, len(J))
    of = propagation_interval(J, PUSH[len(J)], length, parts)
    f = np.cos(omega * step * (np.arange(parts + 1 + 2 * NODES_BESIDE) - NODES_BESIDE))
    whole = with_force(J, PUSH[len(J)], omega)
    for i in range(parts + 1):
        expected = linalg.expm(whole * i * step) @ [*z, 1.0, 0.0]
        # error of the polynomials: 1.1e-3 (w h)^8 = 3e-13 of the force
        assert_allclose(of.states[i] @ z + of.loads[i] @ f, expected[:-2], rtol=0, atol=1e-12)


@pytest.mark.parametrize("degree", range(8))
@pytest.mark.parametrize("J", [OSCILLATOR, CHAIN])
def test_response_to_a_polynomial_is_exact(J: np.ndarray, degree: int) -> None:
    parts, length = 9, 2.0
    m, G = len(J), PUSH[len(J)]
    of = propagation_interval(J, G, length, parts)
    f = extend_nodes((np.arange(parts + 1) / parts)[:, None] ** degree)
    # (t / T)^d and its lower powers down to 1 are states too: (x^k)' = k / T x^(k - 1)
    whole = np.zeros((m + degree + 1,) * 2)
    whole[:m, :m], whole[:m, m : m + 1] = J, G
    whole[m:, m:] = np.diag(np.arange(degree, 0, -1) / length, 1)
    start = np.zeros(len(whole))
    start[-1] = 1.0
    expected = linalg.expm(whole * length) @ start
    assert_allclose(of.loads[-1] @ f[:, 0], expected[:m], rtol=0, atol=1e-12)


@pytest.mark.parametrize("parts", [5, 8, 10, 13, 24])
def test_area_weights_are_exact_to_the_fifth_degree(parts: int) -> None:
    weights, t = area_weights(parts), np.arange(parts + 1) / parts
    for degree in range(6):
        assert weights @ t**degree / parts == pytest.approx(1.0 / (degree + 1), rel=1e-13)
    assert abs(weights @ t**6 / parts - 1.0 / 7.0) > 1e-9


def test_division_keeps_to_the_nodes_asked_for() -> None:
    assert division(0.5, 0.05) == (1, 10)
    assert division(5.0, 0.05) == (5, 20)
    assert division(0.1, 0.05) == (1, 8)  # as many as the polynomials need
    for length in (0.5, 1.7, 3.0, 18.5, 60.0):
        pieces, parts = division(length, 0.05)
        assert 8 <= parts <= 24
        assert length / (pieces * parts) <= 0.05 * (1.0 + 1e-9)


def test_stretches_end_at_breakpoints() -> None:
    times = np.array([0.0, 0.5, 1.0, 1.5, 2.0, 2.2])
    found = [stops.tolist() for stops in stretches(times, np.array([0.5, 1.2, 2.0 + 1e-12]))]
    assert found == [[0.0, 0.5], [0.5, 1.0], [1.0, 1.2], [1.2, 1.5], [1.5, 2.0], [2.0, 2.2]]


def oscillator(**forces: ForceElement) -> hs.Scene:
    """2 kg on 8 N/m with 0.6 N s/m along x, at 1 m at the start: z' = OSCILLATOR z + f / 2."""
    one = np.diag([1.0, 0, 0, 0, 0, 0])
    spring = hs.LinearMooring("block", 8.0 * one, 0.6 * one)
    body = scenes.block(2.0, ["surge"], position=scenes.moving(surge=1.0))
    return dry(body, {"spring": spring, **forces})


def surge_of(run: xr.Dataset) -> np.ndarray:
    """Surge and its rate (nt, 2)."""
    return np.stack([run.position.values[:, 0, 0], run.velocity.values[:, 0, 0]], axis=1)


def test_free_decay_is_the_exponential(validated) -> None:
    run = hs.simulate(oscillator())
    expected = [linalg.expm(OSCILLATOR * t) @ [1.0, 0.0] for t in run.time.values]
    error = np.abs(surge_of(run) - expected).max()
    claim, against = "free decay that is propagated, of its start", "matrix exponential"
    validated(Kind.CLOSED_FORM, claim, against, error, 1e-13, Feature.EXACT)
    assert run.attrs["solver_linear"] == "propagated exactly: linear"
    assert run.attrs["solver_steps"] == 0
    # losses are integrated over nodes 0.05 s apart, with 2 w h = 0.2: (w h)^6 191/60480 = 2e-7
    assert run.attrs["energy_residual_relative"] < 1e-7


def test_harmonic_force() -> None:
    push = scenes.central_force(surge=Harmonic(2.0, 5.0, 0.0, np.pi / 2))
    run = hs.simulate(oscillator(push=push))
    whole = with_force(OSCILLATOR, PUSH[2], 2 * np.pi / 5.0)
    expected = [linalg.expm(whole * t)[:2] @ [1.0, 0.0, 1.0, 0.0] for t in run.time.values]
    assert_allclose(surge_of(run), expected, rtol=0, atol=ROUNDING)


def test_corners_of_a_table_between_records() -> None:
    corners, force = np.array([1.0, 3.37, 3.41, 9.5]), np.array([0.0, 4.0, -2.0, 1.0])
    push = scenes.central_force(surge=Table(corners, force))
    scene = oscillator(push=push)
    run = hs.simulate(replace(scene, duration=12.3))  # the last record is not on the grid either
    ends, slopes = [0.0, *corners, 99.0], [0.0, *np.diff(force) / np.diff(corners), 0.0]
    whole = np.zeros((4, 4))  # of z, f and its slope
    whole[:2, :2], whole[1, 2], whole[2, 3] = OSCILLATOR, 0.5, 1.0
    for t, found in zip(run.time.values, surge_of(run), strict=True):
        z = np.array([1.0, 0.0, 0.0, 0.0])
        for start, end, slope in zip(ends, ends[1:], slopes, strict=False):
            z[3] = slope
            z = linalg.expm(whole * max(min(t, end) - start, 0.0)) @ z
        assert_allclose(found, z[:2], rtol=0, atol=ROUNDING)


def test_a_free_body_drifts() -> None:
    body = scenes.block(5.0, velocity=scenes.moving(sway=0.3, yaw=0.01))
    run = hs.simulate(dry(body, {"push": scenes.steady(surge=10.0, heave=-2.0)}))
    t, expected = run.time.values, np.zeros((run.time.size, 6))
    expected[:, 0], expected[:, 2] = t**2, -0.2 * t**2
    expected[:, 1], expected[:, 5] = 0.3 * t, 0.01 * t
    assert_allclose(run.position.values[:, 0], expected, rtol=0, atol=1e-11)
    assert run.attrs["energy_residual_relative"] < 1e-13


def test_a_current_gives_what_a_damper_takes() -> None:
    """v = U (1 - exp(-c t / m)), and the energy m v^2 / 2 comes from the damper."""
    drag = hs.LinearDamping("block", 0.5 * np.eye(6), relative_to_current=True)
    adrift = replace(dry(scenes.block(1.0), {"drag": drag}), environment=CURRENT)
    run = hs.simulate(adrift)
    assert run.attrs["solver_linear"].startswith("propagated exactly")
    along = CURRENT.current.speed * (1.0 - np.exp(-0.5 * run.time.values))
    assert np.hypot(*run.velocity.values[:, 0, :2].T) == pytest.approx(along, abs=1e-9)
    assert run.energy_dissipated_drag.values == pytest.approx(-0.5 * along**2, abs=1e-9)


@pytest.mark.kernels
def test_steps_come_near_with_their_order(figure) -> None:
    exact, steps = hs.simulate(barge()), (0.2, 0.1, 0.05)
    assert exact.attrs["solver_linear"] == "propagated exactly: linear"
    size = np.ptp(scenes.motion(exact), axis=0)[[0, 2, 4]]
    misses = []
    for step in steps:
        run = hs.simulate(stepped(barge(step)))
        assert run.attrs["solver_steps"] > 0
        misses.append(
            np.abs(scenes.motion(run) - scenes.motion(exact))[:, [0, 2, 4]].max(axis=0) / size
        )
    for dof, miss in zip(PLANAR, np.array(misses).T, strict=True):
        figure(f"{dof}, rk4 at {steps[-1]} s", miss[-1])
        assert_allclose(scenes.observed_orders(steps, miss), 4.0, atol=0.1)
    assert misses[-1].max() < 1e-7
    assert (misses[-1] / 16**2).max() < 1e-9  # what is left at a quarter of the step


def test_all_is_recorded_as_in_a_stepped_run() -> None:
    exact, run = hs.simulate(barge()), hs.simulate(stepped(barge(0.05)))
    assert [*exact, "position_error"] == list(run)
    for name, values in run.drop_vars("position_error").items():
        # rk4 is within 1e-7; |wave power| has corners, between which neither sees them
        tolerance = 1e-4 if name == "energy_wave_absolute" else 5e-7
        if name not in ("energy_residual", "state_value"):
            size = np.abs(values.values).max() + 1e-300
            miss = np.abs(exact[name].values - values.values).max()
            assert miss <= tolerance * size, name
    assert exact.attrs["energy_residual_relative"] < 1e-9 < run.attrs["energy_residual_relative"]


def test_the_step_hardly_matters() -> None:
    fine, coarse = hs.simulate(barge(0.05)), hs.simulate(barge(0.4))
    assert_allclose(
        scenes.motion(coarse), scenes.motion(fine), rtol=0, atol=1e-8 * np.ptp(scenes.motion(fine))
    )


def test_regular_waves_on_all_motions_in_linear_kinematics() -> None:
    waves = hs.WaveTrain(hs.RegularWave(0.7, 9.0), heading=0.6, ramp=11.1)
    scene = scenes.in_waves(
        scenes.with_body(scenes.scene_of("free_floating"), wave_forces=hs.WaveForces()), waves
    )
    roll = hs.LinearDamping("barge", np.diag([0, 0, 0, 3e9, 0, 0]))
    linear = hs.Solver(step=0.05, kinematics=Kinematics.LINEAR)
    scene = replace(scene, duration=60.0, forces={**scene.forces, "bilges": roll}, solver=linear)
    exact, run = hs.simulate(scene), hs.simulate(stepped(scene))
    assert exact.attrs["solver_steps"] == 0 < run.attrs["solver_steps"]
    miss = np.abs(scenes.motion(exact) - scenes.motion(run)).max(axis=0)
    assert (miss < 2e-7 * np.ptp(scenes.motion(run), axis=0)).all()  # of rk4 at 0.05 s


def same(scene: hs.Scene) -> hs.Scene:
    return scene


@pytest.mark.parametrize("first", [same, stepped])
@pytest.mark.parametrize("then", [same, stepped])
def test_restarts_from_and_into_stepped_runs(first: Change, then: Change) -> None:
    half = replace(barge(), duration=100.0)
    start = hs.Start(hs.simulate(first(half)))
    whole, run = hs.simulate(barge()), hs.simulate(then(replace(half, initial=start)))
    after = whole.sel(time=slice(100.0 - 1e-9, None))
    exact = first is then is same
    size = np.ptp(scenes.motion(whole))
    assert_allclose(run.time, after.time, rtol=0, atol=0)
    assert_allclose(  # rk4 at 0.1 s is within 1e-6
        scenes.motion(run), scenes.motion(after), rtol=0, atol=size * (1e-11 if exact else 1e-6)
    )
    work = "energy_work_wave_first_order"
    size = np.ptp(whole[work].values)
    assert_allclose(run[work], after[work], rtol=0, atol=size * (1e-9 if exact else 3e-6))


def test_what_capsizes_fails() -> None:
    lever = scenes.mooring(pitch=-40.0)
    body = scenes.block(1.0, ["pitch"], position=scenes.moving(pitch=0.01))
    scene = dry(body, {"lever": lever}, kinematics=Kinematics.EXACT)
    assert hs.compile_scene(scene).derived.exact
    with pytest.raises(hs.SimulationError, match="the pitch of body block is beyond 85 deg") as at:
        hs.simulate(scene)
    pitch = at.value.dataset.position.values[:, 0, 4]
    # I q'' = 40 q with I = 4
    assert_allclose(pitch, 0.01 * np.cosh(np.sqrt(10.0) * at.value.dataset.time), rtol=1e-9)


RECORD = Recorded(np.linspace(0.0, 20.0, 41), np.sin(np.linspace(0.0, 20.0, 41)))
SIX = np.diag([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
CURRENT = hs.Environment(current=hs.Stream(1.0, 0.3))
PUSHED = hs.AppliedForce("block", (0.0, 0.0, 1.0), {"surge": constant(1.0)})
EXACT = {"kinematics": Kinematics.EXACT}
ON_ONE_AXIS = ("surge", "sway", "heave", "yaw")
BLOCK, HELD = scenes.block(1.0), hs.LinearMooring("block", SIX, SIX)
LINE = ("block", (0, 0, 1.0), (0, 0, 9.0), 1.0, 5.0)
DRAG, THRUST = hs.LinearDamping("block", SIX), replace(PUSHED, frame="body")
TANK = hs.Tank("tank", Box((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)), 1.0, 1000.0)
PUMPED = {"tanks": (TANK,), "pumps": (hs.Pump("out", 1.0, "tank", None),)}
FOLLOWING = hs.WaveForces(position=Place.INSTANTANEOUS)
MEAN = hs.WaveForces(headings=Place.MEAN)
RECORDED = {"push": scenes.central_force(surge=RECORD)}
FILLED = scenes.block(5e4, ["heave"], weight=Weight.CARRIED, **PUMPED)

NONLINEAR = {
    "floor": dry(BLOCK, {"floor": scenes.on_floor(1e3, hs.Frictionless())}),
    "line": dry(BLOCK, {"line": hs.Spring(*LINE)}),
    "drag": dry(BLOCK, {"drag": hs.QuadraticDamping("block", SIX)}),
    r"forces\.push\.force\.surge is a record": dry(BLOCK, RECORDED),
    "exact rotations of block": dry(BLOCK, {}, **EXACT),
    "push turns with block": dry(scenes.block(1.0, ["yaw"]), {"push": PUSHED}, **EXACT),
    "thrust turns with block": dry(scenes.block(1.0, ["yaw"]), {"thrust": THRUST}),
    "drag turns with block": dry(scenes.block(1.0, ON_ONE_AXIS), {"drag": DRAG}, **EXACT),
    "radiation by convolution": scenes.with_body(barge(), radiation="convolution"),
    "waves follow barge": scenes.with_body(barge(), wave_forces=FOLLOWING),
    "the contents of the tanks of block change": dry(FILLED, {"mooring": HELD}),
    "exact rotations of barge": scenes.with_body(barge(), dofs=DOFS, wave_forces=MEAN),
}
LINEAR = {
    "free": dry(BLOCK, {"drag": replace(DRAG, relative_to_current=True)}),
    "off centre": dry(BLOCK, {"push": PUSHED, "mooring": HELD}),
    "one axis": dry(
        scenes.block(1.0, ON_ONE_AXIS, position=scenes.moving(sway=1.0)),
        {
            "mooring": HELD,
            "drag": hs.LinearDamping("block", np.diag([2.0, 2.0, 1.0, 3.0, 3.0, 7.0])),
            "push": scenes.steady(surge=1.0, yaw=2.0),
        },
        **EXACT,
    ),
    "no rotation": dry(
        scenes.block(1.0, DOFS[:3], position=scenes.moving(roll=0.3, yaw=0.2)),
        {"drag": DRAG, "thrust": THRUST},
        **EXACT,
    ),
    "barge": barge(),
    "one frequency": scenes.with_body(barge(), radiation=ConstantRadiation(8.0)),
}


@pytest.mark.parametrize("reason", NONLINEAR)
def test_the_rest_is_stepped(reason: str) -> None:
    scene = NONLINEAR[reason]
    derived = hs.compile_scene(scene).derived
    assert not derived.exact
    said = solution(scene, derived).removeprefix("stepped, not linear: ")
    assert said in reason.replace("\\", "")


@pytest.mark.parametrize("name", LINEAR)
def test_what_is_propagated_is_linear(name: str) -> None:
    still = LINEAR[name]
    scene = replace(still, environment=replace(still.environment, current=CURRENT.current))
    model, state = compiled = hs.compile_scene(scene)
    assert compiled.derived.exact
    work, m, rng = new_work(model), model.energy, np.random.default_rng(5)
    a, b = rng.uniform(-1.2, 1.2, (2, model.size))  # m, rad and so on: far from small

    def slope(y: np.ndarray) -> np.ndarray:
        dy = np.zeros(model.size)
        rhs(7.0, y, state.modes, state.history, model, work, dy)
        return dy[:m]

    left, right = slope(a + b) + slope(0.0 * a), slope(a) + slope(b)
    assert_allclose(left, right, rtol=0, atol=1e-12 * np.abs(slope(a)).max())


def test_it_is_said_and_stepped_if_asked() -> None:
    scene = oscillator()
    derived = hs.compile_scene(stepped(scene)).derived
    assert not derived.exact
    assert solution(stepped(scene), derived) == "stepped, as solver.linear asks"
    told = {"Propagated exactly: linear": scene, "200 steps of 0.1 s": stepped(scene)}
    for text, one in told.items():
        said = "\n".join(texts(check_document(one).nodes))
        assert text in said
        assert ("stable" in said) == (one is not scene)  # a step that is not taken has no limit


def test_steps_above_the_stable_limit_do_not_matter() -> None:
    stiff = hs.LinearMooring("block", 1e4 * np.eye(6))
    body = scenes.block(1.0, ["surge"], position=scenes.moving(surge=1.0))
    run = hs.simulate(dry(body, {"stiff": stiff}, step=0.1, method=Method.RK4))
    assert_allclose(run.position.values[:, 0, 0], np.cos(100.0 * run.time), rtol=0, atol=1e-10)
    assert "step" not in run.attrs.get("warnings", "")


def test_independent_bodies_cost_their_number() -> None:
    """Forty oscillators beside each other: matrices of each alone, motions and energies of each."""
    count = 40
    stiffness = np.linspace(1e3, 4e4, count)
    start = scenes.moving(heave=0.1)
    bodies = tuple(scenes.block(1e3, ["heave"], f"b{k}", position=start) for k in range(count))
    upward = np.diag([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    springs = {f"s{k}": hs.LinearMooring(f"b{k}", of * upward) for k, of in enumerate(stiffness)}
    scene = dry(bodies, springs, duration=10.0)
    response = linear_equation(*hs.compile_scene(scene)).response(0.5, 10)
    assert [part.states.size for part in response.parts] == [2] * count
    run = hs.simulate(scene)
    t = run.time.values
    exact = 0.1 * np.cos(np.sqrt(stiffness / 1e3) * t[:, None])
    assert_allclose(run.position.sel(dof="heave"), exact, atol=1e-12)
    assert float(abs(run.energy_residual).max()) < 1e-8 * 0.5 * 0.01 * stiffness.sum()
