"""Solutions of equations of motion that are not hydrosim's, by an 8th-order method."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import solve_ivp

Equations = Callable[[float, np.ndarray], ArrayLike]


def solved(equations: Equations, start: ArrayLike, time: np.ndarray) -> np.ndarray:
    """States (n, nt) of ``equations`` y' = f(t, y) at ``time``, by DOP853 (Hairer) at 1e-13."""
    begin = np.asarray(start, float)
    span = (time[0], time[-1])
    found = solve_ivp(equations, span, begin, "DOP853", time, rtol=1e-13, atol=1e-14)
    assert found.success
    return np.asarray(found.y)


def skew(w: np.ndarray) -> np.ndarray:
    """The matrix of w x."""
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


def about(axis: int, angle: np.ndarray | float) -> np.ndarray:
    """Rotation matrices (..., 3, 3) about x, y or z (axis 0, 1, 2)."""
    c, s = np.cos(angle), np.sin(angle)
    j, k = (axis + 1) % 3, (axis + 2) % 3
    R = np.zeros((*np.shape(angle), 3, 3), dtype=np.result_type(c, float))
    R[..., axis, axis] = 1.0
    R[..., j, j] = R[..., k, k] = c
    R[..., j, k], R[..., k, j] = -s, s
    return R
