"""The speed limit: what the base case asks for at the very least, in the barest loop.

The moored barge with small angles, classical Runge-Kutta at a fixed step: stiffness and damping,
as many radiation states as hydrosim has, a row of its table of wave loads, the lift, a 6 x 6
Cholesky solve, and four contact points as springs with dashpots, unilateral but without modes,
events or energies. It answers the base case until the first contact, and costs as much after it.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, pi, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from benchmarks.compiled import Several
from hydrosim.radiation import StateSpace
from hydrosim.rigid import place_bodies
from hydrosim.stepping.dynamics import Model, find_mass, new_work

bare = njit(error_model="numpy", nogil=True, fastmath=True, forceinline=True)
"""One loop with all that it calls inside, sums in any order: three times as fast as with calls."""


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
