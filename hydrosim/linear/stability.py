"""The largest stable step of a scene, before it is run.

A method with stability function R damps a mode of eigenvalue lambda only while
|R(h lambda)| <= 1 (Hairer & Wanner 1996, IV.2). The scene is linearised with all contact points
open, all sticking, all slipping and, if asked, single ones alone, on the steepest piece of their
curve (when it is pressed most, if that is prescribed), all springs slack and all taut on their
steepest pieces (as if they were so much shorter), and the smallest limit on h is the scene's;
others below the step are told with it, because each of them is something that will oscillate or
diverge. Growth by less than a thousandth per period of the mode counts as an error, not as an
instability: else no second-order method could take an undamped mode.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from hydrosim.forces import new_modes, own_modes, spring
from hydrosim.forces.contact import guide
from hydrosim.forces.contact.fender import STATES, memories
from hydrosim.forces.contact.geometry import touch
from hydrosim.forces.contact.guide import FREE
from hydrosim.forces.contact.guide import PRESSED as PRESSED_BY_WALL
from hydrosim.forces.contact.laws import LAW, sliding, slowest
from hydrosim.forces.contact.loop import NONE, SET
from hydrosim.forces.modes import MODE, OPEN, SEGMENT, SLIP, STICK
from hydrosim.forces.signal import crest, value
from hydrosim.forces.spring import TAUT, stretch
from hydrosim.forces.trigger import DURING
from hydrosim.integrate import Method
from hydrosim.linear.freedom import Freedom, constraint_rows
from hydrosim.linear.linearise import Linear, inertia, linearise
from hydrosim.linear.modes import participation
from hydrosim.rigid import place_bodies
from hydrosim.stepping.dynamics import Model, dynamic_states, new_work
from hydrosim.stepping.state import State

GROWTH = 1e-3  # per period
REACH = 40.0  # |h lambda| up to which stability functions are looked at
AT_ONCE = 400  # places on a ray, of 8000: most limits are near its start
ALIKE = 1e-6  # steps that differ by less, relative, are one
NAMES = {OPEN: "open", STICK: "sticking", SLIP: "slipping"}
SLIDING = 0.1  # m/s: the speed at which slip is linearised, or that at which it begins
PRESSED = 0.01  # m: the compression beyond the start of a piece at which contact is linearised


@dataclass(frozen=True)
class StepLimit:
    """The largest stable ``step`` [s], the ``eigenvalue`` that sets it, the contact modes it
    belongs to and what moves in it."""

    step: float
    eigenvalue: complex
    contact: str
    what: str

    def describe(self, step: float) -> str:
        """One line on a run with this ``step``."""
        z, limit = abs(self.eigenvalue) * step, abs(self.eigenvalue) * self.step
        return (
            f"largest stable step {self.step:.3g} s: {self.what}, {self.contact}; at {step:g} s"
            f" |lambda| h is {z:.3g}, the limit of the method there {limit:.3g}"
        )


class Combination(NamedTuple):
    """A scene made linear with its contacts and springs in the ``modes`` (rows, 3) that ``contact``
    says in words, and its eigenvalues ``values`` (m,) [1/s]."""

    contact: str
    modes: np.ndarray
    linear: Linear
    values: np.ndarray


Watch = Callable[[Sequence[Any], str], Iterable[Any]]
"""Yields the items of a sequence, and shows how far it is in what it calls by this name."""


def unwatched(items: Sequence[Any], _: str) -> Iterable[Any]:
    """The items, with nothing to show."""
    return items


def combinations(
    model: Model,
    state: State,
    names: list[str],
    each_alone: bool = False,
    watch: Watch = unwatched,
) -> list[Combination]:
    """All that are looked at. ``names`` are those of the free coordinates, then of the contact
    points, then of the springs."""
    time = _pressed_most(model)
    modes_of = list(_modes(model, names, _moved_most(model, state) if each_alone else None))
    found = []
    for contact, modes in watch(modes_of, "contacts and springs"):
        linear = _linearise(model, state, modes, time)
        found.append(Combination(contact, modes, linear, linear.eigenvalues()))
    return found


def _moved_most(model: Model, state: State) -> np.ndarray:
    """Indices of the contact points that are looked at alone. A point alone vibrates with
    omega^2 = k J M^-1 J^T, so of points with one curve and one law only those count that move most
    under a load along the normal or a tangent."""
    points = model.elements.fenders.points
    moves = _mobility(model, state)
    kinds = [_kind(model, point) for point in points]
    alike = [np.flatnonzero([kind == other for other in kinds]) for kind in dict.fromkeys(kinds)]
    most = [same[moves[same].argmax(axis=0)] for same in alike]
    return np.unique(np.concatenate([np.zeros(0, dtype=int), *most]))


def _kind(model: Model, point: np.void) -> tuple[float, ...]:
    """All that sets the stiffness and damping of a contact point, wherever it is."""
    segments = model.elements.fenders.segments
    steepest = segments[_steepest(segments, point)]
    fields = ("normal_damping", "prescribed", "signal", "reach", "lag", *(name for name, _ in LAW))
    return (*steepest.tolist(), *(point[name].item() for name in fields))


def _mobility(model: Model, state: State) -> np.ndarray:
    """J M^-1 J^T of each contact point (k, 3) [1/kg]: along the normal and along both tangents."""
    n, motion = model.bodies.active.size, new_work(model).motion
    rates = []
    for unit in np.eye(n):
        place_bodies(state.y[:n], unit, model.bodies, motion)
        touches = [touch(point, model.bodies, motion) for point in model.elements.fenders.points]
        rates.append([(each.rate, *each.velocity) for each in touches])
    J = np.reshape(rates, (n, -1, 3))
    freedom = Freedom(constraint_rows(model, state.y, _open(model)), inertia(model, state.y))
    yielding = freedom.accelerations(J.reshape(n, -1)).reshape(J.shape)
    return np.asarray((J * yielding).sum(axis=0))


def step_limits(
    found: Sequence[Combination], method: Method, model: Model, names: list[str], step: float
) -> list[StepLimit]:
    """Over all ``found`` combinations, the limits below ``step`` [s] in rising order, of everything
    that moves its smallest; of what has the same limit, one. If none is below, the smallest of all;
    empty if no step is too large.
    """
    least = [_steps(method, x.values).min(initial=np.inf) for x in found]
    bound = max(step, min(least) * (1.0 + ALIKE))
    limits = [
        limit
        for combination, smallest in zip(found, least, strict=True)
        if smallest < bound
        for limit in _below(bound, combination, method, model, names)
    ]
    rising: dict[str, StepLimit] = {}
    for limit in sorted(limits, key=lambda limit: limit.step):
        rising.setdefault(limit.what, limit)
    told = list(rising.values())
    return told[:1] + [b for a, b in pairwise(told) if b.step > a.step * (1.0 + ALIKE)]


def _steps(method: Method, values: np.ndarray) -> np.ndarray:
    """The largest stable step [s] of each eigenvalue."""
    return ray_limits(method, np.angle(values)) / np.maximum(np.abs(values), 1e-12)


def _below(
    bound: float, combination: Combination, method: Method, model: Model, names: list[str]
) -> Iterator[StepLimit]:
    """The limits below ``bound`` of one linearisation."""
    values, share = participation(combination.linear)
    steps = _steps(method, values)
    for k in np.flatnonzero(steps < bound):
        what = what_moves(combination.linear, share[:, k], model, names)
        yield StepLimit(float(steps[k]), complex(values[k]), combination.contact, what)


def ray_limits(method: Method, angle: np.ndarray) -> np.ndarray:
    """Largest |z| up to which the method is stable on the rays z = r exp(i angle), (n,);
    infinite for rays into the right half plane, where the motion itself grows."""
    places = np.linspace(0.0, REACH, 8001)[1:]
    rays, which = np.unique(np.abs(angle), return_inverse=True)  # |R| is the same below and above
    limits = [
        _first_unstable(method, places, phi) if np.cos(phi) <= 1e-9 else np.inf for phi in rays
    ]
    return np.array(limits, dtype=float)[which]


def _first_unstable(method: Method, places: np.ndarray, angle: float) -> float:
    """The first of the ``places`` on a ray at which a method is unstable; infinite if none is."""
    direction = np.exp(1j * angle)
    for start in range(0, places.size, AT_ONCE):
        r = places[start : start + AT_ONCE]
        unstable = np.flatnonzero(
            np.abs(method.stability(r * direction)) > 1.0 + GROWTH * r / (2 * np.pi)
        )
        if unstable.size:
            return float(r[unstable[0]])
    return np.inf


def _modes(
    model: Model, names: list[str], alone: np.ndarray | None
) -> Iterator[tuple[str, np.ndarray]]:
    """All contacts open, sticking or slipping, with all springs slack and all of them taut. Unless
    ``alone`` is None, also each spring alone taut, and the points ``alone`` each alone closed."""
    for contact, modes in _contact_modes(model, names):
        yield from _spring_modes(model, names, contact, modes, alone is not None)
    for contact, modes in _each_contact(model, names, [] if alone is None else alone):
        yield from _spring_modes(model, names, contact, modes, each_alone=False)


def _spring_modes(
    model: Model, names: list[str], contact: str, modes: np.ndarray, each_alone: bool
) -> Iterator[tuple[str, np.ndarray]]:
    """Contacts in these ``modes``, with all springs slack, all taut and, if asked, each alone."""
    springs, start = model.elements.springs, model.elements.fenders.points.size
    lines = springs.lines
    if not lines.size:
        yield contact, modes
        return
    yield f"{contact}, springs slack", modes
    taut, end = modes.copy(), start + lines.size
    taut[start:end, MODE] = TAUT
    taut[start:end, SEGMENT] = [_steepest(springs.segments, line) for line in lines]
    yield f"{contact}, springs taut", taut
    for i in range(start, end if each_alone and lines.size > 1 else 0):
        alone = modes.copy()
        alone[i] = taut[i]
        yield f"{contact}, {names[model.bodies.active.size + i]} alone taut", alone


def _contact_modes(model: Model, names: list[str]) -> Iterator[tuple[str, np.ndarray]]:
    """All points open, sticking or slipping."""
    yield "all contacts open" if model.elements.fenders.points.size else "no contact", _open(model)
    for mode in (STICK, SLIP) if model.elements.fenders.points.size else ():
        yield f"all contacts {NAMES[mode]}", _closed(model, mode)


def _each_contact(
    model: Model, names: list[str], alone: Sequence[int] | np.ndarray
) -> Iterator[tuple[str, np.ndarray]]:
    """Each of the points ``alone`` sticking or slipping, with all others open."""
    if model.elements.fenders.points.size < 2:
        return
    for mode in (STICK, SLIP):
        closed = _closed(model, mode)
        for i in alone:
            modes = _open(model)
            modes[i] = closed[i]
            yield f"{names[model.bodies.active.size + i]} alone {NAMES[mode]}", modes


def _open(model: Model) -> np.ndarray:
    """Modes with all points open, pins free and springs slack."""
    points, lines = model.elements.fenders.points, model.elements.springs.lines
    guides, triggers = model.elements.guides, model.elements.triggers
    modes = new_modes(model.elements)
    modes[: points.size + lines.size, SEGMENT] = [*points["first"], *lines["first"]]
    modes[guides.mode :][: guides.pins.size, MODE] = FREE
    modes[guides.mode :][: guides.pins.size, SEGMENT] = guides.pins["first"]
    modes[triggers.mode :][: triggers.each.size, MODE] = DURING
    return modes


def _closed(model: Model, mode: int) -> np.ndarray:
    """Modes with all points sticking or slipping on their steepest pieces, pins at their walls."""
    fenders, guides, modes = model.elements.fenders, model.elements.guides, _open(model)
    modes[: fenders.points.size, MODE] = mode
    steepest = [_steepest(fenders.segments, point) for point in fenders.points]
    modes[: fenders.points.size, SEGMENT] = steepest
    modes[guides.mode :][: guides.pins.size, MODE] = PRESSED_BY_WALL
    return modes


def _steepest(segments: np.ndarray, each: np.void) -> int:
    """The steepest piece of the curve of a contact point or spring."""
    if "line" in (each.dtype.names or ()) and each["line"] != NONE:
        return int(each["line"])
    pieces = segments[each["first"] : each["last"] + 1]
    return int(each["first"] + np.argmax(pieces["slope"]))


def _linearise(model: Model, state: State, modes: np.ndarray, time: float) -> Linear:
    """Linearise with all contacts and springs on the pieces of their curves that ``modes`` say, and
    with slip going on."""
    pressed = _pressed(model, state, modes)
    start = _sliding(pressed, state, modes, time)
    return linearise(pressed, start, modes, time, states=_moving_states(model, modes))


def _moving_states(model: Model, modes: np.ndarray) -> np.ndarray:
    """The states without the nodes of open contacts. These act on nothing, and are looked at where
    all contacts are open."""
    fenders, states = model.elements.fenders, dynamic_states(model)
    is_open = modes[: fenders.points.size, MODE] == OPEN
    if is_open.all():
        return states
    node = (states - fenders.state) // STATES
    own = (states >= fenders.state) & (node < is_open.size)
    return states[~own | ~is_open[np.where(own, node, 0)]]


def _pressed(model: Model, state: State, modes: np.ndarray) -> Model:
    """The model with each plane where it presses its point, and each spring as long, as the piece
    of its curve wants; all in their place and direction, whatever the others are."""
    points, lines = model.elements.fenders.points.copy(), model.elements.springs.lines.copy()
    pieces, segments = model.elements.fenders.segments, model.elements.springs.segments
    n, bodies, motion = model.bodies.active.size, model.bodies, new_work(model).motion
    place_bodies(state.y[:n], state.y[n : 2 * n], bodies, motion)
    for point, (mode, segment, _) in zip(points, modes[: points.size], strict=True):
        if mode != OPEN:
            nearer = pieces[segment]["start"] + PRESSED - touch(point, bodies, motion).compression
            point["plane_point"] += nearer * point["plane_normal"]
    own = own_modes(spring, model.elements.springs, modes)
    for line, (mode, segment, _) in zip(lines, own, strict=True):
        if mode == TAUT:
            extension = segments[segment]["start"] + PRESSED
            line["length"] = stretch(line, bodies, motion).length - extension
    fenders = model.elements.fenders._replace(points=points)
    springs = model.elements.springs._replace(lines=lines)
    elements = model.elements._replace(
        fenders=fenders, springs=springs, guides=_walled(model.elements.guides)
    )
    return model._replace(elements=elements)


def _walled(guides: guide.Params) -> guide.Params:
    """Guides whose pins are pressed by the steepest piece of their walls wherever they are."""
    pins, segments = guides.pins.copy(), guides.segments.copy()
    for pin in pins:
        own = segments[pin["first"] : pin["last"] + 1]
        own["slope"][0] = own["slope"].max()
        pin["gap"] = pin["slope"] * PRESSED
    return guides._replace(pins=pins, segments=segments)


def _pressed_most(model: Model) -> float:
    """Time of the largest prescribed normal forces; 0 without any."""
    fenders = model.elements.fenders
    signals = fenders.points["signal"][fenders.points["prescribed"]]

    def total(time: float) -> float:
        return sum(value(time, signal, fenders.pieces) for signal in signals)

    return max((crest(signal, fenders.pieces) for signal in signals), key=total, default=0.0)


def _sliding(model: Model, state: State, modes: np.ndarray, time: float) -> State:
    """The state with the bodies moving aside, each at a speed of its own, so that points slip on
    other bodies, too, and the points that slip in steady slip."""
    fenders, bodies, n = model.elements.fenders, model.bodies, model.bodies.active.size
    y, motion = state.y.copy(), new_work(model).motion
    memories(fenders, y)[:, SET] = 0.0  # stiff lines begin where `_pressed` has put the planes
    modes = modes[: fenders.points.size]
    slips = modes[:, MODE] == SLIP
    pairs = zip(fenders.points, modes, strict=True)
    loads = [_normal(model, point, mode, time) for point, mode in pairs]
    if np.any(slips):
        speed = max(SLIDING, *map(slowest, loads, fenders.points))
        y[n : 2 * n] += speed * (1 + bodies.active // 6) * (bodies.active % 6 < 2)
    place_bodies(y[:n], y[n : 2 * n], bodies, motion)
    for i in np.flatnonzero(slips):
        point = fenders.points[i]
        found = sliding(loads[i], np.array(touch(point, bodies, motion).velocity), point)
        if found is not None:
            y[fenders.state + STATES * i :][:2] = found
    return state._replace(y=y)


def _normal(model: Model, point: np.void, mode: np.ndarray, time: float) -> float:
    """Normal force [N] of a point in its ``mode`` (3,), as `_pressed` has it."""
    fenders = model.elements.fenders
    if point["prescribed"]:
        return float(value(time, point["signal"], fenders.pieces))
    piece = fenders.segments[mode[SEGMENT]]
    return float(piece["force"] + PRESSED * piece["slope"])


def what_moves(linear: Linear, share: np.ndarray, model: Model, names: list[str]) -> str:
    """Name of the coordinate, contact node or radiation that has the largest ``share`` (m,) of a
    mode."""
    n, fenders = linear.active.size, model.elements.fenders
    other, states = share[2 * n :], linear.states[2 * n :]
    node = (states - fenders.state) // STATES
    of_nodes = np.bincount(node[node >= 0], other[node >= 0], fenders.points.size)
    shares = [*(share[:n] + share[n : 2 * n]), other[node < 0].sum(), *of_nodes]
    largest = int(np.argmax(shares))
    if largest < n:
        return names[largest]
    return "the radiation states" if largest == n else f"the contact node of {names[largest - 1]}"
