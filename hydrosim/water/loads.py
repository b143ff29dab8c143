"""Wave loads and elevations over time: tables, the kernel that reads them, and sums by FFT.

Waves on a grid are a table on the solver's stage grid. A read at a node is exact. Between the nodes
it is a 6-point Lagrange interpolation. Its error for a component of frequency w on a table of step
h is at most 225/46080 (w h)^6 of its amplitude: (x^2 - 1/4) (x^2 - 9/4) (x^2 - 25/4) / 6!, with x
the steps from the middle of the 6 points, is largest in the middle. The tables keep w h below 0.25,
so the error is below 1.2e-6 at the highest frequency and falls with the sixth power.

If every second stage would suffice with w h below 0.125, only some of the stages are nodes. The
error at the other stages is below 1.9e-8. Waves off the grid are summed one by one, exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, floor, pi, sin
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy

from hydrosim.jit.kernels import kernel, root_giving

if TYPE_CHECKING:
    from hydrosim.water.components import WaveComponents

STENCIL_POINTS = 6
"""Number of rows that an interpolation reads."""

_NODE = 1e-9  # of a step: times this close to a node are at the node


class WaveLoads(NamedTuple):
    """Wave elevation and wave loads of a scene, as sums of tables and of single waves.

    A row is the elevation at the earth's origin [m], the first-order loads on the DOFs
    ``first_dof`` (n1,) and the second-order loads on ``second_dof`` (n2,). Table k is a time
    series: the rows offset[k] to offset[k + 1] of ``values``, at the times start[k], start[k] +
    step[k], ... [s]. Its amplitude grows from zero over ``ramp[k]`` [s]. Single wave l is Re(a
    exp(i omega[l] t)), omega in rad/s. The real and imaginary parts of its rows a are ``lines[l]``
    of ``lines`` (nl, 2, 1 + n1 + n2); it grows over ``line_ramp[l]`` [s].
    The first-order moments of the bodies ``turned`` (nm,) turn with their yaw, see `water.body`.
    """

    start: np.ndarray
    step: np.ndarray
    ramp: np.ndarray
    offset: np.ndarray
    values: np.ndarray
    omega: np.ndarray
    line_ramp: np.ndarray
    lines: np.ndarray
    first_dof: np.ndarray
    second_dof: np.ndarray
    turned: np.ndarray


@kernel
def any_waves(p):
    """True if there are waves."""
    return p.ramp.size + p.line_ramp.size > 0


@root_giving(float)
def wave_loads(t, p, first, second):
    """Elevation at the earth's origin [m] at time t; adds the loads to first and second (n,).

    t must lie within the run for which `build.wave_loads_model` was called.
    """
    elevation = 0.0
    for k in range(p.ramp.size):
        x = (t - p.start[k]) / p.step[k]
        row, points = rows_at(x, p.offset[k + 1] - p.offset[k])
        ramp = rise(t, p.ramp[k])
        for m in range(points):
            weight = ramp * lagrange(x - row, m, points)
            elevation += _add_row(weight, ramp, p.values[p.offset[k] + row + m], p, first, second)
    for k in range(p.omega.size):
        ramp, angle = rise(t, p.line_ramp[k]), p.omega[k] * t
        elevation += _add_row(ramp * cos(angle), ramp, p.lines[k, 0], p, first, second)
        elevation += _add_row(-ramp * sin(angle), ramp, p.lines[k, 1], p, first, second)
    return elevation


@kernel
def _add_row(weight, ramp, row, p, first, second):
    """Add weight times a row's loads; second-order loads are multiplied by the ramp once more."""
    n1 = p.first_dof.size
    for j in range(n1):
        first[p.first_dof[j]] += weight * row[1 + j]
    for j in range(p.second_dof.size):
        second[p.second_dof[j]] += ramp * weight * row[1 + n1 + j]
    return weight * row[0]


@kernel
def rise(t, duration):
    """Growth of the elevation: half a cosine from 0 at t = 0 to 1 at t = duration; 1 if duration is
    0."""
    if duration <= 0.0 or t >= duration:
        return 1.0
    return 0.5 - 0.5 * cos(pi * max(t, 0.0) / duration)


@kernel
def rows_at(x, rows):
    """First row to read at x, and the number of rows."""
    node = floor(x + 0.5)
    if abs(x - node) < _NODE and 0 <= node < rows:
        return node, 1
    return min(max(floor(x) - STENCIL_POINTS // 2 + 1, 0), rows - STENCIL_POINTS), STENCIL_POINTS


@kernel
def lagrange(x, m, points):
    """Weight at x of the value at m, among the values at 0, 1, ... points - 1."""
    weight = 1.0
    for j in range(points):
        if j != m:
            weight *= (x - j) / (m - j)
    return weight


# Sums of harmonic loads in time, by FFT over the repeat period.

_PHASE_STEP = 0.25
"""Largest omega * step [rad] of a grid; it bounds the interpolation error."""

_FINE = 0.125
"""omega * step [rad] of a grid that is fine enough for stages between its points."""

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
        is_chosen = (chosen >= self.first) & (chosen < self.columns.stop)
        first = int(np.searchsorted(chosen, self.first))
        return SpectralLines(self.omega, self.amplitude[:, chosen[is_chosen] - self.first], first)

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
    is within ``missed`` of a sea's standard deviation."""
    whole = max((_interpolation_error(omega, size, block) for omega, size in seas), default=0.0)
    return block / max(int(np.ceil((whole / missed) ** (1.0 / 6.0))), 1)


def _interpolation_error(omega: np.ndarray, amplitude: np.ndarray, step: float) -> float:
    """Interpolation error of a sum of waves over its standard deviation."""
    errors = amplitude * 225.0 / 46080.0 * (omega * step) ** 6
    return float(np.linalg.norm(errors) / max(np.linalg.norm(amplitude), np.finfo(float).tiny))


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


# Elevation at points, after a run or without a run.

_ENOUGH = 100  # fewest times for a transform
_WHOLE = 1e-9  # of a step: distance from a multiple below which a time is that multiple


def elevation_at(waves: WaveComponents, x: float, y: float, time: np.ndarray) -> np.ndarray:
    """Elevation (nt,) [m] of one set at a point, at ``time`` (nt,) [s], by direct summation."""
    growth = np.array([rise(t, waves.ramp) for t in time])
    return growth * _sum_components_directly(waves, waves.amplitudes_at(x, y)[None], time)[:, 0]


def elevations(sets: Sequence[WaveComponents], points: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Elevation (nt, n) [m] of the sum of ``sets`` at ``points`` (n, 2) [m] and ``time`` (nt,) [s].

    Computed by FFT if the times are multiples of an integer fraction of a set's repeat period,
    otherwise by direct summation. Both are equally exact.
    """
    total = np.zeros((time.size, len(points)))
    for waves in sets:
        amplitude = np.array([waves.amplitudes_at(x, y) for x, y in points]).reshape(
            len(points), -1
        )
        growth = np.array([rise(t, waves.ramp) for t in time])
        total += growth[:, None] * _sum_components(waves, amplitude, time)
    return total


def _sum_components(waves: WaveComponents, amplitude: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Re sum of ``amplitude`` (n, nw) e^(i w t), (nt, n)."""
    if waves.spacing == 0.0 or time.size < _ENOUGH:
        return _sum_components_directly(waves, amplitude, time)
    repeat = 2.0 * np.pi / waves.spacing
    parts = repeat / float(np.median(np.diff(time)))
    period = round(parts)
    if abs(parts - period) > _WHOLE * period:
        return _sum_components_directly(waves, amplitude, time)
    step = repeat / period
    lines = np.zeros((len(amplitude), period), dtype=complex)
    for row, values in zip(lines, amplitude, strict=True):
        np.add.at(row, waves.index % period, period * values)
    index = np.rint(time / step).astype(np.int64)
    steady = scipy.fft.ifft(lines).real[:, index % period].T
    off = np.abs(time - index * step) > _WHOLE * step
    steady[off] = _sum_components_directly(waves, amplitude, time[off])
    return steady


def _sum_components_directly(
    waves: WaveComponents, amplitude: np.ndarray, time: np.ndarray
) -> np.ndarray:
    sums = np.empty((time.size, len(amplitude)))
    for row, t in zip(sums, time, strict=True):
        row[:] = np.sum(amplitude * np.exp(1j * waves.omega * t), axis=1).real
    return sums
