"""Rotations, their rates and wrenches, against scipy's rotations and finite differences."""

from math import hypot

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scenes import block, scene
from scipy.spatial.transform import Rotation

import hydrosim as hs
from hydrosim.multibody import constraints, kinematics
from hydrosim.multibody.mass import cholesky, cholesky_solve
from hydrosim.scene import Kinematics

BODIES: kinematics.Bodies = hs.compile_scene(scene(block(2.0), {}, 1.0, 0.5)).model.bodies
LINEAR = scene(block(2.0), {}, 1.0, 0.5, kinematics=Kinematics.LINEAR)
SMALL: kinematics.Bodies = hs.compile_scene(LINEAR).model.bodies
EPS = 1e-5  # of central differences: their error is about EPS^2 here
TOLERANCE = 1e-8


def numbers(count: int, size: float):
    return st.lists(st.floats(-size, size), min_size=count, max_size=count).map(np.array)


PARTS = (numbers(3, 10.0), numbers(1, 3.1), numbers(1, 1.4), numbers(1, 3.1))
COORDINATES = st.tuples(*PARTS).map(np.concatenate)
RATES, VECTOR = numbers(6, 2.0), numbers(3, 5.0)
examples = settings(max_examples=60, deadline=None, derandomize=True)


def placed(
    q: np.ndarray, u: np.ndarray | None = None, bodies: kinematics.Bodies = BODIES
) -> kinematics.Motion:
    motion = kinematics.new_motion(bodies)
    kinematics.place_bodies(q, np.zeros(6) if u is None else u, bodies, motion)
    return motion


def rotation(q: np.ndarray) -> np.ndarray:
    return placed(q).rotation[0]


@examples
@given(COORDINATES)
def test_rotation_is_yaw_then_pitch_then_roll_about_turned_axes(q):
    roll, pitch, yaw = q[3:]
    R = rotation(q)
    assert R == pytest.approx(Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix(), abs=1e-14)
    assert R @ R.T == pytest.approx(np.eye(3), abs=1e-14)
    assert np.linalg.det(R) == pytest.approx(1.0, abs=1e-14)


@examples
@given(COORDINATES, RATES)
def test_angular_velocity_is_the_rate_of_the_rotation(q, u):
    omega = placed(q, u).velocity[3:]
    dR = (rotation(q + EPS * u) - rotation(q - EPS * u)) / (2 * EPS)
    W = dR @ rotation(q).T
    assert W == pytest.approx(np.cross(omega, np.eye(3)).T, abs=TOLERANCE * (1 + np.abs(u).max()))


@examples
@given(COORDINATES, RATES)
def test_bias_is_the_angular_acceleration_at_constant_rates(q, u):
    ahead, behind = placed(q + EPS * u, u).velocity, placed(q - EPS * u, u).velocity
    bias = (ahead - behind) / (2 * EPS)
    assert placed(q, u).bias == pytest.approx(bias, abs=TOLERANCE * (1 + u @ u))


@examples
@given(COORDINATES, RATES, VECTOR)
def test_points_move_with_the_velocity_that_is_said(q, u, r):
    def place(q):
        return np.array(kinematics.attachment(0, tuple(r), BODIES, placed(q))[0])

    motion = placed(q, u)
    _, arm = kinematics.attachment(0, tuple(r), BODIES, motion)
    velocity = (place(q + EPS * u) - place(q - EPS * u)) / (2 * EPS)
    assert arm == pytest.approx(rotation(q) @ r, abs=1e-13)
    assert kinematics.point_velocity(0, arm, motion) == pytest.approx(velocity, abs=1e-7)


@examples
@given(COORDINATES, RATES, RATES)
def test_wrench_of_coordinates_has_their_power(q, u, Q):
    motion, wrench = placed(q, u), np.zeros(6)
    kinematics.wrench_of_coordinates(0, tuple(Q), BODIES, motion, wrench)
    assert wrench[3:] == pytest.approx(np.linalg.solve(motion.rate_map[0].T, Q[3:]), abs=1e-12)
    assert wrench @ motion.velocity == pytest.approx(Q @ u, abs=1e-12)


@examples
@given(COORDINATES, RATES, RATES)
def test_generalised_force_is_the_inverse(q, u, Q):
    motion, wrench, back = placed(q, u), np.zeros(6), np.zeros(6)
    kinematics.wrench_of_coordinates(0, tuple(Q), BODIES, motion, wrench)
    kinematics.generalised_force(BODIES, motion, wrench, back)
    assert back == pytest.approx(Q, abs=1e-12)


@examples
@given(COORDINATES)
def test_acceleration_map_keeps_the_kinetic_energy(q):
    rng = np.random.default_rng(1)
    root, u = rng.normal(size=(6, 6)), rng.normal(size=6)
    M, H, motion = root @ root.T, np.zeros((6, 6)), placed(q, u)
    kinematics.acceleration_map(BODIES, motion, M.copy(), H)
    assert H == pytest.approx(H.T, abs=1e-13)
    assert u @ H @ u == pytest.approx(motion.velocity @ M @ motion.velocity, rel=1e-12)


@examples
@given(COORDINATES, RATES, VECTOR)
def test_small_angles_are_the_first_order_of_the_exact_kinematics(q, u, r):
    """Halving the coordinates must divide the difference by four."""

    def difference(scale: float) -> np.ndarray:
        places, speeds = [], []
        for bodies in (BODIES, SMALL):
            motion = placed(scale * q, scale * u, bodies)
            place, arm = kinematics.attachment(0, tuple(r), bodies, motion)
            places.append(np.array(place))
            speeds.append(np.array(kinematics.point_velocity(0, arm, motion)))
        return np.concatenate([places[0] - places[1], speeds[0] - speeds[1]]) / scale**2

    # what is left after a division by scale^2 is of order scale: the third order of sin and cos
    bound = 40.0 * hypot(*r) * (1 + np.linalg.norm(q[3:])) ** 3 * (1 + np.linalg.norm(u))
    assert np.abs(difference(1e-3) - difference(5e-4)).max() <= 1e-3 * bound + 1e-7
    assert np.abs(difference(1e-3)).max() <= bound


# Constrained solutions against the saddle-point system of the same problem, solved by LAPACK.


@pytest.mark.parametrize(("rows", "n"), [(0, 3), (1, 1), (1, 6), (2, 6), (3, 6), (6, 6), (5, 12)])
def test_against_the_saddle_point_system(rows: int, n: int) -> None:
    rng = np.random.default_rng(10 * n + rows)
    A = rng.normal(size=(n, n))
    H, Q = A @ A.T + n * np.eye(n), rng.normal(size=n)
    J, bound = rng.normal(size=(rows, n)), rng.normal(size=rows)
    saddle = np.block([[H, -J.T], [J, np.zeros((rows, rows))]])
    wanted = np.linalg.solve(saddle, np.concatenate([Q, bound]))

    p = constraints.new_constraints(rows + 1, n)
    p.J[:rows], p.bound[:rows], p.number[0] = J, bound, rows
    x, inertia = Q.copy(), H.copy()
    constraints.solve_for_pivots(p)
    constraints.eliminate(p, inertia, x)
    cholesky(inertia)
    cholesky_solve(inertia, x)
    constraints.find_forces(p, x)
    constraints.restore_pivots(p, x)
    assert_allclose(x, wanted[:n], rtol=1e-10, atol=1e-12)
    assert_allclose(p.force[:rows], wanted[n:], rtol=1e-9, atol=1e-11)


def test_what_is_held_alone_is_held_exactly() -> None:
    p = constraints.new_constraints(2, 1)
    p.J[0], p.number[0] = 0.7, 1
    H, x = np.array([[3.7e8]]), np.array([1.234e5])
    constraints.solve_for_pivots(p)
    constraints.eliminate(p, H, x)
    cholesky(H)
    cholesky_solve(H, x)
    constraints.find_forces(p, x)
    constraints.restore_pivots(p, x)
    assert x[0] == 0.0
    assert p.force[0] == pytest.approx(-1.234e5 / 0.7, rel=1e-15)


def test_restore_changes_only_what_it_must() -> None:
    p = constraints.new_constraints(1, 3)
    p.J[0], p.number[0] = (0.5, 2.0, -1.0), 1
    x = np.array([1.0, 5.0, 3.0])
    constraints.solve_for_pivots(p)
    constraints.restore_pivots(p, x)
    assert_allclose(x, [1.0, 1.25, 3.0])
