"""The memory force: state space, direct convolution and quadrature must agree."""

from __future__ import annotations

import numpy as np
import pytest
from closed_forms import DECAY, FREQUENCY, kernel
from scipy.integrate import quad, solve_ivp

from hydrosim.radiation import (
    FitReport,
    StateSpace,
    convolution_model,
    state_space_model,
    velocity_history,
)
from hydrosim.radiation.memory import push, radiation_memory, radiation_states

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
        report=FitReport(0.0, 0.0, 0.0, 0.0),
    )


def table(step: float):
    time = step * np.arange(round(60.0 / step) + 1)
    return convolution_model(step, kernel(time) * SIZES)


def convolved(nodes: np.ndarray, t: float, model) -> np.ndarray:
    history, force = velocity_history(3, nodes.size), np.zeros(3)
    for node in nodes:
        push(history, node, velocity(node))
    radiation_memory(t, velocity(t), history, model, force)
    return force


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


def test_convolution_is_of_second_order_in_the_nodes():
    model, errors = table(0.001), []
    for step in (0.2, 0.1, 0.05):
        nodes = step * np.arange(round(END / step) + 1)
        errors.append(np.abs(convolved(nodes, END, model) - exact_force(END)).max())
    assert errors[0] < 0.02
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.1)


def test_convolution_is_of_second_order_in_the_table():
    nodes = np.linspace(0.0, END, 12001)
    errors = [
        np.abs(convolved(nodes, END, table(step)) - exact_force(END)).max()
        for step in (0.4, 0.2, 0.1)
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.1)


def test_convolution_at_a_stage_with_uneven_nodes():
    model, errors = table(0.001), []
    for count in (60, 120, 240):
        x = np.linspace(0.0, 1.0, count + 1)
        nodes = END * (x + 0.1 * np.sin(6.0 * x) * (1.0 - x))
        errors.append(np.abs(convolved(nodes[:-1], END - 0.01, model) - exact_force(END - 0.01)))
    order = np.log2(np.max(errors[0]) / np.max(errors[2])) / 2.0
    assert order == pytest.approx(2.0, abs=0.2)


def test_convolution_changes_nothing_and_repeats_itself():
    history, model = velocity_history(3, 50), table(0.05)
    for node in np.linspace(0.0, 5.0, 40):
        push(history, node, velocity(node))
    before = [array.copy() for array in history]
    results = []
    for t in (5.1, 5.2, 5.1):
        force = np.zeros(3)
        radiation_memory(t, velocity(t), history, model, force)
        results.append(force)
    assert np.array_equal(results[0], results[2])
    assert not np.array_equal(results[0], results[1])
    assert all(np.array_equal(a, b) for a, b in zip(before, history, strict=True))


def test_nodes_after_the_instant_are_not_felt():
    model = table(0.01)
    all_nodes, earlier = np.linspace(0.0, 6.0, 61), np.linspace(0.0, 5.0, 51)
    assert np.array_equal(convolved(all_nodes, 5.05, model), convolved(earlier, 5.05, model))


def test_constant_velocity_feels_the_whole_table_and_no_more():
    # trapezoids are exact for K linear and v constant, so the cut at the last lag, 1 s, must be too
    model = convolution_model(1.0, np.array([3.0, 1.0])[:, None, None])
    history, force = velocity_history(1, 100), np.zeros(1)
    for node in 0.3 * np.arange(40):
        push(history, node, np.ones(1))
    radiation_memory(11.83, np.ones(1), history, model, force)
    assert force[0] == pytest.approx(-2.0, abs=1e-12)


def test_ring_that_covers_the_memory_is_as_good_as_one_that_keeps_all():
    step, model = 0.1, convolution_model(0.1, kernel(0.1 * np.arange(31)) * SIZES)
    small, large = velocity_history(3, 34), velocity_history(3, 500)
    for node in step * np.arange(200):
        push(small, node, velocity(node))
        push(large, node, velocity(node))
    forces = np.zeros((2, 3))
    radiation_memory(19.97, velocity(19.97), small, model, forces[0])
    radiation_memory(19.97, velocity(19.97), large, model, forces[1])
    assert np.array_equal(forces[0], forces[1])
    assert np.abs(forces[0, :2]).min() > 0.01


def test_before_the_first_node_there_is_no_force():
    force = np.zeros(3)
    radiation_memory(1.0, velocity(1.0), velocity_history(3, 4), table(0.1), force)
    assert np.array_equal(force, np.zeros(3))


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


def test_no_radiation_costs_no_states_and_no_force():
    model, table_of_none = state_space_model([]), convolution_model(0.1, np.zeros((2, 6, 6)))
    force = np.zeros(6)
    radiation_states(np.empty(0), np.ones(6), model, np.empty(0), force)
    radiation_memory(3.0, np.ones(6), velocity_history(6, 1), table_of_none, force)
    assert model.decay.size == 0
    assert table_of_none.row.size == 0
    assert np.array_equal(force, np.zeros(6))
