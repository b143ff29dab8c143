"""The largest stable and the largest accurate step of a scene, before it is run.

The largest stable step.

A method with stability function R damps a mode of eigenvalue lambda only while |R(h lambda)| <= 1
(Hairer & Wanner 1996, IV.2). The scene is linearised in several postures: all contact points open,
all sticking, all slipping, and single ones alone if requested. Contacts are on the steepest piece
of their curve, or under their largest prescribed force. Springs are all slack or all taut on their
steepest pieces, with lengths adjusted to these.

The smallest limit on h is the scene's. Other limits below the step are reported with it, because
each of them will oscillate or diverge. Growth by less than a thousandth per period of the mode
counts as an error, not as an instability. Otherwise no second-order method could integrate an
undamped mode.

The largest accurate step.

A method with stability function R solves, instead of y' = lambda y, in steps of h exactly

    y' = lambda_h y,   lambda_h = log R(h lambda) / h

So Re lambda_h - Re lambda is its numerical damping and Im lambda_h - Im lambda its error of phase,
each per unit of time (van der Houwen & Sommeijer 1987). For the classical method of order 4
|lambda_h - lambda| is (w h)^4 w / 120, of which (w h)^5 w / 144 is damping. After a time t the
error of a free vibration of unit amplitude is |lambda_h - lambda| t exp(Re lambda t). The error of
the resonance of a damped mode is |lambda_h - lambda| / |Re lambda|. So

    error = |lambda_h - lambda| min(T, 1 / |Re lambda|)

is the error of a vibration that lasts for a time T. Parts that the mode's own damping has removed
do not count. Errors accumulate during the vibration, each part with the amplitude of its time. So T
is the integral of the amplitude over a contact, or the run, divided by the largest amplitude. These
amplitudes exclude the numerical damping of the method.

The error matters in proportion to the excitation of the mode by waves, by the start and by impacts.
The excitation of a coordinate q_i is

    2 |r_i| max |mean(l v exp(-i w t))| / |l r'|

with the right eigenvector (r, r', ...) of positions and rates, and the part l of the left one for
rates. The velocities v are those of a run while its contacts have the mode's state, stick or slip.
The mean over four periods of the mode removes motions forced at other frequencies, where the error
is small.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from hydrosim.elements import kinds_with_mode_sets, loop_modes, modes_of_kind, new_modes
from hydrosim.elements.contact.law import OPEN
from hydrosim.elements.kind import KindWithModeSets, ModeSet
from hydrosim.integrate.dynamics import Model, dynamic_states, motion_at, new_work
from hydrosim.integrate.methods import IntegrationMethod
from hydrosim.integrate.names import StateKind, StateLayout
from hydrosim.integrate.state import State
from hydrosim.linear.linearise import (
    Eigensystem,
    Linear,
    expand_to_active,
    find_constraint_rows,
    inertia,
    linearise,
    nullspace_of,
)
from hydrosim.linear.modes import SMALLEST_FLOAT, participation_factors
from hydrosim.modes import MODE, SEGMENT
from hydrosim.multibody.kinematics import own_coordinates, place_bodies, slopes_at_rest
from hydrosim.scene import Scene

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
    mode_sets = [
        (kind.mode_sets(p), _single_unit_modes(kind, p, scene, model, state) if each_alone else [])
        for kind, p in posing
    ]
    mode_combinations = []
    eigensystems: dict[tuple[bytes, ...], Eigensystem] = {}
    for chosen in watch(list(_chosen_mode_sets(mode_sets)), "contacts and springs"):
        modes = _joint_modes(model, state)
        for (kind, p), posture in zip(posing, chosen, strict=True):
            modes_of_kind(kind, p, modes)[:] = posture.modes
        text = ", ".join(posture.text for posture in chosen if posture.text)
        mode_combinations.append(_make_combination(text, modes, model, state, time, eigensystems))
    return mode_combinations


def open_contacts_combination(model: Model, state: State) -> Combination:
    """The first of `combinations`, with all contacts open, alone."""
    time = max(
        (kind.time_of_largest_load(p) for kind, p in kinds_with_mode_sets(model)), default=0.0
    )
    return _make_combination("", _modes_at_rest(model, state), model, state, time, {})


def _make_combination(
    text: str,
    modes: np.ndarray,
    model: Model,
    state: State,
    time: float,
    eigensystems: dict[tuple[bytes, ...], Eigensystem],
) -> Combination:
    """The scene linearised in these ``modes``."""
    linear = _linearise_modes(model, state, modes, time)
    parts = linear.split(linear.coupled_states)
    for part in parts:
        if part.content not in eigensystems:
            eigensystems[part.content] = Eigensystem(part)
    return Combination(
        text, modes, tuple(UncoupledPart(part, eigensystems[part.content]) for part in parts)
    )


def _chosen_mode_sets(
    mode_sets: Sequence[tuple[Sequence[ModeSet], Sequence[ModeSet]]],
) -> Iterator[tuple[ModeSet, ...]]:
    """One posture per kind: any posture of all its units, or a posture of a single unit with
    postures of all units of the other kinds."""
    if not mode_sets:
        yield ()
        return
    (every, alone), *others = mode_sets
    for posture in every:
        yield from ((posture, *further) for further in _chosen_mode_sets(others))
    together = [(of_all, ()) for of_all, _ in others]
    for posture in alone:
        yield from ((posture, *further) for further in _chosen_mode_sets(together))


def _single_unit_modes(
    kind: KindWithModeSets, p: Any, scene: Scene, model: Model, state: State
) -> list[ModeSet]:
    """Postures of single units. A unit alone vibrates with omega^2 = k J M^-1 J^T. So among equal
    units only those count that move most in one of their directions."""
    moves = _mobility_of_units(kind, p, model, state)
    keys = kind.equivalence_keys(p)
    alike = [np.flatnonzero([key == other for other in keys]) for key in dict.fromkeys(keys)]
    most = [same[moves[same].argmax(axis=0)] for same in alike]
    which = np.unique(np.concatenate([np.zeros(0, dtype=int), *most]))
    return list(kind.one_unit_active(p, kind.unit_names(scene), which.tolist()))


def _mobility_of_units(kind: KindWithModeSets, p: Any, model: Model, state: State) -> np.ndarray:
    """J M^-1 J^T of each unit (n, k) [1/kg] in each of its directions."""
    n = model.bodies.active.size
    motion = new_work(model).motion
    rates = []
    for unit in np.eye(n):
        place_bodies(state.y[:n], unit, model.bodies, motion)
        rates.append(kind.rates(p, model.bodies, motion))
    J = np.array(rates)
    rows = find_constraint_rows(model, state.y, _modes_at_rest(model, state))
    freedom = nullspace_of(rows, inertia(model, state.y))
    yielding = freedom.accelerate(J.reshape(n, -1)).reshape(J.shape)
    return np.asarray((J * yielding).sum(axis=0))


def step_limits(
    mode_combinations: Sequence[Combination],
    method: IntegrationMethod,
    layout: StateLayout,
    step: float,
) -> list[StepLimit]:
    """Limits below ``step`` [s] over all ``mode_combinations``, rising: the smallest limit of
    everything that moves. Of equal limits one is kept. If none is below, the smallest of all; empty
    if any step is stable."""
    parts = [(x.contact, part) for x in mode_combinations for part in x.components]
    least = _least_steps(mode_combinations, method)
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


def smallest_step(mode_combinations: Sequence[Combination], method: IntegrationMethod) -> float:
    """The smallest of the limits [s] of all ``mode_combinations``; infinite if there is none."""
    return min(_least_steps(mode_combinations, method), default=np.inf)


def _least_steps(
    mode_combinations: Sequence[Combination], method: IntegrationMethod
) -> list[float]:
    """The largest stable step [s] of each component of each combination."""
    values = [part.values for x in mode_combinations for part in x.components]
    ends = np.cumsum([eigenvalues.size for eigenvalues in values])
    steps = np.split(_largest_steps(method, np.concatenate(values)), ends[:-1])
    return [float(part_steps.min(initial=np.inf)) for part_steps in steps]


def _largest_steps(method: IntegrationMethod, values: np.ndarray) -> np.ndarray:
    """The largest stable step [s] of each eigenvalue."""
    return ray_limits(method, np.angle(values)) / np.maximum(np.abs(values), 1e-12)


def _limits_below(
    bound: float, contact: str, part: UncoupledPart, method: IntegrationMethod, layout: StateLayout
) -> Iterator[StepLimit]:
    """The limits below ``bound`` of one component."""
    values, left, right = part.spectrum.vectors()
    share = participation_factors(left, right)
    steps = _largest_steps(method, values)
    for k in np.flatnonzero(steps < bound):
        what = largest_participant(part.linear, share[:, k], layout)
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


def _modes_at_rest(model: Model, state: State) -> np.ndarray:
    """Modes (rows, 3) with all units at rest."""
    modes = _joint_modes(model, state)
    for kind, p in kinds_with_mode_sets(model):
        for posture in kind.mode_sets(p)[:1]:
            modes_of_kind(kind, p, modes)[:] = posture.modes
    return modes


def _linearise_modes(model: Model, state: State, modes: np.ndarray, time: float) -> Linear:
    """Linearise with all units on the pieces of their curves given by ``modes``, and in steady
    slip."""
    pressed = _press_all_units(model, state, modes)
    start = _moving_sideways(pressed, state, modes, time)
    idle = [k.idle_states(p, modes_of_kind(k, p, modes)) for k, p in kinds_with_mode_sets(model)]
    states = np.setdiff1d(dynamic_states(model), np.concatenate(idle))
    return linearise(pressed, start, modes, time, states=states)


def _press_all_units(model: Model, state: State, modes: np.ndarray) -> Model:
    """The model with every unit on its piece of its curve."""
    bodies = model.bodies
    motion = motion_at(model, state.y)
    elements = model.elements
    for kind, p in kinds_with_mode_sets(model):
        kind_modes = modes_of_kind(kind, p, modes)
        pressed = kind.moved_onto_segment(p, kind_modes, bodies, motion, state.y)
        elements = kind.replaced_in(elements, pressed)
    return model._replace(elements=elements)


def _moving_sideways(model: Model, state: State, modes: np.ndarray, time: float) -> State:
    """The state with all bodies moving sideways, each at a different speed, so that points also
    slip on other bodies; slipping units are in steady slip."""
    bodies = model.bodies
    n = bodies.active.size
    y = state.y.copy()
    posing = [(kind, p, modes_of_kind(kind, p, modes)) for kind, p in kinds_with_mode_sets(model)]
    speed = max(kind.sliding_speed(p, constants, time) for kind, p, constants in posing)
    if speed > 0.0:
        own_dofs = own_coordinates(bodies)
        rates = y[n : n + own_dofs.size]
        sideways = speed * (1 + own_dofs // 6) * (own_dofs % 6 < 2)
        if _are_apart(rates + sideways, own_dofs, 0.5 * speed):
            rates += sideways
        else:  # a start at such a speed may cancel it
            rates[own_dofs % 6 < 2] = sideways[own_dofs % 6 < 2]
        y[n + own_dofs.size : 2 * n] += speed  # of joints
    motion = motion_at(model, y)
    for kind, p, own_dofs in posing:
        kind.set_steady_slip(p, own_dofs, time, bodies, motion, y)
    return state._replace(y=y)


def _are_apart(rates: np.ndarray, own_dofs: np.ndarray, least: float) -> bool:
    """Whether bodies and the earth differ by so much, or more, in surge and in sway."""
    by_direction = (rates[own_dofs % 6 == direction] for direction in range(2))
    return all((np.diff(np.sort([0.0, *speeds])) >= least).all() for speeds in by_direction)


def largest_participant(linear: Linear, share: np.ndarray, layout: StateLayout) -> str:
    """Name of the coordinate, node of a unit or radiation with the largest ``share`` (m,) of a
    mode."""
    shares: dict[str, float] = {}
    for state, state_share in zip(linear.states, share, strict=True):
        kind, entry = layout.entry_at(state)
        moved = entry.coordinates[0].name if entry.coordinates else f"the {kind} of {entry.owner}"
        name = "the radiation states" if kind == StateKind.RADIATION else moved
        shares[name] = shares.get(name, 0.0) + state_share
    return max(shares, key=shares.__getitem__)


WRONG = 2.0  # error of a vibration that is out of phase
TRIED_STEP_RATIO = 2.0**0.125  # ratio between tried steps
FINEST = 1e-6  # of the step
MIN_VIBRATION_RATE = 1e-9  # rad/s: slower modes do not vibrate
MOVES = 0.05  # share of velocities in a mode, half in one of a body on a spring
# periods of a mean, and its fewest records
PERIODS = 4.0
MIN_RECORDS_PER_MEAN = 5
MAX_EXPONENT = 100.0  # of an exponent
RECORDED_PERIODS = (
    2.0  # records in that many periods: fewer do not distinguish a vibration from forced motion
)


@dataclass(frozen=True, eq=False)
class Vibration:
    """A mode that vibrates while contacts and springs are in ``modes`` (rows, 3), described by
    ``contact``; its ``eigenvalue`` [1/s], and ``what`` moves in it. If nothing else moves,
    velocities v (n,) correspond to the amplitudes ``amplitude`` (n,) |``felt`` (n,) v| of the
    coordinates."""

    contact: str
    modes: np.ndarray
    eigenvalue: complex
    what: str
    amplitude: np.ndarray
    felt: np.ndarray

    def error(self, method: IntegrationMethod, step: float, duration: float) -> float:
        """Error of the vibration relative to its amplitude, in a run of this ``duration`` [s]."""
        return float(vibration_errors(method, step, duration, np.array([self.eigenvalue]))[0])

    def accurate_step(
        self, method: IntegrationMethod, step: float, duration: float, error: float
    ) -> float:
        """The largest step, up to ``step`` [s], with an error of at most ``error``."""
        trial = step
        while self.error(method, trial, duration) > error and trial > FINEST * step:
            trial /= TRIED_STEP_RATIO
        return trial

    def fading(self, method: IntegrationMethod, step: float) -> float:
        """Excess damping rate [1/s] of the vibration by the method."""
        R = method.stability(np.array([step * self.eigenvalue]))
        made = float(np.log(np.maximum(np.abs(R[0]), SMALLEST_FLOAT))) / step
        return max(self.eigenvalue.real - made, 0.0)

    def largest_amplitudes(
        self, time: np.ndarray, velocity: np.ndarray, modes: np.ndarray, fading: float = 0.0
    ) -> tuple[np.ndarray, float]:
        """The largest amplitudes (n,) of the vibration in a run with velocities (nt, n) and
        ``modes`` (nt, rows, 3) at the records' ``time`` (nt,) [s], while contacts are in its modes.

        Also returns the duration [s] for which a vibration of that amplitude would have the error
        that it has in one contact. The method damps it at the rate ``fading`` [1/s].
        """
        touching, alike = self._records_in_mode(modes)
        felt = np.where(alike, velocity @ self.felt, 0.0)
        omega = self.eigenvalue.imag
        step = float(time[1] - time[0])
        samples = PERIODS * 2.0 * np.pi / (omega * step)
        if samples > RECORDED_PERIODS:
            window = np.hanning(max(round(samples), MIN_RECORDS_PER_MEAN) + 2)[1:-1]
            slow = felt * np.exp(-1j * omega * time)
            first = (window.size - 1) // 2
            felt = np.convolve(slow, window / window.sum())[first:][: time.size]
        size = np.where(touching, np.abs(felt), 0.0)
        largest = float(size.max())
        size = np.minimum(
            size * np.exp(np.minimum(fading * (time - time[0]), MAX_EXPONENT)), largest
        )
        ends = np.flatnonzero(np.diff(np.concatenate([[0], touching, [0]])))
        sums = np.add.reduceat(np.append(size, 0.0), ends)[::2] if ends.size else np.zeros(1)
        lasting = step * float(sums.max()) / largest if largest > 0.0 else 0.0
        return self.amplitude * largest, lasting

    def _records_in_mode(self, modes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Two arrays (nt,): records in contact on the mode's piece of the curve, and records that
        stick or slip as in the mode. Records beside such a record count, too. All are true if the
        mode has no contact."""
        closed = self.modes[:, MODE] != OPEN
        if not closed.any():
            return np.ones(len(modes), dtype=bool), np.ones(len(modes), dtype=bool)
        there = modes[:, closed, SEGMENT] == self.modes[closed, SEGMENT]
        there &= modes[:, closed, MODE] != OPEN
        alike = there & (modes[:, closed, MODE] == self.modes[closed, MODE])
        return _include_neighbours(there.any(axis=1)), _include_neighbours(alike.any(axis=1))


def _include_neighbours(here: np.ndarray) -> np.ndarray:
    """True also next to true entries (nt,)."""
    beside = here.copy()
    beside[1:] |= here[:-1]
    beside[:-1] |= here[1:]
    return beside


def vibration_errors(
    method: IntegrationMethod, step: float, duration: float, values: np.ndarray
) -> np.ndarray:
    """Errors of vibrations with eigenvalues ``values`` (m,) [1/s], relative to their amplitudes, as
    above."""
    z = step * values
    made = np.log(np.maximum(np.abs(R := method.stability(z)), SMALLEST_FLOAT)) + 1j * np.angle(R)
    turns = np.round((z.imag - made.imag) / (2.0 * np.pi))
    rate = np.abs(made + 2j * np.pi * turns - z) / step
    lasting = np.minimum(duration, 1.0 / np.maximum(np.abs(values.real), SMALLEST_FLOAT))
    return np.asarray(np.minimum(rate * lasting, WRONG))


def vibrations(
    mode_combinations: Sequence[Combination],
    method: IntegrationMethod,
    model: Model,
    layout: StateLayout,
    duration: float,
    step: float,
    error: float,
) -> Iterator[Vibration]:
    """Modes that vibrate with more than an ``error`` at a ``step`` [s], from all
    ``mode_combinations``. A memory by convolution shifts their eigenvalues by its effect at first
    order, l K^(i w) r'."""

    def wrong(values: np.ndarray) -> np.ndarray:
        return (values.imag > MIN_VIBRATION_RATE) & (
            vibration_errors(method, step, duration, values) > error
        )

    active = model.bodies.active
    for combination, (part, spectrum) in [
        (x, part) for x in mode_combinations for part in x.components
    ]:
        if not wrong(spectrum.values).any():
            continue
        values, left, right = spectrum.vectors()
        share = participation_factors(left, right)
        n = part.active.size
        own_indices = np.searchsorted(active, part.active)
        for k in np.flatnonzero(wrong(values)):
            felt = left[n : 2 * n, k].conj()
            rate = right[n : 2 * n, k]
            whole = np.vdot(left[:, k], right[:, k])
            if abs(felt @ rate) <= MOVES * abs(whole):
                continue  # hardly a motion of bodies
            K = memory_response(model, values[k].imag)[np.ix_(own_indices, own_indices)]
            memory = np.linalg.solve(part.inertia, K @ rate)
            value = complex(values[k] - felt @ memory / whole)
            if wrong(np.array([value])).any():
                what = largest_participant(part, share[:, k], layout)
                amplitude = expand_to_active(2.0 * np.abs(right[:n, k]), part.active, active)
                sensed = expand_to_active(felt / (felt @ rate), part.active, active)
                at = combination.contact, combination.modes
                yield Vibration(*at, value, what, amplitude, sensed)


def memory_response(model: Model, omega: float) -> np.ndarray:
    """Radiation K^(i w), (n, n), of a memory by convolution: force per velocity of the free
    coordinates at ``omega`` [rad/s]."""
    kernel = model.convolution
    size = len(model.added_mass)
    response = np.zeros((size, size), dtype=complex)
    turning = np.exp(-1j * omega * kernel.step * np.arange(len(kernel.K)))
    turning[[0, -1]] *= 0.5  # the trapezoidal rule
    response[kernel.row, kernel.column] = turning @ kernel.K
    S = slopes_at_rest(model.bodies)
    return np.asarray(kernel.step * (S.T @ response @ S))
