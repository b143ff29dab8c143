"""Dry friction in the motions of joints that grows with the load of their bearings.

    f = mu W        W = r (|N_1| + |N_2|) + c |F . a|        N_1, N_2 = F_a / 2 +- M x a / L

F, M: force and moment in the joint at the middle of its two bearings, L apart along the axis a;
F_a: the part of F across a. N_1, N_2 are the forces of both bearings, the shoes of a rail or the
bushes of a pin. Without L they carry no moment. r: radius of the pin, 1 for a slide; c: radius of
the collar that carries the force along the pin. So a push P at a lever e from a rail makes W = 2 P
e / L, and the rail jams if e > L / (2 mu), whatever P is (Beer & Johnston, Statics, chapter 8).

Accelerations and reactions are linear in forces, so that N = N_0 + sum_j f_j N_j at each state. W
is a seminorm. So all f = mu W(N) have one solution if the spectral radius of K, K_ij = mu_i
W_i(N_j), is below 1 (a P-contraction; Ortega & Rheinboldt 1970, 13.1), as the pivots of 1 - K tell.
Newton's method finds it. Otherwise friction that adds to its own load has no solution or several
(Painleve 1895): the motion becomes undefined, and the run ends.

Limits: bearings carry no moment about the axis of a slide, and have no play.
"""

from __future__ import annotations

from math import nan, sqrt
from typing import Any, NamedTuple

import numpy as np

from hydrosim.elements.joint.motions import DOWN, STUCK, UNDEFINED_FRICTION, UP
from hydrosim.jit.kernels import assign, clear, kernel, root
from hydrosim.modes import MODE
from hydrosim.multibody.tree import push_joint
from hydrosim.multibody.vectors import add, cross, dot, scale, sub, vector

BEARING_LOADS = 7  # N_1, N_2 and F . a
MAX_NEWTON, MAX_NEWTON_STEPS = 30, 400  # afterwards the contraction itself, which always converges
FRICTION_ROUNDING = 1e-15  # of the largest friction: residual that is rounding


class LoadFrictionScratch(NamedTuple):
    """Scratch for m motions with such friction, n coordinates and r constraints. Rows 0 are the
    solution without it, rows 1 + j those of a unit force in motion j alone.

    ``total`` (6 nb,): forces on all bodies; ``wrench`` (nr, 6 nb) and ``missing`` (6 nb,): forces
    of one solution; ``joint`` (6 nj,): its loads in joints. ``rates`` (1 + m, n): accelerations;
    ``forces`` (1 + m, r): lambda; ``bearing`` (2 + m, m, 7): loads of bearings, the last those with
    the present friction. Of each motion: the ``direction`` (m,) of its friction, 0 if it does not
    slide; the ``friction`` (m,), the ``load`` (m,) W; the ``pivot`` (m,) of 1 - K. ``matrix`` (m,
    m), ``residual`` and ``step`` (m,) are of Newton's method."""

    total: np.ndarray
    wrench: np.ndarray
    missing: np.ndarray
    joint: np.ndarray
    rates: np.ndarray
    forces: np.ndarray
    bearing: np.ndarray
    direction: np.ndarray
    friction: np.ndarray
    load: np.ndarray
    pivot: np.ndarray
    matrix: np.ndarray
    residual: np.ndarray
    step: np.ndarray


def new_load_friction(
    elements: Any, bodies: int, forces: int, coordinates: int, rows: int
) -> LoadFrictionScratch:
    """Scratch for the motions of joints with such friction, empty for none."""
    m = elements.joint_motions.loaded.size
    joints = elements.locks.joints
    solutions = 1 + m if m else 0
    wide = 6 * bodies if m else 0
    return LoadFrictionScratch(
        np.zeros(wide),
        np.zeros((forces, wide)),
        np.zeros(wide),
        np.zeros(6 * joints if m else 0),
        np.zeros((solutions, coordinates)),
        np.zeros((solutions, rows)),
        np.zeros((2 + m if m else 0, m, BEARING_LOADS)),
        np.zeros(m),
        np.zeros(m),
        np.zeros(m),
        np.zeros(m),
        np.zeros((m, m)),
        np.zeros(m),
        np.zeros(m),
    )


@kernel
def find_directions(modes, p, scratch):
    """Fill the ``direction`` of the friction of all motions."""
    for i in range(p.loaded.size):
        mode = modes[p.mode + p.loaded[i], MODE]
        scratch.direction[i] = -1.0 if mode == UP else 1.0 if mode == DOWN else 0.0


@kernel
def find_bearing_loads(k, y, motion, bodies, p, scratch):
    """Loads of all bearings in solution ``k``, from the loads of its joints. Bearings are on the
    body of a joint; in a reversed one the place of the joint moves along the axis from there."""
    for i in range(p.loaded.size):
        joint_motion = p.each[p.loaded[i]]
        a = vector(motion.growth.axes[joint_motion.move, joint_motion.axis], 0)
        F = vector(scratch.joint, 6 * joint_motion.joint)
        M = vector(scratch.joint, 6 * joint_motion.joint + 3)
        if joint_motion.shifts and bodies.exact:
            M = sub(M, cross(scale(y[joint_motion.coordinate], a), F))
        along = dot(F, a)
        half = scale(0.5, sub(F, scale(along, a)))
        couple = scale(joint_motion.couple, cross(M, a))
        first = add(half, couple)
        second = sub(half, couple)
        for c in range(3):
            scratch.bearing[k, i, c] = first[c]
            scratch.bearing[k, i, 3 + c] = second[c]
        scratch.bearing[k, i, 6] = along


@root
def find_friction(p, scratch):
    """Friction and load of all motions from the loads of bearings in all solutions. Friction is
    zero where it is not unique."""
    m = p.loaded.size
    clear(scratch.friction)
    _fill_gains(p, scratch)
    unique = _eliminate(scratch.matrix, scratch.residual, scratch.pivot)
    for tries in range(MAX_NEWTON_STEPS):
        if _find_residual(unique, p, scratch):
            return
        if tries < MAX_NEWTON:
            _fill_slopes(p, scratch)
            _eliminate(scratch.matrix, scratch.residual, scratch.step)
        for i in range(m):
            scratch.friction[i] += scratch.residual[i]


@kernel
def _fill_gains(p, scratch):
    """1 - K into ``matrix``: no entries between motions that do not slide."""
    for i in range(p.loaded.size):
        for j in range(p.loaded.size):
            scratch.matrix[i, j] = 1.0 if i == j else 0.0
            if scratch.direction[i] != 0.0 and scratch.direction[j] != 0.0:
                bearing = p.each[p.loaded[i]]
                load = _load_of(bearing, scratch.bearing[1 + j, i])
                scratch.matrix[i, j] -= bearing.kinetic_coefficient * load


@kernel
def _find_residual(unique, p, scratch):
    """Loads under the present friction, and mu W - f into ``residual``; true if that is
    rounding."""
    m = p.loaded.size
    now = scratch.bearing[1 + m]
    worst = 0.0
    size = 0.0
    for i in range(m):
        for c in range(BEARING_LOADS):
            now[i, c] = scratch.bearing[0, i, c]
            for j in range(m):
                friction = scratch.direction[j] * scratch.friction[j]
                now[i, c] += friction * scratch.bearing[1 + j, i, c]
        bearing = p.each[p.loaded[i]]
        scratch.load[i] = _load_of(bearing, now[i])
        slides = unique and scratch.direction[i] != 0.0
        friction = bearing.kinetic_coefficient * scratch.load[i] if slides else 0.0
        scratch.residual[i] = friction - scratch.friction[i]
        worst = max(worst, abs(scratch.residual[i]))
        size = max(size, friction)
    return worst <= FRICTION_ROUNDING * size


@kernel
def _fill_slopes(p, scratch):
    """1 - mu dW/df into ``matrix``, at the present friction."""
    m = p.loaded.size
    for i in range(m):
        for j in range(m):
            scratch.matrix[i, j] = 1.0 if i == j else 0.0
            if scratch.direction[i] != 0.0 and scratch.direction[j] != 0.0:
                bearing = p.each[p.loaded[i]]
                slope = _load_slope(bearing, scratch.bearing[1 + m, i], scratch.bearing[1 + j, i])
                scratch.matrix[i, j] -= bearing.kinetic_coefficient * scratch.direction[j] * slope


@kernel
def _load_of(bearing, loads):
    """W from the ``loads`` (7,) of the bearings of a motion."""
    first = vector(loads, 0)
    second = vector(loads, 3)
    both = sqrt(dot(first, first)) + sqrt(dot(second, second))
    return bearing.radius * both + bearing.collar * abs(loads[6])


@kernel
def _load_slope(bearing, loads, change):
    """Derivative of W at ``loads`` (7,) in the direction ``change`` (7,)."""
    slope = 0.0
    for k in range(0, 6, 3):
        force = vector(loads, k)
        size = sqrt(dot(force, force))
        if size > 0.0:
            slope += bearing.radius * dot(force, vector(change, k)) / size
    return slope + bearing.collar * (change[6] if loads[6] >= 0.0 else -change[6])


@kernel
def _eliminate(A, b, pivots):
    """Solve A x = b in place without exchange of rows, which H-matrices do not need. The pivots go
    to ``pivots`` (m,); false at the first that is not positive, and those behind it are 1."""
    m = b.size
    for i in range(m):
        pivots[i] = 1.0
    for i in range(m):
        pivots[i] = A[i, i]
        if not A[i, i] > 0.0:
            return False
        for k in range(i + 1, m):
            part = A[k, i] / A[i, i]
            b[k] -= part * b[i]
            for j in range(i, m):
                A[k, j] -= part * A[i, j]
    for back in range(m):
        i = m - 1 - back
        for j in range(i + 1, m):
            b[i] -= A[i, j] * b[j]
        b[i] /= A[i, i]
    return True


@kernel
def add_solutions(modes, p, scratch, x, force):
    """Accelerations ``x`` (n,) and ``force`` (r,) lambda with the friction that was found. They are
    no numbers where a motion is undefined."""
    m = p.loaded.size
    assign(x, scratch.rates[0])
    assign(force, scratch.forces[0])
    for i in range(m):
        friction = scratch.direction[i] * scratch.friction[i]
        if modes[p.mode + p.loaded[i], MODE] == UNDEFINED_FRICTION:
            friction = nan
        if friction != 0.0:
            for j in range(x.size):
                x[j] += friction * scratch.rates[1 + i, j]
            for j in range(force.size):
                force[j] += friction * scratch.forces[1 + i, j]


@kernel
def add_friction(modes, motion, bodies, p, scratch, holds, wrench):
    """Add the friction of motions that slide to their rows of ``wrench``. Their reactions become
    this friction and the pivot of 1 - K; of motions at rest the second is mu W."""
    for i in range(p.loaded.size):
        number = p.loaded[i]
        joint_motion = p.each[number]
        reaction = holds.reaction[p.reaction + number]
        reaction[1] = 0.0
        if modes[p.mode + number, MODE] == STUCK:
            reaction[1] = joint_motion.static_coefficient * scratch.load[i]
        elif scratch.direction[i] != 0.0:
            reaction[0] = scratch.direction[i] * scratch.friction[i]
            reaction[1] = scratch.pivot[i]
            row = wrench[joint_motion.row]
            push_joint(joint_motion.move, joint_motion.axis, reaction[0], bodies, motion, row)


@kernel
def add_power(y, modes, bodies, p, holds, rates):
    """Add the power that this friction takes to the ``rates`` of the integrals of losses."""
    n = bodies.active.size
    for i in p.loaded:
        if modes[p.mode + i, MODE] != STUCK:
            joint_motion = p.each[i]
            friction = holds.reaction[p.reaction + i, 0]
            rates[joint_motion.row] -= friction * y[n + joint_motion.coordinate]
