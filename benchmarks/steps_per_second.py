"""How many steps per second does the base case take, and how does that compare?

With a bare loop that does the least that the case asks for (`limit`), and with scipy's `solve_ivp`
on the same equations with the same events (`with_scipy`), at a tolerance that gives no larger an
error. All kernels are compiled before the clock starts; compiling is timed apart.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np

from benchmarks import limit
from benchmarks.base_case import FINEST, SURGE, base_case, motions, short_case
from benchmarks.report import ROOT, Answer, Row
from benchmarks.with_scipy import Solution, solve, without_integrals
from hydrosim import compile_scene, simulate
from hydrosim.scene import Scene

REPEATS = 9
STEP = 0.1  # s
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6)
CORNERS = (200.0, 500.0)  # s: ends of the waves' ramp and of the first line of the lift
FIRST_RUN = """
from dataclasses import replace
from time import perf_counter
start = perf_counter()
from benchmarks.base_case import base_case
from hydrosim import simulate
simulate(replace(base_case(), duration=1.0))
print(perf_counter() - start)
"""


def answer() -> Answer:
    """Speeds of the base case, the same by scipy, and the time to compile."""
    speeds, difference = _speeds()
    return Answer(
        {
            f"Base case, 2000 s at rk4, {STEP:g} s; medians of {REPEATS} interleaved runs": speeds,
            "Base case, its first 700 s: surge within an error": _beside_scipy(),
            "A run of 1 s in a process of its own": _first_runs(),
        },
        [
            "The bare loop and hydrosim differ by less than"
            f" {difference:.0e} m and rad until the first contact."
        ],
    )


def _speeds() -> tuple[list[Row], float]:
    """Steps per second, and how far the bare loop is from hydrosim before the first contact."""
    scene = base_case()
    free = replace(scene, forces={k: v for k, v in scene.forces.items() if k != "interface"})
    steps, every = round(scene.duration / STEP), round(scene.output_step / STEP)
    barge = limit.barge(compile_scene(scene)[0], scene)
    limit.run(barge, every, STEP, every)
    seconds: dict[str, list[float]] = {}
    for _ in range(REPEATS):
        bare = timed(seconds, "bare loop", lambda: limit.run(barge, steps, STEP, every))
        loop = simulate(free).attrs["wall_time"]
        seconds.setdefault("hydrosim's loop without fenders", []).append(loop)
        run = timed(seconds, "hydrosim's simulate, all told", lambda: simulate(scene))
        seconds.setdefault("hydrosim's loop", []).append(run.attrs["wall_time"])
    before = run.time.values < run.time.values[(run.fender_mode > 0).any("fender")][0]
    difference = float(np.abs(bare - motions(run))[before].max())
    fastest = median(seconds["bare loop"])
    rows: list[Row] = [
        {
            "what": what,
            "steps/s": round(steps / median(times)),
            "µs/step": 1e6 * median(times) / steps,
            "of bare loop": median(times) / fastest,
        }
        for what, times in sorted(seconds.items(), key=lambda item: median(item[1]))
    ]
    return rows, difference


def _beside_scipy() -> list[Row]:
    """Hydrosim, and scipy at falling tolerances until its error in surge is no larger."""
    reference, scene = motions(simulate(short_case(FINEST))), short_case(STEP)
    seconds: dict[str, list[float]] = {}
    run = simulate(scene)
    mine = _error(motions(run), reference)
    evaluations = {"hydrosim": run.attrs["solver_evaluations"]}
    errors, by_scipy = {"hydrosim": mine}, _scipy(scene)
    for relative in TOLERANCES:
        name = f"solve_ivp, rtol {relative:g}"
        found = by_scipy(relative)
        errors[name], evaluations[name] = _error(found.motions, reference), found.evaluations
        seconds[name] = []
        if errors[name] <= mine:
            break
    for _ in range(REPEATS):
        seconds.setdefault("hydrosim", []).append(simulate(scene).attrs["wall_time"])
        for relative, name in zip(TOLERANCES, [k for k in seconds if k != "hydrosim"], strict=False):
            timed(seconds, name, lambda relative=relative: by_scipy(relative))
    return [
        {
            "solver": name,
            "error of surge [m]": errors[name],
            "evaluations": evaluations[name],
            "time [s]": median(seconds[name]),
            "of hydrosim's": median(seconds[name]) / median(seconds["hydrosim"]),
        }
        for name in errors
    ]
