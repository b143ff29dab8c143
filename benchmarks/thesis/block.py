"""Section 4.2: the block on a floor with friction slopes, and with the exact law."""

from __future__ import annotations

import numpy as np

import hydrosim as hs
from benchmarks.thesis.runs import CASES, Settings, surge

TABLE = "Section 4.2: the block with friction slopes"
WITHOUT_SEA = True

HELD_UNTIL = 8.0  # s: the push exceeds friction at 8.33 s
EVERY_STEP: Settings = {"output.step": 0.1}
EXPLICIT: Settings = {
    "solver.method": "rk2",
    "solver.step": 0.1,
    "solver.events": False,
    "solver.unstable": "warn",
}
SLOPES = ("1e4", "1e6", "1e8", "1e10")
VARIANTS: dict[str, Settings] = {
    "exact": EVERY_STEP,
    **{f"slope_{b}": EVERY_STEP for b in SLOPES},
    "slope_1e10, explicit": {**EVERY_STEP, **EXPLICIT},
}


def figures(variant: str, seed: int) -> dict[str, float]:
    """How far the block is before the push exceeds friction [m], and the share of steps until then
    in which the acceleration changes sign. There is no sea, so ``seed`` does not matter."""
    case = CASES / "friction_block" / f"{variant.partition(',')[0]}.yaml"
    run = hs.simulate(hs.load_case(case, dict(VARIANTS[variant])))
    held = run.sel(time=slice(0.0, HELD_UNTIL))
    gained = np.diff(surge(held, "velocity").values)
    return {
        "creep": float(np.abs(surge(held)).max()),
        "reversals": float(np.mean(gained[1:] * gained[:-1] < 0.0)),
    }
