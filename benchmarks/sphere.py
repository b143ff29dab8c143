"""The sphere in an irregular sea, in the variants that the benchmarks need."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Any

from benchmarks.base_case import with_database_read
from benchmarks.report import ROOT
from hydrosim.scene import (
    Kinematics,
    LinearScenes,
    Radiation,
    Scene,
    StateSpaceRadiation,
    Unstable,
)

STATES = StateSpaceRadiation(tolerance=2e-4)
"""42 states; more exact fits have poles too fast for steps of 0.1 s."""


@lru_cache
def irregular() -> Scene:
    """`cases/sphere/irregular.yaml`, its database read once for all."""
    return with_database_read(ROOT / "cases" / "sphere" / "irregular.yaml")


def sphere(
    duration: float,
    radiation: Radiation = STATES,
    kinematics: Kinematics = Kinematics.EXACT,
    output_step: float = 0.5,
    **solver: Any,
) -> Scene:
    """The sphere for ``duration`` [s], stepped even where the scene is linear; ``solver`` are other
    settings of it."""
    scene = irregular()
    usual = {"linear": LinearScenes.STEP, "unstable": Unstable.WARN}
    return replace(
        scene,
        duration=duration,
        bodies=(replace(scene.bodies[0], radiation=radiation),),
        solver=replace(scene.solver, kinematics=kinematics, **{**usual, **solver}),
        output_step=output_step,
    )
