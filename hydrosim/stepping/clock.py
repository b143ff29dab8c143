"""The clock of a run: its grid, and times that no step may cross.

A time in a case and a point of the grid are often equal but for rounding: 150 steps of 0.07 s are
10.500000000000002 s. Such times are made equal, because a step between them would be as short as
rounding. Signals get their corners at the same times, so that a step that begins at a corner has
the rate of the piece that begins there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.forces.signal import SIGNAL_PIECE
from hydrosim.integrate import Control

if TYPE_CHECKING:
    from hydrosim.stepping.dynamics import Model

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


def align_corners(model: Model, clock: Clock) -> Model:
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
