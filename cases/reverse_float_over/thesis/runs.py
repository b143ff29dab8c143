"""Runs of the cases of the thesis, and what their tables read from them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

import hydrosim as hs
from benchmarks.report import ROOT
from hydrosim.results.phases import Phase

CASES = ROOT / "cases"
BASE = "reverse_float_over/base.yaml"
SEED = "environment.waves.seed"
FRICTION = "forces.interface.friction"
KILO = 1e3
TIMES = (600.0, 1000.0, 1500.0, 2000.0)  # s
STUCK_FROM = 1500.0  # s: the thesis sees stick from here on

Settings = Mapping[str, object]


def run_case(case: str, seed: int, settings: Settings) -> xr.Dataset:
    """A run of a ``case`` with the impulses of its forces."""
    own = {SEED: seed, "output.impulses": True, **settings}
    return hs.simulate(hs.load_case(CASES / case, own))


def surge(run: xr.Dataset, channel: str = "position") -> xr.DataArray:
    """Surge of the barge [m], or its velocity [m/s]."""
    return run[channel].isel(body=0).sel(dof="surge")


def mean_force(run: xr.Dataset, force: str, start: float, end: float) -> float:
    """Mean force in surge from ``start`` to ``end`` by its impulse [kN]."""
    impulse = run.impulse.isel(body=0).sel(dof="surge", force=force)
    change = impulse.sel(time=end) - impulse.sel(time=start)
    return float(change) / (end - start) / KILO


def positions(run: xr.Dataset) -> dict[str, float]:
    """Surge at the times that the thesis names [m]."""
    return {f"surge_{time:g}": float(surge(run).sel(time=time)) for time in TIMES}


def base_figures(run: xr.Dataset) -> dict[str, float]:
    """Figures of a run of the base case or of one that differs from it in a few values."""
    return {
        **positions(run),
        **contact_figures(run),
        **friction_by_direction(run),
        "moored_mean": float(surge(run).sel(time=slice(200.0, 500.0)).mean()),
        "waves_600_1000": _waves(run, 600.0, 1000.0),
        "waves_contact": _waves(run, 600.0, 2000.0),
        "drift_contact": mean_force(run, "wave_second_order", 600.0, 2000.0),
        "fenders_600_1000": mean_force(run, "interface", 600.0, 1000.0),
        "fenders_contact": mean_force(run, "interface", 600.0, 2000.0),
        "fenders_1500_2000": mean_force(run, "interface", 1500.0, 2000.0),
        "velocity_stuck": largest_velocity_stuck(run),
        "heave_velocity": _rms_heave_velocity(run),
    }


def contact_figures(run: xr.Dataset) -> dict[str, float]:
    """First contact and lengths of the phases [s], shares of stick."""
    mode = run.fender_mode
    touches = run.time.values[(mode != _mode(run, "open")).any("fender").values]
    sticks = (mode == _mode(run, "stick")).mean("fender")
    phase = run.contact_phase.isel(contact_group=0)
    step = float(run.time[1] - run.time[0])
    slips = run.time.values[(mode == _mode(run, "slip")).any("fender").values]
    return {
        "first_contact": float(touches[0]) if touches.size else float("nan"),
        "initial_contact_lasts": step * float((phase == Phase.INITIAL_CONTACT).sum()),
        "compressed_lasts": step * float((phase == Phase.COMPRESSED).sum()),
        "stuck_lasts": step * float((phase == Phase.STUCK).sum()),
        "last_slip": float(slips[-1]) if slips.size else float("nan"),
        "stick_600_1500": float(sticks.sel(time=slice(600.0, STUCK_FROM)).mean()),
        "stick_1500_2000": float(sticks.sel(time=slice(STUCK_FROM, None)).mean()),
    }


def friction_by_direction(run: xr.Dataset) -> dict[str, float]:
    """Mean force of the fenders from 600 to 1000 s while the barge moves with the waves and while
    it moves against them [kN]."""
    part = run.sel(time=slice(600.0, 1000.0))
    force = part.force_interface.isel(body=0).sel(dof="surge") / KILO
    velocity = surge(part, "velocity")
    return {
        "fenders_moving_ahead": float(force.where(velocity > 0.0).mean()),
        "fenders_moving_back": float(force.where(velocity < 0.0).mean()),
    }


def largest_velocity_stuck(run: xr.Dataset) -> float:
    """Largest velocity in surge after 1500 s while all points stick [m/s]; not a number where they
    never do."""
    part = run.sel(time=slice(STUCK_FROM, None))
    sticks = (part.fender_mode == _mode(run, "stick")).all("fender").values
    velocity = np.abs(surge(part, "velocity").values[sticks])
    return float(velocity.max()) if velocity.size else float("nan")


def _waves(run: xr.Dataset, start: float, end: float) -> float:
    """Mean first-order wave force [kN]."""
    return mean_force(run, "wave_first_order", start, end)


def _rms_heave_velocity(run: xr.Dataset) -> float:
    """Root mean square of the heave velocity in contact, 600 to 2000 s [m/s]."""
    heave = run.velocity.isel(body=0).sel(dof="heave", time=slice(600.0, None))
    return float((heave**2).mean() ** 0.5)


def _mode(run: xr.Dataset, name: str) -> int:
    """Number of a contact mode in ``fender_mode``."""
    return str(run.fender_mode.attrs["flag_meanings"]).split().index(name)
