"""Motions that change their mode at events, integrated apart from hydrosim."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

Event = tuple[Callable[..., float], Callable[[float, np.ndarray], str]]
"""A function that falls to zero where a mode ends, and the mode that follows."""


def integrate(
    rates: Callable[..., Sequence[float]],
    ends: Callable[[str], Sequence[Event]],
    mode: str,
    y: Sequence[float],
    times: np.ndarray,
) -> tuple[np.ndarray, list[str]]:
    """States (nt, n) at ``times`` of y' = rates(t, y, mode), and the modes in their order."""
    t = float(times[0])
    state = np.array(y, float)
    found = np.zeros((times.size, state.size))
    found[0] = state
    modes = [mode]
    while t < times[-1] - 1e-12:
        watched = [*ends(mode)]
        for function, _ in watched:
            function.terminal = True  # type: ignore[attr-defined]
            function.direction = -1  # type: ignore[attr-defined]
        settings: Mapping[str, Any] = {"rtol": 1e-13, "atol": 1e-12, "max_step": 0.05}
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
        state = piece.y[:, -1]
        if piece.status != 1:
            break
        which = next(k for k, at in enumerate(piece.t_events) if at.size)
        mode = watched[which][1](t, state)
        modes.append(mode)
    return found, modes
