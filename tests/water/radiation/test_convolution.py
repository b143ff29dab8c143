"""The memory integral over nodes and stages, against quadrature."""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
from closed_forms import kernel
from markers import few
from numpy.polynomial.legendre import leggauss

from hydrosim.water.radiation import (
    ConvolutionKernel,
    VelocityHistory,
    convolution,
    convolution_model,
    new_history,
)
from hydrosim.water.radiation.convolution import (
    find_bit_reversal,
    radiation_memory,
    roots_of_unity,
    transform,
    untransform,
)
from hydrosim.water.radiation.history import append_node, recount_integrals, remove_newest_node

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


def filled(nodes, model: ConvolutionKernel) -> VelocityHistory:
    history = new_history(model, 3, 1.0)
    for t in nodes:
        append_node(history, t, velocity(t), acceleration(t))
    return history


def convolved(t: float, history: VelocityHistory, model: ConvolutionKernel, v=None) -> np.ndarray:
    force = np.zeros(3)
    radiation_memory(t, velocity(t) if v is None else v, history, model, force)
    return force


@pytest.mark.parametrize("table_step", [0.05, 0.1, 0.3])
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
        model = table(0.1)
        history = new_history(model, 3, step)
        grid = step * np.arange(round(8.4 / step) + 1)
        for t in (*grid[grid < corner], corner):
            append_node(history, t, bounced(t), acceleration(t))
        for t in (corner, *grid[grid > corner]):
            append_node(history, t, bounced(t), np.array([-1.0, 1.0, 1.0]) * acceleration(t))
        expected = exact_force(8.4, model, bounced, (0.0, corner))
        found = convolved(8.4, history, model, bounced(8.4))
        errors.append(np.abs(found - expected).max())
    assert np.log2(errors[0] / errors[2]) / 2.0 == pytest.approx(4.0, abs=0.3)


class Piece(NamedTuple):
    """A polynomial for the velocities (3, powers) of the time since ``begin``."""

    begin: float
    end: float
    powers: np.ndarray

    def force(self, t: float, model: ConvolutionKernel) -> np.ndarray:
        """-int K(t - s) v(s) ds over the piece, by quadrature from lag to lag of the table."""
        lags = model.step * np.arange(len(model.K))
        edges = np.concatenate([t - lags, [self.begin, self.end]])
        edges = np.unique(np.clip(edges, max(self.begin, t - lags[-1]), self.end))
        middle, half = 0.5 * (edges[1:] + edges[:-1])[:, None], 0.5 * np.diff(edges)[:, None]
        time, weight = (middle + half * POINTS).ravel(), (half * WEIGHTS).ravel()
        v = self.powers @ (time - self.begin) ** np.arange(self.powers.shape[1])[:, None]
        force = np.zeros(3)
        for e, (i, j) in enumerate(zip(model.row, model.column, strict=True)):
            force[i] -= weight @ (np.interp(t - time, lags, model.K[:, e]) * v[j])
        return force


def cubic(t0: float, v0, a0, t1: float, v1, a1) -> Piece:
    h = t1 - t0
    rise = (v1 - v0) / h
    second, third = (3.0 * rise - 2.0 * a0 - a1) / h, (a0 + a1 - 2.0 * rise) / h**2
    return Piece(t0, t1, np.stack([v0, a0, second, third], axis=1))


def parabola(t0: float, v0, a0, t1: float, v1) -> Piece:
    h = t1 - t0
    return Piece(t0, t1, np.stack([v0, a0, (v1 - v0 - h * a0) / h**2], axis=1))


@pytest.mark.parametrize("length", few([0.3, 2.9, 60.0], 2))
@pytest.mark.parametrize("factor", [1, 2, 7])
@pytest.mark.slow
def test_exact_for_steps_of_one_or_several_intervals(length, factor):
    """Cubics from node to node, jumps of velocity and acceleration at nodes, and a parabola to a
    stage: all of it is integrated to rounding, however long the run is."""
    model, rng = table(0.1, length), np.random.default_rng(factor)
    step, pieces, largest = 0.1 * factor, [], 0.0
    history = new_history(model, 3, step)
    v, a = rng.standard_normal((2, 3))
    append_node(history, 0.0, v, a)
    for n in range(1, 260):
        t, before, v, a = (n - 1) * step, (v, a), *rng.standard_normal((2, 3))
        for part in (0.25, 0.5, 1.0):
            now = t + part * step
            expected = parabola(t, *before, now, v).force(now, model)
            expected += sum(p.force(now, model) for p in pieces if p.end > now - length)
            found = convolved(now, history, model, v)
            largest = max(largest, np.abs(expected).max())
            assert found == pytest.approx(expected, abs=1e-11)
        pieces.append(cubic(t, *before, t + step, v, a))
        append_node(history, t + step, v, a)
        assert np.array_equal(convolved(t + step, history, model, v), found)
        recount_integrals(history)
        assert convolved(t + step, history, model, v) == pytest.approx(found, abs=1e-11)
        if n % 5 == 2:
            v, a = rng.standard_normal((2, 3))
            append_node(history, t + step, v, a)
    assert largest > 0.1
    assert length > 10.0 or history.place[3] > 0


def test_what_happens_between_the_points_of_the_grid_is_felt_as_it_should():
    """Where K is straight, displacement and first moment are all that counts, of short steps, too;
    jumps included."""
    model = convolution_model(0.5, (np.linspace(3.0, 0.0, 41)[:, None, None]) * SIZES)
    history, rng, pieces = new_history(model, 3, 0.5), np.random.default_rng(1), []
    times = np.sort(np.append(10.0 * rng.random(120), 0.5 * np.arange(21)))
    v, a = rng.standard_normal((2, 3))
    append_node(history, 0.0, v, a)
    for t0, t1 in pairwise(times):
        before, v, a = (v, a), *rng.standard_normal((2, 3))
        pieces.append(cubic(t0, *before, t1, v, a))
        append_node(history, t1, v, a)
        if rng.random() < 0.2:
            v, a = rng.standard_normal((2, 3))
            append_node(history, t1, v, a)
    for t in (10.1, 10.5, 11.3):
        end = rng.standard_normal(3)
        expected = parabola(10.0, v, a, t, end).force(t, model)
        expected += sum(p.force(t, model) for p in pieces)
        assert convolved(t, history, model, end) == pytest.approx(expected, abs=1e-11)


def test_a_node_that_is_taken_away_was_never_there():
    model, rng = table(0.1, 5.0), np.random.default_rng(2)
    nodes = np.cumsum(rng.random(80) * 0.2)
    whole, other = filled(nodes, model), filled(nodes, model)
    assert not remove_newest_node(float(nodes[-1]) - 0.01, other)
    assert remove_newest_node(float(nodes[-1]), other)
    append_node(other, nodes[-1], velocity(nodes[-1]), acceleration(nodes[-1]))
    for t in nodes[-1] + np.array([0.03, 0.4]):
        assert np.array_equal(convolved(t, whole, model), convolved(t, other, model))


@pytest.mark.slow
def test_a_drift_does_not_cost_digits():
    """Integrals of a steady velocity grow with time and its square, 4e7 here; the force is
    -v int K, and at most 10 on the way."""
    model = table(0.1, 40.0)
    history, v, none = new_history(model, 3, 0.1), np.array([5.0, 0.0, 0.0]), np.zeros(3)
    for n in range(40000):
        append_node(history, 0.1 * n, v, none)
        recount_integrals(history)
    weight = np.full(len(model.K), 0.1)
    weight[[0, -1]] = 0.05
    expected = -5.0 * weight @ model.K[:, (model.row == 0) & (model.column == 0)][:, 0]
    assert convolved(4000.0, history, model, v)[0] == pytest.approx(expected, abs=1e-10)


def test_it_repeats_itself_in_any_order_and_keeps_its_nodes():
    model = table(0.05)
    nodes = 0.125 * np.arange(41)
    history, fresh = filled(nodes, model), filled(nodes, model)
    before = [array.copy() for array in (history.time, history.grid, history.node)]
    times = (5.0625, 5.125, 5.0, 5.1, 5.0625, 5.1, 5.0)
    results = [convolved(t, history, model) for t in times]
    assert all(np.array_equal(results[i], results[j]) for i, j in ((0, 4), (2, 6), (3, 5)))
    assert not np.array_equal(results[0], results[1])
    assert all(
        np.array_equal(convolved(t, fresh, model), result)
        for t, result in reversed(list(zip(times, results, strict=True)))
    )
    after = (history.time, history.grid, history.node)
    assert all(np.array_equal(a, b) for a, b in zip(before, after, strict=True))


def test_a_node_at_the_instant_or_later_is_not_felt():
    model = table(0.01)
    later, earlier = (filled(0.1 * np.arange(count), model) for count in (52, 51))
    for t in (5.05, 5.1):
        assert np.array_equal(convolved(t, later, model), convolved(t, earlier, model))


def test_constant_velocity_feels_the_whole_table_and_no_more():
    model = convolution_model(1.0, np.array([3.0, 1.0])[:, None, None])
    history, force = new_history(model, 1, 0.3), np.zeros(1)
    for node in 0.3 * np.arange(40):
        append_node(history, node, np.ones(1), np.zeros(1))
    radiation_memory(11.83, np.ones(1), history, model, force)
    assert force[0] == pytest.approx(-2.0, abs=1e-12)


def test_before_the_first_node_there_is_no_force():
    model = table(0.1)
    assert np.array_equal(convolved(1.0, new_history(model, 3, 4), model), np.zeros(3))


def test_without_radiation_nothing_is_kept_and_there_is_no_force():
    model = convolution_model(0.1, np.zeros((2, 3, 3)))
    assert model.row.size == 0
    history = new_history(model, 3, 1.0)
    assert history.grid.size == 0
    assert np.array_equal(convolved(3.0, history, model), np.zeros(3))


def test_blocks_add_what_their_points_add(monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps of a tenth of an interval to two blocks at once, a jump, nodes that are taken away, and
    integrals counted anew: sums by blocks and by points alone agree to rounding."""
    blocks = table(0.1, 50.0)
    assert len(blocks.spectrum) >= convolution.FEWEST_BLOCKS
    monkeypatch.setattr(convolution, "FEWEST_BLOCKS", math.inf)
    points = table(0.1, 50.0)
    assert not len(points.spectrum)
    block = blocks.turns.size
    rng = np.random.default_rng(4)
    lengths = np.concatenate(
        [np.full(700, 0.1), 0.3 * rng.random(400), [9.0, 4.0], np.full(90, 0.7)]
    )
    assert lengths.max() > 2 * 0.1 * block
    histories = [new_history(model, 3, 9.0) for model in (blocks, points)]
    largest = 0.0
    for n, t in enumerate(np.cumsum(lengths)):
        for history in histories:
            append_node(history, t, velocity(t), acceleration(t))
            if n % 97 == 0:
                append_node(history, t, velocity(t) + 0.5, acceleration(t))
            if n % 101 == 0:
                remove_newest_node(t, history)
            recount_integrals(history)
        for ahead in (0.04, 0.1, 7.0):
            pair = zip(histories, (blocks, points), strict=True)
            one, other = (convolved(t + ahead, history, model) for history, model in pair)
            largest = max(largest, np.abs(other).max())
            assert one == pytest.approx(other, abs=1e-12 * largest)
    assert histories[0].place[3] > 0


def test_a_block_is_transformed_as_numpy_does() -> None:
    values = np.random.default_rng(5).random((2, 64)).T @ [1.0, 1j]
    turns = roots_of_unity(32)
    changed = values.copy()
    transform.py_func(changed, turns)
    assert changed == pytest.approx(np.fft.fft(values)[find_bit_reversal(64)], abs=1e-13)
    untransform.py_func(changed, turns)
    assert changed == pytest.approx(values, abs=1e-15)
