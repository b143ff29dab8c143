"""The memory integral over nodes and stages, against quadrature, and its fast sums."""

from __future__ import annotations

import numpy as np
import pytest
from closed_forms import kernel
from numpy.polynomial.legendre import leggauss

from hydrosim.radiation import ConvolutionKernel, VelocityHistory, convolution_model, history_for
from hydrosim.radiation.convolution import radiation_memory
from hydrosim.radiation.history import push

SIZES = np.array([[2.0, -0.5, 0.0], [-0.5, 1.0, 0.0], [0.0, 0.0, 0.0]])  # of K between three DOFs
W = np.array([0.7, 1.1, 0.9])  # the velocities are sin(W t)
END = 12.0
POINTS, WEIGHTS = leggauss(12)


def velocity(t):
    return np.sin(W * np.asarray(t)[..., None])


def acceleration(t):
    return W * np.cos(W * np.asarray(t)[..., None])


def table(step: float, length: float = 60.0, **fast) -> ConvolutionKernel:
    time = step * np.arange(round(length / step) + 1)
    return convolution_model(step, kernel(time) * SIZES, **fast)


def exact_force(t: float, model: ConvolutionKernel, motion=velocity, corners=(0.0,)) -> np.ndarray:
    """-int K(t - s) v(s) ds (3,) with the table's K, linear between its lags: by quadrature that is
    exact to rounding on every cell, split at the ``corners`` of the motion."""
    lags = np.append(model.step * np.arange(len(model.K)), t - np.array(corners))
    edges = np.unique(np.clip(lags, 0.0, min(t, lags[: len(model.K)].max())))
    middle, half = 0.5 * (edges[1:] + edges[:-1])[:, None], 0.5 * np.diff(edges)[:, None]
    lag, weight = (middle + half * POINTS).ravel(), (half * WEIGHTS).ravel()
    force = np.zeros(3)
    for e, (i, j) in enumerate(zip(model.row, model.column, strict=True)):
        K = np.interp(lag, lags[: len(model.K)], model.K[:, e])
        force[i] -= weight @ (K * motion(t - lag)[:, j])
    return force


def filled(nodes, model: ConvolutionKernel, capacity: int = 0) -> VelocityHistory:
    history = history_for(model, 3, capacity or len(nodes))
    for t in nodes:
        push(history, t, velocity(t), acceleration(t))
    return history


def convolved(t: float, history: VelocityHistory, model: ConvolutionKernel, v=None) -> np.ndarray:
    force = np.zeros(3)
    radiation_memory(t, velocity(t) if v is None else v, history, model, force)
    return force


@pytest.mark.parametrize("table_step", [0.05, 0.3, 0.7])
def test_order_4_in_the_nodes_whatever_the_table(table_step):
    """In the last step, where a parabola ends in the velocity at that time, the integral errs by
    K(0) v''' h^4 / 72 at most: 1e-3 at 0.4 s."""
    model, errors = table(table_step), []
    for step in (0.4, 0.2, 0.1):
        nodes = step * np.arange(round(END / step) + 1)
        history = filled(nodes, model)
        errors.append(np.abs(convolved(END, history, model) - exact_force(END, model)).max())
    assert errors[0] < 1e-3
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.25)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(4.0, abs=0.25)


def test_order_4_at_stages_with_uneven_nodes():
    model, errors = table(0.1), []
    for count in (30, 60, 120):
        x = np.linspace(0.0, 1.0, count + 1)
        nodes = END * (x + 0.1 * np.sin(6.0 * x) * (1.0 - x))
        history, step = filled(nodes, model), END / count
        times = [END + part * step for part in (0.2, 0.5, 1.0)]
        errors.append(
            max(np.abs(convolved(t, history, model) - exact_force(t, model)).max() for t in times)
        )
    order = np.log2(errors[0] / errors[2]) / 2.0
    assert order == pytest.approx(4.0, abs=0.3)


def test_order_4_through_a_jump_of_the_acceleration():
    """v = |sin W t| for the first DOF: two nodes with the same velocity at its corner, between
    those of the grid."""
    corner = np.pi / W[0]

    def bounced(t):
        return np.where(np.arange(3) == 0, np.abs(velocity(t)), velocity(t))

    errors = []
    for step in (0.4, 0.2, 0.1):
        model = table(0.1, even_step=step, stages=(0.5,))
        history = history_for(model, 3, 500)
        grid = step * np.arange(round(8.4 / step) + 1)
        for t in (*grid[grid < corner], corner):
            push(history, t, bounced(t), acceleration(t))
        for t in (corner, *grid[grid > corner]):
            push(history, t, bounced(t), np.array([-1.0, 1.0, 1.0]) * acceleration(t))
        expected = exact_force(8.4, model, bounced, (0.0, corner))
        found = convolved(8.4, history, model, bounced(8.4))
        errors.append(np.abs(found - expected).max())
    assert np.log2(errors[0] / errors[2]) / 2.0 == pytest.approx(4.0, abs=0.3)


@pytest.mark.parametrize("length", [2.95, 5.0, 60.0])
@pytest.mark.parametrize("table_step", [0.05, 0.1, 0.13])
def test_fast_sums_equal_the_plain_integral(length, table_step):
    """At stages on the grid of nodes, off it, with nodes in between, two at one time, a memory that
    is longer and one that is shorter than the history, and a ring that goes round."""
    step, rng = 0.1, np.random.default_rng(4)
    fast = table(table_step, length, even_step=step, stages=(0.0, 0.5, 1.0))
    plain = table(table_step, length)
    capacity = 200 if length < 10.0 else 500  # else the memory is cut, as either way has it
    histories = [history_for(model, 3, capacity) for model in (fast, plain)]
    largest = 0.0
    for n in range(300):
        t = n * step
        between = t + step * np.sort(rng.random(3)) if n % 7 == 3 else []
        for node in [t, *([t] if n % 11 == 5 else []), *between]:
            v, a = rng.standard_normal((2, 3))
            for history in histories:
                push(history, node, v, a)
        v = rng.standard_normal(3)
        for part in (0.0, 0.5, 1.0, 0.7):
            both = [
                convolved(t + part * step, h, model, v)
                for h, model in zip(histories, (fast, plain), strict=True)
            ]
            largest = max(largest, np.abs(both[0] - both[1]).max())
            assert both[0] == pytest.approx(both[1], abs=1e-12)
    assert histories[0].even.place[1] >= min(fast.weight.shape[-1], 290)
    assert largest > 0.0  # they are two ways


def test_another_grid_is_found_after_a_break():
    """Nodes of another run, with other steps, before those of this one."""
    fast, plain = table(0.1, 20.0, even_step=0.2, stages=(0.5,)), table(0.1, 20.0)
    nodes = np.append(0.07 * np.arange(100), 7.0 + 0.2 * np.arange(40))
    histories = filled(nodes, fast), filled(nodes, plain)
    assert histories[0].even.place[1] >= 38
    for t in (14.85, 14.9, 15.0):
        found, expected = convolved(t, histories[0], fast), convolved(t, histories[1], plain)
        assert found == pytest.approx(expected, abs=1e-13)


def test_it_repeats_itself_in_any_order_and_keeps_its_nodes():
    model = table(0.05, even_step=0.125, stages=(0.5, 1.0))
    nodes = 0.125 * np.arange(41)
    history, fresh = filled(nodes, model), filled(nodes, model)
    before = [array.copy() for array in (history.time, history.velocity, history.acceleration)]
    times = (5.0625, 5.125, 5.0, 5.1, 5.0625, 5.1, 5.0)
    results = [convolved(t, history, model) for t in times]
    assert all(np.array_equal(results[i], results[j]) for i, j in ((0, 4), (2, 6), (3, 5)))
    assert not np.array_equal(results[0], results[1])
    assert all(
        np.array_equal(convolved(t, fresh, model), result)
        for t, result in reversed(list(zip(times, results, strict=True)))
    )
    after = (history.time, history.velocity, history.acceleration)
    assert all(np.array_equal(a, b) for a, b in zip(before, after, strict=True))


def test_nodes_from_the_instant_on_are_not_felt():
    model = table(0.01)
    later, earlier = (
        filled(np.linspace(0.0, 6.0, 61), model),
        filled(np.linspace(0.0, 5.0, 51), model),
    )
    for t in (5.05, 5.1):
        assert np.array_equal(convolved(t, later, model), convolved(t, earlier, model))


def test_constant_velocity_feels_the_whole_table_and_no_more():
    model = convolution_model(1.0, np.array([3.0, 1.0])[:, None, None])
    history, force = history_for(model, 1, 100), np.zeros(1)
    for node in 0.3 * np.arange(40):
        push(history, node, np.ones(1), np.zeros(1))
    radiation_memory(11.83, np.ones(1), history, model, force)
    assert force[0] == pytest.approx(-2.0, abs=1e-12)


def test_ring_that_covers_the_memory_is_as_good_as_one_that_keeps_all():
    model = table(0.1, 3.0)
    nodes = 0.1 * np.arange(200)
    small, large = filled(nodes, model, 34), filled(nodes, model, 500)
    forces = [convolved(19.97, history, model) for history in (small, large)]
    assert np.array_equal(forces[0], forces[1])
    assert np.abs(forces[0][:2]).min() > 0.01


def test_before_the_first_node_there_is_no_force():
    model = table(0.1)
    assert np.array_equal(convolved(1.0, history_for(model, 3, 4), model), np.zeros(3))


def test_without_radiation_nothing_is_kept_and_there_is_no_force():
    model = convolution_model(0.1, np.zeros((2, 3, 3)), even_step=0.1, stages=(0.5,))
    assert model.row.size == 0
    assert history_for(model, 3, 100).time.size == 0
    assert np.array_equal(convolved(3.0, history_for(model, 3, 100), model), np.zeros(3))
