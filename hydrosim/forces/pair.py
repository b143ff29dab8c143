"""Rotation of a body relative to another body or to the earth."""

from __future__ import annotations

from hydrosim.forces.contact.geometry import EARTH
from hydrosim.jit.kernels import kernel
from hydrosim.rigid.vectors import sub, vector


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
