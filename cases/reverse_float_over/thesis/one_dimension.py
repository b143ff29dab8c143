"""The thesis' one-dimensional model: where on the barge its compression is taken, friction, K2, C3.

The thesis exports "the fender compression" of four fenders at x = +-20 m, without saying of which.
So here a run presses with the compression at x = 20, 0 or -20 m: that of the forward pair, the mean
of all four, that of the aft pair. Neither does it say whether the friction factors are of the total
normal force or of one fender's share. A choice that fits afterwards is a spread over what
is not stated, and no tuning.

Each run is made twice, by hydrosim and by the independent code of `plasterk`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import xarray as xr

import hydrosim as hs
from benchmarks.report import ROOT
from cases.reverse_float_over.thesis.plasterk import Model, solve
from cases.reverse_float_over.thesis.statements import Statement

TABLE = "One-dimensional model: compression, friction, K2, C3"
FIRST_STAGE = ROOT / "cases" / "reverse_float_over" / "no_friction.yaml"
SECOND_STAGE = ROOT / "cases" / "one_dimensional" / "base.yaml"

MASS = 1.945e8  # kg, with added mass
K1 = 392.4e3  # N/m
C1 = 0.2 * 2.0 * np.sqrt(K1 * MASS)  # N s/m, 20 % of critical
VERTICAL = 20_000  # t per 0.5 m, all fenders
RATE = 20_000  # t/h that are deballasted
K2, C2, C3 = 5.6e8, 3.3e7, 1e6  # of the base case, N/m and N s/m
PER_HALF_METRE = 2.0 * 9810.0  # N/m
LIFTED = 119_900e3  # N at 500 s; 3600 s later RATE has added its weight
PLACES = {"forward": 20.0, "mean": 0.0, "aft": -20.0}  # m, of the pairs of fenders and between
LEVERS = (*PLACES.values(), -30.0)
PAIRS = [0, 1], [2, 3]  # forward and aft, among the fenders of the first stage
WEAK, STRONG = "0.2/0.1 of N", "0.7/0.4 of N"
FRICTIONS = {
    f"{static}/{kinetic} of {name}": {"static": static, "kinetic": kinetic, "share": share}
    for static, kinetic, name, share in (
        *((0.2, 0.1, "N", 1.0), (0.2, 0.1, "N/4", 0.25)),
        *((0.7, 0.4, "N", 1.0), (0.7, 0.4, "N/4", 0.25)),
        *((0.4, 0.2, "N", 1.0), (0.2, 0.04, "N", 1.0)),
    )
}
TIMES = (600.0, 1000.0, 1500.0, 2000.0)  # s; initial contact is from the first to the second
STUCK_FROM = 1500.0  # s: the thesis sees stick from here on
STICK = 1  # in fender_mode


def _variants() -> Iterator[tuple[str, dict[str, object]]]:
    """Every friction at each place; K2 and C3 with weak and strong friction; the rest with weak."""
    for (at, lever), friction in product(PLACES.items(), FRICTIONS):
        yield f"{at}, {friction}", _settings(lever, friction)
    for (at, lever), friction in product(PLACES.items(), (WEAK, STRONG)):
        for k in (5.6e6, 5.6e7):
            yield f"{at}, {friction}, K2 {k:.1e}", _settings(lever, friction, stiffness=k)
        for c in (0.0, 1e8, 1e10):
            yield f"{at}, {friction}, C3 {c:.0e}", _settings(lever, friction, slip_damping=c)
    for friction in (WEAK, STRONG):
        far = _settings(-30.0, friction, slip_damping=1e10)
        yield f"aft at -30 m, {friction}, C3 1e+10", far
    for at, lever in PLACES.items():
        for rate in (10_000, 50_000):
            yield f"{at}, {WEAK}, {rate} t/h", _settings(lever, WEAK, rate=rate)
        for vertical in (10_000, 40_000):
            name = f"{at}, {WEAK}, K_vert {vertical} t per 0.5 m"
            yield name, _settings(lever, WEAK, vertical=vertical)


def _settings(
    lever: float,
    friction: str,
    stiffness: float = K2,
    slip_damping: float = C3,
    rate: int = RATE,
    vertical: int = VERTICAL,
) -> dict[str, object]:
    return {
        "lever": lever,
        **FRICTIONS[friction],
        "stiffness": stiffness,
        "damping": C2 * (stiffness / K2) ** 0.5,
        "slip_damping": slip_damping,
        "rate": rate,
        "vertical": vertical,
    }


VARIANTS: Mapping[str, Mapping[str, object]] = dict(_variants())


def _statements() -> Iterator[tuple[str, Statement]]:
    """Rows 10 to 14 of the score card: what the thesis says of its sensitivities. Crawl is towards
    -x, so that less of it is a larger surge."""
    end, initial = "surge_2000", "initial_contact"
    for at, friction in product(PLACES, (WEAK, STRONG)):
        case = f"{at}, {friction}"
        soft, middle, undamped = (f"{case}, {x}" for x in ("K2 5.6e+06", "K2 5.6e+07", "C3 0e+00"))
        order = ((middle, case, soft),)
        yield f"{case}: K2 in the thesis' order in initial contact", Statement(initial, order)
        yield f"{case}: K2 in the thesis' order", Statement(end, order)
        yield f"{case}: K2, least crawl at 5.6e6", Statement(end, ((middle, soft), (case, soft)))
        yield f"{case}: K2, most crawl at 5.6e7", Statement(end, ((middle, case), (middle, soft)))
        yield f"{case}: C3, less crawl at 1e6 than at 0", Statement(end, ((undamped, case),))
    damped = (variant for variant in VARIANTS if "C3 1e+08" in variant or "C3 1e+10" in variant)
    for variant in damped:
        ahead = Statement(initial, ((variant,),), above=0.0)
        yield f"{variant}: towards +x in initial contact", ahead
        yield f"{variant}: end at +x", Statement(end, ((variant,),), above=0.0)
    for case in (f"{at}, {WEAK}" for at in PLACES):
        at = case.partition(",")[0]
        pairs = (f"{at}, {mu} of N" for mu in ("0.2/0.04", "0.2/0.1", "0.4/0.2", "0.7/0.4"))
        yield f"{at}: less stick with each lower mu", Statement("stick_1500_2000", (tuple(pairs),))
        slow, fast = f"{case}, 10000 t/h", f"{case}, 50000 t/h"
        yield f"{case}: less crawl with each faster rate", Statement(end, ((slow, case, fast),))
        soft, stiff = (f"{case}, K_vert {k} t per 0.5 m" for k in (10_000, 40_000))
        yield f"{case}: most crawl at K_vert 20000", Statement(end, ((case, soft), (case, stiff)))


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
    friction has; ``rate`` of deballasting [t/h]; ``vertical`` stiffness [t per 0.5 m]; the rest as
    in `hydrosim.elements.StickSlip`, in SI units."""

    lever: float
    static: float
    kinetic: float
    share: float
    stiffness: float
    damping: float
    slip_damping: float
    rate: int
    vertical: int

    @property
    def pressure(self) -> float:
        """Normal force for each metre of compression [N/m]."""
        return self.share * self.vertical * PER_HALF_METRE


def simulated(settings: Settings, seed: int, step: float = 0.1) -> xr.Dataset:
    """The run by hydrosim, with a fixed ``step`` [s]."""
    file = str(first_stage(seed, settings.rate, settings.vertical))
    friction, normal = "forces.interface.friction", "forces.interface.normal.prescribed"
    changes = {
        "forces.waves.force.surge": {"file": file, "column": "push"},
        normal: {
            "file": file,
            "column": f"compression.{settings.lever:g} m",
            "factor": f"{settings.pressure} N/m",
        },
        f"{friction}.static": settings.static,
        f"{friction}.kinetic": settings.kinetic,
        f"{friction}.stiffness": settings.stiffness,
        f"{friction}.damping": settings.damping,
        f"{friction}.slip_damping": settings.slip_damping,
        "solver.step": step,
    }
    return hs.simulate(hs.load_case(SECOND_STAGE, changes))


def independent(
    settings: Settings, seed: int, output_step: float = 0.5, every: int = 1
) -> np.ndarray:
    """u1, v1, u2 (n, 3) by the independent code, at the times of a first stage that records each
    ``output_step`` [s], of which ``every`` so many are used."""
    file = first_stage(seed, settings.rate, settings.vertical, output_step)
    time, push, compression = (row[::every] for row in recorded(file, settings.lever))
    contact = (settings.stiffness, settings.damping, settings.slip_damping)
    model = Model(MASS, K1, C1, *contact, settings.static, settings.kinetic)
    return solve(model, time, push, settings.pressure * compression)[0]


def recorded(file: Path, lever: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time [s], wave force in surge [N] and compression [m] of a first stage."""
    series = xr.load_dataset(file)
    compression = series.compression.sel(lever=f"{lever:g} m")
    return series.time.values, series.push.values, compression.values


@cache
def first_stage(
    seed: int, rate: int = RATE, vertical: int = VERTICAL, output_step: float = 0.5
) -> Path:
    """A file with the wave force and the compressions of the barge without friction."""
    lift = [0.0, LIFTED, LIFTED + rate * 9810.0]
    changes = {
        "environment.waves.seed": seed,
        "forces.deballast.force.heave": lift,
        "forces.interface.normal.stiffness": vertical * PER_HALF_METRE,
        "output.step": output_step,
    }
    run = hs.simulate(hs.load_case(FIRST_STAGE, changes))
    orders = (run.force_wave_first_order, run.force_wave_second_order)
    push = sum(order.sel(body="barge", dof="surge", drop=True) for order in orders)
    forward, aft = (run.fender_compression.isel(fender=pair).mean("fender") for pair in PAIRS)
    mean, slope = (forward + aft) / 2, (forward - aft) / (PLACES["forward"] - PLACES["aft"])
    compression = xr.concat([mean + x * slope for x in LEVERS], "lever")
    series = xr.Dataset(
        {
            "push": push.assign_attrs(units="N"),
            "compression": compression.assign_attrs(units="m"),
        }
    ).assign_coords(lever=[f"{x:g} m" for x in LEVERS])
    path = Path(_folder().name) / f"{seed}_{rate}_{vertical}_{output_step}.nc"
    series.to_netcdf(path)
    return path


@cache
def _folder() -> TemporaryDirectory[str]:
    return TemporaryDirectory(prefix="hydrosim-thesis-")
