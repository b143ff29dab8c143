"""Questions about where lines, joints and named points are on their bodies.

The reach of a body bounds the distance of its points from its centre of gravity. A hull with a
database has the half diagonal of its water plane; cranes and booms reach over it. Another body has
its largest radius of gyration, which bodies on long light arms exceed most.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hydrosim.compiling.questions.extents import ELLIPSE_OVER_RECTANGLE, Extents, extents
from hydrosim.compiling.questions.query import Query, SceneContext, text_beyond
from hydrosim.forces.line.catenary import Catenary
from hydrosim.forces.link import TorsionSpring
from hydrosim.forces.pair import TwoPointElement
from hydrosim.scene import Body, JointType
from hydrosim.scene.joint import MotionKind
from hydrosim.scene.trees import arrangement

HULL_REACH = 3.0  # of the half diagonal of the water plane
DRY_REACH = 20.0  # of the largest radius of gyration
# m
MIN_HULL_REACH = 20.0
MIN_DRY_REACH = 100.0
MIN_UNDER_KEEL = 2.0
MIN_OUTRIGGER = 5.0
MIN_FREEBOARD = 10.0
UNDER_KEEL = 0.3  # of the draught
FREE_AXIS_COSINE = (
    0.1  # cosine of the smallest angle between an axis and the axes that a joint leaves free
)
FRAME = "Points are in the body frame, from the centre of gravity."


def attachments(about: SceneContext) -> Iterator[Query]:
    """Ask about points far off their bodies, and fairleads far under a keel."""
    sizes = {body.name: extents(body, db) for _, body, db in about.floating_bodies()}
    bodies = {body.name: body for body in about.scene.bodies}
    for key, name, point in _points(about):
        body = bodies[name]
        limit = _reach(body, sizes.get(name))
        away = float(np.linalg.norm(point))
        if away > limit:
            found_text = (
                f"a point {text_beyond(away, limit)} m from the centre of gravity of {name}"
            )
            yield Query(key, found_text, f"usual for its size is up to {limit:.3g} m", FRAME)
    for name, line in about.scene.forces.items():
        size = sizes.get(line.body)
        if isinstance(line, Catenary) and size is not None:
            yield from _under_keel(name, line, size)
            yield from _off_hull(name, line, size)


def _points(about: SceneContext) -> Iterator[tuple[str, str, np.ndarray]]:
    """Keys, bodies and points (3,) of lines, joints and named points, in the frame of the body."""
    centre = {body.name: about.centre(b) for b, body in enumerate(about.scene.bodies)}
    turn = {body.name: about.motion.rotation[b] for b, body in enumerate(about.scene.bodies)}
    for name, element in about.scene.forces.items():
        if isinstance(element, TwoPointElement):
            yield f"forces.{name}.point", element.body, np.array(element.point, float)
            if element.anchor_body is not None:
                yield f"forces.{name}.anchor", element.anchor_body, np.array(element.anchor, float)
    for name, joint in about.scene.joints.items():
        point = np.array(joint.point, float)
        yield f"joints.{name}.point", joint.body, point
        if joint.to is not None and all(m.kind != MotionKind.SLIDE for m in joint.motions):
            place = centre[joint.body] + turn[joint.body] @ point
            yield f"joints.{name}.point", joint.to, turn[joint.to].T @ (place - centre[joint.to])
    for body in about.scene.bodies:
        for name, own in body.points.items():
            yield f"bodies.{body.name}.points.{name}", body.name, np.array(own, float)


def _reach(body: Body, size: Extents | None) -> float:
    """Largest usual distance of a point of a body from its centre of gravity [m]."""
    radius = float(np.sqrt(np.diag(body.inertia).max() / body.mass))
    dry = max(DRY_REACH * radius, MIN_DRY_REACH)
    if size is None:
        return dry
    return max(HULL_REACH * float(np.linalg.norm(size.half)), MIN_HULL_REACH)


def _under_keel(name: str, line: Catenary, size: Extents) -> Iterator[Query]:
    """Ask about a fairlead metres under the keel."""
    under = size.centre[2] - ELLIPSE_OVER_RECTANGLE * size.draught - line.point[2]
    limit = max(UNDER_KEEL * size.draught, MIN_UNDER_KEEL)
    if under > limit:
        found_text = (
            f"a fairlead about {text_beyond(under, limit, '.2g')} m under the keel of {line.body}"
        )
        yield Query(f"forces.{name}.point", found_text, f"usual is up to {limit:.2g} m", FRAME)


def _off_hull(name: str, line: Catenary, size: Extents) -> Iterator[Query]:
    """Ask about a fairlead of a mooring line far beside a hull, or far above the water."""
    if line.anchor_body is not None or line.anchor[2] >= 0.0:
        return
    off = np.array(line.point, float) - size.centre
    aside = float(
        np.linalg.norm(np.maximum(np.abs(off[:2]) - ELLIPSE_OVER_RECTANGLE * size.half, 0.0))
    )
    limit = max(MIN_OUTRIGGER, float(size.half.min()))
    if aside > limit:
        found_text = f"a fairlead about {text_beyond(aside, limit, '.2g')} m outside of {line.body}"
        yield Query(f"forces.{name}.point", found_text, f"usual is up to {limit:.2g} m", FRAME)
    limit = max(MIN_FREEBOARD, 2.0 * size.draught)
    if off[2] > limit:
        found_text = f"a fairlead {text_beyond(float(off[2]), limit)} m above the water"
        yield Query(f"forces.{name}.point", found_text, f"usual is up to {limit:.3g} m", FRAME)


def axes(about: SceneContext) -> Iterator[Query]:
    """Ask about torsion springs and power take-offs about an axis that a joint holds."""
    branches = {
        frozenset((branch.child, branch.parent)): branch
        for branch in arrangement(about.scene).branches
        if branch.joint.type in (JointType.HINGE, JointType.CYLINDRICAL)
    }
    for name, spring in about.scene.forces.items():
        branch = None
        if isinstance(spring, TorsionSpring):
            branch = branches.get(frozenset((spring.body, spring.to)))
        if branch is None or not isinstance(spring, TorsionSpring):
            continue
        axis = np.array(spring.axis, float)
        cosine = abs(branch.joint.axes()[0] @ axis) / np.linalg.norm(axis)
        if cosine < FREE_AXIS_COSINE:
            angle = np.degrees(np.arccos(min(cosine, 1.0)))
            found_text = (
                f"an axis at {angle:.3g} deg to that of {branch.name}, which holds this rotation"
            )
            usual = "usual is the axis of the joint"
            yield Query(f"forces.{name}.axis", found_text, usual, "It hardly acts.")
