"""The cubic spline with two continuous derivatives through given points, not-a-knot at its ends (de
Boor 1978, chapter 4).

Equals scipy's ``CubicSpline``, which takes as long to load as half of a short run.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_banded


def interpolate_spline(x: np.ndarray, y: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The spline through ``y`` (n, ...), real or complex, at rising ``x`` (n,), n 2 or more.
    Returns its values (m, ...) ``at`` (m,) places between the first x and the last."""
    values = y.reshape(len(x), -1)
    if len(x) < 4:  # one polynomial
        found = np.vander(at, len(x)) @ np.linalg.solve(np.vander(x), values)
        return found.reshape(at.shape + y.shape[1:])
    h, slope = np.diff(x), slopes(x, values)
    i = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)
    u = ((at - x[i]) / h[i])[:, None]
    v, width = 1.0 - u, h[i, None]
    ends = v * v * (1.0 + 2.0 * u) * values[i] + u * u * (1.0 + 2.0 * v) * values[i + 1]
    found = ends + width * u * v * (v * slope[i] - u * slope[i + 1])
    return found.reshape(at.shape + y.shape[1:])


def slopes(x: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Derivatives (n, ...) at x (n,) of the spline through ``values`` (n, ...), n 4 or more."""
    y, h = values.reshape(len(x), -1), np.diff(x)
    rise, d = np.diff(y, axis=0) / h[:, None], x[2:] - x[:-2]
    bands, right = np.zeros((3, x.size)), np.empty_like(y, dtype=np.result_type(y, 1.0))
    bands[0, 2:], bands[1, 1:-1], bands[2, :-2] = h[:-1], 2.0 * d, h[1:]
    right[1:-1] = 3.0 * (h[1:, None] * rise[:-1] + h[:-1, None] * rise[1:])
    bands[1, 0], bands[0, 1] = h[1], d[0]
    right[0] = ((h[0] + 2.0 * d[0]) * h[1] * rise[0] + h[0] ** 2 * rise[1]) / d[0]
    bands[1, -1], bands[2, -2] = h[-2], d[-1]
    right[-1] = (h[-1] ** 2 * rise[-2] + (2.0 * d[-1] + h[-1]) * h[-2] * rise[-1]) / d[-1]
    return np.asarray(solve_banded((1, 1), bands, right)).reshape(values.shape)
