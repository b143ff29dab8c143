"""How many steps per second does the base case take, and how does that compare?

With a bare loop that does the least that the case asks for (`limit`), and with scipy's `solve_ivp`
on the same equations with the same events (`with_scipy`), at a tolerance that gives no larger an
error. All kernels are compiled before the clock starts; `start_up` times that.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from statistics import median
from time import perf_counter
from typing import NamedTuple

import numpy as np

from benchmarks import limit
from benchmarks.base_case import FINEST, base_case, motions, short_case, touches
from benchmarks.report import Answer, Row
from benchmarks.with_scipy import free_of_integrals, solve
from hydrosim import compile_scene, simulate
from hydrosim.scene import Method, Scene, Tolerance

REPEATS = 7
STEP = 0.1  # s
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
CORNERS = (200.0, 500.0)  # s: ends of the waves' ramp and of the first line of the lift


class Trial(NamedTuple):
    """One run: its displacements and angles (nt, 6), the time it took [s], its evaluations."""

    motions: np.ndarray
    seconds: float
    evaluations: int


def answer() -> Answer:
    """Speeds of the base case, and the same by scipy."""
    difference, speeds = _speeds()
    return Answer(
        {
            f"Base case, 2000 s, rk4 at {STEP:g} s; medians of {REPEATS} interleaved runs": speeds,
            "The first 700 s of it, with surge at least as exact as rk4's": _same_error(),
        },
        [f"Bare loop and hydrosim differ by {difference:.0e} m, rad until the first contact."],
    )


def _speeds() -> tuple[float, list[Row]]:
    """How far the bare loop is from hydrosim before the first contact, and the table of speeds."""
    scene = base_case()
    free = replace(scene, forces={k: v for k, v in scene.forces.items() if k != "interface"})
    past = replace(scene, solver=replace(scene.solver, events=False))
    steps, every = round(scene.duration / STEP), round(scene.output_step / STEP)
    barge = limit.barge(compile_scene(scene)[0], scene)
    seconds: dict[str, list[float]] = {}
    for _ in range(REPEATS + 1):
        begin = perf_counter()
        bare = limit.run(barge, steps, STEP, every)
        middle = perf_counter()
        run = simulate(scene)
        end = perf_counter()
        times = {
            "bare loop": middle - begin,
            "loop without fenders": simulate(free).attrs["wall_time"],
            "loop": run.attrs["wall_time"],
            "loop past events": simulate(past).attrs["wall_time"],
            "simulate, all told": end - middle,
        }
        for what, time in times.items():
            seconds.setdefault(what, []).append(time)
    fastest = median(seconds["bare loop"][1:])  # the first of all compiles
    rows = [_speed(what, median(times[1:]), steps, fastest) for what, times in seconds.items()]
    return float(np.abs(bare - motions(run))[~touches(run)].max()), rows


def _speed(what: str, seconds: float, steps: int, fastest: float) -> Row:
    return {
        "what": what,
        "steps/s": round(steps / seconds),
        "µs per step": 1e6 * seconds / steps,
        "of bare loop": seconds / fastest,
    }


def _same_error() -> list[Row]:
    """Fixed and adaptive steps and scipy: time, evaluations, error against a fine reference."""
    reference = motions(simulate(short_case(FINEST)))
    rk4 = partial(_by_hydrosim, short_case(STEP))
    allowed = _error(rk4(), reference)
    runs: dict[str, Callable[[], Trial]] = {
        f"hydrosim, rk4 at {STEP:g} s": rk4,
        **_loosest("hydrosim, dopri5 at", _adaptive, allowed, reference),
        **_loosest("scipy, RK45 at", _scipy(), allowed, reference),
    }
    rounds = [{name: run() for name, run in runs.items()} for _ in range(REPEATS)]
    seconds = {name: median(each[name].seconds for each in rounds) for name in runs}
    first = next(iter(seconds.values()))
    return [
        {
            "solver": name,
            "error of surge [m]": _error(trial, reference),
            "evaluations": trial.evaluations,
            "time [s]": seconds[name],
            "of rk4's": seconds[name] / first,
        }
        for name, trial in rounds[0].items()
    ]


def _loosest(
    name: str, solver: Callable[[float], Trial], allowed: float, reference: np.ndarray
) -> dict[str, Callable[[], Trial]]:
    """The solver at the loosest relative tolerance that keeps to the allowed error."""
    for relative in TOLERANCES:
        if _error(solver(relative), reference) <= allowed:
            break
    return {f"{name} {relative:.0e}": partial(solver, relative)}


def _by_hydrosim(scene: Scene) -> Trial:
    run = simulate(scene)
    return Trial(motions(run), run.attrs["wall_time"], run.attrs["solver_evaluations"])


def _adaptive(relative: float) -> Trial:
    scene = short_case(STEP, Method.DOPRI5)
    tolerance = Tolerance(relative, relative, relative / 100)  # angles: as if at 100 m
    return _by_hydrosim(replace(scene, solver=replace(scene.solver, tolerance=tolerance)))


def _scipy() -> Callable[[float], Trial]:
    """The first 700 s by scipy, for a relative tolerance; the sizes that absolute tolerances go by
    are those of a rough run."""
    model, state = compile_scene(short_case(STEP))
    times = simulate(short_case(STEP)).time.values
    by_scipy = partial(solve, model, state, times, CORNERS)
    size = free_of_integrals(model, np.zeros(model.size))
    size = free_of_integrals(model, by_scipy(TOLERANCES[0], size).largest)

    def timed(relative: float) -> Trial:
        begin = perf_counter()
        found = by_scipy(relative, size)
        return Trial(found.motions, perf_counter() - begin, found.evaluations)

    return timed


def _error(trial: Trial, reference: np.ndarray) -> float:
    """Largest error of surge [m]."""
    return float(np.abs(trial.motions - reference)[:, 0].max())
