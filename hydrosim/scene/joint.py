"""Joints between bodies, or of a body to the earth, and their arrangement in trees.

A joint leaves some relative motions free. `MOTIONS` lists them for each type: this table is all
that a new type needs here.

How joints arrange bodies: trees, whose joint motions are coordinates, and joints beside them.

Joints that last for the whole run make trees. Each tree grows from the earth or, if it does not
touch the earth, from one of its bodies, which keeps its own six coordinates. A joint that would
close a loop, a joint that is only `active` at times, and a rod is no branch: it is a constraint.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from math import inf
from typing import NamedTuple

import numpy as np

from hydrosim.scene.force import Active


class JointType(StrEnum):
    """Types of joints."""

    HINGE = "hinge"
    BALL = "ball"
    UNIVERSAL = "universal"
    SLIDER = "slider"
    CYLINDRICAL = "cylindrical"
    PLANAR = "planar"
    GUIDE = "guide"
    FIXED = "fixed"
    RATCHET = "ratchet"
    ROD = "rod"


class MotionKind(StrEnum):
    """A slide along an axis, a turn about an axis, or one of the three turns of a ball."""

    SLIDE = "slide"
    TURN = "turn"
    SWIVEL = "swivel"


class JointMotion(NamedTuple):
    """A free motion of a joint: its ``name``, its ``kind``, and the number of its axis among
    `Joint.axes`."""

    name: str
    kind: MotionKind
    axis: int


MOTIONS: dict[JointType, tuple[JointMotion, ...]] = {
    JointType.HINGE: (JointMotion("angle", MotionKind.TURN, 0),),
    JointType.SLIDER: (JointMotion("offset", MotionKind.SLIDE, 0),),
    JointType.CYLINDRICAL: (
        JointMotion("offset", MotionKind.SLIDE, 0),
        JointMotion("angle", MotionKind.TURN, 0),
    ),
    JointType.UNIVERSAL: (
        JointMotion("first_angle", MotionKind.TURN, 0),
        JointMotion("second_angle", MotionKind.TURN, 1),
    ),
    JointType.PLANAR: (
        JointMotion("first_offset", MotionKind.SLIDE, 1),
        JointMotion("second_offset", MotionKind.SLIDE, 2),
        JointMotion("angle", MotionKind.TURN, 0),
    ),
    JointType.BALL: (
        JointMotion("rotation_x", MotionKind.SWIVEL, 0),
        JointMotion("rotation_y", MotionKind.SWIVEL, 1),
        JointMotion("rotation_z", MotionKind.SWIVEL, 2),
    ),
    JointType.GUIDE: (
        JointMotion("offset", MotionKind.SLIDE, 0),
        JointMotion("rotation_x", MotionKind.SWIVEL, 0),
        JointMotion("rotation_y", MotionKind.SWIVEL, 1),
        JointMotion("rotation_z", MotionKind.SWIVEL, 2),
    ),
    JointType.FIXED: (),
    JointType.RATCHET: (),
    JointType.ROD: (),
}
"""Free motions of each type, applied one after the other from ``to`` outwards to ``body``. A
ratchet and a rod are never branches of a tree: they leave all motions free but one."""


@dataclass(frozen=True)
class Stops:
    """End stops of a joint motion beyond ``lowest`` and ``highest`` [m or rad]: ``stiffness`` and
    ``damping`` of both."""

    lowest: float
    highest: float
    stiffness: float
    damping: float = 0.0


@dataclass(frozen=True)
class JointFriction:
    """Dry friction of a joint motion [N or N m]: largest while it rests, and while it moves.

    To ``static`` and ``kinetic``, which are given, both coefficients times the load of the bearings
    are added: of a pin of this ``radius`` [m], or a slide with 1, in two bearings at this distance
    [m] along its axis, and a collar of ``collar_radius`` [m] for the force along the axis."""

    static: float = 0.0
    kinetic: float = 0.0
    static_coefficient: float = 0.0
    kinetic_coefficient: float = 0.0
    radius: float = 1.0
    collar_radius: float = 0.0
    bearing_distance: float = inf


@dataclass(frozen=True)
class Resistance:
    """What acts in a free motion of a joint: a spring of this ``stiffness`` (of either sign) about
    ``neutral``, linear ``damping``, ``stops``, dry ``friction``; ``position`` and ``velocity`` are
    those of the start. In SI units, [N/m], [N m/rad], ..."""

    stiffness: float = 0.0
    neutral: float = 0.0
    damping: float = 0.0
    stops: Stops | None = None
    friction: JointFriction | None = None
    position: float = 0.0
    velocity: float = 0.0

    @property
    def acts(self) -> bool:
        """True if it makes any force."""
        linear = self.stiffness != 0.0 or self.damping != 0.0
        return linear or self.stops is not None or self.friction is not None


@dataclass(frozen=True)
class Window:
    """A joint with a window closes as soon as its point on both bodies is nearer than ``gap`` [m],
    and the relative speed there is below ``speed`` [m/s]. Slides that the joint leaves free do not
    count."""

    gap: float = inf
    speed: float = inf


@dataclass(frozen=True)
class Ratchet:
    """The motion of ``body`` along the axis of the joint, or about it if it ``turns``, never goes
    back; all other motions stay free. With a ``pitch`` [m or rad] it may go back to the last of
    teeth with this distance, which begin where the ratchet becomes active."""

    turns: bool = False
    pitch: float = 0.0


@dataclass(frozen=True)
class Joint:
    """A joint of ``body`` to another body or, without ``to``, to the earth.

    ``point`` (3,) and the axes are in the frame of ``body``, with both bodies at their places at
    rest, where all motions of the joint are zero. ``axis`` is that of the hinge, slider, cylinder
    or guide, the normal of the plane, the first axis of the universal joint (it moves with ``to``).
    ``second`` is the second axis of the universal joint (it moves with ``body``), or the first one
    in the plane; any right angle to ``axis`` without it. ``resistances`` has one entry for each of
    the `MOTIONS`, or none.

    A joint without ``active`` lasts for the whole run; if it does not close a loop, its motions are
    coordinates. One with ``active`` locks what it does not leave free while it is active, at the
    relative place of the bodies when it closes. With a ``window`` it closes only there. It opens
    for good when its force exceeds ``breaks_at`` [N].

    A rod keeps the distance of ``point`` from ``to_point``, which is in the frame of the other body
    or of the earth. The distance is ``length`` [m] or, without it, that of the places at rest.
    """

    type: JointType
    body: str
    to: str | None = None
    point: tuple[float, ...] = (0.0, 0.0, 0.0)
    axis: tuple[float, ...] = (0.0, 0.0, 1.0)
    second: tuple[float, ...] | None = None
    resistances: tuple[Resistance, ...] = ()
    active: Active | None = None
    window: Window | None = None
    ratchet: Ratchet | None = None
    breaks_at: float | None = None
    to_point: tuple[float, ...] | None = None
    length: float | None = None

    @property
    def lasts(self) -> bool:
        """True if it holds for the whole run."""
        limits = (self.active, self.window, self.ratchet, self.breaks_at)
        return all(limit is None for limit in limits)

    @property
    def motions(self) -> tuple[JointMotion, ...]:
        """Its free motions."""
        return MOTIONS[self.type]

    def axes(self) -> np.ndarray:
        """Three unit vectors by rows (3, 3), at right angles, right-handed, in the frame of
        ``body`` at rest. Of a ball they are those of that frame."""
        if self.type == JointType.BALL:
            return np.eye(3)
        first = np.array(self.axis) / np.linalg.norm(self.axis)
        given = self.second
        if given is None:  # the x axis, unless that is nearly the first
            given = (1.0, 0.0, 0.0) if abs(first[0]) < 0.9 else (0.0, 1.0, 0.0)
        second = np.array(given) - first * (first @ np.array(given))
        second /= np.linalg.norm(second)
        return np.array([first, second, np.cross(first, second)])


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
    carrying = {name: j for name, j in lasting.items() if j.type != JointType.ROD}
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
