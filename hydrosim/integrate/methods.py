"""Time stepping without physics: Runge-Kutta methods, error control, event location, Newton stages.

A method is a `Tableau`; a step of length h from (t, y) is

    Y_i = y + h sum_{j<i} a_ij k_j,   k_i = f(t + c_i h, Y_i + h a_ii k_i)
    y_new = y + h sum_i b_i k_i

where a_ii = 0 for explicit methods; otherwise `newton_iteration` finds k_i.

The caller evaluates f, because kernels that take functions cannot be cached on disk. So the loop
over the stages stands beside the equation that it integrates (`hydrosim.integrate.step`, or a
test's own loop):

    for i in range(1, c.size):
        stage_state(i, tableau, h, y, k, Y)
        k[i] = f(t + c[i] * h, Y)
    advance_state(tableau, h, y, k, y_new)

Step size control for embedded pairs: error norm and PI controller.

The error of a step is the largest, over the states with a finite tolerance, of

    e_m = |sum_i (b_i - b^_i) k_i| / (absolute_m + relative max(|y_m|, |y_new_m|))

A step is accepted if this is at most 1. A mean would hide one fast state among many. The error is
per unit of time: the total error of a run grows with its duration, not with its number of steps. A
fast vibration with many short steps is as accurate as a slow one (error per unit step; Hairer,
Norsett & Wanner 1993, II.4; Shampine 2005).

Steps shorter than `SHORT_STEP_S` may have the error of a step of that length. Otherwise the
rounding of k_i would shorten them without end.

The next step is h times 0.9 e^-0.7/q e_last^0.4/q, q the lower order, at least a fifth and at most
five times the last (Gustafsson 1991; Hairer & Wanner 1996, IV.2).

Location of the end of a mode inside a step, by margins that are positive while the mode holds.

The owner of a margin knows its physics; here margins are numbers. All margins that are negative at
the end of a step are watched, each in units of the larger of its values at the two ends. The
smallest of them is phi: its first zero is the first event.

Implicit stages: Newton's method with a Jacobian that is kept over many steps.

A stage of a diagonally implicit method is k = f(t + c h, Y + g k) with g = h a_ii. From a guess,

    (I - g J) d = f(t + c h, Y + g k) - k,   k += d

is repeated until the change g d is small in units of the tolerances. J is the Jacobian of f over
the ``states`` that f depends on; all other states follow from them without a solution. J is renewed
only if Newton's method has become slow or f itself has changed. The factors of I - g J are valid
for one g. (Hairer & Wanner 1996, IV.8.)

Filters, of which there may be hundreds, are solved one by one,

    x' = a x + b z + ...,   z' = a z - b x + ...

Their effect on the other states follows by iteration. Its rate of convergence is g^2 times the
force per mass that a filter feeds back of a velocity. It is small if the step is short compared
with the periods of the motion.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import isfinite, isnan, sqrt
from typing import NamedTuple

import numpy as np

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


# Methods and their properties: kernels receive the `Tableau`, other code an `IntegrationMethod`.


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


# Implicit part of ARK4(3)6L[2]SA (Kennedy & Carpenter 2003, appendix C): order 4, L-stable, stages
# of order 2. For stiff friction and stiff steel.

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


# Methods by name.

METHODS = {method.name: method for method in (RK2, HEUN, RK4, DOPRI5, ESDIRK4)}


def method_named(name: str) -> IntegrationMethod:
    """The method with the name that a scene gives."""
    return METHODS[name]


def methods_for_any_step() -> list[IntegrationMethod]:
    """Methods that are stable for any step."""
    return [method for method in METHODS.values() if method.any_step]


SAFETY, MIN_STEP_FACTOR, MAX_STEP_FACTOR = 0.9, 0.2, 5.0
SHORT_STEP_S = 1e-3  # s


class Control(NamedTuple):
    """Tolerances: ``relative`` [1/s] and ``absolute`` (ny,), the latter in the units of the states
    per second and infinite for states that do not count. If ``adaptive`` is false every step is
    accepted."""

    adaptive: bool
    relative: float
    absolute: np.ndarray


@kernel
def error_norm(h, method, k, y, end, control):
    """Error of a step of length ``h`` with stage derivatives ``k`` from ``y`` to ``end``."""
    largest, part = 0.0, h / max(h, SHORT_STEP_S)
    for m in range(y.size):
        if isfinite(control.absolute[m]):
            error = 0.0
            for i in range(method.error.size):
                error += method.error[i] * k[i, m]
            scale = control.absolute[m] + control.relative * max(abs(y[m]), abs(end[m]))
            error = abs(part * error / scale)
            largest = error if error > largest or isnan(error) else largest
    return largest


@kernel
def step_factor(error, last, order):
    """Factor on the step after an ``error``, with the error of the ``last`` accepted step;
    ``order`` is the higher order of the method."""
    if not isfinite(error):
        return MIN_STEP_FACTOR
    error, last, q = max(error, 1e-10), max(last, 1e-4), order - 1
    factor = SAFETY * error ** (-0.7 / q)
    if error <= 1.0:
        factor *= last ** (0.4 / q)
    return min(max(factor, MIN_STEP_FACTOR), MAX_STEP_FACTOR if error <= 1.0 else SAFETY)


@kernel
def guard_defect(now, before, after):
    """Smallest watched margin of ``now`` in units of its own range over the step."""
    smallest = 1.0
    for i in range(now.size):
        if after[i] < 0.0:
            smallest = min(smallest, linear_value(i, now, before, after))
    return smallest


@kernel
def linear_value(i, now, before, after):
    """Margin ``i`` in units of the larger of its values at the ends of the step."""
    return now[i] / max(abs(before[i]), abs(after[i]))


@kernel
def next_trial(lo, f_lo, hi, f_hi):
    """Next guess for a zero of a function f in [lo, hi], where f(lo) = f_lo >= 0 > f_hi = f(hi).
    It is the zero of the chord, kept 1 % of the bracket away from its ends, so that the bracket
    always shrinks."""
    x = lo + (hi - lo) * f_lo / (f_lo - f_hi)
    guard = 0.01 * (hi - lo)
    return min(max(x, lo + guard), hi - guard)


STAGE_TOLERANCE = 1e-4  # fraction of the tolerances of a step to which stages are solved
MAX_ITERATIONS, SLOW_ITERATIONS = 12, 5
STALE, READY = range(2)


class Filters(NamedTuple):
    """Pairs of states x and z of y that decay and rotate by themselves: entries ``one`` and
    ``other`` (p,) with ``decay`` a and ``rotation`` b (p,). ``other`` equals ``one`` if there is no
    z."""

    one: np.ndarray
    other: np.ndarray
    decay: np.ndarray
    rotation: np.ndarray


NO_FILTERS = Filters(*(np.zeros(0, dtype=np.int64),) * 2, *(np.zeros(0),) * 2)


class Shifts(NamedTuple):
    """Columns of a Jacobian in the order in which differences fill them.

    Those of equal ``number`` follow each other and are shifted at once. Each acts only on states of
    its own ``part``.
    """

    columns: np.ndarray  # (k,) int64
    number: np.ndarray  # (k,) int64
    part: np.ndarray  # (m,) int64, of every state


def shift_each(columns: np.ndarray, states: int) -> Shifts:
    """Shift one of the ``columns`` (k,) at a time; each may act on all of so many ``states``."""
    return Shifts(columns, np.arange(columns.size), np.zeros(states, dtype=np.int64))


class Newton(NamedTuple):
    """Scratch for Newton's method.

    ``states`` (m,) of y are solved together, ``filters`` one by one. ``shifts`` fill the Jacobian.
    ``J`` and the ``factors`` of I - g J are (m, m), the latter with their ``order`` of rows (m,).
    ``change`` is (m,). ``status`` (1,) is `STALE` or `READY`, ``weight`` g (1,) is that of the
    factors, and ``shifted`` (3, ny) is work space.
    """

    states: np.ndarray
    filters: Filters
    shifts: Shifts
    J: np.ndarray
    factors: np.ndarray
    order: np.ndarray
    change: np.ndarray
    status: np.ndarray
    weight: np.ndarray
    shifted: np.ndarray


def new_newton(states: np.ndarray, size: int, filters: Filters = NO_FILTERS) -> Newton:
    """Scratch for ``states`` (m,) out of ``size`` states; m is 0 for explicit methods."""
    m = states.size
    flags, order = np.zeros(1, dtype=np.int64), np.zeros(m, dtype=np.int64)
    J, factors = np.zeros((m, m)), np.zeros((m, m))
    room = np.zeros((3, size))
    shifts = shift_each(np.arange(m), m)
    return Newton(states, filters, shifts, J, factors, order, np.zeros(m), flags, np.zeros(1), room)


@kernel
def newton_iteration(k, f, y, weight, newton, control):
    """One iteration: update ``k`` (ny,) from ``f`` evaluated at it. Returns the change of the stage
    in units of `STAGE_TOLERANCE` times the tolerances. ``y`` sets the scale of relative
    tolerances."""
    d, states, total = newton.change, newton.states, 0.0
    for i in range(states.size):
        d[i] = f[states[i]] - k[states[i]]
    solve(newton.factors, newton.order, d)
    for i in range(states.size):
        m = states[i]
        scale = STAGE_TOLERANCE * (control.absolute[m] + control.relative * abs(y[m]))
        total += (weight * d[i] / scale) ** 2
        d[i] += k[m]
    total += _improve_filters(k, f, y, weight, newton.filters, control)
    assign(k, f)
    for i in range(states.size):
        k[states[i]] = d[i]
    return sqrt(total / max(states.size + 2 * newton.filters.one.size, 1))


@kernel
def _improve_filters(k, f, y, weight, p, control):
    """Write the updated derivatives of filters into ``f``; returns the sum of squares of the
    changes."""
    total = 0.0
    for i in range(p.one.size):
        m, n = p.one[i], p.other[i]
        a, b = 1.0 - weight * p.decay[i], weight * p.rotation[i]
        r, s = f[m] - k[m], f[n] - k[n]
        det = a * a + b * b
        for j, d in ((m, (a * r + b * s) / det), (n, (a * s - b * r) / det)):
            scale = STAGE_TOLERANCE * (control.absolute[j] + control.relative * abs(y[j]))
            total += (weight * d / scale) ** 2
            f[j] = k[j] + d
    return total


@kernel
def factorise_iteration_matrix(weight, newton):
    """Factorise I - g J for this ``weight`` g."""
    m = newton.states.size
    for i in range(m):
        for j in range(m):
            newton.factors[i, j] = -weight * newton.J[i, j]
        newton.factors[i, i] += 1.0
    factorise(newton.factors, newton.order)
    newton.weight[0] = weight


@kernel
def factorise(A, order):
    """Factors L U of ``A`` in place, with the ``order`` of its rows after partial pivoting."""
    n = A.shape[0]
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(A[i, k]) > abs(A[best, k]):
                best = i
        order[k] = best
        if best != k:
            for j in range(n):
                A[k, j], A[best, j] = A[best, j], A[k, j]
        for i in range(k + 1, n):
            factor = A[i, k] / A[k, k]
            A[i, k] = factor
            if factor != 0.0:
                for j in range(k + 1, n):
                    A[i, j] -= factor * A[k, j]


@kernel
def solve(factors, order, x):
    """Solve A x = x in place by the factors of A."""
    n = x.size
    for k in range(n):
        x[k], x[order[k]] = x[order[k]], x[k]
    for i in range(n):
        for j in range(i):
            x[i] -= factors[i, j] * x[j]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            x[i] -= factors[i, j] * x[j]
        x[i] /= factors[i, i]
