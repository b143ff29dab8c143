"""Rigid-body kinematics: from coordinates q and rates q' to positions, rotations and velocities.

Coordinates of a body are the displacement of its centre of gravity (surge, sway, heave) and roll
phi, pitch theta, yaw psi, intrinsic z-y'-x''. R = Rz(psi) Ry(theta) Rx(phi) turns body vectors into
earth vectors. The velocity is v = (velocity of the centre of gravity, angular velocity omega), both
in the earth frame; omega = E (phi', theta', psi') with

    E = [ Rz Ry ex | Rz ey | ez ],   det E = cos(theta),

singular at a pitch of 90 deg. For all bodies together v = S q', v' = S q'' + S' q', where S is the
identity with blocks E. A wrench F does the generalised force S^T F on the coordinates.
Bodies that joints carry have no coordinates of their own: `multibody.tree` has their part of S.

psi is the sum of yaw and heading at rest. With small angles (`Bodies.exact` false) that heading is
zero and E is the identity. Points then move by u + theta x r, and lever arms stay as they are at
rest.
"""

from __future__ import annotations

from collections.abc import Callable
from math import cos, sin
from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import assign, kernel, root
from hydrosim.multibody.tree import (
    BALL,
    NO_TREE,
    SLIDE,
    Tree,
    TreeScratch,
    add_generalised,
    add_inertia,
    add_to_accelerations,
    add_wrench_of_angles,
    fill_small_rotation,
    forward_kinematics,
    new_tree_scratch,
)
from hydrosim.multibody.vectors import add, cross, matvec, vector
from hydrosim.scene.force import MAX_CURVE_POINTS

LARGEST_TILT = 1.48  # rad (85 deg): beyond it the rates of angles lose their meaning

BODY = np.dtype(
    [
        *(("mass", float), ("inertia", float, (3, 3)), ("origin", float, 3), ("heading", float)),
        ("surface", float, 3),
    ]
)
"""Constants of a body: mass, and inertia about the centre of gravity in the body frame. Position of
the centre of gravity at rest in the earth frame, and heading at rest, from which yaw counts.
Density times the second moments of the free surfaces of its contents. Values are those at the start
if contents change (`multibody.mass`)."""


class Bodies(NamedTuple):
    """Constants of all rigid bodies: ``each`` (nb,) of `BODY`, ``active`` (n,) indices of the free
    coordinates among 6 nb, ``locked`` (6 nb,) values of the locked ones; ``exact`` is true for
    rotation matrices, false for small angles. The ``tree`` has their joints, whose coordinates come
    last: their indices in ``active`` begin at 6 nb."""

    each: np.ndarray
    active: np.ndarray
    locked: np.ndarray
    exact: bool
    tree: Tree = NO_TREE


MAX_CORNERS = MAX_CURVE_POINTS - 2
LINE_PIECE = np.dtype(
    [
        *((name, float) for name in ("length", "weight", "stiffness", "hung")),
        *(("corners", int), ("limit", float)),
        *((name, float, MAX_CORNERS) for name in ("corner", "tangent", "offset", "energy")),
    ]
)
"""A piece of a line, see `hydrosim.elements.line.hang`."""


class Motion(NamedTuple):
    """Scratch: ``coordinates`` q and their ``rate`` q' (6 nb,), ``rotation`` R and ``rate_map`` E
    (nb, 3, 3), ``velocity`` v (6 nb,), ``bias`` S' q' (6 nb,); ``growth`` of the tree of joints;
    the ``pieces`` of lines whose length changes with the motion."""

    coordinates: np.ndarray
    rate: np.ndarray
    rotation: np.ndarray
    rate_map: np.ndarray
    velocity: np.ndarray
    bias: np.ndarray
    growth: TreeScratch
    pieces: np.ndarray


def new_motion(bodies: Bodies, pieces: np.ndarray = np.zeros(0, LINE_PIECE)) -> Motion:
    """Scratch for these bodies at rest, and for the ``pieces`` of their lines."""
    nb = bodies.each.size
    unit = np.tile(np.eye(3), (nb, 1, 1))
    zero = np.zeros(6 * nb)
    growth = new_tree_scratch(bodies.tree)
    moving = (zero.copy(), zero.copy(), growth, pieces.copy())
    return Motion(bodies.locked.copy(), zero, unit, unit.copy(), *moving)


@root
def place_bodies(q, u, bodies, motion):
    """Fill ``motion`` from the free coordinates ``q`` (n,) and their rates ``u`` (n,)."""
    place_bodies_inline(q, u, bodies, motion)


@kernel
def place_bodies_inline(q, u, bodies, motion):
    """`place_bodies` as a part of its caller, for callers where the cost of a call matters."""
    for j in range(bodies.active.size - bodies.tree.coordinates):
        motion.coordinates[bodies.active[j]] = q[j]
        motion.rate[bodies.active[j]] = u[j]
    assign(motion.velocity, motion.rate)
    jointed = bodies.tree.branches.size > 0
    for b in range(bodies.each.size):
        if jointed and bodies.tree.branch[b] >= 0:
            continue  # placed from its parent
        angles = vector(motion.coordinates, 6 * b + 3)
        if bodies.exact:
            angles = (angles[0], angles[1], angles[2] + bodies.each[b].heading)
            _fill_rotation(angles, motion.rotation[b])
            _rate_map(angles, motion.rate_map[b])
            _set_angular_velocity(b, angles, motion)
        else:
            fill_small_rotation(angles, motion.rotation[b])
    if jointed:
        forward_kinematics(q, u, bodies, motion)


@kernel
def accelerations(x, bodies, motion, a):
    """Fill ``a`` (6 nb,) = v' = S q'' + S' q' from accelerations ``x`` (n,) of the free
    coordinates; ``motion`` must be filled."""
    assign(a, motion.bias)
    if bodies.tree.branches.size > 0:
        add_to_accelerations(x, bodies, motion, a)
        return
    for j in range(bodies.active.size):
        i = bodies.active[j]
        if i % 6 < 3 or not bodies.exact:
            a[i] += x[j]
        else:
            E = motion.rate_map[i // 6]
            k = 6 * (i // 6) + 3
            for axis in range(3):
                a[k + axis] += E[axis, i - k] * x[j]


@kernel
def _set_angular_velocity(b, angles, motion):
    """Angular velocity E a' and its bias E' a' of body b from the rates a' of its angles."""
    rate = vector(motion.rate, 6 * b + 3)
    omega = matvec(motion.rate_map[b], rate)
    bias = _rate_map_bias(angles, rate)
    for i in range(3):
        motion.velocity[6 * b + 3 + i] = omega[i]
        motion.bias[6 * b + 3 + i] = bias[i]


@kernel
def _fill_rotation(angles, R):
    """R = Rz(psi) Ry(theta) Rx(phi)."""
    cf = cos(angles[0])
    sf = sin(angles[0])
    ct = cos(angles[1])
    st = sin(angles[1])
    cp = cos(angles[2])
    sp = sin(angles[2])
    R[0, 0] = cp * ct
    R[0, 1] = cp * st * sf - sp * cf
    R[0, 2] = cp * st * cf + sp * sf
    R[1, 0] = sp * ct
    R[1, 1] = sp * st * sf + cp * cf
    R[1, 2] = sp * st * cf - cp * sf
    R[2, 0] = -st
    R[2, 1] = ct * sf
    R[2, 2] = ct * cf


@kernel
def _rate_map(angles, E):
    ct = cos(angles[1])
    st = sin(angles[1])
    cp = cos(angles[2])
    sp = sin(angles[2])
    E[0, 0] = cp * ct
    E[0, 1] = -sp
    E[0, 2] = 0.0
    E[1, 0] = sp * ct
    E[1, 1] = cp
    E[1, 2] = 0.0
    E[2, 0] = -st
    E[2, 1] = 0.0
    E[2, 2] = 1.0


@kernel
def _rate_map_bias(angles, rate):
    """E' a': the angular acceleration at constant rates a' of the angles."""
    ct = cos(angles[1])
    st = sin(angles[1])
    cp = cos(angles[2])
    sp = sin(angles[2])
    dphi, dtheta, dpsi = rate
    return (
        -dphi * (dtheta * cp * st + dpsi * sp * ct) - dtheta * dpsi * cp,
        -dphi * (dtheta * sp * st - dpsi * cp * ct) - dtheta * dpsi * sp,
        -dphi * dtheta * ct,
    )


@kernel
def vertical_in_body(b, motion, bodies):
    """The vertical n in the frame of body ``b``; (-pitch, roll, 1) in linear kinematics."""
    R = motion.rotation[b]
    return (R[2, 0], R[2, 1], R[2, 2] if bodies.exact else 1.0)


@kernel
def attachment(b, r, bodies, motion):
    """Position in the earth frame of point ``r`` of body ``b``, and its lever arm."""
    arm = matvec(motion.rotation[b], r)
    centre = add(vector(bodies.each[b].origin, 0), vector(motion.coordinates, 6 * b))
    return add(centre, arm), arm if bodies.exact else r


@kernel
def point_velocity(b, arm, motion):
    """Velocity v + omega x arm of a point of body ``b``."""
    v = vector(motion.velocity, 6 * b)
    return add(v, cross(vector(motion.velocity, 6 * b + 3), arm))


@kernel
def point_bias(b, arm, motion):
    """Acceleration of a body's point for q'' = 0: S' q' and omega x (omega x arm)."""
    omega = vector(motion.velocity, 6 * b + 3)
    bias = vector(motion.bias, 6 * b + 3)
    turning = add(cross(bias, arm), cross(omega, cross(omega, arm)))
    return add(vector(motion.bias, 6 * b), turning)


@kernel
def add_wrench(b, force, moment, wrench):
    """Add a force and a moment about the centre of gravity of body ``b`` to ``wrench`` (6 nb,)."""
    for i in range(3):
        wrench[6 * b + i] += force[i]
        wrench[6 * b + 3 + i] += moment[i]


@kernel
def generalised_force(bodies, motion, wrench, Q):
    """Q = S^T F on the free coordinates; ``wrench`` (6 nb,) is overwritten."""
    if bodies.tree.branches.size > 0:
        add_generalised(bodies, motion, wrench, Q)
        return
    if bodies.exact:
        for b in range(bodies.each.size):
            _transposed_map(motion.rate_map[b], wrench, 6 * b + 3)
    for j in range(bodies.active.size):
        Q[j] = wrench[bodies.active[j]]


@kernel
def _transposed_map(E, wrench, k):
    m = vector(wrench, k)
    for i in range(3):
        wrench[k + i] = E[0, i] * m[0] + E[1, i] * m[1] + E[2, i] * m[2]


@kernel
def wrench_of_coordinates(b, Q, bodies, motion, wrench):
    """Add to ``wrench`` the wrench S^-T Q whose power is Q q', for ``Q`` (6,) of body ``b``.

    Solves E^T m = Q_angles; E^T is [Rz Ry ex; Rz ey; ez] by rows.
    """
    if not bodies.exact:
        for i in range(6):
            wrench[6 * b + i] += Q[i]
        return
    if bodies.tree.branches.size > 0 and bodies.tree.branch[b] >= 0:
        add_wrench_of_angles(b, Q, bodies, motion, wrench)
        return
    for i in range(3):
        wrench[6 * b + i] += Q[i]
    E = motion.rate_map[b]
    ct = E[1, 1] * E[0, 0] - E[0, 1] * E[1, 0]
    along = (Q[3] - E[2, 0] * Q[5]) / ct
    wrench[6 * b + 3] += E[1, 1] * along + E[0, 1] * Q[4]
    wrench[6 * b + 4] += -E[0, 1] * along + E[1, 1] * Q[4]
    wrench[6 * b + 5] += Q[5]


@kernel
def acceleration_map(bodies, motion, M, H):
    """H = S^T M S over the free coordinates; ``M`` (6 nb, 6 nb) is overwritten."""
    if bodies.tree.branches.size > 0:
        add_inertia(bodies, motion, M, H)
        return
    n = M.shape[0]
    if bodies.exact:
        for b in range(bodies.each.size):
            E = motion.rate_map[b]
            k = 6 * b + 3
            for i in range(n):
                row = vector(M[i], k)
                for j in range(3):
                    M[i, k + j] = row[0] * E[0, j] + row[1] * E[1, j] + row[2] * E[2, j]
            for i in range(n):
                col = (M[k, i], M[k + 1, i], M[k + 2, i])
                for j in range(3):
                    M[k + j, i] = E[0, j] * col[0] + E[1, j] * col[1] + E[2, j] * col[2]
    active = bodies.active
    for i in range(active.size):
        for j in range(active.size):
            H[i, j] = M[active[i], active[j]]


# Free coordinates: those of bodies come first, then those of joints (`Bodies.active`).


def own_coordinates(bodies: Bodies) -> np.ndarray:
    """Indices among 6 nb of the free coordinates of bodies, without those of joints."""
    return bodies.active[: bodies.active.size - bodies.tree.coordinates]


def are_lengths(bodies: Bodies) -> np.ndarray:
    """True (n,) for coordinates in metres, false for angles."""
    moves = bodies.tree.moves
    is_length = np.concatenate(
        [own_coordinates(bodies) % 6 < 3, np.zeros(bodies.tree.coordinates, bool)]
    )
    is_length[moves["coordinate"][moves["kind"] == SLIDE]] = True
    return is_length


def coordinate_owners(bodies: Bodies) -> np.ndarray:
    """Body (n,) that each coordinate moves: of a joint, the one that it carries."""
    owners = np.concatenate([own_coordinates(bodies) // 6, np.zeros(bodies.tree.coordinates, int)])
    for branch in bodies.tree.branches:
        for move in bodies.tree.moves[branch["first"] : branch["last"]]:
            owners[move["coordinate"] :][: 3 if move["kind"] == BALL else 1] = branch["child"]
    return owners


def coordinate_groups(bodies: Bodies) -> np.ndarray:
    """Number (n,) of the group of each coordinate: the three positions or the three angles of a
    body, or the motions of a joint of one kind and body."""
    kinds = 2 * (bodies.each.size + coordinate_owners(bodies)) + ~are_lengths(bodies)
    groups = own_coordinates(bodies) // 3
    return np.concatenate([groups, kinds[groups.size :]])


def slopes_at_rest(bodies: Bodies) -> np.ndarray:
    """Displacements (6 nb, n) of all bodies per coordinate, at rest and for small angles."""
    if bodies.tree.branches.size:
        return bodies.tree.slopes
    slopes = np.zeros((6 * bodies.each.size, bodies.active.size))
    slopes[bodies.active, np.arange(bodies.active.size)] = 1.0
    return slopes


def moving_dofs(bodies: Bodies) -> np.ndarray:
    """DOFs among 6 nb that can move, rising."""
    return np.flatnonzero(slopes_at_rest(bodies).any(axis=1))


def positions_at(bodies: Bodies, q: np.ndarray) -> np.ndarray:
    """Displacements (nb, 6) of all bodies at the coordinates ``q`` (n,)."""
    motion = new_motion(bodies)
    place_bodies(q, np.zeros_like(q), bodies, motion)
    return motion.coordinates.reshape(-1, 6)


def slopes_at(bodies: Bodies, q: np.ndarray) -> np.ndarray:
    """S (6 nb, n) at ``q`` (n,): velocities of all bodies per rate of each coordinate."""
    return _slopes_by_rates(bodies, q, lambda motion: motion.velocity)


def coordinate_map(bodies: Bodies, q: np.ndarray) -> np.ndarray:
    """Rates (6 nb, n) of the displacements of all bodies per rate of each coordinate, at ``q``
    (n,)."""
    return _slopes_by_rates(bodies, q, lambda motion: motion.rate)


def _slopes_by_rates(
    bodies: Bodies, q: np.ndarray, measured: Callable[[Motion], np.ndarray]
) -> np.ndarray:
    """What is ``measured`` (6 nb,) of the motion at ``q`` (n,), per rate of each coordinate."""
    motion = new_motion(bodies)
    columns = []
    for rates in np.eye(q.size):
        place_bodies(q, rates, bodies, motion)
        columns.append(measured(motion).copy())
    return np.reshape(columns, (q.size, -1)).T
