"""The equilibrium of a scene, without stepping to it, and linear models of contacts pressed there.

It has zero velocities, no first-order waves and no friction. With friction there is a continuum of
equilibria, and a run's history determines which one it ends in. In the free coordinates q the
generalised loads vanish,

    Q(q) = S^T F(q, q' = 0) = 0.

Newton's method finds it with K = -dQ/dq by central differences, in the directions with stiffness.
These follow from the singular values of K over the inertia of each coordinate, [1/s^2]. The other
directions stay unchanged, and the loads along them make the bodies drift. The modes of contacts and
lines are updated in every iteration.

Where Newton's method gets stuck, as with slack lines, the bodies relax from the start without
inertia: p' = Q / m with the inertia m of each coordinate, in implicit steps 1/u that grow as the
loads fall (pseudo-transient continuation, Kelley & Keyes 1998, SIAM J. Numer. Anal. 35).

Constraints J q' = 0 other than friction hold with reactions: N^T Q = 0 in the directions N that
they allow, and K = -d(Q + J^T lambda)/dq with the reactions lambda at that position. Steps
integrate q' = N p, so that every position satisfies the constraints.

Linear models of contacts that are pressed where a scene is at rest.

Friction that holds is linear. A sticking contact node is the spring K2 with the damper C2 between
body and plane. A friction slope below its limit is a damper. Rigid friction is a constraint: no
motion along the plane at its point.

Friction that slips is not linear. So contacts are treated as held, as frictionless, or as open.
Constraints that leave no motion are refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, NamedTuple

import numpy as np

from hydrosim.elements import lasting_states, without_friction
from hydrosim.elements.contact.law import OPEN, STICK
from hydrosim.elements.contact.laws import COULOMB, FRICTIONLESS
from hydrosim.elements.events import set_initial_modes
from hydrosim.errors import InputError
from hydrosim.integrate.draught_interpolation import steady_filters
from hydrosim.integrate.dynamics import Model, Work, add_constraints, new_work, rhs
from hydrosim.integrate.state import State
from hydrosim.linear.linearise import DEPENDENT, find_constraint_rows, inertia, nullspace_of
from hydrosim.linear.modes import MIN_STIFFNESS_FREQUENCY, MIN_STIFFNESS_RATIO
from hydrosim.modes import MODE, NO_INDEX
from hydrosim.multibody.kinematics import generalised_force, place_bodies, positions_at

MAX_NEWTON_ITERATIONS = 100
RELAXATIONS = 300
MAX_RELAXATION = 1.0  # m, rad: longest step of a relaxation
RATE_CHANGES = (0.2, 2.0)  # of u, from one relaxation to the next
DIFFERENCE_STEP = 1e-5  # m, rad: of the central differences
WIDE = 1e-3  # of those of fourth order
RESIDUAL_RTOL = 1e-9  # of the weight: residual below which the scene is at rest
MOTION_TOLERANCES: Any = {
    "rtol": 1e-12,
    "atol": 1e-13,
}  # steps of the integration along allowed motions
NO_VALUES = np.zeros(0)


class StiffDirections(NamedTuple):
    """The directions with a stiffness. ``loads`` Q (r, n) are the loads that count there; ``moves``
    (n, r) times r numbers are changes of the coordinates. ``left`` (n, n) extracts from loads Q the
    part that nothing holds, ``carried_part`` (n, n) the part that constraints carry."""

    loads: np.ndarray
    moves: np.ndarray
    left: np.ndarray
    carried: np.ndarray

    def felt(self, loads: np.ndarray) -> np.ndarray:
        """The part of ``loads`` (n,) that counts."""
        return loads - self.left @ loads - self.carried @ loads


@dataclass(frozen=True)
class Rest:
    """A ``state`` at rest of the frictionless ``model`` at ``time`` [s], in the ``held``
    directions. ``residual`` is the largest load there over the ``weight`` [N] (moments: over weight
    times 1 m). ``drift`` (n,) [N, N m] are the loads that nothing holds."""

    model: Model
    state: State
    time: float
    residual: float
    drift: np.ndarray
    held: StiffDirections

    @property
    def position(self) -> np.ndarray:
        """Displacements of all bodies, (nb, 6)."""
        bodies = self.model.bodies
        return positions_at(bodies, self.state.y[: bodies.active.size])


class _Loads:
    """Loads of a model over the free coordinates at a time; of selected ``rows`` of forces if they
    are given."""

    def __init__(
        self, model: Model, state: State, time: float, rows: Sequence[int] | None = None
    ) -> None:
        self.model = model
        self.state = state
        self.time = time
        self.rows = rows
        self.smooth = model._replace(elements=without_friction(model.elements))
        self.work: Work = new_work(model)
        self.work.loads_only[0] = 1

    def loads_at(self, q: np.ndarray) -> np.ndarray:
        """Generalised loads (n,) [N, N m] on bodies that rest at the coordinates ``q`` (n,)
        [m, rad]. Contacts are open or closed as they are at ``q``."""
        model = self.model
        state = self.state
        work = self.work
        y = _state_at_rest(q, state, model)
        load = np.zeros(q.size)
        place_bodies(q, np.zeros(q.size), model.bodies, work.motion)
        set_initial_modes(
            self.time, y, state.modes, work.motion, model.bodies, model.elements, model.tanks
        )
        rhs(self.time, y, state.modes, state.history, model, work, np.zeros_like(y))
        total = work.total if self.rows is None else work.wrench[[*self.rows]].sum(axis=0)
        generalised_force(model.bodies, work.motion, total, load)
        return load

    def constraints(self, q: np.ndarray) -> np.ndarray:
        """J (m, n) of constraints other than friction at ``q``."""
        y = _state_at_rest(q, self.state, self.model)
        return find_constraint_rows(self.smooth, y, self.state.modes)

    def stiffness(self, q: np.ndarray) -> np.ndarray:
        """-dQ/dq, (n, n), of loads including the reactions of constraints, which turn with the
        bodies."""
        reactions = self.reactions(q)
        ahead, behind = (
            np.array(
                [
                    self._with_reactions(reactions, q + sign * s)
                    for s in DIFFERENCE_STEP * np.eye(q.size)
                ]
            )
            for sign in (1, -1)
        )
        return (behind - ahead).T / (2.0 * DIFFERENCE_STEP)

    def _with_reactions(self, reactions: np.ndarray, q: np.ndarray) -> np.ndarray:
        load = self.loads_at(q)
        return load + self.constraints(q).T @ reactions if reactions.size else load

    def stiff_directions(
        self, q: np.ndarray, directions: StiffDirections | None = None
    ) -> StiffDirections:
        """The directions with a stiffness at ``q``, in the same number as ``directions`` if
        given."""
        rows = self.constraints(q)
        if directions and not len(rows):
            return directions
        scale = self.scale(q)
        free = nullspace_of(rows / scale, np.eye(q.size))
        K = self.stiffness(q) / np.multiply.outer(scale, scale)
        if not np.isfinite(K).all():
            raise InputError(
                f"equilibrium at {self.time:g} s: none found, because a line, a landing or a joint"
                " has no force near where the bodies are. Start closer to equilibrium"
                " (initial.position); a run from there names the element."
            )
        U, sizes, V = np.linalg.svd(free.project_matrix(K))
        r = int(
            np.count_nonzero(
                sizes
                > max(MIN_STIFFNESS_FREQUENCY**2, MIN_STIFFNESS_RATIO * sizes.max(initial=0.0))
            )
        )
        r = len(directions.loads) if directions else r
        U = free.expand(U)
        V = free.expand(V.T).T
        left = scale[:, None] * (U[:, r:] @ U[:, r:].T) / scale
        return StiffDirections(
            U[:, :r].T / scale, V[:r].T / scale[:, None], left, self.carried_part(q)
        )

    def scale(self, q: np.ndarray) -> np.ndarray:
        """Roots (n,) of the inertias of all coordinates at ``q``."""
        return np.sqrt(np.diag(inertia(self.model, _state_at_rest(q, self.state, self.model))))

    def reactions(self, q: np.ndarray) -> np.ndarray:
        """Forces (m,) of constraints that balance all loads at ``q`` best."""
        rows = self.constraints(q)
        if not len(rows):
            return NO_VALUES
        scale = self.scale(q)
        return np.asarray(-self.loads_at(q) / scale @ np.linalg.pinv(rows / scale, DEPENDENT))

    def carried_part(self, q: np.ndarray) -> np.ndarray:
        """The part of loads at ``q`` that constraints carry, see `StiffDirections`."""
        rows = self.constraints(q)
        if not len(rows):
            return np.zeros((q.size, q.size))
        scale = self.scale(q)
        J = rows / scale
        return np.asarray(scale[:, None] * (np.linalg.pinv(J, DEPENDENT) @ J) / scale)

    def move(self, q: np.ndarray, step: np.ndarray) -> np.ndarray:
        """The position a ``step`` (n,) from ``q`` (n,), along motions that constraints allow."""
        if not len(self.constraints(q)):
            return q + step

        def allowed_rate(_: float, place: np.ndarray) -> np.ndarray:
            M = inertia(self.model, _state_at_rest(place, self.state, self.model))
            free = nullspace_of(self.constraints(place), M)
            return free.expand(free.project_motions(step))

        from scipy.integrate import solve_ivp  # slow to load, and rarely needed

        moved = solve_ivp(allowed_rate, (0.0, 1.0), q, "DOP853", **MOTION_TOLERANCES)
        return np.asarray(moved.y[:, -1])


def equilibrium(
    model: Model, state: State, time: float, weight: float, held: StiffDirections | None = None
) -> Rest:
    """The equilibrium near ``state`` of a ``model`` without friction and first-order waves, under
    the forces of ``time`` [s]; ``weight`` [N] is the weight of all bodies.

    Directions without stiffness, or all directions outside ``held`` if given, stay unchanged.
    Raises InputError with the residual loads if there is no equilibrium in the other directions.
    """
    loads = _Loads(model, state, time)
    start = state.y[: model.bodies.active.size]
    first_modes = state.modes.copy()
    for approach in (_solve_by_newton, _solve_by_relaxation):
        state.modes[:] = first_modes
        q = approach(start.copy(), loads, 1e-3 * RESIDUAL_RTOL * weight, held)
        here = loads.loads_at(q)
        now = loads.stiff_directions(q, held)
        residual = float(np.abs(now.felt(here)).max(initial=0.0) / weight)
        if residual <= RESIDUAL_RTOL:
            break
    drift = now.left @ here
    if not residual <= RESIDUAL_RTOL:
        raise InputError(
            f"equilibrium at {time:g} s: none found; the smallest residual load is"
            f" {residual:.1e} of the weight. Look for an unbalanced force, or start closer to"
            " equilibrium (initial.position)."
        )
    return Rest(
        model, state._replace(y=_state_at_rest(q, state, model)), time, residual, drift, now
    )


def _solve_by_newton(
    q: np.ndarray, loads: _Loads, enough: float, held: StiffDirections | None
) -> np.ndarray:
    """Position by Newton's method from ``q``, with loads below ``enough`` if it is found."""
    here = loads.loads_at(q)
    for _ in range(MAX_NEWTON_ITERATIONS):
        now = loads.stiff_directions(q, held)
        if np.abs(now.felt(here)).max(initial=0.0) <= enough:
            break
        stiffness = now.loads @ loads.stiffness(q) @ now.moves
        step = (
            now.moves @ np.linalg.lstsq(stiffness, now.loads @ here, rcond=MIN_STIFFNESS_RATIO)[0]
        )
        q, here = _shorten_step(q, step, here, loads, now)
    return q


def _solve_by_relaxation(
    q: np.ndarray, loads: _Loads, enough: float, held: StiffDirections | None
) -> np.ndarray:
    """Position by relaxation from ``q``, with loads below ``enough`` if it is found."""
    here = loads.loads_at(q)
    rate: Any = np.nan  # u [1/s^2]
    for _ in range(RELAXATIONS):
        now = loads.stiff_directions(q, held)
        if np.abs(now.felt(here)).max(initial=0.0) <= enough:
            break
        stiffness = (now.moves.T @ loads.stiffness(q)) @ now.moves
        pull = now.moves.T @ now.felt(here)
        if np.isnan(rate):
            rate = np.linalg.norm(stiffness, 2)
        step = now.moves @ np.linalg.solve(stiffness + rate * np.eye(len(pull)), pull)
        q = loads.move(q, step / max(np.abs(step).max() / MAX_RELAXATION, 1.0))
        here = loads.loads_at(q)
        change = np.linalg.norm(now.moves.T @ now.felt(here)) / np.linalg.norm(pull)
        rate *= np.clip(change, *RATE_CHANGES) if change <= 1.0 else RATE_CHANGES[1]
    return q


def stiffness_of(rest: Rest, rows: Sequence[int], step: float = WIDE) -> np.ndarray:
    """-dQ/dq (n, n) of selected ``rows`` of forces at rest, by differences of fourth order with a
    ``step`` [m, rad]; exact to 1e-12 for trigonometric functions."""
    state = rest.state._replace(modes=rest.state.modes.copy())
    loads = _Loads(rest.model, state, rest.time, rows)
    q = state.y[: rest.drift.size]
    behind, ahead, far_behind, far_ahead = (
        np.array([loads.loads_at(q + shift) for shift in size * step * np.eye(q.size)])
        for size in (-1.0, 1.0, -2.0, 2.0)
    )
    return (8.0 * (behind - ahead) - (far_behind - far_ahead)).T / (12.0 * step)


def _state_at_rest(q: np.ndarray, state: State, model: Model) -> np.ndarray:
    """y at rest at ``q`` with the tank contents of a ``state``."""
    y = np.zeros_like(state.y)
    y[: q.size] = q
    if model.family.body.size:
        coordinates = positions_at(model.bodies, q).ravel()
        y[model.draught : model.energy] = steady_filters(model.family, coordinates)
    tanks = model.tanks
    held = slice(tanks.state, tanks.state + tanks.each.size)
    y[held] = state.y[held]
    lasting = lasting_states(model)
    y[lasting] = state.y[lasting]
    return y


def _shorten_step(
    q: np.ndarray, step: np.ndarray, load: np.ndarray, loads: _Loads, held: StiffDirections
) -> tuple[np.ndarray, np.ndarray]:
    """The step, halved until the held loads decrease; the last one tried if they never do."""
    size = np.linalg.norm(held.felt(load))
    for halvings in range(30):
        trial = loads.move(q, step / 2.0**halvings)
        loads_there = loads.loads_at(trial)
        if (
            np.linalg.norm(held._replace(carried=loads.carried_part(trial)).felt(loads_there))
            < size
        ):
            break
    return trial, loads_there


class Contacts(StrEnum):
    """State of contacts that are pressed at rest: friction holds them, they slide freely, or they
    are open, as if they did not exist."""

    STUCK = "stuck"
    SLIDING = "sliding"
    OPEN = "open"


def pressed_points(model: Model, state: State) -> np.ndarray:
    """Indices (k,) of the contact points that are not open."""
    return np.flatnonzero(state.modes[: model.elements.fenders.points.size, MODE] != OPEN)


def with_contacts(
    model: Model, rest: State, contacts: Contacts, names: Sequence[str]
) -> tuple[Model, State]:
    """The model and the state at ``rest``, with its contact points, called ``names``, in the state
    ``contacts``. Raises InputError if rigid friction leaves no motion."""
    modes = rest.modes.copy()
    points = pressed_points(model, rest)
    law = model.elements.fenders.points["law"]
    if contacts == Contacts.STUCK:
        modes[points[law[points] != FRICTIONLESS], MODE] = STICK
        rigid = [names[i] for i in points[law[points] == COULOMB]]
        if rigid and not _leaves_motion(model, rest.y, modes):
            raise InputError(
                f"contacts: rigid friction (coulomb) holds {', '.join(rigid)} at rest, so that"
                " nothing can move. Use stick_slip with a stiffness, or contacts"
                f" {Contacts.SLIDING} (no friction) or {Contacts.OPEN}."
            )
        return model, rest._replace(modes=modes)
    if contacts == Contacts.OPEN:
        modes[points, MODE] = OPEN
    smooth = model._replace(elements=without_friction(model.elements))
    return smooth, rest._replace(modes=modes)


def _leaves_motion(model: Model, y: np.ndarray, modes: np.ndarray) -> bool:
    """True if constraints leave any motion."""
    freedom = nullspace_of(find_constraint_rows(model, y, modes), inertia(model, y))
    return freedom.is_unconstrained or freedom.basis.shape[1] > 0


def find_rigid_tractions(model: Model, state: State, forces: np.ndarray) -> np.ndarray:
    """Friction (..., points, 2) of all contact points along their planes, from ``forces`` (..., m)
    of constraints in a ``state``."""
    n = model.bodies.active.size
    work = new_work(model)
    place_bodies(state.y[:n], np.zeros(n), model.bodies, work.motion)
    add_constraints(state.y, state.modes, model, work)
    points = model.elements.fenders.points.size
    tractions = np.zeros((*forces.shape[:-1], points, 2), dtype=forces.dtype)
    for r in np.flatnonzero(work.holds.point[: forces.shape[-1]] != NO_INDEX):
        tractions[..., work.holds.point[r], :] += forces[..., r, None] * work.holds.direction[r]
    return tractions
