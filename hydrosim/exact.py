"""Linear scenes are not stepped: their motions are propagated exactly, from record to record.

    z' = J z + G (f(t) + rest),   z = (q, q', radiation states),   f = F_wave1 + F_wave2 + F_applied

(`linearity` says which scenes are linear.) The forces f are read at nodes: those of the stages that
a stepped run would take, or more where the waves' table or a regular wave needs them. Between the
nodes f is a polynomial, and the response to it is exact, see `integrate.exponential`; corners of
tables and ends of ramps are ends of intervals. The energies in y are integrals, by polynomials
through 6 nodes, of powers that are exact there: the residual of the ledger is their error.
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

from hydrosim.dynamics import Model, new_work, rhs
from hydrosim.exact_kernels import add_energies, keep_states, sample_loads
from hydrosim.forces import APPLIED, LINEAR_DAMPING, LINEAR_MOORING
from hydrosim.forces.layout import RADIATION, WAVE_FIRST_ORDER, WAVE_SECOND_ORDER
from hydrosim.integrate import Tableau
from hydrosim.integrate.exponential import (
    POINTS,
    Interval,
    area_weights,
    extended,
    follow,
    interval,
)
from hydrosim.linear import linearise
from hydrosim.run import Clock, Record
from hydrosim.stepper import STATUS, State, new_scratch

PHASE = 0.15  # rad between two nodes, at most, of waves and forces of one frequency
FEWEST, WANTED, MOST = POINTS, 16, 24  # parts of an interval
TOGETHER = 1024  # intervals at a time: what they need stays in a core's cache
CLOSE = 1e-9  # of the distance of records: times as close are the same


class Resistances(NamedTuple):
    """Rows (nb,) of forces that take the power v (B v - b) at the free coordinates' rates v (n,):
    ``B`` (nb, n, n) and ``b`` (nb, n)."""

    row: np.ndarray
    B: np.ndarray
    b: np.ndarray


@dataclass(frozen=True, eq=False)
class Equation:
    """z' = J z + G (f + rest) for z (m,): ``G`` (m, n), and ``rest`` (n,) what acts at all times.

    ``memory`` (n, m - 2 n) is the radiation force, against v, per radiation state. ``rows`` (nr,)
    are those of the forces in f; ``resistances`` take energy besides the memory."""

    J: np.ndarray
    G: np.ndarray
    rest: np.ndarray
    memory: np.ndarray
    rows: np.ndarray
    resistances: Resistances

    @property
    def shape(self) -> tuple[int, int]:
        """Of the loads at a node, (nr, n)."""
        return self.rows.size, self.rest.size

    def response(self, length: float, parts: int) -> Interval:
        """Of an interval of this ``length`` [s] with so many parts."""
        return interval(self.J, self.G, length, parts)


def propagate(
    clock: Clock,
    method: Tableau,
    model: Model,
    state: State,
    record: Record,
    counters: np.ndarray,
) -> Iterator[float]:
    """Record the run of a linear scene from ``state`` on, which is left at its end, or where
    ``counters[STATUS]`` says why. Yields the time reached, first of all that of the start."""
    work, scratch = new_work(model), new_scratch(model, method, clock.control, clock.pace)
    times, y, finest = record_times(clock), state.y.copy(), node_spacing(clock, model)
    keep_states(times[:1], y[None], model, state, work, scratch, record, counters)
    equation = linear_equation(times[0], model, state)
    response = lru_cache(maxsize=4)(equation.response)  # of records, and beside corners
    yield times[0]
    for stops in stretches(times, clock.breakpoints):
        length = _length(stops, clock)
        pieces, parts = division(length, finest)
        of, step = response(length / pieces, parts), length / (pieces * parts)
        loads = np.empty(((stops.size - 1) * pieces * parts + 1, *equation.shape))
        sample_loads(stops[0], step, equation.rows, model, state, new_work(model), loads)
        kept, end = np.isin(stops, times), 0
        for states in march(y, step, loads, of, equation):
            ends = end + 1 + np.arange(len(states))
            y, end, whole = states[-1], ends[-1], ends % pieces == 0
            stop = ends[whole] // pieces
            there, known = stops[stop][kept[stop]], states[whole][kept[stop]]
            keep_states(there, known, model, state, work, scratch, record, counters)
            if counters[STATUS]:
                return
            yield float(stops[end // pieces])
    state.y[:] = y


def record_times(clock: Clock) -> np.ndarray:
    """Times (nt,) of the records of a run."""
    points = np.append(np.arange(0, clock.points, clock.every), clock.points)
    return np.minimum(clock.start + (clock.first + points) * clock.step, clock.end)


def stretches(times: np.ndarray, breakpoints: np.ndarray) -> Iterator[np.ndarray]:
    """``times`` and ``breakpoints`` as stretches of equal distances, without a breakpoint inside;
    one begins where the last ended."""
    close = CLOSE * float(np.max(np.diff(times)))
    apart = [np.abs(times - t).min() > close for t in breakpoints]
    stops = np.union1d(times, breakpoints[np.array(apart, dtype=bool)])
    corner = [int(np.abs(stops - t).argmin()) for t in breakpoints]
    distance = np.diff(stops)
    uneven = 1 + np.flatnonzero(np.abs(np.diff(distance)) > close)
    for first, last in pairwise(sorted({0, *corner, *uneven.tolist(), stops.size - 1})):
        yield stops[first : last + 1]


def _length(stops: np.ndarray, clock: Clock) -> float:
    """Distance of the stops, that of the records to the bit where it is that."""
    length, usual = float(stops[-1] - stops[0]) / (stops.size - 1), clock.every * clock.step
    return usual if isclose(length, usual, rel_tol=CLOSE) else length


def node_spacing(clock: Clock, model: Model) -> float:
    """Largest distance of nodes [s]: half a step, as the stages of rk4, or less where the waves'
    tables are finer, and whole parts of that where a frequency needs them."""
    own = min([clock.pace / 2.0, *model.waves.step])
    applied = model.elements[APPLIED].parts["signal"]["frequency"]
    highest = max([0.0, *model.waves.omega, *np.abs(applied)])
    return float(own / max(ceil(highest * own / PHASE), 1))


def division(length: float, finest: float) -> tuple[int, int]:
    """Pieces of a ``length`` and parts of a piece, so that parts are no longer than ``finest`` and,
    if it can be, as long: then the nodes are on the waves' table."""
    total = max(ceil(length / finest * (1.0 - CLOSE)), FEWEST)
    for pieces in range(ceil(total / MOST), total // FEWEST + 1):
        if total % pieces == 0:
            return pieces, total // pieces
    pieces = ceil(total / WANTED)
    return pieces, ceil(total / pieces)


def linear_equation(time: float, model: Model, state: State) -> Equation:
    """The equation of a linear scene; it holds at all times."""
    # differences of any size are exact, and large ones are best in rounding
    linear = linearise(model, state, time=time, step=1.0)
    n, m, J = linear.active.size, linear.states.size, linear.jacobian
    waves = (WAVE_FIRST_ORDER, WAVE_SECOND_ORDER)
    rows = np.array([*waves, *model.elements[APPLIED].each["row"]], dtype=np.int64)
    loads, slope, work = np.empty((1, rows.size, n)), np.empty(model.size), new_work(model)
    sample_loads(time, 0.0, rows, model, state, new_work(model), loads)
    rhs(time, state.y, state.modes, state.history, model, work, slope)
    forced = linear.inertia @ (slope[n : 2 * n] - J[n : 2 * n] @ state.y[:m])
    return Equation(
        J=J,
        G=np.vstack([np.zeros((n, n)), linalg.inv(linear.inertia), np.zeros((m - 2 * n, n))]),
        rest=forced - loads[0].sum(axis=0),
        memory=-linear.inertia @ J[n : 2 * n, 2 * n :],
        rows=rows,
        resistances=_resistances(model),
    )


def _resistances(model: Model) -> Resistances:
    """Of radiation with constant damping, of moorings and of linear damping."""
    elements = (*model.elements[LINEAR_MOORING], *model.elements[LINEAR_DAMPING])
    size, active = 6 * model.bodies.each.size, model.bodies.active
    B, b = np.zeros((1 + len(elements), size, size)), np.zeros((1 + len(elements), size))
    B[0, model.damping.row, model.damping.column] = model.damping.B
    for k, e in enumerate(elements, start=1):
        own = slice(6 * e["body"], 6 * e["body"] + 6)
        B[k, own, own] = e["damping"]
        if "stream" in e.dtype.names:
            b[k, own] = e["damping"][:, :2] @ e["stream"]
    rows = np.array([RADIATION, *(e["row"] for e in elements)], dtype=np.int64)
    return Resistances(rows, B[:, active[:, None], active], b[:, active])


def march(
    y: np.ndarray, step: float, loads: np.ndarray, of: Interval, equation: Equation
) -> Iterator[np.ndarray]:
    """States (nk, ny) at the ends of intervals that begin at ``y`` (ny,), some at a time, under
    ``loads`` (nodes, nr, n) at nodes that are ``step`` [s] apart."""
    parts, (m, n) = len(of.states) - 1, equation.G.shape
    total = extended(np.einsum("krn->kn", loads) + equation.rest)
    around = sliding_window_view(total.ravel(), (parts + POINTS - 1) * n)[:: parts * n]
    # what the powers need: rates, and the forces of the memory
    needed = linalg.block_diag(np.eye(n), equation.memory)
    by_state = (needed @ of.states[:, n:]).reshape(-1, m)
    by_load = (needed @ of.loads[:, n:]).reshape(len(by_state), -1)
    transposed, weights = np.ascontiguousarray(of.states[-1].T), step * area_weights(parts)
    z, energies = y[:m], y[m:]
    for k in range(0, len(around), TOGETHER):
        f = np.ascontiguousarray(around[k : k + TOGETHER])
        ends = f @ of.loads[-1].T
        follow(transposed, z, ends)
        starts = np.vstack([z, ends[:-1]])
        found = (starts @ by_state.T + f @ by_load.T).reshape(len(f), parts + 1, 2, n)
        sums, v, memory = np.zeros((len(f), energies.size)), found[:, :, 0], found[:, :, 1]
        here, weighed, rows = loads[k * parts :], equation.resistances, equation.rows
        add_energies(v, memory, here, weights, weighed, rows, sums)
        sums = energies + np.cumsum(sums, axis=0)
        z, energies = ends[-1].copy(), sums[-1]
        yield np.hstack([ends, sums])
