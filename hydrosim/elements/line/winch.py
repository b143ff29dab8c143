"""Winches: wires from a point of a body to an anchor, whose length a drum changes, as a kind.

    e = l / l0 - 1,   T = max(0, EA (e + c e')),   e' = l'/l0 - l l0'/l0^2,   F = T (a - p) / l

l = |a - p|: distance from the point p, which receives F, to the anchor a on the earth or on another
body, which receives -F; l0: length of wire off the drum without load; EA: stiffness per strain; c:
damping, as a time. Which of both ends has the drum does not matter. l0' is the speed of pay-out s
of the drum (`hydrosim.elements.line.drum`). While l < l0 the wire is slack, T = 0. Slack and taut
are events, and so are the moments where damping alone would push.

Stored energy is EA e^2 l0 / 2. What the bodies lose to the winch beyond it is booked as its loss,

    (T - EA e) l' + EA e (1 + e/2) l0'

which is the damping, the power T l0' that goes into the drum, and the strain energy of the wire
that goes there with it. It is negative when a drum heaves in. T l0' is recorded in two parts: the
friction of the drum, and the work of its drive.

Limits: no mass, no sag and no drag of the wire. With damping, T jumps where a wire snaps taut. What
a snap load is depends on mass and damping of the wire: programs disagree on it by a factor of two.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from math import inf
from typing import Any, ClassVar, NamedTuple

import numpy as np

from hydrosim.elements import kind as kinds
from hydrosim.elements.contact.geometry import EARTH
from hydrosim.elements.line import drum
from hydrosim.elements.line.drum import (
    COMPENSATION,
    DRUM,
    DRUM_INACTIVE,
    DRUM_MODES,
    LENGTH_CONTROL,
    PRESCRIBED,
    SLIPPING_IN,
    SPEED_CONTROL,
    STUCK,
    TENSION_CONTROL,
    DrumLoad,
)
from hydrosim.elements.pair import apply_tension, line_between
from hydrosim.elements.signal import NOTHING, SIGNAL, compile_signals, rate, value
from hydrosim.errors import InputError
from hydrosim.jit.kernels import clear, kernel, root
from hydrosim.modes import (
    CONTACT_MARGIN,
    FRICTION_MARGIN,
    MARGINS,
    MODE,
    NO_INDEX,
    RISING_MARGIN,
    SEGMENT,
    SEGMENT_MARGIN,
)
from hydrosim.multibody.kinematics import attachment, point_velocity
from hydrosim.multibody.vectors import scale, vector
from hydrosim.scene import ForceElement, Scene
from hydrosim.scene.signal import Signal
from hydrosim.scene.winch import Compensation, Winch

WIRE_SLACK, WIRE_TAUT, WIRE_CUT = range(3)  # of the wire; it is cut where damping alone would push
WIRE_LENGTH, DRUM_SPEED, DRIVE_WORK, DRUM_FRICTION, SNAP_SPEED, LARGEST_TENSION, WINCH_STATES = (
    range(7)
)
WINCH_STATE_NAMES = (
    *("length off the drum", "speed of the drum", "work of the drive", "friction loss"),
    *("speed of the last snap", "largest tension"),
)
WIRE_TENSION, LENGTH_OFF, PAY_OUT, DISTANCE, WINCH_OUTPUTS = range(5)  # see `write_outputs`


WINCH = np.dtype(
    [
        *(("body", int), ("row", int), ("point", float, 3)),
        *(("anchor_body", int), ("anchor", float, 3)),
        *(("stiffness", float), ("damping", float), ("start", float), ("pinned", float)),
        ("drum_locked", bool),
        *(("drum", DRUM), ("signal", SIGNAL)),
        *(("followed", int), ("eye", float, 3), ("rest", float), ("gain", float)),
        *(("delay", int), ("factors", float, (drum.FACTORS, 2))),
    ]
)
"""Constants of a winch: its ends, EA, c, l0 at the start, and l0 if it is ``pinned`` (else 0);
whether its drum always stands (``drum_locked``); its drum and signal; the ``followed`` body, the
place of its point and the height of that at rest, the gain, and the first state of its delay among
those of all (`NO_INDEX` if it has none)."""


class WinchConstants(NamedTuple):
    """The winches ``each`` (n,) of `WINCH`, the ``pieces`` of their signals, the number ``delays``
    of those with a delay, the first of their states and of their rows of modes."""

    each: np.ndarray
    pieces: np.ndarray
    delays: int
    state: int
    mode: int


def compile_elements(elements: Mapping[str, ForceElement], layout: kinds.Layout) -> WinchConstants:
    """Constants of the winches among ``elements``, in their order."""
    winches = {name: e for name, e in elements.items() if isinstance(e, Winch)}
    signals = {name: next((s for _, s in e.signals()), None) for name, e in winches.items()}
    signal_rows, pieces = compile_signals([s for s in signals.values() if s is not None])
    compiled = iter(signal_rows)
    rows = []
    delays = 0
    for name, e in winches.items():
        anchor = layout.body[e.anchor_body] if e.anchor_body else EARTH
        ends = (layout.body[e.body], layout.row[name], e.point, anchor, e.anchor)
        signal = NOTHING if signals[name] is None else next(compiled)
        wire = (e.stiffness, e.damping, _first_length(e, layout), 0.0, False)
        follows = _compensation_fields(name, e.compensation, layout, delays)
        rows.append((*ends, *wire, _drum_fields(e), signal, *follows))
        delays += follows[-2] != NO_INDEX
    return WinchConstants(np.array(rows, dtype=WINCH), pieces, delays, 0, 0)


def _first_length(e: Winch, layout: kinds.Layout) -> float:
    """l0 at the start; that at which the set tension acts at rest if none is given."""
    if isinstance(e.length, Signal):
        return 0.0
    if e.length is not None:
        return e.length
    assert e.tension is not None
    here = layout.place_at_rest(e.body, e.point)
    there = layout.place_at_rest(e.anchor_body, e.anchor)
    return float(np.linalg.norm(there - here)) / (1.0 + e.tension / e.stiffness)


def _drum_fields(e: Winch) -> tuple[Any, ...]:
    """Values of `DRUM`."""
    if e.tension is not None:
        T = e.tension
        inwards, outwards = e.friction.heave_in, e.friction.pay_out
        low = T * (1.0 - e.dead_band - inwards)
        high = T * (1.0 + e.dead_band + outwards)
        losses = (T * inwards, T * outwards)
        limits = (e.speed, e.acceleration or 0.0, *e.ends)
        return TENSION_CONTROL, T, low, high, *losses, *limits
    kind = LENGTH_CONTROL if e.speed is None else SPEED_CONTROL
    fastest = inf
    if e.compensation is not None:
        kind = COMPENSATION
        fastest = inf if e.compensation.speed is None else e.compensation.speed
    return kind, 0.0, 0.0, 0.0, 0.0, 0.0, fastest, 0.0, *e.ends


def _compensation_fields(
    name: str, control: Compensation | None, layout: kinds.Layout, delays: int
) -> tuple[int, tuple[float, ...], float, float, int, np.ndarray]:
    """Values of `WINCH` for a compensation."""
    if control is None:
        return NO_INDEX, (0.0, 0.0, 0.0), 0.0, 0.0, NO_INDEX, drum.delay_factors(0.0)
    if control.point not in layout.points:
        point_names = (
            ", ".join(layout.points) or "none in this scene; name points of bodies by points"
        )
        raise InputError(
            f"forces.{name}.compensation.point: found {control.point}; expected a named point:"
            f" {point_names}."
        )
    body, place = layout.points[control.point]
    of = next(key for key, number in layout.body.items() if number == body)
    rest = float(layout.place_at_rest(of, place)[2])
    first = NO_INDEX if control.delay == 0.0 else drum.DELAY_STATES * delays
    return body, place, rest, control.gain, first, drum.delay_factors(control.delay)


def lasting_lengths(p: WinchConstants) -> np.ndarray:
    """Entries (m,) of y with the lengths off drums that do not follow from the place of bodies."""
    uncompensated = np.flatnonzero(p.each["drum"]["control"] != COMPENSATION)
    return np.asarray(p.state + WINCH_STATES * uncompensated + WIRE_LENGTH)


def drums_locked(p: WinchConstants) -> WinchConstants:
    """The same winches with drums that stand, for a scene at rest; those of compensation keep to
    their targets."""
    constants = p.each.copy()
    constants["drum_locked"] = constants["drum"]["control"] != COMPENSATION
    return p._replace(each=constants)


class WireKinematics(NamedTuple):
    """State of one winch: lever arms of both ends, the direction, the distance l and its rate; l0,
    its speed s, the target of l0 and the demanded speed; T, T where it is not cut, EA e."""

    arm: tuple[float, float, float]
    anchor_arm: tuple[float, float, float]
    direction: tuple[float, float, float]
    distance: float
    rate: float
    length: float
    speed: float
    target: float
    demand: float
    tension: float
    uncut: float
    elastic: float
    pull: DrumLoad


@kernel
def kinematics(i, t, y, modes, motion, bodies, p):
    """State of winch ``i``, as a `WireKinematics`."""
    winch = p.each[i]
    mode = modes[p.mode + i]
    k = p.state + WINCH_STATES * i
    line = line_between(
        winch.body,
        vector(winch.point, 0),
        winch.anchor_body,
        vector(winch.anchor, 0),
        bodies,
        motion,
    )
    target, demand = setpoint(i, t, y, motion, bodies, p)
    l0 = target if winch.drum.control == LENGTH_CONTROL else y[k + WIRE_LENGTH]
    if winch.pinned > 0.0:
        l0 = winch.pinned
    EA = winch.stiffness
    e = line.length / l0 - 1.0
    damping = EA * winch.damping
    still = EA * e + damping * line.rate / l0
    by_length = -EA * line.length / (l0 * l0)
    by_speed = winch.damping * by_length
    pull = DrumLoad(still, EA * line.rate / l0, by_length, by_speed)
    s = drum.payout_speed(winch.drum, mode[MODE], y[k + DRUM_SPEED], demand, pull)
    uncut = drum.tension_at(winch.drum, mode[MODE], s, pull)
    T = uncut if mode[SEGMENT] == WIRE_TAUT and mode[MODE] != DRUM_INACTIVE else 0.0
    elastic = EA * max(e, 0.0) if mode[SEGMENT] != WIRE_SLACK else 0.0
    return WireKinematics(
        line.arm,
        line.other_arm,
        line.direction,
        line.length,
        line.rate,
        l0,
        s,
        target,
        demand,
        T,
        uncut,
        elastic,
        pull,
    )


@kernel
def setpoint(i, t, y, motion, bodies, p):
    """Target of l0 and demanded speed of pay-out of winch ``i``; 0 where it has none."""
    winch = p.each[i]
    if winch.drum.control == LENGTH_CONTROL:
        return value(t, winch.signal, p.pieces), rate(t, winch.signal, p.pieces)
    if winch.drum.control == SPEED_CONTROL:
        return 0.0, value(t, winch.signal, p.pieces)
    if winch.drum.control == COMPENSATION:
        rise, speed = _rise_of_point(winch, motion, bodies)
        if winch.delay != NO_INDEX:
            k = _delay_state(winch, p)
            rise, speed = drum.delayed_signal(rise, speed, winch.factors, y, k)
        return winch.start + winch.gain * rise, winch.gain * speed
    return 0.0, 0.0


@kernel
def _rise_of_point(winch, motion, bodies):
    """Rise of the followed point from rest, and its rate."""
    place, arm = attachment(winch.followed, vector(winch.eye, 0), bodies, motion)
    return place[2] - winch.rest, point_velocity(winch.followed, arm, motion)[2]


@kernel
def _delay_state(winch, p):
    """First state in y of the delay of a winch."""
    return p.state + WINCH_STATES * p.each.size + winch.delay


@root
def add_force(t, y, modes, motion, bodies, p, loads):
    """Add the force [N, N m] of every winch to its row of ``wrench``, and the power [W] that it
    takes to ``rate``; the rates of its states into ``dy``, in place."""
    for i in range(p.each.size):
        winch = p.each[i]
        mode = modes[p.mode + i]
        k = p.state + WINCH_STATES * i
        clear(loads.dy[k : k + WINCH_STATES])
        if winch.delay != NO_INDEX:
            rise, _ = _rise_of_point(winch, motion, bodies)
            drum.add_rates(rise, winch.factors, y, _delay_state(winch, p), loads.dy)
        w = kinematics(i, t, y, modes, motion, bodies, p)
        loads.dy[k + WIRE_LENGTH] = w.speed
        if mode[MODE] == DRUM_INACTIVE:
            continue
        lost = drum.friction_loss(winch.drum, w.speed)
        loads.dy[k + DRUM_SPEED] = drum.drum_acceleration(winch.drum, mode[MODE])
        loads.dy[k + DRIVE_WORK] = w.tension * w.speed - lost
        loads.dy[k + DRUM_FRICTION] = lost
        strain = w.elastic / winch.stiffness
        loads.rate[winch.row] += (w.tension - w.elastic) * w.rate
        loads.rate[winch.row] += w.elastic * (1.0 + 0.5 * strain) * w.speed
        force = scale(w.tension, w.direction)
        wrench = loads.wrench[winch.row]
        apply_tension(winch.body, winch.anchor_body, w.arm, w.anchor_arm, force, wrench)


@root
def add_energy(t, y, modes, motion, bodies, p, stored):
    """Add the energy stored in every wire to its row of ``stored``."""
    for i in range(p.each.size):
        winch = p.each[i]
        if modes[p.mode + i, MODE] != DRUM_INACTIVE:
            w = kinematics(i, t, y, modes, motion, bodies, p)
            stored[winch.row] += 0.5 * w.elastic * w.elastic / winch.stiffness * w.length


@root
def write_outputs(t, y, modes, motion, bodies, p, out):
    """Write rows of `WINCH_OUTPUTS` of all winches to ``out``: T, l0, s and l."""
    for i in range(p.each.size):
        w = kinematics(i, t, y, modes, motion, bodies, p)
        row = out[WINCH_OUTPUTS * i : WINCH_OUTPUTS * (i + 1)]
        row[WIRE_TENSION] = w.tension
        row[LENGTH_OFF] = w.length
        row[PAY_OUT] = w.speed
        row[DISTANCE] = w.distance


@root
def record_largest(t, y, modes, motion, bodies, p):
    """Keep the largest tension and, at single steps, what records would miss."""
    for i in range(p.each.size):
        k = p.state + WINCH_STATES * i + LARGEST_TENSION
        y[k] = max(y[k], kinematics(i, t, y, modes, motion, bodies, p).tension)


@root
def find_margins(t, y, modes, motion, bodies, p, out):
    """Margins of all winches into ``out`` (4 to a row of modes): T, or its opposite where it is
    cut; the law of the drum; l - l0, or its opposite where it is slack; the ends of the drum."""
    for i in range(p.each.size):
        winch = p.each[i]
        mode = modes[p.mode + i]
        m = MARGINS * (p.mode + i)
        for k in range(MARGINS):
            out[m + k] = 1.0
        if mode[MODE] == DRUM_INACTIVE:
            continue
        w = kinematics(i, t, y, modes, motion, bodies, p)
        beyond = w.distance - w.length
        out[m + SEGMENT_MARGIN] = -beyond if mode[SEGMENT] == WIRE_SLACK else beyond
        if winch.damping > 0.0 and mode[SEGMENT] != WIRE_SLACK:
            out[m + CONTACT_MARGIN] = w.uncut if mode[SEGMENT] == WIRE_TAUT else -w.uncut
        out[m + FRICTION_MARGIN] = drum.law_margin(
            winch.drum, mode[MODE], w.tension, w.speed, w.length, w.target, w.demand
        )
        out[m + RISING_MARGIN] = drum.end_margin(winch.drum, mode[MODE], w.length)


@kernel
def guard_dependencies(i, part, p):
    """Ranges (from, to) of the states that the margins of winch ``i`` depend on; none if ``i`` is
    beyond all winches."""
    if i >= p.each.size:
        return 0, 0
    if part == 0:
        k = p.state + WINCH_STATES * i
        return k, k + DRIVE_WORK
    if p.each[i].delay == NO_INDEX:
        return 0, 0
    k = _delay_state(p.each[i], p)
    return k, k + drum.DELAY_STATES


@root
def transition(i, which, t, y, modes, motion, bodies, p):
    """Switch winch ``i`` to its next mode, after margin ``which`` has reached zero."""
    winch = p.each[i]
    mode = modes[p.mode + i]
    k = p.state + WINCH_STATES * i
    w = kinematics(i, t, y, modes, motion, bodies, p)
    if which == SEGMENT_MARGIN and mode[SEGMENT] == WIRE_SLACK:
        mode[SEGMENT] = WIRE_TAUT
        y[k + SNAP_SPEED] = w.rate - w.speed
    elif which == SEGMENT_MARGIN:
        mode[SEGMENT] = WIRE_SLACK
    elif which == CONTACT_MARGIN:
        mode[SEGMENT] = WIRE_CUT if mode[SEGMENT] == WIRE_TAUT else WIRE_TAUT
    else:
        before = mode[MODE]
        _place_drum(winch, before, w, y, k)
        w = kinematics(i, t, y, modes, motion, bodies, p)
        if which == RISING_MARGIN:
            mode[MODE] = drum.stop_at_end(winch.drum, before, w.length)
        else:
            taut = mode[SEGMENT] == WIRE_TAUT
            mode[MODE] = drum.next_mode(winch.drum, before, taut, w)
            _place_drum(winch, mode[MODE], w, y, k)
        _keep_speed(winch.drum, mode[MODE], y, k)


@kernel
def _place_drum(winch, mode, w, y, k):
    """Set l0 to what a drum follows in a ``mode`` that ends or begins: a bound of the tension, or
    its target. The integral of the speed has an error, by which the next mode could end at once."""
    drum_data = winch.drum
    slipping = mode in (drum.SLIPPING_OUT, drum.SLIPPING_IN)
    if slipping and winch.damping == 0.0:
        bound = drum_data.high if mode == drum.SLIPPING_OUT else drum_data.low
        y[k + WIRE_LENGTH] = w.distance / (1.0 + bound / winch.stiffness)
    elif drum_data.control == COMPENSATION and mode == drum.PRESCRIBED:
        y[k + WIRE_LENGTH] = min(max(w.target, drum_data.shortest), drum_data.longest)


@kernel
def _keep_speed(drum_data, mode, y, k):
    """Set the speed of a drum with an acceleration to that of its new mode."""
    if mode == drum.FAST_OUT:
        y[k + DRUM_SPEED] = drum_data.fastest
    elif mode == drum.FAST_IN:
        y[k + DRUM_SPEED] = -drum_data.fastest
    elif not drum.SPEEDING_OUT <= mode <= drum.BRAKING_IN:
        y[k + DRUM_SPEED] = 0.0


@root
def set_initial_modes(t, y, modes, motion, bodies, p):
    """Modes of all winches for a start, and l0 where ``y`` has none yet."""
    for i in range(p.each.size):
        if y[p.state + WINCH_STATES * i + WIRE_LENGTH] <= 0.0:
            set_initial_length(i, t, y, motion, bodies, p)
        activate(i, t, y, modes, motion, bodies, p)


@kernel
def set_initial_length(i, t, y, motion, bodies, p):
    """Set l0 of winch ``i`` to that of its start or of its target."""
    winch = p.each[i]
    k = p.state + WINCH_STATES * i
    if winch.delay != NO_INDEX:
        rise, _ = _rise_of_point(winch, motion, bodies)
        drum.start_delay(rise, winch.factors, y, _delay_state(winch, p))
    l0 = winch.start
    if winch.drum.control in (LENGTH_CONTROL, COMPENSATION):
        l0, _ = setpoint(i, t, y, motion, bodies, p)
    y[k + WIRE_LENGTH] = min(max(l0, winch.drum.shortest), winch.drum.longest)


@kernel
def activate(i, t, y, modes, motion, bodies, p):
    """Mode of winch ``i`` when it becomes active."""
    winch = p.each[i]
    mode = modes[p.mode + i]
    mode[MODE] = drum.STUCK
    mode[SEGMENT] = WIRE_TAUT
    w = kinematics(i, t, y, modes, motion, bodies, p)
    if w.distance < w.length or (w.distance == w.length and w.rate <= 0.0):
        mode[SEGMENT] = WIRE_SLACK
    elif w.pull.still < 0.0:
        mode[SEGMENT] = WIRE_CUT
    taut = mode[SEGMENT] == WIRE_TAUT
    if not winch.drum_locked:
        mode[MODE] = drum.initial_mode(winch.drum, w.pull, taut, w.length, w.target, w.demand)
    _keep_speed(winch.drum, mode[MODE], y, p.state + WINCH_STATES * i)


@kernel
def activate_in_run(i, t, y, modes, motion, bodies, p):
    """Activate winch ``i`` in a run; a drum with a target begins there."""
    drum_data = p.each[i].drum
    if drum_data.control in (LENGTH_CONTROL, COMPENSATION):
        l0, _ = setpoint(i, t, y, motion, bodies, p)
        y[p.state + WINCH_STATES * i + WIRE_LENGTH] = min(
            max(l0, drum_data.shortest), drum_data.longest
        )
    activate(i, t, y, modes, motion, bodies, p)


@kernel
def deactivate(i, y, modes, p):
    """Deactivate winch ``i``: its drum stands."""
    modes[p.mode + i, MODE] = DRUM_INACTIVE
    modes[p.mode + i, SEGMENT] = WIRE_SLACK
    y[p.state + WINCH_STATES * i + DRUM_SPEED] = 0.0


# Winches as a kind of units, for set-up and output.

DELAY = tuple(f"delay {k + 1}" for k in range(drum.DELAY_STATES))


class WinchKind(kinds.KindWithModeSets):
    unit = "winch"
    variables: ClassVar = {
        "winch_tension": kinds.tension_variable(
            "tension of the wire",
            "from the point to the anchor",
            "Tension of winches",
            2,
            [
                kinds.SummaryColumn("largest", "at the end", "winch_largest_tension"),
                kinds.SLACK_SHARE,
            ],
        ),
        "winch_length": kinds.Variable(
            "length of wire off the drum, without load",
            "m",
            chart=kinds.ChartHint(
                "Length off the drums of winches", "length off the drum", kinds.Topic.LINKS + 1
            ),
            summary=[
                kinds.SummaryColumn("shortest", "smallest"),
                kinds.SummaryColumn("longest", "largest"),
            ],
        ),
        "winch_speed": kinds.Variable(
            "speed of pay-out of the drum",
            "m/s",
            chart=kinds.ChartHint(
                "Speed of pay-out of winches", "pay-out speed", kinds.Topic.DETAILS + 5
            ),
        ),
        "winch_work": kinds.Variable("energy that the drive of the drum has taken", "J"),
        "winch_friction_loss": kinds.Variable("energy lost by friction in the drum", "J"),
        "winch_snap_speed": kinds.Variable("speed at which the wire last became taut", "m/s"),
        "winch_largest_tension": kinds.Variable("largest tension of all steps so far", "N"),
        "winch_mode": kinds.Variable("mode of the drum", "1", flags=" ".join(DRUM_MODES)),
        "winch_segment": kinds.Variable("wire slack, taut, or cut by its damping", "1"),
    }

    def modes(self, p: WinchConstants) -> kinds.ModeRows:
        count = p.each.size
        return kinds.ModeRows(
            count, first=np.zeros(count, dtype=int), last=np.full(count, WIRE_CUT)
        )

    def states(self, p: WinchConstants, scene: Scene) -> Iterator[kinds.StateBlocks]:
        every = {name: e for name, e in scene.forces.items() if isinstance(e, Winch)}
        yield kinds.StateBlocks("winch", [*every], WINCH_STATE_NAMES)
        late = [n for n, e in every.items() if e.compensation and e.compensation.delay]
        yield kinds.StateBlocks("winch delay", late, DELAY)

    def coupled_states(self, p: WinchConstants) -> np.ndarray:
        ruled = np.flatnonzero(p.each["drum"]["control"] != LENGTH_CONTROL)
        heavy = np.flatnonzero(p.each["drum"]["acceleration"] > 0.0)
        late = WINCH_STATES * p.each.size + np.arange(drum.DELAY_STATES * p.delays)
        states = [WINCH_STATES * ruled + WIRE_LENGTH, WINCH_STATES * heavy + DRUM_SPEED, late]
        return (p.state + np.concatenate(states)).astype(np.int64)

    def is_mirrored(self, p: WinchConstants, y: np.ndarray, modes: np.ndarray) -> bool:
        """Winches that are alike but for their ends have the same lengths and modes."""
        fields = [n for n in p.each.dtype.names or () if n not in ("row", "point", "anchor")]
        alike: dict[bytes, list[int]] = {}
        for i, winch in enumerate(p.each):
            alike.setdefault(b"".join(winch[n].tobytes() for n in fields), []).append(i)
        lengths = y[p.state : p.state + WINCH_STATES * p.each.size].reshape(-1, WINCH_STATES)[
            :, : DRUM_SPEED + 1
        ]
        return all(
            np.array_equal(lengths[i], lengths[same[0]])
            and np.array_equal(modes[i], modes[same[0]])
            for same in alike.values()
            for i in same
        )

    def clear_unused_states(self, p: WinchConstants, y: np.ndarray) -> None:
        """All states have a meaning."""

    def renew(
        self,
        p: WinchConstants,
        y: np.ndarray,
        anew: np.ndarray,
        possible: np.ndarray,
        known_states: np.ndarray,
    ) -> None:
        """Winches that the run before did not have begin with the length of their start."""
        winch_states = slice(
            p.state, p.state + WINCH_STATES * p.each.size + drum.DELAY_STATES * p.delays
        )
        y[winch_states] = np.where(known_states[winch_states], y[winch_states], anew[winch_states])

    def mode_sets(self, p: WinchConstants) -> Sequence[kinds.ModeSet]:
        if not p.each.size:
            return []
        sets = [kinds.ModeSet("winches slack", _modes_of_wires(p, WIRE_SLACK))]
        sets.append(kinds.ModeSet("winches taut", _modes_of_wires(p, WIRE_TAUT)))
        slips = (p.each["drum"]["control"] == TENSION_CONTROL) & (p.each["damping"] > 0.0)
        if slips.any():
            slipping = _modes_of_wires(p, WIRE_TAUT)
            slipping[slips, MODE] = SLIPPING_IN
            sets.append(kinds.ModeSet("drums slipping", slipping))
        return sets

    def one_unit_active(
        self, p: WinchConstants, names: Sequence[str], which: Sequence[int]
    ) -> Iterator[kinds.ModeSet]:
        for i in which if p.each.size > 1 else ():
            winch = kinds.with_mode_of_unit(
                _modes_of_wires(p, WIRE_SLACK), _modes_of_wires(p, WIRE_TAUT), i
            )
            yield kinds.ModeSet(f"{names[i]} alone taut", winch)

    def equivalence_keys(self, p: WinchConstants) -> Sequence[Hashable]:
        """No two winches are alike: each pulls in a direction of its own."""
        return range(p.each.size)

    def rates(self, p: WinchConstants, bodies: Any, motion: Any) -> np.ndarray:
        """Along the wires."""
        rates_by_winch = [_line_of_winch(winch, bodies, motion).rate for winch in p.each]
        return np.reshape(rates_by_winch, (-1, 1))

    def moved_onto_segment(
        self, p: WinchConstants, modes: np.ndarray, bodies: Any, motion: Any, y: np.ndarray
    ) -> WinchConstants:
        """Constants with wires that are just taut, as stiff as at their shortest."""
        constants = p.each.copy()
        for winch, (mode, segment, _) in zip(constants, modes, strict=True):
            if segment == WIRE_TAUT and mode != SLIPPING_IN:
                distance = _line_of_winch(winch, bodies, motion).length
                winch["pinned"] = distance / (
                    1.0 + kinds.LINEARISATION_DEPTH / max(distance, kinds.LINEARISATION_DEPTH)
                )
                winch["stiffness"] *= winch["pinned"] / max(
                    _shortest_wire(winch, p), kinds.LINEARISATION_DEPTH
                )
        return p._replace(each=constants)

    def idle_states(self, p: WinchConstants, modes: np.ndarray) -> np.ndarray:
        """Lengths of drums that do not slip, and their speeds."""
        still = np.flatnonzero(modes[:, MODE] != SLIPPING_IN)
        first = p.state + WINCH_STATES * still
        return np.concatenate([first + WIRE_LENGTH, first + DRUM_SPEED])

    def coordinates(self, scene: Scene) -> dict[str, object]:
        return super().coordinates(scene) | kinds.capacity_of(
            self.unit, kinds.elements_of(scene, Winch)
        )

    def record(
        self, p: WinchConstants, bodies: Any, unit_record: kinds.UnitRecord
    ) -> kinds.Columns:
        dims = ("time", "winch")
        n = p.each.size
        states = unit_record.y[p.state : p.state + WINCH_STATES * n].reshape(-1, n, WINCH_STATES)
        return {
            "winch_tension": (dims, unit_record.observed[:, :, WIRE_TENSION]),
            "winch_length": (dims, unit_record.observed[:, :, LENGTH_OFF]),
            "winch_speed": (dims, unit_record.observed[:, :, PAY_OUT]),
            "winch_work": (dims, states[:, :, DRIVE_WORK]),
            "winch_friction_loss": (dims, states[:, :, DRUM_FRICTION]),
            "winch_snap_speed": (dims, states[:, :, SNAP_SPEED]),
            "winch_largest_tension": (dims, states[:, :, LARGEST_TENSION]),
            "winch_mode": (dims, unit_record.modes[:, :, MODE].astype(np.int8)),
        }


def _modes_of_wires(p: WinchConstants, wire: int) -> np.ndarray:
    """Modes with all drums at rest, or driven by their target, and all wires alike."""
    tense = p.each["drum"]["control"] == TENSION_CONTROL
    modes = kinds.rest_at_first(np.full(p.each.size, wire), STUCK)
    modes[:, MODE] = np.where(tense, STUCK, PRESCRIBED)
    modes[:, SEGMENT] = wire
    return modes


def _line_of_winch(winch: Any, bodies: Any, motion: Any) -> Any:
    """The line between the ends of a winch."""
    ends = (winch["body"], tuple(winch["point"]), winch["anchor_body"], tuple(winch["anchor"]))
    return line_between(*ends, bodies, motion)


def _shortest_wire(winch: np.void, p: WinchConstants) -> float:
    """The shortest length off the drum [m] that a winch may have."""
    if winch["drum"]["control"] == LENGTH_CONTROL:
        signal = winch["signal"]
        pieces = p.pieces[signal["first"] : signal["last"] + 1]
        return float(pieces["a"].min() - abs(signal["amplitude"]))
    if winch["drum"]["shortest"] > 0.0:
        return float(winch["drum"]["shortest"])
    return float(winch["start"])


WINCH_KIND = WinchKind("winches", (Winch,), compile_elements)
