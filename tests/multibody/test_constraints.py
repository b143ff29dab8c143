"""Constrained solutions against the saddle-point system of the same problem, solved by LAPACK."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from hydrosim.multibody.constraints import (
    eliminate,
    find_forces,
    new_constraints,
    restore_pivots,
    solve_for_pivots,
)
from hydrosim.multibody.mass import cholesky, cholesky_solve


@pytest.mark.parametrize(("rows", "n"), [(0, 3), (1, 1), (1, 6), (2, 6), (3, 6), (6, 6), (5, 12)])
def test_against_the_saddle_point_system(rows: int, n: int) -> None:
    rng = np.random.default_rng(10 * n + rows)
    A = rng.normal(size=(n, n))
    H, Q = A @ A.T + n * np.eye(n), rng.normal(size=n)
    J, bound = rng.normal(size=(rows, n)), rng.normal(size=rows)
    saddle = np.block([[H, -J.T], [J, np.zeros((rows, rows))]])
    wanted = np.linalg.solve(saddle, np.concatenate([Q, bound]))

    p = new_constraints(rows + 1, n)
    p.J[:rows], p.bound[:rows], p.number[0] = J, bound, rows
    x, inertia = Q.copy(), H.copy()
    solve_for_pivots(p)
    eliminate(p, inertia, x)
    cholesky(inertia)
    cholesky_solve(inertia, x)
    find_forces(p, x)
    restore_pivots(p, x)
    assert_allclose(x, wanted[:n], rtol=1e-10, atol=1e-12)
    assert_allclose(p.force[:rows], wanted[n:], rtol=1e-9, atol=1e-11)


def test_what_is_held_alone_is_held_exactly() -> None:
    p = new_constraints(2, 1)
    p.J[0], p.number[0] = 0.7, 1
    H, x = np.array([[3.7e8]]), np.array([1.234e5])
    solve_for_pivots(p)
    eliminate(p, H, x)
    cholesky(H)
    cholesky_solve(H, x)
    find_forces(p, x)
    restore_pivots(p, x)
    assert x[0] == 0.0
    assert p.force[0] == pytest.approx(-1.234e5 / 0.7, rel=1e-15)


def test_restore_changes_only_what_it_must() -> None:
    p = new_constraints(1, 3)
    p.J[0], p.number[0] = (0.5, 2.0, -1.0), 1
    x = np.array([1.0, 5.0, 3.0])
    solve_for_pivots(p)
    restore_pivots(p, x)
    assert_allclose(x, [1.0, 1.25, 3.0])
