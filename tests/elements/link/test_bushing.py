"""Bushings: potential at any rotation, small vibrations, half turns, small angles."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import assert_continues, block, moving, scene, with_step
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation
from test_struts import load_on

import hydrosim as hs
from hydrosim.errors import SimulationError
from hydrosim.linear.linearise import linearise
from hydrosim.linear.modes import natural_modes
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Active, Kinematics, LinearScenes, When

RNG = np.random.default_rng(11)
ROOT = RNG.normal(size=(6, 6))
STIFFNESS = 2e3 * (ROOT @ ROOT.T + np.eye(6))
NO_DAMPING = np.zeros((6, 6))
POINT = (0.6, -0.4, 0.9)
JOINED = hs.Bushing("block", POINT, STIFFNESS, NO_DAMPING, "other")


def energy_of(turns: list[Rotation], shifts: np.ndarray) -> float:
    """x^T K x / 2 with the rotation vector of scipy, apart from hydrosim."""
    other = turns[1].as_matrix()
    ends = [shifts[i] + turns[i].apply(POINT) for i in (0, 1)]  # both centres are at the origin
    x = [*(other.T @ (ends[0] - ends[1])), *(turns[1].inv() * turns[0]).as_rotvec()]
    return float(0.5 * np.array(x) @ STIFFNESS @ x)


def test_the_load_is_the_gradient_of_the_energy_at_large_rotations(figure, validated):
    """Coupled stiffness, to 170 deg: forces and moments against differences of the energy."""
    random = np.random.default_rng(4)
    eps, worst, largest = 1e-5, 0.0, 0.0
    for _ in range(10):
        turns = [Rotation.from_rotvec(random.uniform(-1.4, 1.4, 3)) for _ in range(2)]
        shift = random.uniform(-2.0, 2.0, 3)
        angle = (turns[1].inv() * turns[0]).magnitude()
        if angle > np.radians(170.0):
            continue
        largest = max(largest, float(angle))
        wrench, stored = load_on(JOINED, turns, shift)
        at = np.array([shift, np.zeros(3)])
        assert stored == pytest.approx(energy_of(turns, at), rel=1e-10)
        for body in (0, 1):
            found = []
            for move in np.eye(6):
                ends = []
                for sign in (1.0, -1.0):
                    moved, places = [*turns], at.copy()
                    moved[body] = Rotation.from_rotvec(sign * eps * move[3:]) * moved[body]
                    places[body] += sign * eps * move[:3]
                    ends.append(energy_of(moved, places))
                found.append((ends[0] - ends[1]) / (2 * eps))
            scale = np.abs(found).max()
            worst = max(worst, float(np.abs(wrench[body] + found).max() / scale))
    figure("largest angle, deg", np.degrees(largest))
    assert largest > np.radians(120.0)
    claim = "load of a bushing at large rotations, of the largest"
    against = "differences of its energy"
    validated(Kind.INDEPENDENT, claim, against, worst, 1e-7, Feature.BUSHINGS)


def test_small_vibrations_are_those_of_its_stiffness_at_the_centre(figure, validated):
    """Six periods beside its centre: eigenvalues of T^T K T and M, T from centre to bushing."""
    body = block(800.0)
    held = hs.Bushing("block", POINT, STIFFNESS, NO_DAMPING)
    modes = natural_modes(linearise(*hs.compile_scene(scene(body, {"it": held}, 1.0, 0.1))))
    x, y, z = POINT
    T = np.eye(6)
    T[:3, 3:] = -np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    M = np.zeros((6, 6))
    M[:3, :3], M[3:, 3:] = 800.0 * np.eye(3), body.inertia
    expected = np.sqrt(eigh(T.T @ STIFFNESS @ T, M, eigvals_only=True))
    found = np.sort([2 * np.pi / mode.natural_period for mode in modes])
    error = np.abs(found / expected - 1.0).max()
    claim = "six natural frequencies of a body on a bushing, relative"
    validated(Kind.CLOSED_FORM, claim, "stiffness about the centre", error, 1e-6, Feature.BUSHINGS)


def test_half_a_turn_ends_the_run_or_is_refused() -> None:
    body = block(1e3, ("yaw",), velocity=moving(yaw=1.0))
    free = hs.Bushing("block", POINT, NO_DAMPING, np.diag([0, 0, 0, 0, 0, 1e-3]))
    turning = scene(body, {"it": free}, 5.0, 0.1, step=0.05)
    with pytest.raises(SimulationError, match=r"the force of it is lost: it has turned by half"):
        hs.simulate(turning)
    opposite = replace(body, position=moving(yaw=np.pi))
    with pytest.raises(hs.InputError, match=r"forces\.it: it has turned by half a turn.*start"):
        hs.compile_scene(scene(opposite, {"it": free}, 1.0, 0.1))
    absent = replace(free, active=Active(When(4.9)))
    run = hs.simulate(replace(turning, forces={"it": absent}))  # at 4.9 rad: less than half a turn
    assert not run.bushing_load.values[run.time.values < 4.9 - 1e-9].any()


def test_small_angles_are_linear_and_propagated(figure) -> None:
    """Bushings and a torsion spring on two damped bodies, propagated and stepped."""
    earth = hs.Bushing("other", (0.3, 0.2, -0.5), 0.5 * STIFFNESS, 0.02 * STIFFNESS)
    joined = replace(JOINED, damping=0.01 * STIFFNESS)
    curve = (0.0, 1.0), (50.0, 4e3)
    twist = hs.TorsionSpring(
        "block", (0.3, 0.5, 0.9), curve=hs.TorsionCurve(*curve), damping=3e2, to="other"
    )
    spinning = block(2e3, location=(1.0, 0.0), velocity=moving(surge=0.3, yaw=0.2))
    bodies = (spinning, block(5e3, name="other"))
    forces = {"it": joined, "earth": earth, "twist": twist}
    whole = scene(bodies, forces, 5.0, 0.1, kinematics=Kinematics.LINEAR)
    exact = hs.simulate(with_step(whole, 0.1, linear=LinearScenes.EXACT))
    steps = hs.simulate(with_step(whole, 0.005))
    assert exact.solver_linear == "propagated exactly: linear"
    difference = np.abs(exact.position - steps.position).max() / np.abs(steps.position).max()
    figure("difference", float(difference))
    assert difference < 1e-7
    for name in forces:
        lost, expected = (run[f"energy_dissipated_{name}"].values for run in (exact, steps))
        assert expected[-1] > 1.0
        np.testing.assert_allclose(lost, expected, atol=1e-7 * expected[-1])
    assert exact.energy_residual_relative < 1e-6


def test_the_ledger_closes_and_a_restart_goes_on_to_the_bit(figure) -> None:
    thrown = block(2e3, location=(1.0, 0.0), velocity=(0.3, -0.4, 0.2, 0.9, 0.5, -0.7))
    bodies = (thrown, block(5e3, name="other"))
    brief = replace(JOINED, damping=0.05 * STIFFNESS, active=Active(When(0.35), When(3.15)))
    whole = scene(bodies, {"it": brief}, 4.0, 0.1, step=0.005).with_output(states=True)
    run = hs.simulate(whole)
    figure("residual", run.energy_residual_relative)
    assert run.energy_residual_relative < 1e-7
    assert np.ptp(run.energy_dissipated_it.values) > 100.0
    np.testing.assert_array_equal(run.bushing_load.values[run.time.values > 3.2], 0.0)
    assert run.bushing_load.dims == ("time", "bushing", "dof")
    assert run.bushing_displacement.dof_units == "m, m, m, rad, rad, rad"
    names = ("position", "velocity", "bushing_load", "bushing_mode")
    assert_continues(whole, run, (2.0,), *names)
