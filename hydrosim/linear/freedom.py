"""Constraints of a scene in a state, and the motions that they leave.

Constraints are rows J of J q' = 0, with forces J^T lambda. They are asked for at one door, the one
that runs use: `hydrosim.stepping.dynamics.constrain`. With a basis N of all q' that they allow,
J N = 0, the motions are q = N p, and p obeys

    N^T M N p'' = N^T (dQ + d(J^T) lambda0) N p + ...

Q are all other loads. The second term is the geometric stiffness: reactions lambda0 that carry
load at rest turn with the bodies. It is in the derivative of the right hand side, which states J
anew at every place. With `kinematics: linear` J does not change, and there is no such term, in runs
neither. About a motion, not a rest, d(J) q' is left out: what is allowed is what is allowed there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from hydrosim.rigid.kinematics import place_bodies
from hydrosim.stepping.dynamics import Model, constrain, most_constraints, new_work

DEPENDENT = 1e-9  # of the largest: rows that are less apart hold one direction


@dataclass(frozen=True, eq=False)
class Freedom:
    """Motions (n,) that the ``rows`` J (m, n) of constraints allow, with the ``inertia`` (n, n).

    The columns of the ``basis`` N (n, n - rank) are orthonormal in coordinates that are scaled by
    the roots of their own inertias, so that metres and radians compare.
    Without constraints all methods give back what they are given.
    """

    rows: np.ndarray
    inertia: np.ndarray
    basis: np.ndarray

    @property
    def unconstrained(self) -> bool:
        """Whether there are no constraints."""
        return len(self.rows) == 0

    @property
    def has_dependent_rows(self) -> bool:
        """Whether some rows hold what others hold, so that the forces of each are not defined."""
        return not self.unconstrained and self.basis.shape[1] > self.rows.shape[1] - len(self.rows)

    def project_matrix(self, D: np.ndarray) -> np.ndarray:
        """N^T D N of ``D`` (..., n, n)."""
        return D if self.unconstrained else np.asarray(self.basis.T @ D @ self.basis)

    def project_loads(self, F: np.ndarray) -> np.ndarray:
        """N^T F of loads ``F`` (n, ...)."""
        return F if self.unconstrained else np.asarray(self.basis.T @ F)

    def expand(self, p: np.ndarray) -> np.ndarray:
        """N p of ``p`` (k, ...)."""
        return p if self.unconstrained else np.asarray(self.basis @ p)

    def project_motions(self, q: np.ndarray) -> np.ndarray:
        """The p whose N p is nearest to ``q`` (n, ...) by kinetic energy. Of accelerations that
        loads would give without constraints, it is those with them."""
        if self.unconstrained:
            return q
        return np.asarray(
            linalg.solve(self.project_matrix(self.inertia), self.project_loads(self.inertia @ q))
        )

    def expand_covectors(self, left: np.ndarray) -> np.ndarray:
        """The covectors (n, ...) whose product with N p is that of ``left`` (k, ...) with p."""
        if self.unconstrained:
            return left
        mass = self.project_matrix(self.inertia)
        return np.asarray(self.inertia @ self.expand(linalg.solve(mass, left)))

    def find_mobility(self) -> np.ndarray:
        """The accelerations (n, n) that unit loads give, N (N^T M N)^-1 N^T."""
        if self.unconstrained:
            return np.asarray(linalg.inv(self.inertia))
        return self.accelerate(np.eye(len(self.inertia)))

    def accelerate(self, F: np.ndarray) -> np.ndarray:
        """The accelerations (n, r) that loads ``F`` (n, r) give."""
        return self.expand(
            np.linalg.solve(self.project_matrix(self.inertia), self.project_loads(F))
        )

    def solve_motions(self, D: np.ndarray, F: np.ndarray) -> np.ndarray:
        """The motions q (..., n) with N^T D q = N^T F, for ``D`` (..., n, n) and ``F`` (..., n)."""
        if self.unconstrained:
            return np.asarray(np.linalg.solve(D, F[..., None])[..., 0])
        p = np.linalg.solve(self.project_matrix(D), (F @ self.basis)[..., None])[..., 0]
        return np.asarray(p @ self.basis.T)

    def solve_reactions(self, excess: np.ndarray) -> np.ndarray:
        """Forces lambda (..., m) of constraints that make up for loads ``excess`` (..., n) which
        motions need and nothing else gives: J^T lambda."""
        return np.asarray(excess @ np.linalg.pinv(self.rows, DEPENDENT))


def freedom_of(rows: np.ndarray, inertia: np.ndarray) -> Freedom:
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
    constrain(modes, model, work)
    return work.constraints.J[: work.constraints.number[0]].copy()
