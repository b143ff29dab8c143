"""What a run is made of: its constants, what it remembers, its record and the scratch of its steps.

All of it together is a `Run`, which every kernel of this folder takes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.forces import events, new_modes
from hydrosim.integrate import Control, Method, Newton, Tableau
from hydrosim.modes import MARGINS
from hydrosim.radiation.history import VelocityHistory
from hydrosim.stepping.dynamics import Model, Work, dynamic_states, new_work, radiation_filters

RUNNING, NOT_FINITE, CAPSIZED, CHATTERING, STEP_TOO_SMALL, NO_SOLUTION, BLOWN_UP = range(7)
STEPS, REJECTED, RECORDS, EVENTS, EVALUATIONS, LOOKS, STATUS, POINT = range(8)
EVENTS_THEN, STEPS_THEN, COUNTERS = range(8, 11)
"""Of `Run.counters`: ``LOOKS`` are those at margins, ``POINT`` the grid point reached; two belong
to `SINCE`. Their number."""
END, FULL, SLOPE, STAGE, SPARE = range(5)
"""Of `Scratch.states`: the end of the step, the end of the uncut step and the slope there, a stage,
and one to spare."""
BEFORE, AFTER, NOW, EARLY, LATE, TRIAL = range(6)
"""Of `Scratch.margins`: before and after the uncut step, at the place in question, near both ends
and on trial."""
AT_START, AT_THIRD, AT_TWO_THIRDS, AT_END, BETWEEN = range(5)
"""Of `Scratch.reactions`: on the step as it is cut, and at the place in question."""
EVERY, SOME = range(2)
"""Of `Scratch.watched`: all rows of modes, and those that are looked at just now."""
START_SLOPE, END_SLOPE, START_MARGINS = range(3)
"""Of `Scratch.known`: whether k[0] is the slope at the current state, ``states[SLOPE]`` that at the
end of the step, ``margins[BEFORE]`` those at the current state."""
UNKNOWN, BUT_FOR_SLIP, KNOWN = range(3)
"""Of ``known[START_MARGINS]``."""
NEXT_STEP, LAST_ERROR, REACHED, SINCE = range(4)
"""Of `Scratch.pace`: the time reached, and the time from which on events and steps are counted to
see whether a run comes on."""


class State(NamedTuple):
    """All that a run remembers: ``y``, the ``modes`` (rows, 3) of elements, the velocity
    ``history``."""

    y: np.ndarray
    modes: np.ndarray
    history: VelocityHistory


class Clock(NamedTuple):
    """Grid of ``points`` steps up to ``end`` [s]; every ``every``-th and the last are recorded. It
    begins ``first`` steps after ``start``: so a restart is on the grid of the run before it. A slow
    path in waves is taken anew every ``block`` steps, if that is not 0.
    ``breakpoints`` are times that no step may cross; ``events`` false lets steps run past them.

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
    control: Control
    solver_step: float


class Places(NamedTuple):
    """The first entries of channels in a row of the record, see `record.channels`."""

    time: int
    elevation: int
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
    """What is kept at every output time: ``channels`` (nt, nc), which are ``at`` their places, the
    ``modes`` (nt, rows, 3) of elements, and the ``accelerations`` (nt, 6 nb) of bodies, or none."""

    at: Places
    channels: np.ndarray
    modes: np.ndarray
    accelerations: np.ndarray


class Scratch(NamedTuple):
    """Scratch of a step: stage derivatives ``k`` (s, ny), ``states`` (5, ny), ``margins`` (6, nm),
    whether rows of modes are ``watched`` (2, rows), the next adaptive step, the error of the last
    and where the run is as ``pace`` (4,), what is ``known`` (3,) already, the ``headings`` (nf, 2)
    of slip at the start of the step, ``reactions`` (5, nf, 2) of what is held."""

    k: np.ndarray
    states: np.ndarray
    margins: np.ndarray
    watched: np.ndarray
    pace: np.ndarray
    known: np.ndarray
    headings: np.ndarray
    reactions: np.ndarray
    newton: Newton


class Run(NamedTuple):
    """A run on its way: the ``state`` is carried on, ``counters`` say how far and how."""

    clock: Clock
    model: Model
    method: Tableau
    state: State
    work: Work
    scratch: Scratch
    record: Record
    counters: np.ndarray


def new_scratch(model: Model, method: Method, step: float) -> Scratch:
    """Scratch for this model and method; adaptive steps begin with ``step`` [s]."""
    ny = model.size
    rows = len(new_modes(model))
    watched = np.zeros((2, rows), dtype=np.int64)
    watched[EVERY] = 1
    points = events.held_points(model.elements)
    return Scratch(
        np.zeros((method.tableau.b.size, ny)),
        np.zeros((5, ny)),
        np.zeros((6, MARGINS * rows)),
        watched,
        np.array([step, 1.0, 0.0, 0.0]),
        np.zeros(3, dtype=np.int64),
        np.zeros((points, 2)),
        np.zeros((5, points, 2)),
        method.new_newton(dynamic_states(model), radiation_filters(model), ny),
    )


def new_run(clock: Clock, model: Model, method: Method, state: State, record: Record) -> Run:
    """A run that begins with ``state``, which it carries on, into ``record``."""
    scratch = new_scratch(model, method, clock.solver_step)
    counters = np.zeros(COUNTERS, dtype=np.int64)
    work = new_work(model)
    return Run(clock, model, method.tableau, state, work, scratch, record, counters)
