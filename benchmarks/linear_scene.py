"""What does it save that a linear scene is not stepped?

The moored H-851 of the reverse float-over in surge, heave and pitch for almost 3 hours, in
first-order waves and Newman's second-order ones, recorded every 0.5 s: propagated exactly, and by
rk4 at several steps. Errors are against the propagated run; that of rk4 falls with the fourth power
of the step, which says how much of the difference is rk4's.
"""

from __future__ import annotations

from dataclasses import replace
from statistics import median
from time import process_time

import numpy as np
import xarray as xr

from benchmarks.base_case import base_case, motions
from benchmarks.report import Answer, Row
from hydrosim import compile_scene, simulate
from hydrosim.compiling.clock import compile_clock
from hydrosim.linear import propagate
from hydrosim.scene import LinearScenes, Scene

REPEATS = 7
DURATION = 10799.0  # s: the sea repeats itself after 3 hours
STEPS = (0.25, 0.125, 0.0625, 0.03125)  # s; the largest one is stable up to 0.3 s
STEP = 0.125  # s, of the propagated run: nodes are half as far apart
DOFS = ("surge", "heave", "pitch")


def answer() -> Answer:
    """Times and errors of propagated and stepped runs, and the parts of the time of the former."""
    runs = {f"rk4 at {step:g} s": _scene(step, LinearScenes.STEP) for step in STEPS}
    runs = {"propagated": _scene(STEP), **runs}
    seconds: dict[str, list[float]] = {name: [] for name in (*runs, *PARTS)}
    for _ in range(REPEATS + 1):  # the first of all loads or compiles the kernels
        found = {name: simulate(scene) for name, scene in runs.items()}
        for name, run in found.items():
            seconds[name].append(run.attrs["wall_time"])
        for part, time in _parts().items():
            seconds[part].append(time)
    reference = found["propagated"]
    fastest = median(seconds["propagated"][1:])
    rows = [
        {
            "run": name,
            "time [s]": median(seconds[name][1:]),
            "of propagated": median(seconds[name][1:]) / fastest,
            "error of the range": _error(run, reference),
            "energy residual": run.attrs["energy_residual_relative"],
        }
        for name, run in found.items()
    ]
    parts: list[Row] = [
        {"what": part, "CPU time [ms]": 1e3 * median(seconds[part][1:])} for part in PARTS
    ]
    title = (
        f"H-851 in surge, heave and pitch, {DURATION:g} s; medians of {REPEATS} interleaved runs"
    )
    return Answer({title: rows, "Of a propagated run, without records and energies": parts})


PARTS = ("equation and exponentials", "loads at the nodes", "motions at the records")


def _scene(step: float, linear: LinearScenes = LinearScenes.EXACT) -> Scene:
    """The barge without lift and fenders, with this step."""
    scene = base_case()
    (barge,) = scene.bodies
    return replace(
        scene,
        duration=DURATION,
        bodies=(replace(barge, dofs=DOFS),),
        forces={"mooring": scene.forces["mooring"]},
        solver=replace(scene.solver, step=step, linear=linear),
    )


def _parts() -> dict[str, float]:
    """Times [s] of what a propagated run takes for its motions alone, after the waves' ramp."""
    scene = _scene(STEP)
    compiled = compile_scene(scene)
    model, state, clock = compiled.model, compiled.first_state(), compile_clock(compiled)
    begin = process_time()
    equation = propagate.linear_equation(model, state)
    pieces, parts = propagate.division(scene.output_step, propagate.node_spacing(clock, model))
    response = equation.response(scene.output_step / pieces, parts)
    known = process_time()
    loads = propagate.loads_at_rest(
        propagate.record_times(clock), pieces * parts, equation.rows, model, state
    )
    read = process_time()
    f = propagate.extend_nodes(np.einsum("krn->kn", loads) + equation.rest)
    z = state.y[: len(equation.J)]
    for _, states in propagate.motions(z, f, response, pieces):
        states[pieces::pieces, : len(DOFS)].copy()
    return dict(zip(PARTS, np.diff([begin, known, read, process_time()]), strict=True))


def _error(run: xr.Dataset, reference: xr.Dataset) -> float:
    """Largest difference of surge, heave and pitch, each over its range."""
    free = [0, 2, 4]
    size = np.ptp(motions(reference)[:, free], axis=0)
    return float((np.abs(motions(run) - motions(reference))[:, free] / size).max())
