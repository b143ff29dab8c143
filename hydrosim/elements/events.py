"""Modes of all elements that have modes: their ends, their successors, and observed values.

Rows of modes belong to contact points, springs, compensators, other links, flows, bushings,
catenaries, guides, winches, joints, their motions and triggers, in this order. Every row has the
same number of margins, which are positive while its mode lasts.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np

from hydrosim.elements import bushing, drive, external, trigger
from hydrosim.elements.contact import fender, group, landing, transitions
from hydrosim.elements.contact.kind import add_tallies
from hydrosim.elements.contact.laws import COULOMB
from hydrosim.elements.joint import load_friction, locks, motions
from hydrosim.elements.kind import UNIT_ROW, UnitKind
from hydrosim.elements.line import catenary, winch
from hydrosim.elements.link import table as links
from hydrosim.jit.kernels import kernel, root, root_giving
from hydrosim.modes import MODE, NO_INDEX
from hydrosim.tanks import pumping
from hydrosim.water.wind import has_gusts

MAX_HELD_DIRECTIONS = 2  # most directions that a point of rigid friction holds
MAX_DEPENDENCIES = 2  # parts of y that margins of a row depend on


CONTACT_ROW, LINK_ROW, FLOW_ROW, BUSHING_ROW, CATENARY_ROW = range(5)
GUIDE_ROW, WINCH_ROW, LOCK_ROW, JOINT_MOTION_ROW, TRIGGER_ROW = range(5, 10)
ROW_KINDS = {
    "fenders": CONTACT_ROW,
    "link_table": LINK_ROW,
    "tanks": FLOW_ROW,
    "bushings": BUSHING_ROW,
    "catenaries": CATENARY_ROW,
    "guides": GUIDE_ROW,
    "winches": WINCH_ROW,
    "locks": LOCK_ROW,
    "joint_motions": JOINT_MOTION_ROW,
    "triggers": TRIGGER_ROW,
}
"""Numbers of the kinds of rows of modes in `UNIT_ROW`, by the field of their constants."""


def with_rows_and_outputs(elements: Any, kinds: Iterable[tuple[UnitKind, Any]]) -> Any:
    """The same elements with the rows of modes of their ``kinds``, which have these constants, and
    the places where the outputs of each kind begin."""
    rows = _compile_unit_rows(kinds, elements.triggers.each)
    return elements._replace(unit_rows=rows, output_starts=_find_output_starts(elements))


def _compile_unit_rows(kinds: Iterable[tuple[UnitKind, Any]], triggers: np.ndarray) -> np.ndarray:
    """All rows of modes (n,) of `UNIT_ROW`. A trigger owns those of its flow, of its joint, or of
    all units that act in the row of forces of its element."""
    counts: Counter[int] = Counter()
    blocks = [np.zeros(0, dtype=UNIT_ROW)]
    rows = [np.zeros(0, dtype=np.int64)]
    for kind, p in kinds:
        size = kind.modes(p).size
        number = ROW_KINDS[getattr(kind, "field", "tanks")]
        block = np.zeros(size, dtype=UNIT_ROW)
        block["kind"] = number
        block["unit"] = counts[number] + np.arange(size)
        block["trigger"] = NO_INDEX
        counts[number] += size
        blocks.append(block)
        rows.append(_force_rows(p, size))
    units, row = np.concatenate(blocks), np.concatenate(rows)
    for j, switch in enumerate(triggers):
        if switch["flow"] != NO_INDEX:
            owned = (units["kind"] == FLOW_ROW) & (units["unit"] == switch["flow"])
        elif switch["lock"] != NO_INDEX:
            owned = (units["kind"] == LOCK_ROW) & (units["unit"] == switch["lock"])
        else:
            owned = (row == switch["row"]) & (units["kind"] != TRIGGER_ROW)
        units["trigger"][owned] = j
    return units


def _force_rows(p: Any, size: int) -> np.ndarray:
    """The row of forces of each unit of a kind, `NO_INDEX` if its constants have none."""
    for table in p:
        if "row" in (getattr(getattr(table, "dtype", None), "names", None) or ()):
            return np.asarray(table["row"][:size], dtype=np.int64)
    return np.full(size, NO_INDEX)


class OutputStarts(NamedTuple):
    """The first of the outputs of each kind in the flat array of `write_outputs`, by the unit of
    kinds; those of links begin with springs."""

    spring: int
    bushing: int
    line: int
    guide: int
    winch: int
    joint: int
    joint_motion: int
    external: int
    drive: int


def _find_output_starts(elements: Any) -> OutputStarts:
    """The places where the outputs of each kind begin."""
    sizes = {unit: units * outputs for unit, (units, outputs) in output_shapes(elements).items()}
    starts = dict(zip(sizes, accumulate(sizes.values(), initial=0), strict=False))
    return OutputStarts(*(starts[unit] for unit in OutputStarts._fields))


def output_shapes(elements: Any) -> dict[str, tuple[int, int]]:
    """Shapes of the output of `write_outputs`, in its order, by the unit of kinds."""
    return {
        "fender": (elements.fenders.points.size, fender.CONTACT_OUTPUTS),
        **links.output_shapes(elements.link_table),
        "bushing": (elements.bushings.each.size, bushing.BUSHING_OUTPUTS),
        "line": (elements.catenaries.lines.size, catenary.CATENARY_OUTPUTS),
        "guide": (elements.guides.pins.size, landing.GUIDE_OUTPUTS),
        "winch": (elements.winches.each.size, winch.WINCH_OUTPUTS),
        "joint": (elements.locks.joints, 6),
        "joint_motion": (
            elements.joint_motions.each.size,
            motions.output_count(elements.joint_motions),
        ),
        "external": (elements.externals.delayed, external.EXTERNAL_OUTPUTS),
        "drive": (elements.drives.each.size, drive.DRIVE_OUTPUTS),
    }


@kernel
def write_outputs(t, y, modes, motion, bodies, elements, holds, wrench, out):
    """Write what a run records of fenders, springs, links, bushings, guides and joints, except the
    forces of elements, to ``out``. `output_shapes` gives the shapes that follow one another in the
    flat array ``out``. The forces of all elements are read from ``wrench`` (rows, 6 nb) [N, N
    m]."""
    e = elements
    at = e.output_starts
    if e.fenders.points.size > 0:
        fender.write_outputs(t, y, modes, motion, bodies, e.fenders, holds.reaction, out)
    if e.link_table.links.size > 0:
        links.write_outputs(t, y, modes, motion, bodies, e.link_table, out[at.spring :])
    if e.bushings.each.size > 0:
        bushing.write_outputs(modes, motion, bodies, e.bushings, out[at.bushing :])
    if e.catenaries.lines.size > 0:
        catenary.write_outputs(t, y, modes, motion, bodies, e.catenaries, out[at.line :])
    if e.guides.pins.size > 0:
        landing.write_outputs(modes, motion, bodies, e, out[at.guide :])
    if e.winches.each.size > 0:
        winch.write_outputs(t, y, modes, motion, bodies, e.winches, out[at.winch :])
    if e.locks.each.size > 0:
        locks.write_outputs(e.locks, holds, out[at.joint :])
    if e.joint_motions.each.size > 0:
        p = e.joint_motions
        motions.write_outputs(y, modes, bodies, p, holds.reaction, out[at.joint_motion :])
    if e.externals.delayed > 0:
        external.write_outputs(y, e.externals, out[at.external :])
    if e.drives.each.size > 0:
        drive.write_outputs(e.drives, holds, out[at.drive :])


@kernel
def motions_of_joints(elements):
    """Constants of the free motions of joints."""
    return elements.joint_motions


@kernel
def joint_output_start(elements):
    """Place of the loads of joints in the output of `write_outputs`."""
    return elements.output_starts.joint


@root
def set_initial_modes(t, y, modes, motion, bodies, elements, tanks):
    """Fill ``modes`` for a start from ``y``."""
    if elements.fenders.points.size > 0:
        transitions.set_initial_modes(t, y, modes, motion, bodies, elements.fenders)
    if elements.link_table.links.size > 0:
        links.set_initial_modes(t, y, modes, motion, bodies, elements.link_table)
    if tanks.flows.size > 0:
        pumping.set_initial_modes(t, modes, tanks)
    if elements.bushings.each.size > 0:
        bushing.set_initial_modes(modes, motion, bodies, elements.bushings)
    if elements.catenaries.lines.size > 0:
        catenary.set_initial_modes(t, y, modes, motion, bodies, elements.catenaries)
    if elements.guides.pins.size > 0:
        landing.set_initial_modes(modes, motion, bodies, elements)
    if elements.winches.each.size > 0:
        winch.set_initial_modes(t, y, modes, motion, bodies, elements.winches)
    if elements.locks.each.size > 0:
        locks.set_initial_modes(y, modes, motion, bodies, elements.locks)
    if elements.joint_motions.each.size > 0:
        motions.set_initial_modes(y, modes, bodies, elements.joint_motions)
    if elements.triggers.each.size > 0:
        switch_at_start(t, y, modes, motion, bodies, elements, tanks)
    group.initialise_groups(t, y, modes, elements.fenders)


@root
def switch_at_start(t, y, modes, motion, bodies, elements, tanks):
    """Modes of all triggers for a start. Units of those that do not act are inactive, and have
    lost and stored nothing."""
    p = elements.triggers
    for j in range(p.each.size):
        trigger.set_initial_mode(j, t, y, modes, motion, bodies, elements, tanks)
        if trigger.is_on(j, modes, p):
            continue
        for row in range(elements.unit_rows.size):
            unit = elements.unit_rows[row]
            if unit.trigger == j and unit.kind == GUIDE_ROW:
                landing.start_inactive(unit.unit, modes, elements.guides)
        switch_units(j, t, y, modes, motion, bodies, elements, tanks)
        for row in range(elements.unit_rows.size):
            unit = elements.unit_rows[row]
            if unit.trigger == j and unit.kind == CONTACT_ROW:
                transitions.reset_losses(unit.unit, y, elements.fenders)


@kernel
def find_margins(t, y, modes, motion, bodies, elements, tanks, headings, reactions, watched, out):
    """Margins of all rows of modes into ``out``; for contact points and lines only those that are
    ``watched``."""
    fenders = elements.fenders
    transitions.find_margins(
        t, y, modes, motion, bodies, fenders, headings, reactions, watched, out
    )
    if elements.link_table.links.size > 0:
        links.find_margins(t, y, modes, motion, bodies, elements.link_table, out)
    if tanks.flows.size > 0:
        pumping.find_margins(t, y, modes, tanks, out)
    if elements.bushings.each.size > 0:
        bushing.find_margins(modes, motion, bodies, elements.bushings, out)
    if elements.catenaries.lines.size > 0:
        catenary.find_margins(t, y, modes, motion, bodies, elements.catenaries, watched, out)
    if elements.guides.pins.size > 0:
        landing.find_margins(modes, motion, bodies, elements, out)
    if elements.winches.each.size > 0:
        winch.find_margins(t, y, modes, motion, bodies, elements.winches, out)
    if elements.locks.each.size > 0:
        locks.find_margins(y, modes, motion, bodies, elements.locks, reactions, out)
    if elements.joint_motions.each.size > 0:
        motions.find_margins(y, modes, bodies, elements.joint_motions, reactions, out)
    if elements.triggers.each.size > 0:
        trigger.find_margins(t, y, modes, motion, bodies, elements, tanks, out)


@kernel
def has_lines(elements):
    """True if kinks of lines may be passed, see `update_lines_at_step_end`."""
    return elements.catenaries.lines.size > 0


@kernel
def update_lines_at_step_end(t, y, modes, motion, bodies, elements, watched, out):
    """Guesses and margins of lines at the end of a step, and which of them are ``watched``."""
    catenary.update_at_step_end(t, y, modes, motion, bodies, elements.catenaries, watched, out)


@kernel
def find_slip_directions(t, y, modes, motion, bodies, elements, out):
    """Headings of all slipping contact points."""
    transitions.find_slip_directions(t, y, modes, motion, bodies, elements.fenders, out)


@kernel
def transition(row, which, size, step, t, y, modes, motion, bodies, elements, tanks, reactions):
    """Switch a row of modes to the next mode, after margin ``which``, of this ``size`` before or
    after, has reached zero. A node that relaxes in few steps of length ``step`` is settled only
    later."""
    kind = elements.unit_rows[row].kind
    i = elements.unit_rows[row].unit
    if kind == CONTACT_ROW:
        p = elements.fenders
        transitions.transition(i, which, size, step, t, y, modes, motion, bodies, reactions, p)
    elif kind == LINK_ROW:
        links.transition(i, which, t, y, modes, motion, bodies, elements.link_table)
    elif kind == FLOW_ROW:
        pumping.switch_flow(i, which, t, modes, tanks)
    elif kind == BUSHING_ROW:
        bushing.transition(i, modes, elements.bushings)
    elif kind == CATENARY_ROW:
        catenary.transition(i, t, y, modes, motion, bodies, elements.catenaries)
    elif kind == GUIDE_ROW:
        landing.transition(i, which, y, modes, motion, bodies, elements)
    elif kind == WINCH_ROW:
        winch.transition(i, which, t, y, modes, motion, bodies, elements.winches)
    elif kind == LOCK_ROW:
        locks.transition(i, which, y, modes, motion, bodies, elements.locks)
    elif kind == JOINT_MOTION_ROW:
        motions.transition(i, which, y, modes, bodies, reactions, elements.joint_motions)
    elif trigger.transition(i, which, t, y, modes, elements.triggers):
        switch_units(i, t, y, modes, motion, bodies, elements, tanks)


@root
def switch_units(trigger_number, t, y, modes, motion, bodies, elements, tanks):
    """Activate or deactivate the units of a trigger by its mode."""
    stage = modes[elements.triggers.mode + trigger_number, MODE]
    for row in range(elements.unit_rows.size):
        unit = elements.unit_rows[row]
        if unit.trigger == trigger_number and unit.kind == FLOW_ROW:
            pumping.follow_trigger(unit.unit, stage, y, modes, tanks)
        elif unit.trigger == trigger_number and stage == trigger.DURING:
            activate(unit, t, y, modes, motion, bodies, elements)
        elif unit.trigger == trigger_number:
            deactivate(unit, t, y, modes, motion, bodies, elements)


@kernel
def activate(unit, t, y, modes, motion, bodies, elements):
    """Let a ``unit`` act from now on."""
    i = unit.unit
    if unit.kind == CONTACT_ROW:
        transitions.activate(i, t, y, modes, motion, bodies, elements.fenders)
    elif unit.kind == LINK_ROW:
        links.activate(i, t, y, modes, motion, bodies, elements.link_table)
    elif unit.kind == BUSHING_ROW:
        bushing.activate(i, modes, motion, bodies, elements.bushings)
    elif unit.kind == CATENARY_ROW:
        catenary.set_initial_mode(i, t, y, modes, motion, bodies, elements.catenaries)
    elif unit.kind == GUIDE_ROW:
        landing.activate(i, modes, motion, bodies, elements)
    elif unit.kind == WINCH_ROW:
        winch.activate_in_run(i, t, y, modes, motion, bodies, elements.winches)
    elif unit.kind == LOCK_ROW:
        locks.activate(i, y, modes, motion, bodies, elements.locks)


@kernel
def deactivate(unit, t, y, modes, motion, bodies, elements):
    """End the action of a ``unit``."""
    i = unit.unit
    if unit.kind == CONTACT_ROW:
        transitions.deactivate(i, t, y, modes, motion, bodies, elements.fenders)
    elif unit.kind == LINK_ROW:
        links.deactivate(i, modes, elements.link_table)
    elif unit.kind == BUSHING_ROW:
        bushing.deactivate(i, modes, elements.bushings)
    elif unit.kind == CATENARY_ROW:
        catenary.deactivate(i, modes, elements.catenaries)
    elif unit.kind == GUIDE_ROW:
        landing.deactivate(i, y, modes, motion, bodies, elements)
    elif unit.kind == WINCH_ROW:
        winch.deactivate(i, y, modes, elements.winches)
    elif unit.kind == LOCK_ROW:
        locks.deactivate(i, modes, elements.locks)


@kernel
def is_trigger(row, elements):
    """True if a row of modes belongs to a trigger, which may change the energy stored in other
    elements."""
    return elements.unit_rows[row].kind == TRIGGER_ROW


@kernel
def book_stored(row, sign, y, stored, elements):
    """Count the energy ``stored`` (rows,) in the element of a trigger, with this ``sign``, as lost;
    contacts do this themselves."""
    switched = elements.triggers.each[elements.unit_rows[row].unit]
    if not switched.contact:
        y[elements.triggers.losses + switched.row] += sign * stored[switched.row]


@kernel
def guard_dependencies(row, part, elements, tanks):
    """Ranges (from, to) of entries of y, beyond coordinates and rates, that margins of a row depend
    on; `MAX_DEPENDENCIES` ranges."""
    kind = elements.unit_rows[row].kind
    i = elements.unit_rows[row].unit
    if tanks.flows.size > 0 and kind in (FLOW_ROW, TRIGGER_ROW):
        return tanks.state, tanks.state + tanks.each.size
    if kind == WINCH_ROW:
        return winch.guard_dependencies(i, part, elements.winches)
    if kind == CONTACT_ROW:
        return fender.guard_dependencies(i, part, elements.fenders)
    if kind == LINK_ROW and part == 0:
        return links.guard_dependencies(i, elements.link_table)
    if kind == LOCK_ROW and part == 0:
        return locks.guard_dependencies(i, elements.locks)
    return 0, 0


def count_reaction_rows(elements: Any) -> int:
    """Number of the points with directions of slip, or reactions of rigid friction; and of the
    joints, motions of joints and drives with reactions."""
    joints = elements.locks.each.size + elements.joint_motions.each.size
    return int(elements.fenders.points.size + joints + elements.drives.each.size)


@kernel
def add_tally_rates(t, y, modes, motion, bodies, elements, reactions, rates):
    """Rates of the integrals of units, if impulses are asked for."""
    add_tallies(t, y, modes, motion, bodies, elements.fenders, reactions, rates)


@kernel
def stores_step_values(elements):
    """True if any unit stores values that only single steps know."""
    if elements.catenaries.lines.size > 0 or elements.winches.each.size > 0:
        return True
    return elements.fenders.remembering > 0 or elements.fenders.groups.size > 0


@kernel
def record_largest(t, y, modes, motion, bodies, elements, watched):
    """Store values that only single steps know in y; lines ``watched`` have their modes."""
    if elements.catenaries.lines.size > 0:
        catenary.store_step_solutions(t, y, modes, motion, bodies, elements.catenaries, watched)
    transitions.record_largest(t, y, modes, motion, bodies, elements.fenders)
    if elements.winches.each.size > 0:
        winch.record_largest(t, y, modes, motion, bodies, elements.winches)


@kernel
def has_sampled_functions(elements):
    """True if any function is called once where each step ends."""
    return elements.externals.delayed > 0


@kernel
def sample_user_functions(t, jumped, ahead, y, motion, bodies, elements, wrench):
    """Call these functions; motions may have ``jumped``, and the next step is at most ``ahead``
    [s]. The rows of ``wrench`` are scratch. Returns false if one of them fails."""
    p = elements.externals
    return external.sample_user_functions(t, jumped, ahead, y, motion, bodies, p, wrench)


@kernel
def has_fast_transient(t, y, elements):
    """True if any unit still relaxes fast after an event."""
    return transitions.has_fast_transient(t, y, elements.fenders)


@root_giving(bool)
def has_load_limit(modes, elements):
    """True if a mode may end by a load that the motion does not show, because a unit holds still
    until its load reaches a limit."""
    if transitions.has_load_limit(modes, elements.fenders):
        return True
    if locks.has_load_limit(modes, elements.locks):
        return True
    return motions.has_load_limit(modes, elements.joint_motions)


def held_directions(elements: Any) -> int:
    """Largest number of rows of constraints that elements need."""
    rigid = MAX_HELD_DIRECTIONS * int((elements.fenders.points["law"] == COULOMB).sum())
    joints = int(elements.locks.rows) + int(elements.joint_motions.rows)
    return rigid + joints + drive_count(elements)


@kernel
def any_joints(elements):
    """True if any joint is a constraint."""
    return elements.locks.each.size > 0


@kernel
def joint_rows(elements):
    """Largest number of rows of constraints that joints and drives need."""
    return elements.locks.rows + elements.drives.each.size


def drive_count(elements: Any) -> int:
    """Number of the drives."""
    return int(elements.drives.each.size)


@kernel
def begin_drives(t, elements, holds):
    """Prepare drives for a step that begins at ``t``."""
    if elements.drives.each.size > 0:
        drive.begin_step(t, elements.drives, holds)


@kernel
def find_driven_motion(t, elements, holds):
    """Compute what drives prescribe at ``t``."""
    if elements.drives.each.size > 0:
        drive.set_motion(t, elements.drives, holds)


@kernel
def follow_drives(t, y, bodies, elements, holds):
    """Bring driven coordinates in ``y`` and their rates to the signals at ``t``."""
    if elements.drives.each.size > 0:
        drive.set_driven_states(t, y, bodies, elements.drives, holds)


@kernel
def add_drive_constraints(elements, constraints, holds):
    """Add the constraints of drives; returns their number."""
    if elements.drives.each.size > 0:
        drive.add_constraints(elements.drives, constraints, holds)
    return elements.drives.each.size


@kernel
def keep_driven_rates(y, bodies, elements, constraints):
    """Set the bounds of drives to the rates that they prescribe."""
    if elements.drives.each.size > 0:
        drive.keep_rates(y, bodies, elements.drives, constraints)


@kernel
def add_drive_power(y, bodies, elements, holds, rates):
    """Add the power of drives to the ``rates`` of the integrals of work."""
    if elements.drives.each.size > 0:
        drive.add_power(y, bodies, elements.drives, holds, rates)


@kernel
def book_drive_impulses(y, bodies, elements, constraints):
    """Book the work of the impulses of drives in a sudden change."""
    if elements.drives.each.size > 0:
        drive.book_impulses(y, bodies, elements.drives, constraints)


@kernel
def add_drive_impulses(y, motion, bodies, elements, constraints, holds, wrench, impulse, works):
    """Add the impulses of drives, and their works by coordinate, to the integrals of y."""
    if elements.drives.each.size > 0:
        p = elements.drives
        drive.add_impulses(y, motion, bodies, p, constraints, holds, wrench, impulse, works)


def joint_count(elements: Any) -> int:
    """Number of the joints that are constraints."""
    return int(elements.locks.each.size)


@kernel
def may_have_constraints(modes, elements, most):
    """True if any unit may hold bodies now; ``most`` is the largest number of constraints."""
    if elements.drives.each.size > 0:
        return True
    if elements.locks.each.size == 0:
        return most > 0
    return most > elements.locks.rows or locks.any_closed(modes, elements.locks)


@kernel
def clear_joint_reactions(elements, holds):
    """Set all reactions of joints to zero, because nothing holds."""
    if elements.locks.each.size > 0:
        locks.clear_reactions(elements.locks, holds)


@kernel
def add_constraints(y, modes, motion, bodies, elements, wrench, constraints, holds):
    """Add the constraints of elements that hold bodies: those of drives, then those of joints, then
    those of contacts; ``wrench`` (6 nb,) is scratch."""
    add_drive_constraints(elements, constraints, holds)
    if elements.locks.each.size > 0:
        locks.add_constraints(y, modes, motion, bodies, elements.locks, wrench, constraints, holds)
    if elements.joint_motions.rows > 0:
        motions.add_constraints(modes, elements.joint_motions, constraints, holds)
    fender.add_constraints(modes, motion, bodies, elements.fenders, wrench, constraints, holds)


@kernel
def add_reactions(y, modes, motion, bodies, elements, constraints, holds, wrench):
    """Add the reactions of constraints to the rows of ``wrench`` of their elements."""
    fender.add_reactions(modes, motion, bodies, elements.fenders, constraints, holds, wrench)
    if elements.locks.each.size > 0:
        p = elements.locks
        locks.add_reactions(y, modes, motion, bodies, p, constraints, holds, wrench)
    if elements.joint_motions.rows > 0:
        p = elements.joint_motions
        motions.add_reactions(modes, motion, bodies, p, constraints, holds, wrench)
    if elements.drives.each.size > 0:
        drive.add_reactions(motion, bodies, elements.drives, constraints, holds, wrench)


@kernel
def has_load_friction(elements):
    """True if friction in any joint grows with its load."""
    return elements.joint_motions.loaded.size > 0


@kernel
def add_friction_power(y, modes, bodies, elements, holds, rates):
    """Add the power that such friction takes to the ``rates`` of the integrals of losses."""
    if has_load_friction(elements):
        load_friction.add_power(y, modes, bodies, elements.joint_motions, holds, rates)


@kernel
def recheck_after_impact(t, y, modes, motion, bodies, headings, reactions, elements):
    """Test contacts again after velocities have jumped."""
    if elements.fenders.points.size > 0:
        p = elements.fenders
        transitions.recheck_after_impact(t, y, modes, motion, bodies, headings, reactions, p)
    if elements.joint_motions.rows > 0:
        motions.recheck_after_impact(y, modes, bodies, elements.joint_motions)


@kernel
def break_loose(t, y, modes, motion, bodies, elements, reactions):
    """Release the first unit whose reaction exceeds its limit; returns true if there was one."""
    p = elements.joint_motions
    if p.rows > 0 and motions.break_loose(modes, p, reactions):
        return True
    return transitions.break_loose(t, y, modes, motion, bodies, elements.fenders, reactions)


def wind_channels(elements: Any) -> int:
    """Number of wind speeds that a run records."""
    return int(has_gusts(elements.stream_loads.gusts))


@kernel
def gusts_of(elements):
    """The gusts that wind loads feel."""
    return elements.stream_loads.gusts
