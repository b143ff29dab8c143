"""The heading axes of bodies, and added mass that turns with them.

Heading axes go through the centre of gravity, z up, turned from the earth's axes by psi. This is
the heading at rest plus the yaw.

    x_heading = P^T x_earth,   P = Rz(psi),   P' = psi' J P,   J = e_z x

The same P applies to the translations and to the rotations of a velocity or wrench. Quantities that
belong to both the hull and the level water are constant in these axes: added mass, retardation
functions, transfer functions of waves and coefficients of streams. Each of several coupled bodies
has its own axes. In a matrix between two bodies, rows turn with one body and columns with the
other.

psi is the last of the z-y'-x'' angles. With small angles the axes are those at rest, parallel to
the earth's.

Added mass that turns with the heading of each body (Kirchhoff's equations in earth axes).

The water that a body sets in motion has the kinetic energy

    T = w^T A(psi) w / 2,   A(psi) = P A P^T,   w = v - U

P: from the heading axes of each body to the earth's; U: the current on each body.
Lagrange's equations in w give the force on the bodies: force p', moment G' - omega x G, and
-dT/dpsi on psi. (Lamb 1932, art. 124 has them for axes fixed in a body.) With the momentum
(p, G) = A(psi) w,

    F = -p',   M = -G' + omega x G + E^-T (0, 0, dT/dpsi),
    dT/dpsi = w^T J A(psi) w = -e_z . (w_t x p + omega x G)

The last term is Munk's moment. For a jointed body it acts on all joints that turn its heading
(`multibody.tree`). The part -A(psi) v' is inertia; `add_turning` adds the rest. The
rest does no net work but conserves momentum: the work of F is -dT/dt. Body and water together keep
their linear impulse, and their angular impulse about a vertical through any fixed point.
"""

from __future__ import annotations

from math import cos, sin
from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import assign, clear, kernel, root
from hydrosim.multibody.kinematics import Bodies, Motion, new_motion
from hydrosim.multibody.tree import NO_BODY, SLIDE, TURN, add_heading_moment
from hydrosim.multibody.vectors import cross, vector


class Headings(NamedTuple):
    """Constants of the heading axes.

    ``turned`` (nt,) lists the bodies whose heading axes differ from the earth's; ``turning`` (nr,)
    those of them with free yaw. ``surge`` (nt,) is the index of each turned body's surge among the
    free coordinates; sway follows it; -1 if both are locked. ``steady`` is false if only one of the
    two is locked for some body, so that inertia varies. ``current`` (nb, 2) [m/s] is that on each
    body, in the earth frame. ``stream`` (6 nb,) is the current at the start of a run in the axes of
    every body.
    """

    turned: np.ndarray
    turning: np.ndarray
    surge: np.ndarray
    steady: bool
    current: np.ndarray
    stream: np.ndarray


class HeadingScratch(NamedTuple):
    """Scratch, (6 nb,) in heading axes: ``velocity`` for the radiation memory and ``flow`` relative
    to the water, see `find_flow`; ``turn`` psi' J flow; ``momentum`` of the water and its
    ``force``; the ``motion`` of the bodies that their inertia needs."""

    velocity: np.ndarray
    flow: np.ndarray
    turn: np.ndarray
    momentum: np.ndarray
    force: np.ndarray
    motion: Motion


def new_headings(
    bodies: Bodies, wet: np.ndarray, current: np.ndarray, stream: np.ndarray
) -> Headings:
    """Headings of bodies; ``wet`` (nb,) marks those with hydrodynamics. See `Headings`."""
    free = np.isin(np.arange(6 * bodies.each.size), bodies.active).reshape(-1, 6)
    yaw = bodies.locked.reshape(-1, 6)[:, 5] + bodies.each["heading"]
    turning = wet & turning_heading(bodies) & bodies.exact
    turned = np.flatnonzero(turning | (wet & (yaw != 0.0) & bodies.exact))
    place = {index: j for j, index in enumerate(bodies.active.tolist())}
    return Headings(
        turned,
        np.flatnonzero(turning),
        np.array([place.get(6 * b, -1) for b in turned.tolist()], dtype=np.int64),
        bool(np.all(free[turned, 0] == free[turned, 1])) and not bodies.tree.branches.size,
        current,
        stream,
    )


def turning_heading(bodies: Bodies) -> np.ndarray:
    """True (nb,) for bodies whose heading may change: their own yaw is free, or a joint below them
    turns about an axis that is not level."""
    free = np.isin(np.arange(6 * bodies.each.size), bodies.active).reshape(-1, 6)[:, 5]
    for branch in bodies.tree.branches:
        moves = bodies.tree.moves[branch["first"] : branch["last"]]
        turns = moves[moves["kind"] != SLIDE]
        level = len(turns) == 0 or (
            len(turns) == 1 and (turns["kind"] == TURN).all() and abs(turns["axes"][0, 0, 2]) == 0.0
        )
        parent = branch["parent"]
        free[branch["child"]] = not level or (parent != NO_BODY and free[parent])
    return free


def new_heading_scratch(bodies: Bodies) -> HeadingScratch:
    """Scratch for these bodies."""
    velocity, flow, turn, momentum, force = np.zeros((5, 6 * bodies.each.size))
    return HeadingScratch(velocity, flow, turn, momentum, force, new_motion(bodies))


@kernel
def heading(b, bodies, motion):
    """Cosine and sine of the heading of body ``b``."""
    if bodies.exact:
        E = motion.rate_map[b]
        return E[1, 1], -E[0, 1]
    yaw = motion.coordinates[6 * b + 5]
    return cos(yaw), sin(yaw)


@kernel
def heading_rate(b, motion):
    """psi' of body ``b``."""
    return motion.growth.rate[b] if motion.growth.rate.size > 0 else motion.rate[6 * b + 5]


@kernel
def to_heading(b, motion, x):
    """Turn the six entries of body ``b`` in ``x`` (6 nb,) from earth to heading axes, in place."""
    E = motion.rate_map[b]
    _turn_pairs(E[1, 1], E[0, 1], 6 * b, x)


@kernel
def to_earth(b, motion, x):
    """Turn the six entries of body ``b`` in ``x`` (6 nb,) from heading to earth axes, in place."""
    E = motion.rate_map[b]
    _turn_pairs(E[1, 1], -E[0, 1], 6 * b, x)


@kernel
def _turn_pairs(c, s, k, x):
    for i in (k, k + 3):
        x[i], x[i + 1] = c * x[i] - s * x[i + 1], s * x[i] + c * x[i + 1]


@kernel
def all_to_earth(p, motion, x):
    """Apply `to_earth` to all turned bodies."""
    for b in p.turned:
        to_earth(b, motion, x)


@kernel
def all_to_heading(p, motion, x):
    """Apply `to_heading` to all turned bodies."""
    for b in p.turned:
        to_heading(b, motion, x)


@kernel
def turn_matrix(p, motion, A):
    """Turn A (6 nb, 6 nb) in heading axes into P A P^T in the earth's axes, in place."""
    for b in p.turned:
        E, n = motion.rate_map[b], A.shape[0]
        c, s = E[1, 1], -E[0, 1]
        for k in (6 * b, 6 * b + 3):
            for i in range(n):
                A[k, i], A[k + 1, i] = c * A[k, i] - s * A[k + 1, i], s * A[k, i] + c * A[k + 1, i]
            for i in range(n):
                A[i, k], A[i, k + 1] = c * A[i, k] - s * A[i, k + 1], s * A[i, k] + c * A[i, k + 1]


@kernel
def find_flow(p, motion, hulls):
    """Fill ``flow`` = P^T (v - U) and ``velocity``, its part that the radiation memory stores. The
    memory excludes the flow of the current U at the start heading, which has lasted since long
    before the start. Both equal v for bodies that are not turned."""
    assign(hulls.flow, motion.velocity)
    assign(hulls.velocity, motion.velocity)
    for b in p.turned:
        k = 6 * b
        hulls.flow[k] -= p.current[b, 0]
        hulls.flow[k + 1] -= p.current[b, 1]
        to_heading(b, motion, hulls.flow)
        for i in range(k, k + 6):
            hulls.velocity[i] = hulls.flow[i] + p.stream[i]


@kernel
def accelerations_in_heading(p, motion, flow, a):
    """Change the accelerations ``a`` (6 nb,) in place, from v' in earth axes to the time derivative
    of ``flow`` = P^T (v - U) in heading axes, P^T v' - psi' J P^T (v - U). P turns heading axes
    into earth axes, U is the velocity of the water, and J = e_z x."""
    all_to_heading(p, motion, a)
    for b in p.turning:
        rate = heading_rate(b, motion)
        for k in (6 * b, 6 * b + 3):
            a[k] += rate * flow[k + 1]
            a[k + 1] -= rate * flow[k]


@kernel
def motion_along(p, bodies, motion, along):
    """Fill in ``along`` the part of a motion that inertia needs, in heading axes: R, E and S'
    q'."""
    assign(along.bias, motion.bias)
    all_to_heading(p, motion, along.bias)
    for b in range(bodies.each.size):
        for i in range(3):
            assign(along.rotation[b, i], motion.rotation[b, i])
            assign(along.rate_map[b, i], motion.rate_map[b, i])
    for b in p.turned:
        E = motion.rate_map[b]
        c, s = E[1, 1], -E[0, 1]
        for M in (along.rotation[b], along.rate_map[b]):
            for i in range(3):
                M[0, i], M[1, i] = c * M[0, i] + s * M[1, i], c * M[1, i] - s * M[0, i]


@kernel
def translations_to_earth(p, motion, x):
    """Turn the accelerations ``x`` (n,) of surge and sway from heading to earth axes, in place."""
    for i in range(p.turned.size):
        j = p.surge[i]
        if j >= 0:
            E = motion.rate_map[p.turned[i]]
            c, s = E[1, 1], -E[0, 1]
            x[j], x[j + 1] = c * x[j] - s * x[j + 1], s * x[j] + c * x[j + 1]


@root
def add_turning(p, A, bodies, motion, hulls, total):
    """Add to ``total`` (6 nb,) the force of the water without -A(psi) v'; ``hulls.flow`` must be
    filled.

    With z = psi' J P^T w of each turning body, the force is P (A z - psi' J A P^T w), with the
    moments above.
    """
    turn, momentum, force = hulls.turn, hulls.momentum, hulls.force
    clear(turn)
    for b in p.turning:
        _add_turned(heading_rate(b, motion), 6 * b, hulls.flow, turn)
    multiply(A, hulls.flow, momentum)
    multiply(A, turn, force)
    for b in p.turning:
        _add_turned(-heading_rate(b, motion), 6 * b, momentum, force)
        _add_spin(6 * b, hulls.flow, momentum, force)
    all_to_earth(p, motion, force)
    for b in p.turning:
        moment = _heading_moment(6 * b, hulls.flow, momentum)
        add_heading_moment(b, moment, bodies, motion, force)
    for i in range(total.size):
        total[i] += force[i]


@kernel
def _add_turned(rate, k, x, out):
    """Add ``rate`` times J x for the body whose entries begin at k."""
    for i in (k, k + 3):
        out[i] -= rate * x[i + 1]
        out[i + 1] += rate * x[i]


@kernel
def _add_spin(k, w, momentum, force):
    """Add omega x G, in heading axes."""
    spin = cross(vector(w, k + 3), vector(momentum, k + 3))
    for i in range(3):
        force[k + 3 + i] += spin[i]


@kernel
def _heading_moment(k, w, momentum):
    """dT/dpsi of one body."""
    spin = cross(vector(w, k + 3), vector(momentum, k + 3))
    munk = cross(vector(w, k), vector(momentum, k))
    return -munk[2] - spin[2]


@kernel
def multiply(A, x, out):
    """``out`` = A x."""
    for i in range(out.size):
        entry = 0.0
        for j in range(x.size):
            entry += A[i, j] * x[j]
        out[i] = entry


@kernel
def stream_energy(p, A, motion, hulls):
    """Energy U^T A(psi) U / 2 of the current. Subtract it from v^T A(psi) v / 2, so that the work
    of -d/dt(A(psi) w) on v equals that of -dT/dt."""
    if p.turning.size == 0:
        return 0.0
    U, energy = hulls.turn, 0.0
    clear(U)
    for b in range(U.size // 6):
        U[6 * b], U[6 * b + 1] = p.current[b, 0], p.current[b, 1]
    all_to_heading(p, motion, U)
    for i in range(U.size):
        for j in range(U.size):
            energy += 0.5 * U[i] * A[i, j] * U[j]
    return energy
