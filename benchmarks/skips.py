"""What does it save to skip what a scene does not need?

Pairs of the same scene with more and with less of it. Where both answer the same question, the
motions are compared; where less is another physics, the difference says what it is worth. CPU times
of a run all told, but for compiling the scene.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
import xarray as xr

from benchmarks.base_case import base_case, free_barge, motions
from benchmarks.compiled import compiled
from benchmarks.report import Answer, Row
from benchmarks.timing import interleaved, time_all
from hydrosim.scene import LinearScenes, RadiationModel, Scene, SecondOrder, WaveForces

REPEATS = 5
PLANE = ("surge", "heave", "pitch")


class Skip(NamedTuple):
    """What is skipped, and the scenes with it and without; that without is in its plane, or all
    degrees of freedom are free in both."""

    what: str
    whole: Scene
    less: Scene
    in_plane: bool = False


def answer() -> Answer:
    """Times with and without, and how far the motions are apart."""
    return Answer(
        {f"Base case and free barge, 2000 s; medians of {REPEATS} interleaved runs": _rows()},
        ["Largest difference of a motion over its range, in the records of both."],
    )


def _skips() -> list[Skip]:
    """All that can be skipped: a new one is a line here."""
    base, free = base_case(), free_barge()
    plane = _of_body(free, dofs=PLANE)
    floating = {name: force for name, force in base.forces.items() if name != "deballast"}
    without_fenders = {name: force for name, force in floating.items() if name != "interface"}
    first_order = WaveForces(second_order=SecondOrder.NONE)
    return [
        Skip("sway, roll, yaw of a symmetric scene", base, base, in_plane=True),
        Skip("locked degrees of freedom: sway, roll, yaw", free, plane),
        Skip("steps of a linear scene", plane, _solved(plane, linear=LinearScenes.EXACT)),
        Skip(
            "four fenders that never touch",
            replace(base, forces=floating),
            _solved(replace(base, forces=without_fenders), linear=LinearScenes.STEP),
        ),
        Skip("outputs: every 10 s, not 0.5 s", base, replace(base, output_step=10.0)),
        Skip("second-order loads", free, _of_body(free, wave_forces=first_order)),
        Skip("memory", free, _of_body(free, radiation=RadiationModel.NONE)),
        Skip("events", base, _solved(base, events=False)),
    ]


def _of_body(scene: Scene, **changes: object) -> Scene:
    """The scene with its one body changed."""
    (body,) = scene.bodies
    return replace(scene, bodies=(replace(body, **changes),))  # type: ignore[arg-type]


def _solved(scene: Scene, **changes: object) -> Scene:
    """The scene with other settings of its solver."""
    return replace(scene, solver=replace(scene.solver, **changes))  # type: ignore[arg-type]


def _rows() -> list[Row]:
    runs = {}
    for skip in _skips():
        runs[skip.what, True] = partial(time_all, compiled(skip.whole))
        runs[skip.what, False] = partial(time_all, compiled(skip.less, skip.in_plane))
    found = interleaved(runs, REPEATS)
    rows: list[Row] = []
    for skip in _skips():
        what, whole, less = skip.what, found[skip.what, True], found[skip.what, False]
        rows.append(
            {
                "skipped": what,
                "with it [s]": whole.seconds,
                "without [s]": less.seconds,
                "saved": f"{1.0 - less.seconds / whole.seconds:.0%}",
                "apart": f"{_apart(whole.result, less.result):.0e}",
            }
        )
    return rows


def _apart(whole: xr.Dataset, less: xr.Dataset) -> float:
    """Of the motions that there are; a barge in waves from ahead has no others."""
    both = np.isin(whole.time.values, less.time.values)
    expected, found = motions(whole)[both], motions(less)
    span = np.ptp(expected, axis=0)
    moving = span > 0.0
    return float((np.abs(found - expected)[:, moving] / span[moving]).max())
