"""The arrangement of joints in trees, whose motions are coordinates, and joints beside them.

Joints that last for the whole run make trees. Each tree grows from the earth or, if it does not
touch the earth, from one of its bodies, which keeps its own six coordinates. A joint that would
close a loop, a joint that is only `active` at times, and a rod is no branch: it is a constraint.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from hydrosim.scene.joint import Joint, JointMotion, MotionKind, Rod

EARTH_BODY = None
HORIZONTAL_AXIS_TOL = 1e-3  # of a unit axis: its part along the vertical


class TreeJoint(NamedTuple):
    """A joint of a tree: its ``name``, the ``child`` that it carries and its ``parent`` (None: the
    earth). It is ``reversed`` if the child is the joint's `to`."""

    name: str
    joint: Joint
    child: str
    parent: str | None
    reversed: bool


class Arrangement(NamedTuple):
    """The ``branches``, parents before children, and the names of the joints that are constraints:
    ``loops`` (and rods) for the whole run, and ``passing`` at times. The ``children`` are bodies
    that a joint carries: they have no coordinates of their own. The ``roots`` are the first bodies
    of the trees of bodies that joints carry, or that carry others; a joint to the earth begins a
    tree of its own."""

    branches: tuple[TreeJoint, ...]
    loops: tuple[str, ...]
    passing: tuple[str, ...]
    children: frozenset[str]
    roots: Mapping[str, str]

    def anchors(self, body: str) -> bool:
        """Whether joints to the earth hold a ``body`` near its place and heading."""
        below = {branch.child: branch for branch in self.branches}
        root = below.get(self.roots.get(body, body))
        if root is None or root.parent is not EARTH_BODY:
            return False
        place: str | None = body
        while place is not EARTH_BODY:
            joint = below[place].joint
            if not all(_keeps_level(motion, joint) for motion in joint.motions):
                return False
            place = below[place].parent
        return True


def arrange_joints(joints: Mapping[str, Joint], bodies: Sequence[str]) -> Arrangement:
    """Arrange the ``joints`` between ``bodies``. The order of the bodies decides between equals."""
    lasting = {name: joint for name, joint in joints.items() if joint.lasts}
    carrying = {name: j for name, j in lasting.items() if not isinstance(j, Rod)}
    reached: set[str | None] = {EARTH_BODY}
    branches = list(_grow_branches(carrying, reached))
    for body in _roots(carrying, bodies):
        if body not in reached:
            reached.add(body)
            branches += _grow_branches(carrying, reached)
    used = {branch.name for branch in branches}
    return Arrangement(
        tuple(branches),
        tuple(name for name in lasting if name not in used),
        tuple(name for name in joints if name not in lasting),
        frozenset(branch.child for branch in branches),
        _root_of_each(branches),
    )


def _root_of_each(branches: Sequence[TreeJoint]) -> dict[str, str]:
    """The first body of the tree of each body in the ``branches``."""
    roots: dict[str, str] = {}
    for branch in branches:
        below = branch.child if branch.parent is None else branch.parent
        roots[branch.child] = roots.setdefault(below, below)
    return roots


def _keeps_level(motion: JointMotion, joint: Joint) -> bool:
    """Whether a motion turns about a level axis, or slides along the vertical."""
    up = abs(joint.axes()[motion.axis, 2])
    return (
        up < HORIZONTAL_AXIS_TOL
        if motion.kind == MotionKind.TURN
        else up > 1.0 - HORIZONTAL_AXIS_TOL
    )


def _roots(joints: Mapping[str, Joint], bodies: Sequence[str]) -> list[str]:
    """Bodies in the order in which they become roots: first those that others are joined `to`,
    and that are joined to none."""
    joined = {joint.body for joint in joints.values()}
    return sorted(bodies, key=lambda body: body in joined)


def _grow_branches(joints: Mapping[str, Joint], reached: set[str | None]) -> Iterator[TreeJoint]:
    """Branches from the bodies ``reached``, nearest first; it adds the bodies that they carry."""
    grows = True
    while grows:
        grows = False
        layer = set(reached)
        for name, joint in joints.items():
            if joint.to in layer and joint.body not in reached:
                reached.add(joint.body)
                yield TreeJoint(name, joint, joint.body, joint.to, False)
                grows = True
            elif joint.body in layer and joint.to not in reached:
                reached.add(joint.to)
                yield TreeJoint(name, joint, str(joint.to), joint.body, True)
                grows = True
