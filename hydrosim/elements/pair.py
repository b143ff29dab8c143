"""A body relative to another, the earth or a stream: lines between points, rotation, velocity."""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING, NamedTuple

from hydrosim.elements.contact.geometry import EARTH
from hydrosim.jit.kernels import kernel
from hydrosim.multibody.kinematics import add_wrench, attachment, point_velocity
from hydrosim.multibody.vectors import cross, dot, matvec, product, scale, sub, vector
from hydrosim.water.current import current_on_hull

if TYPE_CHECKING:
    from hydrosim.elements.kind import Layout


class LineOfAction(NamedTuple):
    """A line between two points: lever arms of its ends, the ``direction`` from the first to the
    other, in the earth frame, its ``length`` [m] and the ``rate`` [m/s] of that."""

    arm: tuple[float, float, float]
    other_arm: tuple[float, float, float]
    direction: tuple[float, float, float]
    length: float
    rate: float


@kernel
def line_between(body, point, other, place, bodies, motion):
    """The line from a ``point`` of a body to a ``place`` of the other side. Where the ends meet, it
    has no direction."""
    p, arm = attachment(body, point, bodies, motion)
    v = point_velocity(body, arm, motion)
    a = place
    w = (0.0, 0.0, 0.0)
    other_arm = (0.0, 0.0, 0.0)
    if other != EARTH:
        a, other_arm = attachment(other, place, bodies, motion)
        w = point_velocity(other, other_arm, motion)
    d = sub(a, p)
    length = sqrt(dot(d, d))
    e = scale(1.0 / length if length > 0.0 else 0.0, d)
    return LineOfAction(arm, other_arm, e, length, dot(e, sub(w, v)))


@kernel
def relative_turn_rate(body, other, motion):
    """Angular velocity of a body relative to the other side, in the earth frame."""
    omega = vector(motion.velocity, 6 * body + 3)
    if other == EARTH:
        return omega
    return sub(omega, vector(motion.velocity, 6 * other + 3))


@kernel
def relative_small_turn(body, other, motion):
    """Rotation vector of a body relative to the other side, with small angles."""
    theta = _small_angles(body, motion)
    return theta if other == EARTH else sub(theta, _small_angles(other, motion))


@kernel
def _small_angles(b, motion):
    """The angles of R = I + angles x."""
    R = motion.rotation[b]
    return (R[2, 1], R[0, 2], R[1, 0])


@kernel
def apply_tension(body, other, arm, other_arm, force, wrench):
    """Add the ``force`` of a line that pulls to ``wrench`` (6 nb,): on its ``body`` at a lever
    ``arm``, and the opposite at the other end."""
    add_wrench(body, force, cross(arm, force), wrench)
    if other != EARTH:
        reaction = scale(-1.0, force)
        add_wrench(other, reaction, cross(other_arm, reaction), wrench)


# Velocity of a body through a stream of water or air, and a wrench, both in the body's axes.


def current_on(body: str, layout: Layout) -> tuple[float, float]:
    """Mean velocity (2,) [m/s] of the current over the draught of a ``body``. Raises InputError if
    the current varies and the draught is unknown."""
    return current_on_hull(layout.current_profile, layout.draught_of(body), body)


@kernel
def relative_velocity(b, stream, motion):
    """Velocity (6,) of body ``b``'s centre of gravity minus the ``stream`` (2,), and its angular
    velocity, both in its axes, as a tuple."""
    R, v = motion.rotation[b], motion.velocity
    u = matvec(R.T, sub(vector(v, 6 * b), (stream[0], stream[1], 0.0)))
    omega = matvec(R.T, vector(v, 6 * b + 3))
    return (u[0], u[1], u[2], omega[0], omega[1], omega[2])


@kernel
def add_resistance(b, D, u, motion, wrench):
    """Add -D u (6,), in the axes of body ``b``, to ``wrench`` (6 nb,); returns the power taken from
    the body."""
    f = product(D, u, 0)
    R, v = motion.rotation[b], motion.velocity
    force, moment = matvec(R, (-f[0], -f[1], -f[2])), matvec(R, (-f[3], -f[4], -f[5]))
    add_wrench(b, force, moment, wrench)
    lost = 0.0
    for i in range(3):
        lost -= force[i] * v[6 * b + i] + moment[i] * v[6 * b + 3 + i]
    return lost
