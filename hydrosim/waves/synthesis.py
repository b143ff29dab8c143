"""Sums of harmonic loads in time, by FFT over the repeat period."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from hydrosim.waves.loads import STENCIL_POINTS

_PHASE_STEP = 0.25
"""Largest omega * step [rad] of a grid; it bounds the interpolation error."""

_FINE = 0.125
"""omega * step [rad] of a grid that is fine enough for stages between its points, see `loads`."""

MISSED = 1e-6
"""Largest interpolation error between rows, relative to the standard deviation. Adaptive methods
with a smaller tolerance need less: they resolve the corners between two interpolants."""


@dataclass(frozen=True, eq=False)
class SpectralLines:
    """n loads Re sum_l A_l exp(i w_l t): frequencies ``omega`` (nl,) [rad/s], in any order and with
    repetition, and complex ``amplitude`` (nl, n), of n columns of a table from ``first`` on."""

    omega: np.ndarray
    amplitude: np.ndarray
    first: int = 0

    @property
    def columns(self) -> slice:
        """The columns of the table."""
        return slice(self.first, self.first + self.amplitude.shape[1])

    @property
    def loaded_columns(self) -> np.ndarray:
        """The columns (m,) that have a load."""
        return self.first + np.flatnonzero(np.any(self.amplitude != 0.0, axis=0))

    def restrict_columns(self, chosen: np.ndarray) -> SpectralLines:
        """The same for a table of the ``chosen`` columns (m,), rising, alone."""
        own = (chosen >= self.first) & (chosen < self.columns.stop)
        first = int(np.searchsorted(chosen, self.first))
        return SpectralLines(self.omega, self.amplitude[:, chosen[own] - self.first], first)

    @property
    def highest(self) -> float:
        """The highest frequency with a load [rad/s]."""
        loaded = np.any(self.amplitude != 0.0, axis=1)
        return float(self.omega[loaded].max(initial=0.0))


@dataclass(frozen=True)
class Grid:
    """Times (first + j) * step, j < rows, out of ``period`` points over the repeat period."""

    step: float
    period: int
    first: int
    rows: int

    @property
    def start(self) -> float:
        """Time of the first row [s]."""
        return self.first * self.step

    def cut(self, values: np.ndarray) -> np.ndarray:
        """The rows of this grid out of ``values`` (period,), which repeat."""
        return np.take(values, np.arange(self.first, self.first + self.rows), mode="wrap")


def time_grid(spacing: float, highest: float, start: float, dt: float, duration: float) -> Grid:
    """The grid for a run from ``start`` over ``duration`` [s] whose stages are ``dt`` apart, for
    frequencies that are multiples of ``spacing`` up to ``highest`` [rad/s].

    The step is dt, or an integer fraction of dt if the highest frequency needs it. If dt is finer
    than any frequency needs, the step is a multiple of dt, and the stages between the points are
    interpolated. If the repeat period is no multiple of the step, the next smaller step that
    divides it is used.
    """
    repeat = 2.0 * np.pi / spacing
    divisions = max(int(np.ceil(highest * dt / _PHASE_STEP)), 1)
    stages = int(np.ceil(repeat / dt * (1.0 - 1e-9)))
    period = divisions * int(np.ceil(stages / _stages_apart(stages, max(highest, spacing) * dt)))
    step = repeat / period
    first = int(np.floor(start / step)) - STENCIL_POINTS // 2
    last = int(np.ceil((start + duration) / step)) + STENCIL_POINTS // 2
    return Grid(step, period, first, last - first + 1)


def row_step(
    seas: Sequence[tuple[np.ndarray, np.ndarray]], block: float, missed: float = MISSED
) -> float:
    """Step of rows for non-repeating waves of frequency (nw,) [rad/s] and amplitude (nw,). It is
    the longest fraction of a ``block`` [s] at which the error of interpolation between rows
    (`loads`) is within ``missed`` of a sea's standard deviation."""
    whole = max((_interpolation_error(omega, size, block) for omega, size in seas), default=0.0)
    return block / max(int(np.ceil((whole / missed) ** (1.0 / 6.0))), 1)


def _interpolation_error(omega: np.ndarray, amplitude: np.ndarray, step: float) -> float:
    """Interpolation error of a sum of waves over its standard deviation."""
    each = amplitude * 225.0 / 46080.0 * (omega * step) ** 6
    return float(np.linalg.norm(each) / max(np.linalg.norm(amplitude), np.finfo(float).tiny))


def _stages_apart(stages: int, phase: float) -> int:
    """Number of stages between the points of a grid, for ``stages`` in the repeat period and the
    highest ``phase`` [rad] between two stages. It is the largest that is fine enough, or slightly
    less if that divides the period, so that the points are stages."""
    most = max(int(_FINE / phase), 1)
    fitting = (n for n in range(most, most // 2, -1) if stages % n == 0)
    return next(fitting, most)


def add_sum(grid: Grid, lines: SpectralLines, total: np.ndarray) -> None:
    """Add the loads on the grid to their columns of ``total``; all frequencies are multiples of the
    grid's spacing."""
    index = np.rint(lines.omega * grid.step * grid.period / (2.0 * np.pi)).astype(np.int64)
    half = np.where(index == 0, 1.0, 0.5) * grid.period
    for j in np.flatnonzero(np.any(lines.amplitude != 0.0, axis=0)):
        spectrum = np.zeros(grid.period // 2 + 1, dtype=complex)
        np.add.at(spectrum, index, half * lines.amplitude[:, j])
        total[:, lines.first + j] += grid.cut(scipy.fft.irfft(spectrum, grid.period))
