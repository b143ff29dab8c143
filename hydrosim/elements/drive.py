"""Prescribed motion: a free coordinate of a body, or a motion of a joint, follows a signal.

    q_j = f(t),   q_j' = f'(t),   q_j'' = f''(t)

The last one is a constraint of the equation of motion, with the row e_j. Its force lambda is what
drives the coordinate [N or N m]: its power is lambda f', which is booked as work. After every
accepted step, place and rate are set to the signal. Between them they differ by the error of the
method in one step, so that a method keeps its order.

The acceleration of a table jumps at its points. No step crosses them, and all stages of a step use
the piece of the signal in which it begins. A record has no such corners: its acceleration is
continuous.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.elements.kind import (
    ChartHint,
    Columns,
    ElementKind,
    Layout,
    Topic,
    UnitRecord,
    Variable,
)
from hydrosim.elements.signal import SIGNAL, compile_signals, corners, find_motion, find_piece
from hydrosim.jit.kernels import clear, kernel, root
from hydrosim.modes import NO_INDEX
from hydrosim.multibody.kinematics import wrench_of_coordinates
from hydrosim.multibody.tree import push_joint
from hydrosim.scene import ForceElement
from hydrosim.scene.restraints import Drive

POSITION, SPEED, ACCELERATION = range(3)
DRIVE_OUTPUTS = 1

DRIVE = np.dtype(
    [
        *(("coordinate", int), ("row", int), ("body", int), ("dof", int)),
        *(("move", int), ("axis", int), ("cornered", bool), ("signal", SIGNAL)),
    ]
)
"""A drive: its coordinate, its row of forces; its body and degree of freedom, or the move of the
tree of joints and the axis of that (`NO_INDEX` if it drives a body); its signal, and whether that
has corners, which no step crosses."""


class DriveConstants(NamedTuple):
    """The drives ``each`` (n,) of `DRIVE`, the ``pieces`` of their signals; the first of their
    reactions, and of the integrals of work in y, row by row."""

    each: np.ndarray
    pieces: np.ndarray
    reaction: int
    losses: int


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> DriveConstants:
    """Constants of the drives among ``elements``."""
    drives = {name: e for name, e in elements.items() if isinstance(e, Drive)}
    constants = np.zeros(len(drives), dtype=DRIVE)
    signals, pieces = compile_signals([e.position for e in drives.values()])
    for i, (name, e) in enumerate(drives.items()):
        place = _body_place(e, layout) if e.joint is None else _joint_place(e, layout)
        cornered = corners(e.position).size > 0
        constants[i] = (place[0], layout.row[name], *place[1:], cornered, signals[i])
    return DriveConstants(constants, pieces, 0, 0)


def _body_place(drive: Drive, layout: Layout) -> tuple[int, ...]:
    """Entries of `DRIVE` of a drive of a body, without its row and signal."""
    body = layout.body[drive.body]
    dof = DOFS.index(drive.coordinate)
    coordinate = int(np.flatnonzero(layout.active == 6 * body + dof)[0])
    return coordinate, body, dof, NO_INDEX, NO_INDEX


def _joint_place(drive: Drive, layout: Layout) -> tuple[int, ...]:
    """The same of a drive of a joint."""
    assert drive.joint is not None
    coordinate, move, axis = layout.coordinate_of_motion(drive.joint, drive.coordinate)
    return coordinate, NO_INDEX, NO_INDEX, move, axis


@root
def begin_step(t, p, holds):
    """Choose the pieces of the signals with corners for a step that begins at ``t``."""
    for i in range(p.each.size):
        if p.each[i].cornered:
            holds.piece[i] = find_piece(t, p.each[i].signal, p.pieces)


@root
def set_motion(t, p, holds):
    """Fill ``holds.driven`` for the time ``t``. Signals without corners, and others outside steps,
    are on the piece that holds ``t``."""
    for i in range(p.each.size):
        signal = p.each[i].signal
        k = holds.piece[i]
        if k == NO_INDEX:
            k = find_piece(t, signal, p.pieces)
        position, speed, acceleration = find_motion(t, signal, p.pieces[k])
        holds.driven[i, POSITION] = position
        holds.driven[i, SPEED] = speed
        holds.driven[i, ACCELERATION] = acceleration


@root
def set_driven_states(t, y, bodies, p, holds):
    """Set the driven coordinates and their rates in ``y`` to the signals at ``t``, and choose the
    pieces of a step that begins there."""
    n = bodies.active.size
    begin_step(t, p, holds)
    set_motion(t, p, holds)
    for i in range(p.each.size):
        j = p.each[i].coordinate
        y[j] = holds.driven[i, POSITION]
        y[n + j] = holds.driven[i, SPEED]


@root
def add_constraints(p, constraints, holds):
    """Add the constraint q_j'' = f'' of each drive; they come before all others."""
    for i in range(p.each.size):
        r = constraints.number[0]
        clear(constraints.J[r])
        constraints.J[r, p.each[i].coordinate] = 1.0
        constraints.bound[r] = holds.driven[i, ACCELERATION]
        holds.point[r] = NO_INDEX
        holds.lock[r] = NO_INDEX
        holds.motion[r] = NO_INDEX
        holds.residual[r] = 0.0
        holds.size[r] = 0.0
        constraints.number[0] = r + 1


@kernel
def add_drive_wrench(i, force, motion, bodies, p, holds, wrench):
    """Add to ``wrench`` (6 nb,) the wrench whose power is ``force`` times the rate that drive ``i``
    prescribes."""
    drive = p.each[i]
    if drive.body == NO_INDEX:
        push_joint(drive.move, drive.axis, force, bodies, motion, wrench)
        return
    clear(holds.conjugate)
    holds.conjugate[drive.dof] = force
    wrench_of_coordinates(drive.body, holds.conjugate, bodies, motion, wrench)


@root
def add_reactions(motion, bodies, p, constraints, holds, wrench):
    """Add the forces of all drives to their rows of ``wrench``."""
    for i in range(p.each.size):
        force = constraints.force[i]
        holds.reaction[p.reaction + i, 0] = force
        add_drive_wrench(i, force, motion, bodies, p, holds, wrench[p.each[i].row])


@root
def add_power(y, bodies, p, holds, rates):
    """Add the power of all drives to the ``rates`` of the integrals of work, row by row."""
    n = bodies.active.size
    for i in range(p.each.size):
        drive = p.each[i]
        rates[drive.row] += holds.reaction[p.reaction + i, 0] * y[n + drive.coordinate]


@kernel
def book_impulses(y, bodies, p, constraints):
    """Book the work of the impulses by which drives keep their rates in a sudden change."""
    n = bodies.active.size
    for i in range(p.each.size):
        drive = p.each[i]
        y[p.losses + drive.row] += constraints.force[i] * y[n + drive.coordinate]


@root
def add_impulses(y, motion, bodies, p, constraints, holds, wrench, impulse, works):
    """Add the impulses of drives on bodies, and their works by coordinate at the velocities of
    ``motion``, to the integrals of y from ``impulse`` and ``works`` on, row by row; ``wrench`` (6
    nb,) is scratch."""
    m = wrench.size
    for i in range(p.each.size):
        clear(wrench)
        add_drive_wrench(i, constraints.force[i], motion, bodies, p, holds, wrench)
        for k in range(m):
            y[impulse + p.each[i].row * m + k] += wrench[k]
            y[works + p.each[i].row * m + k] += wrench[k] * motion.velocity[k]


@kernel
def keep_rates(y, bodies, p, constraints):
    """Set the bounds of all drives to the rates that they prescribe."""
    n = bodies.active.size
    for i in range(p.each.size):
        constraints.bound[i] = y[n + p.each[i].coordinate]


@root
def write_outputs(p, holds, out):
    """Write the forces of all drives to ``out``."""
    for i in range(p.each.size):
        out[DRIVE_OUTPUTS * i] = holds.reaction[p.reaction + i, 0]


class DriveKind(ElementKind):
    unit = "drive"
    variables: ClassVar[Mapping[str, Variable]] = {
        "drive_force": Variable(
            "force or moment of a drive along the motion that it prescribes",
            "N or N m",
            chart=ChartHint("Force of drives", "drive force", Topic.DRIVES),
            is_detail=True,
        ),
    }

    def record(self, p: DriveConstants, bodies: Any, unit_record: UnitRecord) -> Columns:
        return {"drive_force": (("time", self.unit), unit_record.observed[:, :, 0])}


DRIVE_KIND = DriveKind("drives", (Drive,), compile_elements)
