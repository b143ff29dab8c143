"""Data of a run: its constants, clock, state, record and the scratch of its steps.

A `Run` holds all of them, and every kernel of this folder takes it.

The clock of a run: its grid, and times that no step may cross.

A time in a case and a point of the grid are often equal but for rounding: 150 steps of 0.07 s are
10.500000000000002 s. Such times are made equal, because a step between them would be as short as
rounding. Signals get their corners at the same times, so that a step that begins at a corner has
the rate of the piece that begins there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.elements import events, new_modes
from hydrosim.elements.signal import SIGNAL_PIECE
from hydrosim.integrate import dynamics
from hydrosim.integrate.methods import Control, IntegrationMethod, Newton, Tableau
from hydrosim.modes import MARGINS
from hydrosim.water.radiation.history import VelocityHistory

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hydrosim.scene import Scene

STEP_ROUNDING = 1e-9  # of a step: times so close together are equal
TIME_ROUNDING = 1e-15  # of a time, likewise: four roundings


class Clock(NamedTuple):
    """Grid of ``points`` steps up to ``end`` [s]; every ``every``-th and the last are recorded. It
    begins ``first`` steps after ``start``, so that a restart uses the grid of the run before it. A
    slow path in waves is renewed every ``block`` steps, if that is not 0. No step may cross the
    ``breakpoints``; ``events`` false lets steps run past events. No step is longer than
    ``signal_step`` [s], or than ``held_step`` [s] while a unit holds still until its load reaches a
    limit; both are infinite if no load has a rate.

    With adaptive ``control`` the grid is that of the records, and steps are shorter: they begin
    with the ``solver_step`` [s].
    """

    start: float
    first: int
    step: float
    end: float
    points: int
    every: int
    block: int
    breakpoints: np.ndarray
    events: bool
    signal_step: float
    held_step: float
    control: Control
    solver_step: float


def merge_breakpoints(clock: Clock) -> np.ndarray:
    """The breakpoints of a clock, without those that differ from a point of its grid, or from one
    before, by rounding."""
    times = clock.breakpoints
    step = clock.step
    begin = clock.start + clock.first * step
    points = np.minimum(clock.start + np.rint((times - clock.start) / step) * step, clock.end)
    on_grid = np.abs(times - points) <= rounding_at(times, clock)
    times = np.unique(np.where(on_grid, points, times))
    apart = np.diff(times, prepend=-np.inf) > rounding_at(times, clock)
    return times[apart & (times >= begin) & (times <= clock.end)]


def align_corners(model: dynamics.Model, clock: Clock) -> dynamics.Model:
    """The model with signals whose corners are at the breakpoints of a clock, where they differ
    from these by rounding. It is the same object if none does."""
    elements = {}
    for kind, constants in model.elements._asdict().items():
        pieces = {
            name: _align_pieces(array, clock)
            for name, array in zip(getattr(constants, "_fields", ()), constants, strict=False)
            if isinstance(array, np.ndarray) and array.dtype == SIGNAL_PIECE
        }
        if any(pieces[name] is not getattr(constants, name) for name in pieces):
            elements[kind] = constants._replace(**pieces)
    return model._replace(elements=model.elements._replace(**elements)) if elements else model


def _align_pieces(pieces: np.ndarray, clock: Clock) -> np.ndarray:
    """Pieces of signals that begin at the breakpoints, where they differ from these by rounding."""
    if clock.breakpoints.size == 0:
        return pieces
    start = pieces["start"]
    rounding = rounding_at(start, clock)
    index = np.searchsorted(clock.breakpoints, start - rounding)
    times = clock.breakpoints[np.minimum(index, clock.breakpoints.size - 1)]
    moved = (np.abs(times - start) <= rounding) & (times != start)
    if not moved.any():
        return pieces
    aligned = pieces.copy()
    aligned["start"][moved] = times[moved]
    return aligned


def rounding_at(times: np.ndarray, clock: Clock) -> np.ndarray:
    """Differences from ``times`` [s] that are rounding."""
    least = STEP_ROUNDING * min(clock.step, clock.solver_step)
    return np.maximum(least, TIME_ROUNDING * np.abs(times))


IN_PROGRESS, NOT_FINITE, CAPSIZED, CHATTERING, STEP_TOO_SMALL, NO_SOLUTION, BLOWN_UP = range(7)
SINGULAR, NO_SAMPLE, DRIVEN_APART = range(7, 10)
ACCEPTED, REJECTED, RECORDS, EVENTS, EVALUATIONS, GUARD_EVALUATIONS, STATUS, GRID_POINT = range(8)
EARLIER_EVENTS, EARLIER_STEPS, COUNTERS = range(8, 11)
"""Entries of `Run.counters`: ``GUARD_EVALUATIONS`` counts evaluations of margins, ``GRID_POINT`` is
the grid point reached; two belong to `PROGRESS_TIME`. Number of counters."""
END, FULL, SLOPE, STAGE, SPARE = range(5)
"""Rows of `Scratch.states`: the end of the step, the end of the uncut step and the slope there, a
stage, and a spare one."""
BEFORE_STEP, AFTER_STEP, AT_PLACE, NEAR_START, NEAR_END, TRIAL = range(6)
"""Rows of `Scratch.margins`: before and after the uncut step, at the present place, near both ends,
and for trials."""
AT_START, AT_THIRD, AT_TWO_THIRDS, AT_END, INSIDE_STEP = range(5)
"""Rows of `Scratch.reactions`: on the step as it is cut, and at the present place."""
MAY_END, EVALUATED = range(2)
"""Rows of `Scratch.watched`: rows of modes that may end in this step, and those evaluated at
present."""
START_SLOPE, END_SLOPE, START_MARGINS = range(3)
"""Entries of `Scratch.step_cache`, true if valid: k[0] as the slope at the current state,
``states[SLOPE]`` as the slope at the end of the step, ``margins[BEFORE]`` as the margins at the
current state."""
STALE, STALE_SLIP_ONLY, VALID = range(3)
"""Values of ``step_cache[START_MARGINS]``."""
NEXT_STEP, LAST_ERROR, REACHED_TIME, PROGRESS_TIME, ROW_RANK, ROW_RANK_TIME, ERROR_INTEGRAL = range(
    7
)
"""Entries of `Scratch.pace`: next step, last error, the time reached, the time since which events
and steps are counted to detect a run without progress; the smallest sine between rows of
constraints, and its time (`constraint_projection._check_rank`); the integral over time of the
errors of steps, in units of their tolerance."""


class State(NamedTuple):
    """State of a run: ``y``, the ``modes`` (rows, 3) of elements, the velocity ``history``."""

    y: np.ndarray
    modes: np.ndarray
    history: VelocityHistory


class RecordColumns(NamedTuple):
    """The first entries of channels in a row of the record, see `record.channels`."""

    time: int
    elevation: int
    wind: int
    kinetic: int
    events: int
    y: int
    coordinates: int
    velocity: int
    momentum: int
    stored: int
    wrench: int
    observed: int


class Record(NamedTuple):
    """Values at every output time: ``channels`` (nt, nc), ``at`` their places, the ``modes`` (nt,
    rows, 3) of elements, and the ``accelerations`` (nt, 6 nb) of bodies, or none.

    Radiation states would be half of a record, and are needed only where another run starts. So
    ``memory`` (nm, nr) has those of every ``spacing``-th record, and in its last row those of the
    newest. The numbers of these records are ``remembered`` (nm,), negative in empty rows.
    """

    at: RecordColumns
    channels: np.ndarray
    modes: np.ndarray
    accelerations: np.ndarray
    spacing: int
    remembered: np.ndarray
    memory: np.ndarray


class Scratch(NamedTuple):
    """Scratch of a step: stage derivatives ``k`` (s, ny), ``states`` (5, ny), ``margins`` (6, nm),
    ``watched`` (2, rows) flags of rows of modes. ``pace`` (7,) holds the next adaptive step, the
    last error and the progress of the run; ``step_cache`` (3,) flags of reusable values.
    ``headings`` (nf, 2) of slip at the start of the step, ``reactions`` (5, nf, 2) of held points.
    ``switches`` (rows,) counts how often each row of modes has switched since the time
    `PROGRESS_TIME`."""

    k: np.ndarray
    states: np.ndarray
    margins: np.ndarray
    watched: np.ndarray
    switches: np.ndarray
    pace: np.ndarray
    step_cache: np.ndarray
    headings: np.ndarray
    reactions: np.ndarray
    newton: Newton


class Run(NamedTuple):
    """A run in progress: the ``state`` is advanced, ``counters`` give progress and status."""

    clock: Clock
    model: dynamics.Model
    method: Tableau
    state: State
    work: dynamics.Work
    scratch: Scratch
    record: Record
    counters: np.ndarray


def new_scratch(model: dynamics.Model, method: IntegrationMethod, step: float) -> Scratch:
    """Scratch for this model and method; adaptive steps begin with ``step`` [s]."""
    ny = model.size
    rows = len(new_modes(model))
    watched = np.zeros((2, rows), dtype=np.int64)
    watched[MAY_END] = 1
    points = events.count_reaction_rows(model.elements)
    return Scratch(
        np.zeros((method.tableau.b.size, ny)),
        np.zeros((5, ny)),
        np.zeros((6, MARGINS * rows)),
        watched,
        np.zeros(rows, dtype=np.int64),
        np.array([step, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        np.zeros(3, dtype=np.int64),
        np.zeros((points, 2)),
        np.zeros((5, points, 2)),
        method.new_newton(dynamics.dynamic_states(model), dynamics.radiation_filters(model), ny),
    )


def new_run(
    clock: Clock, model: dynamics.Model, method: IntegrationMethod, state: State, record: Record
) -> Run:
    """A run that begins with ``state``, which it advances, and writes to ``record``."""
    clock = clock._replace(breakpoints=merge_breakpoints(clock))
    model = align_corners(model, clock)
    scratch = new_scratch(model, method, clock.solver_step)
    counters = np.zeros(COUNTERS, dtype=np.int64)
    work = dynamics.new_work(model)
    return Run(clock, model, method.tableau, state, work, scratch, record, counters)


# Forces of elements on their bodies at the start of a run: pretensions of lines.


def start_loads(
    scene: Scene, model: dynamics.Model, state: State, rows: Sequence[str], time: float
) -> dict[str, float]:
    """Magnitudes of the forces of all elements on their bodies [N], by name, in a ``state`` at a
    ``time`` [s]; ``rows`` are the names of the rows of forces."""
    work = dynamics.new_work(model)
    rates = np.empty(state.y.size)
    dynamics.rhs(time, state.y, state.modes, state.history, model, work, rates)
    first = {body.name: 6 * b for b, body in enumerate(scene.bodies)}
    forces = {}
    for name, element in scene.forces.items():
        force = work.wrench[rows.index(name), first[element.body] :][:3]
        forces[name] = float(np.linalg.norm(force))
    return forces
