"""Runge-Kutta steps and the cubic interpolant of a step.

A method is a `Tableau`; a step of length h from (t, y) is

    Y_i = y + h sum_{j<i} a_ij k_j,   k_i = f(t + c_i h, Y_i + h a_ii k_i)
    y_new = y + h sum_i b_i k_i

where a_ii = 0 for explicit methods; otherwise `implicit` finds k_i.

The caller evaluates f, because kernels that take functions cannot be cached on disk. So the loop
over the stages stands beside the equation that it integrates (`hydrosim.integrate.step`, or a
test's own loop):

    for i in range(1, c.size):
        stage_state(i, tableau, h, y, k, Y)
        k[i] = f(t + c[i] * h, Y)
    advance_state(tableau, h, y, k, y_new)
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hydrosim.integrate.implicit import Filters, Newton, new_newton
from hydrosim.jit.kernels import assign, kernel

EXPLICIT, IMPLICIT = range(2)
"""Values of `Tableau.code`: how the stages are found."""


class Tableau(NamedTuple):
    """Butcher tableau: ``a`` (s, s) lower triangular with a_11 = 0, ``b``, ``c`` (s,).

    ``error`` (s,) holds the differences of ``b`` and the embedded weights, or zeros without an
    embedded method. ``code`` tells `hydrosim.integrate.step` how to find the stages. ``closes``
    is true for an explicit method whose last stage is the end of the step: its derivative begins
    the next step (Dormand & Prince 1980).
    """

    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    error: np.ndarray
    order: int
    code: int
    closes: bool


def tableau(
    a: list[list[float]], b: list[float], order: int, embedded: list[float] | None = None
) -> Tableau:
    """Tableau from the rows of ``a`` below the first; ``c`` are the row sums."""
    matrix = np.zeros((len(b), len(b)))
    for i, row in enumerate(a, start=1):
        matrix[i, : len(row)] = row
    weights = np.array(b)
    error = weights - (weights if embedded is None else np.array(embedded))
    code = IMPLICIT if np.diag(matrix).any() else EXPLICIT
    closes = code == EXPLICIT and np.array_equal(matrix[-1], weights)
    return Tableau(matrix, weights, matrix.sum(axis=1), error, order, code, closes)


@kernel
def stage_state(i, method, h, y, k, out):
    """State of stage ``i`` from the derivatives ``k`` (s, ny) of the stages before it."""
    _combine(method.a[i, :i], h, y, k, out)


@kernel
def advance_state(method, h, y, k, out):
    """State at the end of the step from all stage derivatives ``k`` (s, ny)."""
    _combine(method.b, h, y, k, out)


@kernel
def _combine(weights, h, y, k, out):
    """``out`` = y + h sum of the first rows of k by their ``weights``, in one pass for each."""
    begun = False
    for j in range(weights.size):
        weight = h * weights[j]
        if weight != 0.0:
            base = out if begun else y
            for m in range(y.size):
                out[m] = base[m] + weight * k[j, m]
            begun = True
    if not begun:
        assign(out, y)


@kernel
def hermite(theta, h, y0, f0, y1, f1, out):
    """Cubic through both ends of a step with their derivatives, at ``theta`` in [0, 1]. Its error
    is h^4/384 max |y''''| (Hairer, Norsett & Wanner 1993, II.6). A constant state stays constant to
    the last bit: tables are kept while the states that they depend on do not change."""
    c = theta - 1.0
    a = theta * theta * (3.0 - 2.0 * theta)
    b0 = h * theta * c * c
    b1 = h * theta * theta * c
    for m in range(y0.size):
        out[m] = y0[m] + a * (y1[m] - y0[m]) + b0 * f0[m] + b1 * f1[m]


# A method of time integration and its properties.
#
# Kernels receive its `Tableau`, arrays and numbers; all other code asks a `IntegrationMethod`. A
# method that needs more than a tableau, such as an exponential one, is a subclass.


@dataclass(frozen=True, eq=False)
class IntegrationMethod(ABC):
    """A method with its ``name`` and ``tableau``. ``why_any_step`` says why it is stable for any
    step; it is empty for methods with a limit."""

    name: str
    tableau: Tableau
    why_any_step: str

    @property
    def order(self) -> int:
        """Order of the error in the step."""
        return self.tableau.order

    @property
    def adapts(self) -> bool:
        """True if the method chooses its own steps by an embedded error."""
        return bool(self.tableau.error.any())

    @property
    def any_step(self) -> bool:
        """True if the method is stable for any step."""
        return bool(self.why_any_step)

    @abstractmethod
    def stability(self, z: np.ndarray) -> np.ndarray:
        """R(z), the factor by which one step h multiplies y for y' = lambda y with z = h lambda."""

    def new_newton(self, states: np.ndarray, filters: Filters, size: int) -> Newton:
        """Scratch for its steps with ``size`` states. The right hand side depends on ``states``
        (m,), which include the ``filters``."""
        if self.tableau.code != IMPLICIT:
            return new_newton(np.zeros(0, dtype=np.int64), size)
        together = np.setdiff1d(states, np.concatenate([filters.one, filters.other]))
        return new_newton(together, size, filters)


@dataclass(frozen=True, eq=False)
class RungeKutta(IntegrationMethod):
    """A method that its tableau defines. ``numerator`` and ``denominator`` are the coefficients of
    the polynomials in its `stability`, constants first."""

    numerator: np.ndarray
    denominator: np.ndarray

    def stability(self, z: np.ndarray) -> np.ndarray:
        """R(z) = det(I - z A + z 1 b^T) / det(I - z A) (Hairer & Wanner 1996, IV.3.5)."""
        above = np.polyval(self.numerator[::-1], z)
        return np.asarray(above / np.polyval(self.denominator[::-1], z))


def method_of(name: str, tableau: Tableau, why_any_step: str = "") -> IntegrationMethod:
    """The method of a ``tableau``."""
    a = tableau.a
    b = tableau.b
    numerator = np.poly(a - np.outer(np.ones(b.size), b))
    denominator = np.trim_zeros(np.poly(a), "b")  # 1 for an explicit method
    return RungeKutta(name, tableau, why_any_step, numerator, denominator)


# Midpoint rule, order 2 (Runge 1895): the reference method of the founding study.

RK2 = method_of("rk2", tableau([[1 / 2]], [0.0, 1.0], order=2))


# Heun's method (explicit trapezoid), order 2 (Heun 1900).

HEUN = method_of("heun", tableau([[1.0]], [1 / 2, 1 / 2], order=2))


# The classical Runge-Kutta method, order 4 (Kutta 1901).

RK4 = method_of(
    "rk4", tableau([[1 / 2], [0.0, 1 / 2], [0.0, 0.0, 1.0]], [1 / 6, 1 / 3, 1 / 3, 1 / 6], order=4)
)


# Dormand and Prince's pair of orders 5 and 4 (Dormand & Prince 1980), for adaptive steps.

DOPRI5 = method_of(
    "dopri5",
    tableau(
        [
            [1 / 5],
            [3 / 40, 9 / 40],
            [44 / 45, -56 / 15, 32 / 9],
            [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729],
            [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656],
            [35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
        ],
        [35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84, 0.0],
        order=5,
        embedded=[5179 / 57600, 0.0, 7571 / 16695, 393 / 640, -92097 / 339200, 187 / 2100, 1 / 40],
    ),
    "chooses its own steps",
)


# ARK4(3)6L[2]SA, the implicit part (Kennedy & Carpenter 2003, appendix C). It has order 4, is
# L-stable and stiffly accurate, and has stages of order 2, the first explicit. For stiff friction
# and stiff steel.

GAMMA = 1 / 4
ESDIRK4_WEIGHTS = [82889 / 524892, 0.0, 15625 / 83664, 69875 / 102672, -2260 / 8211, GAMMA]

ESDIRK4 = method_of(
    "esdirk4",
    tableau(
        [
            [1 / 4, GAMMA],
            [8611 / 62500, -1743 / 31250, GAMMA],
            [5012029 / 34652500, -654441 / 2922500, 174375 / 388108, GAMMA],
            [
                *(15267082809 / 155376265600, -71443401 / 120774400),
                *(730878875 / 902184768, 2285395 / 8070912, GAMMA),
            ],
            ESDIRK4_WEIGHTS,
        ],
        ESDIRK4_WEIGHTS,
        order=4,
        embedded=[
            *(4586570599 / 29645900160, 0.0, 178811875 / 945068544),
            *(814220225 / 1159782912, -3700637 / 11593932, 61727 / 225920),
        ],
    ),
    "implicit, chooses its own steps",
)


# Time stepping without physics: methods as tableaux, stages, error control, event location.

METHODS = {method.name: method for method in (RK2, HEUN, RK4, DOPRI5, ESDIRK4)}


def method_named(name: str) -> IntegrationMethod:
    """The method with the name that a scene gives."""
    return METHODS[name]


def methods_for_any_step() -> list[IntegrationMethod]:
    """Methods that are stable for any step."""
    return [method for method in METHODS.values() if method.any_step]
