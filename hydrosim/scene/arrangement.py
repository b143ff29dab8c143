"""How joints arrange bodies: trees, whose joint motions are coordinates, and joints beside them.

Joints that last for the whole run make trees. Each tree grows from the earth or, if it does not
touch the earth, from one of its bodies, which keeps its own six coordinates. A joint that would
close a loop, a joint that is only `active` at times, and a rod is no branch: it is a constraint.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from hydrosim.scene.joint import Joint, JointMotion, JointType, MotionKind

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


@dataclass(frozen=True)
class Arrangement:
    """The ``branches``, parents before children, and the names of the joints that are constraints:
    ``loops`` (and rods) for the whole run, and ``passing`` at times."""

    branches: tuple[Branch, ...]
    loops: tuple[str, ...]
    passing: tuple[str, ...]

    @cached_property
    def children(self) -> frozenset[str]:
        """Bodies that a joint carries: they have no coordinates of their own."""
        return frozenset(branch.child for branch in self.branches)

    @cached_property
    def roots(self) -> dict[str, str]:
        """The first body of the tree of each body that joints carry or that carries others. A joint
        to the earth begins a tree of its own."""
        roots: dict[str, str] = {}
        for branch in self.branches:
            below = branch.child if branch.parent is None else branch.parent
            roots[branch.child] = roots.setdefault(below, below)
        return roots

    @cached_property
    def anchored(self) -> frozenset[str]:
        """Bodies that joints to the earth hold near their places and headings."""
        anchored: set[str | None] = {EARTH}
        for branch in self.branches:
            stays = all(_stays(motion, branch.joint) for motion in branch.joint.motions)
            if stays and branch.parent in anchored:
                anchored.add(branch.child)
        return frozenset(body for body in anchored if body is not None)


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


def _stays(motion: JointMotion, joint: Joint) -> bool:
    """Whether a motion turns about a level axis, or slides along the vertical."""
    up = abs(joint.axes()[motion.axis, 2])
    return up < LEVEL if motion.kind == MotionKind.TURN else up > 1.0 - LEVEL


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
