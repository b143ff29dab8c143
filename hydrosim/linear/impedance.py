"""What a change of a radiation force does to motions, without a run: Z v = F for harmonic motions.

Z(s) = s (M + A_inf) + D + C / s + K^(s), s = i w, all other forces made linear at the start. A
force dZ v more changes v by -Z^-1 dZ v. With coordinates scaled by the roots of their inertias, so
that metres and radians compare, the spectral norm of Z^-1 dZ is the largest change that is possible
at a frequency, relative to the motion there: at resonance, dZ over the damping. In a run of T s,
which knows no resonance sharper than 1/T, s = 1/T + i w. Only motions that constraints allow count.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.linear.coordinates import STEP, inertia
from hydrosim.linear.freedom import find_constraint_rows, freedom_of
from hydrosim.radiation import convolution_model
from hydrosim.stepping.dynamics import Model, jacobian, new_work
from hydrosim.stepping.state import State


class Change(NamedTuple):
    """The largest relative change of motion, the frequency ``w`` [rad/s] that it is at, and the
    coordinate (among 6 nb) that it changes most."""

    size: float
    w: float
    coordinate: int


def impedance(
    s: np.ndarray, memory: np.ndarray, model: Model, state: State, time: float = 0.0
) -> np.ndarray:
    """Z (nw, n, n) of the free coordinates at ``s`` (nw,) [1/s], with K^ ``memory``
    (nw, 6 nb, 6 nb) in place of the model's; contacts as they are in ``state`` at ``time`` [s].
    Forces of constraints are in Z, too, but take no part in motions that are allowed."""
    model = model._replace(convolution=convolution_model(1.0, np.zeros((2, 0, 0))))
    n = model.bodies.active.size
    active = model.bodies.active
    work = new_work(model)
    own = np.arange(2 * n)
    scratch = np.zeros((3, model.size))
    J = np.zeros((2 * n, 2 * n))
    y = state.y
    jacobian(time, y, state.modes, state.history, model, work, own, STEP, scratch, J)
    M = inertia(model, y)
    s = s[:, None, None]
    return np.asarray(
        s * M - M @ J[n:, n:] - M @ J[n:, :n] / s + memory[:, active[:, None], active]
    )


def largest_change(
    w: np.ndarray, Z: np.ndarray, dZ: np.ndarray, model: Model, state: State
) -> Change:
    """What ``dZ`` (nw, 6 nb, 6 nb) changes at most, ``Z`` (nw, n, n) being the `impedance`."""
    active = model.bodies.active
    M = inertia(model, state.y)
    root = np.sqrt(np.diag(M))
    free = freedom_of(find_constraint_rows(model, state.y, state.modes), M)
    # N is orthonormal in coordinates that are scaled by these roots
    more = free.project_matrix(dZ[:, active[:, None], active])
    changed = np.linalg.solve(free.project_matrix(Z), more)
    relative = free.expand(changed) * root[:, None]
    if free.unconstrained:
        relative = relative / root
    size = np.linalg.norm(relative, 2, axis=(1, 2))
    k = int(size.argmax())
    left = np.linalg.svd(relative[k])[0][:, 0]
    return Change(float(size[k]), float(w[k]), int(active[np.abs(left).argmax()]))


def at_frequencies(w: np.ndarray, known: np.ndarray, values: np.ndarray) -> np.ndarray:
    """``values`` (nk, n, n) at the frequencies ``w`` (nw,): linear between the ``known`` (nk,),
    constant beyond."""
    k = np.clip(np.searchsorted(known, w), 1, known.size - 1)
    x = np.clip((w - known[k - 1]) / (known[k] - known[k - 1]), 0.0, 1.0)[:, None, None]
    return np.asarray((1.0 - x) * values[k - 1] + x * values[k])
