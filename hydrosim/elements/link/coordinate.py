"""The coordinate of a link: the distance of two points, a twist about an axis, a motion of a joint.

A link has a load T against the growth of its coordinate. x is the coordinate less its neutral value
L0, which may be a signal over time for a distance.

Distance of a point p of the body from an anchor a, on the earth or on another body:

    x = |a - p| - L0,   e = (a - p) / |a - p|,   x' = e (a' - p') - L0'

The body receives T e at p, and the other side -T e at a.

Twist of the body relative to the other side: the twist of the swing-twist decomposition of the
relative rotation (swing after twist; Dobrowolski 2015, arXiv:1506.05481). Let u, v, w be an
orthonormal triad on the other side, and U, V, W that of the body, equal at rest, with the axis u.
Then

    tan(x + L0) = (w V - v W) / (v V + w W),   g = (u + U) / (1 + u U),   x' = g (omega - omega')

with the angular velocities omega of the body and omega' of the other side.

The body receives the moment -T g, the other side T g. As g is the gradient of x at any rotation, a
load that depends on x alone has a potential. Its moment has components across the axis while the
body swings. The twist is counted beyond half a turn: its half turns are in the modes.

Motion of a joint: x = q - L0. The load is -T along it, on the joint's body and the one it moves on.

Limits: no mass. A distance has no direction where its ends meet, and a twist none where the axes
are opposite (a swing of 180 deg): a run ends there. With small angles lever arms stay as at rest
while e follows the points: power is then exact, and moments of the two ends are opposite to the
first order of the displacement. A twist is then the difference of the angles about the axis.
"""

from __future__ import annotations

from math import atan2, pi, sqrt
from typing import Any, NamedTuple

import numpy as np

from hydrosim.elements import pair, signal
from hydrosim.elements.contact.geometry import EARTH
from hydrosim.elements.kind import Layout
from hydrosim.errors import InputError
from hydrosim.jit.kernels import kernel
from hydrosim.modes import RISING
from hydrosim.multibody.kinematics import add_wrench
from hydrosim.multibody.tree import SLIDE, push_joint
from hydrosim.multibody.vectors import add, dot, matvec, scale, vector
from hydrosim.scene.joint import Joint, MotionKind
from hydrosim.scene.links import CoordinateElement, Link, TorsionSpring, TwoPointElement

DISTANCE, TWIST, JOINT_MOTION = range(3)
HALF_TURNS = RISING  # column of modes
MIN_LENGTH_SHARE = 0.01  # of the length at rest: closer ends have no direction
MIN_SWING_COSINE = 1e-3  # least 1 + cosine of the swing of an axis: 177 deg
MAX_HALF_TURN = 0.75 * pi  # from the middle of its half turn: a twist then belongs to the next one
ZERO = (0.0, 0.0, 0.0)


class LinkKinematics(NamedTuple):
    """State of the coordinate of a link: its offset ``x`` and the ``rate`` of that; the ``speed``
    L0'; its ``place`` x + L0; the lever arms and the ``direction`` e, or the gradient g. ``room``
    is positive while it has a direction, and in its half turn, from whose middle it has
    ``turned``."""

    x: float
    rate: float
    speed: float
    place: float
    arm: tuple[float, float, float]
    other_arm: tuple[float, float, float]
    direction: tuple[float, float, float]
    room: float
    turned: float


def coordinate_fields(element: Link, layout: Layout) -> dict[str, Any]:
    """Fields of `COORDINATE` of a link. Raises InputError for a joint that has no such motion, and
    for values in units of another kind of coordinate."""
    neutral = getattr(element, "neutral", 0.0)
    if isinstance(element, TwoPointElement):
        return _distance_fields(element, element.length, layout)  # type: ignore[attr-defined]
    if isinstance(element, TorsionSpring):
        return _twist_fields(element, neutral, layout)
    assert isinstance(element, CoordinateElement)
    if element.joint is not None:
        return _motion_fields(element, element.joint, neutral or 0.0, layout)
    element.check_units(turns=element.axis is not None)
    if element.axis is not None:
        return _twist_fields(element, neutral or 0.0, layout)
    return _distance_fields(element, neutral, layout)


def _distance_fields(element: Any, length: Any, layout: Layout) -> dict[str, Any]:
    """Fields of the distance of two points with a neutral ``length``: a number, a signal, or None
    for the length at rest."""
    other = EARTH if element.anchor_body is None else layout.body[element.anchor_body]
    anchor = layout.place_at_rest(element.anchor_body, element.anchor)
    d = (anchor - layout.place_at_rest(element.body, element.point)).tolist()
    at_rest = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])  # to the bit as in `_distance`
    varies = isinstance(length, signal.Signal)
    neutral = signal.value_at(length) if varies else at_rest if length is None else length
    return {
        "coordinate": DISTANCE,
        "body": layout.body[element.body],
        "other": other,
        "ends": np.array([*element.point, *element.anchor]),
        "closest": MIN_LENGTH_SHARE * max(at_rest, neutral),
        "neutral": neutral,
        "varies": varies,
    }


def _twist_fields(element: Any, neutral: float, layout: Layout) -> dict[str, Any]:
    """Fields of a twist about the axis of an ``element``."""
    first = np.array(element.axis) / np.linalg.norm(element.axis)
    second = np.cross(first, np.eye(3)[np.abs(first).argmin()])
    second /= np.linalg.norm(second)
    axes = np.array([first, second, np.cross(first, second)])
    there = axes @ layout.axes_from(element.body, element.to).T
    return {
        "coordinate": TWIST,
        "body": layout.body[element.body],
        "other": EARTH if element.to is None else layout.body[element.to],
        "axes": np.array([axes, there]).ravel(),
        "neutral": neutral,
    }


def _motion_fields(
    element: CoordinateElement, joint: str, neutral: float, layout: Layout
) -> dict[str, Any]:
    """Fields of a motion of a ``joint``. Raises InputError for a joint that is not there, that
    closes a loop, that has another body, or whose motion is no angle and no distance."""
    trees = {name: j for name, j in layout.joints.items() if name not in layout.constraints}
    if joint not in trees:
        kind = "a joint that closes a loop, comes and goes or breaks"
        found_text = f"{joint}, {kind if joint in layout.joints else 'no joint of the scene'}"
        expected = ", ".join(name for name in trees if _usable_motions(trees[name]))
        raise InputError(f"joint: found {found_text}; expected one of: {expected or 'none'}.")
    if element.body != trees[joint].body:
        expected = f"{trees[joint].body}, which is the body of {joint}"
        raise InputError(f"body: found {element.body}; expected {expected}, or none.")
    names = _usable_motions(trees[joint])
    if not names:
        found_text = f"{joint}, a {trees[joint].type} joint"
        raise InputError(f"joint: found {found_text}; expected one with a turn or a slide.")
    motion = element.motion or (names[0] if len(names) == 1 else None)
    if motion not in names:
        found_text = element.motion or "none"
        raise InputError(f"motion: found {found_text}; expected one of: {', '.join(names)}.")
    coordinate, move, joint_axis = layout.coordinate_of_motion(joint, motion)
    element.check_units(turns=layout.tree.moves[move]["kind"] != SLIDE)
    return {
        "coordinate": JOINT_MOTION,
        "body": EARTH,
        "other": EARTH,
        "motion": coordinate,
        "move": move,
        "joint_axis": joint_axis,
        "neutral": neutral,
    }


def _usable_motions(joint: Joint) -> list[str]:
    """Names of the motions of a ``joint`` that are a slide or a turn about one axis."""
    return [m.name for m in joint.motions if m.kind != MotionKind.SWIVEL]


@kernel
def find_kinematics(link, mode, t, y, motion, bodies, p):
    """State of the coordinate of a link, as a `LinkKinematics`."""
    if link.coordinate == DISTANCE:
        return _distance(link, t, motion, bodies, p)
    if link.coordinate == JOINT_MOTION:
        q = y[link.motion]
        u = y[bodies.active.size + link.motion]
        return LinkKinematics(q - link.neutral, u, 0.0, q, ZERO, ZERO, ZERO, 1.0, 0.0)
    if bodies.exact:
        return _twist(link, mode, motion)
    return _small_twist(link, mode, motion)


@kernel
def _distance(link, t, motion, bodies, p):
    point = vector(link.ends, 0)
    place = vector(link.ends, 3)
    s = pair.line_between(link.body, point, link.other, place, bodies, motion)
    neutral = link.neutral
    speed = 0.0
    if link.varies:
        neutral = signal.value(t, link.signal, p.pieces)
        speed = signal.rate(t, link.signal, p.pieces)
    x = s.length - neutral
    room = s.length - link.closest
    return LinkKinematics(
        x, s.rate - speed, speed, s.length, s.arm, s.other_arm, s.direction, room, 0.0
    )


@kernel
def _axis_vector(link, side, k, motion):
    """Vector ``k`` of the triad of the body (``side`` 0) or of the other side, in the earth
    frame."""
    axis = vector(link.axes, 9 * side + 3 * k)
    b = link.body if side == 0 else link.other
    return axis if b == EARTH else matvec(motion.rotation[b], axis)


@kernel
def _twist(link, mode, motion):
    U = _axis_vector(link, 0, 0, motion)
    V = _axis_vector(link, 0, 1, motion)
    W = _axis_vector(link, 0, 2, motion)
    u = _axis_vector(link, 1, 0, motion)
    v = _axis_vector(link, 1, 1, motion)
    w = _axis_vector(link, 1, 2, motion)
    half_turns = mode[HALF_TURNS]
    sign = 1.0 if half_turns % 2 == 0 else -1.0
    turned = atan2(sign * (dot(w, V) - dot(v, W)), sign * (dot(v, V) + dot(w, W)))
    swing = 1.0 + dot(u, U)
    g = scale(1.0 / swing if swing > 0.0 else 0.0, add(u, U))
    return _twist_kinematics(
        link, pi * half_turns + turned, g, swing - MIN_SWING_COSINE, turned, motion
    )


@kernel
def _small_twist(link, mode, motion):
    """The same with small angles."""
    axis = vector(link.axes, 0)
    angle = dot(axis, pair.relative_small_turn(link.body, link.other, motion))
    turned = angle - pi * mode[HALF_TURNS]
    return _twist_kinematics(link, angle, axis, 1.0, turned, motion)


@kernel
def _twist_kinematics(link, place, g, swing_room, turned, motion):
    """The `LinkKinematics` of a twist with the gradient ``g``."""
    rate = dot(g, pair.relative_turn_rate(link.body, link.other, motion))
    room = min(swing_room, MAX_HALF_TURN - abs(turned))
    return LinkKinematics(place - link.neutral, rate, 0.0, place, ZERO, ZERO, g, room, turned)


@kernel
def leaves_half_turn(link, s):
    """True if a twist whose ``room`` is used up enters the next half turn, and keeps its
    direction."""
    return link.coordinate == TWIST and MAX_HALF_TURN - abs(s.turned) <= s.room


@kernel
def add_load(link, T, s, motion, bodies, wrench):
    """Add the load T of a link to its row of ``wrench``: on its body, and the opposite on the other
    side."""
    if link.coordinate == JOINT_MOTION:
        push_joint(link.move, link.joint_axis, -T, bodies, motion, wrench)
        return
    if link.coordinate == DISTANCE:
        force = scale(T, s.direction)
        pair.apply_tension(link.body, link.other, s.arm, s.other_arm, force, wrench)
        return
    add_wrench(link.body, ZERO, scale(-T, s.direction), wrench)
    if link.other != EARTH:
        add_wrench(link.other, ZERO, scale(T, s.direction), wrench)
