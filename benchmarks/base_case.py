"""The base case of the reverse float-over, in the variants that the benchmarks need."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import xarray as xr

from benchmarks.report import ROOT
from hydrosim import load_case, load_database
from hydrosim.scene import Method, Scene, Unstable

SHORT = 700.0  # s: the first contact, at 534 s, and a few dozen events after it
RECORDED = 0.4  # s
FINEST = RECORDED / 128  # s: the step of the reference


@lru_cache
def base_case() -> Scene:
    """The base case, its database read once for all."""
    scene = load_case(ROOT / "cases" / "reverse_float_over" / "base.yaml").scene()
    (barge,) = scene.bodies
    assert isinstance(barge.hydrodynamics, Path)
    read = replace(barge, hydrodynamics=load_database(barge.hydrodynamics))
    return replace(scene, bodies=(read,))


def short_case(step: float, method: Method = Method.RK4, events: bool = True) -> Scene:
    """The base case until `SHORT`, recorded every `RECORDED`, with this solver, stable or not."""
    settings = {"step": step, "method": method, "events": events, "unstable": Unstable.WARN}
    solver = replace(base_case().solver, **settings)
    return replace(base_case(), duration=SHORT, output_step=RECORDED, solver=solver)


def motions(run: xr.Dataset) -> np.ndarray:
    """Displacements and angles (nt, 6) of the one body."""
    return run.position.isel(body=0).values


def touches(run: xr.Dataset) -> np.ndarray:
    """True (nt,) from the first record with contact on."""
    return np.logical_or.accumulate((run.fender_mode > 0).any("fender").values)
