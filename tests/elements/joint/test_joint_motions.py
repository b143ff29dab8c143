"""Springs, stops and dry friction in joints against closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import hydrosim as hs
from hydrosim import simulate
from hydrosim.elements import AppliedForce, Table
from hydrosim.scene import JointFriction, JointResistance, JointType, LinearScenes, Method, Stops

MASS = 2.0
INERTIA = np.diag([3.0, 4.0, 5.0])


def sliding(step: float, method: Method = Method.RK4, **acting: object) -> hs.Scene:
    """A body that slides along x on the earth."""
    return on_joint(JointType.SLIDER, step, method, **acting)


def on_joint(kind: JointType, step: float, method: Method, **acting: object) -> hs.Scene:
    """A body on a joint to the earth through its centre of gravity, with the axis x."""
    joint = hs.Joint(kind, "body", axis=(1.0, 0.0, 0.0), resistances=(JointResistance(**acting),))
    return hs.Scene(
        "joint",
        6.0,
        (hs.Body("body", MASS, INERTIA),),
        joints={"joint": joint},
        solver=hs.Solver(step=step, method=method, linear=LinearScenes.STEP),
        output_step=0.1,
    )


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
@pytest.mark.parametrize("kind", [JointType.SLIDER, JointType.HINGE])
def test_an_elastic_stop_gives_the_motion_back(kind: JointType, side: float) -> None:
    inertia = MASS if kind == JointType.SLIDER else INERTIA[0, 0]
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
    pull = AppliedForce("body", (0.0, 0.0, 0.0), {"surge": force})
    run = simulate(replace(scene, forces={"pull": pull}))
    t = np.maximum(run.time.values - static / growth, 0.0)
    expected = ((static - kinetic) * t**2 / 2.0 + growth * t**3 / 6.0) / MASS
    assert np.abs(position(run) - expected).max() < 1e-9


@pytest.mark.parametrize("method", [Method.RK4, Method.DOPRI5])
def test_the_order_of_a_method_holds_through_stops_and_friction(method: Method) -> None:
    acting = {
        "stiffness": 9.0,
        "damping": 0.3,
        "velocity": 2.5,
        "stops": Stops(-0.4, 0.6, 30.0, 1.0),
        "friction": JointFriction(0.9, 0.5),
    }
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
    there = hs.Joint(JointType.HINGE, "one", "other", (0.4, 0.1, 0.0), (0.0, 1.0, 0.0))
    here = replace(there, body="other", to="one", point=(0.9, 0.1, 0.0))
    turned = dict(acting, velocity=-0.3, stops=Stops(-0.03, 0.02, 40.0))
    base = hs.Joint(JointType.HINGE, "other", None, (0.0, 0.0, 1.0), (0.0, 1.0, 0.0))
    base = replace(base, resistances=(JointResistance(stiffness=9.0, velocity=0.2),))
    runs = [
        simulate(
            replace(
                sliding(0.01),
                bodies=(other, one),
                joints={"base": base, "joint": replace(joint, resistances=(resistance,))},
            )
        )
        for joint, resistance in (
            (there, JointResistance(**acting)),
            (here, JointResistance(**turned)),
        )
    ]
    first, second = runs
    assert np.abs(first.velocity - second.velocity).max() < 1e-9
    relative = [run.joint_position.sel(joint_motion="joint angle") for run in runs]
    assert np.abs(relative[0] + relative[1]).max() < 1e-9
    loads = [run.joint_force.sel(joint="joint") for run in runs]
    assert np.abs(loads[0] + loads[1]).max() < 1e-9
