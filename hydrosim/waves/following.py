"""First-order loads of waves on a body where it is, not where it is at rest.

    F = R(psi) Re sum_i X_i(b_i - psi) a_i exp(i (w_i t - k_i . (r + d) + e_i))

r: the centre of gravity's place at rest in the earth's x, y; d: its displacement from there; psi:
yaw, counted from the heading at rest; R: rotation from heading axes to the earth's; X: transfer
functions of the elevation at the centre of gravity. Without instantaneous position d = 0, without instantaneous headings
psi = 0. Limits: heave, roll and pitch do not matter, and wave-frequency motions count as the slow
ones do, which is a second-order load of its own. Every wave is summed at every stage, exactly but
for X, which is interpolated in yaw by 6-point Lagrange polynomials, six nodes to a heading of the
database; so this costs much more than the tables of `loads`.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, floor, pi, sin
from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import kernel
from hydrosim.scene import Place
from hydrosim.waves.body import WaveBody
from hydrosim.waves.components import Components
from hydrosim.waves.loads import POINTS, lagrange, rise
from hydrosim.waves.quadratic import QuadraticFunctions
from hydrosim.waves.transfer import excitation_at

NODES = 6  # of yaw between two headings of a database


class FollowingLoads(NamedTuple):
    """Waves on the bodies that they follow, body by body: those of the k-th have the entries
    offset[k] to offset[k + 1] of omega, kx, ky [1/m] and ramp [s]. Transfer functions times
    complex elevations, (nodes[k], 6) of an entry, are one after the other in ``load``, those of
    the body from first[k]."""

    body: np.ndarray  # (nb,) index among the scene's bodies
    heading: np.ndarray  # (nb,) at rest [rad]
    placed: np.ndarray  # (nb,) whether the position counts
    nodes: np.ndarray  # (nb,) of yaw round the circle; 1 if yaw does not count
    offset: np.ndarray  # (nb + 1,)
    first: np.ndarray  # (nb,)
    active: np.ndarray  # (nb, 6) which DOFs are not locked
    omega: np.ndarray
    kx: np.ndarray
    ky: np.ndarray
    ramp: np.ndarray
    load: np.ndarray  # complex


def follows(body: WaveBody) -> bool:
    """Whether the waves follow the body."""
    asked = body.wave_forces
    moving = Place.INSTANTANEOUS in (asked.position, asked.headings)
    return body.database is not None and asked.first_order and moving


def following_model(seas: Sequence[Components], bodies: Sequence[WaveBody]) -> FollowingLoads:
    """The waves of all ``seas`` on the bodies that they follow."""
    chosen = [body for body in bodies if follows(body)]
    parts = [
        (waves, _loads(waves, body, body.database))
        for body in chosen
        for waves in seas
        if body.database is not None
    ]
    count = sum(waves.omega.size for waves in seas)
    nodes = np.array([_yaw_nodes(body).size for body in chosen], dtype=np.int64)

    def joined(name: str) -> np.ndarray:
        return np.concatenate([np.zeros(0), *(getattr(waves, name) for waves, _ in parts)])

    k, heading = joined("wavenumber"), joined("heading")
    placed = [body.wave_forces.position == Place.INSTANTANEOUS for body in chosen]
    return FollowingLoads(
        body=np.array([body.offset // 6 for body in chosen], dtype=np.int64),
        heading=np.array([body.heading for body in chosen]),
        placed=np.array(placed, dtype=bool),
        nodes=nodes,
        offset=count * np.arange(len(chosen) + 1),
        first=np.append(0, np.cumsum(6 * count * nodes))[: len(chosen)],
        active=np.array([body.active for body in chosen], dtype=bool).reshape(-1, 6),
        omega=joined("omega"),
        kx=k * np.cos(heading),
        ky=k * np.sin(heading),
        ramp=np.concatenate([np.zeros(0), *(np.full(x.omega.size, x.ramp) for x, _ in parts)]),
        load=np.concatenate([np.zeros(0, complex), *(load.ravel() for _, load in parts)]),
    )


def _yaw_nodes(body: WaveBody) -> np.ndarray:
    if body.wave_forces.headings == Place.MEAN or body.database is None:
        return np.zeros(1)
    count = NODES * max(body.database.heading.size, 2 * POINTS)
    return 2.0 * np.pi / count * np.arange(count)


def _loads(waves: Components, body: WaveBody, database: QuadraticFunctions) -> np.ndarray:
    """X a exp(i e), (nw, nodes, 6), of elevations at the centre of gravity at rest."""
    x, y = body.centre
    elevation = waves.at(*body.place())
    found = []
    for yaw in _yaw_nodes(body):
        to = waves.heading - body.heading - yaw
        shift = np.exp(1j * waves.wavenumber * (x * np.cos(to) + y * np.sin(to)))
        transfer = excitation_at(database, to, waves.omega)
        found.append((elevation * shift)[:, None] * transfer)
    return np.stack(found, axis=1)


@kernel
def following_loads(t, coordinates, p, scratch, force):
    """Add the loads at time t to ``force`` (6 nb,), for displacements ``coordinates`` (6 nb,);
    ``scratch`` (POINTS + 6,)."""
    weights, load = scratch[:POINTS], scratch[POINTS:]
    for k in range(p.body.size):
        at = 6 * p.body[k]
        yaw = coordinates[at + 5] if p.nodes[k] > 1 else 0.0
        dx = coordinates[at] if p.placed[k] else 0.0
        dy = coordinates[at + 1] if p.placed[k] else 0.0
        node = _weigh(yaw, p.nodes[k], weights)
        for j in range(6):
            load[j] = 0.0
        for i in range(p.offset[k], p.offset[k + 1]):
            angle = p.omega[i] * t - p.kx[i] * dx - p.ky[i] * dy
            row = p.first[k] + (i - p.offset[k]) * p.nodes[k] * 6
            _add_wave(angle, rise(t, p.ramp[i]), row, node, p.nodes[k], weights, p.load, load)
        c, s = cos(p.heading[k] + yaw), sin(p.heading[k] + yaw)
        for j in range(0, 6, 3):
            load[j], load[j + 1] = load[j] * c - load[j + 1] * s, load[j] * s + load[j + 1] * c
        for j in range(6):
            force[at + j] += load[j] if p.active[k, j] else 0.0


@kernel
def _weigh(yaw, nodes, weights):
    """Weights of the nodes round ``yaw``, the first of which is returned."""
    if nodes == 1:
        weights[0] = 1.0
        return 0
    x = yaw * nodes / (2.0 * pi)
    node = floor(x) - POINTS // 2 + 1
    for m in range(POINTS):
        weights[m] = lagrange(x - node, m, POINTS)
    return node % nodes


@kernel
def _add_wave(angle, ramp, row, node, nodes, weights, table, load):
    """Add the loads of one wave."""
    c, s = ramp * cos(angle), ramp * sin(angle)
    for m in range(min(nodes, POINTS)):
        at = row + 6 * ((node + m) % nodes)
        for j in range(6):
            load[j] += weights[m] * (c * table[at + j].real - s * table[at + j].imag)
