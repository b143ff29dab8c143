"""External forces: wrenches that functions of the user or other programs give on bodies.

    F = f(t, motion of all bodies)

    stage         f is called at every stage of the method: its order. f depends on its arguments
                  alone, or the right hand side is not pure.
    held          f is called once where each accepted step ends; F is that value: order 1
    extrapolated  the same, F is the line through the last two values: order 2

    F(s) = F_n + (s - t_n) / (t_n - t_m) (F_n - F_m),   t_n <= s <= t_{n+1}

F: force and moment about the centre of gravity, earth frame; f with a point gives them about that
point. Work is F v. F_n, the value of the last call, and F_m are states. F_m is the value of the
call before, if that is at least `SHORTEST_LINE` of the next step earlier. Otherwise F_m is the
value so much earlier on the line through the two calls before. A line through values that are
closer together would make a large force of a small difference. Where no such line is known, F_n is
held. Where a mode switches, motions may jump, so the line begins anew with one value. A step that
is cut there is two steps.

A delay makes energy (Colgate & Schenkel 1997, of the sampled spring): the integral of (F - f) v is
booked apart, as a part of the work. f is known where steps end, and F is equal to it where a step
of length h begins; r h = t_n - t_m, v is linear, and F - f over the step is

    (F - f)(t_n + x h) = x (F - f)(t_{n+1}),  or  x (x + r) / (1 + r) (F - f)(t_{n+1})

if F is held, or extrapolated. Limits: the estimate has a relative error of the order of the step.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum, StrEnum
from math import nan, sqrt
from typing import Any, ClassVar, NamedTuple
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import ArrayLike

from hydrosim.dofs import DOFS
from hydrosim.elements.kind import (
    NO_CHART,
    Columns,
    ElementKind,
    Layout,
    StateBlocks,
    SummaryColumn,
    Topic,
    UnitRecord,
    Variable,
)
from hydrosim.errors import InputError
from hydrosim.files.interrupts import catching
from hydrosim.jit.kernels import assign, clear, kernel, root, root_giving
from hydrosim.jit.outside import call_python, register
from hydrosim.multibody.tree import record_angles
from hydrosim.scene import ForceElement, Scene

# State of the bodies that a function of the user sees.

ORIGIN = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class BodyState:
    """Motion of a body at one time, as in the dataset of a run.

    ``position`` (6,) [m, rad]: displacement of the centre of gravity from rest, along the earth's
    axes; roll, pitch and yaw. ``velocity`` (6,) [m/s, rad/s]: of the centre of gravity, and the
    angular velocity, in the earth frame. ``rotation`` (3, 3) turns vectors of the body frame into
    the earth frame, heading included. ``reference`` (3,) [m]: the centre of gravity at rest, in the
    earth frame; it cannot be changed. With small angles (``exact`` false) lever arms stay as they
    are at rest.
    """

    name: str
    position: np.ndarray
    velocity: np.ndarray
    rotation: np.ndarray
    reference: np.ndarray
    exact: bool = True

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(
            f"the state of a body has no {name!r}; it has position and velocity, each of"
            f" {len(DOFS)} numbers: {', '.join(DOFS)}; place(point), velocity_of(point) and"
            " wrench(force, point)"
        )

    def place(self, point: ArrayLike = ORIGIN) -> np.ndarray:
        """Place (3,) [m] in the earth frame of a ``point`` (3,) [m] of the body frame, from the
        centre of gravity."""
        centre = self.reference + self.position[:3]
        return np.asarray(centre + self.rotation @ np.asarray(point, float))

    def velocity_of(self, point: ArrayLike) -> np.ndarray:
        """Velocity (3,) [m/s] in the earth frame of a ``point`` (3,) [m] of the body frame."""
        turning = np.cross(self.velocity[3:], self.arm(point))
        return np.asarray(self.velocity[:3] + turning)

    def wrench(self, force: ArrayLike, point: ArrayLike = ORIGIN) -> np.ndarray:
        """Wrench (6,) [N, N m] about the centre of gravity of a ``force`` (3,) [N] in the earth
        frame on a ``point`` (3,) [m] of the body frame."""
        return np.concatenate(
            [np.asarray(force, float), np.cross(self.arm(point), np.asarray(force, float))]
        )

    def arm(self, point: ArrayLike) -> np.ndarray:
        """Lever arm (3,) [m] of a ``point`` of the body frame, along the earth's axes."""
        arm = np.asarray(point, float)
        return np.asarray(self.rotation @ arm) if self.exact else arm


class BodyStates(dict[str, BodyState]):
    """The state of each body by name."""

    def __missing__(self, name: str) -> BodyState:
        raise KeyError(f"no body {name!r}; expected one of {', '.join(self)}")


def read_only(values: np.ndarray) -> np.ndarray:
    """A copy of an array that cannot be changed."""
    copied = np.array(values, float)
    copied.flags.writeable = False
    return copied


def body_states(
    names: Sequence[str],
    references: Sequence[np.ndarray],
    coordinates: np.ndarray,
    velocity: np.ndarray,
    rotation: np.ndarray,
    exact: bool,
) -> BodyStates:
    """The state of each body by name. ``coordinates`` and ``velocity`` (6 nb,), ``rotation``
    (9 nb,) are copied; ``references`` (3,) are not."""
    place = coordinates.reshape(-1, 6).copy()
    speed = velocity.reshape(-1, 6).copy()
    turn = rotation.reshape(-1, 3, 3).copy()
    return BodyStates(
        (name, BodyState(name, place[b], speed[b], turn[b], references[b], exact))
        for b, name in enumerate(names)
    )


# Call of a function of the user from kernels, with checks of what it returns.

Function = Callable[[float, Mapping[str, BodyState]], ArrayLike]
"""f(t, state): wrench (6,) [N, N m], or (k, 6) for k bodies, at the time t [s]."""


_last_callers: WeakValueDictionary[int, Caller] = WeakValueDictionary()
"""The last caller of each function that may remember, by the function's identity."""


class Caller:
    """Calls a ``function`` with the states of all bodies, called ``names``. Its wrenches act on the
    ``bodies`` (their numbers), about their centres of gravity or about the ``point`` of the first.

    After an ``error`` the function is not called again. A function that ``remembers`` may not be
    called by two runs in turn; ``owner`` is an object of its run.
    """

    def __init__(
        self,
        function: Function,
        names: Sequence[str],
        references: Sequence[np.ndarray],
        bodies: Sequence[int],
        point: Sequence[float] | None,
        remembers: bool = False,
        owner: object | None = None,
    ) -> None:
        self.error: BaseException | None = None
        self.number = register(self)
        self._function = function
        self._names = names
        self._references = [read_only(reference) for reference in references]
        self._bodies = bodies
        self._point = point
        self._remembers = remembers
        self._owner = owner
        self._has_called = False

    def answer(
        self,
        t: float,
        exact: bool,
        coordinates: np.ndarray,
        velocity: np.ndarray,
        rotation: np.ndarray,
    ) -> bool:
        """Replace the ``coordinates`` (6 nb,) of all bodies by the wrenches on them. Returns
        false, and keeps the error, if the function raises or returns no wrench."""
        if self.error is not None:
            return False
        before = catching.catches
        try:
            catching.catches = True
            if self._remembers:
                self._check_owner()
            states = body_states(
                self._names, self._references, coordinates, velocity, rotation, exact
            )
            wrench = self._wrench(self._function(t, states))
            if self._point is not None:
                first = states[self._names[self._bodies[0]]]
                wrench[0, 3:] += first.wrench(wrench[0, :3], self._point)[3:]
        except BaseException as error:  # also an interrupt: machine code knows no exceptions
            catching.catches = before
            self.error = error
            return False
        catching.catches = before
        coordinates[:] = 0.0
        coordinates.reshape(-1, 6)[self._bodies] = wrench
        return True

    def _check_owner(self) -> None:
        """Raises ValueError if another run has called the function since this one did."""
        key = id(self._function)  # valid while a caller keeps the function
        last = _last_callers.get(key)
        if self._has_called and last is not None and last._owner is not self._owner:
            raise ValueError(
                "another run has called the same function since, and it may remember; give each run"
                " an object of its own, or say UserForce(..., repeatable=True) if it depends on its"
                " arguments alone"
            )
        self._has_called = True
        _last_callers[key] = self

    def _wrench(self, returned: Any) -> np.ndarray:
        """Wrenches (k, 6) that the function has returned. Raises ValueError if they are none."""
        count = len(self._bodies)
        if returned is None:
            raise ValueError("returned nothing; expected 6 numbers: force [N] and moment [N m]")
        try:
            wrench = np.array(returned, float)
        except (TypeError, ValueError):
            raise ValueError(
                f"returned {type(returned).__name__}; expected 6 numbers: force [N] and moment"
                " [N m] in the earth frame"
            ) from None
        if wrench.shape != (count, 6) and (count > 1 or wrench.shape != (6,)):
            expected = f"({count}, 6)" if count > 1 else "(6,)"
            raise ValueError(
                f"returned an array of shape {wrench.shape}; expected {expected}: force [N] and"
                " moment [N m] in the earth frame"
            )
        if not np.isfinite(wrench).all():
            raise ValueError(f"returned {wrench.tolist()}; expected finite numbers")
        return wrench.reshape(count, 6)


class Coupling(StrEnum):
    """When the function of an external force is called."""

    STAGE = "stage"
    HELD = "held"
    EXTRAPOLATED = "extrapolated"


ORDERS = {
    Coupling.STAGE: "the order of the method",
    Coupling.HELD: "order 1",
    Coupling.EXTRAPOLATED: "order 2",
}
"""Order of the error in the step."""


def _is_point(value: object) -> bool:
    try:
        numbers = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        return False
    return numbers.shape == (3,) and bool(np.isfinite(numbers).all())


@dataclass(frozen=True)
class UserForce(ForceElement):
    """A force that a function gives: ``function(t, state)`` returns a wrench (6,) [N, N m] on
    ``body``, in the earth frame about its centre of gravity, or about ``point`` [m] of the body
    frame. ``state`` has the `BodyState` of every body by name. With the names of other bodies in
    ``also``, it returns (1 + k, 6), that of ``body`` first.

    ``coupling`` is "stage" (called at every stage of the method, with its order; the function must
    depend on its arguments alone), "held" (called once per accepted step, in order; the value is
    kept over the next step: order 1) or "extrapolated" (the line through the last two: order 2).

    A function that is called once per step may remember. A restart then needs methods
    ``get_state()``, which returns something that JSON can hold, and ``set_state(state)``; or
    ``repeatable`` says that it remembers nothing.
    """

    supplies: ClassVar[bool] = True
    function: Function
    coupling: Coupling | str = Coupling.STAGE
    point: tuple[float, float, float] | None = None
    also: tuple[str, ...] = ()
    repeatable: bool = False
    _callers: dict[Any, Caller] = field(
        default_factory=dict, init=False, repr=False, compare=False, hash=False
    )
    _owner: object | None = field(default=None, init=False, repr=False, compare=False, hash=False)

    def check(self, name: str) -> None:
        key = f"forces.{name}"
        if not callable(self.function):
            type_name = type(self.function).__name__
            raise InputError(f"{key}.function: found {type_name}; expected a function f(t, state).")
        if self.coupling not in [*Coupling]:
            expected = ", ".join(Coupling)
            raise InputError(f"{key}.coupling: found {self.coupling}; expected {expected}.")
        if self.active is not None:
            raise InputError(
                f"{key}.active: found a condition; a function itself knows the time and the"
                " motions. Return zeros while it does not act."
            )
        if self.point is not None and (self.also or not _is_point(self.point)):
            raise InputError(
                f"{key}.point: found {self.point}; expected 3 coordinates [m], and one body. For"
                " several bodies, return wrenches about their centres of gravity"
                " (`BodyState.wrench`)."
            )
        if strangers := [body for body in self.also if not isinstance(body, str)]:
            raise InputError(f"{key}.also: found {strangers[0]!r}; expected names of bodies.")
        if len({self.body, *self.also}) < 1 + len(self.also):
            raise InputError(f"{key}.also: found a body twice; expected different bodies.")

    @property
    def delayed(self) -> bool:
        """Whether its function is called once per step."""
        return self.coupling != Coupling.STAGE

    @property
    def restarts(self) -> bool:
        """Whether a run can start from the end of another one with this force."""
        has_state = all(hasattr(self.function, name) for name in ("get_state", "set_state"))
        return not self.delayed or self.repeatable or has_state

    def describe(self) -> str:
        """Description for records."""
        bodies = ", ".join([self.body, *self.also])
        function = self.function
        name = getattr(function, "__qualname__", type(function).__qualname__)
        module = getattr(function, "__module__", None) or type(function).__module__
        order = ORDERS[Coupling(self.coupling)]
        return f"{module}.{name} on {bodies}, {self.coupling} ({order})"

    @property
    def error(self) -> BaseException | None:
        """Error of its last call, if it failed."""
        errors = (caller.error for caller in self._callers.values())
        return next((error for error in errors if error is not None), None)

    def caller(self, layout: Layout) -> Caller:
        """What kernels call, for bodies as in ``layout``; an earlier error is forgotten."""
        names = tuple(layout.body)
        key = names, tuple(tuple(map(float, origin)) for origin in layout.origin)
        if key not in self._callers:
            bodies = [layout.body[name] for name in (self.body, *self.also)]
            remembers = self.delayed and not self.repeatable
            self._callers[key] = Caller(
                self.function, names, layout.origin, bodies, self.point, remembers, self._owner
            )
        self._callers[key].error = None
        return self._callers[key]

    def copied_for(self, owner: object) -> UserForce:
        """The same force for one run, with errors of its own. ``owner`` is an object of the
        run."""
        copied = replace(self)
        object.__setattr__(copied, "_owner", owner)
        return copied

    def clear_error(self) -> None:
        """Forget the error of the last call."""
        for caller in self._callers.values():
            caller.error = None

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_callers": {}, "_owner": None}  # they belong to this process

    def connected_bodies(self) -> Iterator[tuple[str, str | None]]:
        yield from (("also", name) for name in self.also)

    def unit_names(self, name: str) -> Sequence[str]:
        return (name,) if self.delayed else ()


class Way(IntEnum):
    """`Coupling` for kernels."""

    STAGE = 0
    HELD = 1
    EXTRAPOLATED = 2


STAGE = int(Way.STAGE)
EXTRAPOLATED = int(Way.EXTRAPOLATED)
EXTERNAL = np.dtype(
    [
        *(("number", int), ("row", int), ("way", int), ("state", int)),
        *(("body", int), ("bodies", int)),
    ]
)
"""An external force: number of its `Caller`, row of forces, `Way`, place of its states among those
of all, and its bodies: ``bodies`` of them, from ``body`` on in ``members``."""
VECTORS = ("value", "value before", "velocity at")
"""States of each external force with a delay, six for every body: the value of the last call and
the earlier one of the line, and the velocity at the last call."""
CALL_TIME, EARLIER_CALL_TIME, LINE_KIND, CALLS, DELAY_ENERGY = range(5)
"""States that follow: times of both values [s], the kind of the line, the number of all calls, the
energy of the delay [J]."""
LARGEST_FORCE, LARGEST_MOMENT, OVERSHOOT, SCALARS = range(5, 9)
"""The largest force [N] and moment [N m] that the function has returned for a body, and the largest
ratio of a continued force or moment to that. Their number."""
SCALAR_NAMES = (
    *("time of call", "time of call before", "line", "calls", "energy of delay"),
    *("largest force", "largest moment", "overshoot"),
)
NO_VALUE, ONE_VALUE, DRAWN, TOO_SHORT = range(4)
"""Kinds of lines: the last value is of before a jump; there is one value; the line through two
values; two values that are too close together, so that the last one is held."""
SHORTEST_LINE = 0.25  # of the next step: shortest time between the two values of a line
ROUNDING_SHARE = 1e-9  # of a force, a moment per metre or a time: differences by less are rounding
EXTERNAL_OUTPUTS = 2  # calls and energy of the delay


class ExternalConstants(NamedTuple):
    """The external forces ``each`` (n,) of `EXTERNAL`, the ``members`` (m,) of their bodies, and
    the first of their states in y. ``delayed`` is how many are called once per step."""

    each: np.ndarray
    members: np.ndarray
    delayed: int
    state: int


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> ExternalConstants:
    """Constants of the external forces among ``elements``."""
    rows = []
    members: list[int] = []
    state = 0
    for name, e in elements.items():
        if not isinstance(e, UserForce):
            continue
        bodies = [layout.body[body] for body in (e.body, *e.also)]
        way = Way[Coupling(e.coupling).name]
        number = e.caller(layout).number
        rows.append((number, layout.row[name], way, state, len(members), len(bodies)))
        members += bodies
        state += size_of(len(bodies)) if e.delayed else 0
    delayed = sum(row[2] != STAGE for row in rows)
    return ExternalConstants(
        np.array(rows, EXTERNAL), np.array(members, dtype=np.int64), delayed, 0
    )


def size_of(bodies: int) -> int:
    """Number of states of a delayed force on so many bodies."""
    return 6 * bodies * len(VECTORS) + SCALARS


@root
def add_force(t, y, modes, motion, bodies, p, loads):
    """Write the wrench [N, N m] of every function to its row of ``wrench``, and its power [W] to
    ``rate``, in place."""
    for e in p.each:
        wrenches = loads.wrench[e.row]
        if e.way == STAGE:
            call_user_function(e, t, motion, bodies, wrenches)
        else:
            predict_wrench(e, t, y, p, wrenches)
            first = p.state + e.state
            clear(loads.dy[first : first + 18 * e.bodies + SCALARS])
        power = 0.0
        for i in range(wrenches.size):
            power += wrenches[i] * motion.velocity[i]
        loads.rate[e.row] += power


@kernel
def call_user_function(e, t, motion, bodies, wrenches):
    """The ``wrenches`` (6 nb,) that the function gives now; NaN and 0 if it fails."""
    assign(wrenches, motion.coordinates)
    if bodies.tree.branches.size > 0:
        record_angles(bodies, motion, wrenches)
    exact = 1 if bodies.exact else 0
    given = call_python(e.number, t, exact, wrenches, motion.velocity, motion.rotation)
    if given == 0:
        for i in range(wrenches.size):
            wrenches[i] = nan
    return given


@root
def call_at_stage(t, motion, bodies, p, wrench):
    """The wrench of every function that is called at stages, into its row of ``wrench``."""
    for e in p.each:
        if e.way == STAGE:
            call_user_function(e, t, motion, bodies, wrench[e.row])


@kernel
def predict_wrench(e, t, y, p, wrenches):
    """Write to ``wrenches`` (6 nb,) the values that is kept or extrapolated to ``t``."""
    value = p.state + e.state
    before = value + 6 * e.bodies
    scalar = value + 18 * e.bodies
    ahead = 0.0
    if follows_line(e, y, p):
        ahead = (t - y[scalar + CALL_TIME]) / (
            y[scalar + CALL_TIME] - y[scalar + EARLIER_CALL_TIME]
        )
    for k in range(e.bodies):
        b = p.members[e.body + k]
        for i in range(6):
            last = y[value + 6 * k + i]
            wrenches[6 * b + i] = last + ahead * (last - y[before + 6 * k + i])


@kernel
def follows_line(e, y, p):
    """True if the force follows a line now; otherwise it is held."""
    return e.way == EXTRAPOLATED and y[p.state + e.state + 18 * e.bodies + LINE_KIND] == DRAWN


@root_giving(bool)
def sample_user_functions(t, jumped, ahead, y, motion, bodies, p, wrench):
    """Call each function that is called once per step, at the end of a step, and keep its value in
    ``y``. Motions may have ``jumped`` there; the next step is at most ``ahead`` [s]. The rows of
    ``wrench`` are scratch. Returns false if one of them fails."""
    good = True
    for e in p.each:
        if e.way != STAGE:
            wrenches = wrench[e.row]
            if not sample_user_function(e, t, jumped, ahead, y, motion, bodies, p, wrenches):
                good = False
    return good


@kernel
def sample_user_function(e, t, jumped, ahead, y, motion, bodies, p, wrenches):
    """Call a function, unless it was called at this time; returns false if it fails."""
    scalar = p.state + e.state + 18 * e.bodies
    calls = y[scalar + CALLS]
    step = t - y[scalar + CALL_TIME]
    if calls > 0.0 and step <= 0.0:
        if jumped:
            y[scalar + LINE_KIND] = NO_VALUE
        return True
    passed = 0.0
    force = 0.0
    moment = 0.0
    if calls > 0.0:
        clear(wrenches)
        predict_wrench(e, t, y, p, wrenches)
        passed = work_of_rest(e, step, y, motion, p, wrenches)
        if follows_line(e, y, p):
            force, moment = largest_of(e, p, wrenches)
    if call_user_function(e, t, motion, bodies, wrenches) == 0:
        return False
    if calls > 0.0:
        y[scalar + DELAY_ENERGY] += passed - work_of_rest(e, step, y, motion, p, wrenches)
    compare_sizes(e, force, moment, y, p, wrenches)
    store_sample(e, t, jumped, SHORTEST_LINE * ahead, y, motion, p, wrenches)
    y[scalar + CALLS] = calls + 1.0
    return True


@kernel
def store_sample(e, t, jumped, shortest, y, motion, p, wrenches):
    """Keep the ``wrenches`` (6 nb,) of a call at ``t``, and the earlier value of its line,
    which is the ``shortest`` [s] or longer."""
    value = p.state + e.state
    before = value + 6 * e.bodies
    speed = value + 12 * e.bodies
    scalar = value + 18 * e.bodies
    time = y[scalar + CALL_TIME]
    time_before = y[scalar + EARLIER_CALL_TIME]
    latest = t - shortest * (1.0 - ROUNDING_SHARE)
    x = 1.0  # on the line so far, from the earlier value to the last one
    if y[scalar + LINE_KIND] >= DRAWN and time > latest:
        x = max(latest - time_before, 0.0) / (time - time_before)
    for k in range(e.bodies):
        b = p.members[e.body + k]
        for i in range(6):
            j = 6 * k + i
            y[before + j] = (1.0 - x) * y[before + j] + x * y[value + j]
            y[value + j] = wrenches[6 * b + i]
            y[speed + j] = motion.velocity[6 * b + i]
    y[scalar + EARLIER_CALL_TIME] = (1.0 - x) * time_before + x * time
    y[scalar + CALL_TIME] = t
    if jumped or y[scalar + CALLS] == 0.0 or y[scalar + LINE_KIND] == NO_VALUE:
        y[scalar + LINE_KIND] = ONE_VALUE
    else:
        earlier = time if x == 1.0 else time_before
        y[scalar + LINE_KIND] = DRAWN if earlier <= latest else TOO_SHORT


@kernel
def largest_of(e, p, wrenches):
    """The largest force [N] and the largest moment [N m] on a body among ``wrenches``
    (6 nb,)."""
    force = 0.0
    moment = 0.0
    for k in range(e.bodies):
        b = 6 * p.members[e.body + k]
        force = max(force, sqrt(wrenches[b] ** 2 + wrenches[b + 1] ** 2 + wrenches[b + 2] ** 2))
        moment = max(
            moment, sqrt(wrenches[b + 3] ** 2 + wrenches[b + 4] ** 2 + wrenches[b + 5] ** 2)
        )
    return force, moment


@kernel
def compare_sizes(e, force, moment, y, p, wrenches):
    """Compare the largest continued ``force`` [N] and ``moment`` [N m] with the largest that the
    function has returned, ``wrenches`` (6 nb,) included. Parts of a wrench that are rounding of the
    other do not count."""
    scalar = p.state + e.state + 18 * e.bodies
    returned_force, returned_moment = largest_of(e, p, wrenches)
    largest_force = max(returned_force, y[scalar + LARGEST_FORCE])
    largest_moment = max(returned_moment, y[scalar + LARGEST_MOMENT])
    y[scalar + LARGEST_FORCE] = largest_force
    y[scalar + LARGEST_MOMENT] = largest_moment
    if largest_force > ROUNDING_SHARE * largest_moment:
        y[scalar + OVERSHOOT] = max(y[scalar + OVERSHOOT], force / largest_force)
    if largest_moment > ROUNDING_SHARE * largest_force:
        y[scalar + OVERSHOOT] = max(y[scalar + OVERSHOOT], moment / largest_moment)


@kernel
def work_of_rest(e, step, y, motion, p, wrenches):
    """Work [J] over the last ``step`` [s] of a difference of forces that is ``wrenches`` (6 nb,) at
    its end and grows from zero."""
    speed = p.state + e.state + 12 * e.bodies
    scalar = p.state + e.state + 18 * e.bodies
    at_start = 1.0 / 6.0
    at_end = 1.0 / 3.0
    if follows_line(e, y, p):
        r = (y[scalar + CALL_TIME] - y[scalar + EARLIER_CALL_TIME]) / step
        at_start = (1.0 / 12.0 + r / 6.0) / (1.0 + r)
        at_end = (0.25 + r / 3.0) / (1.0 + r)
    work = 0.0
    for k in range(e.bodies):
        b = p.members[e.body + k]
        for i in range(6):
            v = at_start * y[speed + 6 * k + i] + at_end * motion.velocity[6 * b + i]
            work += step * wrenches[6 * b + i] * v
    return work


@root
def write_outputs(y, p, out):
    """Write the number of calls and the energy of the delay [J] of each delayed force to
    ``out``."""
    n = 0
    for e in p.each:
        if e.way != STAGE:
            scalar = p.state + e.state + 18 * e.bodies
            out[n] = y[scalar + CALLS]
            out[n + 1] = y[scalar + DELAY_ENERGY]
            n += EXTERNAL_OUTPUTS


class ExternalKind(ElementKind):
    unit = "external"
    variables: ClassVar = {
        "external_calls": Variable(
            "calls of the function of an external force so far",
            "1",
            chart=NO_CHART._replace(rank=Topic.CAPACITIES),
            summary=[SummaryColumn("calls", "count")],
            row_label="external force",
            is_detail=True,
        ),
        "external_delay_energy": Variable(
            "energy that the delay of an external force has given to the bodies",
            "J",
            chart=NO_CHART._replace(rank=Topic.CAPACITIES),
            summary=[SummaryColumn("energy of its delay", "at the end")],
            is_detail=True,
        ),
    }

    def states(self, p: ExternalConstants, scene: Scene) -> Iterator[StateBlocks]:
        for name, e in scene.forces.items():
            if isinstance(e, UserForce) and e.delayed:
                bodies = (e.body, *e.also)
                components = [
                    f"{what} {d} on {body}" for what in VECTORS for body in bodies for d in DOFS
                ]
                yield StateBlocks("external", [name], [*components, *SCALAR_NAMES])

    def record(self, p: ExternalConstants, bodies: Any, unit_record: UnitRecord) -> Columns:
        calls, energy = np.moveaxis(unit_record.observed, -1, 0)
        along = ("time", "external")
        return {"external_calls": (along, calls), "external_delay_energy": (along, energy)}


EXTERNAL_KIND = ExternalKind("externals", (UserForce,), compile_elements)


def extrapolation_overshoots(p: ExternalConstants, y: np.ndarray) -> Iterator[tuple[int, float]]:
    """Rows of forces that are called once per step, each with the largest ratio of an extrapolated
    force or moment to the largest that its function had returned."""
    for e in p.each:
        if e["way"] != STAGE:
            yield int(e["row"]), float(y[p.state + e["state"] + 18 * e["bodies"] + OVERSHOOT])
