"""Free motions of joints, and what acts in them: spring, damping, end stops, dry friction.

    f = -k (q - q0) - c u + stop - friction

q, u: the motion and its rate [m or rad]; f: force or moment on the joint's body along it, its
opposite on the other body. Stops are those of links (`elements.link.stop`). Friction is the
given kinetic force against the motion, and a part that grows with the load of the joint
(`elements.joint.load_friction`). At rest a constraint holds u = 0, until its force exceeds the
static one.

Modes of friction: none, stuck, moving up or down, or undefined. Those of the stops are in the
column `SEGMENT`. All changes are events.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import inf
from typing import Any, ClassVar, NamedTuple

import numpy as np

from hydrosim.elements import kind as kinds
from hydrosim.elements.link import stop
from hydrosim.jit.kernels import clear, kernel, root, root_giving
from hydrosim.modes import (
    CONTACT_MARGIN,
    FRICTION_MARGIN,
    MARGINS,
    MODE,
    NO_INDEX,
    RISING_MARGIN,
    SEGMENT,
    SEGMENT_MARGIN,
)
from hydrosim.multibody.tree import BALL, SLIDE, coordinate_places, push_joint
from hydrosim.multibody.vectors import dot, quaternion_of_parameters, rotation_vector
from hydrosim.scene import ForceElement, JointResistance, Scene
from hydrosim.scene.scene import tree_joints

NO_FRICTION, STUCK, UP, DOWN, UNDEFINED_FRICTION = range(5)
FRICTION_MODES = ("frictionless", "stuck", "up", "down", "undefined")
STOPS = ("away", "at_lowest", "at_highest", "below", "above")
MOTION_POSITION, MOTION_RATE, MOTION_FORCE, JOINT_MOTION_OUTPUTS = range(4)
MOTION_FRICTION, MOTION_LOAD, LOADED_MOTION_OUTPUTS = range(JOINT_MOTION_OUTPUTS, 6)
REST_RATE = 1e-12  # m/s or rad/s after an impact: rounding

MOTION = np.dtype(
    [
        *(("coordinate", int), ("move", int), ("axis", int), ("row", int)),
        *(("stiffness", float), ("neutral", float), ("damping", float)),
        *(("stops", stop.STOPS), ("static", float), ("kinetic", float)),
        *(("static_coefficient", float), ("kinetic_coefficient", float)),
        *(("radius", float), ("collar", float), ("couple", float)),
        *(("joint", int), ("shifts", bool)),
    ]
)
"""A motion: its coordinate, its move of the tree and the axis of that, its row of forces
(`NO_INDEX` if nothing acts); k, q0, c; its stops; the static and the kinetic force, negative if
none. For friction by load: both mu, 0 if none; r, c and 1 / L; the number of its joint,
and whether that moves the place of the joint away from its bearings."""


class JointMotionConstants(NamedTuple):
    """The motions ``each`` (n,) of `MOTION` of all joints of trees; the number of ``rows`` of
    constraints at most; those with friction by load, ``loaded`` (m,); the first of their rows of
    modes and of their reactions."""

    each: np.ndarray
    rows: int
    loaded: np.ndarray
    mode: int
    reaction: int


def compile_elements(
    elements: Mapping[str, ForceElement], layout: kinds.Layout
) -> JointMotionConstants:
    """Constants of all free motions of the joints of trees."""
    places = coordinate_places(layout.tree)
    rows = []
    coordinate = min(places, default=0)
    for number, (name, joint) in enumerate(layout.joints.items()):
        for i in range(0 if name in layout.constraints else len(joint.motions)):
            acting = joint.resistances[i]
            row = layout.row[name] if acting.acts else NO_INDEX
            move, axis = places[coordinate]
            kind, sign = layout.tree.moves[["kind", "sign"]][move]
            shifts = kind == SLIDE and sign < 0.0
            constants = (coordinate, move, axis, row, *_resistance_constants(acting))
            rows.append((*constants, number, shifts))
            coordinate += 1
    motions = np.array(rows, dtype=MOTION)
    loaded = np.flatnonzero(motions["kinetic_coefficient"] > 0.0)
    return JointMotionConstants(motions, int((motions["static"] >= 0.0).sum()), loaded, 0, 0)


def _resistance_constants(acting: JointResistance) -> tuple[Any, ...]:
    ends = acting.stops
    friction = acting.friction
    radius, collar, distance = friction.levers if friction else (1.0, 0.0, inf)
    return (
        *(acting.stiffness, acting.neutral, acting.damping),
        (*ends.range, ends.stiffness, ends.damping) if ends else stop.NO_STOPS,
        *(friction.constant_friction if friction else (-1.0, 0.0)),
        *(friction.coefficients if friction else (0.0, 0.0)),
        *(radius, collar, 1.0 / distance),
    )


def are_linear(p: JointMotionConstants) -> bool:
    """True if no motion has stops or dry friction."""
    return not np.any(_has_stops(p) | (p.each["static"] >= 0.0))


def _has_stops(p: JointMotionConstants) -> np.ndarray:
    """Which motions (n,) have stops."""
    return np.asarray(p.each["stops"]["stiffness"] > 0.0)


@kernel
def _friction_force(joint_motion, mode):
    """Friction of a moving joint."""
    if mode == UP:
        return -joint_motion.kinetic
    return joint_motion.kinetic if mode == DOWN else 0.0


@kernel
def _acting_force(joint_motion, mode, q, u):
    """Force of all that acts in a motion but the reaction of a stuck one."""
    spring = -joint_motion.stiffness * (q - joint_motion.neutral) - joint_motion.damping * u
    load, _ = stop.find_loads(joint_motion.stops, mode[SEGMENT], q, u)
    return spring - load + _friction_force(joint_motion, mode[MODE])


@kernel
def _dissipated_power(joint_motion, mode, q, u):
    """Power that a motion loses."""
    _, lost = stop.find_loads(joint_motion.stops, mode[SEGMENT], q, u)
    return joint_motion.damping * u * u - _friction_force(joint_motion, mode[MODE]) * u + lost


@root
def add_force(y, modes, motion, bodies, p, wrench, rate):
    """Add the forces of all motions to the rows of ``wrench``, and their losses to ``rate``."""
    n = bodies.active.size
    for i in range(p.each.size):
        joint_motion = p.each[i]
        if joint_motion.row != NO_INDEX:
            q = y[joint_motion.coordinate]
            u = y[n + joint_motion.coordinate]
            mode = modes[p.mode + i]
            push_joint(
                joint_motion.move,
                joint_motion.axis,
                _acting_force(joint_motion, mode, q, u),
                bodies,
                motion,
                wrench[joint_motion.row],
            )
            rate[joint_motion.row] += _dissipated_power(joint_motion, mode, q, u)


@root
def add_energy(y, modes, p, stored):
    """Add the energy of springs and of stops to the rows of ``stored``."""
    for i in range(p.each.size):
        joint_motion = p.each[i]
        if joint_motion.row != NO_INDEX:
            q = y[joint_motion.coordinate]
            stretch = q - joint_motion.neutral
            stored[joint_motion.row] += 0.5 * (joint_motion.stiffness * stretch * stretch)
            segment = modes[p.mode + i, SEGMENT]
            stored[joint_motion.row] += stop.stored_energy(joint_motion.stops, segment, q)


@kernel
def _left_of_friction(i, p, reactions):
    """Friction that is left to the stuck motion ``i`` before it breaks loose."""
    reaction = reactions[p.reaction + i]
    return p.each[i].static + reaction[1] - abs(reaction[0])


@root
def find_margins(y, modes, bodies, p, reactions, out):
    """Margins of all motions into ``out``: way to the stops, or beyond the one that is met; the
    force of that stop; the rate along the motion, or the friction that is left; what is left until
    friction by load is undefined."""
    n = bodies.active.size
    for i in range(p.each.size):
        joint_motion = p.each[i]
        mode = modes[p.mode + i]
        m = MARGINS * (p.mode + i)
        q = y[joint_motion.coordinate]
        u = y[n + joint_motion.coordinate]
        for k in range(MARGINS):
            out[m + k] = 1.0
        if mode[MODE] == STUCK:
            out[m + FRICTION_MARGIN] = _left_of_friction(i, p, reactions)
        elif mode[MODE] == UP or mode[MODE] == DOWN:
            out[m + FRICTION_MARGIN] = u if mode[MODE] == UP else -u
            if joint_motion.kinetic_coefficient > 0.0:
                out[m + RISING_MARGIN] = reactions[p.reaction + i, 1]
        if joint_motion.stops.stiffness > 0.0:
            margins = out[m : m + MARGINS]
            stop.find_margins(joint_motion.stops, mode[SEGMENT], q, u, margins)


@root
def transition(i, which, y, modes, bodies, reactions, p):
    """Switch motion ``i`` to its next mode, after margin ``which`` has reached zero."""
    joint_motion = p.each[i]
    mode = modes[p.mode + i]
    q = y[joint_motion.coordinate]
    u = y[bodies.active.size + joint_motion.coordinate]
    if which in (CONTACT_MARGIN, SEGMENT_MARGIN):
        mode[SEGMENT] = stop.next_segment(joint_motion.stops, which, mode[SEGMENT], q, u)
    elif which == RISING_MARGIN:
        mode[MODE] = UNDEFINED_FRICTION
    elif mode[MODE] == STUCK:
        mode[MODE] = UP if reactions[p.reaction + i, 0] < 0.0 else DOWN
    else:
        mode[MODE] = STUCK


@root
def set_initial_modes(y, modes, bodies, p):
    """Modes of all motions for a start from ``y``."""
    n = bodies.active.size
    for i in range(p.each.size):
        joint_motion = p.each[i]
        mode = modes[p.mode + i]
        q = y[joint_motion.coordinate]
        u = y[n + joint_motion.coordinate]
        mode[MODE] = NO_FRICTION
        if joint_motion.static >= 0.0:
            mode[MODE] = UP if u > 0.0 else DOWN if u < 0.0 else STUCK
        mode[SEGMENT] = stop.initial_segment(joint_motion.stops, q, u)


@root
def add_constraints(modes, p, constraints, holds):
    """Add the constraint u = 0 of each stuck motion."""
    for i in range(p.each.size):
        if modes[p.mode + i, MODE] == STUCK:
            r = constraints.number[0]
            clear(constraints.J[r])
            constraints.J[r, p.each[i].coordinate] = 1.0
            constraints.bound[r] = 0.0
            holds.point[r] = NO_INDEX
            holds.lock[r] = NO_INDEX
            holds.motion[r] = i
            holds.residual[r] = 0.0
            constraints.number[0] = r + 1


@root
def add_reactions(modes, motion, bodies, p, constraints, holds, wrench):
    """Add the reactions of all stuck motions to their rows of ``wrench``."""
    for i in range(p.each.size):
        holds.reaction[p.reaction + i, 0] = 0.0
    for r in range(constraints.number[0]):
        i = holds.motion[r]
        if i != NO_INDEX:
            joint_motion = p.each[i]
            holds.reaction[p.reaction + i, 0] = constraints.force[r]
            push_joint(
                joint_motion.move,
                joint_motion.axis,
                constraints.force[r],
                bodies,
                motion,
                wrench[joint_motion.row],
            )


@root_giving(bool)
def break_loose(modes, p, reactions):
    """Release the first stuck motion whose reaction exceeds its friction, or find one that slides
    with undefined friction; true if there was one."""
    for i in range(p.each.size):
        mode = modes[p.mode + i]
        if mode[MODE] == STUCK and _left_of_friction(i, p, reactions) < 0.0:
            mode[MODE] = UP if reactions[p.reaction + i, 0] < 0.0 else DOWN
            return True
    for i in p.loaded:
        mode = modes[p.mode + i]
        slides = mode[MODE] == UP or mode[MODE] == DOWN
        if slides and not reactions[p.reaction + i, 1] > 0.0:
            mode[MODE] = UNDEFINED_FRICTION
            return True
    return False


@kernel
def has_load_limit(modes, p):
    """True if any motion is stuck."""
    for i in range(p.each.size):
        if modes[p.mode + i, MODE] == STUCK:
            return True
    return False


@root
def recheck_after_impact(y, modes, bodies, p):
    """Test dry friction again, after velocities have jumped. It bears no impulse, because it is
    finite: a stuck motion slides if it moves."""
    n = bodies.active.size
    for i in range(p.each.size):
        if p.each[i].static >= 0.0:
            u = y[n + p.each[i].coordinate]
            modes[p.mode + i, MODE] = UP if u > REST_RATE else DOWN if u < -REST_RATE else STUCK


@kernel
def output_count(p):
    """Number of the outputs of a motion: more if friction of any motion depends on its load."""
    return LOADED_MOTION_OUTPUTS if p.loaded.size > 0 else JOINT_MOTION_OUTPUTS


@root
def write_outputs(y, modes, bodies, p, reactions, out):
    """Write rows of `output_count` of all motions to ``out``: q, u and f; of a ball the rotation
    vector. If friction of any depends on its load, of all their friction and W as well."""
    n = bodies.active.size
    tree = bodies.tree
    width = output_count(p)
    for i in range(p.each.size):
        joint_motion = p.each[i]
        q = y[joint_motion.coordinate]
        u = y[n + joint_motion.coordinate]
        mode = modes[p.mode + i]
        force = _acting_force(joint_motion, mode, q, u)
        reaction = reactions[p.reaction + i]
        if mode[MODE] == STUCK or joint_motion.kinetic_coefficient > 0.0:
            force += reaction[0]
        if tree.moves[joint_motion.move].kind == BALL and bodies.exact:
            j = joint_motion.coordinate - joint_motion.axis
            s = (0.25 * y[j], 0.25 * y[j + 1], 0.25 * y[j + 2])
            chosen = (
                1.0 * (joint_motion.axis == 0),
                1.0 * (joint_motion.axis == 1),
                1.0 * (joint_motion.axis == 2),
            )
            q = dot(rotation_vector(quaternion_of_parameters(s)), chosen)
        out[width * i + MOTION_POSITION] = q
        out[width * i + MOTION_RATE] = u
        out[width * i + MOTION_FORCE] = force
        if width == LOADED_MOTION_OUTPUTS:
            load = 0.0
            if joint_motion.kinetic_coefficient > 0.0 and mode[MODE] == STUCK:
                load = reaction[1] / joint_motion.static_coefficient
            elif joint_motion.kinetic_coefficient > 0.0:
                load = abs(reaction[0]) / joint_motion.kinetic_coefficient
            out[width * i + MOTION_FRICTION] = reaction[0] + _friction_force(
                joint_motion, mode[MODE]
            )
            out[width * i + MOTION_LOAD] = load


class JointMotionKind(kinds.KindWithModeSets):
    unit = "joint_motion"
    variables: ClassVar[Mapping[str, kinds.Variable]] = {
        "joint_position": kinds.Variable(
            "displacement in a joint, zero at rest",
            "m or rad",
            chart=kinds.ChartHint("Motions of joints", "joint motion", kinds.Topic.JOINTS),
            summary=[
                kinds.SummaryColumn(figure, figure)
                for figure in ("mean", "std", "smallest", "largest", "at the end")
            ],
            row_label="joint",
        ),
        "joint_velocity": kinds.Variable(
            "rate of the displacement in a joint",
            "m/s or rad/s",
            chart=kinds.ChartHint("Rates of joints", "joint rate", kinds.Topic.DETAILS + 11),
        ),
        "joint_motion_force": kinds.Variable(
            "force or moment of spring, damping, stops and friction of a joint on its body",
            "N or N m",
            chart=kinds.ChartHint(
                "Springs, damping, stops and friction in joints",
                "spring, damping, stops and friction",
                kinds.Topic.DETAILS + 12,
            ),
        ),
        "joint_friction": kinds.Variable(
            "dry friction in a joint on its body, that at rest included", "N or N m"
        ),
        "joint_friction_load": kinds.Variable(
            "load of the bearings of a joint that its friction grows with", "N or N m"
        ),
        "joint_motion_mode": kinds.Variable(
            "mode of the friction in a joint", "1", flags=" ".join(FRICTION_MODES)
        ),
        "joint_motion_segment": kinds.Variable(
            "mode of the end stops of a joint", "1", flags=" ".join(STOPS)
        ),
    }

    def unit_names(self, scene: Scene) -> list[str]:
        return [f"{name} {m.name}" for name, j in tree_joints(scene).items() for m in j.motions]

    def modes(self, p: JointMotionConstants) -> kinds.ModeRows:
        count = p.each.size
        return kinds.ModeRows(
            count, first=np.zeros(count, dtype=int), last=np.full(count, stop.ABOVE)
        )

    def resistances(self, p: JointMotionConstants) -> Iterator[kinds.LinearResistance]:
        for joint_motion in p.each:
            if joint_motion["row"] != NO_INDEX:
                B = np.array([[joint_motion["damping"]]])
                yield kinds.LinearResistance(
                    joint_motion["row"], NO_INDEX, B, np.zeros(1), int(joint_motion["coordinate"])
                )

    def mode_sets(self, p: JointMotionConstants) -> Sequence[kinds.ModeSet]:
        if not _has_stops(p).any():
            return []
        rest = np.zeros(p.each.size, dtype=int)
        return [
            kinds.ModeSet("joints away from their stops", kinds.rest_at_first(rest, NO_FRICTION)),
            kinds.ModeSet(
                "joints at their stops", kinds.rest_at_first(rest + stop.AT_LOWEST, NO_FRICTION)
            ),
        ]

    def moved_onto_segment(
        self, p: JointMotionConstants, modes: np.ndarray, bodies: Any, motion: Any, y: np.ndarray
    ) -> JointMotionConstants:
        """Constants with the stops of pressed motions in action at any place, and no friction."""
        constants = p.each.copy()
        stops = constants["stops"]
        at = modes[:, SEGMENT] != stop.AWAY
        constants["stiffness"] += np.where(at, stops["stiffness"], 0.0)
        constants["damping"] += np.where(at, stops["damping"], 0.0)
        stops[:] = 0.0
        return p._replace(each=constants)

    def record(
        self, p: JointMotionConstants, bodies: Any, unit_record: kinds.UnitRecord
    ) -> kinds.Columns:
        dims = ("time", self.unit)
        columns: dict[str, tuple[tuple[str, ...], np.ndarray]] = {
            "joint_position": (dims, unit_record.observed[:, :, MOTION_POSITION]),
            "joint_velocity": (dims, unit_record.observed[:, :, MOTION_RATE]),
            "joint_motion_force": (dims, unit_record.observed[:, :, MOTION_FORCE]),
            "joint_motion_mode": (dims, unit_record.modes[:, :, MODE].astype(np.int8)),
            "joint_motion_segment": (dims, unit_record.modes[:, :, SEGMENT].astype(np.int8)),
        }
        if p.loaded.size:
            columns["joint_friction"] = dims, unit_record.observed[:, :, MOTION_FRICTION]
            columns["joint_friction_load"] = dims, unit_record.observed[:, :, MOTION_LOAD]
        return columns

    def undefined_units(
        self, p: JointMotionConstants, modes: np.ndarray
    ) -> Iterator[tuple[int, str]]:
        for i in np.flatnonzero(modes[:, MODE] == UNDEFINED_FRICTION).tolist():
            yield (
                i,
                f"with a kinetic_coefficient of {p.each[i]['kinetic_coefficient']:g} its friction"
                " loads the bearings that cause it so much that no friction balances, or several"
                " do (Painleve). A longer guide_length or bearing_distance, a smaller coefficient,"
                " or forces and a centre of gravity nearer to the joint prevent that",
            )


JOINT_MOTION_KIND = JointMotionKind("joint_motions", (), compile_elements)
