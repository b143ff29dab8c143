"""Geometry of contact: a point r of one body against a plane with edges, on the earth or a body.

c: a point of the plane; n: its unit normal (towards the side where the body is free); p: the
contact point; d = p - c. The compression is delta = -n d, positive in contact. w: velocity of p
relative to the plane's material at p; delta' = -n w. The coordinates u1 = (t1 d, t2 d) in the
plane's own frame have the rates u1' = (t1 w, t2 w). This is exact, because n, t1 and t2 turn with
the plane. In linear kinematics normals and lever arms stay as at rest.

Edges of a plane: of a convex polygon in it, or of the circle of a seat.

An edge is a row (a, b, c). (u1, u2) is the foot of a point in the plane, along its tangents. Its
distance from the edge is a u1 + b u2 + c, positive inside. A point beyond the edge is open. A point
that has passed behind the plane there, or left over the edge while pressed, touches again only
after it has returned to the free side.
"""

from __future__ import annotations

from math import inf
from typing import NamedTuple

import numpy as np

from hydrosim.errors import InputError
from hydrosim.jit.kernels import kernel
from hydrosim.multibody.kinematics import add_wrench, attachment, point_bias, point_velocity
from hydrosim.multibody.vectors import add, cross, dot, length, matvec, scale, sub, vector
from hydrosim.scene.plane import Plane

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


PLANE_RTOL = 1e-6  # of the polygon's size: tolerance of its corners from the plane
CONVEX_RTOL = 1e-9  # of the polygon's size: a corner this far inside is on the edge


def plane_edges(plane: Plane) -> np.ndarray:
    """The edges (n, 3) of a plane; empty if it has none.

    Raises InputError if its corners do not form a convex polygon in the plane.
    """
    if not plane.corners:
        return np.zeros((0, 3))
    normal = np.array(plane.normal, float) / np.linalg.norm(plane.normal)
    apart = np.subtract(plane.corners, plane.point)
    size, u = np.ptp(apart, axis=0).max(), apart @ np.array(tangents(normal)).T
    if np.abs(apart @ normal).max() > PLANE_RTOL * size:
        off = np.abs(apart @ normal).max()
        text = f"found a corner {off:.3g} m off the plane; expected all corners in it"
        raise InputError(f"plane.corners: {text}.")
    about = u - u.mean(axis=0)
    u = u[np.argsort(np.arctan2(about[:, 1], about[:, 0]))]
    along = np.roll(u, -1, axis=0) - u
    inward = np.stack([-along[:, 1], along[:, 0]], 1) / np.linalg.norm(along, axis=1)[:, None]
    sides = np.column_stack([inward, -np.sum(inward * u, axis=1)])
    inside = u @ inward.T + sides[:, 2]
    corner = np.eye(len(u), dtype=bool) | np.roll(np.eye(len(u), dtype=bool), 1, axis=0)
    if len(u) < 3 or not np.all(inside[~corner] > CONVEX_RTOL * size):
        raise InputError(
            "plane.corners: found no convex polygon; expected three corners or more that turn"
            " one way. Use several fenders for any other shape."
        )
    return sides


@kernel
def ends_somewhere(point):
    """True if a point's plane has edges."""
    return point.edges > 0 or point.extent < inf


@kernel
def distance_inside(point, contact, ends):
    """Distance of a point's foot from the nearest edge of its plane, negative beyond."""
    nearest = point.extent - length(contact.offset)
    for k in range(point.edge, point.edge + point.edges):
        u = contact.offset
        nearest = min(nearest, ends[k, 0] * u[0] + ends[k, 1] * u[1] + ends[k, 2])
    return nearest
