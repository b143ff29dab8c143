"""Mass matrix, kinetic energy and the Cholesky factor against numpy and scipy."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import INERTIA, block, scene
from scipy import linalg
from scipy.spatial.transform import Rotation

import hydrosim as hs
from hydrosim.integrate.dynamics import new_work
from hydrosim.multibody.mass import cholesky, cholesky_solve, kinetic_energy, mass_matrix
from hydrosim.scene import Kinematics

RNG = np.random.default_rng(7)


def positive_definite(n: int) -> np.ndarray:
    root = RNG.normal(size=(n, n))
    return root @ root.T + 0.1 * np.eye(n)


@pytest.mark.parametrize("n", [1, 2, 6, 12])
def test_cholesky_equals_lapack(n):
    A, b = positive_definite(n), RNG.normal(size=n)
    L, x = A.copy(), b.copy()
    cholesky(L)
    cholesky_solve(L, x)
    np.fill_diagonal(L, 1.0 / np.diag(L))
    assert np.tril(L) == pytest.approx(linalg.cholesky(A, lower=True), abs=1e-12)
    assert x == pytest.approx(linalg.solve(A, b, assume_a="pos"), rel=1e-9)


def test_cholesky_of_a_matrix_without_mass_is_not_a_number():
    L = np.diag([1.0, -1.0])
    cholesky(L)
    assert np.isnan(L[1, 1])


@pytest.mark.parametrize("kinematics", Kinematics)
def test_mass_matrix_turns_the_inertia_with_the_body(kinematics):
    bodies = [block(2.0, name="a"), block(5.0, name="b")]
    model = hs.compile_scene(scene(bodies, {}, 1.0, 0.5, kinematics=kinematics)).model
    R = Rotation.random(2, rng=3).as_matrix()
    added, M = positive_definite(12), np.zeros((12, 12))
    work = new_work(model)
    motion = work.motion._replace(rotation=np.ascontiguousarray(R))
    mass_matrix(model.bodies, work.contents, model.headings, motion, added, M)
    turned = R if kinematics is Kinematics.EXACT else [np.eye(3)] * 2
    both = zip([2.0, 5.0], turned, strict=True)
    blocks = [x for m, r in both for x in (m * np.eye(3), m * r @ INERTIA @ r.T)]
    assert M - added == pytest.approx(linalg.block_diag(*blocks), abs=1e-12)


def test_kinetic_energy():
    M, v = positive_definite(6), RNG.normal(size=6)
    assert kinetic_energy(v, M) == pytest.approx(0.5 * v @ M @ v, rel=1e-13)
