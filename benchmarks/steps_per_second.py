"""How many steps per second, by scene, and how near is that to the limit?

The limit are bare loops that do the least that a scene asks for (`limit`, `limit_sphere`). The same
equations as one writes them with numpy and scipy (`sphere_with_numpy`) are the other end. All are
compared with hydrosim's motions: so they are the same computation. Times are CPU times of the time
loop, records included; all kernels are compiled before.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from benchmarks import limit, limit_sphere
from benchmarks import sphere_with_numpy as by_numpy
from benchmarks.base_case import barges, base_case, free_barge, motions, touches, with_fenders
from benchmarks.compiled import Compiled, compiled, with_states
from benchmarks.report import Answer, Row
from benchmarks.sphere import sphere
from benchmarks.timing import Timed, interleaved, time_loop, timed
from hydrosim import simulate
from hydrosim.scene import ConvolutionRadiation, Kinematics, Scene

REPEATS = 5
STEP, RECORDED = 0.1, 0.5  # s
DURATION = 600.0  # s, of the sphere
STEPS, EVERY = round(DURATION / STEP), round(RECORDED / STEP)
STATES = 60
MEMORY = ConvolutionRadiation(length=60.0)
HEAVE = 2
SMALL = "hydrosim, small angles"
LIMIT = "bare loop"
SOLVE_IVP = "solve_ivp, RK45"


def answer() -> Answer:
    """Speeds by scene; those of the sphere and of the base case against their limits."""
    states, convolution = _with_states(), _with_convolution()
    return Answer(
        {
            f"rk4 at {STEP:g} s, all outputs every {RECORDED:g} s": _by_scene(),
            f"Sphere, {STATES} radiation states": _compared(states),
            f"Sphere, convolution over {MEMORY.length:g} s": _compared(convolution),
            "Base case, 2000 s": _base_case(),
            "Ratios": [
                *_ratios("sphere", states, {LIMIT: 0.5, SOLVE_IVP: 60.0}),
                *_ratios("sphere, convolution", convolution, {LIMIT: 0.5}),
            ],
        },
        [f"CPU times of the time loop, medians of {REPEATS} interleaved runs."],
    )


def _scenes() -> dict[str, Scene]:
    """By what is said of them."""
    return {
        "sphere, convolution": sphere(DURATION, MEMORY),
        "free barge": free_barge(),
        "2 barges": barges(2),
        "4 barges": barges(4),
        "base case, 4 fenders": base_case(),
        "base case, 16 fenders": with_fenders(16),
        "base case, 64 fenders": with_fenders(64),
    }


def _by_scene() -> list[Row]:
    """Speeds of all scenes."""
    runs = {
        f"sphere, {n} states": with_states(compiled(sphere(DURATION)), n) for n in (60, 120, 240)
    }
    runs |= {name: compiled(scene) for name, scene in _scenes().items()}
    found = interleaved({name: partial(time_loop, run) for name, run in runs.items()}, REPEATS)
    return [
        {
            "scene": name,
            "coordinates": int(run.model.bodies.active.size),
            "states in all": int(run.model.size),
            "events": int(found[name].result.attrs["solver_events"]),
            "steps/s": round(run.scene.duration / STEP / found[name].seconds),
            "µs per step": 1e6 * found[name].seconds * STEP / run.scene.duration,
        }
        for name, run in runs.items()
    ]


def _with_states() -> dict[str, Timed]:
    """The sphere by hydrosim, by the bare loop, and by numpy."""
    exact, small = (
        with_states(compiled(sphere(DURATION, kinematics=kinematics)), STATES)
        for kinematics in (Kinematics.EXACT, Kinematics.LINEAR)
    )
    p, plain = limit_sphere.sphere_of(small.model, small.scene), by_numpy.equation(small)
    quick = replace(plain, by_hand=True)
    others = {
        LIMIT: partial(limit_sphere.run_states, p, STEPS, STEP, EVERY),
        SOLVE_IVP: partial(_solve_ivp, plain.with_states, plain.sizes),
        f"{SOLVE_IVP}, loads by hand": partial(_solve_ivp, quick.with_states, quick.sizes),
        "numpy, RK4 by hand": partial(_rk4, quick.with_states, quick.sizes),
    }
    return _interleaved({"hydrosim": exact, SMALL: small}, others)


def _with_convolution() -> dict[str, Timed]:
    """The same with a convolution; the bare loop to fourth order, and of first order."""
    exact, small = (
        compiled(sphere(DURATION, MEMORY, kinematics))
        for kinematics in (Kinematics.EXACT, Kinematics.LINEAR)
    )
    p, plain = limit_sphere.sphere_of(small.model, small.scene), by_numpy.equation(small)
    memory = limit_sphere.memory_of(small.model.convolution)
    K, quick = plain.kernel.transpose(1, 2, 0).copy(), replace(plain, by_hand=True)
    others: dict[str, Callable[[], np.ndarray]] = {
        LIMIT: partial(limit_sphere.run_convolution, p, memory, STEPS, STEP, EVERY),
        "bare loop, first order": partial(limit_sphere.run_once_a_step, p, K, STEPS, STEP, EVERY),
        SOLVE_IVP: lambda: _solve_ivp(by_numpy.Convolution(plain).rates, np.ones(12)),
        "numpy, RK4 by hand": lambda: _rk4(by_numpy.Convolution(quick).rates, np.ones(12)),
    }
    return _interleaved({"hydrosim": exact, SMALL: small}, others)


def _solve_ivp(rates: by_numpy.Rates, sizes: np.ndarray) -> np.ndarray:
    """With hydrosim's steps: the tolerance, the default one, allows larger ones."""
    times = RECORDED * np.arange(STEPS // EVERY + 1)
    settings: dict[str, Any] = {"max_step": STEP, "rtol": 1e-3, "atol": 1e-3 * sizes}
    return by_numpy.by_solve_ivp(rates, sizes.size, times, **settings)


def _rk4(rates: by_numpy.Rates, sizes: np.ndarray) -> np.ndarray:
    return by_numpy.by_rk4(rates, sizes.size, STEPS, STEP, EVERY)


def _interleaved(
    ours: Mapping[str, Compiled], others: Mapping[str, Callable[[], np.ndarray]]
) -> dict[str, Timed]:
    """All runs, with their motions (nt, 6) as results."""
    runs = {name: partial(time_loop, run) for name, run in ours.items()}
    runs |= {name: partial(timed, run) for name, run in others.items()}
    found = interleaved(runs, REPEATS)
    return {name: run._replace(result=_motions(run.result)) for name, run in found.items()}


def _motions(result: np.ndarray | xr.Dataset) -> np.ndarray:
    return result if isinstance(result, np.ndarray) else motions(result)


def _compared(found: Mapping[str, Timed]) -> list[Row]:
    """Speeds, and differences in motion to hydrosim with small angles, which the others have."""
    ours, same = found["hydrosim"], found[SMALL].result
    span = np.ptp(same[:, HEAVE])
    return [
        {
            "what": name,
            "steps/s": round(STEPS / run.seconds),
            "µs per step": 1e6 * run.seconds / STEPS,
            "time over hydrosim's": run.seconds / ours.seconds,
            "heave apart [of range]": f"{np.abs(run.result - same)[:, HEAVE].max() / span:.0e}",
            "all apart [m, rad]": f"{np.abs(run.result - same).max():.0e}",
        }
        for name, run in found.items()
    ]


def _ratios(scene: str, found: Mapping[str, Timed], wanted: Mapping[str, float]) -> list[Row]:
    """hydrosim's steps per second over those of others."""
    return [
        {
            "scene": scene,
            "hydrosim over": name,
            "is": found[name].seconds / found["hydrosim"].seconds,
            "wanted": f"{least:g} or more",
        }
        for name, least in wanted.items()
    ]


def _base_case() -> list[Row]:
    """The base case by the bare loop and by hydrosim, with and without fenders and events."""
    scene = base_case()
    free = replace(scene, forces={k: v for k, v in scene.forces.items() if k != "interface"})
    past = replace(scene, solver=replace(scene.solver, events=False))
    ours = {"hydrosim without fenders": free, "hydrosim": scene, "hydrosim past events": past}
    steps, every = round(scene.duration / STEP), round(scene.output_step / STEP)
    runs = {name: compiled(each) for name, each in ours.items()}
    barge = limit.barge(runs["hydrosim"].model, scene)
    found = interleaved(
        {
            LIMIT: partial(timed, partial(limit.run, barge, steps, STEP, every)),
            **{name: partial(time_loop, run) for name, run in runs.items()},
            "simulate, all told": partial(timed, partial(simulate, scene)),
        },
        REPEATS,
    )
    run = found["hydrosim"].result
    afloat = ~touches(run)
    return [
        {
            "what": name,
            "steps/s": round(steps / each.seconds),
            "µs per step": 1e6 * each.seconds / steps,
            "of bare loop": each.seconds / found[LIMIT].seconds,
            "apart before contact [m, rad]": f"{_apart(each.result, run, afloat):.0e}",
        }
        for name, each in found.items()
    ]


def _apart(result: np.ndarray | xr.Dataset, run: xr.Dataset, where: np.ndarray) -> float:
    return float(np.abs(_motions(result) - motions(run))[where].max())
