"""The implicit method on textbook problems: order conditions, stability, stiffness, factors."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from test_runge_kutta import order_fulfilled

from hydrosim.integrate import methods

PAIR = methods.ESDIRK4.tableau
Slope = Callable[[float, np.ndarray], np.ndarray]


def integrate(
    f: Slope,
    J: np.ndarray,
    start: np.ndarray,
    end: float,
    steps: int,
    tolerance: float = 1e-10,
    filters: methods.Filters = methods.NO_FILTERS,
) -> np.ndarray:
    """y(end) by equal steps; the package's stages and iterations with a constant Jacobian."""
    h, y, method = end / steps, start.astype(float).copy(), PAIR
    together = np.setdiff1d(np.arange(y.size), np.concatenate([filters.one, filters.other]))
    newton = methods.new_newton(together, y.size, filters)
    control = methods.Control(False, tolerance, tolerance)
    control = control._replace(absolute=np.full(y.size, tolerance))
    newton.J[:] = J[np.ix_(together, together)]
    k, stage, after = np.zeros((method.b.size, y.size)), np.zeros(y.size), np.zeros(y.size)
    for n in range(steps):
        t = n * h
        k[0] = f(t, y)
        for i in range(1, method.c.size):
            methods.stage_state(i, method, h, y, k, stage)
            weight, at = h * method.a[i, i], t + method.c[i] * h
            methods.factorise_iteration_matrix(weight, newton)
            k[i] = k[i - 1]
            for _ in range(methods.MAX_ITERATIONS):
                slope = f(at, stage + weight * k[i])
                if methods.newton_iteration(k[i], slope, y, weight, newton, control) <= 1.0:
                    break
            else:
                pytest.fail("Newton's method does not converge")
        methods.advance_state(method, h, y, k, after)
        y[:] = after
    return y


def test_order_conditions() -> None:
    embedded = PAIR._replace(b=PAIR.b - PAIR.error)
    assert order_fulfilled(PAIR) == 4
    assert order_fulfilled(embedded) == 3
    assert_allclose(PAIR.c, PAIR.a.sum(axis=1))
    # stages of order 2 (from the second on), the last one is the end of the step
    assert_allclose((PAIR.a @ PAIR.c)[1:], PAIR.c[1:] ** 2 / 2, rtol=1e-13)
    assert_allclose(PAIR.a[-1], PAIR.b)


def test_stable_in_the_left_half_plane_and_damping_at_infinity() -> None:
    edge = 1j * np.concatenate([np.linspace(1e-3, 50.0, 20001), np.logspace(2, 8, 200)])
    assert np.abs(methods.ESDIRK4.stability(edge)).max() <= 1.0 + 1e-12  # A-stable: no poles left
    assert np.abs(methods.ESDIRK4.stability(np.array([-1e8, 1e8j]))).max() < 1e-6
    # and what a step really makes of y' = lambda y
    for z in (-0.3, -7.0, -200.0):
        y = integrate(lambda t, y, z=z: z * y, np.array([[z]]), np.ones(1), 1.0, 1)
        assert y[0] == pytest.approx(methods.ESDIRK4.stability(np.array([z]))[0], abs=1e-9)


@pytest.mark.parametrize("rate", [1.0, 1e3])
def test_order_on_a_rotating_decay(rate: float, figure) -> None:
    A = np.array([[-rate, 1.0], [-1.0, -0.5]])
    vectors = np.linalg.eig(A)
    start = np.array([1.0 / rate, 1.0])
    exact = (vectors[1] * np.exp(2.0 * vectors[0])) @ np.linalg.solve(vectors[1], start)
    steps = np.array([20, 40, 80])
    found = [integrate(lambda t, y: A @ y, A, start, 2.0, n, 1e-12) for n in steps]
    error = np.array([np.abs(y - exact.real).max() for y in found])
    orders = np.log2(error[:-1] / error[1:])
    figure(f"order at rate {rate:g}", orders[-1])
    assert orders[-1] == pytest.approx(4.0, abs=0.25)


@pytest.mark.parametrize("rate", [1e4, 1e8])
def test_a_stiff_slave_follows(rate: float, figure) -> None:
    """Prothero and Robinson's problem: the error falls with the step however stiff it is."""
    J = np.array([[-rate]])

    def f(t: float, y: np.ndarray) -> np.ndarray:
        return -rate * (y - np.sin(t)) + np.cos(t)

    error = [abs(integrate(f, J, np.zeros(1), 3.0, n)[0] - np.sin(3.0)) for n in (15, 30, 60)]
    figure(f"error at rate {rate:g}", error[-1])
    assert error[0] < 1e-4
    assert error[2] < error[0] / 8  # between the orders 2 of the stages and 4 of the method


def test_a_nonlinear_stiff_problem_against_scipy(figure) -> None:
    """Robertson's reactions, with a Jacobian of the wrong place: only the solution counts."""

    def f(t: float, y: np.ndarray) -> np.ndarray:
        a, b = -0.04 * y[0] + 1e4 * y[1] * y[2], 3e7 * y[1] ** 2
        return np.array([a, -a - b, b])

    J = np.array([[-0.04, 0.0, 0.3], [0.04, -2.2e3, -0.3], [0.0, 2.2e3, 0.0]])
    start = np.array([1.0, 3.6e-5, 0.0])
    exact = solve_ivp(f, (0, 0.4), start, "Radau", rtol=1e-11, atol=1e-14).y[:, -1]
    error = np.abs(integrate(f, J, start, 0.4, 40, 1e-10) - exact).max()
    figure("error", error)
    assert error < 1e-7


def test_factors_solve_what_lapack_solves() -> None:
    rng = np.random.default_rng(3)
    for n in (1, 2, 7, 30):
        A, b = rng.normal(size=(n, n)), rng.normal(size=n)
        A[0, 0] = 0.0 if n > 1 else A[0, 0]
        wanted = np.linalg.solve(A, b)
        order = np.zeros(n, dtype=np.int64)
        methods.factorise(A, order)
        methods.solve(A, order, b)
        assert_allclose(b, wanted, rtol=1e-9, atol=1e-12)


def test_filters_by_themselves_are_filters_solved_together(figure) -> None:
    """A velocity that drives a pair and a fast pole, and feels both: the stages are the same."""
    A = np.array(
        [
            [-0.1, -0.5, 0.2, -30.0],
            [0.3, -0.4, 2.0, 0.0],
            [-0.1, -2.0, -0.4, 0.0],
            [0.5, 0.0, 0.0, -300.0],
        ]
    )
    entries = np.array([1, 3]), np.array([2, 3])
    filters = methods.Filters(*entries, np.array([-0.4, -300.0]), np.array([2.0, 0.0]))
    start = np.array([1.0, 0.2, -0.3, 0.0])
    whole = integrate(lambda t, y: A @ y, A, start, 3.0, 30)
    apart = integrate(lambda t, y: A @ y, A, start, 3.0, 30, filters=filters)
    figure("difference", np.abs(whole - apart).max())
    assert_allclose(apart, whole, rtol=0.0, atol=1e-12)
