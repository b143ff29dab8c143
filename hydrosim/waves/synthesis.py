"""Sums of the components of a wave train in time, by FFT over the repeat period."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import fft

from hydrosim.waves.components import Components
from hydrosim.waves.loads import POINTS

_PHASE_STEP = 0.25
"""Largest omega * step [rad] of a grid: it bounds the error of the interpolation."""


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


def time_grid(waves: Components, start: float, dt: float, duration: float) -> Grid:
    """The grid for a run from ``start`` over ``duration`` [s] whose stages are ``dt`` apart.

    The step is dt, or dt divided by a whole number where the highest component needs it; if the
    repeat period is no multiple of dt, it is the next smaller step of which it is one.
    """
    repeat = 2.0 * np.pi / waves.spacing
    divisions = int(np.ceil(waves.omega[-1] * dt / _PHASE_STEP))
    period = divisions * int(np.ceil(repeat / dt * (1.0 - 1e-9)))
    step = repeat / period
    first = int(np.floor(start / step)) - POINTS // 2
    last = int(np.ceil((start + duration) / step)) + POINTS // 2
    return Grid(step, period, first, last - first + 1)


def real_sum(grid: Grid, waves: Components, amplitude: np.ndarray) -> np.ndarray:
    """Re sum_i amplitude_i e^(i w_i t) on the grid, (rows, n), for ``amplitude`` (nw, n)."""
    lines = np.zeros(grid.period // 2 + 1, dtype=complex)
    total = np.empty((grid.rows, amplitude.shape[1]))
    for j in range(amplitude.shape[1]):
        lines[waves.index] = 0.5 * grid.period * amplitude[:, j]
        total[:, j] = grid.cut(fft.irfft(lines, grid.period))
    return total


def complex_sum(grid: Grid, waves: Components, amplitude: np.ndarray) -> np.ndarray:
    """sum_i amplitude_i e^(i w_i t) on the grid, (rows, n) complex, for ``amplitude`` (nw, n)."""
    lines = np.zeros(grid.period, dtype=complex)
    total = np.empty((grid.rows, amplitude.shape[1]), dtype=complex)
    for j in range(amplitude.shape[1]):
        lines[waves.index] = grid.period * amplitude[:, j]
        total[:, j] = grid.cut(fft.ifft(lines))
    return total


def newman_sum(
    grid: Grid, waves: Components, amplitude: np.ndarray, drift: np.ndarray
) -> np.ndarray:
    """Slow drift loads (rows, n) [N, N m] of one wave train by Newman's approximation.

    With ``amplitude`` (nw, n) the complex amplitudes of the elevation at the body and
    D = ``drift`` (nw, n) this is, for each load,

        sum_ij a_i a_j (D_i + D_j) / 2 cos(theta_i - theta_j) = Re{ conj(eta) G },
        eta = sum a e^(i theta), G = sum D a e^(i theta):

    the difference-frequency load with the arithmetic mean of the diagonal of the QTF (Newman
    1974), by two Fourier transforms instead of a double sum.
    """
    elevation = complex_sum(grid, waves, amplitude)
    return (elevation.conj() * complex_sum(grid, waves, drift * amplitude)).real
