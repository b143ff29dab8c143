"""A radiation problem with closed forms: K^(s) = R s / ((s + a)^2 + b^2).

K(t) = R exp(-a t) (cos b t - a/b sin b t), B(w) = Re K^(i w), A(w) = A_inf + Im K^(i w) / w. As in
water, B(0) = 0; B falls with w^-2.
"""

import numpy as np

DECAY, FREQUENCY, INFINITE = 0.3, 0.8, 5.0


def kernel(time: np.ndarray) -> np.ndarray:
    """K (nt, 1, 1)."""
    wave = np.cos(FREQUENCY * time) - DECAY / FREQUENCY * np.sin(FREQUENCY * time)
    return (np.exp(-DECAY * time) * wave)[:, None, None]


def transfer(w: np.ndarray) -> np.ndarray:
    """K^(i w) (nw, 1, 1)."""
    s = 1j * w
    return (s / ((s + DECAY) ** 2 + FREQUENCY**2))[:, None, None]


def added_mass(w: np.ndarray) -> np.ndarray:
    """A (nw, 1, 1)."""
    return INFINITE + transfer(w).imag / w[:, None, None]
