"""Trees of joints: places and velocities of bodies from the motions of their joints.

    v = S(q) u,   v' = S u' + b,   q' = N(q) u

v: velocities of all bodies (6 nb,) in the earth frame; u: rates of the free coordinates. They are
q' but for a ball joint, whose u is the relative angular velocity, and whose q is 4 s, four times
the modified Rodrigues parameters s (`multibody.vectors`). Beyond 180 deg s is replaced by
-s / |s|^2, the same rotation, so that a ball joint has no singular attitude.

A joint is a row of moves: slides along, or turns about, an axis that moves with the part before it.
From a parent's place x, rotation, velocity and acceleration bias, one move after the other gives
those of its child. All rotations here are relative to rest, where they are the identity (T):

    slide along a:  x += a q
                    v += a u + omega x a q
                    b += b_omega x a q + omega x (omega x a q) + 2 omega x a u
    turn about a:   T = T Rot(a, q)
                    omega += a u
                    b_omega += omega x a u

In S (6 nb, n) the column of a coordinate is the velocity of all bodies that it carries. Sums over
bodies follow the tree, in place of S. A joint
that is named from the parent's side has the sign -1: its moves are undone in reverse order.

The heading of a jointed body is that of its parent plus the joint's turn about the vertical: the
twist of its rotation (quaternion p, p_0 >= 0) about the vertical z at rest, 2 atan2(p_z, p_0). Its
gradient in the relative angular velocity is

    g = (p_0^2 z + p_0 (p x z) + p_z p) / (p_0^2 + p_z^2)

For a vertical axis it is the angle itself, any number of times round; for a level axis it is zero.

The coordinates of a jointed body are the displacement of its centre of gravity, two entries of its
rotation vector relative to its heading axes, and the heading: for a hinge with a level axis, its
angle times the axis. For small angles S is constant, that at rest.
"""

from __future__ import annotations

from math import atan2, cos, floor, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import assign, clear, kernel, root, root_giving
from hydrosim.multibody.vectors import (
    add,
    conjugate_moment,
    cross,
    dot,
    fill_rotation,
    multiply,
    parameter_rates,
    quaternion_about,
    quaternion_of_parameters,
    rotate_vector,
    rotation_vector,
    scale,
    sub,
    vector,
    vector_rates,
)

SLIDE, TURN, BALL = range(3)
NO_BODY = -1
UP = (0.0, 0.0, 1.0)
FULL_TURN = 2.0 * pi
HALF_TURN_NORM = 4.0  # of four Rodrigues parameters: an angle of 180 deg

MOVE = np.dtype([("kind", int), ("coordinate", int), ("sign", float), ("axes", float, (3, 3))])
"""A move: its first coordinate, its axis in the earth frame at rest; a ball has three of both."""
BRANCH = np.dtype(
    [
        *(("child", int), ("parent", int), ("first", int), ("last", int), ("heading", float)),
        *(("from_parent", float, 3), ("to_child", float, 3), ("winding", int)),
        *(("joint", int), ("reversed", bool)),
    ]
)
"""A joint: its bodies (or `NO_BODY`, the earth), its range of moves, the heading of the child at
rest, the arms to the joint from the parent's centre of gravity (from the earth's origin) and from
the child's, in the earth frame at rest, the move about the vertical or -1, its number among all
joints, and whether the child is the joint's `to`."""


class Tree(NamedTuple):
    """Constants of all joints that are coordinates: ``branches`` (nj,) of `BRANCH`, parents first;
    ``moves`` (nm,) of `MOVE`; ``branch`` (nb,) of each body, or -1; the number of ``coordinates``;
    ``start`` (nq, 2) their values and rates; ``slopes`` (6 nb, n), S at rest."""

    branches: np.ndarray
    moves: np.ndarray
    branch: np.ndarray
    coordinates: int
    start: np.ndarray
    slopes: np.ndarray


class TreeScratch(NamedTuple):
    """Scratch of a tree: ``S`` (6 nb, n), of small angles or where the whole matrix is asked for.
    Of each coordinate: its column ``columns`` (n, 6) of S at its own body. Of each body: its
    rotation since rest as a quaternion ``turned`` (nb, 4); its ``heading`` (nb,) since rest and the
    ``rate`` (nb,) of that; its rotation vector from there in heading axes, ``angles`` (nb, 3). Of
    each joint: its ``place`` (nj, 3), and the ``gradient`` (nj, 3) of its turn about the vertical.
    Of each move: its present ``axes`` (nm, 3, 3).

    Of `multibody.articulated`: ``arm`` (nj, 3) of each joint, from the parent's to the child's
    centre of gravity; wrenches or accelerations ``carried`` (6 nb,) along the tree; ``inertia``
    (nb, 9, 3) of each body; U ``pulls`` (n, 6), s F ``pushes`` (n,) and 1 / D ``pivots`` (n,)."""

    S: np.ndarray
    columns: np.ndarray
    turned: np.ndarray
    heading: np.ndarray
    rate: np.ndarray
    angles: np.ndarray
    place: np.ndarray
    gradient: np.ndarray
    axes: np.ndarray
    arm: np.ndarray
    carried: np.ndarray
    inertia: np.ndarray
    pulls: np.ndarray
    pushes: np.ndarray
    pivots: np.ndarray


NO_TREE = Tree(
    np.zeros(0, BRANCH),
    np.zeros(0, MOVE),
    np.zeros(0, dtype=np.int64),
    0,
    np.zeros((0, 2)),
    np.zeros((0, 0)),
)


def new_tree_scratch(tree: Tree) -> TreeScratch:
    """Scratch for this tree, at rest."""
    nb = tree.branch.size
    nj = tree.branches.size
    n = tree.slopes.shape[1]
    return TreeScratch(
        tree.slopes.copy(),
        np.zeros((n, 6)),
        np.tile([1.0, 0.0, 0.0, 0.0], (nb, 1)),
        np.zeros(nb),
        np.zeros(nb),
        np.zeros((nb, 3)),
        np.zeros((nj, 3)),
        np.zeros((nj, 3)),
        tree.moves["axes"].copy(),
        np.zeros((nj, 3)),
        np.zeros(6 * nb),
        np.zeros((nb, 9, 3)),
        np.zeros((n, 6)),
        np.zeros(n),
        np.zeros(n),
    )


def coordinate_places(tree: Tree) -> dict[int, tuple[int, int]]:
    """The move and its axis of each coordinate of a tree, which follow one another."""
    return {
        int(move["coordinate"]) + a: (m, a)
        for m, move in enumerate(tree.moves)
        for a in range(3 if move["kind"] == BALL else 1)
    }


@kernel
def coordinate_count(move):
    """Number of the coordinates of a move."""
    return 3 if move.kind == BALL else 1


@root
def forward_kinematics(q, u, bodies, motion):
    """Fill ``motion`` of all jointed bodies, and the `TreeScratch`, from the roots, which are
    placed."""
    tree = bodies.tree
    if not bodies.exact:
        _small_angle_kinematics(q, u, bodies, motion)
        return
    _fill_roots(bodies, motion)
    for k in range(tree.branches.size):
        _transfer_to_child(k, q, u, bodies, motion)


@kernel
def _small_angle_kinematics(q, u, bodies, motion):
    """Displacements and velocities S q and S u of jointed bodies, for small angles."""
    tree = bodies.tree
    S = tree.slopes
    for k in range(tree.branches.size):
        b = tree.branches[k].child
        for i in range(6 * b, 6 * b + 6):
            place = 0.0
            speed = 0.0
            for j in range(q.size):
                place += S[i, j] * q[j]
                speed += S[i, j] * u[j]
            motion.coordinates[i] = place
            motion.rate[i] = speed
            motion.velocity[i] = speed
        motion.growth.rate[b] = motion.rate[6 * b + 5]
        fill_small_rotation(vector(motion.coordinates, 6 * b + 3), motion.rotation[b])


@kernel
def fill_small_rotation(angles, R):
    """I + angles x, the first order of R."""
    R[0, 0] = 1.0
    R[0, 1] = -angles[2]
    R[0, 2] = angles[1]
    R[1, 0] = angles[2]
    R[1, 1] = 1.0
    R[1, 2] = -angles[0]
    R[2, 0] = -angles[1]
    R[2, 1] = angles[0]
    R[2, 2] = 1.0


@kernel
def _fill_roots(bodies, motion):
    """Columns, rotation and heading of the bodies with coordinates of their own."""
    tree = bodies.tree
    growth = motion.growth
    for j in range(bodies.active.size - tree.coordinates):
        i = bodies.active[j]
        if i % 6 < 3:
            growth.columns[j, i % 6] = 1.0
        else:
            E = motion.rate_map[i // 6]
            for a in range(3):
                growth.columns[j, 3 + a] = E[a, i % 6 - 3]
    for b in range(bodies.each.size):
        if tree.branch[b] < 0:
            roll, pitch, yaw = vector(motion.coordinates, 6 * b + 3)
            back = quaternion_about(UP, -bodies.each[b].heading)
            tilt = multiply(
                quaternion_about((0.0, 1.0, 0.0), pitch), quaternion_about((1.0, 0.0, 0.0), roll)
            )
            heading = quaternion_about(UP, yaw + bodies.each[b].heading)
            _copy_vector(multiply(heading, multiply(tilt, back)), growth.turned[b])
            growth.heading[b] = yaw
            growth.rate[b] = motion.rate[6 * b + 5]


@kernel
def _transfer_to_child(k, q, u, bodies, motion):
    """Place the child of joint ``k``, and give its velocity, its bias and its columns of S."""
    tree = bodies.tree
    growth = motion.growth
    branch = tree.branches[k]
    here, x, v, omega, b, b_omega = _begin_at_parent(k, bodies, motion)
    there = (1.0, 0.0, 0.0, 0.0)  # rotation in the joint
    relative = (0.0, 0.0, 0.0)  # angular velocity in the joint
    for m in range(branch.first, branch.last):
        _set_axes(m, multiply(here, there), tree, growth)
        if tree.moves[m].kind == SLIDE:
            x, v, b = _move_slide(m, q, u, tree, growth, (x, v, omega, b, b_omega))
        else:
            spin = _spin_of(m, u, tree, growth)
            b_omega = add(b_omega, cross(omega, spin))
            omega = add(omega, spin)
            relative = add(relative, spin)
            there = multiply(there, _turn_of(m, q, tree))
    _copy_vector(multiply(here, there), growth.turned[branch.child])
    _copy_vector(x, growth.place[k])
    centre = _finish_child(k, (x, v, omega, b, b_omega), bodies, motion)
    _turn_heading(k, q, here, there, relative, tree, growth)
    _set_orientation(k, omega, bodies, motion)
    _fill_columns(k, centre, bodies, motion)


@kernel
def _move_slide(m, q, u, tree, growth, at):
    """Place, velocity and bias after slide ``m``, from place, velocity, angular velocity, and their
    biases ``at`` its beginning."""
    x, v, omega, b, b_omega = at
    move = tree.moves[m]
    axis = vector(growth.axes[m, 0], 0)
    shift = scale(move.sign * q[move.coordinate], axis)
    speed = scale(move.sign * u[move.coordinate], axis)
    swing = cross(omega, shift)
    turning = add(cross(b_omega, shift), cross(omega, swing))
    coriolis = scale(2.0, cross(omega, speed))
    return add(x, shift), add(v, add(speed, swing)), add(add(b, turning), coriolis)


@kernel
def _finish_child(k, at, bodies, motion):
    """Displacement, velocity and bias of the child of joint ``k`` from those ``at`` the joint, as
    of `_move_slide`. Returns the place of its centre of gravity."""
    x, v, omega, b, b_omega = at
    branch = bodies.tree.branches[k]
    child = branch.child
    q = motion.growth.turned[child]
    arm = rotate_vector((q[0], q[1], q[2], q[3]), scale(-1.0, vector(branch.to_child, 0)))
    swing = cross(omega, arm)
    velocity = add(v, swing)
    bias = add(b, add(cross(b_omega, arm), cross(omega, swing)))
    centre = add(x, arm)
    _put_vector(child, sub(centre, vector(bodies.each[child].origin, 0)), motion.coordinates, 0)
    _put_vector(child, velocity, motion.velocity, 0)
    _put_vector(child, velocity, motion.rate, 0)
    _put_vector(child, omega, motion.velocity, 3)
    _put_vector(child, bias, motion.bias, 0)
    _put_vector(child, b_omega, motion.bias, 3)
    return centre


@kernel
def _begin_at_parent(k, bodies, motion):
    """Rotation, and place, velocity and acceleration bias of the parent's point of joint ``k``."""
    branch = bodies.tree.branches[k]
    p = branch.parent
    arm = vector(branch.from_parent, 0)
    zero = (0.0, 0.0, 0.0)
    if p == NO_BODY:
        return (1.0, 0.0, 0.0, 0.0), arm, zero, zero, zero, zero
    q = motion.growth.turned[p]
    here = (q[0], q[1], q[2], q[3])
    arm = rotate_vector(here, arm)
    centre = add(vector(bodies.each[p].origin, 0), vector(motion.coordinates, 6 * p))
    omega = vector(motion.velocity, 6 * p + 3)
    b_omega = vector(motion.bias, 6 * p + 3)
    swing = cross(omega, arm)
    v = add(vector(motion.velocity, 6 * p), swing)
    b = add(vector(motion.bias, 6 * p), add(cross(b_omega, arm), cross(omega, swing)))
    return here, add(centre, arm), v, omega, b, b_omega


@kernel
def _set_axes(m, rotation, tree, growth):
    for a in range(coordinate_count(tree.moves[m])):
        axis = rotate_vector(rotation, vector(tree.moves[m].axes[a], 0))
        for i in range(3):
            growth.axes[m, a, i] = axis[i]


@kernel
def _turn_of(m, q, tree):
    """Rotation of a turn or of a ball, in the axes at rest."""
    move = tree.moves[m]
    j = move.coordinate
    if move.kind == TURN:
        return quaternion_about(vector(move.axes[0], 0), move.sign * q[j])
    return quaternion_of_parameters(
        _combine_axes(move.axes, scale(0.25 * move.sign, (q[j], q[j + 1], q[j + 2])))
    )


@kernel
def _spin_of(m, u, tree, growth):
    """Relative angular velocity of a turn or of a ball, in the earth frame."""
    move = tree.moves[m]
    j = move.coordinate
    if move.kind == TURN:
        return scale(move.sign * u[j], vector(growth.axes[m, 0], 0))
    return _combine_axes(growth.axes[m], scale(move.sign, (u[j], u[j + 1], u[j + 2])))


@kernel
def _combine_axes(axes, a):
    """Sum of the ``axes`` times the entries of a."""
    first = add(scale(a[0], vector(axes[0], 0)), scale(a[1], vector(axes[1], 0)))
    return add(first, scale(a[2], vector(axes[2], 0)))


@kernel
def _turn_heading(k, q, here, there, relative, tree, growth):
    """Heading of the child of joint ``k``, its rate, and the gradient of the joint's part in it."""
    branch = tree.branches[k]
    heading = 0.0
    rate = 0.0
    if branch.parent != NO_BODY:
        heading = growth.heading[branch.parent]
        rate = growth.rate[branch.parent]
    square = there[0] * there[0] + there[3] * there[3]
    axis = (there[1], there[2], there[3])
    g = add(scale(there[0] * there[0], UP), scale(there[0], cross(axis, UP)))
    g = scale(1.0 / square, add(g, scale(there[3], axis))) if square > 0.0 else UP
    g = rotate_vector(here, g)
    if branch.winding >= 0:
        move = tree.moves[branch.winding]
        heading += move.sign * q[move.coordinate] * move.axes[0, 2]
    else:
        side = 1.0 if there[0] >= 0.0 else -1.0  # of p and -p, the same rotation
        heading += 2.0 * atan2(side * there[3], side * there[0])
    growth.heading[branch.child] = heading
    growth.rate[branch.child] = rate + dot(g, relative)
    _copy_vector(g, growth.gradient[k])


@kernel
def _set_orientation(k, omega, bodies, motion):
    """Rotation matrix, angles and their rates of the child of joint ``k``. Its ``rate_map`` is the
    turn by its heading, which `multibody.heading` reads."""
    growth = motion.growth
    b = bodies.tree.branches[k].child
    rest_heading = bodies.each[b].heading
    heading = growth.heading[b] + rest_heading
    q = growth.turned[b]
    attitude = multiply((q[0], q[1], q[2], q[3]), quaternion_about(UP, rest_heading))
    fill_rotation(attitude, motion.rotation[b])
    c = cos(heading)
    s = sin(heading)
    E = motion.rate_map[b]
    E[0, 0] = c
    E[0, 1] = -s
    E[1, 0] = s
    E[1, 1] = c
    angles = rotation_vector(multiply(quaternion_about(UP, -heading), attitude))
    spin = (c * omega[0] + s * omega[1], c * omega[1] - s * omega[0], omega[2] - growth.rate[b])
    rates = vector_rates(angles, spin)
    for i in range(3):
        growth.angles[b, i] = angles[i]
    _put_vector(b, (angles[0], angles[1], growth.heading[b]), motion.coordinates, 3)
    _put_vector(b, (rates[0], rates[1], growth.rate[b]), motion.rate, 3)


@kernel
def _fill_columns(k, centre, bodies, motion):
    """The arm of joint ``k``, and the columns of its own moves at its child."""
    tree = bodies.tree
    growth = motion.growth
    branch = tree.branches[k]
    if branch.parent != NO_BODY:
        origin = vector(bodies.each[branch.parent].origin, 0)
        parent = add(origin, vector(motion.coordinates, 6 * branch.parent))
        _copy_vector(sub(centre, parent), growth.arm[k])
    arm = sub(centre, vector(growth.place[k], 0))
    for m in range(branch.first, branch.last):
        move = tree.moves[m]
        for a in range(coordinate_count(move)):
            axis = scale(move.sign, vector(growth.axes[m, a], 0))
            column = growth.columns[move.coordinate + a]
            swing = cross(axis, arm)
            for i in range(3):
                column[i] = axis[i] if move.kind == SLIDE else swing[i]
                column[3 + i] = 0.0 if move.kind == SLIDE else axis[i]


@kernel
def _fill_slopes(bodies, motion):
    """S from its columns at their own bodies, carried along the tree."""
    tree = bodies.tree
    growth = motion.growth
    S = growth.S
    for i in range(S.shape[0]):
        clear(S[i])
    for j in range(bodies.active.size - tree.coordinates):
        k = 6 * (bodies.active[j] // 6)
        for i in range(6):
            S[k + i, j] = growth.columns[j, i]
    for k in range(tree.branches.size):
        branch = tree.branches[k]
        c = 6 * branch.child
        p = 6 * branch.parent
        if branch.parent != NO_BODY:
            arm = vector(growth.arm[k], 0)
            for j in range(S.shape[1]):
                axis = (S[p + 3, j], S[p + 4, j], S[p + 5, j])
                swing = cross(axis, arm)
                for i in range(3):
                    S[c + i, j] = S[p + i, j] + swing[i]
                    S[c + 3 + i, j] = axis[i]
        for m in range(branch.first, branch.last):
            move = tree.moves[m]
            for j in range(move.coordinate, move.coordinate + coordinate_count(move)):
                for i in range(6):
                    S[c + i, j] = growth.columns[j, i]


@kernel
def _copy_vector(value, target):
    for i in range(target.size):
        target[i] = value[i]


@kernel
def _put_vector(b, value, target, first):
    for i in range(3):
        target[6 * b + first + i] = value[i]


@root
def record_angles(bodies, motion, out):
    """Write to ``out`` (6 nb,) roll, pitch and yaw of jointed bodies (z-y'-x'') in place of their
    rotation vectors: records have the same angles for all bodies. Of the two triples of one
    attitude they are that with the yaw nearest to the heading: a flap that turns over keeps it."""
    tree = bodies.tree
    for k in range(tree.branches.size if bodies.exact else 0):
        b = tree.branches[k].child
        R = motion.rotation[b]
        heading = motion.growth.heading[b]
        course = heading + bodies.each[b].heading
        side = 1.0 if cos(course) * R[0, 0] + sin(course) * R[1, 0] >= 0.0 else -1.0
        yaw = atan2(side * R[1, 0], side * R[0, 0]) - bodies.each[b].heading
        level = side * sqrt(R[0, 0] * R[0, 0] + R[1, 0] * R[1, 0])
        out[6 * b + 3] = atan2(side * R[2, 1], side * R[2, 2])
        out[6 * b + 4] = atan2(-R[2, 0], level)
        out[6 * b + 5] = yaw + FULL_TURN * floor((heading - yaw) / FULL_TURN + 0.5)


@root
def fill_rates(q, u, bodies, dq):
    """Fill the entries of ``dq`` (n,) = q' = N(q) u of ball joints; all others must hold u."""
    tree = bodies.tree
    for m in range(tree.moves.size if bodies.exact else 0):
        move = tree.moves[m]
        if move.kind == BALL:
            j = move.coordinate
            s = scale(0.25 * move.sign, (q[j], q[j + 1], q[j + 2]))
            omega = scale(move.sign, (u[j], u[j + 1], u[j + 2]))
            rates = parameter_rates(s, omega)
            for i in range(3):
                dq[j + i] = move.sign * rates[i]


@root_giving(bool)
def switch_rotation_chart(q, bodies):
    """Replace Rodrigues parameters beyond 180 deg by those of the same rotation, in place. Returns
    true if there were any."""
    tree = bodies.tree
    changed = False
    for m in range(tree.moves.size if bodies.exact else 0):
        move = tree.moves[m]
        if move.kind == BALL:
            j = move.coordinate
            p = (q[j], q[j + 1], q[j + 2])
            square = dot(p, p)
            if square > HALF_TURN_NORM * HALF_TURN_NORM:
                changed = True
                for i in range(3):
                    q[j + i] = -HALF_TURN_NORM * HALF_TURN_NORM / square * p[i]
    return changed


@root
def add_generalised(bodies, motion, wrench, Q):
    """Q = S^T F (n,) for the wrenches F (6 nb,)."""
    tree = bodies.tree
    growth = motion.growth
    if not bodies.exact:
        S = growth.S
        for j in range(Q.size):
            entry = 0.0
            for i in range(wrench.size):
                entry += S[i, j] * wrench[i]
            Q[j] = entry
        return
    F = growth.carried
    assign(F, wrench)
    for k in range(tree.branches.size - 1, -1, -1):
        branch = tree.branches[k]
        c = 6 * branch.child
        for m in range(branch.first, branch.last):
            move = tree.moves[m]
            for j in range(move.coordinate, move.coordinate + coordinate_count(move)):
                Q[j] = _power(growth.columns[j], F, c)
        if branch.parent != NO_BODY:
            carry_wrench(branch.child, branch.parent, vector(growth.arm[k], 0), F)
    for j in range(bodies.active.size - tree.coordinates):
        Q[j] = _power(growth.columns[j], F, 6 * (bodies.active[j] // 6))


@kernel
def carry_wrench(child, parent, arm, F):
    """Add the wrench of the ``child`` in ``F`` (6 nb,) to that of its parent, whose centre of
    gravity is at -``arm`` from its own."""
    c = 6 * child
    p = 6 * parent
    swing = cross(arm, vector(F, c))
    for i in range(3):
        F[p + i] += F[c + i]
        F[p + 3 + i] += F[c + 3 + i] + swing[i]


@kernel
def carry_acceleration(parent, child, arm, alpha):
    """The acceleration of the ``child`` in ``alpha`` (6 nb,) if it moves as a part of its
    parent."""
    c = 6 * child
    p = 6 * parent
    swing = cross(vector(alpha, p + 3), arm)
    for i in range(3):
        alpha[c + i] = alpha[p + i] + swing[i]
        alpha[c + 3 + i] = alpha[p + 3 + i]


@kernel
def _power(column, F, k):
    """A ``column`` (6,) times the wrench from index ``k`` on."""
    push = dot(vector(column, 0), vector(F, k))
    return push + dot(vector(column, 3), vector(F, k + 3))


@root
def add_inertia(bodies, motion, M, H):
    """H = S^T M S (n, n) for M (6 nb, 6 nb), whose first n columns become M S. Most entries of M
    are zero, and so are those of S where trees are wide."""
    S = motion.growth.S
    if bodies.exact:
        _fill_slopes(bodies, motion)
    size = M.shape[0]
    n = H.shape[0]
    for i in range(size):
        clear(H[0])
        for k in range(size):
            entry = M[i, k]
            if entry != 0.0:
                for j in range(n):
                    H[0, j] += entry * S[k, j]
        for j in range(n):
            M[i, j] = H[0, j]
    for i in range(n):
        clear(H[i])
    for k in range(size):
        for i in range(n):
            entry = S[k, i]
            if entry != 0.0:
                for j in range(n):
                    H[i, j] += entry * M[k, j]


@root
def add_to_accelerations(x, bodies, motion, a):
    """a += S u' for the accelerations ``x`` (n,)."""
    tree = bodies.tree
    growth = motion.growth
    if not bodies.exact:
        S = growth.S
        for i in range(a.size):
            for j in range(x.size):
                a[i] += S[i, j] * x[j]
        return
    alpha = growth.carried
    clear(alpha)
    for j in range(bodies.active.size - tree.coordinates):
        _add_column(growth.columns[j], x[j], 6 * (bodies.active[j] // 6), alpha)
    for k in range(tree.branches.size):
        branch = tree.branches[k]
        c = 6 * branch.child
        if branch.parent != NO_BODY:
            carry_acceleration(branch.parent, branch.child, vector(growth.arm[k], 0), alpha)
        for m in range(branch.first, branch.last):
            move = tree.moves[m]
            for j in range(move.coordinate, move.coordinate + coordinate_count(move)):
                _add_column(growth.columns[j], x[j], c, alpha)
    for i in range(a.size):
        a[i] += alpha[i]


@kernel
def _add_column(column, rate, k, alpha):
    for i in range(6):
        alpha[k + i] += rate * column[i]


@kernel
def add_heading_moment(b, moment, bodies, motion, wrench):
    """Add to ``wrench`` the wrench whose power is ``moment`` times the heading rate of a body."""
    tree = bodies.tree
    while tree.branches.size > 0 and b != NO_BODY and tree.branch[b] >= 0:
        k = tree.branch[b]
        parent = tree.branches[k].parent
        for i in range(3):
            m = moment * motion.growth.gradient[k, i]
            wrench[6 * b + 3 + i] += m
            if parent != NO_BODY:
                wrench[6 * parent + 3 + i] -= m
        b = parent
    if b != NO_BODY:
        E = motion.rate_map[b]
        along = -E[2, 0] * moment / (E[1, 1] * E[0, 0] - E[0, 1] * E[1, 0])
        wrench[6 * b + 3] += E[1, 1] * along
        wrench[6 * b + 4] -= E[0, 1] * along
        wrench[6 * b + 5] += moment


@root
def add_wrench_of_angles(b, Q, bodies, motion, wrench):
    """Add the wrench whose power is ``Q`` (6,) times the rates of the coordinates of a jointed
    body."""
    moment = conjugate_moment(vector(motion.growth.angles[b], 0), (Q[3], Q[4], 0.0))
    E = motion.rate_map[b]
    for i in range(3):
        wrench[6 * b + i] += Q[i]
    wrench[6 * b + 3] += E[0, 0] * moment[0] + E[0, 1] * moment[1]
    wrench[6 * b + 4] += E[1, 0] * moment[0] + E[1, 1] * moment[1]
    wrench[6 * b + 5] += moment[2]
    add_heading_moment(b, Q[5] - moment[2], bodies, motion, wrench)


@kernel
def push_joint(m, a, force, bodies, motion, wrench):
    """Add to ``wrench`` the wrench whose power is ``force`` times the rate of coordinate ``a`` of
    move ``m``: on the child of its joint, and its opposite on the parent."""
    tree = bodies.tree
    growth = motion.growth
    k = _joint_of(m, tree)
    branch = tree.branches[k]
    move = tree.moves[m]
    push = scale(move.sign * force, vector(growth.axes[m, a], 0))
    for side in range(2):
        b = branch.child if side == 0 else branch.parent
        sign = 1.0 - 2.0 * side
        if b != NO_BODY:
            moment = push
            if move.kind == SLIDE:
                moment = cross(arm_to_joint(k, side, bodies, motion), push)
            for i in range(3):
                if move.kind == SLIDE:
                    wrench[6 * b + i] += sign * push[i]
                wrench[6 * b + 3 + i] += sign * moment[i]


@kernel
def arm_to_joint(k, side, bodies, motion):
    """Arm of joint ``k`` from the centre of gravity of its child (side 0) or of its parent."""
    branch = bodies.tree.branches[k]
    if not bodies.exact:
        return vector(branch.to_child if side == 0 else branch.from_parent, 0)
    b = branch.child if side == 0 else branch.parent
    centre = add(vector(bodies.each[b].origin, 0), vector(motion.coordinates, 6 * b))
    return sub(vector(motion.growth.place[k], 0), centre)


@root
def sum_joint_loads(missing, bodies, motion, out):
    """Write force and moment (6,) about each joint k of trees to ``out`` from 6 k on: on the
    joint's body, in the earth frame. They are the sums of the wrenches ``missing`` (6 nb,) of all
    bodies that the joint carries; ``missing`` is overwritten."""
    tree = bodies.tree
    for j in range(tree.branches.size):
        k = tree.branches.size - 1 - j
        branch = tree.branches[k]
        c = 6 * branch.child
        F = vector(missing, c)
        moment = sub(vector(missing, c + 3), cross(arm_to_joint(k, 0, bodies, motion), F))
        sign = -1.0 if branch.reversed else 1.0
        for i in range(3):
            out[6 * branch.joint + i] = sign * F[i]
            out[6 * branch.joint + 3 + i] = sign * moment[i]
        if branch.parent != NO_BODY:
            p = 6 * branch.parent
            onward = add(moment, cross(arm_to_joint(k, 1, bodies, motion), F))
            for i in range(3):
                missing[p + i] += F[i]
                missing[p + 3 + i] += onward[i]


@kernel
def _joint_of(m, tree):
    """The joint that a move belongs to."""
    k = 0
    while tree.branches[k].last <= m:
        k += 1
    return k
