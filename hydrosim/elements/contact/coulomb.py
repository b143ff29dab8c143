"""Coulomb's friction, rigid: a sticking point does not move at all.

    stick   v = 0 by a reaction in the plane              until |reaction| = mu_s N
    slip    f = -mu_k N d,  d = v / |v|                   until v = 0

v: velocity of the body's point relative to the plane. A held point is a constraint on the
accelerations, J q'' = c, whose force is the reaction (`hydrosim.multibody.constraints`). It holds
in those directions of the plane in which the point could move. Slip begins against the last
reaction, and continues in the half plane of its heading, so that it is smooth through its end.
Dissipation mu_k N |v|; nothing is stored.

Limits: if several held points over-determine a rigid body, their shares are not defined; such
scenes are refused. If slip in the plane is driven sideways, it stops with a turn that is not
smooth, and the order drops at such a stop.
"""

from __future__ import annotations

from math import atan2, cos, sin

import numpy as np

from hydrosim.elements.contact.geometry import add_contact_wrench, tangential_bias
from hydrosim.elements.contact.law import AT_REST, SLIP, STICK, Constants, Friction, direction
from hydrosim.jit.kernels import clear, kernel
from hydrosim.modes import NO_INDEX
from hydrosim.multibody.kinematics import generalised_force
from hydrosim.multibody.vectors import length
from hydrosim.scene.contacts import Coulomb

STOPPED = 1e-6  # of the speed by which the end of slip was located: slip has come to rest
RANK_RTOL = 1e-12  # of the larger: smaller components are no direction of motion


def constants(law: Coulomb) -> Constants:
    """The coefficients alone."""
    return Constants(law.static, law.kinetic)


@kernel
def friction(mode, load, v, heading, p):
    """Friction of a contact point in slip; in stick it is the reaction, computed elsewhere."""
    if mode != SLIP:
        return Friction((0.0, 0.0), (0.0, 0.0), 0.0, 0.0, 0.0, 0.0)
    d = direction(v, heading, AT_REST)
    speed = length(v)
    size = p.kinetic * load.N
    power = size * (d[0] * v[0] + d[1] * v[1])
    return Friction((-size * d[0], -size * d[1]), (0.0, 0.0), speed, power, 0.0, 0.0)


@kernel
def margin(mode, load, v, heading, reaction, p):
    """Quantity that becomes negative where the ``mode`` of the contact point ends. In stick it is
    the static limit mu_s N minus the size of the reaction [N]. In slip it is the component of the
    velocity ``v`` along the direction of slip ``heading`` [m/s]."""
    if mode == STICK:
        return p.static * load.N - length(reaction)
    return v[0] * heading[0] + v[1] * heading[1]


@kernel
def break_away(reaction):
    """Slip begins against the last reaction, if there was one."""
    size = length(reaction)
    if size == 0.0:
        return (0.0, 0.0), 0.0, 0.0
    return (-reaction[0] / size, -reaction[1] / size), 0.0, 0.0


@kernel
def end_slip(size, v, s):
    """Slip ends, unless the point has only turned out of the half plane of its heading."""
    speed = length(v)
    return (
        (STICK, s)
        if speed <= max(STOPPED * size, AT_REST)
        else (SLIP, (v[0] / speed, v[1] / speed))
    )


@kernel
def begin_contact(v):
    """Contact begins in slip, unless the point is at rest."""
    return (STICK if length(v) <= AT_REST else SLIP), direction(v, (0.0, 0.0), AT_REST)


def slip_heading(velocity: np.ndarray) -> np.ndarray:
    """The heading (2,) of a velocity."""
    return velocity / max(np.hypot(*velocity), 1e-12)


@kernel
def add_constraints(i, point, contact, bodies, motion, wrench, rows, holds):
    """Add the constraints that hold point ``i`` to ``rows``; ``wrench`` (6 nb,) is scratch."""
    r = rows.number[0]
    bias = tangential_bias(point, contact, bodies, motion)
    for a in range(2):
        along = (1.0, 0.0) if a == 0 else (0.0, 1.0)
        clear(wrench)
        add_contact_wrench(point, contact, 0.0, along, wrench)
        generalised_force(bodies, motion, wrench, rows.J[r + a])
        holds.point[r + a] = i
        holds.lock[r + a] = NO_INDEX
        holds.motion[r + a] = NO_INDEX
        holds.residual[r + a] = 0.0
        holds.direction[r + a, 0], holds.direction[r + a, 1] = along
        rows.bound[r + a] = -bias[a]
    rows.number[0] += _count_independent(r, rows, holds)


@kernel
def _count_independent(r, rows, holds):
    """Number of independent directions in row ``r`` and the next; if it is one, row r has it."""
    g11 = 0.0
    g12 = 0.0
    g22 = 0.0
    for j in range(rows.J.shape[1]):
        g11 += rows.J[r, j] * rows.J[r, j]
        g12 += rows.J[r, j] * rows.J[r + 1, j]
        g22 += rows.J[r + 1, j] * rows.J[r + 1, j]
    if g11 + g22 == 0.0:
        return 0
    if g11 * g22 - g12 * g12 > RANK_RTOL * (g11 + g22) ** 2:
        return 2
    angle = 0.5 * atan2(2.0 * g12, g11 - g22)
    u1 = cos(angle)
    u2 = sin(angle)
    # along the second axis: the same one of two signs each time, so that rows are smooth
    if u2 < -u1:
        u1 = -u1
        u2 = -u2
    for j in range(rows.J.shape[1]):
        rows.J[r, j] = u1 * rows.J[r, j] + u2 * rows.J[r + 1, j]
    rows.bound[r] = u1 * rows.bound[r] + u2 * rows.bound[r + 1]
    holds.direction[r, 0] = u1
    holds.direction[r, 1] = u2
    return 1


@kernel
def collect_reactions(rows, holds):
    """Compute the reactions of all points from the forces of their constraints ``rows``."""
    clear(holds.reaction.reshape(holds.reaction.size))
    for r in range(rows.number[0]):
        for a in range(2 if holds.point[r] != NO_INDEX else 0):
            force = rows.force[r] * holds.direction[r, a]
            holds.reaction[holds.point[r], a] += force
