"""What a function of the user sees of the bodies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

ORIGIN = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class BodyState:
    """Motion of a body at one time, as in the dataset of a run.

    ``position`` (6,) [m, rad]: displacement of the centre of gravity from rest, along the earth's
    axes; roll, pitch and yaw. ``velocity`` (6,) [m/s, rad/s]: of the centre of gravity, and the
    angular velocity, in the earth frame. ``rotation`` (3, 3) turns vectors of the body frame into
    the earth frame, heading included. ``reference`` (3,) [m]: the centre of gravity at rest, in the
    earth frame; it cannot be changed. With small angles (``exact`` false) lever arms stay as they
    are at rest.
    """

    name: str
    position: np.ndarray
    velocity: np.ndarray
    rotation: np.ndarray
    reference: np.ndarray
    exact: bool = True

    def place(self, point: ArrayLike = ORIGIN) -> np.ndarray:
        """Place (3,) [m] in the earth frame of a ``point`` (3,) [m] of the body frame, from the
        centre of gravity."""
        centre = self.reference + self.position[:3]
        return np.asarray(centre + self.rotation @ np.asarray(point, float))

    def velocity_of(self, point: ArrayLike) -> np.ndarray:
        """Velocity (3,) [m/s] in the earth frame of a ``point`` (3,) [m] of the body frame."""
        turning = np.cross(self.velocity[3:], self.arm(point))
        return np.asarray(self.velocity[:3] + turning)

    def wrench(self, force: ArrayLike, point: ArrayLike = ORIGIN) -> np.ndarray:
        """Wrench (6,) [N, N m] about the centre of gravity of a ``force`` (3,) [N] in the earth
        frame on a ``point`` (3,) [m] of the body frame."""
        return np.concatenate(
            [np.asarray(force, float), np.cross(self.arm(point), np.asarray(force, float))]
        )

    def arm(self, point: ArrayLike) -> np.ndarray:
        """Lever arm (3,) [m] of a ``point`` of the body frame, along the earth's axes."""
        arm = np.asarray(point, float)
        return np.asarray(self.rotation @ arm) if self.exact else arm


def read_only(values: np.ndarray) -> np.ndarray:
    """A copy of an array that cannot be changed."""
    copied = np.array(values, float)
    copied.flags.writeable = False
    return copied


def body_states(
    names: Sequence[str],
    references: Sequence[np.ndarray],
    coordinates: np.ndarray,
    velocity: np.ndarray,
    rotation: np.ndarray,
    exact: bool,
) -> Mapping[str, BodyState]:
    """The state of each body by name. ``coordinates`` and ``velocity`` (6 nb,), ``rotation``
    (9 nb,) are copied; ``references`` (3,) are not."""
    place = coordinates.reshape(-1, 6).copy()
    speed = velocity.reshape(-1, 6).copy()
    turn = rotation.reshape(-1, 3, 3).copy()
    return {
        name: BodyState(name, place[b], speed[b], turn[b], references[b], exact)
        for b, name in enumerate(names)
    }
