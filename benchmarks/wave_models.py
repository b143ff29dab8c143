"""What do models of the waves cost: ways of the memory, and loads that follow the heading?

The base case with each memory of the radiated waves; the first 700 s are compared, where motions
are still the same from run to run: contact multiplies any difference later on. And the base case
with waves to other headings, so that it yaws: by default, where waves follow its slow yaw, over the
same with `headings: mean`.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from math import radians
from statistics import median

import numpy as np
import xarray as xr

from benchmarks.report import Answer, Row
from benchmarks.scenes import SHORT, base_case, compiled, motions
from benchmarks.timing import interleaved, time_loop
from hydrosim import simulate
from hydrosim.scene import (
    ConstantRadiation,
    ConvolutionRadiation,
    Place,
    Radiation,
    Scene,
    SecondOrder,
    StateSpaceRadiation,
)

REPEATS = 3
HEADING_REPEATS = 5
DEGREES = (30.0, 60.0)
ORDERS = (SecondOrder.NONE, SecondOrder.NEWMAN)
PLANE = [0, 2, 4]  # surge, heave, pitch: the waves are from ahead
WAYS: dict[str, Radiation | str] = {
    "convolution": ConvolutionRadiation(),
    "convolution, table of 0.02 s": ConvolutionRadiation(step=0.02),
    "state space, 1e-2": StateSpaceRadiation(1e-2),
    "state space, 1e-3": StateSpaceRadiation(1e-3),
    "state space, 3e-4": StateSpaceRadiation(3e-4),
    "constant, of 8 s": ConstantRadiation(8.0),
    "none": "none",
}


def answer() -> Answer:
    """Times of the whole base case and differences until 700 s, and times of its loop."""
    runs: dict[str, list[xr.Dataset]] = {way: [] for way in WAYS}
    for _ in range(REPEATS):
        for way, radiation in WAYS.items():
            runs[way].append(_run(radiation))
    direct = _motions(runs["convolution"][0])
    memories = [_memory_row(way, found, direct) for way, found in runs.items()]
    headings = [_heading_row(heading, order) for heading in DEGREES for order in ORDERS]
    of_headings = f"Time loop, medians of {HEADING_REPEATS} interleaved runs"
    return Answer({"Base case, rk4 at 0.1 s": memories, of_headings: headings})


def _run(radiation: Radiation | str) -> xr.Dataset:
    scene = base_case()
    return simulate(replace(scene, bodies=(replace(scene.bodies[0], radiation=radiation),)))


def _motions(run: xr.Dataset) -> np.ndarray:
    return motions(run.sel(time=slice(0.0, SHORT)))[:, PLANE]


def _memory_row(way: str, runs: list[xr.Dataset], direct: np.ndarray) -> Row:
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


def _heading_row(degrees: float, order: SecondOrder) -> Row:
    scenes = {place: _oblique_scene(degrees, order, place) for place in (Place.MEAN, Place.SLOW)}
    runs = {place: partial(time_loop, compiled(scene)) for place, scene in scenes.items()}
    found = interleaved(runs, HEADING_REPEATS)
    mean = found[Place.MEAN].seconds
    slow = found[Place.SLOW].seconds
    steps = base_case().duration / base_case().solver.step
    return {
        "waves to [deg]": degrees,
        "second order": str(order),
        "mean [µs per step]": mean / steps * 1e6,
        "slow [µs per step]": slow / steps * 1e6,
        "ratio": slow / mean,
    }


def _oblique_scene(degrees: float, order: SecondOrder, headings: Place) -> Scene:
    scene = base_case()
    (train,) = scene.environment.waves
    (body,) = scene.bodies
    loads = replace(body.wave_forces, second_order=order, headings=headings, position=Place.MEAN)
    oblique = replace(scene.environment, waves=(replace(train, heading=radians(degrees)),))
    return replace(scene, environment=oblique, bodies=(replace(body, wave_forces=loads),))
