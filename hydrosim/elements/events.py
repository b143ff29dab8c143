"""Modes of all elements that have modes: their ends, their successors, and observed values.

Rows of modes belong to contact points, springs, compensators, other links, flows, bushings,
catenaries, guides, winches, joints, their motions and triggers, in this order. Every row has the
same number of margins, which are positive while its mode lasts.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from hydrosim.elements import bushing, drive, external, trigger
from hydrosim.elements.contact import curves, fender, group, landing, transitions
from hydrosim.elements.contact.kind import add_tallies
from hydrosim.elements.contact.laws import COULOMB
from hydrosim.elements.joint import load_friction, locks, motions
from hydrosim.elements.joint.rows import REFERENCE_SIZE
from hydrosim.elements.line import catenary, winch
from hydrosim.elements.link import table as links
from hydrosim.jit.kernels import kernel, root, root_giving
from hydrosim.modes import NO_INDEX
from hydrosim.tanks import pumping
from hydrosim.water.wind import has_gusts

if TYPE_CHECKING:
    from hydrosim.elements import Elements

MAX_HELD_DIRECTIONS = 2  # most directions that a point of rigid friction holds
MAX_DEPENDENCIES = 2  # parts of y that margins of a row depend on


def output_shapes(elements: Elements) -> dict[str, tuple[int, int]]:
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
def joint_output_start(elements):
    """Place of the loads of joints in the output of `write_outputs`."""
    behind = elements.fenders.points.size * fender.CONTACT_OUTPUTS
    behind += elements.link_table.links.size * links.LINK_OUTPUTS
    behind += elements.bushings.each.size * bushing.BUSHING_OUTPUTS
    behind += elements.catenaries.lines.size * catenary.CATENARY_OUTPUTS
    behind += elements.guides.pins.size * landing.GUIDE_OUTPUTS
    return behind + elements.winches.each.size * winch.WINCH_OUTPUTS


@kernel
def write_outputs(t, y, modes, motion, bodies, elements, holds, wrench, out):
    """Write what a run records of fenders, springs, links, bushings, guides and joints, except the
    forces of elements, to ``out``. `output_shapes` gives the shapes that follow one another in the
    flat array ``out``. The forces of all elements are read from ``wrench`` (rows, 6 nb) [N, N
    m]."""
    fenders = elements.fenders
    if fenders.points.size > 0:
        fender.write_outputs(t, y, modes, motion, bodies, fenders, holds.reaction, out)
    behind = fenders.points.size * fender.CONTACT_OUTPUTS
    if elements.link_table.links.size > 0:
        links.write_outputs(t, y, modes, motion, bodies, elements.link_table, out[behind:])
    behind += elements.link_table.links.size * links.LINK_OUTPUTS
    if elements.bushings.each.size > 0:
        bushing.write_outputs(modes, motion, bodies, elements.bushings, out[behind:])
    behind += elements.bushings.each.size * bushing.BUSHING_OUTPUTS
    if elements.catenaries.lines.size > 0:
        catenary.write_outputs(t, y, modes, motion, bodies, elements.catenaries, out[behind:])
    behind += elements.catenaries.lines.size * catenary.CATENARY_OUTPUTS
    if elements.guides.pins.size > 0:
        landing.write_outputs(modes, motion, bodies, elements, out[behind:])
    behind += elements.guides.pins.size * landing.GUIDE_OUTPUTS
    if elements.winches.each.size > 0:
        winch.write_outputs(t, y, modes, motion, bodies, elements.winches, out[behind:])
    behind += elements.winches.each.size * winch.WINCH_OUTPUTS
    if elements.locks.each.size > 0:
        locks.write_outputs(elements.locks, holds, out[behind:])
    behind += elements.locks.joints * 6
    if elements.joint_motions.each.size > 0:
        p = elements.joint_motions
        motions.write_outputs(y, modes, bodies, p, holds.reaction, out[behind:])
    behind += elements.joint_motions.each.size * motions.output_count(elements.joint_motions)
    if elements.externals.delayed > 0:
        external.write_outputs(y, elements.externals, out[behind:])
    behind += elements.externals.delayed * external.EXTERNAL_OUTPUTS
    if elements.drives.each.size > 0:
        drive.write_outputs(elements.drives, holds, out[behind:])


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
        trigger.set_initial_modes(t, y, modes, motion, bodies, elements, tanks)
    group.initialise_groups(t, y, modes, elements.fenders)


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
    fenders = elements.fenders
    triggers = elements.triggers
    if is_trigger(row, elements):
        trigger.transition(row - triggers.mode, which, t, y, modes, motion, bodies, elements, tanks)
        return
    if row >= elements.joint_motions.mode and elements.joint_motions.each.size > 0:
        p = elements.joint_motions
        motions.transition(row - p.mode, which, y, modes, bodies, reactions, p)
        return
    if row >= elements.locks.mode and elements.locks.each.size > 0:
        locks.transition(row - elements.locks.mode, which, y, modes, motion, bodies, elements.locks)
        return
    if row >= elements.winches.mode and elements.winches.each.size > 0:
        p = elements.winches
        winch.transition(row - p.mode, which, t, y, modes, motion, bodies, p)
        return
    if row >= elements.guides.mode and elements.guides.pins.size > 0:
        i = row - elements.guides.mode
        landing.transition(i, which, y, modes, motion, bodies, elements)
        return
    if row >= elements.catenaries.mode and elements.catenaries.lines.size > 0:
        i = row - elements.catenaries.mode
        catenary.transition(i, t, y, modes, motion, bodies, elements.catenaries)
        return
    if row >= elements.bushings.mode and elements.bushings.each.size > 0:
        bushing.transition(row - elements.bushings.mode, modes, elements.bushings)
        return
    if row >= tanks.mode and tanks.flows.size > 0:
        pumping.switch_flow(row - tanks.mode, which, t, modes, tanks)
        return
    if row >= elements.link_table.mode and elements.link_table.links.size > 0:
        i = row - elements.link_table.mode
        links.transition(i, which, t, y, modes, motion, bodies, elements.link_table)
        return
    i = row - fenders.mode
    transitions.transition(i, which, size, step, t, y, modes, motion, bodies, reactions, fenders)


@kernel
def is_trigger(row, elements):
    """True if a row of modes belongs to a trigger, which may change the energy stored in other
    elements."""
    return elements.triggers.each.size > 0 and row >= elements.triggers.mode


@kernel
def book_stored(row, sign, y, stored, elements):
    """Count the energy ``stored`` (rows,) in the element of a trigger, with this ``sign``, as lost;
    contacts do this themselves."""
    unit = elements.triggers.each[row - elements.triggers.mode]
    if unit.points == 0:
        y[elements.triggers.losses + unit.row] += sign * stored[unit.row]


@kernel
def guard_dependencies(row, part, elements, tanks):
    """Ranges (from, to) of entries of y, beyond coordinates and rates, that margins of a row depend
    on; `MAX_DEPENDENCIES` ranges."""
    fenders = elements.fenders
    if tanks.flows.size > 0 and tanks.mode <= row < tanks.mode + tanks.flows.size:
        return tanks.state, tanks.state + tanks.each.size
    if tanks.flows.size > 0 and is_trigger(row, elements):
        return tanks.state, tanks.state + tanks.each.size
    if row >= elements.locks.mode and elements.locks.each.size > 0 and part == 0:
        k = elements.locks.state + locks.LOCK_STATES * (row - elements.locks.mode)
        return (k, k + REFERENCE_SIZE) if row < elements.joint_motions.mode else (0, 0)
    if elements.winches.each.size > 0 and row >= elements.winches.mode:
        return winch.guard_dependencies(row - elements.winches.mode, part, elements.winches)
    i = row - elements.link_table.mode
    if 0 <= i < elements.link_table.links.size:
        return links.guard_dependencies(i, elements.link_table) if part == 0 else (0, 0)
    if row < fenders.mode or row >= fenders.mode + fenders.points.size:
        return 0, 0
    point = fenders.points[row - fenders.mode]
    if part == 0:
        k = fenders.state + fender.CONTACT_STATES * (row - fenders.mode)
        return k, k + fender.FELT_STATES
    if point.memory == NO_INDEX:
        return 0, 0
    k = fender.memory_start(point, fenders) + curves.BRANCH_START
    return k, k + 1


def count_reaction_rows(elements: Elements) -> int:
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


def held_directions(elements: Elements) -> int:
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


def drive_count(elements: Elements) -> int:
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


def joint_count(elements: Elements) -> int:
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


def wind_channels(elements: Elements) -> int:
    """Number of wind speeds that a run records."""
    return int(has_gusts(elements.stream_loads.gusts))


@kernel
def gusts_of(elements):
    """The gusts that wind loads feel."""
    return elements.stream_loads.gusts
