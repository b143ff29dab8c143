"""Contact points as a kind: states, modes, postures, variables, and integrals by mode.

Impulses, works and displacements of contact points by mode: integrals in y, if asked for.

For each point and each of its modes (open, stick, slip), in the earth frame:

    time, N, N n, f                 impulses of the normal force and of friction f on the body
    w                               displacement of the point along the plane
    f w by axis, N n w              works of friction and of the normal force

with the velocity w of the point relative to the plane. In slip also, with its direction d = -f /
|f|: d, N d, C3 |v2| d, the node's |v2| d, and for three of them the part towards positive axes,
max(d, 0). So in slip, with the mean E and the duration T,

    int f dt = -mu_k int N d dt - int C3 |v2| d dt,     int N d dt = T (E[N] E[d] + Cov(N, d))
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from typing import Any, ClassVar

import numpy as np

from hydrosim.elements import kind
from hydrosim.elements.contact import curves, geometry, group, laws
from hydrosim.elements.contact.curves import BRANCH_START
from hydrosim.elements.contact.fender import (
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
    ContactConstants,
    clear_unused_states,
    compile_elements,
    dynamic_states,
    is_mirrored,
    memory_range,
    memory_states,
    normal_load_of,
    points_with_memory,
)
from hydrosim.elements.contact.geometry import contact_kinematics
from hydrosim.elements.contact.law import OPEN, SLIP, STICK
from hydrosim.elements.contact.laws import COULOMB, LAW, least_slip_speed, steady_slip_state
from hydrosim.elements.signal import time_of_largest, value
from hydrosim.jit.kernels import clear, kernel
from hydrosim.modes import MODE, NO_INDEX, SEGMENT
from hydrosim.multibody.vectors import add, length, scale
from hydrosim.scene import Scene
from hydrosim.scene.contacts import Contact

MODES = ("open", "stick", "slip")
TALLIES_OF_MODES = (  # for each mode: name and number of entries
    *(("time", 1), ("impulse", 1), ("press", 3), ("friction", 3)),
    *(("moved", 3), ("friction_work", 3), ("press_work", 1)),
)
TALLIES_OF_SLIP = (  # in slip also
    *(("slip_direction", 3), ("slip_load", 3), ("slip_damping", 3), ("slip_moved", 3)),
    *(("slip_direction_ahead", 3), ("slip_load_ahead", 3), ("slip_moved_ahead", 3)),
)
MODE_TALLIES = sum(count for _, count in TALLIES_OF_MODES)
POINT_TALLIES = len(MODES) * MODE_TALLIES + sum(count for _, count in TALLIES_OF_SLIP)


@kernel
def add_tallies(t, y, modes, motion, bodies, p, reactions, rates):
    """Rates of the integrals of all points, `POINT_TALLIES` for each, with the ``reactions`` (nf,
    2) of rigid friction."""
    clear(rates[: POINT_TALLIES * p.points.size])
    for i in range(p.points.size):
        point, mode, k = p.points[i], modes[p.mode + i, MODE], p.state + CONTACT_STATES * i
        c = geometry.contact_kinematics(point, bodies, motion)
        load = normal_load_of(i, t, y, modes, c, p)
        law = laws.friction(mode, load, c.velocity, (y[k], y[k + 1]), point)
        f = law.force
        if point.law == COULOMB and mode == STICK:
            f = (reactions[i, 0], reactions[i, 1])
        first = POINT_TALLIES * i + MODE_TALLIES * mode
        _add_mode_tallies(load.N, f, c, rates[first : first + MODE_TALLIES])
        if mode == SLIP and length(f) > 0.0:
            last = POINT_TALLIES * (i + 1)
            _add_slip_tallies(
                load.N, f, law, c, rates[POINT_TALLIES * i + len(MODES) * MODE_TALLIES : last]
            )


@kernel
def _add_mode_tallies(N, f, c, out):
    """The rates of `TALLIES_OF_MODES`."""
    force, press = _earth_vector(f, c), scale(N, c.normal)
    w = _earth_vector(c.velocity, c)
    out[0], out[1], out[MODE_TALLIES - 1] = 1.0, N, -N * c.rate
    for a in range(3):
        out[2 + a], out[5 + a], out[8 + a] = press[a], force[a], w[a]
        out[11 + a] = force[a] * w[a]


@kernel
def _add_slip_tallies(N, f, law, c, out):
    """The rates of `TALLIES_OF_SLIP`."""
    size, v2 = length(f), law.slip_speed
    d = _earth_vector((-f[0] / size, -f[1] / size), c)
    damping = law.slip_damped / v2 if v2 != 0.0 else 0.0
    for a in range(3):
        ahead = max(d[a], 0.0)
        out[a], out[3 + a], out[6 + a], out[9 + a] = d[a], N * d[a], damping * d[a], v2 * d[a]
        out[12 + a], out[15 + a], out[18 + a] = ahead, N * ahead, v2 * ahead


@kernel
def _earth_vector(u, c):
    """A vector (2,) in the plane, turned into the earth frame."""
    return add(scale(u[0], c.tangent1), scale(u[1], c.tangent2))


# Postures of contact points: open, sticking, in steady slip; on the steepest piece of their curve.

CLOSED_MODES = {STICK: "sticking", SLIP: "slipping"}
SLIDING = 0.1  # m/s: the speed at which slip is linearised, unless slip begins at a higher one


class KindOfContacts(kind.KindWithModeSets):
    """Postures of contact points."""

    def mode_sets(self, p: ContactConstants) -> Sequence[kind.ModeSet]:
        text = "all contacts open" if p.points.size else "no contact"
        rest = kind.ModeSet(text, kind.rest_at_first(p.points["first"], OPEN))
        modes = CLOSED_MODES if p.points.size else ()
        return [
            rest,
            *(kind.ModeSet(f"all contacts {CLOSED_MODES[m]}", _closed_modes(p, m)) for m in modes),
        ]

    def one_unit_active(
        self, p: ContactConstants, names: Sequence[str], which: Sequence[int]
    ) -> Iterator[kind.ModeSet]:
        rest = kind.rest_at_first(p.points["first"], OPEN)
        for mode, text in CLOSED_MODES.items() if p.points.size > 1 else ():
            closed = _closed_modes(p, mode)
            for i in which:
                yield kind.ModeSet(
                    f"{names[i]} alone {text}", kind.with_mode_of_unit(rest, closed, i)
                )

    def equivalence_keys(self, p: ContactConstants) -> Sequence[Hashable]:
        law = (name for name, _ in LAW)
        fields = ("normal_damping", "prescribed", "signal", "reach", "lag", *law)
        return [
            (
                *p.segments[_steepest_segment(p, point)].tolist(),
                *(point[name].item() for name in fields),
            )
            for point in p.points
        ]

    def rates(self, p: ContactConstants, bodies: Any, motion: Any) -> np.ndarray:
        """Along the normal and along both tangents."""
        touches = [contact_kinematics(point, bodies, motion) for point in p.points]
        return np.reshape([(touch.rate, *touch.velocity) for touch in touches], (-1, 3))

    def moved_onto_segment(
        self, p: ContactConstants, modes: np.ndarray, bodies: Any, motion: Any, y: np.ndarray
    ) -> ContactConstants:
        """Constants in which each plane presses its point, and each mode keeps its branch."""
        points = p.points.copy()
        points["saturates"] = False
        for point, (mode, segment, _) in zip(points, modes, strict=True):
            if mode != OPEN:
                start = p.segments[segment]["start"]
                nearer = (
                    start
                    + kind.LINEARISATION_DEPTH
                    - contact_kinematics(point, bodies, motion).compression
                )
                point["plane_point"] += nearer * point["plane_normal"]
        return p._replace(points=points)

    def time_of_largest_load(self, p: ContactConstants) -> float:
        signals = p.points["signal"][p.points["prescribed"]]

        def total(time: float) -> float:
            return sum(value(time, signal, p.pieces) for signal in signals)

        return max(
            (time_of_largest(signal, p.pieces) for signal in signals), key=total, default=0.0
        )

    def sliding_speed(self, p: ContactConstants, modes: np.ndarray, time: float) -> float:
        if not np.any(modes[:, MODE] == SLIP):
            return 0.0
        return max(SLIDING, *map(least_slip_speed, _normal_loads(p, modes, time), p.points))

    def set_steady_slip(
        self,
        p: ContactConstants,
        modes: np.ndarray,
        time: float,
        bodies: Any,
        motion: Any,
        y: np.ndarray,
    ) -> None:
        """Put points into steady slip; stiff lines begin at the planes of `moved_onto_segment`."""
        memory_states(p, y)[:, BRANCH_START] = 0.0
        loads = _normal_loads(p, modes, time)
        for i in np.flatnonzero(modes[:, MODE] == SLIP):
            point = p.points[i]
            steady_state = steady_slip_state(
                loads[i], np.array(contact_kinematics(point, bodies, motion).velocity), point
            )
            if steady_state is not None:
                y[p.state + CONTACT_STATES * i :][:2] = steady_state

    def idle_states(self, p: ContactConstants, modes: np.ndarray) -> np.ndarray:
        """The nodes of open contacts; they are analysed in the posture with all contacts open."""
        states = dynamic_states(p)
        is_open = modes[:, MODE] == OPEN
        return states[is_open[(states - p.state) // CONTACT_STATES] & (not is_open.all())]


def _closed_modes(p: ContactConstants, mode: int) -> np.ndarray:
    """Modes with all points in one mode on their steepest pieces."""
    modes = kind.rest_at_first(p.points["first"], mode)
    modes[:, SEGMENT] = [_steepest_segment(p, point) for point in p.points]
    return modes


def _steepest_segment(p: ContactConstants, point: np.void) -> int:
    """The steepest piece of the curve of a point: the stiff line, if it has one."""
    line = int(point["line"])
    return (
        line
        if line != NO_INDEX
        else kind.steepest_segment(p.segments, point["first"], point["last"])
    )


def _normal_loads(p: ContactConstants, modes: np.ndarray, time: float) -> list[float]:
    """Normal force [N] of every point in its mode, for the planes of
    `KindOfContacts.moved_onto_segment`."""
    return [_normal_load(p, point, mode, time) for point, mode in zip(p.points, modes, strict=True)]


def _normal_load(p: ContactConstants, point: np.void, mode: np.ndarray, time: float) -> float:
    if point["prescribed"]:
        return float(value(time, point["signal"], p.pieces))
    piece = p.segments[mode[SEGMENT]]
    return float(piece["force"] + kind.LINEARISATION_DEPTH * piece["slope"])


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


INTEGRALS = {
    "contact_time": kind.Variable("time in a contact mode", "s"),
    "contact_impulse": kind.Variable("integral of the normal force in a contact mode", "N s"),
    "contact_press": kind.Variable(
        "impulse of the normal force on the body in a contact mode", "N s", EARTH_NAME
    ),
    "contact_friction": kind.Variable(
        "impulse of friction on the body in a contact mode", "N s", EARTH_NAME
    ),
    "contact_moved": kind.Variable(
        "displacement of the point along the plane in a mode", "m", EARTH_NAME
    ),
    "contact_friction_work": kind.Variable(
        "work of friction on the body in a contact mode", "J", EARTH_NAME
    ),
    "contact_press_work": kind.Variable("work of the normal force in a contact mode", "J"),
    "slip_direction": kind.Variable("integral of the direction of slip", "s", EARTH_NAME),
    "slip_load": kind.Variable(
        "integral of normal force times direction of slip", "N s", EARTH_NAME
    ),
    "slip_damping": kind.Variable("integral of C3 times the velocity of slip", "N s", EARTH_NAME),
    "slip_moved": kind.Variable("displacement of the contact node in slip", "m", EARTH_NAME),
    "slip_direction_ahead": kind.Variable(
        "the part of slip_direction towards positive axes", "s", EARTH_NAME
    ),
    "slip_load_ahead": kind.Variable(
        "the part of slip_load towards positive axes", "N s", EARTH_NAME
    ),
    "slip_moved_ahead": kind.Variable(
        "the part of slip_moved towards positive axes", "m", EARTH_NAME
    ),
}
"""Variables of runs that record impulses: integrals over the steps since the start."""


class ContactKind(KindOfContacts):
    unit = "fender"
    variables: ClassVar = {
        "fender_compression": kind.Variable(
            "compression, negative when open, at most 0 where the plane or seat does not act",
            "m",
            NORMAL,
        ),
        "fender_normal_force": kind.Variable(
            "normal force",
            "N",
            NORMAL,
            chart=kind.ChartHint("Normal force of contacts", "normal force", kind.Topic.CONTACTS),
            lowest=0.0,
            is_load=True,
        ),
        "fender_mode": kind.Variable("contact mode", "1", flags="open stick slip"),
        "fender_friction": kind.Variable("friction force on the body", "N", EARTH_NAME),
        "fender_node": kind.Variable("position of the contact node on the plane", "m", EARTH_NAME),
        "fender_slip_distance": kind.Variable(
            "distance slipped since the start",
            "m",
            "plane",
            chart=kind.ChartHint("Distance slipped", "slip distance", kind.Topic.DETAILS + 3),
        ),
        "fender_dissipated": kind.Variable(
            "energy lost in friction and loops since the start",
            "J",
            chart=kind.ChartHint(
                "Friction loss of contacts", "friction loss", kind.Topic.DETAILS + 3
            ),
        ),
        "fender_dissipated_damping": kind.Variable(
            "part of the energy lost: in the node's damper C2", "J"
        ),
        "fender_dissipated_slip_damping": kind.Variable(
            "part of the energy lost: in slip damping C3", "J"
        ),
        "fender_closings": kind.Variable("number of closings since the start", "1"),
        "fender_closing_speed": kind.Variable("speed of the last closing", "m/s", NORMAL),
        "fender_largest_force": kind.Variable(
            "largest normal force since the last closing", "N", NORMAL
        ),
        "fender_segment": kind.Variable("piece of the normal curve, counted from 0", "1"),
        "fender_rising": kind.Variable("1 if the stretch is that of a rising load", "1"),
        **{name: variable._replace(is_detail=True) for name, variable in INTEGRALS.items()},
    }
    impulse_names: ClassVar = tuple(f"tally {k + 1}" for k in range(POINT_TALLIES))

    def modes(self, p: ContactConstants) -> kind.ModeRows:
        points = p.points
        last = np.maximum(points["last"], points["line"])
        return kind.ModeRows(
            points.size, "mode", "rising", points["first"], last, points["steepest"]
        )

    def states(self, p: ContactConstants, scene: Scene) -> Iterator[kind.StateBlocks]:
        """States of all points, of points with memory, and of groups with memory."""
        names = self.unit_names(scene)
        groups = [*dict.fromkeys(group_of_points(scene))]
        yield kind.StateBlocks("contact node", names, CONTACT_STATE_NAMES)
        yield kind.StateBlocks(
            "closings", [names[i] for i in points_with_memory(p)], curves.LOOP_STATE_NAMES
        )
        owners = [groups[k] for k in p.groups["index"]]
        yield kind.StateBlocks("contact group", owners, group.GROUP_STATE_NAMES, "group ")

    def coupled_states(self, p: ContactConstants) -> np.ndarray:
        return dynamic_states(p)

    def coordinates(self, scene: Scene) -> dict[str, object]:
        """Coordinates with the element of each point, and these elements."""
        groups = group_of_points(scene)
        if not groups:
            return {}
        description = {"long_name": "element of contact points, whose phases are told together"}
        return {
            "fender": ("fender", self.unit_names(scene)),
            "fender_group": ("fender", groups, description),
            "contact_group": ("contact_group", [*dict.fromkeys(groups)], description),
            **kind.capacity_of(self.unit, kind.elements_of(scene, self.classes)),
            **(_kinetic_coefficients(scene) if scene.output.impulses else {}),
        }

    def record(
        self, p: ContactConstants, bodies: Any, unit_record: kind.UnitRecord
    ) -> kind.Columns:
        seen = unit_record.observed
        is_open = unit_record.modes[:, :, MODE] == OPEN
        axes = POINT_AXES[:2]
        point_states = unit_record.y[p.state : p.state + CONTACT_STATES * p.points.size]
        states = point_states.reshape(len(point_states), -1, CONTACT_STATES)
        return {
            "fender_compression": (axes, seen[:, :, COMPRESSION]),
            "fender_normal_force": (axes, np.where(is_open, 0.0, seen[:, :, NORMAL_FORCE])),
            "fender_mode": (axes, unit_record.modes[:, :, MODE].astype(np.int8)),
            "fender_friction": (POINT_AXES, seen[:, :, FRICTION_FORCE:NODE]),
            "fender_node": (POINT_AXES, seen[:, :, NODE:ENERGY_LOST]),
            "fender_slip_distance": (axes, states[:, :, SLIP_DISTANCE]),
            "fender_dissipated": (axes, seen[:, :, ENERGY_LOST]),
            "fender_dissipated_damping": (axes, states[:, :, DAMPED]),
            "fender_dissipated_slip_damping": (axes, states[:, :, SLIP_DAMPED]),
            **_closing_columns(p, unit_record.y),
            **(dict(_tally_variables(unit_record.tallies)) if unit_record.tallies.size else {}),
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
        known_states: np.ndarray,
    ) -> None:
        """Reset stiff lines of new points and of points that cannot be pressed as stored, and the
        memory of groups that did not have one in the run."""
        for k, i in enumerate(points_with_memory(p)):
            if not (possible[i] and known_states[p.state + CONTACT_STATES * i]):
                memory_states(p, y)[k, curves.BRANCH_START] = memory_states(p, anew)[
                    k, curves.BRANCH_START
                ]
        for first in p.state + p.groups["first"]:
            if not known_states[first]:
                y[first : first + group.GROUP_STATES] = anew[first : first + group.GROUP_STATES]


CONTACT_KIND = ContactKind("fenders", (Contact,), compile_elements)


def _kinetic_coefficients(scene: Scene) -> dict[str, object]:
    """Contact modes, and mu_k of each contact point."""
    contacts = [e for e in scene.forces.values() if isinstance(e, Contact)]
    kinetic = [getattr(e.friction, "kinetic", 0.0) for e in contacts for _ in e.points]
    description = {"long_name": "coefficient of kinetic friction", "units": "1"}
    return {
        "contact_mode": ("contact_mode", list(MODES)),
        "fender_kinetic": ("fender", kinetic, description),
    }


def _closing_columns(p: ContactConstants, y: kind.RecordedStates) -> kind.Columns:
    """Memory of closings of contacts; NaN for contacts without memory."""
    if p.remembering == 0:
        return {}
    loop_states = np.full((len(y), p.points.size, curves.LOOP_STATES), np.nan)
    memory = y[memory_range(p)]
    loop_states[:, points_with_memory(p)] = memory.reshape(
        len(y), p.remembering, curves.LOOP_STATES
    )
    return {
        "fender_closings": (POINT_AXES[:2], loop_states[:, :, curves.CLOSINGS]),
        "fender_closing_speed": (POINT_AXES[:2], loop_states[:, :, curves.CLOSING_SPEED]),
        "fender_largest_force": (POINT_AXES[:2], loop_states[:, :, curves.LARGEST_NORMAL]),
    }


def _tally_variables(
    tallies: np.ndarray,
) -> Iterator[tuple[str, tuple[tuple[str, ...], np.ndarray]]]:
    """Variables from the ``tallies`` (nt, nf, `POINT_TALLIES`) of contact points: `contact_*`
    (time, fender, mode) and `slip_*` (time, fender, axis)."""
    dims = ("time", "fender", "contact_mode")
    end = len(MODES) * MODE_TALLIES
    modes = tallies[:, :, :end].reshape(*tallies.shape[:2], len(MODES), MODE_TALLIES)
    at = 0
    for name, count in TALLIES_OF_MODES:
        part = modes[..., at : at + count]
        yield f"contact_{name}", (dims, part[..., 0]) if count == 1 else ((*dims, "axis"), part)
        at += count
    at = end
    for name, count in TALLIES_OF_SLIP:
        yield name, (POINT_AXES, tallies[:, :, at : at + count])
        at += count


def remembered_groups(parts: kind.KindConstants, y: kind.RecordedStates) -> list[group.GroupMemory]:
    """All groups with memory, with their states from y."""
    p = CONTACT_KIND.constants_in(parts)
    starts = p.state + p.groups["first"]
    return [
        group.GroupMemory(
            int(group_row["index"]),
            float(group_row["weight"]),
            y[first : first + group.GROUP_STATES],
        )
        for group_row, first in zip(p.groups, starts, strict=True)
    ]
