"""Free coordinates of a scene: their velocities, their inertia, and difference steps.

Constraints of a scene in a state, and the motions that they leave.

Constraints are rows J of J q' = 0, with forces J^T lambda. They come from the function that runs
use: `hydrosim.stepping.dynamics.add_constraints`. With a basis N of all allowed q', J N = 0, the
motions are q = N p, and p obeys

    N^T M N p'' = N^T (dQ + d(J^T) lambda0) N p + ...

Q are all other loads. The second term is the geometric stiffness: reactions lambda0 that carry load
at rest turn with the bodies. The derivative of the right hand side includes it, because J is
evaluated at every position. With `kinematics: linear` J is constant, and neither the linearisation
nor runs have this term.

About a motion instead of a rest, the term with d(J) q' is left out, and N is that of the present
position.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from hydrosim.forces import in_gusts
from hydrosim.rigid.kinematics import acceleration_map, place_bodies
from hydrosim.stepping.blending import blend_draughts
from hydrosim.stepping.dynamics import (
    Model,
    add_constraints,
    find_mass,
    most_constraints,
    new_work,
    update_contents,
)
from hydrosim.streams.wind import NO_GUSTS
from hydrosim.waves.build import wave_loads_model
from hydrosim.waves.displaced_loads import following_model

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
    found = np.zeros((n, n))
    place_bodies(y[:n], y[n : 2 * n], model.bodies, work.motion)
    if model.family.body.size:
        blend_draughts(y[model.draught :], model.family, A, work.blend)
        A = work.blend.added_mass
    update_contents(y, model, work)
    find_mass(model, A, work)
    acceleration_map(model.bodies, work.motion, work.mass, found)
    return found


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
