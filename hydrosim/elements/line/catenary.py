"""Catenary: a mooring line of segments between a point of a body and an anchor, in static balance.

    F = H e - V k - c (v - u)_perp + m u_perp,   F_anchor = -H_a e + V_a k

H, V: horizontal and downward pull at the fairlead; e: horizontal direction to the anchor; k: up;
H_a, V_a: the same at the anchor. They follow from the distance x along e, the height z of the
fairlead above the anchor, and the height of the seabed (`line.shape`: elastic catenary, segments,
clumps, buoys, seabed with friction). The anchor is on the earth or on another body.

The drag c (v - u)_perp acts at the fairlead, across the line there; v: velocity of the fairlead; u:
current. c and m stand for the quadratic drag of the whole line, linearised (`compile.line_drag`).

The solution of the last accepted step is in the state. It is the first guess of the next solution,
which does not depend on it. Modes are profiles: which segment touches down, where the friction of
the bed ends, whether the line is slack. The slope of the stiffness jumps from one profile to the
next, and the tension has a kink in its second derivative. A kink is an event where it is
`SHARP_KINK` over a step, the line is nearly slack, or its tension passes a corner of a curve of
tension over stretch: there the stiffness of a light line jumps. Other kinks are passed: they change
the impulse of the line in that step by less than 3e-5 of its tension times the step.

Without friction of the bed, the line has a potential: strain energy plus weight in water times
height. The drag is its loss, and so is the work of a length that changes, with the opposite sign.
With friction of the bed there is no potential, and the stiffness is not symmetric. All work of the
line is then its loss, of either sign.

Limits: no inertia and no dynamic tension of the line; friction across the line is neglected, and
the line lies in one vertical plane. With small angles lever arms stay as they are at rest.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, nan, sqrt
from typing import NamedTuple

import numpy as np

from hydrosim.elements.contact.geometry import EARTH
from hydrosim.elements.kind import Layout
from hydrosim.elements.line import search, shape
from hydrosim.elements.line.hang import SuspendedLine, branch_at, branch_law, pieces_of_segments
from hydrosim.elements.signal import SIGNAL, compile_signals, value, value_at
from hydrosim.elements.signal import rate as signal_rate
from hydrosim.errors import InputError
from hydrosim.jit.kernels import clear, kernel, root, root_giving
from hydrosim.modes import (
    ACTING,
    INACTIVE,
    MARGINS,
    MODE,
    NO_INDEX,
    RISING,
    SEGMENT,
    SEGMENT_MARGIN,
    UNDEFINED,
)
from hydrosim.multibody.kinematics import LINE_PIECE, add_wrench, attachment, point_velocity
from hydrosim.multibody.vectors import cross, dot, scale, sub, vector
from hydrosim.scene import ForceElement
from hydrosim.scene.catenary import Catenary
from hydrosim.scene.signal import constant
from hydrosim.water.current import current_at, mean_current

TAUT_LINE = UNDEFINED + 1
"""Modes; lines are `TAUT_LINE` in postures alone."""
FAIRLEAD_TENSION, ANCHOR_TENSION, HORIZONTAL, GROUNDED, CATENARY_OUTPUTS = range(
    5
)  # see `write_outputs`
GUESS = (
    "horizontal pull",
    "vertical pull",
    "span",
    "height",
    "H by x",
    "H by z",
    "V by x",
    "V by z",
)
"""States of each line: its last solution H, V [N], the x and z there [m], and its stiffness
[N/m]."""
CATENARY_STATES = len(GUESS)
FIRST_LOOK_AHEAD_S = 1e-10  # s: first look ahead for the next profile
LAST_LOOK_AHEAD_S = 1e-2  # s: and the last
ON_BED = 1e-6  # m: an anchor this close to the seabed is on it
SHARP_KINK = (
    1e-3  # of the tension: what a kink adds to the trapezoidal sum of the stiffness, at least
)
NEARLY_SLACK = shape.MAX_SLACK_PULL  # of the weight: horizontal pull below which slack may be near


CATENARY = np.dtype(
    [
        *(("body", int), ("row", int), ("point", float, 3)),
        *(("anchor_body", int), ("anchor", float, 3)),
        *(("first", int), ("last", int), ("bed", float), ("friction", float)),
        *(("width", float), ("damping", float), ("drift", float), ("stream", float, 2)),
        *(("paying", int), ("paid", SIGNAL), ("potential", bool), ("datum", float)),
    ]
)
"""Constants of a line: its ends, its pieces ``first`` <= k < ``last``, the height of the seabed,
its friction; the largest ``width`` of drag; ``damping`` c and ``drift`` m of the drag, the current;
the piece that changes its length, and this length; whether it has a potential, which counts from
the height ``datum`` of the anchor at rest."""


class CatenaryConstants(NamedTuple):
    """``lines`` (n,) of `CATENARY`, their ``pieces`` of `LINE_PIECE` with the ``widths`` [m] of
    drag, the pieces of their ``signals``; the first of their states in y and of their rows of
    modes."""

    lines: np.ndarray
    pieces: np.ndarray
    widths: np.ndarray
    signals: np.ndarray
    state: int
    mode: int


class EndKinematics(NamedTuple):
    """Place of one line: lever arms of its ends, horizontal direction ``e`` to the anchor, distance
    ``x`` along it, height ``z`` of the fairlead above the anchor, height ``bed`` of the seabed
    above the anchor, height of the ``anchor`` above the still water, velocities ``v`` and ``w`` of
    both ends."""

    arm: tuple[float, float, float]
    anchor_arm: tuple[float, float, float]
    e: tuple[float, float]
    x: float
    z: float
    bed: float
    anchor: float
    v: tuple[float, float, float]
    w: tuple[float, float, float]


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> CatenaryConstants:
    """Constants of the catenaries among ``elements``, in their order. Raises InputError for lines
    that need a seabed where there is none, or begin below it."""
    catenaries = {name: e for name, e in elements.items() if isinstance(e, Catenary)}
    signals, signal_pieces = compile_signals([e.paid or constant(0.0) for e in catenaries.values()])
    rows = []
    pieces = [np.zeros(0, dtype=LINE_PIECE)]
    first = 0
    for (name, e), signal in zip(catenaries.items(), signals, strict=True):
        anchor, bed = _anchor_and_bed(name, e, layout)
        last = first + len(e.segments)
        end = EARTH if e.anchor_body is None else layout.body[e.anchor_body]
        ends = (layout.body[e.body], layout.row[name], e.point, end, anchor)
        friction = e.friction or 0.0
        drag = (e.drag_width.max(), 0.0, 0.0, _current_on(e, layout))
        datum = layout.place_at_rest(e.anchor_body, anchor)[2]
        paying = NO_INDEX if e.paid is None else 0
        paid = (paying, signal, friction == 0.0, datum)
        rows.append((*ends, first, last, bed, friction, *drag, *paid))
        pieces.append(pieces_of_line(e))
        first = last
    widths = np.concatenate([np.zeros(0), *(e.drag_width for e in catenaries.values())])
    every = np.concatenate(pieces)
    return CatenaryConstants(np.array(rows, dtype=CATENARY), every, widths, signal_pieces, 0, 0)


def _current_on(line: Catenary, layout: Layout) -> tuple[float, float]:
    """Velocity (2,) [m/s] of the current on a line: the mean over the depths of its upper half,
    which moves most with the fairlead."""
    top = -float(layout.place_at_rest(line.body, line.point)[2])
    end = -float(layout.place_at_rest(line.anchor_body, line.anchor)[2])
    middle = 0.5 * (top + end)
    low, high = sorted((max(top, 0.0), max(middle, 0.0)))
    if high - low < ON_BED:
        x, y = current_at(layout.current_profile, low)
        return float(x), float(y)
    return mean_current(layout.current_profile, low, high)


def pieces_of_line(line: Catenary, t: float = 0.0) -> np.ndarray:
    """The segments, of `LINE_PIECE`, with the length that is paid out at a time [s]."""
    pieces = pieces_of_segments(line.segments)
    if line.paid is not None:
        pieces["length"][0] = value_at(line.paid, t)
    return pieces


def _anchor_and_bed(name: str, line: Catenary, layout: Layout) -> tuple[tuple[float, ...], float]:
    """The anchor, exactly on the seabed if it is close to it, and the height of the seabed."""
    if line.friction is None:
        return line.anchor, -inf
    if not np.isfinite(layout.depth):
        raise InputError(
            f"forces.{name}.seabed: found a seabed where the water depth is infinite; expected"
            " environment.water_depth, at which the seabed is. Without the key seabed, a line does"
            " not touch it."
        )
    height = float(layout.place_at_rest(line.anchor_body, line.anchor)[2])
    if height < -layout.depth - ON_BED:
        raise InputError(
            f"forces.{name}.anchor: found an anchor at {height:g} m, below the seabed at"
            f" {-layout.depth:g} m; expected an anchor on it or above it."
        )
    if line.anchor_body is None and abs(height + layout.depth) <= ON_BED:
        return (*line.anchor[:2], -layout.depth), -layout.depth
    return line.anchor, -layout.depth


@kernel
def end_kinematics(line, bodies, motion):
    """Place of a line, as a `EndKinematics`. Where one end is above the other, it has no
    direction."""
    p, arm = attachment(line.body, vector(line.point, 0), bodies, motion)
    v = point_velocity(line.body, arm, motion)
    a = vector(line.anchor, 0)
    anchor_arm = (0.0, 0.0, 0.0)
    w = (0.0, 0.0, 0.0)
    if line.anchor_body != EARTH:
        a, anchor_arm = attachment(line.anchor_body, a, bodies, motion)
        w = point_velocity(line.anchor_body, anchor_arm, motion)
    d = sub(a, p)
    x = sqrt(d[0] * d[0] + d[1] * d[1])
    per = 1.0 / x if x > 0.0 else 0.0
    return EndKinematics(
        arm, anchor_arm, (d[0] * per, d[1] * per), x, -d[2], line.bed - a[2], a[2], v, w
    )


@kernel
def suspended_line(line, s, pieces):
    """The `SuspendedLine` of a line over its `EndKinematics` ``s``."""
    return SuspendedLine(pieces, line.first, line.last, s.x, s.z, s.bed, line.friction)


@root_giving(float, float, float, float, float, float, bool, int)
def pull_entries(line, H, V):
    """The entries of the `shape.LinePull` of a `SuspendedLine`, with the guess H, V."""
    a = shape.solve(line, H, V)
    return a.H, a.V, a.anchor_V, a.anchor_H, a.touch, a.dead, a.converged, a.reason


@kernel
def solve_from_guess(i, s, H, V, pieces, p):
    """The `shape.LinePull` of line ``i`` over its `EndKinematics` ``s``, with the guess H, V."""
    H, V, anchor_V, anchor_H, touch, dead, converged, reason = pull_entries(
        suspended_line(p.lines[i], s, pieces), H, V
    )
    return shape.LinePull(H, V, anchor_V, anchor_H, touch, dead, converged, reason)


@root_giving(float, float, float, float, float, float, bool, int)
def rebuild_pull_entries(line, H, V):
    """`pull_entries` where H, V are the solution itself."""
    a = shape.rebuild_pull(line, H, V)
    return a.H, a.V, a.anchor_V, a.anchor_H, a.touch, a.dead, a.converged, a.reason


@kernel
def rebuild_pull(line, s, H, V, pieces):
    """The `shape.LinePull` of a line whose solution over its `EndKinematics` ``s`` is H, V."""
    H, V, anchor_V, anchor_H, touch, dead, converged, reason = rebuild_pull_entries(
        suspended_line(line, s, pieces), H, V
    )
    return shape.LinePull(H, V, anchor_V, anchor_H, touch, dead, converged, reason)


@kernel
def solve_line(i, t, y, s, motion, p):
    """The `shape.LinePull` of line ``i``, and its pieces as they are now. A length that changes is
    written to the scratch ``motion.pieces``."""
    line = p.lines[i]
    k = p.state + CATENARY_STATES * i
    pieces = p.pieces
    if line.paying != NO_INDEX:
        pieces = motion.pieces
        pieces[line.first + line.paying].length = value(t, line.paid, p.signals)
    dx = s.x - y[k + 2]
    dz = s.z - y[k + 3]
    if dx == 0.0 and dz == 0.0 and line.paying == NO_INDEX:
        pull = rebuild_pull(line, s, y[k], y[k + 1], pieces)
        if pull.converged:
            return pull, pieces
    H = y[k] + y[k + 4] * dx + y[k + 5] * dz
    V = y[k + 1] + y[k + 6] * dx + y[k + 7] * dz
    near = y[k] <= 2.0 * H
    if not near:
        H = y[k]
        V = y[k + 1]
    return solve_from_guess(i, s, H, V, pieces, p), pieces


@root
def add_force(t, y, modes, motion, bodies, p, loads):
    """Add the force [N, N m] of every line to its row of ``wrench``, and the power [W] that it
    loses to ``rate``, in place."""
    for i in range(p.lines.size):
        line = p.lines[i]
        for k in range(CATENARY_STATES):
            loads.dy[p.state + CATENARY_STATES * i + k] = 0.0
        mode = modes[p.mode + i, MODE]
        if mode == INACTIVE:
            continue
        s = end_kinematics(line, bodies, motion)
        pull, pieces = solve_line(i, t, y, s, motion, p)
        drag = find_drag(line, s, pull)
        if mode == UNDEFINED:  # ends the run
            drag = (nan, nan, nan)
        loads.rate[line.row] -= dot(drag, s.v)
        add_ends(line, s, pull, drag, loads.wrench, loads.rate)
        if line.potential and line.paying != NO_INDEX:
            loads.rate[line.row] -= paid_energy(line, s, pull, pieces) * signal_rate(
                t, line.paid, p.signals
            )


@kernel
def add_ends(line, s, pull, drag, wrench, rate):
    """Add the forces on both ends to the row of ``wrench``. Without a potential, their work is a
    loss."""
    e = s.e
    static = (pull.H * e[0], pull.H * e[1], -pull.V)
    force = (static[0] + drag[0], static[1] + drag[1], static[2] + drag[2])
    add_wrench(line.body, force, cross(s.arm, force), wrench[line.row])
    anchored = (-pull.anchor_H * e[0], -pull.anchor_H * e[1], pull.anchor_V)
    if line.anchor_body != EARTH:
        moment = cross(s.anchor_arm, anchored)
        add_wrench(line.anchor_body, anchored, moment, wrench[line.row])
    if not line.potential:
        rate[line.row] -= dot(static, s.v) + dot(anchored, s.w)


@kernel
def paid_energy(line, s, pull, pieces):
    """Energy stored per length [N] that is added at the fairlead: w z - T - integral of eps dT."""
    piece = pieces[line.first]
    T2 = pull.H * pull.H + pull.V * pull.V
    T = sqrt(T2)
    EA, o, c = branch_law(piece, branch_at(piece, T))
    height = s.z + s.anchor - line.datum
    return piece.weight * height - T - 0.5 * T2 / EA - o * T - c


@kernel
def find_drag(line, s, pull):
    """The linearised drag [N] at the fairlead, across the line there."""
    u = mean_current_past_line(line)
    T2 = pull.H * pull.H + pull.V * pull.V
    per = 1.0 / sqrt(T2) if T2 > 0.0 else 0.0
    along = (pull.H * per * s.e[0], pull.H * per * s.e[1], -pull.V * per)
    c = line.damping
    m = line.drift
    w = (m * u[0] - c * s.v[0], m * u[1] - c * s.v[1], -c * s.v[2])
    return sub(w, scale(dot(w, along), along))


@kernel
def mean_current_past_line(line):
    """Velocity of the water [m/s] past a line: the mean current over its depth."""
    return line.stream[0], line.stream[1]


@root
def add_energy(t, y, modes, motion, bodies, p, stored):
    """Add the energy stored in every line with a potential to its row of ``stored``."""
    for i in range(p.lines.size):
        line = p.lines[i]
        if modes[p.mode + i, MODE] == INACTIVE or not line.potential:
            continue
        s = end_kinematics(line, bodies, motion)
        pull, pieces = solve_line(i, t, y, s, motion, p)
        U = search.stored_energy(suspended_line(line, s, pieces), pull)
        stored[line.row] += U + total_weight(line, pieces) * (s.anchor - line.datum)


@kernel
def total_weight(line, pieces):
    """Weight in water of a line and all that hangs on it but at its anchor [N]."""
    total = 0.0
    for k in range(line.first, line.last):
        total += pieces[k].weight * pieces[k].length
        if k + 1 < line.last:
            total += pieces[k].hung
    return total


@root_giving(float)
def tension_of(i, t, y, modes, motion, bodies, p):
    """Tension [N] at the fairlead of line ``i``, 0 where it is gone."""
    if modes[p.mode + i, MODE] == INACTIVE:
        return 0.0
    pull, _ = solve_line(i, t, y, end_kinematics(p.lines[i], bodies, motion), motion, p)
    return sqrt(pull.H * pull.H + pull.V * pull.V)


@root
def write_outputs(t, y, modes, motion, bodies, p, out):
    """Write rows of `CATENARY_OUTPUTS` of all lines to ``out``: tensions at the fairlead and the
    anchor, horizontal pull at the fairlead, length on the seabed."""
    for i in range(p.lines.size):
        row = out[CATENARY_OUTPUTS * i : CATENARY_OUTPUTS * (i + 1)]
        for k in range(CATENARY_OUTPUTS):
            row[k] = 0.0
        if modes[p.mode + i, MODE] != INACTIVE:
            line = p.lines[i]
            pull, pieces = solve_line(i, t, y, end_kinematics(line, bodies, motion), motion, p)
            row[FAIRLEAD_TENSION] = sqrt(pull.H * pull.H + pull.V * pull.V)
            row[ANCHOR_TENSION] = sqrt(pull.anchor_H * pull.anchor_H + pull.anchor_V**2)
            row[HORIZONTAL] = pull.H
            row[GROUNDED] = full_length(line, pieces) - pull.touch


@kernel
def full_length(line, pieces):
    """Unstretched length [m] of a line."""
    total = 0.0
    for k in range(line.first, line.last):
        total += pieces[k].length
    return total


@root
def find_margins(t, y, modes, motion, bodies, p, watched, out):
    """Margins of the ``watched`` lines into ``out`` (4 to a row of modes): the room in their
    profile; inf of the others."""
    for i in range(p.lines.size):
        line = p.lines[i]
        row = p.mode + i
        fill_margins(row, inf, out)
        if watched[row] != 0 and modes[row, MODE] == ACTING:
            s = end_kinematics(line, bodies, motion)
            pull, pieces = solve_line(i, t, y, s, motion, p)
            fill_margins(row, room_of(line, s, pull, modes[row, SEGMENT], pieces), out)


@kernel
def fill_margins(row, room, out):
    """Margins of a row of modes: its ``room``, and three that no line has."""
    m = MARGINS * row
    for k in range(MARGINS):
        out[m + k] = inf
    out[m + SEGMENT_MARGIN] = room


@root
def update_at_step_end(t, y, modes, motion, bodies, p, watched, out):
    """Look at all lines at the end of a step, whose state ``y`` has the solutions of its start.

    Solutions become guesses in ``y``. Kinks that are not sharp are passed. Lines that are nearly
    slack at both ends of the step, and those at a sharp kink, are ``watched``. Margins go to
    ``out``, inf where nothing can end."""
    for i in range(p.lines.size):
        row = p.mode + i
        watched[row] = 0
        fill_margins(row, inf, out)
        if modes[row, MODE] != ACTING:
            continue
        line = p.lines[i]
        k = p.state + CATENARY_STATES * i
        s = end_kinematics(line, bodies, motion)
        pull, pieces = solve_line(i, t, y, s, motion, p)
        if not pull.converged:  # `store_step_solutions` reports it
            continue
        slack_before = is_nearly_slack(line, y[k], modes[row, SEGMENT], pieces)
        stiffness = stiffness_of(line, s, pull, pieces)
        number = profile_of(line, s, pull, pieces)
        sharp = number != modes[row, SEGMENT] and (
            slack_before
            or line.paying != NO_INDEX
            or number // shape.CORNER_CODE != modes[row, SEGMENT] // shape.CORNER_CODE
            or is_sharp(y[k : k + CATENARY_STATES], s, pull, stiffness)
        )
        write_guess(y[k : k + CATENARY_STATES], s, pull, stiffness)
        if not sharp:
            modes[row, SEGMENT] = number
        slack = is_nearly_slack(line, pull.H, number, pieces)
        watched[row] = 1 if sharp or (slack and slack_before) else 0
        if sharp or slack:
            fill_margins(row, room_of(line, s, pull, modes[row, SEGMENT], pieces), out)


@kernel
def is_nearly_slack(line, H, number, pieces):
    """True if a line with H in the profile ``number`` may become slack, or tight, soon."""
    weight = abs(total_weight(line, pieces))
    return number & shape.SLACK_CODE != 0 or NEARLY_SLACK * weight > H


@kernel
def is_sharp(guess, s, pull, stiffness):
    """True if the pull changes otherwise over a step than by the mean of the stiffnesses at its
    ends, by `SHARP_KINK` or more. ``guess`` are the states of `GUESS` at its start."""
    dx = 0.5 * (s.x - guess[2])
    dz = 0.5 * (s.z - guess[3])
    Hx, Hz, Vx, Vz = stiffness
    off_H = pull.H - guess[0] - (guess[4] + Hx) * dx - (guess[5] + Hz) * dz
    off_V = pull.V - guess[1] - (guess[6] + Vx) * dx - (guess[7] + Vz) * dz
    tension2 = pull.H * pull.H + pull.V * pull.V
    return off_H * off_H + off_V * off_V > SHARP_KINK * SHARP_KINK * tension2


@kernel
def room_of(line, s, pull, number, pieces):
    """Room of a line in the profile of this ``number``."""
    return shape.kink_room(suspended_line(line, s, pieces), pull, number)


@root
def transition(i, t, y, modes, motion, bodies, p):
    """Switch line ``i`` to its next profile: that of the line a moment later, because an event is
    located a little before its kink. `FIRST_LOOK_AHEAD_S` doubles until the profile is another
    one."""
    line = p.lines[i]
    mode = modes[p.mode + i]
    s = end_kinematics(line, bodies, motion)
    rate = (s.w[0] - s.v[0]) * s.e[0] + (s.w[1] - s.v[1]) * s.e[1]
    ahead = FIRST_LOOK_AHEAD_S
    while ahead < LAST_LOOK_AHEAD_S:
        x = abs(s.x + ahead * rate)
        z = s.z + ahead * (s.v[2] - s.w[2])
        bed = s.bed - ahead * s.w[2]
        later = EndKinematics(s.arm, s.anchor_arm, s.e, x, z, bed, s.anchor, s.v, s.w)
        pull, pieces = solve_line(i, t + ahead, y, later, motion, p)
        number = profile_of(line, later, pull, pieces)
        if pull.converged and number != mode[SEGMENT]:
            mode[SEGMENT] = number
            return
        ahead *= 2.0
    pull, pieces = solve_line(i, t, y, s, motion, p)
    if not pull.converged:
        store_solution(i, y, modes, s, pull, pieces, p)


@kernel
def profile_of(line, s, pull, pieces):
    """Number of the profile of a line."""
    return shape.find_profile(suspended_line(line, s, pieces), pull)


@root
def set_initial_modes(t, y, modes, motion, bodies, p):
    """Modes and first guesses of all lines for a start."""
    for i in range(p.lines.size):
        set_initial_mode(i, t, y, modes, motion, bodies, p)


@kernel
def set_initial_mode(i, t, y, modes, motion, bodies, p):
    """Mode and guess of line ``i`` when it becomes active."""
    line = p.lines[i]
    k = p.state + CATENARY_STATES * i
    clear(y[k : k + CATENARY_STATES])
    y[k] = -1.0  # no guess
    s = end_kinematics(line, bodies, motion)
    pull, pieces = solve_line(i, t, y, s, motion, p)
    store_solution(i, y, modes, s, pull, pieces, p)
    modes[p.mode + i, SEGMENT] = profile_of(line, s, pull, pieces)


@kernel
def store_solution(i, y, modes, s, pull, pieces, p):
    """Keep a solution, and its stiffness, for the next guesses; a line without one is lost."""
    k = p.state + CATENARY_STATES * i
    line = p.lines[i]
    write_guess(y[k : k + CATENARY_STATES], s, pull, stiffness_of(line, s, pull, pieces))
    modes[p.mode + i, MODE] = ACTING if pull.converged else UNDEFINED
    modes[p.mode + i, RISING] = pull.reason


@kernel
def write_guess(guess, s, pull, stiffness):
    """Write a solution and its stiffness to the states ``guess`` of `GUESS`."""
    guess[0] = pull.H
    guess[1] = pull.V
    guess[2] = s.x
    guess[3] = s.z
    guess[4], guess[5], guess[6], guess[7] = stiffness


@kernel
def stiffness_of(line, s, pull, pieces):
    """dH/dx, dH/dz, dV/dx, dV/dz [N/m] of a line."""
    return search.stiffness(suspended_line(line, s, pieces), pull)


@kernel
def deactivate(i, modes, p):
    """Deactivate line ``i``."""
    modes[p.mode + i, MODE] = INACTIVE


@root
def store_step_solutions(t, y, modes, motion, bodies, p, watched):
    """Keep the solutions of an accepted step as the next guesses, where `update_at_step_end` has
    not: if the step was cut since then, if lengths change or if there is no solution. Lines that
    are not ``watched`` may not have reached their kink yet."""
    for i in range(p.lines.size):
        row = p.mode + i
        if modes[row, MODE] == ACTING:
            line = p.lines[i]
            k = p.state + CATENARY_STATES * i
            s = end_kinematics(line, bodies, motion)
            if s.x == y[k + 2] and s.z == y[k + 3] and line.paying == NO_INDEX:
                continue
            pull, pieces = solve_line(i, t, y, s, motion, p)
            store_solution(i, y, modes, s, pull, pieces, p)
            if pull.converged and watched[row] == 0:
                modes[row, SEGMENT] = profile_of(line, s, pull, pieces)
