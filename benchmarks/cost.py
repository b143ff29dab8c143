"""How does the cost of a run grow with its duration, the waves, the fenders and the bodies?

The base case, all outputs every 0.5 s. The exponent is the power of the growth since the row
before: 1 is in proportion. CPU times; memory is the most that a new process takes which simulates
once.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import log
from typing import Any

import numpy as np

from benchmarks.base_case import barges, base_case, motions, with_fenders
from benchmarks.compiled import compiled
from benchmarks.report import ROOT, Answer, Row
from benchmarks.timing import Timed, interleaved, time_loop, timed
from hydrosim import simulate
from hydrosim.compiling.compile import compile_in_calm
from hydrosim.compiling.without_waves import add_waves
from hydrosim.scene import Scene, SecondOrder
from hydrosim.waves import sea

REPEATS = 3
HOURS = (0.75, 1.5, 3.0, 6.0)
STEPS, FINE = (0.1, 0.05, 0.025), 0.0125  # s
REPEATED = (3.0, 6.0, 12.0, 24.0)  # h, that the sea repeats itself after
FENDERS, BODIES = (4, 16, 64), (1, 2, 4)
WANTED = (SecondOrder.NONE, SecondOrder.NEWMAN, SecondOrder.QTF)
MEGABYTE = 1e6
NEW_PROCESS = """
from pathlib import Path
from benchmarks.cost import long_case
from hydrosim import simulate
run = simulate(long_case({hours}))
status = dict(line.split(":") for line in Path("/proc/self/status").read_text().splitlines())
print(1024 * int(status["VmHWM"].split()[0]), run.nbytes)
"""
Runs = Mapping[Any, Callable[[], Timed]]
"""By their number of what the cost grows with."""


def answer() -> Answer:
    """A table for each of what the cost grows with."""
    hours = {n: partial(timed, partial(simulate, long_case(n))) for n in HOURS}
    fenders = {n: partial(time_loop, compiled(with_fenders(n))) for n in FENDERS}
    bodies = {n: partial(time_loop, compiled(barges(n))) for n in BODIES}
    return Answer(
        {
            "Three hours of the base case, all outputs every 0.5 s": _three_hours(),
            "Duration, base case, all told": _growth("hours", hours),
            "Components, base case, 0.75 h, synthesis of the waves": _by_components(),
            "Fenders, base case, time loop": _growth("fenders", fenders),
            "Bodies, moored barges, time loop": _growth("bodies", bodies),
            "Memory, base case": [_memory(hours) for hours in (0.01, *HOURS)],
        },
        [f"CPU times, medians of {REPEATS} interleaved runs."],
    )


def _three_hours() -> list[Row]:
    """CPU times by the step, and errors of surge over its range, against a fine step."""
    scenes = {h: _with_step(replace(base_case(), duration=3 * 3600.0), h) for h in (*STEPS, FINE)}
    loops = {h: partial(time_loop, compiled(scenes[h], in_plane=True)) for h in STEPS}
    wholes = {h: partial(timed, partial(simulate, scenes[h])) for h in STEPS}
    loop, whole = interleaved(loops, REPEATS), interleaved(wholes, REPEATS)
    exact = motions(simulate(scenes[FINE]))[:, 0]
    return [
        {
            "step [s]": h,
            "CPU time, all told [s]": whole[h].seconds,
            "of it the time loop [s]": loop[h].seconds,
            "error of surge [of range]": float(
                np.abs(motions(whole[h].result)[:, 0] - exact).max() / np.ptp(exact)
            ),
        }
        for h in STEPS
    ]


def _with_step(scene: Scene, step: float) -> Scene:
    """With another step of the solver [s]."""
    return replace(scene, solver=replace(scene.solver, step=step))


def long_case(hours: float, repeated: float = HOURS[-1]) -> Scene:
    """The base case for this long, in a sea that repeats itself after ``repeated`` [h]."""
    scene = base_case()
    (train,) = scene.environment.waves
    waves = (replace(train, repeat_period=3600.0 * repeated),)
    return replace(
        scene, duration=3600.0 * hours, environment=replace(scene.environment, waves=waves)
    )


def _growth(what: str, runs: Runs) -> list[Row]:
    """CPU time by number, over the first, and its growth."""
    seconds = {n: run.seconds for n, run in interleaved(runs, REPEATS).items()}
    first = next(iter(seconds.values()))
    return [
        {what: n, "CPU time [s]": time, "of the first": time / first, "exponent": exponent}
        for (n, time), exponent in zip(seconds.items(), _exponents(seconds), strict=True)
    ]


def _exponents(seconds: Mapping[float, float]) -> list[str]:
    """Of the growth from one to the next."""
    pairs = pairwise(seconds.items())
    return ["-", *(f"{log(b / a) / log(n / m):.2f}" for (m, a), (n, b) in pairs)]


def _by_components() -> list[Row]:
    """First-order loads alone, with Newman's second order, and with the full QTF."""
    columns = {
        wanted: interleaved({n: partial(timed, _synthesis(n, wanted)) for n in REPEATED}, REPEATS)
        for wanted in WANTED
    }
    growth = {
        wanted: _exponents({n: run.seconds for n, run in found.items()})
        for wanted, found in columns.items()
    }
    return [
        {
            "components": int(sea(long_case(HOURS[0], n).environment)[0].omega.size),
            **{
                f"{wanted} [ms] (exponent)": f"{1e3 * found[n].seconds:.3g} ({growth[wanted][k]})"
                for wanted, found in columns.items()
            },
        }
        for k, n in enumerate(REPEATED)
    ]


def _synthesis(repeated: float, wanted: SecondOrder) -> Callable[[], object]:
    """Makes the waves' loads of a scene that is otherwise compiled."""
    scene = long_case(HOURS[0], repeated)
    (barge,) = scene.bodies
    forces = replace(barge.wave_forces, second_order=wanted)
    scene = replace(scene, bodies=(replace(barge, wave_forces=forces),))
    calm = compile_in_calm(scene)
    return lambda: add_waves(calm, scene, sea(scene.environment))


def _memory(hours: float) -> Row:
    """Of a new process."""
    command = [sys.executable, "-W", "ignore", "-c", NEW_PROCESS.format(hours=hours)]
    peak, dataset = map(int, subprocess.check_output(command, cwd=ROOT, text=True).split())
    return {
        "hours": hours,
        "most [MB]": round(peak / MEGABYTE),
        "of it the dataset [MB]": round(dataset / MEGABYTE),
    }
