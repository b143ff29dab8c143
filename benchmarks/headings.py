"""What does a step cost where waves follow the heading of a body?

The base case, with waves to other headings, so that it yaws: by default, where waves follow its
slow yaw, over the same with `headings: mean`.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from math import radians

from benchmarks.base_case import base_case
from benchmarks.compiled import compiled
from benchmarks.report import Answer, Row
from benchmarks.timing import interleaved, time_loop
from hydrosim.scene import Place, Scene, SecondOrder

REPEATS = 5
DEGREES = (30.0, 60.0)
ORDERS = (SecondOrder.NONE, SecondOrder.NEWMAN)


def answer() -> Answer:
    """CPU times of the time loop."""
    rows = [_row(heading, order) for heading in DEGREES for order in ORDERS]
    return Answer({f"Time loop of the base case, medians of {REPEATS} interleaved runs": rows})


def _row(degrees: float, order: SecondOrder) -> Row:
    scenes = {place: _scene(degrees, order, place) for place in (Place.MEAN, Place.SLOW)}
    runs = {place: partial(time_loop, compiled(scene)) for place, scene in scenes.items()}
    found = interleaved(runs, REPEATS)
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


def _scene(degrees: float, order: SecondOrder, headings: Place) -> Scene:
    scene = base_case()
    (train,) = scene.environment.waves
    (body,) = scene.bodies
    loads = replace(body.wave_forces, second_order=order, headings=headings, position=Place.MEAN)
    oblique = replace(scene.environment, waves=(replace(train, heading=radians(degrees)),))
    return replace(scene, environment=oblique, bodies=(replace(body, wave_forces=loads),))
