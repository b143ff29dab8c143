"""Slip damping C3 that is a step behind: does it move the barge towards +x, as the thesis says?

With C3 of 1e8 and 1e10 N s/m the thesis sees positive motion in initial contact and blames "high
peaks in the force balance". A code that takes C3 times the velocity of the last step would have
peaks. So the one-dimensional model is integrated here as a plain code would: midpoint rule, 0.1 s,
modes looked at once a stage, no events. C3 enters in five ways (T, d, v2 as in
`plasterk`, v2' is the velocity of the node a step ago):

    now                 v2 = (T - d mu N) / (C2 + C3), nothing is behind: for comparison
    node                v2 = (T - d (mu N + C3 |v2'|)) / C2, an iteration with factor -C3/C2
    node, no reversal   the same, but zero where it is against d
    mass                v2 = (T - d mu N) / C2, the mass feels d mu N + C3 v2
    mass, behind        the same, the mass feels d mu N + C3 v2'
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import product
from math import copysign, nan

import numpy as np
from scipy.interpolate import CubicSpline

from cases.reverse_float_over.thesis.one_dimension import (
    C1,
    C2,
    K1,
    K2,
    MASS,
    PER_HALF_METRE,
    PLACES,
    VERTICAL,
    first_stage,
    recorded,
)

TABLE = "One-dimensional model: C3 a step behind"
STEP = 0.1  # s
STATIC, KINETIC = 0.2, 0.1
FAR = 1e4  # m: the run has failed
CONTACT = (600.0, 1000.0)  # s, of initial contact

Slip = tuple[float, float]
"""v2 and the force on the mass."""


def _now(T: float, d: float, N: float, old: float, C3: float) -> Slip:
    v2 = (T - d * KINETIC * N) / (C2 + C3)
    return v2, T - C2 * v2


def _node(T: float, d: float, N: float, old: float, C3: float) -> Slip:
    v2 = (T - d * (KINETIC * N + C3 * abs(old))) / C2
    return v2, T - C2 * v2


def _no_reversal(T: float, d: float, N: float, old: float, C3: float) -> Slip:
    v2, force = _node(T, d, N, old, C3)
    return (v2, force) if v2 * d > 0.0 else (0.0, T)


def _mass(T: float, d: float, N: float, old: float, C3: float) -> Slip:
    v2 = (T - d * KINETIC * N) / C2
    return v2, d * KINETIC * N + C3 * v2


def _mass_behind(T: float, d: float, N: float, old: float, C3: float) -> Slip:
    v2 = (T - d * KINETIC * N) / C2
    return v2, d * KINETIC * N + C3 * old


WAYS: Mapping[str, Callable[[float, float, float, float, float], Slip]] = {
    "now": _now,
    "node": _node,
    "node, no reversal": _no_reversal,
    "mass": _mass,
    "mass, behind": _mass_behind,
}
VARIANTS: Mapping[str, Mapping[str, object]] = {
    f"{at}, C3 {C3:.0e}, {way}": {"lever": lever, "C3": C3, "way": way}
    for (at, lever), C3, way in product(PLACES.items(), (1e8, 1e10), WAYS)
}


def figures(variant: str, seed: int) -> dict[str, float]:
    """Of one run: surge at the end and the way gone in initial contact [m], and whether each is
    towards +x (1 or 0), not a number where the run fails before. The time at which it fails [s],
    not a number where it does not."""
    settings = VARIANTS[variant]
    surge = integrate(seed, **settings)  # type: ignore[arg-type]
    start, end = (surge[round(t / STEP)] for t in CONTACT)
    known = np.isfinite(surge)
    fails = nan if known.all() else STEP * float(known.argmin())
    return {
        "surge_2000": float(surge[-1]),
        "ends_ahead": _is_ahead(surge[-1]),
        "initial_contact": float(end - start),
        "goes_ahead": _is_ahead(end - start),
        "fails_at": fails,
    }


def _is_ahead(way: float) -> float:
    """1 towards +x, 0 towards -x, not a number of a run that has failed."""
    return float(way > 0.0) if np.isfinite(way) else nan


def integrate(seed: int, lever: float, C3: float, way: str) -> np.ndarray:
    """Surge [m] at every step; not a number from the step on at which it is beyond all bounds."""
    time, push, compression = recorded(first_stage(seed), lever)
    stages = np.arange(0.0, time[-1] + STEP / 4, STEP / 2)
    F = CubicSpline(time, push)(stages).tolist()
    N = (VERTICAL * PER_HALF_METRE * CubicSpline(time, compression)(stages)).tolist()
    surge = np.full(stages.size // 2 + 1, nan)
    y, v2, slips = (0.0, 0.0, 0.0), 0.0, False
    for i in range(surge.size - 1):
        surge[i] = y[0]
        first, slips = _rates(y, F[2 * i], N[2 * i], v2, slips, C3, way)
        middle = _moved(y, first, STEP / 2)
        second, _ = _rates(middle, F[2 * i + 1], N[2 * i + 1], v2, slips, C3, way)
        y, v2 = _moved(y, second, STEP), first[2]
        if not abs(y[0]) < FAR:
            return surge
    surge[-1] = y[0]
    return surge


Three = tuple[float, float, float]


def _rates(
    y: Three, F: float, N: float, old: float, slips: bool, C3: float, way: str
) -> tuple[Three, bool]:
    """Rates of u1, v1, u2, and whether the node slips."""
    u1, v1, u2 = y
    T = K2 * (u1 - u2) + C2 * v1
    slips = N > 0.0 and abs(T) > (KINETIC if slips else STATIC) * N
    v2, force = 0.0, T
    if N <= 0.0:
        v2, force = T / C2, 0.0
    elif slips:
        v2, force = WAYS[way](T, copysign(1.0, T), N, old, C3)
    return (v1, (F - K1 * u1 - C1 * v1 - force) / MASS, v2), slips


def _moved(y: Three, rates: Three, step: float) -> Three:
    return (y[0] + step * rates[0], y[1] + step * rates[1], y[2] + step * rates[2])
