"""Section 3.2: lifted 1.5 m with and without friction, and pressed from rubber to steel.

The first two variants are lifted as in the thesis, waves at 0 deg, to 3000 s. The last two are
``base.yaml`` and ``fine_step.yaml`` of the numerical oscillation.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from cases.reverse_float_over.thesis.runs import Settings, run_case, surge

TABLE = "Section 3.2: lifted 1.5 m, and steel on steel"

AHEAD: Settings = {"environment.waves.heading": 0.0, "duration": 3000.0}
STEADY: Settings = {"solver.method": "rk4", "solver.step": 0.1, "solver.unstable": "error"}
LIFTED_FROM, ON_STEEL_FROM = 2000.0, 4200.0  # s
FOUND = 0.05  # m: the new position is found where surge stays this near to its last mean
RISES = 1000.0  # s

CASES: dict[str, str] = {
    "no friction, lifted 1.5 m": "no_friction",
    "friction, lifted 1.5 m": "base",
    "rk2 at 0.1 s": "base",
    "rk2 at 0.01 s": "fine_step",
}
VARIANTS: dict[str, Settings] = {
    "no friction, lifted 1.5 m": {**AHEAD, **STEADY},
    "friction, lifted 1.5 m": {**AHEAD, **STEADY},
    "rk2 at 0.1 s": {},
    "rk2 at 0.01 s": {},
}


def figures(variant: str, seed: int) -> dict[str, float]:
    """Surge while lifted [m], how long after the first contact it comes to rest [s], and the heave
    velocity on steel [m/s], which is not a number where no steel is reached."""
    run = run_case(f"numerical_oscillation/{CASES[variant]}.yaml", seed, VARIANTS[variant])
    lifted = surge(run).sel(time=slice(LIFTED_FROM, 3000.0))
    touches = run.time.values[(run.fender_normal_force > 0.0).any("fender").values]
    return {
        "lifted_mean": float(lifted.mean()),
        "lifted_least": float(lifted.min()),
        "lifted_most": float(lifted.max()),
        "found_after": _found(run) - float(touches[0]),
        "heave_velocity_on_steel": _heave_velocity(run.sel(time=slice(ON_STEEL_FROM, None))),
    }


def _found(run: xr.Dataset) -> float:
    """Time [s] from which surge stays near its mean while lifted."""
    part = surge(run).sel(time=slice(RISES, 3000.0))
    last = float(part.sel(time=slice(LIFTED_FROM, None)).mean())
    away = part.time.values[np.abs(part.values - last) > FOUND]
    return float(away[-1]) if away.size else RISES


def _heave_velocity(run: xr.Dataset) -> float:
    """Root mean square of the heave velocity [m/s]."""
    heave = run.velocity.isel(body=0).sel(dof="heave")
    return float((heave**2).mean() ** 0.5)
