"""Friction with a slope: viscous at small velocity, saturated at large velocity, as in aNySIM's
fender.

    f = -min(mu N, b |v|) v / |v|

v: velocity of the body's point relative to the plane; b: friction slope [N s/m]. Below |v| = mu N/b
("stick") the point creeps; above it ("slip") mu N opposes the velocity. The corner between is an
event, and each mode has one branch. If steps do not end at events, the smaller of both is taken at
every evaluation. Dissipation f v; nothing is stored. Source: Plasterk (2017), section 4.2.
"""

from __future__ import annotations

import numpy as np

from hydrosim.elements.contact.law import (
    AT_REST,
    OPEN,
    SLIP,
    STICK,
    Constants,
    Friction,
    direction,
    size_along,
)
from hydrosim.jit.kernels import kernel
from hydrosim.multibody.vectors import length
from hydrosim.scene.contacts import FrictionSlope


def constants(law: FrictionSlope) -> Constants:
    """mu as both coefficients, and b in place of a damping."""
    return Constants(law.coefficient, law.coefficient, damping=law.slope)


@kernel
def friction(mode, load, v1, s, p):
    """Friction of a contact point in ``mode``; mu is ``p.kinetic``, b is ``p.damping``. Slip
    continues in the half plane of its heading ``s`` (2,), so that it is smooth through rest."""
    speed = length(v1)
    if mode == OPEN or speed == 0.0:
        return Friction((0.0, 0.0), (0.0, 0.0), 0.0, 0.0, 0.0, 0.0)
    along = (v1[0] / speed, v1[1] / speed)
    size, d = p.kinetic * load.N, direction(v1, s, AT_REST)
    if p.saturates:
        size, d = min(max(size, 0.0), p.damping * speed), along
    elif mode == STICK:
        size, d = p.damping * speed, along
    power = size * (d[0] * v1[0] + d[1] * v1[1])
    return Friction((-size * d[0], -size * d[1]), (0.0, 0.0), speed, power, 0.0, 0.0)


@kernel
def margin(mode, load, v1, heading, p):
    """Distance of the point from the corner mu N = b |v| [N]. Negative past it, and where the
    velocity has reversed relative to its ``heading`` (2,) at the start of the step."""
    if mode == STICK:
        return p.kinetic * load.N - p.damping * length(v1)
    return p.damping * size_along(v1, heading) - p.kinetic * load.N


@kernel
def break_away(v):
    """Slip begins along the velocity."""
    return direction(v, (0.0, 0.0), AT_REST), 0.0, 0.0


@kernel
def begin_contact(load, v, p):
    """Contact begins in the mode that fits the speed, with its heading."""
    return (STICK if margin(STICK, load, v, (0.0, 0.0), p) >= 0.0 else SLIP), break_away(v)[0]


def corner_speed(N: float, p: np.void) -> float:
    """The speed [m/s] of the corner, mu N / b."""
    return float(p["kinetic"] * max(N, 0.0) / p["damping"])
