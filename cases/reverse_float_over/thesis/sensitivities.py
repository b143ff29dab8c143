"""The five sensitivities of the thesis (section 6.4) in six degrees of freedom."""

from __future__ import annotations

from cases.reverse_float_over.thesis.runs import (
    BASE,
    FRICTION,
    Settings,
    base_figures,
    run_case,
    surge,
)

TABLE = "Six degrees of freedom: the five sensitivities"

K2, C2 = 5.6e8, 3.3e7  # of the base case [N/m, N s/m]; C2 keeps 5 % of critical
LIFTED, HOURLY = 119_900e3, 20_000 * 9810.0  # N at 500 s, and in an hour
PER_HALF_METRE = 2.0 * 9806.65  # N/m of a tonne-force per 0.5 m

SLIP_DAMPING: dict[str, Settings] = {
    f"C3 {c:.0e}": {f"{FRICTION}.slip_damping": c} for c in (0.0, 1e6, 1e8, 1e10)
}
STIFFNESS: dict[str, Settings] = {
    f"K2 {k:.1e}": {f"{FRICTION}.stiffness": k, f"{FRICTION}.damping": C2 * (k / K2) ** 0.5}
    for k in (5.6e6, 5.6e7, 5.6e8)
}
COEFFICIENTS: dict[str, Settings] = {
    f"mu {s}/{k}": {f"{FRICTION}.static": s, f"{FRICTION}.kinetic": k}
    for s, k in ((0.7, 0.4), (0.4, 0.2), (0.2, 0.1), (0.2, 0.04))
}
DEBALLASTING: dict[str, Settings] = {
    f"{rate} t/h": {"forces.deballast.force.heave": [0.0, LIFTED, LIFTED + rate * HOURLY / 20_000]}
    for rate in (10_000, 20_000, 50_000)
}
VERTICAL: dict[str, Settings] = {
    f"K_vert {k} t per 0.5 m": {"forces.interface.normal.stiffness": k * PER_HALF_METRE}
    for k in (10_000, 20_000, 40_000)
}
BASE_CASE = "base case"
UNTIL_STUCK: Settings = {"duration": 3500.0}
"""Slow deballasting has not pressed the barge enough to stick at 2000 s."""
AS_BASE = {"C3 1e+06", "K2 5.6e+08", "mu 0.2/0.1", "20000 t/h", "K_vert 20000 t per 0.5 m"}
"""Values that are those of the base case, which is run once."""

VARIED = SLIP_DAMPING | STIFFNESS | COEFFICIENTS | DEBALLASTING | VERTICAL
VARIANTS: dict[str, Settings] = {
    BASE_CASE: {},
    **{name: settings for name, settings in VARIED.items() if name not in AS_BASE},
    "10000 t/h, to 3500 s": {**DEBALLASTING["10000 t/h"], **UNTIL_STUCK},
}


def figures(variant: str, seed: int) -> dict[str, float]:
    """Figures of one run, and surge at its end [m]."""
    run = run_case(BASE, seed, VARIANTS[variant])
    return {**base_figures(run), "surge_end": float(surge(run)[-1])}
