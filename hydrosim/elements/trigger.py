"""Triggers: start and end of the action of elements, pumps and joints, by channels they watch.

A trigger waits for its ``start``, acts, waits for its ``end`` and acts no more. Each is a time, or
a condition that a channel has been above or below a value for a duration. Both are events. A start
or an end does not occur twice.

When a contact becomes active, it is in contact at once if it is pressed, with its friction
unloaded. A line becomes as taut as its length gives. Their stored energy then comes from outside,
and is booked as a negative loss. The wall of a landing that becomes active catches a pin that is
inside it. Energy stored in an element when it ends is lost.

`hydrosim.elements.channel` lists the channels that a condition may refer to.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import inf
from typing import Any, ClassVar, NamedTuple

import numpy as np

from hydrosim.elements import channel
from hydrosim.elements import kind as kinds
from hydrosim.errors import InputError
from hydrosim.jit.kernels import clear, kernel, root, root_giving
from hydrosim.modes import CONTACT_MARGIN, FRICTION_MARGIN, MARGINS, MODE, NO_INDEX, RISING
from hydrosim.scene import Active, ForceElement, Scene, When
from hydrosim.scene.contacts import Contact
from hydrosim.tanks.contents import flow_names, triggered_pumps

TRIGGER_STATE_NAMES = ("time last met",)
"""State of each trigger: time at which its condition was last met [s]."""
BEFORE, DURING, AFTER = range(3)
"""Modes of a trigger; the column `RISING` is 1 while the condition of its channel is met."""
CONDITION = np.dtype(
    [
        *(("time", float), ("watches", bool), ("channel", channel.CHANNEL)),
        *(("sign", float), ("value", float), ("lasting", float)),
    ]
)
TRIGGER = np.dtype(
    [
        *(("row", int), ("start", CONDITION), ("end", CONDITION)),
        *(("contact", bool), ("flow", int), ("lock", int)),
    ]
)
"""A trigger: the row of forces of its element, and both conditions; whether its element is a
contact, which books by itself what it had stored; or its flow or joint, else `NO_INDEX`."""


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


def compile_elements(
    elements: Mapping[str, ForceElement], layout: kinds.Layout
) -> TriggerConstants:
    """Constants of the triggers of ``elements``, in their order, followed by those of pumps and of
    joints."""
    rows: list[Any] = []
    for name, element in elements.items():
        if element.active is not None:
            ends = _compile_conditions(f"forces.{name}.active", element.active, elements, layout)
            contact = isinstance(element, Contact)
            rows.append((layout.row[name], *ends, contact, NO_INDEX, NO_INDEX))
    for pump in layout.pumps:
        ends = _compile_conditions(pump.key, pump.active, elements, layout)
        rows.append((layout.flow, *ends, False, pump.flow, NO_INDEX))
    for lock, name in enumerate(layout.constraints):
        active = layout.joints[name].active
        if active is not None:
            ends = _compile_conditions(f"joints.{name}.active", active, elements, layout)
            rows.append((layout.joint_row, *ends, False, NO_INDEX, lock))
    return TriggerConstants(
        np.array(rows, dtype=TRIGGER),
        channel.compile_clearances(layout),
        channel.compile_points(layout),
        0,
        0,
        0,
    )


def _compile_conditions(
    key: str, active: Active, elements: Mapping[str, ForceElement], layout: kinds.Layout
) -> tuple[Any, Any]:
    """The conditions of the start and of the end."""
    ends = (active.start or -inf, active.until or inf)
    try:
        start, until = (_compile_condition(end, elements, layout) for end in ends)
    except InputError as error:
        raise InputError(f"{key}: {error}") from None
    return start, until


def _compile_condition(
    when: When | float, elements: Mapping[str, ForceElement], layout: kinds.Layout
) -> tuple[Any, ...]:
    if isinstance(when, float) or when.channel is None:
        time = when if isinstance(when, float) else when.time
        return time, False, (0, 0, 0), 1.0, 0.0, 0.0
    watched = channel.compile_channel(when.channel, elements, layout)
    channel.check_unit(when, elements, layout)
    above = when.above is not None
    value = when.above if when.above is not None else when.below
    return 0.0, True, watched, 1.0 if above else -1.0, value, when.lasting


@kernel
def condition_excess(condition, t, y, modes, motion, bodies, elements, tanks):
    """Amount by which a condition exceeds its time or value."""
    if not condition.watches:
        return t - condition.time
    value = channel.channel_value(condition.channel, t, y, modes, motion, bodies, elements, tanks)
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


@root_giving(bool)
def transition(j, which, t, y, modes, p):
    """Update trigger ``j`` after one of its margins has reached zero; true if it switches its
    units."""
    mode = modes[p.mode + j]
    trigger = p.each[j]
    condition = trigger.start if mode[MODE] == BEFORE else trigger.end
    if which == CONTACT_MARGIN and mode[RISING] == 1:
        mode[RISING] = 0
        return False
    if which == CONTACT_MARGIN and condition.lasting > 0.0:
        mode[RISING] = 1
        y[p.state + j] = t
        return False
    mode[MODE] = mode[MODE] + 1
    mode[RISING] = 0
    return True


@root
def set_initial_mode(j, t, y, modes, motion, bodies, elements, tanks):
    """Mode of trigger ``j`` for a start."""
    p = elements.triggers
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
        clears = not trigger.contact and trigger.lock == NO_INDEX
        if clears and not is_on(j, modes, p):
            stored[trigger.row] = 0.0


class TriggerKind(kinds.KindWithModeSets):
    unit = "trigger"
    variables: ClassVar = {
        "trigger_stage": kinds.Variable(
            "before, during or after the time in which an element acts",
            "1",
            flags="before during after",
        ),
        "trigger_waits": kinds.Variable("1 while the condition of the trigger is met", "1"),
    }

    def unit_names(self, scene: Scene) -> list[str]:
        """Names of the elements that are active for a limited time, of pumps that wait for events,
        and of joints that are active for a limited time."""
        named = [name for name, element in scene.forces.items() if element.active is not None]
        flows = flow_names(scene)
        held = [
            name for name in kinds.constraint_names(scene) if scene.joints[name].active is not None
        ]
        return [*named, *(flows[pump.flow] for pump in triggered_pumps(scene)), *held]

    def modes(self, p: TriggerConstants) -> kinds.ModeRows:
        return kinds.ModeRows(p.each.size, "stage", "waits")

    def states(self, p: TriggerConstants, scene: Scene) -> Iterator[kinds.StateBlocks]:
        yield kinds.StateBlocks("trigger", self.unit_names(scene), TRIGGER_STATE_NAMES)

    def mode_sets(self, p: TriggerConstants) -> Sequence[kinds.ModeSet]:
        """The posture in which all elements act."""
        return [kinds.ModeSet("", kinds.rest_at_first(np.zeros(p.each.size), DURING))]

    def record(
        self, p: TriggerConstants, bodies: Any, unit_record: kinds.UnitRecord
    ) -> kinds.Columns:
        return {
            "trigger_stage": (("time", "trigger"), unit_record.modes[:, :, MODE].astype(np.int8))
        }


TRIGGER_KIND = TriggerKind("triggers", (), compile_elements)
