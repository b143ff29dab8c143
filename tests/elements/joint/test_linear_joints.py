"""Joints that are constraints in linear analysis, at rest, and with small angles."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import Acting, JointFriction, scene, steady, with_motions

import hydrosim as hs
from hydrosim.compile.compile import compile_scene
from hydrosim.linear.modes import natural_modes
from hydrosim.run.step_limits import scene_step_limits
from hydrosim.scene import Kinematics, LinearScenes, Method

G, MASS, ARM, INERTIA = 9.81, 3.0, 2.0, 2.0


def pendulum(side: float = 0.0, **changes: object) -> hs.Scene:
    """A body that hangs on a hinge to the earth, under its weight and a force to the side."""
    inertia = np.diag([1.0, INERTIA, 1.5])
    body = hs.Body("bob", MASS, inertia, centre_of_gravity=(0.0, 0.0, -ARM))
    load = steady("bob", heave=-MASS * G, surge=side)
    hinge = hs.Hinge("bob", None, (0.0, 0.0, ARM), axis=(0.0, 1.0, 0.0))
    found = scene([body], {"load": load}, 4.0, 0.1, step=0.01, method=Method.RK4)
    return replace(found, joints={"hinge": hinge}, **changes)


def test_a_pendulum_at_rest_and_its_frequency() -> None:
    """tan(angle) = F / mg; w^2 = m g' l / (I + m l^2), with the hinge's geometric stiffness."""
    side = 5.0
    compiled = compile_scene(pendulum(side, at_rest=True))
    angle = np.arctan2(side, MASS * G)
    assert compiled.state.y[0] == pytest.approx(-angle, abs=1e-9)
    w = np.sqrt(MASS * np.hypot(G, side / MASS) * ARM / (INERTIA + MASS * ARM**2))
    linear = hs.linearise(*compiled)
    assert np.abs(linear.eigenvalues().imag) == pytest.approx([w, w], rel=1e-6)
    run = hs.simulate(pendulum(side, at_rest=True))
    assert np.abs(run.velocity.values).max() < 1e-9
    load = run.joint_force.values[-1, 0, :3]
    assert load == pytest.approx([-side, 0.0, MASS * G], abs=1e-9)


def test_the_limit_of_steps_is_that_of_the_motions_that_joints_leave() -> None:
    """A stiff spring across a fixed joint limits no step; beside the joint it does."""
    K = np.zeros((6, 6))
    K[1, 1] = 1e8
    stiff = hs.LinearMooring("bob", K)
    base = pendulum()
    held = replace(base, forces={**base.forces, "stiff": stiff})
    loose = replace(held, joints={})
    limits = [min(x.step for x in scene_step_limits(compile_scene(s))) for s in (held, loose)]
    assert limits[1] < 1e-2 < limits[0]


def test_small_angles_keep_joints_and_are_propagated() -> None:
    """J is constant: exact propagation applies and agrees with steps; the joint stays closed."""
    K = np.zeros((6, 6))
    K[4, 4], K[0, 0] = 60.0, 8.0
    spring = hs.LinearMooring("bob", K)
    base = pendulum(1.0)
    solver = replace(base.solver, kinematics=Kinematics.LINEAR)
    small = replace(base, forces={**base.forces, "spring": spring}, solver=solver)
    start = Acting(position=-0.1, velocity=-0.2)
    hinge = with_motions(small.joints["hinge"], start)
    small = replace(small, joints={"hinge": hinge})
    stepped = hs.simulate(replace(small, solver=replace(small.solver, step=0.002)))
    exact = hs.simulate(replace(small, solver=replace(small.solver, linear=LinearScenes.EXACT)))
    assert exact.position.values == pytest.approx(stepped.position.values, abs=1e-9)
    q = exact.position.values[:, 0]
    assert np.abs(q[:, 0] + ARM * q[:, 4]).max() < 1e-12
    assert exact.joint_force.values == pytest.approx(stepped.joint_force.values, abs=1e-7)


def test_a_lock_at_rest_is_a_constraint_of_the_linear_analysis() -> None:
    """Two masses on springs that a lock holds together: one frequency, that of both."""
    bodies = []
    forces = {}
    for name, mass, k in (("a", 2.0, 8.0), ("b", 3.0, 27.0)):
        bodies.append(hs.Body(name, mass, np.eye(3), dofs=("surge",)))
        K = np.zeros((6, 6))
        K[0, 0] = k
        forces[f"{name}_spring"] = hs.LinearMooring(name, K)
    pin = hs.Fixed("a", "b", active=hs.Active(None, hs.When(100.0)))
    found = replace(scene(bodies, forces, 1.0, 0.1), joints={"pin": pin})
    linear = hs.linearise(*compile_scene(found))
    w = np.sqrt(35.0 / 5.0)
    assert np.abs(linear.eigenvalues().imag) == pytest.approx([w, w], rel=1e-9)


def test_a_hinge_that_friction_and_a_ratchet_hold_has_no_mode() -> None:
    """Both hold its one motion, so that their shares are not defined, and nothing asks for them."""
    base = pendulum()
    stuck = Acting(friction=JointFriction(20.0, 10.0))
    hinge = with_motions(base.joints["hinge"], stuck)
    pawl = hs.Ratchet("bob", None, (0.0, 0.0, ARM), axis=(0.0, 1.0, 0.0), turn=hs.TurningPawl())
    compiled = compile_scene(replace(base, joints={"hinge": hinge, "pawl": pawl}))
    linear = hs.linearise(*compiled)
    assert len(linear.constraints) == 2
    assert natural_modes(linear) == []
