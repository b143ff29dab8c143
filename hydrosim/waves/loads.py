"""Wave loads at a time: the arrays that `build` fills and the kernel that reads them.

An irregular sea is a table on the solver's stage grid. A read at a node is exact; between the
nodes it is a 6-point Lagrange interpolation, whose error for a component of frequency w on a table
of step h is at most 225/46080 (w h)^6 of its amplitude. The tables keep w h below 0.25, so this is
below 1.2e-6 at the highest frequency and falls with the sixth power. A regular wave is exact.
"""

from __future__ import annotations

from math import cos, floor, pi, sin
from typing import NamedTuple

import numpy as np

from hydrosim.kernels import kernel

POINTS = 6
"""Rows of a table that an interpolation reads."""

_NODE = 1e-9  # of a step: closer than this to a node is at the node


class WaveLoads(NamedTuple):
    """Wave loads of a scene: those of each wave train are a weighted sum of rows of ``values``.

    A row is the elevation at the earth's origin [m], the first-order loads on the DOFs
    ``first_dof`` (n1,) and the second-order loads on ``second_dof`` (n2,). Train k has the rows
    offset[k] to offset[k + 1] and grows over ``ramp`` (ntrain,) [s]. With x = (t - start) / step,
    an irregular train has its loads at x = 0, 1, 2, ... in its rows; a ``regular`` one has step
    1 / w, so that x is its angle, and three rows, with the weights cos x, -sin x and 1.
    """

    start: np.ndarray
    step: np.ndarray
    ramp: np.ndarray
    regular: np.ndarray
    offset: np.ndarray
    values: np.ndarray
    first_dof: np.ndarray
    second_dof: np.ndarray


@kernel
def wave_loads(t, p, first, second):
    """Elevation at the earth's origin [m] at time t; adds the loads to first and second (n,).

    Only for times of the run that `build.wave_loads_model` was given.
    """
    n1, n2 = p.first_dof.size, p.second_dof.size
    elevation = 0.0
    for k in range(p.ramp.size):
        ramp = rise(t, p.ramp[k])
        x = (t - p.start[k]) / p.step[k]
        regular = p.regular[k]
        row, points = _rows_at(x, p.offset[k + 1] - p.offset[k], regular)
        for m in range(points):
            weight = ramp * (_rotating(x, m) if regular else _lagrange(x - row, m, points))
            i = p.offset[k] + row + m
            elevation += weight * p.values[i, 0]
            for j in range(n1):
                first[p.first_dof[j]] += weight * p.values[i, 1 + j]
            for j in range(n2):
                second[p.second_dof[j]] += ramp * weight * p.values[i, 1 + n1 + j]
    return elevation


@kernel
def rise(t, duration):
    """Growth of the elevation: half a cosine from 0 at t = 0 to 1 at t = duration, if not 0."""
    if duration <= 0.0 or t >= duration:
        return 1.0
    return 0.5 - 0.5 * cos(pi * max(t, 0.0) / duration)


@kernel
def _rows_at(x, rows, regular):
    """First of the rows to read at x, and their number."""
    node = floor(x + 0.5)
    if regular:
        return 0, rows
    if abs(x - node) < _NODE and 0 <= node < rows:
        return node, 1
    return min(max(floor(x) - POINTS // 2 + 1, 0), rows - POINTS), POINTS


@kernel
def _lagrange(x, m, points):
    """Weight at x of the value at m, out of the values at 0, 1, ... points - 1."""
    weight = 1.0
    for j in range(points):
        if j != m:
            weight *= (x - j) / (m - j)
    return weight


@kernel
def _rotating(x, m):
    """Weight of row m of a regular wave: real part, imaginary part, mean."""
    if m == 0:
        return cos(x)
    return -sin(x) if m == 1 else 1.0
