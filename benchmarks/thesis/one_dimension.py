"""The thesis' one-dimensional model: where on the barge its compression is taken, friction, K2, C3.

The thesis exports "the fender compression" of four fenders at x = +-20 m, without saying of which.
So here a run presses with the compression at x = 20, 0 or -20 m: that of the forward pair, the mean
of all four, that of the aft pair. Neither does it say whether the friction factors are of the total
normal force or of one fender's share. A choice that fits afterwards is a spread over what
is not stated, and no tuning.

Each run is made twice, by hydrosim and by the independent code of `benchmarks.thesis.plasterk`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import pairwise, product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
import xarray as xr

import hydrosim as hs
from benchmarks.report import ROOT
from benchmarks.thesis.plasterk import Model, solve

TABLE = "One-dimensional model: compression, friction, K2, C3"
FIRST_STAGE = ROOT / "cases" / "reverse_float_over" / "no_friction.yaml"
SECOND_STAGE = ROOT / "cases" / "one_dimensional" / "base.yaml"

MASS = 1.945e8  # kg, with added mass
K1 = 392.4e3  # N/m
C1 = 0.2 * 2.0 * np.sqrt(K1 * MASS)  # N s/m, 20 % of critical
VERTICAL = 40_000 * 9810.0  # N/m, 20 000 t per 0.5 m, all fenders
K2, C2, C3 = 5.6e8, 3.3e7, 1e6  # of the base case, N/m and N s/m
LEVERS = {"forward": 20.0, "mean": 0.0, "aft": -20.0, "aft at -30 m": -30.0}
FENDERS = 20.0  # m, fore and aft of the centre of gravity
PAIRS = [0, 1], [2, 3]  # forward and aft, among the fenders of the first stage
FRICTIONS = {
    f"{static}/{kinetic} of {name}": {"static": static, "kinetic": kinetic, "share": share}
    for static, kinetic in ((0.2, 0.1), (0.7, 0.4))
    for name, share in (("N", 1.0), ("N/4", 0.25))
}
NEAR = ("0.2/0.1 of N", "0.7/0.4 of N/4")
TIMES = (600.0, 1000.0, 1500.0, 2000.0)  # s; initial contact is from the first to the second
STUCK_FROM = 1500.0  # s: the thesis sees stick from here on
STICK = 1  # in fender_mode


def _variants() -> Iterator[tuple[str, dict[str, object]]]:
    """Each friction at each place; K2 and C3 with those two frictions whose runs end near the
    thesis' -1.20 m."""
    for at, friction in product(("forward", "mean", "aft"), FRICTIONS):
        yield f"{at}, {friction}", _settings(at, friction)
    for at, friction in product(("forward", "mean", "aft"), NEAR):
        for k in (5.6e6, 5.6e7):
            yield f"{at}, {friction}, K2 {k:.1e}", _settings(at, friction, stiffness=k)
        for c in (0.0, 1e8, 1e10):
            yield f"{at}, {friction}, C3 {c:.0e}", _settings(at, friction, slip_damping=c)
    for friction in NEAR:
        far = _settings("aft at -30 m", friction, slip_damping=1e10)
        yield f"aft at -30 m, {friction}, C3 1e+10", far


def _settings(
    at: str, friction: str, stiffness: float = K2, slip_damping: float = C3
) -> dict[str, object]:
    return {
        "lever": LEVERS[at],
        **FRICTIONS[friction],
        "stiffness": stiffness,
        "damping": C2 * (stiffness / K2) ** 0.5,
        "slip_damping": slip_damping,
    }


VARIANTS: Mapping[str, Mapping[str, object]] = dict(_variants())


class Statement(NamedTuple):
    """A ``figure`` of a seed rises along the variants ``rising`` and is ``above`` a value there."""

    figure: str
    rising: tuple[str, ...]
    above: float = -np.inf

    def holds(self, seed: Mapping[str, Mapping[str, float]]) -> bool:
        """Of the figures of a seed by their variants."""
        values = [seed[variant][self.figure] for variant in self.rising]
        return values[0] > self.above and all(a < b for a, b in pairwise(values))


def _statements() -> Iterator[tuple[str, Statement]]:
    """Rows 10 and 11 of the score card: what the thesis says of C3 and K2."""
    end, initial = "surge_2000", "initial_contact"
    for case in (f"{at}, {friction}" for at, friction in product(("forward", "mean", "aft"), NEAR)):
        soft, middle = f"{case}, K2 5.6e+06", f"{case}, K2 5.6e+07"
        yield f"{case}: K2, most at 5.6e7, least at 5.6e6", Statement(end, (middle, case, soft))
        yield f"{case}: K2, least at 5.6e6", Statement(end, (case, soft))
        yield f"{case}: K2, most at 5.6e7", Statement(end, (middle, case))
        yield f"{case}: C3, 1e6 less than 0", Statement(end, (f"{case}, C3 0e+00", case))
        for c in ("1e+08", "1e+10"):
            yield f"{case}: C3 {c}, +x", Statement(initial, (f"{case}, C3 {c}",), above=0.0)
            yield f"{case}: C3 {c}, end at +x", Statement(end, (f"{case}, C3 {c}",), above=0.0)
    for far in (variant for variant in VARIANTS if "-30 m" in variant):
        yield f"{far}, +x", Statement(initial, (far,), above=0.0)
        yield f"{far}, end at +x", Statement(end, (far,), above=0.0)


STATEMENTS: Mapping[str, Statement] = dict(_statements())


def figures(variant: str, seed: int) -> dict[str, float]:
    """Of one run: surge [m], the largest velocity while the node sticks after 1500 s [m/s], the
    share of stick then, and by how much the end of the independent code differs [m]."""
    settings = Settings(**VARIANTS[variant])  # type: ignore[arg-type]
    run = simulated(settings, seed)
    surge = {t: float(run.position.isel(body=0).sel(dof="surge", time=t)) for t in TIMES}
    late = run.isel(body=0, fender=0).sel(dof="surge", time=slice(STUCK_FROM, None))
    stuck = late.fender_mode == STICK
    end = float(independent(settings, seed)[-1, 0])
    return {
        **{f"surge_{t:g}": value for t, value in surge.items()},
        "initial_contact": surge[1000.0] - surge[600.0],
        "velocity_stuck": float(np.abs(late.velocity).where(stuck).max()),
        "stick_1500_2000": float(stuck.mean()),
        "independent_code": end - surge[2000.0],
    }


@dataclass(frozen=True)
class Settings:
    """``lever`` x [m] at which the compression is taken; ``share`` of the total normal force that
    friction has; the rest as in `hydrosim.forces.StickSlip`, in SI units."""

    lever: float
    static: float
    kinetic: float
    share: float
    stiffness: float
    damping: float
    slip_damping: float


def simulated(settings: Settings, seed: int, step: float = 0.1) -> xr.Dataset:
    """The run by hydrosim, with a fixed ``step`` [s]."""
    file = str(_first_stage(seed))
    friction, normal = "forces.interface.friction", "forces.interface.normal.prescribed"
    changes = {
        "forces.waves.force.surge": {"file": file, "column": "push"},
        normal: {
            "file": file,
            "column": f"compression.{settings.lever:g} m",
            "factor": f"{VERTICAL * settings.share} N/m",
        },
        f"{friction}.static": settings.static,
        f"{friction}.kinetic": settings.kinetic,
        f"{friction}.stiffness": settings.stiffness,
        f"{friction}.damping": settings.damping,
        f"{friction}.slip_damping": settings.slip_damping,
        "solver.step": step,
    }
    return hs.simulate(hs.load_case(SECOND_STAGE, changes))


def independent(settings: Settings, seed: int) -> np.ndarray:
    """u1, v1, u2 (n, 3) by the independent code, at the times of the first stage."""
    friction = (settings.static, settings.kinetic)
    contact = (settings.stiffness, settings.damping, settings.slip_damping)
    time, push, compression = recorded(seed, settings.lever)
    normal = settings.share * VERTICAL * compression
    return solve(Model(MASS, K1, C1, *contact, *friction), time, push, normal)[0]


def recorded(seed: int, lever: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time [s], wave force in surge [N] and compression [m] of the first stage."""
    series = xr.load_dataset(_first_stage(seed))
    compression = series.compression.sel(lever=f"{lever:g} m")
    return series.time.values, series.push.values, compression.values


@cache
def _first_stage(seed: int) -> Path:
    """A file with the wave force and the compressions of the barge without friction."""
    run = hs.simulate(hs.load_case(FIRST_STAGE, {"environment.waves.seed": seed}))
    orders = (run.force_wave_first_order, run.force_wave_second_order)
    push = sum(order.sel(body="barge", dof="surge", drop=True) for order in orders)
    forward, aft = (run.fender_compression.isel(fender=pair).mean("fender") for pair in PAIRS)
    compression = [(forward + aft) / 2 + x * (forward - aft) / 2 / FENDERS for x in LEVERS.values()]
    series = xr.Dataset(
        {
            "push": push.assign_attrs(units="N"),
            "compression": xr.concat(compression, "lever").assign_attrs(units="m"),
        }
    ).assign_coords(lever=[f"{x:g} m" for x in LEVERS.values()])
    path = Path(_folder().name) / f"{seed}.nc"
    series.to_netcdf(path)
    return path


@cache
def _folder() -> TemporaryDirectory[str]:
    return TemporaryDirectory(prefix="hydrosim-thesis-")
