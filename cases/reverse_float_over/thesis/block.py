"""Section 4.2: the block on a floor with friction slopes, and with the exact law.

``explicit`` is a plain rk2 at 0.1 s that takes the smaller of mu N and b |v| at every evaluation,
as aNySIM does. It uses nothing of hydrosim.
"""

from __future__ import annotations

import numpy as np

import hydrosim as hs
from cases.reverse_float_over.thesis.runs import CASES, Settings, surge

TABLE = "Section 4.2: the block with friction slopes"
WITHOUT_SEA = True

HELD_UNTIL = 8.0  # s: the push exceeds friction at 8.33 s
STEP = 0.1  # s
MASS, PUSH, PERIOD, HOLDS, STEEPEST = 1e8, 4e5, 100.0, 2e5, 1e10  # kg, N, s, N, N s/m
CASE_OF = {"exact": "exact", **{f"slope {b}": f"slope_{b}" for b in ("1e4", "1e6", "1e8", "1e10")}}
EXPLICIT = "slope 1e10, explicit"
VARIANTS: dict[str, Settings] = {name: {"output.step": STEP} for name in (*CASE_OF, EXPLICIT)}


def figures(variant: str, seed: int) -> dict[str, float]:
    """How far the block moves before the push exceeds friction [m], and the share of steps until
    then in which its acceleration changes sign. There is no sea, so ``seed`` does not matter."""
    position, velocity = _explicit() if variant == EXPLICIT else _simulated(variant)
    gained = np.diff(velocity)
    return {
        "creep": float(np.abs(position).max()),
        "reversals": float(np.mean(gained[1:] * gained[:-1] < 0.0)),
    }


def _simulated(variant: str) -> tuple[np.ndarray, np.ndarray]:
    """Position [m] and velocity [m/s] of a case until the push exceeds friction."""
    case = CASES / "friction_block" / f"{CASE_OF[variant]}.yaml"
    run = hs.simulate(hs.load_case(case, dict(VARIANTS[variant])))
    held = run.sel(time=slice(0.0, HELD_UNTIL))
    return surge(held).values, surge(held, "velocity").values


def _explicit() -> tuple[np.ndarray, np.ndarray]:
    """The same by rk2 (midpoint) with the steepest slope."""
    states = [np.zeros(2)]
    for time in np.arange(0.0, HELD_UNTIL, STEP):
        middle = states[-1] + STEP / 2 * _rate(time, states[-1])
        states.append(states[-1] + STEP * _rate(time + STEP / 2, middle))
    position, velocity = np.transpose(states)
    return position, velocity


def _rate(time: float, state: np.ndarray) -> np.ndarray:
    """Velocity [m/s] and acceleration [m/s^2]."""
    push = PUSH * np.sin(2.0 * np.pi * time / PERIOD)
    friction = np.clip(STEEPEST * state[1], -HOLDS, HOLDS)
    return np.array([state[1], (push - friction) / MASS])
