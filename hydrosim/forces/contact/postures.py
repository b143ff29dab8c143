"""Postures of contact points: open, sticking, slipping; see `hydrosim.forces.postures`.

Points are linearised on the steepest piece of their curve, or under the largest prescribed force,
and in steady slip.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from typing import Any

import numpy as np

from hydrosim.forces.contact.fender import (
    CONTACT_STATES,
    ContactConstants,
    dynamic_states,
    memory_states,
)
from hydrosim.forces.contact.geometry import contact_kinematics
from hydrosim.forces.contact.laws import LAW, least_slip_speed, steady_slip_state
from hydrosim.forces.contact.loop import BRANCH_START
from hydrosim.forces.contact.modes import OPEN, SLIP, STICK
from hydrosim.forces.postures import (
    LINEARISATION_DEPTH,
    KindWithModeSets,
    ModeSet,
    rest_at_first,
    steepest_segment,
    with_mode_of_unit,
)
from hydrosim.forces.signal import time_of_largest, value
from hydrosim.modes import MODE, NO_INDEX, SEGMENT

CLOSED_MODES = {STICK: "sticking", SLIP: "slipping"}
SLIDING = 0.1  # m/s: the speed at which slip is linearised, unless slip begins at a higher one


class KindOfContacts(KindWithModeSets):
    """Postures of contact points."""

    def mode_sets(self, p: ContactConstants) -> Sequence[ModeSet]:
        text = "all contacts open" if p.points.size else "no contact"
        rest = ModeSet(text, rest_at_first(p.points["first"], OPEN))
        modes = CLOSED_MODES if p.points.size else ()
        return [
            rest,
            *(ModeSet(f"all contacts {CLOSED_MODES[m]}", _closed_modes(p, m)) for m in modes),
        ]

    def one_unit_active(
        self, p: ContactConstants, names: Sequence[str], which: Sequence[int]
    ) -> Iterator[ModeSet]:
        rest = rest_at_first(p.points["first"], OPEN)
        for mode, text in CLOSED_MODES.items() if p.points.size > 1 else ():
            closed = _closed_modes(p, mode)
            for i in which:
                yield ModeSet(f"{names[i]} alone {text}", with_mode_of_unit(rest, closed, i))

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
        return np.reshape([(each.rate, *each.velocity) for each in touches], (-1, 3))

    def moved_onto_segment(
        self, p: ContactConstants, modes: np.ndarray, bodies: Any, motion: Any
    ) -> ContactConstants:
        """Constants in which each plane presses its point, and each mode keeps its branch."""
        points = p.points.copy()
        points["saturates"] = False
        for point, (mode, segment, _) in zip(points, modes, strict=True):
            if mode != OPEN:
                start = p.segments[segment]["start"]
                nearer = (
                    start
                    + LINEARISATION_DEPTH
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
            found = steady_slip_state(
                loads[i], np.array(contact_kinematics(point, bodies, motion).velocity), point
            )
            if found is not None:
                y[p.state + CONTACT_STATES * i :][:2] = found

    def idle_states(self, p: ContactConstants, modes: np.ndarray) -> np.ndarray:
        """The nodes of open contacts; they are analysed in the posture with all contacts open."""
        states = dynamic_states(p)
        is_open = modes[:, MODE] == OPEN
        return states[is_open[(states - p.state) // CONTACT_STATES] & (not is_open.all())]


def _closed_modes(p: ContactConstants, mode: int) -> np.ndarray:
    """Modes with all points in one mode on their steepest pieces."""
    modes = rest_at_first(p.points["first"], mode)
    modes[:, SEGMENT] = [_steepest_segment(p, point) for point in p.points]
    return modes


def _steepest_segment(p: ContactConstants, point: np.void) -> int:
    """The steepest piece of the curve of a point: the stiff line, if it has one."""
    line = int(point["line"])
    return line if line != NO_INDEX else steepest_segment(p.segments, point["first"], point["last"])


def _normal_loads(p: ContactConstants, modes: np.ndarray, time: float) -> list[float]:
    """Normal force [N] of every point in its mode, for the planes of
    `KindOfContacts.moved_onto_segment`."""
    return [_normal_load(p, point, mode, time) for point, mode in zip(p.points, modes, strict=True)]


def _normal_load(p: ContactConstants, point: np.void, mode: np.ndarray, time: float) -> float:
    if point["prescribed"]:
        return float(value(time, point["signal"], p.pieces))
    piece = p.segments[mode[SEGMENT]]
    return float(piece["force"] + LINEARISATION_DEPTH * piece["slope"])
