"""Properties of a body that wave loads depend on, and wave moments on a body that yaws.

Roll and pitch moments of first-order waves on a body that yaws.

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
from dataclasses import dataclass, replace
from math import cos, sin
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.dofs import about_z, loads_about_z
from hydrosim.jit.kernels import kernel

if TYPE_CHECKING:
    from hydrosim.scene import WaveForces
    from hydrosim.water.components import WaveComponents
    from hydrosim.water.second_order import QuadraticFunctions
    from hydrosim.water.transfer import TransferFunctions


@dataclass(frozen=True, eq=False)
class WaveBody:
    """A body in waves.

    ``database``: transfer functions of n loads about the centre of gravity, for all headings, in
    the body's heading axes; None for a dry body. ``location`` (2,): origin of the database's frame
    at rest, in the earth's x, y [m]. ``centre`` (2,): centre of gravity in that frame. ``offset``:
    index of the body's first DOF among those of the scene. ``active`` (n,): true for DOFs that are
    not locked. ``heading``: heading of the database's frame at rest [rad]. ``owner``: index of the
    scene's body, if these loads are one share of several.
    """

    database: QuadraticFunctions | None
    location: tuple[float, ...]
    wave_forces: WaveForces
    offset: int
    active: np.ndarray
    centre: tuple[float, ...] = (0.0, 0.0)
    heading: float = 0.0
    owner: int | None = None

    @property
    def index(self) -> int:
        """Index of the body among those of the scene."""
        return self.offset // 6 if self.owner is None else self.owner

    def place(self) -> tuple[float, float]:
        """Centre of gravity at rest in the earth's x, y [m]."""
        x, y, _ = about_z(self.heading) @ (*self.centre[:2], 0.0)
        return self.location[0] + x, self.location[1] + y

    def moved_by(self, at: np.ndarray) -> WaveBody:
        """The body displaced by (6,): moved, and turned by its yaw about its centre of gravity."""
        heading = self.heading + at[5]
        frame = np.array(self.place()) + at[:2] - (about_z(heading) @ (*self.centre[:2], 0.0))[:2]
        return replace(self, heading=heading, location=tuple(frame))

    def relative_waves(self, waves: WaveComponents) -> WaveComponents:
        """The waves with their headings relative to the body at rest."""
        return (
            waves if self.heading == 0.0 else replace(waves, heading=waves.heading - self.heading)
        )

    def in_earth_axes(self, loads: np.ndarray) -> np.ndarray:
        """Loads (..., n) turned from heading axes to the earth's; forces and moments alternate in
        threes."""
        return loads if self.heading == 0.0 else loads_about_z(loads, self.heading)


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
