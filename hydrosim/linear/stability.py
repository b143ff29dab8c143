"""The largest stable step of a scene, before it is run.

A method with stability function R damps a mode of eigenvalue lambda only while |R(h lambda)| <= 1
(Hairer & Wanner 1996, IV.2). The scene is linearised in several postures: all contact points open,
all sticking, all slipping, and single ones alone if requested. Contacts are on the steepest piece
of their curve, or under their largest prescribed force. Springs are all slack or all taut on their
steepest pieces, with lengths adjusted to these.

The smallest limit on h is the scene's. Other limits below the step are reported with it, because
each of them will oscillate or diverge. Growth by less than a thousandth per period of the mode
counts as an error, not as an instability. Otherwise no second-order method could integrate an
undamped mode.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from hydrosim.forces import kinds_with_mode_sets, loop_modes, modes_of_kind, new_modes
from hydrosim.forces.postures import KindWithModeSets, ModeSet
from hydrosim.integrate import IntegrationMethod
from hydrosim.linear.coordinates import inertia
from hydrosim.linear.freedom import find_constraint_rows, nullspace_of
from hydrosim.linear.linearise import Eigensystem, Linear, linearise
from hydrosim.linear.modes import participation_factors
from hydrosim.rigid.free import own_coordinates
from hydrosim.rigid.kinematics import place_bodies
from hydrosim.scene import Scene
from hydrosim.stepping.dynamics import Model, dynamic_states, motion_at, new_work
from hydrosim.stepping.state import State
from hydrosim.stepping.state_layout import StateKind, StateLayout

GROWTH = 1e-3  # per period
REACH = 40.0  # largest |h lambda| at which stability functions are evaluated
AT_ONCE = 400  # points on a ray, of 8000 evaluated first: most limits are near its start
EQUAL_STEP_RTOL = 1e-6  # relative difference below which steps count as one


@dataclass(frozen=True)
class StepLimit:
    """The largest stable ``step`` [s], the ``eigenvalue`` that sets it, the contact modes at which
    it occurs, and what moves in it."""

    step: float
    eigenvalue: complex
    contact: str
    what: str

    def describe(self, step: float) -> str:
        """One line on a run with this ``step``."""
        z = abs(self.eigenvalue) * step
        limit = abs(self.eigenvalue) * self.step
        return (
            f"largest stable step {self.step:.3g} s: {self.what}, {self.contact}; at {step:g} s"
            f" |lambda| h is {z:.3g}, the limit of the method there {limit:.3g}"
        )


class UncoupledPart(NamedTuple):
    """An uncoupled part of a linearised scene, and its ``spectrum``."""

    linear: Linear
    spectrum: Eigensystem

    @property
    def values(self) -> np.ndarray:
        """Its eigenvalues (m,) [1/s]."""
        return self.spectrum.values


class Combination(NamedTuple):
    """A scene linearised with its contacts and springs in ``modes`` (rows, 3), described by
    ``contact``, as its ``components``."""

    contact: str
    modes: np.ndarray
    components: tuple[UncoupledPart, ...]

    @property
    def values(self) -> np.ndarray:
        """The eigenvalues (m,) of all components [1/s]."""
        return np.concatenate([part.values for part in self.components])


Watch = Callable[[Sequence[Any], str], Iterable[Any]]
"""Yields the items of a sequence and shows its progress under this name."""


def without_progress(items: Sequence[Any], _: str) -> Iterable[Any]:
    """The items, without a progress display."""
    return items


def combinations(
    scene: Scene,
    model: Model,
    state: State,
    each_alone: bool = False,
    watch: Watch = without_progress,
) -> list[Combination]:
    """All analysed combinations, with single units alone in a mode if ``each_alone``."""
    posing = [(kind, p) for kind, p in kinds_with_mode_sets(model) if kind.mode_sets(p)]
    time = max(kind.time_of_largest_load(p) for kind, p in posing)
    each = [
        (kind.mode_sets(p), _single_unit_modes(kind, p, scene, model, state) if each_alone else [])
        for kind, p in posing
    ]
    found = []
    known: dict[tuple[bytes, ...], Eigensystem] = {}
    for chosen in watch(list(_chosen(each)), "contacts and springs"):
        modes = _joint_modes(model, state)
        for (kind, p), posture in zip(posing, chosen, strict=True):
            modes_of_kind(kind, p, modes)[:] = posture.modes
        text = ", ".join(posture.text for posture in chosen if posture.text)
        found.append(_combination(text, modes, model, state, time, known))
    return found


def all_open(model: Model, state: State) -> Combination:
    """The first of `combinations`, with all contacts open, alone."""
    time = max(
        (kind.time_of_largest_load(p) for kind, p in kinds_with_mode_sets(model)), default=0.0
    )
    return _combination("", _at_rest(model, state), model, state, time, {})


def _combination(
    text: str,
    modes: np.ndarray,
    model: Model,
    state: State,
    time: float,
    known: dict[tuple[bytes, ...], Eigensystem],
) -> Combination:
    """The scene linearised in these ``modes``."""
    linear = _linearise(model, state, modes, time)
    parts = linear.split(linear.coupled_states)
    for part in parts:
        if part.content not in known:
            known[part.content] = Eigensystem(part)
    return Combination(
        text, modes, tuple(UncoupledPart(part, known[part.content]) for part in parts)
    )


def _chosen(
    each: Sequence[tuple[Sequence[ModeSet], Sequence[ModeSet]]],
) -> Iterator[tuple[ModeSet, ...]]:
    """One posture per kind: any posture of all its units, or a posture of a single unit with
    postures of all units of the other kinds."""
    if not each:
        yield ()
        return
    (every, alone), *others = each
    for posture in every:
        yield from ((posture, *further) for further in _chosen(others))
    together = [(of_all, ()) for of_all, _ in others]
    for posture in alone:
        yield from ((posture, *further) for further in _chosen(together))


def _single_unit_modes(
    kind: KindWithModeSets, p: Any, scene: Scene, model: Model, state: State
) -> list[ModeSet]:
    """Postures of single units. A unit alone vibrates with omega^2 = k J M^-1 J^T. So among equal
    units only those count that move most in one of their directions."""
    moves = _mobility(kind, p, model, state)
    keys = kind.equivalence_keys(p)
    alike = [np.flatnonzero([key == other for other in keys]) for key in dict.fromkeys(keys)]
    most = [same[moves[same].argmax(axis=0)] for same in alike]
    which = np.unique(np.concatenate([np.zeros(0, dtype=int), *most]))
    return list(kind.one_unit_active(p, kind.unit_names(scene), which.tolist()))


def _mobility(kind: KindWithModeSets, p: Any, model: Model, state: State) -> np.ndarray:
    """J M^-1 J^T of each unit (n, k) [1/kg] in each of its directions."""
    n = model.bodies.active.size
    motion = new_work(model).motion
    rates = []
    for unit in np.eye(n):
        place_bodies(state.y[:n], unit, model.bodies, motion)
        rates.append(kind.rates(p, model.bodies, motion))
    J = np.array(rates)
    rows = find_constraint_rows(model, state.y, _at_rest(model, state))
    freedom = nullspace_of(rows, inertia(model, state.y))
    yielding = freedom.accelerate(J.reshape(n, -1)).reshape(J.shape)
    return np.asarray((J * yielding).sum(axis=0))


def step_limits(
    found: Sequence[Combination], method: IntegrationMethod, layout: StateLayout, step: float
) -> list[StepLimit]:
    """Limits below ``step`` [s] over all ``found`` combinations, rising: the smallest limit of
    everything that moves. Of equal limits one is kept. If none is below, the smallest of all; empty
    if any step is stable."""
    parts = [(x.contact, part) for x in found for part in x.components]
    least = _least_steps(found, method)
    bound = max(step, min(least, default=np.inf) * (1.0 + EQUAL_STEP_RTOL))
    limits = [
        limit
        for (contact, part), smallest in zip(parts, least, strict=True)
        if smallest < bound
        for limit in _limits_below(bound, contact, part, method, layout)
    ]
    rising: dict[str, StepLimit] = {}
    for limit in sorted(limits, key=lambda limit: limit.step):
        rising.setdefault(limit.what, limit)
    told = list(rising.values())
    return told[:1] + [b for a, b in pairwise(told) if b.step > a.step * (1.0 + EQUAL_STEP_RTOL)]


def smallest_step(found: Sequence[Combination], method: IntegrationMethod) -> float:
    """The smallest of the limits [s] of all ``found`` combinations; infinite if there is none."""
    return min(_least_steps(found, method), default=np.inf)


def _least_steps(found: Sequence[Combination], method: IntegrationMethod) -> list[float]:
    """The largest stable step [s] of each component of each combination."""
    values = [part.values for x in found for part in x.components]
    ends = np.cumsum([own.size for own in values])
    steps = np.split(_steps(method, np.concatenate(values)), ends[:-1])
    return [float(own.min(initial=np.inf)) for own in steps]


def _steps(method: IntegrationMethod, values: np.ndarray) -> np.ndarray:
    """The largest stable step [s] of each eigenvalue."""
    return ray_limits(method, np.angle(values)) / np.maximum(np.abs(values), 1e-12)


def _limits_below(
    bound: float, contact: str, part: UncoupledPart, method: IntegrationMethod, layout: StateLayout
) -> Iterator[StepLimit]:
    """The limits below ``bound`` of one component."""
    values, left, right = part.spectrum.vectors()
    share = participation_factors(left, right)
    steps = _steps(method, values)
    for k in np.flatnonzero(steps < bound):
        what = what_moves(part.linear, share[:, k], layout)
        yield StepLimit(float(steps[k]), complex(values[k]), contact, what)


def ray_limits(method: IntegrationMethod, angle: np.ndarray) -> np.ndarray:
    """Largest |z| up to which the method is stable on the rays z = r exp(i angle), (n,). Infinite
    for rays into the right half plane, where the motion itself grows."""
    places = np.linspace(0.0, REACH, 8001)[1:]
    # |R| is the same below and above the real axis
    rays, which = np.unique(np.abs(angle), return_inverse=True)
    limits = [
        _first_unstable(method, places, phi) if np.cos(phi) <= 1e-9 else np.inf for phi in rays
    ]
    return np.array(limits, dtype=float)[which]


def _first_unstable(method: IntegrationMethod, places: np.ndarray, angle: float) -> float:
    """The first of the ``places`` on a ray at which a method is unstable; infinite if there is
    none."""
    direction = np.exp(1j * angle)
    for start in range(0, places.size, AT_ONCE):
        r = places[start : start + AT_ONCE]
        unstable = np.flatnonzero(
            np.abs(method.stability(r * direction)) > 1.0 + GROWTH * r / (2 * np.pi)
        )
        if unstable.size:
            return float(r[unstable[0]])
    return np.inf


def _joint_modes(model: Model, state: State) -> np.ndarray:
    """New modes (rows, 3) in which loops of joints hold, as in the ``state``, and no lock does:
    what locks hold moves no faster than without them."""
    modes = new_modes(model)
    loops = loop_modes(model)
    modes[loops] = state.modes[loops]
    return modes


def _at_rest(model: Model, state: State) -> np.ndarray:
    """Modes (rows, 3) with all units at rest."""
    modes = _joint_modes(model, state)
    for kind, p in kinds_with_mode_sets(model):
        for posture in kind.mode_sets(p)[:1]:
            modes_of_kind(kind, p, modes)[:] = posture.modes
    return modes


def _linearise(model: Model, state: State, modes: np.ndarray, time: float) -> Linear:
    """Linearise with all units on the pieces of their curves given by ``modes``, and in steady
    slip."""
    pressed = _with_all_pressed(model, state, modes)
    start = _sliding(pressed, state, modes, time)
    idle = [k.idle_states(p, modes_of_kind(k, p, modes)) for k, p in kinds_with_mode_sets(model)]
    states = np.setdiff1d(dynamic_states(model), np.concatenate(idle))
    return linearise(pressed, start, modes, time, states=states)


def _with_all_pressed(model: Model, state: State, modes: np.ndarray) -> Model:
    """The model with every unit on its piece of its curve."""
    bodies = model.bodies
    motion = motion_at(model, state.y)
    changed = {
        kind.field: kind.moved_onto_segment(p, modes_of_kind(kind, p, modes), bodies, motion)
        for kind, p in kinds_with_mode_sets(model)
    }
    return model._replace(elements=model.elements._replace(**changed))


def _sliding(model: Model, state: State, modes: np.ndarray, time: float) -> State:
    """The state with all bodies moving sideways, each at a different speed, so that points also
    slip on other bodies; slipping units are in steady slip."""
    bodies = model.bodies
    n = bodies.active.size
    y = state.y.copy()
    posing = [(kind, p, modes_of_kind(kind, p, modes)) for kind, p in kinds_with_mode_sets(model)]
    speed = max(kind.sliding_speed(p, own, time) for kind, p, own in posing)
    if speed > 0.0:
        own = own_coordinates(bodies)
        y[n : n + own.size] += speed * (1 + own // 6) * (own % 6 < 2)
        y[n + own.size : 2 * n] += speed  # of joints
    motion = motion_at(model, y)
    for kind, p, own in posing:
        kind.set_steady_slip(p, own, time, bodies, motion, y)
    return state._replace(y=y)


def what_moves(linear: Linear, share: np.ndarray, layout: StateLayout) -> str:
    """Name of the coordinate, node of a unit or radiation with the largest ``share`` (m,) of a
    mode."""
    shares: dict[str, float] = {}
    for state, own in zip(linear.states, share, strict=True):
        kind, entry = layout.entry_at(state)
        moved = entry.coordinates[0].name if entry.coordinates else f"the {kind} of {entry.owner}"
        name = "the radiation states" if kind == StateKind.RADIATION else moved
        shares[name] = shares.get(name, 0.0) + own
    return max(shares, key=shares.__getitem__)
