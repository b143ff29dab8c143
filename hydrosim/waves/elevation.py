"""Elevation at points, after a run or without a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import scipy

from hydrosim.waves.loads import rise

if TYPE_CHECKING:
    from hydrosim.waves.components import WaveComponents

_ENOUGH = 100  # fewest times for a transform
_WHOLE = 1e-9  # of a step: distance from a multiple below which a time is that multiple


def elevation_at(waves: WaveComponents, x: float, y: float, time: np.ndarray) -> np.ndarray:
    """Elevation (nt,) [m] of one set at a point, at ``time`` (nt,) [s], by direct summation."""
    growth = np.array([rise(t, waves.ramp) for t in time])
    return growth * _direct(waves, waves.amplitudes_at(x, y)[None], time)[:, 0]


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
        total += growth[:, None] * _steady(waves, amplitude, time)
    return total


def _steady(waves: WaveComponents, amplitude: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Re sum of ``amplitude`` (n, nw) e^(i w t), (nt, n)."""
    if waves.spacing == 0.0 or time.size < _ENOUGH:
        return _direct(waves, amplitude, time)
    repeat = 2.0 * np.pi / waves.spacing
    parts = repeat / float(np.median(np.diff(time)))
    period = round(parts)
    if abs(parts - period) > _WHOLE * period:
        return _direct(waves, amplitude, time)
    step = repeat / period
    lines = np.zeros((len(amplitude), period), dtype=complex)
    for row, values in zip(lines, amplitude, strict=True):
        np.add.at(row, waves.index % period, period * values)
    index = np.rint(time / step).astype(np.int64)
    found = scipy.fft.ifft(lines).real[:, index % period].T
    off = np.abs(time - index * step) > _WHOLE * step
    found[off] = _direct(waves, amplitude, time[off])
    return found


def _direct(waves: WaveComponents, amplitude: np.ndarray, time: np.ndarray) -> np.ndarray:
    found = np.empty((time.size, len(amplitude)))
    for row, t in zip(found, time, strict=True):
        row[:] = np.sum(amplitude * np.exp(1j * waves.omega * t), axis=1).real
    return found
