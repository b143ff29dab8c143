"""Added mass, memory and wave loads of a hull with varying draught, from databases at several
draughts.

    F = -sum_i r_i [A_i d(r_i u)/dt + int_0^t K_i(t - s) r_i(s) u(s) ds],    sum_i r_i^2 = 1
      = -A u' - A' u / 2 - sum_i r_i int_0^t K_i(t - s) r_i(s) u(s) ds,    A = sum_i r_i^2 A_i
    F_wave = sum_i r_i^2 F_wave,i

u: velocity of the body in its heading axes. At the fraction s between two draughts, their roots r
are cos(pi s / 2) and sin(pi s / 2); beyond the last draught its root is 1; all others are zero.

No motion can gain energy, however fast the draught changes. The water has the energy u A u / 2, and
the force of a memory acts through the same root as its input. (Blending A v' or d(A v)/dt, or one
memory behind the sum of others, creates energy near parametric resonance.)

The draught is the body's slow draught, T = T_0 - z_2. Heave q_3 passes through a causal filter that
leaves (c / w)^2 of a motion of frequency w, and lags 2 / c behind a steady one:

    z_1' = c (q_3 - z_1),   z_2' = c (z_1 - z_2)

Limits: where T passes a draught of a database, r has a corner where it is zero, so that r^2 and the
forces have none. Coefficients between two draughts are accurate if the draughts are close.
"""

from __future__ import annotations

from math import cos, pi, sin
from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import assign, clear, kernel, root

DRAUGHT_CUTOFF = 0.05  # rad/s, c
DRAUGHT_STATES = 2  # states of a family in y: z_1 and z_2


class DraughtFamilies(NamedTuple):
    """Constants of the families of databases: the ``body`` (nf,) of each and its draught at
    ``rest`` (nf,) [m], T_0. Members of a family start at ``first`` (nf + 1,). Each has its body
    ``owner`` (nm,), rising ``draught`` (nm,) [m] and ``added_mass`` (nm, 6, 6) at infinite
    frequency. In arrays that include members, the coordinates of member k start at 6 (nb + k)."""

    body: np.ndarray
    rest: np.ndarray
    first: np.ndarray
    owner: np.ndarray
    draught: np.ndarray
    added_mass: np.ndarray


class Blend(NamedTuple):
    """Scratch: the ``root`` r (nm,) and its rate ``change`` (nm,); ``added_mass`` (6 nb, 6 nb)
    including the families; A' u / 2 as ``lag`` (6 nb,). For bodies and members, (6 (nb + nm),): the
    ``velocity`` r u, their ``force``, and the loads ``first`` and ``second``."""

    root: np.ndarray
    change: np.ndarray
    added_mass: np.ndarray
    lag: np.ndarray
    velocity: np.ndarray
    force: np.ndarray
    first: np.ndarray
    second: np.ndarray


def new_blend(family: DraughtFamilies, bodies: int) -> Blend:
    """Scratch for these families and this number of bodies."""
    members, own_dofs = family.owner.size, 6 * bodies
    every = np.zeros((4, own_dofs + 6 * members))
    blended = np.zeros((own_dofs, own_dofs)) if members else np.zeros((0, 0))
    return Blend(np.zeros(members), np.zeros(members), blended, np.zeros(own_dofs), *every)


def steady_filters(family: DraughtFamilies, coordinates: np.ndarray) -> np.ndarray:
    """Filters (2 nf,) of bodies that have long been at their ``coordinates`` (6 nb,)."""
    return np.repeat(coordinates[6 * family.body + 2], DRAUGHT_STATES)


@root
def blend_draughts(y, p, added_mass, out):
    """Fill roots and ``added_mass`` for the filters ``y`` (2 nf,); the argument ``added_mass`` (6
    nb, 6 nb) covers all other bodies."""
    for i in range(added_mass.shape[0]):
        assign(out.added_mass[i], added_mass[i])
    clear(out.root)
    clear(out.change)
    for f in range(p.body.size):
        z_1, z_2 = y[DRAUGHT_STATES * f], y[DRAUGHT_STATES * f + 1]
        _set_roots(
            p.rest[f] - z_2, DRAUGHT_CUTOFF * (z_2 - z_1), p.first[f], p.first[f + 1] - 1, p, out
        )
        at = 6 * p.body[f]
        for i in range(6):
            for j in range(6):
                entry = 0.0
                for k in range(p.first[f], p.first[f + 1]):
                    entry += out.root[k] ** 2 * p.added_mass[k, i, j]
                out.added_mass[at + i, at + j] = entry


@kernel
def _set_roots(draught, rate, first, last, p, out):
    """Roots of the members ``first`` to ``last`` at a ``draught``, and their rates."""
    k = first
    while k < last - 1 and draught > p.draught[k + 1]:
        k += 1
    span = p.draught[k + 1] - p.draught[k]
    part = min(max((draught - p.draught[k]) / span, 0.0), 1.0)
    angle = 0.5 * pi * part
    turning = 0.5 * pi * rate / span if 0.0 < part < 1.0 else 0.0
    out.root[k], out.root[k + 1] = cos(angle), sin(angle)
    out.change[k], out.change[k + 1] = -turning * sin(angle), turning * cos(angle)


@kernel
def velocities_of_members(u, p, out):
    """Velocities of bodies and members, r u, from those of the bodies (6 nb,); all forces are
    cleared."""
    assign(out.velocity, u)
    clear(out.force)
    clear(out.first)
    clear(out.second)
    for k in range(p.owner.size):
        for j in range(6):
            out.velocity[u.size + 6 * k + j] = out.root[k] * u[6 * p.owner[k] + j]


@kernel
def add_forces_of_members(every, squared, p, roots, force):
    """Add the forces on bodies and members, ``every`` (6 (nb + nm),), to ``force`` (6 nb,). A
    member's force is multiplied by its root, or by the square of it."""
    for i in range(force.size):
        force[i] += every[i]
    for k in range(p.owner.size):
        weight = roots[k] * roots[k] if squared else roots[k]
        for j in range(6):
            force[6 * p.owner[k] + j] += weight * every[force.size + 6 * k + j]


@kernel
def added_mass_rate_force(u, p, out):
    """Fill ``out.lag`` with A' u / 2, A' = sum 2 r r' A_i."""
    clear(out.lag)
    for k in range(p.owner.size):
        at, weight = 6 * p.owner[k], out.root[k] * out.change[k]
        for i in range(6 if weight != 0.0 else 0):
            for j in range(6):
                out.lag[at + i] += weight * p.added_mass[k, i, j] * u[at + j]


@kernel
def draught_rates(y, coordinates, p, dy):
    """Rates ``dy`` of the filters ``y`` (2 nf,)."""
    for f in range(p.body.size):
        z_1, z_2 = y[DRAUGHT_STATES * f], y[DRAUGHT_STATES * f + 1]
        dy[DRAUGHT_STATES * f] = DRAUGHT_CUTOFF * (coordinates[6 * p.body[f] + 2] - z_1)
        dy[DRAUGHT_STATES * f + 1] = DRAUGHT_CUTOFF * (z_1 - z_2)
