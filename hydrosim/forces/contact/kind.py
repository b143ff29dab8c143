"""Contact points as a kind: states, modes, variables, and states that a restart initialises."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from hydrosim.forces.contact import group, loop
from hydrosim.forces.contact.fender import (
    COMPRESSION,
    CONTACT_STATE_NAMES,
    CONTACT_STATES,
    DAMPED,
    ENERGY_LOST,
    FRICTION_FORCE,
    NODE,
    NORMAL_FORCE,
    SLIP_DAMPED,
    SLIP_DISTANCE,
    Contact,
    ContactConstants,
    clear_unused_states,
    compile_elements,
    dynamic_states,
    is_mirrored,
    memory_range,
    memory_states,
    points_with_memory,
)
from hydrosim.forces.contact.modes import OPEN
from hydrosim.forces.contact.postures import KindOfContacts
from hydrosim.forces.contact.tally import MODE_TALLIES, TALLIES_OF_MODES, TALLIES_OF_SLIP
from hydrosim.forces.contact.tally import MODES as TALLIED
from hydrosim.forces.contact.tally import POINT_TALLIES as TALLIES
from hydrosim.forces.kind import (
    Columns,
    KindConstants,
    ModeRows,
    RecordedStates,
    StateBlocks,
    UnitRecord,
    Variable,
    capacity_of,
    elements_of,
)
from hydrosim.modes import MODE
from hydrosim.scene import Scene

EARTH_NAME = "earth"
NORMAL = "normal of the plane"
POINT_AXES = ("time", "fender", "axis")


def group_of_points(scene: Scene) -> list[str]:
    """Name of the group of each contact point; by default the name of its element."""
    return [
        element.group or name
        for name, element in scene.forces.items()
        if isinstance(element, Contact)
        for _ in element.unit_names(name)
    ]


class ContactKind(KindOfContacts):
    unit = "fender"
    variables: ClassVar = {
        "fender_compression": Variable(
            "compression, negative when open, at most 0 where the plane or seat does not act",
            "m",
            NORMAL,
        ),
        "fender_normal_force": Variable("normal force", "N", NORMAL),
        "fender_mode": Variable("contact mode", "1", flags="open stick slip"),
        "fender_friction": Variable("friction force on the body", "N", EARTH_NAME),
        "fender_node": Variable("position of the contact node on the plane", "m", EARTH_NAME),
        "fender_slip_distance": Variable("distance slipped since the start", "m", "plane"),
        "fender_dissipated": Variable("energy lost in friction and loops since the start", "J"),
        "fender_dissipated_damping": Variable(
            "part of the energy lost: in the node's damper C2", "J"
        ),
        "fender_dissipated_slip_damping": Variable(
            "part of the energy lost: in slip damping C3", "J"
        ),
        "fender_closings": Variable("number of closings since the start", "1"),
        "fender_closing_speed": Variable("speed of the last closing", "m/s", NORMAL),
        "fender_largest_force": Variable(
            "largest normal force since the last closing", "N", NORMAL
        ),
        "fender_segment": Variable("piece of the normal curve, counted from 0", "1"),
        "fender_rising": Variable("1 if the stretch is that of a rising load", "1"),
        "contact_time": Variable("time in a contact mode", "s"),
        "contact_impulse": Variable("integral of the normal force in a contact mode", "N s"),
        "contact_press": Variable(
            "impulse of the normal force on the body in a contact mode", "N s", EARTH_NAME
        ),
        "contact_friction": Variable(
            "impulse of friction on the body in a contact mode", "N s", EARTH_NAME
        ),
        "contact_moved": Variable(
            "displacement of the point along the plane in a mode", "m", EARTH_NAME
        ),
        "contact_friction_work": Variable(
            "work of friction on the body in a contact mode", "J", EARTH_NAME
        ),
        "contact_press_work": Variable("work of the normal force in a contact mode", "J"),
        "slip_direction": Variable("integral of the direction of slip", "s", EARTH_NAME),
        "slip_load": Variable(
            "integral of normal force times direction of slip", "N s", EARTH_NAME
        ),
        "slip_damping": Variable("integral of C3 times the velocity of slip", "N s", EARTH_NAME),
        "slip_moved": Variable("displacement of the contact node in slip", "m", EARTH_NAME),
        "slip_direction_ahead": Variable(
            "the part of slip_direction towards positive axes", "s", EARTH_NAME
        ),
        "slip_load_ahead": Variable(
            "the part of slip_load towards positive axes", "N s", EARTH_NAME
        ),
        "slip_moved_ahead": Variable(
            "the part of slip_moved towards positive axes", "m", EARTH_NAME
        ),
    }
    impulse_names: ClassVar = tuple(f"tally {k + 1}" for k in range(TALLIES))

    def modes(self, p: ContactConstants) -> ModeRows:
        points = p.points
        last = np.maximum(points["last"], points["line"])
        return ModeRows(points.size, "mode", "rising", points["first"], last, points["steepest"])

    def states(self, p: ContactConstants, scene: Scene) -> Iterator[StateBlocks]:
        """States of all points, of points with memory, and of groups with memory."""
        names = self.unit_names(scene)
        groups = [*dict.fromkeys(group_of_points(scene))]
        yield StateBlocks("contact node", names, CONTACT_STATE_NAMES)
        yield StateBlocks(
            "closings", [names[i] for i in points_with_memory(p)], loop.LOOP_STATE_NAMES
        )
        owners = [groups[k] for k in p.groups["index"]]
        yield StateBlocks("contact group", owners, group.GROUP_STATE_NAMES, "group ")

    def coupled_states(self, p: ContactConstants) -> np.ndarray:
        return dynamic_states(p)

    def coordinates(self, scene: Scene) -> dict[str, object]:
        """Coordinates with the element of each point, and these elements."""
        groups = group_of_points(scene)
        if not groups:
            return {}
        said = {"long_name": "element of contact points, whose phases are told together"}
        return {
            "fender": ("fender", self.unit_names(scene)),
            "fender_group": ("fender", groups, said),
            "contact_group": ("contact_group", [*dict.fromkeys(groups)], said),
            **capacity_of(self.unit, elements_of(scene, self.classes)),
            **(_kinetic_coefficients(scene) if scene.output_impulses else {}),
        }

    def record(self, p: ContactConstants, bodies: Any, kept: UnitRecord) -> Columns:
        seen = kept.observed
        is_open = kept.modes[:, :, MODE] == OPEN
        each = POINT_AXES[:2]
        own = kept.y[p.state : p.state + CONTACT_STATES * p.points.size]
        states = own.reshape(len(own), -1, CONTACT_STATES)
        return {
            "fender_compression": (each, seen[:, :, COMPRESSION]),
            "fender_normal_force": (each, np.where(is_open, 0.0, seen[:, :, NORMAL_FORCE])),
            "fender_mode": (each, kept.modes[:, :, MODE].astype(np.int8)),
            "fender_friction": (POINT_AXES, seen[:, :, FRICTION_FORCE:NODE]),
            "fender_node": (POINT_AXES, seen[:, :, NODE:ENERGY_LOST]),
            "fender_slip_distance": (each, states[:, :, SLIP_DISTANCE]),
            "fender_dissipated": (each, seen[:, :, ENERGY_LOST]),
            "fender_dissipated_damping": (each, states[:, :, DAMPED]),
            "fender_dissipated_slip_damping": (each, states[:, :, SLIP_DAMPED]),
            **_closings(p, kept.y),
            **(dict(_tally_variables(kept.tallies)) if kept.tallies.size else {}),
        }

    def losses(self, p: ContactConstants, observed: np.ndarray) -> dict[int, np.ndarray]:
        """Energy lost in friction."""
        rows = p.points["row"]
        return {row: observed[:, rows == row, ENERGY_LOST].sum(axis=1) for row in np.unique(rows)}

    def is_mirrored(self, p: ContactConstants, y: np.ndarray, modes: np.ndarray) -> bool:
        return is_mirrored(p, y, modes)

    def clear_unused_states(self, p: ContactConstants, y: np.ndarray) -> None:
        clear_unused_states(p, y)

    def renew(
        self,
        p: ContactConstants,
        y: np.ndarray,
        anew: np.ndarray,
        possible: np.ndarray,
        known: np.ndarray,
    ) -> None:
        """Reset stiff lines of new points and of points that cannot be pressed as stored, and the
        memory of groups that did not have one in the run."""
        for k, i in enumerate(points_with_memory(p)):
            if not (possible[i] and known[p.state + CONTACT_STATES * i]):
                memory_states(p, y)[k, loop.BRANCH_START] = memory_states(p, anew)[
                    k, loop.BRANCH_START
                ]
        for first in p.state + p.groups["first"]:
            if not known[first]:
                y[first : first + group.GROUP_STATES] = anew[first : first + group.GROUP_STATES]


CONTACT_KIND = ContactKind("fenders", (Contact,), compile_elements)


def _kinetic_coefficients(scene: Scene) -> dict[str, object]:
    """Contact modes, and mu_k of each contact point."""
    contacts = [e for e in scene.forces.values() if isinstance(e, Contact)]
    kinetic = [getattr(e.friction, "kinetic", 0.0) for e in contacts for _ in e.points]
    said = {"long_name": "coefficient of kinetic friction", "units": "1"}
    return {
        "contact_mode": ("contact_mode", list(TALLIED)),
        "fender_kinetic": ("fender", kinetic, said),
    }


def _closings(p: ContactConstants, y: RecordedStates) -> Columns:
    """Memory of closings of contacts; NaN for contacts without memory."""
    if p.remembering == 0:
        return {}
    known = np.full((len(y), p.points.size, loop.LOOP_STATES), np.nan)
    own = y[memory_range(p)]
    known[:, points_with_memory(p)] = own.reshape(len(y), p.remembering, loop.LOOP_STATES)
    return {
        "fender_closings": (POINT_AXES[:2], known[:, :, loop.CLOSINGS]),
        "fender_closing_speed": (POINT_AXES[:2], known[:, :, loop.CLOSING_SPEED]),
        "fender_largest_force": (POINT_AXES[:2], known[:, :, loop.LARGEST_NORMAL]),
    }


def _tally_variables(
    tallies: np.ndarray,
) -> Iterator[tuple[str, tuple[tuple[str, ...], np.ndarray]]]:
    """Variables from the ``tallies`` (nt, nf, `TALLIES`) of contact points: `contact_*` (time,
    fender, mode) and `slip_*` (time, fender, axis)."""
    dims = ("time", "fender", "contact_mode")
    end = len(TALLIED) * MODE_TALLIES
    modes = tallies[:, :, :end].reshape(*tallies.shape[:2], len(TALLIED), MODE_TALLIES)
    at = 0
    for name, count in TALLIES_OF_MODES:
        part = modes[..., at : at + count]
        yield f"contact_{name}", (dims, part[..., 0]) if count == 1 else ((*dims, "axis"), part)
        at += count
    at = end
    for name, count in TALLIES_OF_SLIP:
        yield name, (POINT_AXES, tallies[:, :, at : at + count])
        at += count


def remembered_groups(parts: KindConstants, y: RecordedStates) -> list[group.GroupMemory]:
    """All groups with memory, with their states from y."""
    p = CONTACT_KIND.constants_in(parts)
    starts = p.state + p.groups["first"]
    return [
        group.GroupMemory(
            int(each["index"]), float(each["weight"]), y[first : first + group.GROUP_STATES]
        )
        for each, first in zip(p.groups, starts, strict=True)
    ]
