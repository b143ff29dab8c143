"""Bodies and joints of a scene as constants: trees of joints, and their start."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import cos, remainder, sin, tan

import numpy as np

from hydrosim.compile.tanks import steady_surface
from hydrosim.dofs import DOFS, about_z
from hydrosim.multibody.kinematics import BODY, Bodies, slopes_at
from hydrosim.multibody.tree import (
    BALL,
    BRANCH,
    FULL_TURN,
    MOVE,
    NO_BODY,
    NO_TREE,
    SLIDE,
    TURN,
    Tree,
)
from hydrosim.scene import Ball, Body, Hinge, Joint, Kinematics, Planar, Scene, Universal, Weight
from hydrosim.scene.joint import JointMotion, MotionKind
from hydrosim.scene.scene import TreeJoint, arrangement, tree_joints

# Trees of joints as arrays: their motions are coordinates.

SWIVEL = MotionKind.SWIVEL
TREE_JOINT_CODES = {MotionKind.SLIDE: SLIDE, MotionKind.TURN: TURN, SWIVEL: BALL}


def check_trees(scene: Scene) -> Iterator[str]:
    """Problems of joints and of what they carry that a case file cannot contain."""
    joint_tree = arrangement(scene)
    bodies = {body.name: body for body in scene.bodies}
    little = scene.solver.kinematics == Kinematics.LINEAR
    roots = (body for name, body in bodies.items() if name not in joint_tree.children)
    if not any(body.dofs for body in roots) and not any(
        b.joint.motions for b in joint_tree.branches
    ):
        yield "joints: found that they hold all bodies; expected at least one that can move"
    for branch in joint_tree.branches:
        child = bodies[branch.child]
        parent = bodies.get(str(branch.parent), child)
        if little and Weight.CARRIED in (child.weight, parent.weight):
            yield (
                f"joints.{branch.name}: kinematics: linear keeps arms as at rest, so that a weight"
                " that a joint carries restores nothing; choose exact"
            )
        if any(child.position) or any(child.velocity):
            yield f"bodies.{child.name}: found a start of a body that {branch.name} carries"
    for name, joint in scene.joints.items():
        for motion, acting in zip(joint.motions, joint.resistances, strict=True):
            friction = acting.friction
            if friction and friction.coefficients[1] and not has_own_bearings(joint, motion):
                yield (
                    f"joints.{name}: found static_coefficient, a friction that grows with the load,"
                    f" in {motion.name}; expected it in a hinge, a universal joint, or the slide of"
                    " a slider, guide or cylindrical joint. Others share one load between motions:"
                    " give a force or moment"
                )
        if name in joint_tree.loops and any(
            r.acts or r.position or r.velocity for r in joint.resistances
        ):
            yield f"joints.{name}: found forces or a start in a joint that closes a loop"


def has_own_bearings(joint: Joint, motion: JointMotion) -> bool:
    """Whether the load of a joint makes friction in this motion alone."""
    if motion.kind == MotionKind.TURN:
        return isinstance(joint, Hinge | Universal)
    return motion.kind == MotionKind.SLIDE and not isinstance(joint, Planar)


def tree_of(scene: Scene, own_dofs: np.ndarray, origins: np.ndarray) -> Tree:
    """Tree of the joints of a scene. ``own_dofs`` are the indices of the free coordinates of its
    roots, which come first; ``origins`` (nb, 3) are the centres of gravity at rest."""
    names = [body.name for body in scene.bodies]
    tree_branches = arrangement(scene).branches
    if not tree_branches:
        return NO_TREE
    index = {name: i for i, name in enumerate(names)}
    first = _first_coordinates(scene, own_dofs.size)
    moves: list[tuple[object, ...]] = []
    branches = []
    for branch in tree_branches:
        child = index[branch.child]
        parent = NO_BODY if branch.parent is None else index[branch.parent]
        body = index[branch.joint.body]
        place = place_at_rest(branch.joint, scene.bodies[body], origins[body])
        begin = len(moves)
        moves += _branch_moves(branch, scene.bodies[body], first[branch.name])
        branches.append(
            (
                *(child, parent, begin, len(moves), scene.bodies[child].heading),
                place - (0.0 if parent == NO_BODY else origins[parent]),
                place - origins[child],
                _winding_index(moves[begin:], begin),
                *(list(scene.joints).index(branch.name), branch.reversed),
            )
        )
    tree = Tree(
        np.array(branches, dtype=BRANCH),
        np.array(moves, dtype=MOVE),
        np.full(len(names), -1),
        sum(len(joint.motions) for joint in tree_joints(scene).values()),
        _start_coordinates(scene),
        np.zeros((0, 0)),
    )
    tree.branch[tree.branches["child"]] = np.arange(len(branches))
    return tree._replace(slopes=_slopes_at_rest(tree, own_dofs, origins))


def place_at_rest(joint: Joint, body: Body, origin: np.ndarray) -> np.ndarray:
    """Place of a joint with all bodies at rest, in the earth frame (3,); ``origin`` is the centre
    of gravity of its ``body``."""
    return np.asarray(origin + about_z(body.heading) @ np.array(joint.point))


def _first_coordinates(scene: Scene, first: int) -> dict[str, int]:
    """First coordinate of every joint of the trees, the first of all being ``first``."""
    first_by_joint = {}
    for name, joint in tree_joints(scene).items():
        first_by_joint[name] = first
        first += len(joint.motions)
    return first_by_joint


def _branch_moves(branch: TreeJoint, body: Body, first: int) -> Iterator[tuple[object, ...]]:
    """Entries of `MOVE` of a joint, from parent to child; its coordinates begin at ``first``."""
    axes = branch.joint.axes() @ about_z(body.heading).T
    steps = [
        (
            TREE_JOINT_CODES[motion.kind],
            first + j,
            -1.0 if branch.reversed else 1.0,
            _axes_of(motion, axes),
        )
        for j, motion in enumerate(branch.joint.motions)
        if motion.kind != MotionKind.SWIVEL or motion.axis == 0  # a ball is one move
    ]
    yield from reversed(steps) if branch.reversed else steps


def _axes_of(motion: JointMotion, axes: np.ndarray) -> np.ndarray:
    """The axis of a motion as first of three; a ball has all three in their order."""
    return np.roll(axes, -motion.axis, axis=0)


def _winding_index(moves: list[tuple[object, ...]], begin: int) -> int:
    """Number of the move that turns a joint about the vertical if it has no other turn, else -1."""
    turns = [(begin + m, move) for m, move in enumerate(moves) if move[0] != SLIDE]
    upright = len(turns) == 1 and turns[0][1][0] == TURN
    if upright and not np.any(np.asarray(turns[0][1][3])[0, :2]):
        return turns[0][0]
    return -1


def _start_coordinates(scene: Scene) -> np.ndarray:
    """Values and rates (nq, 2) of the coordinates of joints at the start."""
    branches = arrangement(scene).branches
    backwards = {branch.name for branch in branches if branch.reversed}
    starts = []
    for name, joint in tree_joints(scene).items():
        values = [(acting.position, acting.velocity) for acting in joint.resistances]
        start = np.reshape(np.array(values, dtype=float), (-1, 2))
        if isinstance(joint, Ball) and scene.solver.kinematics == "exact":
            if name in backwards:
                start[:, 1] = _seen_from_body(start[:, 1], start[:, 0])
            start[:, 0] = rodrigues(start[:, 0])
        starts.append(start)
    return np.concatenate(starts)


def _seen_from_body(rate: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """An angular velocity (3,) in the axes of a joint's body, which has turned by a ``rotation``
    vector (3,), from those of its `to`. Rates of a ball are along axes of the parent."""
    angle = float(np.linalg.norm(rotation))
    if angle == 0.0:
        return rate
    axis = rotation / angle
    along = axis * (axis @ rate)
    return np.asarray(along + cos(angle) * (rate - along) - sin(angle) * np.cross(axis, rate))


def rodrigues(rotation: np.ndarray) -> np.ndarray:
    """Four times the modified Rodrigues parameters (3,) of a rotation vector (3,), of at most 180
    deg."""
    angle = float(np.linalg.norm(rotation))
    nearest = remainder(angle, FULL_TURN)
    return rotation if angle == 0.0 else rotation * (4.0 * tan(0.25 * nearest) / angle)


def _slopes_at_rest(tree: Tree, own_dofs: np.ndarray, origins: np.ndarray) -> np.ndarray:
    """S (6 nb, n) at rest."""
    n = own_dofs.size + tree.coordinates  # none, if all is fixed
    S = np.zeros((len(origins), 6, n))
    S.reshape(6 * len(origins), n)[own_dofs, np.arange(own_dofs.size)] = 1.0
    for branch in tree.branches:
        child, parent = branch["child"], branch["parent"]
        if parent != NO_BODY:
            arm = origins[child] - origins[parent]
            S[child] = S[parent]
            S[child, :3] += np.cross(S[parent, 3:].T, arm).T
        for move in tree.moves[branch["first"] : branch["last"]]:
            for a in range(3 if move["kind"] == BALL else 1):
                axis = move["sign"] * move["axes"][a]
                j = move["coordinate"] + a
                if move["kind"] == SLIDE:
                    S[child, :3, j] = axis
                else:
                    S[child, :3, j] = np.cross(axis, -branch["to_child"])
                    S[child, 3:, j] = axis
    return np.ascontiguousarray(S.reshape(6 * len(origins), n))


# Bodies as arrays, with the joints between them.

DISPLACEMENT_RTOL = 1e-9  # of a displacement per coordinate: smaller ones are rounding
SAMPLED_CONFIGURATIONS = 3  # at which joints are looked at, besides rest


def bodies_of(scene: Scene) -> Bodies:
    """Constants of all bodies of a scene and of their joints."""
    carried = arrangement(scene).children
    own_dofs = np.array(
        [
            6 * i + DOFS.index(dof)
            for i, body in enumerate(scene.bodies)
            for dof in sorted(body.dofs, key=DOFS.index)
            if body.name not in carried
        ],
        dtype=np.int64,
    )
    body_rows = [
        (
            b.mass,
            b.inertia,
            about_z(b.heading) @ b.centre_of_gravity + (*b.location, 0.0),
            b.heading,
            steady_surface(b, scene),
        )
        for b in scene.bodies
    ]
    constants = np.array(body_rows, dtype=BODY)
    tree = tree_of(scene, own_dofs, constants["origin"])
    return Bodies(
        each=constants,
        active=np.concatenate([own_dofs, 6 * len(body_rows) + np.arange(tree.coordinates)]),
        locked=np.concatenate([b.position for b in scene.bodies]).astype(float),
        exact=scene.solver.kinematics == Kinematics.EXACT,
        tree=tree,
    )


def with_dofs_of_joints(scene: Scene) -> Scene:
    """Scene in which bodies that joints carry have the degrees of freedom that their joints leave.
    Waves, memory and questions leave out the others."""
    carried = arrangement(scene).children
    if not carried:
        return scene
    bodies = bodies_of(scene)
    draw = np.random.default_rng(1)
    n = bodies.active.size
    places = [np.zeros(n), *(draw.uniform(-1.0, 1.0, n) for _ in range(SAMPLED_CONFIGURATIONS))]
    size = np.max([np.abs(slopes_at(bodies, q)).max(axis=1, initial=0.0) for q in places], axis=0)
    moves = size.reshape(-1, 6) > DISPLACEMENT_RTOL
    free_bodies = [
        replace(body, dofs=tuple(np.array(DOFS)[may_move])) if body.name in carried else body
        for body, may_move in zip(scene.bodies, moves, strict=True)
    ]
    return replace(scene, bodies=tuple(free_bodies))
