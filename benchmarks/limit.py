"""The speed limit: what the base case and the sphere ask for at the very least, in bare loops.

The moored barge with small angles, classical Runge-Kutta at a fixed step: stiffness and damping,
as many radiation states as hydrosim has, a row of its table of wave loads, the lift, a 6 x 6
Cholesky solve, and four contact points as springs with dashpots, unilateral but without modes,
events or energies. It answers the base case until the first contact, and costs as much after it.

The sphere likewise, by the inverse of the mass matrix; and for the radiated waves as many states as
hydrosim has, or the convolution, to fourth order with weights of all nodes, or as programs of first
order do it: K (6 x 6 x N) times the velocities of the last N steps, once a step.

hydrosim computes more: with states, two more loops of the sphere do so too. One has its ledger,
works and dissipations that ride along as states, the other its exact rotations as well: the angular
velocity and its bias, springs conjugate to the angles, gyroscopic moments, and R I R^T at every
stage.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, cos, pi, sin, sqrt
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from scipy.interpolate import make_interp_spline

from benchmarks.scenes import Several
from hydrosim.elements.kind import RADIATION, WAVE_FIRST_ORDER
from hydrosim.integrate.dynamics import Model, find_mass, new_work
from hydrosim.multibody import vectors
from hydrosim.multibody.kinematics import place_bodies
from hydrosim.multibody.mass import Inertia
from hydrosim.water.radiation import StateSpace
from hydrosim.water.radiation.convolution import ConvolutionKernel, new_history, radiation_memory
from hydrosim.water.radiation.history import append_node

bare = njit(error_model="numpy", nogil=True, fastmath=True, forceinline=True)
"""One loop with all that it calls inside, sums in any order: three times as fast as with calls."""
add, sub, cross, dot, matvec, vector, product = (
    bare(getattr(vectors, name).py_func)
    for name in ("add", "sub", "cross", "dot", "matvec", "vector", "product")
)


class States(NamedTuple):
    """Radiation states of groups of coupled DOFs: group g owns ``state[g]:state[g+1]``, the real
    poles first, then the first states of all pairs, then their second states; it couples the DOFs
    ``dof[member[g]:member[g+1]]``, and its rows of B and C begin at ``matrix[g]``."""

    state: np.ndarray
    member: np.ndarray
    matrix: np.ndarray
    real: np.ndarray
    dof: np.ndarray
    decay: np.ndarray
    rotation: np.ndarray
    B: np.ndarray
    C: np.ndarray


class Barge(NamedTuple):
    """Constants of the loop: matrices (6, 6), radiation, ``waves`` (rows, 1 + loads) from ``start``
    at half a step, the lift's table, and of the contact points places, gap, stiffness, dashpot."""

    inertia: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    states: States
    waves: np.ndarray
    start: int
    ramp: float
    first_dof: np.ndarray
    second_dof: np.ndarray
    lift_time: np.ndarray
    lift: np.ndarray
    places: np.ndarray
    gap: float
    spring: float
    dashpot: float


def barge(run: Several) -> Barge:
    """The constants, out of the compiled base case."""
    model, scene = run.model, run.scene
    mooring = model.elements.linear_moorings[0]
    lift = model.elements.applied_forces.pieces
    fenders, waves, h = model.elements.fenders, model.waves, scene.solver.step
    if not np.isclose(waves.step[0], h / 2):
        raise ValueError(f"the table of waves has a step of {waves.step[0]} s, not of {h / 2} s")
    point = fenders.points[0]
    return Barge(
        inertia=inertia_of(model),
        stiffness=model.stiffness[0] + mooring["stiffness"],
        damping=mooring["damping"],
        states=states_of(run.fits),
        waves=waves.values,
        start=round(-waves.start[0] / waves.step[0]),
        ramp=waves.ramp[0],
        first_dof=waves.first_dof,
        second_dof=waves.second_dof,
        lift_time=lift["start"].copy(),
        lift=lift["a"].copy(),
        places=fenders.points["place"].copy(),
        gap=point["plane_point"][2] - (model.bodies.each[0]["origin"] + point["place"])[2],
        spring=point["steepest"],
        dashpot=point["slip_damping"],
    )


def states_of(fits: Sequence[StateSpace]) -> States:
    """Of the models of all groups."""

    def starts(sizes: list[int]) -> np.ndarray:
        return np.cumsum([0, *sizes])

    def joined(parts: list[np.ndarray]) -> np.ndarray:
        return np.concatenate([np.zeros(0), *(np.ravel(part) for part in parts)])

    return States(
        state=starts([fit.order for fit in fits]),
        member=starts([fit.dofs.size for fit in fits]),
        matrix=starts([fit.B.size for fit in fits]),
        real=np.array([fit.real for fit in fits], dtype=np.int64),
        dof=joined([fit.dofs for fit in fits]).astype(np.int64),
        decay=joined([np.diag(fit.matrix) for fit in fits]),
        rotation=joined([fit.matrix.sum(axis=1) - np.diag(fit.matrix) for fit in fits]),
        B=joined([fit.B.T for fit in fits]),
        C=joined([fit.C for fit in fits]),
    )


def inertia_of(model: Model) -> np.ndarray:
    """Mass and added mass (6 nb, 6 nb) at rest."""
    work, n = new_work(model), model.bodies.active.size
    place_bodies(np.zeros(n), np.zeros(n), model.bodies, work.motion)
    find_mass(model, model.added_mass, work)
    return work.mass


def growth(t: np.ndarray, ramp: float) -> np.ndarray:
    """Of the waves at the times ``t`` [s]."""
    return 0.5 - 0.5 * np.cos(pi * np.minimum(t, ramp) / ramp)


def run(p: Barge, steps: int, step: float, every: int) -> np.ndarray:
    """Displacements and angles (steps / every + 1, 6) of a run from rest."""
    size = 12 + p.states.decay.size
    out = np.zeros((steps // every + 1, 6))
    loop(steps, step, every, p, np.zeros((3, size)), np.zeros((4, size)), np.zeros((7, 6)), out)
    return out


@bare
def loop(steps, h, every, p, y, k, scratch, out):
    """Classical Runge-Kutta; ``y[0]`` is the state, ``y[1]`` that of a stage."""
    now, stage = y[0], y[1]
    for n in range(steps):
        derivative(2 * n, n * h, now, p, scratch, k[0])
        for i in range(1, 4):
            ahead = 1 if i < 3 else 2
            for m in range(now.size):
                stage[m] = now[m] + 0.5 * ahead * h * k[i - 1, m]
            derivative(2 * n + ahead, (n + 0.5 * ahead) * h, stage, p, scratch, k[i])
        for m in range(now.size):
            now[m] += h / 6.0 * (k[0, m] + 2.0 * k[1, m] + 2.0 * k[2, m] + k[3, m])
        if (n + 1) % every == 0:
            for m in range(6):
                out[(n + 1) // every, m] = now[m]


@bare
def derivative(row, t, y, p, scratch, dy):
    """dy = y' at half-step ``row``, time ``t``."""
    q, v, force, L = y[:6], y[6:12], scratch[6], scratch[:6]
    for i in range(6):
        force[i] = 0.0
        for j in range(6):
            force[i] -= p.stiffness[i, j] * q[j] + p.damping[i, j] * v[j]
    radiate(y[12:], v, p.states, dy[12:], force)
    ramp = 1.0 if t >= p.ramp else 0.5 - 0.5 * cos(pi * t / p.ramp)
    loads = p.waves[p.start + row]
    for j in range(p.first_dof.size):
        force[p.first_dof[j]] += ramp * loads[1 + j]
    for j in range(p.second_dof.size):
        force[p.second_dof[j]] += ramp * ramp * loads[1 + p.first_dof.size + j]
    force[2] += lifted(t, p.lift_time, p.lift)
    touch(q, v, p, force)
    for i in range(6):
        dy[i] = v[i]
        for j in range(6):
            L[i, j] = p.inertia[i, j]
    solve(L, force)
    for i in range(6):
        dy[6 + i] = force[i]


@bare
def radiate(x, v, p, dx, force):
    """The states of all groups, and their forces."""
    for g in range(p.real.size):
        first, last, at = p.state[g], p.state[g + 1], p.matrix[g]
        real, size = p.real[g], last - first
        state, rate = x[first:last], dx[first:last]
        decay, rotation = p.decay[first:last], p.rotation[first + real : last]
        for k in range(size):
            rate[k] = decay[k] * state[k]
        pairs = (size - real) // 2
        upper, lower = state[real : real + pairs], state[real + pairs :]
        upper_rate, lower_rate = rate[real : real + pairs], rate[real + pairs :]
        for k in range(pairs):
            upper_rate[k] += rotation[k] * lower[k]
            lower_rate[k] -= rotation[k] * upper[k]
        for j in range(p.member[g], p.member[g + 1]):
            B, C, u, total = p.B[at : at + size], p.C[at : at + size], v[p.dof[j]], 0.0
            for k in range(size):
                rate[k] += B[k] * u
                total += C[k] * state[k]
            force[p.dof[j]] -= total
            at += size


@bare
def lifted(t, time, lift):
    """The lift at ``t``, on straight lines."""
    k = 1
    while k < time.size - 1 and t > time[k]:
        k += 1
    return lift[k - 1] + (lift[k] - lift[k - 1]) * (t - time[k - 1]) / (time[k] - time[k - 1])


@bare
def touch(q, v, p, force):
    """Springs that push down and dashpots along the plane, where a point is above it."""
    for i in range(p.places.shape[0]):
        x, y, z = p.places[i]
        compression = q[2] + y * q[3] - x * q[4] - p.gap
        if compression > 0.0:
            down = -p.spring * compression
            along = -p.dashpot * (v[0] + z * v[4] - y * v[5])
            across = -p.dashpot * (v[1] - z * v[3] + x * v[5])
            force[0] += along
            force[1] += across
            force[2] += down
            force[3] += y * down - z * across
            force[4] += z * along - x * down
            force[5] += x * across - y * along


@bare
def solve(L, b):
    """b = L^-1 b by Cholesky's factors, both in place."""
    for j in range(6):
        for k in range(j):
            L[j, j] -= L[j, k] * L[j, k]
        L[j, j] = sqrt(L[j, j])
        for i in range(j + 1, 6):
            for k in range(j):
                L[i, j] -= L[i, k] * L[j, k]
            L[i, j] /= L[j, j]
    for i in range(6):
        for k in range(i):
            b[i] -= L[i, k] * b[k]
        b[i] /= L[i, i]
    for i in range(5, -1, -1):
        for k in range(i + 1, 6):
            b[i] -= L[k, i] * b[k]
        b[i] /= L[i, i]


# Gauss and Legendre's rule of three points on [0, 1]: exact for degree 5, where 4 is asked for.
POINTS = (0.5 - 0.1**0.5 * 1.5**0.5, 0.5, 0.5 + 0.1**0.5 * 1.5**0.5)
WEIGHTS = (5 / 18, 8 / 18, 5 / 18)

ROWS = 5  # of forces: hydrostatics, radiation, waves of first and second order, mooring
MOORING = ROWS - 1
ENERGIES = ROWS + 1
"""States of the ledger: of all rows, and of |wave power|. Those of hydrostatics and of waves of
second order stay zero."""


class Sphere(NamedTuple):
    """Constants of the loops: matrices (6, 6), radiation, wave loads (rows, 6) at half steps; for
    exact rotations the inertia (3, 3) about the body's axes, and the parts of the mass matrix."""

    inverse: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    states: States
    waves: np.ndarray
    inertia: np.ndarray
    parts: Inertia


class Memory(NamedTuple):
    """Constants of the convolution: ``weight`` (2, 2, entries, nodes) of velocities and
    accelerations of the nodes, for the middle and the end of a step; the entries' ``row`` and
    ``column``; and ``piece`` (2, 3, 6, 6), what the last node's velocity and acceleration and the
    velocity at the time add."""

    weight: np.ndarray
    row: np.ndarray
    column: np.ndarray
    piece: np.ndarray


def sphere_of(run: Several) -> Sphere:
    """The constants, out of the compiled scene."""
    model = run.model
    mooring = model.elements.linear_moorings[0]
    return Sphere(
        inverse=np.linalg.inv(inertia_of(model)),
        stiffness=model.stiffness[0] + mooring["stiffness"],
        damping=mooring["damping"].copy(),
        states=states_of(run.fits),
        waves=wave_loads(model, run.scene.solver.step / 2),
        inertia=model.bodies.each[0]["inertia"].copy(),
        parts=model.inertia,
    )


def wave_loads(model: Model, step: float) -> np.ndarray:
    """First-order loads (rows, 6) every ``step`` [s] from 0 on; between the rows of the table,
    which resolve the waves, by splines of degree 7."""
    waves = model.waves
    known = waves.values[round(-waves.start[0] / waves.step[0]) :]
    time = waves.step[0] * np.arange(len(known))
    wanted = step * np.arange(int(time[-1] / step) + 1)
    rows = make_interp_spline(time, known, 7)(wanted)
    loads = np.zeros((len(rows), 6))
    loads[:, waves.first_dof] = rows[:, 1 : 1 + waves.first_dof.size]
    return loads * growth(step * np.arange(len(rows)), waves.ramp[0])[:, None]


def memory_of(p: ConvolutionKernel, step: float) -> Memory:
    """The constants of the convolution, for steps of this length [s]."""
    offsets, nodes = (0.5, 1.0), ceil((len(p.K) - 1) * p.step / step - 1e-9) + 1
    weight = np.array([_weights(p.step, p.K, step, offset, nodes) for offset in offsets])
    piece = np.array([_piece(offset * step, p) for offset in offsets])
    return Memory(weight, p.row, p.column, piece)


def _weights(step: float, K: np.ndarray, even: float, offset: float, nodes: int) -> np.ndarray:
    """Integrals of K (lags, entries) times the cubics of all nodes: (2, entries, nodes)."""
    length = (len(K) - 1) * step
    newest = offset * even
    edges = np.concatenate([newest + even * np.arange(nodes), step * np.arange(len(K))])
    edges = np.unique(edges[(edges >= newest) & (edges <= length)])
    width, middle = np.diff(edges), 0.5 * (edges[1:] + edges[:-1])
    cell = np.minimum((middle / step).astype(int), len(K) - 2)
    node = np.minimum(((middle - newest) / even).astype(int), nodes - 2)
    result = np.zeros((2, nodes, K.shape[1]))
    for point, weight in zip(POINTS, WEIGHTS, strict=True):
        lag = edges[:-1] + point * width
        part = (lag / step - cell)[:, None]
        force = (weight * width)[:, None] * ((1.0 - part) * K[cell] + part * K[cell + 1])
        basis = _cubic(node + 1 - (lag - newest) / even, even)
        for older, (v, a) in ((1, basis[:2]), (0, basis[2:])):
            np.add.at(result[0], node + older, v[:, None] * force)
            np.add.at(result[1], node + older, a[:, None] * force)
    return np.ascontiguousarray(result.transpose(0, 2, 1))


def _cubic(x, h):
    """Of the cubic at x in [0, 1] of an interval h: weights of the velocity and acceleration at
    its start, and at its end."""
    end = x * x * (3.0 - 2.0 * x)
    return 1.0 - end, h * x * (1.0 - x) ** 2, end, -h * x * x * (1.0 - x)


def _piece(h: float, p: ConvolutionKernel) -> np.ndarray:
    """Force (3, 6, 6) per velocity and acceleration of one node at 0, and per velocity at ``h``."""
    unit, none, force = np.eye(6), np.zeros(6), np.zeros((3, 6, 6))
    for j in range(6):
        for k, (u, a, v) in enumerate(
            [(unit[j], none, none), (none, unit[j], none), (none, none, unit[j])]
        ):
            history = new_history(p, 6, h)
            append_node(history, 0.0, u, a)
            radiation_memory(h, v, history, p, force[k, j])
    return np.ascontiguousarray(force.transpose(0, 2, 1))


def run_states(p: Sphere, steps: int, step: float, every: int) -> np.ndarray:
    """Displacements and angles (steps / every + 1, 6) of a run from rest."""
    return _run(_of_states, 0, p, steps, step, every)


def run_with_energies(p: Sphere, steps: int, step: float, every: int) -> np.ndarray:
    """The same with the ledger after the angles, (steps / every + 1, 6 + `ENERGIES`)."""
    return _run(_of_states_and_energies, ENERGIES, p, steps, step, every)


def run_exact(p: Sphere, steps: int, step: float, every: int) -> np.ndarray:
    """The same with exact rotations; ``p`` is of a scene that has them."""
    return _run(_of_rotations, ENERGIES, p, steps, step, every)


def _run(rates: Any, energies: int, p: Sphere, steps: int, step: float, every: int) -> np.ndarray:
    size = 12 + p.states.decay.size + energies
    out = np.zeros((steps // every + 1, 6 + energies))
    y, k, scratch = np.zeros((2, size)), np.zeros((4, size)), np.zeros((2, 6))
    _with_states(rates, steps, step, every, p, y, k, scratch, out)
    return out


@bare
def _with_states(rates, steps, h, every, p, y, k, scratch, out):
    now, stage = y[0], y[1]
    for n in range(steps):
        rates(p.waves[2 * n], now, p, scratch, k[0])
        for i in range(1, 4):
            _stage(i, h, now, k, stage)
            rates(p.waves[2 * n + (i + 1) // 2], stage, p, scratch, k[i])
        _finish(n, h, every, now, k, out)


@bare
def _stage(i, h, now, k, stage):
    slope, part = k[i - 1], h if i == 3 else 0.5 * h
    for m in range(now.size):
        stage[m] = now[m] + part * slope[m]


@bare
def _of_states(waves, y, p, scratch, dy):
    force = scratch[0]
    for i in range(6):
        force[i] = waves[i]
    radiate(y[12:], y[6:12], p.states, dy[12:], force)
    _accelerate(y, p, force, dy)


@bare
def _of_states_and_energies(waves, y, p, scratch, dy):
    force, v = scratch[0], y[6:12]
    _loads(waves, y[12:], v, p, force, dy[12:])
    for i in range(6):
        for j in range(6):
            force[i] -= p.stiffness[i, j] * y[j]
    _divide(v, p, force, dy)


@bare
def _loads(waves, x, v, p, force, dx):
    """All forces but the springs', and the rates of the radiation states and of the ledger."""
    for i in range(6):
        force[i] = 0.0
    radiate(x, v, p.states, dx, force)
    radiated, work, damped = 0.0, 0.0, 0.0
    for i in range(6):
        resistance = 0.0
        for j in range(6):
            resistance += p.damping[i, j] * v[j]
        radiated -= force[i] * v[i]
        work += waves[i] * v[i]
        damped += resistance * v[i]
        force[i] += waves[i] - resistance
    rate = dx[p.states.decay.size :]
    rate[RADIATION], rate[WAVE_FIRST_ORDER], rate[MOORING] = radiated, work, damped
    rate[ROWS] = abs(work)


@bare
def _of_rotations(waves, y, p, scratch, dy):
    """By hydrosim's Schur complement, but for the angular acceleration first, then the angles'."""
    force, v = scratch[0], scratch[1]
    cf, sf, ct, st, cp, sp = cos(y[3]), sin(y[3]), cos(y[4]), sin(y[4]), cos(y[5]), sin(y[5])
    roll, pitch, yaw = vector(y, 9)
    v[0], v[1], v[2] = vector(y, 6)
    v[3], v[4], v[5] = cp * ct * roll - sp * pitch, sp * ct * roll + cp * pitch, yaw - st * roll
    _loads(waves, y[12:], v, p, force, dy[12:])
    _add_springs(ct, st, cp, sp, y, p, force)
    R = (
        (cp * ct, cp * st * sf - sp * cf, cp * st * cf + sp * sf),
        (sp * ct, sp * st * sf + cp * cf, sp * st * cf - cp * sf),
        (-st, ct * sf, ct * cf),
    )
    bias = (
        -roll * (pitch * cp * st + yaw * sp * ct) - pitch * yaw * cp,
        -roll * (pitch * sp * st - yaw * cp * ct) - pitch * yaw * sp,
        -roll * pitch * ct,
    )
    a, b, c = sub(_accelerate_exactly(R, vector(v, 3), p, force, dy), bias)
    dy[9], dy[10] = (cp * a + sp * b) / ct, cp * b - sp * a
    dy[11] = c + st * dy[9]
    for i in range(6):
        dy[i] = y[6 + i]


@bare
def _add_springs(ct, st, cp, sp, y, p, force):
    """The wrench of what the springs do on the coordinates."""
    Q = product(p.stiffness, y, 0)
    along = (Q[3] + st * Q[5]) / ct
    wrench = (Q[0], Q[1], Q[2], cp * along - sp * Q[4], sp * along + cp * Q[4], Q[5])
    for i in range(6):
        force[i] -= wrench[i]


@bare
def _accelerate_exactly(R, omega, p, force, dy):
    """The angular acceleration; the accelerations of the translations go into ``dy``."""
    parts, rest = p.parts, p.parts.rest
    first, second, third = _turned_inertia(R, p.inertia)
    spin = (dot(first, omega), dot(second, omega), dot(third, omega))
    still = matvec(parts.inverse, force)
    moment = sub(sub(vector(force, 3), matvec(parts.coupling, still)), cross(omega, spin))
    alpha = _solve(
        add(first, vector(rest[0], 0)),
        add(second, vector(rest[1], 0)),
        add(third, vector(rest[2], 0)),
        moment,
    )
    dy[6], dy[7], dy[8] = sub(still, matvec(parts.gain, alpha))
    return alpha


@bare
def _turned_inertia(R, inertia):
    """Rows of R I R^T."""
    x, y, z = matvec(inertia, R[0]), matvec(inertia, R[1]), matvec(inertia, R[2])
    xy, xz, yz = dot(R[0], y), dot(R[0], z), dot(R[1], z)
    return (dot(R[0], x), xy, xz), (xy, dot(R[1], y), yz), (xz, yz, dot(R[2], z))


@bare
def _solve(a, b, c, m):
    """x of the equations a x, b x, c x = m, of a symmetric matrix, by its cofactors."""
    first, second, third = cross(b, c), cross(c, a), cross(a, b)
    scale = 1.0 / dot(a, first)
    return (scale * dot(first, m), scale * dot(second, m), scale * dot(third, m))


@bare
def _accelerate(y, p, force, dy):
    for i in range(6):
        for j in range(6):
            force[i] -= p.stiffness[i, j] * y[j] + p.damping[i, j] * y[6 + j]
    _divide(y[6:12], p, force, dy)


@bare
def _divide(v, p, force, dy):
    """Rates of displacements and velocities."""
    for i in range(6):
        dy[i], dy[6 + i] = v[i], 0.0
        for j in range(6):
            dy[6 + i] += p.inverse[i, j] * force[j]


@bare
def _finish(n, h, every, now, k, out):
    first, second, third, fourth = k[0], k[1], k[2], k[3]
    for m in range(now.size):
        now[m] += h / 6.0 * (first[m] + 2.0 * second[m] + 2.0 * third[m] + fourth[m])
    if (n + 1) % every == 0:
        row = out[(n + 1) // every]
        for m in range(6):
            row[m] = now[m]
        for m in range(6, row.size):
            row[m] = now[now.size - row.size + m]


def run_convolution(p: Sphere, m: Memory, steps: int, step: float, every: int) -> np.ndarray:
    """The same with the convolution to fourth order."""
    out, nodes = np.zeros((steps // every + 1, 6)), m.weight.shape[3]
    motion, past = np.zeros((2, 6, steps + nodes)), np.zeros((2, 6))
    scratch = np.zeros((2, 12)), np.zeros((4, 12)), np.zeros(6)
    _with_convolution(steps, step, every, p, m, motion, past, *scratch, out)
    return out


@bare
def _with_convolution(steps, h, every, p, m, motion, past, y, k, force, out):
    """``motion`` (2, 6, steps + nodes) are velocities and accelerations, the newest first."""
    now, stage = y[0], y[1]
    _of_past(p.waves[0], now, past[0], m.piece[0, 2], p, force, k[0])
    for n in range(steps):
        first = steps - 1 - n
        for j in range(6):
            motion[0, j, first], motion[1, j, first] = now[6 + j], k[0, 6 + j]
        for i in range(2):
            _sum_up(first, motion, m.weight[i], m.piece[i], m, past[i])
        for i in range(1, 4):
            _stage(i, h, now, k, stage)
            at, waves = i // 3, p.waves[2 * n + (i + 1) // 2]
            _of_past(waves, stage, past[at], m.piece[at, 2], p, force, k[i])
        _finish(n, h, every, now, k, out)
        _of_past(p.waves[2 * n + 2], now, past[1], m.piece[1, 2], p, force, k[0])


@bare
def _sum_up(first, motion, weight, piece, m, past):
    """The part of the nodes in the memory force."""
    for i in range(6):
        past[i] = 0.0
        for j in range(6):
            past[i] += piece[0, i, j] * motion[0, j, first] + piece[1, i, j] * motion[1, j, first]
    for e in range(m.row.size):
        total = 0.0
        v, a = motion[0, m.column[e], first:], motion[1, m.column[e], first:]
        for k in range(weight.shape[2]):
            total += weight[0, e, k] * v[k] + weight[1, e, k] * a[k]
        past[m.row[e]] -= total


@bare
def _of_past(waves, y, past, piece, p, force, dy):
    for i in range(6):
        force[i] = waves[i] + past[i]
        for j in range(6):
            force[i] += piece[i, j] * y[6 + j]
    _accelerate(y, p, force, dy)


def run_once_a_step(p: Sphere, K: np.ndarray, steps: int, step: float, every: int) -> np.ndarray:
    """The same with the whole ``K`` (6, 6, lags), its lags a step apart, once a step."""
    out, velocity = np.zeros((steps // every + 1, 6)), np.zeros((6, steps + K.shape[2]))
    scratch = np.zeros((2, 12)), np.zeros((4, 12)), np.zeros((2, 6))
    _once_a_step(steps, step, every, p, K, velocity, *scratch, out)
    return out


@bare
def _once_a_step(steps, h, every, p, K, velocity, y, k, scratch, out):
    """The force is the trapezoidal rule's at the beginning of the step, and stays."""
    now, stage, force, memory = y[0], y[1], scratch[0], scratch[1]
    for n in range(steps):
        first = steps - 1 - n
        for j in range(6):
            velocity[j, first] = now[6 + j]
        for i in range(6):
            total = 0.0
            for j in range(6):
                v = velocity[j, first:]
                total -= 0.5 * K[i, j, 0] * v[0]
                for m in range(K.shape[2]):
                    total += K[i, j, m] * v[m]
            memory[i] = h * total
        for i in range(4):
            if i > 0:
                _stage(i, h, now, k, stage)
            for j in range(6):
                force[j] = p.waves[2 * n + (i + 1) // 2, j] - memory[j]
            _accelerate(stage if i > 0 else now, p, force, k[i])
        _finish(n, h, every, now, k, out)
