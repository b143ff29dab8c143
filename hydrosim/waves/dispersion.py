"""Dispersion of linear gravity waves."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

_GUO = 2.4908  # exponent of Guo's closed form
_NEWTON_STEPS = 3  # Guo's form is within 0.75 %, and each step squares the error


def wavenumber(omega: ArrayLike, depth: float, gravity: float) -> np.ndarray:
    """Wavenumber k [1/m] with omega^2 = g k tanh(k depth), for ``omega`` [rad/s] of any shape.

    ``depth`` [m] may be infinite. Newton's method on k h tanh(k h) = omega^2 h / g starts from the
    closed form of Guo (2002, Coastal Engineering 45, eq. 21). The result is accurate to rounding.
    """
    deep = np.asarray(omega, dtype=float) ** 2 / gravity
    if np.isinf(depth):
        return deep
    target = deep * depth
    wet = target > 0.0
    y = np.where(wet, target, 1.0)
    kh = y * (-np.expm1(-(y ** (_GUO / 2.0)))) ** (-1.0 / _GUO)
    for _ in range(_NEWTON_STEPS):
        tanh = np.tanh(kh)
        kh -= (kh * tanh - y) / (tanh + kh * (1.0 - tanh * tanh))
    return np.where(wet, kh / depth, 0.0)
