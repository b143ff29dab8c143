"""The largest stable step of a scene, before it is run.

A method with stability function R damps a mode of eigenvalue lambda only while
|R(h lambda)| <= 1 (Hairer & Wanner 1996, IV.2). The scene is linearised with all contact points
open, all sticking, all slipping and, if asked, each of them alone, on the steepest piece of its
curve (when it is pressed most, if that is prescribed), all springs slack and all taut on their
steepest pieces (as if they were so much shorter), and the smallest limit on h is the scene's;
others below the step are told with it, because each of them is something that will oscillate or
diverge. Growth by less than a thousandth per period of the mode counts as an error, not as an
instability: else no second-order method could take an undamped mode.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy import linalg

from hydrosim.forces import new_modes, own_modes, spring
from hydrosim.forces.contact import guide
from hydrosim.forces.contact.fender import STATES, memories
from hydrosim.forces.contact.geometry import touch
from hydrosim.forces.contact.guide import FREE
from hydrosim.forces.contact.guide import PRESSED as PRESSED_BY_WALL
from hydrosim.forces.contact.laws import sliding, slowest
from hydrosim.forces.contact.loop import NONE, SET
from hydrosim.forces.modes import MODE, OPEN, SEGMENT, SLIP, STICK
from hydrosim.forces.signal import crest, value
from hydrosim.forces.spring import TAUT, stretch
from hydrosim.forces.trigger import DURING
from hydrosim.integrate import Tableau
from hydrosim.linear.linearise import Linear, linearise
from hydrosim.linear.modes import participation
from hydrosim.rigid import place_bodies
from hydrosim.stepping.dynamics import Model, new_work
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


def combinations(
    model: Model, state: State, names: list[str], each_alone: bool = False
) -> list[Combination]:
    """All that are looked at. ``names`` are those of the free coordinates, then of the contact
    points, then of the springs."""
    time = _pressed_most(model)
    found = []
    for contact, modes in _modes(model, names, each_alone):
        linear = _linearise(model, state, modes, time)
        found.append(Combination(contact, modes, linear, linalg.eigvals(linear.jacobian)))
    return found


def step_limits(
    found: Sequence[Combination], method: Tableau, model: Model, names: list[str], step: float
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


def _steps(method: Tableau, values: np.ndarray) -> np.ndarray:
    """The largest stable step [s] of each eigenvalue."""
    return ray_limits(method, np.angle(values)) / np.maximum(np.abs(values), 1e-12)


def _below(
    bound: float, combination: Combination, method: Tableau, model: Model, names: list[str]
) -> Iterator[StepLimit]:
    """The limits below ``bound`` of one linearisation."""
    values, share = participation(combination.linear)
    steps = _steps(method, values)
    for k in np.flatnonzero(steps < bound):
        what = what_moves(combination.linear, share[:, k], model, names)
        yield StepLimit(float(steps[k]), complex(values[k]), combination.contact, what)


def ray_limits(method: Tableau, angle: np.ndarray) -> np.ndarray:
    """Largest |z| up to which the method is stable on the rays z = r exp(i angle), (n,);
    infinite for rays into the right half plane, where the motion itself grows."""
    R, places = stability_function(method), np.linspace(0.0, REACH, 8001)[1:]
    rays, which = np.unique(np.abs(angle), return_inverse=True)  # |R| is the same below and above
    limits = [_first_unstable(R, places, phi) if np.cos(phi) <= 1e-9 else np.inf for phi in rays]
    return np.array(limits, dtype=float)[which]


def _first_unstable(
    R: Callable[[np.ndarray], np.ndarray], places: np.ndarray, angle: float
) -> float:
    """The first of the ``places`` on a ray at which a method is unstable; infinite if none is."""
    direction = np.exp(1j * angle)
    for start in range(0, places.size, AT_ONCE):
        r = places[start : start + AT_ONCE]
        unstable = np.flatnonzero(np.abs(R(r * direction)) > 1.0 + GROWTH * r / (2 * np.pi))
        if unstable.size:
            return float(r[unstable[0]])
    return np.inf


def stability_function(method: Tableau) -> Callable[[np.ndarray], np.ndarray]:
    """R(z) = det(I - z A + z 1 b^T) / det(I - z A), what one step makes of y' = lambda y with
    z = h lambda (Hairer & Wanner 1996, IV.3.5)."""
    numerator = np.poly(method.a - np.outer(np.ones(method.b.size), method.b))
    denominator = np.trim_zeros(np.poly(method.a), "b")  # 1 of an explicit method
    return lambda z: np.polyval(numerator[::-1], z) / np.polyval(denominator[::-1], z)


def _modes(model: Model, names: list[str], each_alone: bool) -> Iterator[tuple[str, np.ndarray]]:
    """Those of all contacts with all springs slack; with springs, also with all of them taut, and
    if asked each spring alone taut."""
    points, springs = model.elements.fenders.points, model.elements.springs
    lines, segments = springs.lines, springs.segments
    for contact, modes in _contact_modes(model, names, each_alone):
        yield f"{contact}, springs slack" if lines.size else contact, modes
        taut, end = modes.copy(), points.size + lines.size
        taut[points.size : end, MODE] = TAUT
        taut[points.size : end, SEGMENT] = [_steepest(segments, line) for line in lines]
        if lines.size:
            yield f"{contact}, springs taut", taut
        for i in range(points.size, end if each_alone and lines.size > 1 else 0):
            alone = modes.copy()
            alone[i] = taut[i]
            yield f"{contact}, {names[model.bodies.active.size + i]} alone taut", alone


def _contact_modes(
    model: Model, names: list[str], each_alone: bool
) -> Iterator[tuple[str, np.ndarray]]:
    """All points open, sticking or slipping, and if asked each alone sticking or slipping."""
    points, lines = model.elements.fenders.points, model.elements.springs.lines
    steep = [_steepest(model.elements.fenders.segments, point) for point in points]
    modes = new_modes(model.elements)
    modes[: points.size + lines.size, SEGMENT] = [*points["first"], *lines["first"]]
    guides, triggers = model.elements.guides, model.elements.triggers
    modes[guides.mode :][: guides.pins.size, MODE] = FREE
    modes[guides.mode :][: guides.pins.size, SEGMENT] = guides.pins["first"]
    modes[triggers.mode :][: triggers.each.size, MODE] = DURING
    yield "all contacts open" if points.size else "no contact", modes
    for mode in (STICK, SLIP) if points.size else ():
        closed = modes.copy()
        closed[: points.size, MODE], closed[: points.size, SEGMENT] = mode, steep
        closed[guides.mode :][: guides.pins.size, MODE] = PRESSED_BY_WALL
        yield f"all contacts {NAMES[mode]}", closed
        for i in range(points.size if each_alone and points.size > 1 else 0):
            alone = modes.copy()
            alone[i] = closed[i]
            yield f"{names[model.bodies.active.size + i]} alone {NAMES[mode]}", alone


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
    return linearise(pressed, _sliding(pressed, state, modes, time), modes, time)


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
    shares = {name: share[i] + share[n + i] for i, name in enumerate(names[:n])}
    shares["the radiation states"] = other[node < 0].sum()
    for i, name in enumerate(names[n : n + fenders.points.size]):
        shares[f"the contact node of {name}"] = other[node == i].sum()
    return max(shares, key=shares.__getitem__)
