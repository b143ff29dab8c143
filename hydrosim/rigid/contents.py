"""What bodies hold: mass and its first and second moments about the body's origin, at a time.

Fluids are part of the body as ice would be, but that their free surfaces may stay level.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from hydrosim.rigid.kinematics import Bodies


class Contents(NamedTuple):
    """Of the weight: ``mass`` m (nb,) [kg], ``moment`` m c (nb, 3) [kg m], c from the body's origin
    to the centre of gravity in the body frame, and ``surface`` (nb, 3) [kg m^2], density times the
    second moments xx, xy, yy of all free surfaces about their own centroids. Of the inertia: mass,
    moment and ``inertia`` (nb, 3, 3) about the origin."""

    mass: np.ndarray
    moment: np.ndarray
    surface: np.ndarray
    moving_mass: np.ndarray
    moving_moment: np.ndarray
    inertia: np.ndarray


def new_contents(bodies: Bodies) -> Contents:
    """Those of the bodies at the start."""
    each, nothing = bodies.each, np.zeros((bodies.each.size, 3))
    of_weight = (each["mass"].copy(), nothing, each["surface"].copy())
    return Contents(*of_weight, each["mass"].copy(), nothing.copy(), each["inertia"].copy())
