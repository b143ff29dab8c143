"""Accelerations from forces, where nothing is held: (M + A) v' = F in two small steps.

Turning changes the inertia of a body about its axes alone, I(R) = R I R^T. All else is known before
the run: with t for translations and r for rotations, M_tt and M_tr come from mass and added mass,

    y = M_tt^-1 F_t                       translations, if no body were to turn faster
    W = I(R) + D,    D = A_rr - M_rt M_tt^-1 M_tr
    E^T W E a'' = E^T (F_r - M_rt y - W b)
    v_t' = y - G (E a'' + b),    G = M_tt^-1 M_tr

(the Schur complement of M_tt). a: angles, omega' = E a'' + b, see `kinematics`. With small angles
the rotations are as steady as the translations: all coordinates are t, and y is the answer. Locked
coordinates have no rows in these. Where rigid friction holds points the whole of S^T (M + A) S is
factored instead (`mass`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.kernels import assign, kernel
from hydrosim.rigid.kinematics import Bodies
from hydrosim.rigid.mass import add_earth_inertia, cholesky, cholesky_solve
from hydrosim.rigid.vectors import dot, vector


class Inertia(NamedTuple):
    """Constants for nt ``steady`` and na ``turning`` coordinates: where they stand among the free
    ones (nt,), (na,), and among all six of each body, ``force`` (nt,) and ``angle`` (na,); M_tt^-1
    ``inverse`` (nt, nt), M_rt ``coupling`` (3 nb, nt), G ``gain`` (nt, 3 nb), D ``rest``
    (3 nb, 3 nb)."""

    steady: np.ndarray
    turning: np.ndarray
    force: np.ndarray
    angle: np.ndarray
    inverse: np.ndarray
    coupling: np.ndarray
    gain: np.ndarray
    rest: np.ndarray


class Turning(NamedTuple):
    """Scratch: W (3 nb, 3 nb), E^T W E (na, na), moments or omega' (3 nb,), a'' (na,)."""

    W: np.ndarray
    schur: np.ndarray
    moment: np.ndarray
    angles: np.ndarray


def constant_inertia(bodies: Bodies, added_mass: np.ndarray) -> Inertia:
    """What of the inertia with ``added_mass`` (6 nb, 6 nb) does not change, all angles being zero.

    Not a number where it is singular: a body without mass is found out when it is run.
    """
    M = added_mass.copy()
    for b, body in enumerate(bodies.each):
        M[6 * b : 6 * b + 3, 6 * b : 6 * b + 3] += body["mass"] * np.eye(3)
        if not bodies.exact:
            M[6 * b + 3 : 6 * b + 6, 6 * b + 3 : 6 * b + 6] += body["inertia"]
    turns = (bodies.active % 6 >= 3) & bodies.exact
    t, r = bodies.active[~turns], np.arange(6 * bodies.each.size).reshape(-1, 6)[:, 3:].ravel()
    try:
        root = np.linalg.inv(np.linalg.cholesky(M[np.ix_(t, t)]))
        inverse = root.T @ root
    except np.linalg.LinAlgError:
        inverse = np.full((t.size, t.size), np.nan)
    coupling = np.ascontiguousarray(M[np.ix_(r, t)])
    gain = inverse @ coupling.T
    return Inertia(
        *(np.flatnonzero(~turns), np.flatnonzero(turns), t, bodies.active[turns]),
        *(inverse, coupling, gain, added_mass[np.ix_(r, r)] - coupling @ gain),
    )


def new_turning(inertia: Inertia) -> Turning:
    """Scratch for this inertia."""
    rotations, na = inertia.rest.shape[0], inertia.turning.size
    return Turning(
        np.zeros((rotations, rotations)), np.zeros((na, na)), np.zeros(rotations), np.zeros(na)
    )


@kernel
def accelerate_freely(p, bodies, motion, F, room, x):
    """Accelerations ``x`` (n,) of the free coordinates under the wrenches ``F`` (6 nb,), from which
    gyroscopic moments have been taken."""
    for i in range(p.steady.size):
        y = 0.0
        for j in range(p.steady.size):
            y += p.inverse[i, j] * F[p.force[j]]
        x[p.steady[i]] = y
    if p.turning.size > 0:
        _fill_rotary_inertia(p, bodies, motion, room.W)
        _find_moments(p, motion, F, room, x)
        _turn(p, motion, room, x)


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
        moment = F[_rotation(i)]
        for j in range(p.steady.size):
            moment -= p.coupling[i, j] * y[p.steady[j]]
        for j in range(room.moment.size):
            moment -= room.W[i, j] * motion.bias[_rotation(j)]
        room.moment[i] = moment


@kernel
def _turn(p, motion, room, x):
    """Accelerations of the angles from the moments, and what they change of the translations."""
    for i in range(p.angle.size):
        k, axis = _axis(p.angle[i], motion)
        room.angles[i] = dot(axis, vector(room.moment, k))
        for j in range(i + 1):
            room.schur[i, j] = _between(k, axis, p.angle[j], motion, room.W)
    cholesky(room.schur)
    cholesky_solve(room.schur, room.angles)

    for i in range(room.moment.size):  # from here on omega'
        room.moment[i] = motion.bias[_rotation(i)]
    for i in range(p.angle.size):
        k, axis = _axis(p.angle[i], motion)
        x[p.turning[i]] = room.angles[i]
        for j in range(3):
            room.moment[k + j] += axis[j] * room.angles[i]
    for i in range(p.steady.size):
        for j in range(room.moment.size):
            x[p.steady[i]] -= p.gain[i, j] * room.moment[j]


@kernel
def _between(k, axis, other, motion, W):
    """Entry of E^T W E for an ``axis`` of the body with the rotations from k, and another angle."""
    m, turned = _axis(other, motion)
    moment = (
        dot(vector(W[k], m), turned),
        dot(vector(W[k + 1], m), turned),
        dot(vector(W[k + 2], m), turned),
    )
    return dot(axis, moment)


@kernel
def _axis(angle, motion):
    """Where among all rotations those of its body begin, and the axis (column of E) of an angle."""
    b = angle // 6
    E, j = motion.rate_map[b], angle - 6 * b - 3
    return 3 * b, (E[0, j], E[1, j], E[2, j])


@kernel
def _rotation(i):
    """Place of rotation i of all bodies among their velocities."""
    return i + 3 * (i // 3) + 3
