"""Triggers: start and end of the action of elements, pumps and joints, by channels they watch.

A trigger waits for its ``start``, acts, waits for its ``end`` and acts no more. Each is a time, or
a condition that a channel has been above or below a value for a duration. Both are events. A start
or an end does not occur twice.

When a contact becomes active, it is in contact at once if it is pressed, with its friction
unloaded. A line becomes as taut as its length gives. Their stored energy then comes from outside,
and is booked as a negative loss. The wall of a landing that becomes active catches a pin that is
inside it. Energy stored in an element when it ends is lost.

Channels that a condition may refer to.

    position.BODY.DOF, velocity.BODY.DOF    of the centre of gravity; angles
    speed.BODY                              horizontal, of the centre of gravity
    fender_normal_force.NAME                of a contact point, or the sum over an element
    fender_compression.POINT                of a contact point
    spring_tension.NAME                     of a spring
    line_tension.NAME                       of a catenary, at its fairlead
    strut_force.NAME, strut_length.NAME     of a strut or power take-off; tension is positive
    winch_tension.NAME, winch_length.NAME   of a winch; the length off its drum without load
    torsion_angle.NAME                      of a torsion spring or rotary power take-off
    tank_level.TANK of BODY                 above the bottom of a tank that is pumped
    clearance.NAME                          of a named point from another, or from a plane
    relative_speed.POINT to POINT           of two named points, "eye of a to eye of b"

The names are those in the result of a run.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import permutations
from math import hypot, inf, sqrt
from typing import Any, ClassVar, NamedTuple

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.elements import bushing
from hydrosim.elements.contact import geometry, landing, transitions
from hydrosim.elements.contact.fender import normal_load_of
from hydrosim.elements.contact.geometry import EARTH
from hydrosim.elements.joint import locks
from hydrosim.elements.kind import (
    Columns,
    KindWithModeSets,
    Layout,
    ModeRows,
    ModeSet,
    StateBlocks,
    UnitRecord,
    Variable,
    constraint_names,
    rest_at_first,
    unit_ranges,
)
from hydrosim.elements.line import catenary, winch
from hydrosim.elements.line.catenary import Catenary
from hydrosim.elements.line.winch import Winch
from hydrosim.elements.link import table as links
from hydrosim.elements.link.law import Link
from hydrosim.errors import InputError
from hydrosim.jit.kernels import clear, kernel, root
from hydrosim.modes import CONTACT_MARGIN, FRICTION_MARGIN, MARGINS, MODE, NO_INDEX, RISING
from hydrosim.multibody.kinematics import attachment, point_velocity
from hydrosim.multibody.vectors import dot, matvec, sub, vector
from hydrosim.scene import Active, Clearance, ForceElement, Scene, When
from hydrosim.scene.contacts import Contact
from hydrosim.scene.links import Spring, Strut, TorsionSpring
from hydrosim.scene.restraints import Bushing
from hydrosim.tanks import contents, pumping
from hydrosim.tanks.contents import flow_names, triggered_pumps

(
    POSITION,
    VELOCITY,
    HORIZONTAL_SPEED,
    NORMAL_FORCE,
    COMPRESSION,
    LINK_LOAD,
    LINK_PLACE,
    TANK_LEVEL,
) = range(8)
CLEARANCE, RELATIVE_SPEED, LINE_TENSION, WINCH_TENSION, WINCH_LENGTH = 8, 9, 10, 11, 12
CHANNEL_KINDS = {
    "position": POSITION,
    "velocity": VELOCITY,
    "speed": HORIZONTAL_SPEED,
    "fender_normal_force": NORMAL_FORCE,
    "fender_compression": COMPRESSION,
    "spring_tension": LINK_LOAD,
    "line_tension": LINE_TENSION,
    "strut_force": LINK_LOAD,
    "strut_length": LINK_PLACE,
    "winch_tension": WINCH_TENSION,
    "winch_length": WINCH_LENGTH,
    "torsion_angle": LINK_PLACE,
    "tank_level": TANK_LEVEL,
    "clearance": CLEARANCE,
    "relative_speed": RELATIVE_SPEED,
}
CHANNEL_CLASSES: dict[str, tuple[type[ForceElement], Any]] = {
    "fender_normal_force": (Contact, Contact),
    "fender_compression": (Contact, Contact),
    "spring_tension": (Link, Spring),
    "line_tension": (Catenary, Catenary),
    "strut_force": (Link, Strut),
    "strut_length": (Link, Strut),
    "torsion_angle": (Link, TorsionSpring),
    "winch_tension": (Winch, Winch),
    "winch_length": (Winch, Winch),
}
"""Of kinds that belong to units: the elements among which these units are numbered, and those that
have the channel."""
CHANNEL = np.dtype([("kind", int), ("first", int), ("end", int)])
"""A channel: its kind and its entries, points, links or tanks with ``first`` <= i <
``end``; two named points for a relative speed."""

GAP = np.dtype(
    [
        *(("body", int), ("point", float, 3), ("to", int), ("other", float, 3)),
        *(("plane", bool), ("normal", float, 3)),
    ]
)
"""A clearance: its point on a body; a point of the other body (`EARTH`: of the earth), and the unit
normal there if it is that of a ``plane``."""
NAMED_POINT = np.dtype([("body", int), ("place", float, 3)])
"""A named point of a body."""
TO = " to "  # between two points


def compile_points(layout: Layout) -> np.ndarray:
    """All named points of a scene, (n,) of `NAMED_POINT`."""
    return np.array([*layout.points.values()], dtype=NAMED_POINT)


def compile_clearances(layout: Layout) -> np.ndarray:
    """All clearances of a scene, (n,) of `GAP`."""
    return np.array([_clearance_row(c, layout) for c in layout.clearances.values()], dtype=GAP)


def _clearance_row(c: Clearance, layout: Layout) -> tuple[Any, ...]:
    body, point = layout.points[c.of]
    if c.to is not None:
        other, place = layout.points[c.to]
        return body, point, other, place, False, (0.0, 0.0, 0.0)
    assert c.plane is not None
    normal = np.array(c.plane.normal, float) / np.linalg.norm(c.plane.normal)
    other = EARTH if c.plane.body is None else layout.body[c.plane.body]
    return body, point, other, c.plane.point, True, normal


@kernel
def clearance(gap, bodies, motion):
    """Present value of a clearance [m]."""
    d, _ = attachment(gap.body, vector(gap.point, 0), bodies, motion)
    normal = vector(gap.normal, 0)
    other = vector(gap.other, 0)
    if gap.to != EARTH:
        other, _ = attachment(gap.to, other, bodies, motion)
        normal = matvec(motion.rotation[gap.to], normal)
    d = sub(d, other)
    return dot(d, normal) if gap.plane else sqrt(dot(d, d))


@kernel
def relative_speed(first, second, bodies, motion):
    """Present relative speed of two named points [m/s]."""
    _, arm = attachment(first.body, vector(first.place, 0), bodies, motion)
    v = point_velocity(first.body, arm, motion)
    _, arm = attachment(second.body, vector(second.place, 0), bodies, motion)
    v = sub(v, point_velocity(second.body, arm, motion))
    return sqrt(dot(v, v))


def compile_channel(
    name: str, elements: Mapping[str, ForceElement], layout: Layout
) -> tuple[int, int, int]:
    """Values of `CHANNEL`; raises InputError if there is no such channel."""
    kind, _, of = name.partition(".")
    channel_range = _channel_range(kind, elements, layout)
    if of not in channel_range:
        there = ", ".join(channel_range) or "nothing in this scene"
        expected = (
            f"one of {', '.join(CHANNEL_KINDS)}"
            if kind not in CHANNEL_KINDS
            else f"{kind}. and {there}"
        )
        raise InputError(f"channel: found {name}; expected {expected}.")
    return CHANNEL_KINDS[kind], *channel_range[of]


def _channel_range(
    kind: str, elements: Mapping[str, ForceElement], layout: Layout
) -> dict[str, tuple[int, int]]:
    """Names that a channel of a kind may have, with their entries."""
    body = layout.body
    if kind == "clearance":
        return {name: (k, k + 1) for k, name in enumerate(layout.clearances)}
    if kind == "relative_speed":
        names = enumerate(layout.points)
        return {f"{a}{TO}{b}": (i, j) for (i, a), (j, b) in permutations(names, 2)}
    if kind == "tank_level":
        return {name: (k, k + 1) for k, name in enumerate(layout.tank_names)}
    if kind in ("position", "velocity"):
        pairs = (
            (f"{name}.{dof}", 6 * b + j) for name, b in body.items() for j, dof in enumerate(DOFS)
        )
        return {name: (k, k + 1) for name, k in pairs}
    if kind == "speed":
        return {name: (6 * b, 6 * b + 2) for name, b in body.items()}
    if kind not in CHANNEL_CLASSES:
        return {}
    among, classes = CHANNEL_CLASSES[kind]
    every = unit_ranges(order_units(elements), among)
    units = {name: place for name, place in every.items() if isinstance(elements[name], classes)}
    unit_indices = {
        unit: (k, k + 1)
        for name, (first, _) in units.items()
        for k, unit in enumerate(elements[name].unit_names(name), first)
    }
    return unit_indices | (units if kind == "fender_normal_force" else {})


@kernel
def channel_value(channel, t, y, modes, motion, bodies, elements, tanks):
    """Present value of a channel."""
    k = channel.first
    fenders = elements.fenders
    if channel.kind == POSITION:
        return motion.coordinates[k]
    if channel.kind == VELOCITY:
        return motion.velocity[k]
    if channel.kind == HORIZONTAL_SPEED:
        return hypot(motion.velocity[k], motion.velocity[k + 1])
    if channel.kind == LINE_TENSION:
        return catenary.tension_of(k, t, y, modes, motion, bodies, elements.catenaries)
    if channel.kind == WINCH_TENSION:
        return winch.kinematics(k, t, y, modes, motion, bodies, elements.winches).tension
    if channel.kind == WINCH_LENGTH:
        return winch.kinematics(k, t, y, modes, motion, bodies, elements.winches).length
    if channel.kind == LINK_LOAD:
        return links.find_load(k, t, y, modes, motion, bodies, elements.link_table)
    if channel.kind == LINK_PLACE:
        return links.find_place(k, t, y, modes, motion, bodies, elements.link_table)
    if channel.kind == COMPRESSION:
        return geometry.contact_kinematics(fenders.points[k], bodies, motion).compression
    if channel.kind == CLEARANCE:
        return clearance(elements.triggers.gaps[k], bodies, motion)
    if channel.kind == RELATIVE_SPEED:
        points = elements.triggers.points
        return relative_speed(points[k], points[channel.end], bodies, motion)
    if channel.kind == TANK_LEVEL:
        return contents.level(k, y, tanks) if tanks.each.size > 0 else 0.0
    total = 0.0
    for i in range(k, channel.end):
        contact = geometry.contact_kinematics(fenders.points[i], bodies, motion)
        total += normal_load_of(i, t, y, modes, contact, fenders).N
    return total


TRIGGER_STATE_NAMES = ("time last met",)
"""State of each trigger: time at which its condition was last met [s]."""
BEFORE, DURING, AFTER = range(3)
"""Modes of a trigger; the column `RISING` is 1 while the condition of its channel is met."""
CONDITION = np.dtype(
    [
        *(("time", float), ("watches", bool), ("channel", CHANNEL)),
        *(("sign", float), ("value", float), ("lasting", float)),
    ]
)
TRIGGER = np.dtype(
    [
        *(("row", int), ("start", CONDITION), ("end", CONDITION)),
        *(("point", int), ("points", int)),
        *(("link", int), ("links", int), ("bushing", int), ("bushings", int)),
        *(("catenary", int), ("catenaries", int), ("winch", int), ("winches", int)),
        *(("flow", int), ("lock", int)),
    ]
)
"""A trigger: the row of forces of its element, both conditions, and its own contact points,
links, bushings, catenaries and winches, ``points`` from ``point`` on; or its
flow or joint, else `NO_INDEX`."""
NO_UNITS = (0,) * 10


class TriggerConstants(NamedTuple):
    """The triggers ``each`` (n,) of `TRIGGER`, and what they may watch: clearances ``gaps`` and
    named ``points``; the first of their states in y and of their rows of modes, and of the
    integrals of losses in y, row by row."""

    each: np.ndarray
    gaps: np.ndarray
    points: np.ndarray
    state: int
    mode: int
    losses: int


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> TriggerConstants:
    """Constants of the triggers of ``elements``, in their order, followed by those of pumps and of
    joints."""
    kinds = (Contact, Link, Bushing, Catenary, Winch)
    ordered = order_units(elements)
    ranges = [unit_ranges(ordered, kind) for kind in kinds]
    rows: list[Any] = []
    for name, element in elements.items():
        if element.active is None:
            continue
        key = f"forces.{name}.active"
        element_ranges = (of.get(name, (0, 0)) for of in ranges)
        ends = _compile_conditions(key, element.active, elements, layout)
        rows.append(
            (
                layout.row[name],
                *ends,
                *(x for a, b in element_ranges for x in (a, b - a)),
                NO_INDEX,
                NO_INDEX,
            )
        )
    for pump in layout.pumps:
        ends = _compile_conditions(pump.key, pump.active, elements, layout)
        rows.append((layout.flow, *ends, *NO_UNITS, pump.flow, NO_INDEX))
    for lock, name in enumerate(layout.constraints):
        active = layout.joints[name].active
        if active is not None:
            ends = _compile_conditions(f"joints.{name}.active", active, elements, layout)
            rows.append((layout.joint_row, *ends, *NO_UNITS, NO_INDEX, lock))
    return TriggerConstants(
        np.array(rows, dtype=TRIGGER), compile_clearances(layout), compile_points(layout), 0, 0, 0
    )


def order_units(elements: Mapping[str, ForceElement]) -> dict[str, ForceElement]:
    """The elements in the order in which units are numbered: links as in their table."""
    others = {name: e for name, e in elements.items() if not isinstance(e, Link)}
    return {**others, **links.order_links(elements)}


def _compile_conditions(
    key: str, active: Active, elements: Mapping[str, ForceElement], layout: Layout
) -> tuple[Any, Any]:
    """The conditions of the start and of the end."""
    start = active.start or When(time=-inf)
    until = active.until or When(time=inf)
    try:
        return _compile_condition(start, elements, layout), _compile_condition(
            until, elements, layout
        )
    except InputError as error:
        raise InputError(f"{key}: {error}") from None


def _compile_condition(
    when: When, elements: Mapping[str, ForceElement], layout: Layout
) -> tuple[Any, ...]:
    if when.channel is None:
        return when.time, False, (0, 0, 0), 1.0, 0.0, 0.0
    channel = compile_channel(when.channel, elements, layout)
    above = when.above is not None
    value = when.above if when.above is not None else when.below
    return 0.0, True, channel, 1.0 if above else -1.0, value, when.lasting


@kernel
def condition_excess(condition, t, y, modes, motion, bodies, elements, tanks):
    """Amount by which a condition exceeds its time or value."""
    if not condition.watches:
        return t - condition.time
    value = channel_value(condition.channel, t, y, modes, motion, bodies, elements, tanks)
    return condition.sign * (value - condition.value)


@root
def find_margins(t, y, modes, motion, bodies, elements, tanks, out):
    """Margins of all triggers into ``out``: distance to the condition or, if it is met, to leaving
    it, and the remaining duration."""
    p = elements.triggers
    for j in range(p.each.size):
        mode = modes[p.mode + j]
        m = MARGINS * (p.mode + j)
        for k in range(MARGINS):
            out[m + k] = 1.0
        if mode[MODE] == AFTER:
            continue
        condition = p.each[j].start if mode[MODE] == BEFORE else p.each[j].end
        if not condition.watches and condition.time == inf:
            continue
        ahead = condition_excess(condition, t, y, modes, motion, bodies, elements, tanks)
        out[m + CONTACT_MARGIN] = ahead if mode[RISING] == 1 else -ahead
        if mode[RISING] == 1:
            out[m + FRICTION_MARGIN] = y[p.state + j] + condition.lasting - t


@root
def transition(j, which, t, y, modes, motion, bodies, elements, tanks):
    """Update trigger ``j`` after one of its margins has reached zero."""
    p = elements.triggers
    mode = modes[p.mode + j]
    trigger = p.each[j]
    condition = trigger.start if mode[MODE] == BEFORE else trigger.end
    if which == CONTACT_MARGIN and mode[RISING] == 1:
        mode[RISING] = 0
    elif which == CONTACT_MARGIN and condition.lasting > 0.0:
        mode[RISING] = 1
        y[p.state + j] = t
    else:
        mode[MODE] = mode[MODE] + 1
        mode[RISING] = 0
        apply_switch(j, t, y, modes, motion, bodies, elements, tanks)


@kernel
def apply_switch(j, t, y, modes, motion, bodies, elements, tanks):
    """Activate or deactivate the contacts and lines of trigger ``j``; switch its flow."""
    trigger = elements.triggers.each[j]
    fenders = elements.fenders
    stage = modes[elements.triggers.mode + j, MODE]
    now = stage == DURING
    if trigger.flow != NO_INDEX:
        pumping.follow_trigger(trigger.flow, stage, y, modes, tanks)
    if trigger.lock != NO_INDEX:
        if now:
            locks.activate(trigger.lock, y, modes, motion, bodies, elements.locks)
        else:
            locks.deactivate(trigger.lock, modes, elements.locks)
    for i in range(trigger.point, trigger.point + trigger.points):
        if now:
            transitions.activate(i, t, y, modes, motion, bodies, fenders)
        else:
            transitions.deactivate(i, t, y, modes, motion, bodies, fenders)
    for i in range(elements.guides.pins.size):
        if not _has_point(elements.guides.pins[i].point, trigger):
            continue
        if now:
            landing.activate(i, modes, motion, bodies, elements)
        else:
            landing.deactivate(i, y, modes, motion, bodies, elements)
    for i in range(trigger.link, trigger.link + trigger.links):
        if now:
            links.activate(i, t, y, modes, motion, bodies, elements.link_table)
        else:
            links.deactivate(i, modes, elements.link_table)
    for i in range(trigger.bushing, trigger.bushing + trigger.bushings):
        if now:
            bushing.activate(i, modes, motion, bodies, elements.bushings)
        else:
            bushing.deactivate(i, modes, elements.bushings)
    for i in range(trigger.catenary, trigger.catenary + trigger.catenaries):
        if now:
            catenary.set_initial_mode(i, t, y, modes, motion, bodies, elements.catenaries)
        else:
            catenary.deactivate(i, modes, elements.catenaries)
    for i in range(trigger.winch, trigger.winch + trigger.winches):
        if now:
            winch.activate_in_run(i, t, y, modes, motion, bodies, elements.winches)
        else:
            winch.deactivate(i, y, modes, elements.winches)


@kernel
def _has_point(point, trigger):
    """True if a contact point belongs to the element of a trigger."""
    return trigger.point <= point < trigger.point + trigger.points


@root
def set_initial_modes(t, y, modes, motion, bodies, elements, tanks):
    """Modes of all triggers for a start; inactive contacts and lines are deactivated."""
    p = elements.triggers
    for j in range(p.each.size):
        mode = modes[p.mode + j]
        mode[MODE] = BEFORE
        mode[RISING] = 0
        for stage in range(AFTER):
            condition = p.each[j].start if stage == BEFORE else p.each[j].end
            there = condition_excess(condition, t, y, modes, motion, bodies, elements, tanks) >= 0.0
            if mode[MODE] == stage and there and condition.lasting == 0.0:
                mode[MODE] = stage + 1
            elif mode[MODE] == stage and there:
                mode[RISING] = 1
                y[p.state + j] = t
        if mode[MODE] != DURING:
            for i in range(elements.guides.pins.size):
                if _has_point(elements.guides.pins[i].point, p.each[j]):
                    landing.start_inactive(i, modes, elements.guides)
            apply_switch(j, t, y, modes, motion, bodies, elements, tanks)
            for i in range(p.each[j].point, p.each[j].point + p.each[j].points):
                transitions.reset_losses(i, y, elements.fenders)


@kernel
def is_on(j, modes, p):
    """True if trigger ``j`` acts."""
    return modes[p.mode + j, MODE] == DURING


@root
def clear_inactive(modes, p, wrench, rate):
    """Clear the rows of forces, and of work or dissipation, of inactive elements."""
    for j in range(p.each.size):
        acts_alone = p.each[j].flow == NO_INDEX and p.each[j].lock == NO_INDEX
        if acts_alone and not is_on(j, modes, p):
            clear(wrench[p.each[j].row])
            rate[p.each[j].row] = 0.0


@root
def clear_inactive_energy(modes, p, stored):
    """Clear the energy stored in inactive elements that have no modes of their own."""
    for j in range(p.each.size):
        trigger = p.each[j]
        has_no_modes = trigger.points == 0 and trigger.lock == NO_INDEX
        if has_no_modes and not is_on(j, modes, p):
            stored[trigger.row] = 0.0


class TriggerKind(KindWithModeSets):
    unit = "trigger"
    variables: ClassVar = {
        "trigger_stage": Variable(
            "before, during or after the time in which an element acts",
            "1",
            flags="before during after",
        ),
        "trigger_waits": Variable("1 while the condition of the trigger is met", "1"),
    }

    def unit_names(self, scene: Scene) -> list[str]:
        """Names of the elements that are active for a limited time, of pumps that wait for events,
        and of joints that are active for a limited time."""
        named = [name for name, element in scene.forces.items() if element.active is not None]
        flows = flow_names(scene)
        held = [name for name in constraint_names(scene) if scene.joints[name].active is not None]
        return [*named, *(flows[pump.flow] for pump in triggered_pumps(scene)), *held]

    def modes(self, p: TriggerConstants) -> ModeRows:
        return ModeRows(p.each.size, "stage", "waits")

    def states(self, p: TriggerConstants, scene: Scene) -> Iterator[StateBlocks]:
        yield StateBlocks("trigger", self.unit_names(scene), TRIGGER_STATE_NAMES)

    def mode_sets(self, p: TriggerConstants) -> Sequence[ModeSet]:
        """The posture in which all elements act."""
        return [ModeSet("", rest_at_first(np.zeros(p.each.size), DURING))]

    def record(self, p: TriggerConstants, bodies: Any, unit_record: UnitRecord) -> Columns:
        return {
            "trigger_stage": (("time", "trigger"), unit_record.modes[:, :, MODE].astype(np.int8))
        }


TRIGGER_KIND = TriggerKind("triggers", (), compile_elements)
