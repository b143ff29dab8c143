"""Bodies that turn without moments: conserved quantities, Euler's and Hamilton's equations."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from dry_bodies import INERTIA, dry_body, rate_map, rotation, skew
from numpy.testing import assert_allclose
from scenes import straight_curve, table
from scipy.integrate import solve_ivp

from hydrosim import simulate
from hydrosim.dofs import DOFS
from hydrosim.elements import AppliedForce, Fender, LinearMooring, Plane, StickSlip
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Kinematics, Method, Scene, Solver

ORDERS = {Method.RK2: 2, Method.HEUN: 2, Method.RK4: 4}
START = np.array([0.3, -0.2, 0.5])  # roll, pitch, yaw
SPIN = np.array([0.3, 0.2, 2.0])  # mostly about the axis of the largest inertia: no tumbling
DURATION = 6.0


def turning(step: float = 0.01, method: Method = Method.RK4, **changes: Any) -> Scene:
    """A free body with ``START`` and ``SPIN``, drifting along."""
    body = dry_body(position=(0, 0, 0, *START), velocity=(1.0, -2.0, 0.5, *SPIN))
    bodies = (replace(body, **changes),)
    return Scene("top", DURATION, bodies, solver=Solver(method, step), output={"step": 0.1})


def angular_momentum(run: xr.Dataset) -> np.ndarray:
    """R I R^T omega (nt, 3)."""
    R = np.array([rotation(a) for a in run.position.values[:, 0, 3:]])
    return np.einsum("tij,jk,tlk,tl->ti", R, INERTIA, R, run.velocity.values[:, 0, 3:])


def observed_order(error: Callable[[float], float], step: float) -> float:
    return float(np.log2(error(step) / error(step / 2)))


@pytest.mark.parametrize("method", list(ORDERS))
def test_energy_and_angular_momentum_are_conserved_at_the_order_of_the_method(method, figure):
    def momentum_error(step: float) -> float:
        momentum = angular_momentum(simulate(turning(step, method)))
        return float(np.abs(momentum - momentum[0]).max())

    def energy_error(step: float) -> float:
        return float(np.abs(simulate(turning(step, method)).energy_residual).max())

    for name, error in (("momentum", momentum_error), ("energy", energy_error)):
        order = observed_order(error, 0.025)
        figure(f"order of {name} by {method}", order)
        assert order >= ORDERS[method] - 0.2  # 0.2: steps that are not infinitely small


def test_rotation_by_eulers_equations(validated) -> None:
    """Against Euler's equations in the body frame, R' = R (omega x), by an 8th-order method."""
    R0, inverse = rotation(START), np.linalg.inv(INERTIA)

    def euler(t: float, state: np.ndarray) -> np.ndarray:
        R, w = state[:9].reshape(3, 3), state[9:]
        acceleration = inverse @ np.cross(INERTIA @ w, w)
        return np.concatenate([(R @ skew(w)).ravel(), acceleration])

    start = np.concatenate([R0.ravel(), R0.T @ SPIN])
    run = simulate(turning(0.005))
    exact = solve_ivp(
        euler, (0, DURATION), start, "DOP853", run.time.values, rtol=1e-12, atol=1e-13
    )
    R = np.array([rotation(a) for a in run.position.values[:, 0, 3:]])
    error = np.abs(R - exact.y[:9].T.reshape(-1, 3, 3)).max()
    claim, against = "body that tumbles freely over 12 rad", "Euler's equations by DOP853"
    # (h |omega|)^4 / 120 over 12 rad
    validated(Kind.INDEPENDENT, claim, against, error, 1e-9, Feature.ROTATIONS)
    drift = np.outer(run.time.values, [1.0, -2.0, 0.5])
    assert_allclose(run.position.values[:, 0, :3], drift, atol=1e-12)


class Hamilton:
    """Rotations of a body of which some angles are locked: a' = H^-1 p, p' = a'.dH/da.a' / 2.

    H = E^T R I R^T E over the free angles; its derivatives are by the complex step.
    """

    def __init__(self, free: tuple[int, ...]) -> None:
        self.free = np.array(free)

    def mass(self, angles: np.ndarray) -> np.ndarray:
        x, y, z = np.cos(angles), np.sin(angles), np.eye(3)
        body_map = np.array(  # R^T E by hand, since scipy's rotations are not complex
            [[z[0, 0], 0, -y[1]], [0, x[0], y[0] * x[1]], [0, -y[0], x[0] * x[1]]]
        )[:, self.free]
        return body_map.T @ INERTIA @ body_map

    def __call__(self, t: float, state: np.ndarray) -> np.ndarray:
        n = self.free.size
        angles = START.astype(complex)
        angles[self.free] = state[:n]
        rate = np.linalg.solve(self.mass(angles).real, state[n:])
        slope = np.zeros(n)
        for i, k in enumerate(self.free):
            shifted = angles + 1e-30j * (np.arange(3) == k)
            slope[i] = rate @ self.mass(shifted).imag @ rate / 2e-30
        return np.concatenate([rate, slope])


@pytest.mark.parametrize(
    "free",
    [(0,), (1,), (2,), (0, 1), (0, 2), (1, 2), (0, 1, 2)],
    ids=lambda f: "".join(map(str, f)),
)
def test_locked_angles(free: tuple[int, ...], figure) -> None:
    """Against Hamilton's equations: one, two or three free angles; the locked stay for ever."""
    locked = [k for k in range(3) if k not in free]
    speed = np.array([0.5, 0.2, 1.5]) * np.isin(range(3), free)
    dofs, rates = tuple(DOFS[3 + k] for k in free), rate_map(START) @ speed
    run = simulate(turning(0.01, dofs=dofs, velocity=(0, 0, 0, *rates)))
    equations = Hamilton(free)
    index = list(free)
    momentum = equations.mass(START) @ speed[index]
    start = np.concatenate([START[index], momentum])
    exact = solve_ivp(
        equations, (0, DURATION), start, "DOP853", run.time.values, rtol=1e-12, atol=1e-13
    )
    angles = run.position.values[:, 0, 3:]
    error = np.abs(angles[:, index] - exact.y[: len(free)].T).max()
    figure("error of the free angles", error)
    assert error <= 1e-8  # (h |omega|)^4 / 120 over 10 rad
    assert run.energy_residual_relative <= 1e-9
    assert np.all(angles[:, locked] == START[locked])
    assert np.all(run.position.values[:, 0, :3] == 0.0)


def swinging(size: float, kinematics: Kinematics) -> np.ndarray:
    """Positions (nt, 12) of two moored bodies, ``size`` apart at rest; contact is homogeneous."""
    stiffness = np.diag([9.0, 8.0, 30.0, 40.0, 50.0, 20.0])
    stiffness[1, 3] = stiffness[3, 1] = 4.0
    push = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [1.0, 2.0, -3.0, 1.0, 2.0, 0.5]])
    lower = dry_body(name="lower", velocity=tuple(size * np.array([1.0, 0.5, 0, 0.4, -0.3, 0.6])))
    upper = dry_body(name="upper", mass=3.0, position=tuple(size * np.array([0, 0, 1.0, 0, 0, 0])))
    corners = np.array([[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
    deck = Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), body="lower")
    law = StickSlip(static=0.3, kinetic=0.2, stiffness=100.0, damping=2.0, slip_damping=1.0)
    fender = Fender("upper", corners, deck, straight_curve(20.0, damping=1.0), law)
    forces = {
        "lower": LinearMooring("lower", stiffness, 0.1 * stiffness),
        "upper": LinearMooring("upper", stiffness),
        "push": AppliedForce("upper", (0.5, 0.2, 0.1), table([0.0, 2.0], size * push)),
        "fender": fender,
    }
    solver = Solver(step=0.01, kinematics=kinematics)
    scene = Scene(
        "swinging", 3.0, (lower, upper), forces=forces, solver=solver, output={"step": 0.1}
    )
    run = simulate(scene)
    assert len(np.unique(run.fender_mode)) == 3
    return run.position.values.reshape(-1, 12)


def test_linear_kinematics_is_the_limit_of_small_motions(figure) -> None:
    """The difference to exact kinematics is of second order in the size of the motion."""

    def difference(size: float) -> float:
        exact, linear = (swinging(size, k) for k in (Kinematics.EXACT, Kinematics.LINEAR))
        return float(np.abs(exact - linear).max())

    order = np.log2(difference(2e-3) / difference(1e-3))
    figure("order in the size of the motion", float(order))
    assert order == pytest.approx(2.0, abs=0.05)


def test_linear_kinematics_is_linear() -> None:
    small, large = (swinging(size, Kinematics.LINEAR) for size in (0.01, 0.1))
    assert_allclose(large, 10 * small, atol=1e-12)
