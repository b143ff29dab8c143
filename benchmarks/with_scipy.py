"""The same scene by scipy's `solve_ivp`: hydrosim's right hand side, called from Python, and the
ends of contact modes as events that stop it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from hydrosim.dynamics import Model, new_work, rhs
from hydrosim.forces import FENDER
from hydrosim.forces.contact.fender import MARGINS, margins, switch
from hydrosim.rigid import place_bodies
from hydrosim.run import State

ENDED = 1e-2  # N: a margin this near to zero has ended its mode; forces here are of 1e6 N
CEASED = 1e-9  # s: pieces shorter than this are not integrated


class Solution(NamedTuple):
    """Displacements and angles (nt, n) at the times asked for, the largest size of every state,
    the numbers of evaluations and of events."""

    motions: np.ndarray
    largest: np.ndarray
    evaluations: int
    events: int


def solve(
    model: Model,
    state: State,
    times: np.ndarray,
    breakpoints: np.ndarray,
    relative: float,
    absolute: np.ndarray | float,
) -> Solution:
    """RK45 from ``state`` over ``times`` (nt,), begun anew at breakpoints and events. Slip
    distances and energies, which act on nothing, have no say in the step."""
    y, modes, n = state.y.copy(), state.modes.copy(), model.bodies.active.size
    contact = Contact(model, modes)
    rate, work, t = np.zeros(model.size), new_work(model), times[0]
    kept, largest, evaluations, events = [y[None, :n]], np.abs(y), 0, 0

    def derivative(t: float, y: np.ndarray) -> np.ndarray:
        rhs(t, y, modes, state.history, model, work, rate)
        return rate.copy()

    for stop in (*breakpoints, times[-1]):
        while t < stop - CEASED:
            piece = solve_ivp(
                *(derivative, (t, stop), y, "RK45"),
                events=contact.smallest_margin,
                rtol=relative,
                atol=absolute,
            )
            grid = times[(times > t) & (times <= piece.t[-1])]
            kept.append(_at(grid, piece, n))
            t, y = piece.t[-1], piece.y[:, -1].copy()
            largest = np.maximum(largest, np.abs(piece.y).max(axis=1))
            evaluations += piece.nfev
            if piece.status == 1:
                contact.switch(y)
                events += 1
    return Solution(np.concatenate(kept), largest, evaluations, events)
