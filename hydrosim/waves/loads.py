"""Wave loads at a time: the arrays that `build` fills and the kernel that reads them.

Waves on a grid are a table on the solver's stage grid. A read at a node is exact. Between the nodes
it is a 6-point Lagrange interpolation. Its error for a component of frequency w on a table of step
h is at most 225/46080 (w h)^6 of its amplitude: (x^2 - 1/4) (x^2 - 9/4) (x^2 - 25/4) / 6!, with x
the steps from the middle of the 6 points, is largest in the middle. The tables keep w h below 0.25,
so the error is below 1.2e-6 at the highest frequency and falls with the sixth power.

If every second stage would suffice with w h below 0.125, only some of the stages are nodes. The
error at the other stages is below 1.9e-8. Waves off the grid are summed one by one, exactly.
"""

from __future__ import annotations

from math import cos, floor, pi, sin
from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import kernel, root_giving

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
    The first-order moments of the bodies ``turned`` (nm,) turn with their yaw, see `moments`.
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
