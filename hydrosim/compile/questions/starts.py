"""Questions about the start: angles, speeds, overlaps, bodies on the wrong side."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import inf

import numpy as np

from hydrosim.compile.questions.query import Query, SceneContext, extents, text_beyond
from hydrosim.elements.kind import elements_of
from hydrosim.elements.line.points import largest_tension, line_shapes
from hydrosim.elements.line.winch import WINCH_KIND
from hydrosim.elements.link.kind import LINK_KIND, SPRING_KIND, link_kinematics
from hydrosim.scene import ForceElement, GivenComponents, Weight
from hydrosim.scene.contacts import Contact, NormalCurve, PrescribedNormal
from hydrosim.scene.joint import MotionKind
from hydrosim.scene.links import Spring, Stop, Strut
from hydrosim.scene.plane import Plane
from hydrosim.scene.scene import arrangement, joined_with, tree_joints
from hydrosim.scene.winch import Winch

FULL_TURN_RAD = 2.0 * np.pi * (1.0 + 1e-9)
ROUND_DEG = (5.0, 10.0, 20.0, *range(15, 361, 15))
ROUND_RTOL = 6e-4  # between an angle of few digits in rad and a round one in degrees
TILT = np.radians(30.0)  # limit for a body afloat with linear hydrostatics
FASTEST = 15.0  # m/s
MAX_START_COMPRESSION_M = 1.0  # m of compression at the start
DROP = 3.0  # m above all contacts that carry a body
BENT = np.radians(5.0)  # beyond a stop at the start
MAX_STOP_OVERRUN_FRACTION = 0.1  # of the range between two stops, beyond one of them at the start
STRETCHED = 0.2  # of a line's length
MAX_SLACK_RATIO = 5.0  # times the distance of its ends
MAX_START_STRAIN = 0.05  # strain of a catenary


def ask_about_angles(about: SceneContext) -> Iterator[Query]:
    """Ask about angles of more than a turn, degrees that were read as radians, and about angles in
    degrees that are round ones in radians."""
    for key, angle in _start_angles(about):
        round_deg = _round_angle_if_radians(float(np.degrees(angle)))
        if round_deg is not None:
            found_text = f"{np.degrees(angle):.6g} deg"
            usual = f"{np.degrees(angle):.6g} rad are {round_deg:g} deg"
            yield Query(key, found_text, usual, "Is it in radians? Then give it without a unit.")
        if abs(angle) > FULL_TURN_RAD:
            found_text = f"{angle:g} rad, which is {np.degrees(angle):.5g} deg"
            advice = f'A number is in radians; degrees are "{angle:g} deg".'
            yield Query(key, found_text, "an angle is usually within one turn", advice)
    for _, body, _ in about.floating_bodies():
        for name, angle in zip(("roll", "pitch"), body.position[3:5], strict=True):
            if TILT < abs(angle) <= FULL_TURN_RAD:
                tilt = text_beyond(np.degrees(angle), np.copysign(np.degrees(TILT), angle))
                found_text = f"a {name} of {tilt} deg"
                usual = "usual is less than 30 deg, because hydrostatics are linear"
                yield Query(f"bodies.{body.name}.initial.position", found_text, usual)


def _round_angle_if_radians(angle: float) -> float | None:
    """Round angle [deg] that a number of degrees would be as radians; None if there is none, or if
    the number is round itself."""
    size = abs(angle)
    if size > FULL_TURN_RAD or abs(float(f"{size:.2g}") - size) <= 1e-9 * size:
        return None
    errors = np.abs(np.degrees(size) / np.array(ROUND_DEG) - 1.0)
    nearest = int(errors.argmin())
    return float(np.copysign(ROUND_DEG[nearest], angle)) if errors[nearest] < ROUND_RTOL else None


def _start_angles(about: SceneContext) -> Iterator[tuple[str, float]]:
    """All angles of a scene with their keys."""
    environment = about.scene.environment
    for body in about.scene.bodies:
        yield f"bodies.{body.name}.heading", body.heading
        for angle in body.position[3:]:
            yield f"bodies.{body.name}.initial.position", angle
    for train in environment.waves:
        given = train.spectrum.heading if isinstance(train.spectrum, GivenComponents) else ()
        for angle in (train.heading, *given):
            yield "environment.waves.heading", angle
    yield "environment.current.heading", environment.current.direction
    yield "environment.wind.heading", environment.wind.heading
    for name, joint in about.scene.joints.items():
        for motion, acting in zip(joint.motions, joint.resistances, strict=False):
            if motion.kind != MotionKind.SLIDE:
                yield f"joints.{name}", acting.position
                yield f"joints.{name}", acting.neutral


def ask_about_speed(about: SceneContext) -> Iterator[Query]:
    """Ask about speeds that no body has."""
    for body in about.scene.bodies:
        fastest = max(map(abs, body.velocity[:3]))
        if fastest > FASTEST:
            key, usual = f"bodies.{body.name}.initial.velocity", f"usual is up to {FASTEST:g} m/s"
            yield Query(key, f"{fastest:g} m/s", usual)
    for branch in arrangement(about.scene).branches:
        b = about.body_numbers[branch.child]
        fastest = float(np.linalg.norm(about.motion.velocity[6 * b : 6 * b + 3]))
        if fastest > FASTEST and any(
            resistance.velocity for resistance in branch.joint.resistances
        ):
            found_text = f"a rate that moves {branch.child} at {text_beyond(fastest, FASTEST)} m/s"
            yield Query(f"joints.{branch.name}", found_text, f"usual is up to {FASTEST:g} m/s")


def ask_about_overlap(about: SceneContext) -> Iterator[Query]:
    """Ask about fender points deep behind their planes, and joints and elements far beyond their
    stops, at the start."""
    yield from _ask_about_pressed_stops(about)
    yield from _ask_about_stop_elements(about)
    for name, fender, deep in _fender_starts(about):
        worst = int(np.argmax(deep))
        if isinstance(fender.normal, NormalCurve) and deep[worst] > MAX_START_COMPRESSION_M:
            found_text = (
                f"that point {worst + 1} is {_metres_text(deep[worst])} behind its"
                " plane at the start"
            )
            usual = f"usual is a gap, or a compression of up to {MAX_START_COMPRESSION_M:g} m"
            advice = "Check points (body frame, from the centre of gravity) and plane.point."
            yield Query(f"forces.{name}", found_text, usual, advice)


def _ask_about_stop_elements(about: SceneContext) -> Iterator[Query]:
    p = LINK_KIND.constants_in(about.model)
    for i, (name, stop) in enumerate(elements_of(about.scene, LINK_KIND.classes)):
        if not isinstance(stop, Stop):
            continue
        place = link_kinematics(p, i, about.state.y, about.motion, about.model.bodies).place
        beyond = max(stop.low - place, place - stop.high)
        limit = min(MAX_STOP_OVERRUN_FRACTION * (stop.high - stop.low), MAX_START_COMPRESSION_M)
        if beyond > limit:
            key, end = ("lowest", stop.low) if place < stop.low else ("highest", stop.high)
            unit = "rad" if stop.turns(about.scene.joints) else "m"
            yield Query(
                f"forces.{name}.{key}",
                f"{end:g} {unit}, while it is at {place:.4g} {unit} at the start and presses with"
                f" {stop.stiffness * beyond:.3g} N{' m' * (unit == 'rad')}",
                "a stop is usually free at the start",
                "Distances count from 0, where the ends meet; points of a body from its centre of"
                " gravity.",
            )


def _ask_about_pressed_stops(about: SceneContext) -> Iterator[Query]:
    bodies = about.model.bodies
    n = bodies.active.size
    places = iter(about.state.y[n - bodies.tree.coordinates : n])
    for name, joint in tree_joints(about.scene).items():
        here = [float(next(places)) for _ in joint.motions]
        for motion, acting, x in zip(joint.motions, joint.resistances, here, strict=False):
            stops = acting.stops
            limit = MAX_START_COMPRESSION_M if motion.kind == MotionKind.SLIDE else BENT
            lowest, highest = stops.range if stops else (-inf, inf)
            beyond = max(lowest - x, x - highest)
            if stops is None or (about.scene.at_rest and beyond <= limit):
                continue
            if beyond > min(limit, MAX_STOP_OVERRUN_FRACTION * (highest - lowest)):
                size = _size_text_of_kind(motion.kind)
                found_text = f"that {name} starts {size(beyond)} beyond a stop, at {size(x)}"
                yield Query(f"joints.{name}", found_text, "usual is a start between the stops")


def _size_text_of_kind(kind: MotionKind) -> Callable[[float], str]:
    """How to tell a motion of this kind."""
    return _metres_text if kind == MotionKind.SLIDE else _degrees_text


def _degrees_text(angle: float) -> str:
    return f"{np.degrees(angle):.3g} deg"


def ask_about_planes(about: SceneContext) -> Iterator[Query]:
    """Ask about planes with their body on the wrong side."""
    for name, fender, deep in _fender_starts(about):
        here = about.centre(about.body_numbers[fender.body])
        behind = _depth_inside_plane(about, fender.planes()[0], here)
        if behind > 0.0 and np.all(behind > deep) and np.any(deep != 0.0):
            found_text = (
                f"{fender.body}'s centre of gravity, which is {_metres_text(behind)}"
                " behind the plane"
            )
            usual = f"usual is a normal that points to the side of {fender.body}"
            advice = "Is plane.normal reversed? It points to the free side."
            yield Query(f"forces.{name}.plane", found_text, usual, advice)


def ask_about_fall(about: SceneContext) -> Iterator[Query]:
    """Ask about dry bodies that fall by metres before a contact carries them, and about hulls that
    start far above or below their draught."""
    yield from _ask_about_draught_at_start(about)
    acting = about.scene.forces.values()
    held = {
        element.body
        for element in acting
        if element.can_carry_weight() and not _can_carry_body(element)
    }
    carried = arrangement(about.scene).children
    deepest: dict[str, float] = {}
    for _, fender, deep in _fender_starts(about):
        most = max(float(deep.max()), deepest.get(fender.body, -np.inf))
        deepest[fender.body] = most
    for body in about.scene.bodies:
        jointed = len(joined_with(about.scene, body.name)) > 1 or body.name in carried
        falls = body.weight == Weight.CARRIED and "heave" in body.dofs and not jointed
        gap = -deepest.get(body.name, 0.0)
        if falls and body.name not in held | {*about.derived.databases} and gap > DROP:
            yield Query(
                f"bodies.{body.name}.initial.position",
                f"a gap of {_metres_text(gap)} between {body.name} and all contacts"
                " that can carry it",
                f"usual is up to {DROP:g} m",
                "It falls freely until it touches. Points are in the body frame, from the centre"
                " of gravity; planes in the earth frame.",
            )


def _ask_about_draught_at_start(about: SceneContext) -> Iterator[Query]:
    """Ask about hulls with linear hydrostatics that start out of the water, or as deep again."""
    for _, body, db in about.afloat():
        size = extents(body, db) if body.hydrostatics is None else None
        heave = abs(body.position[2])
        if size is not None and heave > size.draught and about.scene.initial is None:
            found_text = f"a heave of {text_beyond(heave, size.draught)} m at the start"
            usual = f"usual is less than the draught of about {size.draught:.3g} m"
            yield Query(f"bodies.{body.name}.initial.position", found_text, usual)


def _can_carry_body(element: ForceElement) -> bool:
    """Whether an element is a contact that can carry a body."""
    return isinstance(element, Contact) and not isinstance(element.normal, PrescribedNormal)


def ask_about_line_starts(about: SceneContext) -> Iterator[Query]:
    """Ask about lines that are far too short, winches whose drum ends before they pull, and struts
    of another length."""
    yield from _ask_about_springs(about)
    yield from _ask_about_drums(about)
    yield from _ask_about_catenaries(about)
    yield from _ask_about_struts(about)


def _ask_about_springs(about: SceneContext) -> Iterator[Query]:
    springs = {name: of for name, of in about.scene.forces.items() if isinstance(of, Spring)}
    p = SPRING_KIND.constants_in(about.model)
    for i, (name, line) in enumerate(springs.items()):
        s = link_kinematics(p, i, about.state.y, about.motion, about.model.bodies)
        longer = s.x
        length = s.place - s.x
        apart = length + longer
        if length > MAX_SLACK_RATIO * apart > 0.0 and line.tension[0] == 0.0:
            found_text = f"{length:g} m, while its ends are {apart:.3g} m apart at the start"
            yield Query(
                f"forces.{name}.length",
                found_text,
                f"usual is up to {MAX_SLACK_RATIO:g} times that",
            )
        if longer > max(STRETCHED * length, float(line.extension[-1])):
            found_text = (
                f"{length:g} m, while its ends are {longer:.3g} m further apart at the start"
            )
            yield Query(
                f"forces.{name}.length", found_text, f"usual is up to {STRETCHED:.0%} of its length"
            )


def _ask_about_drums(about: SceneContext) -> Iterator[Query]:
    """Ask about winches that hold a tension, and whose wire at the start the drum cannot have."""
    winches = [(name, of) for name, of in about.scene.forces.items() if isinstance(of, Winch)]
    for (name, winch), row in zip(winches, WINCH_KIND.constants_in(about.model).each, strict=True):
        wire = float(row["start"])
        shortest, longest = winch.ends
        if winch.tension is not None and not shortest <= wire <= longest:
            found_text = (
                f"{shortest:g} m to {longest:g} m, while the set tension takes {wire:.4g} m"
            )
            usual = "the length at the start is usually between the ends"
            slack = "The wire starts slack." if wire < shortest else ""
            yield Query(f"forces.{name}.drum", found_text, usual, slack)


def _ask_about_catenaries(about: SceneContext) -> Iterator[Query]:
    """Ask about strain, a line without horizontal pull, and a body afloat that hangs from its
    anchor. Lines in air, to a crane, a quay or a fixed topside, are usual."""
    afloat = {body.name for body in about.scene.bodies if body.hydrodynamics is not None}
    state = about.state
    model = about.model
    time = about.end - about.scene.duration
    every = line_shapes(model, about.scene, time, state.y, state.modes, model.bodies, about.motion)
    acting = [*every]
    for name in _parted_catenaries(about, {line.name for line in acting}):
        found_text = "a tension above it at the start, so that the line parts at once"
        yield Query(f"forces.{name}.breaks_at", found_text, "a line usually holds at the start")
    for line in acting:
        key = f"forces.{line.name}"
        if line.strain > MAX_START_STRAIN:
            strain = text_beyond(line.strain, MAX_START_STRAIN, ".1%")
            found_text = f"{line.length:g} m, stretched by {strain} at the start"
            yield Query(f"{key}.segments", found_text, f"usual is up to {MAX_START_STRAIN:.0%}")
        tension = largest_tension(line.pull)
        if tension > line.curve_end:
            found_text = f"a tension of {text_beyond(tension, line.curve_end)} N at the start"
            usual = f"the curve of stiffness ends at {line.curve_end:.3g} N"
            yield Query(f"{key}.segments", found_text, usual, "Its last slope goes on.")
        if line.pull.H == 0.0 and line.ends.x > 0.0:
            found_text = f"{line.length:g} m, slack at the start: no horizontal pull"
            yield Query(f"{key}.segments", found_text, "a moored body is held by its lines")
        anchor = line.ends.anchor
        moored = about.scene.forces[line.name]
        earth = not any(body for _, body in moored.connected_bodies())
        hangs = line.ends.z < 0.0 and moored.body in afloat and earth
        if anchor > 0.0 and hangs:
            yield Query(
                f"{key}.anchor",
                f"{_metres_text(anchor)} above the still water, and above the fairlead",
                "an anchor is usually below both",
                "z is upward, and weights of segments are in water.",
            )


def _parted_catenaries(about: SceneContext, acting: set[str]) -> Iterator[str]:
    """Catenaries that do not act, because their own tension at the start ends their action."""
    for name, element in about.scene.forces.items():
        until = element.active.until if element.active else None
        waits = element.active is not None and element.active.start is not None
        breaks_by_tension = until is not None and until.channel == f"line_tension.{name}"
        if breaks_by_tension and not waits and name not in acting and about.scene.initial is None:
            yield name


def _ask_about_struts(about: SceneContext) -> Iterator[Query]:
    p = LINK_KIND.constants_in(about.model)
    for i, (name, strut) in enumerate(elements_of(about.scene, LINK_KIND.classes)):
        if not (isinstance(strut, Strut) and np.any(strut.force)):
            continue
        s = link_kinematics(p, i, about.state.y, about.motion, about.model.bodies)
        offset = s.x
        length = s.place - s.x
        if abs(offset) > max(STRETCHED * length, float(np.abs(strut.offset).max())):
            longer = "longer" if offset > 0.0 else "shorter"
            found_text = f"{length:g} m, while it is {abs(offset):.3g} m {longer} at the start"
            yield Query(
                f"forces.{name}.length", found_text, f"usual is up to {STRETCHED:.0%} of its length"
            )


def _fender_starts(about: SceneContext) -> Iterator[tuple[str, Contact, np.ndarray]]:
    """Fenders with the compressions (n,) of their points at the start."""
    for name, fender in about.scene.forces.items():
        if isinstance(fender, Contact):
            b = about.body_numbers[fender.body]
            places = [_place_at_start(about, b, point) for point in np.asarray(fender.points)]
            pairs = zip(fender.planes(), places, strict=True)
            deep = [_depth_inside_plane(about, plane, place) for plane, place in pairs]
            yield name, fender, np.array(deep)


def _metres_text(length: float) -> str:
    """A length with its unit. A decimal tells it from a number of something."""
    return f"{length:.1f} m" if 0.1 <= length < 100.0 else f"{length:.3g} m"


def _depth_inside_plane(about: SceneContext, plane: Plane, place: np.ndarray) -> float:
    """Distance of a ``place`` behind a plane [m]."""
    normal, point = np.array(plane.normal, float), np.array(plane.point, float)
    if plane.body is not None:
        b = about.body_numbers[plane.body]
        normal, point = about.motion.rotation[b] @ normal, _place_at_start(about, b, point)
    return float(normal @ (point - place) / np.linalg.norm(normal))


def _place_at_start(about: SceneContext, b: int, point: np.ndarray) -> np.ndarray:
    """Position of a point of a body at the start."""
    return about.centre(b) + about.motion.rotation[b] @ point
