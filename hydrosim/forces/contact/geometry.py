"""Geometry of contact: a point r of one body against a plane on the earth or on another body.

With c a point of the plane, n its unit normal (towards the side where the body is free), p the
contact point and d = p - c, the compression is delta = -n d, positive in contact. w is the velocity
of p relative to the plane's material at p; delta' = -n w, and u1' = (t1 w, t2 w) are the rates of
the coordinates u1 = (t1 d, t2 d) in the plane's own frame, exactly, because n, t1 and t2 turn with
the plane. In linear kinematics normals and lever arms stay as at rest.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.kernels import kernel
from hydrosim.rigid import add_wrench, attachment, point_velocity
from hydrosim.rigid.vectors import add, cross, dot, matvec, scale, sub, vector

EARTH = -1


class Planes(NamedTuple):
    """Planes of n contact points: ``point`` and unit ``normal``, ``tangent1``, ``tangent2`` (n, 3)
    in the frame of ``body`` (n,), about its centre of gravity, or of the earth (body -1)."""

    body: np.ndarray
    point: np.ndarray
    normal: np.ndarray
    tangent1: np.ndarray
    tangent2: np.ndarray


class Touch(NamedTuple):
    """State of one contact point; vectors are tuples in the earth frame."""

    place: tuple[float, float, float]
    arm: tuple[float, float, float]
    plane_arm: tuple[float, float, float]
    normal: tuple[float, float, float]
    tangent1: tuple[float, float, float]
    tangent2: tuple[float, float, float]
    compression: float
    rate: float
    velocity: tuple[float, float]


@kernel
def touch(b, r, i, planes, bodies, motion):
    """Where point ``r`` of body ``b`` stands against plane ``i``, as a `Touch`."""
    p, arm = attachment(b, r, bodies, motion)
    v = point_velocity(b, arm, motion)
    normal, t1, t2 = (
        vector(planes.normal[i], 0),
        vector(planes.tangent1[i], 0),
        vector(planes.tangent2[i], 0),
    )
    c, a = vector(planes.point[i], 0), planes.body[i]
    d, plane_arm = sub(p, c), (0.0, 0.0, 0.0)
    if a != EARTH:
        d, plane_arm = _from_moving_plane(b, r, a, c, p, bodies, motion)
        v = sub(v, point_velocity(a, plane_arm, motion))
        if bodies.exact:
            R = motion.rotation[a]
            normal, t1, t2 = matvec(R, normal), matvec(R, t1), matvec(R, t2)
    velocity = (dot(t1, v), dot(t2, v))
    return Touch(p, arm, plane_arm, normal, t1, t2, -dot(normal, d), -dot(normal, v), velocity)


@kernel
def _from_moving_plane(b, r, a, c, p, bodies, motion):
    """d from the plane of body ``a`` to the point, and the lever arm of the point on that body."""
    centre = add(vector(bodies.origin[a], 0), vector(motion.coordinates, 6 * a))
    if bodies.exact:
        return sub(p, add(centre, matvec(motion.rotation[a], c))), sub(p, centre)
    rest = add(sub(vector(bodies.origin[b], 0), vector(bodies.origin[a], 0)), r)
    material = add(centre, matvec(motion.rotation[a], rest))
    return add(sub(p, material), sub(rest, c)), rest


@kernel
def press(b, a, contact, normal_force, friction, wrench):
    """Put the force of the plane on body ``b``, and its opposite on the plane's body ``a``, into
    ``wrench``: ``normal_force`` along the normal and the tangential ``friction`` (2,)."""
    force = add(
        scale(normal_force, contact.normal),
        add(scale(friction[0], contact.tangent1), scale(friction[1], contact.tangent2)),
    )
    add_wrench(b, force, cross(contact.arm, force), wrench)
    if a != EARTH:
        reaction = scale(-1.0, force)
        add_wrench(a, reaction, cross(contact.plane_arm, reaction), wrench)


def tangents(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors that make a right-handed frame (t1, t2, normal); t1 is as near to the x axis
    as it can be, so that for a level plane facing up the frame is the earth's."""
    guess = np.eye(3)[0 if abs(normal[0]) < 0.9 else 1]
    t1 = guess - normal * (guess @ normal)
    t1 /= np.linalg.norm(t1)
    return t1, np.cross(normal, t1)
