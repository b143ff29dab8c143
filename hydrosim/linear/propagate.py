"""Exact propagation of linear scenes from record to record, without time steps.

    z' = J z + G (f(t) + rest),   z = (q, q', radiation states),   f = F_wave1 + F_wave2 + F_applied

`nonlinearities` says which scenes are linear. With constraints, J and G include their reactions,
which do no work. The forces f are read at nodes: the stages of a stepped run, or more if the waves'
table or a regular wave needs them.

Between the nodes f is a polynomial, and the response to it is exact, see `integrate.exponential`.
Corners of tables and ends of ramps are ends of intervals. The energies in y are integrals of the
powers, by polynomials through 6 nodes; the powers are exact at the nodes. The residual of the
energy balance is the error of these integrals.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import ceil, isclose
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy import linalg

from hydrosim.elements import given_frequencies, given_rows, resistances
from hydrosim.elements.kind import RADIATION, WAVE_FIRST_ORDER, WAVE_SECOND_ORDER
from hydrosim.integrate import exponential
from hydrosim.integrate.dynamics import Model, new_work, rhs
from hydrosim.integrate.exact import Resistances, add_energies, keep_states, sample_loads
from hydrosim.integrate.state import STATUS, Clock, Run, State
from hydrosim.jit.refs import StructReference
from hydrosim.linear.linearise import find_components, linearise, without_waves
from hydrosim.multibody.kinematics import slopes_at_rest

PHASE = 0.15  # rad, largest phase between two nodes, for waves and forces of one frequency
# parts of an interval
MIN_PARTS = exponential.POLYNOMIAL_NODES
USUAL_PARTS = 16
MAX_PARTS = 24
# intervals at a time, such that their data stay in a core's cache; fewer with more states
INTERVALS_PER_BLOCK = 1024
CACHED_STATES = 64
EQUAL_TIME_RTOL = 1e-9  # of the distance of records: times this close are equal


class PartResponse(NamedTuple):
    """Response of a part of an equation that nothing couples with the rest: its ``states`` of z and
    its ``coordinates`` of f, by index, and its ``interval``. Its rates and memory forces (2, k) at
    the nodes, in one row, are z @ ``by_state`` + f @ ``by_load``, with z at the start and the
    forces f around the interval."""

    states: np.ndarray
    coordinates: np.ndarray
    interval: exponential.PropagationInterval
    by_state: np.ndarray
    by_load: np.ndarray


class Response(NamedTuple):
    """Response of an interval in p parts of time, by ``parts`` of the equation. ``weights``
    (p + 1,) [s] are the quadrature weights of the nodes."""

    parts: tuple[PartResponse, ...]
    weights: np.ndarray


Constant = tuple[bytes, tuple[int, ...]]
"""A matrix as a key of a cache: its values, and its shape."""


def _constant(matrix: np.ndarray) -> Constant:
    return matrix.tobytes(), matrix.shape


@lru_cache(maxsize=8)
def _make_response(
    J: Constant, G: Constant, memory: Constant, length: float, parts: int
) -> Response:
    """`Equation.response`, shared by runs with the same equation."""
    arrays = (np.frombuffer(values).reshape(shape) for values, shape in (J, G, memory))
    jacobian, mobility, force = arrays
    split = _independent_parts(jacobian, mobility, force)
    of = [_part_response(*part, jacobian, mobility, force, length, parts) for part in split]
    return Response(tuple(of), length / parts * exponential.area_weights(parts))


def _part_response(
    states: np.ndarray,
    coordinates: np.ndarray,
    J: np.ndarray,
    G: np.ndarray,
    memory: np.ndarray,
    length: float,
    parts: int,
) -> PartResponse:
    """Response of the part with these ``states`` and ``coordinates``, by index."""
    n = coordinates.size
    of = exponential.propagation_interval(
        J[np.ix_(states, states)], G[np.ix_(states, coordinates)], length, parts
    )
    force = memory[np.ix_(coordinates, states[2 * n :] - 2 * len(memory))]
    needed = linalg.block_diag(np.eye(n), force)  # of all but q: for the powers
    by_state = needed @ of.states[:, n:]
    by_load = needed @ of.loads[:, n:]
    return PartResponse(states, coordinates, of, np.vstack(by_state).T, np.vstack(by_load).T)


def _independent_parts(
    J: np.ndarray, G: np.ndarray, memory: np.ndarray
) -> list[tuple[np.ndarray, np.ndarray]]:
    """States and coordinates, by index, of the parts of z' = J z + G f without coupling."""
    n = len(memory)
    coupled = J != 0.0
    coupled[:n, n : 2 * n] |= np.eye(n, dtype=bool)
    coupled[n : 2 * n, n : 2 * n] |= G[n : 2 * n] != 0.0
    coupled[n : 2 * n, 2 * n :] |= memory != 0.0
    components = find_components(coupled)
    # memory that nothing drives goes with the first part
    alone = [part for part in components if part[0] >= 2 * n]
    moving = [part for part in components if part[0] < 2 * n]
    moving[0] = np.sort(np.concatenate([moving[0], *alone]))
    return [(states, states[states < n]) for states in moving]


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
            and all(
                field is other_field
                for field, other_field in zip(self.model, other.model, strict=True)
            )
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
        return _make_response(*constants, length, parts)

    def gains(
        self,
        f: Sequence[np.ndarray],
        starts: np.ndarray,
        loads: np.ndarray,
        response: Response,
        size: int,
    ) -> np.ndarray:
        """Gains (nk, size) of the ``size`` energies in y in intervals with the states ``starts``
        (nk, m), the forces ``f`` (nk, ...) around them, by part, and ``loads`` (nodes, nr, n)
        inside."""
        shape = (len(starts), response.weights.size, self.rest.size)
        v = np.empty(shape)
        memory = np.empty(shape)
        for part, around in zip(response.parts, f, strict=True):
            own_gains = starts[:, part.states] @ part.by_state + around @ part.by_load
            own_gains = own_gains.reshape(*shape[:2], 2, part.coordinates.size)
            v[:, :, part.coordinates] = own_gains[:, :, 0]
            memory[:, :, part.coordinates] = own_gains[:, :, 1]
        gained = np.zeros((len(starts), size))
        add_energies(v, memory, loads, response.weights, self.resistances, self.rows, gained)
        return gained


def propagate(run: Run) -> Iterator[float]:
    """Record the run of a linear scene from its present state. The state is left at the end of the
    run, or where ``counters[STATUS]`` gives the reason of a stop. Yields the time reached, first
    the start."""
    clock = run.clock
    model = run.model
    state = run.state
    times = record_times(clock)
    y = state.y.copy()
    held = StructReference(run)
    keep_states(times[:1], y[None], held)
    equation = linear_equation(model, state)
    finest = node_spacing(clock, model)
    yield times[0]
    for stops in stretches(times, clock.breakpoints):
        length = _stop_distance(stops, clock)
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
            chosen_states = states[chosen]
            keep_states(there, chosen_states, held)
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
    close = EQUAL_TIME_RTOL * float(np.max(np.diff(times)))
    apart = [np.abs(times - t).min() > close for t in breakpoints]
    stops = np.union1d(times, breakpoints[np.array(apart, dtype=bool)])
    corner = [int(np.abs(stops - t).argmin()) for t in breakpoints]
    distance = np.diff(stops)
    uneven = 1 + np.flatnonzero(np.abs(np.diff(distance)) > close)
    for first, last in pairwise(sorted({0, *corner, *uneven.tolist(), stops.size - 1})):
        yield stops[first : last + 1]


def _stop_distance(stops: np.ndarray, clock: Clock) -> float:
    """Distance of the stops; identical to the distance of the records where they agree."""
    length = float(stops[-1] - stops[0]) / (stops.size - 1)
    usual = clock.every * clock.step
    return usual if isclose(length, usual, rel_tol=EQUAL_TIME_RTOL) else length


def node_spacing(clock: Clock, model: Model) -> float:
    """Largest distance of nodes [s]: half a step, like the stages of rk4, or less if the waves'
    tables are finer, and an integer fraction of that if a frequency needs it."""
    steps = min([clock.solver_step / 2.0, *model.waves.step])
    applied = given_frequencies(model.elements)
    highest = max([0.0, *model.waves.omega, *np.abs(applied)])
    return float(steps / max(ceil(highest * steps / PHASE), 1))


def division(length: float, finest: float) -> tuple[int, int]:
    """Pieces of a ``length`` and parts of a piece, such that parts are at most ``finest`` long.
    They equal ``finest`` if possible: then the nodes are on the waves' table."""
    total = max(ceil(length / finest * (1.0 - EQUAL_TIME_RTOL)), MIN_PARTS)
    for pieces in range(ceil(total / MAX_PARTS), total // MIN_PARTS + 1):
        if total % pieces == 0:
            return pieces, total // pieces
    pieces = ceil(total / USUAL_PARTS)
    return pieces, ceil(total / pieces)


def linear_equation(model: Model, state: State) -> Equation:
    """The equation of a linear scene without waves. It is linearised at the equilibrium of the
    start and is valid at all positions and times."""
    return _linear_equation(_Rest(model, state))


@lru_cache(maxsize=4)
def _linear_equation(calm: _Rest) -> Equation:
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
        resistances=_linear_resistances(model),
    )


def _linear_resistances(model: Model) -> Resistances:
    """Resistances of radiation with constant damping, and of elements that declare them."""
    size = 6 * model.bodies.each.size
    S = slopes_at_rest(model.bodies)
    damping = model.damping
    B = np.zeros((size, size))
    B[damping.row, damping.column] = damping.B
    terms = [_power_terms(RADIATION, S.T @ B @ S, np.zeros(S.shape[1]))]
    for resistance in resistances(model):
        if resistance.coordinate >= 0:
            of = np.array([resistance.coordinate])
            terms.append(_power_terms(resistance.row, resistance.B[:1, :1], np.zeros(1), of))
            continue
        sides = [resistance.body] if resistance.other < 0 else [resistance.body, resistance.other]
        side_rows = S[np.concatenate([6 * b + np.arange(6) for b in sides])]
        of = np.flatnonzero(side_rows.any(axis=0))
        side_rows = side_rows[:, of]
        terms.append(
            _power_terms(
                resistance.row, side_rows.T @ resistance.B @ side_rows, resistance.b @ side_rows, of
            )
        )
    return Resistances(*map(np.concatenate, zip(*terms, strict=True)))


def _power_terms(
    row: int, B: np.ndarray, b: np.ndarray, of: np.ndarray | None = None
) -> Resistances:
    """The terms of v (B v - b) that are not zero, for the coordinates ``of``, or all."""
    of = np.arange(b.size) if of is None else of
    rows, columns = np.nonzero(B)
    steady = np.flatnonzero(b)
    return Resistances(
        np.full(rows.size, row, dtype=np.int64),
        of[rows].astype(np.int64),
        of[columns].astype(np.int64),
        B[rows, columns],
        np.full(steady.size, row, dtype=np.int64),
        of[steady].astype(np.int64),
        b[steady],
    )


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
    f = exponential.extend_nodes(np.einsum("krn->kn", loads) + equation.rest)
    for around, states in motions(y[:m], f, response, pieces):
        here = loads[first * parts :]
        gained = equation.gains(around, states[:-1], here, response, y.size - m)
        states_and_loads = np.hstack([states[1:], y[m:] + np.cumsum(gained, axis=0)])
        y = states_and_loads[-1]
        first = first + len(states_and_loads)
        yield states_and_loads[pieces - 1 :: pieces]


def motions(
    z: np.ndarray, f: np.ndarray, of: Response, pieces: int
) -> Iterator[tuple[list[np.ndarray], np.ndarray]]:
    """Forces (nk, ...) around intervals, by part of the equation, and states (nk + 1, m) from the
    start of the first on, many intervals at a time and multiples of ``pieces``. ``z`` (m,) is the
    state at the very start; ``f`` are the forces at all nodes, (nodes + 2 `NODES_BESIDE`, n)."""
    parts = of.weights.size - 1
    around = [_forces_around(f[:, part.coordinates], part, parts) for part in of.parts]
    turned = [np.ascontiguousarray(part.interval.states[-1].T) for part in of.parts]
    together = (
        max(int(INTERVALS_PER_BLOCK * min(CACHED_STATES / z.size, 1.0)) // pieces, 1) * pieces
    )
    for k in range(0, (len(f) - 2 * exponential.NODES_BESIDE - 1) // parts, together):
        here = [np.ascontiguousarray(loads[k : k + together]) for loads in around]
        states = np.empty((len(here[0]) + 1, z.size))
        for part, transposed, forces in zip(of.parts, turned, here, strict=True):
            own_states = np.empty((len(states), part.states.size))
            own_states[0] = z[part.states]
            np.matmul(forces, part.interval.loads[-1].T, out=own_states[1:])
            exponential.fill_recursion(transposed, own_states)
            states[:, part.states] = own_states
        z = states[-1]
        yield here, states


def _forces_around(f: np.ndarray, part: PartResponse, parts: int) -> np.ndarray:
    """The forces ``f`` (nodes, k) of a part around each interval (nk, ...), one a row."""
    width = part.interval.loads.shape[2]
    return sliding_window_view(f.ravel(), width)[:: parts * f.shape[1]]
