"""The force of the radiated waves by extra states, against quadrature, and by constant damping."""

import numpy as np
import pytest
from closed_forms import DECAY, FREQUENCY, kernel
from scipy.integrate import quad, solve_ivp

from hydrosim.water.radiation import FitReport, StateSpace, constant_damping, state_space_model
from hydrosim.water.radiation.memory import radiation_damping, radiation_states

SIZES = np.array([[2.0, -0.5, 0.0], [-0.5, 1.0, 0.0], [0.0, 0.0, 0.0]])  # of K between three DOFs
W = np.array([0.7, 1.1, 0.9])  # the velocities are sin(W t)
END = 12.0


def velocity(t: float) -> np.ndarray:
    return np.sin(W * t)


def exact_force(t: float) -> np.ndarray:
    """-int K(t - s) v(s) ds by adaptive quadrature, (3,)."""

    def scalar(u: float) -> float:
        return kernel(np.array([u]))[0, 0, 0]

    integral = [
        quad(lambda s, w=w: scalar(t - s) * np.sin(w * s), 0.0, t, epsabs=1e-11)[0] for w in W
    ]
    return -SIZES @ integral


def state_space() -> StateSpace:
    """Exact: K = SIZES (cos - a/b sin) exp(-a t) on DOFs 0 and 1, two states per input."""
    a, b = -DECAY, FREQUENCY
    return StateSpace(
        dofs=np.array([0, 1]),
        decay=np.array([a, a]),
        frequency=np.array([b, b]),
        # x1 = exp(a t) cos b t and x2 = -exp(a t) sin b t for an impulse on the first state
        B=np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [0.0, 0.0]]),
        C=np.hstack([SIZES[:2, :2], SIZES[:2, :2] * DECAY / FREQUENCY]),
        report=FitReport(0.0, 0.0, 0.0, 0.0, 0.0),
    )


def test_state_space_force_equals_quadrature():
    model = state_space_model([state_space()])

    def rate(t: float, x: np.ndarray) -> np.ndarray:
        dx = np.empty_like(x)
        radiation_states(x, velocity(t), model, dx, np.zeros(3))
        return dx

    x = solve_ivp(rate, (0.0, END), np.zeros(4), rtol=1e-10, atol=1e-12).y[:, -1]
    force = np.full(3, 5.0)
    radiation_states(x, velocity(END), model, np.empty(4), force)
    assert force - 5.0 == pytest.approx(exact_force(END), abs=1e-8)


def test_groups_act_on_their_own_degrees_of_freedom():
    rng = np.random.default_rng(5)
    groups = [state_space().on_dofs(np.array([6, 2])), state_space().on_dofs(np.array([1, 7]))]
    model = state_space_model(groups)
    x, v = rng.standard_normal(8), rng.standard_normal(9)
    dx, force = np.empty(8), np.zeros(9)
    radiation_states(x, v, model, dx, force)
    expected = np.zeros(9)
    for k, group in enumerate(groups):
        own = slice(4 * k, 4 * k + 4)
        assert dx[own] == pytest.approx(group.matrix @ x[own] + group.B @ v[group.dofs])
        expected[group.dofs] -= group.C @ x[own]
    assert force == pytest.approx(expected)


def test_constant_damping_is_a_matrix_product():
    B = np.array([[2.0, 0.0, -0.5], [0.0, 0.0, 0.0], [-0.5, 0.0, 3.0]])
    model, v, force = constant_damping(B), np.array([1.0, -2.0, 0.5]), np.full(3, 7.0)
    radiation_damping(v, model, force)
    assert force - 7.0 == pytest.approx(-B @ v)
    assert model.row.size == 4


def test_no_radiation_costs_no_states_and_no_force():
    model, no_damping = state_space_model([]), constant_damping(np.zeros((6, 6)))
    force = np.zeros(6)
    radiation_states(np.empty(0), np.ones(6), model, np.empty(0), force)
    radiation_damping(np.ones(6), no_damping, force)
    assert model.decay.size == 0
    assert no_damping.row.size == 0
    assert np.array_equal(force, np.zeros(6))
