"""Rows of the constraints of a joint: what it holds, how that moves with the bodies, its force.

With a_k the axes of the joint that move with the other body, b_k those that move with the body (the
same at the reference), and d the way from the joint's point on the other body to that on the body:

    slide   a . d = 0         force a on the body at its point, -a on the other body there
    turn    a . b = 0         moment b x a on the body, its opposite on the other body

    rod     |d| = length  force d / |d| on the body at its point, its opposite on the other body

The points of a rod differ, those of other joints coincide in the relative place that is held. The
reference of a rod is its length.

The reference is the relative place that is held: the point in the frame of the other body, and
R_other^T R_body. With small angles all axes and levers are those at rest; the reference is d, and
the difference of the angles.
"""

from __future__ import annotations

from math import atan2, cos, sin, sqrt
from typing import NamedTuple

import numpy as np

from hydrosim.elements.contact.geometry import EARTH
from hydrosim.jit.kernels import kernel
from hydrosim.modes import NO_INDEX
from hydrosim.multibody.kinematics import add_wrench, attachment, point_bias, point_velocity
from hydrosim.multibody.vectors import add, cross, dot, matvec, scale, sub, vector

PLACE_ENTRY, TURN_ENTRY, REFERENCE_SIZE = 0, 3, 12
"""A reference: entries of the place and of the turn (9, or 3 angles), and their number."""
ZERO = (0.0, 0.0, 0.0)


class Pose(NamedTuple):
    """Momentary place of a joint in the earth frame: ``arm`` of its point on the body, ``own`` arm
    of the point on the other body, and the ``gap`` d from the latter to the former."""

    arm: tuple[float, ...]
    other_arm: tuple[float, ...]
    gap: tuple[float, ...]


class Row(NamedTuple):
    """A constraint: ``force`` and ``moment`` (3,) on the body at its point, per unit of lambda; the
    ``bias`` of its second derivative, and its ``residual``."""

    force: tuple[float, ...]
    moment: tuple[float, ...]
    bias: float
    residual: float


@kernel
def pose(lock, reference, bodies, motion):
    """`Pose` of a joint with this ``reference`` (12,)."""
    place, arm = attachment(lock.body, vector(lock.point, 0), bodies, motion)
    moves = bodies.exact and not lock.rod
    at = vector(reference, PLACE_ENTRY) if moves else vector(lock.other, 0)
    if lock.to == EARTH:
        lock_pose = Pose(arm, ZERO, sub(place, at))
    else:
        other, attached = attachment(lock.to, at, bodies, motion)
        lock_pose = Pose(arm, attached, sub(place, other))
    if bodies.exact:
        return lock_pose
    return Pose(arm, lock_pose.other_arm, sub(lock_pose.gap, vector(reference, PLACE_ENTRY)))


@kernel
def axis_on_body(lock, k, bodies, motion):
    """b_k in the earth frame."""
    a = vector(lock.axes[k], 0)
    return matvec(motion.rotation[lock.body], a) if bodies.exact else a


@kernel
def axis_on_other(lock, k, reference, bodies, motion):
    """a_k in the earth frame."""
    a = vector(lock.axes[k], 0)
    if not bodies.exact:
        return a
    a = (
        dot(vector(reference, TURN_ENTRY), a),
        dot(vector(reference, TURN_ENTRY + 3), a),
        dot(vector(reference, TURN_ENTRY + 6), a),
    )
    return a if lock.to == EARTH else matvec(motion.rotation[lock.to], a)


@kernel
def find_row(lock, k, at, reference, bodies, motion):
    """`Row` ``k`` of a joint in the pose ``at``."""
    if lock.rod and bodies.exact:
        return _rod_row(lock, at, reference[0], motion)
    a = axis_on_other(lock, lock.first[k], reference, bodies, motion)
    if lock.second[k] == NO_INDEX:
        bias = _slide_bias(lock, a, at, motion) if bodies.exact else 0.0
        return Row(a, ZERO, bias, dot(a, at.gap))
    b = axis_on_body(lock, lock.second[k], bodies, motion)
    m = cross(b, a)
    if bodies.exact:
        return Row(ZERO, m, _turn_bias(lock, a, b, motion), dot(a, b))
    turn = sub(_turn_between(lock, motion.coordinates, motion), vector(reference, TURN_ENTRY))
    return Row(ZERO, m, 0.0, dot(m, turn))


@kernel
def _rod_row(lock, at, length, motion):
    """`Row` of a rod. |d|'' is n . d'' + (|d'|^2 - (n . d')^2) / |d|, with n = d / |d|."""
    distance = sqrt(dot(at.gap, at.gap))
    n = scale(1.0 / distance, at.gap)
    velocity = point_velocity(lock.body, at.arm, motion)
    acceleration = point_bias(lock.body, at.arm, motion)
    if lock.to != EARTH:
        velocity = sub(velocity, point_velocity(lock.to, at.other_arm, motion))
        acceleration = sub(acceleration, point_bias(lock.to, at.other_arm, motion))
    along = dot(n, velocity)
    across = dot(velocity, velocity) - along * along
    return Row(n, ZERO, dot(n, acceleration) + across / distance, distance - length)


@kernel
def _turn_between(lock, values, motion):
    """The three turning entries of the body, less those of the other body."""
    angles = vector(values, 6 * lock.body + 3)
    return angles if lock.to == EARTH else sub(angles, vector(values, 6 * lock.to + 3))


@kernel
def _slide_bias(lock, a, at, motion):
    """(a . d)'' when all q'' are zero."""
    acceleration = point_bias(lock.body, at.arm, motion)
    if lock.to == EARTH:
        return dot(a, acceleration)
    omega = vector(motion.velocity, 6 * lock.to + 3)
    spin = vector(motion.bias, 6 * lock.to + 3)
    acceleration = sub(acceleration, point_bias(lock.to, at.other_arm, motion))
    velocity = sub(
        point_velocity(lock.body, at.arm, motion), point_velocity(lock.to, at.other_arm, motion)
    )
    turned = cross(omega, a)
    turns = add(cross(spin, a), cross(omega, turned))
    return dot(a, acceleration) + 2.0 * dot(turned, velocity) + dot(turns, at.gap)


@kernel
def _turn_bias(lock, a, b, motion):
    """(a . b)'' when all q'' are zero."""
    relative = _turn_between(lock, motion.velocity, motion)
    spin = _turn_between(lock, motion.bias, motion)
    turns = cross(cross(vector(motion.velocity, 6 * lock.body + 3), b), a)
    if lock.to != EARTH:
        turns = add(turns, cross(b, cross(vector(motion.velocity, 6 * lock.to + 3), a)))
    return dot(spin, cross(b, a)) + dot(relative, turns)


@kernel
def add_row_wrench(lock, at, force, moment, bodies, wrench):
    """Add ``force`` and ``moment`` on the body at the joint's point, and their opposites on the
    other body, to ``wrench`` (6 nb,)."""
    add_wrench(lock.body, force, add(cross(at.arm, force), moment), wrench)
    if lock.to != EARTH:
        lever = add(at.other_arm, at.gap) if bodies.exact else at.other_arm
        opposite = add(cross(lever, force), moment)
        add_wrench(lock.to, scale(-1.0, force), scale(-1.0, opposite), wrench)


@kernel
def row_rate(lock, row, at, bodies, motion):
    """Rate of a constraint at the present velocities."""
    v = point_velocity(lock.body, at.arm, motion)
    if lock.to != EARTH:
        lever = add(at.other_arm, at.gap) if bodies.exact else at.other_arm
        v = sub(v, point_velocity(lock.to, lever, motion))
    return dot(row.force, v) + dot(row.moment, _turn_between(lock, motion.velocity, motion))


@kernel
def turn_from_reference(lock, reference, bodies, motion):
    """Angle about the first axis from the reference [rad], within half a turn both ways."""
    if not bodies.exact:
        turn = sub(_turn_between(lock, motion.coordinates, motion), vector(reference, TURN_ENTRY))
        return dot(vector(lock.axes[0], 0), turn)
    b = axis_on_body(lock, 1, bodies, motion)
    along = dot(axis_on_other(lock, 1, reference, bodies, motion), b)
    return atan2(dot(axis_on_other(lock, 2, reference, bodies, motion), b), along)


@kernel
def take_reference(lock, bodies, motion, reference):
    """Fill ``reference`` (12,) with the present relative place of the bodies."""
    place, _ = attachment(lock.body, vector(lock.point, 0), bodies, motion)
    if not bodies.exact:
        gap = sub(place, vector(lock.other, 0))
        if lock.to != EARTH:
            other, _ = attachment(lock.to, vector(lock.other, 0), bodies, motion)
            gap = sub(place, other)
        turn = _turn_between(lock, motion.coordinates, motion)
        for i in range(3):
            reference[PLACE_ENTRY + i] = gap[i]
            reference[TURN_ENTRY + i] = turn[i]
        return
    if lock.rod:
        gap = sub(place, vector(lock.other, 0))
        if lock.to != EARTH:
            other, _ = attachment(lock.to, vector(lock.other, 0), bodies, motion)
            gap = sub(place, other)
        reference[0] = sqrt(dot(gap, gap))
        return
    R = motion.rotation[lock.body]
    if lock.to != EARTH:
        centre, _ = attachment(lock.to, ZERO, bodies, motion)
        place = matvec(motion.rotation[lock.to].T, sub(place, centre))
    for i in range(3):
        reference[PLACE_ENTRY + i] = place[i]
        for j in range(3):
            entry = R[i, j]
            if lock.to != EARTH:
                Q = motion.rotation[lock.to]
                entry = Q[0, i] * R[0, j] + Q[1, i] * R[1, j] + Q[2, i] * R[2, j]
            reference[TURN_ENTRY + 3 * i + j] = entry


@kernel
def advance_reference(lock, turns, pitch, bodies, reference):
    """Move ``reference`` by one ``pitch`` along the first axis, or about it if it ``turns``."""
    a = vector(lock.axes[0], 0)
    if not bodies.exact:
        first = TURN_ENTRY if turns else PLACE_ENTRY
        for i in range(3):
            reference[first + i] += pitch * a[i]
        return
    turn = (
        vector(reference, TURN_ENTRY),
        vector(reference, TURN_ENTRY + 3),
        vector(reference, TURN_ENTRY + 6),
    )
    if not turns:
        for i in range(3):
            reference[PLACE_ENTRY + i] += pitch * dot(turn[i], a)
        return
    # C Rot(a, pitch): rows of C turn by -pitch about the axis
    c = cos(pitch)
    s = sin(pitch)
    for i in range(3):
        row = turn[i]
        along = (1.0 - c) * dot(row, a)
        across = cross(row, a)
        for j in range(3):
            reference[TURN_ENTRY + 3 * i + j] = c * row[j] + s * across[j] + along * a[j]


# Scratch of constraints that hold bodies: owners of rows, and reactions.


class Holds(NamedTuple):
    """Scratch for each of r constraints, and the reactions of units.

    A row belongs to a contact ``point`` (r,) and acts in the ``direction`` (r, 2) in its plane. Or
    it is row ``bit`` (r,) of a joint ``lock`` (r,), acts on its body by the ``axis`` (r, 6) of
    force and moment at the joint, and is not met by its ``residual`` (r,) [m or 1]; its ``size``
    (r,) is about J M^-1 J^T of bodies without joints. Or it holds a ``motion`` (r,) of a joint. The
    first rows belong to drives, if there are any: ``driven`` (drives, 3) are the position, speed
    and acceleration of each, and ``piece`` (drives,) the piece of its signal in the present step.
    ``reaction`` (points + locks + motions + drives, 2) are the reactions on each point's body, of
    ratchets, of stuck motions and of drives; ``joint`` (locks, 6) are force and moment of each
    joint on its body. ``conjugate`` (6,) is a force by coordinate of a body.
    """

    point: np.ndarray
    direction: np.ndarray
    lock: np.ndarray
    bit: np.ndarray
    axis: np.ndarray
    residual: np.ndarray
    size: np.ndarray
    motion: np.ndarray
    reaction: np.ndarray
    joint: np.ndarray
    driven: np.ndarray
    piece: np.ndarray
    conjugate: np.ndarray


def new_holds(reactions: int, rows: int, joints: int, drives: int) -> Holds:
    """Scratch for this number of ``reactions`` of points and locks, of ``rows`` of constraints, of
    ``joints`` that are constraints, and of ``drives``."""
    none = np.full(rows, NO_INDEX)
    return Holds(
        none,
        np.zeros((rows, 2)),
        none.copy(),
        np.zeros(rows, dtype=np.int64),
        np.zeros((rows, 6)),
        np.zeros(rows),
        np.zeros(rows),
        none.copy(),
        np.zeros((reactions, 2)),
        np.zeros((joints, 6)),
        np.zeros((drives, 3)),
        np.full(drives, NO_INDEX),
        np.zeros(6),
    )
