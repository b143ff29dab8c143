"""Geometry of contact: a point r of one body against a plane on the earth or on another body.

c: a point of the plane; n: its unit normal (towards the side where the body is free); p: the
contact point; d = p - c. The compression is delta = -n d, positive in contact. w: velocity of p
relative to the plane's material at p; delta' = -n w. The coordinates u1 = (t1 d, t2 d) in the
plane's own frame have the rates u1' = (t1 w, t2 w). This is exact, because n, t1 and t2 turn with
the plane. In linear kinematics normals and lever arms stay as at rest.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import kernel
from hydrosim.rigid.kinematics import add_wrench, attachment, point_bias, point_velocity
from hydrosim.rigid.vectors import add, cross, dot, matvec, scale, sub, vector

EARTH = -1


PLANE = [("plane_body", int), *((f"plane_{name}", float, 3) for name in ("point", "normal"))]
PLANE += [("tangent1", float, 3), ("tangent2", float, 3)]
"""Fields of a contact point's plane: a point and unit vectors in the frame of its body, about the
centre of gravity, or of the earth (body -1)."""


class ContactKinematics(NamedTuple):
    """State of one contact point; vectors are tuples in the earth frame, ``offset`` is u1."""

    place: tuple[float, float, float]
    arm: tuple[float, float, float]
    plane_arm: tuple[float, float, float]
    normal: tuple[float, float, float]
    tangent1: tuple[float, float, float]
    tangent2: tuple[float, float, float]
    compression: float
    rate: float
    velocity: tuple[float, float]
    offset: tuple[float, float]


@kernel
def contact_kinematics(point, bodies, motion):
    """Position and velocity of a contact point relative to its plane, as a `ContactKinematics`."""
    b = point.body
    r = vector(point.place, 0)
    p, arm = attachment(b, r, bodies, motion)
    v = point_velocity(b, arm, motion)
    a = point.plane_body
    c = vector(point.plane_point, 0)
    normal = vector(point.plane_normal, 0)
    t1 = vector(point.tangent1, 0)
    t2 = vector(point.tangent2, 0)
    d = sub(p, c)
    plane_arm = (0.0, 0.0, 0.0)
    if a != EARTH:
        d, plane_arm = _from_moving_plane(b, r, a, c, p, bodies, motion)
        v = sub(v, point_velocity(a, plane_arm, motion))
        if bodies.exact:
            R = motion.rotation[a]
            normal = matvec(R, normal)
            t1 = matvec(R, t1)
            t2 = matvec(R, t2)
    velocity = (dot(t1, v), dot(t2, v))
    offset = (dot(t1, d), dot(t2, d))
    depth = -dot(normal, d)
    rate = -dot(normal, v)
    return ContactKinematics(p, arm, plane_arm, normal, t1, t2, depth, rate, velocity, offset)


@kernel
def _from_moving_plane(b, r, a, c, p, bodies, motion):
    """d from the plane of body ``a`` to the point, and the lever arm of the point on that body."""
    centre = add(vector(bodies.each[a].origin, 0), vector(motion.coordinates, 6 * a))
    if bodies.exact:
        return sub(p, add(centre, matvec(motion.rotation[a], c))), sub(p, centre)
    rest = add(sub(vector(bodies.each[b].origin, 0), vector(bodies.each[a].origin, 0)), r)
    material = add(centre, matvec(motion.rotation[a], rest))
    return add(sub(p, material), sub(rest, c)), rest


@kernel
def tangential_bias(point, contact, bodies, motion):
    """u1'' (2,) of a point when all q'' are zero: the part from rotations and from the rate of
    their map."""
    if not bodies.exact:
        return (0.0, 0.0)
    a = point_bias(point.body, contact.arm, motion)
    w = point_velocity(point.body, contact.arm, motion)
    turn = (0.0, 0.0, 0.0)
    if point.plane_body != EARTH:
        turn = vector(motion.velocity, 6 * point.plane_body + 3)
        centre = vector(motion.velocity, 6 * point.plane_body)
        a = sub(a, _plane_bias(point.plane_body, contact.plane_arm, sub(w, centre), motion))
        w = sub(w, point_velocity(point.plane_body, contact.plane_arm, motion))
    t1 = contact.tangent1
    t2 = contact.tangent2
    return (dot(t1, a) + dot(cross(turn, t1), w), dot(t2, a) + dot(cross(turn, t2), w))


@kernel
def _plane_bias(b, arm, velocity, motion):
    """Rate of omega x arm of the plane's body. The ``arm`` ends at the point, which moves with
    ``velocity``."""
    omega = vector(motion.velocity, 6 * b + 3)
    bias = vector(motion.bias, 6 * b + 3)
    return add(cross(bias, arm), cross(omega, velocity))


@kernel
def add_contact_wrench(point, contact, normal_force, friction, wrench):
    """Add the force of the plane on the point's body, and its opposite on the plane's body, to
    ``wrench``: ``normal_force`` along the normal and the tangential ``friction`` (2,)."""
    force = add(
        scale(normal_force, contact.normal),
        add(scale(friction[0], contact.tangent1), scale(friction[1], contact.tangent2)),
    )
    add_wrench(point.body, force, cross(contact.arm, force), wrench)
    if point.plane_body != EARTH:
        reaction = scale(-1.0, force)
        add_wrench(point.plane_body, reaction, cross(contact.plane_arm, reaction), wrench)


def tangents(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors that make a right-handed frame (t1, t2, normal). t1 is as near to the x axis
    as possible, so that for a level plane facing up the frame is the earth's."""
    guess = np.eye(3)[0 if abs(normal[0]) < 0.9 else 1]
    t1 = guess - normal * (guess @ normal)
    t1 /= np.linalg.norm(t1)
    return t1, np.cross(normal, t1)
