"""Questions about where lines, joints and named points are on bodies, and where catenaries run.

The reach of a body bounds the distance of its points from its centre of gravity. A hull with a
database has the half diagonal of its water plane; cranes and booms reach over it. Another body has
its largest radius of gyration, which bodies on long light arms exceed most.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hydrosim.compile.questions import query
from hydrosim.elements.line.points import LineShape, line_shapes
from hydrosim.scene import Body, Cylindrical, Hinge
from hydrosim.scene.catenary import Catenary
from hydrosim.scene.joint import MotionKind
from hydrosim.scene.links import CoordinateElement, TorsionSpring, TwoPointElement
from hydrosim.scene.scene import arrangement

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


def ask_about_attachments(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about points far off their bodies, and fairleads far under a keel."""
    sizes = {body.name: query.extents(body, db) for _, body, db in about.floating_bodies()}
    bodies = {body.name: body for body in about.scene.bodies}
    for key, name, point in _attachment_points(about):
        body = bodies[name]
        limit = _reach_of_body(body, sizes.get(name))
        away = float(np.linalg.norm(point))
        if away > limit:
            found_text = (
                f"a point {query.text_beyond(away, limit)} m from the centre of gravity of {name}"
            )
            yield query.Query(key, found_text, f"usual for its size is up to {limit:.3g} m", FRAME)
    for name, line in about.scene.forces.items():
        size = sizes.get(line.body)
        if isinstance(line, Catenary) and size is not None:
            yield from _ask_about_depth_under_keel(name, line, size)
            yield from _ask_about_place_off_hull(name, line, size)


def _attachment_points(about: query.SceneContext) -> Iterator[tuple[str, str, np.ndarray]]:
    """Keys, bodies and points (3,) of lines, joints and named points, in the frame of the body."""
    centre = {body.name: about.centre(b) for b, body in enumerate(about.scene.bodies)}
    turn = {body.name: about.motion.rotation[b] for b, body in enumerate(about.scene.bodies)}
    for name, element in about.scene.forces.items():
        if isinstance(element, TwoPointElement | CoordinateElement) and element.point is not None:
            yield f"forces.{name}.point", str(element.body), np.array(element.point, float)
            if element.anchor_body is not None:
                yield f"forces.{name}.anchor", element.anchor_body, np.array(element.anchor, float)
    for name, joint in about.scene.joints.items():
        point = np.array(joint.point, float)
        yield f"joints.{name}.point", joint.body, point
        if joint.to is not None and all(m.kind != MotionKind.SLIDE for m in joint.motions):
            place = centre[joint.body] + turn[joint.body] @ point
            yield f"joints.{name}.point", joint.to, turn[joint.to].T @ (place - centre[joint.to])
    for body in about.scene.bodies:
        for name, named_point in body.points.items():
            yield f"bodies.{body.name}.points.{name}", body.name, np.array(named_point, float)


def _reach_of_body(body: Body, size: query.Extents | None) -> float:
    """Largest usual distance of a point of a body from its centre of gravity [m]."""
    radius = float(np.sqrt(np.diag(body.inertia).max() / body.mass))
    dry = max(DRY_REACH * radius, MIN_DRY_REACH)
    if size is None:
        return dry
    return max(HULL_REACH * float(np.linalg.norm(size.half)), MIN_HULL_REACH)


def _ask_about_depth_under_keel(
    name: str, line: Catenary, size: query.Extents
) -> Iterator[query.Query]:
    """Ask about a fairlead metres under the keel."""
    under = size.centre[2] - query.ELLIPSE_OVER_RECTANGLE * size.draught - line.point[2]
    limit = max(UNDER_KEEL * size.draught, MIN_UNDER_KEEL)
    if under > limit:
        depth_text = query.text_beyond(under, limit, ".2g")
        found_text = f"a fairlead about {depth_text} m under the keel of {line.body}"
        yield query.Query(
            f"forces.{name}.point", found_text, f"usual is up to {limit:.2g} m", FRAME
        )


def _ask_about_place_off_hull(
    name: str, line: Catenary, size: query.Extents
) -> Iterator[query.Query]:
    """Ask about a fairlead of a mooring line far beside a hull, or far above the water."""
    if line.anchor_body is not None or line.anchor[2] >= 0.0:
        return
    off = np.array(line.point, float) - size.centre
    aside = float(
        np.linalg.norm(np.maximum(np.abs(off[:2]) - query.ELLIPSE_OVER_RECTANGLE * size.half, 0.0))
    )
    limit = max(MIN_OUTRIGGER, float(size.half.min()))
    if aside > limit:
        found_text = (
            f"a fairlead about {query.text_beyond(aside, limit, '.2g')} m outside of {line.body}"
        )
        yield query.Query(
            f"forces.{name}.point", found_text, f"usual is up to {limit:.2g} m", FRAME
        )
    limit = max(MIN_FREEBOARD, 2.0 * size.draught)
    if off[2] > limit:
        found_text = f"a fairlead {query.text_beyond(float(off[2]), limit)} m above the water"
        yield query.Query(
            f"forces.{name}.point", found_text, f"usual is up to {limit:.3g} m", FRAME
        )


def ask_about_axes(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about links about an axis that a joint holds."""
    branches = {
        frozenset((branch.child, branch.parent)): branch
        for branch in arrangement(about.scene).branches
        if isinstance(branch.joint, Hinge | Cylindrical)
    }
    for name, spring in about.scene.forces.items():
        branch = None
        if isinstance(spring, TorsionSpring | CoordinateElement) and spring.axis is not None:
            branch = branches.get(frozenset((spring.body, spring.to)))
        if branch is None or not isinstance(spring, TorsionSpring | CoordinateElement):
            continue
        axis = np.array(spring.axis, float)
        cosine = abs(branch.joint.axes()[0] @ axis) / np.linalg.norm(axis)
        if cosine < FREE_AXIS_COSINE:
            angle = np.degrees(np.arccos(min(cosine, 1.0)))
            found_text = (
                f"an axis at {angle:.3g} deg to that of {branch.name}, which holds this rotation"
            )
            usual = "usual is the axis of the joint"
            yield query.Query(f"forces.{name}.axis", found_text, usual, "It hardly acts.")


# Catenaries through the seabed, under a hull, or too soft; lengths in m.

BURIED = 1.0
HOVERING = 0.25  # of the water depth, for lines that know no seabed
ABOVE_BED = 0.03  # of the water depth, for lines that do
MIN_HEIGHT_ABOVE_BED_M = 2.0
# EA over the weight of the lightest body; a nylon hawser of a large tanker has 1.5e-3
MIN_STIFFNESS_OVER_WEIGHT = 1e-3
SIDE_FRACTION = 0.7  # of half of the breadth or length: fairleads further out are at a side
WIDE_CHAIN = 20.0  # bar diameters: coefficient times diameter, 2.4 of studless chain
WIDEST = 10.0  # m, of other lines
CROSSING = 0.5  # of the breadth of a hull
KEEL = 0.8  # of the draught: fairleads deeper are at the keel


def ask_about_line_routes(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about lines that run through the seabed or a hull, hang above it, or are too soft."""
    state = about.state
    depth = about.scene.environment.water_depth
    sizes = {body.name: query.extents(body, db) for _, body, db in about.floating_bodies()}
    bodies = about.model.bodies
    begin = about.end - about.scene.duration
    every = line_shapes(about.model, about.scene, begin, state.y, state.modes, bodies, about.motion)
    for line in every:
        of = about.scene.forces[line.name]
        assert isinstance(of, Catenary)
        yield from _ask_about_seabed(line, of, depth)
        yield from _ask_about_softness(about, line, of)
        yield from _ask_about_drag(about, line, of)
        size = sizes.get(of.body)
        if size is not None and of.anchor_body is None and of.anchor[2] < 0.0:
            yield from _ask_about_crossing_under_hull(about, line, of, size)


def _ask_about_seabed(line: LineShape, of: Catenary, depth: float) -> Iterator[query.Query]:
    """Ask about a line that runs below the seabed, and about an anchor high above it."""
    key = f"forces.{line.name}"
    lowest = -float(line.places()[0][:, 2].min())
    if of.friction is None and lowest > depth + BURIED:
        found_text = f"a line down to {query.text_beyond(lowest, depth)} m in water of {depth:g} m"
        usual = "usual is a line above the seabed"
        yield query.Query(key, found_text, usual, "With the key seabed, it rests on the seabed.")
    moored = of.anchor_body is None and of.anchor[2] < 0.0
    above = depth + of.anchor[2]
    limit = max(HOVERING * depth, BURIED)
    if of.friction is not None:
        limit = max(ABOVE_BED * depth, MIN_HEIGHT_ABOVE_BED_M)
    if moored and np.isfinite(depth) and above > limit:
        found_text = f"an anchor {above:.3g} m above the seabed, in water of {depth:g} m"
        yield query.Query(f"{key}.anchor", found_text, "usual is an anchor on the seabed")


def _ask_about_softness(
    about: query.SceneContext, line: LineShape, of: Catenary
) -> Iterator[query.Query]:
    """Ask about mooring lines whose EA is hardly a thousandth of the weight that they hold."""
    if of.anchor_body is not None or of.body not in about.derived.databases:
        return
    weight = about.scene.environment.gravity * about.scene.bodies[about.body_numbers[of.body]].mass
    if line.stiffness < MIN_STIFFNESS_OVER_WEIGHT * weight:
        found_text = f"an EA of {line.stiffness:.3g} N, for a body whose weight is {weight:.3g} N"
        usual = f"usual is above {MIN_STIFFNESS_OVER_WEIGHT:g} of the weight"
        advice = "Check the diameter and its unit."
        yield query.Query(f"forces.{line.name}.segments", found_text, usual, advice)


def _ask_about_drag(
    about: query.SceneContext, line: LineShape, of: Catenary
) -> Iterator[query.Query]:
    """Ask about drag of a line that is far wider than its chain, or wider than any line."""
    widest = float(of.drag_width.max())
    bars = list(query.bar_diameters(of, about.scene.environment))
    limit = WIDE_CHAIN * max(bars) if bars else WIDEST
    if widest > limit:
        found_text = f"a drag coefficient times diameter of {query.text_beyond(widest, limit)} m"
        usual = f"usual is up to {limit:.3g} m"
        yield query.Query(
            f"forces.{line.name}.segments", found_text, usual, "Is the diameter in mm?"
        )


def _ask_about_crossing_under_hull(
    about: query.SceneContext, line: LineShape, of: Catenary, size: query.Extents
) -> Iterator[query.Query]:
    """Ask about a line from a side of a compact hull that crosses under it to the other side."""
    aside = (np.array(of.point[:2]) - size.centre[:2]) / size.half
    at_keel = of.point[2] < size.centre[2] - KEEL * size.draught
    if size.filled < query.COMPACT or at_keel or np.abs(aside).max() < SIDE_FRACTION:
        return
    turn = about.motion.rotation[about.body_numbers[of.body]]
    away = turn.T @ np.array([*line.ends.e, 0.0])
    inside = _length_inside(aside, away[:2] / size.half)
    limit = CROSSING * 2.0 * float(size.half.min())
    if inside > limit:
        found_text = (
            f"a line that runs {query.text_beyond(inside, limit)} m under the hull of {of.body}"
        )
        usual = "usual is a fairlead on the side of its anchor"
        advice = "Has point the sign of the other side?"
        yield query.Query(f"forces.{line.name}.point", found_text, usual, advice)


def _length_inside(start: np.ndarray, direction: np.ndarray) -> float:
    """Length [m] inside the square |x|, |y| < 1 of the ray from ``start`` (2,) along ``direction``
    (2,), per metre."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.sort([(-1.0 - start) / direction, (1.0 - start) / direction], axis=0)
    enters = float(np.nanmax([0.0, *ends[0]]))
    leaves = float(np.nanmin(ends[1]))
    return max(leaves - enters, 0.0)
