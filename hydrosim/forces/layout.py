"""What every force element gets when a scene is compiled: where things are in the arrays."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

HYDROSTATIC, RADIATION, WAVE_FIRST_ORDER, WAVE_SECOND_ORDER = range(4)
ROWS = ("hydrostatic", "radiation", "wave_first_order", "wave_second_order")


@dataclass(frozen=True)
class Layout:
    """Indices of bodies by name, rows of forces by element name, the first free entry of y.

    ``critical_damping`` (body, stiffness (6,)) -> (6,) is 2 sqrt(k (m + a(w_n))) per DOF.
    """

    body: dict[str, int]
    row: dict[str, int]
    state: int
    critical_damping: Callable[[int, np.ndarray], np.ndarray]
