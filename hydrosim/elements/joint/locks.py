"""Joints that are constraints, as kinds of units: their modes, states and forces.

    open      before and after its `active` time         no force
    waiting   active, outside its `Window`               until gap and speed are small enough
    running   a ratchet that moves its way               until it would go back, or a tooth later
    closed    holds                                      a ratchet until its reaction changes sign,
                                                         others until their force exceeds a limit

A joint that closes a loop is always closed, at its place at rest. Any other joint holds the
relative place of the bodies when it closes; that place is in the state. What it stops is lost at
once (`hydrosim.integrate.constraint_projection`). Of a closed joint the column `SEGMENT` of modes
has a bit for each row that is kept: rows that repeat what others hold are dropped.

Limit: a running ratchet without teeth holds as soon as it would go back; its place is then that of
the located event.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import inf, sqrt
from typing import Any, ClassVar, NamedTuple

import numpy as np

from hydrosim.dofs import about_z
from hydrosim.elements import kind as kinds
from hydrosim.elements.contact.geometry import EARTH
from hydrosim.elements.joint import rows
from hydrosim.elements.joint.rows import REFERENCE_SIZE
from hydrosim.jit.kernels import assign, clear, kernel, root
from hydrosim.modes import (
    CONTACT_MARGIN,
    FRICTION_MARGIN,
    MARGINS,
    MODE,
    NO_INDEX,
    SEGMENT,
    SEGMENT_MARGIN,
)
from hydrosim.multibody.kinematics import generalised_force
from hydrosim.multibody.vectors import dot, vector
from hydrosim.scene import ForceElement, Joint, Scene
from hydrosim.scene.joint import MotionKind, Rod

OPEN, WAITING, RATCHETING, CLOSED = range(4)
LOCK_MODES = ("open", "waiting", "running", "closed")
MAX_JOINT_ROWS = 6  # most rows of a joint
ALL_ROW_BITS = 2**MAX_JOINT_ROWS - 1  # bits of six rows
LOCK_LOSS = REFERENCE_SIZE
LOCK_IMPULSE = LOCK_LOSS + 1
LOCK_STATES = LOCK_IMPULSE + 6
"""States of a joint: the reference (12,), the energy lost when it closed, the impulse (6,) on its
body then."""
RATE_ROUNDING = 1e-12  # m/s or rad/s: a ratchet that has just let go is as fast by rounding
TOOTH_TOLERANCE = 1e-9  # m or rad behind a tooth at which a ratchet falls on it
NO_RATCHET, RATCHET_SLIDES, RATCHET_TURNS = range(3)
HELD_TURNS = {0: ((1, 0), (2, 0), (2, 1)), 1: ((1, 0), (2, 0)), 2: ((0, 1),), 3: ()}
"""Pairs of axes (on the other body, on the body) that stay at right angles, by the number of free
turns."""
LOCK = np.dtype(
    [
        *(("joint", int), ("row", int), ("body", int), ("to", int)),
        *(("point", float, 3), ("other", float, 3), ("axes", float, (3, 3))),
        *(
            ("rest", float, REFERENCE_SIZE),
            ("first", int, MAX_JOINT_ROWS),
            ("second", int, MAX_JOINT_ROWS),
            ("count", int),
        ),
        *(("lasts", bool), ("ratchet", int), ("pitch", float), ("gap", float), ("speed", float)),
        *(("strength", float), ("rod", bool)),
    ]
)
"""A joint: its number among all joints, its row of forces, its bodies, its point and axes, the
reference at rest, its rows (axes on the other body and on the body; `NO_INDEX`: a slide). The first
axis of a rod is its direction at rest."""


class LockConstants(NamedTuple):
    """The joints ``each`` (n,) of `LOCK` that are constraints; the number of ``joints`` of the
    scene, and of ``rows`` of constraints at most; the first of their states in y, of their rows of
    modes and of their reactions, and of the integrals of losses in y, row by row."""

    each: np.ndarray
    joints: int
    rows: int
    state: int
    mode: int
    losses: int
    reaction: int


def compile_elements(elements: Mapping[str, ForceElement], layout: kinds.Layout) -> LockConstants:
    """Constants of all joints of the layout that are constraints."""
    order = {name: i for i, name in enumerate(layout.joints)}
    rows = [
        _lock_constants(order[name], layout.joints[name], bodies, layout)
        for name, bodies in layout.constraints.items()
    ]
    constants = np.array(rows, dtype=LOCK)
    return LockConstants(constants, len(order), int(constants["count"].sum()), 0, 0, 0, 0)


def _lock_constants(number: int, joint: Joint, at: Any, layout: kinds.Layout) -> tuple[Any, ...]:
    body, other, exact = at
    if isinstance(joint, Rod):
        point, axes, rest = _rod_at_rest(joint, body, other, exact)
    else:
        point, rest = _reference_at_rest(joint, body, other)
        axes = joint.axes()
        rest = rest if exact else np.zeros(REFERENCE_SIZE)
    gap, speed = joint.window.limits if joint.window else (inf, inf)
    return (
        number,
        layout.joint_row,
        body.number,
        EARTH if other is None else other.number,
        joint.point,
        point,
        axes,
        rest,
        *_row_axes(joint),
        joint.lasts,
        NO_RATCHET if joint.pawl is None else RATCHET_TURNS if joint.pawl.turns else RATCHET_SLIDES,
        joint.pawl.pitch if joint.pawl else 0.0,
        gap,
        speed,
        inf if joint.breaks_at is None else joint.breaks_at,
        isinstance(joint, Rod),
    )


def _reference_at_rest(
    joint: Joint, body: kinds.BodyAtRest, other: kinds.BodyAtRest | None
) -> tuple[np.ndarray, ...]:
    """Point of a joint on the other body, and the exact reference at rest (12,)."""
    turn = about_z(body.heading)
    place = np.array(body.origin) + turn @ np.array(joint.point)
    if other is None:
        return place, np.concatenate([place, turn.ravel()])
    back = about_z(other.heading).T
    point = back @ (place - np.array(other.origin))
    return point, np.concatenate([point, (back @ turn).ravel()])


def _rod_at_rest(
    joint: Rod, body: kinds.BodyAtRest, other: kinds.BodyAtRest | None, exact: bool
) -> tuple[np.ndarray, ...]:
    """Point of a rod on the other body, its direction at rest as first of three axes, and its
    reference (12,)."""
    gap = rod_at_rest(joint, body, other)
    length = float(np.linalg.norm(gap))
    axes = np.eye(3)
    axes[0] = gap / length
    rest = np.zeros(REFERENCE_SIZE)
    rest_length = length if joint.length is None else joint.length
    rest[:3] = (rest_length, 0.0, 0.0) if exact else rest_length * axes[0]
    return np.array(joint.to_point), axes, rest


def rod_at_rest(joint: Rod, body: kinds.BodyAtRest, other: kinds.BodyAtRest | None) -> np.ndarray:
    """Way (3,) [m] from the end of a rod on the other body to that on its body, both at rest."""
    far = np.array(joint.to_point)
    if other is not None:
        far = np.array(other.origin) + about_z(other.heading) @ far
    return np.array(body.origin) + about_z(body.heading) @ np.array(joint.point) - far


def _row_axes(joint: Joint) -> tuple[np.ndarray, np.ndarray, int]:
    """Axes of all rows, and their number."""
    if isinstance(joint, Rod):
        pairs = [(0, NO_INDEX)]
    elif joint.pawl is not None:
        pairs = [(2, 1)] if joint.pawl.turns else [(0, NO_INDEX)]
    else:
        free = {m.axis for m in joint.motions if m.kind == MotionKind.SLIDE}
        turns = sum(m.kind != MotionKind.SLIDE for m in joint.motions)
        pairs = [(k, NO_INDEX) for k in range(3) if k not in free]
        pairs += HELD_TURNS[turns]
    padded = np.array(pairs + [(0, NO_INDEX)] * (MAX_JOINT_ROWS - len(pairs)))
    return padded[:, 0], padded[:, 1], len(pairs)


def states_of(p: LockConstants) -> slice:
    """Entries of y of all joints."""
    return slice(p.state, p.state + LOCK_STATES * int(p.each.size))


@kernel
def first_state(i, p):
    """Entry of y where the states of joint ``i`` begin: first its reference (12,)."""
    return p.state + LOCK_STATES * i


@kernel
def every_row(i, p):
    """Bits of all rows of joint ``i``."""
    return (1 << p.each[i].count) - 1


@kernel
def is_closed(i, modes, p):
    """True if joint ``i`` holds."""
    return modes[p.mode + i, MODE] == CLOSED


@kernel
def any_closed(modes, p):
    """True if any joint holds."""
    for i in range(p.each.size):
        if is_closed(i, modes, p):
            return True
    return False


@kernel
def has_load_limit(modes, p):
    """True if any closed joint opens by its load: a ratchet, or a joint that may break."""
    for i in range(p.each.size):
        opens = p.each[i].ratchet != NO_RATCHET or p.each[i].strength < inf
        if opens and is_closed(i, modes, p):
            return True
    return False


@root
def add_constraints(y, modes, motion, bodies, p, wrench, constraints, holds):
    """Add the constraints of all closed joints; ``wrench`` (6 nb,) is scratch."""
    for i in range(p.each.size):
        if is_closed(i, modes, p):
            _add_lock_rows(
                i, y, modes[p.mode + i, SEGMENT], motion, bodies, p, wrench, constraints, holds
            )


@kernel
def _add_lock_rows(i, y, kept_rows, motion, bodies, p, wrench, constraints, holds):
    """Add the ``kept_rows`` of joint ``i``."""
    lock = p.each[i]
    k = first_state(i, p)
    rest = y[k : k + REFERENCE_SIZE]
    at = rows.pose(lock, rest, bodies, motion)
    for bit in range(lock.count):
        if (kept_rows >> bit) & 1 == 0:
            continue
        r = constraints.number[0]
        row = rows.find_row(lock, bit, at, rest, bodies, motion)
        clear(wrench)
        rows.add_row_wrench(lock, at, row.force, row.moment, bodies, wrench)
        holds.size[r] = _row_size(lock, wrench, bodies)
        generalised_force(bodies, motion, wrench, constraints.J[r])
        constraints.bound[r] = -row.bias
        holds.point[r] = NO_INDEX
        holds.lock[r] = i
        holds.motion[r] = NO_INDEX
        holds.bit[r] = bit
        holds.residual[r] = row.residual
        for a in range(3):
            holds.axis[r, a] = row.force[a]
            holds.axis[r, 3 + a] = row.moment[a]
        constraints.number[0] = r + 1


@kernel
def _row_size(lock, wrench, bodies):
    """Sum of the squares of force and moment on both bodies, over mass and mean inertia."""
    size = 0.0
    for b in (lock.body, lock.to):
        if b != EARTH:
            body = bodies.each[b]
            inertia = (body.inertia[0, 0] + body.inertia[1, 1] + body.inertia[2, 2]) / 3.0
            f = vector(wrench, 6 * b)
            m = vector(wrench, 6 * b + 3)
            size += dot(f, f) / body.mass + dot(m, m) / inertia
    return size


@root
def add_reactions(y, modes, motion, bodies, p, constraints, holds, wrench):
    """Add the reactions of all closed joints to their row of ``wrench`` (rows, 6 nb)."""
    collect_reactions(p, constraints, holds)
    for i in range(p.each.size):
        if is_closed(i, modes, p):
            add_joint_wrench(i, y, holds.joint[i], motion, bodies, p, wrench[p.each[i].row])


@kernel
def add_joint_wrench(i, y, load, motion, bodies, p, wrench):
    """Add force and moment ``load`` (6,) of joint ``i``, and their opposites, to ``wrench`` (6
    nb,)."""
    k = first_state(i, p)
    at = rows.pose(p.each[i], y[k : k + REFERENCE_SIZE], bodies, motion)
    rows.add_row_wrench(p.each[i], at, vector(load, 0), vector(load, 3), bodies, wrench)


@kernel
def collect_reactions(p, constraints, holds):
    """Compute force and moment of every joint, and the reactions of ratchets and of joints that may
    break, from the forces of the constraints."""
    clear_reactions(p, holds)
    for r in range(constraints.number[0]):
        i = holds.lock[r]
        if i != NO_INDEX:
            for a in range(6):
                holds.joint[i, a] += constraints.force[r] * holds.axis[r, a]
            holds.reaction[p.reaction + i, 0] = constraints.force[r]
    for i in range(p.each.size):
        if p.each[i].strength < inf:
            f = vector(holds.joint[i], 0)
            holds.reaction[p.reaction + i, 0] = sqrt(dot(f, f))


@kernel
def clear_reactions(p, holds):
    """Set the reactions of all joints to zero."""
    for i in range(p.each.size):
        clear(holds.joint[i])
        holds.reaction[p.reaction + i, 0] = 0.0


@kernel
def _gap_and_speed(lock, bodies, motion):
    """Distance [m] between the joint's points on both bodies, and their relative speed [m/s], both
    without the slides that the joint leaves free."""
    at = rows.pose(lock, lock.rest, bodies, motion)
    apart = 0.0
    speed = 0.0
    for k in range(lock.count):
        if lock.second[k] == NO_INDEX:
            row = rows.find_row(lock, k, at, lock.rest, bodies, motion)
            apart += row.residual**2
            speed += rows.row_rate(lock, row, at, bodies, motion) ** 2
    return sqrt(apart), sqrt(speed)


@kernel
def _window_excess(lock, bodies, motion):
    """Part by which gap or speed is beyond the window of a joint; negative inside."""
    gap, speed = _gap_and_speed(lock, bodies, motion)
    return max(gap / lock.gap, speed / lock.speed) - 1.0


@kernel
def _ratchet_travel(i, y, bodies, motion, p):
    """Way [m or rad] of ratchet ``i`` from its reference, and its rate."""
    lock = p.each[i]
    k = first_state(i, p)
    rest = y[k : k + REFERENCE_SIZE]
    at = rows.pose(lock, rest, bodies, motion)
    speed = ratchet_rate(i, y, bodies, motion, p)
    if lock.ratchet == RATCHET_TURNS:
        return rows.turn_from_reference(lock, rest, bodies, motion), speed
    return dot(rows.axis_on_other(lock, 0, rest, bodies, motion), at.gap), speed


@kernel
def ratchet_rate(i, y, bodies, motion, p):
    """Rate of ratchet ``i`` in its direction [m/s or rad/s]."""
    lock = p.each[i]
    k = first_state(i, p)
    rest = y[k : k + REFERENCE_SIZE]
    at = rows.pose(lock, rest, bodies, motion)
    a = rows.axis_on_other(lock, 0, rest, bodies, motion)
    zero = (0.0, 0.0, 0.0)
    slides = lock.ratchet == RATCHET_SLIDES
    row = rows.Row(a if slides else zero, zero if slides else a, 0.0, 0.0)
    return rows.row_rate(lock, row, at, bodies, motion)


@root
def find_margins(y, modes, motion, bodies, p, reactions, out):
    """Margins of all joints into ``out``: part outside the window; way or speed of a ratchet and
    way to its next tooth; its reaction [N or N m]."""
    for i in range(p.each.size):
        lock = p.each[i]
        mode = modes[p.mode + i, MODE]
        m = MARGINS * (p.mode + i)
        for k in range(MARGINS):
            out[m + k] = 1.0
        if mode == WAITING:
            out[m + CONTACT_MARGIN] = _window_excess(lock, bodies, motion)
        elif mode == RATCHETING:
            way, speed = _ratchet_travel(i, y, bodies, motion, p)
            out[m + CONTACT_MARGIN] = way + TOOTH_TOLERANCE if lock.pitch > 0.0 else speed
            out[m + SEGMENT_MARGIN] = lock.pitch - way if lock.pitch > 0.0 else 1.0
        elif mode == CLOSED and lock.ratchet != NO_RATCHET:
            out[m + FRICTION_MARGIN] = reactions[p.reaction + i, 0]
            if modes[p.mode + i, SEGMENT] == 0:  # a drive at rest holds it, and may move on
                out[m + FRICTION_MARGIN] = RATE_ROUNDING - ratchet_rate(i, y, bodies, motion, p)
        elif mode == CLOSED and lock.strength < inf:
            out[m + FRICTION_MARGIN] = lock.strength - reactions[p.reaction + i, 0]


@root
def transition(i, which, y, modes, motion, bodies, p):
    """Switch joint ``i`` to its next mode, after margin ``which`` has reached zero."""
    lock = p.each[i]
    k = first_state(i, p)
    if which == SEGMENT_MARGIN:
        turns = lock.ratchet == RATCHET_TURNS
        rows.advance_reference(lock, turns, lock.pitch, bodies, y[k : k + REFERENCE_SIZE])
    elif which == FRICTION_MARGIN:
        modes[p.mode + i, MODE] = RATCHETING if lock.ratchet != NO_RATCHET else OPEN
    elif lock.pitch > 0.0:
        modes[p.mode + i, MODE] = CLOSED
    else:
        close_lock(i, y, modes, motion, bodies, p)


@kernel
def close_lock(i, y, modes, motion, bodies, p):
    """Close joint ``i`` at the present place. The axis of a ratchet stays where it is on the other
    body."""
    lock = p.each[i]
    k = first_state(i, p)
    reference = y[k : k + REFERENCE_SIZE]
    if lock.ratchet == NO_RATCHET:
        rows.take_reference(lock, bodies, motion, reference)
    else:
        way, _ = _ratchet_travel(i, y, bodies, motion, p)
        rows.advance_reference(lock, lock.ratchet == RATCHET_TURNS, way, bodies, reference)
    modes[p.mode + i, MODE] = CLOSED
    modes[p.mode + i, SEGMENT] = every_row(i, p)


@kernel
def goes_back(i, y, modes, bodies, motion, p):
    """True if joint ``i`` is a running ratchet without teeth that goes back."""
    if modes[p.mode + i, MODE] != RATCHETING or p.each[i].pitch > 0.0:
        return False
    return ratchet_rate(i, y, bodies, motion, p) < -RATE_ROUNDING


@kernel
def activate(i, y, modes, motion, bodies, p):
    """Activate joint ``i``: it closes at once, unless it waits for its window or is a ratchet."""
    lock = p.each[i]
    if lock.ratchet != NO_RATCHET:
        k = first_state(i, p)
        rows.take_reference(lock, bodies, motion, y[k : k + REFERENCE_SIZE])
        modes[p.mode + i, MODE] = RATCHETING
        modes[p.mode + i, SEGMENT] = every_row(i, p)
        if ratchet_rate(i, y, bodies, motion, p) <= 0.0:
            modes[p.mode + i, MODE] = CLOSED
    elif _window_excess(lock, bodies, motion) <= 0.0:
        close_lock(i, y, modes, motion, bodies, p)
    else:
        modes[p.mode + i, MODE] = WAITING


@kernel
def deactivate(i, modes, p):
    """Open joint ``i``."""
    modes[p.mode + i, MODE] = OPEN


@root
def set_initial_modes(y, modes, motion, bodies, p):
    """Modes and references of all joints for a start; rows that are known to be kept stay so."""
    for i in range(p.each.size):
        mode = modes[p.mode + i]
        kept_rows = mode[SEGMENT]
        if p.each[i].lasts:
            k = first_state(i, p)
            assign(y[k : k + REFERENCE_SIZE], p.each[i].rest)
            mode[MODE] = CLOSED
        else:
            activate(i, y, modes, motion, bodies, p)
        mode[SEGMENT] = kept_rows if kept_rows > 0 else every_row(i, p)


@root
def write_outputs(p, holds, out):
    """Write force and moment (6,) of every joint of the scene to ``out``; zero of those that are no
    constraints, or open."""
    for i in range(p.each.size):
        for a in range(6):
            out[6 * p.each[i].joint + a] = holds.joint[i, a]


# Joints as kinds of units: locks, and the forces of all joints.

LOCK_STATE_NAMES = (
    *(f"reference {k + 1}" for k in range(REFERENCE_SIZE)),
    "energy lost",
    *(f"impulse of {force}" for force in ("force x", "force y", "force z")),
    *(f"impulse of {moment}" for moment in ("moment x", "moment y", "moment z")),
)


@kernel
def guard_dependencies(i, p):
    """Range of the states that margins of joint ``i`` depend on."""
    k = p.state + LOCK_STATES * i
    return k, k + REFERENCE_SIZE


class LockKind(kinds.ElementKind):
    unit = "lock"
    variables: ClassVar[Mapping[str, kinds.Variable]] = {
        "lock_mode": kinds.Variable(
            "mode of a joint that is a constraint", "1", flags=" ".join(LOCK_MODES)
        ),
        "lock_segment": kinds.Variable("bits of the rows of a joint that are not redundant", "1"),
        "lock_rows": kinds.Variable(
            "number of relative motions that a joint holds; those that others hold do not count",
            "1",
            is_detail=True,
        ),
        "lock_impulse": kinds.Variable(
            "impulses of a joint on its body since the start, when joints closed; moment about the"
            " joint",
            "N s or N m s",
            "earth",
            is_detail=True,
        ),
        "lock_loss": kinds.Variable(
            "energy lost since the start, when the joint closed", "J", is_detail=True
        ),
    }

    def unit_names(self, scene: Scene) -> list[str]:
        return list(kinds.constraint_names(scene))

    def modes(self, p: LockConstants) -> kinds.ModeRows:
        count = p.each.size
        return kinds.ModeRows(
            count, first=np.zeros(count, dtype=int), last=np.full(count, ALL_ROW_BITS)
        )

    def states(self, p: LockConstants, scene: Scene) -> Iterator[kinds.StateBlocks]:
        yield kinds.StateBlocks("lock", self.unit_names(scene), LOCK_STATE_NAMES)

    def record(self, p: LockConstants, bodies: Any, unit_record: kinds.UnitRecord) -> kinds.Columns:
        count = p.each.size
        lock_states = unit_record.y[p.state : p.state + LOCK_STATES * count].reshape(
            -1, count, LOCK_STATES
        )
        return {
            "lock_mode": (("time", "lock"), unit_record.modes[:, :, MODE].astype(np.int8)),
            "lock_impulse": (("time", "lock", "dof"), lock_states[:, :, LOCK_IMPULSE:LOCK_STATES]),
            "lock_loss": (("time", "lock"), lock_states[:, :, LOCK_LOSS]),
            "lock_rows": (("time", "lock"), _held_rows(unit_record.modes)),
        }

    def is_mirrored(self, p: LockConstants, y: np.ndarray, modes: np.ndarray) -> bool:
        """True if all joints are in the same mode; others may be mirrored too."""
        lock_modes = modes[p.mode : p.mode + p.each.size, MODE]
        return bool((lock_modes == lock_modes[:1]).all())

    def clear_unused_states(self, p: LockConstants, y: np.ndarray) -> None:
        """No state of a joint lacks meaning after a restart."""

    def renew(
        self,
        p: LockConstants,
        y: np.ndarray,
        anew: np.ndarray,
        possible: np.ndarray,
        known_states: np.ndarray,
    ) -> None:
        """References of loops, and of joints that the earlier run did not have, are those of
        now."""
        for i, lock in enumerate(p.each):
            reference = slice(p.state + LOCK_STATES * i, p.state + LOCK_STATES * i + REFERENCE_SIZE)
            if lock["lasts"] or not known_states[reference].all():
                y[reference] = anew[reference]


def _held_rows(modes: np.ndarray) -> np.ndarray:
    """Number (nt, n) of the rows that each joint holds."""
    bits = np.unpackbits(modes[:, :, SEGMENT].astype(np.uint8)[..., None], axis=2).sum(axis=2)
    return np.where(modes[:, :, MODE] == CLOSED, bits, 0).astype(np.int8)


class JointLoadKind(kinds.UnitKind):
    unit = "joint"
    variables: ClassVar[Mapping[str, kinds.Variable]] = {
        "joint_force": kinds.Variable(
            *("force and moment of a joint at its point on its body", "N or N m", "earth"),
            chart=kinds.NO_CHART._replace(rank=kinds.Topic.JOINTS + 1),
            summary=[
                kinds.SummaryColumn(f"largest {size}", f"largest {size}")
                for size in ("force", "moment")
            ],
        ),
    }

    def constants_in(self, parts: kinds.KindConstants) -> LockConstants:
        constants: LockConstants = parts.elements.locks
        return constants

    def unit_names(self, scene: Scene) -> list[str]:
        return list(scene.joints)

    def record(self, p: LockConstants, bodies: Any, unit_record: kinds.UnitRecord) -> kinds.Columns:
        return {"joint_force": (("time", "joint", "dof"), unit_record.observed)}


LOCK_KIND = LockKind("locks", (), compile_elements)
JOINT_LOAD_KIND = JointLoadKind()
