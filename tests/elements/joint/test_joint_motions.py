"""Springs, stops and dry friction in joints against closed forms."""

from dataclasses import replace
from math import log

import numpy as np
import pytest
import xarray as xr
from jointed import carried, completed, joint, scene
from scenes import Acting, JointFriction, Stops, central_force, joint_of, with_motions

import hydrosim as hs
from hydrosim import simulate
from hydrosim.compile.joints import rodrigues
from hydrosim.elements import Table
from hydrosim.errors import InputError
from hydrosim.scene import LinearScenes, Method

MASS = 2.0
INERTIA = np.diag([3.0, 4.0, 5.0])


def sliding(step: float, method: Method = Method.RK4, **acting: object) -> hs.Scene:
    """A body that slides along x on the earth."""
    return on_joint("slider", step, method, **acting)


def on_joint(kind: str, step: float, method: Method, **acting: object) -> hs.Scene:
    """A body on a joint to the earth through its centre of gravity, with the axis x."""
    joint = joint_of(kind, "body", None, Acting(**acting), axis=(1.0, 0.0, 0.0))
    solver = hs.Solver(step=step, method=method, linear=LinearScenes.STEP)
    bodies = (hs.Body("body", MASS, INERTIA),)
    whole = hs.Scene("joint", 6.0, bodies, joints={"joint": joint}, solver=solver)
    return whole.with_output(step=0.1)


def position(run: xr.Dataset) -> np.ndarray:
    """The motion of the joint over time."""
    return np.asarray(run.joint_position.values[:, 0])


def bounced(t: np.ndarray, speed: float, end: float, omega: float) -> np.ndarray:
    """A body that runs against an elastic stop at ``end``, and back."""
    meets = end / speed
    leaves = meets + np.pi / omega
    pressed = end + speed / omega * np.sin(omega * (t - meets))
    away = end - speed * (t - leaves)
    return np.where(t < meets, speed * t, np.where(t < leaves, pressed, away))


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("kind", ["slider", "hinge"])
def test_an_elastic_stop_gives_the_motion_back(kind: str, side: float) -> None:
    inertia = MASS if kind == "slider" else INERTIA[0, 0]
    omega = np.sqrt(18.0 / inertia)
    stops = Stops(-0.53 if side < 0 else -9.0, 0.53 if side > 0 else 9.0, 18.0)
    run = simulate(on_joint(kind, 0.005, Method.RK4, velocity=0.7 * side, stops=stops))
    expected = side * bounced(run.time.values, 0.7, 0.53, omega)
    assert np.abs(position(run) - expected).max() < 1e-9
    assert np.abs(run.energy_residual).max() < 1e-9


def test_a_stop_never_pulls() -> None:
    """With damping the force ends before the body has come back to the stop."""
    stops = Stops(-9.0, 0.5, 18.0, 4.0)
    run = simulate(sliding(0.005, velocity=0.7, stops=stops))
    force = run.joint_motion_force.values[:, 0]
    assert (force <= 0.0).all()
    assert ((position(run) > 0.5) & (force == 0.0)).any()  # beyond the end
    delta = 4.0 / (2.0 * MASS)
    omega = np.sqrt(18.0 / MASS - delta**2)
    t = np.arctan2(2.0 * delta * omega, 2.0 * delta**2 - 18.0 / MASS) / omega  # k d + c d' = 0
    end = 0.7 / omega * np.exp(-delta * t) * np.sin(omega * t)
    rate = 0.7 * np.exp(-delta * t) * (np.cos(omega * t) - delta / omega * np.sin(omega * t))
    assert 18.0 * end + 4.0 * rate == pytest.approx(0.0, abs=1e-12)
    free = run.time.values - 0.5 / 0.7 - t
    expected = 0.5 + end + rate * free
    assert np.abs(position(run) - expected)[free > 0.0].max() < 1e-8
    assert np.abs(run.energy_residual).max() < 1e-9


def test_dry_friction_stops_a_spring_after_half_periods() -> None:
    """Amplitudes fall by 2 F / k in each half period, until the spring cannot pull it on."""
    stiffness, kinetic, start = 8.0, 0.6, 0.51
    friction = JointFriction(0.8, kinetic)
    run = simulate(sliding(0.005, stiffness=stiffness, position=start, friction=friction))
    omega = np.sqrt(stiffness / MASS)
    expected = np.full(run.time.size, np.nan)
    amplitude, sign, half = start, 1.0, np.pi / omega
    t = run.time.values
    for k in range(20):
        here = (t >= k * half) & (t <= (k + 1) * half)
        middle = sign * kinetic / stiffness
        swing = (sign * amplitude - middle) * np.cos(omega * (t - k * half))
        expected = np.where(here, middle + swing, expected)
        amplitude -= 2.0 * kinetic / stiffness
        sign = -sign
        if stiffness * amplitude <= friction.static:
            expected = np.where(t >= (k + 1) * half, sign * amplitude, expected)
            break
    assert np.abs(position(run) - expected).max() < 1e-9
    assert run.joint_motion_mode.values[-1, 0] == 1  # stuck
    lost = 0.5 * stiffness * (start**2 - amplitude**2)
    assert float(run.energy_dissipated_joint[-1]) == pytest.approx(lost, rel=1e-9)


def test_a_stuck_joint_breaks_away_under_a_growing_force() -> None:
    growth, static, kinetic = 0.5, 1.1, 0.7
    force = Table(np.array([0.0, 10.0]), np.array([0.0, 10.0 * growth]))
    scene = sliding(0.05, friction=JointFriction(static, kinetic))
    pull = central_force("body", surge=force)
    run = simulate(replace(scene, forces={"pull": pull}))
    t = np.maximum(run.time.values - static / growth, 0.0)
    expected = ((static - kinetic) * t**2 / 2.0 + growth * t**3 / 6.0) / MASS
    assert np.abs(position(run) - expected).max() < 1e-9


@pytest.mark.parametrize("method", [Method.RK4, Method.DOPRI5])
def test_the_order_of_a_method_holds_through_stops_and_friction(method: Method) -> None:
    limits = {"stops": Stops(-0.4, 0.6, 30.0, 1.0), "friction": JointFriction(0.9, 0.5)}
    acting = {"stiffness": 9.0, "damping": 0.3, "velocity": 2.5, **limits}
    if method.adapts:
        run = simulate(sliding(0.02, method, **acting))
        finest = simulate(sliding(0.0005, **acting))
        assert np.abs(position(run) - position(finest)).max() < 1e-5
        return
    runs = [position(simulate(sliding(step, **acting))) for step in (0.05, 0.025, 0.0005)]
    errors = [np.abs(x - runs[-1]).max() for x in runs[:2]]
    assert np.log2(errors[0] / errors[1]) > 3.8


def test_a_joint_told_from_its_other_side_is_the_same() -> None:
    """Body and to in exchange: the motion of `body` relative to `to` changes its sign."""
    acting = {"stiffness": 5.0, "damping": 0.4, "velocity": 0.3, "stops": Stops(-0.02, 0.03, 40.0)}
    one = hs.Body("one", 2.0, INERTIA, centre_of_gravity=(0.5, 0.0, 0.0))
    other = hs.Body("other", 5.0, 2.0 * INERTIA)
    there = hs.Hinge("one", "other", (0.4, 0.1, 0.0), axis=(0.0, 1.0, 0.0))
    here = replace(there, body="other", to="one", point=(0.9, 0.1, 0.0))
    turned = dict(acting, velocity=-0.3, stops=Stops(-0.03, 0.02, 40.0))
    base = hs.Hinge("other", None, (0.0, 0.0, 1.0), axis=(0.0, 1.0, 0.0))
    base = with_motions(base, Acting(stiffness=9.0, velocity=0.2))
    runs = []
    for hinge, motions in ((there, Acting(**acting)), (here, Acting(**turned))):
        joints = {"base": base, "joint": with_motions(hinge, motions)}
        runs.append(simulate(replace(sliding(0.01), bodies=(other, one), joints=joints)))
    first, second = runs
    assert np.abs(first.velocity - second.velocity).max() < 1e-9
    relative = [run.joint_position.sel(joint_motion="joint angle") for run in runs]
    assert np.abs(relative[0] + relative[1]).max() < 1e-9
    loads = [run.joint_force.sel(joint="joint") for run in runs]
    assert np.abs(loads[0] + loads[1]).max() < 1e-9


# Joints that leave nothing to move are refused.


def test_joints_that_hold_all_bodies_are_refused() -> None:
    bodies = [carried(name, 1.0, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)) for name in ("a", "b")]
    joints = {"pin": joint("fixed", "a"), "weld": joint("fixed", "b", "a")}
    with pytest.raises(InputError, match="they hold all bodies; expected at least one"):
        hs.simulate(scene(bodies, joints, 1.0))


# Times at which joints close, read from the places that they hold, against closed forms.

SLIDING_MASS, RAIL_DAMPING, LAUNCH_SPEED = 3.0, 1.2, 2.0


def held_at(pin: hs.Joint, step: float, method: Method) -> float:
    """Where a sliding body that damping slows down is held by a ``pin`` to the earth [m]."""
    damped = Acting(damping=RAIL_DAMPING, velocity=LAUNCH_SPEED)
    rail = joint_of("slider", "body", None, damped, axis=(1.0, 0.0, 0.0))
    solver = hs.Solver(step=step, method=method, linear=LinearScenes.STEP)
    bodies, joints = (hs.Body("body", SLIDING_MASS, np.eye(3)),), {"rail": rail, "pin": pin}
    scene = hs.Scene("closing", 4.0, bodies, joints=joints, solver=solver, output={"step": 0.5})
    run = simulate(scene)
    assert (run.joint_velocity.values[-1] == 0.0).all()
    return float(run.joint_position.values[-1, 0])


def time_of(place: float) -> float:
    """Time at which the body comes by [s]."""
    rate = RAIL_DAMPING / SLIDING_MASS
    return -log(1.0 - place * rate / LAUNCH_SPEED) / rate


@pytest.mark.parametrize("method", [Method.RK4, Method.DOPRI5])
def test_a_window_closes_at_its_speed(method: Method) -> None:
    pin = hs.Fixed("body", window=hs.JointWindow(gap=100.0, speed=0.9))
    found = time_of(held_at(pin, 0.01, method))
    assert found == pytest.approx(SLIDING_MASS / RAIL_DAMPING * log(LAUNCH_SPEED / 0.9), abs=1e-9)


@pytest.mark.parametrize("method", [Method.RK4, Method.DOPRI5])
def test_a_channel_closes_at_its_value(method: Method) -> None:
    active = hs.Active(hs.When(channel="position.body.surge", above=1.7))
    pin = hs.Fixed("body", active=active)
    assert time_of(held_at(pin, 0.01, method)) == pytest.approx(time_of(1.7), abs=1e-9)


def test_a_time_closes_at_that_time() -> None:
    pin = hs.Fixed("body", active=hs.Active(hs.When(1.234567)))
    found = time_of(held_at(pin, 0.01, Method.RK4))
    assert found == pytest.approx(1.234567, abs=1e-9)


# Bodies that turn over on joints: their recorded angles, and attitudes that are given twice.

TURN_RATE = 1.5  # rad/s, for 6 s: more than a turn
HINGE_TILT = np.radians(30.0)


def spinning(axis: tuple[float, float, float]) -> np.ndarray:
    """Roll, pitch, yaw and hinge angle (nt, 4) of a body that turns about its centre of gravity."""
    body = carried("body", 2.0, [3.0, 4.0, 6.0], (0.0, 0.0, 0.0))
    hinge = joint("hinge", "body", None, Acting(velocity=TURN_RATE), axis=axis)
    run = completed(scene([body], {"hinge": hinge}, 6.0))
    turned = run.joint_position.values[:, :1]
    assert turned[-1, 0] == pytest.approx(6.0 * TURN_RATE, abs=1e-9)
    return np.hstack([run.position.values[:, 0, 3:], turned])


def within_half_a_turn(angle: np.ndarray) -> np.ndarray:
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)


@pytest.mark.parametrize("dof", [0, 1])
def test_a_level_hinge_keeps_the_heading_at_every_angle(dof: int) -> None:
    """Roll or pitch is the angle within half a turn; the two others stay zero."""
    axis = (1.0, 0.0, 0.0) if dof == 0 else (0.0, 1.0, 0.0)
    angles = spinning(axis)
    assert np.abs(angles[:, [1 - dof, 2]]).max() < 1e-12
    assert np.abs(within_half_a_turn(angles[:, dof] - angles[:, 3])).max() < 1e-12


def test_a_vertical_hinge_counts_turns() -> None:
    angles = spinning((0.0, 0.0, 1.0))
    assert np.abs(angles[:, 2] - angles[:, 3]).max() < 1e-12


def test_yaw_on_a_leaning_hinge_stays_within_half_a_turn_of_the_heading() -> None:
    """Its heading is the twist, 2 atan2(cos(tilt) sin(angle / 2), cos(angle / 2)), within half a
    turn; its yaw is less than a quarter of a turn from there."""
    angles = spinning((np.sin(HINGE_TILT), 0.0, np.cos(HINGE_TILT)))
    half = 0.5 * within_half_a_turn(angles[:, 3])
    heading = 2.0 * np.arctan2(np.cos(HINGE_TILT) * np.sin(half), np.cos(half))
    assert np.abs(angles[:, 2] - heading).max() < 0.5 * np.pi


def test_rotation_vectors_of_more_than_half_a_turn_are_the_same_rotation() -> None:
    axis = np.array([0.6, 0.0, 0.8])
    for angle in (-300.0, -170.0, 190.0, 360.0, 540.0 - 1e-3, 725.0):
        turn = np.radians(angle)
        nearest = turn - 2.0 * np.pi * np.round(turn / (2.0 * np.pi))
        assert rodrigues(turn * axis) == pytest.approx(rodrigues(nearest * axis), abs=1e-9)
        assert np.linalg.norm(rodrigues(turn * axis)) <= 4.0 + 1e-9
