"""Mass: contents of bodies, matrix in the earth frame, kinetic energy, accelerations from forces.

Accelerations from forces without constraints: (M + A) v' = F in two small steps.

Turning changes only the inertia of a body about its axes, I(R) = R I R^T. Everything else is
constant during the run. With t for translations and r for rotations, M_tt and M_tr come from mass
and added mass:

    y = M_tt^-1 F_t                       translations, if no body were to turn faster
    W = I(R) + D,    D = A_rr - M_rt M_tt^-1 M_tr
    E^T W E a'' = E^T (F_r - M_rt y - W b)
    v_t' = y - G (E a'' + b),    G = M_tt^-1 M_tr

(the Schur complement of M_tt). a: angles, omega' = E a'' + b, see `kinematics`. With small angles
rotations have constant inertia like translations: all coordinates are t, and y is the answer.
Locked coordinates have no rows here. If rigid friction holds points, the whole of S^T (M + A) S is
factored instead (`mass_matrix`).
"""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.jit.kernels import assign, kernel
from hydrosim.multibody.heading import turn_matrix
from hydrosim.multibody.vectors import add, cross, dot, matvec, product, sub, vector

if TYPE_CHECKING:
    from hydrosim.multibody.kinematics import Bodies

# Contents of bodies at a time: mass and moments; fluids move rigidly, but surfaces may be level.


class Contents(NamedTuple):
    """Mass properties of all bodies with their contents.

    Weight: ``mass`` m (nb,) [kg] and ``moment`` m c (nb, 3) [kg m], c from the body's origin to the
    centre of gravity in the body frame with all surfaces level in the body. ``shift`` (nb, 3) [kg
    m] is added by surfaces that are level in the earth, each at a ``height`` (nl,) [m] above the
    body's origin (`hydrosim.tanks.surface`). ``surface`` (nb, 3) [kg m^2] is density times the
    second moments xx, xy, yy of all other free surfaces about their own centroids.

    Inertia: ``moving_mass`` (nb,), ``moving_moment`` (nb, 3) and ``inertia`` (nb, 3, 3) about the
    origin.
    """

    mass: np.ndarray
    moment: np.ndarray
    shift: np.ndarray
    height: np.ndarray
    surface: np.ndarray
    moving_mass: np.ndarray
    moving_moment: np.ndarray
    inertia: np.ndarray


def new_contents(bodies: Bodies, surfaces: int) -> Contents:
    """Contents of the bodies at the start, with this number of level ``surfaces``."""
    body_rows = bodies.each
    nothing = np.zeros((body_rows.size, 3))
    return Contents(
        mass=body_rows["mass"].copy(),
        moment=nothing,
        shift=nothing.copy(),
        height=np.zeros(surfaces),
        surface=body_rows["surface"].copy(),
        moving_mass=body_rows["mass"].copy(),
        moving_moment=nothing.copy(),
        inertia=body_rows["inertia"].copy(),
    )


@kernel
def mass_matrix(bodies, contents, headings, motion, added_mass, M):
    """Fill M (6 nb, 6 nb) about the bodies' origins: mass m, m [c x] and inertia R I R^T of every
    body, plus ``added_mass`` of their heading axes."""
    for i in range(M.shape[0]):
        assign(M[i], added_mass[i])
    turn_matrix(headings, motion, M)
    for b in range(bodies.each.size):
        R, moment = motion.rotation[b], vector(contents.moving_moment[b], 0)
        for i in range(3):
            M[6 * b + i, 6 * b + i] += contents.moving_mass[b]
            add_earth_inertia(6 * b + 3, i, contents.inertia[b], R, bodies.exact, M)
        if moment[0] != 0.0 or moment[1] != 0.0 or moment[2] != 0.0:
            _add_moment(6 * b, matvec(R, moment) if bodies.exact else moment, M)


@kernel
def _add_moment(k, moment, M):
    """Add m [c x] to ``M``, which couples rotations and translations."""
    for i in range(3):
        j, h = (i + 1) % 3, (i + 2) % 3
        M[k + i, k + 3 + j] += moment[h]
        M[k + i, k + 3 + h] -= moment[j]
        M[k + 3 + j, k + i] += moment[h]
        M[k + 3 + h, k + i] -= moment[j]


@kernel
def add_earth_inertia(k, j, inertia, R, exact, M):
    """Add column j of R I R^T to ``M`` from (k, k) on; of I itself in linear kinematics."""
    if exact:
        column = matvec(R, matvec(inertia, (R[j, 0], R[j, 1], R[j, 2])))
    else:
        column = (inertia[0, j], inertia[1, j], inertia[2, j])
    for i in range(3):
        M[k + i, k + j] += column[i]


@kernel
def kinetic_energy(v, M):
    """v^T M v / 2."""
    energy = 0.0
    for i in range(v.size):
        for j in range(v.size):
            energy += 0.5 * v[i] * M[i, j] * v[j]
    return energy


@kernel
def cholesky(H):
    """Lower Cholesky factor of ``H`` in place, with 1 / L_jj on the diagonal; NaN where H is not
    positive definite."""
    for i in range(H.shape[0]):
        for j in range(i):
            entry = H[i, j]
            for k in range(j):
                entry -= H[i, k] * H[j, k]
            H[i, j] = entry * H[j, j]
        square = H[i, i]
        for k in range(i):
            square -= H[i, k] * H[i, k]
        H[i, i] = 1.0 / sqrt(square)


@kernel
def cholesky_solve(L, x):
    """Solve L L^T x = x in place, for the factor of `cholesky`."""
    n = x.size
    for i in range(n):
        entry = x[i]
        for k in range(i):
            entry -= L[i, k] * x[k]
        x[i] = entry * L[i, i]
    for i in range(n - 1, -1, -1):
        entry = x[i]
        for k in range(i + 1, n):
            entry -= L[k, i] * x[k]
        x[i] = entry * L[i, i]


class Inertia(NamedTuple):
    """Constants for nt ``steady`` and na ``turning`` coordinates.

    ``steady`` (nt,) and ``turning`` (na,) are indices among the free coordinates. ``force`` (nt,)
    gives the steady ones among all six of each body. ``body`` (na,) and ``angle`` (na,) identify
    the turning ones. Matrices: M_tt^-1 ``inverse`` (nt, nt), M_rt ``coupling`` (3 nb, nt), G
    ``gain`` (nt, 3 nb), D ``rest`` (3 nb, 3 nb). ``alone`` is true for a body that is free and has
    no added mass in common with another, ``uncoupled`` if no two bodies have any in common.
    """

    steady: np.ndarray
    turning: np.ndarray
    force: np.ndarray
    body: np.ndarray
    angle: np.ndarray
    inverse: np.ndarray
    coupling: np.ndarray
    gain: np.ndarray
    rest: np.ndarray
    alone: bool
    uncoupled: bool


class Turning(NamedTuple):
    """Scratch: W (3 nb, 3 nb), E^T W E (na, na), moments or omega' (3 nb,), a'' (na,)."""

    W: np.ndarray
    schur: np.ndarray
    moment: np.ndarray
    angles: np.ndarray


def constant_inertia(bodies: Bodies, added_mass: np.ndarray) -> Inertia:
    """Constant part of the inertia with ``added_mass`` (6 nb, 6 nb), at zero angles.

    Entries are NaN where it is singular: the run reports a body without mass.
    """
    M = added_mass.copy()
    for b, body in enumerate(bodies.each):
        M[6 * b : 6 * b + 3, 6 * b : 6 * b + 3] += body["mass"] * np.eye(3)
        if not bodies.exact:
            M[6 * b + 3 : 6 * b + 6, 6 * b + 3 : 6 * b + 6] += body["inertia"]
    own_dofs = bodies.active[: bodies.active.size - bodies.tree.coordinates]  # joints do without it
    turns = (own_dofs % 6 >= 3) & bodies.exact
    t, r = own_dofs[~turns], np.arange(6 * bodies.each.size).reshape(-1, 6)[:, 3:].ravel()
    try:
        root = np.linalg.inv(np.linalg.cholesky(M[np.ix_(t, t)]))
        inverse = root.T @ root
    except np.linalg.LinAlgError:
        inverse = np.full((t.size, t.size), np.nan)
    coupling = np.ascontiguousarray(M[np.ix_(r, t)])
    gain = inverse @ coupling.T
    return Inertia(
        *(np.flatnonzero(~turns), np.flatnonzero(turns), t),
        *(own_dofs[turns] // 6, own_dofs[turns] % 6 - 3),
        *(inverse, coupling, gain, added_mass[np.ix_(r, r)] - coupling @ gain),
        alone=len(M) == bodies.active.size and not _couples_bodies(added_mass),
        uncoupled=not _couples_bodies(added_mass),
    )


def _couples_bodies(added_mass: np.ndarray) -> bool:
    """True if added mass couples two bodies."""
    body = np.arange(len(added_mass)) // 6
    return bool(added_mass[body[:, None] != body].any())


def new_turning(inertia: Inertia) -> Turning:
    """Scratch for this inertia."""
    rotations, na = inertia.rest.shape[0], inertia.turning.size
    return Turning(
        np.zeros((rotations, rotations)), np.zeros((na, na)), np.zeros(rotations), np.zeros(na)
    )


@kernel
def accelerate_freely(p, bodies, motion, F, room, x):
    """Accelerations ``x`` (n,) of the free coordinates under the wrenches ``F`` (6 nb,), from which
    gyroscopic moments have been subtracted."""
    if p.alone:
        for b in range(bodies.each.size):
            if bodies.exact:
                _accelerate_alone(b, p, bodies.each[b].inertia, motion, F, x)
            else:
                k = 6 * b
                v = product(p.inverse[k : k + 6, k : k + 6], F, k)
                x[k], x[k + 1], x[k + 2], x[k + 3], x[k + 4], x[k + 5] = v
        return
    for i in range(p.steady.size):
        y = 0.0
        for j in range(p.steady.size):
            y += p.inverse[i, j] * F[p.force[j]]
        x[p.steady[i]] = y
    if p.turning.size > 0:
        _fill_rotary_inertia(p, bodies, motion, room.W)
        _find_moments(p, motion, F, room, x)
        _solve_turning(p, motion, room, x)


@kernel
def _accelerate_alone(b, p, inertia, motion, F, x):
    """`accelerate_freely` for a free body without coupling. W omega' = F_r - M_rt y is solved by
    Cramer's rule, then a'' = E^-1 (omega' - b). Written out, because loops this short take six
    times longer."""
    k, f = 3 * b, 6 * b
    R, E = motion.rotation[b], motion.rate_map[b]
    x_, y_, z_ = vector(R[0], 0), vector(R[1], 0), vector(R[2], 0)
    t = matvec(inertia, x_), matvec(inertia, y_), matvec(inertia, z_)
    W = (
        add(vector(p.rest[k], k), (dot(x_, t[0]), dot(x_, t[1]), dot(x_, t[2]))),
        add(vector(p.rest[k + 1], k), (dot(y_, t[0]), dot(y_, t[1]), dot(y_, t[2]))),
        add(vector(p.rest[k + 2], k), (dot(z_, t[0]), dot(z_, t[1]), dot(z_, t[2]))),
    )
    y = _multiply_block(p.inverse, k, vector(F, f))
    omega = _solve_rotary(W, sub(vector(F, f + 3), _multiply_block(p.coupling, k, y)))
    v = sub(y, _multiply_block(p.gain, k, omega))
    d = sub(omega, vector(motion.bias, f + 3))
    cp, sp = E[1, 1], -E[0, 1]
    roll = (cp * d[0] + sp * d[1]) / (cp * E[0, 0] + sp * E[1, 0])
    x[f], x[f + 1], x[f + 2] = v
    x[f + 3], x[f + 4], x[f + 5] = roll, cp * d[1] - sp * d[0], d[2] - E[2, 0] * roll


@kernel
def _multiply_block(A, k, a):
    """Product of the (3, 3) block on the diagonal of ``A`` from k on and a vector."""
    return (dot(vector(A[k], k), a), dot(vector(A[k + 1], k), a), dot(vector(A[k + 2], k), a))


@kernel
def _solve_rotary(W, m):
    """Solve W x = m for a symmetric W, given by rows."""
    first, second, third = cross(W[1], W[2]), cross(W[2], W[0]), cross(W[0], W[1])
    scale = 1.0 / dot(W[0], first)
    return (scale * dot(first, m), scale * dot(second, m), scale * dot(third, m))


@kernel
def _fill_rotary_inertia(p, bodies, motion, W):
    """W = I(R) + D."""
    for i in range(W.shape[0]):
        assign(W[i], p.rest[i])
    for b in range(bodies.each.size):
        for j in range(3):
            add_earth_inertia(3 * b, j, bodies.each[b].inertia, motion.rotation[b], True, W)


@kernel
def _find_moments(p, motion, F, room, y):
    """F_r - M_rt y - W b."""
    for i in range(room.moment.size):
        moment = F[_velocity_index_of_rotation(i)]
        for j in range(p.steady.size):
            moment -= p.coupling[i, j] * y[p.steady[j]]
        for j in range(room.moment.size):
            moment -= room.W[i, j] * motion.bias[_velocity_index_of_rotation(j)]
        room.moment[i] = moment


@kernel
def _solve_turning(p, motion, room, x):
    """Accelerations of the angles from the moments, and the resulting change of the
    translations."""
    for i in range(p.turning.size):
        room.angles[i] = dot(_rotation_axis(i, p, motion), vector(room.moment, 3 * p.body[i]))
    for i in range(p.turning.size):
        _multiply_axis(room.W, 3 * p.body[i], _rotation_axis(i, p, motion), room.moment)
        for j in range(i, p.turning.size):
            room.schur[j, i] = dot(_rotation_axis(j, p, motion), vector(room.moment, 3 * p.body[j]))
    cholesky(room.schur)
    cholesky_solve(room.schur, room.angles)

    for i in range(room.moment.size):  # omega' from here on
        room.moment[i] = motion.bias[_velocity_index_of_rotation(i)]
    for i in range(p.turning.size):
        x[p.turning[i]] = room.angles[i]
        axis = _rotation_axis(i, p, motion)
        for j in range(3):
            room.moment[3 * p.body[i] + j] += axis[j] * room.angles[i]
    for i in range(p.steady.size):
        change = 0.0
        for j in range(room.moment.size):
            change += p.gain[i, j] * room.moment[j]
        x[p.steady[i]] -= change


@kernel
def _rotation_axis(i, p, motion):
    """Axis of a turning coordinate: its column of E."""
    E, j = motion.rate_map[p.body[i]], p.angle[i]
    return (E[0, j], E[1, j], E[2, j])


@kernel
def _multiply_axis(W, k, axis, out):
    """``out`` = W times the ``axis`` of the body whose rotations begin at k."""
    for i in range(out.size):
        out[i] = dot(vector(W[i], k), axis)


@kernel
def _velocity_index_of_rotation(i):
    """Index of rotation i among the velocities of all bodies."""
    return i + 3 * (i // 3) + 3


# A linear spring on a body's coordinates: force -K q, potential q^T K q / 2.


@kernel
def spring_force(k, q, K):
    """-K q (6,) as a tuple, for the six coordinates from index ``k``."""
    f = product(K, q, k)
    return (-f[0], -f[1], -f[2], -f[3], -f[4], -f[5])


@kernel
def spring_energy(k, q, K):
    """q^T K q / 2 of the six coordinates from index ``k``."""
    energy = 0.0
    for i in range(6):
        for j in range(6):
            energy += 0.5 * q[k + i] * K[i, j] * q[k + j]
    return energy
