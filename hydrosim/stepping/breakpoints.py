"""Times that no step may cross, on the grid of a run and apart from each other.

A time in a case and a point of the grid are often equal but for rounding: 150 steps of 0.07 s are
10.500000000000002 s. Such times are made equal, because a step between them would be as short as
rounding. Signals get their corners at the same times, so that a step that begins at a corner has
the rate of the piece that begins there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hydrosim.forces.signal import PIECE

if TYPE_CHECKING:
    from hydrosim.stepping.dynamics import Model
    from hydrosim.stepping.state import Clock

STEP_ROUNDING = 1e-9  # of a step: times so close together are equal
TIME_ROUNDING = 1e-15  # of a time, likewise: four roundings


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
            name: _aligned(array, clock)
            for name, array in zip(getattr(constants, "_fields", ()), constants, strict=False)
            if isinstance(array, np.ndarray) and array.dtype == PIECE
        }
        if any(pieces[name] is not getattr(constants, name) for name in pieces):
            elements[kind] = constants._replace(**pieces)
    return model._replace(elements=model.elements._replace(**elements)) if elements else model


def _aligned(pieces: np.ndarray, clock: Clock) -> np.ndarray:
    """Pieces of signals that begin at the breakpoints, where they differ from these by rounding."""
    if clock.breakpoints.size == 0:
        return pieces
    start = pieces["start"]
    before = np.maximum(np.searchsorted(clock.breakpoints, start) - 1, 0)
    for index in (before, np.minimum(before + 1, clock.breakpoints.size - 1)):
        times = clock.breakpoints[index]
        near = np.abs(times - start) <= rounding_at(start, clock)
        if np.any(near & (times != start)):
            pieces = pieces.copy()
            pieces["start"] = np.where(near, times, start)
            start = pieces["start"]
    return pieces


def rounding_at(times: np.ndarray, clock: Clock) -> np.ndarray:
    """Differences from ``times`` [s] that are rounding."""
    least = STEP_ROUNDING * min(clock.step, clock.solver_step)
    return np.maximum(least, TIME_ROUNDING * np.abs(times))
