"""The base case of the reverse float-over, in the variants that the benchmarks need."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import xarray as xr

from benchmarks.report import ROOT
from hydrosim import database, load_case
from hydrosim.scene import Method, Scene

SHORT = 700.0  # s: the first contact, at 534 s, and some twenty after it
CONTACT = 534.0  # s
SURGE, HEAVE, PITCH = 0, 2, 4


@lru_cache
def base_case() -> Scene:
    """The base case with its database read."""
    scene = load_case(ROOT / "cases" / "reverse_float_over" / "base.yaml").scene()
    (barge,) = scene.bodies
    barge = replace(barge, hydrodynamics=database.load(barge.hydrodynamics))
    return replace(scene, bodies=(barge,))


def short_case(step: float, method: Method = Method.RK4, events: bool = True) -> Scene:
    """The base case until `SHORT`, recorded every 0.4 s, with this solver."""
    scene = base_case()
    solver = replace(scene.solver, step=step, method=method, events=events)
    return replace(scene, duration=SHORT, output_step=0.4, solver=solver)


def motions(run: xr.Dataset) -> np.ndarray:
    """Displacements and angles (nt, 6) of the one body."""
    return run.position.isel(body=0).values
