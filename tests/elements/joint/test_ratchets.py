"""Ratchets: they hold as soon as a motion would go back, and let go when their load turns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import block, central_force, moving, scene, table
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import hydrosim as hs
from hydrosim.scene import Active, Body, Joint, JointType, Kinematics, Method, Ratchet, Scene, When

MASS, STIFFNESS = 2.0, 8.0
CORNERS = np.array([0.0, 2.0, 4.0, 6.0, 8.0])
FORCE = np.array([0.0, 0.0, 10.0, -10.0, 12.0])
TIGHT = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}


def along(stiffness: float) -> hs.LinearMooring:
    K = np.zeros((6, 6))
    K[0, 0] = stiffness
    return hs.LinearMooring("cart", K)


def driven(pitch: float = 0.0, step: float = 0.05, **changes: object) -> Scene:
    """A cart on a spring, thrown forward and then pushed and pulled; a ratchet lets it go +x."""
    cart = block(MASS, ("surge",), "cart", velocity=moving(surge=1.0))
    six = np.column_stack([FORCE, *[0.0 * FORCE] * 5])
    push = central_force("cart", **table(CORNERS, six))
    loads = {"spring": along(STIFFNESS), "push": push}
    found = scene([cart], loads, 8.0, 0.1, step=step, method=Method.RK4)
    pawl = Joint(JointType.RATCHET, "cart", axis=(1.0, 0.0, 0.0), ratchet=Ratchet(False, pitch))
    return replace(found, joints={"pawl": pawl}, **changes)


def force(t: float) -> float:
    return float(np.interp(t, CORNERS, FORCE))


def reference(end: float) -> tuple[list[float], np.ndarray]:
    """Times at which the cart is held and let go, and its place at the end; by DOP853."""

    def rhs(t: float, y: np.ndarray) -> list[float]:
        return [y[1], (force(t) - STIFFNESS * y[0]) / MASS]

    def back(t: float, y: np.ndarray) -> float:
        return y[1]

    back.terminal, back.direction = True, -1.0
    t, y = 0.0, np.array([0.0, 1.0])
    times: list[float] = []
    while t < end:
        corner = float(CORNERS[CORNERS > t + 1e-12][0])
        first = max(t, 1e-12)
        way = solve_ivp(rhs, (first, corner), y, events=back, **TIGHT)
        t, y = float(way.t[-1]), way.y[:, -1]
        if not way.t_events[0].size:
            continue
        times.append(t)
        y[1] = 0.0
        grid = np.linspace(t, end, 80001)
        pulls = np.array([force(s) for s in grid]) - STIFFNESS * y[0]
        later = np.flatnonzero(pulls > 1e-9)
        if not later.size:
            break
        i = int(later[0])
        held = STIFFNESS * float(y[0])
        t = brentq(lambda s, held=held: force(s) - held, grid[i - 1], grid[i], xtol=1e-14)
        times.append(t)
        y[1] = 1e-13  # on its way: the event of going back begins above zero
    return times, y


def test_a_ratchet_against_dop853() -> None:
    """Held where it stops, let go where the force exceeds the spring; fourth order, no loss."""
    times, wanted = reference(8.0)
    assert len(times) >= 3
    errors = []
    for step in (0.05, 0.025, 0.0125):
        run = hs.simulate(driven(step=step))
        errors.append(abs(run.position.values[-1, 0, 0] - wanted[0]))
    assert errors[-1] < 1e-8
    assert errors[0] / errors[-1] > 16.0**1.9
    x = run.position.values[:, 0, 0]
    assert np.diff(x).min() > -1e-12
    load = run.joint_force.values[:, 0, 0]
    assert load.min() > -1e-9  # it only pushes
    held = run.lock_mode.values[:, 0] == 3
    t = run.time.values
    pulls = np.array([STIFFNESS * p - force(s) for s, p in zip(t, x, strict=True)])
    assert load[held] == pytest.approx(pulls[held], abs=1e-9)
    assert not load[~held].any()
    assert run.energy_dissipated_joints.values[-1] < 1e-30
    assert np.abs(run.energy_residual).max() < 1e-7


def test_the_times_of_a_ratchet_against_dop853() -> None:
    """It stops at v = 0, a quarter of a period; it lets go at 2.8 s: 1e-9 s, from modes."""
    times, _ = reference(8.0)
    run = hs.simulate(driven(step=0.0125, output_step=0.0125))
    closed = (run.lock_mode.values[:, 0] == 3).astype(int)
    changes = np.flatnonzero(np.diff(closed))
    for k, when in zip(changes, times, strict=False):
        assert run.time.values[k] <= when + 1e-9
        assert when <= run.time.values[k + 1] + 1e-9
    assert times[0] == pytest.approx(np.pi / 4.0, abs=1e-9)
    assert run.position.values[changes[0] + 1, 0, 0] == pytest.approx(0.5, abs=1e-9)


def test_teeth_catch_with_a_loss() -> None:
    """From 0.5 m the cart falls back on the tooth at 0.45 m: it loses what the spring has given."""
    base = driven(0.15, step=0.005)
    base = replace(base, duration=1.6, forces={"spring": along(STIFFNESS)})
    run = hs.simulate(base)
    assert run.position.values[-1, 0, 0] == pytest.approx(0.45, abs=1e-12)
    lost = 0.5 * STIFFNESS * (0.5**2 - 0.45**2)
    assert run.lock_loss.values[-1, 0] == pytest.approx(lost, rel=1e-7)
    assert np.abs(run.energy_residual).max() < 1e-8
    assert run.lock_impulse.values[-1, 0, 0] == pytest.approx(np.sqrt(2.0 * lost * MASS), rel=1e-7)


@pytest.mark.parametrize("kinematics", Kinematics)
@pytest.mark.parametrize("pitch", [0.0, 0.3])
def test_a_ratchet_about_an_axis(kinematics: Kinematics, pitch: float) -> None:
    """A flywheel on a spring that turns one way, to 0.5 rad or to the tooth before."""
    K = np.zeros((6, 6))
    K[5, 5] = 8.0
    wheel = Body("wheel", 1.0, np.diag([1.0, 1.5, 2.0]), velocity=moving(yaw=1.0))
    forces = {"spring": hs.LinearMooring("wheel", K)}
    solver = {"step": 0.01, "method": Method.RK4, "kinematics": kinematics}
    found = scene([wheel], forces, 2.0, 0.1, **solver)
    pawl = Joint(JointType.RATCHET, "wheel", axis=(0.0, 0.0, 1.0), ratchet=Ratchet(True, pitch))
    run = hs.simulate(replace(found, joints={"pawl": pawl}))
    wanted = 0.3 if pitch else 0.5
    assert run.position.values[-1, 0, 5] == pytest.approx(wanted, abs=1e-8)
    assert run.joint_force.values[-1, 0, 5] == pytest.approx(8.0 * wanted, abs=1e-6)
    lost = 0.5 * 8.0 * (0.25 - wanted**2)
    assert run.lock_loss.values[-1, 0] == pytest.approx(lost, abs=1e-6)


def test_a_ratchet_is_pushed_back_by_an_impact() -> None:
    """A cart that a pin stops from behind is thrown back: the ratchet takes the impulse."""
    cart = block(MASS, ("surge",), "cart", velocity=moving(surge=0.5))
    other = block(3.0, ("surge",), "other", velocity=moving(surge=-1.0), location=(3.0, 0.0))
    pawl = Joint(JointType.RATCHET, "cart", axis=(1.0, 0.0, 0.0), ratchet=Ratchet())
    pin = Joint(JointType.FIXED, "cart", "other", active=Active(When(0.55)))
    found = scene([cart, other], {}, 1.0, 0.1)
    run = hs.simulate(replace(found, joints={"pawl": pawl, "pin": pin}))
    assert np.abs(run.velocity.values[-1]).max() < 1e-12
    assert run.lock_loss.values[-1].sum() == pytest.approx(0.5 * (2 * 0.25 + 3.0), rel=1e-12)
    impulse = dict(zip(run.lock.values, run.lock_impulse.values[-1, :, 0], strict=True))
    assert impulse["pawl"] == pytest.approx(2.0, rel=1e-12)


def test_a_ratchet_continues_to_the_bit() -> None:
    base = driven(output_states=True)
    whole = hs.simulate(base)
    rest = hs.simulate(replace(base, duration=4.0, initial=hs.scene.Start(whole, 4.0)))
    for name in ("position", "velocity", "joint_force", "lock_mode"):
        assert np.array_equal(rest[name].values, whole[name].sel(time=rest.time.values).values)


def test_the_axis_of_a_ratchet_without_teeth_stays_where_it_is() -> None:
    """On the earth, while the body turns by half a turn: it pushes along x, wherever it closes."""
    start = moving(surge=1.0, yaw=0.4)
    cart = block(MASS, ("surge", "sway", "yaw"), "cart", velocity=start)
    pushes = np.column_stack([FORCE, *[0.0 * FORCE] * 5])
    push = central_force("cart", **table(CORNERS, pushes))
    found = scene([cart], {"spring": along(STIFFNESS), "push": push}, 8.0, 0.1, step=0.05)
    pawl = Joint(JointType.RATCHET, "cart", axis=(1.0, 0.0, 0.0), ratchet=Ratchet(False, 0.0))
    run = hs.simulate(replace(found, joints={"pawl": pawl}))
    closings = np.flatnonzero(np.diff(run.lock_mode.values[:, 0]) > 0)
    assert closings.size == 2
    assert run.position.values[closings[1], 0, 5] > 1.0  # rad: it has turned since it closed first
    assert run.joint_force.values[:, 0, 0].max() > 1.0
    assert np.abs(run.joint_force.values[:, 0, 1]).max() < 1e-9
    alone = hs.simulate(driven())
    assert run.position.values[:, 0, 0] == pytest.approx(alone.position.values[:, 0, 0], abs=1e-6)
