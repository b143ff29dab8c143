"""How many steps per second, by scene, and how near is that to the limit?

The limit are bare loops that do the least that a scene asks for, and for the sphere also the same
arithmetic as hydrosim, energies and exact rotations included (`limit`). The same
equations as one writes them with numpy and scipy (`sphere_with_numpy`) are the other end. All are
compared with hydrosim's motions and energies: so they are the same computation. Times are CPU times
of the time loop, records included; all kernels are compiled before.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from benchmarks import limit
from benchmarks import sphere_with_numpy as by_numpy
from benchmarks.report import Answer, Row
from benchmarks.scenes import (
    Several,
    barges,
    base_case,
    compiled,
    free_barge,
    motions,
    sphere,
    touches,
    with_fenders,
    with_states,
)
from benchmarks.timing import Timed, interleaved, time_loop, timed
from hydrosim import simulate
from hydrosim.scene import ConvolutionRadiation, Kinematics, Place, Scene

REPEATS, FEW = 7, 2  # few of what takes seconds
STEP, RECORDED = 0.1, 0.5  # s
DURATION = 1800.0  # s, of the sphere
STEPS, EVERY = round(DURATION / STEP), round(RECORDED / STEP)
STATES = 60
MEMORY = ConvolutionRadiation(length=60.0)
HEAVE = 2
EXACT, SMALL = "hydrosim", "hydrosim, small angles"
LIMIT = "bare loop"
LEDGER = "bare loop, with energies"
ROTATIONS = "bare loop, exact, with energies"
ENERGIES = (
    *("energy_dissipated_radiation", "energy_work_wave_first_order"),
    *("energy_work_wave_second_order", "energy_dissipated_mooring", "energy_wave_absolute"),
)
"""Of all rows of forces but hydrostatics, and of |wave power|."""
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
                _ratio("sphere", states, SMALL, LEDGER, 0.5),
                _ratio("sphere", states, EXACT, ROTATIONS, 0.5),
                _ratio("sphere", states, SMALL, LIMIT),
                _ratio("sphere", states, EXACT, LIMIT),
                _ratio("sphere", states, EXACT, SOLVE_IVP, 60.0),
                _ratio("sphere, convolution", convolution, SMALL, LIMIT, 0.5),
                _ratio("sphere, convolution", convolution, EXACT, LIMIT, 0.5),
            ],
        },
        [f"CPU times of the time loop, medians of {REPEATS} interleaved runs ({FEW} with numpy)."],
    )


def _scenes() -> dict[str, Scene]:
    """By what is said of them."""
    return {
        "sphere, convolution": sphere(DURATION, MEMORY),
        "free barge": free_barge(),
        "2 barges": barges(2),
        "4 barges": barges(4),
        "base case, 64 fenders": with_fenders(64),
        "base case, 16 fenders": with_fenders(16),
        "base case, 4 fenders": base_case(),
    }


def _by_scene() -> list[Row]:
    """Speeds of all scenes."""
    runs = {
        f"sphere, {n} states": with_states(compiled(sphere(DURATION)), n) for n in (60, 120, 240)
    }
    runs |= {name: compiled(scene) for name, scene in _scenes().items()}
    runs["the same in its plane"] = compiled(base_case(), in_plane=True)
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
    """The sphere by hydrosim, by the bare loops, and by numpy."""
    exact, small = (
        with_states(compiled(sphere(DURATION, kinematics=kinematics)), STATES)
        for kinematics in (Kinematics.EXACT, Kinematics.LINEAR)
    )
    p, turning = limit.sphere_of(small), limit.sphere_of(exact)
    plain = by_numpy.equation(small)
    quick = replace(plain, by_hand=True)
    loops = {
        LIMIT: partial(limit.run_states, p, STEPS, STEP, EVERY),
        LEDGER: partial(limit.run_with_energies, p, STEPS, STEP, EVERY),
        ROTATIONS: partial(limit.run_exact, turning, STEPS, STEP, EVERY),
    }
    slow = {
        SOLVE_IVP: partial(_solve_ivp, plain.with_states, plain.sizes),
        f"{SOLVE_IVP}, loads by hand": partial(_solve_ivp, quick.with_states, quick.sizes),
        "numpy, RK4 by hand": partial(_rk4, quick.with_states, quick.sizes),
    }
    return _interleaved({EXACT: exact, SMALL: small}, loops, slow)


def _with_convolution() -> dict[str, Timed]:
    """The same with a convolution; the bare loop to fourth order, and of first order."""
    exact, small = (
        compiled(sphere(DURATION, MEMORY, kinematics))
        for kinematics in (Kinematics.EXACT, Kinematics.LINEAR)
    )
    p, plain = limit.sphere_of(small), by_numpy.equation(small)
    memory = limit.memory_of(small.model.convolution, STEP)
    K, quick = plain.kernel.transpose(1, 2, 0).copy(), replace(plain, by_hand=True)
    loops = {
        LIMIT: partial(limit.run_convolution, p, memory, STEPS, STEP, EVERY),
        "bare loop, first order": partial(limit.run_once_a_step, p, K, STEPS, STEP, EVERY),
    }
    slow: dict[str, Callable[[], np.ndarray]] = {
        SOLVE_IVP: lambda: _solve_ivp(by_numpy.Convolution(plain).rates, np.ones(12)),
        "numpy, RK4 by hand": lambda: _rk4(by_numpy.Convolution(quick).rates, np.ones(12)),
    }
    return _interleaved({EXACT: exact, SMALL: small}, loops, slow)


def _solve_ivp(rates: by_numpy.Rates, sizes: np.ndarray) -> np.ndarray:
    """With hydrosim's steps: the tolerance, the default one, allows larger ones."""
    times = RECORDED * np.arange(STEPS // EVERY + 1)
    settings: dict[str, Any] = {"max_step": STEP, "rtol": 1e-3, "atol": 1e-3 * sizes}
    return by_numpy.by_solve_ivp(rates, sizes.size, times, **settings)


def _rk4(rates: by_numpy.Rates, sizes: np.ndarray) -> np.ndarray:
    return by_numpy.by_rk4(rates, sizes.size, STEPS, STEP, EVERY)


def _interleaved(
    ours: Mapping[str, Several],
    loops: Mapping[str, Callable[[], np.ndarray]],
    slow: Mapping[str, Callable[[], np.ndarray]],
) -> dict[str, Timed]:
    """All runs, with their motions, and energies if they have any, as results (nt, 6 or 12)."""
    runs = {name: partial(time_loop, run) for name, run in ours.items()}
    runs |= {name: partial(timed, run) for name, run in loops.items()}
    found = interleaved(runs, REPEATS)
    found |= interleaved({name: partial(timed, run) for name, run in slow.items()}, FEW)
    return {name: run._replace(result=_values(run.result)) for name, run in found.items()}


def _values(result: np.ndarray | xr.Dataset) -> np.ndarray:
    if isinstance(result, np.ndarray):
        return result
    none = np.zeros(result.sizes["time"])  # hydrostatics dissipate nothing
    return np.column_stack([motions(result), none, *(result[name].values for name in ENERGIES)])


def _compared(found: Mapping[str, Timed]) -> list[Row]:
    """Speeds, and differences to hydrosim: with small angles, which all have but one."""
    ours = found[EXACT]
    rows: list[Row] = []
    for name, run in found.items():
        same = found[EXACT if name == ROTATIONS else SMALL].result
        apart = np.abs(run.result - same[:, : run.result.shape[1]]).max(axis=0)
        energies = f"{apart[6:].max() / same[-1, -1]:.0e}" if apart.size > 6 else ""
        rows.append(
            {
                "what": name,
                "steps/s": round(STEPS / run.seconds),
                "µs per step": 1e6 * run.seconds / STEPS,
                "time over hydrosim's": run.seconds / ours.seconds,
                "heave apart [of range]": f"{apart[HEAVE] / np.ptp(same[:, HEAVE]):.0e}",
                "all apart [m, rad]": f"{apart[:6].max():.0e}",
                "energies apart [of wave work]": energies,
            }
        )
    return rows


def _ratio(
    scene: str, found: Mapping[str, Timed], ours: str, other: str, wanted: float | None = None
) -> Row:
    """Steps per second over those of another."""
    return {
        "scene": scene,
        "what": ours,
        "over": other,
        "is": found[other].seconds / found[ours].seconds,
        "wanted": "" if wanted is None else f"{wanted:g} or more",
    }


def _base_case() -> list[Row]:
    """The base case by the bare loop and by hydrosim, with and without fenders and events, all of
    them with the waves at the place at rest, as the bare loop has them."""
    scene = _with_waves_at_rest(base_case())
    free = replace(scene, forces={k: v for k, v in scene.forces.items() if k != "interface"})
    past = replace(scene, solver=replace(scene.solver, events=False))
    ours = {"hydrosim without fenders": free, "hydrosim": scene, "hydrosim past events": past}
    steps, every = round(scene.duration / STEP), round(scene.output_step / STEP)
    runs = {name: compiled(each) for name, each in ours.items()}
    barge = limit.barge(runs["hydrosim"])
    found = interleaved(
        {
            LIMIT: partial(timed, partial(limit.run, barge, steps, STEP, every)),
            **{name: partial(time_loop, run) for name, run in runs.items()},
            "simulate in its plane, all told": partial(timed, partial(simulate, scene)),
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


def _with_waves_at_rest(scene: Scene) -> Scene:
    (body,) = scene.bodies
    loads = replace(body.wave_forces, position=Place.MEAN, headings=Place.MEAN)
    return replace(scene, bodies=(replace(body, wave_forces=loads),))


def _apart(result: np.ndarray | xr.Dataset, run: xr.Dataset, where: np.ndarray) -> float:
    found = result if isinstance(result, np.ndarray) else motions(result)
    return float(np.abs(found - motions(run))[where].max())
