"""A body and another body, or the earth: the line between two points, and the relative rotation."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

from hydrosim.forces.contact.geometry import EARTH
from hydrosim.jit.kernels import kernel
from hydrosim.rigid.kinematics import attachment, point_velocity
from hydrosim.rigid.vectors import dot, scale, sub, vector


class Line(NamedTuple):
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
    return Line(arm, other_arm, e, length, dot(e, sub(w, v)))


@kernel
def turning(body, other, motion):
    """Angular velocity of a body relative to the other side, in the earth frame."""
    omega = vector(motion.velocity, 6 * body + 3)
    if other == EARTH:
        return omega
    return sub(omega, vector(motion.velocity, 6 * other + 3))


@kernel
def small_turn(body, other, motion):
    """Rotation vector of a body relative to the other side, with small angles."""
    theta = _small_angles(body, motion)
    return theta if other == EARTH else sub(theta, _small_angles(other, motion))


@kernel
def _small_angles(b, motion):
    """The angles of R = I + angles x."""
    R = motion.rotation[b]
    return (R[2, 1], R[0, 2], R[1, 0])
