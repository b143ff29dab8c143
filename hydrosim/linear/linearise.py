"""The linearisation of a scene: free coordinates, constraints, components, and a test of linearity.

About a state y0 with fixed contact modes, the mechanical, radiation and stretch states z obey z' =
J z + G F. J is the derivative of the right hand side by central differences (exact except for
rounding where the scene is linear). G is the inverse inertia in the rows of the velocities.

With constraints J includes the reactions, and only allowed motions count: see `Freedom`. D(w) is
the stiffness without changes of these reactions; reactions at rest turn with the bodies: D q = F +
J^T lambda.

Test whether a scene is linear: its moving states obey z' = J z + G f(t) with constant J and G.

Small-angle kinematics are linear. Exact kinematics are linear if no body turns about more than one
axis: E is the unit vector along it, the inertia about it is constant, and the gyroscopic moment is
perpendicular to it. If a body with hydrodynamics turns with exact kinematics, its hydrodynamics
turn with it, and the scene is not linear.

Free coordinates of a scene: their velocities, their inertia, and difference steps.

Constraints of a scene in a state, and the motions that they leave.

Constraints are rows J of J q' = 0, with forces J^T lambda. They come from the function that runs
use: `hydrosim.integrate.dynamics.add_constraints`. With a basis N of all allowed q', J N = 0, the
motions are q = N p, and p obeys

    N^T M N p'' = N^T (dQ + d(J^T) lambda0) N p + ...

Q are all other loads. The second term is the geometric stiffness: reactions lambda0 that carry load
at rest turn with the bodies. The derivative of the right hand side includes it, because J is
evaluated at every position. With `kinematics: linear` J is constant, and neither the linearisation
nor runs have this term.

About a motion instead of a rest, the term with d(J) q' is left out, and N is that of the present
position.

Work on a whole system grows with the cube of its size, work on its components with their number.
Only an exact zero counts as no coupling, so that no weak line is left out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import linalg

from hydrosim.elements import Recorded, in_gusts, joints_are_linear, signals_of
from hydrosim.elements.kind import BODY_ROWS, constraint_names
from hydrosim.errors import InputError
from hydrosim.integrate.draught_interpolation import blend_draughts
from hydrosim.integrate.dynamics import (
    Model,
    add_constraints,
    dynamic_states,
    fill_jacobian,
    find_mass,
    most_constraints,
    new_work,
    rhs,
    update_contents,
)
from hydrosim.integrate.methods import Shifts, shift_each
from hydrosim.multibody.kinematics import acceleration_map, moving_dofs, place_bodies
from hydrosim.multibody.tree import BALL, NO_BODY, SLIDE, fill_rates
from hydrosim.scene import Scene, Turns
from hydrosim.water.build import wave_loads_model
from hydrosim.water.displaced_loads import following_model
from hydrosim.water.wind import NO_GUSTS

if TYPE_CHECKING:
    from hydrosim.integrate.state import State

STEP = 1e-4  # of the central differences: m, rad and their rates
CALM = wave_loads_model((), (), 0.0, 1.0, 1.0)
NO_FOLLOWED_BODIES = following_model((), ())


def without_waves(model: Model) -> Model:
    """The model in calm water and in the mean wind."""
    elements = in_gusts(model.elements, NO_GUSTS)
    return model._replace(waves=CALM, following=NO_FOLLOWED_BODIES, elements=elements)


def inertia(model: Model, y: np.ndarray) -> np.ndarray:
    """Inertia (n, n) of the free coordinates, added mass included, in the state ``y`` with its slow
    draughts and tank contents."""
    work = new_work(model)
    n = model.bodies.active.size
    A = model.added_mass
    matrix = np.zeros((n, n))
    place_bodies(y[:n], y[n : 2 * n], model.bodies, work.motion)
    if model.family.body.size:
        blend_draughts(y[model.draught :], model.family, A, work.blend)
        A = work.blend.added_mass
    update_contents(y, model, work)
    find_mass(model, A, work)
    acceleration_map(model.bodies, work.motion, work.mass, matrix)
    return matrix


DEPENDENT = 1e-9  # of the largest: rows that differ by less hold the same direction


@dataclass(frozen=True, eq=False)
class Freedom:
    """Motions (n,) that the ``rows`` J (m, n) of constraints allow, with the ``inertia`` (n, n).

    The columns of the ``basis`` N (n, n - rank) are orthonormal in coordinates scaled by the roots
    of their own inertias, so that metres and radians compare. Without constraints all methods
    return their arguments.
    """

    rows: np.ndarray
    inertia: np.ndarray
    basis: np.ndarray

    @property
    def is_unconstrained(self) -> bool:
        """True if there are no constraints."""
        return len(self.rows) == 0

    @property
    def has_dependent_rows(self) -> bool:
        """True if some rows depend on others, so that the force of each is not defined."""
        return not self.is_unconstrained and self.basis.shape[1] > self.rows.shape[1] - len(
            self.rows
        )

    def project_matrix(self, D: np.ndarray) -> np.ndarray:
        """N^T D N for ``D`` (..., n, n)."""
        return D if self.is_unconstrained else np.asarray(self.basis.T @ D @ self.basis)

    def project_loads(self, F: np.ndarray) -> np.ndarray:
        """N^T F for loads ``F`` (n, ...)."""
        return F if self.is_unconstrained else np.asarray(self.basis.T @ F)

    def expand(self, p: np.ndarray) -> np.ndarray:
        """N p for ``p`` (k, ...)."""
        return p if self.is_unconstrained else np.asarray(self.basis @ p)

    def project_motions(self, q: np.ndarray) -> np.ndarray:
        """The p whose N p is nearest to ``q`` (n, ...) by kinetic energy. For accelerations from
        loads without constraints it gives the accelerations with constraints."""
        if self.is_unconstrained:
            return q
        return np.asarray(
            linalg.solve(self.project_matrix(self.inertia), self.project_loads(self.inertia @ q))
        )

    def expand_covectors(self, left: np.ndarray) -> np.ndarray:
        """The covectors (n, ...) whose product with N p equals that of ``left`` (k, ...) with p."""
        if self.is_unconstrained:
            return left
        mass = self.project_matrix(self.inertia)
        return np.asarray(self.inertia @ self.expand(linalg.solve(mass, left)))

    def find_mobility(self) -> np.ndarray:
        """The accelerations (n, n) under unit loads, N (N^T M N)^-1 N^T."""
        if self.is_unconstrained:
            return np.asarray(linalg.inv(self.inertia))
        return self.accelerate(np.eye(len(self.inertia)))

    def accelerate(self, F: np.ndarray) -> np.ndarray:
        """The accelerations (n, r) under loads ``F`` (n, r)."""
        return self.expand(
            np.linalg.solve(self.project_matrix(self.inertia), self.project_loads(F))
        )

    def solve_motions(self, D: np.ndarray, F: np.ndarray) -> np.ndarray:
        """The motions q (..., n) with N^T D q = N^T F, for ``D`` (..., n, n) and ``F`` (..., n)."""
        if self.is_unconstrained:
            return np.asarray(np.linalg.solve(D, F[..., None])[..., 0])
        p = np.linalg.solve(self.project_matrix(D), (F @ self.basis)[..., None])[..., 0]
        return np.asarray(p @ self.basis.T)

    def solve_reactions(self, excess: np.ndarray) -> np.ndarray:
        """Forces lambda (..., m) of constraints that balance ``excess`` (..., n): loads that
        motions need and no other force provides. J^T lambda equals the excess."""
        return np.asarray(excess @ np.linalg.pinv(self.rows, DEPENDENT))


def nullspace_of(rows: np.ndarray, inertia: np.ndarray) -> Freedom:
    """The motions that constraints allow."""
    root = np.sqrt(np.diag(inertia))
    if not len(rows):
        return Freedom(rows, inertia, np.diag(1.0 / root))
    scaled = rows / root
    size = np.maximum(np.linalg.norm(scaled, axis=1, keepdims=True), np.finfo(float).tiny)
    basis = linalg.null_space(scaled / size, rcond=DEPENDENT)
    return Freedom(rows, inertia, np.asarray(basis / root[:, None]))


def find_constraint_rows(model: Model, y: np.ndarray, modes: np.ndarray) -> np.ndarray:
    """J (m, n) of all constraints of a model in a state ``y`` with contact ``modes``."""
    n = model.bodies.active.size
    if not most_constraints(model):
        return np.zeros((0, n))
    work = new_work(model)
    place_bodies(y[:n], np.zeros(n), model.bodies, work.motion)
    add_constraints(y, modes, model, work)
    return work.constraints.J[: work.constraints.number[0]].copy()


# Components of a linear system: parts without coupling, each solved by itself.


def find_components(coupled: np.ndarray) -> list[np.ndarray]:
    """Indices, rising, of the components of a graph. Its edges are the non-zero entries of
    ``coupled`` (n, n), in either direction."""
    edge = coupled != 0
    edge |= edge.T
    left = np.ones(len(edge), dtype=bool)
    components = []
    while left.any():
        reached = np.arange(left.size) == left.argmax()
        new = reached
        while new.any():
            new = edge[new].any(axis=0) & ~reached
            reached = reached | new
        components.append(np.flatnonzero(reached))
        left &= ~reached
    return components


def expand_to_active(values: np.ndarray, own_dofs: np.ndarray, active: np.ndarray) -> np.ndarray:
    """Expand the ``values`` (k,) of the coordinates ``own_dofs`` (k,) to all ``active`` coordinates
    (n,), rising; zero elsewhere."""
    every = np.zeros(active.size, dtype=values.dtype)
    every[np.searchsorted(active, own_dofs)] = values
    return every


FREQUENCIES_PER_BLOCK = 1000  # frequencies at a time
LARGE = 500  # states: vectors are nearly always needed, and cost as much again as values alone
SEPARATE = 1e7  # condition number of the eigenvectors up to which other states are diagonalised


class Others(NamedTuple):
    """All states except motion, diagonalised. Their acceleration per coordinate is the sum over
    their ``poles`` p (r,) of ``share`` / (i w - p), matrices (r, n, n), plus ``direct`` (n, n) from
    states driven by rates: i w / (i w - p) = 1 + p / (i w - p)."""

    poles: np.ndarray
    share: np.ndarray
    direct: np.ndarray


@dataclass(frozen=True, eq=False)
class Linear:
    """``jacobian`` (m, m) of the ``states`` (m,) of y. The first 2 n are the n free coordinates
    ``active`` (among 6 nb) and their rates. ``freedom`` are the motions that the c constraints
    allow. ``reactions`` (c, m) are the changes of their forces by state, NaN if the constraints
    change with position."""

    jacobian: np.ndarray
    states: np.ndarray
    active: np.ndarray
    freedom: Freedom
    reactions: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def inertia(self) -> np.ndarray:
        """Inertia of the n coordinates (n, n), added mass included."""
        return self.freedom.inertia

    @property
    def constraints(self) -> np.ndarray:
        """Rows of the constraints (c, n)."""
        return self.freedom.rows

    def dynamic_stiffness(self, omega: ArrayLike) -> np.ndarray:
        """D(w) = K - w^2 (M + A(w)) + i w B(w), (n, n), or (nw, n, n) for ``omega`` (nw,) [rad/s]:
        loads Re(D q exp(i w t)) cause the harmonic motion Re(q exp(i w t)). All other states are
        eliminated. Raises InputError if forces of constraints are not defined."""
        n = self.active.size
        every = np.atleast_1d(np.asarray(omega, dtype=float))
        unheld, others = self._at_rest
        own_rows = unheld[n : 2 * n]
        stiffness = np.empty((every.size, n, n), dtype=complex)
        for k in range(0, every.size, FREQUENCIES_PER_BLOCK):
            s = 1j * every[k : k + FREQUENCIES_PER_BLOCK, None, None]
            acceleration = own_rows[:, :n] + s * own_rows[:, n : 2 * n]
            acceleration = acceleration + _of_others(s, n, unheld, others)
            stiffness[k : k + FREQUENCIES_PER_BLOCK] = self.inertia @ (
                s * s * np.eye(n) - acceleration
            )
        return stiffness.reshape(*np.shape(omega), n, n)

    def response(self, omega: float, load: np.ndarray) -> np.ndarray:
        """Complex amplitudes (n,) of the coordinates under loads Re(load exp(i omega t)), (n,)."""
        D = self.dynamic_stiffness(omega)
        if self.freedom.is_unconstrained:
            return linalg.solve(D, load)
        return self.freedom.solve_motions(D, load)

    def reaction(self, omega: float, load: np.ndarray) -> np.ndarray:
        """Complex amplitudes (c,) of the forces of constraints under the same loads."""
        D = self.dynamic_stiffness(omega)
        motion = self.freedom.solve_motions(D, load)
        return self.freedom.solve_reactions(D @ motion - load)

    @property
    def content(self) -> tuple[bytes, ...]:
        """Data that determine the eigenvalues: equal for equal components."""
        return self.jacobian.tobytes(), self.inertia.tobytes(), self.constraints.tobytes()

    @property
    def coupled_states(self) -> np.ndarray:
        """States (m, m) that are coupled by forces, inertia or constraints."""
        n = self.active.size
        coupled = self.jacobian != 0.0
        coupled[:n, :n] |= self.inertia != 0.0
        held = self.constraints != 0.0
        coupled[:n, :n] |= held.T @ held
        if len(held):
            coupled[:n] |= held.T @ (self.reactions != 0.0)
        return coupled

    def split(self, coupled: np.ndarray) -> tuple[Linear, ...]:
        """The components of the states, given the ``coupled_states`` ones (m, m)."""
        places = find_components(coupled)
        # a row that holds no moving coordinate belongs to no part
        if len(places) < 2 or not self.constraints.any(axis=1).all():
            return (self,)
        return tuple(self._restrict(component) for component in places)

    def eigenvalues(self) -> np.ndarray:
        """Eigenvalues of the jacobian (k,) [1/s], in motions that constraints allow."""
        return np.asarray(linalg.eigvals(self._constrained_jacobian))

    def eigenvectors(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The eigenvalues (k,), left and right eigenvectors (m, k) over all states, one per column.
        With constraints, only products of left ones with allowed motions have a meaning."""
        values, left, right = linalg.eig(self._constrained_jacobian, left=True, right=True)
        if self.freedom.is_unconstrained:
            return values, left, right
        free = self.freedom
        return (
            values,
            self._change_motions(free.expand_covectors, left),
            self._change_motions(free.expand, right),
        )

    def _restrict(self, places: np.ndarray) -> Linear:
        """The part with the states at ``places`` (k,), rising."""
        own_dofs = places[places < self.active.size]
        rows = np.flatnonzero(self.constraints[:, own_dofs].any(axis=1))
        held = self.constraints[np.ix_(rows, own_dofs)]
        return Linear(
            self.jacobian[np.ix_(places, places)],
            self.states[places],
            self.active[own_dofs],
            nullspace_of(held, self.inertia[np.ix_(own_dofs, own_dofs)]),
            self.reactions[np.ix_(rows, places)] if len(held) else np.zeros((0, 0)),
        )

    @property
    def _constrained_jacobian(self) -> np.ndarray:
        """The jacobian of the states that constraints allow: (p, p', all others), q = N p."""
        if self.freedom.is_unconstrained:
            return self.jacobian
        rows = self._change_motions(self.freedom.project_motions, self.jacobian)
        return self._change_motions(self.freedom.project_loads, rows.T).T

    def _change_motions(
        self, change: Callable[[np.ndarray], np.ndarray], x: np.ndarray
    ) -> np.ndarray:
        """Apply the same change to positions and rates of ``x`` (m, ...); all other states are
        kept."""
        size = len(x) - len(self.jacobian) + 2 * self.active.size
        place, rate = np.split(x[:size], 2)
        return np.concatenate([change(place), change(rate), x[size:]])

    @cached_property
    def _at_rest(self) -> tuple[np.ndarray, Others | None]:
        """The jacobian with all forces of constraints fixed at their values at rest, and its other
        states."""
        unheld = self._jacobian_at_fixed_reactions()
        return unheld, _separate(unheld, self.active.size)

    def _jacobian_at_fixed_reactions(self) -> np.ndarray:
        if self.freedom.is_unconstrained:
            return self.jacobian
        if self.freedom.has_dependent_rows or not np.isfinite(self.reactions).all():
            raise InputError(
                "linear: the forces of rigid friction or joints are not defined, because they hold"
                " dependent directions, or directions that change with position. Use stick_slip"
                " with a stiffness there, or fewer points."
            )
        n = self.active.size
        unheld = self.jacobian.copy()
        unheld[n : 2 * n] -= linalg.solve(self.inertia, self.freedom.rows.T @ self.reactions)
        return unheld


class Eigensystem:
    """Spectrum of a component, computed once for all who ask, and for all equal components. A chain
    of 16 hulls has 2704 states: its eigenvalues take 7 s, with eigenvectors 14 s."""

    def __init__(self, linear: Linear) -> None:
        self._linear = linear
        large = len(linear.jacobian) > LARGE
        self._known = linear.eigenvectors() if large else None
        self.values = linear.eigenvalues() if self._known is None else self._known[0]
        """The eigenvalues (k,) [1/s]."""

    def vectors(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Eigenvalues, left and right eigenvectors, as `Linear.eigenvectors`."""
        return self._linear.eigenvectors() if self._known is None else self._known


def _of_others(s: np.ndarray, n: int, J: np.ndarray, others: Others | None) -> np.ndarray:
    """Accelerations (nw, n, n) by all other states per coordinate, ``s`` = i w (nw, 1, 1)."""
    if others is None:
        drive = J[2 * n :, :n] + s * J[2 * n :, n : 2 * n]
        inner = s * np.eye(len(J) - 2 * n) - J[2 * n :, 2 * n :]
        return np.asarray(J[n : 2 * n, 2 * n :] @ np.linalg.solve(inner, drive))
    transfer = (1.0 / (s[:, :, 0] - others.poles)) @ others.share.reshape(-1, n * n)
    return np.asarray(transfer.reshape(-1, n, n) + others.direct)


def _separate(J: np.ndarray, n: int) -> Others | None:
    """All states except motion, by diagonalising their part of J. None if its eigenvectors are too
    parallel for that (those of radiation are orthogonal, except for rounding)."""
    poles, vectors = np.linalg.eig(J[2 * n :, 2 * n :])
    if poles.size and np.linalg.cond(vectors) > SEPARATE:
        return None
    felt = J[n : 2 * n, 2 * n :] @ vectors
    driven = np.linalg.solve(vectors, J[2 * n :, : 2 * n])
    place, speed = (felt.T[:, :, None] * x[:, None, :] for x in (driven[:, :n], driven[:, n:]))
    share = place + poles[:, None, None] * speed
    return Others(poles.astype(complex), share + 0j, speed.sum(axis=0))


def linearise(
    model: Model,
    state: State,
    modes: np.ndarray | None = None,
    time: float = 0.0,
    step: float = STEP,
    states: np.ndarray | None = None,
) -> Linear:
    """Linearise about ``state`` with its contact modes, or with ``modes`` (nf + ns, 3), over the
    entries ``states`` (m,) of y; by default over all that act on others.

    ``step`` is the step of the differences: a linear function is differentiated to rounding with a
    step of 1. The memory of a radiation by convolution is left out: use the state-space model for
    it.
    """
    held = state.modes if modes is None else modes
    states = dynamic_states(model) if states is None else states
    at = state._replace(modes=held)
    J = differentiate(model, at, time, step, states)
    _use_rates(J, model, state.y)
    rows = find_constraint_rows(model, state.y, held)
    freedom = nullspace_of(rows, inertia(model, state.y))
    linear = Linear(J, states, model.bodies.active, freedom)
    if linear.freedom.is_unconstrained:
        return linear
    return replace(
        linear, reactions=differentiate_reactions(model, at, time, step, states, len(rows))
    )


def differentiate(
    model: Model, state: State, time: float, step: float, states: np.ndarray
) -> np.ndarray:
    """Derivatives (m, m) of the ``states`` (m,) of y' by those of y, by central differences.

    The memory of bodies that do not feel each other is shifted at once.
    """
    J = np.zeros((states.size, states.size))
    scratch = np.zeros((3, model.size))
    work = new_work(model)

    def fill(shifts: Shifts, offset: float) -> None:
        y, modes, history = state.y, state.modes, state.history
        fill_jacobian(time, y, modes, history, model, work, states, shifts, offset, scratch, J)

    def fill_curved(shifts: Shifts) -> None:
        fill(shifts, step)
        if model.bodies.tree.branches.size == 0:
            return
        near = J[:, shifts.columns]  # places of a tree are curved: removes the error of order two
        fill(shifts, 2.0 * step)
        J[:, shifts.columns] = (4.0 * near - J[:, shifts.columns]) / 3.0

    remembers = (states >= model.radiation) & (states < model.own)
    fill_curved(shift_each(np.flatnonzero(~remembers), states.size))
    if not remembers.any():
        return J
    part = _find_parts(model, state, states, J)
    driven = J.any(axis=1)
    fill_curved(shift_each(np.flatnonzero(remembers & ~driven), states.size))
    fill_curved(_shift_parts(np.flatnonzero(remembers & driven), part))
    return J


def _find_parts(model: Model, state: State, states: np.ndarray, J: np.ndarray) -> np.ndarray:
    """The part (m,) of every state. Parts do not feel each other, by the filled columns of their
    derivatives ``J`` (m, m), their inertia and their constraints."""
    n = model.bodies.active.size
    rows = find_constraint_rows(model, state.y, state.modes)
    coupled = (inertia(model, state.y) != 0.0) | (np.abs(rows.T) @ np.abs(rows) != 0.0)
    moves = np.flatnonzero(states < 2 * n)
    coordinate = states[moves] % n
    edges = J != 0.0
    edges[np.ix_(moves, moves)] |= coupled[np.ix_(coordinate, coordinate)]
    part = np.zeros(states.size, dtype=np.int64)
    for label, component in enumerate(find_components(edges)):
        part[component] = label
    return part


def _shift_parts(columns: np.ndarray, part: np.ndarray) -> Shifts:
    """Shift one of the ``columns`` of every ``part`` at once."""
    by_part = columns[np.argsort(part[columns], kind="stable")]
    _, begin, count = np.unique(part[by_part], return_index=True, return_counts=True)
    number = np.arange(by_part.size) - np.repeat(begin, count)
    order = np.argsort(number, kind="stable")
    return Shifts(by_part[order], number[order], part)


def _use_rates(J: np.ndarray, model: Model, y: np.ndarray) -> None:
    """Change the coordinates of the Jacobian ``J`` (m, m), in place, to integrals of the rates: a
    ball joint has q' = N u, with N at the present place."""
    bodies = model.bodies
    n = bodies.active.size
    if not (bodies.tree.moves["kind"] == BALL).any():
        return
    N = np.eye(n)
    for u, column in zip(np.eye(n), N, strict=True):
        fill_rates(y[:n], u, bodies, column)
    J[:, :n] = J[:, :n] @ N.T
    J[:n] = np.linalg.solve(N.T, J[:n])


def differentiate_reactions(
    model: Model, state: State, time: float, step: float, states: np.ndarray, count: int
) -> np.ndarray:
    """Derivatives (count, m) of the forces of all constraints by the ``states`` (m,) of y, by
    central differences; NaN if the ``count`` of constraints changes with position."""
    work = new_work(model)
    slope = np.empty(model.size)
    y = state.y.copy()
    constraints = work.constraints

    def forces_at(k: int, shift: float) -> np.ndarray:
        y[k] = state.y[k] + shift
        rhs(time, y, state.modes, state.history, model, work, slope)
        y[k] = state.y[k]
        alike = constraints.number[0] == count
        return constraints.force[:count].copy() if alike else np.full(count, np.nan)

    changes = [forces_at(k, step) - forces_at(k, -step) for k in states]
    return np.transpose(changes) / (2.0 * step)


ANGLES = range(3, 6)
INCLINING = range(3, 5)  # roll and pitch


def nonlinearities(scene: Scene, model: Model) -> Iterator[str]:
    """Reasons why a scene is not linear, or is not propagated."""
    if model.impulse < model.size:
        yield "output.impulses needs integrals over time steps"
    if model.convolution.row.size:
        yield "radiation by convolution"
    for b in model.following.body:
        yield f"waves follow {scene.bodies[b].name}"
    for b in model.tanks.rests["body"]:
        yield f"the contents of the tanks of {scene.bodies[b].name} change"
    for b in sorted({*model.liquids.each["body"].tolist()}):
        if any(i in _free_angles(b, model) for i in INCLINING):
            yield f"free surfaces in the tanks of {scene.bodies[b].name}"
    for b in model.hulls.body:
        yield f"buoyancy of the hull of {scene.bodies[b].name}"
    for key, signal in signals_of(scene.forces):
        if isinstance(signal, Recorded):
            yield f"{key} is a record"
    for branch in model.bodies.tree.branches if model.bodies.exact else ():
        if not _is_straight(branch, model):
            yield f"exact rotations of {scene.bodies[branch['child']].name} on its joint"
    for b, body in enumerate(scene.bodies):
        free = _free_angles(b, model)
        locked = [i for i in ANGLES if i not in free and body.position[i] != 0.0]
        turned = locked or body.heading != 0.0
        if model.bodies.exact and (len(free) > 1 or (free and turned)):
            yield f"exact rotations of {body.name}"
        elif b in model.headings.turning and (model.bodies.active.size > 1 or _stream(model)):
            yield f"hydrodynamics turn with {body.name}"
    yield from _elements(scene, model)
    for name in constraint_names(scene):
        if not scene.joints[name].lasts:
            yield f"{name} is not always closed"
        elif model.bodies.exact:
            yield f"exact rotations of the joint {name}"
    if not joints_are_linear(model):
        yield "stops or friction in joints"


def _is_straight(branch: np.void, model: Model) -> bool:
    """True for a joint to the earth that slides."""
    moves = model.bodies.tree.moves[branch["first"] : branch["last"]]
    return branch["parent"] == NO_BODY and bool(np.all(moves["kind"] == SLIDE))


def _stream(model: Model) -> bool:
    return bool(np.any(model.headings.current))


def _elements(scene: Scene, model: Model) -> Iterator[str]:
    """Reasons that elements give."""
    index = {body.name: b for b, body in enumerate(scene.bodies)}
    exact = model.bodies.exact
    for row, (name, element) in enumerate(scene.forces.items(), len(BODY_ROWS)):
        free = _free_angles(index[element.body], model)
        reason = element.nonlinearity(name, Turns(free, exact, model.elements, row))
        if element.active is not None:
            reason = f"{name} is not always active"
        if reason is not None:
            yield reason


def _free_angles(body: int, model: Model) -> list[int]:
    moving = moving_dofs(model.bodies)
    return [i for i in ANGLES if 6 * body + i in moving]
