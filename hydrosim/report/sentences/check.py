"""Sentences and tables of a scene before it is run, for `hydrosim check` and `hydrosim.check`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import atan2, ceil, cos, hypot, isfinite, pi, radians, sin
from pathlib import Path

import numpy as np

from hydrosim.analysis.ballast import with_contents_at
from hydrosim.case import Case, as_case
from hydrosim.compile import sizes
from hydrosim.compile.clock import compile_clock
from hydrosim.compile.compile import compile_calm, compile_scene
from hydrosim.compile.compiled import Compiled, Notes, solution
from hydrosim.compile.drives import drives_of, is_turn, motion_at, sample_times
from hydrosim.compile.hydrodynamic_groups import scene_with_states
from hydrosim.compile.questions.query import SceneContext, describe_start, extents
from hydrosim.compile.restart import resumed_state, started_from
from hydrosim.compile.waves import add_waves
from hydrosim.database.database import HydroDatabase, require_array
from hydrosim.elements.drive import Drive
from hydrosim.elements.viscous_roll import EDDIES, VISCOUS_ROLL_KIND
from hydrosim.files import document_nodes
from hydrosim.files.display_units import units_of
from hydrosim.files.document import Document
from hydrosim.files.yaml_nodes import add_source_lines, source_context
from hydrosim.integrate.names import coordinate_at
from hydrosim.integrate.state import start_loads
from hydrosim.linear.linearise import linearise
from hydrosim.linear.modes import ModeKind, NaturalMode, natural_modes
from hydrosim.linear.stability import StepLimit, Watch, without_progress
from hydrosim.report.sentences.run import radiation_verdict
from hydrosim.run.step_limits import accuracy_limit, scene_combinations, scene_step_limits
from hydrosim.scene import Body, Joint, Scene, Weight
from hydrosim.scene.catenary import Catenary
from hydrosim.scene.damping import ViscousRoll
from hydrosim.scene.joint import MotionKind, Rod
from hydrosim.scene.links import TwoPointElement
from hydrosim.scene.scene import arrangement, floating_roots
from hydrosim.scene.signal import Harmonic, Recorded
from hydrosim.simulation import check_criteria
from hydrosim.water.components import sea_state

# Joints and prescribed motions of a scene.


def describe_joints(scene: Scene) -> Iterator[str]:
    """A line for each joint: what it connects, and how its motions are solved."""
    joint_tree = arrangement(scene)
    bodies = {body.name: body for body in scene.bodies}
    for branch in joint_tree.branches:
        motions = ", ".join(motion.name.replace("_", " ") for motion in branch.joint.motions)
        how = f"coordinates: {motions}" if motions else "no motion"
        restoring = _restoring_text(bodies[branch.child])
        friction = "".join(_load_friction_texts(branch.joint))
        yield f"{branch.name}: {_bodies_of_joint(branch.joint)}; {how}{friction}{restoring}"
    for name in joint_tree.loops:
        joint = scene.joints[name]
        role = "keeps a distance" if isinstance(joint, Rod) else "closes a loop"
        yield f"{name}: {_bodies_of_joint(joint)}; {role}, held by constraint forces"
    for name in joint_tree.passing:
        yield f"{name}: {_bodies_of_joint(scene.joints[name])}; a constraint while it is closed"


def _bodies_of_joint(joint: Joint) -> str:
    other = "the earth" if joint.to is None else joint.to
    return f"{joint.type} between {joint.body} and {other}"


def _load_friction_texts(joint: Joint) -> Iterator[str]:
    """What friction grows with, and the lever of a push along the axis from which a guide jams."""
    for motion, acting in zip(joint.motions, joint.resistances, strict=False):
        friction = acting.friction
        if friction is None or not friction.coefficients[1]:
            continue
        static, kinetic = friction.coefficients
        yield (
            f". Friction of {motion.name.replace('_', ' ')}: {static:g} of the"
            f" load of its bearings at rest, {kinetic:g} in motion"
        )
        if motion.kind == MotionKind.SLIDE and isfinite(distance := friction.levers[2]):
            lever = distance / (2.0 * static)
            yield f"; pushed more than {lever:.3g} m beside the joint it jams"


def _restoring_text(body: Body) -> str:
    """What restores a body that a joint carries, and where that is valid."""
    if body.hydrodynamics is None:
        return ""
    if body.hydrostatics is not None:
        return f". Buoyancy of {body.name}: of its hull, at any attitude"
    weight = "; weight and buoyancy at rest act as forces" if body.weight == Weight.CARRIED else ""
    return (
        f". Stiffness of {body.name}: linear in the displacement and the rotation vector of its"
        f" centre of gravity{weight}"
    )


def describe_drives(scene: Scene, begin: float = 0.0) -> Iterator[document_nodes.Sentence]:
    """A sentence for each drive: what it moves, how far, and how fast."""
    for name, drive in drives_of(scene).items():
        unit = "rad" if is_turn(scene, drive) else "m"
        times = sample_times(drive, begin, begin + scene.duration)
        position, speed, acceleration = np.array([motion_at(drive, float(t)) for t in times]).T
        parts: list[document_nodes.Part] = [
            *(name, drive.driven, _drive_form_text(drive)),
            *document_nodes.value_cells((position.min(), position.max(), position[0]), unit),
            *document_nodes.value_cells((speed[0], np.abs(speed).max()), f"{unit}/s"),
            document_nodes.Value(float(np.abs(acceleration).max()), f"{unit}/s^2"),
        ]
        text = "{} moves {} by {}: from {} to {}; it starts at {} with {}; at most {} and {}."
        yield document_nodes.Sentence(text, parts)


def _drive_form_text(drive: Drive) -> str:
    signal = drive.position
    if isinstance(signal, Harmonic):
        return f"a sine of {signal.period:g} s"
    what = "a record" if isinstance(signal, Recorded) else "a table"
    return f"{what} of {np.size(signal.value)} values"


# Roll damping of a scene.

AMPLITUDE_DEG = 5.0  # deg


def describe_roll_damping(compiled: Compiled) -> Iterator[str]:
    """A line for each roll damping: its coefficients, the damping by waves that is taken off, and
    the damping ratio without waves at an amplitude of 5 deg."""
    elements = [(n, e) for n, e in compiled.scene.forces.items() if isinstance(e, ViscousRoll)]
    rolling = VISCOUS_ROLL_KIND.constants_in(compiled.model)
    for (name, element), linear_damping in zip(elements, rolling, strict=True):
        B1, B2, B3, mass, omega = (
            float(linear_damping[x]) for x in ("linear", "quadratic", "cubic", "mass", "frequency")
        )
        parts = [f"{name}: B1 {B1:.4g}, B2 {B2:.4g}, B3 {B3:.4g} N m s^n/rad^n"]
        if element.p1 or element.p2 or element.p3:
            waves = float(linear_damping["waves"])
            off = (
                f"less {waves:.4g} by waves"
                if element.includes_waves is not False
                else "waves not taken off"
            )
            parts.append(f"p1 is {float(linear_damping['measured']):.4g} N m s/rad in all, {off}")
        if omega > 0.0:
            rate = omega * radians(AMPLITUDE_DEG)
            damping = B1 + EDDIES * B2 * rate + 0.75 * B3 * rate**2
            ratio = 50.0 * damping / (mass * omega)
            parts.append(
                f"{ratio:.3g} % of critical besides waves at {AMPLITUDE_DEG:g} deg and"
                f" {2.0 * pi / omega:.4g} s"
            )
        yield "; ".join(parts)


# Flotation at the start, and directions that waves, wind and current come from.

SIDES = (
    "from astern",
    "from the starboard quarter",
    "from starboard abeam",
    "from the starboard bow",
    "from ahead",
    "from the port bow",
    "from port abeam",
    "from the port quarter",
)
"""Where a stream comes from that goes to 0, 45, 90, ... degrees of a body's heading."""
ALONG_AXIS = sin(pi / 8.0)  # component below which a direction is along the other axis
MAX_NAMED_BODIES = 4
ANGLE_DIGITS = 9  # of rad: what is smaller is left over from the search for rest
FLOATING_HEAD = (
    "body",
    "heading",
    "heel",
    "trim",
    "draught, about",
    "G above water",
    "GM in roll",
    "GM in pitch",
)


def describe_floating(compiled: Compiled) -> document_nodes.Nodes:
    """Directions of the environment beside bodies, and how hulls with a database float."""
    scene = compiled.scene
    about = describe_start(
        scene, compiled.derived, compiled.state, compiled.sea, compiled.begin + scene.duration
    )
    afloat = list(about.afloat())
    rotation = {body.name: about.motion.rotation[i] for i, body, _ in afloat}
    headings = {name: atan2(R[1, 0], R[0, 0]) for name, R in rotation.items()}
    directions = list(_describe_directions(scene, headings))
    if directions:
        yield document_nodes.List(directions, "Directions at the start")
    rows = [
        _floating_row(about, body, db, headings[body.name], rotation[body.name])
        for _, body, db in afloat
    ]
    columns = [k for k in range(len(FLOATING_HEAD)) if any(row[k] != "" for row in rows)]
    if rows:
        head = [FLOATING_HEAD[k] for k in columns]
        cells = [[row[k] for k in columns] for row in rows]
        yield document_nodes.Table(head, cells, "Bodies afloat at the start")


def _floating_row(
    about: SceneContext, body: Body, db: HydroDatabase, heading: float, R: np.ndarray
) -> document_nodes.Row:
    gravity = about.scene.environment.gravity
    size = extents(body, db)
    stiffness = require_array(db, "hydrostatic_stiffness")
    transverse, longitudinal = (float(stiffness[k, k]) / (body.mass * gravity) for k in (3, 4))
    angles = heading, atan2(R[2, 1], R[2, 2]), atan2(-R[2, 0], hypot(R[0, 0], R[1, 0]))
    height = float(about.centre(about.body_numbers[body.name])[2])
    return [
        body.name,
        *document_nodes.value_cells(np.round(angles, ANGLE_DIGITS), "rad", 3),
        document_nodes.Value(size.draught, "m", 3) if size is not None else "",
        *document_nodes.value_cells((height, transverse, longitudinal), "m", 3),
    ]


def _describe_directions(scene: Scene, headings: dict[str, float]) -> Iterator[str]:
    environment = scene.environment
    trains = environment.waves
    for k, train in enumerate(trains, 1):
        heading = sea_state(train, environment).heading
        name = f"waves {k}" if len(trains) > 1 else "waves"
        if isfinite(heading):
            yield f"{name} {describe_direction(heading, headings)}"
    for name, stream in (("current", environment.current), ("wind", environment.wind)):
        if stream.top_speed > 0.0:
            yield f"{name} {describe_direction(stream.direction, headings)}"


def describe_direction(heading: float, headings: dict[str, float]) -> str:
    """Where a stream with this ``heading`` [rad] goes, and from where it meets bodies with these
    ``headings``, in words."""
    text = f"towards {_axis_text(heading)} of the earth frame"
    met: dict[str, list[str]] = {}
    for body, body_heading in headings.items():
        octant = round((heading - body_heading) / (pi / 4.0)) % 8
        met.setdefault(SIDES[octant], []).append(body)
    for side, bodies in met.items():
        more = len(bodies) - MAX_NAMED_BODIES
        names = ", ".join(bodies[:MAX_NAMED_BODIES]) + (f" and {more} more" if more > 0 else "")
        text += f"; {side} of {names}"
    return text


def _axis_text(heading: float) -> str:
    parts = [
        f"{'+' if component > 0.0 else '-'}{axis}"
        for axis, component in (("x", cos(heading)), ("y", sin(heading)))
        if abs(component) > ALONG_AXIS
    ]
    return " and ".join(parts)


def describe_lines(compiled: Compiled) -> Iterator[document_nodes.Table]:
    """Tensions of lines and forces of struts at the start, beside what they may carry, and the
    heights of the ends of mooring lines."""
    lines = {
        name: of for name, of in compiled.scene.forces.items() if isinstance(of, TwoPointElement)
    }
    if not lines:
        return
    loads = start_loads(
        compiled.scene, compiled.model, compiled.state, compiled.derived.rows, compiled.begin
    )
    about = describe_start(
        compiled.scene, compiled.derived, compiled.state, compiled.sea, compiled.begin
    )
    heights = {name: _line_heights(about, of) for name, of in lines.items()}
    moored = any(any(cells) for cells in heights.values())
    rows = []
    for name, line in lines.items():
        cells: document_nodes.Row = [name, document_nodes.Value(loads[name], "N"), "", ""]
        if line.capacity is not None:
            used = document_nodes.Value(loads[name] / line.capacity, "share", 2)
            cells[2:] = document_nodes.Value(line.capacity, "N"), used
        rows.append([*cells, *(heights[name] if moored else ())])
    head = ["line", "load at the start", "capacity", "used"]
    if moored:
        head += ["fairlead above water", "anchor above bed"]
    yield document_nodes.Table(head, rows, "Loads of lines")


def _line_heights(about: SceneContext, line: TwoPointElement) -> document_nodes.Row:
    """Heights of the fairlead of a mooring line above the water, and of its anchor above the bed;
    empty for other lines."""
    if not isinstance(line, Catenary) or line.anchor_body is not None:
        return ["", ""]
    b = about.body_numbers[line.body]
    place = about.centre(b) + about.motion.rotation[b] @ np.array(line.point, float)
    above = about.scene.environment.water_depth + line.anchor[2]
    return [
        document_nodes.Value(float(place[2]), "m", 3),
        document_nodes.Value(above, "m", 3) if isfinite(above) else "",
    ]


CLOSE_ENOUGH = 1e-2  # tolerance of a fit for periods and damping ratios, where a run convolves


def check_document(
    scene: Scene, times: Sequence[float] = (), watch: Watch = without_progress
) -> Document:
    """Verdicts on warnings, step and radiation; natural periods; in detail the size of the problem,
    databases and what is skipped. Step limits and periods are those of the start, of ``times`` [s]
    and, if tanks change, of the end. ``watch`` shows how far the search for step limits is."""
    whole_scene = compile_scene(scene, in_plane=True)
    with source_context(scene.places):
        check_criteria(whole_scene)
    compiled = with_linearisable_memory(whole_scene)
    whole = with_linearisable_memory(whole_scene.whole) if whole_scene.whole else compiled
    nodes: list[document_nodes.Node] = [*_describe_verdicts(whole_scene, compiled, watch)]
    nodes += _lists({"Waves": whole_scene.notes.seas})
    nodes += describe_floating(whole_scene.whole or whole_scene)
    nodes += _lists({"Trees of joints": list(_describe_roots(whole_scene.scene))})
    nodes += describe_drives(whole_scene.scene, whole_scene.begin)
    nodes += _lists(
        {"Wind and current": whole_scene.notes.streams, "Lines": whole_scene.notes.drag}
    )
    nodes += describe_lines(whole_scene)
    nodes += _periods_of(whole, "at the start of the run")
    end = [compiled.begin + scene.duration] if whole_scene.model.tanks.each.size else []
    for time in sorted({*times, *end}):
        nodes += _limits_at(
            with_contents_at(compiled, time), with_contents_at(whole, time), watch, time
        )
    nodes += [
        document_nodes.Heading("Details", "details", detail=True),
        *_describe_details(whole_scene, compiled),
    ]
    return Document(scene.title, nodes, units=units_of(scene.source))


def check(case: Case | Scene | str | Path, times: Sequence[float] = ()) -> Document:
    """What `hydrosim check` prints of a case, of the case in a file or of a scene; `print` and
    notebooks show it. Step limits and natural periods are also those at ``times`` [s]. Raises
    InputError as `simulate` does.

    >>> "rk4 is stable at any step" in str(hs.check("cases/friction_block/exact.yaml"))
    True
    """
    scene = case if isinstance(case, Scene) else as_case(case).scene()
    return check_document(scene, times)


def _describe_verdicts(whole: Compiled, compiled: Compiled, watch: Watch) -> document_nodes.Nodes:
    yield from document_nodes.warnings(
        [add_source_lines(text, whole.scene.places) for text in whole.notes.warnings]
    )
    if not whole.derived.exact:
        yield from _describe_step(compiled, watch)
    if isfinite(whole.notes.radiation_error):
        yield radiation_verdict(whole.notes.radiation_error)
    yield document_nodes.Sentence("{}.", [_capitalise(solution(whole.scene, whole.derived))])


def _describe_step(compiled: Compiled, watch: Watch) -> document_nodes.Nodes:
    """Whether the step is stable, and what it resolves."""
    mode_combinations = scene_combinations(compiled, each_alone=True, watch=watch)
    limits = scene_step_limits(compiled, mode_combinations)
    solver = compiled.scene.solver
    yield from (_limit_verdict(limit, solver.step) for limit in limits)
    if not limits:
        yield document_nodes.Verdict(
            document_nodes.Outcome.GOOD, "{} is stable at any step.", [str(solver.method)]
        )
    if not compiled.method.adapts:
        yield document_nodes.Sentence(
            "{}.", [_capitalise(accuracy_limit(compiled, mode_combinations))]
        )


def _limit_verdict(limit: StepLimit, step: float) -> document_nodes.Verdict:
    stable = step <= limit.step
    text = (
        "The step of {} is stable: the largest stable step is {} ({}, {})."
        if stable
        else "The step of {} is UNSTABLE: the largest stable step is {} ({}, {})."
    )
    parts: list[document_nodes.Part] = [
        document_nodes.Value(step, "s", 3),
        document_nodes.Value(limit.step, "s", 3),
        limit.what,
        limit.contact,
    ]
    return document_nodes.Verdict(
        document_nodes.Outcome.GOOD if stable else document_nodes.Outcome.BAD, text, parts
    )


def _describe_roots(scene: Scene) -> Iterator[str]:
    """Roots of floating trees of bodies in water: their choice matters at second order."""
    wet = {body.name for body in scene.bodies if body.hydrodynamics is not None}
    for root, carried in floating_roots(scene).items():
        if len(wet & {root, *carried}) > 1:
            yield (
                f"{root} is the root of the floating tree with {', '.join(carried)}. Heading and"
                " restoring of the others are defined along the tree, so another root changes roll"
                " and pitch at second order. A joint makes its `to` the root"
            )


def _capitalise(text: str) -> str:
    """A text with a capital at its beginning. Names in it keep theirs."""
    return text[:1].upper() + text[1:]


def _limits_at(
    compiled: Compiled, whole: Compiled, watch: Watch, time: float
) -> document_nodes.Nodes:
    """Step limits and natural periods at a ``time`` [s]."""
    yield document_nodes.Heading(f"At {time:g} s")
    if not compiled.derived.exact:
        yield from _describe_step(compiled, watch)
    yield from _periods_of(whole, f"at {time:g} s", time)


def _periods_of(whole: Compiled, when: str, time: float | None = None) -> document_nodes.Nodes:
    linear = linearise(whole.model, whole.state, time=whole.begin if time is None else time)
    held = len(linear.constraints)
    when = f"{when}, {held} directions held" if held else when
    yield _period_table(whole.scene, natural_modes(linear), when)


def _period_table(scene: Scene, modes: Sequence[NaturalMode], when: str) -> document_nodes.Table:
    head = ("body", "mode", "natural period", "damped period", "damping ratio")
    return document_nodes.Table(
        head, [_mode_cells(scene, mode) for mode in modes], f"Natural periods {when}"
    )


def _mode_cells(scene: Scene, mode: NaturalMode) -> document_nodes.Row:
    coordinate = coordinate_at(scene, mode.coordinate)
    cells: document_nodes.Row = [coordinate.body, coordinate.dof]
    if mode.kind == ModeKind.FREE:
        return [*cells, "free", "", ""]
    cells.append(document_nodes.Value(mode.natural_period, "s"))
    if mode.kind != ModeKind.OSCILLATING:
        return [*cells, str(mode.kind), ""]
    return [
        *cells,
        document_nodes.Value(mode.damped_period, "s"),
        document_nodes.Value(mode.damping_ratio, digits=3),
    ]


def _describe_details(whole: Compiled, compiled: Compiled) -> document_nodes.Nodes:
    """How large the problem is, how it is solved, what it reads and what is skipped."""
    notes = whole.notes
    yield document_nodes.List(list(_size_texts(whole, compiled)))
    for wet in whole.wet:
        provenance = [
            f"{key.replace('_', ' ')}: {value}" for key, value in wet.provenance().items()
        ]
        yield document_nodes.List(provenance, ", ".join(wet.names))
    yield from _lists({"Joints": list(describe_joints(whole.scene))})
    yield from _lists({"Roll damping": list(describe_roll_damping(whole))})
    yield from _lists({"Radiation": notes.memory, "Recorded": notes.records})
    yield from _lists({"Where waves meet bodies": notes.meetings, "Skipped": notes.skipped})


def _lists(lists: dict[str, Sequence[str]]) -> Iterator[document_nodes.List]:
    return (document_nodes.List(items, title) for title, items in lists.items() if items)


def _size_texts(whole: Compiled, compiled: Compiled) -> Iterator[str]:
    scene = compiled.scene
    model = whole.model
    for key, value in started_from(scene).items():
        yield f"{key.replace('_', ' ')}: {value}"
    yield (
        f"{len(scene.bodies)} bodies, {model.bodies.active.size} free coordinates,"
        f" {model.states.decay.size} radiation states, {len(scene.forces)} force elements,"
        f" {model.size} states in all"
    )
    memory = sizes.size_text(sizes.memory_needed(scene))
    yield f"about {memory} of memory, {sizes.size_text(sizes.result_size(scene))} of result"
    if whole.notes.symmetry:
        yield f"solved {whole.notes.symmetry}"
    if compiled is not whole:
        yield "radiation by convolution; states are for step limits and natural periods alone"
    yield from _step_texts(whole, compiled)


def _step_texts(whole: Compiled, compiled: Compiled) -> Iterator[str]:
    scene = compiled.scene
    clock = compile_clock(compiled)
    if whole.derived.exact:
        yield f"{ceil(scene.duration / scene.output_step):,} records every {scene.output_step:g} s"
    elif clock.control.adaptive:
        yield f"adaptive steps by {scene.solver.method}, recorded every {clock.step:g} s"
        if whole.notes.method:
            yield f"chosen: {whole.notes.method}"
    else:
        yield f"{clock.points:,} steps of {clock.step:g} s by {scene.solver.method}"


def with_linearisable_memory(compiled: Compiled) -> Compiled:
    """A compiled scene with states instead of a convolution, whose memory cannot be linearised."""
    if compiled.model.convolution.row.size == 0:
        return compiled
    scene, wet = scene_with_states(compiled.scene, compiled.wet, CLOSE_ENOUGH)
    fresh = compile_calm(replace(scene, initial=None), wet)
    state = fresh.state
    if scene.initial is not None:
        state = resumed_state(scene, fresh.model, fresh.derived.layout, state)
    calm = Notes(symmetry=compiled.notes.symmetry, zero=compiled.notes.zero)
    return add_waves(replace(fresh, state=state, notes=calm), scene, compiled.sea)
