"""Section 3.3: first-order waves at 0 deg, friction slopes, pressed into the fenders to 7000 s.

The lift at the end is lost. So it is varied: 0.5 to 1.1 of 132,105 kN, which lifts the barge by the
gap of 1 m, and 264,210 kN (``crawl.yaml``), the thesis' number for 1.5 m. The lift at 2000 s is
132,105 kN, or that at the end where it is less. Exact runs are rk4 at 0.1 s with steps cut at
events. Others are rk2 at 0.1 s without events, beyond the limit of that method. They resemble the
thesis' program, which also takes the smaller of mu N and b |v| at every evaluation. The last
variant has the contact node of chapter 5 in place of the slope, with 0.2 for both frictions.
"""

from __future__ import annotations

import xarray as xr

from cases.reverse_float_over.thesis.runs import Settings, mean_force, run_case, surge

TABLE = "Section 3.3: pressed into the fenders from 2000 to 7000 s"

GAP_CLOSED = 132_105e3  # N
SHIPPED = 2.0  # of that: the lift of crawl.yaml at the end
LIFTS = (0.5, 0.7, 0.9, 1.0, 1.1, SHIPPED)
START, END = 2000.0, 7000.0  # s

EXACT: Settings = {"solver.method": "rk4", "solver.step": 0.1, "solver.unstable": "error"}
WITHOUT_EVENTS: Settings = {
    "solver.method": "rk2",
    "solver.step": 0.1,
    "solver.events": False,
    "solver.unstable": "warn",
}
NODE: Settings = {
    "solver.method": "rk4",
    "solver.step": 0.1,
    "forces.interface.friction": {
        "law": "stick_slip",
        "static": 0.2,
        "kinetic": 0.2,
        "stiffness": 5.6e8,
        "damping": 3.3e7,
        "total": True,
    },
}
UNEXACT = "rk2 at 0.1 s without events"


def _lift(end: float) -> Settings:
    before = min(end, 1.0)
    return {"forces.deballast.force.heave": [0.0, before * GAP_CLOSED, end * GAP_CLOSED]}


VARIANTS: dict[str, Settings] = {
    **{f"exact, lift {lift:g}": {**_lift(lift), **EXACT} for lift in LIFTS},
    **{f"{UNEXACT}, lift {lift:g}": {**_lift(lift), **WITHOUT_EVENTS} for lift in LIFTS[2:]},
    f"contact node, lift {SHIPPED:g}": {**_lift(SHIPPED), **NODE},
}


def figures(variant: str, seed: int) -> dict[str, float]:
    """Surge [m] and mean forces in surge from 2000 to 7000 s [kN]. The mean of the fender force is
    by its impulse, and as a mean over samples every 0.5 s."""
    run = run_case("numerical_oscillation/crawl.yaml", seed, VARIANTS[variant])
    pressed = run.sel(time=slice(START, END))
    return {
        "surge_2000": float(surge(run).sel(time=START)),
        "surge_7000": float(surge(run).sel(time=END)),
        "surge_mean": float(surge(pressed).mean()),
        "surge_least": float(surge(pressed).min()),
        "surge_most": float(surge(pressed).max()),
        "waves": mean_force(run, "wave_first_order", START, END),
        "mooring": mean_force(run, "mooring", START, END),
        "fenders": mean_force(run, "interface", START, END),
        "fenders_sampled": _sampled(pressed),
        "contact": float((run.fender_normal_force > 0.0).any("fender").mean()),
    }


def _sampled(run: xr.Dataset) -> float:
    """Mean over the samples of the force of the fenders in surge [kN]."""
    return float(run.force_interface.isel(body=0).sel(dof="surge").mean()) / 1e3
