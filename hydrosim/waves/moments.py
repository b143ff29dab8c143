"""Roll and pitch moments of first-order waves on a body that yaws.

    M = R(psi - psi_w) M_w

M_w: moments about horizontal axes, in the earth's axes, for the yaw psi_w at which the waves meet
the body: its yaw at rest, or that of its slow path; psi: its present yaw; R: rotation about the
vertical.

The pitch moment of a long hull is many times its roll moment and keeps to the hull's own axis. In
the axes of psi_w, a yaw of 1 deg would turn 1.7 % of it into roll, which resonates. Hulls that are
about as broad as long keep their moments in the earth's axes: there the direction of the waves
counts. Horizontal forces are not turned, because in long waves they point along the waves.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.jit.kernels import kernel

if TYPE_CHECKING:
    from hydrosim.waves.body import WaveBody
    from hydrosim.waves.transfer import TransferFunctions

LONG_HULL_MOMENT_RATIO = 2.0
"""Ratio of pitch to roll moments, or the reverse, above which moments turn with the hull. The loss
by keeping them in either axes is the same at 2.3, for moments of the first harmonic of heading."""


def turned_bodies(bodies: Sequence[WaveBody]) -> np.ndarray:
    """Indices (nm,) of the bodies whose first-order moments turn with their yaw."""
    long = {
        body.index
        for body in bodies
        if body.database is not None and body.wave_forces.first_order and is_long(body.database)
    }
    return np.array(sorted(long), dtype=np.int64)


def is_long(database: TransferFunctions) -> bool:
    """True if roll and pitch moments are of different size over all waves of the database."""
    sizes = np.sqrt(np.mean(np.abs(database.excitation[..., 3:5]) ** 2, axis=(0, 1)))
    return bool(sizes.max() > LONG_HULL_MOMENT_RATIO * sizes.min())


@kernel
def turn_moments(bodies, coordinates, met, load):
    """Turn the moments of ``load`` (6 nb,) from the yaws ``met`` (nb,) of the ``bodies`` (nm,) to
    their present ones, in place."""
    for b in bodies:
        angle = coordinates[6 * b + 5] - met[b]
        c, s = cos(angle), sin(angle)
        roll, pitch = load[6 * b + 3], load[6 * b + 4]
        load[6 * b + 3] = c * roll - s * pitch
        load[6 * b + 4] = s * roll + c * pitch
