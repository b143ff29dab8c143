"""Orders of the methods on textbook problems, order conditions, and the error of the cubic."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose

from hydrosim.integrate import methods
from hydrosim.report.evidence import Feature, Kind

# what dopri5's error is estimated with, a method of its own
PAIR = methods.DOPRI5.tableau
EMBEDDED = PAIR._replace(b=PAIR.b - PAIR.error, order=4)
METHODS = {
    **{
        method.name: method.tableau
        for method in (methods.RK2, methods.HEUN, methods.RK4, methods.DOPRI5)
    },
    "dopri5, embedded": EMBEDDED,
}
Slope = Callable[[float, np.ndarray], np.ndarray]

PROBLEMS: dict[str, tuple[Slope, Slope]] = {
    # name: right hand side, solution (t, y0)
    "decay": (lambda t, y: -y, lambda t, y0: y0 * np.exp(-t)),
    "oscillator": (
        lambda t, y: np.array([y[1], -y[0]]),
        lambda t, y0: np.array([[np.cos(t), np.sin(t)], [-np.sin(t), np.cos(t)]]) @ y0,
    ),
    "logistic": (lambda t, y: y * (1 - y), lambda t, y0: y0 / (y0 + (1 - y0) * np.exp(-t))),
    "in time": (lambda t, y: y * np.cos(t), lambda t, y0: y0 * np.exp(np.sin(t))),
    "quadrature": (lambda t, y: np.exp(t) + 0 * y, lambda t, y0: y0 + np.exp(t) - 1),
}
START = np.array([0.7, 0.2])
END = 2.0


def integrate(method: methods.Tableau, f: Slope, steps: int) -> np.ndarray:
    """y(END) by equal steps, with the package's stages and this loop."""
    h, y, end, stage = END / steps, START.copy(), np.zeros(2), np.zeros(2)
    k = np.zeros((method.b.size, 2))
    for n in range(steps):
        t = n * h
        k[0] = f(t, y)
        for i in range(1, method.c.size):
            methods.stage_state(i, method, h, y, k, stage)
            k[i] = f(t + method.c[i] * h, stage)
        methods.advance_state(method, h, y, k, end)
        y[:] = end
    return y


@pytest.mark.parametrize("problem", PROBLEMS)
@pytest.mark.parametrize("name", METHODS)
def test_order_on_textbook_problems(name, problem, validated):
    """From three steps: an error C h^p (1 + c h + ...) is seen with order p + c h / (2 ln 2), half
    as far from p at half the step, so that twice the finer order less the coarser is h^2 from p.
    dopri5, whose C is small, has c up to 2; its finest error, 3e-12, is far above rounding."""
    method, (f, solution) = METHODS[name], PROBLEMS[problem]
    error = [np.abs(integrate(method, f, n) - solution(END, START)).max() for n in (10, 20, 40)]
    coarse, fine = (float(np.log2(e / half)) for e, half in pairwise(error))
    error = abs(2 * fine - coarse - method.order)
    claim = "order of rk2, heun, rk4 and dopri5 on problems of textbooks [orders]"
    validated(Kind.CLOSED_FORM, claim, "order of the tableau", error, 0.1, Feature.STEPS)


def conditions(m: methods.Tableau) -> list[tuple[int, float, float]]:
    """Order, sum, wanted value: all trees to five nodes (Hairer et al. 1993, table II.2.1)."""
    A, b, c = m.a, m.b, m.c
    return [
        (1, b.sum(), 1),
        (2, b @ c, 1 / 2),
        (3, b @ c**2, 1 / 3),
        (3, b @ A @ c, 1 / 6),
        (4, b @ c**3, 1 / 4),
        (4, b @ (c * (A @ c)), 1 / 8),
        (4, b @ A @ c**2, 1 / 12),
        (4, b @ A @ A @ c, 1 / 24),
        (5, b @ c**4, 1 / 5),
        (5, b @ (c**2 * (A @ c)), 1 / 10),
        (5, b @ (c * (A @ c**2)), 1 / 15),
        (5, b @ (c * (A @ A @ c)), 1 / 30),
        (5, b @ (A @ c) ** 2, 1 / 20),
        (5, b @ A @ c**3, 1 / 20),
        (5, b @ A @ (c * (A @ c)), 1 / 40),
        (5, b @ A @ A @ c**2, 1 / 60),
        (5, b @ A @ A @ A @ c, 1 / 120),
    ]


def order_fulfilled(method: methods.Tableau) -> int:
    """The largest order, up to five, whose conditions and those of all lower orders hold."""
    orders = conditions(method)
    broken = [p for p, found, wanted in orders if not np.isclose(found, wanted, rtol=1e-14)]
    return min(broken, default=6) - 1


@pytest.mark.parametrize("name", METHODS)
def test_order_conditions(name: str) -> None:
    assert order_fulfilled(METHODS[name]) == METHODS[name].order


@pytest.mark.parametrize("name", METHODS)
def test_methods_are_explicit_and_consistent(name: str) -> None:
    method = METHODS[name]
    assert np.all(np.triu(method.a) == 0.0)
    assert_allclose(method.c, method.a.sum(axis=1))


def cubic(f: Callable[[float], float], slope: Callable[[float], float], h: float) -> np.ndarray:
    """Values on the cubic through both ends of [0, h] at 101 places."""
    ends = [np.array([g(t)]) for t in (0.0, h) for g in (f, slope)]
    out, values = np.zeros(1), []
    for theta in np.linspace(0.0, 1.0, 101):
        methods.hermite(theta, h, *ends, out)
        values.append(out[0])
    return np.array(values)


def test_cubic_is_exact_for_cubics() -> None:
    h = 0.8
    t = h * np.linspace(0.0, 1.0, 101)
    values = cubic(lambda t: 2 - t + 3 * t**2 - 5 * t**3, lambda t: -1 + 6 * t - 15 * t**2, h)
    assert_allclose(values, 2 - t + 3 * t**2 - 5 * t**3, rtol=1e-13)


def test_error_of_the_cubic() -> None:
    """h^4/384 y'''' in the middle, where it is largest, and so exactly for a quartic."""
    h = 0.8
    t = h * np.linspace(0.0, 1.0, 101)
    error = t**4 - cubic(lambda t: t**4, lambda t: 4 * t**3, h)
    assert np.abs(error).argmax() == 50
    assert error[50] == pytest.approx(24 * h**4 / 384, rel=1e-12)
    for h in (0.4, 0.2, 0.1):
        t = h * np.linspace(0.0, 1.0, 101)
        ends = cubic(lambda t: np.sin(2 * t), lambda t: 2 * np.cos(2 * t), h)
        error = np.abs(np.sin(2 * t) - ends)
        assert error.max() <= (2 * h) ** 4 / 384 * np.sin(2 * h)


def test_the_cubic_leaves_alone_what_is_constant() -> None:
    """To the last bit, as what is made for the times of a state is made again if that changes."""
    y = np.random.default_rng(3).normal(scale=1e3, size=1000)
    still, out = np.zeros(1000), np.ones(1000)
    for theta in np.linspace(0.0, 1.0, 17):
        methods.hermite(theta, 0.1, y, still, y, still, out)
        assert np.array_equal(out, y)
