"""No friction: a point in contact always slips, free of any force in the plane."""

from __future__ import annotations

from hydrosim.elements.contact.law import SLIP, Constants, Friction
from hydrosim.jit.kernels import kernel
from hydrosim.multibody.vectors import length
from hydrosim.scene.contacts import Frictionless


def constants(law: Frictionless) -> Constants:
    """No constants."""
    return Constants()


@kernel
def friction(mode, load, v, s, p):
    """Zero force; the slip distance is counted."""
    speed = length(v) if mode == SLIP else 0.0
    return Friction((0.0, 0.0), (0.0, 0.0), speed, 0.0, 0.0, 0.0)


@kernel
def margin(mode):
    """Stick ends as soon as it begins."""
    return 1.0 if mode == SLIP else -1.0
