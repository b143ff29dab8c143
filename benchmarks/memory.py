"""What do the ways of computing the memory of the radiated waves cost, and how far are they apart?

The base case with each; the first 700 s are compared, where motions are still the same from run to
run: contact multiplies any difference later on.
"""

from __future__ import annotations

from dataclasses import replace
from statistics import median

import numpy as np
import xarray as xr

from benchmarks.base_case import SHORT, base_case, motions
from benchmarks.report import Answer, Row
from hydrosim import simulate
from hydrosim.scene import (
    ConstantRadiation,
    ConvolutionRadiation,
    Radiation,
    RadiationModel,
    StateSpaceRadiation,
)

REPEATS = 3
PLANE = [0, 2, 4]  # surge, heave, pitch: the waves are from ahead
WAYS: dict[str, Radiation | RadiationModel] = {
    "convolution": ConvolutionRadiation(),
    "convolution, table of 0.02 s": ConvolutionRadiation(step=0.02),
    "state space, 1e-2": StateSpaceRadiation(1e-2),
    "state space, 1e-3": StateSpaceRadiation(1e-3),
    "state space, 3e-4": StateSpaceRadiation(3e-4),
    "constant, of 8 s": ConstantRadiation(8.0),
    "none": RadiationModel.NONE,
}


def answer() -> Answer:
    """Times of the whole base case, interleaved, and differences until 700 s."""
    runs: dict[str, list[xr.Dataset]] = {way: [] for way in WAYS}
    for _ in range(REPEATS):
        for way, radiation in WAYS.items():
            runs[way].append(_run(radiation))
    direct = _motions(runs["convolution"][0])
    return Answer(
        {"Base case, rk4 at 0.1 s": [_row(w, found, direct) for w, found in runs.items()]}
    )


def _run(radiation: Radiation | RadiationModel) -> xr.Dataset:
    scene = base_case()
    return simulate(replace(scene, bodies=(replace(scene.bodies[0], radiation=radiation),)))


def _motions(run: xr.Dataset) -> np.ndarray:
    return motions(run.sel(time=slice(0.0, SHORT)))[:, PLANE]


def _row(way: str, runs: list[xr.Dataset], direct: np.ndarray) -> Row:
    first = runs[0]
    seconds = median(run.attrs["wall_time"] for run in runs)
    difference = (_motions(first) - direct).std(axis=0) / direct.std(axis=0)
    return {
        "memory": way,
        "states": sum("radiation " in str(name) for name in first.state.values),
        "steps/s": round(first.attrs["solver_steps"] / seconds),
        **{
            f"{dof} [of std]": f"{value:.1e}"
            for dof, value in zip(("surge", "heave", "pitch"), difference, strict=True)
        },
    }
