"""Elevation at points, after a run or without one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hydrosim.waves.components import Components
from hydrosim.waves.loads import rise

_BLOCK = 128  # times that share a table of e^(i w t)


def elevation_at(waves: Components, x: float, y: float, time: np.ndarray) -> np.ndarray:
    """Elevation (nt,) [m] of one set at a point, at ``time`` (nt,) [s]."""
    return elevations([waves], np.array([[x, y]]), time)[:, 0]


def elevations(sets: Sequence[Components], points: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Elevation (nt, n) [m] of the sum of ``sets`` at ``points`` (n, 2) [m] and ``time`` (nt,) [s].

    A direct sum over the components at any times, in blocks: e^(i w t) is e^(i w t0) of a block
    times a table of e^(i w (t - t0)), which blocks of equally spaced times have in common.
    """
    total = np.zeros((time.size, len(points)))
    for waves in sets:
        growth = np.array([rise(t, waves.ramp) for t in time])
        total += growth[:, None] * _steady(waves, points, time)
    return total


def _steady(waves: Components, points: np.ndarray, time: np.ndarray) -> np.ndarray:
    amplitude = np.array([waves.at(x, y) for x, y in points]).reshape(len(points), -1)
    found, shared = np.empty((time.size, len(points))), np.empty(0)
    for first in range(0, time.size, _BLOCK):
        block = time[first : first + _BLOCK]
        since = block - block[0]
        if shared.size < since.size or not _same(shared[: since.size], since, block[-1]):
            shared, table = since, np.exp(1j * np.outer(waves.omega, since))
        there = amplitude * np.exp(1j * waves.omega * block[0])
        found[first : first + _BLOCK] = (there @ table[:, : since.size]).real.T
    return found


def _same(one: np.ndarray, other: np.ndarray, time: float) -> bool:
    """True if times since the beginning of a block differ by no more than the rounding of time."""
    return bool(np.abs(one - other).max() <= 4.0 * np.spacing(abs(time)))
