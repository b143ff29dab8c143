"""What bodies hold: mass and its first and second moments about the body's origin, at a time.

Fluids are as solid ice in a body of which they are part, but that their free surfaces stay level.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.rigid.kinematics import Bodies


class Contents(NamedTuple):
    """``mass`` m (nb,) [kg]; ``moment`` m c (nb, 3) [kg m], c from the body's origin to the centre
    of gravity, in the body frame; ``surface`` (nb, 3) [kg m^2], density times the second moments
    xx, xy, yy of all free surfaces about their own centroids."""

    mass: np.ndarray
    moment: np.ndarray
    surface: np.ndarray


def new_contents(bodies: Bodies) -> Contents:
    """Those of bodies that hold nothing besides themselves."""
    nb = bodies.each.size
    return Contents(bodies.each["mass"].copy(), np.zeros((nb, 3)), np.zeros((nb, 3)))
