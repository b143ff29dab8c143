"""Contents of the bodies at a time: mass and its first and second moments about the body's origin.

Fluids move rigidly with the body, except that their free surfaces may stay level.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from hydrosim.rigid.kinematics import Bodies


class Contents(NamedTuple):
    """Mass properties of all bodies with their contents.

    Weight: ``mass`` m (nb,) [kg] and ``moment`` m c (nb, 3) [kg m], c from the body's origin to the
    centre of gravity in the body frame with all surfaces level in the body. ``shift`` (nb, 3) [kg
    m] is added by surfaces that are level in the earth, each at a ``height`` (nl,) [m] above the
    body's origin (`hydrosim.tanks.surface`). ``surface`` (nb, 3) [kg m^2] is density times the
    second moments xx, xy, yy of all other free surfaces about their own centroids.

    Inertia: ``moving_mass`` (nb,), ``moving_moment`` (nb, 3) and ``inertia`` (nb, 3, 3) about the
    origin.
    """

    mass: np.ndarray
    moment: np.ndarray
    shift: np.ndarray
    height: np.ndarray
    surface: np.ndarray
    moving_mass: np.ndarray
    moving_moment: np.ndarray
    inertia: np.ndarray


def new_contents(bodies: Bodies, surfaces: int) -> Contents:
    """Contents of the bodies at the start, with this number of level ``surfaces``."""
    each = bodies.each
    nothing = np.zeros((each.size, 3))
    return Contents(
        mass=each["mass"].copy(),
        moment=nothing,
        shift=nothing.copy(),
        height=np.zeros(surfaces),
        surface=each["surface"].copy(),
        moving_mass=each["mass"].copy(),
        moving_moment=nothing.copy(),
        inertia=each["inertia"].copy(),
    )
