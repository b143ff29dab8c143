"""How joints arrange bodies: trees, whose joint motions are coordinates, and joints beside them.

Joints that last for the whole run make trees. Each tree grows from the earth or, if it does not
touch the earth, from one of its bodies, which keeps its own six coordinates. A joint that would
close a loop, a joint that is only `active` at times, and a rod is no branch: it is a constraint.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from hydrosim.scene.joint import Joint, JointMotion, JointType, MotionKind

if TYPE_CHECKING:
    from hydrosim.scene.scene import Scene

EARTH = None
LEVEL = 1e-3  # of a unit axis: its part along the vertical


class Branch(NamedTuple):
    """A joint of a tree: its ``name``, the ``child`` that it carries and its ``parent`` (None: the
    earth). It is ``reversed`` if the child is the joint's `to`."""

    name: str
    joint: Joint
    child: str
    parent: str | None
    reversed: bool


class Arrangement(NamedTuple):
    """The ``branches``, parents before children, and the names of the joints that are constraints:
    ``loops`` (and rods) for the whole run, and ``passing`` at times."""

    branches: tuple[Branch, ...]
    loops: tuple[str, ...]
    passing: tuple[str, ...]

    @property
    def children(self) -> frozenset[str]:
        """Bodies that a joint carries: they have no coordinates of their own."""
        return frozenset(branch.child for branch in self.branches)


def arranged(joints: Mapping[str, Joint], bodies: Sequence[str]) -> Arrangement:
    """Arrange the ``joints`` between ``bodies``. The order of the bodies decides between equals."""
    lasting = {name: joint for name, joint in joints.items() if joint.lasts}
    carrying = {name: j for name, j in lasting.items() if j.type != JointType.ROD}
    reached: set[str | None] = {EARTH}
    branches = list(_grown(carrying, reached))
    for body in _roots(carrying, bodies):
        if body not in reached:
            reached.add(body)
            branches += _grown(carrying, reached)
    used = {branch.name for branch in branches}
    return Arrangement(
        tuple(branches),
        tuple(name for name in lasting if name not in used),
        tuple(name for name in joints if name not in lasting),
    )


def arrangement(scene: Scene) -> Arrangement:
    """How the joints of a scene arrange its bodies."""
    return arranged(scene.joints, [body.name for body in scene.bodies])


def joined_with(scene: Scene, body: str) -> frozenset[str]:
    """The body and all bodies that the joints of its tree connect with it."""
    found = {body}
    branches = arrangement(scene).branches
    for _ in branches:
        for branch in branches:
            if branch.parent is not None and {branch.child, branch.parent} & found:
                found |= {branch.child, branch.parent}
    return frozenset(found)


def is_anchored(scene: Scene, body: str) -> bool:
    """True if joints to the earth hold a body near its place and heading: they turn about level
    axes, or slide up and down."""
    branches = arrangement(scene).branches
    below = {branch.child: branch for branch in branches}
    while body in below:
        if not all(_stays(motion, below[body].joint) for motion in below[body].joint.motions):
            return False
        parent = below[body].parent
        if parent is None:
            return True
        body = parent
    return False


def _stays(motion: JointMotion, joint: Joint) -> bool:
    """Whether a motion turns about a level axis, or slides along the vertical."""
    up = abs(joint.axes()[motion.axis, 2])
    return up < LEVEL if motion.kind == MotionKind.TURN else up > 1.0 - LEVEL


def floating_roots(scene: Scene) -> dict[str, tuple[str, ...]]:
    """Roots of trees that do not touch the earth, each with the bodies that the tree carries."""
    carried: dict[str, list[str]] = {}
    root_of: dict[str, str | None] = {}
    for branch in arrangement(scene).branches:  # parents before children
        parent = branch.parent
        root = parent if parent is None else root_of.get(parent, parent)
        root_of[branch.child] = root
        if root is not None:
            carried.setdefault(root, []).append(branch.child)
    return {root: tuple(children) for root, children in carried.items()}


def tree_joints(scene: Scene) -> dict[str, Joint]:
    """The joints whose motions are coordinates, in the order of the scene."""
    found = arrangement(scene).branches
    used = {branch.name for branch in found}
    return {name: joint for name, joint in scene.joints.items() if name in used}


def _roots(joints: Mapping[str, Joint], bodies: Sequence[str]) -> list[str]:
    """Bodies in the order in which they become roots: first those that others are joined `to`,
    and that are joined to none."""
    joined = {joint.body for joint in joints.values()}
    return sorted(bodies, key=lambda body: body in joined)


def _grown(joints: Mapping[str, Joint], reached: set[str | None]) -> Iterator[Branch]:
    """Branches from the bodies ``reached``, nearest first; it adds the bodies that they carry."""
    grows = True
    while grows:
        grows = False
        layer = set(reached)
        for name, joint in joints.items():
            if joint.to in layer and joint.body not in reached:
                reached.add(joint.body)
                yield Branch(name, joint, joint.body, joint.to, False)
                grows = True
            elif joint.body in layer and joint.to not in reached:
                reached.add(joint.to)
                yield Branch(name, joint, str(joint.to), joint.body, True)
                grows = True
