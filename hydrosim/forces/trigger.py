"""Triggers: start and end of the action of elements, pumps and joints.

A trigger waits for its ``start``, acts, waits for its ``end`` and acts no more. Each is a time, or
a condition that a channel has been above or below a value for a duration
(`hydrosim.forces.channels`). Both are events. A start or an end does not occur twice.

When a contact becomes active, it is in contact at once if it is pressed, with its friction
unloaded. A line becomes as taut as its length gives. Their stored energy then comes from outside,
and is booked as a negative loss. The wall of a landing that becomes active catches a pin that is
inside it. Energy stored in an element when it ends is lost.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from hydrosim.errors import InputError
from hydrosim.forces import bushing, link, spring
from hydrosim.forces.bushing import Bushing
from hydrosim.forces.channels import (
    CHANNEL,
    channel_value,
    compile_channel,
    compile_clearances,
    compile_points,
)
from hydrosim.forces.contact import guide, transitions
from hydrosim.forces.contact.fender import Contact
from hydrosim.forces.joint import locks
from hydrosim.forces.kind import Columns, ModeRows, StateBlocks, UnitRecord, Variable
from hydrosim.forces.layout import constraint_names, unit_ranges
from hydrosim.forces.line import catenary, compensator, winch
from hydrosim.forces.line.catenary import Catenary
from hydrosim.forces.line.compensator import Compensator
from hydrosim.forces.line.winch import Winch
from hydrosim.forces.link import Link
from hydrosim.forces.postures import KindWithModeSets, ModeSet, rest_at_first
from hydrosim.forces.spring import Spring
from hydrosim.jit.kernels import clear, kernel, root
from hydrosim.modes import CONTACT_MARGIN, FRICTION_MARGIN, MARGINS, MODE, NO_INDEX, RISING
from hydrosim.scene import Active, ForceElement, Scene, When
from hydrosim.tanks import pumping
from hydrosim.tanks.contents import flow_names
from hydrosim.tanks.events import triggered_pumps

if TYPE_CHECKING:
    from hydrosim.forces.layout import Layout

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
        *(("point", int), ("points", int), ("line", int), ("lines", int)),
        *(("link", int), ("links", int), ("bushing", int), ("bushings", int)),
        *(("catenary", int), ("catenaries", int)),
        *(("winch", int), ("winches", int), ("cylinder", int), ("cylinders", int)),
        *(("flow", int), ("lock", int)),
    ]
)
"""A trigger: the row of forces of its element, both conditions, and its own contact points,
springs, links, bushings, catenaries, winches and compensators, ``points`` from ``point`` on; or its
flow or joint, else `NO_INDEX`."""
NO_UNITS = (0,) * 14


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
    kinds = (Contact, Spring, Link, Bushing, Catenary, Winch, Compensator)
    ranges = [unit_ranges(elements, kind) for kind in kinds]
    rows: list[Any] = []
    for name, element in elements.items():
        if element.active is None:
            continue
        key = f"forces.{name}.active"
        own = (of.get(name, (0, 0)) for of in ranges)
        ends = _conditions(key, element.active, elements, layout)
        rows.append(
            (layout.row[name], *ends, *(x for a, b in own for x in (a, b - a)), NO_INDEX, NO_INDEX)
        )
    for pump in layout.pumps:
        ends = _conditions(pump.key, pump.active, elements, layout)
        rows.append((layout.flow, *ends, *NO_UNITS, pump.flow, NO_INDEX))
    for lock, name in enumerate(layout.constraints):
        active = layout.joints[name].active
        if active is not None:
            ends = _conditions(f"joints.{name}.active", active, elements, layout)
            rows.append((layout.joint_row, *ends, *NO_UNITS, NO_INDEX, lock))
    return TriggerConstants(
        np.array(rows, dtype=TRIGGER), compile_clearances(layout), compile_points(layout), 0, 0, 0
    )


def _conditions(
    key: str, active: Active, elements: Mapping[str, ForceElement], layout: Layout
) -> tuple[Any, Any]:
    """The conditions of the start and of the end."""
    start = active.start or When(time=-inf)
    until = active.until or When(time=inf)
    try:
        return _condition(start, elements, layout), _condition(until, elements, layout)
    except InputError as error:
        raise InputError(f"{key}: {error}") from None


def _condition(when: When, elements: Mapping[str, ForceElement], layout: Layout) -> tuple[Any, ...]:
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
    found = channel_value(condition.channel, t, y, modes, motion, bodies, elements, tanks)
    return condition.sign * (found - condition.value)


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
    springs = elements.springs
    stage = modes[elements.triggers.mode + j, MODE]
    now = stage == DURING
    if trigger.flow != NO_INDEX:
        pumping.turn(trigger.flow, stage, y, modes, tanks)
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
            guide.activate(i, modes, motion, bodies, elements)
        else:
            guide.deactivate(i, y, modes, motion, bodies, elements)
    for i in range(trigger.line, trigger.line + trigger.lines):
        if now:
            spring.set_initial_mode(i, t, modes, motion, bodies, springs)
        else:
            spring.deactivate(i, modes, springs)
    for i in range(trigger.link, trigger.link + trigger.links):
        if now:
            link.activate(i, modes, motion, bodies, elements.links)
        else:
            link.deactivate(i, modes, elements.links)
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
    for i in range(trigger.cylinder, trigger.cylinder + trigger.cylinders):
        if now:
            compensator.activate(i, modes, motion, bodies, elements.compensators)
        else:
            compensator.deactivate(i, modes, elements.compensators)


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
                    guide.start_inactive(i, modes, elements.guides)
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
        own = p.each[j].flow == NO_INDEX and p.each[j].lock == NO_INDEX
        if own and not is_on(j, modes, p):
            clear(wrench[p.each[j].row])
            rate[p.each[j].row] = 0.0


@root
def clear_inactive_energy(modes, p, stored):
    """Clear the energy stored in inactive elements that have no modes of their own."""
    for j in range(p.each.size):
        trigger = p.each[j]
        own = trigger.points + trigger.lines == 0 and trigger.lock == NO_INDEX
        if own and not is_on(j, modes, p):
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

    def record(self, p: TriggerConstants, bodies: Any, kept: UnitRecord) -> Columns:
        return {"trigger_stage": (("time", "trigger"), kept.modes[:, :, MODE].astype(np.int8))}


TRIGGER_KIND = TriggerKind("triggers", (), compile_elements)
