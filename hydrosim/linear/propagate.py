"""Exact propagation of linear scenes from record to record, without time steps.

    z' = J z + G (f(t) + rest),   z = (q, q', radiation states),   f = F_wave1 + F_wave2 + F_applied

`linearity` says which scenes are linear. With constraints, J and G include their reactions, which
do no work. The forces f are read at nodes: the stages of a stepped run, or more if the waves' table
or a regular wave needs them.

Between the nodes f is a polynomial, and the response to it is exact, see `integrate.exponential`.
Corners of tables and ends of ramps are ends of intervals. The energies in y are integrals of the
powers, by polynomials through 6 nodes; the powers are exact at the nodes. The residual of the
energy balance is the error of these integrals.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import ceil, isclose
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy import linalg

from hydrosim.forces import given_frequencies, given_rows, resistances
from hydrosim.forces.layout import RADIATION, WAVE_FIRST_ORDER, WAVE_SECOND_ORDER
from hydrosim.integrate.exponential import (
    POINTS,
    Interval,
    area_weights,
    extended,
    follow,
    interval,
)
from hydrosim.jit.refs import Held
from hydrosim.linear.coordinates import without_waves
from hydrosim.linear.linearise import linearise
from hydrosim.rigid.free import slopes_at_rest
from hydrosim.stepping.clock import Clock
from hydrosim.stepping.dynamics import Model, new_work, rhs
from hydrosim.stepping.exact import Resistances, add_energies, keep_states, sample_loads
from hydrosim.stepping.state import STATUS, Run, State

PHASE = 0.15  # rad, largest phase between two nodes, for waves and forces of one frequency
# parts of an interval
FEWEST = POINTS
WANTED = 16
MOST = 24
TOGETHER = 1024  # intervals at a time, such that their data stay in a core's cache
CLOSE = 1e-9  # of the distance of records: times this close are equal


class Response(NamedTuple):
    """Response of an interval in p parts: rates and memory forces (2, n) at its p + 1 nodes, in one
    row. z at its start contributes z @ ``by_state``, the forces around it f @ ``by_load``.
    ``weights`` (p + 1,) [s] are the quadrature weights of the nodes."""

    interval: Interval
    by_state: np.ndarray
    by_load: np.ndarray
    weights: np.ndarray


Constant = tuple[bytes, tuple[int, ...]]
"""A matrix as a key of a cache: its values, and its shape."""


def _constant(matrix: np.ndarray) -> Constant:
    return matrix.tobytes(), matrix.shape


@lru_cache(maxsize=8)
def _response(J: Constant, G: Constant, memory: Constant, length: float, parts: int) -> Response:
    """`Equation.response`, shared by runs with the same equation."""
    each = (np.frombuffer(values).reshape(shape) for values, shape in (J, G, memory))
    jacobian, mobility, force = each
    of = interval(jacobian, mobility, length, parts)
    n = len(force)
    needed = linalg.block_diag(np.eye(n), force)  # of all but q: for the powers
    by_state = needed @ of.states[:, n:]
    by_load = needed @ of.loads[:, n:]
    weights = length / parts * area_weights(parts)
    return Response(of, np.vstack(by_state).T, np.vstack(by_load).T, weights)


class _Rest:
    """A model in calm water and a state, as a key of a cache. Two are equal if the parts of their
    models are the same objects, as in runs that differ in their waves alone, and their modes are
    equal."""

    def __init__(self, model: Model, state: State) -> None:
        self.model = without_waves(model)
        self.state = state._replace(y=np.zeros(model.size))

    def __hash__(self) -> int:
        return hash(tuple(map(id, self.model)))

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, _Rest)
            and all(one is two for one, two in zip(self.model, other.model, strict=True))
            and np.array_equal(self.state.modes, other.state.modes)
        )


@dataclass(frozen=True, eq=False)
class Equation:
    """z' = J z + G (f + rest) for z (m,): ``G`` (m, n), and ``rest`` (n,), the constant loads.

    ``memory`` (n, m - 2 n) is the radiation force, against v, per radiation state. ``rows`` (nr,)
    are the rows of the forces in f. ``resistances`` take energy in addition to the memory.
    """

    J: np.ndarray
    G: np.ndarray
    rest: np.ndarray
    memory: np.ndarray
    rows: np.ndarray
    resistances: Resistances

    def response(self, length: float, parts: int) -> Response:
        """Response of an interval of this ``length`` [s] with this number of ``parts``."""
        constants = map(_constant, (self.J, self.G, self.memory))
        return _response(*constants, length, parts)

    def gains(
        self, f: np.ndarray, starts: np.ndarray, loads: np.ndarray, response: Response, size: int
    ) -> np.ndarray:
        """Gains (nk, size) of the ``size`` energies in y in intervals with the states ``starts``
        (nk, m), the forces ``f`` (nk, ...) around them and ``loads`` (nodes, nr, n) inside."""
        found = starts @ response.by_state + f @ response.by_load
        found = found.reshape(len(f), -1, 2, self.rest.size)
        v = found[:, :, 0]
        memory = found[:, :, 1]
        gained = np.zeros((len(f), size))
        add_energies(v, memory, loads, response.weights, self.resistances, self.rows, gained)
        return gained


def propagate(
    run: Run,
) -> Iterator[float]:
    """Record the run of a linear scene from its present state. The state is left at the end of the
    run, or where ``counters[STATUS]`` gives the reason of a stop. Yields the time reached, first
    the start."""
    clock = run.clock
    model = run.model
    state = run.state
    times = record_times(clock)
    y = state.y.copy()
    held = Held(run)
    keep_states(times[:1], y[None], held)
    equation = linear_equation(model, state)
    finest = node_spacing(clock, model)
    yield times[0]
    for stops in stretches(times, clock.breakpoints):
        length = _length(stops, clock)
        pieces, parts = division(length, finest)
        of = equation.response(length / pieces, parts)
        first = 1
        loads = loads_at_rest(stops, pieces * parts, equation.rows, model, state)
        recorded = np.isin(stops, times)
        for states in march(y, loads, of, equation, pieces):
            y = states[-1]
            last = first + len(states)
            chosen = recorded[first:last]
            there = stops[first:last][chosen]
            known = states[chosen]
            keep_states(there, known, held)
            if run.counters[STATUS]:
                return
            yield float(stops[last - 1])
            first = last
    state.y[:] = y


def record_times(clock: Clock) -> np.ndarray:
    """Times (nt,) of the records of a run."""
    points = np.append(np.arange(0, clock.points, clock.every), clock.points)
    return np.minimum(clock.start + (clock.first + points) * clock.step, clock.end)


def stretches(times: np.ndarray, breakpoints: np.ndarray) -> Iterator[np.ndarray]:
    """``times`` and ``breakpoints`` as stretches of equal distances, without a breakpoint inside;
    each begins where the one before ended."""
    close = CLOSE * float(np.max(np.diff(times)))
    apart = [np.abs(times - t).min() > close for t in breakpoints]
    stops = np.union1d(times, breakpoints[np.array(apart, dtype=bool)])
    corner = [int(np.abs(stops - t).argmin()) for t in breakpoints]
    distance = np.diff(stops)
    uneven = 1 + np.flatnonzero(np.abs(np.diff(distance)) > close)
    for first, last in pairwise(sorted({0, *corner, *uneven.tolist(), stops.size - 1})):
        yield stops[first : last + 1]


def _length(stops: np.ndarray, clock: Clock) -> float:
    """Distance of the stops; identical to the distance of the records where they agree."""
    length = float(stops[-1] - stops[0]) / (stops.size - 1)
    usual = clock.every * clock.step
    return usual if isclose(length, usual, rel_tol=CLOSE) else length


def node_spacing(clock: Clock, model: Model) -> float:
    """Largest distance of nodes [s]: half a step, like the stages of rk4, or less if the waves'
    tables are finer, and an integer fraction of that if a frequency needs it."""
    own = min([clock.solver_step / 2.0, *model.waves.step])
    applied = given_frequencies(model.elements)
    highest = max([0.0, *model.waves.omega, *np.abs(applied)])
    return float(own / max(ceil(highest * own / PHASE), 1))


def division(length: float, finest: float) -> tuple[int, int]:
    """Pieces of a ``length`` and parts of a piece, such that parts are at most ``finest`` long.
    They equal ``finest`` if possible: then the nodes are on the waves' table."""
    total = max(ceil(length / finest * (1.0 - CLOSE)), FEWEST)
    for pieces in range(ceil(total / MOST), total // FEWEST + 1):
        if total % pieces == 0:
            return pieces, total // pieces
    pieces = ceil(total / WANTED)
    return pieces, ceil(total / pieces)


def linear_equation(model: Model, state: State) -> Equation:
    """The equation of a linear scene without waves. It is linearised at the equilibrium of the
    start and is valid at all positions and times."""
    return _equation(_Rest(model, state))


@lru_cache(maxsize=4)
def _equation(calm: _Rest) -> Equation:
    model = calm.model
    state = calm.state
    # differences of any size are exact, and large ones round least
    linear = linearise(model, state, step=1.0)
    n = linear.active.size
    m = linear.states.size
    J = linear.jacobian
    waves = (WAVE_FIRST_ORDER, WAVE_SECOND_ORDER)
    rows = np.array([*waves, *given_rows(model.elements)], dtype=np.int64)
    loads = loads_at_rest(np.zeros(2), 1, rows, model, state)[0]
    slope = np.empty(model.size)
    rhs(0.0, state.y, state.modes, state.history, model, new_work(model), slope)
    return Equation(
        J=J,
        G=np.vstack([np.zeros((n, n)), linear.freedom.find_mobility(), np.zeros((m - 2 * n, n))]),
        rest=linear.inertia @ slope[n : 2 * n] - loads.sum(axis=0),
        memory=-linear.inertia @ J[n : 2 * n, 2 * n :],
        rows=rows,
        resistances=_resistances(model),
    )


def _resistances(model: Model) -> Resistances:
    """Resistances of radiation with constant damping, and of elements that declare them."""
    size = 6 * model.bodies.each.size
    S = slopes_at_rest(model.bodies)
    damping = model.damping
    B = [np.zeros((size, size))]
    b = [np.zeros(size)]
    rows = [RADIATION]
    B[0][damping.row, damping.column] = damping.B
    for each in resistances(model):
        sides = [each.body] if each.other < 0 else [each.body, each.other]
        own = np.concatenate([6 * b + np.arange(6) for b in sides])
        B.append(np.zeros((size, size)))
        b.append(np.zeros(size))
        if each.coordinate < 0:
            B[-1][np.ix_(own, own)] = each.B
            b[-1][own] = each.b
        rows.append(each.row)
    matrices = S.T @ np.array(B) @ S
    steady = np.array(b) @ S
    for k, each in enumerate(resistances(model), 1):
        if each.coordinate >= 0:
            matrices[k, each.coordinate, each.coordinate] = each.B[0, 0]
    return Resistances(np.array(rows, dtype=np.int64), matrices, steady)


def loads_at_rest(
    stops: np.ndarray, parts: int, rows: np.ndarray, model: Model, state: State
) -> np.ndarray:
    """Loads (nodes, nr, n) of the rows of forces at ``parts`` nodes per distance of ``stops``."""
    count = (stops.size - 1) * parts
    loads = np.empty((count + 1, rows.size, model.bodies.active.size))
    step = (stops[-1] - stops[0]) / count
    sample_loads(stops[0], step, rows, model, state, new_work(model), loads)
    return loads


def march(
    y: np.ndarray, loads: np.ndarray, response: Response, equation: Equation, pieces: int
) -> Iterator[np.ndarray]:
    """States (nk, ny) after every ``pieces`` intervals from ``y`` (ny,) on, many at a time, under
    ``loads`` (nodes, nr, n)."""
    m = len(equation.J)
    parts = response.weights.size - 1
    first = 0
    f = extended(np.einsum("krn->kn", loads) + equation.rest)
    for around, states in motions(y[:m], f, response.interval, pieces):
        here = loads[first * parts :]
        gained = equation.gains(around, states[:-1], here, response, y.size - m)
        known = np.hstack([states[1:], y[m:] + np.cumsum(gained, axis=0)])
        y = known[-1]
        first = first + len(known)
        yield known[pieces - 1 :: pieces]


def motions(
    z: np.ndarray, f: np.ndarray, of: Interval, pieces: int
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Forces (nk, ...) around intervals and states (nk + 1, m) from the start of the first on, many
    intervals at a time and multiples of ``pieces``. ``z`` (m,) is the state at the very start;
    ``f`` are the forces at all nodes, (nodes + 2 `BESIDE`, n)."""
    width = of.loads.shape[2]
    parts = len(of.states) - 1
    around = sliding_window_view(f.ravel(), width)[:: parts * f.shape[1]]
    transposed = np.ascontiguousarray(of.states[-1].T)
    together = max(TOGETHER // pieces, 1) * pieces
    for k in range(0, len(around), together):
        here = np.ascontiguousarray(around[k : k + together])
        states = np.empty((len(here) + 1, z.size))
        states[0] = z
        np.matmul(here, of.loads[-1].T, out=states[1:])
        follow(transposed, states)
        z = states[-1]
        yield here, states
