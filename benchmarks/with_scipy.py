"""The same scene by scipy's `solve_ivp`: hydrosim's right hand side, called from Python, and the
ends of contact modes as events that stop it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from hydrosim.dynamics import Model, new_work, rhs
from hydrosim.forces import FENDER
from hydrosim.forces.contact.fender import STATES
from hydrosim.forces.contact.transitions import MARGINS, find_headings, margins, switch
from hydrosim.rigid import place_bodies
from hydrosim.stepper import State

ENDED = 1e-2  # N: a margin this near to zero has ended its mode; forces here are of 1e6 N
SHORTEST = 1e-9  # s: of a piece between two events
TINY = 1e-9  # of any state, all of which are far larger where they are not zero


class Solution(NamedTuple):
    """Displacements and angles (nt, n) at the times asked for, the largest size (ny,) of every
    state, the numbers of evaluations and of events."""

    motions: np.ndarray
    largest: np.ndarray
    evaluations: int
    events: int


class Contact:
    """The contact points of a model: ``modes`` (nf, 2), and what ends them."""

    def __init__(self, model: Model, modes: np.ndarray) -> None:
        self.modes, self.bodies, self.points = modes.copy(), model.bodies, model.elements[FENDER]
        self.motion, self.margins = new_work(model).motion, np.zeros(MARGINS * len(modes))
        self.headings = np.zeros((len(modes), 2))

    def measure(self, t: float, y: np.ndarray) -> np.ndarray:
        """Margins (3 nf,) of the modes at t, ``y``; slip is measured along its own direction."""
        n = self.bodies.active.size
        place_bodies(y[:n], y[n : 2 * n], self.bodies, self.motion)
        points, headings = self.points, self.headings
        find_headings(t, y, self.modes, self.motion, self.bodies, points, headings)
        none = np.zeros_like(headings)  # reactions of rigid friction
        margins(t, y, self.modes, self.motion, self.bodies, points, headings, none, self.margins)
        return self.margins

    def switch(self, t: float, y: np.ndarray) -> None:
        """Switch all modes that have ended at t, ``y``."""
        for i, left in enumerate(self.measure(t, y).reshape(-1, MARGINS)):
            if left.min() < ENDED:
                which = int(left.argmin())
                none = np.zeros((len(self.modes), 2))
                switch(i, which, 1.0, t, y, self.modes, self.motion, self.bodies, none, self.points)


def solve(
    model: Model,
    state: State,
    times: np.ndarray,
    breakpoints: Sequence[float],
    relative: float,
    size: np.ndarray,
) -> Solution:
    """RK45 from ``state`` over ``times`` (nt,), begun anew at breakpoints and events. The error per
    step is kept below ``relative`` of ``size`` (ny,) or of the value, whichever is larger."""
    contact, y, n = Contact(model, state.modes), state.y.copy(), model.bodies.active.size
    settings = {"rtol": relative, "atol": relative * size, "events": _end_of_mode(contact)}
    derivative = _derivative(model, state, contact)
    t, kept, largest, evaluations, events = times[0], [y[None, :n]], np.abs(y), 0, 0
    for stop in (*breakpoints, times[-1]):
        while t < stop - SHORTEST:
            piece = solve_ivp(derivative, (t, stop), y, "RK45", dense_output=True, **settings)
            inside = times[(times > t) & (times <= piece.t[-1])]
            if inside.size:
                kept.append(piece.sol(inside)[:n].T)
            t, y = piece.t[-1], piece.y[:, -1].copy()
            largest = np.maximum(largest, np.abs(piece.y).max(axis=1))
            evaluations += piece.nfev
            if piece.status == 1:
                contact.switch(t, y)
                events += 1
    return Solution(np.concatenate(kept), largest, evaluations, events)


def free_of_integrals(model: Model, size: np.ndarray) -> np.ndarray:
    """``size`` (ny,), not zero, and infinite for slip distances and energies: they act on nothing,
    and must not cost steps that hydrosim does not take for them."""
    fenders, free = model.elements[FENDER], np.maximum(size, TINY)
    points = free[fenders.state : model.energy].reshape(-1, STATES)
    points[:, 2:] = np.inf
    free[model.energy :] = np.inf
    return free


def _derivative(
    model: Model, state: State, contact: Contact
) -> Callable[[float, np.ndarray], np.ndarray]:
    work, rate = new_work(model), np.zeros(model.size)

    def derivative(t: float, y: np.ndarray) -> np.ndarray:
        rhs(t, y, contact.modes, state.history, model, work, rate)
        return rate.copy()

    return derivative


def _end_of_mode(contact: Contact) -> Any:
    def smallest_margin(t: float, y: np.ndarray) -> float:
        return float(contact.measure(t, y).min())

    smallest_margin.terminal = True  # type: ignore[attr-defined]
    smallest_margin.direction = -1.0  # type: ignore[attr-defined]
    return smallest_margin
