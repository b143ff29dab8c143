"""What does a catenary cost beside a spring, and three hours of a barge on eight of them?

A dry block on lines or springs, and the barge H-851 in 50 m of water on eight chains to one turret,
in a sea, all six degrees of freedom. rk4 at 0.1 s. CPU times of the time loop.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.compiled import compiled
from benchmarks.report import ROOT, Answer, Row
from benchmarks.timing import interleaved, time_loop
from hydrosim import load_case
from hydrosim.dofs import DOFS
from hydrosim.forces import Catenary, LinearMooring, Spring
from hydrosim.scene import Body, Environment, ForceElement, LinearScenes, Method, Scene, Solver

REPEATS = 5
LINES = 4
BLOCK = 500.0  # s
STEP = 0.1  # s
DEPTH = 200.0  # m
AFLOAT = LinearMooring("block", np.diag([0.0, 0.0, 1e7, 1e10, 1e10, 1e8]))
TURRET = """
title: Barge on eight chains
duration: {duration} s
environment:
  water_depth: 50 m
  current: {{speed: 0.5 m/s, heading: 160 deg}}
  waves: {{spectrum: jonswap, significant_height: 2 m, peak_period: 9 s, heading: 170 deg,
    seed: 1, ramp: 100 s, repeat_period: 3 hour}}
bodies:
  barge:
    hydrodynamics: {database}
    mass: 1.568e8 kg
    centre_of_gravity: [0 m, 0 m, -4.9 m]
    radii_of_gyration: [22.05 m, 67.6 m, 68.9 m]
    wave_forces: {{second_order: newman}}
forces:
{lines}
  yaw: {{type: linear_damping, body: barge, damping: {{yaw: 1e9 N*m*s/rad}}}}
initial: at_rest
solver: {{method: rk4, step: 0.1 s}}
output: {{step: 0.5 s}}
"""
CHAIN = (
    "  line_{k}: {{type: catenary, body: barge, point: [{x:.4f} m, {y:.4f} m, -5 m],"
    " anchor: [{X:.4f} m, {Y:.4f} m, -50 m], seabed: {{friction: 0}}, segments:"
    " [{{length: 300 m, chain: {{diameter: 90 mm}}, drag: {{coefficient: 2.4, diameter: 90 mm}}}},"
    " {{length: 322 m, chain: {{diameter: 100 mm}}}}]}}"
)


def answer() -> Answer:
    """A table for the block, and one for the barge."""
    runs = {
        name: partial(time_loop, compiled(block(elements)))
        for name, elements in (("springs", springs(LINES)), ("catenaries", catenaries(LINES)))
    }
    seconds = {name: run.seconds for name, run in interleaved(runs, REPEATS).items()}
    steps = BLOCK / STEP
    rows: list[Row] = [
        {
            f"{LINES} of": name,
            "us per step": 1e6 * time / steps,
            "of springs": time / seconds["springs"],
        }
        for name, time in seconds.items()
    ]
    run = time_loop(compiled(turret(10800.0)))
    hours: list[Row] = [
        {
            "barge on eight chains": "three hours",
            "CPU time [s]": run.seconds,
            "largest tension [kN]": float(run.result.line_tension.max()) / 1e3,
            "kinks that cut a step": int(run.result.attrs["solver_events"]),
        }
    ]
    return Answer({"A block": rows, "A barge in a sea": hours})


def block(elements: Mapping[str, ForceElement]) -> Scene:
    """A block that swings on lines."""
    inertia = 5e7 * np.diag([100.0, 600.0, 600.0])
    body = Body(
        "block",
        5e7,
        inertia,
        dofs=DOFS,
        position=(3.0, 1.0, 0.0, 0.0, 0.0, 0.0),
        velocity=(0.3, 0.0, 0.0, 0.0, 0.0, 0.002),
    )
    solver = Solver(step=STEP, method=Method.RK4, linear=LinearScenes.STEP)
    found = Scene("block", BLOCK, (body,), forces={"afloat": AFLOAT, **elements}, solver=solver)
    return replace(found, environment=Environment(water_depth=DEPTH), output_step=10.0)


def _ends(k: int, count: int) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Fairlead and anchor of a line."""
    angle = 2.0 * np.pi * k / count + 0.1
    along, aside = np.cos(angle), np.sin(angle)
    return (50.0 + 5.0 * along, 5.0 * aside, -5.0), (50.0 + 700.0 * along, 700.0 * aside, -DEPTH)


def catenaries(count: int) -> dict[str, ForceElement]:
    """Lines of two segments that touch down in the second."""
    none = np.zeros(2)
    pieces = (np.array([300.0, 420.0]), np.array([1500.0, 1100.0]), np.array([8e8, 7e8]))
    return {
        f"line_{k}": Catenary("block", *_ends(k, count), *pieces, none, none, 0.0)
        for k in range(count)
    }


def springs(count: int) -> dict[str, ForceElement]:
    """Springs between the same points."""
    curve = (np.array([0.0, 1.0]), np.array([0.0, 1e6]))
    return {f"spring_{k}": Spring("block", *_ends(k, count), 715.0, *curve) for k in range(count)}


def turret(duration: float) -> Scene:
    """The barge on eight chains."""
    lines = []
    for k in range(8):
        angle = 2.0 * np.pi * (k + 0.5) / 8
        along, aside = np.cos(angle), np.sin(angle)
        place = {"x": 60.0 + 4.0 * along, "y": 4.0 * aside}
        anchor = {"X": 60.0 + 620.0 * along, "Y": 620.0 * aside}
        lines.append(CHAIN.format(k=k, **place, **anchor))
    database = ROOT / "hydro_db" / "h851_50m.nc"
    text = TURRET.format(duration=duration, database=database, lines="\n".join(lines))
    with TemporaryDirectory() as folder:
        path = Path(folder, "turret.yaml")
        path.write_text(text)
        return load_case(path).scene()
