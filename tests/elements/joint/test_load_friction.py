"""Dry friction that grows with the load of a joint against closed forms and equations of its own:
rails on slopes, guides that jam, pins of pendulums, a chain in maximal coordinates."""

from __future__ import annotations

from dataclasses import replace
from math import cos, sin, tan
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from jointed import (
    G,
    by_rk4,
    carried,
    completed,
    joint,
    moved,
    places,
    scene,
)
from markers import few
from scenes import Acting, JointFriction, turned_scene, with_motions
from scipy.integrate import solve_ivp
from turning import points, swapped, turned_back

import hydrosim as hs
from hydrosim.analysis.seakeeping import LinearRequest, linear_analysis
from hydrosim.compile.compile import compile_scene
from hydrosim.elements import AppliedForce, Table
from hydrosim.errors import InputError, SimulationError
from hydrosim.report.sentences.analysis import linear_document
from hydrosim.scene import Method, Scene, Start
from tests.generators.articulated_cases import articulated_case
from tests.generators.random_cases import Case
from tests.generators.scene_trials import offences, tried

STUCK, UP, DOWN = 1, 2, 3
MASS = 1000.0
INERTIA = (300.0, 400.0, 500.0)


def grips(kinetic: float, static: float | None = None, **bearing: float) -> JointFriction:
    """Friction by load alone."""
    return JointFriction(0.0, 0.0, static or kinetic, kinetic, **bearing)


def pushed(surge: float, pitch: float) -> AppliedForce:
    """A steady force at the centre of gravity, and a moment."""
    time = np.array([0.0, 100.0])
    sides = {"surge": surge, "pitch": pitch}
    return AppliedForce(
        "body", (0.0, 0.0, 0.0), {k: Table(time, np.full(2, v)) for k, v in sides.items()}
    )


def on_rail(slope: float, friction: JointFriction, speed: float = 0.0, lever: float = 0.0) -> Scene:
    """A body on a rail down a ``slope`` [rad], its centre of gravity a ``lever`` above the rail."""
    down = np.array([cos(slope), 0.0, -sin(slope)])
    across = np.array([sin(slope), 0.0, cos(slope)])
    body = carried("body", MASS, INERTIA, (0.0, 0.0, 0.0))
    place = {"point": tuple(-lever * across), "axis": tuple(down)}
    rail = joint("slider", "body", None, moved(0.0, speed, friction=friction), **place)
    return by_rk4(scene([body], {"rail": rail}, 2.0), 0.05)


def mode(run: xr.Dataset) -> np.ndarray:
    return np.asarray(run.joint_motion_mode.values[:, 0])


def position(run: xr.Dataset) -> np.ndarray:
    return np.asarray(run.joint_position.values[:, 0])


def loss(run: xr.Dataset) -> float:
    return float(sum(run[v][-1] for v in run.data_vars if str(v).startswith("energy_dissipated_")))


def test_a_body_slides_down_a_rail() -> None:
    slope, mu = 0.5, 0.3
    run = completed(on_rail(slope, grips(mu)))
    rate = G * (sin(slope) - mu * cos(slope))
    np.testing.assert_allclose(position(run), 0.5 * rate * run.time.values**2, atol=1e-12)
    load = MASS * G * cos(slope)
    np.testing.assert_allclose(run.joint_friction_load.values[:, 0], load, rtol=1e-12)
    np.testing.assert_allclose(run.joint_friction.values[:, 0], -mu * load, rtol=1e-12)
    np.testing.assert_allclose(run.joint_motion_force.values[:, 0], -mu * load, rtol=1e-12)
    assert loss(run) == pytest.approx(mu * load * position(run)[-1], rel=1e-9)
    assert np.abs(run.energy_residual).max() < 1e-9 * loss(run)


@pytest.mark.parametrize("beside", [1e-9, -1e-9])
def test_a_body_holds_on_a_rail_up_to_the_angle_of_friction(beside: float) -> None:
    slope = 0.5
    run = completed(on_rail(slope, grips(0.1, tan(slope) * (1.0 + beside))))
    assert (mode(run) == (STUCK if beside > 0.0 else UP)).all()
    load = MASS * G * cos(slope)
    if beside > 0.0:
        assert (position(run) == 0.0).all()
        np.testing.assert_allclose(run.joint_friction_load.values[:, 0], load, rtol=1e-12)
        np.testing.assert_allclose(run.joint_friction.values[:, 0], -tan(slope) * load, rtol=1e-12)


def test_a_body_that_goes_up_a_rail_comes_to_rest_and_slides_back() -> None:
    """The given force and that of the load add up."""
    slope, mu, speed = 0.6, 0.2, -2.0
    given = JointFriction(400.0, 300.0, mu, mu)
    run = completed(on_rail(slope, given, speed))
    held = 300.0 / MASS + mu * G * cos(slope)
    up, back = G * sin(slope) + held, G * sin(slope) - held
    rest = -speed / up
    t = run.time.values
    highest = 0.5 * speed * rest
    expected = np.where(
        t < rest, speed * t + 0.5 * up * t**2, highest + 0.5 * back * (t - rest) ** 2
    )
    np.testing.assert_allclose(position(run), expected, atol=1e-9)
    assert {DOWN, UP} == set(mode(run).tolist())


@pytest.mark.parametrize("lever", [0.0, 0.3, -0.3])
def test_shoes_share_the_load(lever: float) -> None:
    """The centre of gravity beside the rail loads the shoes when the body speeds up: W = |N/2 + M /
    L| + |N/2 - M / L| with M = lever (m a - m g sin)."""
    slope, mu, length = 0.5, 0.2, 1.2
    run = completed(on_rail(slope, grips(mu, bearing_distance=length), 0.0, lever))
    across, along = MASS * G * cos(slope), MASS * G * sin(slope)
    friction = 0.0
    for _ in range(200):
        moment = lever * friction
        both = abs(across / 2 + moment / length) + abs(across / 2 - moment / length)
        friction = mu * both
    rate = (along - friction) / MASS
    np.testing.assert_allclose(position(run), 0.5 * rate * run.time.values**2, atol=1e-12)


@pytest.mark.parametrize("push", [10.0, 1e5])
@pytest.mark.parametrize("beside", [1e-9, -1e-9])
def test_an_eccentric_push_jams_a_guide(push: float, beside: float) -> None:
    """W = 2 P e / L, whatever the push is (Beer & Johnston, the movable bracket)."""
    mu, length = 0.25, 1.5
    lever = length / (2.0 * mu) * (1.0 + beside)
    calm = on_rail(0.0, grips(mu, bearing_distance=length))
    pushes = {"push": pushed(push, push * lever)}
    water = replace(calm.environment, gravity=1e-300)
    run = completed(replace(calm, forces=pushes, environment=water))
    assert (mode(run) == (STUCK if beside > 0.0 else UP)).all()
    load = run.joint_friction_load.values[-1, 0]
    assert load == pytest.approx(2.0 * push * lever / length, rel=1e-12)


def test_friction_that_makes_its_own_load_has_no_solution() -> None:
    """The centre of gravity is far beside the rail: 2 mu e / L is 1.25."""
    heavy = on_rail(0.0, grips(0.25, bearing_distance=1.0), 1.0, 2.5)
    with pytest.raises(SimulationError) as caught:
        hs.simulate(heavy)
    said = str(caught.value)
    assert "rail offset" in said
    assert "Painleve" in said
    assert "kinetic_coefficient of 0.25" in said
    assert "guide_length" in said


def test_a_body_may_stay_stuck_where_it_could_not_slide() -> None:
    run = completed(on_rail(0.3, grips(0.5, bearing_distance=1.0), 0.0, 2.5))
    assert (mode(run) == STUCK).all()


# A pendulum on a pin.

LEVER, RADIUS, ABOUT_CENTRE = 2.0, 0.25, 900.0
MU, ANGLE = 0.5, 1.2


def pendulum(static: float, step: float, duration: float, rate: float = 0.0) -> Scene:
    """A pendulum on a pin with the axis y."""
    body = carried("body", MASS, (700.0, ABOUT_CENTRE, 500.0), (0.0, 0.0, -LEVER))
    friction = grips(MU, static, radius=RADIUS)
    pin = joint(
        "hinge",
        "body",
        None,
        moved(ANGLE, rate, friction=friction),
        point=(0.0, 0.0, LEVER),
        axis=(0.0, 1.0, 0.0),
    )
    return by_rk4(scene([body], {"pin": pin}, duration), step)


def pin_acceleration(angle: float, rate: float, sense: float) -> float:
    """The root of a quadratic: the reaction of the pin holds the acceleration."""
    about_pin = ABOUT_CENTRE + MASS * LEVER**2
    radial = LEVER * rate**2 + G * cos(angle)
    c = sense * MU * RADIUS * MASS
    # (I a + m g l sin)^2 = c^2 (radial^2 + (l a + g sin)^2)
    free = MASS * G * LEVER * sin(angle)
    across = G * sin(angle)
    A = about_pin**2 - c**2 * LEVER**2
    B = 2.0 * (about_pin * free - c**2 * LEVER * across)
    C = free**2 - c**2 * (radial**2 + across**2)
    roots = (-B + np.array([1.0, -1.0]) * np.sqrt(B**2 - 4.0 * A * C)) / (2.0 * A)
    return float(roots[0] if sense < 0.0 else roots[1])


def swings(static: float, t: np.ndarray) -> np.ndarray:
    """Angles of the pendulum by DOP853, swing by swing, until the pin holds it."""
    angles = np.full(t.size, np.nan)
    begin, here = 0.0, ANGLE
    while True:
        if LEVER * abs(sin(here)) <= static * RADIUS:
            angles[t >= begin] = here
            return angles
        sense = -np.sign(here)

        def slope(_: float, y: np.ndarray, sense: float = sense) -> list[float]:
            return [y[1], pin_acceleration(y[0], y[1], sense)]

        def rests(_: float, y: np.ndarray, sense: float = sense) -> float:
            return float(sense * y[1] + (1e-9 if y[0] * sense < 0.0 else 0.0))

        rests.terminal, rests.direction = True, -1.0  # type: ignore[attr-defined]
        swing = solve_ivp(
            slope,
            (begin, t[-1] + 20.0),
            [here, 0.0],
            method="DOP853",
            rtol=1e-13,
            atol=1e-13,
            events=rests,
            dense_output=True,
        )
        end = float(swing.t_events[0][0])
        inside = (t >= begin) & (t <= end)
        angles[inside] = swing.sol(t[inside])[0]
        begin, here = end, float(swing.y_events[0][0][0])
        if begin > t[-1]:
            return angles


@pytest.mark.parametrize("static", [0.5, 1.5])
def test_a_pendulum_on_a_pin(static: float) -> None:
    """It swings out, and rests where its weight cannot turn the pin."""
    base = pendulum(static, 0.01, 25.0)
    run = completed(replace(base, solver=replace(base.solver, method=Method.DOPRI5)))
    expected = swings(static, run.time.values)
    assert np.abs(position(run) - expected).max() < 1e-9 * ANGLE
    assert np.abs(run.energy_residual).max() < 1e-9 * loss(run)
    assert mode(run)[-1] == STUCK


def test_the_order_of_rk4_holds_with_a_pin() -> None:
    base = pendulum(1.5, 0.05, 8.0)
    angle = swings(1.5, completed(base).time.values)
    errors = [
        np.abs(position(completed(by_rk4(base, step))) - angle).max()
        for step in (0.05, 0.025, 0.0125)
    ]
    assert errors[-1] < 1e-6
    assert np.log2(errors[0] / errors[1]) > 3.8
    assert np.log2(errors[1] / errors[2]) > 3.8


def test_a_collar_carries_the_force_along_a_pin() -> None:
    """A vertical pin: the weight lies on its collar, the centrifugal force on its bush."""
    collar, radius, mu, rate, lever = 0.4, 0.1, 0.2, 1.5, 0.7
    body = carried("body", MASS, INERTIA, (lever, 0.0, 0.0))
    friction = grips(mu, radius=radius, collar_radius=collar)
    place = {"point": (-lever, 0.0, 0.0), "axis": (0.0, 0.0, 1.0)}
    pin = joint("hinge", "body", None, moved(0.0, rate, friction=friction), **place)
    run = completed(by_rk4(scene([body], {"pin": pin}, 0.5), 0.01))
    u = run.joint_velocity.values[:, 0]
    about_pin = INERTIA[2] + MASS * lever**2
    found = -run.joint_friction.values[:, 0]
    across = MASS * lever * np.hypot(u**2, found / about_pin)
    np.testing.assert_allclose(found, mu * (radius * across + collar * MASS * G), rtol=1e-12)


# Two such joints in a chain, against maximal coordinates.

CART, BOB, ROD = 800.0, 300.0, 1.7
MU_RAIL, MU_PIN, PIN_RADIUS, GUIDE, SLOPE, ABOVE = 0.12, 0.35, 0.2, 0.9, 0.35, 0.25


def chain(duration: float) -> Scene:
    """A cart on a sloping rail, with a pendulum on a pin above the rail."""
    down = (cos(SLOPE), 0.0, -sin(SLOPE))
    across = np.array([sin(SLOPE), 0.0, cos(SLOPE)])
    cart = carried("cart", CART, INERTIA, (0.0, 0.0, 0.0))
    at = ABOVE * across
    bob = carried("bob", BOB, (80.0, 90.0, 70.0), (at[0], 0.0, at[2] - ROD))
    rail = moved(0.0, 1.0, friction=grips(MU_RAIL, bearing_distance=GUIDE))
    pin = moved(1.1, -2.0, friction=grips(MU_PIN, radius=PIN_RADIUS))
    joints = {
        "rail": joint("slider", "cart", None, rail, axis=down),
        "pin": joint("hinge", "bob", "cart", pin, point=(0.0, 0.0, ROD), axis=(0.0, 1.0, 0.0)),
    }
    return scene([cart, bob], joints, duration, output_step=0.02)


def chain_rates(_: float, state: np.ndarray) -> np.ndarray:
    """Rates of (x, z, x', z' of the cart, then x, z, angle of the bob and their rates). The forces
    of rail and pin are unknowns, and friction is found by repetition."""
    u, w = state[2:4]
    angle, ub, wb, rate = state[6:]
    d = np.array([cos(SLOPE), -sin(SLOPE)])
    n = np.array([sin(SLOPE), cos(SLOPE)])
    arm = np.array([ROD * sin(angle), ROD * cos(angle)])  # from the bob to the pin
    turn = np.array([arm[1], -arm[0]])  # velocity of the pin on the bob, over its rate about y
    # unknowns: a (2), b (2), alpha, normal N, moment M of the rail, force P (2) on the bob
    A = np.zeros((9, 9))
    c = np.zeros(9)
    A[0:2, 0:2] = CART * np.eye(2)
    A[0:2, 5] = -n
    A[0:2, 7:9] = np.eye(2)
    c[1] = -CART * G
    A[2:4, 2:4] = BOB * np.eye(2)
    A[2:4, 7:9] = -np.eye(2)
    c[3] = -BOB * G
    A[4, 4] = 90.0
    A[4, 7], A[4, 8] = -arm[1], arm[0]
    A[5, 0:2] = n
    A[6, 6] = 1.0  # moments on the cart about y: M + (pin x -P) + friction of the pin = 0
    at = ABOVE * n
    A[6, 7], A[6, 8] = -at[1], at[0]
    A[7:9, 0:2] = np.eye(2)
    A[7:9, 2:4] = -np.eye(2)
    A[7:9, 4] = -turn
    c[7:9] = -(rate**2) * arm  # the centripetal part of the pin on the bob
    friction = np.zeros(2)
    along = np.sign(u * d[0] + w * d[1])
    sense = np.sign(rate)
    for _ in range(400):
        right = c.copy()
        right[0:2] -= along * friction[0] * d
        right[4] -= sense * friction[1]
        right[6] -= sense * friction[1]
        solution = np.linalg.solve(A, right)
        N, M, P = solution[5], solution[6], solution[7:9]
        shoes = abs(N / 2 + M / GUIDE) + abs(N / 2 - M / GUIDE)
        new = np.array([MU_RAIL * shoes, MU_PIN * PIN_RADIUS * np.hypot(*P)])
        if np.array_equal(new, friction):
            break
        friction = new
    a, b, alpha = solution[0:2], solution[2:4], solution[4]
    return np.array([u, w, *a, ub, wb, rate, *b, alpha])


def test_two_joints_of_a_chain_feel_the_friction_of_each_other() -> None:
    run = completed(chain(0.6))
    moving = run.joint_motion_mode.values
    assert set(moving[:, 0]) == {UP}
    assert set(moving[:, 1]) == {DOWN}
    d = np.array([cos(SLOPE), -sin(SLOPE)])
    pin = ABOVE * np.array([sin(SLOPE), cos(SLOPE)])
    arm = ROD * np.array([sin(1.1), cos(1.1)])
    bob = pin - arm
    turn = np.array([-arm[1], arm[0]]) * -2.0
    start = [0.0, 0.0, *d, *bob, 1.1, *(d + turn), -2.0]
    t = run.time.values
    found = solve_ivp(
        chain_rates, (0.0, t[-1]), start, method="DOP853", rtol=1e-12, atol=1e-12, t_eval=t
    )
    ours = np.column_stack([places(run, "cart")[:, [0, 2]], places(run, "bob")[:, [0, 2]]])
    assert np.abs(ours - found.y[[0, 1, 4, 5]].T).max() < 1e-9
    assert np.abs(run.energy_residual).max() < 1e-9 * loss(run)


# What must not matter, and what the record says.


def crane(duration: float = 2.0) -> Scene:
    """A trolley on a sloping rail, a boom on a pin of two bearings, a load on a universal joint,
    all with friction by load; a spring in the pin."""
    bodies = [
        carried("trolley", 900.0, INERTIA, (0.0, 0.3, 0.0)),
        carried("boom", 400.0, (90.0, 150.0, 120.0), (1.0, 0.5, 0.8)),
        carried("load", 250.0, (20.0, 30.0, 25.0), (2.1, 0.4, -0.7)),
    ]
    rail = grips(0.15, 0.2, bearing_distance=2.0)
    pin = grips(0.2, 0.25, radius=0.12, collar_radius=0.2, bearing_distance=0.8)
    cross = grips(0.3, 0.4, radius=0.05)
    turn = moved(
        0.0, 0.8, stiffness=6e3, neutral=0.3, friction=pin._replace(static=30.0, kinetic=20.0)
    )
    joints = {
        "rail": joint(
            "slider",
            "trolley",
            None,
            moved(0.1, 0.6, friction=rail),
            point=(0.0, -0.2, 0.3),
            axis=(1.0, 0.2, -0.4),
        ),
        "pin": joint(
            "hinge", "boom", "trolley", turn, point=(-0.9, -0.2, -0.5), axis=(0.3, 1.0, 0.2)
        ),
        "cross": joint(
            "universal",
            "load",
            "boom",
            moved(0.3, -1.0, friction=cross),
            moved(-0.2, 0.7, friction=cross),
            point=(0.0, 0.0, 1.6),
            axis=(1.0, 0.0, 0.0),
            second_axis=(0.0, 1.0, 0.0),
        ),
    }
    return by_rk4(scene(bodies, joints, duration, output_step=0.05), 0.005)


def test_a_turned_crane_does_the_same() -> None:
    base = crane()
    run = completed(base)
    for by in (0.7, -2.5):
        other = completed(turned_scene(base, by, (4.0, -9.0)))
        found = turned_back(points(other, base), by, (4.0, -9.0))
        assert np.abs(found - points(run, base)).max() < 1e-9
        np.testing.assert_allclose(other.joint_friction, run.joint_friction, rtol=1e-7, atol=1e-4)
    assert len(np.unique(run.joint_motion_mode)) > 1
    assert np.abs(run.energy_residual).max() < 1e-7 * loss(run)


@pytest.mark.parametrize("name", ["pin", "cross"])
def test_a_joint_told_from_its_other_side_has_the_same_friction(name: str) -> None:
    base = crane()
    run, other = completed(base), completed(swapped(base, name))
    assert np.abs(points(other, base) - points(run, base)).max() < 1e-8


def test_the_bearings_of_a_slide_are_on_its_body() -> None:
    """Told from the other side the shoes are on the other body: the load of the shoes changes as
    the moment at their middle does."""
    trolley = carried("trolley", 900.0, INERTIA, (0.0, 0.0, 0.0))
    cart = carried("cart", 300.0, INERTIA, (0.0, 0.0, 0.4))
    base = joint("hinge", "trolley", None, point=(0.0, 0.0, 0.0), axis=(0.0, 1.0, 0.0))
    base = with_motions(base, Acting(stiffness=5e5, damping=2e4))
    friction = grips(0.1, bearing_distance=0.5)
    shoes_on_cart = joint(
        "slider", "cart", "trolley", moved(0.2, 0.5, friction=friction), axis=(1.0, 0.0, 0.0)
    )
    shoes_on_trolley = joint(
        "slider",
        "trolley",
        "cart",
        moved(-0.2, -0.5, friction=friction),
        point=(0.0, 0.0, 0.4),
        axis=(1.0, 0.0, 0.0),
    )
    for rail in (shoes_on_cart, shoes_on_trolley):
        made = scene([trolley, cart], {"base": base, "rail": rail}, 0.4, output_step=0.02)
        run = completed(by_rk4(made, 0.002))
        wrench = run.joint_force.sel(joint="rail").values
        angle = run.joint_position.sel(joint_motion="base angle").values
        offset = run.joint_position.sel(joint_motion="rail offset").values
        across = wrench[:, 0] * np.sin(angle) + wrench[:, 2] * np.cos(angle)
        # about the place that moves with the cart, the recorded one, and about the shoes
        moment = wrench[:, 4]
        if rail is shoes_on_trolley:
            moment = moment + offset * across * 1.0
        shoes = abs(across / 2 + moment / 0.5) + abs(across / 2 - moment / 0.5)
        load = run.joint_friction_load.sel(joint_motion="rail offset").values
        np.testing.assert_allclose(load, shoes, rtol=1e-9)


def test_friction_agrees_with_the_recorded_loads_of_a_loop() -> None:
    """A four-bar linkage, driven by a spring: its cut joint is a constraint."""
    run = completed(four_bar("left"))
    wrench = run.joint_force.sel(joint="left").values
    across = np.hypot(wrench[:, 0], wrench[:, 2])
    load = run.joint_friction_load.sel(joint_motion="left angle").values
    np.testing.assert_allclose(load, 0.1 * across, rtol=1e-9, atol=1e-9)
    assert set(np.unique(run.joint_motion_mode.sel(joint_motion="left angle"))) >= {UP, DOWN}
    assert np.abs(run.energy_residual).max() < 1e-5 * loss(run)


def test_friction_by_load_must_be_determined_in_a_loop() -> None:
    """Two hinges of a linkage with one motion would share the friction at rest; a hinge that closes
    the loop holds what others hold already."""
    with pytest.raises(InputError, match="holds more motions \\(left angle, top angle\\)"):
        hs.simulate(four_bar("left", "top"))
    loop = four_bar("left")
    pin = joint("hinge", "rocker", "coupler", point=(0.0, 0.0, 0.6), axis=(0.0, 1.0, 0.0))
    with pytest.raises(InputError, match="left angle, while other joints or drives hold a part"):
        hs.simulate(replace(loop, joints={**loop.joints, "pin": pin}))


def four_bar(*rubbing: str) -> Scene:
    """A crank on the earth, a coupler, and a rocker on the earth that closes the loop."""
    y = (0.0, 1.0, 0.0)
    bodies = [
        carried("crank", 100.0, (10.0, 12.0, 10.0), (0.0, 0.0, 0.5)),
        carried("coupler", 150.0, (20.0, 22.0, 20.0), (1.0, 0.0, 1.1)),
        carried("rocker", 120.0, (15.0, 16.0, 15.0), (2.0, 0.0, 0.6)),
    ]
    grip = grips(0.2, 0.3, radius=0.1)
    spring = {"stiffness": 900.0, "neutral": 1.0}
    left, top = (moved(friction=grip if name in rubbing else None) for name in ("left", "top"))
    joints = {
        "left": joint("hinge", "crank", None, left._replace(**spring), point=(0, 0, -0.5), axis=y),
        "top": joint("hinge", "coupler", "crank", top, point=(-1.0, 0.0, -0.1), axis=y),
        "right": joint("hinge", "rocker", None, point=(0.0, 0.0, -0.6), axis=y),
        "pin": joint("guide", "rocker", "coupler", point=(0.0, 0.0, 0.6), axis=y),
    }
    return by_rk4(scene(bodies, joints, 3.0), 0.004)


def restarted(time: float, state: int) -> None:
    base = pendulum(10.0, 0.01, 4.0, -2.0).with_output(states=True)
    whole = completed(base)
    first = int(np.argmin(np.abs(whole.time.values - time)))
    assert mode(whole)[first] == state
    rest = completed(replace(base, initial=Start(whole, time), duration=4.0 - time))
    for name in ("joint_position", "joint_velocity", "joint_friction", "joint_friction_load"):
        np.testing.assert_array_equal(rest[name].values, whole[name].values[first:])


def test_a_run_goes_on_to_the_bit_in_slip() -> None:
    restarted(0.4, DOWN)


def test_a_run_goes_on_to_the_bit_at_rest() -> None:
    restarted(2.5, STUCK)


@pytest.mark.parametrize("kind", ["planar", "cylindrical"])
def test_friction_by_load_is_refused_where_motions_share_it(kind: str) -> None:
    grip = moved(friction=grips(0.1))
    motions = [grip, moved(), moved()] if kind == "planar" else [moved(), grip]
    body = carried("body", MASS, INERTIA, (0.0, 0.0, 0.0))
    made = scene([body], {"held": joint(kind, "body", None, *motions)}, 1.0)
    with pytest.raises(
        InputError, match=r"joints.held: found static_coefficient.*slide of a slider"
    ):
        hs.simulate(made)


def test_the_linear_analysis_takes_it_as_given_friction() -> None:
    base = pendulum(0.5, 0.01, 1.0)
    given = moved(friction=JointFriction(20.0, 10.0))
    pin = with_motions(base.joints["pin"], given)
    linear = [hs.linearise(*compile_scene(s)) for s in (base, replace(base, joints={"pin": pin}))]
    np.testing.assert_array_equal(linear[0].constraints, linear[1].constraints)
    np.testing.assert_array_equal(linear[0].eigenvalues(), linear[1].eigenvalues())


def test_a_linear_analysis_says_that_friction_holds_all() -> None:
    held = linear_analysis(pendulum(0.5, 0.01, 1.0), LinearRequest())
    assert held.mode_shape.shape == (0, 1, 6)
    assert held.joint_mode_shape.shape == (0, 1)
    assert "There are no natural modes: friction at rest" in str(linear_document(held, raos=False))


CASE = """
title: trolley
duration: 2 s
bodies:
  trolley:
    mass: 2 tonne
    radii_of_gyration: [1 m, 1 m, 1 m]
    centre_of_gravity: [0, 0, 1 m]
    weight: carried
joints:
  rail:
    type: slider
    body: trolley
    axis: [1, 0, -0.5]
    friction: {law: coulomb, %s}
"""


def test_a_case_file_tells_the_friction(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    path.write_text(CASE % "static_coefficient: 0.2, guide_length: 0.8 m, static_force: 100 N")
    held = hs.load_case(path).scene().joints["rail"].resistances[0].friction
    assert held.constant_friction == (100.0, 100.0)
    assert held.coefficients == (0.2, 0.2)
    assert held.levers == (1.0, 0.0, 0.8)
    said = str(hs.check(path))
    assert "0.2 of the load of its bearings at rest" in said
    assert "more than 2 m beside the joint it jams" in said


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ("kinetic_force: 2 N", "found no friction; expected static_force, static_coefficient"),
        ("static_coefficient: 0.1, kinetic_coefficient: 0.2", "kinetic_coefficient 0.2 above"),
        ("static_coefficient: 0", "found a coefficient of 0"),
        ("static_force: 1 N, guide_length: 1 m", "found guide_length without static_coefficient"),
        ("static_coefficient: 0.1, radius: 1 m", "radius"),
    ],
)
def test_keys_that_do_not_fit_are_refused(tmp_path: Path, keys: str, said: str) -> None:
    path = tmp_path / "case.yaml"
    path.write_text(CASE % keys)
    with pytest.raises(InputError, match=said):
        hs.load_case(path)


def with_load_friction(seed: int, turn: float = 0.0) -> Case:
    """A random articulated case with friction by load in all its hinges and slides."""
    case = articulated_case(seed, turn)
    draw = np.random.default_rng(seed)
    for of in case.get("joints", {}).values():
        parts = {
            "hinge": [(of, True)],
            "slider": [(of, False)],
            "universal": [(of.get("first"), True), (of.get("second"), True)],
            "cylindrical": [(of.get("slide"), False)],
        }.get(of["type"], [])
        for acting, turns in parts:
            mu = round(float(draw.uniform(0.02, 0.3)), 4)
            size = float(np.linalg.norm(of["point"]))
            bearing = (
                {"radius": round(0.1 * size, 6)} if turns else {"guide_length": round(size, 6)}
            )
            friction = {"law": "coulomb", "static_coefficient": mu, **bearing}
            acting["friction"] = {**acting.get("friction", {}), **friction}
    return case


@pytest.mark.parametrize("number", few(range(1_000_000, 1_000_040), 8))
def test_a_random_articulated_scene_with_friction_by_load(number: int) -> None:
    trial = tried(with_load_friction, number)
    assert trial.status in ("complete", "failed", "refused"), trial.said
    assert list(offences(trial)) == []
