"""Motions that change their mode at events, integrated apart from hydrosim."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

Event = tuple[Callable[..., float], Any]
"""A function (t, y, mode) that falls to zero where a mode ends, and the mode that follows: itself,
or a function of (t, y), which may change y."""


class ModalMotion(NamedTuple):
    """States (nt, n), the modes in their order, and the times [s] between them."""

    states: np.ndarray
    modes: list[Any]
    events: list[float]

    def modes_at(self, times: np.ndarray) -> np.ndarray:
        return np.array(self.modes)[np.searchsorted(self.events, times, side="right")]


def integrate(
    rates: Callable[..., Sequence[float]],
    ends: Callable[[Any], Sequence[Event]],
    mode: Any,
    y: Sequence[float],
    times: np.ndarray,
    **settings: float,
) -> ModalMotion:
    """The motion y' = rates(t, y, mode) at ``times`` by DOP853."""
    t = float(times[0])
    state = np.array(y, float)
    found = np.zeros((times.size, state.size))
    found[0] = state
    modes, events = [mode], []
    settings = {"rtol": 1e-13, "atol": 1e-12, "max_step": 0.05, **settings}
    while t < times[-1] - 1e-12:
        watched = [*ends(mode)]
        for function, _ in watched:
            function.terminal = True  # type: ignore[attr-defined]
            function.direction = -1  # type: ignore[attr-defined]
        piece = solve_ivp(
            *(rates, (t, float(times[-1])), state, "DOP853"),
            args=(mode,),
            events=[function for function, _ in watched],
            dense_output=True,
            **settings,
        )
        inside = (times > t) & (times <= piece.t[-1])
        if inside.any():
            found[inside] = piece.sol(times[inside]).T
        t = piece.t[-1]
        state = piece.y[:, -1].copy()
        if piece.status != 1:
            break
        which = next(k for k, at in enumerate(piece.t_events) if at.size)
        follows = watched[which][1]
        mode = follows(t, state) if callable(follows) else follows
        modes.append(mode)
        events.append(t)
    return ModalMotion(found, modes, events)
