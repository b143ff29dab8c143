"""Mass matrix, kinetic energy and the Cholesky factor against numpy and scipy."""

import numpy as np
import pytest
from scenes import INERTIA, block, scene
from scipy import linalg
from scipy.spatial.transform import Rotation

import hydrosim as hs
from hydrosim.dofs import DOFS
from hydrosim.integrate.dynamics import new_work
from hydrosim.multibody import mass
from hydrosim.multibody.kinematics import new_motion, place_bodies
from hydrosim.scene import Kinematics

RNG = np.random.default_rng(7)


def positive_definite(n: int) -> np.ndarray:
    root = RNG.normal(size=(n, n))
    return root @ root.T + 0.1 * np.eye(n)


@pytest.mark.parametrize("n", [1, 2, 6, 12])
def test_cholesky_equals_lapack(n):
    A, b = positive_definite(n), RNG.normal(size=n)
    L, x = A.copy(), b.copy()
    mass.cholesky(L)
    mass.cholesky_solve(L, x)
    np.fill_diagonal(L, 1.0 / np.diag(L))
    assert np.tril(L) == pytest.approx(linalg.cholesky(A, lower=True), abs=1e-12)
    assert x == pytest.approx(linalg.solve(A, b, assume_a="pos"), rel=1e-9)


def test_cholesky_of_a_matrix_without_mass_is_not_a_number():
    L = np.diag([1.0, -1.0])
    mass.cholesky(L)
    assert np.isnan(L[1, 1])


@pytest.mark.parametrize("kinematics", Kinematics)
def test_mass_matrix_turns_the_inertia_with_the_body(kinematics):
    bodies = [block(2.0, name="a"), block(5.0, name="b")]
    model = hs.compile_scene(scene(bodies, {}, 1.0, 0.5, kinematics=kinematics)).model
    R = Rotation.random(2, rng=3).as_matrix()
    added, M = positive_definite(12), np.zeros((12, 12))
    work = new_work(model)
    motion = work.motion._replace(rotation=np.ascontiguousarray(R))
    mass.mass_matrix(model.bodies, work.contents, model.headings, motion, added, M)
    turned = R if kinematics is Kinematics.EXACT else [np.eye(3)] * 2
    both = zip([2.0, 5.0], turned, strict=True)
    blocks = [x for m, r in both for x in (m * np.eye(3), m * r @ INERTIA @ r.T)]
    assert M - added == pytest.approx(linalg.block_diag(*blocks), abs=1e-12)


def test_kinetic_energy():
    M, v = positive_definite(6), RNG.normal(size=6)
    assert mass.kinetic_energy(v, M) == pytest.approx(0.5 * v @ M @ v, rel=1e-13)


# Accelerations in two steps against numpy's solution of S^T M S q'' = S^T (F - M S' q').

GENERATOR = np.random.default_rng(11)
MASSES = (2.0, 5.0)
FREE = {
    "all": (DOFS, DOFS),
    "in the plane": (("surge", "heave", "pitch"), ("surge", "heave", "pitch")),
    "some": (("heave", "yaw", "roll"), ("surge",)),
    "no angles": (("surge", "heave"), ("sway",)),
    "angles alone": (("pitch", "yaw"), ("roll",)),
}


def by_numpy(model, motion, added, F):
    """q'' of the free coordinates, from the whole matrix."""
    S = linalg.block_diag(*(x for E in motion.rate_map for x in (np.eye(3), E)))
    turned = motion.rotation if model.bodies.exact else [np.eye(3)] * 2
    both = zip(MASSES, turned, strict=True)
    blocks = (x for m, R in both for x in (m * np.eye(3), m * R @ INERTIA @ R.T))
    M, S = added + linalg.block_diag(*blocks), S[:, model.bodies.active]
    return np.linalg.solve(S.T @ M @ S, S.T @ (F - M @ motion.bias))


@pytest.mark.parametrize("free", FREE.values(), ids=FREE)
@pytest.mark.parametrize("kinematics", Kinematics)
@pytest.mark.parametrize("coupled", [True, False])
def test_accelerations_are_those_of_the_whole_matrix(free, kinematics, coupled):
    bodies = [block(m, dofs, name) for m, dofs, name in zip(MASSES, free, "ab", strict=True)]
    model = hs.compile_scene(scene(bodies, {}, 1.0, 0.5, kinematics=kinematics)).model
    root = GENERATOR.normal(size=(12, 12))
    added, F, n = root @ root.T, GENERATOR.normal(size=12), model.bodies.active.size
    if not coupled:
        added[:6, 6:] = added[6:, :6] = 0.0
    motion, x = new_motion(model.bodies), np.full(n, np.nan)
    place_bodies(GENERATOR.normal(size=n), GENERATOR.normal(size=n), model.bodies, motion)
    inertia = mass.constant_inertia(model.bodies, added)
    assert inertia.alone == (not coupled and n == 12)
    mass.accelerate_freely(inertia, model.bodies, motion, F, mass.new_turning(inertia), x)
    assert x == pytest.approx(by_numpy(model, motion, added, F), rel=1e-9, abs=1e-10)


def test_a_body_without_mass_has_no_acceleration():
    bodies = [block(m, name=name) for m, name in zip(MASSES, "ab", strict=True)]
    model = hs.compile_scene(scene(bodies, {}, 1.0, 0.5)).model
    assert np.isnan(mass.constant_inertia(model.bodies, -10.0 * np.eye(12)).inverse).all()
