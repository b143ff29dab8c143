"""How long does it take to set up many bodies?

Moored barges with a database of their own each, 500 m apart: compiling the scene and finding the
limits of its step, all that comes before the first step. CPU times of one thread, in a process that
has done the same for one barge: kernels are compiled and radiation is fitted.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from statistics import median

import numpy as np

from benchmarks.base_case import barges
from benchmarks.report import Answer, Row
from benchmarks.timing import timed
from hydrosim import compile_scene
from hydrosim.scene import Place, Scene
from hydrosim.studies.run.step_limits import add_step_warnings

BODIES = (1, 4, 16)
REPEATS = 3
OBLIQUE = np.radians(30.0)


def answer() -> Answer:
    """CPU times by the number of bodies."""
    kinds: dict[str, Callable[[int], Scene]] = {
        "calm water": _calm,
        "waves ahead": barges,
        "oblique waves": _oblique,
        "oblique waves, met at rest": _at_rest,
    }
    rows = [{"scene": name, **_times(scene)} for name, scene in kinds.items()]
    return Answer({f"CPU time [s] of setting up, medians of {REPEATS}": rows})


def _times(scene: Callable[[int], Scene]) -> Row:
    _set_up(scene(BODIES[0]))
    return {
        f"{count} bodies": median(
            timed(partial(_set_up, scene(count))).seconds for _ in range(REPEATS)
        )
        for count in BODIES
    }


def _set_up(scene: Scene) -> None:
    add_step_warnings(compile_scene(scene, in_plane=True))


def _calm(count: int) -> Scene:
    scene = barges(count)
    return replace(scene, environment=replace(scene.environment, waves=()))


def _oblique(count: int) -> Scene:
    scene = barges(count)
    waves = tuple(replace(train, heading=OBLIQUE) for train in scene.environment.waves)
    return replace(scene, environment=replace(scene.environment, waves=waves))


def _at_rest(count: int) -> Scene:
    scene = _oblique(count)
    loads = replace(scene.bodies[0].wave_forces, position=Place.MEAN, headings=Place.MEAN)
    return replace(scene, bodies=tuple(replace(body, wave_forces=loads) for body in scene.bodies))
